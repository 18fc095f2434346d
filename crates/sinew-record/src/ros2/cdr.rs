//! Messages in CDR, little-endian, as ROS 2 puts them on the wire and into bags.

/// CDR, little-endian, without options.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// A message that is written field by field. Numbers are aligned to their size, counted from behind the
/// encapsulation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cdr(Vec<u8>);

impl Default for Cdr {
    fn default() -> Self {
        Self::new()
    }
}

impl Cdr {
    /// Without any field.
    #[must_use]
    pub fn new() -> Self {
        Self(ENCAPSULATION.to_vec())
    }

    /// With the encapsulation, as a bag has it.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// The fields alone.
    #[must_use]
    pub fn fields(&self) -> &[u8] {
        self.0.get(ENCAPSULATION.len()..).unwrap_or_default()
    }

    fn put<const N: usize>(&mut self, octets: [u8; N]) {
        let begin = (self.0.len() - ENCAPSULATION.len()).next_multiple_of(N) + ENCAPSULATION.len();
        self.0.resize(begin, 0);
        self.0.extend_from_slice(&octets);
    }

    /// A `uint8`, `byte` or `bool`.
    pub fn u8(&mut self, x: u8) {
        self.put([x]);
    }

    /// A `uint32`, or how many entries follow.
    pub fn length(&mut self, x: usize) {
        self.put((x as u32).to_le_bytes());
    }

    /// A `float64`.
    pub fn f64(&mut self, x: f64) {
        self.put(x.to_le_bytes());
    }

    /// A `float64[]`.
    pub fn f64s(&mut self, values: &[f64]) {
        self.length(values.len());
        values.iter().for_each(|x| self.f64(*x));
    }

    /// A `string`.
    pub fn text(&mut self, text: &str) {
        self.length(text.len() + 1);
        self.0.extend_from_slice(text.as_bytes());
        self.0.push(0);
    }

    /// A `string[]`.
    pub fn texts<'a>(&mut self, texts: impl ExactSizeIterator<Item = &'a str>) {
        self.length(texts.len());
        texts.for_each(|text| self.text(text));
    }

    /// `std_msgs/Header`, of ns since 1970.
    pub fn header(&mut self, ns: u64, frame: &str) {
        self.put(((ns / 1_000_000_000) as i32).to_le_bytes());
        self.put(((ns % 1_000_000_000) as u32).to_le_bytes());
        self.text(frame);
    }
}

/// A message that is read field by field, in either order of bytes; none where it ends early.
#[derive(Debug, Clone)]
pub struct CdrReader<'a> {
    /// From behind the encapsulation on.
    message: &'a [u8],
    at: usize,
    little_endian: bool,
}

impl<'a> CdrReader<'a> {
    /// Of plain CDR, which ROS 2 writes; none of others.
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Option<Self> {
        let (head, message) = bytes.split_at_checked(ENCAPSULATION.len())?;
        match head {
            [0, order @ (0 | 1), ..] => Some(Self::of_fields(message, *order == 1)),
            _ => None,
        }
    }

    /// Of the fields alone.
    #[must_use]
    pub fn of_fields(message: &'a [u8], little_endian: bool) -> Self {
        Self { message, at: 0, little_endian }
    }

    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let taken = self.message.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        Some(taken)
    }

    fn get<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.at = self.at.next_multiple_of(N);
        let mut octets: [u8; N] = self.take(N)?.try_into().ok()?;
        if !self.little_endian {
            octets.reverse();
        }
        Some(octets)
    }

    /// A `uint32`, or how many entries follow.
    pub fn length(&mut self) -> Option<usize> {
        self.get().map(|octets| u32::from_le_bytes(octets) as usize)
    }

    /// A `float64`.
    pub fn f64(&mut self) -> Option<f64> {
        self.get().map(f64::from_le_bytes)
    }

    /// A `float64[]`.
    pub fn f64s(&mut self) -> Option<Vec<f64>> {
        (0..self.length()?).map(|_| self.f64()).collect()
    }

    /// A `string[]`.
    pub fn texts(&mut self) -> Option<Vec<&'a str>> {
        (0..self.length()?).map(|_| self.text()).collect()
    }

    /// A `string`.
    pub fn text(&mut self) -> Option<&'a str> {
        let count = self.length()?;
        let (end, text) = self.take(count)?.split_last()?;
        std::str::from_utf8(text).ok().filter(|_| *end == 0)
    }

    /// `builtin_interfaces/Time` or `Duration`, ns.
    pub fn time(&mut self) -> Option<i64> {
        let seconds = i64::from(i32::from_le_bytes(self.get()?));
        let ns = i64::from(u32::from_le_bytes(self.get()?));
        Some(1_000_000_000 * seconds + ns)
    }

    /// `std_msgs/Header`: ns since 1970, and the frame.
    pub fn header(&mut self) -> Option<(i64, &'a str)> {
        Some((self.time()?, self.text()?))
    }

    /// Whether all is read, but for octets that fill up the last four.
    #[must_use]
    pub fn is_read(&self) -> bool {
        self.message.len() - self.at < 4
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_read_as_it_was_written_in_both_orders_and_not_where_it_ends_early() {
        let mut message = Cdr::new();
        message.header(3_000_000_004, "b");
        message.f64(0.5);
        let read = |bytes: &[u8]| {
            let mut reader = CdrReader::new(bytes)?;
            let (ns, frame) = reader.header()?;
            let found = (ns, frame.to_owned(), reader.f64()?);
            reader.is_read().then_some(found)
        };
        let expected = Some((3_000_000_004, "b".to_owned(), 0.5));
        assert_eq!(read(message.bytes()), expected);
        let mut other = message.bytes().to_vec();
        other[1] = 0;
        for number in [4..8, 8..12, 12..16, 20..28] {
            other[number].reverse();
        }
        assert_eq!(read(&other), expected);
        for end in 0..message.bytes().len() {
            assert_eq!(read(&message.bytes()[..end]), None, "{end}");
        }
    }

    /// `rosbags` 0.11.9, `serialize_cdr` of `JointState` with names, positions, no velocities, an effort.
    #[test]
    fn a_message_has_the_octets_of_rosbags() {
        let mut message = Cdr::new();
        message.header(3_000_000_004, "b");
        message.texts(["hip", "knee"].into_iter());
        message.f64s(&[0.5, -1.0]);
        message.f64s(&[]);
        message.f64s(&[2.0]);
        let octets: Vec<String> = message.bytes().iter().map(|octet| format!("{octet:02x}")).collect();
        assert_eq!(octets.concat(), GOLDEN);
    }

    const GOLDEN: &str = "0001000003000000040000000200000062000000020000000400000068697000050000006b6e6565000000000200000000000000000000000000e03f000000000000f0bf00000000010000000000000000000040";
}
