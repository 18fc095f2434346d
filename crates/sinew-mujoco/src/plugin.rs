//! What both plugins are to `abi`.

use crate::text::Config;
use crate::view::{Data, Model};
use crate::wiring::Wirings;
use std::cell::RefCell;
use std::ffi::CStr;
use std::thread::LocalKey;

/// What a wiring is derived from.
pub(crate) struct Setup<'a> {
    pub(crate) model: &'a Model<'a>,
    pub(crate) instance: usize,
    /// Configurations of the instances of the same plugin up to this one, which is the last.
    pub(crate) configs: &'a [Config],
}

impl Setup<'_> {
    /// This instance's configuration, and those of the instances before it.
    pub(crate) fn config(&self) -> (&[String], &[Config]) {
        self.configs.split_last().map_or((&[], &[]), |(own, earlier)| (own, earlier))
    }
}

/// A plugin: its constants, what it derives from a model, and its work in a step.
pub(crate) trait Plugin: Sized + 'static {
    /// Name in models.
    const NAME: &'static CStr;
    /// Attributes of its configuration.
    const ATTRIBUTES: &'static [&'static CStr];

    /// Numbers of state of an instance; called before actuators have their transmissions.
    fn state_len(model: &Model<'_>, instance: usize, config: &Config) -> usize;

    /// Derives the wiring and checks the configuration against the model.
    fn wire(setup: &Setup<'_>) -> Result<Self, String>;

    /// Writes forces; changes nothing that a second call would see.
    fn compute(&mut self, model: &Model<'_>, data: &mut Data<'_>, instance: usize);

    /// Ends a time step.
    fn advance(&mut self, model: &Model<'_>, data: &mut Data<'_>, instance: usize);

    /// Those of the calling thread.
    fn wirings() -> &'static LocalKey<RefCell<Wirings<Self>>>;
}
