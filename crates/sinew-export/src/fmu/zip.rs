//! A ZIP archive: deflated entries, no time of day, so that the same model gives the same bytes.

use crate::{ExportError, ExportedFile};
use flate2::Compression;
use flate2::write::DeflateEncoder;
use std::io::Write;

/// 1980-01-01 in the date format of DOS: the first day that there is.
const DATE: u16 = 0x0021;
/// Version 2.0 of the format has deflate.
const VERSION: u16 = 20;
const DEFLATED: u16 = 8;
/// Names are UTF-8.
const UTF8: u16 = 1 << 11;

/// The archive of these files.
pub(super) fn archive(files: &[ExportedFile]) -> Result<Vec<u8>, ExportError> {
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    for file in files {
        let offset = size(out.len())?;
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
        let packed = encoder.write_all(&file.bytes).and_then(|()| encoder.finish());
        let packed = packed.map_err(|error| ExportError::Archive(error.to_string()))?;
        // What the entry and its line in the directory have in common.
        let mut common = Vec::new();
        for field in [VERSION, UTF8, DEFLATED, 0, DATE] {
            common.extend(field.to_le_bytes());
        }
        for field in [crc32fast::hash(&file.bytes), size(packed.len())?, size(file.bytes.len())?] {
            common.extend(field.to_le_bytes());
        }
        common.extend((size(file.path.len())? as u16).to_le_bytes());
        common.extend(0_u16.to_le_bytes());

        out.extend(0x0403_4b50_u32.to_le_bytes());
        out.extend(&common);
        out.extend(file.path.as_bytes());
        out.extend(packed);

        directory.extend(0x0201_4b50_u32.to_le_bytes());
        directory.extend(VERSION.to_le_bytes());
        directory.extend(&common);
        // Comment, disk, internal attributes; external attributes.
        directory.extend([0; 10]);
        directory.extend(offset.to_le_bytes());
        directory.extend(file.path.as_bytes());
    }
    let (begin, count) = (size(out.len())?, files.len() as u16);
    out.extend(&directory);
    out.extend(0x0605_4b50_u32.to_le_bytes());
    for field in [0, 0, count, count] {
        out.extend(field.to_le_bytes());
    }
    out.extend(size(directory.len())?.to_le_bytes());
    out.extend(begin.to_le_bytes());
    out.extend(0_u16.to_le_bytes());
    Ok(out)
}

fn size(length: usize) -> Result<u32, ExportError> {
    u32::try_from(length).map_err(|_| ExportError::Archive("more than 4 GiB".to_owned()))
}
