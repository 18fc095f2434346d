//! A sheath whose bend changes with a joint: a controller that knows it, and one that does not.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use sinew::machine::Machine;
use sinew::trajectory::Trajectory;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{CalibratedArm, first_infeasibility, plan_tour};
use sinew_lab::experiment::arm::{TrackRun, track};

/// The leg with a sheath over the hip that bends by this much per radian.
fn leg(slope: f64) -> Machine {
    let text = sinew_models::PLANAR_LEG;
    let bent =
        format!("{text}\n[[transmission]]\nmuscle = \"hip_flexor\"\nbend_by_joint = {{ hip = {slope:?} }}\n");
    let read = sinew::description::machine_from_toml("leg.toml", &bent, &mut |_| Err("no other file".into()));
    read.unwrap().machine
}

/// What a controller of a calibrated specimen attains on a slow tour.
struct Errors {
    /// Mean of the end point, m.
    end_point: f64,
    /// Mean of the hip, rad.
    hip: f64,
    /// Mean of the estimated tension at the anchor of the bent sheath, N.
    estimate: f64,
}

/// The leg as built and calibrated, with its tour.
struct Built {
    machine: Machine,
    arm: CalibratedArm,
    trajectory: Trajectory,
    seed: u64,
}

impl Built {
    fn new(seed: u64, slope: f64) -> Self {
        let machine = leg(slope);
        let check = |trajectory: &_| first_infeasibility(&machine, trajectory, 1);
        let trajectory = plan_tour(&machine, Some(20.0), check).unwrap();
        Self { arm: CalibratedArm::new(&machine, seed).unwrap(), machine, trajectory, seed }
    }

    /// Without `known`, the controller takes the bend as constant.
    fn errors(&self, known: bool) -> Errors {
        let Self { machine, arm, trajectory, seed } = self;
        let limits = arm.gains(trajectory).unwrap().0.tension_limits();
        let bends = if known { machine.sheath_bends() } else { leg(0.0).sheath_bends() };
        let controller = arm.controller(CompensationVariant::Observer, trajectory).unwrap();
        let controller = controller.with_sheath_bends(&bends.unwrap()).unwrap();
        let run = TrackRun {
            specimen: &arm.specimen,
            robot: &machine.robot,
            site: machine.task.site(),
            tension_limits: &limits,
            standing: None,
            trajectory,
            repeats: 1,
            before: 2.0,
            after: 0.0,
            faults: &[],
            seed: *seed,
        };
        let (mut sum, mut count) = (0.0, 0.0);
        let summary = track(&run, controller, |row| {
            if row.time > 3.0 {
                sum += (row.command.estimated_tension[0] - row.truth.cables[0].tension_out).abs();
                count += 1.0;
            }
        })
        .unwrap();
        assert!(summary.stopped.is_none() && summary.plant_failed.is_none(), "{:?}", summary.stopped);
        Errors {
            end_point: summary.end_point_error.mean,
            hip: summary.joint_error[0].mean,
            estimate: sum / count,
        }
    }
}

#[test]
fn a_leg_whose_sheath_bends_with_the_hip_tracks_as_one_whose_does_not_if_the_controller_knows_it() {
    let slopes: [(u64, &[(f64, f64)]); 2] = [(1, &[(0.5, 1.02)]), (2, &[(2.0, 1.5)])];
    for (seed, bends) in slopes {
        let plain = Built::new(seed, 0.0).errors(true);
        for (slope, worse) in bends {
            let built = Built::new(seed, *slope);
            let [known, ignored] = [true, false].map(|known| built.errors(known));
            assert!(known.end_point < 1.1 * plain.end_point, "{} m, {} m", known.end_point, plain.end_point);
            assert!(ignored.estimate > 1.4 * known.estimate, "{} N, {} N", ignored.estimate, known.estimate);
            assert!(ignored.hip > worse * known.hip, "{} rad, {} rad", ignored.hip, known.hip);
        }
    }
}
