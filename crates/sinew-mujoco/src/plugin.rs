//! What both plugins are to `abi`.

use crate::view::{Data, Model};
use crate::wiring::Wirings;
use std::cell::RefCell;
use std::ffi::CStr;
use std::thread::LocalKey;

/// Configuration of one plugin instance: the value of every attribute, empty where it is not given.
pub(crate) type Config = Vec<String>;

/// What a wiring is derived from.
pub(crate) struct Setup<'a> {
    pub(crate) model: &'a Model<'a>,
    pub(crate) instance: usize,
    pub(crate) config: &'a Config,
    /// Configurations of the instances of the same plugin that come before this one.
    pub(crate) earlier: &'a [Config],
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

    /// The wirings of the calling thread.
    fn wirings() -> &'static LocalKey<RefCell<Wirings<Self>>>;
}
