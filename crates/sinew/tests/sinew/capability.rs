//! Sets of torques and largest loads: against all corners of the tensions, against each other, and with
//! friction against the discretised cable.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::common;

use common::lm_arm;
use sinew::control::capability::{CableMotion, CapabilityModel, LoadSearch, TorqueSet};
use sinew::control::tension::{Distribution, Problem, Status};
use sinew::machine::Machine;
use sinew::random::Random;
use sinew::transmission::cable::CableLaw;

struct Muscles {
    arms: Vec<f64>,
    limits: Vec<[f64; 2]>,
    joints: usize,
}

/// Random muscles; some share a direction, some cross few joints.
fn muscles(random: &mut Random, count: usize, joints: usize) -> Muscles {
    let kind = random.bits() % 3;
    // From instruments to excavators.
    let size = [1e-4, 0.03, 5.0][(random.bits() % 3) as usize];
    let mut arms: Vec<f64> = (0..count * joints).map(|_| size * random.normal()).collect();
    if kind == 1 && count > joints + 1 {
        let (first, last) = (arms[..joints].to_vec(), (count - 1) * joints);
        arms[last..].iter_mut().zip(first).for_each(|(arm, first)| *arm = -1.5 * first);
    }
    if kind == 2 {
        for (k, arm) in arms.iter_mut().enumerate() {
            if (k / joints + k % joints).is_multiple_of(3) && k / joints % joints != k % joints {
                *arm = 0.0;
            }
        }
    }
    let limits = (0..count)
        .map(|k| {
            let least = 30.0 * random.unit();
            // A muscle that gives one tension only; the others still move all joints.
            let fixed = k == count / 2 && count > joints + 2 && kind == 0;
            let range = if fixed { 0.0 } else { 10.0 + 300.0 * random.unit() };
            [least, least + range]
        })
        .collect();
    Muscles { arms, limits, joints }
}

impl Muscles {
    fn set(&self) -> TorqueSet {
        TorqueSet::new(&self.arms, self.joints, &self.limits).unwrap()
    }

    fn torque(&self, tension: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut torque = vec![0.0; self.joints];
        for (k, row) in self.arms.chunks_exact(self.joints).enumerate() {
            let tension = tension(k);
            torque.iter_mut().zip(row).for_each(|(torque, arm)| *torque += arm * tension);
        }
        torque
    }

    /// The torques of all combinations of least and largest tensions.
    fn corners(&self) -> Vec<Vec<f64>> {
        let corner = |code: u32| self.torque(|k| self.limits[k][(code >> k & 1) as usize]);
        (0..1 << self.limits.len()).map(corner).collect()
    }

    /// Normals of all planes that the moment arms of `joints - 1` muscles span, both ways: among them are
    /// those of all facets.
    fn normals(&self) -> Vec<Vec<f64>> {
        let (n, arms) = (self.joints, self.arms.chunks_exact(self.joints).collect::<Vec<_>>());
        let chosen = (0_u32..1 << arms.len()).filter(|code| code.count_ones() as usize == n - 1);
        let normal = |code: u32| {
            let rows: Vec<&[f64]> = (0..arms.len()).filter(|k| code >> k & 1 == 1).map(|k| arms[k]).collect();
            let minor = |j: usize| {
                let columns: Vec<usize> = (0..n).filter(|&k| k != j).collect();
                if j.is_multiple_of(2) { determinant(&rows, &columns) } else { -determinant(&rows, &columns) }
            };
            (0..n).map(minor).collect::<Vec<f64>>()
        };
        let length = |normal: &[f64]| dot(normal, normal).sqrt();
        let all: Vec<Vec<f64>> = chosen.map(normal).collect();
        let longest = all.iter().map(|normal| length(normal)).fold(0.0, f64::max);
        let planes = all.into_iter().filter(|normal| length(normal) > 1e-9 * longest);
        planes.flat_map(|normal| [normal.iter().map(|x| -x).collect(), normal]).collect()
    }

    fn size(&self) -> f64 {
        (0..self.joints)
            .map(|j| {
                let axis: Vec<f64> = (0..self.joints).map(|k| if k == j { 1.0 } else { 0.0 }).collect();
                let opposite: Vec<f64> = axis.iter().map(|x| -x).collect();
                self.set().support(&axis).unwrap() + self.set().support(&opposite).unwrap()
            })
            .fold(0.0, f64::max)
    }
}

/// Of rows and some of their columns, by the first row.
fn determinant(rows: &[&[f64]], columns: &[usize]) -> f64 {
    let Some((first, rest)) = rows.split_first() else { return 1.0 };
    let term = |k: usize| {
        let others: Vec<usize> = columns.iter().copied().filter(|&column| column != columns[k]).collect();
        let sign = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        sign * first[columns[k]] * determinant(rest, &others)
    };
    (0..columns.len()).map(term).sum()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[test]
fn the_support_is_the_largest_torque_of_all_corners_of_the_tensions() {
    let mut random = Random::new(1);
    for case in 0..200 {
        let joints = 1 + case % 4;
        let count = joints + 1 + (random.bits() % 6) as usize;
        let muscles = muscles(&mut random, count, joints);
        let (set, corners, size) = (muscles.set(), muscles.corners(), muscles.size());
        let direction: Vec<f64> = (0..joints).map(|_| random.normal()).collect();
        let most = corners.iter().map(|corner| dot(corner, &direction)).fold(f64::MIN, f64::max);
        assert!((set.support(&direction).unwrap() - most).abs() < 1e-9 * size, "{case}");
    }
}

#[test]
fn the_largest_load_lies_on_a_facet_and_its_muscles_bind() {
    let mut random = Random::new(3);
    let mut loads = 0;
    for case in 0..400 {
        let joints = 1 + case % 4;
        let count = joints + 1 + (random.bits() % 8) as usize;
        let muscles = muscles(&mut random, count, joints);
        let fractions: Vec<f64> = muscles.limits.iter().map(|_| 0.3 + 0.4 * random.unit()).collect();
        let needed = muscles.torque(|k| {
            let [least, most] = muscles.limits[k];
            least + fractions[k] * (most - least)
        });
        let load: Vec<f64> = (0..joints).map(|_| random.normal()).collect();
        let mut search = LoadSearch::new(count, joints);
        let mut largest =
            |limits: &[[f64; 2]]| search.largest(&muscles.arms, limits, &needed, &load).unwrap().unwrap();
        let found = largest(&muscles.limits);
        let set = muscles.set();
        let cut = |normal: Vec<f64>| {
            let slope = dot(&normal, &load);
            let room = set.support(&normal).unwrap() - dot(&normal, &needed);
            if slope > 0.0 { room / slope } else { f64::INFINITY }
        };
        let exact = muscles.normals().into_iter().map(cut).fold(f64::INFINITY, f64::min);
        assert!((found.factor / exact - 1.0).abs() < 1e-8, "{case}: {} {exact}", found.factor);
        // The derivative with respect to the first muscle's limit.
        let first = found.binding[0];
        let mut wider = muscles.limits.clone();
        let step = 1e-3;
        wider[first.muscle][usize::from(first.largest)] += if first.largest { step } else { -step };
        let gained = (largest(&wider).factor - found.factor) / step;
        assert!(gained > 0.5 * first.gain && gained < 1.5 * first.gain, "{case}: {gained} {first:?}");
        loads += 1;
    }
    assert_eq!(loads, 400);
}

#[test]
fn the_largest_load_of_many_joints_is_reached_and_nothing_above_it() {
    let mut random = Random::new(4);
    for case in 0..60 {
        let joints = 5 + case % 8;
        let count = joints + 2 + (random.bits() % 14) as usize;
        let muscles = muscles(&mut random, count, joints);
        let needed = muscles.torque(|k| 0.5 * (muscles.limits[k][0] + muscles.limits[k][1]));
        let load: Vec<f64> = (0..joints).map(|_| random.normal()).collect();
        let mut search = LoadSearch::new(count, joints);
        let found = search.largest(&muscles.arms, &muscles.limits, &needed, &load).unwrap().unwrap();
        let reached = |fraction: f64| {
            let torque: Vec<f64> = needed
                .iter()
                .zip(&load)
                .map(|(needed, load)| needed + fraction * found.factor * load)
                .collect();
            let (minimum, maximum): (Vec<f64>, Vec<f64>) =
                muscles.limits.iter().map(|limits| (limits[0], limits[1])).unzip();
            let (reference, weight) = (vec![0.0; count], vec![1.0; count]);
            let problem = Problem {
                moment_arms: &muscles.arms,
                torque: &torque,
                minimum: &minimum,
                maximum: &maximum,
                reference: &reference,
                weight: &weight,
            };
            Distribution::new(count, joints).solve(&problem).unwrap().status == Status::Optimal
        };
        assert!(reached(1.0 - 1e-6) && !reached(1.0 + 1e-6), "{case}: {}", found.factor);
        assert!(!found.binding.is_empty());
    }
}

#[test]
fn what_cannot_be_held_has_no_largest_load_and_wrong_numbers_are_refused() {
    let mut search = LoadSearch::new(2, 1);
    let (arms, limits) = ([0.03, -0.03], [[10.0, 100.0]; 2]);
    assert_eq!(search.largest(&arms, &limits, &[3.0], &[1.0]).unwrap(), None);
    let free = search.largest(&arms, &limits, &[1.0], &[0.0]).unwrap().unwrap();
    assert!(free.factor.is_infinite() && free.binding.is_empty());
    assert!(search.largest(&arms, &limits[..1], &[1.0], &[1.0]).is_err());
    assert!(search.largest(&arms, &limits, &[f64::NAN], &[1.0]).is_err());
    assert!(TorqueSet::new(&arms, 1, &[[10.0, 5.0], [0.0, 1.0]]).is_err());
    assert!(TorqueSet::new(&arms, 1, &[[10.0, f64::NAN], [0.0, 1.0]]).is_err());
    assert!(TorqueSet::new(&arms, 0, &[]).is_err());
    // The second joint has no muscle.
    let flat = TorqueSet::new(&[0.03, 0.0, -0.02, 0.0], 2, &limits).unwrap();
    assert!(flat.support(&[0.0, 1.0]).unwrap().abs() < 1e-12);
}

/// Tension at the anchor at which the drive of a slowly sliding cable has a tension, N, by bisection.
fn anchor_tension(law: &CableLaw, tension_in: f64, toward_motor: bool) -> f64 {
    let velocity = if toward_motor { 1e-12 } else { -1e-12 };
    let (mut low, mut high) = (0.0, 1e4);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        // At a slip of 1 m/s friction has its sliding value.
        let now = law.sliding(middle, velocity, 1.0, 0.0).unwrap().tension_in;
        *(if now < tension_in { &mut low } else { &mut high }) = middle;
    }
    low
}

#[test]
fn with_friction_the_torques_are_those_of_all_drive_tensions_through_the_discretised_cables() {
    let robot = lm_arm();
    let machine = Machine::from_robot(&robot).unwrap();
    let mut model = CapabilityModel::new(&machine).unwrap();
    let mut random = Random::new(5);
    for pose in machine.poses(6).unwrap() {
        model.evaluate(&pose).unwrap();
        let velocity: Vec<f64> = (0..7).map(|_| random.normal()).collect();
        let limits = model.tension_limits(CableMotion::Along(&velocity)).unwrap();
        let arms = model.moment_arms().to_vec();
        let set = TorqueSet::new(&arms, 7, &limits).unwrap();
        let mut through = Vec::new();
        for (k, design) in machine.muscles.iter().enumerate() {
            let wrap = (model.friction_angle(k) + design.cable.efficiency.ln()) / design.cable.friction
                - design.bend;
            let law = CableLaw::new(&design.path(0.1, wrap).unwrap(), &design.cable, 24).unwrap();
            let toward_motor = dot(&arms[7 * k..7 * k + 7], &velocity) > 0.0;
            let drive = [design.drive.min_tension, design.drive.working_tension()];
            let [least, most] = drive.map(|tension| anchor_tension(&law, tension, toward_motor));
            // The machine's own limits hold as well.
            let [lower, upper] = design.tension;
            through.push([least.max(lower.unwrap_or(0.0)), most.min(upper.unwrap_or(f64::INFINITY))]);
        }
        for (k, (ours, theirs)) in limits.iter().zip(&through).enumerate() {
            for (ours, theirs) in ours.iter().zip(theirs) {
                assert!((ours / theirs - 1.0).abs() < 5e-7, "{k}: {ours} {theirs}");
            }
        }
        let muscles = Muscles { arms, limits: through, joints: 7 };
        let corners = muscles.corners();
        let size = muscles.size();
        for _ in 0..10 {
            let direction: Vec<f64> = (0..7).map(|_| random.normal()).collect();
            let most = corners.iter().map(|corner| dot(corner, &direction)).fold(f64::MIN, f64::max);
            assert!((set.support(&direction).unwrap() - most).abs() < 4e-7 * size);
        }
    }
}

#[test]
fn what_is_held_whichever_way_the_cables_slid_is_also_lifted_and_lowered() {
    let machine = Machine::from_robot(&lm_arm()).unwrap();
    let mut model = CapabilityModel::new(&machine).unwrap();
    let mut compared = 0;
    for pose in machine.poses(40).unwrap() {
        let found = model.at(&pose).unwrap();
        let end_point = found.end_point.unwrap();
        let value = |k: usize| end_point.payload[k].map(|extreme| extreme.value);
        if let (Some(lifted), Some(held), Some(lowered)) = (value(0), value(1), value(2)) {
            // Tensions that both directions allow are a part of those of each.
            assert!(
                held <= lifted * (1.0 + 1e-9) && held <= lowered * (1.0 + 1e-9),
                "{held} {lifted} {lowered}"
            );
            compared += 1;
        }
        for joint in &found.joints {
            assert!(joint.stiffness.unwrap() > 0.0 && joint.speed.value > 0.0);
        }
        let [least, most] = end_point.stiffness.unwrap();
        assert!(least > 0.0 && least <= most);
        assert!(end_point.speed.unwrap().0.value > 0.0);
    }
    assert!(compared > 10, "{compared}");
}
