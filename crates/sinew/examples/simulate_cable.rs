//! Simulates a cable in its sheath: the motor winds in and pays out 30 mm while the anchor stands still, and
//! the table shows the hysteresis between the tensions at both ends.

#![allow(clippy::print_stdout, reason = "an example prints")]

use sinew::transmission::cable::{Cable, CableLaw, CableParameters, CablePath, EndMotion};

/// Time step, s.
const STEP: f64 = 1e-3;

fn main() -> Result<(), sinew::Error> {
    let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 12)?;
    let mut cable = Cable::new(law);
    let mut position = 0.0;
    println!("time s | motor mm | drive end N | anchor N | dissipated J");
    let mut dissipated = 0.0;
    for k in 0..2000 {
        let time = f64::from(k + 1) * STEP;
        let next = 0.015 * (1.0 - libm::cos(core::f64::consts::PI * time));
        let ends = cable.step(STEP, EndMotion { motor: next - position, anchor: 0.0 })?;
        position = next;
        dissipated += ends.dissipated;
        if (k + 1) % 200 == 0 {
            println!(
                "{time:6.2} | {:8.2} | {:11.2} | {:8.2} | {dissipated:12.4}",
                1e3 * position,
                ends.tension_in,
                ends.tension_out
            );
        }
    }
    Ok(())
}
