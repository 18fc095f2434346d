//! One simulated machine under its supervisor.

use crate::drawing::{Drawing, FREE_POINTS, POINTS, SHEATH_POINTS};
use crate::frame::Along;
use crate::motion::PageMotion;
use crate::signals::Signals;
use sinew::Error;
use sinew::control::supervisor::{Mode, Request, Supervisor};
use sinew::machine::Machine;
use sinew::trajectory::Trajectory;
use sinew::transmission::cable::CableLaw;
use sinew::twin::arm::{ArmTwin, Failure, InjectedFault};
use sinew_session::signals::{Frame, FrameLayout, Signal};
use sinew_session::{Plant, Session, TwinPlant, VirtualClock};
use std::sync::Arc;

/// Speed of a point of a cable from which on it slides, m/s.
const SLIDES: f64 = 1e-4;

/// What a simulation is made of.
#[derive(Debug)]
pub struct SimulationParts {
    /// As designed, with its payload.
    pub machine: Machine,
    /// The plant, in the first pose of the motion; joints without an encoder in the machine's start.
    pub plant: ArmTwin,
    /// In its initial state.
    pub supervisor: Supervisor,
    /// The motion.
    pub trajectory: Arc<Trajectory>,
}

/// A simulated machine, its supervisor and its motion; one control cycle a step.
#[derive(Debug)]
pub struct Simulation {
    machine: Machine,
    session: Session<TwinPlant, PageMotion>,
    faults: Vec<InjectedFault>,
    /// Signals of the last cycle.
    shown: Frame,
    cables: Vec<CableView>,
    /// Cycle of the last picture.
    shown_at: u64,
}

/// One cable between two pictures.
#[derive(Debug, Clone)]
struct CableView {
    /// Of every cell, m/N, drive end first.
    compliance: Vec<f64>,
    /// Tensions, N, and travel of the winch, m, at the last picture.
    before: (Vec<f64>, f64),
    travel: f64,
    /// Sliding of every point at the last picture: 0, 1 or 2.
    sliding: Vec<f64>,
    /// Fraction of the sheath in the length of the cable.
    sheath_fraction: f64,
}

impl Simulation {
    /// At the beginning of its motion, with the goal to run.
    ///
    /// # Errors
    /// Parts of different machines.
    pub fn new(parts: SimulationParts) -> Result<Self, Error> {
        let SimulationParts { machine, plant, supervisor, trajectory } = parts;
        let motion = PageMotion::new(&machine, trajectory, machine.period, supervisor.mode())?;
        let view = |(k, design): (usize, &sinew::machine::MuscleDesign)| {
            let specimen = &plant.specimen().cables[k];
            let cells = plant.cable_tensions(k)?.count();
            let law = CableLaw::new(&specimen.path, &specimen.parameters, cells)?;
            let tensions: Vec<f64> = plant.cable_tensions(k)?.collect();
            let sheath = design.near + design.sheath;
            Ok(CableView {
                compliance: law.compliance().to_vec(),
                before: (tensions, 0.0),
                travel: 0.0,
                sliding: vec![0.0; POINTS],
                sheath_fraction: (sheath / specimen.path.length()).clamp(0.05, 0.95),
            })
        };
        let cables = machine.muscles.iter().enumerate().map(view).collect::<Result<_, Error>>()?;
        let [muscles, joints] = supervisor.dimensions();
        let mut shown = Frame::new(Arc::new(FrameLayout::new([muscles, joints], true)));
        shown.of_mut(Signal::JointReference).copy_from_slice(motion.newest());
        shown.of_mut(Signal::JointTrue).copy_from_slice(plant.truth().q);
        let session = Session::new(TwinPlant::new(plant), supervisor, motion, machine.period);
        Ok(Self { machine, session, faults: Vec::new(), shown, cables, shown_at: 0 })
    }

    /// The machine as designed.
    #[must_use]
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// The plant.
    #[must_use]
    pub fn plant(&self) -> &ArmTwin {
        self.session.plant().arm()
    }

    /// Failures that were injected and are not known to be over.
    #[must_use]
    pub fn faults(&self) -> &[InjectedFault] {
        &self.faults
    }

    /// Mode of the supervisor in the last cycle.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.session.mode()
    }

    /// Simulated time, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.session.time().seconds()
    }

    /// One control cycle. A plant whose integration failed stands. Nothing is allocated.
    ///
    /// # Errors
    /// As [`Session::step`].
    pub fn step(&mut self) -> Result<(), Error> {
        self.pass();
        if !self.session.plant().has_failed() {
            self.shown.fill(&self.session.step(&mut VirtualClock::default(), 0)?.seen());
        }
        Ok(())
    }

    /// Lets the period after the last commands pass, once: what is shown is the cycle and the plant as it
    /// found it.
    fn pass(&mut self) {
        let Self { session, cables, .. } = self;
        let before = session.plant().arm().truth().time;
        session.plant_mut().pass();
        let truth = session.plant().arm().truth();
        if truth.time > before {
            for (view, drive) in cables.iter_mut().zip(truth.drives) {
                view.travel += drive.moved;
            }
        }
    }

    /// Asks the supervisor for a mode.
    pub fn ask(&mut self, request: Request) {
        self.session.motion_mut().ask(request);
    }

    /// Where the end point is to go, m.
    ///
    /// # Errors
    /// In words, where the machine has no end point.
    pub fn drag(&mut self, target: [f64; 3]) -> Result<(), String> {
        if self.machine.task.site().is_none() {
            return Err("the machine has no end point".to_owned());
        }
        self.session.motion_mut().drag(target);
        Ok(())
    }

    /// The end point stays where it is.
    pub fn release(&mut self) {
        self.session.motion_mut().release();
    }

    /// Injects a failure from the next cycle on.
    ///
    /// # Errors
    /// As [`InjectedFault::validate`].
    pub fn inject(&mut self, failure: Failure, duration: f64) -> Result<(), Error> {
        self.pass();
        let fault = InjectedFault { start: self.plant().truth().time, duration, failure };
        let [muscles, joints] = self.session.supervisor().dimensions();
        fault.validate(muscles, joints)?;
        self.inject_all(&[fault])
    }

    /// Adds failures; nothing changes where the plant refuses one.
    fn inject_all(&mut self, faults: &[InjectedFault]) -> Result<(), Error> {
        let now = self.plant().truth().time;
        // Those that are over need no place, and a part that has failed for good cannot fail again.
        let mut all: Vec<InjectedFault> =
            self.faults.iter().copied().filter(|fault| fault.start + fault.duration >= now).collect();
        for fault in faults {
            let lasts =
                |other: &InjectedFault| other.duration.is_infinite() && other.failure == fault.failure;
            if !all.iter().any(lasts) {
                all.push(*fault);
            }
        }
        self.session.plant_mut().set_faults(&all)?;
        self.faults = all;
        Ok(())
    }

    /// Pushes a point of a body, m in its frame, with a force, N in the world, for a time, s; how many joints
    /// feel it.
    ///
    /// # Errors
    /// As [`inject`](Self::inject).
    pub(crate) fn push(
        &mut self,
        drawing: &mut Drawing,
        (body, point): (usize, [f64; 3]),
        force: [f64; 3],
        duration: f64,
    ) -> Result<usize, Error> {
        self.pass();
        let (q, now) = (self.plant().truth().q.to_vec(), self.plant().truth().time);
        let mut pushes = Vec::new();
        // The torques that do the same work: F dx/dq.
        let h = 1e-6;
        for joint in 0..q.len() {
            let at = |drawing: &mut Drawing, side: f64| {
                let mut moved = q.clone();
                moved[joint] += side * h;
                drawing.evaluate(&moved).map(|()| drawing.place(body, point))
            };
            let (plus, minus) = (at(drawing, 1.0)?, at(drawing, -1.0)?);
            let torque = (0..3).map(|k| force[k] * (plus[k] - minus[k]) / (2.0 * h)).sum::<f64>();
            if torque.abs() > 1e-9 {
                let failure = Failure::Push { joint, torque };
                let push = InjectedFault { start: now, duration, failure };
                let [muscles, joints] = self.session.supervisor().dimensions();
                push.validate(muscles, joints)?;
                pushes.push(push);
            }
        }
        self.inject_all(&pushes).map(|()| pushes.len())
    }

    /// The signals after the last cycle.
    pub(crate) fn signals(&self) -> Signals {
        Signals { time: self.time(), frame: self.shown.clone() }
    }

    /// Tension behind the sheath with the pretension `T_0`, and sliding of every point since the last call.
    pub(crate) fn along_cables(&mut self) -> Result<Along, Error> {
        let (mut tension, mut sliding) = (Vec::new(), Vec::new());
        // While time stands, what slid before is shown.
        let (now, plant) = (self.session.time().index, self.session.plant().arm());
        let elapsed = (now - self.shown_at) as f64 * self.machine.period;
        self.shown_at = now;
        for (k, view) in self.cables.iter_mut().enumerate() {
            let now: Vec<f64> = plant.cable_tensions(k)?.collect();
            let mut moved = view.travel - view.before.1;
            let steps: Vec<f64> = now
                .iter()
                .zip(&view.before.0)
                .zip(&view.compliance)
                .map(|((now, before), compliance)| {
                    moved -= compliance * (now - before);
                    moved
                })
                .collect();
            // The law's pretension acts at the anchor, behind the sheath.
            let pretension = plant.truth().cables[k].tension_out - now.last().copied().unwrap_or(0.0);
            for point in 0..POINTS {
                let offset = if point < SHEATH_POINTS { 0.0 } else { pretension };
                let fraction = if point < SHEATH_POINTS {
                    view.sheath_fraction * point as f64 / SHEATH_POINTS as f64
                } else {
                    let rest = (point - SHEATH_POINTS) as f64 / (FREE_POINTS - 1) as f64;
                    view.sheath_fraction + (1.0 - view.sheath_fraction) * rest
                };
                let place = fraction * (now.len() - 1) as f64;
                let (cell, part) = (place.floor() as usize, place.fract());
                let next = (cell + 1).min(now.len() - 1);
                tension.push(now[cell] + part * (now[next] - now[cell]) + offset);
                let step = steps[place.round() as usize];
                if elapsed > 0.0 {
                    view.sliding[point] = match step / elapsed {
                        speed if speed > SLIDES => 1.0,
                        speed if speed < -SLIDES => 2.0,
                        _ => 0.0,
                    };
                }
            }
            sliding.extend(&view.sliding);
            view.before = (now, view.travel);
        }
        Ok(Along { tension, sliding })
    }
}
