use crate::Error;
use serde::{Deserialize, Serialize};
use sinew::body::{Displacement, JointCorrection, Robot};
use sinew::machine::Machine;

/// How far the end point, or another marker, is from where it is expected, m; or what is missed of lengths,
/// m, or torques, Nm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorRange {
    /// Mean over the poses.
    pub mean: f64,
    /// Largest.
    pub max: f64,
}

/// The mean error that the estimate itself expects, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Reported {
    /// Mean over the poses.
    pub mean: f64,
}

/// Errors in the poses that the estimate has not seen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// As designed.
    pub before: ErrorRange,
    /// Calibrated.
    pub after: ErrorRange,
    /// By the uncertainty of parameters and camera.
    pub reported: Reported,
}

/// What is missed in places that an estimate has not seen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Missed {
    /// As designed.
    pub before: ErrorRange,
    /// Calibrated.
    pub after: ErrorRange,
}

/// The same of what a machine reads by itself, without a camera.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HeldOutCables {
    /// Of the lengths of muscles, m.
    pub length_m: Missed,
    /// Of the torques of all joints at once, Nm (N of slides).
    pub torque_nm: Missed,
}

/// A parameter as found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CalibratedParameter {
    /// With its unit at the end.
    pub name: String,
    /// Found.
    pub value: f64,
    /// Standard deviation after.
    pub sd: f64,
    /// Before; none where nothing was known.
    #[serde(default)]
    pub tolerance: Option<f64>,
    /// Whether the standard deviation is below half of the tolerance.
    pub determined: bool,
}

/// How a joint differs from its description.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibratedJoint {
    /// Its name.
    pub name: String,
    /// Of its frame, m.
    pub offset_m: [f64; 3],
    /// Of its axis about x and y of its frame, rad.
    pub tilt_rad: [f64; 2],
    /// Reading of its encoder where the description has its coordinate at zero, rad or m.
    pub zero: f64,
    /// Bend of the link behind it, rad/Nm.
    pub flex_rad_per_nm: f64,
}

/// Where a site of an equivalent route is on its body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibratedSite {
    /// Its index in the robot.
    pub index: usize,
    /// Its name.
    pub name: String,
    /// m.
    pub position_m: [f64; 3],
}

/// Surface of an equivalent route.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibratedWrap {
    /// Its index in the robot.
    pub index: usize,
    /// Its name.
    pub name: String,
    /// m.
    pub radius_m: f64,
}

/// Load of a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibratedBody {
    /// Its index in the robot.
    pub index: usize,
    /// Its name.
    pub name: String,
    /// kg.
    pub mass_kg: f64,
    /// In its frame, m.
    pub center_of_mass_m: [f64; 3],
}

/// A calibration of a machine, as in `calibration.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Version of the file.
    pub version: u32,
    /// Name of the machine.
    pub machine: String,
    /// Hash of the files of the machine.
    pub machine_hash: String,
    /// Whether the machine was simulated.
    pub simulated: bool,
    /// `use`, `use with care` or `do not use`; none in files of before.
    #[serde(default)]
    pub recommendation: Option<String>,
    /// Errors in poses that the estimate has not seen, by a camera.
    #[serde(default)]
    pub held_out_error_m: Option<HeldOut>,
    /// The same without a camera.
    #[serde(default)]
    pub held_out: Option<HeldOutCables>,
    /// All joints in the order of the machine; empty without a camera.
    #[serde(default)]
    pub joint: Vec<CalibratedJoint>,
    /// Sites that are elsewhere.
    #[serde(default)]
    pub site: Vec<CalibratedSite>,
    /// Surfaces of another radius.
    #[serde(default)]
    pub wrap: Vec<CalibratedWrap>,
    /// Bodies of another mass or centre of mass.
    #[serde(default)]
    pub body: Vec<CalibratedBody>,
    /// All parameters, those of camera and markers included.
    pub parameter: Vec<CalibratedParameter>,
}

impl Calibration {
    /// Version of the files that are written.
    pub const VERSION: u32 = 1;

    /// The machine with this geometry, in the readings of its encoders as coordinates.
    ///
    /// # Errors
    /// [`Error::Experiment`] for the calibration of another machine or a newer version;
    /// [`Error::Physics`] for
    /// numbers that are no valid machine.
    pub fn apply(&self, machine: &Machine, hash: &str) -> Result<Machine, Error> {
        let refuse = |name, expected, got: &str| Err(Error::experiment(name, expected, &got));
        if self.version != Self::VERSION {
            return refuse("version of the calibration", "1", &self.version.to_string());
        }
        if self.machine_hash != hash {
            let got = format!("{} of `{}`; this machine has {hash}", self.machine_hash, self.machine);
            return refuse("machine_hash of the calibration", "that of this machine's files", &got);
        }
        let joints = machine.robot.parts().joints.iter().map(|joint| joint.name.as_str());
        let camera = !self.joint.is_empty();
        if camera && !joints.eq(self.joint.iter().map(|joint| joint.name.as_str())) {
            let got: Vec<&str> = self.joint.iter().map(|joint| joint.name.as_str()).collect();
            return refuse(
                "joints of the calibration",
                "those of the machine, in its order",
                &got.join(", "),
            );
        }
        let mut parts = machine.robot.parts().clone();
        for CalibratedSite { index, name, position_m } in &self.site {
            let Some(site) = parts.sites.get_mut(*index).filter(|site| site.name == *name) else {
                return refuse("site of the calibration", "one of the machine", name);
            };
            site.position = *position_m;
        }
        for CalibratedWrap { index, name, radius_m } in &self.wrap {
            let Some(wrap) = parts.wraps.get_mut(*index).filter(|wrap| wrap.name == *name) else {
                return refuse("wrap of the calibration", "one of the machine", name);
            };
            wrap.radius = *radius_m;
        }
        for CalibratedBody { index, name, mass_kg, center_of_mass_m } in &self.body {
            let Some(body) = parts.bodies.get_mut(*index).filter(|body| body.name == *name) else {
                return refuse("body of the calibration", "one of the machine", name);
            };
            (body.mass, body.center_of_mass) = (*mass_kg, *center_of_mass_m);
        }
        let correction = |joint: &CalibratedJoint| JointCorrection {
            displacement: Displacement { offset: joint.offset_m, tilt: joint.tilt_rad },
            zero: joint.zero,
            flex: joint.flex_rad_per_nm,
        };
        let corrections: Vec<JointCorrection> = self.joint.iter().map(correction).collect();
        let parts = if camera { parts.corrected(&corrections) } else { parts };
        let robot = Robot::new(parts).map_err(sinew::Error::from)?;
        let mut calibrated = Machine { robot, ..machine.clone() };
        if camera {
            for (k, joint) in machine.robot.independent_joints().into_iter().enumerate() {
                calibrated.start[k] += corrections[joint].zero;
                calibrated.redundancy.rest[k] += corrections[joint].zero;
            }
        }
        calibrated.validate()?;
        Ok(calibrated)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine_file::load_machine;
    use sinew::body::Poses;
    use std::path::Path;

    fn finger() -> Machine {
        load_machine(Path::new("finger"), None).unwrap().machine
    }

    fn calibration(machine: &Machine, zero: f64) -> Calibration {
        let range = ErrorRange { mean: 1e-3, max: 2e-3 };
        let joints = machine.robot.parts().joints.iter().map(|joint| CalibratedJoint {
            name: joint.name.clone(),
            offset_m: [0.0; 3],
            tilt_rad: [0.0; 2],
            zero,
            flex_rad_per_nm: 0.0,
        });
        Calibration {
            version: Calibration::VERSION,
            machine: "finger".to_owned(),
            machine_hash: "1".to_owned(),
            simulated: true,
            recommendation: None,
            held_out_error_m: Some(HeldOut {
                before: range,
                after: range,
                reported: Reported { mean: 1e-3 },
            }),
            held_out: None,
            joint: joints.collect(),
            site: Vec::new(),
            wrap: Vec::new(),
            body: Vec::new(),
            parameter: Vec::new(),
        }
    }

    #[test]
    fn a_zero_shifts_the_readings_and_leaves_the_end_point_where_it_is() {
        let machine = finger();
        let calibrated = calibration(&machine, 0.02).apply(&machine, "1").unwrap();
        let tip = |machine: &Machine| {
            let mut poses = Poses::new(&machine.robot);
            let q = machine.robot.pose_from_independent(&machine.start).unwrap();
            machine.robot.bent_kinematics(&q, &mut poses).unwrap();
            machine.robot.site_pose(&poses, machine.payload_site().unwrap()).origin
        };
        assert!((calibrated.start[0] - machine.start[0] - 0.02).abs() < 1e-15);
        for (a, b) in tip(&machine).into_iter().zip(tip(&calibrated)) {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn nothing_found_is_the_machine_to_the_bit_and_another_machine_is_refused() {
        let machine = finger();
        assert_eq!(calibration(&machine, 0.0).apply(&machine, "1").unwrap(), machine);
        let text = calibration(&machine, 0.0).apply(&machine, "2").unwrap_err().to_string();
        assert!(text.contains("machine_hash") && text.contains("this machine has 2"), "{text}");
        let mut other = calibration(&machine, 0.0);
        other.joint.pop();
        let text = other.apply(&machine, "1").unwrap_err().to_string();
        assert!(text.contains("joints of the calibration"), "{text}");
    }
}
