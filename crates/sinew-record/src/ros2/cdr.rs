//! Messages in CDR, little-endian, as ROS 2 puts them on the wire and into bags.

/// CDR, little-endian, without options.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// A message that is written field by field. Numbers are aligned to their size, counted from behind the
/// encapsulation.
#[derive(Debug)]
pub(super) struct Cdr(Vec<u8>);

impl Cdr {
    pub(super) fn new() -> Self {
        Self(ENCAPSULATION.to_vec())
    }

    pub(super) fn bytes(&self) -> &[u8] {
        &self.0
    }

    fn put<const N: usize>(&mut self, octets: [u8; N]) {
        let begin = (self.0.len() - ENCAPSULATION.len()).next_multiple_of(N) + ENCAPSULATION.len();
        self.0.resize(begin, 0);
        self.0.extend_from_slice(&octets);
    }

    pub(super) fn u8(&mut self, x: u8) {
        self.put([x]);
    }

    pub(super) fn length(&mut self, x: usize) {
        self.put((x as u32).to_le_bytes());
    }

    pub(super) fn f64(&mut self, x: f64) {
        self.put(x.to_le_bytes());
    }

    pub(super) fn f64s(&mut self, values: &[f64]) {
        self.length(values.len());
        values.iter().for_each(|x| self.f64(*x));
    }

    pub(super) fn text(&mut self, text: &str) {
        self.length(text.len() + 1);
        self.0.extend_from_slice(text.as_bytes());
        self.0.push(0);
    }

    pub(super) fn texts<'a>(&mut self, texts: impl ExactSizeIterator<Item = &'a str>) {
        self.length(texts.len());
        texts.for_each(|text| self.text(text));
    }

    /// `std_msgs/Header`, of ns since 1970.
    pub(super) fn header(&mut self, ns: u64, frame: &str) {
        self.put(((ns / 1_000_000_000) as i32).to_le_bytes());
        self.put(((ns % 1_000_000_000) as u32).to_le_bytes());
        self.text(frame);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
