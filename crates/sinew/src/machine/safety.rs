use crate::Error;
use crate::drive::DriveParameters;
use crate::error::{non_negative, positive, within};
use serde::{Deserialize, Serialize};

/// Limits that the supervisor of a machine keeps, and the times of its reactions.
///
/// # Source
/// Chosen with fault-free and faulty runs of the twin; `docs/supervisor.md` says what each stands for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SafetyLimits {
    /// Largest tension at a drive, N, > 0; none: the one above which the drive does not wind in.
    #[serde(rename = "tension_n")]
    pub tension: Option<f64>,
    /// Largest rate of change of it, N/s, > 0; none: 20 of the former per second.
    #[serde(rename = "tension_rate_n_per_s")]
    pub tension_rate: Option<f64>,
    /// Largest speed of a cable at its winch, m/s, > 0; none: 1.25 of the drive's without a load.
    #[serde(rename = "cable_speed_m_per_s")]
    pub cable_speed: Option<f64>,
    /// Highest temperature of a winding by the thermal model, degrees Celsius, > 25; none: 5 below the
    /// motor's.
    #[serde(rename = "winding_c")]
    pub winding: Option<f64>,
    /// Fraction of a joint's range by which it may be beyond it, 1, >= 0.
    pub joint_margin: f64,
    /// Speed of the joints at which slack is wound in, rad/s, > 0; of a slide a quarter of it in m/s.
    #[serde(rename = "wind_in_speed_rad_per_s", alias = "take_up_speed_rad_per_s")]
    pub wind_in_speed: f64,
    /// Time in which the tensions rise in pretension, s, > 0.
    #[serde(rename = "pretension_time_s")]
    pub pretension_time: f64,
    /// Largest slack that is wound in, as travel of the joint on which a cable acts most, rad, > 0; of a
    /// slide a quarter of it in m.
    #[serde(rename = "largest_slack_rad")]
    pub largest_slack: f64,
    /// Time for which the pose is held in a safe stop before it is released, s, >= 0.
    #[serde(rename = "holding_time_s")]
    pub holding_time: f64,
    /// Speed of the joints at which they are released, rad/s, > 0; of a slide a quarter of it in m/s.
    #[serde(rename = "lowering_speed_rad_per_s")]
    pub lowering_speed: f64,
    /// Time after which a machine counts as let down, s, > 0.
    #[serde(rename = "lowering_time_s")]
    pub lowering_time: f64,
    /// Time for which lost readings are bridged, s, >= 0; longer is for good.
    #[serde(rename = "bridged_loss_s")]
    pub bridged_loss: f64,
    /// Lateness of a single cycle that is bridged, s, >= 0; a later one is late for good.
    #[serde(rename = "bridged_lateness_s")]
    pub bridged_lateness: f64,
    /// Time by which cycles may be late, summed over those of the last second, s, > 0.
    #[serde(rename = "lateness_s")]
    pub lateness: f64,
    /// Age of a command above which it is stale, s, > 0.
    #[serde(rename = "command_age_s")]
    pub command_age: f64,
    /// Time for which a machine under tension whose client has gone is held before it is released, s, >= 0.
    #[serde(rename = "unattended_s")]
    pub unattended: f64,
}

/// Cycles whose readings may be lost, or by which one may be late, at least.
const BRIDGED_CYCLES: f64 = 2.0;
/// Cycles by which those of a second may be late together, at least.
const LATE_CYCLES: f64 = 4.0;

impl Default for SafetyLimits {
    fn default() -> Self {
        Self {
            tension: None,
            tension_rate: None,
            cable_speed: None,
            winding: None,
            joint_margin: 0.1,
            wind_in_speed: 0.3,
            pretension_time: 1.0,
            largest_slack: 4.0,
            holding_time: 1.0,
            lowering_speed: 0.2,
            lowering_time: 20.0,
            bridged_loss: 0.004,
            bridged_lateness: 0.012,
            lateness: 0.02,
            command_age: 0.1,
            unattended: 5.0,
        }
    }
}

impl SafetyLimits {
    /// Those of a machine that says none, at a period of its control cycle, s: what is bridged is some cycles
    /// at least.
    #[must_use]
    pub fn at_period(period: f64) -> Self {
        let usual = Self::default();
        Self {
            bridged_loss: usual.bridged_loss.max(BRIDGED_CYCLES * period),
            bridged_lateness: usual.bridged_lateness.max(BRIDGED_CYCLES * period),
            lateness: usual.lateness.max(LATE_CYCLES * period),
            ..usual
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        for (name, value) in [
            ("tension", self.tension),
            ("tension_rate", self.tension_rate),
            ("cable_speed", self.cable_speed),
        ] {
            value.map_or(Ok(1.0), |value| positive(name, value))?;
        }
        if let Some(winding) = self.winding {
            within("winding", "a finite number > 25", winding, winding > 25.0 && winding.is_finite())?;
        }
        for (name, value) in [
            ("wind_in_speed", self.wind_in_speed),
            ("pretension_time", self.pretension_time),
            ("largest_slack", self.largest_slack),
            ("lowering_speed", self.lowering_speed),
            ("lowering_time", self.lowering_time),
            ("lateness", self.lateness),
            ("command_age", self.command_age),
        ] {
            positive(name, value)?;
        }
        non_negative("joint_margin", self.joint_margin)?;
        non_negative("holding_time", self.holding_time)?;
        non_negative("bridged_lateness", self.bridged_lateness)?;
        non_negative("unattended", self.unattended)?;
        non_negative("bridged_loss", self.bridged_loss).map(drop)
    }
}

/// Limits of a muscle that follow from its drive where the machine does not say them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveLimits {
    /// Largest tension at the drive, N.
    pub tension: f64,
    /// Largest rate of change of it, N/s.
    pub tension_rate: f64,
    /// Largest speed of the cable at the winch, m/s.
    pub cable_speed: f64,
    /// Highest temperature of the winding by the thermal model, degrees Celsius.
    pub winding: f64,
}

/// Default of the tension's rate, largest tensions of the drive per second.
const TENSION_RATE: f64 = 20.0;
/// Default of the speed, of the drive's without a load, 1.
const SPEED_FRACTION: f64 = 1.25;
/// Degrees by which a winding stays below its own limit.
const WINDING_MARGIN: f64 = 5.0;

impl SafetyLimits {
    /// The limits of a muscle with this drive.
    #[must_use]
    pub fn of_drive(&self, drive: &DriveParameters) -> DriveLimits {
        DriveLimits {
            tension: self.tension.unwrap_or(drive.max_tension),
            tension_rate: self.tension_rate.unwrap_or(TENSION_RATE * drive.max_tension),
            cable_speed: self.cable_speed.unwrap_or(SPEED_FRACTION * drive.speed_at(0.0)),
            winding: self.winding.unwrap_or(drive.motor.hottest - WINDING_MARGIN),
        }
    }
}
