//! Any bytes as a log, and what must hold of whatever is accepted.

use sinew_identify::log::{Dataset, ReadOptions, RequestedRoles, read_bytes};

/// Reads `bytes` as a log by canonical names, by numbered names and with a group; checks what is accepted.
pub fn read_log(bytes: &[u8]) {
    let numbered = RequestedRoles {
        far: Some("col3".into()),
        effort: vec!["col2".into()],
        time: Some("col1".into()),
        ..RequestedRoles::default()
    };
    let grouped = RequestedRoles { group: Some("load".into()), ..RequestedRoles::default() };
    for flags in [RequestedRoles::default(), numbered, grouped] {
        for (skip_s, far_required) in [(0.0, true), (0.1, false)] {
            let options = ReadOptions { skip_s, far_required, ..ReadOptions::default() };
            let twice = [("a", bytes), ("b", bytes)];
            for logs in [&twice[..1], &twice[..]] {
                match read_bytes(logs, &flags, &options) {
                    Ok(dataset) => check(&dataset),
                    Err(error) => assert!(!error.to_string().is_empty()),
                }
            }
        }
    }
}

/// The promises of the types in `sinew_identify::log`.
pub fn check(dataset: &Dataset) {
    for sequence in &dataset.sequences {
        let n = sequence.row.len();
        assert!(n > 0 && sequence.log < dataset.logs.len());
        assert_eq!(sequence.time_s.len(), n);
        assert_eq!(sequence.inputs.len(), n * dataset.roles.inputs.len());
        assert_eq!(sequence.far.len(), n);
        assert_eq!(sequence.far_clean.len(), n);
        assert_eq!(sequence.scored.len(), n);
        assert_eq!(sequence.condition_values.len(), dataset.conditions.len());
        assert!(sequence.time_s.iter().all(|t| t.is_finite()), "time is finite");
        assert!(sequence.time_s.windows(2).all(|w| w[0] < w[1]), "time runs forward");
        assert!(!sequence.inputs.iter().chain(&sequence.far).any(|x| x.is_infinite()));
        assert!(sequence.scored.iter().zip(&sequence.far).all(|(s, far)| !s || far.is_finite()));
    }
    let samples: usize = dataset.logs.iter().map(|log| log.samples).sum();
    assert_eq!(samples, dataset.sequences.iter().map(|s| s.row.len()).sum::<usize>());
}

/// Any bytes after the header of a MATLAB v5 file, in both byte orders.
pub fn read_mat5(bytes: &[u8]) {
    let Some((order, body)) = bytes.split_first() else { return };
    let mut file = vec![b' '; 124];
    file.extend(if order & 1 == 0 { *b"\x00\x01IM" } else { *b"\x01\x00MI" });
    file.extend(body);
    read_log(&file);
}

/// Any bytes that start like an HDF5 file.
pub fn read_mat73(bytes: &[u8]) {
    if bytes.starts_with(b"\x89HDF\r\n\x1a\n") {
        read_log(bytes);
    }
}

/// Any bytes that start like a Parquet file.
pub fn read_parquet(bytes: &[u8]) {
    if bytes.starts_with(b"PAR1") {
        read_log(bytes);
    }
}
