//! The check of the live page: a headless Chromium opens it and acts as a person would.
//!
//! `sinew-view-browser [--address URL] [--axe FILE] [--out FOLDER] [--program FILE]`. Without an address the
//! page is served here, of a synthetic machine whose positions are known. Skipped with a message where there
//! is no Chromium. With `SINEW_LONG` in the environment the memory of the browser is watched for an hour.

mod browser;
mod checks;
mod input;
mod machine;
mod memory;
mod program;
mod reports;
mod server;

use browser::Browser;
use std::path::PathBuf;
use std::process::ExitCode;

/// What can go wrong, in words.
pub(crate) type Outcome<T> = Result<T, String>;

/// What the check was asked for.
#[derive(Debug, Default)]
pub(crate) struct Requested {
    /// A server that runs already.
    pub(crate) address: Option<String>,
    /// axe-core, as one script.
    pub(crate) axe: Option<PathBuf>,
    /// The program, whose own pages are then looked at as well.
    pub(crate) program: Option<PathBuf>,
    /// Folder of the screenshots.
    pub(crate) out: PathBuf,
    /// Mean number of waiting programs before the check, where others have the processors: times are then
    /// told, not judged.
    pub(crate) busy: Option<f64>,
}

/// The load of the last minute, where it is more than half of what the machine has processors.
fn busy() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/loadavg").ok()?;
    let load: f64 = text.split(' ').next()?.parse().ok()?;
    let processors = std::thread::available_parallelism().map_or(1.0, |count| count.get() as f64);
    (load > 0.5 * processors).then_some(load)
}

fn requested() -> Outcome<Requested> {
    let mut requested = Requested { out: PathBuf::from("out/page"), busy: busy(), ..Requested::default() };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word} needs a value"));
        match word.as_str() {
            "--address" => requested.address = Some(value()?),
            "--axe" => requested.axe = Some(PathBuf::from(value()?)),
            "--out" => requested.out = PathBuf::from(value()?),
            "--program" => requested.program = Some(PathBuf::from(value()?)),
            other => {
                return Err(format!("unknown argument {other}; expected --address, --axe, --out, --program"));
            }
        }
    }
    Ok(requested)
}

fn run() -> Outcome<()> {
    let requested = requested()?;
    let Some(driver) = browser::driver()? else {
        println!(
            "skipped: no Chromium with its driver here (Debian: apt-get install chromium chromium-driver)"
        );
        return Ok(());
    };
    std::fs::create_dir_all(&requested.out).map_err(|e| format!("{}: {e}", requested.out.display()))?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let runtime = runtime.map_err(|e| format!("no runtime: {e}"))?;
    runtime.block_on(async {
        let server = if requested.address.is_some() { None } else { Some(server::Server::start()?) };
        let address = requested.address.clone().or_else(|| server.as_ref().map(server::Server::address));
        let page = Browser::open(&driver).await?;
        let mut outcome = checks::all(&page, &address.unwrap_or_default(), server.as_ref(), &requested).await;
        if let (Ok(()), Some(program)) = (&outcome, &requested.program) {
            outcome = program::all(&page, program, &requested).await;
        }
        page.close().await;
        outcome
    })
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}
