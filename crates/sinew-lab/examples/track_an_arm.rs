//! Calibrates the cables of the arm `models/lm_arm.toml` on the twin, tracks two turns of a closed path of
//! its end point, and prints the end point's error over time.

#![allow(clippy::print_stdout, reason = "an example prints")]

use sinew::description::machine_from_toml;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{CalibratedArm, DesiredMotion, plan};
use sinew_lab::experiment::arm::{TrackRun, track};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = sinew_models::LM_ARM;
    let machine = machine_from_toml("lm_arm.toml", text, &mut |_| Err("no other file".into()))?.machine;
    let path = machine.paths.first().ok_or("the machine has no path")?.path.clone();
    let trajectory = plan(&machine, &DesiredMotion::ClosedPath(path), Some(11.5))?;

    let arm = CalibratedArm::new(&machine, 1)?;
    let controller = arm.controller(CompensationVariant::Observer, &trajectory)?;
    let run = TrackRun {
        specimen: &arm.specimen,
        robot: &machine.robot,
        site: machine.task.site(),
        tension_limits: &arm.gains(&trajectory)?.0.tension_limits(),
        standing: None,
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
