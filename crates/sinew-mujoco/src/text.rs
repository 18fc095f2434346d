//! The plugins' configuration: `PATTERN: key=value key=value; PATTERN: ...`.

/// Configuration of one plugin instance: the value of every attribute, empty where it is not given.
pub(crate) type Config = Vec<String>;

/// One pattern over tendon names with its keys and values in the order in which they are written.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Entry<'a> {
    /// `*` stands for any text, `?` for one character.
    pub(crate) pattern: &'a str,
    pub(crate) pairs: Vec<(&'a str, &'a str)>,
}

/// The entries of a text; spaces and line breaks separate pairs, semicolons entries.
pub(crate) fn entries(text: &str) -> Result<Vec<Entry<'_>>, String> {
    let written = text.split(';').map(str::trim).filter(|entry| !entry.is_empty());
    let found = written.map(entry).collect::<Result<Vec<_>, _>>()?;
    if found.is_empty() {
        return Err("no entry, expected \"PATTERN: key=value ...\"".into());
    }
    Ok(found)
}

fn entry(text: &str) -> Result<Entry<'_>, String> {
    let wrong = |what: &str| format!("\"{text}\": {what}, expected \"PATTERN: key=value ...\"");
    // A name may contain colons of its own, as those of attached models do.
    let end = text.find(": ").or_else(|| text.strip_suffix(':').map(str::len));
    let end = end.or_else(|| text.find(":\n")).ok_or_else(|| wrong("no colon after the pattern"))?;
    let (pattern, pairs) = (text[..end].trim(), &text[end + 1..]);
    let pair = |word: &'_ str| {
        word.split_once('=').map(|_| ()).ok_or_else(|| wrong(&format!("\"{word}\" has no value")))
    };
    pairs.split_whitespace().try_for_each(pair)?;
    Ok(Entry { pattern, pairs: pairs.split_whitespace().filter_map(|word| word.split_once('=')).collect() })
}

/// A finite number.
pub(crate) fn number(key: &str, text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| format!("{key}={text}: expected a finite number"))
}

/// Whether a name fits a pattern.
pub(crate) fn matches(pattern: &str, name: &str) -> bool {
    let (pattern, name): (Vec<char>, Vec<char>) = (pattern.chars().collect(), name.chars().collect());
    let (mut p, mut n) = (0, 0);
    // The last star, and where the text that it takes ends.
    let mut star: Option<(usize, usize)> = None;
    while n < name.len() {
        if pattern.get(p) == Some(&'*') {
            star = Some((p, n));
            p += 1;
        } else if pattern.get(p).is_some_and(|c| *c == '?' || *c == name[n]) {
            (p, n) = (p + 1, n + 1);
        } else if let Some((at, taken)) = star {
            star = Some((at, taken + 1));
            (p, n) = (at + 1, taken + 1);
        } else {
            return false;
        }
    }
    pattern[p..].iter().all(|c| *c == '*')
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn entries_are_read_in_order_with_their_pairs() {
        let text = "flexor*: mu=0.1 bend=3.1;\n robot:a:\n mu=0.2;";
        let read = entries(text).unwrap();
        assert_eq!(read[0], Entry { pattern: "flexor*", pairs: vec![("mu", "0.1"), ("bend", "3.1")] });
        assert_eq!(read[1], Entry { pattern: "robot:a", pairs: vec![("mu", "0.2")] });
    }

    #[test]
    fn what_is_not_an_entry_is_refused_with_its_text() {
        for (text, part) in [("", "no entry"), ("a mu=1", "no colon"), ("a: mu", "\"mu\" has no value")] {
            assert!(entries(text).unwrap_err().contains(part), "{text}");
        }
        for text in ["nan", "inf", "1,5", ""] {
            assert!(number("mu", text).is_err());
        }
    }

    #[test]
    fn patterns_match_as_in_a_shell() {
        for (pattern, name, fits) in [
            ("*", "", true),
            ("a*c", "abbc", true),
            ("a*c", "abcb", false),
            ("?b", "ab", true),
            ("?", "", false),
            ("*b*b", "abab", true),
            ("", "a", false),
        ] {
            assert_eq!(matches(pattern, name), fits, "{pattern} {name}");
        }
    }

    /// The same by recursion.
    fn plainly(pattern: &[char], name: &[char]) -> bool {
        match (pattern.split_first(), name.split_first()) {
            (None, None) => true,
            (Some(('*', rest)), _) => {
                plainly(rest, name) || name.split_first().is_some_and(|(_, behind)| plainly(pattern, behind))
            }
            (Some((c, rest)), Some((d, behind))) => (*c == '?' || c == d) && plainly(rest, behind),
            _ => false,
        }
    }

    proptest! {
        #[test]
        fn matching_agrees_with_the_definition(pattern in "[ab*?]{0,8}", name in "[ab]{0,10}") {
            let (p, n): (Vec<char>, Vec<char>) = (pattern.chars().collect(), name.chars().collect());
            prop_assert_eq!(matches(&pattern, &name), plainly(&p, &n));
        }
    }
}
