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

/// Writes the records into the header where `SINEW_LINK_WRITE` is set.
#[test]
fn the_records_of_the_c_header_are_those_of_the_code() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../clients/c/sinew_link.h");
    let header = std::fs::read_to_string(path).unwrap();
    let record = |name: &str, fields: &[sinew_link::wire::Field]| {
        let names: Vec<_> = fields.iter().map(|field| field.name).collect();
        format!("typedef struct {{ double {}; }} {name};", names.join(", "))
    };
    let desired = [
        record("sinew_joint", sinew_link::JointState::FIELDS),
        record("sinew_muscle", sinew_link::MuscleState::FIELDS),
    ];
    if std::env::var_os("SINEW_LINK_WRITE").is_some() {
        let line = |line: &str| {
            let own = desired.iter().find(|own| line.ends_with(own.rsplit(' ').next().unwrap()));
            own.filter(|_| line.starts_with("typedef struct { double"))
                .map_or(line, |own| own.as_str())
                .to_owned()
                + "\n"
        };
        std::fs::write(path, header.lines().map(line).collect::<String>()).unwrap();
        return;
    }
    for line in &desired {
        assert!(header.contains(line.as_str()), "run this test with SINEW_LINK_WRITE=1: {line}");
    }
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
