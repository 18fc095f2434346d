//! Sequences that two logs contain: only the first is used. With one copy in the training data and the other
//! in the held-out data, the error on held-out data would be underestimated (data leakage).

use super::types::Sequence;
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

/// Number of samples below which equal sequences do not count as copies: short ones can be equal by chance,
/// for instance while nothing moves. The value is assumed.
const MIN_SAMPLES: usize = 20;

/// For every sequence, the index of the first one with the same samples in an earlier log: `[sequences]`.
///
/// Samples are the same where inputs and far side agree bit by bit. Times, rows and labels are not compared,
/// so that a copy with another time origin is found. Repetitions within one log are not copies.
pub(super) fn find(sequences: &[Sequence]) -> Vec<Option<usize>> {
    let mut seen: HashMap<u64, Vec<usize>> = HashMap::new();
    let mut twins = Vec::with_capacity(sequences.len());
    for (i, sequence) in sequences.iter().enumerate() {
        if sequence.row.len() < MIN_SAMPLES {
            twins.push(None);
            continue;
        }
        let earlier = seen.entry(fingerprint(sequence)).or_default();
        let twin = earlier
            .iter()
            .copied()
            .find(|&j| sequences[j].log != sequence.log && same(&sequences[j], sequence));
        if twin.is_none() {
            earlier.push(i);
        }
        twins.push(twin);
    }
    twins
}

/// Bit patterns of inputs and far side; they are equal also where a value is missing (NaN).
fn bits(sequence: &Sequence) -> impl Iterator<Item = u64> + '_ {
    sequence.inputs.iter().chain(&sequence.far).map(|x| x.to_bits())
}

/// Hash of the samples; equal hashes are confirmed by [`same`].
fn fingerprint(sequence: &Sequence) -> u64 {
    let mut hasher = DefaultHasher::new();
    bits(sequence).for_each(|b| b.hash(&mut hasher));
    hasher.finish()
}

fn same(a: &Sequence, b: &Sequence) -> bool {
    a.inputs.len() == b.inputs.len() && a.far.len() == b.far.len() && bits(a).eq(bits(b))
}
