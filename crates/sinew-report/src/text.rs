//! Sentences as HTML.

/// A sentence with its names between backquotes set as code: `` `elbow` `` becomes `<code>elbow</code>`. A
/// backquote without a second one stays.
pub(crate) fn marked(sentence: &str) -> String {
    let mut html = String::with_capacity(sentence.len());
    let mut parts = sentence.split('`').map(escaped);
    html.extend(parts.next());
    while let Some(inside) = parts.next() {
        match parts.next() {
            Some(outside) => html.extend(["<code>", &inside, "</code>", &outside]),
            None => html.extend(["`", &inside]),
        }
    }
    html
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
    }
}
