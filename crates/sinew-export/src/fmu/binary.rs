//! The binary of a unit, by the C compiler of this machine.

use super::version::Version;
use crate::{ExportError, ExportedFile, Name};
use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, Stdio};

/// Where the binary of this machine stands in a unit of FMI 3.0.
pub const PLATFORM: &str = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
    "x86_64-linux"
} else if cfg!(all(target_os = "linux", target_arch = "aarch64")) {
    "aarch64-linux"
} else if cfg!(all(target_os = "macos", target_arch = "aarch64")) {
    "aarch64-darwin"
} else if cfg!(target_os = "macos") {
    "x86_64-darwin"
} else if cfg!(target_os = "windows") {
    "x86_64-windows"
} else {
    "unknown"
};

/// The shared library of sources for this machine; none where there is no such compiler.
pub(super) fn compile(sources: &[ExportedFile], compiler: &Path) -> Result<Option<Vec<u8>>, ExportError> {
    let refuse = |reason: String| ExportError::Compiler { compiler: compiler.to_owned(), reason };
    let folder = tempfile::tempdir().map_err(|error| refuse(error.to_string()))?;
    for file in sources {
        std::fs::write(folder.path().join(&file.path), &file.bytes)
            .map_err(|error| refuse(error.to_string()))?;
    }
    let mut command = Command::new(compiler);
    command.current_dir(folder.path()).stdin(Stdio::null());
    command.args(["-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden"]);
    let code = sources.iter().map(|file| &file.path).filter(|path| path.ends_with(".c"));
    command.args(code).args(["-o", "binary", "-lm"]);
    match command.output() {
        Ok(output) if output.status.success() => {
            let bytes = std::fs::read(folder.path().join("binary"));
            bytes.map(Some).map_err(|error| refuse(error.to_string()))
        }
        Ok(output) => {
            let said = String::from_utf8_lossy(&output.stderr);
            Err(refuse(said.lines().next().unwrap_or("it failed without a word").to_owned()))
        }
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(refuse(error.to_string())),
    }
}

/// Place of the binary below `binaries`.
pub(super) fn place(name: &Name, version: Version) -> String {
    let (system, extension) = match std::env::consts::OS {
        "macos" => ("darwin64", "dylib"),
        "windows" => ("win64", "dll"),
        _ => ("linux64", "so"),
    };
    let folder = if version == Version::Three { PLATFORM } else { system };
    format!("{folder}/{}.{extension}", name.as_str())
}
