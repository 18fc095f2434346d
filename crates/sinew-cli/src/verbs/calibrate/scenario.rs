//! Machine, markers and camera of a calibration.

use crate::arguments::ScenarioArguments;
use crate::error::Error;
use crate::verbs::machine_source::{self, Loaded};
use sinew::machine::{BASE_MARKER_SD_M, LINK_MARKER_SD_M, Machine, Marker};
use sinew::trajectory::Trajectory;
use sinew::twin::camera::CameraParameters;
use sinew_lab::vision::{CalibrationPoses, choose_poses};

/// What is calibrated, and what a camera sees of it.
pub(super) struct Scenario {
    /// As designed.
    pub(super) machine: Machine,
    /// Of its files.
    pub(super) hash: String,
    pub(super) markers: Vec<Marker>,
}

/// Name of the first joint whose position no sensor measures.
fn without_encoder(machine: &Machine) -> Option<&str> {
    let joints = machine.robot.independent_joints().into_iter().zip(&machine.encoders);
    let mut missing = joints.filter(|(_, encoder)| encoder.is_none());
    missing.next().map(|(joint, _)| machine.robot.parts().joints[joint].name.as_str())
}

impl Scenario {
    pub(super) fn new(arguments: &ScenarioArguments) -> Result<Self, Error> {
        let Loaded { described, source, .. } =
            machine_source::load(&arguments.model, arguments.root.dir.as_deref())?;
        let mut machine = described.machine;
        if let Some(workshop) = arguments.tolerances {
            machine = machine.built_by(workshop);
        }
        let tolerances = &machine.tolerances;
        if tolerances.link == 0.0 && tolerances.axis == 0.0 && tolerances.zero == 0.0 {
            return Err(Error::Argument {
                flag: "--tolerances",
                value: String::new(),
                expected: "careful or rough, or link_m, axis_rad and zero_rad in [tolerances] of the machine file",
            });
        }
        if let Some(joint) = without_encoder(&machine) {
            return Err(Error::Shown(format!(
                "joint `{joint}` has no encoder: frames and zeros can be calibrated only of machines with an \
                    encoder at every joint that follows no other"
            )));
        }
        let mut markers = machine.default_markers();
        let own = |marker: &Marker| marker.body != 0;
        if !arguments.marker.is_empty() {
            markers.retain(|marker| !own(marker));
            for text in &arguments.marker {
                markers.push(on_body(&machine, text)?);
            }
        }
        if !arguments.base_tag.is_empty() {
            markers.retain(own);
            for text in &arguments.base_tag {
                let (name, place) = named_place("--base-tag", text, text)?;
                markers.push(Marker { name, body: 0, position: place, position_sd: BASE_MARKER_SD_M });
            }
        }
        Ok(Self { machine, hash: source.hash(), markers })
    }

    /// See [`choose_poses`].
    pub(super) fn poses(
        &self,
        arguments: &ScenarioArguments,
        fails: impl FnMut(&Trajectory) -> Result<Option<f64>, sinew_lab::Error>,
    ) -> Result<CalibrationPoses, Error> {
        let counts = (usize::from(arguments.poses), usize::from(arguments.check));
        Ok(choose_poses(&self.machine, &self.markers, counts, arguments.seed, fails)?)
    }

    /// The simulated camera with its faults, on a motion of a duration, s.
    pub(super) fn camera(&self, faults: &[String], duration: f64) -> Result<CameraParameters, Error> {
        let mut camera = CameraParameters::looking_at(0.5 * self.machine.size());
        for text in faults {
            let refuse = || Error::Argument {
                flag: "--camera-fault",
                value: text.clone(),
                expected: "KEY=NUMBER with noise_m, delay_s, jitter_s, scale, distortion_m, outliers, dropouts, \
                    swapped, mirrored or moved_m",
            };
            let (key, number) = text.split_once('=').ok_or_else(refuse)?;
            let number: f64 =
                number.trim().parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(refuse)?;
            let fraction = (0.0..=1.0).contains(&number);
            match key.trim() {
                "noise_m" if number >= 0.0 => camera.noise = number,
                "delay_s" => camera.delay = number,
                "jitter_s" if number >= 0.0 => camera.jitter = number,
                "scale" if number.abs() < 0.5 => camera.scale = number,
                "distortion_m" if number >= 0.0 => camera.distortion = number,
                "outliers" if fraction => camera.outliers = number,
                "dropouts" if fraction => camera.dropouts = number,
                "swapped" if fraction => camera.swapped = number,
                "mirrored" => camera.mirrored = number != 0.0,
                "moved_m" => camera.moved = (0.5 * duration, [number, 0.0, 0.0]),
                _ => return Err(refuse()),
            }
        }
        Ok(camera)
    }
}

fn on_body(machine: &Machine, text: &str) -> Result<Marker, Error> {
    let refuse = || Error::Argument {
        flag: "--marker",
        value: text.to_owned(),
        expected: "NAME=BODY:X,Y,Z with a body of the machine",
    };
    let (name, rest) = text.split_once('=').ok_or_else(refuse)?;
    let (body, place) = rest.rsplit_once(':').ok_or_else(refuse)?;
    let body = machine.robot.body(body.trim()).ok_or_else(refuse)?;
    let (_, position) = named_place("--marker", text, &format!("{name}={place}"))?;
    Ok(Marker { name: name.trim().to_owned(), body, position, position_sd: LINK_MARKER_SD_M })
}

fn named_place(flag: &'static str, given: &str, text: &str) -> Result<(String, [f64; 3]), Error> {
    let refuse = || Error::Argument { flag, value: given.to_owned(), expected: "NAME=X,Y,Z in m" };
    let (name, place) = text.split_once('=').ok_or_else(refuse)?;
    let numbers: Vec<f64> = place.split(',').filter_map(|x| x.trim().parse().ok()).collect();
    let place = <[f64; 3]>::try_from(numbers).ok().filter(|x| x.iter().all(|x| x.is_finite()));
    Ok((name.trim().to_owned(), place.ok_or_else(refuse)?))
}
