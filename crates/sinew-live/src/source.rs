//! What a page can show.

use crate::command::Command;
use crate::error::LiveError;
use serde_json::Value;

/// A machine on the page: simulated there, recorded, or in a run that goes on elsewhere. One thread owns it.
pub trait Source: Send {
    /// Number of the present scene.
    fn revision(&self) -> u32;

    /// The answer to `/scene`.
    ///
    /// # Errors
    /// For a machine whose kinematics cannot be evaluated.
    fn scene(&mut self) -> Result<Value, LiveError>;

    /// The next state message.
    ///
    /// # Errors
    /// As [`scene`](Self::scene).
    fn state(&mut self) -> Result<Vec<u8>, LiveError>;

    /// Lets real time pass, s, until `is_spent` says that the next picture is due or a command waits.
    ///
    /// # Errors
    /// Where the source has failed, which ends the page.
    fn advance(&mut self, seconds: f64, is_spent: &mut dyn FnMut() -> bool) -> Result<(), LiveError>;

    /// Executes a command.
    ///
    /// # Errors
    /// The reason for which it is refused, for the person at the page.
    fn command(&mut self, command: &Command) -> Result<(), String>;

    /// The signals before now, of a source whose time can be set, as a message; see `docs/live.md`.
    ///
    /// # Errors
    /// As [`scene`](Self::scene).
    fn history(&mut self) -> Result<Option<Vec<u8>>, LiveError> {
        Ok(None)
    }
}
