//! Several drives, one in each SIMD lane.

use super::exchange::{DriveCommand, DriveFault, DriveReading, DriveStep};
use super::motor::MotorState;
use super::parameters::DriveParameters;
use super::quadrant::Quadrant;
use super::sensors::Delays;
use super::speed_control::{MeasuredShaft, SpeedControl};
use super::state::{Asked, DriveState, Mode, Powered};
use super::tension_loop::TensionLoop;
use super::winch::Drum;
use crate::Error;
use crate::dispatch::{Arithmetic, InstructionSet, Work};
use crate::lanes::{Abreast, Row};
use crate::random::Random;

/// Milliseconds of a delay are steps of this length, s.
const MILLISECOND: f64 = 1e-3;

/// `N` drives; everything may differ from lane to lane.
#[derive(Debug, Clone)]
pub(super) struct DriveLanes<const N: usize> {
    parameters: <DriveParameters as Abreast>::Rows<N>,
    pub(super) state: <DriveState as Abreast>::Rows<N>,
    reading: <DriveReading as Abreast>::Rows<N>,
    /// Turns of the winch per turn of the motor.
    per_ratio: Row<N>,
    pub(super) drum: Drum<N>,
    /// Angles at which the drums are full, rad.
    full: Row<N>,
    /// Of position, tension and current.
    delays: Delays<N, 3>,
    random: [Random; N],
    pub(super) fault: [Option<DriveFault>; N],
}

/// What goes into a step and comes out of it.
struct Exchange<const N: usize> {
    asked: <Asked as Abreast>::Rows<N>,
    /// At the outlets, N.
    tension: Row<N>,
    powered: <Powered as Abreast>::Rows<N>,
    moved: Row<N>,
    /// Lost in impacts of the flanks and changes of layer, J.
    impact: Row<N>,
}

impl DriveLanes<1> {
    /// One drive as [`Drive::in_steps`](super::Drive::in_steps).
    pub(super) fn new(parameters: DriveParameters, seed: u64, step: f64) -> Result<Self, Error> {
        let p = parameters;
        let winch = 0.5 * p.winch.full();
        let drum = Drum::new([p.winch]);
        let Row([wound]) = drum.wound(Row([winch]));
        let delay = p.delay_ms * (MILLISECOND / step);
        let state = DriveState {
            motor: MotorState::cold(&p.motor),
            angle: winch * p.reducer.ratio,
            speed: 0.0,
            winch,
            wound,
            current_loop: Default::default(),
            speed_control: SpeedControl::new(),
            tension_loop: TensionLoop::of_drive(),
            mode: Mode::Free,
            torque: 0.0,
        };
        Ok(Self {
            parameters: p.repeated(),
            state: state.repeated(),
            reading: DriveReading { position: wound, tension: 0.0, current: 0.0 }.repeated(),
            per_ratio: Row([1.0 / p.reducer.ratio]),
            full: Row([p.winch.full()]),
            drum,
            delays: Delays::new(delay, [wound, 0.0, 0.0])?,
            random: [Random::new(seed)],
            fault: [None],
        })
    }

    /// [`Drive::settle`](super::Drive::settle).
    pub(super) fn settle(&mut self, tension: f64) {
        if tension > 0.0 {
            let reducer = DriveParameters::at(&self.parameters, 0).reducer;
            self.state.angle[0] = (self.state.winch[0] + 0.5 * reducer.backlash) * reducer.ratio;
            let wound = self.drum.wound(Row(self.state.angle) * self.per_ratio);
            self.delays.fill(0, 0, wound.0[0]);
        }
        self.stand(tension);
    }

    /// [`Drive::stand`](super::Drive::stand).
    pub(super) fn stand(&mut self, tension: f64) {
        let tension = pulling(tension);
        self.rest(0, tension);
        self.sense(Row([tension]));
    }

    /// These side by side, at least one and at most `N`; idle lanes copy the last.
    pub(super) fn gathered<const N: usize>(drives: &[&Self]) -> DriveLanes<N> {
        let of = |k: usize| drives[k.min(drives.len() - 1)];
        let first = of(0);
        let mut lanes = DriveLanes {
            parameters: DriveParameters::at(&first.parameters, 0).repeated(),
            state: first.state(0).repeated(),
            reading: first.reading(0).repeated(),
            per_ratio: Row(core::array::from_fn(|k| of(k).per_ratio.0[0])),
            full: Row(core::array::from_fn(|k| of(k).full.0[0])),
            drum: Drum::new(core::array::from_fn(|k| DriveParameters::at(&of(k).parameters, 0).winch)),
            delays: Delays::gathered(core::array::from_fn(|k| &of(k).delays)),
            random: core::array::from_fn(|k| of(k).random[0].clone()),
            fault: core::array::from_fn(|k| of(k).fault[0]),
        };
        for k in 0..N {
            DriveParameters::at(&of(k).parameters, 0).set(&mut lanes.parameters, k);
            of(k).state(0).set(&mut lanes.state, k);
            of(k).reading(0).set(&mut lanes.reading, k);
        }
        lanes
    }
}

impl<const N: usize> DriveLanes<N> {
    pub(super) fn state(&self, k: usize) -> DriveState {
        DriveState::at(&self.state, k)
    }

    pub(super) fn reading(&self, k: usize) -> DriveReading {
        DriveReading::at(&self.reading, k)
    }

    pub(super) fn winding(&self, k: usize) -> f64 {
        self.state.motor.winding[k]
    }

    /// The past tension is what the load cell measures now.
    fn rest(&mut self, k: usize, tension: f64) {
        let measured = DriveParameters::at(&self.parameters, k).measured(tension, &mut self.random[k]);
        self.delays.fill(k, 1, measured);
    }

    /// Reads the sensors, which drives show after a delay; returns the tension that they show.
    #[inline(always)]
    fn sense(&mut self, tension: Row<N>) -> Row<N> {
        let (mut measured, mut angle) = (Row::<N>::default(), Row::<N>::default());
        for k in 0..N {
            let p = DriveParameters::at(&self.parameters, k);
            measured.0[k] = p.measured(tension.0[k], &mut self.random[k]);
            angle.0[k] = p.encoder.read(self.state.angle[k]);
        }
        let position = self.drum.wound(angle * self.per_ratio);
        let delayed = self.delays.pass([position, measured, Row(self.state.motor.current)]);
        let [position, tension, current] = delayed;
        self.reading.position = position.0;
        (self.reading.tension, self.reading.current) = (tension.0, current.0);
        tension
    }

    /// [`Drive::step`](super::Drive::step) of as many as there are entries in `steps`.
    #[inline]
    pub(super) fn step(
        &mut self,
        instructions: InstructionSet,
        mut of: impl FnMut(usize) -> (DriveCommand, f64),
        h: f64,
        steps: &mut [DriveStep],
    ) {
        let mut exchange = Exchange {
            asked: Asked::NOTHING.repeated(),
            tension: Row::default(),
            powered: Powered::NONE.repeated(),
            moved: Row::default(),
            impact: Row::default(),
        };
        let mut braked = [false; N];
        for (k, braked) in braked.iter_mut().enumerate().take(steps.len()) {
            let (command, tension) = of(k);
            let tension = pulling(tension);
            exchange.tension.0[k] = tension;
            *braked = command == DriveCommand::Brake;
            if *braked {
                self.rest(k, tension);
            }
            let asked = Asked::new(command, self.parameters.has_load_cell[k]);
            Asked { on: asked.on && self.fault[k].is_none(), ..asked }.set(&mut exchange.asked, k);
        }
        let before = braked.contains(&true).then(|| self.state.clone());
        instructions.run(Step { lanes: self, exchange: &mut exchange, h });
        for (k, step) in steps.iter_mut().enumerate().take(N) {
            if let Some(before) = before.as_ref().filter(|_| braked[k]) {
                // The brake holds the shaft at once; nothing moves.
                let state = DriveState::at(before, k);
                DriveState { mode: Mode::Free, torque: 0.0, speed: 0.0, ..state }.set(&mut self.state, k);
                *step = DriveStep { fault: self.fault[k], ..DriveStep::STANDING };
                continue;
            }
            self.check_faults(k);
            let Powered { turn, winding, electrical } = Powered::at(&exchange.powered, k);
            let moved = exchange.moved.0[k];
            *step = DriveStep {
                moved,
                speed: moved / h,
                electrical,
                heat: winding.heat,
                to_air: winding.to_air,
                lost: turn.lost + exchange.impact.0[k],
                quadrant: Quadrant::new(turn.speed, winding.mean),
                fault: self.fault[k],
            };
        }
    }

    /// Prepares the windings for a step.
    #[cold]
    #[inline(never)]
    fn prepare(&mut self, h: f64) {
        for k in 0..N {
            let mut motor = MotorState::at(&self.state.motor, k);
            motor.prepare(&DriveParameters::at(&self.parameters, k).motor, h);
            motor.set(&mut self.state.motor, k);
        }
    }

    /// Latches the first fault.
    pub(super) fn check_faults(&mut self, k: usize) {
        let (winch, winding) = (self.state.winch[k], self.state.motor.winding[k]);
        if self.fault[k].is_some() {
            return;
        }
        self.fault[k] = if winding > self.parameters.motor.hottest[k] {
            Some(DriveFault::Hot { winding })
        } else if winch > self.full.0[k] {
            Some(DriveFault::DrumFull)
        } else if winch < 0.0 {
            Some(DriveFault::DrumEmpty)
        } else {
            None
        };
    }
}

/// A step of all lanes.
struct Step<'a, const N: usize> {
    lanes: &'a mut DriveLanes<N>,
    exchange: &'a mut Exchange<N>,
    h: f64,
}

impl<const N: usize> Work for Step<'_, N> {
    #[inline(always)]
    fn run<A: Arithmetic>(self, _: A) {
        let Self { lanes, exchange, h } = self;
        let Exchange { asked, tension, powered, moved, impact } = exchange;
        let seen = lanes.sense(*tension);
        let mut due = false;
        for k in 0..N {
            let motor = DriveParameters::at(&lanes.parameters, k).motor;
            due |= DriveState::at(&lanes.state, k).motor.is_due(&motor, h);
        }
        if due {
            lanes.prepare(h);
        }
        let arm = lanes.drum.arm(Row(lanes.state.winch));
        // Copies, of which the compiler sees that they do not overlap.
        let (p, asked, pulled, per_ratio) = (&lanes.parameters, asked.clone(), *tension, lanes.per_ratio);
        let (before, mut after) = (lanes.state.clone(), lanes.state.clone());
        let mut done = powered.clone();
        for k in 0..N {
            let p = DriveParameters::at(p, k);
            let asked = Asked::at(&asked, k);
            let mut state = DriveState::at(&before, k);
            let (tension, arm) = (pulled.0[k], arm.0[k]);
            let measured = MeasuredShaft { tension: seen.0[k], speed: state.speed, arm };
            state.command(&p, asked, measured, h);
            let power = state.power(&p, asked.on, tension * arm, h);
            state.advance(p.reducer.backlash, power.turn.speed, per_ratio.0[k], tension, h);
            state.set(&mut after, k);
            power.set(&mut done, k);
        }
        (lanes.state, *powered) = (after, done);
        let wound = lanes.drum.wound(Row(lanes.state.winch));
        *moved = wound - Row(lanes.state.wound);
        *impact = *tension * (arm * Row::all(h) * Row(powered.turn.speed) * lanes.per_ratio - *moved);
        lanes.state.wound = wound.0;
    }
}

/// A tension that is not finite is none.
fn pulling(tension: f64) -> f64 {
    if tension.is_finite() { tension.max(0.0) } else { 0.0 }
}
