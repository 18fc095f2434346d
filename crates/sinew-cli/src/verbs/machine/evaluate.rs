//! `sinew machine evaluate`: lengths, moment arms, wrap angles, gravity forces and site positions of a robot
//! in given poses, as CSV or JSON.
//!
//! One row per pose, with these columns:
//!
//! | column | unit | shape | meaning |
//! |---|---|---|---|
//! | `length_m:MUSCLE` | m | `[muscles]` | length of the cable between first and last site |
//! | `moment_arm_m:MUSCLE:JOINT` | m; 1 for a translation | `[muscles x nv]`, row by row | `R = -dl/dq` |
//! | `wrap_rad:MUSCLE` | rad | `[muscles]` | wrap angle, the sum over the surfaces |
//! | `gravity_torque_nm:JOINT` | Nm; N for a translation | `[nv]` | `g(q)`, balances gravity less what holds bodies |
//! | `x_m:SITE`, `y_m:SITE`, `z_m:SITE` | m | `[sites x 3]` | position in the world frame |

use super::names::{display_name, print_warnings};
use super::poses::{read_poses, velocity_names};
use crate::answer::{Answer, Content};
use crate::arguments::{General, MachineEvaluateArguments};
use crate::csv_text::Csv;
use crate::error::Error;
use crate::output::{refuse_overwrite, write_all};
use serde_json::{Map, Value};
use sinew::body::{Poses, Robot, Scratch};
use sinew::muscle::{Geometry, Muscles};
use sinew_lab::machine_file::load_robot;

pub(crate) fn run(arguments: &MachineEvaluateArguments, general: &General) -> Result<Answer, Error> {
    let inputs = [&arguments.model, &arguments.poses].into_iter().chain(&arguments.files.muscles);
    refuse_overwrite(inputs, arguments.out.as_slice(), general.no_clobber)?;
    let loaded = load_robot(
        &arguments.model,
        arguments.files.muscles.as_deref(),
        arguments.files.root.dir.as_deref(),
    )?;
    print_warnings(&loaded.warnings);
    let poses = read_poses(&loaded.robot, &arguments.poses)?;
    let names = columns(&loaded.robot);
    let rows = rows(&loaded.robot, &poses)?;
    let table = table(&names, &rows)?;
    let written = match &arguments.out {
        Some(out) => write_all(&[(out.clone(), table.as_bytes())])?,
        None => Vec::new(),
    };
    let content = match &arguments.out {
        _ if general.json => Content::json(&serde_json::json!({ "poses": objects(&names, &rows) }))?,
        Some(_) => Content::Text(format!("{} poses\n", rows.len())),
        None => Content::Text(table),
    };
    Ok(Answer::done(content, written))
}

/// One object per pose, by the names of the columns.
fn objects(names: &[String], rows: &[Vec<f64>]) -> Vec<Map<String, Value>> {
    rows.iter().map(|row| names.iter().cloned().zip(row.iter().map(|&x| Value::from(x))).collect()).collect()
}

fn table(names: &[String], rows: &[Vec<f64>]) -> Result<String, Error> {
    let mut table = Csv::new();
    table.row(names)?;
    for row in rows {
        table.row(row.iter().map(ToString::to_string))?;
    }
    table.text()
}

/// Names of the columns, in the order of a row of [`rows`].
fn columns(robot: &Robot) -> Vec<String> {
    let parts = robot.parts();
    let muscles: Vec<String> =
        parts.tendons.iter().enumerate().map(|(i, tendon)| display_name("tendon", &tendon.name, i)).collect();
    let joints = velocity_names(robot);
    let mut names: Vec<String> = muscles.iter().map(|muscle| format!("length_m:{muscle}")).collect();
    for muscle in &muscles {
        names.extend(joints.iter().map(|joint| format!("moment_arm_m:{muscle}:{joint}")));
    }
    names.extend(muscles.iter().map(|muscle| format!("wrap_rad:{muscle}")));
    names.extend(joints.iter().map(|joint| format!("gravity_torque_nm:{joint}")));
    for (index, site) in parts.sites.iter().enumerate() {
        let site = display_name("site", &site.name, index);
        names.extend(["x", "y", "z"].map(|axis| format!("{axis}_m:{site}")));
    }
    names
}

/// One row of numbers per pose, `poses: [poses][nq]`, in rad or m.
fn rows(robot: &Robot, poses: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, Error> {
    let muscles = Muscles::new(robot);
    let mut geometry = Geometry::new(robot, &muscles);
    let (mut scratch, mut frames) = (Scratch::new(robot), Poses::new(robot));
    let mut arms = vec![0.0; muscles.count() * robot.nv()];
    let mut angles = vec![0.0; muscles.count()];
    let (mut torques, mut held) = (vec![0.0; robot.nv()], vec![0.0; robot.nv()]);
    let mut rows = Vec::new();
    for q in poses {
        muscles.evaluate(q, &mut geometry)?;
        muscles.dense(&geometry, &mut arms)?;
        muscles.wrap_angles(&geometry, &mut angles)?;
        robot.forward_kinematics(q, &mut frames)?;
        robot.gravity_force(q, &mut scratch, &mut torques)?;
        robot.gravity_compensation(&frames, &mut held)?;
        torques.iter_mut().zip(&held).for_each(|(torque, held)| *torque -= held);
        let mut row = geometry.lengths().to_vec();
        row.extend(&arms);
        row.extend(&angles);
        row.extend(&torques);
        for site in 0..robot.parts().sites.len() {
            row.extend(robot.site_pose(&frames, site).origin);
        }
        rows.push(row);
    }
    Ok(rows)
}
