//! A map of bounded size.

use std::collections::{HashMap, VecDeque};
use std::hash::Hash;

/// The newest entries, at most so many: a further one replaces the oldest.
#[derive(Debug)]
pub(super) struct Newest<K, V> {
    entries: HashMap<K, V>,
    /// Keys in the order in which they came, also of entries that were taken out.
    order: VecDeque<K>,
    most: usize,
}

impl<K: Copy + Eq + Hash, V> Newest<K, V> {
    pub(super) fn at_most(most: usize) -> Self {
        Self { entries: HashMap::with_capacity(most), order: VecDeque::with_capacity(most), most }
    }

    pub(super) fn get(&self, key: &K) -> Option<&V> {
        self.entries.get(key)
    }

    pub(super) fn get_mut(&mut self, key: &K) -> Option<&mut V> {
        self.entries.get_mut(key)
    }

    pub(super) fn take(&mut self, key: &K) -> Option<V> {
        self.entries.remove(key)
    }

    pub(super) fn put(&mut self, key: K, value: V) {
        if self.entries.insert(key, value).is_some() {
            return;
        }
        if self.order.len() == self.most
            && let Some(oldest) = self.order.pop_front()
        {
            self.entries.remove(&oldest);
        }
        self.order.push_back(key);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_further_entry_replaces_the_oldest_and_a_changed_one_none() {
        let mut newest = Newest::at_most(3);
        (0..3).for_each(|k| newest.put(k, k));
        newest.put(0, 10);
        assert_eq!((newest.get(&0), newest.get(&1)), (Some(&10), Some(&1)));
        newest.put(3, 3);
        assert_eq!((newest.get(&0), newest.get(&1), newest.get(&3)), (None, Some(&1), Some(&3)));
        assert_eq!((newest.take(&1), newest.get(&1)), (Some(1), None));
        (4..100).for_each(|k| newest.put(k, k));
        assert_eq!((96..100).filter(|k| newest.get(k).is_some()).count(), 3);
    }
}
