//! Counted occurrences with the places of the first few, for findings.

/// Places named one by one before the rest is only counted.
const PLACES: usize = 5;

/// `1 gap`, `2 gaps`.
pub(super) fn counted(count: usize, one: &str) -> String {
    format!("{count} {one}{}", if count == 1 { "" } else { "s" })
}

/// Something that occurs repeatedly: counted, with the places of the first few.
#[derive(Default)]
pub(super) struct Occurrences {
    /// How often it happened.
    pub(super) count: usize,
    places: Vec<String>,
}

impl Occurrences {
    /// Counts one more, and keeps its place if it is among the first.
    pub(super) fn record(&mut self, place: impl FnOnce() -> String) {
        self.count += 1;
        if self.places.len() < PLACES {
            self.places.push(place());
        }
    }

    /// The first places, and how many there are besides.
    pub(super) fn places(&self) -> String {
        let more = self.count - self.places.len();
        let tail = if more > 0 { format!(" and {more} more") } else { String::new() };
        format!("{}{tail}", self.places.join(", "))
    }
}
