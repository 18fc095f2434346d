use crate::error::Error;
use sinew_record::Recording;
use std::io::Read;
use std::path::Path;

/// Largest recording that is read, bytes: some ten hours of a large machine.
const MAX_BYTES: u64 = 4 << 30;

/// First bytes of an MCAP file.
const MAGIC: [u8; 5] = *b"\x89MCAP";

/// Whether a file is a recording, by its first bytes, or is called one.
pub(crate) fn is_recording(path: &Path) -> bool {
    let mut start = [0; MAGIC.len()];
    let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut start));
    (read.is_ok() && start == MAGIC) || path.extension().is_some_and(|extension| extension == "mcap")
}

/// The bytes of a recording.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, Error> {
    let unreadable = |source| Error::Unreadable { file: path.to_owned(), source };
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
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
