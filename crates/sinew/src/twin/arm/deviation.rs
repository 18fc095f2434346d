//! What makes real machines differ from their drawings beside masses, attachments and zeros: frames of
//! joints,
//! centres of mass, radii, eccentric encoders, links that bend, an unknown payload.

use crate::body::{Displacement, JointKind, Parts, Robot};
use crate::drive::JointEncoder;
use crate::machine::{Machine, Tolerances};
use crate::random::Random;
use alloc::vec::Vec;

/// Deviations of one specimen. Every kind has a random stream of its own, so that one does not change the
/// others, nor what is drawn elsewhere.
pub(super) struct Deviation {
    tolerances: Tolerances,
    seed: u64,
}

/// Numbers of the streams.
#[derive(Clone, Copy)]
enum Kind {
    Link = 1,
    Axis,
    CenterOfMass,
    Wrap,
    Winch,
    Eccentricity,
    Flex,
    Payload,
}

impl Deviation {
    pub(super) fn new(tolerances: Tolerances, seed: u64) -> Self {
        Self { tolerances, seed }
    }

    /// Uniform numbers in [-bound, bound).
    fn within(&self, kind: Kind, bound: f64) -> impl FnMut() -> f64 + use<> {
        let mut random = Random::new(self.seed ^ (kind as u64).wrapping_mul(0xD1B5_4A32_D192_ED03));
        move || bound * (2.0 * random.unit() - 1.0)
    }

    /// Frames of joints, centres of mass, radii of wraps, flex of links.
    pub(super) fn of_parts(&self, parts: &mut Parts) {
        let Tolerances { link, axis, center_of_mass, wrap_radius, flex, .. } = self.tolerances;
        if link > 0.0 || axis > 0.0 {
            let (mut offset, mut tilt) = (self.within(Kind::Link, link), self.within(Kind::Axis, axis));
            let mut draw = || Displacement {
                offset: core::array::from_fn(|_| offset()),
                tilt: core::array::from_fn(|_| tilt()),
            };
            let drawn: Vec<Displacement> = parts.joints.iter().map(|_| draw()).collect();
            *parts = parts.displaced(&drawn);
        }
        if center_of_mass > 0.0 {
            let mut shift = self.within(Kind::CenterOfMass, center_of_mass);
            let bodies = parts.bodies.iter_mut().filter(|body| body.mass > 0.0);
            bodies.for_each(|body| body.center_of_mass.iter_mut().for_each(|x| *x += shift()));
        }
        if wrap_radius > 0.0 {
            let mut more = self.within(Kind::Wrap, wrap_radius);
            parts.wraps.iter_mut().for_each(|wrap| {
                wrap.radius = (wrap.radius + more()).max(0.5 * wrap.radius);
            });
        }
        if flex > 0.0 {
            let mut part = self.within(Kind::Flex, 0.5);
            let hinges = parts.joints.iter_mut().filter(|joint| joint.kind == JointKind::Hinge);
            hinges.for_each(|joint| joint.flex += flex * (0.5 + part()));
        }
    }

    /// Eccentric discs of the encoders of hinges; `kinds` are those of the independent joints.
    pub(super) fn of_encoders(
        &self,
        encoders: &mut [Option<JointEncoder>],
        kinds: impl Iterator<Item = JointKind>,
    ) {
        if self.tolerances.eccentricity == 0.0 {
            return;
        }
        let mut part = self.within(Kind::Eccentricity, 1.0);
        for (encoder, kind) in encoders.iter_mut().zip(kinds) {
            let amplitude = 0.5 * (1.0 + part()) * self.tolerances.eccentricity;
            let (sine, cosine) = libm::sincos(core::f64::consts::PI * part());
            if let (Some(encoder), JointKind::Hinge) = (encoder, kind) {
                encoder.eccentricity = [amplitude * cosine, amplitude * sine];
            }
        }
    }

    /// Radius over that of the design of every winch.
    pub(super) fn of_winches(&self, winches: &mut [f64]) {
        if self.tolerances.winch > 0.0 {
            let mut more = self.within(Kind::Winch, self.tolerances.winch);
            winches.iter_mut().for_each(|ratio| *ratio *= 1.0 + more());
        }
    }

    /// With the unknown mass at the end point.
    pub(super) fn loaded(&self, robot: Robot, machine: &Machine) -> Result<Robot, crate::Error> {
        let Some(site) = machine.payload_site().filter(|_| self.tolerances.payload > 0.0) else {
            return Ok(robot);
        };
        let mass = self.tolerances.payload * (0.5 + self.within(Kind::Payload, 0.5)());
        let site = &robot.parts().sites[site];
        robot.with_payload(site.body, site.position, mass)
    }
}

#[cfg(test)]
mod tests {
    use crate::body::{Poses, Robot};
    use crate::machine::{Machine, Tolerances, Workshop};
    use crate::twin::arm::ArmSpecimen;
    use alloc::vec::Vec;

    fn arm() -> Machine {
        let text = include_str!("../../../../../models/lm_arm.toml");
        let parts = crate::description::from_toml("lm_arm.toml", text).unwrap().parts;
        Machine::from_robot(&Robot::new(parts).unwrap()).unwrap()
    }

    fn drawn(tolerances: Tolerances, seed: u64) -> ArmSpecimen {
        ArmSpecimen::draw(&Machine { tolerances, ..arm() }, seed).unwrap()
    }

    #[test]
    fn each_kind_of_deviation_leaves_all_others_as_they_are() {
        let default = Tolerances::default();
        let all = default.of(Workshop::Careful, 1.0);
        let (plain, careful) = (drawn(default, 5), drawn(Tolerances { payload: 0.1, ..all }, 5));
        let axis = drawn(Tolerances { axis: all.axis, ..default }, 5);
        let flex = drawn(Tolerances { flex: all.flex, ..default }, 5);
        let winch = drawn(Tolerances { winch: all.winch, ..default }, 5);
        let kappa = |s: &ArmSpecimen| s.robot.parts().joints.iter().map(|j| j.flex).collect::<Vec<_>>();
        assert!(kappa(&flex) == kappa(&careful) && flex.robot.parts().bodies == plain.robot.parts().bodies);
        assert_eq!((&winch.robot, &winch.winches), (&plain.robot, &careful.winches));
        assert!(axis.robot != plain.robot && axis.cables == plain.cables && axis.encoders == plain.encoders);
        assert!(careful.cables == plain.cables && careful.drives == plain.drives);
        let zeros = |s: &ArmSpecimen| s.encoders.iter().flatten().map(|e| e.zero).collect::<Vec<_>>();
        assert_eq!(zeros(&careful), zeros(&plain));
        let mass = |s: &ArmSpecimen| s.robot.moving_mass();
        assert!((1e-6..0.1).contains(&(mass(&careful) - mass(&plain))));
    }

    #[test]
    fn the_end_point_of_a_rough_arm_is_off_by_a_centimetre_and_of_a_careful_one_by_one_or_two_millimetres() {
        let machine = arm();
        let site = machine.task.site().unwrap();
        for (workshop, expected) in [(Workshop::Careful, 0.6e-3..4e-3), (Workshop::Rough, 5e-3..25e-3)] {
            let built = machine.clone().built_by(workshop);
            let (mut sum, mut count) = (0.0, 0.0);
            for seed in 0..10 {
                let specimen = ArmSpecimen::draw(&built, seed).unwrap();
                let mut poses = Poses::new(&machine.robot);
                for reading in machine.poses(10).unwrap() {
                    machine.robot.forward_kinematics(&reading, &mut poses).unwrap();
                    let design = machine.robot.site_pose(&poses, site).origin;
                    let encoders = specimen.encoders.iter().flatten();
                    let q: Vec<f64> = reading.iter().zip(encoders).map(|(r, e)| r - e.error(*r)).collect();
                    specimen.robot.bent_kinematics(&q, &mut poses).unwrap();
                    let real = specimen.robot.site_pose(&poses, site).origin;
                    sum += (0..3).map(|k| (real[k] - design[k]).powi(2)).sum::<f64>().sqrt();
                    count += 1.0;
                }
            }
            assert!(expected.contains(&(sum / count)), "{workshop:?}: {} m", sum / count);
        }
    }
}
