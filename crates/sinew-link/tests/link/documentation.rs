//! docs/link.md contains the tables of the code.

use sinew_link::wire::tables;

const BEGIN: &str = "<!-- tables of the code: begin -->\n";
const END: &str = "<!-- tables of the code: end -->";

/// Writes the tables where `SINEW_LINK_WRITE` is set.
#[test]
fn the_byte_tables_of_the_documentation_are_those_of_the_code() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/link.md");
    let page = std::fs::read_to_string(path).unwrap();
    let (before, rest) = page.split_once(BEGIN).expect("the mark before the tables");
    let (written, after) = rest.split_once(END).expect("the mark after the tables");
    if std::env::var_os("SINEW_LINK_WRITE").is_some() {
        std::fs::write(path, format!("{before}{BEGIN}\n{}\n{END}{after}", tables())).unwrap();
        return;
    }
    assert_eq!(written.trim(), tables().trim(), "run this test with SINEW_LINK_WRITE=1");
}

#[test]
fn no_two_fields_of_a_section_have_the_same_name() {
    for section in sinew_link::wire::sections() {
        let mut names: Vec<_> = section.fields.iter().map(|field| field.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), section.fields.len(), "{}", section.title);
    }
}
