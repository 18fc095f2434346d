/// What one sensor says, since when it is not believed, and whether it says the same although it should not.
///
/// ```text
/// believed:   |y - y_last| <= d_max (1 + t_missing/h)   and   |int v dt| since y was new <= x_stuck
/// ```
///
/// A value that is not a number is never believed. `v` is what the other side of its loop says of it: a sensor that repeats itself
/// to the bit while it should have gone further than its counts, its noise and its lag explain, is stuck.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Channel {
    /// What it said last that could be believed.
    pub(super) last: f64,
    /// Since when it is not believed, s.
    pub(super) missing: f64,
    /// Since when it says the same, s.
    pub(super) still: f64,
    /// How far it should have gone meanwhile.
    due: f64,
    heard: f64,
}

impl Channel {
    /// Whether what it says can be believed; `due` is how far it should have gone since the sample before, there and back.
    pub(super) fn judge(&mut self, h: f64, said: f64, due: f64, bounds: &Bounds) -> bool {
        if said.to_bits() == self.heard.to_bits() {
            (self.still, self.due) = (self.still + h, self.due + due);
        } else {
            (self.still, self.due) = (0.0, 0.0);
        }
        self.heard = said;
        let near = (said - self.last).abs() <= bounds.step * (1.0 + self.missing / h);
        let good = near && self.due.abs() <= bounds.stuck;
        if good {
            (self.last, self.missing) = (said, 0.0);
        } else {
            self.missing += h;
        }
        good
    }
}

/// What a sensor can say.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    /// Largest change in a millisecond.
    pub(super) step: f64,
    /// Largest way that it may leave out.
    pub(super) stuck: f64,
}
