//! Definitions of the messages in a bag, as `ros2msg` schemas have them: a message, then those in it.

use sinew_session::signals::{Axis, Signal};

const HEADER: [(&str, &str); 2] = [
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"),
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"),
];

pub(super) fn joint_state() -> String {
    let fields =
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n";
    with(fields.to_owned(), &[])
}

pub(super) fn transforms() -> String {
    with(
        "geometry_msgs/TransformStamped[] transforms\n".to_owned(),
        &[
            (
                "geometry_msgs/TransformStamped",
                "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
            ),
            (
                "geometry_msgs/Transform",
                "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
            ),
            ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"),
            ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"),
        ],
    )
}

pub(super) fn diagnostics() -> String {
    with(
        "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n".to_owned(),
        &[
            (
                "diagnostic_msgs/DiagnosticStatus",
                "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\nstring message\n\
                    string hardware_id\ndiagnostic_msgs/KeyValue[] values\n",
            ),
            ("diagnostic_msgs/KeyValue", "string key\nstring value\n"),
        ],
    )
}

/// All signals of an axis, a field each, by the table.
pub(super) fn signals(axis: Axis) -> String {
    let (of, names, kind) = match axis {
        Axis::Cycle => ("control cycle", "", "float64"),
        Axis::Joint => ("independent joints", "string[] name\n", "float64[]"),
        Axis::Muscle => ("muscles", "string[] name\n", "float64[]"),
    };
    let mut fields = format!(
        "# Signals of a machine's {of}; NaN or an empty list where the recording has none.\n\
            std_msgs/Header header\n{names}"
    );
    for row in Signal::ALL.iter().map(|signal| signal.row()).filter(|row| row.axis == axis) {
        fields += &format!("# {}, {}\n{kind} {}\n", row.unit, row.about, row.name);
    }
    with(fields, &[])
}

/// A definition with those of its parts and of the header.
fn with(fields: String, parts: &[(&str, &str)]) -> String {
    parts
        .iter()
        .chain(&HEADER)
        .fold(fields, |all, (name, fields)| all + &format!("{}\nMSG: {name}\n{fields}", "=".repeat(80)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_signal_has_a_name_that_a_field_may_have() {
        for signal in Signal::ALL {
            let name = signal.row().name;
            let usual = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
            assert!(name.chars().all(usual) && !name.contains("__") && !name.ends_with('_'), "{name}");
            assert!(name.starts_with(|c: char| c.is_ascii_lowercase()), "{name}");
            assert!(!["header", "name"].contains(&name), "{name}");
        }
    }
}
