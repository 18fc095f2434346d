//! Servos in operation: one request to every line, one deadline for all answers.

use super::bring_up::{Configuring, Exchange as Question};
use super::device::{OperatingMode, ServoDevice};
use super::error::ServoError;
use super::line::Lines;
use super::protocol::instruction::{FAST_SYNC_READ, STATUS, SYNC_READ, SYNC_WRITE};
use super::protocol::{BROADCAST, Decoder};
use super::series::Series;
use super::simulated::SimulatedMachine;
use super::slot::Slot;
use crate::rest::{Drives, bring_to_rest};
use sinew::drive::DriveCommand;
use sinew::machine::Machine;
use sinew::twin::arm::ArmTwin;
use sinew_session::{BusFault, Exchange, Feedback, Plant};

/// Servos that matched the machine and are configured. It owns them: dropped it brings them to rest.
#[derive(Debug)]
pub struct ServoBus<L: Lines> {
    lines: L,
    servos: Vec<Slot>,
    per_line: Vec<Line>,
    /// What is sent next, and the parameters of an instruction in it.
    out: Vec<u8>,
    parameters: Vec<u8>,
    muscles: usize,
    /// Control period, ns.
    period: u64,
    /// When the cycle began, and when commands were last written, ns.
    begin: u64,
    commanded: Option<u64>,
    asked: bool,
    in_operation: bool,
    /// Whether the last writing did not leave the computer.
    lost: bool,
}

#[derive(Debug)]
struct Line {
    series: Series,
    decoder: Decoder,
    /// Whether all answer in one packet, as Dynamixels can.
    fast: bool,
    /// Indices of its servos in the order in which they are asked: a silent one is asked last, since those
    /// behind it may wait for it.
    order: Vec<usize>,
}

/// A servo that is silent for so many cycles counts as missing.
const SILENT_CYCLES: u32 = 3;
/// Since the beginning of a cycle, when answers are waited for no longer: a fraction of the period.
const READ_FRACTION: f64 = 0.5;
/// Time for the answers before the first cycle, ns.
const PATIENCE: u64 = 40_000_000;
/// Part of the period that a line may be busy.
const LINE_FRACTION: f64 = 0.95;
/// Codes of [`BusFault::NotReady`].
pub(super) const SILENT: u16 = 0;
pub(super) const WITHOUT_TORQUE: u16 = 1;
pub(super) const TIMED_OUT: u16 = 2;
/// Octets that are sent or come at once, at most.
const OCTETS: usize = 8192;
/// Cycles in which a servo takes a change of its state, at most.
const MIN_CYCLES: u64 = 5;

impl<L: Lines> ServoBus<L> {
    /// Finds the servos of a machine, sets them up and reads everything back. None moves, none has torque
    /// until the first command.
    ///
    /// # Errors
    /// The first servo that is missing, another one, faulty, or does not take what it is told.
    pub fn start(mut lines: L, machine: &Machine, devices: &[ServoDevice]) -> Result<Self, ServoError> {
        if let Some(of) = machine.devices.iter().find(|of| !of.channels().is_empty()) {
            return Err(ServoError::Sensor { device: of.name.clone() });
        }
        if devices.len() != machine.devices.iter().filter(|of| of.driven_muscle().is_some()).count() {
            return Err(ServoError::OtherBus);
        }
        check_lines(devices)?;
        let ports = ServoDevice::ports(devices);
        let line_of = |device: &ServoDevice| ports.iter().position(|port| *port == device.port).unwrap_or(0);
        let mut question = Question::new(&mut lines);
        for device in devices {
            let line = line_of(device);
            Configuring { exchange: &mut question, device, line }.configure(machine)?;
        }
        let parameters = |device: &ServoDevice| machine.muscles[device.drive.muscle].drive;
        let servos: Vec<Slot> = devices
            .iter()
            .map(|device| Slot::new(device.clone(), line_of(device), parameters(device)))
            .collect();
        let of_line = |line| (0..servos.len()).filter(|k| servos[*k].line == line).collect();
        let line = |line| {
            let order: Vec<usize> = of_line(line);
            let series = order.first().map_or(Series::X, |k| servos[*k].device.model.series);
            let decoder = Decoder::new(series.protocol(), true);
            Line { series, decoder, fast: series != Series::Sts, order }
        };
        let per_line = (0..ports.len()).map(line).collect();
        let mut bus = Self {
            per_line,
            lines,
            servos,
            out: Vec::with_capacity(OCTETS),
            parameters: Vec::with_capacity(OCTETS),
            muscles: machine.muscles.len(),
            period: machine.period_ns(),
            begin: 0,
            commanded: None,
            asked: false,
            in_operation: true,
            lost: false,
        };
        bus.probe()?;
        Ok(bus)
    }

    /// Finds out whether the servos of every line answer a fast sync read, and that all answer in time.
    fn probe(&mut self) -> Result<(), ServoError> {
        let mut feedback = Feedback::new(self.muscles, 0);
        for _ in 0..2 {
            for _ in 0..MIN_CYCLES {
                self.lines.begin_cycle(self.period);
                self.exchange(None);
                let deadline = self.lines.now() + PATIENCE;
                self.gather(deadline, &mut feedback);
                self.begin = self.lines.now();
            }
            for (line, of) in self.per_line.iter_mut().enumerate() {
                // Old firmware does not know it.
                let silent = self.servos.iter().any(|servo| servo.line == line && servo.silent > 0);
                of.fast = of.fast && !silent;
            }
        }
        if let Some(Slot { device, .. }) = self.servos.iter().find(|servo| servo.silent > 0) {
            return Err(device.silent());
        }
        for (line, of) in self.per_line.iter().enumerate() {
            let Some(Slot { device, .. }) = self.servos.iter().find(|servo| servo.line == line) else {
                continue;
            };
            let servos = of.order.len();
            let octets = of.series.cycle_octets(servos, of.fast);
            let needed = (octets * 10) as f64 / f64::from(device.baud);
            let period = self.period as f64 * 1e-9;
            if needed > LINE_FRACTION * period {
                let (device, baud) = (device.name.clone(), device.baud);
                return Err(ServoError::Slow { device, servos, baud, needed, period });
            }
        }
        // The first cycle finds its readings as every other.
        self.exchange(None);
        Ok(())
    }

    /// The lines.
    pub fn lines_mut(&mut self) -> &mut L {
        &mut self.lines
    }

    /// Whether the servos of every line answer in one packet.
    #[must_use]
    pub fn is_fast(&self) -> bool {
        self.per_line.iter().all(|line| line.fast)
    }

    /// Sends the goals, where there are commands, and asks for the next readings.
    fn exchange(&mut self, commands: Option<&[DriveCommand]>) {
        self.lost = false;
        let h = self.period as f64 * 1e-9;
        for line in 0..self.per_line.len() {
            self.out.clear();
            if let Some(commands) = commands {
                self.encode_goals(line, commands, h);
            }
            self.encode_request(line);
            // What is left of an earlier answer is none of the next.
            let (now, mut buffer) = (self.lines.now(), [0; 256]);
            while matches!(self.lines.receive(line, &mut buffer, now), Ok(count) if count > 0) {}
            self.per_line[line].decoder.clear();
            self.lost |= self.lines.send(line, &self.out).is_err();
        }
        self.servos.iter_mut().for_each(|servo| servo.expected = servo.torque);
        self.asked = true;
    }

    fn encode_goals(&mut self, line: usize, commands: &[DriveCommand], h: f64) {
        let Self { servos, per_line, out, parameters, .. } = self;
        let series = per_line[line].series;
        let protocol = series.protocol();
        let modes = [OperatingMode::Current, OperatingMode::Velocity, OperatingMode::ExtendedPosition];
        for mode in modes {
            parameters.clear();
            for servo in servos.iter_mut().filter(|servo| servo.line == line && servo.device.mode == mode) {
                let (address, octets) = servo.goal_place();
                if parameters.is_empty() {
                    protocol.places(parameters, &[address, octets as u16]);
                }
                let command = commands.get(servo.muscle()).copied().unwrap_or(DriveCommand::Brake);
                let goal = series.goal(servo.goal(command, h));
                parameters.push(servo.device.id);
                parameters.extend(&goal[..octets]);
            }
            if !parameters.is_empty() {
                protocol.instruct(out, BROADCAST, SYNC_WRITE, &[parameters]);
            }
        }
        for (address, with_torque) in series.power() {
            parameters.clear();
            for servo in servos.iter().filter(|servo| servo.line == line && servo.torque != servo.expected) {
                if parameters.is_empty() {
                    protocol.places(parameters, &[*address, 1]);
                }
                parameters
                    .extend([servo.device.id, if servo.torque { *with_torque } else { 1 - with_torque }]);
            }
            if !parameters.is_empty() {
                protocol.instruct(out, BROADCAST, SYNC_WRITE, &[parameters]);
            }
        }
    }

    fn encode_request(&mut self, line: usize) {
        let Self { servos, per_line, out, parameters, .. } = self;
        let of = &per_line[line];
        parameters.clear();
        of.series.protocol().places(parameters, &of.series.reading());
        parameters.extend(of.order.iter().map(|k| servos[*k].device.id));
        let instruction = if of.fast { FAST_SYNC_READ } else { SYNC_READ };
        of.series.protocol().instruct(out, BROADCAST, instruction, &[parameters]);
    }

    /// Collects the answers of a line until all have come or the deadline has; the octets that came.
    fn collect(&mut self, line: usize, deadline: u64) -> usize {
        let Self { lines, servos, per_line, period, .. } = self;
        let h = *period as f64 * 1e-9;
        let Line { series, decoder, fast, order } = &mut per_line[line];
        let fast = fast.then_some(usize::from(series.reading()[1]));
        let (mut left, mut octets, mut buffer) = (order.len(), 0, [0; 1024]);
        order.iter().for_each(|k| servos[*k].silent = servos[*k].silent.saturating_add(1));
        while left > 0 {
            while let Some(packet) = decoder.next(fast) {
                let of = order.iter().copied().find(|k| servos[*k].device.id == packet.id);
                if let (STATUS, Some(servo)) = (packet.instruction, of)
                    && let silent @ 1.. = servos[servo].silent
                    && servos[servo].read(packet.data, f64::from(silent) * h)
                {
                    servos[servo].silent = 0;
                    left -= 1;
                }
            }
            if left == 0 {
                break;
            }
            match lines.receive(line, &mut buffer, deadline) {
                Ok(count) if count > 0 => {
                    decoder.feed(&buffer[..count]);
                    octets += count;
                }
                _ => break,
            }
        }
        if let Some(place) = order.iter().position(|k| servos[*k].silent > 0) {
            order[place..].rotate_left(1);
        }
        octets
    }

    /// Collects the answers of all lines until a deadline, ns; what is wrong.
    fn gather(&mut self, deadline: u64, feedback: &mut Feedback) -> Option<BusFault> {
        let octets: usize = (0..self.per_line.len()).map(|line| self.collect(line, deadline)).sum();
        feedback.clear();
        if octets == 0 || self.lost {
            return Some(BusFault::Lost);
        }
        self.take_over(feedback).or(self.lines.injected())
    }

    /// Takes over the readings of the servos that answered; the first thing that is wrong.
    fn take_over(&self, feedback: &mut Feedback) -> Option<BusFault> {
        let age = self.commanded.map_or(f64::NAN, |at| self.begin.saturating_sub(at) as f64 * 1e-3);
        feedback.setpoint_age.fill(age);
        let (mut fault, mut silent) = (None, None);
        for servo in &self.servos {
            let (muscle, device) = (servo.muscle(), servo.device.device);
            let not_ready = |code, muscle| BusFault::NotReady { device, code, muscle };
            if servo.silent > 0 {
                // One that is silent for long is missing; until then its reading is bridged.
                if servo.silent >= SILENT_CYCLES {
                    fault = fault.or(Some(not_ready(SILENT, Some(muscle))));
                } else {
                    silent = silent.or(Some(not_ready(SILENT, None)));
                }
                continue;
            }
            let reading = servo.reading;
            if reading.error != 0 {
                fault = fault.or(Some(BusFault::Drive { muscle, code: u16::from(reading.error) }));
            } else if servo.expected && !reading.torque {
                // It has started anew: what it shows is no position of the cable.
                fault = fault.or(Some(not_ready(WITHOUT_TORQUE, Some(muscle))));
                continue;
            } else if servo.expected && reading.timed_out {
                // It stands, and takes no goals.
                fault = fault.or(Some(not_ready(TIMED_OUT, Some(muscle))));
            }
            feedback.motor[muscle] = reading.cable;
            feedback.current[muscle] = reading.current;
            feedback.temperature[muscle] = reading.temperature;
        }
        fault.or(silent)
    }
}

/// Refuses servos of one line that cannot be asked together.
fn check_lines(devices: &[ServoDevice]) -> Result<(), ServoError> {
    for (k, device) in devices.iter().enumerate() {
        for other in devices[..k].iter().filter(|other| other.port == device.port) {
            let expected = if other.id == device.id {
                "each an id of its own"
            } else if other.baud != device.baud {
                "the same baud"
            } else if other.model.series != device.model.series {
                "models of one series"
            } else {
                continue;
            };
            let (device, other) = (device.name.clone(), other.name.clone());
            return Err(ServoError::Line { device, other, expected });
        }
    }
    Ok(())
}

impl<L: Lines> Drives for ServoBus<L> {
    fn dimensions(&self) -> [usize; 2] {
        [self.muscles, 0]
    }

    fn slow_down(&self, commands: &mut [DriveCommand]) -> bool {
        let h = self.period as f64 * 1e-9;
        let mut standing = true;
        for servo in &self.servos {
            let speed = servo.braked_speed(h);
            standing &= speed == 0.0;
            // One without torque does not get any for it.
            commands[servo.muscle()] =
                if servo.torque { DriveCommand::Velocity(speed) } else { DriveCommand::Off };
        }
        standing
    }

    fn are_without_power(&self, _last: Exchange) -> bool {
        self.servos.iter().all(|servo| servo.silent == 0 && !servo.reading.torque)
    }

    fn write_and_wait(&mut self, commands: &[DriveCommand]) {
        self.write(commands);
        if commands.iter().all(|command| *command == DriveCommand::Off) {
            // A packet may be lost: torque is turned off again in every cycle.
            self.servos.iter_mut().for_each(|servo| servo.expected = true);
        }
        self.lines.rest_until(self.begin.saturating_add(self.period));
    }

    fn cycles_of(&self, time: u64) -> u64 {
        (time / self.period.max(1)).max(MIN_CYCLES)
    }
}

impl<L: Lines> Drop for ServoBus<L> {
    fn drop(&mut self) {
        self.stop();
    }
}

impl<L: Lines> Plant for ServoBus<L> {
    fn read(&mut self, feedback: &mut Feedback) -> Exchange {
        self.lines.begin_cycle(self.period);
        self.begin = self.lines.now();
        if !std::mem::take(&mut self.asked) {
            self.exchange(None);
        }
        let deadline = self.begin + (self.period as f64 * READ_FRACTION) as u64;
        Exchange { fault: self.gather(deadline, feedback) }
    }

    fn write(&mut self, commands: &[DriveCommand]) {
        let now = self.lines.now();
        self.exchange(Some(commands));
        if !self.lost {
            self.commanded = Some(now);
        }
    }

    fn stop(&mut self) {
        if std::mem::take(&mut self.in_operation) {
            bring_to_rest(self);
        }
    }

    fn simulated(&self) -> Option<&ArmTwin> {
        self.lines.simulated().map(SimulatedMachine::arm)
    }

    fn has_failed(&self) -> bool {
        self.lines.simulated().is_some_and(SimulatedMachine::failed)
    }
}
