//! Declared sizes in a Parquet file, compared with its length before its reader allocates for them.

use super::thrift::{ThriftError, parse_struct};
use parquet::file::metadata::ParquetMetaData;
use parquet::file::reader::ChunkReader;

/// Most bytes that one packed byte can hold: deflate reaches 1032, Snappy 21.
const EXPANSION: i64 = 1100;

/// Most rows per byte of a file that can be a log: packed as tightly as may be, a time stamp takes more than
/// this.
const ROWS_PER_BYTE: i64 = 256;

/// Bytes read for a page header at first, and at most: statistics of long texts make some long.
const HEADER_BYTES: [usize; 2] = [1 << 10, 1 << 18];

/// Compares the footer's lists with the bytes it has.
pub(super) fn footer<R: ChunkReader>(source: &R) -> Result<(), String> {
    let read = |start: u64, length: usize| source.get_bytes(start, length).map_err(|e| e.to_string());
    let total = source.len();
    let Some(end) = total.checked_sub(8) else { return Err(format!("{total} bytes")) };
    let tail = read(end, 8)?;
    let length = tail.iter().take(4).rev().fold(0, |sum, byte| sum << 8 | u64::from(*byte));
    let Some(start) = end.checked_sub(length) else {
        return Err(format!("a footer of {length} bytes in a file of {total}"));
    };
    let bytes = read(start, usize::try_from(length).map_err(|e| e.to_string())?)?;
    parse_struct(&bytes, &mut |_, _| {}).map(|_| ()).map_err(|_| "a footer that ends too early".to_string())
}

/// Compares rows and pages with the bytes there are.
pub(super) fn pages<R: ChunkReader>(source: &R, metadata: &ParquetMetaData) -> Result<(), String> {
    let total = i64::try_from(source.len()).unwrap_or(i64::MAX);
    let claimed = metadata.row_groups().iter().map(|group| group.num_rows());
    let rows = claimed.fold(metadata.file_metadata().num_rows(), i64::saturating_add);
    if rows > ROWS_PER_BYTE.saturating_mul(total) {
        return Err(format!("{rows} rows in {total} bytes"));
    }
    for column in metadata.row_groups().iter().flat_map(|group| group.columns()) {
        let first = column.data_page_offset();
        let first = column.dictionary_page_offset().filter(|at| *at > 0 && *at < first).unwrap_or(first);
        let outside = || format!("a footer that places column `{}` outside the file", column.column_path());
        let start = u64::try_from(first).map_err(|_| outside())?;
        let length = u64::try_from(column.compressed_size()).map_err(|_| outside())?;
        let end = start.checked_add(length).filter(|end| *end <= source.len()).ok_or_else(outside)?;
        let mut at = start;
        while at < end {
            at = page(source, at, end)
                .map_err(|why| format!("column `{}` with {why}", column.column_path()))?;
        }
    }
    Ok(())
}

/// Checks the page at `at`: where the next one starts.
fn page<R: ChunkReader>(source: &R, at: u64, end: u64) -> Result<u64, String> {
    for most in HEADER_BYTES {
        let here = usize::try_from(end - at).map_or(most, |left| left.min(most));
        let bytes = source.get_bytes(at, here).map_err(|e| e.to_string())?;
        let (mut unpacked, mut packed, mut values) = (0, 0, 0);
        let header = parse_struct(&bytes, &mut |path, value| match path {
            [2] => unpacked = value,
            [3] => packed = value,
            // Values in a dictionary; in data pages repeated values take no room.
            [7, 1] => values = value,
            _ => {}
        });
        match header {
            Err(ThriftError::Truncated) if here == most => continue,
            Err(_) => return Err("a damaged page header".into()),
            Ok(used) => {
                let next = u64::try_from(packed).ok().and_then(|p| (at + used as u64).checked_add(p));
                let next = next.filter(|next| *next <= end).ok_or("a page that is longer than its column")?;
                if unpacked < 0 || unpacked > EXPANSION * (packed + 16) {
                    return Err(format!("a page of {unpacked} bytes packed into {packed}"));
                }
                if values < 0 || values > unpacked {
                    return Err(format!("a dictionary of {values} values in {unpacked} bytes"));
                }
                return Ok(next);
            }
        }
    }
    Err("a page header that does not end".into())
}
