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
