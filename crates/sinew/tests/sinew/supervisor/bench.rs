//! A supervised lever between two cables: its readings are given, or those of its twin.

use sinew::control::arm::{
    ActuationMode, ArmController, ArmMeasurement, ArmStatus, CableStateSource, PreviewedReference, synthesize,
};
use sinew::control::supervisor::{
    ExchangeStatus, FaultKind, Limits, Mode, MuscleState, NamedFault, Request, Supervisor,
};
use sinew::drive::DriveCommand;
use sinew::machine::Machine;
use sinew::predictor::CableModel;
use sinew::trajectory::Reference;
use sinew::twin::arm::{ArmSpecimen, ArmTwin};
use sinew::twin::cable::Specimen;
use std::sync::OnceLock;

/// Control period, s.
pub(crate) const H: f64 = 1e-3;
/// Nothing unusual.
pub(crate) const FINE: ExchangeStatus =
    ExchangeStatus { received: true, drive: None, lateness: 0.0, command_age: None };
/// No readings.
pub(crate) const LOST: ExchangeStatus = ExchangeStatus { received: false, ..FINE };
pub(crate) const STANDING: DriveCommand = DriveCommand::Velocity(0.0);

/// The design, the models of its cables and their controller.
fn design() -> &'static (Machine, Vec<CableModel>, ArmController) {
    static DESIGN: OnceLock<(Machine, Vec<CableModel>, ArmController)> = OnceLock::new();
    DESIGN.get_or_init(|| {
        let text = sinew_models::BENCH_JOINT;
        let machine = sinew::description::machine_from_toml("bench_joint.toml", text, &mut |_| {
            Err("no other file".into())
        })
        .unwrap()
        .machine;
        let model = |cable: &Specimen| {
            let mut parameters = cable.parameters;
            parameters.weakening = cable.effects.slow.map(|slow| slow.weakening);
            parameters.sheath_compliance += cable.effects.sheath.map_or(0.0, |sheath| sheath.compliance);
            CableModel { path: cable.path.clone(), parameters, start: 1.0, ..CableModel::bench() }
        };
        let models: Vec<CableModel> =
            ArmSpecimen::nominal(&machine).unwrap().cables.iter().map(model).collect();
        let (gains, _) = synthesize(&machine, &models, &machine.poses(20).unwrap()).unwrap();
        let mode = ActuationMode::WinchSpeed(CableStateSource::Observer);
        let controller = ArmController::new(&machine.robot, &models, gains, mode).unwrap();
        (machine, models, controller)
    })
}

pub(crate) fn controller() -> ArmController {
    design().2.clone()
}

/// Compliance of a whole cable, m/N.
pub(crate) fn compliance() -> f64 {
    design().1[0].law().unwrap().compliance().iter().sum()
}

/// Tensions at the drives that carry the lever in a pose, N: the least ones at the anchors that balance
/// gravity, both cables having slid toward their drives.
pub(crate) fn carrying(q: f64) -> [f64; 2] {
    // 0.8 kg at 0.11 m on a drum of 30 mm.
    let (torque, arm) = (0.8 * 9.81 * 0.11 * q.sin(), 0.03);
    let least = |k: usize| design().2.gains().muscles[k].tension[0];
    let anchors = [least(0) + (torque / arm).max(0.0), least(1) + (-torque / arm).max(0.0)];
    [0, 1].map(|k| design().1[k].law().unwrap().steady(anchors[k], 0.0, 1.0).unwrap().tension_in)
}

/// What came of one cycle.
#[derive(Debug, Clone)]
pub(crate) struct Cycle {
    pub(crate) mode: Mode,
    pub(crate) fault: Option<NamedFault>,
    pub(crate) muscles: [MuscleState; 2],
    pub(crate) drives: [DriveCommand; 2],
    pub(crate) reference: Reference,
    pub(crate) status: ArmStatus,
    pub(crate) desired_tension: [f64; 2],
}

impl Cycle {
    pub(crate) fn kind(&self) -> Option<FaultKind> {
        self.fault.map(NamedFault::kind)
    }

    /// Speeds of the winches, m/s; NaN where a drive is given none.
    pub(crate) fn speeds(&self) -> [f64; 2] {
        self.drives.map(|drive| if let DriveCommand::Velocity(speed) = drive { speed } else { f64::NAN })
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Bench {
    pub(crate) supervisor: Supervisor,
    pub(crate) motor: [f64; 2],
    pub(crate) tension: [f64; 2],
    pub(crate) joint: f64,
    pub(crate) reference: Reference,
    /// The same 0.12 s later.
    pub(crate) previewed: Reference,
    twin: Option<ArmTwin>,
}

impl Bench {
    /// Off, with these tensions, N, and with limits that the gains alone tell, then changed.
    pub(crate) fn new(tension: [f64; 2], change: impl FnOnce(&mut Limits)) -> Self {
        let controller = controller();
        let mut limits = Limits::of_gains(controller.gains());
        change(&mut limits);
        Self {
            supervisor: Supervisor::new(controller, limits).unwrap(),
            motor: [0.2; 2],
            tension,
            joint: 0.0,
            reference: Reference::new(1),
            previewed: Reference::new(1),
            twin: None,
        }
    }

    /// Off, with readings of a twin that hangs at rest under tension; limits as in [`Self::new`].
    pub(crate) fn live(change: impl FnOnce(&mut Limits)) -> Self {
        let mut bench = Self::new([0.0; 2], change);
        bench.hang();
        bench
    }

    /// The twin hangs at rest under tension, whatever has happened to it.
    pub(crate) fn hang(&mut self) {
        let specimen = ArmSpecimen::nominal(&design().0).unwrap();
        self.twin = Some(ArmTwin::new(&specimen, &[0.0], &[25.0; 2], 1).unwrap());
        // The first readings are delayed.
        (0..5).for_each(|_| self.advance(&[STANDING; 2]));
    }

    fn advance(&mut self, drives: &[DriveCommand]) {
        let Some(twin) = &mut self.twin else { return };
        twin.step(drives, H).unwrap();
        let reading = twin.reading();
        self.motor.copy_from_slice(&reading.motor);
        self.tension.copy_from_slice(&reading.tension);
        self.joint = reading.joint[0];
    }

    /// The reference moves at this speed, rad/s, from now on.
    pub(crate) fn lead(&mut self, speed: f64) {
        self.reference.q[0] += H * speed;
        self.previewed.q[0] = self.reference.q[0] + 0.12 * speed;
        (self.reference.v[0], self.previewed.v[0]) = (speed, speed);
    }

    /// The reference is at rest in a pose.
    pub(crate) fn rest_in(&mut self, q: f64) {
        self.reference = Reference { q: vec![q], ..Reference::new(1) };
        self.previewed = self.reference.clone();
    }

    pub(crate) fn step(&mut self, request: Request) -> Cycle {
        self.step_with(request, FINE)
    }

    /// A cycle; without readings they are no numbers.
    pub(crate) fn step_with(&mut self, request: Request, exchange: ExchangeStatus) -> Cycle {
        let lost = [f64::NAN; 2];
        let measurement = match exchange.received {
            true => ArmMeasurement {
                motor: &self.motor,
                tension: &self.tension,
                joint: std::slice::from_ref(&self.joint),
            },
            false => ArmMeasurement { motor: &lost, tension: &lost, joint: &lost[..1] },
        };
        let reference =
            PreviewedReference { current: &self.reference, previewed: &self.previewed, repeat_time: None };
        let command = self.supervisor.step(H, &measurement, &reference, request, &exchange).unwrap();
        let cycle = Cycle {
            mode: command.mode,
            fault: command.fault,
            muscles: command.muscles.try_into().unwrap(),
            drives: command.arm.drives.try_into().unwrap(),
            reference: command.reference.clone(),
            status: command.arm.status,
            desired_tension: command.arm.desired_tension.try_into().unwrap(),
        };
        assert_eq!(cycle.mode, self.supervisor.mode());
        self.advance(&cycle.drives);
        cycle
    }

    /// The last of some cycles.
    pub(crate) fn steps(&mut self, cycles: usize, request: Request) -> Cycle {
        for _ in 1..cycles {
            self.step(request);
        }
        self.step(request)
    }

    /// Cycles until the mode is another, and the first of that.
    pub(crate) fn until_left(
        &mut self,
        request: Request,
        exchange: ExchangeStatus,
        most: usize,
    ) -> Option<(usize, Cycle)> {
        let before = self.supervisor.mode();
        (1..=most).map(|k| (k, self.step_with(request, exchange))).find(|(_, cycle)| cycle.mode != before)
    }
}
