//! Distributes a joint torque over redundant muscles: shoulder and elbow with four muscles, one of them
//! biarticular, within limits and with the least deviation from a reference tension.

#![allow(clippy::print_stdout, reason = "an example prints")]

use sinew::control::tension::{Distribution, Problem};

fn main() -> Result<(), sinew::Error> {
    // Moment arms, m: muscles x joints (shoulder, elbow).
    let moment_arms = [0.04, 0.0, -0.04, 0.0, 0.02, 0.03, 0.0, -0.025];
    let mut distribution = Distribution::new(4, 2);
    println!("shoulder Nm | elbow Nm | tensions N                    | status, residual Nm");
    for torque in [[0.0, 0.0], [2.0, 0.5], [-2.0, 3.0], [6.0, -4.0], [20.0, 0.0]] {
        let solution = distribution.solve(&Problem {
            moment_arms: &moment_arms,
            torque: &torque,
            minimum: &[5.0; 4],
            maximum: &[200.0; 4],
            reference: &[20.0; 4],
            weight: &[1.0; 4],
        })?;
        print!("{:11.1} | {:8.1} |", torque[0], torque[1]);
        for tension in solution.tension {
            print!(" {tension:6.1}");
        }
        let residual = solution.residual.iter().fold(0.0_f64, |most, r| most.max(r.abs()));
        println!("  | {:?}, {residual:.1e}", solution.status);
    }
    Ok(())
}
