//! Packets of serial servos: Dynamixel protocol 2.0, and [`Feetech`](Protocol::Feetech).
//!
//! ```text
//! ff ff fd 00 | id | length, 2 octets | instruction | parameters | CRC-16, 2 octets
//! ```
//!
//! The length counts from the instruction on. In instruction and parameters `ff ff fd` is followed by another
//! `fd`, so that no header is found within a packet. Source: ROBOTIS, DYNAMIXEL Protocol 2.0.

mod feetech;

const HEADER: [u8; 4] = [0xff, 0xff, 0xfd, 0x00];
/// Header, identifier and length.
const HEAD: usize = 7;
const CRC: usize = 2;
/// Octets of a packet, at most, and of the memory of a decoder.
const CAPACITY: usize = 4096;

/// Identifier of all servos of a chain.
pub const BROADCAST: u8 = 0xfe;
/// The largest identifier of one servo.
pub const MAX_ID: u8 = 252;
/// Bit of the error of a status that announces a hardware error.
pub const ALERT: u8 = 0x80;

/// Instructions.
pub mod instruction {
    /// Answered by model number and version of the firmware.
    pub const PING: u8 = 0x01;
    /// Address and length, 2 octets each.
    pub const READ: u8 = 0x02;
    /// Address and data.
    pub const WRITE: u8 = 0x03;
    /// Starts the servo anew.
    pub const REBOOT: u8 = 0x08;
    /// An answer: error and data.
    pub const STATUS: u8 = 0x55;
    /// Address, length, identifiers: one status each.
    pub const SYNC_READ: u8 = 0x82;
    /// Address, length, then identifier and data of each; not answered.
    pub const SYNC_WRITE: u8 = 0x83;
    /// As a sync read; all answers are in one packet.
    pub const FAST_SYNC_READ: u8 = 0x8a;
}

/// How the octets on a line are packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Protocol {
    /// Dynamixel protocol 2.0.
    #[default]
    Dynamixel,
    /// That of Feetech servos, with numbers that begin with their low octet.
    Feetech,
}

impl Protocol {
    /// Appends an instruction with the parameters of all parts, within the capacity of `out` without an
    /// allocation.
    pub fn instruct(self, out: &mut Vec<u8>, id: u8, instruction: u8, parts: &[&[u8]]) {
        match self {
            Self::Dynamixel => encode(out, id, instruction, parts),
            Self::Feetech => feetech::encode(out, id, instruction, parts),
        }
    }

    /// Appends an answer with an error and data.
    pub fn answer(self, out: &mut Vec<u8>, id: u8, error: u8, data: &[u8]) {
        match self {
            Self::Dynamixel => encode(out, id, instruction::STATUS, &[&[error], data]),
            Self::Feetech => feetech::encode(out, id, error, &[data]),
        }
    }

    /// Octets of an address or a length in parameters.
    #[must_use]
    pub const fn width(self) -> usize {
        match self {
            Self::Dynamixel => 2,
            Self::Feetech => 1,
        }
    }

    /// Appends addresses and lengths to parameters.
    pub fn places(self, parameters: &mut Vec<u8>, places: &[u16]) {
        places.iter().for_each(|place| parameters.extend(&place.to_le_bytes()[..self.width()]));
    }
}

/// CRC-16 with the polynomial 0x8005, not reflected, that goes on from `crc`; it begins with 0.
#[must_use]
pub fn crc16(crc: u16, octets: &[u8]) -> u16 {
    octets.iter().fold(crc, |crc, octet| (crc << 8) ^ TABLE[usize::from((crc >> 8) as u8 ^ octet)])
}

const TABLE: [u16; 256] = {
    let (mut table, mut k) = ([0_u16; 256], 0);
    while k < 256 {
        let (mut crc, mut bit) = ((k as u16) << 8, 0);
        while bit < 8 {
            crc = (crc << 1) ^ if crc & 0x8000 == 0 { 0 } else { 0x8005 };
            bit += 1;
        }
        table[k] = crc;
        k += 1;
    }
    table
};

/// Appends a packet of a Dynamixel with the parameters of all parts, within the capacity of `out` without an
/// allocation.
pub fn encode(out: &mut Vec<u8>, id: u8, instruction: u8, parts: &[&[u8]]) {
    let start = out.len();
    out.extend(HEADER);
    out.extend([id, 0, 0, instruction]);
    let mut last = [0; 2];
    for octet in parts.iter().copied().flatten().copied() {
        out.push(octet);
        if last == [0xff; 2] && octet == 0xfd {
            out.push(octet);
        }
        last = [last[1], octet];
    }
    let length = (out.len() - start - HEAD + CRC) as u16;
    out[start + 5..start + HEAD].copy_from_slice(&length.to_le_bytes());
    let crc = crc16(0, &out[start..]);
    out.extend(crc.to_le_bytes());
}

/// Appends the beginning of the answer to a fast sync read of `servos`, whose blocks have `data` octets of
/// data.
pub fn encode_fast_head(out: &mut Vec<u8>, servos: usize, data: usize) {
    out.extend(HEADER);
    out.push(BROADCAST);
    out.extend(((1 + servos * block_length(data)) as u16).to_le_bytes());
    out.push(instruction::STATUS);
}

/// Appends the block of a servo to such an answer, which begins at `start` of `out`.
pub fn encode_fast_block(out: &mut Vec<u8>, start: usize, (id, error): (u8, u8), data: &[u8]) {
    out.extend([error, id]);
    out.extend(data);
    let crc = crc16(0, &out[start..]);
    out.extend(crc.to_le_bytes());
}

/// Error, identifier, data and CRC.
const fn block_length(data: usize) -> usize {
    2 + data + CRC
}

/// A packet, or the block of one servo in the answer to a fast sync read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packet<'a> {
    /// Identifier.
    pub id: u8,
    /// Instruction.
    pub instruction: u8,
    /// Of a status: number of the error, 0 for none, and [`ALERT`].
    pub error: u8,
    /// Parameters of an instruction, data of a status.
    pub data: &'a [u8],
}

/// Finds packets in a stream of octets; what belongs to none is left out.
#[derive(Debug, Clone)]
pub struct Decoder {
    protocol: Protocol,
    /// Whether what comes are answers: a Feetech's do not say so.
    answers: bool,
    octets: Vec<u8>,
    start: usize,
    /// Blocks of the answer to a fast sync read at `start` that have been given out.
    blocks: usize,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new(Protocol::Dynamixel, true)
    }
}

/// Where a packet was found, and where the search goes on.
struct Found {
    id: u8,
    instruction: u8,
    error: u8,
    data: [usize; 2],
}

impl Decoder {
    /// One for the answers of servos, or for what a master sends them.
    #[must_use]
    pub fn new(protocol: Protocol, answers: bool) -> Self {
        Self { protocol, answers, octets: Vec::with_capacity(CAPACITY), start: 0, blocks: 0 }
    }

    /// The protocol of what comes.
    #[must_use]
    pub fn protocol(&self) -> Protocol {
        self.protocol
    }

    /// Forgets what has come.
    pub fn clear(&mut self) {
        self.octets.clear();
        (self.start, self.blocks) = (0, 0);
    }

    /// Takes octets over; of too many without a packet the earlier ones are forgotten.
    pub fn feed(&mut self, octets: &[u8]) {
        self.octets.drain(..self.start);
        self.start = 0;
        if self.octets.len() + octets.len() > CAPACITY {
            self.clear();
        }
        let most = octets.len().min(CAPACITY);
        self.octets.extend_from_slice(&octets[octets.len() - most..]);
    }

    /// The next packet; `fast` are the octets of data in a block of an answer to a fast sync read, where one
    /// is expected: its blocks are given out one by one as they come.
    pub fn next(&mut self, fast: Option<usize>) -> Option<Packet<'_>> {
        if self.protocol == Protocol::Feetech {
            let (id, code, [from, to]) = feetech::next(&self.octets, &mut self.start)?;
            let [instruction, error] = if self.answers { [instruction::STATUS, code] } else { [code, 0] };
            return Some(Packet { id, instruction, error, data: &self.octets[from..to] });
        }
        let Found { id, instruction, error, data: [from, to] } = loop {
            let rest = &self.octets[self.start..];
            let Some(at) = rest.windows(HEADER.len()).position(|octets| octets == HEADER) else {
                // The last ones may be the beginning of a header.
                self.start += rest.len().saturating_sub(HEADER.len() - 1);
                return None;
            };
            self.blocks = if at == 0 { self.blocks } else { 0 };
            self.start += at;
            let [id, low, high, instruction] = *self.octets.get(self.start + 4..)?.first_chunk()?;
            let length = usize::from(u16::from_le_bytes([low, high]));
            let end = self.start + HEAD + length;
            let fast = fast.filter(|_| id == BROADCAST && instruction == instruction::STATUS);
            let fits = (1 + CRC..=CAPACITY - HEAD).contains(&length);
            let found = match fast {
                _ if !fits => None,
                Some(data) => {
                    let from = self.start + HEAD + 1 + self.blocks * block_length(data);
                    let to = from + block_length(data);
                    if to > end {
                        None
                    } else {
                        let block = self.checked(from, to)?;
                        self.blocks += 1;
                        block.map(|[error, id]| {
                            let done = to == end;
                            self.blocks = if done { 0 } else { self.blocks };
                            (
                                done.then_some(end),
                                Found { id, instruction, error, data: [from + 2, to - CRC] },
                            )
                        })
                    }
                }
                None => {
                    let from = self.start + HEAD + 1;
                    self.checked(from.min(end - CRC), end)?.map(|_| {
                        let to = self.unstuff(from, end - CRC);
                        let status = instruction == instruction::STATUS && to > from;
                        let error = if status { self.octets[from] } else { 0 };
                        let data = [from + usize::from(status), to];
                        (Some(end), Found { id, instruction, error, data })
                    })
                }
            };
            match found {
                Some((end, found)) => {
                    self.start = end.unwrap_or(self.start);
                    break found;
                }
                None => (self.start, self.blocks) = (self.start + 1, 0),
            }
        };
        Some(Packet { id, instruction, error, data: &self.octets[from..to] })
    }

    /// The octets at `from` of a part of a packet that ends with its CRC at `to`, none where that is wrong;
    /// none at all until it is complete.
    fn checked(&self, from: usize, to: usize) -> Option<Option<[u8; 2]>> {
        let (octets, given) = self.octets.get(self.start..to)?.split_last_chunk::<CRC>()?;
        let right = crc16(0, octets) == u16::from_le_bytes(*given);
        Some(self.octets.get(from..).and_then(|octets| octets.first_chunk().copied()).filter(|_| right))
    }

    /// Takes the stuffed octets out of a range and returns its new end.
    fn unstuff(&mut self, from: usize, to: usize) -> usize {
        let (mut end, mut last) = (from, [0_u8; 3]);
        for at in from..to {
            let octet = self.octets[at];
            if last == [0xff, 0xff, 0xfd] && octet == 0xfd {
                last = [0; 3];
                continue;
            }
            self.octets[end] = octet;
            end += 1;
            last = [last[1], last[2], octet];
        }
        end
    }
}
