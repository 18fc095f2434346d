//! The tables as documentation.

use super::TAG_SIZE;
use super::packets::{
    CommandHead, Head, Hello, JointState, Kind, MuscleState, PointHead, Refused, StateHead, Welcome,
};
use super::table::{Code, Field};
use crate::{Mode, RefusedBecause, Rejection, Request, Role, SetpointKind};
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
    text += "### Codes\n\n| field | codes |\n|---|---|\n";
    for (name, codes) in lists {
        let codes: Vec<String> =
            codes.iter().map(|Code { number, name }| format!("{number} {name}")).collect();
        let _ = writeln!(text, "| `{name}` | {} |", codes.join(", "));
    }
    text += "\n### Rejections, in the order of the checks\n\n| `last_rejection` | name | the packet |\n|---|---|---|\n";
    for reason in Rejection::ALL {
        let _ = writeln!(text, "| {} | `{}` | {} |", reason.number(), reason.name(), reason.about());
    }
    text
}
