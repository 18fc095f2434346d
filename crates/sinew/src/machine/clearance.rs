use super::design::Machine;
use crate::Error;
use crate::body::{PathElement, Poses, Robot, TendonPath, WrapKind, vector};
use alloc::vec::Vec;

/// How far a site of a tendon stands clear of the surface that the tendon wraps next to it.
///
/// ```text
/// sphere:    clearance = |p| - r,                  displacement <= sqrt(3) a + b
/// cylinder:  clearance = sqrt(p_x^2 + p_y^2) - r,  displacement <= sqrt(2) a + b
/// ```
///
/// | symbol | meaning                                                            | unit |
/// |--------|--------------------------------------------------------------------|------|
/// | p      | position of the site from the surface's centre, z along the cylinder | m    |
/// | r      | radius                                                             | m    |
/// | a, b   | [`Machine::attachment_tolerance`], of every coordinate; that of the radius | m    |
///
/// A tendon does not wrap a surface that one of its sites beside it lies within (`mujoco2012`): its length
/// and its moment arms jump.
#[derive(Debug, Clone, PartialEq)]
pub struct Clearance {
    /// Index of the muscle.
    pub muscle: usize,
    /// Index of the site.
    pub site: usize,
    /// Index of the surface.
    pub wrap: usize,
    /// Smallest of some poses, m; negative within the surface.
    pub least: f64,
    /// By which the tolerance may lessen it, m.
    pub displacement: f64,
    /// Index of the pose of the least; none where it is the same in all of them.
    pub pose: Option<usize>,
}

/// By which a constant clearance differs between poses, m.
const ROUNDING: f64 = 1e-9;

impl Clearance {
    /// Whether a machine within its tolerances may lose the wrap.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.least <= self.displacement
    }
}

impl Machine {
    /// Of every site beside a wrapping surface on a tendon's path, over some poses: `[places][joints]`.
    ///
    /// # Errors
    /// As [`Robot::pose_from_independent`] and [`Robot::forward_kinematics`].
    pub fn clearances(&self, poses: &[Vec<f64>]) -> Result<Vec<Clearance>, Error> {
        let parts = self.robot.parts();
        let mut found = Vec::new();
        for (muscle, tendon) in parts.tendons.iter().enumerate() {
            let TendonPath::Spatial(elements) = &tendon.path else { continue };
            for (site, wrap) in neighbours(elements) {
                let axes = if parts.wraps[wrap].kind == WrapKind::Sphere { 3.0 } else { 2.0 };
                let displacement =
                    libm::sqrt(axes) * self.attachment_tolerance() + self.tolerances.wrap_radius;
                found.push(Clearance { muscle, site, wrap, least: f64::INFINITY, displacement, pose: None });
            }
        }
        let mut placed = Poses::new(&self.robot);
        for (index, pose) in poses.iter().enumerate() {
            self.robot.forward_kinematics(&self.robot.pose_from_independent(pose)?, &mut placed)?;
            for clearance in &mut found {
                let here = clearance_of(&self.robot, &placed, clearance.site, clearance.wrap);
                if index == 0 {
                    clearance.least = here;
                } else if (here - clearance.least).abs() > ROUNDING {
                    let before = clearance.pose.unwrap_or(0);
                    clearance.pose = Some(if here < clearance.least { index } else { before });
                    clearance.least = clearance.least.min(here);
                }
            }
        }
        Ok(found)
    }
}

/// The sites before and after every surface of a path, each pair once.
fn neighbours(elements: &[PathElement]) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    let mut push = |pair| {
        if !pairs.contains(&pair) {
            pairs.push(pair);
        }
    };
    for window in elements.windows(2) {
        match *window {
            [PathElement::Site(site), PathElement::Wrap { wrap, .. }]
            | [PathElement::Wrap { wrap, .. }, PathElement::Site(site)] => push((site, wrap)),
            _ => {}
        }
    }
    pairs
}

fn clearance_of(robot: &Robot, poses: &Poses, site: usize, wrap: usize) -> f64 {
    let surface = poses.of(&robot.wrap_place(wrap));
    let from_centre = vector::sub(robot.site_pose(poses, site).origin, surface.origin);
    let [x, y, z] = vector::unrotate(&surface.axes, from_centre);
    let part = &robot.parts().wraps[wrap];
    let square = match part.kind {
        WrapKind::Sphere => x * x + y * y + z * z,
        WrapKind::Cylinder => x * x + y * y,
    };
    libm::sqrt(square) - part.radius
}
