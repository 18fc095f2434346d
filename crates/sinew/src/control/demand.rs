//! What a motion demands of the drives of a machine.

use crate::Error;
use crate::control::arm::tension_limits;
use crate::control::tension::{Distribution, Problem, Status};
use crate::error::{positive, within};
use crate::machine::Machine;
use crate::muscle::MuscleDynamics;
use crate::random::EvenPoints;
use crate::trajectory::{ControllableMotion, Equilibrium};
use crate::transmission::cable::CableLaw;
use alloc::vec;
use alloc::vec::Vec;

/// A motion of every joint by which drives are sized.
///
/// ```text
/// q_j = m_j + s w_j/2 sin(2 pi t/T + p_j)
/// ```
///
/// | symbol | field    | unit | domain | meaning                                             |
/// |--------|----------|------|--------|-----------------------------------------------------|
/// | T      | `period` | s    | > 0    | of every joint                                      |
/// | s      | `fraction`  | 1    | (0, 1] | fraction of the joint's range that the motion covers    |
/// | m, w   |          | rad or m |    | middle and width of the joint's range                |
/// | p      |          | rad  |        | any phases: every combination of phases has to be possible |
///
/// The ranges are [`Machine::ranges`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SizingMotion {
    /// s, > 0.
    pub period: f64,
    /// 1, in (0, 1].
    pub fraction: f64,
}

/// Largest demand on one drive over a motion, at the cable.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriveDemand {
    /// Tension at the drive's outlet while it winds in cable, N.
    pub tension: f64,
    /// Speed, m/s.
    pub speed: f64,
    /// Acceleration, m/s^2.
    pub acceleration: f64,
    /// Difference between the greatest and the smallest length of the muscle over the ranges of all joints,
    /// and the stretch of the cable under the largest tension, m.
    pub stroke: f64,
}

/// Demands on all drives of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveDemands {
    /// `[muscles]`.
    pub muscles: Vec<DriveDemand>,
    /// Sampled instants at which no tensions from the smallest on give the torque, whatever the drives.
    pub unreachable: usize,
    /// Those of them at which smaller tensions would.
    pub overpowered: usize,
    /// The largest missing torque.
    pub missing: Option<MissingTorque>,
    /// All sampled instants.
    pub samples: usize,
}

/// A torque that no tensions give.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MissingTorque {
    /// Independent joint.
    pub joint: usize,
    /// Nm or N.
    pub torque: f64,
    /// The muscle whose smallest tension pulls most against it, that tension, N, and its moment arm, m; none
    /// where no muscle does.
    pub against: Option<(usize, f64, f64)>,
}

/// Cells of a cable.
const CELLS: usize = 8;
/// Sampled instants.
const SAMPLES: usize = 400;
/// Largest tension that is considered, N: none.
const MAX_TENSION: f64 = 1e6;

/// Demands on the drives of a machine by a motion with its payload, from inverse dynamics and the
/// distribution of minimum tensions.
///
/// # Assumes
/// Friction of a cable is that of sliding toward the drive, `T_in = (T_out - T_0) e^A`, at the largest
/// demand. Of a machine with fewer motors than joints, springs and weight take the joints where they stand at
/// these lengths of the cables, and only what the cables control moves.
///
/// # Errors
/// [`Error::OutOfDomain`] for a motion outside its domain; as [`Machine::validate`].
pub fn drive_demands(machine: &Machine, motion: &SizingMotion) -> Result<DriveDemands, Error> {
    positive("period", motion.period)?;
    within(
        "fraction",
        "a number in (0, 1]",
        motion.fraction,
        motion.fraction > 0.0 && motion.fraction <= 1.0,
    )?;
    let machine = &machine.loaded()?;
    let mut dynamics = MuscleDynamics::new(&machine.robot)?;
    let start = machine.laws(CELLS)?;
    let mut laws = start.clone();
    let bends = machine.sheath_bends()?;
    let minimum: Vec<f64> = tension_limits(machine, &laws).iter().map(|[least, _]| *least).collect();
    let mut sampler = Sampler::new(machine, motion)?;
    // Less than its minimum tension no muscle is ever asked for.
    let least = minimum
        .iter()
        .zip(&laws)
        .map(|(least, law)| DriveDemand { tension: near_tension(*least, law), ..DriveDemand::default() });
    let least = least.collect();
    let mut equilibrium = Equilibrium::new(&machine.robot)?;
    let coordinates = equilibrium.as_ref().map_or(machine.encoders.len(), |found| found.motion().count());
    let mut torques = Torques::new(minimum, machine.encoders.len(), coordinates);
    let mut demands =
        DriveDemands { muscles: least, unreachable: 0, overpowered: 0, missing: None, samples: SAMPLES };
    for _ in 0..SAMPLES {
        let [mut q, mut v, mut a] = sampler.next();
        if let Some(equilibrium) = &mut equilibrium {
            if equilibrium.settle(&mut q)?.is_some() {
                demands.unreachable += 1;
                continue;
            }
            let mut motion = equilibrium.motion().clone();
            motion.project(&mut v);
            motion.project(&mut a);
        }
        dynamics.evaluate(&q)?;
        for ((law, bend), start) in laws.iter_mut().zip(&bends).zip(&start) {
            if !bend.is_constant() {
                *law = start.clone().with_sheath_bend(bend.at(&q))?;
            }
        }
        let motion = equilibrium.as_ref().map(Equilibrium::motion);
        torques.include(&mut dynamics, motion, [&v, &a], &laws, &mut demands)?;
    }
    let strokes = strokes(machine, &mut dynamics)?;
    for ((demand, stroke), law) in demands.muscles.iter_mut().zip(strokes).zip(&laws) {
        demand.stroke = stroke + demand.tension * law.compliance().iter().sum::<f64>();
    }
    Ok(demands)
}

/// Tension at the drive that pulls its cable in against this tension at the anchor, N.
fn near_tension(anchor: f64, law: &CableLaw) -> f64 {
    (anchor - law.pretension()).max(0.0) * libm::exp(law.friction_angle())
}

/// Instants of the motion at any phases of all joints.
struct Sampler {
    middle: Vec<f64>,
    amplitude: Vec<f64>,
    rate: f64,
    points: EvenPoints,
}

impl Sampler {
    fn new(machine: &Machine, motion: &SizingMotion) -> Result<Self, Error> {
        let ranges = machine.ranges()?;
        Ok(Self {
            middle: ranges.iter().map(|[low, high]| 0.5 * (low + high)).collect(),
            amplitude: ranges.iter().map(|[low, high]| 0.5 * motion.fraction * (high - low)).collect(),
            rate: 2.0 * core::f64::consts::PI / motion.period,
            points: EvenPoints::new(ranges.len()),
        })
    }

    /// Coordinates, velocities and accelerations of the independent joints.
    fn next(&mut self) -> [Vec<f64>; 3] {
        let mut state = [vec![], vec![], vec![]];
        let point = self.points.next().into_iter().flatten();
        for ((middle, amplitude), fraction) in self.middle.iter().zip(&self.amplitude).zip(point) {
            let phase = 2.0 * core::f64::consts::PI * fraction;
            let (sine, cosine) = (libm::sin(phase), libm::cos(phase));
            state[0].push(middle + amplitude * sine);
            state[1].push(amplitude * self.rate * cosine);
            state[2].push(-amplitude * self.rate * self.rate * sine);
        }
        state
    }
}

/// Minimum tensions for the torque of an instant.
struct Torques {
    distribution: Distribution,
    minimum: Vec<f64>,
    maximum: Vec<f64>,
    zeros: Vec<f64>,
    ones: Vec<f64>,
    torque: Vec<f64>,
    /// Of the coordinates that the cables control.
    along: Vec<f64>,
    motion: Vec<f64>,
}

impl Torques {
    fn new(minimum: Vec<f64>, joints: usize, coordinates: usize) -> Self {
        let muscles = minimum.len();
        Self {
            distribution: Distribution::new(muscles, coordinates),
            minimum,
            maximum: vec![MAX_TENSION; muscles],
            zeros: vec![0.0; muscles],
            ones: vec![1.0; muscles],
            torque: vec![0.0; joints],
            along: vec![0.0; coordinates],
            motion: vec![0.0; muscles],
        }
    }

    fn include(
        &mut self,
        dynamics: &mut MuscleDynamics,
        controllable: Option<&ControllableMotion>,
        [v, a]: [&[f64]; 2],
        laws: &[CableLaw],
        demands: &mut DriveDemands,
    ) -> Result<(), Error> {
        dynamics.inverse_dynamics(v, a, &mut self.torque)?;
        match controllable {
            Some(motion) => motion.torque(&self.torque, &mut self.along),
            None => self.along.copy_from_slice(&self.torque),
        }
        let moment_arms = controllable.map_or(dynamics.moment_arms(), ControllableMotion::arms);
        let solution = self.distribution.solve(&Problem {
            moment_arms,
            torque: &self.along,
            minimum: &self.minimum,
            maximum: &self.maximum,
            reference: &self.zeros,
            weight: &self.ones,
        })?;
        if solution.status == Status::Optimal {
            for ((demand, tension), law) in demands.muscles.iter_mut().zip(solution.tension).zip(laws) {
                demand.tension = demand.tension.max(near_tension(*tension, law));
            }
        } else {
            demands.unreachable += 1;
            for (k, torque) in solution.residual.iter().enumerate() {
                if demands.missing.is_none_or(|missing| torque.abs() > missing.torque.abs()) {
                    let against = against(moment_arms, &self.minimum, (k, *torque), self.along.len());
                    let joint = controllable.map_or(k, |motion| moved_most(motion, k));
                    demands.missing = Some(MissingTorque { joint, torque: *torque, against });
                }
            }
            let solution = self.distribution.solve(&Problem {
                moment_arms,
                torque: &self.along,
                minimum: &self.zeros,
                maximum: &self.maximum,
                reference: &self.zeros,
                weight: &self.ones,
            })?;
            demands.overpowered += usize::from(solution.status == Status::Optimal);
        }
        dynamics.anchor_motion(v, &mut self.motion);
        for (demand, speed) in demands.muscles.iter_mut().zip(&self.motion) {
            demand.speed = demand.speed.max(speed.abs());
        }
        dynamics.anchor_motion(a, &mut self.motion);
        for (demand, acceleration) in demands.muscles.iter_mut().zip(&self.motion) {
            demand.acceleration = demand.acceleration.max(acceleration.abs());
        }
        Ok(())
    }
}

/// The joint that a controllable coordinate moves most.
fn moved_most(motion: &ControllableMotion, coordinate: usize) -> usize {
    let joints = motion.motion().len() / motion.count();
    let row = motion.motion().chunks_exact(joints).nth(coordinate).unwrap_or_default();
    let most = row.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    most.map_or(0, |(joint, _)| joint)
}

/// The muscle whose smallest tension pulls most against the torque that is missing at a joint.
fn against(
    moment_arms: &[f64],
    minimum: &[f64],
    (joint, torque): (usize, f64),
    joints: usize,
) -> Option<(usize, f64, f64)> {
    let arms = moment_arms.chunks_exact(joints).zip(minimum).enumerate();
    let pulls = arms.map(|(muscle, (row, tension))| (muscle, *tension, row[joint]));
    let wrong = pulls.filter(|(_, tension, arm)| tension * arm * torque < 0.0);
    wrong.max_by(|a, b| (a.1 * a.2).abs().total_cmp(&(b.1 * b.2).abs()))
}

/// Travel of every muscle over the ranges of all joints, m.
fn strokes(machine: &Machine, dynamics: &mut MuscleDynamics) -> Result<Vec<f64>, Error> {
    let ranges = machine.ranges()?;
    let mut travel = vec![[f64::INFINITY, f64::NEG_INFINITY]; machine.muscles.len()];
    for (sample, point) in EvenPoints::new(ranges.len()).take(SAMPLES).enumerate() {
        // Half of them at corners of the ranges, where lengths are extreme.
        let fraction = |fraction: f64| if sample % 2 == 0 { fraction } else { libm::rint(fraction) };
        let q: Vec<f64> =
            ranges.iter().zip(point).map(|([low, high], x)| low + fraction(x) * (high - low)).collect();
        dynamics.evaluate(&q)?;
        for ([least, most], length) in travel.iter_mut().zip(dynamics.lengths()) {
            (*least, *most) = (least.min(*length), most.max(*length));
        }
    }
    Ok(travel.into_iter().map(|[least, most]| most - least).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{JointKind, PathElement, Robot, Site, TendonPath};
    use crate::control::tests::{Slide, slides};

    /// So slow that nothing accelerates.
    const SLOW: SizingMotion = SizingMotion { period: 1e4, fraction: 1.0 };
    const UP: [f64; 3] = [0.0, 0.0, 1.0];

    fn machine(gravity: f64, ranges: &[[f64; 2]], arms: &[&[f64]]) -> Machine {
        let slide = |range: &[f64; 2]| Slide { axis: UP, mass: 2.0, range: *range };
        let along: Vec<Slide> = ranges.iter().map(slide).collect();
        let mut machine = Machine::from_robot(&slides(gravity, &along, arms)).unwrap();
        machine.muscles.iter_mut().for_each(|design| design.tension = [Some(20.0), None]);
        machine
    }

    #[test]
    fn a_share_of_nothing_and_one_beyond_the_range_are_refused() {
        let machine = machine(0.0, &[[-0.1, 0.1]], &[&[1.0], &[-1.0]]);
        for fraction in [0.0, -0.5, 1.0 + 1e-9, f64::NAN] {
            assert!(drive_demands(&machine, &SizingMotion { fraction, ..SLOW }).is_err(), "{fraction}");
        }
        assert!(drive_demands(&machine, &SizingMotion { fraction: 1.0, ..SLOW }).is_ok());
    }

    #[test]
    fn where_cables_only_pull_with_the_weight_the_larger_torque_is_missing_and_they_are_kept_tight() {
        // Two weights on each other; cables pull both down, the upper one by the higher arm.
        let machine = machine(9.81, &[[-0.1, 0.1]; 2], &[&[-1.0, 0.0], &[0.0, -3.0]]);
        let demands = drive_demands(&machine, &SLOW).unwrap();
        assert_eq!(demands.unreachable, demands.samples);
        assert_eq!(demands.overpowered, 0, "smaller tensions lift no weight");
        let missing = demands.missing.unwrap();
        // 4 kg and 20 N are missing at the lower slide, 2 kg and 60 N at the upper one.
        assert_eq!((missing.joint, missing.against), (1, Some((1, 20.0, -3.0))));
        assert!((missing.torque - (2.0 * 9.81 + 60.0)).abs() < 3e-7, "{missing:?}");
        for (demand, law) in demands.muscles.iter().zip(machine.laws(CELLS).unwrap()) {
            let tension = (20.0 - law.pretension()) * libm::exp(law.friction_angle());
            assert!((demand.tension - tension).abs() < 1e-14, "{} {tension}", demand.tension);
        }
    }

    #[test]
    fn a_weight_that_the_smallest_tension_of_its_cable_lifts_off_is_overpowered_and_the_cable_named() {
        // A cable lifts each of two weights, nothing but the weight pulls down.
        let arms: &[&[f64]] = &[&[1.0, 0.0], &[0.0, 1.0]];
        for (smallest, overpowered) in [(1.0, false), (19.0, false), (25.0, true)] {
            let mut machine = machine(9.81, &[[-0.1, 0.1]; 2], arms);
            machine.muscles.iter_mut().for_each(|design| design.tension = [Some(smallest), None]);
            let demands = drive_demands(&machine, &SLOW).unwrap();
            assert_eq!(demands.overpowered > 0, overpowered, "{smallest}");
            assert_eq!(demands.overpowered, demands.unreachable);
            if overpowered {
                // 25 N lift the upper weight of 19.62 N.
                let missing = demands.missing.unwrap();
                assert_eq!((missing.joint, missing.against), (1, Some((1, 25.0, 1.0))));
                assert!((missing.torque + 25.0 - 19.62).abs() < 1e-6, "{missing:?}");
            }
        }
    }

    #[test]
    fn a_sheath_that_the_joints_bend_demands_the_friction_of_its_largest_bend() {
        let mut machine = machine(0.0, &[[-0.1, 0.3]], &[&[1.0], &[-1.0]]);
        machine.muscles[0].bend_by_joint = vec![2.0];
        let demands = drive_demands(&machine, &SLOW).unwrap();
        let law = &machine.laws(CELLS).unwrap()[0];
        // By 0.3 m a bend of 0.6 rad more than in the start.
        let largest = law.friction_angle() + machine.muscles[0].cable.friction * 0.6;
        let tension = |angle: f64| (20.0 - law.pretension()) * libm::exp(angle);
        let [bent, straight] = [0, 1].map(|muscle| demands.muscles[muscle].tension);
        assert!((bent / tension(largest) - 1.0).abs() < 5e-7, "{bent} {}", tension(largest));
        assert!((straight / tension(law.friction_angle()) - 1.0).abs() < 7e-8);
    }

    #[test]
    fn samples_are_instants_of_sines_of_evenly_spread_phases() {
        let machine = machine(0.0, &[[-0.1, 0.3], [-0.2, 0.2]], &[&[1.0, 1.0], &[-1.0, -1.0]]);
        let motion = SizingMotion { period: 3.0, fraction: 0.5 };
        let rate = core::f64::consts::TAU / 3.0;
        let mut sampler = Sampler::new(&machine, &motion).unwrap();
        let mut means = [[0.0; 2]; 2];
        for _ in 0..1000 {
            let [q, v, a] = sampler.next();
            for (j, middle) in [0.1, 0.0].into_iter().enumerate() {
                // A fraction of 0.5 of 0.4 m is an amplitude of 0.1 m.
                let (sine, cosine) = ((q[j] - middle) / 0.1, v[j] / (0.1 * rate));
                assert!((sine * sine + cosine * cosine - 1.0).abs() < 1e-15);
                assert!((a[j] + 0.1 * rate * rate * sine).abs() < 4e-16);
                means[j][0] += sine / 1000.0;
                means[j][1] += cosine / 1000.0;
            }
        }
        assert!(means.as_flattened().iter().all(|mean| mean.abs() < 7e-4), "{means:?}");
    }

    /// A hinge on the first slide's place with a cable from its lever of 0.1 m to a point at 0.3 m.
    fn hinge(range: [f64; 2]) -> Machine {
        let mut parts = slides(0.0, &[Slide { axis: UP, mass: 2.0, range }], &[&[1.0]]).parts().clone();
        (parts.joints[0].kind, parts.joints[0].axis) = (JointKind::Hinge, [0.0, 1.0, 0.0]);
        let site = |name: &str, body: usize, x: f64| Site {
            name: name.into(),
            body,
            position: [x, 0.0, 0.0],
            orientation: [1.0, 0.0, 0.0, 0.0],
            active: None,
        };
        parts.sites = vec![site("anchor", 1, 0.1), site("sheath", 0, 0.3)];
        parts.tendons[0].path = TendonPath::Spatial(vec![PathElement::Site(1), PathElement::Site(0)]);
        Machine::from_robot(&Robot::new(parts).unwrap()).unwrap()
    }

    #[test]
    fn the_stroke_is_from_the_shortest_to_the_longest_within_the_range_and_the_stretch() {
        let length = |q: f64| libm::sqrt(0.01 + 0.09 - 0.06 * libm::cos(q));
        // Shortest within the range, off its middle; longest at an end of it.
        for (range, shortest, longest) in
            [([-1.0, 0.5], length(0.0), length(1.0)), ([0.2, 1.2], length(0.2), length(1.2))]
        {
            let machine = hinge(range);
            let demand = drive_demands(&machine, &SizingMotion { fraction: 0.5, ..SLOW }).unwrap().muscles[0];
            let compliance: f64 = machine.laws(CELLS).unwrap()[0].compliance().iter().sum();
            let stroke = longest - shortest + demand.tension * compliance;
            assert!((demand.stroke - stroke).abs() < 2e-6, "{} {stroke}", demand.stroke);
        }
    }
}
