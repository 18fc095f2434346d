//! The tables as documentation.

use super::datagram::Datagram;
use super::packets::{
    CommandHead, Head, Hello, JointState, Kind, MuscleState, PointHead, Refused, StateHead, Welcome,
};
use super::seal::{CLIENT_LABEL, HOST_LABEL, Nonce, Sealer, SessionKeys, session_of};
use super::table::{Code, Field};
use super::{MAGIC, TAG_SIZE, VERSION};
use crate::{Key, Mode, RefusedBecause, Rejection, Request, Role, SetpointKind};
use std::fmt::Write;

/// A part of a datagram with its fields.
#[derive(Debug, Clone, Copy)]
pub struct Section {
    /// Its title.
    pub title: &'static str,
    /// Its fields.
    pub fields: &'static [Field],
}

/// All parts, in the order of the documentation.
#[must_use]
pub fn sections() -> [Section; 10] {
    let section = |title, fields| Section { title, fields };
    [
        section("Head of every datagram", Head::FIELDS),
        section("1 Hello", Hello::FIELDS),
        section("2 Welcome", Welcome::FIELDS),
        section("3 Refused", Refused::FIELDS),
        section("4 Command", CommandHead::FIELDS),
        section("4 Command, beginning of every point; `values` numbers (f64) follow", PointHead::FIELDS),
        section("5 State", StateHead::FIELDS),
        section("5 State, every joint", JointState::FIELDS),
        section("5 State, every muscle, after the joints", MuscleState::FIELDS),
        section("6 Goodbye and 7 Watch have no body. Tag, at the end of every datagram", TAG),
    ]
}

/// Key, random numbers and the keys of a session that follow from them.
fn worked_example() -> String {
    let hex = |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    let key: [u8; 32] = std::array::from_fn(|k| k as u8);
    let [client_nonce, host_nonce]: [Nonce; 2] =
        [0xa0, 0xb0].map(|first| std::array::from_fn(|k| first + k as u8));
    let base = Sealer::new(&Key::new(key));
    let of = |label: &[u8]| hex(&base.tag(&[label, &client_nonce, &host_nonce].concat()));
    let mut goodbye = Datagram::default();
    let head = Head {
        magic: MAGIC,
        version: VERSION,
        kind: Kind::Goodbye as u8,
        length: 0,
        session: session_of(&host_nonce),
        sequence: 1,
        reflected_sequence: 0,
        time_ns: 1000,
        reflected_time_ns: 0,
        held_ns: 0,
    };
    goodbye.seal(head, &SessionKeys::new(&base, &client_nonce, &host_nonce).client, |_| Some(()));
    let rows = [
        ("pre-shared key", hex(&key)),
        ("`client_nonce`", hex(&client_nonce)),
        ("`host_nonce`", hex(&host_nonce)),
        ("key of the client", of(CLIENT_LABEL)),
        ("key of the host", of(HOST_LABEL)),
        ("a Goodbye, `sequence` 1, `time_ns` 1000", hex(goodbye.bytes())),
    ];
    let rows: String = rows.iter().map(|(what, bytes)| format!("| {what} | `{bytes}` |\n")).collect();
    format!("### Worked example of the keys of a session\n\n| what | bytes |\n|---|---|\n{rows}\n")
}

const TAG: &[Field] = &[Field {
    name: "tag",
    kind: "u8[32]",
    size: TAG_SIZE,
    unit: "1",
    meaning: "HMAC-SHA256 of all bytes before it.",
}];

/// The tables of all packets, codes and rejections, as Markdown.
#[must_use]
pub fn tables() -> String {
    let mut text = String::new();
    for Section { title, fields } in sections() {
        let size: usize = fields.iter().map(|field| field.size).sum();
        let _ = writeln!(
            text,
            "### {title}: {size} bytes\n\n| byte | field | type | unit | meaning |\n|---|---|---|---|---|"
        );
        let mut at = 0;
        for Field { name, kind, size, unit, meaning } in fields {
            let _ = writeln!(text, "| {at} | `{name}` | {kind} | {unit} | {meaning} |");
            at += size;
        }
        text.push('\n');
    }
    let lists = [
        ("role", Role::codes()),
        ("kind", Kind::ALL.map(Kind::code).to_vec()),
        ("mode", Mode::codes()),
        ("request", Request::codes()),
        ("setpoint", SetpointKind::codes()),
        ("because", RefusedBecause::codes()),
    ];
    text += &worked_example();
    text += "### Codes\n\n| field | codes |\n|---|---|\n";
    for (name, codes) in lists {
        let codes: Vec<String> =
            codes.iter().map(|Code { number, name }| format!("{number} {name}")).collect();
        let _ = writeln!(text, "| `{name}` | {} |", codes.join(", "));
    }
    text += "\n### Rejections, in the order of the checks\n\n| `last_rejection` | name | the packet \
        |\n|---|---|---|\n";
    for reason in Rejection::ALL {
        let _ = writeln!(text, "| {} | `{}` | {} |", reason.number(), reason.name(), reason.about());
    }
    text
}
