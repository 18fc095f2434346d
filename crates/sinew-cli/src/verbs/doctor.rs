//! `sinew doctor`.

use crate::answer::{Answer, Content};
use crate::arguments::General;
use crate::error::Error;
use crate::table::table;
use crate::version::version;
use serde::Serialize;
use sinew_runtime::cycle::RealTime;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Time after which another program's answer is no longer waited for.
const PATIENCE: Duration = Duration::from_secs(10);

/// Programs that show a page, in the order in which they are looked for.
const BROWSERS: [&str; 7] =
    ["xdg-open", "chromium", "chromium-browser", "google-chrome", "firefox", "microsoft-edge", "open"];

/// One thing that a verb may need of this computer.
#[derive(Debug, Serialize)]
struct Finding {
    /// What it is.
    part: &'static str,
    available: bool,
    /// What was found.
    found: String,
    /// What it is for, and what helps where it is missing.
    needed_for: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    remedy: Option<String>,
}

pub(crate) fn run(general: &General) -> Result<Answer, Error> {
    let findings = [
        program(),
        real_time(),
        raw_frames(),
        browser(),
        python(
            "the Python package",
            "import sinew, sys; print(sinew.__version__, 'for Python', sys.version.split()[0])",
        ),
        python("MuJoCo", "import mujoco; print(mujoco.__version__)"),
        compiler(),
    ];
    let content = if general.json {
        Content::json(&serde_json::json!({ "findings": findings }))?
    } else {
        Content::Text(text(&findings))
    };
    Ok(Answer::done(content, Vec::new()))
}

fn text(findings: &[Finding]) -> String {
    let row = |finding: &Finding| {
        let state = if finding.available { "yes" } else { "no" };
        [finding.part, state, &finding.found, finding.needed_for].map(str::to_owned).to_vec()
    };
    let rows: Vec<Vec<String>> = findings.iter().map(row).collect();
    let remedy = |finding: &Finding| Some(format!("{}: {}\n", finding.part, finding.remedy.as_ref()?));
    let remedies: String = findings.iter().filter_map(remedy).collect();
    let what_helps = if remedies.is_empty() { String::new() } else { format!("\nWhat helps:\n{remedies}") };
    table(&["part", "there", "found", "needed for"], &rows, 4) + &what_helps
}

fn program() -> Finding {
    Finding {
        part: "this program",
        available: true,
        found: format!("{} on {} {}", version(), std::env::consts::OS, std::env::consts::ARCH),
        needed_for: "everything but the rows below",
        remedy: None,
    }
}

/// On a thread of its own, so that nothing else inherits the priority.
fn real_time() -> Finding {
    let granted = std::thread::spawn(RealTime::request).join().unwrap_or_default();
    let refused = &granted.shortcomings;
    let each = |text: fn(&sinew_runtime::cycle::Shortcoming) -> String| {
        refused.iter().map(text).collect::<Vec<_>>().join("; ")
    };
    Finding {
        part: "real time",
        available: refused.is_empty(),
        found: if refused.is_empty() {
            "locked memory and SCHED_FIFO".to_owned()
        } else {
            each(|shortcoming| format!("{}: {}", shortcoming.what, shortcoming.why))
        },
        needed_for: "`run` on hardware at 1 ms",
        remedy: (!refused.is_empty()).then(|| each(|shortcoming| shortcoming.remedy.to_owned())),
    }
}

/// Whether frames may be sent without a protocol: tried on the loopback interface, to which nothing is sent.
#[cfg(target_os = "linux")]
fn raw_frames() -> Finding {
    let opened = sinew_runtime::ethercat::RawSocketLink::open("lo");
    let interfaces = std::fs::read_dir("/sys/class/net").into_iter().flatten().flatten();
    let mut names: Vec<String> =
        interfaces.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort_unstable();
    Finding {
        part: "raw Ethernet frames",
        available: opened.is_ok(),
        found: format!("interfaces: {}", names.join(", ")),
        needed_for: "`run --bus ethercat`, `ethercat`",
        remedy: opened.err().map(|error| error.to_string()),
    }
}

#[cfg(not(target_os = "linux"))]
fn raw_frames() -> Finding {
    Finding {
        part: "raw Ethernet frames",
        available: false,
        found: format!("none on {}", std::env::consts::OS),
        needed_for: "`run --bus ethercat`, `ethercat`",
        remedy: Some("use a computer with Linux".to_owned()),
    }
}

fn browser() -> Finding {
    let folders: Vec<_> =
        std::env::var_os("PATH").map(|path| std::env::split_paths(&path).collect()).unwrap_or_default();
    let is_there =
        |name: &&&str| folders.iter().any(|folder: &std::path::PathBuf| folder.join(name).is_file());
    let found = BROWSERS.iter().find(is_there);
    Finding {
        part: "browser",
        available: found.is_some(),
        found: found.map_or_else(|| "none in PATH".to_owned(), |name| (*name).to_owned()),
        needed_for: "reports, `live`, `--page`, `--open`",
        remedy: found
            .is_none()
            .then(|| "open reports and pages with a browser of another computer".to_owned()),
    }
}

fn python(part: &'static str, script: &str) -> Finding {
    let answer = answer("python3", &["-c", script]);
    let remedy = match part {
        "MuJoCo" => "pip install mujoco",
        _ => "pip install . in the folder of this program's sources; the distribution is sinew-robotics",
    };
    Finding {
        part,
        available: answer.is_ok(),
        needed_for: if part == "MuJoCo" {
            "`sinew.mujoco` and its plugins"
        } else {
            "Python, notebooks, training"
        },
        remedy: answer.is_err().then(|| remedy.to_owned()),
        found: answer.unwrap_or_else(|why| why),
    }
}

fn compiler() -> Finding {
    let answer = answer("cc", &["--version"]);
    Finding {
        part: "C compiler",
        available: answer.is_ok(),
        needed_for: "building this program; exported C",
        remedy: answer.is_err().then(|| "install GCC or Clang".to_owned()),
        found: answer.unwrap_or_else(|why| why),
    }
}

/// First line that a program prints; last line of its complaint where it fails.
fn answer(program: &str, arguments: &[&str]) -> Result<String, String> {
    let mut child = Command::new(program)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| format!("{program}: {error}"))?;
    let since = Instant::now();
    while child.try_wait().map_err(|error| format!("{program}: {error}"))?.is_none() {
        if since.elapsed() > PATIENCE {
            // Its answer no longer matters, nor whether it had just ended.
            let _ = child.kill();
            let _ = child.wait();
            return Err(format!("{program} gave no answer within {} s", PATIENCE.as_secs()));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let output = child.wait_with_output().map_err(|error| format!("{program}: {error}"))?;
    let lines = |bytes: &[u8]| String::from_utf8_lossy(bytes).lines().map(str::to_owned).collect::<Vec<_>>();
    if output.status.success() {
        return lines(&output.stdout).into_iter().next().ok_or_else(|| format!("{program} printed nothing"));
    }
    Err(lines(&output.stderr).pop().unwrap_or_else(|| format!("{program} ended with {}", output.status)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_program_answers_with_its_first_line_or_its_last_complaint() {
        assert_eq!(answer("sh", &["-c", "echo one; echo two"]).unwrap(), "one");
        assert_eq!(answer("sh", &["-c", "echo first >&2; echo last >&2; exit 1"]).unwrap_err(), "last");
        assert!(answer("no-such-program", &[]).unwrap_err().starts_with("no-such-program: "));
    }

    #[test]
    fn what_is_missing_comes_with_a_remedy_and_nothing_else_does() {
        for finding in [program(), real_time(), raw_frames(), browser(), compiler()] {
            assert_eq!(finding.available, finding.remedy.is_none(), "{finding:?}");
            assert!(!finding.found.is_empty(), "{finding:?}");
        }
    }
}
