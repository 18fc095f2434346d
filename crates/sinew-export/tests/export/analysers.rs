//! Static analysis of exported C: no finding of Clang's analyser nor of cppcheck, where they are there.

use crate::models::{Kind, model};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sinew::compensator::CompensatorSettings;
use sinew_export::{ExportedFile, Name, c, fmu};
use std::path::Path;
use std::process::Command;

const CLANG: &[&str] =
    &["clang", "--analyze", "-std=c99", "-Xclang", "-analyzer-output=text", "-Xclang", "-analyzer-werror"];
/// Without the headers of the C library it has to be told what `float.h` says. A variable without an
/// initialiser that is static and constant is zero, as meant. Parameters and structures of FMI are the
/// standard's.
const CPPCHECK: &[&str] = &[
    "cppcheck",
    "--quiet",
    "--std=c99",
    "--enable=warning,style,performance,portability",
    "--suppress=unassignedVariable",
    "--suppress=constParameter",
    "--suppress=unusedStructMember",
    "-DDBL_MANT_DIG=53",
    "-DDBL_MAX_EXP=1024",
    "-DFLT_MANT_DIG=24",
    "-DFLT_EVAL_METHOD=0",
    "--error-exitcode=1",
];

/// What the analysers find in the sources among some files.
fn found(files: &[ExportedFile], label: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    for file in files.iter().filter(|file| !file.path.contains('/')) {
        std::fs::write(folder.path().join(&file.path), &file.bytes).unwrap();
    }
    let sources =
        files.iter().map(|file| &file.path).filter(|path| path.ends_with(".c") && !path.contains('/'));
    let sources: Vec<&String> = sources.collect();
    let all =
        [CLANG, CPPCHECK].into_iter().filter_map(|analyser| findings(analyser, folder.path(), &sources));
    all.filter(|said| !said.is_empty()).map(|said| format!("{label}: {said}\n")).collect()
}

/// What an analyser says; none without it.
fn findings(analyser: &[&str], folder: &Path, sources: &[&String]) -> Option<String> {
    let mut command = Command::new(analyser[0]);
    let Ok(output) = command.args(&analyser[1..]).args(sources).current_dir(folder).output() else {
        println!("skipped: no {}", analyser[0]);
        return None;
    };
    let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() || !said.is_empty(), "{}: {}", analyser[0], output.status);
    Some(said.into_owned())
}

#[test]
fn analysers_find_nothing_in_exported_c() {
    let (name, mut all) = (Name::new("exported").unwrap(), String::new());
    // Between them they need every part of the generated code.
    let few = [Kind::Observer, Kind::HybridCell, Kind::Mean, Kind::AxisForce, Kind::AxisMotion];
    let kinds = if std::env::var_os("SINEW_LONG").is_some() { &Kind::ALL[..] } else { &few };
    for &kind in kinds {
        let model = model(kind, &mut ChaCha8Rng::seed_from_u64(1000 * kind as u64));
        let settings = CompensatorSettings { rate: Some(50.0), ..CompensatorSettings::default() };
        let content = c::Content::Compensator(settings);
        // The example depends on columns alone.
        let files = match kind {
            Kind::Observer => c::files(&model, &name, content).unwrap(),
            _ => Vec::from(c::library(&model, &name, content).unwrap()),
        };
        all += &found(&files, &format!("{kind:?}"));
    }
    let model = model(Kind::HybridObserver, &mut ChaCha8Rng::seed_from_u64(1));
    for version in [fmu::Version::Three, fmu::Version::Two] {
        let unit = fmu::Unit::of_model(&model, &name, c::Content::Predictor, version).unwrap();
        // The model is the same in both.
        let mut sources = unit.sources().to_vec();
        sources.retain(|file| version == fmu::Version::Three || file.path != "exported.c");
        all += &found(&sources, &format!("{version:?}"));
        let plant = crate::units::plant();
        let unit = fmu::Unit::of_plant(&plant, &name, version).unwrap();
        all += &found(unit.sources(), &format!("{version:?} of a plant"));
    }
    assert_eq!(all, "");
}
