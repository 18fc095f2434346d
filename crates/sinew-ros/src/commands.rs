use crate::refusal::Refusal;
use crate::setpoint::setpoint;
use crate::trajectory::Trajectory;
use sinew_link::host::{Domain, Local, Port, RateLimit, SessionSettings};
use sinew_link::{Command, Mode, Request, SetpointKind, Setpoints, Snapshot};
use sinew_record::ros2::CdrReader;

/// Who sent something: the DDS writer.
pub type Sender = [u8; 16];

/// What other nodes ask for, as commands of a link: the same checks, the same queue to the control cycle and
/// the same goal.
///
/// All other nodes together are one client. Its session begins with what is asked for first, and ends where
/// no publisher and no client of a service has been there for `unattended_ns`; from then on the machine does
/// what it does where a client of a link has gone. Modes may be asked for by anyone, one at a time moves the
/// machine: a trajectory until its end, whoever sent it may go, or a stream of set-points, which ends
/// [`Mode::Run`] in hold where it stops. Times are those of one monotonic clock, ns.
#[derive(Debug)]
pub struct Commands {
    local: Local,
    joints: Vec<String>,
    settings: SessionSettings,
    motion: Motion,
    setpoints: RateLimit,
    /// When the cycle was last told that this side lives.
    told: u64,
    /// Since when nobody is there.
    alone: Option<u64>,
}

#[derive(Debug)]
enum Motion {
    None,
    Along(Along),
    Stream(Stream),
}

/// A trajectory that is executed.
#[derive(Debug)]
struct Along {
    trajectory: Trajectory,
    /// The machine's time at which it begins, ns.
    start: u64,
    /// Points that the cycle has been given.
    given: usize,
    /// The machine's time of the state after which the newest of them were given.
    given_at: u64,
}

/// Set-points that come one by one.
#[derive(Debug)]
struct Stream {
    sender: Sender,
    heard: u64,
    /// Of the newest, in the machine's time.
    at: u64,
}

/// From the arrival of a trajectory to its beginning, ns: its first points are there by then.
const LEAD: u64 = 10_000_000;
/// From the last point of a trajectory to one that says that the motion rests there, ns.
const REST: u64 = 100_000_000;
/// Points that wait in the cycle before more are given, and states that are not yet counted among them, ns.
const WAITING: usize = 64;
const COUNTED: u64 = 10_000_000;
/// Of the time-out of commands, between two signs of life.
const SIGNS: u64 = 5;
/// Set-points a second, and at once: fewer than the cycle takes, so that there is room for a stop.
const RATE: u32 = 1000;
const BURST: u32 = 32;
/// How far in the past and in the future a trajectory may begin, ns.
const PAST: i64 = 1_000_000_000;
const FUTURE: i64 = 60_000_000_000;

impl Commands {
    /// Without a session, for joints in the order of the machine, and the control cycle's port.
    ///
    /// # Errors
    /// As [`Local::new`].
    pub fn new(
        domain: Domain,
        joints: Vec<String>,
        settings: SessionSettings,
    ) -> Result<(Self, Port), sinew_link::Error> {
        let (local, port) = Local::new(domain)?;
        let (motion, setpoints) = (Motion::None, RateLimit::new(RATE, BURST));
        Ok((Self { local, joints, settings, motion, setpoints, told: 0, alone: None }, port))
    }

    /// Takes a `trajectory_msgs/JointTrajectory`, at a time since 1970, ns.
    ///
    /// # Errors
    /// Those of [`Trajectory::read`]; a beginning too far away; a machine that is not in [`Mode::Run`], or
    /// that something else moves.
    pub fn trajectory(&mut self, message: CdrReader<'_>, since_1970: i64) -> Result<(), Refusal> {
        let trajectory = Trajectory::read(message, &self.joints, &self.local.domain().joint)?;
        let ahead = match trajectory.stamp {
            0 => 0,
            stamp => stamp.saturating_sub(since_1970),
        };
        if !(-PAST..=FUTURE).contains(&ahead) {
            let got = format!("{:.3} s from now", ahead as f64 * 1e-9);
            return Err(Refusal::new("header.stamp", "0, or -1 s to 60 s from now", got));
        }
        let state = self.running()?;
        match self.motion {
            Motion::None => {}
            Motion::Along(_) => return Err(busy("the end of the trajectory before, or `hold`")),
            Motion::Stream(_) => return Err(busy("the end of the set-points, or `hold`")),
        }
        let start = state + LEAD + ahead.max(0) as u64;
        self.motion = Motion::Along(Along { trajectory, start, given: 0, given_at: 0 });
        Ok(())
    }

    /// Takes a `sensor_msgs/JointState` as a set-point, `now`.
    ///
    /// # Errors
    /// More than a thousand a second; those of [`setpoint`]; a machine that is not in [`Mode::Run`], or that
    /// something else moves; what the link rejects.
    pub fn setpoint(&mut self, from: Sender, message: CdrReader<'_>, now: u64) -> Result<(), Refusal> {
        if !self.setpoints.allow(now) {
            return Err(Refusal::new("rate", format!("at most {RATE} set-points a second"), "more"));
        }
        let numbers = setpoint(message, &self.joints, &self.local.domain().joint)?;
        let state = self.running()?;
        let (gap, after) = match &self.motion {
            Motion::None => (0, 0),
            Motion::Along(_) => return Err(busy("the end of the trajectory, or `hold`")),
            Motion::Stream(stream) if stream.sender != from => {
                return Err(busy("the end of another node's set-points, or `hold`"));
            }
            Motion::Stream(stream) => (now.saturating_sub(stream.heard), stream.at),
        };
        // It takes effect when the next one is due, so that the way there is even.
        let at = (state + gap.min(self.settings.timeout_ns)).max(after + 1);
        let mut setpoints = Setpoints::new(SetpointKind::Joint, numbers.len());
        setpoints.push(at, &numbers);
        self.give(&Command { setpoints, ..Command::from_request(Request::None) })?;
        self.motion = Motion::Stream(Stream { sender: from, heard: now, at });
        Ok(())
    }

    /// Asks the supervisor for something; the mode of the machine before. A request counts where it differs
    /// from the one before, so that one to run again, after stale set-points, comes behind one to hold.
    ///
    /// # Errors
    /// Where the cycle does not take it.
    pub fn request(&mut self, request: Request) -> Result<Mode, Refusal> {
        let state = self.local.state();
        let (mode, goal) = (state.mode, state.request);
        if request != Request::Run {
            self.motion = Motion::None;
        } else if goal == Request::Run && mode != Mode::Run {
            self.give(&Command::from_request(Request::Hold))?;
        }
        self.give(&Command::from_request(request))?;
        Ok(mode)
    }

    /// What goes on with the time: points of a trajectory, signs of life, the end of the session. `anyone` is
    /// whether other nodes can ask for something.
    pub fn pass(&mut self, now: u64, anyone: bool) {
        let state = self.local.state();
        let (mode, time, queued) = (state.mode, state.machine_time_ns, usize::from(state.queued));
        if mode != Mode::Run {
            self.motion = Motion::None;
        }
        if let Motion::Along(along) = &mut self.motion {
            if time > along.start + along.trajectory.duration() + 2 * REST {
                self.motion = Motion::None;
            } else if queued < WAITING && (along.given_at == 0 || time > along.given_at + COUNTED) {
                along.give(&mut self.local, time);
            }
        }
        let streams = matches!(self.motion, Motion::Stream(_));
        let due = now.saturating_sub(self.told) >= self.settings.timeout_ns / SIGNS;
        if self.local.is_attached() && !streams && due {
            // Where there is no room the cycle has signs enough.
            let _ = self.give(&Command::from_request(Request::None));
            self.told = now;
        }
        self.alone =
            if anyone || !matches!(self.motion, Motion::None) { None } else { self.alone.or(Some(now)) };
        if self.alone.is_some_and(|since| now.saturating_sub(since) >= self.settings.unattended_ns)
            && self.local.is_attached()
        {
            self.local.end();
        }
    }

    /// The newest state of the machine.
    pub fn state(&mut self) -> &Snapshot {
        self.local.state()
    }

    /// The machine's time, where it follows set-points.
    fn running(&mut self) -> Result<u64, Refusal> {
        let state = self.local.state();
        if state.mode == Mode::Run {
            return Ok(state.machine_time_ns);
        }
        Err(Refusal::new("mode", "a machine in Run", state.mode.name()))
    }

    fn give(&mut self, command: &Command) -> Result<(), Refusal> {
        let expected = "a command that the control cycle takes";
        self.local.command(command).map_err(|because| Refusal::new("link", expected, because.name()))
    }
}

fn busy(expected: &str) -> Refusal {
    Refusal::new("motion", expected, "one more to begin before")
}

impl Along {
    /// Gives the next points to the cycle, and behind the last one that the motion rests there.
    fn give(&mut self, local: &mut Local, time: u64) {
        let joints = local.domain().joint.len();
        let mut room = WAITING;
        while room > 0 && self.given <= self.trajectory.times.len() {
            let mut setpoints = Setpoints::new(SetpointKind::Joint, joints);
            let mut given = self.given;
            while let Some((at, numbers)) = self.point(given)
                && setpoints.push(at, numbers)
            {
                given += 1;
            }
            let command = Command { setpoints, ..Command::from_request(Request::None) };
            // Without room for it the same is given later.
            if given == self.given || local.command(&command).is_err() {
                return;
            }
            room = room.saturating_sub(given - self.given);
            (self.given, self.given_at) = (given, time);
        }
    }

    /// A point in the machine's time; one more than there are rests at the last.
    fn point(&self, k: usize) -> Option<(u64, &[f64])> {
        let last = self.trajectory.times.len().checked_sub(1)?;
        let (at, numbers) = self.trajectory.point(k.min(last)).filter(|_| k <= last + 1)?;
        Some((self.start + at + if k > last { REST } else { 0 }, numbers))
    }
}
