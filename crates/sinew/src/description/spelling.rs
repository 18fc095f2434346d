//! The known name that a misspelt one probably stands for.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// `: expected `NAME`?` with the most similar known name, or nothing where none is similar.
pub(super) fn near(name: &str, known: &[&str]) -> String {
    if let Some(known) = in_si(name, known) {
        return format!(": expected `{known}`?");
    }
    let best = known.iter().map(|known| (distance(name, known), known)).min();
    match best {
        Some((distance, known)) if distance <= 1 + known.len() / 5 => format!(": expected `{known}`?"),
        _ => String::new(),
    }
}

/// The known name of the same quantity in SI units: `top_speed_rad_per_s` for `top_speed_rpm`.
fn in_si<'k>(name: &str, known: &[&'k str]) -> Option<&'k str> {
    let word = |word| UNITS.iter().find(|(other, _)| *other == word).map_or(word, |(_, si)| *si);
    let si: Vec<&str> = name.split('_').map(word).collect();
    let si = si.join("_");
    known.iter().find(|known| **known == si && si != name).copied()
}

/// Other units in keys, with those of SI.
const UNITS: [(&str, &str); 20] = [
    ("deg", "rad"),
    ("rpm", "rad_per_s"),
    ("mm", "m"),
    ("cm", "m"),
    ("cm2", "m2"),
    ("mm2", "m2"),
    ("g", "kg"),
    ("kn", "n"),
    ("nmm", "nm"),
    ("mnm", "nm"),
    ("ms", "s"),
    ("min", "s"),
    ("us", "s"),
    ("ma", "a"),
    ("mv", "v"),
    ("mohm", "ohm"),
    ("mh", "h"),
    ("uh", "h"),
    ("k", "c"),
    ("mj", "j"),
];

/// What was expected in place of an unknown name: the most similar one, else the first of those there are.
pub(super) fn expected(name: &str, known: &[&str]) -> String {
    let near = near(name, known);
    if !near.is_empty() {
        return near;
    }
    let listed: Vec<String> = known.iter().take(LISTED).map(|known| format!("`{known}`")).collect();
    match known.len() {
        0 => ": there is none".into(),
        1 => format!(": expected {}", listed.concat()),
        all if all > LISTED => format!(": expected one of {} and {} more", listed.join(", "), all - LISTED),
        _ => format!(": expected one of {}", listed.join(", ")),
    }
}

/// Names that an error lists.
const LISTED: usize = 40;

/// Edit distance; two letters in exchanged order are one edit.
fn distance(a: &str, b: &str) -> usize {
    if a.len() > 40 {
        return usize::MAX;
    }
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let mut before: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = alloc::vec![i];
        for j in 1..=b.len() {
            let changed = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut least = changed.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(before[j - 2] + 1);
            }
            row.push(least);
        }
        before = core::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;

    #[test]
    fn a_slip_is_answered_with_one_name_and_anything_else_with_the_list() {
        let known = ["elbow_flexion", "wrist_flexion", "shoulder"];
        assert_eq!(near("elbow_flexon", &known), ": expected `elbow_flexion`?");
        assert_eq!(near("hip", &known), "");
        assert_eq!(near("prot", &["port", "muscle"]), ": expected `port`?");
        assert_eq!([distance("abcd", "badc"), distance("abc", "ca"), distance("", "ab")], [2, 3, 2]);
        assert!(expected("hip", &known).contains("`shoulder`"));
        assert_eq!(expected("hip", &[]), ": there is none");
        let many = vec!["abcdefgh"; 50];
        assert!(expected("x", &many).ends_with("and 10 more"));
    }
}
