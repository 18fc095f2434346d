//! What a plugin derives from a model: kept per thread, found by the hash of all that it is derived from.
//!
//! `mjData` may be copied, pickled and stepped on any thread, and its `plugin_data` is copied as a number. So
//! nothing is owned by an `mjData`: `plugin_data` holds a hash, and a thread that does not know it derives
//! the wiring again from the model.

use crate::text::Config;
use crate::view::Model;
use std::hash::{DefaultHasher, Hash, Hasher};

/// Wirings of a thread: more models than these alternate at the price of deriving theirs again.
const MOST: usize = 64;

/// Wirings by their hash, the last used one first.
pub(crate) struct Wirings<T>(Vec<(u64, T)>);

impl<T> Wirings<T> {
    pub(crate) const fn new() -> Self {
        Self(Vec::new())
    }

    /// Takes a wiring in, in the place of one of the same hash.
    pub(crate) fn put(&mut self, hash: u64, wiring: T) {
        self.0.retain(|(known, _)| *known != hash);
        self.0.truncate(MOST - 1);
        self.0.insert(0, (hash, wiring));
    }

    /// The wiring of a hash, built where this thread does not have it.
    pub(crate) fn get(
        &mut self,
        hash: u64,
        build: impl FnOnce() -> Result<T, String>,
    ) -> Result<&mut T, String> {
        match self.0.iter().position(|(known, _)| *known == hash) {
            Some(at) => self.0[..=at].rotate_right(1),
            None => self.put(hash, build()?),
        }
        self.0.first_mut().map(|(_, wiring)| wiring).ok_or_else(|| "no wiring".into())
    }
}

/// The hash of an instance, of the configurations up to it, and of the actuators and tendons of the model;
/// never zero, which marks an `mjData` without hash.
///
/// All else that a plugin needs of the model is read from it in every step, because users change it.
pub(crate) fn hash_of(model: &Model<'_>, instance: usize, configs: &[Config]) -> u64 {
    let mut hasher = DefaultHasher::new();
    (instance, configs).hash(&mut hasher);
    (model.tendons, model.actuators).hash(&mut hasher);
    (model.trntype, model.trnid, model.actuator_plugin).hash(&mut hasher);
    (model.outadr, model.ctrladr, model.actadr, model.actnum).hash(&mut hasher);
    (model.names, model.name_tendonadr).hash(&mut hasher);
    hasher.finish().max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wiring_is_built_once_and_the_longest_unused_is_forgotten() {
        let mut wirings = Wirings::new();
        for hash in 0..MOST as u64 {
            wirings.get(hash, || Ok(hash)).unwrap();
        }
        assert_eq!(*wirings.get(0, || Err("forgotten".into())).unwrap(), 0);
        wirings.get(1000, || Ok(1000)).unwrap();
        assert!(wirings.get(1, || Err("forgotten".into())).is_err());
        assert!(wirings.get(0, || Err("forgotten".into())).is_ok());
        assert_eq!(wirings.0.len(), MOST);
    }
}
