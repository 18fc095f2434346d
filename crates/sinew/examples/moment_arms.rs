//! Reads the robot `models/lm_arm.toml` and prints length and moment arms of its muscles in two poses.

#![allow(clippy::print_stdout, reason = "an example prints")]

use sinew::description::from_toml;
use sinew::muscle::{Geometry, Muscles};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = include_str!("../../../models/lm_arm.toml");
    let (robot, _warnings) = from_toml("lm_arm.toml", text)?.robot()?;
    let muscles = Muscles::new(&robot);
    let mut geometry = Geometry::new(&robot, &muscles);
    let mut bent = robot.reference_pose();
    bent.iter_mut().for_each(|q| *q += 0.3);
    for (pose, q) in [("reference pose", robot.reference_pose()), ("0.3 rad in every joint", bent)] {
        muscles.evaluate(&q, &mut geometry)?;
        println!("{pose}");
        println!("{:<26} | length mm | moment arms mm about each joint", "muscle");
        for (k, tendon) in robot.parts().tendons.iter().enumerate() {
            let length = 1e3 * geometry.lengths()[k];
            print!("{:<26} | {length:9.1} |", tendon.name);
            for (velocity, arm) in muscles.columns(k).iter().zip(muscles.arms(&geometry, k)) {
                print!(" {velocity}: {:6.1}", 1e3 * arm);
            }
            println!();
        }
    }
    Ok(())
}
