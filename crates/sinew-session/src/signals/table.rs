//! The table of signals.

use super::codes::{bus_code, command_code, fault_code, status_code};
use crate::plant::Plant;
use crate::record::CycleRecord;
use sinew::control::tension::Status;

/// A cycle as the table sees it, whatever the plant.
pub type Seen<'a> = CycleRecord<'a, dyn Plant + 'a>;

/// What there are several of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// One number per cycle.
    Cycle,
    /// One per independent joint.
    Joint,
    /// One per muscle.
    Muscle,
}

/// Where a signal comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Times, modes and faults of the cycle itself.
    State,
    /// A reading of a sensor.
    Measured,
    /// An estimate of the controller.
    Estimated,
    /// What the machine is to follow.
    Reference,
    /// What the drives are commanded.
    Command,
    /// The truth of a simulated machine, which has nothing of it otherwise.
    Truth,
}

/// How exactly a signal is kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Resolution {
    /// Bit for bit.
    Exact,
    /// In multiples of a number.
    Rounded(f64),
}

/// A row of the table.
pub struct Row {
    /// Its name, with its unit but where that is a joint's.
    pub name: &'static str,
    /// Its unit; `1` where it has none, `rad or m` of joints.
    pub unit: &'static str,
    /// What there are several of.
    pub axis: Axis,
    /// Where it comes from.
    pub kind: Kind,
    /// How exactly it is kept.
    pub resolution: Resolution,
    /// Whether it is kept every 20 cycles only.
    pub slow: bool,
    /// In a few words, for a legend.
    pub label: &'static str,
    /// What it means.
    pub about: &'static str,
    /// Writes its numbers of a cycle into a place of NaN.
    pub(super) fill: fn(&Seen<'_>, &mut [f64]),
}

macro_rules! signals {
    ($(#[doc = $about:literal] $id:ident($name:literal, $unit:literal, $axis:ident, $kind:ident, $resolution:expr,
        $slow:ident, $label:literal) = $fill:expr;)*) => {
        /// A signal: a row of the table.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Signal { $(#[doc = $about] $id,)* }

        impl Signal {
            /// All signals, in the order of the table.
            pub const ALL: &'static [Self] = &[$(Self::$id,)*];
        }

        static ROWS: &[Row] = &[$(Row {
            name: $name,
            unit: $unit,
            axis: Axis::$axis,
            kind: Kind::$kind,
            resolution: $resolution,
            slow: slow!($slow),
            label: $label,
            about: $about,
            fill: $fill,
        },)*];
    };
}

macro_rules! slow {
    (every) => {
        false
    };
    (slow) => {
        true
    };
}

/// Resolutions: counts and codes, 1; delays, 1 ns in us, and currents, 1 mA, because the supervisor judges
/// them; tensions, N; temperatures, degC; joints, rad or m; commands, m/s, A or N.
const ONE: Resolution = Resolution::Rounded(1.0);
const DELAY: Resolution = Resolution::Rounded(1e-3);
const TENSION: Resolution = Resolution::Rounded(0.01);
const CURRENT: Resolution = Resolution::Rounded(1e-3);
const TEMPERATURE: Resolution = Resolution::Rounded(0.1);
const JOINT: Resolution = Resolution::Rounded(1e-6);
const COMMAND: Resolution = Resolution::Rounded(1e-4);
const EXACT: Resolution = Resolution::Exact;

signals! {
    #[doc = "when the cycle was to begin, since the first one"]
    Deadline("deadline_us", "us", Cycle, State, ONE, every, "beginning of the cycle") =
        |cycle, out| put(out, cycle.times.deadline as f64 * 1e-3);
    #[doc = "delay after the deadline"]
    WakeUp("wake_up_us", "us", Cycle, State, DELAY, every, "wake-up delay") =
        |cycle, out| put(out, us(cycle.times.deadline, cycle.times.woken));
    #[doc = "duration of the reading"]
    Read("read_us", "us", Cycle, State, ONE, every, "reading") =
        |cycle, out| put(out, us(cycle.times.woken, cycle.times.read));
    #[doc = "duration of motion, supervisor and controller"]
    Control("control_us", "us", Cycle, State, ONE, every, "control") =
        |cycle, out| put(out, us(cycle.times.read, cycle.times.controlled));
    #[doc = "duration of the writing"]
    Write("write_us", "us", Cycle, State, ONE, every, "writing") =
        |cycle, out| put(out, us(cycle.times.controlled, cycle.times.written));
    #[doc = "index of the repeat, -1 at rest"]
    Repeat("repeat", "1", Cycle, State, ONE, every, "repeat") =
        |cycle, out| put(out, cycle.moment.repeat.map_or(-1.0, f64::from));
    #[doc = "of the controller: 0 following, 1 holding, 2 degraded, 3 stopped"]
    Status("status", "1", Cycle, State, ONE, every, "status") =
        |cycle, out| put(out, status_code(cycle.command.arm.status, cycle.command.fault)[0]);
    #[doc = "its fault: 1000 times the code ([link.md](link.md#faults)) plus the index of its muscle or \
        joint; 0 without one"]
    Fault("fault", "1", Cycle, State, ONE, every, "fault") =
        |cycle, out| put(out, status_code(cycle.command.arm.status, cycle.command.fault)[1]);
    #[doc = "of the supervisor: 0 off, 1 ready, 2 pretension, 3 hold, 4 run, 5 safe stop, 6 fault"]
    Mode("mode", "1", Cycle, State, ONE, every, "mode") =
        |cycle, out| put(out, f64::from(cycle.command.mode as u8));
    #[doc = "its fault, as `fault`"]
    ModeFault("mode_fault", "1", Cycle, State, ONE, every, "fault of the mode") =
        |cycle, out| put(out, cycle.command.fault.map_or(0.0, fault_code));
    #[doc = "0 none, 1 lost, 2 devices missing, 3 device not ready, 4 drive, by injection 5 late (ns), 6 \
        without a new command (its age, us)"]
    BusFault("bus_fault", "1", Cycle, State, ONE, every, "fault of the bus") =
        |cycle, out| put(out, bus_code(cycle.exchange.fault)[0]);
    #[doc = "numbers of the bus fault"]
    BusDetail("bus_detail", "1", Cycle, State, ONE, every, "detail of the fault") =
        |cycle, out| put(out, bus_code(cycle.exchange.fault)[1]);
    #[doc = "tension distribution: 0 optimal, 1 out of reach, 2 not converged"]
    Distribution("distribution", "1", Cycle, State, ONE, every, "tension distribution") =
        |cycle, out| put(out, match cycle.command.arm.distribution {
            Status::Optimal => 0.0,
            Status::Infeasible => 1.0,
            Status::NotConverged => 2.0,
        });
    #[doc = "motor encoder, + toward the motor"]
    PositionIn("position_in_m", "m", Muscle, Measured, EXACT, every, "winch position") =
        |cycle, out| copy(out, &cycle.feedback.motor);
    #[doc = "load cell at the drive"]
    TensionIn("tension_in_n", "N", Muscle, Measured, EXACT, every, "near tension") =
        |cycle, out| copy(out, &cycle.feedback.tension);
    #[doc = "current of the motor as its drive says, + winds in; every cycle where a muscle lacks a load \
        cell: a pretension ends by it"]
    Current("current_a", "A", Muscle, Measured, CURRENT, slow, "motor current") =
        |cycle, out| copy(out, &cycle.feedback.current);
    #[doc = "temperature of the motor as its drive says"]
    Temperature("temperature_degc", "degC", Muscle, Measured, TEMPERATURE, slow, "motor temperature") =
        |cycle, out| copy(out, &cycle.feedback.temperature);
    #[doc = "age of the newest set-point in this cycle, as its drive received it"]
    SetpointAge("setpoint_age_us", "us", Muscle, Measured, ONE, slow, "age of the set-point") =
        |cycle, out| copy(out, &cycle.feedback.setpoint_age);
    #[doc = "joint encoder"]
    Joint("joint", "rad or m", Joint, Measured, EXACT, every, "measured") =
        |cycle, out| copy(out, &cycle.feedback.joint);
    #[doc = "0 speed, 1 tension, 2 current, 3 off, 4 brake"]
    CommandKind("command_kind", "1", Muscle, Command, ONE, every, "kind of the command") =
        |cycle, out| put_all(out, cycle.command.arm.drives.iter().map(|command| command_code(command)[0]));
    #[doc = "number of the command: m/s, N or A"]
    Command("command", "m/s, N or A", Muscle, Command, COMMAND, every, "command of the drive") =
        |cycle, out| put_all(out, cycle.command.arm.drives.iter().map(|command| command_code(command)[1]));
    #[doc = "feed-forward of a tension command"]
    Feed("feed_m_per_s", "m/s", Muscle, Command, COMMAND, every, "feed-forward") =
        |cycle, out| put_all(out, cycle.command.arm.drives.iter().map(|command| command_code(command)[2]));
    #[doc = "reference that is followed"]
    JointReference("joint_reference", "rad or m", Joint, Reference, JOINT, slow, "reference") =
        |cycle, out| copy(out, &cycle.reference.q);
    #[doc = "estimate of the controller"]
    JointEstimated("joint_estimated", "rad or m", Joint, Estimated, JOINT, slow, "estimated") =
        |cycle, out| copy(out, cycle.command.arm.q);
    #[doc = "desired tension at the anchor"]
    TensionOutDesired("tension_out_desired_n", "N", Muscle, Reference, TENSION, slow, "far tension, reference") =
        |cycle, out| copy(out, cycle.command.arm.desired_tension);
    #[doc = "estimated tension at the anchor"]
    TensionOutEstimated("tension_out_estimated_n", "N", Muscle, Estimated, TENSION, slow, "far tension, estimated") =
        |cycle, out| copy(out, cycle.command.arm.estimated_tension);
    #[doc = "true coordinate"]
    JointTrue("joint_true", "rad or m", Joint, Truth, JOINT, slow, "true") =
        |cycle, out| if let Some(truth) = cycle.truth() { copy(out, truth.q) };
    #[doc = "true tension at the anchor"]
    TensionOut("tension_out_n", "N", Muscle, Truth, TENSION, slow, "far tension, true") =
        |cycle, out| if let Some(truth) = cycle.truth() {
            put_all(out, truth.cables.iter().map(|cable| cable.tension_out));
        };
    #[doc = "true temperature of the motor's winding"]
    Winding("winding_true_degc", "degC", Muscle, Truth, TEMPERATURE, slow, "winding temperature, true") =
        |cycle, out| if let Some(arm) = cycle.plant.simulated() {
            put_all(out, (0..).map(|muscle| arm.winding(muscle)));
        };
    #[doc = "true tension at the drive"]
    TensionInTrue("tension_in_true_n", "N", Muscle, Truth, TENSION, slow, "near tension, true") =
        |cycle, out| if let Some(truth) = cycle.truth() {
            put_all(out, truth.cables.iter().map(|cable| cable.tension_in));
        };
}

impl Signal {
    /// Its row of the table.
    #[must_use]
    pub fn row(self) -> &'static Row {
        &ROWS[self as usize]
    }

    /// The signal of a name.
    #[must_use]
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|signal| signal.row().name == name)
    }

    /// Name of its column of a part: with the unit where that is the part's, and the name of the part.
    #[must_use]
    pub fn column(self, part: &str, unit: &str) -> String {
        let name = self.row().name;
        match self.row().axis {
            Axis::Cycle => name.to_owned(),
            Axis::Joint => format!("{name}_{unit}:{part}"),
            Axis::Muscle => format!("{name}:{part}"),
        }
    }
}

impl Row {
    /// Digits behind the point with which a number is written, one more than are kept; none for all.
    #[must_use]
    pub fn digits(&self) -> Option<usize> {
        match self.resolution {
            Resolution::Exact => None,
            Resolution::Rounded(resolution) if resolution < 1.0 => {
                Some((1.0 - resolution.log10()).round() as usize)
            }
            Resolution::Rounded(_) => Some(0),
        }
    }
}

impl std::fmt::Debug for Row {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{} ({})", self.name, self.unit)
    }
}

fn us(from: u64, to: u64) -> f64 {
    to.saturating_sub(from) as f64 * 1e-3
}

fn put(out: &mut [f64], value: f64) {
    put_all(out, [value].into_iter());
}

fn copy(out: &mut [f64], values: &[f64]) {
    put_all(out, values.iter().copied());
}

/// Where there are fewer values the rest stays as it is.
fn put_all(out: &mut [f64], values: impl Iterator<Item = f64>) {
    out.iter_mut().zip(values).for_each(|(out, value)| *out = value);
}
