//! Sentences as HTML.

/// A sentence with its names between backquotes set as code: `` `elbow` `` becomes `<code>elbow</code>`. A
/// backquote without a second one stays. A number and its unit stay on one line.
pub(crate) fn marked(sentence: &str) -> String {
    let mut html = String::with_capacity(sentence.len());
    let bound = bound(sentence);
    let mut parts = bound.split('`').map(escaped);
    html.extend(parts.next());
    while let Some(inside) = parts.next() {
        match parts.next() {
            Some(outside) => html.extend(["<code>", &inside, "</code>", &outside]),
            None => html.extend(["`", &inside]),
        }
    }
    html
}

/// Units that follow a number in a sentence.
const UNITS: [&str; 18] = [
    "%", "°C", "mm", "m", "N", "Nm", "kg", "s", "ms", "µs", "rad", "mrad", "rad/s", "m/s", "1/s", "A", "Hz",
    "N/m",
];

/// The sentence with a space that does not break between a number and its unit.
fn bound(sentence: &str) -> String {
    let mut text = String::with_capacity(sentence.len());
    for (k, word) in sentence.split(' ').enumerate() {
        let unit = word.trim_end_matches([',', '.', ';', ':', ')', '”']);
        let number = text.ends_with(|letter: char| letter.is_ascii_digit());
        match (k == 0, number && UNITS.contains(&unit)) {
            (true, _) => {}
            (false, true) => text.push('\u{a0}'),
            (false, false) => text.push(' '),
        }
        text += word;
    }
    text
}

fn escaped(text: &str) -> String {
    text.chars().fold(String::with_capacity(text.len()), |mut html, letter| {
        match letter {
            '&' => html += "&amp;",
            '<' => html += "&lt;",
            '>' => html += "&gt;",
            '"' => html += "&quot;",
            _ => html.push(letter),
        }
        html
    })
}

#[cfg(test)]
mod tests {
    use super::marked;

    #[test]
    fn names_are_code_and_nothing_else_is_markup() {
        assert_eq!(marked("`a<b` is, as `c`, 1 < 2"), "<code>a&lt;b</code> is, as <code>c</code>, 1 &lt; 2");
        assert_eq!(marked("one ` alone"), "one ` alone");
        assert_eq!(marked("`<script>`"), "<code>&lt;script&gt;</code>");
        assert_eq!(marked(""), "");
        assert_eq!(marked("2.08 mm mean, 3 times in 4 s."), "2.08\u{a0}mm mean, 3 times in 4\u{a0}s.");
    }
}
