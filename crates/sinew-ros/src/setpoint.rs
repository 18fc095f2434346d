use crate::refusal::{Refusal, coordinates, places};
use sinew_record::ros2::CdrReader;

const KIND: &str = "sensor_msgs/JointState";

/// Positions of a `sensor_msgs/JointState` as a set-point, in the order of the machine, rad or m. Velocities
/// and efforts are not used.
///
/// # Shapes
/// `ranges: [joints]`, rad or m.
///
/// # Errors
/// The first part that is wrong: names that are not those of `joints`, each once; numbers that are not
/// finite, out of range, too many or too few.
pub fn setpoint(
    mut message: CdrReader<'_>,
    joints: &[String],
    ranges: &[[f64; 2]],
) -> Result<Vec<f64>, Refusal> {
    let read = (message.header(), message.texts(), message.f64s(), message.f64s(), message.f64s());
    let (Some(_), Some(names), Some(position), Some(_), Some(_)) = read else {
        return Err(Refusal::bytes(KIND));
    };
    if !message.is_read() {
        return Err(Refusal::bytes(KIND));
    }
    let places = places("name", &names, joints)?;
    coordinates("position", &position, &places, joints, ranges)
}
