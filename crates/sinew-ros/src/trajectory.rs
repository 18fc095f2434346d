use crate::refusal::{Refusal, coordinates, places};
use sinew_record::ros2::CdrReader;

/// `trajectory_msgs/JointTrajectory` for a machine: positions of all joints at times that ascend.
///
/// Between the points the reference is that of a link's set-points; velocities, accelerations and efforts of
/// the message must be finite, and are not used.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// When it begins, ns since 1970; 0 for at once.
    pub stamp: i64,
    /// From the beginning to every point, ns.
    pub times: Vec<u64>,
    /// Coordinates in the order of the machine, rad or m: `[points x joints]`.
    pub numbers: Vec<f64>,
}

const KIND: &str = "trajectory_msgs/JointTrajectory";

impl Trajectory {
    /// Reads and checks a message.
    ///
    /// # Shapes
    /// `ranges: [joints]`, rad or m.
    ///
    /// # Errors
    /// The first part that is wrong: names that are not those of `joints`, each once; no points; numbers that
    /// are not finite, out of range, too many or too few; times that do not ascend.
    pub fn read(mut message: CdrReader<'_>, joints: &[String], ranges: &[[f64; 2]]) -> Result<Self, Refusal> {
        let other = || Refusal::bytes(KIND);
        let (stamp, _) = message.header().ok_or_else(other)?;
        let names = message.texts().ok_or_else(other)?;
        let count = message.length().ok_or_else(other)?;
        let places = places("joint_names", &names, joints)?;
        let (mut times, mut numbers) = (Vec::new(), Vec::new());
        for point in 0..count {
            let lists = [message.f64s(), message.f64s(), message.f64s(), message.f64s()];
            let [Some(positions), Some(velocities), Some(accelerations), Some(effort)] = lists else {
                return Err(other());
            };
            let time = message.time().ok_or_else(other)?;
            let place = |field: &str| format!("points[{point}].{field}");
            numbers.extend(coordinates(&place("positions"), &positions, &places, joints, ranges)?);
            let unused = [("velocities", velocities), ("accelerations", accelerations), ("effort", effort)];
            for (field, list) in unused {
                if !list.is_empty() && list.len() != joints.len() {
                    let expected = format!("none or {} numbers", joints.len());
                    return Err(Refusal::new(place(field), expected, list.len()));
                }
                if let Some(x) = list.iter().find(|x| !x.is_finite()) {
                    return Err(Refusal::new(place(field), "finite numbers", x));
                }
            }
            let after = times.last().copied();
            let time = u64::try_from(time).ok().filter(|time| after.is_none_or(|after| *time > after));
            times.push(time.ok_or_else(|| {
                let expected = match after {
                    Some(after) => format!("more than the {} s of the point before", seconds(after)),
                    None => "0 s or more".to_owned(),
                };
                Refusal::new(place("time_from_start"), expected, "one that is not")
            })?);
        }
        if times.is_empty() {
            return Err(Refusal::new("points", "at least one", "none"));
        }
        if message.is_read() { Ok(Self { stamp, times, numbers }) } else { Err(other()) }
    }

    /// From its beginning to its last point, ns.
    #[must_use]
    pub fn duration(&self) -> u64 {
        self.times.last().copied().unwrap_or(0)
    }

    /// Time and coordinates of a point.
    #[must_use]
    pub fn point(&self, k: usize) -> Option<(u64, &[f64])> {
        let joints = self.numbers.len() / self.times.len().max(1);
        Some((*self.times.get(k)?, self.numbers.get(k * joints..(k + 1) * joints)?))
    }
}

fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}
