//! A machine that a client commands over a link, on virtual time in lock-step.

use crate::common::{PERIOD, STEP, Setup, machine};
use sinew::machine::Task;
use sinew::trajectory::online::{EndPointStep, JointLimits, MuscleLengthStep};
use sinew_link::client::Client;
use sinew_link::host::{Server, ServerSettings, SessionSettings};
use sinew_link::{Command, Mode, Request, SetpointKind, Setpoints, Snapshot};
use sinew_runtime::cycle::{Cycle, Timing, VirtualClock, run};
use sinew_runtime::link::{LinkedMotion, domain};
use sinew_session::TwinPlant;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

const MS: u64 = 1_000_000;
const PATIENCE: Duration = Duration::from_secs(60);

/// A client in lock-step.
struct Driver {
    client: Client,
    now: u64,
}

impl Driver {
    /// Lets the machine's time go on by so many milliseconds.
    fn advance(&mut self, setpoints: Setpoints, milliseconds: u64) -> Snapshot {
        self.now += milliseconds * MS;
        let command = Command { request: Request::Run, advance_to_ns: self.now, setpoints };
        loop {
            self.client.send(&command).unwrap();
            while let Ok(state) = self.client.receive(Duration::from_millis(100)) {
                if state.machine_time_ns >= self.now {
                    return *state;
                }
            }
        }
    }

    /// Numbers from one set-point to another in two seconds, then held; the state after that.
    fn move_to(&mut self, kind: SetpointKind, from: &[f64], to: &[f64]) -> Snapshot {
        let mut state = None;
        for k in 1..=100_u64 {
            let fraction = k as f64 / 100.0;
            let fraction = fraction * fraction * (3.0 - 2.0 * fraction);
            let mut setpoints = Setpoints::new(kind, from.len());
            let numbers: Vec<f64> = from.iter().zip(to).map(|(a, b)| a + fraction * (b - a)).collect();
            assert!(setpoints.push(self.now + 20 * MS, &numbers));
            state = Some(self.advance(setpoints, 20));
        }
        for _ in 0..15 {
            state = Some(self.advance(Setpoints::none(), 100));
        }
        state.unwrap()
    }
}

/// Runs a machine under a client.
fn drive<T: Send>(setup: &Setup, client: impl FnOnce(Driver) -> T + Send) -> T {
    let sessions = SessionSettings { lock_step: true, playout_delay_ns: 0, ..SessionSettings::default() };
    let limits = JointLimits::of_motion(&setup.trajectory, setup.machine.ranges().unwrap()).unwrap();
    let gains = setup.supervisor().controller().gains().clone();
    let tension: Vec<[f64; 2]> = gains.muscles.iter().map(|muscle| muscle.tension).collect();
    let domain = domain("machine", &setup.machine, &limits.range, &tension).unwrap();
    let address = "127.0.0.1:0".parse().unwrap();
    let (server, port) = Server::start(ServerSettings { address, key: None, domain, sessions }).unwrap();
    let start = &setup.machine.start;
    let motion = LinkedMotion::new(port, sessions, &setup.machine, limits, start, None).unwrap();
    let mut cycle: Cycle<'_, TwinPlant> = Cycle::new(setup.twin_bus(), setup.supervisor(), motion, STEP);
    let (stop, mut timing) = (AtomicBool::new(false), Timing::new());
    let address = server.address();
    std::thread::scope(|scope| {
        let driven = scope.spawn(|| {
            // However the client ends, the cycle ends with it.
            let _end = Ending(&stop);
            let session = Client::connect(address, None, PATIENCE).unwrap();
            client(Driver { client: session, now: 0 })
        });
        run(&mut cycle, &mut VirtualClock::default(), PERIOD, &stop, &mut timing, |_| Ok(())).unwrap();
        driven.join().unwrap()
    })
}

struct Ending<'a>(&'a AtomicBool);

impl Drop for Ending<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Largest difference.
fn off(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn positions(state: &Snapshot) -> Vec<f64> {
    state.joints().iter().map(|joint| joint.joint_estimated).collect()
}

#[test]
fn set_points_of_joints_muscle_lengths_and_end_points_move_the_machine() {
    for name in ["planar_leg", "finger", "lm_arm"] {
        let setup = Setup::new(machine(name), 1, &[]);
        let machine = &setup.machine;
        let ranges = machine.ranges().unwrap();
        let start = machine.start.clone();
        let aside = |fraction: f64| -> Vec<f64> {
            let toward = |(start, [low, high]): (&f64, &[f64; 2])| {
                start + fraction * (if high - start > start - low { high - start } else { low - start })
            };
            start.iter().zip(&ranges).map(toward).collect()
        };
        let (near, far) = (aside(0.05), aside(0.15));
        let mut muscles = MuscleLengthStep::new(&machine.robot, &ranges).unwrap();
        let [at_far, at_near] = [&far, &near].map(|pose| muscles.lengths(pose).unwrap().to_vec());
        let mut point = match machine.task {
            Task::EndPoint { site, axes } => {
                Some(EndPointStep::new(&machine.robot, &machine.redundancy, site, axes, &ranges).unwrap())
            }
            Task::Joints => None,
        };
        let points = point.as_mut().map(|step| [step.position(&near).unwrap(), step.position(&far).unwrap()]);
        drive(&setup, |mut driver| {
            let state = driver.advance(Setpoints::none(), 200);
            assert_eq!(state.mode, Mode::Run, "{name}");
            let state = driver.move_to(SetpointKind::Joint, &start, &far);
            let joint_error = off(&positions(&state), &far);
            let state = driver.move_to(SetpointKind::MuscleLength, &at_far, &at_near);
            let length_error = off(&positions(&state), &near);
            let mut point_error = 0.0;
            if let Some([from, to]) = points {
                let state = driver.move_to(SetpointKind::EndPoint, &from, &to);
                point_error = off(&state.end_point, &to);
            }
            eprintln!("{name}: {joint_error:.4} {length_error:.4} rad, {point_error:.5} m");
            assert!(joint_error < 0.02 && length_error < 0.02, "{name}: {joint_error} {length_error}");
            assert!(point_error < 0.01, "{name}: {point_error}");
            assert_eq!((state.mode, state.late), (Mode::Run, 0), "{name}");
        });
    }
}

#[test]
fn tensions_are_followed_within_the_machines_limits() {
    for (name, seconds) in [("planar_leg", 2), ("bench_joint", 2)] {
        let setup = Setup::new(machine(name), 1, &[]);
        let limits: Vec<[f64; 2]> =
            setup.supervisor().controller().gains().muscles.iter().map(|muscle| muscle.tension).collect();
        drive(&setup, |mut driver| {
            let state = driver.advance(Setpoints::none(), 500);
            let tensions = |state: &Snapshot| -> Vec<f64> {
                state.muscles().iter().map(|muscle| muscle.tension_out_estimated_n).collect()
            };
            let from: Vec<f64> = tensions(&state)
                .iter()
                .zip(&limits)
                .map(|(tension, [least, most])| tension.clamp(*least, *most))
                .collect();
            // A little more on every cable: the pose stays nearly where it is.
            let to: Vec<f64> = from.iter().zip(&limits).map(|(f, [_, most])| (1.1 * f).min(*most)).collect();
            let mut state = state;
            for k in 1..=50 * seconds {
                let fraction = (k as f64 / 20.0).min(1.0);
                let mut setpoints = Setpoints::new(SetpointKind::Tension, from.len());
                let numbers: Vec<f64> = from.iter().zip(&to).map(|(a, b)| a + fraction * (b - a)).collect();
                assert!(setpoints.push(driver.now + 20 * MS, &numbers));
                state = driver.advance(setpoints, 20);
            }
            let reached = tensions(&state);
            let distance = |a: &[f64]| {
                let squares = a.iter().zip(&to).map(|(a, b)| (a - b) * (a - b) / (b * b));
                (squares.sum::<f64>() / to.len() as f64).sqrt()
            };
            let (before, after) = (distance(&from), distance(&reached));
            eprintln!("{name}: {from:.1?} {to:.1?} {reached:.1?}, rms {before:.3} {after:.3}");
            assert_eq!(state.mode, Mode::Run, "{name}: {:?}", state.fault);
            assert!(before > 0.08 && after < 0.5 * before, "{name}: {before} {after}");
        });
    }
}
