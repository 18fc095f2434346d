//! A bus of one's own, lines of text over UDP: `text_bus devices 127.0.0.1:7400` are the drives and sensors
//! of `planar_leg`, simulated; `text_bus run 127.0.0.1:7400`, another process, moves it. See docs/bus.md.

#![allow(clippy::print_stdout, reason = "an example prints")]

use sinew::control::arm::resting_tensions;
use sinew::control::supervisor::{Limits, Supervisor};
use sinew::drive::DriveCommand;
use sinew::machine::{Machine, SafetyLimits};
use sinew::trajectory::{MinimumJerk, Schedule, Trajectory};
use sinew::twin::arm::{ArmSpecimen, ArmTwin};
use sinew_lab::{arm::IdentifiedMachine, machine_file::load_machine};
use sinew_runtime::cycle::{Cycle, MonotonicClock, Timing, run};
use sinew_runtime::{Bus, BusError, Devices, Wire};
use sinew_session::{BusFault, BusStatistics, Exchange, Feedback, Plant, Scheduled, TwinPlant};
use std::{error::Error, fmt::Write as _, net::UdpSocket, path::Path, time::Duration};

/// The line in the list of buses.
const BUS: Bus = Bus {
    name: "text",
    about: "Lines of text over UDP",
    needs_interface: true,
    reads_ahead: false,
    open,
    words: |_| String::new(),
    tables: None,
};

fn open(address: &str) -> Result<Box<dyn Wire>, BusError> {
    let socket = UdpSocket::bind("127.0.0.1:0").and_then(|socket| socket.connect(address).map(|()| socket));
    Ok(Box::new(TextWire(socket.map_err(|error| BusError::System(error.into()))?)))
}

struct TextWire(UdpSocket);

impl Wire for TextWire {
    fn operate<'a>(&'a mut self, machine: &Machine, _: &Devices) -> Result<Box<dyn Plant + 'a>, BusError> {
        let patience = self.0.set_read_timeout(Some(Duration::from_nanos(machine.period_ns() / 2)));
        patience.map_err(|error| BusError::System(error.into()))?;
        let (line, muscles) = (String::with_capacity(4096), machine.muscles.len());
        Ok(Box::new(TextBus { socket: &self.0, cycle: 0, line, answer: [0; 4096], muscles }))
    }
}

struct TextBus<'a> {
    socket: &'a UdpSocket,
    cycle: u64,
    /// Long enough for every line, so that writing into it neither allocates nor fails.
    line: String,
    answer: [u8; 4096],
    muscles: usize,
}

impl TextBus<'_> {
    /// Sends `read CYCLE` and takes over the numbers of its answer; answers to earlier cycles are left out.
    fn ask(&mut self, feedback: &mut Feedback) -> Option<()> {
        self.cycle += 1;
        self.line.clear();
        write!(self.line, "read {}", self.cycle).ok()?;
        self.socket.send(self.line.as_bytes()).ok()?;
        loop {
            let length = self.socket.recv(&mut self.answer).ok()?;
            let mut words = str::from_utf8(&self.answer[..length]).ok()?.split_whitespace();
            if words.next()?.parse() == Ok(self.cycle) {
                let Feedback { motor, tension, joint, .. } = feedback;
                let mut numbers = motor.iter_mut().chain(tension).chain(joint);
                return numbers.try_for_each(|number| words.next()?.parse().ok().map(|read| *number = read));
            }
        }
    }
}

impl Plant for TextBus<'_> {
    fn read(&mut self, feedback: &mut Feedback) -> Exchange {
        feedback.clear();
        Exchange { fault: self.ask(feedback).is_none().then_some(BusFault::Lost) }
    }

    /// Sends `write COMMAND ..`: a speed of the cable, m/s, `off` or `brake`.
    fn write(&mut self, commands: &[DriveCommand]) {
        self.line.replace_range(.., "write");
        for command in commands {
            let _ = match command {
                DriveCommand::Velocity(speed) => write!(self.line, " {speed}"),
                DriveCommand::Off => write!(self.line, " off"),
                _ => write!(self.line, " brake"),
            };
        }
        let _ = self.socket.send(self.line.as_bytes());
    }
}

impl Drop for TextBus<'_> {
    /// The drives slow down by themselves, and brake when they stand.
    fn drop(&mut self) {
        self.write(&vec![DriveCommand::Velocity(0.0); self.muscles]);
    }
}

/// The other end: drives and sensors of a twin, which moves on by a period with every cycle.
fn devices(address: &str, mut twin: TwinPlant, mut feedback: Feedback) -> Result<(), Box<dyn Error>> {
    let (socket, mut bytes) = (UdpSocket::bind(address)?, [0; 4096]);
    loop {
        let (length, from) = socket.recv_from(&mut bytes)?;
        let mut words = str::from_utf8(&bytes[..length])?.split_whitespace();
        if words.next() == Some("read") {
            twin.read(&mut feedback);
            let numbers = [&feedback.motor, &feedback.tension, &feedback.joint].into_iter().flatten();
            let cycle = words.next().unwrap_or_default().to_owned();
            let answer = numbers.fold(cycle, |line, number| format!("{line} {number}"));
            socket.send_to(answer.as_bytes(), from)?;
        } else {
            let command = |word: &str| match word {
                "off" => DriveCommand::Off,
                speed => speed.parse().map_or(DriveCommand::Brake, DriveCommand::Velocity),
            };
            twin.write(&words.map(command).collect::<Vec<_>>());
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [role, address] = &arguments[..] else { return Err("expected: devices|run ADDRESS".into()) };
    let mut machine = load_machine(Path::new("planar_leg"), None)?.machine;
    // These devices wait for a cycle, which a computer with other work may begin late.
    let SafetyLimits { bridged_loss, bridged_lateness, lateness, .. } = &mut machine.safety;
    (*bridged_loss, *bridged_lateness, *lateness) = (0.1, 1.0, 10.0);
    let end: Vec<f64> = machine.start.iter().map(|q| 0.8 * q).collect();
    let trajectory = Trajectory::PointToPoint(MinimumJerk::new(&machine.start, &end, 2.0)?);
    let controller = IdentifiedMachine::designed(&machine, &trajectory, None)?.plain_controller()?;
    let gains = controller.gains();
    if role == "devices" {
        let tensions = resting_tensions(&machine.robot, &machine.start, &gains.tension_limits())?;
        let arm = ArmTwin::new(&ArmSpecimen::nominal(&machine)?, &machine.start, &tensions, 1)?;
        let feedback = Feedback::new(machine.muscles.len(), machine.start.len());
        return devices(address, TwinPlant::new(arm), feedback);
    }
    let mut wire = (BUS.open)(address)?;
    let plant = wire.operate(&machine, &Devices::default())?;
    let schedule = Schedule::new(&trajectory, 1, 0.3, 0.7)?;
    let schedule = Scheduled::new(schedule, &machine.robot, &machine.start)?;
    let limits = Limits::from_machine(&machine, gains)?;
    let mut cycle = Cycle::new(plant, Supervisor::new(controller, limits)?, schedule, machine.period);
    let (mut timing, mut error) = (Timing::new(), 0.0_f64);
    run(&mut cycle, &mut MonotonicClock, machine.period_ns(), &false.into(), &mut timing, |record| {
        let errors = record.feedback.joint.iter().zip(&record.reference.q).map(|(q, desired)| q - desired);
        error = errors.map(f64::abs).fold(error, f64::max);
        Ok(())
    })?;
    let (mode, BusStatistics { exchanges, lost, .. }) = (cycle.mode(), cycle.statistics());
    println!("{mode:?} after {exchanges} cycles, {lost} of them lost; errors up to {error:.4} rad");
    Ok(())
}
