#![allow(clippy::all, missing_docs, clippy::print_stdout, clippy::unwrap_used, reason = "scratch")]
use sinew::control::tension::{Distribution, Problem, Solution, Status};
use sinew::random::Random;
use std::collections::BTreeMap;

struct P {
    m: usize,
    n: usize,
    arms: Vec<f64>,
    torque: Vec<f64>,
    lo: Vec<f64>,
    hi: Vec<f64>,
    rf: Vec<f64>,
    w: Vec<f64>,
}
impl P {
    fn p(&self) -> Problem<'_> {
        Problem {
            moment_arms: &self.arms,
            torque: &self.torque,
            minimum: &self.lo,
            maximum: &self.hi,
            reference: &self.rf,
            weight: &self.w,
        }
    }
}
fn below(r: &mut Random, n: usize) -> usize {
    ((r.unit() * n as f64) as usize).min(n - 1)
}

fn draw(r: &mut Random, m: usize, n: usize) -> (String, P) {
    let mut name = String::new();
    let mut arms: Vec<f64> = (0..m * n).map(|_| 0.04 * r.normal()).collect();
    let structure = below(r, 5);
    name += ["dense ", "groups ", "sparse ", "ill ", "lattice "][structure];
    for i in 0..m {
        for j in 0..n {
            let a = &mut arms[i * n..(i + 1) * n];
            match structure {
                1 => {
                    if j / 3 != (i % n) / 3 {
                        a[j] = 0.0
                    }
                }
                2 => {
                    if r.unit() > 3.0 / n as f64 {
                        a[j] = 0.0
                    }
                }
                3 => {
                    if j > 0 {
                        a[j] = 10f64.powi(-((j % 4) as i32)) * (a[0] + 0.01 * a[j])
                    }
                }
                4 => a[j] = (below(r, 3) as f64 - 1.0) * 0.03,
                _ => {}
            }
        }
    }
    if below(r, 2) == 0 {
        name += "twice ";
        for i in 0..m {
            let o = below(r, m);
            match below(r, 5) {
                0 => arms.copy_within(o * n..(o + 1) * n, i * n),
                1 => arms[i * n..(i + 1) * n].fill(0.0),
                2 => {
                    for j in 0..n {
                        arms[i * n + j] = -arms[o * n + j];
                    }
                }
                _ => {}
            }
        }
    }
    if below(r, 3) == 0 && n > 1 {
        name += "zerojoint ";
        let j = below(r, n);
        for i in 0..m {
            arms[i * n + j] = 0.0;
        }
    }
    if below(r, 4) == 0 && n > 1 {
        name += "samejoint ";
        let j = below(r, n);
        let k = below(r, n);
        for i in 0..m {
            arms[i * n + j] = arms[i * n + k];
        }
    }
    let lo: Vec<f64> = (0..m).map(|_| if structure == 4 { 10.0 } else { 20.0 * r.unit() }).collect();
    let mut hi: Vec<f64> =
        lo.iter().map(|l| l + if structure == 4 { 100.0 } else { 50.0 + 350.0 * r.unit() }).collect();
    if below(r, 3) == 0 {
        name += "fixed ";
        for i in 0..m {
            if below(r, 4) == 0 {
                hi[i] = lo[i];
            }
        }
    }
    let wr = [0.0, 1.0, 6.0][below(r, 3)];
    if wr == 6.0 {
        name += "weights1e6 ";
    }
    let w: Vec<f64> = (0..m).map(|_| 10f64.powf(wr * (r.unit() - 0.5))).collect();
    let rf: Vec<f64> = (0..m)
        .map(|i| match below(r, 3) {
            0 => 0.0,
            1 => lo[i],
            _ => 100.0 * r.unit(),
        })
        .collect();
    let dir: Vec<f64> = (0..n).map(|_| r.normal()).collect();
    let kind = below(r, 5);
    name += ["inside ", "corner ", "vertex ", "beyond ", "edge "][kind];
    let t: Vec<f64> = (0..m)
        .map(|i| {
            let along: f64 = (0..n).map(|j| arms[i * n + j] * dir[j]).sum();
            let inside = lo[i] + (hi[i] - lo[i]) * r.unit();
            match kind {
                1 => {
                    if along > 0.0 {
                        hi[i]
                    } else {
                        lo[i]
                    }
                }
                2 => match below(r, 3) {
                    0 => lo[i],
                    1 => hi[i],
                    _ => inside,
                },
                4 => {
                    if along.abs() < 0.02 {
                        inside
                    } else if along > 0.0 {
                        hi[i]
                    } else {
                        lo[i]
                    }
                }
                _ => inside,
            }
        })
        .collect();
    let mut torque = vec![0.0; n];
    for i in 0..m {
        for j in 0..n {
            torque[j] += arms[i * n + j] * t[i];
        }
    }
    if kind == 3 {
        let most: f64 = hi.iter().sum();
        for j in 0..n {
            torque[j] += 0.04 * most * r.unit() * dir[j];
        }
    }
    (name, P { m, n, arms, torque, lo, hi, rf, w })
}

fn dist(o: &P, s: &Solution) -> (f64, f64, f64) {
    let n = o.n;
    let size = s.residual.iter().map(|r| r * r).sum::<f64>().sqrt();
    let mut miss = 0f64;
    let mut kkt = 0f64;
    let mut rel = 0f64;
    for j in 0..n {
        let mut made = o.torque[j].abs();
        let mut res = o.torque[j];
        for i in 0..o.m {
            let x = o.arms[i * n + j] * s.tension[i];
            made += x.abs();
            res -= x;
        }
        miss = miss.max((res - s.residual[j]).abs() / made.max(1e-300));
        if s.status == Status::Optimal {
            miss = miss.max(res.abs() / made.max(1e-300));
        }
        rel = rel.max(res.abs() / made.max(1e-300));
    }
    for i in 0..o.m {
        let row = &o.arms[i * n..(i + 1) * n];
        let along = |x: &[f64]| -> f64 { row.iter().zip(x).map(|(a, x)| a * x).sum() };
        let arm = row.iter().map(|a| a * a).sum::<f64>().sqrt();
        let (lo, hi, t) = (o.lo[i], o.hi[i], s.tension[i]);
        assert!((lo..=hi).contains(&t));
        let wish = along(s.residual);
        if s.status != Status::Optimal && wish.abs() > 1e-9 * arm * size {
            let limit = if wish > 0.0 { hi } else { lo };
            kkt = kkt.max((t - limit).abs() / hi.abs());
        } else {
            let want = o.rf[i] + along(s.multiplier) / o.w[i];
            let noise =
                8.0 * 2.2e-16 * (0..n).map(|j| (row[j] * s.multiplier[j]).abs()).sum::<f64>() / o.w[i];
            kkt = kkt.max(((t - want.max(lo).min(hi)).abs() - noise) / hi.abs());
        }
    }
    (miss, kkt, rel)
}

#[test]
fn stress() {
    let total: usize = std::env::var("STRESS").ok().and_then(|x| x.parse().ok()).unwrap_or(2000);
    let sizes =
        [(2, 1), (3, 2), (6, 3), (4, 4), (2, 3), (8, 4), (15, 7), (20, 3), (30, 12), (63, 20), (100, 30)];
    let seed: u64 = std::env::var("SEED").ok().and_then(|x| x.parse().ok()).unwrap_or(7);
    let mut bad: BTreeMap<String, usize> = BTreeMap::new();
    let mut count: BTreeMap<String, usize> = BTreeMap::new();
    let (mut wm, mut wk) = (0f64, 0f64);
    let mut steps = 0;
    let only: Option<usize> = std::env::var("ONLY").ok().and_then(|x| x.parse().ok());
    for k in 0..total {
        if only.is_some_and(|o| o != k) {
            continue;
        }
        let mut r = Random::new(seed * 1_000_000 + k as u64);
        let (m, n) = sizes[k % sizes.len()];
        let (name, p) = draw(&mut r, m, n);
        let mut d = Distribution::new(m, n);
        let s = d.solve(&p.p()).unwrap();
        let (miss, kkt, rel) = dist(&p, &s);
        *count.entry(format!("{:?}", s.status)).or_default() += 1;
        wm = wm.max(miss);
        wk = wk.max(kkt);
        steps = steps.max(s.iterations);
        let made = !name.contains("beyond");
        let wrong = miss > 1e-11
            || kkt > 1e-10
            || !matches!(s.status, Status::Optimal | Status::Infeasible)
            || (made && s.status != Status::Optimal)
            || (s.status == Status::Infeasible && rel < 1e-8);
        if wrong {
            *bad.entry(name.clone()).or_default() += 1;
            if std::env::var("SHOW").is_ok() {
                println!(
                    "{k} {m}x{n} {name}: {:?} miss {miss:.1e} kkt {kkt:.1e} rel {rel:.1e} steps {}",
                    s.status, s.iterations
                );
            }
        }
    }
    println!("{count:?} worst miss {wm:.1e} kkt {wk:.1e} steps {steps}, bad {}", bad.values().sum::<usize>());
    if std::env::var("SHOW").is_ok() {
        for (n, c) in bad {
            println!("  {c} {n}");
        }
    }
}
