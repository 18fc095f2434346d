//! Tracks one sine loop of the end point with the arm `models/lm_arm.toml` on the twin, its cable models
//! known exactly, and prints the end point's error over time.

#![allow(clippy::print_stdout, reason = "an example prints")]

use sinew::control::arm::{ActuationMode, ArmController, ArmGains, CableStateSource};
use sinew::description::from_toml;
use sinew::trajectory::{EndPointPath, JointPath, Loop, Redundancy, Reference, TimeLaw, Trajectory};
use sinew::twin::arm::ArmSpecimen;
use sinew_lab::experiment::arm::{TrackRun, track};
use sinew_lab::experiment::oracle_models;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = include_str!("../../../models/lm_arm.toml");
    let (robot, _warnings) = from_toml("lm_arm.toml", text)?.robot()?;
    let site = robot.site("endpoint").ok_or("the model has no site `endpoint`")?;
    let path = EndPointPath::lm_arm(Loop::Sine);
    let joints = JointPath::resolve(&robot, site, &path, &Redundancy::lm_arm(), 720)?;
    let law = TimeLaw::new(4.0 * std::f64::consts::PI, 11.5)?;
    let trajectory = Trajectory::AlongPath { joints, law };
    let mut start = Reference::new(robot.nv());
    trajectory.sample(0.0, &mut start)?;

    let specimen = ArmSpecimen::draw(&robot, &start.q, 1)?;
    let models = oracle_models(&specimen);
    let mode = ActuationMode::WinchSpeed(CableStateSource::Observer);
    let controller = ArmController::new(&robot, &models, ArmGains::lm_arm(), mode)?;
    let run = TrackRun {
        specimen: &specimen,
        robot: &robot,
        site,
        trajectory: &trajectory,
        repeats: 1,
        before: 1.0,
        after: 0.0,
        faults: &[],
        seed: 1,
    };
    println!("time s | end-point error mm");
    let (mut step, mut squares) = (0_u32, 0.0);
    track(&run, controller, |row| {
        let offset = [0, 1, 2].map(|i| row.end_point[i] - row.reference_point[i]);
        let error = 1e3 * offset.iter().map(|x| x * x).sum::<f64>().sqrt();
        squares += error * error;
        if step % 1000 == 0 {
            println!("{:6.1} | {error:8.2}", row.time);
        }
        step += 1;
    })?;
    println!("   rms | {:8.2}", (squares / f64::from(step)).sqrt());
    Ok(())
}
