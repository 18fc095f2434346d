//! The page of the program itself: a simulated machine, recordings of it, a run while it goes on.

use crate::browser::{Browser, rest};
use crate::checks::{NEAR_M, quiet, ready, settled};
use crate::input::{click, key};
use crate::{Outcome, Requested, reports};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// Frames per second without a graphics processor.
const MIN_FPS: f64 = 20.0;
/// Time of the machine between a click on the stop and the mode that it leads to, s: two states lie between
/// what the page knew and what it sees, 16.7 ms apart.
const STOPS_IN: f64 = 0.04;
const STOPS: usize = 2;
/// Viewers at once.
const VIEWERS: usize = 8;
/// Code of a program whose run did not end as asked.
const NOT_AS_ASKED: i32 = 3;

/// A verb of the program that serves a page; it ends with its value.
struct Served {
    process: Child,
    address: String,
}

impl Served {
    fn start(program: &Path, folder: &Path, arguments: &str) -> Outcome<Self> {
        let mut command = Command::new(program);
        command.args(arguments.split(' ')).args(["--bind", "127.0.0.1:0"]).current_dir(folder);
        let spawned = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
        let mut process = spawned.map_err(|e| format!("{}: {e}", program.display()))?;
        let words = process.stderr.take().ok_or("no output")?;
        let mut lines = BufReader::new(words).lines().map_while(Result::ok);
        let found = lines.by_ref().find_map(|line| {
            line.split_whitespace()
                .find(|word| word.starts_with("http://"))
                .map(|word| word.trim_end_matches(';').to_owned())
        });
        // The program goes on writing.
        std::thread::spawn(move || lines.for_each(drop));
        let address = found.ok_or(format!("`{arguments}` served no page"))?;
        Ok(Self { process, address })
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// All of it; the first that fails is the outcome.
pub(crate) async fn all(page: &Browser, program: &Path, requested: &Requested) -> Outcome<()> {
    let program = std::fs::canonicalize(program).map_err(|e| format!("{}: {e}", program.display()))?;
    let folder = requested.out.join("recordings");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    page.size(1400, 900).await?;
    simulated(page, &program, &folder, requested).await?;
    meshed(page, &program, &folder, requested).await?;
    recorded(page, &program, &folder, requested).await?;
    watched(page, &program, &folder, requested).await?;
    reports::all(page, &program, &folder, requested).await
}

async fn open(page: &Browser, served: &Served) -> Outcome<()> {
    page.go("about:blank").await?;
    page.go(&served.address).await?;
    ready(page).await
}

/// The LM-Arm moves fast enough, stops where it is, and is seen by many at once.
async fn simulated(page: &Browser, program: &Path, folder: &Path, requested: &Requested) -> Outcome<()> {
    let served = Served::start(program, folder, "live lm_arm")?;
    open(page, &served).await?;
    rest(8000).await;
    let fps = page.number("return sinew.fps").await?;
    let busy = requested.busy.map_or(String::new(), |load| format!(", not judged at a load of {load:.1}"));
    println!("the LM-Arm: {fps:.1} frames per second{busy}");
    if fps < MIN_FPS && requested.busy.is_none() {
        return Err(format!("{fps:.1} frames per second, expected {MIN_FPS}"));
    }
    page.picture(&requested.out, "lm-arm").await?;
    let mut longest = 0.0_f64;
    for _ in 0..STOPS {
        page.value("sinew.session.command('mode', { request: 'run' })").await?;
        page.until("the machine runs", "sinew.mode === 'run'").await?;
        let took = page
            .later(
                "const done = arguments[0], s = sinew.session, before = s.time;
             const seen = () => { if (s.mode === 'safe_stop') { s.removeEventListener('state', seen); \
             done(s.time - before); } };
             s.addEventListener('state', seen); document.querySelector('#stop').click();",
            )
            .await?;
        longest = longest.max(took.as_f64().ok_or("no time of the stop")?);
        page.until("the machine is released", "sinew.mode === 'ready'").await?;
    }
    println!("stop: at most {:.0} ms of the machine's time until the page knows of it{busy}", 1e3 * longest);
    if longest > STOPS_IN && requested.busy.is_none() {
        return Err(format!("the machine stopped {longest} s after the click"));
    }
    let counts = page
        .later(&format!(
            "const done = arguments[0], counts = Array({VIEWERS}).fill(0);
         const sockets = counts.map((_, k) => {{ const s = new WebSocket(location.href.replace('http', \
         'ws').split('#')[0] + 'stream', ['sinew.live.1']); s.onmessage = () => {{ counts[k] += 1; }}; \
         return s; }});
         setTimeout(() => {{ sockets.forEach((s) => s.close()); done(counts); }}, 3000);",
        ))
        .await?;
    let least = counts.as_array().into_iter().flatten().filter_map(Value::as_u64).min().unwrap_or(0);
    println!("{VIEWERS} viewers: at least {least} states in 3 s");
    if least < 10 {
        return Err(format!("of {VIEWERS} viewers at once one got {least} states in 3 s"));
    }
    exported(page).await?;
    quiet(page, "of a simulated machine").await?;
    page.go("about:blank").await
}

/// A link whose shape is a file of four triangles is drawn with them, in its place.
async fn meshed(page: &Browser, program: &Path, folder: &Path, requested: &Requested) -> Outcome<()> {
    let write = |name: &str, text: &str| {
        std::fs::write(folder.join(name), text).map_err(|e| format!("{}: {e}", folder.join(name).display()))
    };
    write("wedge.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 -1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")?;
    write(
        "leg.xml",
        r#"<mujoco><asset><mesh file="wedge.obj" scale="0.05 0.05 0.3"/></asset><worldbody><site name="a" pos="0.05 0 0.1"/>
        <body name="thigh"><joint name="hip" axis="0 1 0" range="-40 40"/><inertial pos="0 0 -0.1" mass="1" diaginertia="0.01 0.01 0.01"/>
        <geom type="mesh" mesh="wedge"/><site name="b" pos="0.05 0 -0.1"/></body></worldbody>
        <tendon><spatial name="t"><site site="a"/><site site="b"/></spatial></tendon></mujoco>"#,
    )?;
    let served = Served::start(program, folder, "live leg.xml")?;
    open(page, &served).await?;
    rest(1500).await;
    let found = page.value(
        "const drawn = sinew.view.bodies.looks.get('body').filter(({ parts }) => parts[0].shape.kind === \
            'mesh');
         const { mesh, parts: [{ local }] } = drawn[0], { geometry } = mesh, at = \
         geometry.getAttribute('position');
         geometry.computeBoundingBox();
         const { min, max } = geometry.boundingBox.clone().applyMatrix4(local);
         return { drawn: drawn.length, corners: at.count, box: [...min.toArray(), ...max.toArray()], seen: \
         mesh.visible };",
    ).await?;
    let box_m = [0.0, 0.0, -0.3, 0.05, 0.05, 0.0];
    let fits = box_m
        .iter()
        .enumerate()
        .all(|(k, m): (usize, &f64)| found["box"][k].as_f64().is_some_and(|at| (at - m).abs() <= NEAR_M));
    println!("a shape of a file: {} corners, in the box {} m", found["corners"], found["box"]);
    page.picture(&requested.out, "shape").await?;
    if found["drawn"] != 1 || found["corners"] != 12 || found["seen"] != true || !fits {
        return Err(format!("a shape of a file is drawn wrong: {found}"));
    }
    quiet(page, "with a shape of a file").await?;
    page.go("about:blank").await
}

/// What is seen is saved as a table and as a picture.
async fn exported(page: &Browser) -> Outcome<()> {
    page.value(
        "window.saved = []; const make = URL.createObjectURL; URL.createObjectURL = (blob) => { \
            saved.push(blob); return make(blob); };
         for (const kind of ['CSV', 'PNG']) document.querySelector(`[aria-label='Save what is shown as \
         ${kind}']`).click();",
    )
    .await?;
    page.until("both files are made", "saved.length === 2").await?;
    let found = page
        .later(
            "const done = arguments[0]; Promise.all([saved[0].text(), saved[1].arrayBuffer()]).then(([csv, \
            png]) => done({ rows: csv.trim().split('\\n').map((row) => row.split(',').length), head: \
            csv.slice(0, 6), png: png.byteLength }))",
        )
        .await?;
    let columns: Vec<u64> =
        found["rows"].as_array().into_iter().flatten().filter_map(Value::as_u64).collect();
    let even = columns.len() > 10 && columns.iter().all(|count| *count == columns[0]) && columns[0] > 3;
    println!("saved: {} rows of {} columns, a picture of {} bytes", columns.len(), columns[0], found["png"]);
    if even && found["head"] == "time_s" && found["png"].as_u64().is_some_and(|bytes| bytes > 5000) {
        Ok(())
    } else {
        Err(format!("what is saved is wrong: {found}"))
    }
}

/// A recording goes to any time, by hand and by its events, and carries another one.
async fn recorded(page: &Browser, program: &Path, folder: &Path, requested: &Requested) -> Outcome<()> {
    let record = |name: &str, more: &str| {
        let file = folder.join(name);
        let motion =
            format!("run lm_arm --duration 6 --repeats 1 --hold 0.5 --virtual-time --record {name}{more}");
        let ended = Command::new(program).args(motion.split(' ')).current_dir(folder).output();
        ended.map_err(|e| format!("{}: {e}", program.display()))?;
        if file.is_file() { Ok(()) } else { Err(format!("`{motion}` recorded nothing")) }
    };
    record("first.mcap", "")?;
    record("second.mcap", " --compensation none --fault cable:triceps@4")?;
    let served = Served::start(program, folder, "live second.mcap --overlay first.mcap")?;
    open(page, &served).await?;
    page.until("it plays by itself", "sinew.session.time > 0.5").await?;
    page.value("document.activeElement.blur()").await?;
    key(page, ' ').await?;
    page.until("the space bar pauses it", "sinew.session.flag('paused')").await?;
    page.value(
        "const s = document.querySelector('#replay input'); s.value = 5; s.dispatchEvent(new \
        Event('input')); s.dispatchEvent(new Event('change'))",
    )
    .await?;
    page.until("the scrubber goes to a time", "Math.abs(sinew.session.time - 5) < 1e-9").await?;
    page.until(
        "signals before it are there",
        "sinew.session.history.count > 100 && sinew.session.history.time[sinew.session.history.at(0)] < 0.1",
    )
    .await?;
    let faults = page.number("return sinew.scene.events.filter((e) => e.kind === 'fault').length").await?;
    if faults < 1.0 {
        return Err("the fault of the recording is no event".to_owned());
    }
    // What stands is drawn once more, finer.
    rest(1500).await;
    page.picture(&requested.out, "recording").await?;
    key(page, '[').await?;
    page.until(
        "an event before it is gone to",
        "sinew.session.time < 5 && sinew.scene.events.some((e) => \
        Math.abs(e.time_s - sinew.session.time) < 1e-6)",
    )
    .await?;
    key(page, '.').await?;
    page.until(
        "one cycle is stepped",
        "sinew.scene.events.some((e) => Math.abs(e.time_s + 0.001 - sinew.session.time) < 1e-6)",
    )
    .await?;
    page.value(
        "const s = [...document.querySelectorAll('#replay select')].at(-1); s.value = ''; \
        s.dispatchEvent(new Event('change'))",
    )
    .await?;
    page.until(
        "the other recording is taken away",
        "sinew.scene.compare === null && !sinew.state.body_pose_2",
    )
    .await?;
    println!(
        "recording: played, paused, gone to by hand and by events ({faults:.0} faults), stepped, with \
            another one over it"
    );
    quiet(page, "of a recording").await?;
    page.go("about:blank").await
}

/// A run while it goes on can be stopped, and ends then.
async fn watched(page: &Browser, program: &Path, folder: &Path, requested: &Requested) -> Outcome<()> {
    let mut served = Served::start(program, folder, "run planar_leg --bus segment --page")?;
    open(page, &served).await?;
    page.until("the run goes on", "sinew.mode === 'run' && sinew.session.time > 3.5").await?;
    settled(page).await?;
    page.picture(&requested.out, "run").await?;
    let offered = page.number("return document.querySelectorAll('#commands button').length").await?;
    click(page, "#stop").await?;
    page.until("the run stops", "sinew.mode === 'safe_stop'").await?;
    page.until("the end of the run is shown", "sinew.connection === 'lost'").await?;
    let status = served.process.wait().map_err(|e| e.to_string())?;
    println!("run: stopped from the page, ended with code {:?}", status.code());
    // A request that fails because the program has ended is the browser's own message.
    page.console_errors().await?;
    if offered > 0.0 || status.code() != Some(NOT_AS_ASKED) {
        return Err(format!("a run offers {offered} commands and ended with {status}"));
    }
    Ok(())
}
