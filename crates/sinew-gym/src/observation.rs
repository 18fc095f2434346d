//! The layout of observations: what a robot's own sensors tell, what it is asked for, and what it did last.

use sinew::machine::{Machine, Task as Space};

/// A part of an observation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ObservationPart {
    /// Its name.
    pub name: &'static str,
    /// Its unit; of joints, rad for hinges and m for slides.
    pub unit: &'static str,
    /// Index of its first entry.
    pub start: usize,
    /// Number of entries.
    pub width: usize,
}

/// All parts, with the bounds within which every entry is kept.
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    pub(crate) parts: Vec<ObservationPart>,
    pub(crate) bounds: Vec<[f32; 2]>,
}

/// Largest rate of a coordinate of a joint that is told, rad/s or m/s.
const LARGEST_JOINT_RATE: f64 = 50.0;
/// Largest speed of a cable that is told, m/s.
const LARGEST_CABLE_SPEED: f64 = 5.0;
/// Distance from the origin of the world within which positions are told, m.
const LARGEST_DISTANCE: f64 = 100.0;

impl Layout {
    /// Of a machine whose joints with these indices have encoders.
    pub(crate) fn new(machine: &Machine, ranges: &[[f64; 2]], encoded: &[usize], moving: bool) -> Self {
        let mut layout = Self { parts: Vec::new(), bounds: Vec::new() };
        let (muscles, joints) = (machine.muscles.len(), ranges.len());
        let around = |k: usize| {
            let [low, high] = ranges[k];
            // Room for stops that give way, and for errors of the encoder's zero.
            let room = (high - low).max(0.1);
            [low - room, high + room]
        };
        let drum = |k: usize| machine.muscles[k].drive.winch.capacity();
        let cell = |k: usize| machine.muscles[k].drive.load_cell.range;
        layout.add("motor", "m", (0..muscles).map(|k| [-drum(k), drum(k)]));
        let speeds = (0..muscles).map(|_| [-LARGEST_CABLE_SPEED, LARGEST_CABLE_SPEED]);
        layout.add("motor_rate", "m/s", speeds);
        layout.add("tension", "N", (0..muscles).map(|k| [-0.1 * cell(k), cell(k)]));
        layout.add("joint", "rad or m", encoded.iter().map(|k| around(*k)));
        let rates = || [-LARGEST_JOINT_RATE, LARGEST_JOINT_RATE];
        layout.add("joint_rate", "rad/s or m/s", encoded.iter().map(|_| rates()));
        layout.add("target", "rad or m", (0..joints).map(around));
        if moving {
            layout.add("target_rate", "rad/s or m/s", (0..joints).map(|_| rates()));
        }
        if let Space::EndPoint { axes, .. } = machine.task {
            let tracked = axes.into_iter().filter(|axis| *axis);
            layout.add("target_point", "m", tracked.map(|_| [-LARGEST_DISTANCE, LARGEST_DISTANCE]));
        }
        layout.add("last_action", "1", (0..muscles).map(|_| [-1.0, 1.0]));
        layout
    }

    fn add(&mut self, name: &'static str, unit: &'static str, bounds: impl Iterator<Item = [f64; 2]>) {
        let start = self.bounds.len();
        self.bounds.extend(bounds.map(|[low, high]| [low as f32, high as f32]));
        let width = self.bounds.len() - start;
        if width > 0 {
            self.parts.push(ObservationPart { name, unit, start, width });
        }
    }

    /// Entries of an observation.
    pub(crate) fn len(&self) -> usize {
        self.bounds.len()
    }

    /// Writes an observation part after part, every entry within its bounds.
    pub(crate) fn write(&self, parts: &[&[f64]], out: &mut [f32]) {
        let mut rest = &mut *out;
        for part in parts {
            let (now, behind) = rest.split_at_mut(part.len().min(rest.len()));
            for (out, entry) in now.iter_mut().zip(*part) {
                *out = *entry as f32;
            }
            rest = behind;
        }
        // A pass of its own, in SIMD lanes. A reading that is not a number, which no sensor here gives, would
        // be the lower bound.
        for (out, [low, high]) in out.iter_mut().zip(&self.bounds) {
            *out = out.max(*low).min(*high);
        }
    }
}
