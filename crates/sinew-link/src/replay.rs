//! Which sequence numbers have been seen.

/// Numbers behind the newest that are told apart.
const WIDTH: u64 = 64;

/// Window of the sequence numbers received from the other side.
///
/// # Source
/// RFC 4303, section 3.4.3 and appendix A2, with a window of 64.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ReplayWindow {
    newest: u64,
    /// Bit k: `newest - k` has been received.
    seen: u64,
}

/// What a window says of a sequence number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Freshness {
    /// Above all before.
    Newest,
    /// Overtaken by others, seen for the first time.
    Late,
    /// Seen before.
    Replayed,
    /// Behind the window, or 0, which no packet has.
    Old,
}

impl ReplayWindow {
    /// Newest number that was accepted; 0 before the first.
    #[must_use]
    pub fn newest(self) -> u64 {
        self.newest
    }

    /// Judges a number without recording it.
    #[must_use]
    pub fn judge(self, sequence: u64) -> Freshness {
        if sequence > self.newest {
            return Freshness::Newest;
        }
        let behind = self.newest - sequence;
        if sequence == 0 || behind >= WIDTH {
            Freshness::Old
        } else if self.seen >> behind & 1 == 1 {
            Freshness::Replayed
        } else {
            Freshness::Late
        }
    }

    /// Records a number of an authentic packet.
    pub fn record(&mut self, sequence: u64) {
        if sequence > self.newest {
            let ahead = sequence - self.newest;
            self.seen = if ahead < WIDTH { self.seen << ahead | 1 } else { 1 };
            self.newest = sequence;
        } else if sequence > 0 && self.newest - sequence < WIDTH {
            self.seen |= 1 << (self.newest - sequence);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    proptest! {
        #[test]
        fn a_number_is_accepted_once_and_never_behind_the_window(
            steps in prop::collection::vec((0_u64..200, any::<bool>()), 1..300),
        ) {
            let (mut window, mut seen) = (ReplayWindow::default(), BTreeSet::new());
            for (step, forward) in steps {
                let newest = seen.last().copied().unwrap_or(0);
                let sequence = if forward { newest + step } else { newest.saturating_sub(step) };
                let expected = if sequence > newest {
                    Freshness::Newest
                } else if sequence == 0 || newest - sequence >= 64 {
                    Freshness::Old
                } else if seen.contains(&sequence) {
                    Freshness::Replayed
                } else {
                    Freshness::Late
                };
                prop_assert_eq!(window.judge(sequence), expected);
                if matches!(expected, Freshness::Newest | Freshness::Late) {
                    window.record(sequence);
                    seen.insert(sequence);
                }
            }
        }
    }

    #[test]
    fn the_largest_number_does_not_wrap() {
        let mut window = ReplayWindow::default();
        window.record(u64::MAX);
        assert_eq!(window.judge(u64::MAX), Freshness::Replayed);
        assert_eq!(window.judge(1), Freshness::Old);
        assert_eq!(window.judge(u64::MAX - 63), Freshness::Late);
    }
}
