//! The reports of the program, as files, from the address bar: no error, accessible, drawn, and no wider than
//! a phone.

use crate::browser::{Browser, rest};
use crate::checks::{accessible, clipped};
use crate::{Outcome, Requested};
use std::path::Path;
use std::process::Command;

/// What is run in turn, and the report that it writes.
const REPORTS: [(&str, &str); 7] = [
    ("twin bench --duration 6 --speeds 0.02,0.05 --out bench.csv", ""),
    ("identify bench.csv --out model --model linear,cell", "model/report.html"),
    ("track planar_leg --path step --no-learning --report track.html", "track.html"),
    ("machine body lm_arm --report arm.html", "arm.html"),
    ("machine tune bench_joint --out gains.json --report tune.html", "tune.html"),
    ("machine map planar_leg --report map.html", "map.html"),
    ("log plot first.mcap --report plot.html", "plot.html"),
];

/// All of them; `folder` holds a recording.
pub(crate) async fn all(page: &Browser, program: &Path, folder: &Path, requested: &Requested) -> Outcome<()> {
    // A page whose run has ended goes on asking for it.
    page.go("about:blank").await?;
    rest(300).await;
    page.console_errors().await?;
    for (arguments, report) in REPORTS {
        let mut command = Command::new(program);
        let ended = command.args(arguments.split(' ')).current_dir(folder).output();
        let ended = ended.map_err(|e| format!("{}: {e}", program.display()))?;
        if !ended.status.success() {
            let words = String::from_utf8_lossy(&ended.stderr).into_owned();
            return Err(format!("`sinew {arguments}` ended with {}: {words}", ended.status));
        }
        if !report.is_empty() {
            let file = folder.join(report);
            let file = std::fs::canonicalize(&file).map_err(|e| format!("{}: {e}", file.display()))?;
            looked_at(page, &file, requested).await?;
        }
    }
    page.size(1400, 900).await?;
    page.go("about:blank").await
}

/// Every plot is saved as SVG and as PDF of the width that the reader chose.
async fn saved(page: &Browser, name: &str) -> Outcome<()> {
    let found = page
        .later(
            "const done = arguments[0], blobs = [], make = URL.createObjectURL;
         URL.createObjectURL = (blob) => { blobs.push(blob); return make(blob); };
         const width = document.querySelector('#figures input');
         width.value = '84'; width.dispatchEvent(new Event('change', { bubbles: true }));
         document.querySelectorAll('[aria-label^=\"Save as\"], #save-svg, #save-pdf').forEach((b) => b.click());
         URL.createObjectURL = make;
         const wrong = (text) => text.startsWith('%PDF') ? !text.includes('/MediaBox [0 0 238.11 ') || \
         Number(/startxref\\n(\\d+)/.exec(text)[1]) !== text.indexOf('xref\\n') || /NaN|undefined|Infinity/.test(text)
         : !text.includes('width=\"84mm\"') || /NaN|undefined|Infinity/.test(text) ||
         new DOMParser().parseFromString(text, 'image/svg+xml').querySelector('parsererror') !== null;
         Promise.all(blobs.map((b) => b.text())).then((texts) => done({ plots: \
         document.querySelectorAll('.plot').length, files: texts.length, wrong: texts.filter(wrong) }));",
        )
        .await?;
    println!("{name}: {} files of {} plots", found["files"], found["plots"]);
    let enough = found["files"].as_u64() >= found["plots"].as_u64().map(|plots| 2 * plots);
    if enough && found["wrong"].as_array().is_some_and(Vec::is_empty) {
        return Ok(());
    }
    Err(format!("{name}: saved figures are wrong: {found}"))
}

async fn looked_at(page: &Browser, file: &Path, requested: &Requested) -> Outcome<()> {
    let name = file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let name = format!("report-{name}");
    let address = format!("file://{}", file.display());
    for theme in ["dark", "light"] {
        page.size(1400, 900).await?;
        page.go(&address).await?;
        page.value(&format!("document.documentElement.dataset.theme = '{theme}'")).await?;
        rest(300).await;
        accessible(page, requested, &format!("{name}, {theme}")).await?;
    }
    page.picture(&requested.out, &name).await?;
    // A view is drawn where it comes into sight.
    page.value("document.querySelectorAll('figure.scene').forEach((figure) => figure.scrollIntoView())")
        .await?;
    page.until(
        "the three-dimensional view is drawn",
        "[...document.querySelectorAll('figure.scene canvas')].every((c) => c.width > 300)",
    )
    .await?;
    let failed = page.number("return document.querySelectorAll('figure.scene .notice').length").await?;
    saved(page, &name).await?;
    clipped(page, &name).await?;
    page.size(390, 844).await?;
    page.go(&address).await?;
    rest(500).await;
    page.picture(&requested.out, &format!("{name}-phone")).await?;
    let narrow = page
        .value(
            "return { wide: document.documentElement.scrollWidth, views: \
        document.querySelectorAll('figure.scene').length }",
        )
        .await?;
    let errors = page.console_errors().await?;
    println!("{name}: {} views, {} px wide on a phone", narrow["views"], narrow["wide"]);
    if !errors.is_empty() || failed > 0.0 || narrow["wide"].as_f64().is_none_or(|wide| wide > 390.0) {
        return Err(format!("{name}: {failed} views failed, {narrow}, {}", errors.join("; ")));
    }
    Ok(())
}
