//! The page as a whole: size, external resources, escaping and degenerate inputs.

pub(crate) mod fixture;
mod pages;

use super::{picture_svg, render};
use fixture::{many_trials, simulated};
use sinew_identify::report::IdentificationReport;

#[test]
#[ignore = "writes sample reports to target/report for visual inspection"]
fn write_sample_reports() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/report");
    std::fs::create_dir_all(&folder).unwrap();
    let reports = [
        ("logs", simulated(3000)),
        ("trials", many_trials(50, 2000)),
        ("bare", bare()),
        ("hostile", hostile().0),
        ("large", simulated(20_000)),
    ];
    for (name, report) in reports {
        std::fs::write(folder.join(format!("{name}.html")), render(&report).unwrap()).unwrap();
        std::fs::write(folder.join(format!("{name}.svg")), picture_svg(&report).unwrap()).unwrap();
    }
}

/// A report without any data.
fn bare() -> IdentificationReport {
    let mut report = simulated(10);
    report.traces.clear();
    report.logs.clear();
    report.candidates.clear();
    report.influence.clear();
    report.classical.clear();
    report.warnings.clear();
    report.chosen.parameters.clear();
    report.inputs.clear();
    report.folds = 0;
    report.far_range = f64::NAN;
    report.recommendations = [String::new(), String::new()];
    report
}

/// A report in which every text tries to leave its place; and what it tries with.
fn hostile() -> (IdentificationReport, &'static str) {
    let evil =
        "\"'><script>alert(1)</script></title></style><img src=x onerror=alert(1)>{{7*7}}&amp;\u{2028}";
    let mut report = simulated(200);
    let name = || evil.to_owned();
    report.logs.iter_mut().for_each(|l| (l.name, l.findings) = (name(), vec![name()]));
    report.traces.iter_mut().for_each(|t| (t.log, t.trial, t.near_name) = (name(), name(), name()));
    report.influence.iter_mut().for_each(|r| (r.log, r.remark) = (name(), name()));
    report.candidates.iter_mut().for_each(|c| (c.name, c.description) = (name(), name()));
    report.candidates.iter_mut().filter(|c| c.failed.is_some()).for_each(|c| c.failed = Some(name()));
    report.inputs.iter_mut().for_each(|i| i.column = name());
    for p in report.classical.iter_mut().flat_map(|c| &mut c.parameters).chain(&mut report.chosen.parameters)
    {
        (p.name, p.unit, p.remark) = (name(), name(), name());
    }
    report.classical.iter_mut().for_each(|c| (c.law, c.equation, c.remark) = (name(), name(), name()));
    (report.far, report.question, report.version) = (name(), name(), name());
    (report.warnings, report.recommendations) = (vec![name()], [name(), name()]);
    (report.chosen.name, report.chosen.description) = (name(), name());
    (report, evil)
}

/// Elements that have no end tag.
const VOID: [&str; 5] = ["meta", "br", "img", "input", "link"];

/// Every element of a page as (tag, attributes), or what is wrong with it: a tag that is not closed in order,
/// an attribute without quotes, a bare `<`.
pub(crate) fn elements(page: &str) -> Result<Vec<(String, String)>, String> {
    let (mut rest, mut open, mut found) = (page, Vec::<String>::new(), Vec::new());
    while let Some(start) = rest.find('<') {
        rest = &rest[start + 1..];
        if rest.starts_with('!') {
            continue;
        }
        let end = tag_end(rest).ok_or("a tag without end")?;
        let (tag, after) = (&rest[..end], &rest[end + 1..]);
        rest = after;
        if let Some(name) = tag.strip_prefix('/') {
            if open.pop().as_deref() != Some(name) {
                return Err(format!("</{name}> closes nothing"));
            }
            continue;
        }
        let name: String = tag.chars().take_while(char::is_ascii_alphanumeric).collect();
        if name.is_empty() {
            return Err(format!("a bare < before {:?}", tag.chars().take(20).collect::<String>()));
        }
        let attributes = tag[name.len()..].trim_end_matches('/');
        if attributes.matches('"').count() % 2 == 1 {
            return Err(format!("odd quotes in <{tag}>"));
        }
        found.push((name.clone(), attributes.trim().to_owned()));
        if name == "script" || name == "style" {
            let close = format!("</{name}>");
            rest = &rest[rest.find(&close).ok_or("a script without end")? + close.len()..];
        } else if !tag.ends_with('/') && !VOID.contains(&name.as_str()) {
            open.push(name);
        }
    }
    if open.is_empty() { Ok(found) } else { Err(format!("never closed: {open:?}")) }
}

/// The first `>` outside quotes.
fn tag_end(text: &str) -> Option<usize> {
    let mut quoted = false;
    text.bytes().position(|b| {
        quoted ^= b == b'"';
        b == b'>' && !quoted
    })
}

fn data(page: &str) -> serde_json::Value {
    let start = page.find("id=\"data\">").unwrap() + "id=\"data\">".len();
    let end = page[start..].find("</script>").unwrap();
    serde_json::from_str(&page[start..start + end]).unwrap()
}

#[test]
fn a_hundred_thousand_rows_fit_in_a_page_that_can_be_mailed() {
    for report in [simulated(20_000), many_trials(50, 2000)] {
        let rows: usize = report.traces.iter().map(|t| t.time_s.len()).sum();
        assert!(rows >= 100_000, "guard: the report has that many rows");
        let page = render(&report).unwrap();
        assert!(page.len() < 900_000, "{} bytes", page.len());
    }
}

#[test]
fn the_page_loads_nothing_from_anywhere() {
    let page = render(&simulated(300)).unwrap();
    assert!(page.contains("default-src 'none'"));
    for (tag, attributes) in elements(&page).unwrap() {
        assert!(
            !matches!(tag.as_str(), "link" | "img" | "iframe" | "object" | "base"),
            "<{tag} {attributes}>"
        );
        assert!(!attributes.contains("src="), "<{tag} {attributes}>");
        if let Some((_, target)) = attributes.split_once("href=\"") {
            assert!(target.starts_with('#'), "<{tag} {attributes}>");
        }
    }
    for call in ["url(", "@import", "fetch(", "XMLHttpRequest", "import("] {
        assert!(!page.contains(call), "{call}");
    }
}

#[test]
fn every_element_is_closed_in_order_for_any_report() {
    for report in [simulated(300), many_trials(50, 40), bare(), hostile().0] {
        assert_eq!(elements(&render(&report).unwrap()).err(), None);
        assert_eq!(elements(&picture_svg(&report).unwrap()).err(), None);
    }
    assert!(elements("<p><b></p></b>").is_err(), "guard: the check can fail");
    assert!(elements("<p>a < b</p>").is_err(), "guard: the check can fail");
}

#[test]
fn hostile_names_stay_text() {
    let (report, evil) = hostile();
    let page = render(&report).unwrap();
    let picture = picture_svg(&report).unwrap();
    for text in [&page, &picture] {
        assert!(!text.contains("<script>alert"), "a name became a script");
        assert!(!text.contains("<img"), "a name became an element");
        for (tag, attributes) in elements(text).unwrap() {
            let unquoted = attributes.split('"').step_by(2).collect::<String>();
            assert!(!unquoted.contains("onerror"), "a name became an attribute of <{tag} {attributes}>");
        }
    }
    assert!(page.contains("{{7*7}}"), "a template's marks in a name are text");
    let label = data(&page)["records"][0]["label"].as_str().unwrap().to_owned();
    assert!(label.contains(evil), "the script sees the name as it is: {label}");
}

#[test]
fn the_same_report_gives_the_same_bytes() {
    assert_eq!(render(&simulated(500)).unwrap(), render(&simulated(500)).unwrap());
    assert_eq!(picture_svg(&simulated(500)).unwrap(), picture_svg(&simulated(500)).unwrap());
}

#[test]
fn no_numbers_no_folds_no_traces_still_make_a_page() {
    let mut reports = vec![bare()];
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, 1e308, -1e308, 1e-320] {
        let mut report = simulated(60);
        report.far_range = bad;
        for t in &mut report.traces {
            for column in [&mut t.near, &mut t.far, &mut t.predicted, &mut t.half_width, &mut t.near_rate] {
                column.iter_mut().step_by(2).for_each(|v| *v = bad);
            }
            t.gate.iter_mut().chain(&mut t.since_reversal_s).for_each(|v| *v = bad);
        }
        report.traces[0].time_s.fill(bad);
        for c in &mut report.candidates {
            (c.score, c.rmse, c.percent_of_range) = (bad, bad, bad);
            (c.pearson, c.coverage95, c.rmse_in_sample) = (bad, bad, bad);
            c.fold_rmse.fill(bad);
        }
        report.influence.iter_mut().for_each(|r| r.influence = bad);
        report.logs.iter_mut().for_each(|l| (l.duration_s, l.interval_s) = (bad, bad));
        for c in &mut report.classical {
            (c.rmse, c.condition) = (bad, bad);
            c.parameters.iter_mut().for_each(|p| (p.value, p.low, p.high) = (bad, bad, -bad));
        }
        report.chosen.band_factor = bad;
        reports.push(report);
    }
    for report in reports {
        let page = render(&report).unwrap();
        assert_eq!(elements(&page).err(), None);
        for word in [">NaN", "NaN<", ">inf", "inf<", "NaN%", "inf%", "NaN ", "M NaN"] {
            assert!(!page.replace("isNaN", "").split("<script").next().unwrap().contains(word), "{word}");
        }
        picture_svg(&report).unwrap();
    }
}

#[test]
fn vectors_of_different_lengths_are_truncated() {
    let mut report = simulated(200);
    report.traces[0].far.truncate(50);
    report.traces[1].near.clear();
    report.traces[2].scored.clear();
    report.traces[3].time_s.clear();
    report.traces[4].predicted.truncate(1);
    let page = render(&report).unwrap();
    assert_eq!(elements(&page).err(), None);
}

#[test]
fn one_log_and_one_model_are_enough() {
    let mut report = simulated(300);
    report.traces.truncate(1);
    report.logs.truncate(1);
    report.candidates.truncate(1);
    report.influence.clear();
    let page = render(&report).unwrap();
    assert!(page.contains("at least four logs are required"));
    assert_eq!(data(&page)["records"].as_array().unwrap().len(), 1);
}

#[test]
fn the_selected_model_is_marked_once_and_a_failed_one_with_its_reason() {
    let mut report = simulated(100);
    report.candidates.reverse();
    let page = render(&report).unwrap();
    assert_eq!(page.matches("<span class=\"tag\">selected</span>").count(), 1);
    assert!(page.contains("could not be fitted: stiffness left its bounds in 3 of 5 folds"));
    let place = |name: &str| page.find(&format!("<span class=\"name\">{name}</span>")).unwrap();
    assert!(
        place("clamp+net") < place("clamp") && place("linear") < place("lugre"),
        "best first, failed last"
    );
}

#[test]
fn a_band_with_low_coverage_is_called_unreliable_in_the_first_sentence() {
    let mut report = simulated(100);
    report.candidates.iter_mut().for_each(|c| c.coverage95 = 0.61);
    assert!(render(&report).unwrap().contains("the band is not reliable"));
    assert!(!render(&simulated(100)).unwrap().contains("the band is not reliable"));
}

#[test]
fn simulated_data_are_labelled_and_measured_data_are_not() {
    let badge = "<span class=\"tag warn\">simulated data</span>";
    let mut report = simulated(100);
    assert!(render(&report).unwrap().contains(badge));
    assert!(picture_svg(&report).unwrap().contains("simulated data"));
    report.logs.iter_mut().for_each(|l| l.name = "bench.csv".to_owned());
    assert!(!render(&report).unwrap().contains(badge));
    report.logs[0].findings = vec!["Simulated with capstan play".to_owned()];
    assert!(render(&report).unwrap().contains(badge));
}

#[test]
fn a_gap_breaks_the_line_and_the_parts_of_a_log_are_one_record() {
    let report = simulated(400);
    let page = render(&report).unwrap();
    assert_eq!(report.traces.len(), 6, "guard: one log has two sequences");
    assert_eq!(data(&page)["records"].as_array().unwrap().len(), 5);
    let thumb = page.split("class=\"thumb\"").nth(2).unwrap();
    let line = thumb.split("class=\"measured\" d=\"").nth(1).unwrap().split('"').next().unwrap();
    assert_eq!(line.matches('M').count(), 2, "{line}");
}
