//! A host without sockets, one honest client, and everything else that may arrive: each datagram is made so
//! that it is known beforehand for which reason it has to be rejected.

use sinew_link::client::{ClientSession, Greeting};
use sinew_link::host::{Domain, Outcome, SessionSettings, Sessions, WATCHERS};
use sinew_link::wire::{Datagram, Head, Nonce, Sealer, SessionKeys, TAG_SIZE};
use sinew_link::{Command, Counters, Key, Rejection, Request, SetpointKind, Setpoints};
use std::collections::VecDeque;
use std::net::SocketAddr;

/// Choices of the adversary: bytes of a fuzzer, or random numbers of a seed.
pub(crate) trait Choices {
    fn next(&mut self) -> Option<u64>;
}

/// SplitMix64 for a number of packets.
pub(crate) struct Random {
    pub(crate) state: u64,
    pub(crate) left: u64,
}

impl Choices for Random {
    fn next(&mut self) -> Option<u64> {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.state ^ self.state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        self.left = self.left.checked_sub(1)?;
        Some(z ^ z >> 31)
    }
}

/// Bytes of a fuzzer, eight at a time.
pub(crate) struct Bytes<'a>(pub(crate) &'a [u8]);

impl Choices for Bytes<'_> {
    fn next(&mut self) -> Option<u64> {
        let (first, rest) = self.0.split_first_chunk::<8>()?;
        self.0 = rest;
        Some(u64::from_le_bytes(*first))
    }
}

const JOINTS: usize = 3;
const MUSCLES: usize = 5;
/// Between two packets, ns: 2500 per second, below the limit of commands.
const STEP: u64 = 400_000;
/// Silence after which the session ends, ns.
const EXPIRY: u64 = 500_000_000;
/// Packets that are kept for replays.
const KEPT: usize = 40;

/// Offsets within a datagram.
const VERSION_AT: usize = 4;
const KIND_AT: usize = 5;
const LENGTH_AT: usize = 6;
const SESSION_AT: usize = 8;
const SEQUENCE_AT: usize = 16;
const TIME_AT: usize = 32;
/// Number of the kind of packet.
const WATCH: u8 = 7;
const REQUEST_AT: usize = Head::SIZE;
const VALUES_AT: usize = Head::SIZE + 2;
const POINTS_AT: usize = Head::SIZE + 4;
const NUMBER_AT: usize = Head::SIZE + 16 + 8;

pub(crate) struct Played {
    pub(crate) counters: Counters,
    pub(crate) expected: Vec<(Rejection, u64)>,
    pub(crate) expected_accepted: u64,
    /// Commands that the honest client sent, and those that the machine got.
    pub(crate) sent: u64,
    pub(crate) taken: u64,
}

struct Scene {
    host: Sessions,
    session: ClientSession,
    keys: SessionKeys,
    now: u64,
    reply: Datagram,
    own: Datagram,
    /// Authentic datagrams of this session, the newest last.
    kept: VecDeque<Vec<u8>>,
    expected: Vec<u64>,
    expected_accepted: u64,
    sent: u64,
    taken: u64,
    full: bool,
    /// Newest sequence number that arrived with its tag, and when.
    newest: u64,
    heard: u64,
    nonce: u64,
    /// A second session that was offered before the first became active.
    other: ClientSession,
    /// A session that watches, and when it was heard last.
    watcher: Option<(ClientSession, u64)>,
}

fn address(port: u16) -> SocketAddr {
    SocketAddr::from(([127, 0, 0, 1], port))
}

fn domain() -> Domain {
    Domain {
        name: "test".into(),
        joint: vec![[-2.0, 2.0]; JOINTS],
        muscle_length: vec![[0.1, 0.4]; MUSCLES],
        tension: vec![[5.0, 300.0]; MUSCLES],
        end_point: Some([[-1.0, 1.0]; 3]),
    }
}

/// Number `k` of the stream that the honest client sends: what the machine gets is recognised by it.
fn honest(k: u64) -> Command {
    let phase = k as f64 * 0.01;
    let mut setpoints = Setpoints::new(SetpointKind::Joint, JOINTS);
    let joints = [phase.sin(), phase.cos(), (k % 1000) as f64 * 1e-3];
    assert!(setpoints.push(1 + k * STEP, &joints));
    Command { request: Request::ALL[k as usize % Request::ALL.len()], advance_to_ns: k, setpoints }
}

fn hello(host: &mut Sessions, key: &Key, nonce: Nonce, now: u64) -> (ClientSession, SessionKeys) {
    let greeting = Greeting::new(key, nonce);
    let (mut datagram, mut reply) = (Datagram::default(), Datagram::default());
    let bytes = greeting.hello(now, &mut datagram).to_vec();
    let outcome = host.receive(&bytes, address(1000), now, &mut reply, |_, _| true);
    assert_eq!(outcome, Outcome::Offered);
    let session = greeting.answer(reply.bytes()).expect("a Welcome").expect("a session");
    let keys = SessionKeys::new(&Sealer::new(key), &nonce, &session.welcome().host_nonce);
    (session, keys)
}

/// Plays until the choices end.
pub(crate) fn play(choices: &mut impl Choices) -> Played {
    let key = Key::new([7; 32]);
    let mut count = 0_u64;
    let random = Box::new(move |nonce: &mut Nonce| {
        count += 1;
        nonce[..8].copy_from_slice(&count.wrapping_mul(0x9e37_79b9_7f4a_7c15).to_le_bytes());
        true
    });
    let mut host = Sessions::new(&key, domain(), SessionSettings::default(), random).expect("a sound domain");
    let (session, keys) = hello(&mut host, &key, [1; 16], 0);
    let (other, _) = hello(&mut host, &key, [2; 16], 0);
    let mut scene = Scene {
        host,
        session,
        keys,
        now: 1_000_000_000,
        reply: Datagram::default(),
        own: Datagram::default(),
        kept: VecDeque::new(),
        expected: vec![0; Rejection::ALL.len()],
        expected_accepted: 2,
        sent: 0,
        taken: 0,
        full: false,
        newest: 0,
        heard: 1_000_000_000,
        nonce: 2,
        other,
        watcher: None,
    };
    scene.honest();
    while let Some(choice) = choices.next() {
        scene.now += STEP;
        scene.act(choice);
    }
    Played {
        counters: scene.host.counters(),
        expected: Rejection::ALL.iter().copied().zip(scene.expected).collect(),
        expected_accepted: scene.expected_accepted,
        sent: scene.sent,
        taken: scene.taken,
    }
}

impl Scene {
    fn act(&mut self, choice: u64) {
        let detail = choice >> 8;
        if self.now - self.heard > EXPIRY / 2 {
            self.honest();
        }
        match choice % 26 {
            0 => self.noise(detail),
            1 => self.truncated(detail),
            2 => self.flipped(detail),
            3 => self.other_key(),
            4 => self.replayed(detail),
            5 => self.reordered(detail),
            6 => self.other_session(detail),
            7 => self.second_client(),
            8 => self.second_hello(),
            9 => self.backwards(),
            10 => self.forged(Rejection::Version, |d| d[VERSION_AT] = d[VERSION_AT].wrapping_add(1)),
            11 => self.forged(Rejection::Magic, |d| d[(detail % 4) as usize] ^= 1 << (detail >> 2 & 7)),
            12 => self.forged(Rejection::Kind, |d| d[KIND_AT] = [0, 2, 3, 5, 8, 255][(detail % 6) as usize]),
            13 => self.forged(Rejection::Length, |d| d[LENGTH_AT] ^= 1 << (detail & 7)),
            14 => self.malformed(detail),
            15 => self.out_of_domain(detail),
            16 => self.queue_full(),
            17 => self.forged_content(Rejection::Role, |d| d[KIND_AT] = WATCH),
            18 => self.watched(detail),
            19 if detail.is_multiple_of(8) => self.crowded(),
            _ => self.honest(),
        }
    }

    fn receive(&mut self, bytes: &[u8], port: u16, expected: Option<Rejection>) {
        let (full, mut taken) = (self.full, None);
        let outcome = self.host.receive(bytes, address(port), self.now, &mut self.reply, |command, _| {
            taken = Some(*command);
            !full
        });
        match expected {
            Some(reason) => {
                self.expected[reason as usize] += 1;
                assert_eq!(outcome, Outcome::Rejected(reason));
                assert!(taken.is_none() || reason == Rejection::QueueFull, "{reason:?} reached the machine");
            }
            None => {
                self.expected_accepted += 1;
                assert_eq!(outcome, Outcome::Commanded);
                let command = taken.expect("an accepted command is taken");
                let mut sent = honest(command.advance_to_ns);
                if command.request == Request::None {
                    sent.request = Request::None;
                }
                assert_eq!(command, sent, "what the machine gets is what the client sent");
                self.taken += 1;
                self.arrived(bytes);
            }
        }
    }

    /// An authentic packet was not rejected before its number counted as used.
    fn arrived(&mut self, bytes: &[u8]) {
        self.newest = self.newest.max(u64_at(bytes, SEQUENCE_AT));
        self.heard = self.now;
    }

    fn next_honest(&mut self) -> Vec<u8> {
        self.session.command(&honest(self.sent), self.now, &mut self.own).to_vec()
    }

    fn keep(&mut self, bytes: Vec<u8>) {
        if self.kept.len() == KEPT {
            self.kept.pop_front();
        }
        self.kept.push_back(bytes);
    }

    fn honest(&mut self) {
        let bytes = self.next_honest();
        self.sent += 1;
        self.receive(&bytes, 2000, None);
        self.keep(bytes);
    }

    /// Bytes without structure, or with the magic and a length that is right.
    fn noise(&mut self, detail: u64) {
        let size = (detail % 1300) as usize;
        let mut bytes = Vec::with_capacity(size + 8);
        let mut word = detail;
        while bytes.len() < size {
            bytes.extend(word.to_le_bytes());
            word = word.wrapping_mul(0x2545_f491_4f6c_dd1d).rotate_left(17) ^ 0x9e37;
        }
        bytes.truncate(size);
        if size >= 8 {
            bytes[0] = b'X';
        }
        let reason = match size {
            0..88 => Rejection::TooShort,
            1233.. => Rejection::TooLong,
            _ => Rejection::Magic,
        };
        self.receive(&bytes, 3000, Some(reason));
    }

    fn truncated(&mut self, detail: u64) {
        let bytes = self.next_honest();
        self.sent += 1;
        let size = detail as usize % bytes.len();
        let reason = if size < 88 { Rejection::TooShort } else { Rejection::Length };
        self.receive(&bytes[..size], 2000, Some(reason));
    }

    /// One bit of what only the tag protects.
    fn flipped(&mut self, detail: u64) {
        let mut bytes = self.next_honest();
        self.sent += 1;
        let first = SEQUENCE_AT;
        let place = first + detail as usize % (bytes.len() - first);
        bytes[place] ^= 1 << (detail >> 32 & 7);
        self.receive(&bytes, 2000, Some(Rejection::Tag));
    }

    /// The right session, another key.
    fn other_key(&mut self) {
        let mut bytes = self.next_honest();
        self.sent += 1;
        seal(&mut bytes, &Sealer::new(&Key::new([8; 32])));
        self.receive(&bytes, 2000, Some(Rejection::Tag));
    }

    fn replayed(&mut self, detail: u64) {
        let bytes = self.kept[detail as usize % self.kept.len()].clone();
        let in_window = self.newest - u64_at(&bytes, SEQUENCE_AT) < 64;
        self.receive(&bytes, 2000, Some(if in_window { Rejection::Replayed } else { Rejection::Old }));
    }

    /// A few honest commands that arrive in the reverse order.
    fn reordered(&mut self, detail: u64) {
        let count = 2 + detail as usize % 4;
        let batch: Vec<Vec<u8>> = (0..count)
            .map(|_| {
                let bytes = self.next_honest();
                self.sent += 1;
                self.now += STEP;
                bytes
            })
            .collect();
        for bytes in batch.iter().rev() {
            self.receive(bytes, 2000, None);
        }
        batch.into_iter().for_each(|bytes| self.keep(bytes));
    }

    fn other_session(&mut self, detail: u64) {
        let mut bytes = self.next_honest();
        self.sent += 1;
        let session = detail | 1 << 63;
        bytes[SESSION_AT..SESSION_AT + 8].copy_from_slice(&session.to_le_bytes());
        seal(&mut bytes, &self.keys.client);
        self.receive(&bytes, 2000, Some(Rejection::Session));
    }

    /// A client with the key and an offered session, while the first one is active.
    fn second_client(&mut self) {
        let bytes = self.other.command(&honest(0), self.now, &mut self.own).to_vec();
        self.receive(&bytes, 4000, Some(Rejection::SecondClient));
    }

    fn second_hello(&mut self) {
        self.nonce += 1;
        let mut nonce = [0; 16];
        nonce[..8].copy_from_slice(&self.nonce.to_le_bytes());
        let greeting = Greeting::new(&Key::new([7; 32]), nonce);
        let bytes = greeting.hello(self.now, &mut self.own).to_vec();
        self.receive(&bytes, 4000, Some(Rejection::SecondClient));
        assert!(greeting.answer(self.reply.bytes()).expect("an answer").is_err(), "the client is told");
        self.honest();
    }

    /// A client that watches: its signs of life are accepted, its commands are not.
    fn watched(&mut self, detail: u64) {
        let known = self.watcher.take().filter(|(_, heard)| self.now - heard <= EXPIRY);
        let known = known.map(|(watcher, _)| watcher);
        let Some(mut watcher) = known.or_else(|| self.begin_watching()) else { return };
        let forbidden = detail & 1 == 1;
        let bytes = match forbidden {
            true => watcher.command(&honest(0), self.now, &mut self.own),
            false => watcher.watch(self.now, &mut self.own),
        };
        let bytes = bytes.to_vec();
        let outcome = self.host.receive(&bytes, address(5000), self.now, &mut self.reply, |_, _| {
            panic!("a client that watches commands the machine")
        });
        if forbidden {
            self.expected[Rejection::Role as usize] += 1;
            assert_eq!(outcome, Outcome::Rejected(Rejection::Role));
        } else {
            self.expected_accepted += 1;
            assert_eq!(outcome, Outcome::Watched);
        }
        self.watcher = Some((watcher, self.now));
    }

    /// More clients than may watch.
    fn crowded(&mut self) {
        while self.begin_watching().is_some() {}
    }

    /// A new session that watches; none where as many do as may.
    fn begin_watching(&mut self) -> Option<ClientSession> {
        self.nonce += 1;
        let mut nonce = [0; 16];
        nonce[..8].copy_from_slice(&self.nonce.to_le_bytes());
        let greeting = Greeting::new(&Key::new([7; 32]), nonce).watching();
        let bytes = greeting.hello(self.now, &mut self.own).to_vec();
        self.host.expire(self.now);
        let full = self.host.watchers() == WATCHERS;
        let outcome = self.host.receive(&bytes, address(5000), self.now, &mut self.reply, |_, _| true);
        if full {
            self.expected[Rejection::TooManyWatchers as usize] += 1;
            assert_eq!(outcome, Outcome::Rejected(Rejection::TooManyWatchers));
            return None;
        }
        assert_eq!(outcome, Outcome::Offered);
        let mut watcher = greeting.answer(self.reply.bytes()).expect("a Welcome").expect("a session");
        let bytes = watcher.watch(self.now, &mut self.own).to_vec();
        let outcome = self.host.receive(&bytes, address(5000), self.now, &mut self.reply, |_, _| true);
        assert_eq!(outcome, Outcome::Watched);
        self.expected_accepted += 2;
        self.honest();
        Some(watcher)
    }

    fn backwards(&mut self) {
        let mut bytes = self.next_honest();
        self.sent += 1;
        bytes[TIME_AT..TIME_AT + 8].copy_from_slice(&1_u64.to_le_bytes());
        seal(&mut bytes, &self.keys.client);
        self.receive(&bytes, 2000, Some(Rejection::Time));
    }

    /// An honest packet, changed before it is sealed.
    fn forged(&mut self, reason: Rejection, change: impl FnOnce(&mut [u8])) {
        let mut bytes = self.next_honest();
        self.sent += 1;
        change(&mut bytes);
        seal(&mut bytes, &self.keys.client);
        self.receive(&bytes, 2000, Some(reason));
    }

    /// As above, with a content that is rejected: its number counts as used.
    fn forged_content(&mut self, reason: Rejection, change: impl FnOnce(&mut [u8])) {
        self.forged(reason, change);
        self.newest = self.newest.max(self.session.peer().sent());
        self.heard = self.now;
    }

    fn malformed(&mut self, detail: u64) {
        let word = (detail >> 8) as u16;
        match detail % 4 {
            0 => self.forged_content(Rejection::Code, |d| {
                d[REQUEST_AT + (word & 1) as usize] = 8 + (word >> 8) as u8 % 200;
            }),
            1 => self.forged_content(Rejection::Count, |d| {
                d[VALUES_AT..VALUES_AT + 2].copy_from_slice(&(129 + word % 60_000).to_le_bytes());
            }),
            2 => self.forged_content(Rejection::Count, |d| {
                d[POINTS_AT..POINTS_AT + 2].copy_from_slice(&(1000 + word % 60_000).to_le_bytes());
            }),
            _ => self.forged_content(Rejection::Length, |d| {
                d[POINTS_AT..POINTS_AT + 2].copy_from_slice(&(2 + word % 30).to_le_bytes());
            }),
        }
    }

    fn out_of_domain(&mut self, detail: u64) {
        let bad =
            [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 2.1, -1e300, 1e-310 - 3.0][(detail % 6) as usize];
        let reason = if bad.is_finite() { Rejection::OutOfRange } else { Rejection::NonFinite };
        let at = NUMBER_AT + 8 * (detail >> 8) as usize % (8 * JOINTS);
        self.forged_content(reason, |d| d[at..at + 8].copy_from_slice(&bad.to_le_bytes()));
    }

    fn queue_full(&mut self) {
        let bytes = self.next_honest();
        self.sent += 1;
        self.full = true;
        self.receive(&bytes, 2000, Some(Rejection::QueueFull));
        self.arrived(&bytes);
        self.full = false;
    }
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"))
}

fn seal(bytes: &mut [u8], sealer: &Sealer) {
    let (sealed, tag) = bytes.split_at_mut(bytes.len() - TAG_SIZE);
    tag.copy_from_slice(&sealer.tag(sealed));
}
