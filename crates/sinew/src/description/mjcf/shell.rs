//! Shells: solids whose mass is on the surface.

use super::solid::TYPES;
use core::f64::consts::PI;

/// Surface, and principal moments of a shell of mass one; kinds in the order of [`TYPES`].
pub(super) fn inertia(kind: usize, s: [f64; 3]) -> (f64, [f64; 3]) {
    match TYPES[kind.min(4)] {
        "sphere" => (4.0 * PI * s[0] * s[0], [2.0 / 3.0 * s[0] * s[0]; 3]),
        "capsule" => {
            let (r, h) = (s[0], 2.0 * s[1]);
            let balls = 2.0 * r / (2.0 * r + h);
            let tube = 1.0 - balls;
            let ball = balls * 2.0 / 3.0 * r * r;
            let across = tube * (6.0 * r * r + h * h) / 12.0 + ball + balls * h * (h + 2.0 * r) / 4.0;
            (2.0 * PI * r * (2.0 * r + h), [across, across, tube * r * r + ball])
        }
        "cylinder" => {
            let (r, h) = (s[0], 2.0 * s[1]);
            let ends = r / (r + h);
            let tube = 1.0 - ends;
            let across = tube * (6.0 * r * r + h * h) / 12.0 + ends * (r * r + h * h) / 4.0;
            (2.0 * PI * r * (r + h), [across, across, tube * r * r + ends * r * r / 2.0])
        }
        "ellipsoid" => ellipsoid(s),
        _ => {
            let sides = [s[1] * s[2], s[0] * s[2], s[0] * s[1]];
            let all: f64 = sides.iter().sum();
            // About an axis: two faces rotate in their plane, the other four are offset from it.
            let about = |i: usize| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let (b, c) = (s[j] * s[j], s[k] * s[k]);
                (sides[i] * (b + c) / 3.0 + sides[j] * (c / 3.0 + b) + sides[k] * (b / 3.0 + c)) / all
            };
            (8.0 * all, [about(0), about(1), about(2)])
        }
    }
}

/// MuJoCo's: the surface by Thomsen's formula, the inertia of the space to an ellipsoid with half-axes longer
/// by 1 um.
fn ellipsoid(s: [f64; 3]) -> (f64, [f64; 3]) {
    const POWER: f64 = 1.6075;
    const SKIN: f64 = 1e-6;
    let term = |a: f64, b: f64| libm::pow(a * b, POWER);
    let mean = (term(s[0], s[1]) + term(s[1], s[2]) + term(s[2], s[0])) / 3.0;
    let outer = s.map(|a| a + SKIN);
    let volume = |s: [f64; 3]| s[0] * s[1] * s[2];
    let (within, whole) = (volume(s), volume(outer));
    let about = |i: usize| {
        let square = |s: [f64; 3]| s[(i + 1) % 3] * s[(i + 1) % 3] + s[(i + 2) % 3] * s[(i + 2) % 3];
        (whole * square(outer) - within * square(s)) / (5.0 * (whole - within))
    };
    (4.0 * PI * libm::pow(mean, 1.0 / POWER), [about(0), about(1), about(2)])
}
