//! MATLAB files of version 7.3: HDF5 with MATLAB's habits.

use super::array::Array;
use super::panics::catch_panic;
use crate::Error;
use crate::log::memory_limit::MEMORY_LIMIT_BYTES;
use hdf5_pure::{AttrValue, File, Group};

const EXPECTED: &str = "a MATLAB v7.3 (HDF5) file";
/// Structs inside structs deeper than this are skipped.
const MAX_DEPTH: usize = 8;

/// All real numeric arrays of a file, also inside structs.
pub(super) fn arrays(file: &str, bytes: Vec<u8>) -> Result<Vec<Array>, Error> {
    let size = bytes.len() as u64;
    catch_panic(file, EXPECTED, || {
        let hdf = File::from_bytes(bytes).map_err(|e| damaged(file, &e))?;
        let mut found = Found { file, budget: MEMORY_LIMIT_BYTES / 8, size, arrays: Vec::new() };
        found.group(&hdf.root(), "", 0)?;
        Ok(found.arrays)
    })
}

fn damaged(file: &str, error: &hdf5_pure::Error) -> Error {
    Error::Malformed {
        file: file.into(),
        line: None,
        expected: EXPECTED.into(),
        got: format!("a damaged one ({error})"),
    }
}

struct Found<'a> {
    file: &'a str,
    /// Numbers that may still be read.
    budget: u64,
    /// Bytes of the file.
    size: u64,
    arrays: Vec<Array>,
}

impl Found<'_> {
    fn group(&mut self, group: &Group, parent: &str, depth: usize) -> Result<(), Error> {
        let mut names = group.datasets().map_err(|e| damaged(self.file, &e))?;
        names.sort();
        for name in names {
            self.dataset(group, &name, &join(parent, &name))?;
        }
        if depth >= MAX_DEPTH {
            return Ok(());
        }
        let mut names = group.groups().map_err(|e| damaged(self.file, &e))?;
        names.sort();
        // Names with # are where MATLAB keeps cells and objects.
        for name in names.iter().filter(|name| !name.starts_with('#')) {
            let inner = group.group(name).map_err(|e| damaged(self.file, &e))?;
            self.group(&inner, &join(parent, name), depth + 1)?;
        }
        Ok(())
    }

    fn dataset(&mut self, group: &Group, name: &str, path: &str) -> Result<(), Error> {
        let broken = |e: hdf5_pure::Error| damaged(self.file, &e);
        let dataset = group.dataset(name).map_err(broken)?;
        let attributes = dataset.attrs().map_err(broken)?;
        let class = match attributes.get("MATLAB_class") {
            Some(AttrValue::AsciiString(class) | AttrValue::String(class)) => class.as_str(),
            _ => "",
        };
        // Text is stored as numbers too; an empty array is stored as its size.
        if matches!(class, "char" | "cell") || attributes.contains_key("MATLAB_empty") {
            return Ok(());
        }
        let shape = dataset.shape().map_err(broken)?;
        let count = shape.iter().try_fold(1_u64, |p, &d| p.checked_mul(d)).unwrap_or(u64::MAX);
        // Deflate packs at most about a thousandfold: more is a lie of a damaged file.
        if count > self.budget || count / 8192 > self.size {
            return Err(Error::TooLarge {
                file: self.file.into(),
                needed_mb: count >> 17,
                limit_mb: MEMORY_LIMIT_BYTES >> 20,
            });
        }
        let Ok(data) = dataset.read_f64() else { return Ok(()) };
        if data.is_empty() || data.len() as u64 != count {
            return Ok(());
        }
        self.budget -= count;
        // HDF5 counts the last dimension fastest, MATLAB the first: the shape is the other way round.
        let rows = shape.last().map_or(1, |&d| d as usize);
        let columns = data.len() / rows.max(1);
        self.arrays.push(Array { path: path.to_owned(), rows, columns, data });
        Ok(())
    }
}

fn join(parent: &str, name: &str) -> String {
    if parent.is_empty() { name.to_owned() } else { format!("{parent}.{name}") }
}
