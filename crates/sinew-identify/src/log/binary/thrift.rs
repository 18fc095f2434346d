//! Validation of the structs in a Parquet file before its reader allocates for them.
//!
//! Footer and page headers are structs in Thrift's compact protocol. A damaged one can declare a list of 2e9
//! elements, a page of two gigabytes or a dictionary of as many values in a file of a kilobyte, and the
//! reader would iterate over, or allocate, all of them. Every declared length is compared with the bytes that
//! are left, and numbers of interest are collected by their path of field numbers.

/// Structs inside structs that a header may have; Parquet needs five.
const DEEPEST: usize = 12;

/// Why a struct could not be parsed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ThriftError {
    /// The bytes end before the struct does.
    Truncated,
    /// A length or nesting that no valid file has.
    Implausible,
}

/// Parses one struct and returns the bytes it takes. `number(path, value)` is called for every integer field
/// outside lists, `path` being its field number within the field numbers of the structs around it.
pub(super) fn parse_struct(bytes: &[u8], number: &mut dyn FnMut(&[i16], i64)) -> Result<usize, ThriftError> {
    let mut parser = Parser { rest: bytes, path: Vec::with_capacity(DEEPEST), lists: 0, number };
    parser.fields()?;
    Ok(bytes.len() - parser.rest.len())
}

struct Parser<'a, 'b> {
    rest: &'a [u8],
    path: Vec<i16>,
    lists: usize,
    number: &'b mut dyn FnMut(&[i16], i64),
}

impl Parser<'_, '_> {
    fn byte(&mut self) -> Result<u8, ThriftError> {
        let (first, rest) = self.rest.split_first().ok_or(ThriftError::Truncated)?;
        self.rest = rest;
        Ok(*first)
    }

    fn skip(&mut self, count: u64) -> Result<(), ThriftError> {
        let count = usize::try_from(count).map_err(|_| ThriftError::Implausible)?;
        self.rest = self.rest.get(count..).ok_or(ThriftError::Truncated)?;
        Ok(())
    }

    fn varint(&mut self) -> Result<u64, ThriftError> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err(ThriftError::Implausible)
    }

    fn integer(&mut self) -> Result<i64, ThriftError> {
        let zigzag = self.varint()?;
        Ok((zigzag >> 1) as i64 ^ -((zigzag & 1) as i64))
    }

    fn fields(&mut self) -> Result<(), ThriftError> {
        if self.path.len() >= DEEPEST {
            return Err(ThriftError::Implausible);
        }
        self.path.push(0);
        loop {
            let head = self.byte()?;
            let (kind, step) = (head & 0x0f, i16::from(head >> 4));
            if kind == 0 {
                self.path.pop();
                return Ok(());
            }
            let field = if step == 0 { self.integer()? as i16 } else { self.last().wrapping_add(step) };
            if let Some(last) = self.path.last_mut() {
                *last = field;
            }
            // A boolean is encoded in the head itself.
            if kind > 2 {
                self.value(kind)?;
            }
        }
    }

    fn last(&self) -> i16 {
        self.path.last().copied().unwrap_or(0)
    }

    fn value(&mut self, kind: u8) -> Result<(), ThriftError> {
        match kind {
            1..=3 => self.skip(1),
            4..=6 => {
                let value = self.integer()?;
                if self.lists == 0 {
                    (self.number)(&self.path, value);
                }
                Ok(())
            }
            7 => self.skip(8),
            8 => {
                let length = self.varint()?;
                self.skip(length)
            }
            9 | 10 => self.list(),
            11 => self.map(),
            12 => self.fields(),
            _ => Err(ThriftError::Implausible),
        }
    }

    fn list(&mut self) -> Result<(), ThriftError> {
        let head = self.byte()?;
        let count = if head >> 4 == 15 { self.varint()? } else { u64::from(head >> 4) };
        self.elements(count, &[head & 0x0f])
    }

    fn map(&mut self) -> Result<(), ThriftError> {
        let count = self.varint()?;
        if count == 0 {
            return Ok(());
        }
        let kinds = self.byte()?;
        self.elements(count, &[kinds >> 4, kinds & 0x0f])
    }

    /// Every element takes a byte at least: more of them than bytes are left is not plausible.
    fn elements(&mut self, count: u64, kinds: &[u8]) -> Result<(), ThriftError> {
        if count > self.rest.len() as u64 {
            return Err(ThriftError::Truncated);
        }
        self.lists += 1;
        for _ in 0..count {
            kinds.iter().try_for_each(|&kind| self.value(kind))?;
        }
        self.lists -= 1;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Numbers = Vec<(Vec<i16>, i64)>;

    fn numbers(bytes: &[u8]) -> Result<(usize, Numbers), ThriftError> {
        let mut found = Vec::new();
        let used = parse_struct(bytes, &mut |path, value| found.push((path.to_vec(), value)))?;
        Ok((used, found))
    }

    #[test]
    fn numbers_are_found_by_their_path() {
        // {1: 2, 3: -5, 7: {1: 300}, 8: true, 9: "ab", 10: [1, 2]} and one byte of something else
        let bytes =
            [0x15, 4, 0x25, 9, 0x4c, 0x15, 0xd8, 0x04, 0, 0x11, 0x18, 2, b'a', b'b', 0x19, 0x25, 2, 4, 0, 99];
        let expected = vec![(vec![1], 2), (vec![3], -5), (vec![7, 1], 300)];
        assert_eq!(numbers(&bytes), Ok((bytes.len() - 1, expected)));
    }

    #[test]
    fn a_list_longer_than_the_file_and_a_tower_of_structs_are_refused() {
        assert_eq!(numbers(&[0x19, 0xf1, 0xff, 0xff, 0xff, 0xff, 0x07, 0]), Err(ThriftError::Truncated));
        assert_eq!(numbers(&[0x1c; 40]), Err(ThriftError::Implausible));
        assert_eq!(
            numbers(&[0x15, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff]),
            Err(ThriftError::Implausible)
        );
        assert_eq!(numbers(&[]), Err(ThriftError::Truncated));
    }
}
