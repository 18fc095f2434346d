//! A self-contained page: moment arms over each joint's range, and a three-dimensional view of the robot.

use super::model::display_name;
use super::poses::{apply_couplings, velocity_names};
use super::survey::{Survey, coupled_reference_pose, joint_range};
use super::view::view_data;
use crate::error::Error;
use sinew::body::{JointKind, Robot};
use sinew::muscle::{Geometry, Muscles};

/// Points of a curve.
const CURVE_POINTS: usize = 61;
/// Curves with smaller moment arms everywhere are not drawn, m.
const MIN_ARM_M: f64 = 1e-6;

const PAGE: &str = include_str!("../../../assets/arm.html");

pub(super) fn page(robot: &Robot, survey: &Survey) -> Result<String, Error> {
    let muscles: Vec<_> = survey
        .muscles
        .iter()
        .map(|m| {
            serde_json::json!([
                m.name,
                m.length_m,
                m.travel_m(),
                m.strongest,
                m.arm_m[0],
                m.arm_m[1],
                m.wrap_rad[0],
                m.wrap_rad[1]
            ])
        })
        .collect();
    let data = serde_json::json!({"name": robot.parts().name, "mass_kg": robot.moving_mass(),
        "muscles": muscles, "curves": curves(robot)?, "view": view_data(robot)?});
    // `<` could close the script element.
    let data = serde_json::to_string(&data)?.replace('<', "\\u003c");
    Ok(PAGE.replace("/*DATA*/null", &data))
}

/// For every joint of one coordinate: its values, and the moment arms about it of the muscles that cross it.
fn curves(robot: &Robot) -> Result<Vec<serde_json::Value>, Error> {
    let muscles = Muscles::new(robot);
    let mut geometry = Geometry::new(robot, &muscles);
    let (count, nv) = (muscles.count(), robot.nv());
    let mut dense = vec![0.0; count * nv];
    let (rest, names) = (coupled_reference_pose(robot), velocity_names(robot));
    let mut curves = Vec::new();
    for joint in 0..robot.parts().joints.len() {
        let follows = robot.parts().couplings.iter().any(|coupling| coupling.follower == joint);
        let Some([low, high]) = joint_range(robot, joint).filter(|_| !follows) else { continue };
        let (coordinate, velocity) = (robot.coordinates_of(joint).start, robot.velocities_of(joint).start);
        let mut at = Vec::new();
        let mut arms = vec![Vec::new(); count];
        for k in 0..CURVE_POINTS {
            let mut q = rest.clone();
            #[expect(clippy::cast_precision_loss, reason = "a few dozen points")]
            let part = k as f64 / (CURVE_POINTS - 1) as f64;
            q[coordinate] = low + part * (high - low);
            apply_couplings(robot, &[], &mut q);
            at.push(q[coordinate]);
            muscles.evaluate(&q, &mut geometry)?;
            muscles.dense(&geometry, &mut dense)?;
            (0..count).for_each(|m| arms[m].push(dense[m * nv + velocity]));
        }
        let seen: Vec<_> = robot
            .parts()
            .tendons
            .iter()
            .enumerate()
            .zip(arms)
            .filter(|(_, arm)| arm.iter().any(|x| x.abs() > MIN_ARM_M))
            .map(|((i, tendon), arm)| serde_json::json!([display_name("tendon", &tendon.name, i), arm]))
            .collect();
        if !seen.is_empty() {
            let slides = robot.parts().joints[joint].kind == JointKind::Slide;
            let unit = if slides { "m" } else { "rad" };
            curves.push(serde_json::json!({"joint": names[velocity], "unit": unit, "at": at, "arms": seen}));
        }
    }
    Ok(curves)
}
