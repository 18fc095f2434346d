//! MATLAB v5 logs, written here byte by byte as the format's description asks.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::common;

use common::{Sample, options, samples};
use proptest::prelude::*;
use sinew_identify::Error;
use sinew_identify::log::{Dataset, RequestedRoles, read_bytes};
use std::io::Write;

/// Writes elements in one byte order.
#[derive(Clone, Copy)]
struct Writer {
    little: bool,
}

impl Writer {
    fn u32(self, value: u32) -> [u8; 4] {
        if self.little { value.to_le_bytes() } else { value.to_be_bytes() }
    }

    fn element(self, kind: u32, data: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        if !data.is_empty() && data.len() <= 4 {
            out.extend(self.u32(kind | (data.len() as u32) << 16));
            out.extend(data);
        } else {
            out.extend(self.u32(kind));
            out.extend(self.u32(data.len() as u32));
            out.extend(data);
        }
        out.resize(out.len().next_multiple_of(8), 0);
        out
    }

    fn head(self, class: u32, dimensions: &[u32], name: &str) -> Vec<u8> {
        let mut out = self.element(6, &[self.u32(class), self.u32(0)].concat());
        let dimensions: Vec<u8> = dimensions.iter().flat_map(|&d| self.u32(d)).collect();
        out.extend(self.element(5, &dimensions));
        out.extend(self.element(1, name.as_bytes()));
        out
    }

    fn doubles(self, name: &str, rows: u32, values: &[f64]) -> Vec<u8> {
        let mut body = self.head(6, &[rows, values.len() as u32 / rows], name);
        let bytes: Vec<u8> =
            values.iter().flat_map(|x| if self.little { x.to_le_bytes() } else { x.to_be_bytes() }).collect();
        body.extend(self.element(9, &bytes));
        self.element(14, &body)
    }

    fn text(self, name: &str, text: &str) -> Vec<u8> {
        let mut body = self.head(4, &[1, text.len() as u32], name);
        body.extend(self.element(16, text.as_bytes()));
        self.element(14, &body)
    }

    fn structure(self, name: &str, fields: &[(&str, Vec<u8>)]) -> Vec<u8> {
        let mut body = self.head(2, &[1, 1], name);
        body.extend(self.element(5, &self.u32(32)));
        let mut names = Vec::new();
        for (field, _) in fields {
            names.extend(field.as_bytes());
            names.resize(names.len().next_multiple_of(32), 0);
        }
        body.extend(self.element(1, &names));
        fields.iter().for_each(|(_, value)| body.extend(value));
        self.element(14, &body)
    }

    fn compressed(self, element: &[u8]) -> Vec<u8> {
        let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(element).unwrap();
        let packed = encoder.finish().unwrap();
        [&self.u32(15)[..], &self.u32(packed.len() as u32), &packed].concat()
    }

    fn file(self, elements: &[Vec<u8>]) -> Vec<u8> {
        let mut out = b"MATLAB 5.0 MAT-file".to_vec();
        out.resize(124, b' ');
        out.extend(if self.little { *b"\x00\x01IM" } else { *b"\x01\x00MI" });
        elements.iter().for_each(|e| out.extend(e));
        out
    }
}

const LITTLE: Writer = Writer { little: true };

fn column(samples: &[Sample], k: usize) -> Vec<f64> {
    samples.iter().map(|s| s[k]).collect()
}

fn vectors(writer: Writer, samples: &[Sample]) -> Vec<Vec<u8>> {
    let n = samples.len() as u32;
    vec![
        writer.doubles("t_s", n, &column(samples, 0)),
        writer.doubles("tension_in_n", n, &column(samples, 1)),
        writer.doubles("tension_out_n", 1, &column(samples, 2)),
    ]
}

fn read(bytes: &[u8], flags: &RequestedRoles) -> Result<Dataset, Error> {
    read_bytes(&[("log.mat", bytes)], flags, &options())
}

#[track_caller]
fn holds(dataset: &Dataset, samples: &[Sample]) {
    let [sequence] = dataset.sequences.as_slice() else { panic!("one sequence expected") };
    assert_eq!(sequence.time_s, column(samples, 0));
    assert_eq!(sequence.inputs, column(samples, 1));
    assert_eq!(sequence.far, column(samples, 2));
}

#[test]
fn vectors_of_equal_length_are_columns_in_either_byte_order_packed_or_not() {
    let samples = samples(80, 0.0);
    for writer in [LITTLE, Writer { little: false }] {
        let plain = vectors(writer, &samples);
        holds(&read(&writer.file(&plain), &RequestedRoles::default()).unwrap(), &samples);
        let packed: Vec<_> = plain.iter().map(|e| writer.compressed(e)).collect();
        holds(&read(&writer.file(&packed), &RequestedRoles::default()).unwrap(), &samples);
    }
}

#[test]
fn fields_of_a_struct_are_columns_by_their_own_names() {
    let samples = samples(80, 0.0);
    let field = |name: &'static str, k: usize| (name, LITTLE.doubles("", 80, &column(&samples, k)));
    let inner = LITTLE.structure("", &[field("tension_out_n", 2)]);
    let log = LITTLE.structure(
        "log",
        &[field("t_s", 0), field("tension_in_n", 1), ("far", inner), ("who", LITTLE.text("", "me"))],
    );
    holds(&read(&LITTLE.file(&[log]), &RequestedRoles::default()).unwrap(), &samples);
}

#[test]
fn a_matrix_gives_numbered_columns_either_way_round() {
    let samples = samples(80, 0.0);
    let upright: Vec<f64> = (0..3).flat_map(|k| column(&samples, k)).collect();
    let lying: Vec<f64> = samples.iter().flatten().copied().collect();
    let flags = RequestedRoles {
        time: Some("data_1".into()),
        effort: vec!["data_2".into()],
        far: Some("data_3".into()),
        ..RequestedRoles::default()
    };
    let upright = LITTLE.file(&[LITTLE.doubles("data", 80, &upright)]);
    holds(&read(&upright, &flags).unwrap(), &samples);
    let index: Vec<f64> = (0..80).map(f64::from).collect();
    let mut elements = vec![LITTLE.doubles("data", 3, &lying)];
    for name in ["a", "b", "c", "d"] {
        elements.push(LITTLE.doubles(name, 80, &index));
    }
    holds(&read(&LITTLE.file(&elements), &flags).unwrap(), &samples);
}

#[test]
fn single_numbers_are_constant_columns_and_other_sizes_are_told() {
    let logs: Vec<Vec<u8>> = [30.0, 60.0, 90.0]
        .iter()
        .map(|&bend| {
            let mut elements = vectors(LITTLE, &samples(80, bend));
            elements.push(LITTLE.doubles("sheath_deg", 1, &[bend]));
            elements.push(LITTLE.doubles("calibration", 2, &[1.0, 2.0, 3.0, 4.0]));
            LITTLE.file(&elements)
        })
        .collect();
    let logs: Vec<(&str, &[u8])> =
        ["a.mat", "b.mat", "c.mat"].into_iter().zip(logs.iter().map(Vec::as_slice)).collect();
    let dataset = read_bytes(&logs, &RequestedRoles::default(), &options()).unwrap();
    assert_eq!(dataset.conditions[0].values, ["30", "60", "90"]);
    let findings = &dataset.logs[0].findings[0];
    assert!(findings.contains("1 array ") && findings.contains("`calibration`"), "{findings}");
}

#[test]
fn a_file_without_vectors_says_what_is_not_read() {
    let file = LITTLE.file(&[LITTLE.text("notes", "no numbers here")]);
    let got = read(&file, &RequestedRoles::default()).unwrap_err().to_string();
    assert!(got.contains("log.mat") && got.contains("no numeric vector"), "{got}");
}

#[test]
fn a_file_that_is_cut_off_is_refused_wherever_it_is_cut() {
    let samples = samples(40, 0.0);
    let whole = LITTLE.file(&vectors(LITTLE, &samples));
    for length in (130..whole.len() - 8).step_by(7) {
        // A cut between two variables leaves a whole file with a column less.
        assert!(read(&whole[..length], &RequestedRoles::default()).is_err(), "{length} bytes");
    }
}

#[test]
fn an_infinity_is_placed() {
    let mut bad = samples(80, 0.0);
    bad[41][1] = f64::INFINITY;
    let got = read(&LITTLE.file(&vectors(LITTLE, &bad)), &RequestedRoles::default()).unwrap_err().to_string();
    assert!(got.contains("line 42") && got.contains("`tension_in_n`"), "{got}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn a_damaged_file_is_read_or_refused(
        changes in prop::collection::vec((128_usize..2400, any::<u8>()), 1..12),
        packed: bool,
    ) {
        let mut elements = vectors(LITTLE, &samples(40, 0.0));
        elements.push(LITTLE.structure("s", &[("x", LITTLE.doubles("", 40, &[0.5; 40]))]));
        if packed {
            elements = elements.iter().map(|e| LITTLE.compressed(e)).collect();
        }
        let mut file = LITTLE.file(&elements);
        for (at, byte) in changes {
            let at = at % file.len();
            if at >= 128 {
                file[at] = byte;
            }
        }
        let _ = read(&file, &RequestedRoles::default());
    }
}
