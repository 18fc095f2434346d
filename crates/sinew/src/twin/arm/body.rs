use crate::Error;
use crate::body::{JointKind, Poses, Robot, Scratch, cholesky};
use crate::dispatch::{Arithmetic, InstructionSet, Work};
use crate::lanes::{Mask, Row};
use crate::muscle::{MuscleDynamics, MuscleWorlds};
use alloc::vec;
use alloc::vec::Vec;

/// Stiffness of the stops of a hinge, Nm/rad, and of a slide, N/m; assumed: rubber on a short lever.
const STOP_STIFFNESS: [f64; 2] = [300.0, 3e5];
/// Largest product of step and natural frequency of a joint on its stops, 1.
const STOP_STEP_ANGLE: f64 = 0.5;
/// `zeta_s`, damping ratio of the same, 1.
const STOP_DAMPING: f64 = 0.3;

/// The rigid bodies of a machine under cable tensions, in the coordinates of its independent joints.
///
/// ```text
/// M v' = R^T T_out - c - g - springs - damping - stops
/// v <- v + h v',   q <- q + h v                    semi-implicit
/// stop:  -k x - 2 zeta_s sqrt(k I) v,   x beyond the range,   k = min(k_s, I (0.5/h)^2),   I = 1/(M^-1)_jj at the start
/// ```
///
/// A cable whose far end sticks is a spring on the joint's inertia. Semi-implicit steps are stable up to 2/h
/// and conserve energy in the mean; [`ArmSpecimen`](super::ArmSpecimen) chooses their number. A light joint
/// has softer stops, whose mode these steps integrate, too.
#[derive(Debug, Clone)]
pub(super) struct Limb {
    model: MuscleDynamics,
    /// Whether the model is that of the present pose: others move the limb, too.
    evaluated: bool,
    joints: Joints<1>,
    /// From sheath end to anchor, m: `[muscles]`.
    pub(super) lengths: Vec<f64>,
    /// `phi(q)`, rad: `[muscles]`.
    pub(super) bends: Vec<f64>,
}

/// Motion of the independent joints of several worlds, and what acts on them beside the muscles.
#[derive(Debug, Clone)]
struct Joints<const N: usize> {
    q: Vec<[f64; N]>,
    v: Vec<[f64; N]>,
    a: Vec<[f64; N]>,
    /// From outside, Nm or N.
    push: Vec<[f64; N]>,
    /// From outside and of the stops.
    force: Vec<[f64; N]>,
    stops: Vec<Stop<N>>,
}

/// The stops of a joint; one without a range ends at infinity.
#[derive(Debug, Clone, Copy, Default)]
struct Stop<const N: usize> {
    /// rad or m.
    low: Row<N>,
    high: Row<N>,
    /// Nm/rad or N/m.
    stiffness: Row<N>,
    /// Nm s/rad or N s/m.
    damping: Row<N>,
}

impl Limb {
    /// At rest with these coordinates of the independent joints, for steps of `h` s.
    pub(super) fn new(robot: &Robot, q: &[f64], h: f64) -> Result<Self, Error> {
        let mut model = MuscleDynamics::new(robot)?;
        let n = model.joints();
        model.evaluate(q)?;
        let mut factor = vec![0.0; n * n];
        model.mass_matrix(&mut factor)?;
        cholesky::factor(&mut factor, n)?;
        let joints = robot.independent_joints();
        let stop = |(j, joint): (usize, usize)| {
            let mut unit = vec![0.0; n];
            unit[j] = 1.0;
            cholesky::solve_lower(&factor, &mut unit);
            let inertia = 1.0 / unit.iter().map(|x| x * x).sum::<f64>();
            let joint = &robot.parts().joints[joint];
            let firm = STOP_STIFFNESS[usize::from(joint.kind == JointKind::Slide)];
            let stiffness = firm.min(inertia * (STOP_STEP_ANGLE / h) * (STOP_STEP_ANGLE / h));
            let damping = 2.0 * STOP_DAMPING * libm::sqrt(stiffness * inertia);
            let [low, high] = joint.range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            Stop { low: Row([low]), high: Row([high]), stiffness: Row([stiffness]), damping: Row([damping]) }
        };
        let stops = joints.into_iter().enumerate().map(stop).collect();
        let mut joints = Joints::new(n, stops);
        joints.q.as_flattened_mut().copy_from_slice(q);
        let (lengths, bends) = (model.lengths().to_vec(), vec![0.0; model.muscles()]);
        let mut limb = Self { model, evaluated: true, joints, lengths, bends };
        limb.update_bends();
        Ok(limb)
    }

    /// Of the independent joints, rad or m.
    pub(super) fn q(&self) -> &[f64] {
        self.joints.q.as_flattened()
    }

    /// The same, per s.
    pub(super) fn v(&self) -> &[f64] {
        self.joints.v.as_flattened()
    }

    pub(super) fn set_velocities(&mut self, v: &[f64]) {
        self.joints.v.as_flattened_mut().copy_from_slice(v);
    }

    /// Range, rad or m, stiffness and damping of the stops of every joint.
    pub(super) fn stops(&self) -> impl Iterator<Item = [f64; 4]> {
        self.joints
            .stops
            .iter()
            .map(|stop| [stop.low.0[0], stop.high.0[0], stop.stiffness.0[0], stop.damping.0[0]])
    }

    /// Forces from outside at the joints, Nm or N.
    pub(super) fn push(&mut self) -> &mut [f64] {
        self.joints.push.as_flattened_mut()
    }

    /// Advances by `h` seconds under these tensions at the anchors.
    pub(super) fn advance(&mut self, h: f64, tensions: &[f64]) -> Result<(), Error> {
        let Self { model, joints, .. } = self;
        if !self.evaluated {
            model.evaluate(joints.q.as_flattened())?;
            self.evaluated = true;
        }
        joints.update_force();
        let force = Some(joints.force.as_flattened());
        model.forward_dynamics(joints.v.as_flattened(), tensions, force, joints.a.as_flattened_mut())?;
        joints.integrate(h);
        model.evaluate(joints.q.as_flattened())?;
        self.lengths.copy_from_slice(model.lengths());
        Ok(())
    }

    /// Sets the bends to those of the present pose.
    pub(super) fn update_bends(&mut self) {
        for (muscle, bend) in self.bends.iter_mut().enumerate() {
            *bend = self.model.wrap_angle(muscle);
        }
    }

    /// Kinetic, potential and elastic energy of springs and stops, J.
    pub(super) fn energy(&mut self) -> Result<f64, Error> {
        let Self { model, joints, .. } = self;
        let (q, v) = (joints.q.as_flattened(), joints.v.as_flattened());
        model.evaluate(q)?;
        let stops = joints.stops.iter().zip(q);
        let pressed = |(stop, q): (&Stop<1>, &f64)| {
            let x = stop.beyond(Row([*q])).0[0];
            0.5 * stop.stiffness.0[0] * x * x
        };
        let pressed: f64 = stops.map(pressed).sum();
        // The forces of a step expand the velocities of coupled joints.
        model.forward_dynamics(v, &vec![0.0; model.muscles()], None, joints.a.as_flattened_mut())?;
        let (robot, q) = (model.robot(), model.coordinates());
        let (mut poses, mut scratch) = (Poses::new(robot), Scratch::new(robot));
        robot.forward_kinematics(q, &mut poses)?;
        let height = robot.potential_energy(q, &poses)?;
        Ok(robot.kinetic_energy(q, model.velocities(), &mut scratch)?
            + height
            + pressed
            + model.spring_energy())
    }
}

impl<const N: usize> Joints<N> {
    fn new(n: usize, stops: Vec<Stop<N>>) -> Self {
        let [q, v, a, push, force] = [(); 5].map(|()| vec![[0.0; N]; n]);
        Self { q, v, a, push, force, stops }
    }

    #[inline(always)]
    fn update_force(&mut self) {
        for (k, force) in self.force.iter_mut().enumerate() {
            *force = (self.stops[k].force(Row(self.q[k]), Row(self.v[k])) + Row(self.push[k])).0;
        }
    }

    #[inline(always)]
    fn integrate(&mut self, h: f64) {
        for ((q, v), a) in self.q.iter_mut().zip(&mut self.v).zip(&self.a) {
            *v = (Row(*v) + h * Row(*a)).0;
            *q = (Row(*q) + h * Row(*v)).0;
        }
    }
}

impl<const N: usize> Stop<N> {
    /// Signed penetration.
    #[inline(always)]
    fn beyond(&self, q: Row<N>) -> Row<N> {
        (q - self.high).max(0.0) + (q - self.low).min(0.0)
    }

    /// A unilateral spring and damper.
    #[inline(always)]
    fn force(&self, q: Row<N>, v: Row<N>) -> Row<N> {
        let (x, none) = (self.beyond(q), Row::default());
        let push = -self.stiffness * x - self.damping * v;
        let pressed = x.less(none).select(push.max(0.0), none);
        none.less(x).select(push.min(0.0), pressed)
    }
}

/// Worlds in a group.
pub(super) const LANES: usize = 8;

/// Limbs of one machine whose joints are not coupled, side by side.
#[derive(Debug, Clone)]
pub(super) struct Limbs {
    worlds: MuscleWorlds<LANES>,
    joints: Joints<LANES>,
    tensions: Vec<[f64; LANES]>,
    bends: Vec<[f64; LANES]>,
    instructions: InstructionSet,
}

impl Limbs {
    /// Eight like this one; none where joints are coupled.
    pub(super) fn new(limb: &Limb) -> Option<Self> {
        let worlds = limb.model.worlds()?.repeated();
        let muscles = limb.lengths.len();
        Some(Self {
            joints: Joints::new(limb.joints.q.len(), vec![Stop::default(); limb.joints.stops.len()]),
            tensions: vec![[0.0; LANES]; muscles],
            bends: vec![[0.0; LANES]; muscles],
            instructions: InstructionSet::detect(),
            worlds,
        })
    }

    /// Whether a limb is of the same machine.
    pub(super) fn is_alike(&self, limb: &Limb) -> bool {
        limb.model.worlds().is_some_and(|world| self.worlds.is_alike(world))
    }

    /// Takes the numbers and the motion of a limb that is alike as world `k`.
    pub(super) fn take(&mut self, k: usize, limb: &Limb) {
        if let Some(world) = limb.model.worlds() {
            self.worlds.set(k, world);
        }
        for (stop, one) in self.joints.stops.iter_mut().zip(&limb.joints.stops) {
            (stop.low.0[k], stop.high.0[k]) = (one.low.0[0], one.high.0[0]);
            (stop.stiffness.0[k], stop.damping.0[k]) = (one.stiffness.0[0], one.damping.0[0]);
        }
        copy(&mut self.joints.q, k, limb.q());
        copy(&mut self.joints.v, k, limb.v());
    }

    /// Evaluates the muscles in the poses that were taken.
    pub(super) fn evaluate(&mut self) {
        let Self { worlds, joints, .. } = self;
        self.instructions.run(Evaluate { worlds, q: &joints.q });
    }

    /// What acts on world `k` in the next step.
    pub(super) fn load(&mut self, k: usize, limb: &Limb, tensions: &[f64]) {
        copy(&mut self.joints.push, k, limb.joints.push.as_flattened());
        copy(&mut self.tensions, k, tensions);
    }

    /// Advances all worlds by `h` seconds; those in which all stayed finite.
    pub(super) fn advance(&mut self, h: f64) -> Mask<LANES> {
        let mut sound = Mask::NONE;
        let Self { worlds, joints, tensions, .. } = self;
        self.instructions.run(Advance { worlds, joints, tensions, h, sound: &mut sound });
        self.evaluate();
        sound & self.worlds.is_finite()
    }

    /// Gives a limb the motion of world `k`.
    pub(super) fn give(&self, k: usize, limb: &mut Limb) {
        let lane = |rows: &[[f64; LANES]], out: &mut [f64]| {
            out.iter_mut().zip(rows).for_each(|(out, row)| *out = row[k]);
        };
        lane(&self.joints.q, limb.joints.q.as_flattened_mut());
        lane(&self.joints.v, limb.joints.v.as_flattened_mut());
        lane(self.worlds.lengths(), &mut limb.lengths);
        limb.evaluated = false;
    }

    /// Evaluates the bends of all worlds.
    pub(super) fn update_bends(&mut self) {
        let Self { worlds, bends, .. } = self;
        self.instructions.run(Bends { worlds, bends });
    }

    /// Gives a limb the bends of world `k`.
    pub(super) fn give_bends(&self, k: usize, limb: &mut Limb) {
        limb.bends.iter_mut().zip(&self.bends).for_each(|(bend, row)| *bend = row[k]);
    }
}

/// Sets lane `k` of every row.
fn copy(rows: &mut [[f64; LANES]], k: usize, numbers: &[f64]) {
    rows.iter_mut().zip(numbers).for_each(|(row, number)| row[k] = *number);
}

struct Evaluate<'a> {
    worlds: &'a mut MuscleWorlds<LANES>,
    q: &'a [[f64; LANES]],
}

impl Work for Evaluate<'_> {
    #[inline(always)]
    fn run<A: Arithmetic>(self, _: A) {
        self.worlds.evaluate(self.q);
    }
}

struct Advance<'a> {
    worlds: &'a mut MuscleWorlds<LANES>,
    joints: &'a mut Joints<LANES>,
    tensions: &'a [[f64; LANES]],
    h: f64,
    sound: &'a mut Mask<LANES>,
}

impl Work for Advance<'_> {
    #[inline(always)]
    fn run<A: Arithmetic>(self, _: A) {
        let Self { worlds, joints, tensions, h, sound } = self;
        joints.update_force();
        let Joints { q, v, a, force, .. } = joints;
        *sound = worlds.accelerate([q, v, tensions, force], a);
        joints.integrate(h);
    }
}

struct Bends<'a> {
    worlds: &'a MuscleWorlds<LANES>,
    bends: &'a mut [[f64; LANES]],
}

impl Work for Bends<'_> {
    #[inline(always)]
    fn run<A: Arithmetic>(self, _: A) {
        for (muscle, bend) in self.bends.iter_mut().enumerate() {
            *bend = self.worlds.bend(muscle).0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_force_of_a_stop_is_unilateral() {
        let [low, high, stiffness, damping] = [-1.0, 2.0, 300.0, 0.2].map(Row::all);
        let stop = Stop { low, high, stiffness, damping };
        let Row(force) = stop.force(Row([2.1, -1.1, 2.001, 0.0]), Row([0.0, 0.0, -50.0, 9.0]));
        assert!(force[0] < 0.0 && force[1] > 0.0);
        assert!(force[2].abs() < 1e-12 && force[3].abs() < 1e-12);
    }
}
