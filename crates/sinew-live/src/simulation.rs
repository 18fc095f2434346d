//! One simulated machine under its supervisor.

use crate::drawing::{Drawing, FREE_POINTS, POINTS, SHEATH_POINTS};
use crate::frame::Along;
use crate::motion::Motion;
use crate::signals::{Signals, fault_numbers};
use sinew::Error;
use sinew::control::arm::{ArmMeasurement, PreviewedReference};
use sinew::control::supervisor::{ExchangeStatus, Mode, NamedFault, Request, Supervisor};
use sinew::drive::DriveCommand;
use sinew::machine::Machine;
use sinew::trajectory::Trajectory;
use sinew::transmission::cable::CableLaw;
use sinew::twin::arm::{ArmTwin, Failure, InjectedFault};
use std::sync::Arc;

/// Control cycle, s.
pub(crate) const CYCLE: f64 = 1e-3;
/// Speed of a point of a cable from which on it slides, m/s.
const SLIDES: f64 = 1e-4;

/// What a simulation is made of.
#[derive(Debug)]
pub struct SimulationParts {
    /// As designed, with its payload.
    pub machine: Machine,
    /// The plant, in the first pose of the motion.
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
    plant: ArmTwin,
    supervisor: Supervisor,
    motion: Motion,
    faults: Vec<InjectedFault>,
    commands: Vec<DriveCommand>,
    shown: Shown,
    cables: Vec<CableView>,
    /// Cycle of the last picture.
    shown_at: u64,
}

/// What the last cycle commanded and estimated.
#[derive(Debug, Clone)]
struct Shown {
    cycle: u64,
    mode: Mode,
    fault: Option<NamedFault>,
    reference: Vec<f64>,
    estimated: Vec<f64>,
    desired_tension: Vec<f64>,
    estimated_tension: Vec<f64>,
    /// Whether the plant moved faster than the laws of its cables allow: it stands since.
    failed: bool,
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
    /// Share of the sheath in the length of the cable.
    sheath_share: f64,
}

impl Simulation {
    /// At the beginning of its motion, with the goal to run.
    ///
    /// # Errors
    /// Parts of different machines.
    pub fn new(parts: SimulationParts) -> Result<Self, Error> {
        let SimulationParts { machine, plant, supervisor, trajectory } = parts;
        let motion = Motion::new(&machine, trajectory, CYCLE)?;
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
                sheath_share: (sheath / specimen.path.length()).clamp(0.05, 0.95),
            })
        };
        let cables = machine.muscles.iter().enumerate().map(view).collect::<Result<_, Error>>()?;
        let [muscles, joints] = supervisor.dimensions();
        let shown = Shown {
            cycle: 0,
            mode: supervisor.mode(),
            fault: None,
            reference: motion.current.q.clone(),
            estimated: vec![f64::NAN; joints],
            desired_tension: vec![f64::NAN; muscles],
            estimated_tension: vec![f64::NAN; muscles],
            failed: false,
        };
        let commands = vec![DriveCommand::Velocity(0.0); muscles];
        let faults = Vec::new();
        Ok(Self { machine, plant, supervisor, motion, faults, commands, shown, cables, shown_at: 0 })
    }

    /// The machine as designed.
    #[must_use]
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// The plant.
    #[must_use]
    pub fn plant(&self) -> &ArmTwin {
        &self.plant
    }

    /// Failures that were injected and are not known to be over.
    #[must_use]
    pub fn faults(&self) -> &[InjectedFault] {
        &self.faults
    }

    /// Mode of the supervisor in the last cycle.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.shown.mode
    }

    /// Simulated time, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.shown.cycle as f64 * CYCLE
    }

    /// One control cycle. A plant whose integration failed stands. Nothing is allocated.
    ///
    /// # Errors
    /// As [`Supervisor::step`].
    pub fn step(&mut self) -> Result<(), Error> {
        if self.shown.failed {
            return Ok(());
        }
        let Self { plant, supervisor, motion, commands, shown, cables, .. } = self;
        motion.sample(CYCLE, shown.mode)?;
        let reading = plant.reading();
        let measurement =
            ArmMeasurement { motor: &reading.motor, tension: &reading.tension, joint: &reading.joint };
        let reference =
            PreviewedReference { current: &motion.current, previewed: &motion.previewed, repeat_time: None };
        let request = motion.request();
        let command =
            supervisor.step(CYCLE, &measurement, &reference, request, &ExchangeStatus::default())?;
        commands.copy_from_slice(command.arm.drives);
        (shown.mode, shown.fault) = (command.mode, command.fault);
        shown.reference.copy_from_slice(&command.reference.q);
        shown.estimated.copy_from_slice(command.arm.q);
        shown.desired_tension.copy_from_slice(command.arm.desired_tension);
        shown.estimated_tension.copy_from_slice(command.arm.estimated_tension);
        let mode = command.mode;
        motion.settle(mode, command.reference);
        shown.failed = plant.step(commands, CYCLE).is_err();
        for (view, drive) in cables.iter_mut().zip(plant.truth().drives) {
            view.travel += drive.moved;
        }
        shown.cycle += 1;
        Ok(())
    }

    /// Asks the supervisor for a mode.
    pub fn ask(&mut self, request: Request) {
        self.motion.ask(request, self.shown.mode);
    }

    /// Where the end point is to go, m.
    ///
    /// # Errors
    /// In words, where the machine has no end point.
    pub fn drag(&mut self, target: [f64; 3]) -> Result<(), String> {
        if self.machine.task.site().is_none() {
            return Err("the machine has no end point".to_owned());
        }
        self.motion.drag(target, self.shown.mode);
        Ok(())
    }

    /// The end point stays where it is.
    pub fn release(&mut self) {
        self.motion.release();
    }

    /// Injects a failure from the next cycle on.
    ///
    /// # Errors
    /// As [`InjectedFault::validate`].
    pub fn inject(&mut self, failure: Failure, duration: f64) -> Result<(), Error> {
        let fault = InjectedFault { start: self.plant.truth().time, duration, failure };
        let [muscles, joints] = self.supervisor.dimensions();
        fault.validate(muscles, joints)?;
        self.inject_all(&[fault])
    }

    /// Adds failures; nothing changes where the plant refuses one.
    fn inject_all(&mut self, faults: &[InjectedFault]) -> Result<(), Error> {
        let now = self.plant.truth().time;
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
        self.plant = self.plant.clone().with_faults(&all)?;
        self.faults = all;
        Ok(())
    }

    /// Pushes a point of a body, m in its frame, with a force, N in the world, for a time, s; how many joints feel it.
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
        let (q, now) = (self.plant.truth().q.to_vec(), self.plant.truth().time);
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
                let [muscles, joints] = self.supervisor.dimensions();
                push.validate(muscles, joints)?;
                pushes.push(push);
            }
        }
        self.inject_all(&pushes).map(|()| pushes.len())
    }

    /// The signals after the last cycle.
    pub(crate) fn signals(&self) -> Signals {
        let Self { shown, plant, .. } = self;
        let (truth, reading) = (plant.truth(), plant.reading());
        Signals {
            time: self.time(),
            mode: f64::from(shown.mode as u8),
            fault: fault_numbers(shown.fault),
            cycle_us: [f64::NAN; 2],
            joint_reference: shown.reference.clone(),
            joint_estimated: shown.estimated.clone(),
            joint_true: truth.q.to_vec(),
            tension_in: reading.tension.clone(),
            tension_out_desired: shown.desired_tension.clone(),
            tension_out_estimated: shown.estimated_tension.clone(),
            tension_out_true: truth.cables.iter().map(|cable| cable.tension_out).collect(),
            winch_position: reading.motor.clone(),
            motor_temperature: (0..reading.motor.len()).map(|k| plant.winding(k)).collect(),
        }
    }

    /// Tension behind the sheath with the pretension `T_0`, and sliding of every point since the last call.
    pub(crate) fn along_cables(&mut self) -> Result<Along, Error> {
        let (mut tension, mut sliding) = (Vec::new(), Vec::new());
        // While time stands, what slid before is shown.
        let elapsed = (self.shown.cycle - self.shown_at) as f64 * CYCLE;
        self.shown_at = self.shown.cycle;
        for (k, view) in self.cables.iter_mut().enumerate() {
            let now: Vec<f64> = self.plant.cable_tensions(k)?.collect();
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
            let pretension = self.plant.truth().cables[k].tension_out - now.last().copied().unwrap_or(0.0);
            for point in 0..POINTS {
                let offset = if point < SHEATH_POINTS { 0.0 } else { pretension };
                let share = if point < SHEATH_POINTS {
                    view.sheath_share * point as f64 / SHEATH_POINTS as f64
                } else {
                    let rest = (point - SHEATH_POINTS) as f64 / (FREE_POINTS - 1) as f64;
                    view.sheath_share + (1.0 - view.sheath_share) * rest
                };
                let place = share * (now.len() - 1) as f64;
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
