use crate::error::{Error, non_negative, positive, within};
use crate::lanes::{Row, abreast};
use core::ops::Add;

/// Winch: cable wound per turn, layer by layer.
///
/// ```text
/// l(theta) = theta sqrt(r^2 + (p/2 pi)^2)          in the first layer; r + d in the second, r + 2 d in the third
/// ```
///
/// | symbol | argument          | unit | domain | meaning                                      |
/// |--------|-------------------|------|--------|----------------------------------------------|
/// | r      | `radius`          | m    | > 0    | drum to the centre of the cable, first layer   |
/// | p      | `lead`            | m    | >= 0   | advance of the groove per turn                |
/// | d      | `cable_diameter`  | m    | > 0    | increase of the radius per layer               |
/// |        | `turns_per_layer` | 1    | > 0    | turns of a layer                              |
/// |        | `layers`          | 1    | 1..=8  | beyond the last the drum is full               |
///
/// # Assumes
/// Layers are stacked without nesting. Angle 0 is the empty drum.
///
/// # Source
/// Textbook geometry; cable 3 mm of `yuan2023`. Its radius is not given: 15 mm is assumed, because with 10 mm
/// the 24 V motor is too slow to move the cable at 0.12 m/s while it stretches by 60 mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Winch {
    /// Radius of the drum, m.
    pub radius: f64,
    /// m per turn.
    pub lead: f64,
    /// Diameter of the cable, m.
    pub cable_diameter: f64,
    /// Turns.
    pub turns_per_layer: f64,
    /// Layers.
    pub layers: u8,
}

abreast!(WinchRows of Winch { f64: radius lead cable_diameter turns_per_layer; u8: layers });

const TURN: f64 = 2.0 * core::f64::consts::PI;

impl Winch {
    /// One layer of twelve turns of 3 mm cable on a radius of 15 mm: 1.1 m.
    #[must_use]
    pub fn fifteen_millimetres() -> Self {
        Self { radius: 0.015, lead: 3.2e-3, cable_diameter: 3e-3, turns_per_layer: 12.0, layers: 1 }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        positive("radius", self.radius)?;
        non_negative("lead", self.lead)?;
        positive("cable_diameter", self.cable_diameter)?;
        positive("turns_per_layer", self.turns_per_layer)?;
        let layers = f64::from(self.layers);
        within("layers", "a number in 1..=8", layers, (1..=8).contains(&self.layers))?;
        Ok(())
    }

    /// Cable per radian in a layer, m: the lever arm between tension and torque.
    #[inline]
    #[must_use]
    pub fn arm(&self, layer: u8) -> f64 {
        let radius = self.radius + f64::from(layer) * self.cable_diameter;
        let pitch = self.lead / TURN;
        libm::sqrt(radius * radius + pitch * pitch)
    }

    /// The layer being wound at an angle, rad; 0 on the bare drum.
    #[inline]
    #[must_use]
    pub fn layer(&self, angle: f64) -> u8 {
        let full = angle / (TURN * self.turns_per_layer);
        // Beyond either end of the drum the geometry of the last layer is extrapolated.
        if full >= f64::from(self.layers) { self.layers - 1 } else { full.max(0.0) as u8 }
    }

    /// Cable on the drum at an angle, m.
    #[must_use]
    pub fn wound(&self, angle: f64) -> f64 {
        let per_layer = TURN * self.turns_per_layer;
        let layer = self.layer(angle);
        let below: f64 = (0..layer).map(|k| per_layer * self.arm(k)).sum();
        below + (angle - f64::from(layer) * per_layer) * self.arm(layer)
    }

    /// Angle at which there is this much cable on the drum, m: the inverse of [`wound`](Self::wound), rad.
    #[must_use]
    pub fn angle(&self, wound: f64) -> f64 {
        let per_layer = TURN * self.turns_per_layer;
        let (mut below, mut layer) = (0.0, 0);
        while layer + 1 < self.layers && wound >= below + per_layer * self.arm(layer) {
            below += per_layer * self.arm(layer);
            layer += 1;
        }
        f64::from(layer) * per_layer + (wound - below) / self.arm(layer)
    }

    /// Angle at which the drum is full, rad.
    #[must_use]
    pub fn full(&self) -> f64 {
        TURN * self.turns_per_layer * f64::from(self.layers)
    }

    /// Capacity of the drum, m.
    #[must_use]
    pub fn capacity(&self) -> f64 {
        self.wound(self.full())
    }
}

/// Winches with precomputed layers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Drum<const N: usize> {
    layers: [Layer<N>; 8],
    /// Angle of one full layer, rad.
    per_layer: Row<N>,
    layers_per_radian: Row<N>,
    /// Number of the last layer.
    last: Row<N>,
    /// Layers of the winch that has most.
    most: usize,
}

/// A layer of every winch.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Layer<const N: usize> {
    number: Row<N>,
    /// Cable per radian, m.
    arm: Row<N>,
    /// Cable below, m.
    below: Row<N>,
}

impl<const N: usize> Drum<N> {
    pub(super) fn new(winches: [Winch; N]) -> Self {
        let row = |value: &dyn Fn(&Winch) -> f64| Row(winches.each_ref().map(value));
        let per_layer = row(&|winch| TURN * winch.turns_per_layer);
        let last = row(&|winch| f64::from(winch.layers.clamp(1, 8) - 1));
        let arm = |k: u8| row(&move |winch| winch.arm(k));
        let below = |layer: u8| (0..layer).map(|k| per_layer * arm(k)).fold(Row::all(-0.0), Row::add);
        let layer = |k: usize| Layer { number: Row::all(k as f64), arm: arm(k as u8), below: below(k as u8) };
        let most = winches.iter().map(|winch| usize::from(winch.layers.clamp(1, 8))).max().unwrap_or(1);
        let layers = core::array::from_fn(layer);
        Self { layers, per_layer, layers_per_radian: 1.0 / per_layer, last, most }
    }

    /// As [`Winch::arm`] in [`Winch::layer`].
    #[inline(always)]
    pub(super) fn arm(&self, angle: Row<N>) -> Row<N> {
        self.layer(angle).arm
    }

    /// As [`Winch::wound`].
    #[inline(always)]
    pub(super) fn wound(&self, angle: Row<N>) -> Row<N> {
        let Layer { number, arm, below } = self.layer(angle);
        below + (angle - number * self.per_layer) * arm
    }

    #[inline(always)]
    fn layer(&self, angle: Row<N>) -> Layer<N> {
        let turned = angle * self.layers_per_radian;
        let mut layer = self.layers[0];
        for next in &self.layers[1..self.most] {
            let begun = next.number.at_most(turned) & next.number.at_most(self.last);
            layer.number = begun.select(next.number, layer.number);
            layer.arm = begun.select(next.arm, layer.arm);
            layer.below = begun.select(next.below, layer.below);
        }
        layer
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wound_length_is_continuous_across_layers() {
        let winch = Winch { layers: 3, ..Winch::fifteen_millimetres() };
        let mut last = winch.wound(0.0);
        for k in 1..=4000 {
            let wound = winch.wound(winch.full() * f64::from(k) / 4000.0);
            let step = wound - last;
            assert!(step > 0.0 && step < winch.arm(2) * winch.full() / 4000.0 * 1.001);
            last = wound;
        }
        let turns = TURN * winch.turns_per_layer;
        assert!((winch.capacity() - turns * (0..3).map(|k| winch.arm(k)).sum::<f64>()).abs() < 1e-12);
    }

    #[test]
    fn the_precomputed_drum_equals_its_winch() {
        for layers in 1..=8 {
            let winch = Winch { layers, ..Winch::fifteen_millimetres() };
            let drum = Drum::new([winch; 1]);
            for k in -100..900 {
                let angle = winch.full() * f64::from(k) / 777.0;
                let (Row([wound]), Row([arm])) = (drum.wound(Row([angle])), drum.arm(Row([angle])));
                assert!((wound - winch.wound(angle)).abs() < 1e-12, "{layers} {angle}");
                assert!((arm - winch.arm(winch.layer(angle))).abs() < 1e-15);
                assert!((winch.angle(winch.wound(angle)) - angle).abs() < 1e-9, "{layers} {angle}");
            }
        }
    }

    #[test]
    fn a_groove_without_lead_is_a_circle() {
        let winch = Winch { lead: 0.0, ..Winch::fifteen_millimetres() };
        assert!((winch.wound(TURN) - TURN * winch.radius).abs() < 1e-15);
    }

    #[test]
    fn a_turn_takes_up_the_length_of_its_helix() {
        let winch = Winch { lead: 0.03, layers: 4, ..Winch::fifteen_millimetres() };
        for layer in 0..4 {
            let radius = 0.015 + 3e-3 * f64::from(layer);
            let point = |k: u32| {
                let angle = TURN * f64::from(k) / 2000.0;
                [radius * angle.cos(), radius * angle.sin(), winch.lead * angle / TURN]
            };
            // Chords are shorter than their arcs by a 24th of the square of their angle.
            let length: f64 = (0..2000)
                .map(|k| {
                    let (from, to) = (point(k), point(k + 1));
                    libm::sqrt((0..3).map(|i| (to[i] - from[i]).powi(2)).sum::<f64>())
                })
                .sum();
            assert!((TURN * winch.arm(layer) / length - 1.0).abs() < 5e-7, "{layer} {length}");
        }
    }
}
