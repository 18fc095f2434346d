//! Exported C on a Cortex-M4F and a Cortex-M7 in QEMU, and the flash that it needs; skipped without
//! `arm-none-eabi-gcc` and `qemu-system-arm`.

use crate::bits::{HARNESS, bytes, predicted};
use crate::compiler::{STRICT, first_difference, rows_of, run_program};
use crate::models::{Kind, model};
use crate::samples::rows;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sinew_export::{Name, c};
use std::path::Path;
use std::process::Command;

const M4: [&str; 3] = ["-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"];
const M7: [&str; 3] = ["-mcpu=cortex-m7", "-mfloat-abi=hard", "-mfpu=fpv5-d16"];
/// Of a whole program that predicts in a loop, on an M4 at -Os, bytes.
const FLASH: usize = 16 * 1024;

/// The smallest program: inputs and prediction at fixed places, as with registers of a converter.
const LOOP: &str = r"
#include <exported.h>
static exported_state state;
static volatile double port[1 + EXPORTED_INPUTS], result[4];
int main(void)
{
    exported_init(&state);
    for (;;) {
        double inputs[EXPORTED_INPUTS];
        exported_prediction p;
        int i;
        for (i = 0; i < EXPORTED_INPUTS; i++) {
            inputs[i] = port[1 + i];
        }
        p = exported_step(&state, port[0], inputs);
        result[0] = p.mean;
        result[1] = p.standard_deviation;
        result[2] = p.gate;
        result[3] = (double)p.flags;
    }
}
";

fn there() -> bool {
    let works = |name: &str| Command::new(name).arg("--version").output().is_ok_and(|o| o.status.success());
    let found = ["arm-none-eabi-gcc", "arm-none-eabi-size", "qemu-system-arm"].into_iter().all(works);
    if !found {
        println!("skipped: no arm-none-eabi-gcc or no qemu-system-arm");
    }
    found
}

/// Compiles `exported.c` and a main program to `program`.
fn compile(folder: &Path, main: &str, flags: &[&str]) {
    std::fs::write(folder.join("main.c"), main).unwrap();
    std::fs::write(folder.join("start.c"), include_str!("cortex/start.c")).unwrap();
    std::fs::write(folder.join("board.ld"), include_str!("cortex/board.ld")).unwrap();
    let mut command = Command::new("arm-none-eabi-gcc");
    command.current_dir(folder).args(["-std=c99", "-mthumb", "-I."]).args(STRICT).args(flags);
    command.args(["-T", "board.ld", "start.c", "exported.c", "main.c", "-lm", "-o", "program"]);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn both_cortex_m_predict_the_bits_of_the_library() {
    if !there() {
        return;
    }
    let long = std::env::var_os("SINEW_LONG").is_some();
    let (models, count) = if long { (10, 10_000) } else { (1, 400) };
    for kind in Kind::ALL {
        for seed in 0..models {
            let mut random = ChaCha8Rng::seed_from_u64(1000 * kind as u64 + seed);
            let model = model(kind, &mut random);
            let rows = rows(count, &mut random);
            let (folder, expected) = (tempfile::tempdir().unwrap(), predicted(&model, &rows));
            for file in c::library(&model, &Name::new("exported").unwrap(), c::Content::Predictor).unwrap() {
                std::fs::write(folder.path().join(&file.path), &file.bytes).unwrap();
            }
            for (board, core) in [("mps2-an386", M4), ("mps2-an500", M7)] {
                compile(folder.path(), HARNESS, &[&core[..], &["-O2", "--specs=rdimon.specs"]].concat());
                let mut qemu = Command::new("qemu-system-arm");
                qemu.args(["-M", board, "-nographic", "-monitor", "none", "-serial", "none"]);
                qemu.args(["-semihosting-config", "enable=on,target=native", "-kernel"]);
                qemu.arg(folder.path().join("program"));
                let got = rows_of(&run_program(qemu, &bytes(&rows)));
                let different = first_difference(&got, &expected);
                assert_eq!(different, None, "{kind:?} {seed} on {board}: row, on the core, in Rust");
            }
        }
    }
}

#[test]
fn a_whole_program_for_a_cortex_m4_fits_16_kilobytes_of_flash() {
    if !there() {
        return;
    }
    for kind in [Kind::Cell, Kind::HybridCell, Kind::Observer, Kind::AxisForce, Kind::Perceptron] {
        let folder = tempfile::tempdir().unwrap();
        let model = model(kind, &mut ChaCha8Rng::seed_from_u64(1000 * kind as u64));
        for file in c::library(&model, &Name::new("exported").unwrap(), c::Content::Predictor).unwrap() {
            std::fs::write(folder.path().join(&file.path), &file.bytes).unwrap();
        }
        // The linker warns of the system calls of nosys.specs, which are never made.
        let flags =
            ["-Os", "--specs=nosys.specs", "-ffunction-sections", "-fdata-sections", "-Wl,--gc-sections,-w"];
        compile(folder.path(), LOOP, &[&M4[..], &flags].concat());
        let output = Command::new("arm-none-eabi-size").arg(folder.path().join("program")).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let mut sizes = text.lines().nth(1).unwrap().split_whitespace().map(|n| n.parse::<usize>().unwrap());
        let flash = sizes.next().unwrap() + sizes.next().unwrap();
        println!("{kind:?}: {flash} bytes");
        assert!(flash <= FLASH, "{kind:?}: {flash} bytes");
    }
}
