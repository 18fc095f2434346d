//! The pre-shared key and its file.

use crate::error::KeyFileError;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::Path;
use zeroize::{Zeroize, Zeroizing};

/// A pre-shared key of 256 bits; overwritten in memory when dropped, never shown.
#[derive(Clone, PartialEq, Eq)]
pub struct Key([u8; Key::SIZE]);

impl std::fmt::Debug for Key {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Key(redacted)")
    }
}

impl Drop for Key {
    fn drop(&mut self) {
        self.0.zeroize();
    }
}

/// Permissions of group and others.
const OTHERS: u32 = 0o077;

impl Key {
    /// Bytes of a key.
    pub const SIZE: usize = 32;

    /// The key of links without one: 32 zero bytes. Tags then show damage, not origin.
    #[must_use]
    pub fn none() -> Self {
        Self([0; Self::SIZE])
    }

    /// A key of these bytes.
    #[must_use]
    pub fn new(bytes: [u8; Self::SIZE]) -> Self {
        Self(bytes)
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// Writes a new random key to a new file that its owner alone may read and write.
    ///
    /// # Errors
    /// [`KeyFileError`] where the file exists or cannot be written; a file that was begun is removed.
    pub fn create(path: &Path) -> Result<Self, KeyFileError> {
        let name = || path.display().to_string();
        let mut key = Self([0; Self::SIZE]);
        getrandom::fill(&mut key.0).map_err(|source| KeyFileError::Random { file: name(), source })?;
        let mut file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .mode(0o600)
            .open(path)
            .map_err(|source| KeyFileError::File { file: name(), source })?;
        let text = key.to_hex();
        if let Err(source) = file.write_all(text.as_bytes()).and_then(|()| file.sync_all()) {
            let _ = std::fs::remove_file(path);
            return Err(KeyFileError::File { file: name(), source });
        }
        Ok(key)
    }

    /// Reads a key file, which nobody but its owner may read.
    ///
    /// # Errors
    /// [`KeyFileError`] names the file and what is wrong with it.
    pub fn read(path: &Path) -> Result<Self, KeyFileError> {
        let name = || path.display().to_string();
        let failed = |source| KeyFileError::File { file: name(), source };
        let file = File::open(path).map_err(failed)?;
        let about = file.metadata().map_err(failed)?;
        if !about.is_file() {
            return Err(KeyFileError::Content { file: name(), got: "not a regular file".into() });
        }
        let mode = about.mode() & 0o7777;
        if mode & OTHERS != 0 {
            return Err(KeyFileError::Permissions { file: name(), mode });
        }
        // One digit pair more than a key, so that a longer file is seen; never more of a wrong file.
        let mut text = Zeroizing::new(Vec::with_capacity(2 * Self::SIZE + 3));
        match file.take(2 * Self::SIZE as u64 + 3).read_to_end(&mut text) {
            Ok(_) => {}
            Err(source) if source.kind() == ErrorKind::InvalidData => {
                return Err(KeyFileError::Content { file: name(), got: "bytes".into() });
            }
            Err(source) => return Err(failed(source)),
        }
        let digits = text.strip_suffix(b"\r\n").or_else(|| text.strip_suffix(b"\n")).unwrap_or(&text);
        Self::from_hex(digits).ok_or_else(|| {
            let expected = 2 * Self::SIZE;
            let got = match digits.len() {
                n if n > expected => format!("more than {expected} characters"),
                n if n < expected => format!("{n} characters"),
                _ => "other characters".to_owned(),
            };
            KeyFileError::Content { file: name(), got }
        })
    }

    fn to_hex(&self) -> Zeroizing<String> {
        let mut text = Zeroizing::new(String::with_capacity(2 * Self::SIZE + 1));
        for byte in self.0 {
            for digit in [byte >> 4, byte & 15] {
                text.push(char::from_digit(u32::from(digit), 16).unwrap_or('0'));
            }
        }
        text.push('\n');
        text
    }

    fn from_hex(digits: &[u8]) -> Option<Self> {
        let mut key = Self([0; Self::SIZE]);
        if digits.len() != 2 * Self::SIZE {
            return None;
        }
        let digit = |byte: u8| char::from(byte).to_digit(16).map(|digit| digit as u8);
        for (byte, pair) in key.0.iter_mut().zip(digits.chunks_exact(2)) {
            *byte = 16 * digit(pair[0])? + digit(pair[1])?;
        }
        Some(key)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::Permissions;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_key_file_is_private_and_read_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("key");
        let key = Key::create(&path).unwrap();
        assert_eq!(std::fs::metadata(&path).unwrap().mode() & 0o777, 0o600);
        assert!(Key::read(&path).unwrap() == key && key != Key::none());
        assert!(Key::create(&path).is_err(), "an existing key is not replaced");
        assert!(Key::read(&path).unwrap() == key);
        let other = Key::create(&folder.path().join("other")).unwrap();
        assert!(key != other);
    }

    #[test]
    fn a_file_that_group_or_others_may_read_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("key");
        Key::create(&path).unwrap();
        for mode in [0o640, 0o604, 0o660, 0o610, 0o601, 0o644] {
            std::fs::set_permissions(&path, Permissions::from_mode(mode)).unwrap();
            let message = Key::read(&path).unwrap_err().to_string();
            assert!(message.contains(&format!("{mode:04o}")), "{message}");
        }
        std::fs::set_permissions(&path, Permissions::from_mode(0o400)).unwrap();
        assert!(Key::read(&path).is_ok());
    }

    #[test]
    fn neither_debug_nor_errors_show_the_key() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("key");
        let key = Key::create(&path).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(!format!("{key:?}").contains(&text[..8]));
        for wrong in [text[..40].to_owned(), format!("{}00", text.trim()), text.replace(&text[..1], "x")] {
            std::fs::write(&path, &wrong).unwrap();
            let error = Key::read(&path).unwrap_err();
            assert!(!format!("{error} {error:?}").contains(&wrong[10..18]), "{error}");
        }
        assert!(Key::read(folder.path()).is_err(), "a folder is no key");
    }
}
