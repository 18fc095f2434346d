//! How far an end must move for a tension, and the tension after it has moved: exact for friction without speed.

/// A cell as the moving end sees it, the nearest first.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Seen {
    /// `T_j`, N.
    pub(super) tension: f64,
    /// `c_j`, m/N.
    pub(super) compliance: f64,
    /// `E_j`: tension here over that at the end, where everything between slides.
    pub(super) ratio: f64,
}

/// Travel of the end, m, that brings its tension to `wanted` while the other end is held.
///
/// ```text
/// X(T*) = sum_j c_j (T* E_j - T_j)   over cells with s (T* E_j - T_j) > 0
/// ```
///
/// `s = 1` pulls (`E_j` falls along the cable), `s = -1` yields (`E_j` grows).
pub(super) fn travel(cells: impl Iterator<Item = Seen>, wanted: f64, s: f64) -> f64 {
    cells
        .map(|cell| (wanted * cell.ratio - cell.tension, cell.compliance))
        .filter(|(change, _)| s * change > 0.0)
        .map(|(change, compliance)| compliance * change)
        .sum()
}

/// Moves the end by `distance`, m: positive pulls, negative yields; the other end is held.
///
/// The inverse of [`travel`] in `T*`, then `T_j <- max(T_j, T* E_j)`, or `min` where it yields. `X` is piecewise
/// linear and, times `s`, convex in `T*`: Newton's method from beyond reaches the root in as many steps as
/// the set of sliding cells changes. Returns the tension at the end.
///
/// It creates no energy: with `T'` after and `T` before, `T'_end d - sum c (T'^2 - T^2)/2 = sum c (T' - T)(T'_end
/// - (T' + T)/2) >= 0`, because where tension rises it stays below `T'_end`, and above where it falls.
pub(super) fn move_end(cells: &mut [Seen], distance: f64) -> f64 {
    let Some(end) = cells.first().map(|cell| cell.tension) else { return 0.0 };
    if distance == 0.0 {
        return end;
    }
    let s = if distance > 0.0 { 1.0 } else { -1.0 };
    let (mut wanted, mut sliding) = (f64::INFINITY * s, 0);
    for _ in 0..=cells.len() {
        let (mut stretch, mut weight, mut count) = (distance, 0.0, 0);
        for cell in cells.iter() {
            if wanted.is_infinite() || s * (wanted * cell.ratio - cell.tension) > 0.0 {
                stretch += cell.compliance * cell.tension;
                weight += cell.compliance * cell.ratio;
                count += 1;
            }
        }
        if count == 0 || count == sliding {
            break;
        }
        (wanted, sliding) = ((stretch / weight).max(0.0), count);
    }
    if wanted.is_infinite() {
        return end;
    }
    for cell in cells.iter_mut() {
        let slid = wanted * cell.ratio;
        if s * (slid - cell.tension) > 0.0 {
            cell.tension = slid;
        }
    }
    cells.first().map_or(end, |cell| cell.tension)
}
