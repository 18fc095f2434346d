//! What a Parquet file says about itself, walked through before its reader believes it.
//!
//! Footer and page headers are structs in Thrift's compact protocol. A damaged one can promise a list of two
//! thousand million elements, a page of two gigabytes or a dictionary of as many values in a file of a kilobyte;
//! the reader would count, or make room for, all of them. Here every promise is held against the bytes that are
//! left, and numbers of interest are picked out by their path of field numbers.

/// Structs inside structs that a header may have; Parquet needs five.
const DEEPEST: usize = 12;

/// Why a struct could not be walked through.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fault {
    /// The bytes end before the struct does.
    Ends,
    /// A length or nesting that no sound file has.
    Promise,
}

/// Reads one struct: how many bytes it takes. `number(path, value)` is called for every integer field outside
/// lists, `path` being its field number within the field numbers of the structs around it.
pub(super) fn walk(bytes: &[u8], number: &mut dyn FnMut(&[i16], i64)) -> Result<usize, Fault> {
    let mut cursor = Cursor { rest: bytes, path: Vec::with_capacity(DEEPEST), lists: 0, number };
    cursor.fields()?;
    Ok(bytes.len() - cursor.rest.len())
}

struct Cursor<'a, 'b> {
    rest: &'a [u8],
    path: Vec<i16>,
    lists: usize,
    number: &'b mut dyn FnMut(&[i16], i64),
}

impl Cursor<'_, '_> {
    fn byte(&mut self) -> Result<u8, Fault> {
        let (first, rest) = self.rest.split_first().ok_or(Fault::Ends)?;
        self.rest = rest;
        Ok(*first)
    }

    fn skip(&mut self, count: u64) -> Result<(), Fault> {
        let count = usize::try_from(count).map_err(|_| Fault::Promise)?;
        self.rest = self.rest.get(count..).ok_or(Fault::Ends)?;
        Ok(())
    }

    fn varint(&mut self) -> Result<u64, Fault> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err(Fault::Promise)
    }

    fn integer(&mut self) -> Result<i64, Fault> {
        let zigzag = self.varint()?;
        Ok((zigzag >> 1) as i64 ^ -((zigzag & 1) as i64))
    }

    fn fields(&mut self) -> Result<(), Fault> {
        if self.path.len() >= DEEPEST {
            return Err(Fault::Promise);
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
            // A truth stands in the head itself.
            if kind > 2 {
                self.value(kind)?;
            }
        }
    }

    fn last(&self) -> i16 {
        self.path.last().copied().unwrap_or(0)
    }

    fn value(&mut self, kind: u8) -> Result<(), Fault> {
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
            _ => Err(Fault::Promise),
        }
    }

    fn list(&mut self) -> Result<(), Fault> {
        let head = self.byte()?;
        let count = if head >> 4 == 15 { self.varint()? } else { u64::from(head >> 4) };
        self.elements(count, &[head & 0x0f])
    }

    fn map(&mut self) -> Result<(), Fault> {
        let count = self.varint()?;
        if count == 0 {
            return Ok(());
        }
        let kinds = self.byte()?;
        self.elements(count, &[kinds >> 4, kinds & 0x0f])
    }

    /// Every element takes a byte at least: more of them than bytes are left is a promise nobody keeps.
    fn elements(&mut self, count: u64, kinds: &[u8]) -> Result<(), Fault> {
        if count > self.rest.len() as u64 {
            return Err(Fault::Ends);
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

    fn numbers(bytes: &[u8]) -> Result<(usize, Numbers), Fault> {
        let mut found = Vec::new();
        let used = walk(bytes, &mut |path, value| found.push((path.to_vec(), value)))?;
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
        assert_eq!(numbers(&[0x19, 0xf1, 0xff, 0xff, 0xff, 0xff, 0x07, 0]), Err(Fault::Ends));
        assert_eq!(numbers(&[0x1c; 40]), Err(Fault::Promise));
        assert_eq!(
            numbers(&[0x15, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff]),
            Err(Fault::Promise)
        );
        assert_eq!(numbers(&[]), Err(Fault::Ends));
    }
}
