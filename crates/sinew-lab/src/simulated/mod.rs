//! Logs of a simulated bench, labelled as simulated, for demonstrations without hardware.
//!
//! The plant is an elastic cable in series with eight nodes of friction, each with its own bend and state,
//! that creeps under load. The logs carry the displacement of the anchor, so that identification can fit both
//! kinds of candidates:
//!
//! | candidate                    | shared with this plant                      | not shared                                  |
//! |------------------------------|---------------------------------------------|---------------------------------------------|
//! | clamp cells, classical laws, networks | the capstan's ratio of tensions at one bend | states along the cable, creep, aging, noise |
//! | cable observer               | springs in series with nodes, capstan friction at each, a drag, friction that falls with speed | code; number and places of nodes (here two tight bends), form of the fall and of its lag, creep, daily changes, zeros and noise |
//!
//! With the anchor's displacement the candidate family is therefore of the same structure as the plant, at
//! another discretisation and without creep: errors on these logs are lower bounds of those on a real bench.

mod motion;
mod plant;

use motion::{Motion, Sampler};
use plant::Cable;
use std::fmt::Write;

/// Longest step of the plant, s.
const LONGEST_STEP_S: f64 = 0.005;
/// Motion before the first sample, s: as on a bench, a log starts at an arbitrary state of the hysteresis.
const WARM_UP_S: f64 = 3.0;

/// Options of a simulated log.
///
/// | field        | unit | domain     | meaning                                                         |
/// |--------------|------|------------|-----------------------------------------------------------------|
/// | `seed`       |      |            | specimen and all random draws                                    |
/// | `day`        |      |            | same specimen, another motion, slightly other friction and zero  |
/// | `duration_s` | s    | 1 to 600   | length of the log                                                |
/// | `rate_hz`    | Hz   | 10 to 1000 | samples per second                                               |
/// | `noise`      | 1    | 0 to 100   | 1: a good bench (0.15 N, 5 um); 0: none                          |
///
/// A number outside its domain counts as the nearest inside it, NaN as the default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulatedLog {
    /// Specimen and all random draws.
    pub seed: u64,
    /// Same specimen, another motion, slightly other friction and sensor zero.
    pub day: u32,
    /// Length of the log, s.
    pub duration_s: f64,
    /// Samples per second, Hz.
    pub rate_hz: f64,
    /// Sensor noise as a multiple of a good bench's.
    pub noise: f64,
}

impl Default for SimulatedLog {
    fn default() -> Self {
        Self { seed: 1, day: 1, duration_s: 90.0, rate_hz: 100.0, noise: 1.0 }
    }
}

impl SimulatedLog {
    /// The same with every number inside its domain.
    fn within_domain(self) -> Self {
        let default = Self::default();
        let inside = |value: f64, low: f64, high: f64, otherwise: f64| {
            if value.is_nan() { otherwise } else { value.clamp(low, high) }
        };
        Self {
            duration_s: inside(self.duration_s, 1.0, 600.0, default.duration_s),
            rate_hz: inside(self.rate_hz, 10.0, 1000.0, default.rate_hz),
            noise: inside(self.noise, 0.0, 100.0, default.noise),
            ..self
        }
    }
}

/// A simulated log as CSV text: comments that label it as simulated, then `time_s, tension_in_n,
/// position_in_m, tension_out_n, anchor_m`, displacements positive toward the motor.
///
/// The same options give the same bytes on every machine.
///
/// # Example
/// ```
/// use sinew_lab::simulated::{SimulatedLog, simulated_log};
/// let text = simulated_log(&SimulatedLog { duration_s: 2.0, ..SimulatedLog::default() });
/// assert!(text.starts_with("# SIMULATED"));
/// assert_eq!(text.lines().filter(|line| !line.starts_with('#')).count(), 1 + 200);
/// ```
#[must_use]
pub fn simulated_log(options: &SimulatedLog) -> String {
    let options = options.within_domain();
    let mut sampler = Sampler::new(options.seed, options.day);
    let day = Day::sampled(&mut sampler);
    let motion = Motion::sampled(&mut sampler, WARM_UP_S + options.duration_s + 1.0);
    let mut cable = Cable::specimen(options.seed, day.friction_factor, day.stiffness_factor);
    let interval_s = 1.0 / options.rate_hz;
    let parts = (interval_s / LONGEST_STEP_S).ceil().max(1.0);
    let rows = (options.duration_s * options.rate_hz).round() as usize;
    let warm_up = (WARM_UP_S * options.rate_hz).round() as usize;
    let mut text = header(&options, &day, &cable);
    let mut noise = |scale: f64| options.noise * scale * sampler.normal();
    for row in 0..warm_up + rows {
        let mut at = motion.at(row as f64 * interval_s);
        let mut ends = cable.step(at.winch_m, at.anchor_m, interval_s / parts);
        for part in 1..parts as usize {
            at = motion.at((row as f64 + part as f64 / parts) * interval_s);
            ends = cable.step(at.winch_m, at.anchor_m, interval_s / parts);
        }
        if row < warm_up {
            continue;
        }
        let time_s = (row - warm_up) as f64 * interval_s;
        let tension_in = ends.tension_in + day.zero_n + noise(0.15);
        let (winch, tension_out) = (at.winch_m + noise(5e-6), ends.tension_out + noise(0.15));
        let anchor = at.anchor_m + noise(5e-6);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{time_s:.4},{tension_in:.3},{winch:.6},{tension_out:.3},{anchor:.6}");
    }
    text
}

/// Five days on one simulated bench, as names and texts: four for training and `simulated_day_5.csv` for
/// testing.
#[must_use]
pub fn demo_logs(seed: u64) -> Vec<(String, String)> {
    let log = |day| simulated_log(&SimulatedLog { seed, day, ..SimulatedLog::default() });
    (1..=5).map(|day| (format!("simulated_day_{day}.csv"), log(day))).collect()
}

/// A number of the simulated specimen that an identification estimates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// As the report of an identification names it.
    pub name: &'static str,
    /// Its unit; `1` for none.
    pub unit: &'static str,
    /// Its value on an average day.
    pub value: f64,
}

/// The numbers of the specimen of [`demo_logs`] that the cable observer has, too: of the other quantities the
/// plant has none, or another one at every node.
#[must_use]
pub fn demo_truth(seed: u64) -> [Truth; 3] {
    let cable = Cable::specimen(seed, 1.0, 1.0);
    let truth = |name, unit, value| Truth { name, unit, value };
    [
        truth("friction angle (mu phi - ln eta)", "1", cable.friction_angle()),
        truth("drag of the grease", "N s/m", cable.whole_drag()),
        truth("compliance of the whole cable", "m/N", cable.compliance()),
    ]
}

/// Variation from day to day.
struct Day {
    friction_factor: f64,
    stiffness_factor: f64,
    zero_n: f64,
}

impl Day {
    fn sampled(sampler: &mut Sampler) -> Self {
        Self {
            friction_factor: 1.0 + 0.015 * sampler.normal().clamp(-2.0, 2.0),
            stiffness_factor: 1.0 + 0.005 * sampler.normal().clamp(-2.0, 2.0),
            zero_n: 0.2 * sampler.normal().clamp(-2.0, 2.0),
        }
    }
}

fn header(options: &SimulatedLog, day: &Day, cable: &Cable) -> String {
    let SimulatedLog { seed, day: number, duration_s, rate_hz, noise } = options;
    format!(
        "# SIMULATED, not measured: no cable was pulled for this log\n\
         # seed {seed}, day {number}, {duration_s} s at {rate_hz} Hz, noise {noise} times 0.15 N and 5 um\n\
         # plant: {}\n\
         # this day: friction x {:.4}, stiffness x {:.4}, zero of tension_in {:+.3} N\n\
         # displacements are positive toward the motor\n\
         time_s,tension_in_n,position_in_m,tension_out_n,anchor_m\n",
        cable.describe(),
        day.friction_factor,
        day.stiffness_factor,
        day.zero_n,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn short(day: u32) -> SimulatedLog {
        SimulatedLog { day, duration_s: 30.0, noise: 0.0, ..SimulatedLog::default() }
    }

    /// Rows of a log: time, tension in, winch, tension out, anchor.
    fn rows(text: &str) -> Vec<[f64; 5]> {
        let data = text.lines().filter(|line| !line.starts_with('#')).skip(1);
        data.map(|line| {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            cells.try_into().unwrap()
        })
        .collect()
    }

    #[test]
    fn every_log_is_labelled_as_simulated_with_its_parameters() {
        for (name, text) in demo_logs(7) {
            assert!(name.starts_with("simulated_"), "{name}");
            assert!(text.starts_with("# SIMULATED, not measured"));
            assert!(text.lines().nth(1).unwrap().contains("seed 7"));
            assert!(text.lines().any(|line| line.starts_with("# plant:")));
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_bytes_and_another_seed_or_day_does_not() {
        let options = SimulatedLog { duration_s: 3.0, ..SimulatedLog::default() };
        let text = simulated_log(&options);
        assert_eq!(text, simulated_log(&options));
        assert_ne!(rows(&text), rows(&simulated_log(&SimulatedLog { seed: 2, ..options })));
        assert_ne!(rows(&text), rows(&simulated_log(&SimulatedLog { day: 2, ..options })));
    }

    #[test]
    fn the_far_tension_has_hysteresis() {
        // At equal near tension the far tension is lower while the cable is pulled in than while it is paid
        // out.
        let rows = rows(&simulated_log(&short(1)));
        let (mut pulled, mut eased) = (Vec::new(), Vec::new());
        for pair in rows.windows(2) {
            let speed = (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0]);
            if (70.0..90.0).contains(&pair[1][1]) && speed.abs() > 5.0 {
                if speed > 0.0 { &mut pulled } else { &mut eased }.push(pair[1][3]);
            }
        }
        assert!(pulled.len() > 20 && eased.len() > 20, "{} {}", pulled.len(), eased.len());
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let gap = mean(&eased) - mean(&pulled);
        assert!(gap > 10.0, "{gap} N between the branches");
    }

    #[test]
    fn tensions_are_positive_and_bounded_and_the_motion_reverses_often() {
        let rows = rows(&simulated_log(&short(2)));
        assert!(rows.iter().all(|row| row.iter().all(|value| value.is_finite())));
        assert!(rows.iter().all(|row| row[1] > 0.0 && row[3] > 0.0 && row[1] < 400.0 && row[3] < 400.0));
        let steps: Vec<f64> = rows.windows(2).map(|w| w[1][1] - w[0][1]).filter(|s| s.abs() > 0.05).collect();
        let reversals = steps.windows(2).filter(|w| w[0] * w[1] < 0.0).count();
        assert!(reversals >= 10, "{reversals}");
    }

    #[test]
    fn options_outside_their_domain_still_give_a_finite_log() {
        for wild in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -1.0, 1e300] {
            let options =
                SimulatedLog { noise: wild, duration_s: wild.min(2.0), rate_hz: wild.min(50.0), ..short(1) };
            assert!(rows(&simulated_log(&options)).len() >= 10);
        }
    }

    #[test]
    fn the_log_reader_finds_every_role_by_name() {
        use sinew_identify::log::{ReadOptions, RequestedRoles, read_bytes};
        let text = simulated_log(&short(1));
        let logs = [("simulated_day_1.csv", text.as_bytes())];
        let options = ReadOptions { far_required: true, ..ReadOptions::default() };
        let data = read_bytes(&logs, &RequestedRoles::default(), &options).unwrap();
        let inputs: Vec<&str> = data.roles.inputs.iter().map(|input| input.column.as_str()).collect();
        assert_eq!(inputs, ["tension_in_n", "position_in_m", "anchor_m"]);
        assert_eq!(data.roles.far.as_deref(), Some("tension_out_n"));
        assert_eq!(data.logs[0].samples, 3000);
    }
}
