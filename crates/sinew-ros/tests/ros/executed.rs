//! What a machine makes of it, cycle by cycle.

use crate::common::{PERIOD, STEP, Setup, machine};
use crate::messages::{Point, state, trajectory};
use allocation_counter::measure;
use rand::{RngExt, SeedableRng};
use sinew::control::supervisor::Mode as SupervisorMode;
use sinew::trajectory::online::JointLimits;
use sinew_link::host::SessionSettings;
use sinew_link::{Mode, Request};
use sinew_record::ros2::CdrReader;
use sinew_ros::{Commands, Refusal, Tap};
use sinew_runtime::cycle::{Cycle, VirtualClock};
use sinew_runtime::link::{LinkedMotion, domain};
use sinew_session::TwinPlant;

const MS: u64 = 1_000_000;
const NAMES: [&str; 2] = ["hip", "knee"];
const UNATTENDED: u64 = 300 * MS;

/// A machine and what other nodes ask of it.
struct World<'a> {
    cycle: Cycle<'a, TwinPlant>,
    commands: Commands,
    now: u64,
    /// Whether other nodes are there.
    anyone: bool,
    start: Vec<f64>,
}

fn setup() -> Setup {
    let mut machine = machine("planar_leg");
    (machine.safety.holding_time, machine.safety.lowering_time) = (0.1, 0.5);
    machine.safety.lowering_speed = 2.0;
    Setup::new(machine, 1, &[])
}

impl<'a> World<'a> {
    fn new(setup: &'a Setup) -> Self {
        let settings = SessionSettings { unattended_ns: UNATTENDED, ..SessionSettings::default() };
        let machine = &setup.machine;
        let limits = JointLimits::of_motion(&setup.trajectory, machine.ranges().unwrap()).unwrap();
        let tension = setup.controller.gains().tension_limits();
        let domain = domain("planar_leg", machine, &limits.range, &tension).unwrap();
        let joints = NAMES.map(str::to_owned).to_vec();
        let (commands, port) = Commands::new(domain, joints, settings).unwrap();
        let start = machine.start.clone();
        let motion = LinkedMotion::new(port, settings, machine, limits, &start, None).unwrap();
        let cycle = Cycle::new(setup.twin_bus(), setup.supervisor(), motion, STEP);
        Self { cycle, commands, now: 0, anyone: true, start }
    }

    /// In run.
    fn running(setup: &'a Setup) -> Self {
        let mut world = Self::new(setup);
        world.pass(500);
        world.commands.request(Request::Run).unwrap();
        world.pass(200);
        assert_eq!(world.mode(), Mode::Run);
        world
    }

    fn pass(&mut self, milliseconds: u64) {
        for _ in 0..milliseconds {
            self.commands.pass(self.now, self.anyone);
            self.cycle.step(&mut VirtualClock::default(), 0).unwrap();
            self.now += PERIOD;
        }
    }

    fn mode(&mut self) -> Mode {
        self.commands.state().mode
    }

    fn reference(&mut self) -> Vec<f64> {
        self.commands.state().joints().iter().map(|joint| joint.joint_reference).collect()
    }

    fn send(&mut self, points: &[Point<'_>]) -> Result<(), Refusal> {
        self.send_bytes(&trajectory(0, &NAMES, points))
    }

    fn send_bytes(&mut self, bytes: &[u8]) -> Result<(), Refusal> {
        self.commands.trajectory(CdrReader::new(bytes).unwrap(), 1_000_000_000_000)
    }

    fn stream(&mut self, sender: u8, positions: &[f64]) -> Result<(), Refusal> {
        let bytes = state(&NAMES, positions);
        self.commands.setpoint([sender; 16], CdrReader::new(&bytes).unwrap(), self.now)
    }

    /// The start, and so far from it.
    fn aside(&self, by: f64) -> Vec<f64> {
        self.start.iter().map(|q| q + by).collect()
    }
}

fn off(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn a_trajectory_is_executed_to_its_last_point_also_where_its_sender_has_gone() {
    let setup = setup();
    let mut world = World::running(&setup);
    let (there, back) = (world.aside(0.08), world.aside(-0.03));
    world.send(&[(&there, &[], [1, 0]), (&back, &[], [2, 500_000_000])]).unwrap();
    world.anyone = false;
    let mut farthest = 0.0_f64;
    for _ in 0..2700 {
        world.pass(1);
        farthest = farthest.max(world.reference()[0] - world.start[0]);
    }
    assert!((farthest - 0.08).abs() < 0.002, "{farthest}: through the point between, not beyond");
    assert!(off(&world.reference(), &back) < 1e-3, "{:?} {back:?}", world.reference());
    assert_eq!(world.commands.state().late, 0);
    let error = off(&setup_pose(&world), &back);
    assert!(error < 0.02, "{error} rad");
    // Nobody is there, and nothing goes on any more.
    world.pass(300 + UNATTENDED / MS);
    assert_eq!(world.mode(), Mode::Hold);
    world.pass(UNATTENDED / MS + 10);
    assert_eq!(world.mode(), Mode::SafeStop);
}

fn setup_pose(world: &World<'_>) -> Vec<f64> {
    world.cycle.plant().arm().truth().q.to_vec()
}

#[test]
fn hundreds_of_points_are_given_as_there_is_room() {
    let setup = setup();
    let mut world = World::running(&setup);
    let count = 1500_u64;
    let at = |k: u64| 0.05 * (1.0 - (core::f64::consts::TAU * k as f64 / count as f64).cos());
    let poses: Vec<Vec<f64>> = (0..=count).map(|k| world.aside(at(k))).collect();
    let points: Vec<Point<'_>> = poses
        .iter()
        .enumerate()
        .map(|(k, pose)| (&pose[..], &[][..], [(k / 500) as i32, (2_000_000 * (k % 500)) as i32]))
        .collect();
    world.send(&points).unwrap();
    let mut worst = 0.0_f64;
    for k in 0..2900_u64 {
        world.pass(1);
        if k > 400 {
            // Behind the points by the lead of a trajectory, the delay of set-points and the preview.
            let now = at(k / 2 - (10 + 4 + 120) / 2);
            worst = worst.max((world.reference()[0] - world.start[0] - now).abs());
        }
    }
    assert!(worst < 2e-3, "{worst} rad");
    assert_eq!(world.commands.state().late, 0);
}

#[test]
fn what_is_refused_moves_nothing() {
    let setup = setup();
    let mut world = World::running(&setup);
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let still = world.reference();
    let names = [&NAMES[..], &["hip"], &["hip", "ankle"], &["hip", "hip"]];
    for _ in 0..300 {
        let mut poses = [world.aside(0.1), world.aside(0.2)];
        let (mut times, mut given) = ([[1, 0], [2, 0]], names[0]);
        let pose = random.random_range(0..2_usize);
        match random.random_range(0..5_u32) {
            0 => given = names[random.random_range(1..4_usize)],
            1 => poses[pose][random.random_range(0..2_usize)] = f64::NAN,
            2 => poses[pose][random.random_range(0..2_usize)] = random.random_range(7.0..1e9),
            3 => times[1] = [random.random_range(-9..=1), 0],
            _ => poses[pose].truncate(random.random_range(0..2_usize)),
        }
        let points = [(&poses[0][..], &[][..], times[0]), (&poses[1][..], &[][..], times[1])];
        let text = world.send_bytes(&trajectory(0, given, &points)).unwrap_err().to_string();
        assert!(text.contains("expected") && text.lines().count() == 1, "{text}");
        world.pass(1);
    }
    for (stamp, fine) in [(998, false), (1061, false), (999, true)] {
        let there = world.aside(0.0);
        let bytes = trajectory(stamp * 1_000_000_000, &NAMES, &[(&there, &[], [1, 0])]);
        assert_eq!(world.send_bytes(&bytes).is_ok(), fine, "{stamp} s");
    }
    world.pass(100);
    assert!(off(&still, &world.reference()) < 1e-12);
    assert_eq!(world.mode(), Mode::Run);
}

#[test]
fn one_at_a_time_moves_the_machine_and_a_hold_ends_its_motion() {
    let setup = setup();
    let mut world = World::new(&setup);
    world.pass(500);
    let there = world.aside(0.1);
    let text = world.send(&[(&there, &[], [2, 0])]).unwrap_err().to_string();
    assert_eq!(text, "mode: expected a machine in Run, got Hold");
    assert!(world.stream(1, &there).is_err());
    world.commands.request(Request::Run).unwrap();
    world.pass(100);
    world.send(&[(&there, &[], [2, 0])]).unwrap();
    world.pass(500);
    assert!(world.send(&[(&there, &[], [2, 0])]).unwrap_err().to_string().contains("the trajectory before"));
    assert!(world.stream(1, &there).unwrap_err().to_string().contains("the end of the trajectory"));
    world.commands.request(Request::Hold).unwrap();
    world.pass(300);
    let held = world.reference();
    assert!(off(&held, &there) > 0.05, "it was under way: {held:?}");
    world.pass(2000);
    assert!(off(&held, &world.reference()) < 1e-9, "the rest of it was forgotten");
    world.commands.request(Request::Run).unwrap();
    world.pass(500);
    assert_eq!(world.mode(), Mode::Run);
    assert!(off(&held, &world.reference()) < 1e-9, "also where it runs again");
    let (held, slightly) = (held.clone(), held.iter().map(|q| q + 0.01).collect::<Vec<_>>());
    world.stream(1, &held).unwrap();
    assert!(world.stream(2, &held).unwrap_err().to_string().contains("another node's set-points"));
    assert!(world.send(&[(&there, &[], [2, 0])]).unwrap_err().to_string().contains("the set-points"));
    // Half of the speed that is allowed at most.
    for k in 1..=100 {
        let toward = |(a, b): (&f64, &f64)| a + (b - a) * f64::from(k.min(80)) / 80.0;
        let pose: Vec<f64> = held.iter().zip(&slightly).map(toward).collect();
        world.stream(1, &pose).unwrap();
        world.pass(10);
    }
    assert!(off(&slightly, &world.reference()) < 1e-3, "{:?} {slightly:?}", world.reference());
}

#[test]
fn set_points_that_stop_end_in_hold_and_run_counts_again() {
    let setup = setup();
    let mut world = World::running(&setup);
    let here = world.reference();
    for _ in 0..20 {
        world.stream(1, &here).unwrap();
        world.pass(20);
    }
    assert_eq!(world.mode(), Mode::Run);
    world.pass(70);
    assert_eq!(world.mode(), Mode::Run);
    world.pass(20);
    assert_eq!(world.mode(), Mode::Hold);
    assert!(world.stream(1, &here).is_err(), "nothing moves again by itself");
    world.commands.request(Request::Run).unwrap();
    world.pass(100);
    assert_eq!(world.mode(), Mode::Run);
}

#[test]
fn a_flood_of_set_points_leaves_room_for_a_stop() {
    let setup = setup();
    let mut world = World::running(&setup);
    let here = world.reference();
    let mut refused = 0;
    for _ in 0..100 {
        for _ in 0..50 {
            refused += usize::from(world.stream(1, &here).is_err());
        }
        world.pass(1);
    }
    assert!((4800..4900).contains(&refused), "{refused} of 5000");
    world.commands.request(Request::SafeStop).unwrap();
    world.pass(10);
    assert_eq!(world.mode(), Mode::SafeStop);
}

#[test]
fn a_safe_stop_is_undone_by_nobody_who_comes_or_goes() {
    let setup = setup();
    let mut world = World::running(&setup);
    let there = world.aside(0.05);
    world.commands.request(Request::SafeStop).unwrap();
    for k in 0..40 {
        world.anyone = k % 3 == 0;
        assert!(world.stream(3, &there).is_err() || k == 0);
        assert!(world.send(&[(&there, &[], [1, 0])]).is_err() || k == 0);
        world.pass(100);
        let mode = world.mode();
        assert!(matches!(mode, Mode::SafeStop | Mode::Ready), "{k}: {mode:?}");
    }
    assert_eq!(world.mode(), Mode::Ready);
    world.commands.request(Request::Hold).unwrap();
    world.pass(2000);
    assert_eq!(world.mode(), Mode::Hold, "a request does");
    world.commands.request(Request::TurnOff).unwrap();
    world.pass(3000);
    assert_eq!(world.cycle.supervisor().mode(), SupervisorMode::Off);
}

#[test]
fn a_cycle_that_a_node_looks_at_and_commands_allocates_nothing() {
    let setup = setup();
    let mut world = World::running(&setup);
    let there = world.aside(0.05);
    world.send(&[(&there, &[], [2, 0])]).unwrap();
    let mut tap = Tap::detached([setup.machine.muscles.len(), 2], STEP);
    let mut allocations = 0;
    // The ring is full for the last of them.
    for _ in 0..1500 {
        world.commands.pass(world.now, true);
        let counted = measure(|| {
            let record = world.cycle.step(&mut VirtualClock::default(), 0).unwrap();
            tap.show(&record);
        });
        allocations += counted.count_total;
        world.now += PERIOD;
    }
    assert_eq!(allocations, 0);
    assert!(tap.missed() > 100, "{}", tap.missed());
    assert!(off(&world.reference(), &world.start) > 0.01, "it moved");
}
