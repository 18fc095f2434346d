use super::unreached::UnreachedPoint;
use alloc::string::String;
use core::fmt;

/// A violated limit.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Violation {
    /// A point of the path that the joints do not follow.
    Unreachable(UnreachedPoint),
    /// A joint outside its range.
    JointRange {
        /// Its name.
        joint: String,
        /// rad or m.
        position: f64,
        /// rad or m.
        range: [f64; 2],
        /// `rad` or `m`.
        unit: &'static str,
    },
    /// A joint above its speed limit.
    JointSpeed {
        /// Its name.
        joint: String,
        /// rad/s or m/s.
        speed: f64,
        /// rad/s or m/s.
        most: f64,
        /// `rad` or `m`, per s.
        unit: &'static str,
    },
    /// A cable above the speed limit of its winch.
    CableSpeed {
        /// Its name.
        muscle: String,
        /// Speed of the cable, m/s.
        speed: f64,
        /// Highest speed that its drive reaches, m/s.
        most: f64,
    },
    /// A cable above the acceleration limit of its winch.
    CableAcceleration {
        /// Its name.
        muscle: String,
        /// m/s^2.
        acceleration: f64,
        /// m/s^2.
        most: f64,
    },
    /// A joint torque that the tension limits do not admit.
    Torque {
        /// Name of the joint.
        joint: String,
        /// Required, Nm or N.
        needed: f64,
        /// Residual, Nm or N.
        missing: f64,
        /// `N m` or `N`.
        unit: &'static str,
        /// The saturated muscle with the largest moment arm in its direction, and its tension, N.
        muscle: Option<(String, f64)>,
    },
    /// A cable whose joints, left to their springs, need less tension than keeps it taut.
    Slack {
        /// Its name.
        muscle: String,
        /// That its joints need, N.
        tension: f64,
        /// Least, N.
        least: f64,
    },
    /// A cable that needs more tension than its muscle may have, whatever the motion.
    TensionLimit {
        /// Its name.
        muscle: String,
        /// Needed so that it stays taut, N.
        needed: f64,
        /// Allowed, N.
        most: f64,
    },
    /// A pose that the machine leaves by itself while its winches are held, faster than its controller can
    /// hold it.
    Unstable {
        /// Name of the joint that moves most.
        joint: String,
        /// The muscle whose moment arm grows as it shortens; none where that is gravity.
        muscle: Option<String>,
        /// At which it leaves the pose, 1/s.
        rate: f64,
        /// 1/s, at the period of its control cycle.
        most: f64,
        /// Control period, s.
        period: f64,
    },
    /// A winding above the temperature that it may reach.
    Heat {
        /// Muscle of the drive.
        muscle: String,
        /// Largest temperature of the winding, degrees Celsius.
        hottest: f64,
    },
}

/// The first time at which a trajectory violates a limit.
#[derive(Debug, Clone, PartialEq)]
pub struct Infeasibility {
    /// From the start, s.
    pub time: f64,
    /// The limit that is violated.
    pub violation: Violation,
}

impl fmt::Display for Infeasibility {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "at {:.3} s: ", self.time)?;
        match &self.violation {
            Violation::Unreachable(point) => point.fmt(f),
            Violation::JointRange { joint, position, range: [low, high], unit } => {
                write!(
                    f,
                    "joint `{joint}` must be within {low:.5} and {high:.5} {unit}, but the reference is \
                        {position:.5} {unit}"
                )
            }
            Violation::JointSpeed { joint, speed, most, unit } => {
                write!(
                    f,
                    "joint `{joint}` may move at most {most:.3} {unit}/s, but the reference moves \
                        {speed:.3} {unit}/s"
                )
            }
            Violation::CableSpeed { muscle, speed, most } => {
                write!(
                    f,
                    "the winch of `{muscle}` winds at most {most:.3} m/s, but the reference needs {speed:.3}"
                )
            }
            Violation::CableAcceleration { muscle, acceleration, most } => {
                write!(
                    f,
                    "the winch of `{muscle}` accelerates by at most {most:.3} m/s^2, but the reference \
                        needs {acceleration:.3}"
                )
            }
            Violation::Torque { joint, needed, missing, unit, muscle } => {
                write!(
                    f,
                    "`{joint}` needs {:.3} {unit}, of which tensions within their limits leave {} {unit} unmet",
                    needed.abs(),
                    Significant(missing.abs())
                )?;
                match muscle {
                    Some((muscle, tension)) => write!(
                        f,
                        ": `{muscle}` is at {tension:.0} N, what its drive gives less the friction of its cable"
                    ),
                    None => Ok(()),
                }
            }
            Violation::Slack { muscle, tension, least } => write!(
                f,
                "`{muscle}` goes slack: the springs of its joints hold {} N against it, and it stays taut from \
                    {} N on; stiffer springs, or ones that are at rest further open, keep it taut",
                Significant(*tension),
                Significant(*least)
            ),
            Violation::TensionLimit { muscle, needed, most } => write!(
                f,
                "`{muscle}` may pull at most {} N, and its cable stays taut from {} N on",
                Significant(*most),
                Significant(*needed)
            ),
            Violation::Unstable { joint, muscle, rate, most, period } => {
                write!(
                    f,
                    "with locked winches the machine leaves the pose by itself, mostly `{joint}`, at a rate \
                        of {rate:.0} 1/s, and its controller holds at most {most:.0} 1/s at a period of {} \
                        ms: ",
                    1e3 * period
                )?;
                match muscle {
                    Some(muscle) => write!(f, "the moment arm of `{muscle}` grows as it shortens"),
                    None => write!(f, "gravity outweighs the stiffness of the cables"),
                }
            }
            Violation::Heat { muscle, hottest } => {
                write!(f, "the winding of `{muscle}` reaches {hottest:.0} degrees Celsius, what it may")
            }
        }
    }
}

/// A positive number with at least two significant digits, and at least three decimals.
struct Significant(f64);

impl fmt::Display for Significant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let leading = -libm::floor(libm::log10(self.0.abs().max(1e-12)));
        write!(f, "{:.*}", (leading + 1.0).max(3.0) as usize, self.0)
    }
}
