#![allow(warnings)]
#[path = "../tests/common/mod.rs"]
mod common;
use common::random_models::{model, Draw};
use sinew::compensator::*;
use sinew::predictor::*;
fn main() {
    let a: Vec<f64> = std::env::args().skip(1).map(|x| x.parse().unwrap()).collect();
    let (rate, h, show) = (a[0], a[1], a.get(2).copied().unwrap_or(-1.0));
    TRUST.store(a.get(3).copied().unwrap_or(0.0).to_bits(), std::sync::atomic::Ordering::Relaxed);
    for kind in [3, 4] {
        let mut sq = 0.0; let (mut all, mut att, mut cold, mut catt, mut rev, mut lim) = (0, 0, 0, 0, 0, 0);
        for j in 0..40u64 {
            let seed = kind + 8 * j;
            let m = model(seed);
            let mut draw = Draw::new(seed + 7000);
            let range = m.provenance.far_range;
            let centre = if range > 100.0 { 0.4 * range } else { 0.0 };
            let (s0, s1) = (draw.between(0.02, 0.2) * range, draw.between(0.0, 0.05) * range);
            let (r0, r1, an) = (draw.between(0.5, 4.0), draw.between(2.0, 9.0), draw.between(0.0, 0.05));
            let mut c = Compensator::new(m.clone(), &CompensatorSettings { rate: Some(rate), ..Default::default() }).unwrap();
            let (mut last, mut dlast) = (0.0f64, 0.0f64);
            for k in 0..(4.0 / h) as u32 {
                let t = k as f64 * h;
                let y = centre + s0 * (r0 * t).sin() + s1 * (r1 * t).sin();
                let row: Vec<f64> = if kind == 7 { vec![f64::NAN] } else { vec![f64::NAN, f64::NAN, an * (r0 * t).sin()] };
                let cmd = c.step(&Sample { time_s: t, inputs: &row }, y);
                if seed as f64 == show && t > 2.0 { println!("{t:.3} {y:.3} {:.3} u {:.3} T {:.2} {} {}", cmd.mean, cmd.value, c.inputs()[0], cmd.flags.not_attainable, cmd.flags.rate_limited); }
                all += 1;
                att += u32::from(!cmd.flags.not_attainable);
                let d = cmd.value - last;
                if t > 1.0 { sq += (cmd.mean-y).powi(2); cold += 1; catt += u32::from(!cmd.flags.not_attainable); rev += u32::from(d * dlast < 0.0); lim += u32::from(cmd.flags.rate_limited); }
                if d != 0.0 { dlast = d; }
                last = cmd.value;
            }
        }
        println!("kind {kind}: attained {:.3} after start {:.3}, reversals per sample {:.3} limited {:.3} rms {:.3}", att as f64 / all as f64, catt as f64 / cold as f64, rev as f64 / cold as f64, lim as f64 / cold as f64, (sq/cold as f64).sqrt());
    }
}
