//! Recordings that occur twice: used once, because a copy leaks from training to held-out data.

use super::types::Sequence;
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

/// Shorter sequences can be equal by chance, for instance while nothing moves.
const MIN_SAMPLES: usize = 20;

/// For every sequence, the sequence of an earlier log that holds the same samples.
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

fn bits(sequence: &Sequence) -> impl Iterator<Item = u64> + '_ {
    sequence.inputs.iter().chain(&sequence.far).map(|x| x.to_bits())
}

fn fingerprint(sequence: &Sequence) -> u64 {
    let mut hasher = DefaultHasher::new();
    bits(sequence).for_each(|b| b.hash(&mut hasher));
    hasher.finish()
}

fn same(a: &Sequence, b: &Sequence) -> bool {
    a.inputs.len() == b.inputs.len() && a.far.len() == b.far.len() && bits(a).eq(bits(b))
}
