//! What the page must do, one sentence each, in the order of a visit.

use crate::browser::{Browser, rest};
use crate::input::{click, drag, key};
use crate::server::Server;
use crate::{Outcome, Requested, memory};
use serde_json::Value;
use std::time::{Duration, Instant};

/// First frame after the start of the page; the best of some visits, as another program may have the
/// processor.
const FIRST_FRAME_MS: f64 = 2000.0;
const VISITS: usize = 3;
/// Silence of the server until the page says so.
const LOST: Duration = Duration::from_millis(1000);
/// What the page and the check need to notice, on a loaded machine.
const NOTICE: Duration = Duration::from_millis(700);
/// Distance of a drawn position from the one that was sent, m.
pub(crate) const NEAR_M: f64 = 1e-6;
/// Space bar and tabulator in WebDriver's alphabet.
const SPACE: char = ' ';
const TAB: char = '\u{e004}';

/// All checks; the first that fails is the outcome.
pub(crate) async fn all(
    page: &Browser,
    address: &str,
    server: Option<&Server>,
    requested: &Requested,
) -> Outcome<()> {
    let began = Instant::now();
    let out = &requested.out;
    page.size(1400, 900).await?;
    first_frame(page, address, requested).await?;
    settled(page).await?;
    page.picture(out, "light").await?;
    positions(page, server).await?;
    pace(page).await?;
    story(page, address, requested).await?;
    page.value("localStorage.setItem('sinew-theme', 'dark')").await?;
    page.go(address).await?;
    ready(page).await?;
    settled(page).await?;
    page.picture(out, "dark").await?;
    accessible(page, requested, "dark").await?;
    page.value("localStorage.setItem('sinew-theme', 'light')").await?;
    page.go(address).await?;
    ready(page).await?;
    accessible(page, requested, "light").await?;
    dragged(page, requested).await?;
    stopped(page, requested).await?;
    keyboard(page).await?;
    if let Some(server) = server {
        lost_and_healed(page, server, requested).await?;
    }
    phone(page, requested).await?;
    page.size(1400, 900).await?;
    quiet(page, "after the visit").await?;
    memory::steady(page).await?;
    quiet(page, "at the end").await?;
    println!("page: all in {:.0} s; pictures in {}", began.elapsed().as_secs_f64(), out.display());
    Ok(())
}

/// Waits until a machine is sampled.
pub(crate) async fn ready(page: &Browser) -> Outcome<()> {
    page.until(
        "the page shows a machine",
        "window.sinew && sinew.ready && sinew.connection === 'open' && sinew.state",
    )
    .await?;
    Ok(())
}

async fn first_frame(page: &Browser, address: &str, requested: &Requested) -> Outcome<()> {
    let mut best = f64::INFINITY;
    for _ in 0..VISITS {
        page.go(address).await?;
        ready(page).await?;
        best = best.min(page.number("return sinew.firstFrameMs").await?);
        if best <= FIRST_FRAME_MS {
            break;
        }
    }
    let busy = requested.busy.map_or(String::new(), |load| format!(", not judged at a load of {load:.1}"));
    println!("first frame: {best:.0} ms{busy}");
    if best > FIRST_FRAME_MS && requested.busy.is_none() {
        return Err(format!("the first frame came after {best:.0} ms, expected {FIRST_FRAME_MS:.0}"));
    }
    rest(2000).await;
    quiet(page, "after the start").await
}

/// Waits for some more frames, so that a picture shows what was asked for.
pub(crate) async fn settled(page: &Browser) -> Outcome<()> {
    let drawn = page.number("return sinew.view.stage.frames").await?;
    page.until("frames are drawn", &format!("sinew.view.stage.frames > {drawn} + 4")).await?;
    rest(400).await;
    Ok(())
}

/// No error in the console, none of a script.
pub(crate) async fn quiet(page: &Browser, when: &str) -> Outcome<()> {
    let mut errors = page.console_errors().await?;
    let own = page.value("return sinew.errors").await?;
    errors.extend(own.as_array().into_iter().flatten().map(Value::to_string));
    if errors.is_empty() { Ok(()) } else { Err(format!("{when} the page reports: {}", errors.join("; "))) }
}

/// Where bodies are drawn is where the server says they are.
async fn positions(page: &Browser, server: Option<&Server>) -> Outcome<()> {
    let mut largest = 0.0_f64;
    for _ in 0..5 {
        rest(100).await;
        // The frame that stands: what it shows, and how far each shape lies from its body's pose.
        let found = page
            .value(
                "const v = sinew.view, now = v.now; let worst = 0;
             for (const { mesh, parts } of v.bodies.looks.get('body')) parts.forEach(({ shape, local }, k) \
             => {
               const b = 7 * shape.body, [x, y, z] = [12, 13, 14].map((i) => local.elements[i]), p = \
               now.body_pose;
               const [w, a, c, d] = [p[b + 3], p[b + 4], p[b + 5], p[b + 6]];
               const t = [c * z - d * y, d * x - a * z, a * y - c * x].map((v) => 2 * v);
               const at = [x + w * t[0] + c * t[2] - d * t[1], y + w * t[1] + d * t[0] - a * t[2], z + w * \
               t[2] + a * t[1] - c * t[0]];
               const drawn = mesh.instanceMatrix.array.slice(16 * k + 12, 16 * k + 15);
               worst = Math.max(worst, ...at.map((v, i) => Math.abs(p[b + i] + v - drawn[i])));
             });
             return { worst, sequence: now.sequence[0], poses: [...now.body_pose] };",
            )
            .await?;
        largest = largest.max(found["worst"].as_f64().unwrap_or(f64::NAN));
        let Some(server) = server else { continue };
        let sequence = found["sequence"].as_f64().ok_or("no sequence")?;
        let sent = server.sent(sequence).ok_or(format!("state {sequence} was not sent"))?;
        for (k, expected) in sent.iter().enumerate() {
            let shown = found["poses"][k].as_f64().unwrap_or(f64::NAN);
            largest = largest.max((shown - expected).abs());
        }
    }
    println!("positions: within {largest:.1e} m of the server's");
    if largest <= NEAR_M {
        Ok(())
    } else {
        Err(format!("a position is off by {largest:e} m, expected at most {NEAR_M:e}"))
    }
}

/// Frames per second are reported; only a page that stands still fails, as other programs share the
/// processor.
async fn pace(page: &Browser) -> Outcome<()> {
    rest(3000).await;
    let fps = page.number("return sinew.fps").await?;
    let fraction = page.number("return sinew.fraction").await?;
    let software = page.value("return sinew.view.stage.software").await? == Value::Bool(true);
    let how = if software { "software rendering" } else { "a graphics processor" };
    println!("pace: {fps:.1} frames per second with {how}, at {:.0} % of the resolution", 100.0 * fraction);
    if fps > 0.5 { Ok(()) } else { Err(format!("{fps} frames per second")) }
}

/// Every step of the introduction has a link that opens it.
async fn story(page: &Browser, address: &str, requested: &Requested) -> Outcome<()> {
    for step in 1..=5 {
        page.go("about:blank").await?;
        page.go(&format!("{address}#story={step}")).await?;
        ready(page).await?;
        page.until(
            "the step is shown",
            &format!("document.querySelector('#story [aria-current=step]')?.textContent === '{step}'"),
        )
        .await?;
        settled(page).await?;
        page.picture(&requested.out, &format!("story-{step}")).await?;
    }
    Ok(())
}

/// Dragging the end point moves it.
async fn dragged(page: &Browser, requested: &Requested) -> Outcome<()> {
    page.later("const done = arguments[0]; sinew.session.command('mode', { request: 'hold' }).then(done)")
        .await?;
    // Until the machine rests and is drawn so.
    rest(800).await;
    settled(page).await?;
    let at = page
        .value(
            "const v = sinew.view, p = v.surroundings.handle.position.clone().project(v.stage.camera), b = \
            v.stage.canvas.getBoundingClientRect();
         return [b.left + (0.5 + 0.5 * p.x) * b.width, b.top + (0.5 - 0.5 * p.y) * b.height];",
        )
        .await?;
    let from = [0, 1].map(|k| at[k].as_f64().unwrap_or(0.0));
    let before = page.value("return [...sinew.state.end_point]").await?;
    drag(page, from, [-60.0, -70.0], Duration::from_millis(1200)).await?;
    page.picture(&requested.out, "dragged").await?;
    let after = page.value("return [...sinew.state.end_point]").await?;
    let moved = (0..3)
        .map(|k| (after[k].as_f64().unwrap_or(0.0) - before[k].as_f64().unwrap_or(0.0)).powi(2))
        .sum::<f64>()
        .sqrt();
    println!("drag: the end point moved by {:.0} mm", 1e3 * moved);
    if moved > 0.01 { Ok(()) } else { Err(format!("the drag moved the end point by {moved} m")) }
}

/// The stop acts by a click and by the space bar, wherever the focus is.
async fn stopped(page: &Browser, requested: &Requested) -> Outcome<()> {
    for by_key in [false, true] {
        page.later("const done = arguments[0]; sinew.session.command('mode', { request: 'run' }).then(done)")
            .await?;
        page.until("the machine runs", "/run/.test(sinew.mode)").await?;
        if by_key {
            page.value("document.querySelector('#theme').focus()").await?;
            key(page, SPACE).await?;
        } else {
            click(page, "#stop").await?;
        }
        let took = page.until("the machine stops", "/stop/.test(sinew.mode)").await?;
        println!(
            "stop by {}: shown after {} ms",
            if by_key { "the space bar" } else { "a click" },
            took.as_millis()
        );
    }
    page.picture(&requested.out, "stopped").await
}

/// The tabulator reaches every control; letters select and change.
async fn keyboard(page: &Browser) -> Outcome<()> {
    page.value("document.activeElement.blur(); window.scrollTo(0, 0)").await?;
    let all = "[...document.querySelectorAll('a[href], button, input, select, \
        canvas[tabindex]')].filter((e) => !e.disabled && e.checkVisibility())";
    let count = page
        .number(&format!(
            "window.reached = new Set(); document.addEventListener('focusin', (e) \
        => reached.add(e.target)); return {all}.length"
        ))
        .await?;
    for _ in 0..(count as usize + 10) {
        key(page, TAB).await?;
    }
    let missed = page
        .value(&format!("return {all}.filter((e) => !reached.has(e)).map((e) => e.outerHTML.slice(0, 80))"))
        .await?;
    if missed.as_array().is_some_and(|list| !list.is_empty()) {
        return Err(format!("the tabulator does not reach {missed}"));
    }
    page.value("document.querySelector('#view').focus()").await?;
    let before = page.value("return [sinew.selected, sinew.view.orbit.yaw]").await?;
    key(page, 'm').await?;
    key(page, '2').await?;
    page.until(
        "m selects a muscle, 2 turns the view",
        &format!("sinew.selected !== {} && sinew.view.orbit.yaw !== {}", before[0], before[1]),
    )
    .await?;
    key(page, '?').await?;
    page.until("the list of keys opens", "document.querySelector('#keys').open").await?;
    key(page, '\u{e00c}').await?;
    page.until("Escape closes it", "!document.querySelector('#keys').open").await?;
    println!("keyboard: {count:.0} controls reached");
    Ok(())
}

/// A cut connection is shown within a second, and heals by itself.
async fn lost_and_healed(page: &Browser, server: &Server, requested: &Requested) -> Outcome<()> {
    let began = Instant::now();
    server.silence(true);
    page.until("the loss is shown", "sinew.connection === 'lost'").await?;
    let took = began.elapsed();
    page.picture(&requested.out, "lost").await?;
    server.silence(false);
    let healed = page.until("the connection heals", "sinew.connection === 'open'").await?;
    println!(
        "lost connection: shown after {} ms, healed {} ms after the server was back",
        took.as_millis(),
        healed.as_millis()
    );
    // A request that fails while the server is away is the browser's own message.
    page.console_errors().await?;
    if took > LOST + NOTICE && requested.busy.is_none() {
        Err(format!("the loss was shown after {} ms", took.as_millis()))
    } else {
        Ok(())
    }
}

/// Rules of accessibility, by axe-core, where it is at hand.
pub(crate) async fn accessible(page: &Browser, requested: &Requested, state: &str) -> Outcome<()> {
    let Some(axe) = &requested.axe else {
        println!("accessibility: skipped, axe-core is not here");
        return Ok(());
    };
    let script = std::fs::read_to_string(axe).map_err(|e| format!("{}: {e}", axe.display()))?;
    page.value(&script).await?;
    let found = page
        .later(
            "const done = arguments[0]; axe.run({ runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', \
            'wcag22aa'] }).then((r) =>
           done({ passes: r.passes.length, violations: r.violations.map((v) => `${v.id}: \
           ${v.nodes.slice(0, 3).map((n) => n.html.slice(0, 90) + ' ' + n.any.map((a) => a.message).join(' \
           ')).join(' | ')}`) }), (e) => done({ violations: [String(e)] }))",
        )
        .await?;
    let broken: Vec<String> =
        found["violations"].as_array().into_iter().flatten().map(Value::to_string).collect();
    println!("accessibility, {state}: {} rules kept, {} broken", found["passes"], broken.len());
    if broken.is_empty() { Ok(()) } else { Err(format!("accessibility, {state}: {}", broken.join("\n"))) }
}

/// Text that something hides or that lies beyond the screen, on a page of any of the widths in use.
pub(crate) async fn clipped(page: &Browser, name: &str) -> Outcome<()> {
    for width in [390, 768, 1280, 1920] {
        page.size(width, 900).await?;
        rest(300).await;
        let found = page.value(include_str!("clipped.js")).await?;
        if found.as_array().is_none_or(|list| !list.is_empty()) {
            return Err(format!("{name}, {width} px: text is cut: {found}"));
        }
    }
    println!("{name}: no text is cut from 390 to 1920 px");
    Ok(())
}

/// A phone's width: nothing wider than the screen, the stop in sight and covered by nothing, and the machine
/// is drawn whenever the canvas changes its size.
async fn phone(page: &Browser, requested: &Requested) -> Outcome<()> {
    page.value(
        "window.empty = 0; const { stage } = sinew.view, { renderer } = stage; let bare = false;
         const resize = stage.resize.bind(stage), render = renderer.render.bind(renderer);
         stage.resize = (...a) => { resize(...a); bare = true; };
         renderer.render = (...a) => { render(...a); bare = false; };
         const painted = () => { empty += bare; requestAnimationFrame(() => setTimeout(painted)); }; painted();",
    )
    .await?;
    clipped(page, "page").await?;
    page.size(390, 844).await?;
    settled(page).await?;
    page.picture(&requested.out, "phone").await?;
    let empty = page.number("return empty").await?;
    if empty > 0.0 {
        return Err(format!("the view was empty in {empty} frames while its size changed"));
    }
    let covered = page
        .value(
            "const stop = document.querySelector('#stop'), over = new Set();
         for (let y = 0; y < document.documentElement.scrollHeight; y += 200) {
           scrollTo(0, y);
           const b = stop.getBoundingClientRect();
           for (const x of [0.25, 0.5, 0.75]) {
             const top = document.elementFromPoint(b.left + x * b.width, b.top + b.height / 2);
             if (!stop.contains(top)) over.add(top?.outerHTML.slice(0, 80));
           }
         }
         scrollTo(0, 0);
         return [...over];",
        )
        .await?;
    if covered.as_array().is_none_or(|list| !list.is_empty()) {
        return Err(format!("the stop is covered by {covered}"));
    }
    let narrow = page
        .value(
            "const s = document.querySelector('#stop').getBoundingClientRect();
         return { wide: document.documentElement.scrollWidth, stop: [s.left, s.top, s.right, s.bottom], \
         ready: sinew.ready };",
        )
        .await?;
    let edge = |k: usize| narrow["stop"][k].as_f64().unwrap_or(f64::NAN);
    let inside = edge(0) >= 0.0 && edge(1) >= 0.0 && edge(2) <= 390.0 && edge(3) <= 844.0;
    println!("phone: {} px wide, stop at {}", narrow["wide"], narrow["stop"]);
    if narrow["wide"].as_f64().is_some_and(|wide| wide <= 390.0) && inside && narrow["ready"] == true {
        return Ok(());
    }
    Err(format!("at a phone's width: {narrow}"))
}
