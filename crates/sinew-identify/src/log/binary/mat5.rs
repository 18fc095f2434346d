//! MATLAB files of version 5 (`save -v6`, `save -v7`): numeric arrays, also inside structs.
//!
//! Layout: a header of 128 bytes, then elements of a tag (type, length) and data. A variable is an element
//! of type matrix, which holds elements for its class, dimensions, name and numbers; `-v7` wraps each into a
//! zlib stream. Source: MathWorks, "MAT-File Format", chapter 1.

use super::array::Array;
use crate::Error;
use crate::log::memory_limit::MEMORY_LIMIT_BYTES;
use std::io::Read;

const HEADER_BYTES: usize = 128;
const COMPRESSED: u32 = 15;
const MATRIX: u32 = 14;
/// `mxSTRUCT_CLASS`.
const STRUCT: u32 = 2;
/// `mxDOUBLE_CLASS` to `mxUINT64_CLASS`.
const NUMERIC: std::ops::RangeInclusive<u32> = 6..=15;
/// Structs inside structs deeper than this are skipped.
const MAX_DEPTH: usize = 8;

/// Whether `head` starts a MATLAB v5 file.
pub(in crate::log) fn is_mat5(head: &[u8]) -> bool {
    head.len() >= HEADER_BYTES && matches!(head.get(124..128), Some([0, 1, b'I', b'M'] | [1, 0, b'M', b'I']))
}

/// All numeric arrays of a file.
pub(super) fn arrays(file: &str, bytes: &[u8]) -> Result<Vec<Array>, Error> {
    let little = bytes.get(126) == Some(&b'I');
    let mut reader = Reader { file, little, budget: MEMORY_LIMIT_BYTES, arrays: Vec::new() };
    let mut rest = bytes.get(HEADER_BYTES..).unwrap_or_default();
    while rest.iter().any(|&b| b != 0) {
        let element = reader.element(&mut rest)?;
        reader.variable(&element)?;
    }
    Ok(reader.arrays)
}

/// A tag with its data.
struct Element<'a> {
    kind: u32,
    data: &'a [u8],
}

struct Reader<'a> {
    file: &'a str,
    little: bool,
    /// Bytes that may still be unpacked: a small file can hold zeros without end.
    budget: u64,
    arrays: Vec<Array>,
}

impl Reader<'_> {
    fn malformed(&self, expected: &str, got: String) -> Error {
        Error::Malformed { file: self.file.into(), line: None, expected: expected.into(), got }
    }

    fn u32(&self, bytes: [u8; 4]) -> u32 {
        if self.little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) }
    }

    /// Takes the next element from `rest`.
    fn element<'b>(&self, rest: &mut &'b [u8]) -> Result<Element<'b>, Error> {
        let cut = || self.malformed("a whole MATLAB v5 file", "a file that is cut off or damaged".into());
        let (tag, after) = rest.split_first_chunk::<4>().ok_or_else(cut)?;
        let tag = self.u32(*tag);
        // Up to four bytes of data are packed into the tag.
        let small = (tag >> 16) as usize;
        if small != 0 {
            let data = after.get(..small.min(4)).ok_or_else(cut)?;
            *rest = after.get(4..).ok_or_else(cut)?;
            return Ok(Element { kind: tag & 0xFFFF, data });
        }
        let (length, after) = after.split_first_chunk::<4>().ok_or_else(cut)?;
        let length = self.u32(*length) as usize;
        let data = after.get(..length).ok_or_else(cut)?;
        let padded = if tag == COMPRESSED { length } else { length.next_multiple_of(8) };
        *rest = after.get(padded.min(after.len())..).unwrap_or_default();
        Ok(Element { kind: tag, data })
    }

    fn variable(&mut self, element: &Element<'_>) -> Result<(), Error> {
        match element.kind {
            MATRIX => self.matrix(element.data, "", 0),
            COMPRESSED => {
                let unpacked = self.unpack(element.data)?;
                let inner = self.element(&mut unpacked.as_slice())?;
                if inner.kind == MATRIX { self.matrix(inner.data, "", 0) } else { Ok(()) }
            }
            _ => Ok(()),
        }
    }

    fn unpack(&mut self, data: &[u8]) -> Result<Vec<u8>, Error> {
        let mut unpacked = Vec::new();
        let mut stream = flate2::read::ZlibDecoder::new(data).take(self.budget + 1);
        let result = stream.read_to_end(&mut unpacked);
        result.map_err(|e| self.malformed("a zlib stream", format!("a damaged one ({e})")))?;
        self.spend(unpacked.len() as u64)?;
        Ok(unpacked)
    }

    fn spend(&mut self, bytes: u64) -> Result<(), Error> {
        self.budget = self.budget.checked_sub(bytes).ok_or_else(|| Error::TooLarge {
            file: self.file.into(),
            needed_mb: (MEMORY_LIMIT_BYTES - self.budget + bytes) >> 20,
            limit_mb: MEMORY_LIMIT_BYTES >> 20,
        })?;
        Ok(())
    }

    /// One variable, or one field of a struct.
    fn matrix(&mut self, data: &[u8], parent: &str, depth: usize) -> Result<(), Error> {
        let mut rest = data;
        if rest.is_empty() {
            return Ok(());
        }
        let flags = self.element(&mut rest)?;
        let Some(class) = flags.data.first_chunk::<4>().map(|b| self.u32(*b) & 0xFF) else {
            return Err(self.malformed("the flags of an array", "none".into()));
        };
        if class != STRUCT && !NUMERIC.contains(&class) {
            return Ok(());
        }
        let dimensions = self.element(&mut rest)?;
        let dimensions: Vec<usize> =
            dimensions.data.as_chunks::<4>().0.iter().map(|b| self.u32(*b) as usize).collect();
        let name = self.element(&mut rest)?;
        let name = String::from_utf8_lossy(name.data);
        let path = if parent.is_empty() { name.into_owned() } else { parent.to_owned() };
        if class == STRUCT {
            return self.fields(rest, &dimensions, &path, depth);
        }
        let real = self.element(&mut rest)?;
        let complex = flags.data.first_chunk::<4>().is_some_and(|b| self.u32(*b) & 0x0800 != 0);
        if complex {
            return Ok(());
        }
        self.numeric(&real, &dimensions, path)
    }

    fn numeric(&mut self, real: &Element<'_>, dimensions: &[usize], path: String) -> Result<(), Error> {
        let width = width(real.kind);
        let count = real.data.len().checked_div(width).unwrap_or(0);
        self.spend(count as u64 * 8)?;
        let data = self.numbers(real);
        let rows = dimensions.first().copied().unwrap_or(0);
        let columns = dimensions.iter().skip(1).try_fold(1_usize, |p, &d| p.checked_mul(d));
        let expected = columns.and_then(|c| c.checked_mul(rows));
        if expected != Some(data.len()) {
            let expected = format!("{dimensions:?} numbers in `{path}`");
            return Err(self.malformed(&expected, data.len().to_string()));
        }
        if !data.is_empty() {
            self.arrays.push(Array { path, rows, columns: columns.unwrap_or(0), data });
        }
        Ok(())
    }

    /// The fields of a struct that is not an array of structs.
    fn fields(
        &mut self,
        mut rest: &[u8],
        dimensions: &[usize],
        path: &str,
        depth: usize,
    ) -> Result<(), Error> {
        if depth >= MAX_DEPTH || dimensions.iter().any(|&d| d != 1) {
            return Ok(());
        }
        let length = self.element(&mut rest)?;
        let length = length.data.first_chunk::<4>().map_or(0, |b| self.u32(*b) as usize);
        let names = self.element(&mut rest)?;
        if length == 0 {
            return Ok(());
        }
        for name in names.data.chunks_exact(length) {
            let end = name.iter().position(|&b| b == 0).unwrap_or(length);
            let field = String::from_utf8_lossy(&name[..end]);
            let value = self.element(&mut rest)?;
            if value.kind == MATRIX {
                self.matrix(value.data, &format!("{path}.{field}"), depth + 1)?;
            }
        }
        Ok(())
    }

    /// Numbers of whatever type they were stored in.
    fn numbers(&self, element: &Element<'_>) -> Vec<f64> {
        macro_rules! read {
            ($type:ty) => {
                element
                    .data
                    .as_chunks::<{ size_of::<$type>() }>()
                    .0
                    .iter()
                    .map(|&b| {
                        let value =
                            if self.little { <$type>::from_le_bytes(b) } else { <$type>::from_be_bytes(b) };
                        value as f64
                    })
                    .collect()
            };
        }
        match element.kind {
            1 => read!(i8),
            2 => read!(u8),
            3 => read!(i16),
            4 => read!(u16),
            5 => read!(i32),
            6 => read!(u32),
            7 => read!(f32),
            9 => read!(f64),
            12 => read!(i64),
            13 => read!(u64),
            _ => Vec::new(),
        }
    }
}

/// Bytes per number of a storage type; 0 if it holds none.
fn width(kind: u32) -> usize {
    match kind {
        1 | 2 => 1,
        3 | 4 => 2,
        5..=7 => 4,
        9 | 12 | 13 => 8,
        _ => 0,
    }
}
