//! Laws of the tension distribution, on problems of all sizes and kinds.

#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a failing test may panic, a long one tells its counts"
)]

mod scaling;

use sinew::Error;
use sinew::control::tension::{Distribution, Limit, Problem, Settings, Solution, Status, cocontract};
use sinew::random::Random;

/// A problem with its numbers.
#[derive(Debug, Clone)]
struct Owned {
    muscles: usize,
    joints: usize,
    arms: Vec<f64>,
    torque: Vec<f64>,
    minimum: Vec<f64>,
    maximum: Vec<f64>,
    reference: Vec<f64>,
    weight: Vec<f64>,
}

impl Owned {
    fn problem(&self) -> Problem<'_> {
        Problem {
            moment_arms: &self.arms,
            torque: &self.torque,
            minimum: &self.minimum,
            maximum: &self.maximum,
            reference: &self.reference,
            weight: &self.weight,
        }
    }

    fn torque_of(&self, tension: &[f64]) -> Vec<f64> {
        let mut torque = vec![0.0; self.joints];
        for (row, tension) in self.arms.chunks_exact(self.joints).zip(tension) {
            for (torque, arm) in torque.iter_mut().zip(row) {
                *torque += arm * tension;
            }
        }
        torque
    }
}

/// Kinds of trouble.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    /// Full rank, reachable.
    Plain,
    /// Each muscle crosses one group of joints.
    Grouped,
    /// Joints whose arms are nearly the same, in units that differ a thousandfold.
    Ill,
    /// Muscles twice, muscles without arms, a joint without muscles, fixed muscles.
    Degenerate,
    /// The only tensions that give the torque are at their limits.
    Corner,
    /// More torque than there is.
    Beyond,
}

const KINDS: [Kind; 6] =
    [Kind::Plain, Kind::Grouped, Kind::Ill, Kind::Degenerate, Kind::Corner, Kind::Beyond];

const SIZES: [(usize, usize); 9] =
    [(2, 1), (3, 2), (6, 3), (4, 4), (15, 7), (20, 3), (30, 12), (63, 20), (100, 30)];

fn below(random: &mut Random, n: usize) -> usize {
    ((random.unit() * n as f64) as usize).min(n - 1)
}

fn arms(random: &mut Random, kind: Kind, muscles: usize, joints: usize) -> Vec<f64> {
    let mut arms: Vec<f64> = (0..muscles * joints).map(|_| 0.04 * random.normal()).collect();
    for (i, row) in arms.chunks_exact_mut(joints).enumerate() {
        match kind {
            Kind::Grouped => {
                let first = i % joints;
                for (j, arm) in row.iter_mut().enumerate() {
                    if j / 3 != first / 3 {
                        *arm = 0.0;
                    }
                }
            }
            Kind::Ill => {
                for j in 1..joints {
                    row[j] = 10.0_f64.powi(-((j % 4) as i32)) * (row[0] + 0.01 * row[j]);
                }
            }
            _ => {}
        }
    }
    if kind == Kind::Degenerate {
        for i in 0..muscles {
            let other = below(random, muscles);
            match below(random, 4) {
                0 => arms.copy_within(other * joints..(other + 1) * joints, i * joints),
                1 => arms[i * joints..(i + 1) * joints].fill(0.0),
                _ => {}
            }
        }
        if joints > 2 {
            let idle = below(random, joints);
            arms.chunks_exact_mut(joints).for_each(|row| row[idle] = 0.0);
        }
    }
    arms
}

/// The problem of one seed.
fn draw(random: &mut Random, kind: Kind, (muscles, joints): (usize, usize)) -> Owned {
    let arms = arms(random, kind, muscles, joints);
    let minimum: Vec<f64> = (0..muscles).map(|_| 20.0 * random.unit()).collect();
    let mut maximum: Vec<f64> = minimum.iter().map(|low| low + 50.0 + 350.0 * random.unit()).collect();
    if kind == Kind::Degenerate {
        let fixed = below(random, muscles);
        maximum[fixed] = minimum[fixed];
    }
    let reference = (0..muscles).map(|_| 100.0 * random.unit() * below(random, 2) as f64).collect();
    let weight = (0..muscles).map(|_| 10.0_f64.powf(random.unit() - 0.5)).collect();
    let mut owned = Owned { muscles, joints, arms, torque: vec![], minimum, maximum, reference, weight };
    let direction: Vec<f64> = (0..joints).map(|_| random.normal()).collect();
    let tension: Vec<f64> = (0..muscles)
        .map(|i| {
            let (low, high) = (owned.minimum[i], owned.maximum[i]);
            let row = &owned.arms[i * joints..(i + 1) * joints];
            let along: f64 = row.iter().zip(&direction).map(|(arm, d)| arm * d).sum();
            match kind {
                Kind::Corner => {
                    if along > 0.0 {
                        high
                    } else {
                        low
                    }
                }
                _ => low + (high - low) * random.unit(),
            }
        })
        .collect();
    owned.torque = owned.torque_of(&tension);
    if kind == Kind::Beyond {
        let most: f64 = owned.maximum.iter().sum();
        for (torque, direction) in owned.torque.iter_mut().zip(&direction) {
            *torque += 0.04 * most * random.unit() * direction;
        }
    }
    owned
}

/// How far the answer is from one that no other can beat; zero but for rounding.
///
/// Reached torques: `R^T F = tau` and `F = clip(F_ref + W^-1 R lambda)`. Others: every muscle that would
/// lower the residual is at its limit, and the rule for `lambda` holds for the rest.
fn distance_from_optimum(owned: &Owned, solution: &Solution) -> f64 {
    let size = solution.residual.iter().map(|r| r * r).sum::<f64>().sqrt();
    let reached = owned.torque_of(solution.tension);
    let mut worst = 0.0_f64;
    for (j, reached) in reached.iter().enumerate() {
        let made_of: f64 = (0..owned.muscles)
            .map(|i| (owned.arms[i * owned.joints + j] * solution.tension[i]).abs())
            .sum::<f64>()
            .max(owned.torque[j].abs());
        let mismatch = (owned.torque[j] - reached - solution.residual[j]).abs();
        worst = worst.max(mismatch / made_of.max(1e-300));
        if solution.status == Status::Optimal {
            worst = worst.max(solution.residual[j].abs() / made_of.max(1e-300));
        }
    }
    for i in 0..owned.muscles {
        let row = &owned.arms[i * owned.joints..(i + 1) * owned.joints];
        let along = |x: &[f64]| -> f64 { row.iter().zip(x).map(|(arm, x)| arm * x).sum() };
        let arm = row.iter().map(|arm| arm * arm).sum::<f64>().sqrt();
        let (low, high, tension) = (owned.minimum[i], owned.maximum[i], solution.tension[i]);
        assert!((low..=high).contains(&tension), "{tension} is not within {low} to {high}");
        let reduced_gradient = along(solution.residual);
        if solution.status == Status::Infeasible && reduced_gradient.abs() > 1e-9 * arm * size {
            let limit = if reduced_gradient > 0.0 { high } else { low };
            worst = worst.max((tension - limit).abs() / high.abs());
        } else {
            let desired = owned.reference[i] + along(solution.multiplier) / owned.weight[i];
            worst = worst.max((tension - desired.max(low).min(high)).abs() / high.abs());
        }
    }
    worst
}

/// Runs `law` on problems of every kind and size.
fn for_all(rounds: usize, mut law: impl FnMut(&str, &Owned)) {
    let mut random = Random::new(5);
    for size in SIZES {
        for kind in KINDS {
            for round in 0..rounds {
                law(&format!("{kind:?} {size:?} {round}"), &draw(&mut random, kind, size));
            }
        }
    }
}

/// Largest difference, relative to the largest entry of `a`.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let size = a.iter().fold(1e-300, |most: f64, x| most.max(x.abs()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs() / size).fold(0.0, f64::max)
}

#[test]
fn no_other_tensions_cost_less_or_come_closer() {
    let (mut optimal, mut infeasible) = (0, 0);
    for_all(60, |name, owned| {
        let mut distribution = Distribution::new(owned.muscles, owned.joints);
        let solution = distribution.solve(&owned.problem()).unwrap();
        let distance = distance_from_optimum(owned, &solution);
        assert!(distance < 1e-10, "{name}: {distance:e} {solution:?}");
        *(if solution.status == Status::Optimal { &mut optimal } else { &mut infeasible }) += 1;
    });
    assert!(optimal > 1000 && infeasible > 300, "{optimal} {infeasible}");
}

#[test]
fn a_torque_made_by_tensions_within_the_limits_is_reached() {
    for_all(20, |name, owned| {
        // The names of the kinds say how the torque was made.
        if !name.starts_with("Beyond") {
            let mut distribution = Distribution::new(owned.muscles, owned.joints);
            let solution = distribution.solve(&owned.problem()).unwrap();
            assert_eq!(solution.status, Status::Optimal, "{name} {:?}", solution.residual);
        }
    });
}

#[test]
fn joints_told_apart_hardly_fixed_muscles_and_unequal_weights_stop_nothing() {
    degenerate_problems_are_solved(15);
}

#[test]
fn long_joints_told_apart_hardly_fixed_muscles_and_unequal_weights_stop_nothing() {
    if std::env::var_os("SINEW_LONG").is_some() {
        degenerate_problems_are_solved(120);
    }
}

/// `rounds` problems of every size.
fn degenerate_problems_are_solved(rounds: usize) {
    let mut random = Random::new(17);
    for size in SIZES {
        for round in 0..rounds {
            let kind = KINDS[round % 5];
            let mut owned = draw(&mut random, kind, size);
            let (muscles, joints) = size;
            // One joint like another, muscles against each other, a quarter at equal limits, weights of six
            // decades.
            let (one, other) = (below(&mut random, joints), below(&mut random, joints));
            owned.arms.chunks_exact_mut(joints).for_each(|row| row[one] = row[other]);
            let first: Vec<f64> = owned.arms[..joints].iter().map(|arm| -arm).collect();
            owned.arms[(muscles - 1) * joints..].copy_from_slice(&first);
            for i in (0..muscles).step_by(4) {
                owned.maximum[i] = owned.minimum[i];
            }
            owned.weight.iter_mut().for_each(|weight| *weight = 10.0_f64.powf(6.0 * random.unit() - 3.0));
            let tension: Vec<f64> = (0..muscles)
                .map(|i| match below(&mut random, 3) {
                    0 => owned.minimum[i],
                    1 => owned.maximum[i],
                    _ => f64::midpoint(owned.minimum[i], owned.maximum[i]),
                })
                .collect();
            owned.torque = owned.torque_of(&tension);
            let mut distribution = Distribution::new(muscles, joints);
            let solution = distribution.solve(&owned.problem()).unwrap();
            assert_eq!(solution.status, Status::Optimal, "{kind:?} {size:?} {round}: {solution:?}");
            let scale = |j: usize| -> f64 {
                let made = |i: usize| (owned.arms[i * joints + j] * solution.tension[i]).abs();
                (0..muscles).map(made).sum::<f64>() + owned.torque[j].abs()
            };
            for (j, residual) in solution.residual.iter().enumerate() {
                assert!(residual.abs() <= 1e-12 * scale(j), "{kind:?} {size:?} {round}: {residual:e}");
            }
        }
    }
}

#[test]
fn the_start_does_not_change_the_answer() {
    let mut random = Random::new(11);
    for_all(10, |name, owned| {
        let mut distribution = Distribution::new(owned.muscles, owned.joints);
        let cold = distribution.solve(&owned.problem()).unwrap().tension.to_vec();
        let mut other = owned.clone();
        other.torque.iter_mut().for_each(|torque| *torque *= random.normal());
        distribution.solve(&other.problem()).unwrap();
        let warm = distribution.solve(&owned.problem()).unwrap();
        assert!(apart(&cold, warm.tension) < 1e-9, "{name}: {:e}", apart(&cold, warm.tension));
    });
}

#[test]
fn equal_questions_get_equal_bits_and_a_warm_start_saves_steps() {
    let (mut cold_steps, mut warm_steps) = (0, 0);
    for_all(10, |name, owned| {
        let mut distribution = Distribution::new(owned.muscles, owned.joints);
        let cold = distribution.solve(&owned.problem()).unwrap();
        let (tension, steps) = (cold.tension.to_vec(), cold.iterations);
        let reached = cold.status == Status::Optimal;
        if reached {
            cold_steps += steps;
            warm_steps += distribution.solve(&owned.problem()).unwrap().iterations;
        }
        distribution.forget();
        let again = distribution.solve(&owned.problem()).unwrap();
        assert_eq!(tension, again.tension, "{name}");
        assert_eq!(steps, again.iterations, "{name}");
    });
    assert!(5 * warm_steps < cold_steps, "{warm_steps} {cold_steps}");
}

#[test]
fn what_was_solved_before_leaves_nothing_once_it_is_forgotten() {
    let mut random = Random::new(12);
    for_all(10, |name, owned| {
        // Other arms vanish in each of the problems, altogether or nearly.
        let [first, second] = [(); 2].map(|()| {
            let mut thinned = owned.clone();
            for arm in &mut thinned.arms {
                match below(&mut random, 6) {
                    0 | 1 => *arm = 0.0,
                    2 => *arm *= 1e-200,
                    3 => *arm = f64::MIN_POSITIVE,
                    _ => {}
                }
            }
            thinned
        });
        let mut used = Distribution::new(owned.muscles, owned.joints);
        used.solve(&first.problem()).unwrap();
        used.forget();
        let used = used.solve(&second.problem()).unwrap();
        let mut fresh = Distribution::new(owned.muscles, owned.joints);
        let fresh = fresh.solve(&second.problem()).unwrap();
        assert_eq!(used, fresh, "{name}");
        assert!(fresh.residual.iter().all(|residual| residual.is_finite()), "{name}: {fresh:?}");
    });
}

#[test]
fn tensions_that_are_desired_and_give_the_torque_are_returned() {
    for_all(10, |name, owned| {
        let mut distribution = Distribution::new(owned.muscles, owned.joints);
        let solution = distribution.solve(&owned.problem()).unwrap();
        let (status, tension) = (solution.status, solution.tension.to_vec());
        let mut asked = owned.clone();
        asked.reference.clone_from(&tension);
        let again = distribution.solve(&asked.problem()).unwrap();
        assert_eq!(again.status, status, "{name}");
        assert!(apart(&tension, again.tension) < 1e-9, "{name}: {:e}", apart(&tension, again.tension));
    });
}

#[test]
fn units_do_not_matter() {
    // Newton and metre may be anything, joint by joint where the torque is reached.
    let (force, length) = (1e3, 1e-4);
    for_all(10, |name, owned| {
        let mut other = owned.clone();
        other.arms.iter_mut().for_each(|arm| *arm *= length);
        other.torque.iter_mut().for_each(|torque| *torque *= force * length);
        for list in [&mut other.minimum, &mut other.maximum, &mut other.reference] {
            list.iter_mut().for_each(|tension| *tension *= force);
        }
        other.weight.iter_mut().for_each(|weight| *weight *= 1e7);
        let mut ours = Distribution::new(owned.muscles, owned.joints);
        let mut theirs = ours.clone();
        let a = ours.solve(&owned.problem()).unwrap();
        let b = theirs.solve(&other.problem()).unwrap();
        let b_tension: Vec<f64> = b.tension.iter().map(|tension| tension / force).collect();
        assert_eq!(a.status, b.status, "{name}");
        assert!(apart(a.tension, &b_tension) < 1e-9, "{name}: {:e}", apart(a.tension, &b_tension));
    });
}

#[test]
fn tensions_follow_a_moving_torque_without_a_jump() {
    let mut random = Random::new(3);
    for _ in 0..20 {
        let owned = draw(&mut random, Kind::Grouped, (15, 7));
        let mut distribution = Distribution::new(15, 7);
        // From slack to far beyond what the muscles can.
        let mut at = |part: f64| {
            let mut moving = owned.clone();
            moving.torque.iter_mut().for_each(|torque| *torque *= 6.0 * part);
            let solution = distribution.solve(&moving.problem()).unwrap();
            (solution.tension.to_vec(), solution.limit.to_vec())
        };
        let change = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let path: Vec<_> = (0..=500_u32).map(|k| at(f64::from(k) / 500.0)).collect();
        let bends = path.windows(2).filter(|pair| pair[0].1 != pair[1].1).count();
        assert!(bends > 10, "{bends}");
        // Wherever the limits that hold change, the step shrinks to nothing as it is halved.
        for (k, pair) in path.windows(2).enumerate().filter(|(_, pair)| pair[0].1 != pair[1].1) {
            let (mut from, mut to) = (pair[0].0.clone(), pair[1].0.clone());
            let (mut low, mut high) = (k as f64 / 500.0, (k + 1) as f64 / 500.0);
            for _ in 0..36 {
                let middle = f64::midpoint(low, high);
                let (tension, _) = at(middle);
                if change(&from, &tension) > change(&tension, &to) {
                    (high, to) = (middle, tension);
                } else {
                    (low, from) = (middle, tension);
                }
            }
            assert!(change(&from, &to) < 1e-5, "{} N between {low} and {high}", change(&from, &to));
        }
    }
}

#[test]
fn a_torque_and_arms_that_move_in_time_move_tensions_in_proportion_to_the_step() {
    let mut random = Random::new(23);
    for round in 0..3 {
        let owned = draw(&mut random, Kind::Plain, (15, 7));
        let sway: Vec<f64> = (0..15).map(|_| std::f64::consts::TAU * random.unit()).collect();
        // A second in so many ticks: arms sway, and so do the tensions that make the torque.
        let walk = |ticks: u32| {
            let mut distribution = Distribution::new(15, 7);
            let (mut last, mut bends, mut most) = (None::<(Vec<f64>, Vec<Limit>)>, 0, 0.0_f64);
            for k in 0..=ticks {
                let angle = 3.0 * f64::from(k) / f64::from(ticks);
                let mut now = owned.clone();
                for (row, sway) in now.arms.chunks_exact_mut(7).zip(&sway) {
                    row.iter_mut().for_each(|arm| *arm *= 1.0 + 0.1 * (angle + sway).sin());
                }
                let pull = |i: usize| {
                    let half = 0.5 * (owned.maximum[i] - owned.minimum[i]);
                    owned.minimum[i] + half * (1.0 + (2.0 * angle + sway[i]).sin())
                };
                now.torque = now.torque_of(&(0..15).map(pull).collect::<Vec<_>>());
                let solution = distribution.solve(&now.problem()).unwrap();
                let next = (solution.tension.to_vec(), solution.limit.to_vec());
                if let Some((tension, limit)) = &last {
                    bends += u32::from(*limit != next.1);
                    let moved = tension.iter().zip(&next.0).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                    most = most.max(moved * f64::from(ticks));
                }
                last = Some(next);
            }
            (bends, most)
        };
        // Pieces in which few muscles are free are steep and short: ticks have to be shorter than these.
        let ((bends, coarse), (_, fine)) = (walk(32_000), walk(128_000));
        assert!(bends >= 3, "{round}: {bends}");
        // A jump would make the rate grow with the number of ticks.
        assert!(fine < 1.5 * coarse, "{round}: {coarse} N/s, then {fine} N/s");
    }
}

#[test]
fn limits_are_named_where_they_hold() {
    for_all(5, |name, owned| {
        let mut distribution = Distribution::new(owned.muscles, owned.joints);
        let solution = distribution.solve(&owned.problem()).unwrap();
        for (i, limit) in solution.limit.iter().enumerate() {
            let at = match limit {
                Limit::Lower => owned.minimum[i],
                Limit::Upper => owned.maximum[i],
                Limit::Free => continue,
            };
            assert_eq!(solution.tension[i].to_bits(), at.to_bits(), "{name}");
        }
    });
}

#[test]
fn what_is_no_problem_is_refused_by_name() {
    let good = draw(&mut Random::new(1), Kind::Plain, (3, 2));
    let refused = |change: &dyn Fn(&mut Owned)| {
        let mut bad = good.clone();
        change(&mut bad);
        Distribution::new(3, 2).solve(&bad.problem()).unwrap_err().to_string()
    };
    for wrong in [f64::NAN, f64::INFINITY, -1e31] {
        assert!(refused(&|p| p.arms[4] = wrong).contains("moment_arms"));
        assert!(refused(&|p| p.torque[1] = wrong).contains("torque"));
        assert!(refused(&|p| p.minimum[2] = wrong).contains("minimum"));
        assert!(refused(&|p| p.maximum[2] = wrong).contains("maximum"));
        assert!(refused(&|p| p.reference[0] = wrong).contains("reference"));
        assert!(refused(&|p| p.weight[0] = wrong).contains("weight"));
    }
    assert!(refused(&|p| p.weight[0] = 0.0).contains("weight"));
    assert!(refused(&|p| p.minimum[1] = 1e9).contains("minimum[1] must be <= maximum"));
    assert!(matches!(
        Distribution::new(4, 2).solve(&good.problem()),
        Err(Error::WrongLength { name: "moment_arms", expected: 8, got: 6 })
    ));
}

#[test]
fn a_search_that_ends_at_its_step_limit_proves_nothing_and_says_so() {
    let settings = Settings { max_iterations: 1, ..Settings::default() };
    let (mut not_converged, mut rounds) = (0, 0);
    for_all(5, |name, owned| {
        let mut distribution = Distribution::with_settings(owned.muscles, owned.joints, &settings);
        let solution = distribution.solve(&owned.problem()).unwrap();
        for (i, tension) in solution.tension.iter().enumerate() {
            assert!((owned.minimum[i]..=owned.maximum[i]).contains(tension), "{name}");
        }
        // What is proved is proved within the limit, too.
        if solution.status == Status::NotConverged {
            not_converged += 1;
        } else {
            let distance = distance_from_optimum(owned, &solution);
            assert!(distance < 1e-10, "{name}: {distance:e} {solution:?}");
        }
        rounds += 1;
        let mut unlimited = Distribution::new(owned.muscles, owned.joints);
        assert_ne!(unlimited.solve(&owned.problem()).unwrap().status, Status::NotConverged, "{name}");
    });
    assert!(2 * not_converged > rounds, "{not_converged} of {rounds}");
}

#[test]
fn a_problem_that_needs_more_multiplications_than_allowed_is_refused() {
    let mut random = Random::new(29);
    let owned = draw(&mut random, Kind::Plain, (100, 30));
    let solve = |max_operations: u64| {
        let settings = Settings { max_operations, ..Settings::default() };
        let mut distribution = Distribution::with_settings(100, 30, &settings);
        let solution = distribution.solve(&owned.problem()).unwrap();
        (solution.status, solution.iterations)
    };
    let (status, steps) = solve(Settings::default().max_operations);
    assert!(status == Status::Optimal && steps >= 3, "{status:?} {steps}");
    // A step takes 100 x 30^2 / 2 for the matrix, 30^3 / 6 for its factors, 100^2 for the line search.
    assert_eq!(solve(59_000), (Status::NotConverged, 0));
    assert_eq!(solve(2 * 60_000), (Status::NotConverged, 2));
}

#[test]
fn sizes_without_muscles_or_joints_have_answers() {
    let none = Problem {
        moment_arms: &[],
        torque: &[],
        minimum: &[1.0, 2.0],
        maximum: &[5.0, 5.0],
        reference: &[3.0, 0.0],
        weight: &[1.0, 1.0],
    };
    let mut distribution = Distribution::new(2, 0);
    assert_eq!(distribution.solve(&none).unwrap().tension, [3.0, 2.0]);
    let no_muscle =
        Problem { torque: &[1.0], minimum: &[], maximum: &[], reference: &[], weight: &[], ..none };
    let mut distribution = Distribution::new(0, 1);
    let solution = distribution.solve(&no_muscle).unwrap();
    assert_eq!((solution.status, solution.residual), (Status::Infeasible, &[1.0][..]));
}

#[test]
fn co_contraction_tightens_muscles_and_leaves_the_torque() {
    let owned = draw(&mut Random::new(2), Kind::Plain, (20, 3));
    let mut distribution = Distribution::new(20, 3);
    let mut last = 0.0;
    for level in [0.0, 0.3, 0.6, 0.9] {
        let mut tighter = owned.clone();
        cocontract(level, &owned.minimum, &owned.maximum, &mut tighter.reference).unwrap();
        let solution = distribution.solve(&tighter.problem()).unwrap();
        assert_eq!(solution.status, Status::Optimal);
        let sum: f64 = solution.tension.iter().sum();
        assert!(sum > last + 10.0, "{level}: {sum} after {last}");
        last = sum;
    }
    assert!(cocontract(f64::NAN, &[], &[], &mut []).is_err() && cocontract(1.1, &[], &[], &mut []).is_err());
}
