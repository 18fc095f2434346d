//! Machines in a pose; a cable step by step.

use crate::Answer;
use serde::Deserialize;
use serde_json::json;
use sinew::body::{Poses, Reduction};
use sinew::machine::Machine;
use sinew::muscle::MuscleDynamics;
use sinew::transmission::Sliding;
use sinew::transmission::cable::{Cable, CableLaw, CableParameters, CablePath, EndMotion};

/// A machine of the repository, or of a file in MJCF.
pub(crate) fn machine(name: &str) -> Result<Machine, Box<dyn std::error::Error>> {
    if name.ends_with(".xml") {
        let text = std::fs::read_to_string(name)?;
        let described = sinew::description::from_mjcf(name, &text, &mut |_| Err("no other file".into()))?;
        return Ok(sinew::description::machine_of(described)?.machine);
    }
    let path = format!("{}/../../../models/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path)?;
    Ok(sinew::description::machine_from_toml(name, &text, &mut |_| Err("no other file".into()))?.machine)
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Pose {
    machine: String,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    tension: Vec<f64>,
    site: String,
}

impl Pose {
    pub(crate) fn answer(&self) -> Answer {
        let machine = machine(&self.machine)?;
        let robot = &machine.robot;
        let mut model = MuscleDynamics::new(robot)?;
        let n = model.joints();
        model.evaluate(&self.q)?;
        let (mut torque, mut acceleration, mut mass) = (vec![0.0; n], vec![0.0; n], vec![0.0; n * n]);
        model.inverse_dynamics(&self.v, &self.a, &mut torque)?;
        model.forward_dynamics(&self.v, &self.tension, None, &mut acceleration)?;
        model.mass_matrix(&mut mass)?;
        let site = robot.site(&self.site).ok_or("no such site")?;
        let mut poses = Poses::new(robot);
        robot.forward_kinematics(model.coordinates(), &mut poses)?;
        let position = robot.site_pose(&poses, site).origin;
        let nv = robot.nv();
        let mut rows = vec![0.0; 6 * nv];
        let (linear, angular) = rows.split_at_mut(3 * nv);
        robot.jacobian(&poses, robot.parts().sites[site].body, position, linear, angular)?;
        let mut reduction = Reduction::new(robot);
        reduction.update(robot, model.coordinates())?;
        let mut jacobian = vec![0.0; 6 * n];
        reduction.rows(&rows, &mut jacobian)?;
        Ok(json!({
            "lengths": model.lengths(),
            "moment_arms": model.moment_arms(),
            "wrap_angles": (0..model.muscles()).map(|muscle| model.wrap_angle(muscle)).collect::<Vec<f64>>(),
            "inverse_dynamics": torque,
            "forward_dynamics": acceleration,
            "mass_matrix": mass,
            "position": position,
            "jacobian": jacobian,
        }))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CableSteps {
    path: CablePath,
    parameters: CableParameters,
    cells: usize,
    settle: f64,
    interval: f64,
    steps: Vec<[f64; 2]>,
}

impl CableSteps {
    pub(crate) fn answer(&self) -> Answer {
        let mut cable = Cable::new(CableLaw::new(&self.path, &self.parameters, self.cells)?);
        cable.settle(self.settle, Sliding::TowardMotor)?;
        let mut rows = Vec::new();
        for [motor, anchor] in &self.steps {
            let ends = cable.step(self.interval, EndMotion { motor: *motor, anchor: *anchor })?;
            rows.push([ends.tension_in, ends.tension_out, ends.dissipated, cable.stretch()]);
        }
        Ok(
            json!({ "rows": rows, "tensions": cable.tensions().collect::<Vec<_>>(), "energy": cable.energy() }),
        )
    }
}

/// The time of a loop over a pose, for the benchmarks of the package.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PoseLoop {
    machine: String,
    count: usize,
}

impl PoseLoop {
    pub(crate) fn answer(&self) -> Answer {
        let machine = machine(&self.machine)?;
        let mut model = MuscleDynamics::new(&machine.robot)?;
        let poses = machine.start.repeat(self.count);
        let mut lengths = vec![0.0; self.count * model.muscles()];
        let began = std::time::Instant::now();
        for (q, out) in poses.chunks(model.joints()).zip(lengths.chunks_mut(machine.muscles.len())) {
            model.evaluate(q)?;
            out.copy_from_slice(model.lengths());
        }
        Ok(json!(began.elapsed().as_secs_f64()))
    }
}
