//! Travel of an end for a tension, and the tension after a travel: exact for Coulomb friction.

/// A cell in the order from the moving end.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct CellView {
    /// `T_j`, N.
    pub(super) tension: f64,
    /// `c_j`, m/N.
    pub(super) compliance: f64,
    /// `E_j`: tension here over that at the end, where everything between slides.
    pub(super) ratio: f64,
}

/// Travel of the end, m, that brings its tension to `target` while the other end is held.
///
/// ```text
/// X(T*) = sum_j c_j (T* E_j - T_j)   over cells with s (T* E_j - T_j) > 0
/// ```
///
/// `s = 1` pulls (`E_j` falls along the cable), `s = -1` yields (`E_j` grows).
pub(super) fn travel(cells: impl Iterator<Item = CellView>, target: f64, s: f64) -> f64 {
    cells
        .map(|cell| (target * cell.ratio - cell.tension, cell.compliance))
        .filter(|(change, _)| s * change > 0.0)
        .map(|(change, compliance)| compliance * change)
        .sum()
}

/// Moves the end by `distance`, m: positive pulls, negative yields; the other end is held.
///
/// The inverse of [`travel`] in `T*`, then `T_j <- max(T_j, T* E_j)`, or `min` where it yields. `X` is
/// piecewise linear and, times `s`, convex in `T*`: Newton's method from beyond the root reaches it in as
/// many steps as the set of sliding cells changes. Returns the tension at the end.
///
/// It creates no energy: with `T'` after and `T` before, `T'_end d - sum c (T'^2 - T^2)/2 = sum c (T' -
/// T)(T'_end
/// - (T' + T)/2) >= 0`, because where tension rises it stays below `T'_end`, and above where it falls.
pub(super) fn move_end(cells: &mut [CellView], distance: f64) -> f64 {
    let Some(end) = cells.first().map(|cell| cell.tension) else { return 0.0 };
    if distance == 0.0 {
        return end;
    }
    let s = if distance > 0.0 { 1.0 } else { -1.0 };
    let (mut target, mut sliding) = (f64::INFINITY * s, 0);
    for _ in 0..=cells.len() {
        let (mut stretch, mut weight, mut count) = (distance, 0.0, 0);
        for cell in cells.iter() {
            if target.is_infinite() || s * (target * cell.ratio - cell.tension) > 0.0 {
                stretch += cell.compliance * cell.tension;
                weight += cell.compliance * cell.ratio;
                count += 1;
            }
        }
        if count == 0 || count == sliding {
            break;
        }
        (target, sliding) = ((stretch / weight).max(0.0), count);
    }
    if target.is_infinite() {
        return end;
    }
    for cell in cells.iter_mut() {
        let slid = target * cell.ratio;
        if s * (slid - cell.tension) > 0.0 {
            cell.tension = slid;
        }
    }
    cells.first().map_or(end, |cell| cell.tension)
}

#[cfg(test)]
mod tests {
    use super::super::bare::{Random, swept};
    use super::*;
    use alloc::vec::Vec;

    /// Cells of these tensions, seen from an end that moves in the direction `s`.
    fn view(tension: &[f64], compliance: &[f64], half_angle: &[f64], s: f64) -> Vec<CellView> {
        let mut ratio = 1.0;
        let mut cells = Vec::new();
        for (j, (&tension, &compliance)) in tension.iter().zip(compliance).enumerate() {
            if j > 0 {
                ratio *= libm::exp(-2.0 * s * half_angle[j - 1]);
            }
            cells.push(CellView { tension, compliance, ratio });
        }
        cells
    }

    #[test]
    fn an_end_moves_as_bisection_finds_from_any_tensions_and_creates_no_energy() {
        let mut random = Random(1);
        let (mut slackened, mut partly) = (0, 0);
        for case in 0..400 {
            // Differences below and above 1 N.
            let largest = if case % 2 == 0 { 0.6 } else { 60.0 };
            let tension = random.many(5, 0.0, largest);
            let (compliance, half_angle) = (random.many(5, 1e-4, 1e-3), random.many(4, 0.01, 0.2));
            let distance = random.between(-1.5e-3, 1.5e-3) * largest;
            let s = distance.signum();
            let mut cells = view(&tension, &compliance, &half_angle, s);
            let end = move_end(&mut cells, distance);
            let exact = swept(&tension, &compliance, &half_angle, distance);
            let off = cells.iter().zip(&exact).map(|(cell, exact)| (cell.tension - exact).abs());
            assert!(off.fold(0.0, f64::max) < 1e-15 * largest, "{case} {cells:?} {exact:?}");
            assert!((end - cells[0].tension).abs() < 1e-15);
            let still =
                cells.iter().zip(&tension).filter(|(cell, before)| (cell.tension - **before).abs() == 0.0);
            partly += usize::from((1..5).contains(&still.count()));

            let stored = |tensions: &mut dyn Iterator<Item = f64>| -> f64 {
                tensions.zip(&compliance).map(|(t, c)| 0.5 * c * t * t).sum()
            };
            let gained =
                stored(&mut cells.iter().map(|cell| cell.tension)) - stored(&mut tension.iter().copied());
            assert!(end * distance - gained >= -1e-15 * largest, "{case}");
            slackened += usize::from(cells.iter().all(|cell| cell.tension == 0.0));
        }
        assert!(slackened > 20 && partly > 100, "{slackened} {partly}");
    }

    #[test]
    fn the_travel_to_a_tension_moves_the_end_to_it() {
        let (tension, compliance, half_angle) = ([30.0, 20.0, 25.0], [1e-4, 3e-4, 2e-4], [0.1, 0.05]);
        for (target, s) in [(33.0, 1.0), (80.0, 1.0), (18.0, -1.0), (2.0, -1.0)] {
            let mut cells = view(&tension, &compliance, &half_angle, s);
            let distance = travel(cells.iter().copied(), target, s);
            assert!((move_end(&mut cells, distance) - target).abs() < 1e-14);
        }
    }

    #[test]
    fn an_end_that_does_not_move_keeps_every_tension() {
        // Tensions that no sweep would leave alone.
        let mut cells = view(&[3.0, 40.0, 1.0], &[1e-4; 3], &[0.1; 2], 1.0);
        let before = cells.clone();
        assert!((move_end(&mut cells, 0.0) - 3.0).abs() < 1e-15);
        assert_eq!(cells, before);
    }
}
