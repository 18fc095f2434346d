//! Recoverable creep: a Kelvin-Voigt element in every cell of every lane.
//!
//! ```text
//! x_j <- x_j + dt/(tau + dt) (kappa c_j T_j - x_j)          x_j is added to the length of cell j
//! ```

use super::elementary::at_least;
use super::lane_group::{Creep, LaneGroup, Row};
use crate::error::{Error, non_negative, positive};
use alloc::vec;

impl<const N: usize> LaneGroup<N> {
    /// Lets the cable of a lane creep, from no creep on.
    pub(super) fn set_creep(&mut self, k: usize, fraction: f64, time: f64) -> Result<(), Error> {
        non_negative("creep.fraction", fraction)?;
        positive("creep.time", time)?;
        let cells = self.tension.len();
        let none =
            || Creep { fraction: Row::ZERO, time: Row([f64::INFINITY; N]), crept: vec![Row::ZERO; cells] };
        let creep = self.creep.get_or_insert_with(none);
        (creep.fraction.0[k], creep.time.0[k]) = (fraction, time);
        creep.crept.iter_mut().for_each(|row| row.0[k] = 0.0);
        Ok(())
    }
}

/// Lets the cables creep over an interval, s: cells lengthen, tensions are clipped at zero. An interval that
/// is not above zero and finite changes nothing.
#[inline(always)]
pub(super) fn creep<const N: usize>(lanes: &mut LaneGroup<N>, interval: f64) {
    let Some(creep) = &mut lanes.creep else { return };
    if !(interval > 0.0 && interval.is_finite()) {
        return;
    }
    let (fraction, mut rate, mut taut) = (creep.fraction, Row::<N>::ZERO, Row::<N>::ZERO);
    for k in 0..N {
        rate.0[k] = interval / (creep.time.0[k] + interval);
        // A factor, not a condition: the loop over the cells has no branch then.
        taut.0[k] = if rate.0[k] > 0.0 && lanes.stretch.0[k] > 0.0 { 1.0 } else { 0.0 };
    }
    let (mut grown, mut stretch, mut energy) = (Row::<N>::ZERO, Row::<N>::ZERO, Row::<N>::ZERO);
    let cells = lanes.tension.iter_mut().zip(&lanes.compliance).zip(&lanes.stiffness).zip(&mut creep.crept);
    for (((tension, compliance), stiffness), crept) in cells {
        let (mut t, c, stiff, mut x) = (*tension, *compliance, *stiffness, *crept);
        for k in 0..N {
            let growth = rate.0[k] * (fraction.0[k] * c.0[k] * t.0[k] - x.0[k]);
            x.0[k] += growth;
            grown.0[k] += growth;
            t.0[k] = at_least(t.0[k] - taut.0[k] * growth * stiff.0[k], 0.0);
            stretch.0[k] += c.0[k] * t.0[k];
            energy.0[k] += c.0[k] * t.0[k] * t.0[k];
        }
        (*tension, *crept) = (t, x);
    }
    for k in 0..N {
        if taut.0[k] > 0.0 {
            (lanes.stretch.0[k], lanes.energy.0[k]) = (stretch.0[k], energy.0[k]);
        } else if rate.0[k] > 0.0 {
            // A slack cable that shrinks stays without tension until an end moves.
            lanes.stretch.0[k] = (lanes.stretch.0[k] - grown.0[k]).min(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bare::law;
    use super::super::lane_group::{Ends, Motion};
    use super::super::step::advance;
    use super::super::{CableLaw, CableParameters, CablePath};
    use super::*;

    /// The law of one cell, written out for one cable: growth of `x_j`.
    fn growth(interval: f64, fraction: f64, time: f64, compliance: f64, tension: f64, crept: f64) -> f64 {
        interval / (time + interval) * (fraction * compliance * tension - crept)
    }

    #[test]
    #[expect(clippy::needless_range_loop, reason = "cells and lanes index several arrays at once")]
    fn lanes_creep_to_the_bit_as_the_law_written_out_for_one_cable_and_others_not_at_all() {
        let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 11).unwrap();
        let mut lanes = LaneGroup::<8>::new(std::slice::from_ref(&law));
        // Every second lane creeps.
        let of = |k: usize| k.is_multiple_of(2).then_some((0.02 + 0.01 * k as f64, 0.5 + k as f64));
        for k in 0..8 {
            if let Some((fraction, time)) = of(k) {
                lanes.set_creep(k, fraction, time).unwrap();
            }
        }
        let mut crept = vec![[0.0; 8]; 11];
        let (mut taut, mut slack) = (0, 0);
        for step in 0..600 {
            let pull = |k: usize| 4e-4 * libm::sin(0.02 * f64::from(step) + k as f64);
            let motion = Motion { motor: Row(core::array::from_fn(pull)), anchor: Row::ZERO };
            let mut ends = Ends { near: Row::ZERO, far: Row::ZERO, dissipated: Row::ZERO };
            advance(&mut lanes, 1e-3, &motion, &mut ends);
            let before = lanes.clone();
            creep(&mut lanes, 1e-3);
            for k in 0..8 {
                let (mut grown, mut stretch, mut energy) = (0.0, 0.0, 0.0);
                for j in 0..11 {
                    let (t, c) = (before.tension[j].0[k], before.compliance[j].0[k]);
                    let growth =
                        of(k).map_or(0.0, |(fraction, time)| growth(1e-3, fraction, time, c, t, crept[j][k]));
                    crept[j][k] += growth;
                    grown += growth;
                    let loaded = before.stretch.0[k] > 0.0;
                    let eased = if loaded { (t - growth * before.stiffness[j].0[k]).max(0.0) } else { t };
                    assert_eq!(lanes.tension[j].0[k].to_bits(), eased.to_bits(), "{step} {j} {k}");
                    stretch += c * eased;
                    energy += c * eased * eased;
                }
                let lengthened = of(k).is_some() && before.stretch.0[k] > 0.0;
                let energy = if lengthened { energy } else { before.energy.0[k] };
                assert_eq!(lanes.energy.0[k].to_bits(), energy.to_bits(), "{step} {k}");
                let expected = match of(k) {
                    None => before.stretch.0[k],
                    Some(_) if before.stretch.0[k] > 0.0 => stretch,
                    Some(_) => (before.stretch.0[k] - grown).min(0.0),
                };
                assert_eq!(lanes.stretch.0[k].to_bits(), expected.to_bits(), "{step} {k}");
                *(if before.stretch.0[k] > 0.0 { &mut taut } else { &mut slack }) += 1;
            }
        }
        assert!(taut > 500 && slack > 500, "{taut} {slack}: both have to occur");
    }

    #[test]
    fn a_held_cable_relaxes_to_its_tension_over_one_and_the_share() {
        // Constant length: c T + x = c T_0, hence x_n = c T_0 fraction/(1 + fraction) (1 - (1 - r (1 +
        // fraction))^n).
        let (fraction, time, interval) = (0.25, 0.4, 1e-2);
        let mut lanes = LaneGroup::<1>::new(&[law(&[2e-4, 5e-4], &[0.1])]);
        lanes.settle(0, 40.0, crate::transmission::Sliding::TowardMotor);
        lanes.set_creep(0, fraction, time).unwrap();
        let before = lanes.clone();
        let rate = interval / (time + interval);
        for n in 1..=400 {
            creep(&mut lanes, interval);
            let crept =
                fraction / (1.0 + fraction) * (1.0 - libm::pow(1.0 - rate * (1.0 + fraction), f64::from(n)));
            for (tension, before) in lanes.tension.iter().zip(&before.tension) {
                assert!((tension.0[0] / before.0[0] - (1.0 - crept)).abs() < 3e-15, "{n}");
            }
            assert!((lanes.stretch.0[0] / before.stretch.0[0] - (1.0 - crept)).abs() < 2e-15);
            assert!((lanes.energy.0[0] / before.energy.0[0] - (1.0 - crept) * (1.0 - crept)).abs() < 3e-15);
        }
        assert!((lanes.tension[1].0[0] - 40.0 / 1.25).abs() < 6e-5);
    }

    #[test]
    fn a_slack_cable_that_recovers_takes_up_its_slack_and_no_more() {
        let mut lanes = LaneGroup::<1>::new(&[law(&[2e-4, 5e-4], &[0.1])]);
        lanes.set_creep(0, 0.2, 0.1).unwrap();
        lanes.creep.as_mut().unwrap().crept.fill(Row([1e-3]));
        lanes.stretch = Row([-1.5e-3]);
        for n in 1..=200 {
            creep(&mut lanes, 1e-2);
            // Two cells have crept by 1 mm each, of which 1.5 mm in all are slack.
            let recovered = 2e-3 * (1.0 - libm::pow(0.1 / 0.11, f64::from(n)));
            assert!((lanes.stretch.0[0] - (recovered - 1.5e-3).min(0.0)).abs() < 2e-18, "{n}");
            assert!(lanes.tension.iter().all(|tension| tension.0[0] == 0.0), "{n}");
        }
    }

    #[test]
    fn an_interval_that_is_none_changes_nothing_then_or_later() {
        let of = |lanes: &LaneGroup<1>| {
            let crept = &lanes.creep.as_ref().unwrap().crept;
            let rows = lanes.tension.iter().chain(crept).chain([&lanes.stretch, &lanes.energy]);
            rows.map(|row| row.0[0].to_bits()).collect::<vec::Vec<_>>()
        };
        let mut lanes = LaneGroup::<1>::new(&[law(&[2e-4, 5e-4], &[0.1])]);
        lanes.settle(0, 40.0, crate::transmission::Sliding::TowardMotor);
        lanes.set_creep(0, 0.2, 0.1).unwrap();
        creep(&mut lanes, 1e-2);
        let before = of(&lanes);
        for interval in [0.0, -1e-3, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            creep(&mut lanes, interval);
            assert_eq!(of(&lanes), before, "{interval}");
        }
    }

    #[test]
    fn what_is_no_creep_is_refused() {
        let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 11).unwrap();
        let mut lanes = LaneGroup::<1>::new(&[law]);
        assert!(lanes.set_creep(0, -0.1, 1.0).is_err() && lanes.set_creep(0, 0.1, 0.0).is_err());
        assert!(lanes.set_creep(0, 0.1, f64::NAN).is_err() && lanes.creep.is_none());
    }
}
