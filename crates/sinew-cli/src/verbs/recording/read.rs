use crate::error::Error;
use sinew_record::Recording;
use std::io::{Read, Seek};
use std::path::Path;

/// Largest recording that is read, bytes: some ten hours of a large machine.
const MAX_BYTES: u64 = 4 << 30;

/// Bytes of a file that is no recording.
const BEGINNING: u64 = 64;
/// First bytes of an MCAP file.
const MAGIC: [u8; 5] = *b"\x89MCAP";

/// Whether a file is a recording, by its first bytes, or is called one.
pub(crate) fn is_recording(path: &Path) -> bool {
    let on_disk = std::fs::metadata(path).is_ok_and(|about| about.is_file());
    let begins = || std::fs::File::open(path).is_ok_and(|mut file| begins_as_recording(&mut file));
    (on_disk && begins()) || path.extension().is_some_and(|extension| extension == "mcap")
}

fn begins_as_recording(file: &mut std::fs::File) -> bool {
    let mut start = [0; MAGIC.len()];
    file.read_exact(&mut start).is_ok() && start == MAGIC
}

/// The bytes of a recording; of a file that begins otherwise no more than its beginning, which is refused
/// when it is read.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, Error> {
    let unreadable = |source| Error::Unreadable { file: path.to_owned(), source };
    // Before it is opened: a pipe waits for its writer, and a device has no end.
    let about = std::fs::metadata(path).map_err(unreadable)?;
    if !about.is_file() && !about.is_dir() {
        return Err(Error::NotOnDisk { file: path.to_owned() });
    }
    let mut file = std::fs::File::open(path).map_err(unreadable)?;
    let whole = begins_as_recording(&mut file);
    file.rewind().map_err(unreadable)?;
    let most = if whole { MAX_BYTES + 1 } else { BEGINNING };
    let mut bytes = Vec::new();
    file.take(most).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > MAX_BYTES {
        let reason = format!("more than {} MB", MAX_BYTES >> 20);
        let got =
            sinew_record::Error::Damaged { at: MAX_BYTES, expected: "the end of a recording", got: reason };
        return Err(Error::recording(path)(got));
    }
    Ok(bytes)
}

/// The recording in the bytes of a file.
pub(crate) fn recording<'a>(path: &Path, bytes: &'a [u8]) -> Result<Recording<'a>, Error> {
    Recording::read(bytes).map_err(Error::recording(path))
}

/// An attachment that cannot be used.
pub(super) fn attachment(file: &Path, name: &str, reason: String) -> Error {
    Error::recording(file)(sinew_record::Error::Attachment { name: name.to_owned(), reason })
}
