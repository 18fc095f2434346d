//! A stop over a link holds: every event of a session in every mode, on virtual time without a network, and
//! over sockets in real and virtual time with clients in three languages.

use crate::common::{PERIOD, STEP, Setup, machine};
use sinew::control::supervisor::{Mode, Request};
use sinew::trajectory::online::JointLimits;
use sinew::twin::arm::{ExchangeFailure, Failure, InjectedFault};
use sinew_link::Command;
use sinew_link::client::Client;
use sinew_link::host::{Input, Server, ServerSettings, SessionSettings};
use sinew_runtime::cycle::{Cycle, MonotonicClock, Timing, VirtualClock, run};
use sinew_runtime::link::{CycleInput, LinkedMotion, Taken, domain};
use sinew_session::TwinPlant;
use std::path::{Path, PathBuf};
use std::process::Command as Process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

const SOON: Duration = Duration::from_secs(30);
/// By which a session without a word has ended.
const ENDED: Duration = Duration::from_millis(1300);
/// Time in which its cables are slack, s.
const SLACK: f64 = 4.0;
/// Of a machine that is left, ns of its time.
const UNATTENDED: u64 = 300_000_000;

/// A machine that is released fast, within a time, s.
fn setup(lowering_time: f64, faults: &[InjectedFault]) -> Setup {
    let mut machine = machine("bench_joint");
    (machine.safety.holding_time, machine.safety.lowering_time) = (0.1, lowering_time);
    machine.safety.lowering_speed = 2.0;
    machine.safety.pretension_time = 0.3;
    // A computer with other work is no reason to hold.
    machine.safety.command_age = 30.0;
    Setup::new(machine, 1, faults)
}

fn settings(lock_step: bool) -> SessionSettings {
    let expiry_ns = 1_000_000_000;
    SessionSettings { lock_step, unattended_ns: UNATTENDED, expiry_ns, ..SessionSettings::default() }
}

/// A machine whose sessions and commands are given cycle by cycle.
struct Given<'a> {
    cycle: Cycle<'a, TwinPlant>,
    cycles: u64,
    mode: Mode,
}

impl<'a> Given<'a> {
    fn new(setup: &'a Setup) -> Self {
        let limits = JointLimits::of_motion(&setup.trajectory, setup.machine.ranges().unwrap()).unwrap();
        let start = &setup.machine.start;
        let motion = LinkedMotion::replayed(settings(false), &setup.machine, limits, start).unwrap();
        let cycle = Cycle::new(setup.twin_bus(), setup.supervisor(), motion, STEP);
        Self { cycle, cycles: 0, mode: Mode::Off }
    }

    fn give(&mut self, input: Input) {
        self.cycle.motion_mut().supply(CycleInput { at_ns: self.cycles * PERIOD, what: Taken::Link(input) });
    }

    fn ask(&mut self, request: Request) {
        let request = sinew_link::Request::from_number(request as u8).unwrap();
        self.give(Input::Command(Command::from_request(request)));
    }

    fn step(&mut self) -> Mode {
        self.mode = self.cycle.step(&mut VirtualClock::default(), 0).unwrap().command.mode;
        self.cycles += 1;
        self.mode
    }

    /// A client that goes on to say what it wants, until the machine is in a mode.
    fn reach(&mut self, request: Request, mode: Mode) {
        for _ in 0..5000 {
            self.ask(request);
            if self.step() == mode {
                return;
            }
        }
        panic!("{request:?} does not lead to {mode:?} but to {:?}", self.mode);
    }

    /// A client that has led the machine to a mode; [`Mode::Fault`] by a bus that is lost in the first
    /// second.
    fn in_mode(setup: &'a Setup, mode: Mode) -> Self {
        let mut machine = Self::new(setup);
        machine.give(Input::Begins);
        match mode {
            Mode::Off => {}
            Mode::Ready => machine.reach(Request::GetReady, Mode::Ready),
            // Of slack cables: this machine is tense from the first cycle on.
            Mode::Pretension => {
                machine.reach(Request::Run, Mode::Run);
                machine.reach(Request::GetReady, Mode::Ready);
                machine.reach(Request::Hold, Mode::Pretension);
            }
            Mode::Hold => machine.reach(Request::Hold, Mode::Hold),
            Mode::Run | Mode::Fault => machine.reach(Request::Run, mode),
            Mode::SafeStop => {
                machine.reach(Request::Run, Mode::Run);
                machine.reach(Request::SafeStop, Mode::SafeStop);
            }
        }
        machine
    }

    /// Modes until it is at rest, and a little longer; each once.
    fn modes_to_rest(&mut self) -> Vec<Mode> {
        let mut modes = Vec::new();
        while !AT_REST.contains(&self.mode) && self.cycles < 30_000 {
            modes.extend(self.modes(50));
        }
        modes.extend(self.modes(300));
        modes.dedup();
        modes
    }

    /// Modes from now on, each once.
    fn modes(&mut self, cycles: usize) -> Vec<Mode> {
        let mut modes = Vec::new();
        for _ in 0..cycles {
            let mode = self.step();
            if modes.last() != Some(&mode) {
                modes.push(mode);
            }
        }
        modes
    }
}

/// Modes in which a machine stays where nothing is asked of it, without tension.
const AT_REST: [Mode; 3] = [Mode::Off, Mode::Ready, Mode::Fault];

fn faults_of(mode: Mode) -> Vec<InjectedFault> {
    let failure = Failure::Exchange(ExchangeFailure::Lost);
    let lost = InjectedFault { start: 1.0, duration: 0.02, failure };
    if mode == Mode::Fault { vec![lost] } else { Vec::new() }
}

/// What happens to sessions after a stop: nothing of it asks for anything.
fn happenings() -> Vec<Vec<Input>> {
    let alive = Input::Command(Command::from_request(sinew_link::Request::None));
    vec![
        vec![],
        vec![Input::Ends],
        vec![Input::Ends, Input::Begins],
        vec![Input::Ends, Input::Begins, alive],
        vec![Input::Ends, Input::Begins, alive, Input::Ends],
        vec![alive],
    ]
}

#[test]
fn no_event_of_a_session_undoes_a_stop_in_any_mode_now_or_later() {
    for mode in Mode::ALL {
        let setup = setup(SLACK, &faults_of(mode));
        for stop in [Request::SafeStop, Request::GetReady, Request::TurnOff] {
            for (k, happening) in happenings().into_iter().enumerate() {
                // In the cycle of the stop, while it is released, and when it is down.
                for delay in [0, 50, 1200] {
                    let mut machine = Given::in_mode(&setup, mode);
                    machine.ask(stop);
                    let mut modes = machine.modes(delay);
                    happening.iter().for_each(|input| machine.give(*input));
                    modes.extend(machine.modes_to_rest());
                    let case = format!("{mode:?} {stop:?} {k} after {delay}: {modes:?}");
                    let end = match (stop, mode) {
                        (Request::TurnOff, _) | (Request::SafeStop, Mode::Off) => Mode::Off,
                        (_, Mode::Fault) => Mode::Fault,
                        _ => Mode::Ready,
                    };
                    assert_eq!(modes.last(), Some(&end), "{case}");
                    let under_way = [Mode::Pretension, Mode::Hold, Mode::Run];
                    assert!(!modes.iter().any(|mode| under_way.contains(mode)), "{case}");
                }
            }
        }
    }
}

#[test]
fn a_machine_that_is_left_is_held_for_a_time_and_then_let_down_in_every_mode() {
    for mode in Mode::ALL {
        let setup = setup(SLACK, &faults_of(mode));
        let mut left = Given::in_mode(&setup, mode);
        left.give(Input::Ends);
        let held = left.modes((UNATTENDED / PERIOD) as usize);
        assert!(!held.contains(&Mode::Run), "{mode:?}: {held:?}");
        let down = left.modes(4500);
        let end = if mode == Mode::Fault { Mode::Fault } else { Mode::Ready };
        assert_eq!(down.last(), Some(&end), "{mode:?}: {held:?} {down:?}");
        if matches!(mode, Mode::Hold | Mode::Run) {
            assert_eq!((held, down), (vec![Mode::Hold], vec![Mode::SafeStop, Mode::Ready]), "{mode:?}");
        }
        assert_eq!(left.modes(1000), [end], "nothing moves again");
        // Another client that comes in time finds it held, and may go on.
        if mode == Mode::Run {
            let mut left = Given::in_mode(&setup, mode);
            left.give(Input::Ends);
            left.modes((UNATTENDED / PERIOD) as usize / 2);
            left.give(Input::Begins);
            assert_eq!(left.modes(2000), [Mode::Hold]);
            left.reach(Request::Run, Mode::Run);
        }
    }
}

/// What came of a machine on a link.
#[derive(Debug)]
struct Linked<T> {
    client: T,
    modes: Vec<Mode>,
}

/// Runs the machine in real time or in lock-step under `client`, which is given the address, until that has
/// ended.
fn linked<T: Send>(lock_step: bool, client: impl FnOnce(std::net::SocketAddr) -> T + Send) -> Linked<T> {
    let setup = setup(0.5, &[]);
    let sessions = settings(lock_step);
    let limits = JointLimits::of_motion(&setup.trajectory, setup.machine.ranges().unwrap()).unwrap();
    let tension = setup.controller.gains().tension_limits();
    let domain = domain("machine", &setup.machine, &limits.range, &tension).unwrap();
    let address = "127.0.0.1:0".parse().unwrap();
    let (server, port) = Server::start(ServerSettings { address, key: None, domain, sessions }).unwrap();
    let start = &setup.machine.start;
    let motion = LinkedMotion::new(port, sessions, &setup.machine, limits, start, None).unwrap();
    let mut cycle = Cycle::new(setup.twin_bus(), setup.supervisor(), motion, STEP);
    let (end, mut timing, mut modes) = (AtomicBool::new(false), Timing::new(), Vec::new());
    let address = server.address();
    let client = std::thread::scope(|scope| {
        let client = scope.spawn(|| {
            let _end = Ending(&end);
            client(address)
        });
        let see = |record: &sinew_runtime::cycle::CycleRecord<'_, TwinPlant>| {
            if modes.last() != Some(&record.command.mode) {
                modes.push(record.command.mode);
            }
            Ok(())
        };
        let ran = match lock_step {
            true => run(&mut cycle, &mut VirtualClock::default(), PERIOD, &end, &mut timing, see),
            false => run(&mut cycle, &mut MonotonicClock, PERIOD, &end, &mut timing, see),
        };
        ran.unwrap();
        client.join().unwrap()
    });
    Linked { client, modes }
}

struct Ending<'a>(&'a AtomicBool);

impl Drop for Ending<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Asks until the machine is in a mode; in lock-step 20 ms further each time.
fn until(client: &mut Client, request: sinew_link::Request, mode: sinew_link::Mode) {
    let begin = Instant::now();
    let mut goal = client.session().state().machine_time_ns;
    while client.session().state().mode != mode {
        assert!(
            begin.elapsed() < SOON,
            "{request:?} does not lead to {mode:?}: {:?}",
            client.session().state()
        );
        if client.session().state().machine_time_ns >= goal {
            goal += 20_000_000;
        }
        client.send(&Command { advance_to_ns: goal, ..Command::from_request(request) }).unwrap();
        let _ = client.receive(Duration::from_millis(20));
    }
}

/// How a client leaves after its stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Leaves {
    Closing,
    Silently,
    Hastily,
}

#[test]
fn a_stop_over_sockets_outlives_its_client_in_real_and_virtual_time() {
    use sinew_link::{Mode as LinkMode, Request as LinkRequest};
    for lock_step in [false, true] {
        for leaves in [Leaves::Closing, Leaves::Silently, Leaves::Hastily] {
            let linked = linked(lock_step, |address| {
                let mut client = Client::connect(address, None, SOON).unwrap();
                until(&mut client, LinkRequest::Run, LinkMode::Run);
                let mut watcher = Client::connect_to_watch(address, None, SOON).unwrap();
                watcher.watch().unwrap();
                let granted = client.session().state().machine_time_ns + 1_500_000_000;
                let stop = Command { advance_to_ns: granted, ..Command::from_request(LinkRequest::SafeStop) };
                client.send(&stop).unwrap();
                match leaves {
                    Leaves::Closing => client.close().unwrap(),
                    // Its session ends a second later.
                    Leaves::Silently => drop(client),
                    // The Goodbye comes with the stop.
                    Leaves::Hastily => client.close_at_once().unwrap(),
                }
                drop(watcher);
                // Whoever comes next asks for nothing.
                let mut next = Client::connect(address, None, SOON).unwrap();
                let begin = Instant::now();
                let mut seen = Vec::new();
                let mut goal = granted;
                // It is seen at rest, and once the session that left has ended.
                let at_rest = |seen: &[LinkMode]| seen.last() == Some(&LinkMode::Ready);
                while begin.elapsed() < ENDED || (!at_rest(&seen) && begin.elapsed() < SOON) {
                    goal += 20_000_000;
                    next.send(&Command { advance_to_ns: goal, ..Command::from_request(LinkRequest::None) })
                        .unwrap();
                    if let Ok(state) = next.receive(Duration::from_millis(20))
                        && seen.last() != Some(&state.mode)
                    {
                        seen.push(state.mode);
                    }
                }
                next.close().unwrap();
                seen
            });
            let case = format!("{lock_step} {leaves:?}: {linked:?}");
            let last = linked.modes.iter().rposition(|mode| *mode == Mode::Run).unwrap();
            assert_eq!(linked.modes[last..], [Mode::Run, Mode::SafeStop, Mode::Ready], "{case}");
            assert!(!linked.client.contains(&LinkMode::Hold), "{case}");
            assert_eq!(linked.client.last(), Some(&LinkMode::Ready), "{case}");
        }
    }
}

fn clients() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../clients")
}

/// Whether a program is there; says so where it is not.
fn is_there(program: &str) -> bool {
    let there = Process::new(program).arg("--version").output().is_ok_and(|output| output.status.success());
    if !there {
        eprintln!("skipped: no {program}");
    }
    there
}

/// A client in another language that runs the machine, stops it, and closes; then nobody is there for a
/// while.
fn stopped_by(mut command: Process, lock_step: bool) {
    let linked = linked(lock_step, |address| {
        let port = address.port().to_string();
        let output = command.args([port.as_str(), if lock_step { "1" } else { "0" }]).output().unwrap();
        std::thread::sleep(Duration::from_millis(if lock_step { 100 } else { 1500 }));
        output
    });
    let (output, modes) = (linked.client, linked.modes);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text} {}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(text.trim(), "acknowledged", "{modes:?}");
    let last = modes.iter().rposition(|mode| *mode == Mode::Run).unwrap();
    assert_eq!(modes[last..], [Mode::Run, Mode::SafeStop, Mode::Ready], "{lock_step}: {modes:?}");
}

#[test]
fn a_stop_of_the_python_client_outlives_it() {
    if !is_there("python3") {
        return;
    }
    let script = "import sys, time
from sinew_link import Link, SAFE_STOP
port, lock_step = int(sys.argv[1]), sys.argv[2] == '1'
link, goal, mode, end = Link(('127.0.0.1', port)), 0, 0, time.monotonic() + 30
while mode != 4 and time.monotonic() < end:
    goal += 20_000_000
    for _ in range(50):
        link.command(5, advance_to_ns=goal if lock_step else 0)
        state = link.state()
        if state and (not lock_step or state['machine_time_ns'] >= goal): break
    mode = state['mode'] if state else mode
link.command(SAFE_STOP, advance_to_ns=goal + 1_500_000_000 if lock_step else 0)
print('acknowledged' if link.close(5.0) else 'not acknowledged')
";
    for lock_step in [false, true] {
        let mut command = Process::new("python3");
        command.args(["-B", "-c", script]).env("PYTHONPATH", clients().join("python"));
        stopped_by(command, lock_step);
    }
}

#[test]
fn a_stop_of_the_c_client_outlives_it() {
    if !is_there("cc") {
        return;
    }
    let program = "#include <stdio.h>
#include <stdlib.h>
#define SINEW_LINK_IMPLEMENTATION
#include \"sinew_link.h\"
int main(int count, char **arguments) {
    static sinew_link robot;
    if (count < 3 || sinew_link_open(&robot, \"127.0.0.1\", (unsigned)atoi(arguments[1]), NULL, 5.0)) \
    return 1;
    uint64_t goal = 0, lock_step = atoi(arguments[2]) == 1, end = sinew_now() + 30000000000u;
    while (robot.state.mode != SINEW_RUN && sinew_now() < end) {
        goal += 20000000u;
        for (int i = 0; i < 50; i++) {
            sinew_link_command(&robot, SINEW_ASK_RUN, SINEW_NONE, NULL, NULL, 0, 0, lock_step * goal);
            if (sinew_link_receive(&robot, 0.1) && (!lock_step || robot.state.machine_time_ns >= goal)) break;
        }
    }
    sinew_link_command(&robot, SINEW_ASK_SAFE_STOP, SINEW_NONE, NULL, NULL, 0, 0, lock_step * (goal + \
    1500000000u));
    puts(sinew_link_close(&robot) ? \"not acknowledged\" : \"acknowledged\");
    return 0;
}
";
    let folder = std::env::temp_dir().join(format!("sinew-link-stop-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (source, built) = (folder.join("stop.c"), folder.join("stop"));
    std::fs::write(&source, program).unwrap();
    let output = Process::new("cc")
        .args(["-std=c99", "-O1", "-D_POSIX_C_SOURCE=200809L", "-I"])
        .arg(clients().join("c"))
        .arg("-o")
        .args([&built, &source])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for lock_step in [false, true] {
        stopped_by(Process::new(&built), lock_step);
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
