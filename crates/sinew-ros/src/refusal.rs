use std::fmt::Display;

/// Why something that another node sent has no effect.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{place}: expected {expected}, got {got}")]
pub struct Refusal {
    /// Which part of it.
    pub place: String,
    /// What belongs there.
    pub expected: String,
    /// What is there.
    pub got: String,
}

impl Refusal {
    pub(crate) fn new(place: impl Display, expected: impl Display, got: impl Display) -> Self {
        Self { place: place.to_string(), expected: expected.to_string(), got: got.to_string() }
    }

    /// Of bytes that are no message of a type.
    pub(crate) fn bytes(kind: &str) -> Self {
        Self::new("message", format!("{kind} in CDR"), "other bytes")
    }
}

/// Joints that a message names: where each joint of the machine stands in it.
///
/// # Errors
/// Where they are not the machine's joints, each once.
pub(crate) fn places(place: &str, given: &[&str], joints: &[String]) -> Result<Vec<usize>, Refusal> {
    let found: Option<Vec<usize>> =
        joints.iter().map(|joint| given.iter().position(|name| name == joint)).collect();
    match found {
        Some(found) if given.len() == joints.len() => Ok(found),
        _ => Err(Refusal::new(place, format!("each once: {}", joints.join(", ")), listed(given))),
    }
}

/// Names as they were sent, cut where they are many.
fn listed(names: &[&str]) -> String {
    const MOST: usize = 200;
    let text = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
    // Others' names may hold line breaks.
    let text = text.escape_debug().to_string();
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{} ..", text.get(..end).unwrap_or_default()),
        None => text,
    }
}

/// A coordinate of every joint of the machine, within its range.
///
/// # Errors
/// Names the first that is not.
pub(crate) fn coordinates(
    place: &str,
    given: &[f64],
    places: &[usize],
    joints: &[String],
    ranges: &[[f64; 2]],
) -> Result<Vec<f64>, Refusal> {
    if given.len() != joints.len() {
        return Err(Refusal::new(place, format!("{} numbers", joints.len()), given.len()));
    }
    let each = places.iter().zip(joints).zip(ranges).map(|((place_of, joint), [low, high])| {
        let x = given.get(*place_of).copied().unwrap_or(f64::NAN);
        if x >= *low && x <= *high {
            Ok(x)
        } else {
            Err(Refusal::new(format!("{place} of {joint}"), format!("{low} to {high}"), x))
        }
    });
    each.collect()
}
