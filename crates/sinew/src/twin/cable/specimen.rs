//! Parameters of one cable of the plant: the calibrated one, or one drawn around it.

use super::effects::{
    BraidCreep, Breakage, DragHeat, Effects, SheathCompliance, SlowFriction, UnevenCurvature,
};
use crate::Error;
use crate::random::Random;
use crate::transmission::cable::{CableLaw, CableParameters, CablePath, Segment, Weakening};
use alloc::vec::Vec;

/// A cable with its path, its parameters and its effects.
#[derive(Debug, Clone, PartialEq)]
pub struct Specimen {
    /// Sheaths, pulleys and free lengths.
    pub path: CablePath,
    /// Friction and elasticity, without the effects.
    pub parameters: CableParameters,
    /// Effects beside the law.
    pub effects: Effects,
}

/// Ratio of the cable's own compliance to the calibrated one: the wall of the sheath adds a tenth over half
/// of the length, creep about 2 %.
const COMPLIANCE_LEFT: f64 = 0.93;
/// Ratio of the cold cable's drag to the calibrated one: half a minute at the higher speeds warms it by a few
/// kelvin. Of 1.05 to 1.2 in steps of 0.05, 1.15 is closest to Tables II and III of `yuan2023` (7.4 % rms).
const COLD_DRAG: f64 = 1.15;

impl Specimen {
    /// The bench as calibrated, every effect at its default size.
    ///
    /// The tables of `yuan2023` were measured with all effects present: the cable's own compliance is lower
    /// than the calibrated one by the contribution of sheath and creep (`COMPLIANCE_LEFT`), and its cold drag
    /// higher by that of heat (`COLD_DRAG`).
    #[must_use]
    pub fn bench() -> Self {
        let calibrated = CableParameters::bench();
        let parameters = CableParameters {
            compliance: COMPLIANCE_LEFT * calibrated.compliance,
            drag: COLD_DRAG * calibrated.drag,
            ..calibrated
        };
        Self { path: CablePath::bench(), parameters, effects: Effects::default() }
    }

    /// The law alone with calibrated parameters: for comparisons.
    #[must_use]
    pub fn ideal() -> Self {
        Self { path: CablePath::bench(), parameters: CableParameters::bench(), effects: Effects::none() }
    }

    /// A random specimen of the bench's cable; the same seed gives the same specimen.
    ///
    /// Standard deviations are those of the calibration: friction 4 %, drag 22 %, pretension 12 %, near free
    /// length 25 %, compliance 3 %, all clipped to two standard deviations; effects between half and one
    /// and a half of their default sizes.
    #[must_use]
    pub fn draw(seed: u64) -> Self {
        Self::sampled_around(&Self::bench(), seed)
    }

    /// A random specimen of another design: its parameters, its near free length and its effects times the
    /// factors of [`draw`](Self::draw). Uneven curvature, where present, is drawn anew as six parts; the
    /// breaking tension is kept.
    #[must_use]
    pub fn sampled_around(of: &Self, seed: u64) -> Self {
        let mut draw = Draws(Random::new(seed));
        let mut parameters = of.parameters;
        parameters.friction *= draw.around(0.04);
        parameters.drag *= draw.around(0.22);
        parameters.pretension *= draw.around(0.12);
        parameters.compliance *= draw.around(0.03);
        let near = draw.around(0.25);
        let mut segments: Vec<Segment> = of.path.segments().to_vec();
        // The total length is kept: the far end is shorter by what the near end is longer.
        if let (Some(Segment::Free { length: first }), Some(Segment::Free { length: last })) =
            (segments.first().cloned(), segments.last().cloned())
        {
            let gained = (first * (near - 1.0)).clamp(-0.5 * first, 0.5 * last);
            if let Some(Segment::Free { length }) = segments.first_mut() {
                *length += gained;
            }
            if let Some(Segment::Free { length }) = segments.last_mut() {
                *length -= gained;
            }
        }
        let path = CablePath::new(segments).unwrap_or_else(|_| of.path.clone());
        Self { path, parameters, effects: draw.effects(&of.effects) }
    }

    /// The cable law discretised into `cells` cells, with those effects that belong to it.
    ///
    /// # Errors
    /// As [`CableLaw::new`] and [`Effects::validate`].
    pub fn law(&self, cells: usize) -> Result<CableLaw, Error> {
        self.effects.validate()?;
        let mut parameters = self.parameters;
        if let Some(sheath) = &self.effects.sheath {
            parameters.sheath_compliance += sheath.compliance;
        }
        if let Some(slow) = &self.effects.slow {
            parameters.weakening = Some(slow.weakening);
        }
        let mut segments = self.path.segments().to_vec();
        if let Some(uneven) = &self.effects.curvature {
            for segment in &mut segments {
                if let Segment::Sheath { curvature, .. } = segment {
                    curvature.clone_from(&uneven.parts);
                }
            }
        }
        CableLaw::new(&CablePath::new(segments)?, &parameters, cells)
    }
}

/// Factors from a seed.
struct Draws(Random);

impl Draws {
    /// A factor around 1 of this relative standard deviation, clipped to two: approximately normal, as the
    /// sum of twelve uniform numbers.
    fn around(&mut self, deviation: f64) -> f64 {
        let sum: f64 = (0..12).map(|_| self.0.unit()).sum();
        1.0 + deviation * (sum - 6.0).clamp(-2.0, 2.0)
    }

    /// A factor in [0.5, 1.5).
    fn half(&mut self) -> f64 {
        0.5 + self.0.unit()
    }

    fn effects(&mut self, of: &Effects) -> Effects {
        // Every number is drawn whether its effect is present or not: leaving one out changes no other.
        let parts: Vec<f64> = (0..6).map(|_| self.half()).collect();
        let [sheath, softening, fraction, rise] = [self.half(), self.half(), self.half(), self.half()];
        let [speed, lag] = [self.half(), self.half()];
        Effects {
            curvature: of.curvature.as_ref().map(|_| UnevenCurvature { parts }),
            sheath: of.sheath.map(|s| SheathCompliance { compliance: s.compliance * sheath }),
            heat: of.heat.map(|h| DragHeat { softening: h.softening * softening, ..h }),
            creep: of.creep.map(|c| BraidCreep { fraction: c.fraction * fraction, ..c }),
            slow: of.slow.map(|slow| {
                let Weakening { form, rise: most, speed: half, lag: memory } = slow.weakening;
                let weakening = Weakening { form, rise: most * rise, speed: half * speed, lag: memory * lag };
                SlowFriction { weakening }
            }),
            breakage: of.breakage.map(|b| Breakage { tension: b.tension }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_always_draws_the_same_specimen_and_another_seed_another() {
        assert_eq!(Specimen::draw(5), Specimen::draw(5));
        assert!(
            Specimen::draw(5).parameters.friction < Specimen::draw(6).parameters.friction
                || Specimen::draw(5).parameters.friction > Specimen::draw(6).parameters.friction
        );
    }

    #[test]
    fn every_specimen_is_a_cable_and_they_scatter_as_documented() {
        let (mut sum, mut squares) = (0.0, 0.0);
        for seed in 0..400 {
            let specimen = Specimen::draw(seed);
            assert!(specimen.law(24).is_ok());
            assert!((specimen.path.length() - CablePath::bench().length()).abs() < 1e-12);
            let relative = specimen.parameters.drag / Specimen::bench().parameters.drag - 1.0;
            sum += relative;
            squares += relative * relative;
        }
        let deviation = libm::sqrt(squares / 400.0);
        assert!((sum / 400.0_f64).abs() < 0.03 && (0.16..0.24).contains(&deviation), "{sum} {deviation}");
    }

    #[test]
    fn leaving_an_effect_out_changes_no_other() {
        let mut without = Specimen::bench();
        without.effects.sheath = None;
        let (all, less) = (Specimen::draw(3), Specimen::sampled_around(&without, 3));
        assert_eq!(all.parameters, less.parameters);
        assert_eq!((all.effects.creep, all.effects.slow), (less.effects.creep, less.effects.slow));
        assert!(less.effects.sheath.is_none() && all.effects.sheath.is_some());
    }
}
