//! What the fuzz targets do with any bytes, as functions of the workspace, so that every check and test sees
//! them. Each panics where a promise of a reader is broken.

mod logs;
mod models;
mod recordings;
mod robots;
mod wire;

pub use logs::{read_log, read_mat5, read_mat73, read_parquet};
pub use models::read_model;
pub use recordings::read_recording;
pub use robots::{read_machine, read_mjcf, read_osim, read_robot_toml, read_urdf};
pub use wire::{play_link, play_segment, read_device, read_page_command};

use std::process::ExitCode;

/// A fuzz target: the fuzzer's entry where the build is instrumented (`--cfg fuzzing`), elsewhere a program
/// that runs the files it is given, such as a finding.
#[macro_export]
macro_rules! target {
    ($run:path $(, init: $init:expr)?) => {
        #[cfg(fuzzing)]
        libfuzzer_sys::fuzz_target!($(init: $init,)? |bytes: &[u8]| $run(bytes));

        #[cfg(not(fuzzing))]
        fn main() -> std::process::ExitCode {
            $crate::run_files($run)
        }
    };
}

/// Runs the files of the command line.
pub fn run_files(run: fn(&[u8])) -> ExitCode {
    for path in std::env::args_os().skip(1) {
        match std::fs::read(&path) {
            Ok(bytes) => run(&bytes),
            Err(error) => {
                eprintln!("{}: {error}", path.display());
                return ExitCode::from(2);
            }
        }
    }
    ExitCode::SUCCESS
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// Runs every file of `seeds`, or of another folder of the repository.
    fn seeds(folder: &str, run: fn(&[u8])) {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        let files = std::fs::read_dir(&folder).expect("the seeds are there");
        let mut count = 0;
        for file in files {
            let path = file.expect("a file").path();
            run(&std::fs::read(&path).expect("a seed is read"));
            count += 1;
        }
        assert!(count > 0, "{}", folder.display());
    }

    #[test]
    fn what_every_target_promises_holds_for_its_seeds() {
        seeds("seeds/csv_log", read_log);
        seeds("seeds/mat5_log", read_mat5);
        seeds("seeds/mat73_log", read_mat73);
        seeds("seeds/parquet_log", read_parquet);
        seeds("seeds/mjcf", read_mjcf);
        seeds("seeds/urdf", read_urdf);
        seeds("seeds/osim", read_osim);
        seeds("seeds/robot_toml", read_robot_toml);
        seeds("seeds/machine", read_machine);
        seeds("seeds/model", read_model);
        seeds("seeds/page_command", read_page_command);
        seeds("../crates/sinew-segment/tests/segment/esi", read_device);
        // Random to their readers: packets, frames and blocks are drawn from the bytes.
        for run in [play_link, play_segment, read_recording] {
            seeds("seeds/csv_log", run);
        }
    }
}
