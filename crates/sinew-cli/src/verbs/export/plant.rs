//! Simulated plants behind units: what goes in, what comes out, how they step.

use crate::arguments::SpecimenText;
use crate::error::Error;
use crate::verbs::machine_source::MachineSource;
use crate::verbs::simulated_arm::simulated_arm;
use serde::{Deserialize, Serialize};
use sinew::drive::DriveCommand;
use sinew::transmission::Sliding;
use sinew::transmission::cable::EndMotion;
use sinew::twin::arm::ArmTwin;
use sinew::twin::cable::{CablePlant, CableReading, Resolution};
use sinew_export::fmu::{Plant, Port};

/// Longest step of a cable, s; a longer one of the unit is divided.
const CABLE_STEP: f64 = 1e-3;
/// Most parts of one step.
const MOST_PARTS: f64 = 1e5;

/// `resources/plant.json` of a unit.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum PlantFile {
    /// One cable with both of its ends.
    Cable {
        /// As `--specimen` takes it.
        specimen: String,
        /// Far tension before the first step, N.
        start_n: f64,
    },
    /// A machine with all its files.
    Machine {
        source: MachineSource,
        /// Of the specimen and of the noise of its sensors.
        seed: u64,
    },
}

/// A plant in time.
#[derive(Clone)]
pub(super) enum SimulatedPlant {
    Cable { plant: Box<CablePlant>, ends: [f64; 2], reading: CableReading },
    Machine { arm: Box<ArmTwin>, commands: Vec<DriveCommand>, read: bool },
}

impl PlantFile {
    /// The plant before its first step.
    pub(super) fn build(&self) -> Result<SimulatedPlant, Error> {
        Ok(match self {
            Self::Cable { specimen, start_n } => {
                let Some(SpecimenText { specimen, .. }) = SpecimenText::new(specimen) else {
                    return Err(Error::Shown(format!(
                        "specimen: expected bench, ideal or a seed, got {specimen}"
                    )));
                };
                let mut plant = Box::new(CablePlant::new(&specimen, Resolution::default())?);
                plant.settle(*start_n, Sliding::TowardMotor)?;
                let reading = plant.clone().step(CABLE_STEP, EndMotion::default())?;
                SimulatedPlant::Cable { plant, ends: [0.0; 2], reading }
            }
            Self::Machine { source, seed } => {
                let arm = Box::new(simulated_arm(&source.machine()?.machine, *seed)?);
                let commands = vec![DriveCommand::Velocity(0.0); arm.specimen().drives.len()];
                SimulatedPlant::Machine { arm, commands, read: false }
            }
        })
    }
}

fn port(part: &str, name: impl Into<String>, description: &str) -> Port {
    let (part, description) = (part.to_owned(), description.to_owned());
    Port { part, name: name.into(), description, start: 0.0 }
}

impl SimulatedPlant {
    /// What a unit says of it, in the order of [`step`](Self::step) and [`outputs`](Self::outputs).
    pub(super) fn describe(&self, file: String) -> Plant {
        match self {
            Self::Cable { .. } => Plant {
                description: "SIMULATED cable through a sheath".to_owned(),
                file,
                step_s: CABLE_STEP,
                inputs: vec![
                    port("motor", "position_m", "position of the cable at the motor, + toward the motor"),
                    port("anchor", "position_m", "position of the cable at the anchor, + toward the motor"),
                ],
                outputs: vec![
                    port("motor", "tension_n", "tension at the motor"),
                    port("anchor", "tension_n", "tension at the anchor"),
                    port("cable", "stretch_m", "stretch from zero tension; negative where slack"),
                ],
                flags: vec![port("cable", "broken", "whether it is broken")],
            },
            Self::Machine { arm, .. } => {
                let parts = arm.specimen().robot.parts();
                let muscles: Vec<&str> = parts.tendons.iter().map(|tendon| tendon.name.as_str()).collect();
                let speed = "speed of the cable at the winch, + toward the motor; NaN: drive off";
                let mut outputs = Vec::new();
                for muscle in &muscles {
                    outputs.push(port(muscle, "motor_m", "position of the cable by the motor's encoder"));
                    outputs.push(port(muscle, "tension_n", "tension at the drive by its load cell"));
                    outputs.push(port(muscle, "far_tension_n", "true tension at the anchor"));
                }
                for joint in arm.specimen().robot.independent_joints() {
                    let (joint, unit) = (&parts.joints[joint], parts.joints[joint].kind.unit());
                    let named = |what: &str, per: &str| format!("{what}_{unit}{per}");
                    outputs.push(port(
                        &joint.name,
                        named("encoder", ""),
                        "coordinate by the joint's encoder",
                    ));
                    outputs.push(port(&joint.name, named("position", ""), "true coordinate"));
                    outputs.push(port(&joint.name, named("velocity", "_s"), "true velocity"));
                }
                Plant {
                    description: format!("SIMULATED machine {}, {} muscles", parts.name, muscles.len()),
                    file,
                    step_s: arm.specimen().period,
                    inputs: muscles.iter().map(|muscle| port(muscle, "speed_m_s", speed)).collect(),
                    outputs,
                    flags: muscles.iter().map(|m| port(m, "broken", "whether its cable is broken")).collect(),
                }
            }
        }
    }

    /// Numbers that go in.
    pub(super) fn inputs(&self) -> usize {
        match self {
            Self::Cable { ends, .. } => ends.len(),
            Self::Machine { commands, .. } => commands.len(),
        }
    }

    /// Steps over some seconds with inputs; whether it could.
    pub(super) fn step(&mut self, seconds: f64, inputs: &[f64]) -> bool {
        let longest = match self {
            Self::Cable { .. } => CABLE_STEP,
            Self::Machine { arm, .. } => arm.specimen().period,
        };
        // The difference of two times is not quite the step.
        let parts = (seconds / longest - 1e-6).ceil().max(1.0);
        if !(seconds > 0.0 && parts <= MOST_PARTS) {
            return false;
        }
        match self {
            Self::Cable { plant, ends, reading } => {
                let [motor, anchor] = [0, 1].map(|k| (inputs[k] - ends[k]) / parts);
                let before = plant.clone();
                for _ in 0..parts as usize {
                    match plant.step(seconds / parts, EndMotion { motor, anchor }) {
                        Ok(said) => *reading = said,
                        Err(_) => {
                            *plant = before;
                            return false;
                        }
                    }
                }
                ends.copy_from_slice(inputs);
                true
            }
            Self::Machine { arm, commands, read } => {
                for (command, speed) in commands.iter_mut().zip(inputs) {
                    let off = !speed.is_finite();
                    *command = if off { DriveCommand::Off } else { DriveCommand::Velocity(*speed) };
                }
                *read = true;
                (0..parts as usize).all(|_| arm.step(commands, seconds / parts).is_ok())
            }
        }
    }

    /// Numbers, then flags, that come out; readings of sensors are missing before the first step.
    pub(super) fn outputs(&self) -> Vec<f64> {
        match self {
            Self::Cable { reading, .. } => {
                let broken = f64::from(u8::from(reading.broken.is_some()));
                vec![reading.tension_in, reading.tension_out, reading.stretch, broken]
            }
            Self::Machine { arm, read, .. } => {
                let missing = arm.reading().missing();
                let (reading, truth) = (if *read { arm.reading() } else { &missing }, arm.truth());
                let muscles = truth.cables.iter().enumerate();
                let muscles =
                    muscles.flat_map(|(k, c)| [reading.motor[k], reading.tension[k], c.tension_out]);
                let joints = truth.q.iter().zip(truth.v).zip(&reading.joint);
                let joints = joints.flat_map(|((q, v), encoder)| [*encoder, *q, *v]);
                let broken = truth.cables.iter().map(|c| f64::from(u8::from(c.broken.is_some())));
                muscles.chain(joints).chain(broken).collect()
            }
        }
    }
}
