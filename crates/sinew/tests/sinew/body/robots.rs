//! Robots of the golden files, and random states of them.

use serde::Deserialize;
use sinew::body::{JointKind, Parts, Robot};
use std::path::{Path, PathBuf};

#[derive(Deserialize)]
pub(crate) struct Golden<C> {
    pub(crate) parts: Parts,
    pub(crate) cases: Vec<C>,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

/// Files with values of MuJoCo; `SINEW_BODY_GOLDEN` may name a folder with more.
pub(crate) fn files() -> Vec<PathBuf> {
    let extra = std::env::var_os("SINEW_BODY_GOLDEN").map(PathBuf::from);
    let mut files: Vec<PathBuf> = [Some(folder()), extra]
        .into_iter()
        .flatten()
        .flat_map(|folder| std::fs::read_dir(folder).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "json"))
        .filter(|path| path.file_stem().is_some_and(|name| name != "chain7"))
        .collect();
    files.sort();
    assert!(files.len() >= 7);
    files
}

pub(crate) fn read<C: for<'a> Deserialize<'a>>(path: &Path) -> Golden<C> {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

pub(crate) fn text(name: &str) -> String {
    std::fs::read_to_string(folder().join(name)).unwrap()
}

#[derive(Deserialize)]
struct Nothing {}

pub(crate) fn parts(name: &str) -> Parts {
    read::<Nothing>(&folder().join(format!("{name}.json"))).parts
}

pub(crate) fn robot(name: &str) -> Robot {
    Robot::new(parts(name)).unwrap()
}

pub(crate) const ALL: [&str; 8] =
    ["lm_arm", "finger", "chain7", "random_0", "random_1", "random_2", "random_3", "random_4"];

/// Numbers in (-1, 1) from a seed.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f64 {
        // Knuth's linear congruence; the high bits are good enough for poses.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub(crate) fn vector(&mut self, count: usize) -> Vec<f64> {
        (0..count).map(|_| self.next()).collect()
    }

    /// A pose within the limits, quaternions of unit length.
    pub(crate) fn pose(&mut self, robot: &Robot) -> Vec<f64> {
        let mut q = robot.reference_pose();
        for (index, joint) in robot.parts().joints.iter().enumerate() {
            let range = robot.coordinates_of(index);
            match (joint.kind, joint.range) {
                (JointKind::Hinge | JointKind::Slide, Some([low, high])) => {
                    q[range.start] = low + (high - low) * 0.5 * (self.next() + 1.0);
                }
                (JointKind::Hinge, _) => q[range.start] += 2.0 * self.next(),
                (JointKind::Slide, _) => q[range.start] += 0.1 * self.next(),
                _ => {
                    let turn = range.end - 4..range.end;
                    let raw: Vec<f64> = turn.clone().map(|_| self.next()).collect();
                    let length = raw.iter().map(|x| x * x).sum::<f64>().sqrt().max(0.1);
                    turn.zip(raw).for_each(|(k, x)| q[k] = x / length);
                }
            }
        }
        q
    }
}

/// Largest difference, relative to the largest entry.
pub(crate) fn difference(ours: &[f64], theirs: &[f64]) -> f64 {
    assert_eq!(ours.len(), theirs.len());
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0_f64, |m, x| m.max(x.abs()));
    let scale = largest(&mut theirs.iter().copied()).max(1e-3);
    largest(&mut ours.iter().zip(theirs).map(|(a, b)| a - b)) / scale
}
