//! Formats behind cargo features: read where they were built in, and else the feature is named.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::common;

use common::options;
#[cfg(any(feature = "parquet", feature = "mat73"))]
use common::{Sample, samples};
use sinew_identify::log::{RequestedRoles, read_bytes};

/// Changes bytes here and there, reproducibly, and reads: any outcome but a panic is right.
#[cfg(any(feature = "parquet", feature = "mat73"))]
fn survives_damage(whole: &[u8]) {
    let mut random = 0x9E37_79B9_7F4A_7C15_u64;
    let mut next = move || {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        random as usize
    };
    for _ in 0..400 {
        let mut file = whole.to_vec();
        for _ in 0..1 + next() % 4 {
            let at = next() % file.len();
            file[at] = next() as u8;
        }
        let _ = read_bytes(&[("log", &file)], &RequestedRoles::default(), &options());
    }
}

fn refusal(bytes: &[u8]) -> String {
    read_bytes(&[("log", bytes)], &RequestedRoles::default(), &options()).unwrap_err().to_string()
}

#[cfg(any(feature = "parquet", feature = "mat73"))]
fn column(samples: &[Sample], k: usize) -> Vec<f64> {
    samples.iter().map(|s| s[k]).collect()
}

#[cfg(not(feature = "parquet"))]
#[test]
fn parquet_names_its_feature() {
    assert!(refusal(b"PAR1 and more").contains("cargo feature `parquet`"));
}

#[cfg(not(feature = "mat73"))]
#[test]
fn matlab_73_names_its_feature() {
    let mut file = vec![b' '; 512];
    file.extend(b"\x89HDF\r\n\x1a\n");
    assert!(refusal(&file).contains("cargo feature `mat73`"));
}

#[cfg(feature = "mat73")]
mod mat73 {
    use super::*;
    use hdf5_pure::{AttrValue, FileBuilder};

    /// A file as MATLAB lays it out: vectors n x 1 are stored 1 x n.
    fn file(samples: &[Sample], in_struct: bool) -> Vec<u8> {
        let n = samples.len() as u64;
        let mut builder = FileBuilder::new();
        builder.create_dataset("t_s").with_f64_data(&column(samples, 0)).with_shape(&[1, n]);
        builder.create_dataset("tension_in_n").with_f64_data(&column(samples, 1)).with_shape(&[n, 1]);
        if in_struct {
            let mut group = builder.create_group("log");
            group.create_dataset("tension_out_n").with_f64_data(&column(samples, 2)).with_shape(&[1, n]);
            builder.add_group(group.finish());
        } else {
            builder.create_dataset("tension_out_n").with_f64_data(&column(samples, 2)).with_shape(&[1, n]);
        }
        let text: Vec<u16> = "note".encode_utf16().collect();
        builder
            .create_dataset("note")
            .with_u16_data(&text)
            .with_shape(&[4, 1])
            .set_attr("MATLAB_class", AttrValue::AsciiString("char".into()));
        builder.finish().unwrap()
    }

    #[test]
    fn vectors_are_columns_also_in_structs_and_after_a_matlab_header() {
        let samples = samples(80, 0.0);
        for in_struct in [false, true] {
            let bytes = file(&samples, in_struct);
            let dataset = read_bytes(&[("log.mat", &bytes)], &RequestedRoles::default(), &options()).unwrap();
            let sequence = &dataset.sequences[0];
            assert_eq!(sequence.time_s, column(&samples, 0));
            assert_eq!(sequence.inputs, column(&samples, 1));
            assert_eq!(sequence.far, column(&samples, 2));
            let findings = &dataset.logs[0].findings;
            assert!(
                findings.iter().all(|finding| !finding.contains("note")),
                "text is no column: {findings:?}"
            );
        }
    }

    #[test]
    fn a_damaged_file_is_read_or_refused() {
        let whole = file(&samples(80, 0.0), false);
        let cut = &whole[..whole.len() / 3];
        assert!(!refusal(cut).is_empty());
        survives_damage(&whole);
    }
}

#[cfg(feature = "parquet")]
mod parquet_logs {
    use super::*;
    use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::parser::parse_message_type;
    use std::sync::Arc;

    fn file(samples: &[Sample], compression: parquet::basic::Compression) -> Vec<u8> {
        let schema = "message log {
            required binary trial (STRING);
            required int64 time (TIMESTAMP(MICROS,true));
            required double tension_out_n;
            optional double tension_in_n;
        }";
        let schema = Arc::new(parse_message_type(schema).unwrap());
        let properties = Arc::new(WriterProperties::builder().set_compression(compression).build());
        let mut bytes = Vec::new();
        let mut writer = SerializedFileWriter::new(&mut bytes, schema, properties).unwrap();
        let mut group = writer.next_row_group().unwrap();
        let n = samples.len();
        let trials: Vec<ByteArray> = (0..n).map(|i| if i < n / 2 { "slow" } else { "fast" }.into()).collect();
        let mut next = group.next_column().unwrap().unwrap();
        next.typed::<ByteArrayType>().write_batch(&trials, None, None).unwrap();
        next.close().unwrap();
        let time: Vec<i64> = samples.iter().map(|s| (s[0] * 1e6).round() as i64).collect();
        let mut next = group.next_column().unwrap().unwrap();
        next.typed::<Int64Type>().write_batch(&time, None, None).unwrap();
        next.close().unwrap();
        let mut next = group.next_column().unwrap().unwrap();
        next.typed::<DoubleType>().write_batch(&column(samples, 2), None, None).unwrap();
        next.close().unwrap();
        let mut next = group.next_column().unwrap().unwrap();
        // The last cell is empty.
        let levels: Vec<i16> = (0..n).map(|i| i16::from(i + 1 < n)).collect();
        next.typed::<DoubleType>().write_batch(&column(samples, 1)[..n - 1], Some(&levels), None).unwrap();
        next.close().unwrap();
        group.close().unwrap();
        writer.close().unwrap();
        bytes
    }

    #[test]
    fn columns_trials_times_and_empty_cells_are_read() {
        use parquet::basic::{Compression, GzipLevel};
        let samples = samples(80, 0.0);
        for packing in
            [Compression::UNCOMPRESSED, Compression::SNAPPY, Compression::GZIP(GzipLevel::default())]
        {
            let bytes = file(&samples, packing);
            let dataset =
                read_bytes(&[("log.parquet", &bytes)], &RequestedRoles::default(), &options()).unwrap();
            let trials: Vec<&str> = dataset.sequences.iter().map(|s| s.trial.as_str()).collect();
            assert_eq!(trials, ["slow", "fast"]);
            assert_eq!(dataset.sequences[0].far, column(&samples[..40], 2));
            assert_eq!(dataset.sequences[1].inputs[..39], column(&samples[40..79], 1));
            assert!(dataset.sequences[1].inputs[39].is_nan());
            assert!((dataset.sequences[0].time_s[7] - 0.07).abs() < 1e-9);
        }
    }

    #[test]
    fn text_in_a_number_is_placed() {
        let bytes = file(&samples(80, 0.0), parquet::basic::Compression::UNCOMPRESSED);
        let flags = RequestedRoles { effort: vec!["trial".into()], ..RequestedRoles::default() };
        let got = read_bytes(&[("log.parquet", &bytes)], &flags, &options()).unwrap_err().to_string();
        assert!(got.contains("line 1") && got.contains("`trial`") && got.contains("slow"), "{got}");
    }

    #[test]
    fn a_damaged_file_is_read_or_refused() {
        let whole = file(&samples(80, 0.0), parquet::basic::Compression::SNAPPY);
        assert!(refusal(&whole[..whole.len() / 2]).contains("Parquet"));
        survives_damage(&whole);
    }
}
