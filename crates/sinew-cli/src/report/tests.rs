//! The page as a whole: what it may weigh, load, show and survive.

use super::fixture::{many_trials, simulated};
use super::{picture_svg, render};
use sinew_identify::report::IdentificationReport;

#[test]
#[ignore = "writes pictures for a person to look at"]
fn write_the_reports_to_look_at() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/report");
    std::fs::create_dir_all(&folder).unwrap();
    let accounts = [
        ("logs", simulated(3000)),
        ("trials", many_trials(50, 2000)),
        ("bare", bare()),
        ("hostile", hostile().0),
        ("large", simulated(20_000)),
    ];
    for (name, account) in accounts {
        std::fs::write(folder.join(format!("{name}.html")), render(&account).unwrap()).unwrap();
        std::fs::write(folder.join(format!("{name}.svg")), picture_svg(&account).unwrap()).unwrap();
    }
}

/// An account of nothing at all.
fn bare() -> IdentificationReport {
    let mut account = simulated(10);
    account.traces.clear();
    account.logs.clear();
    account.candidates.clear();
    account.influence.clear();
    account.classical.clear();
    account.warnings.clear();
    account.chosen.parameters.clear();
    account.inputs.clear();
    account.folds = 0;
    account.far_range = f64::NAN;
    account.recommendations = [String::new(), String::new()];
    account
}

/// An account in which every text tries to leave its place; and what it tries with.
fn hostile() -> (IdentificationReport, &'static str) {
    let evil =
        "\"'><script>alert(1)</script></title></style><img src=x onerror=alert(1)>{{7*7}}&amp;\u{2028}";
    let mut account = simulated(200);
    let name = || evil.to_owned();
    account.logs.iter_mut().for_each(|l| (l.name, l.findings) = (name(), vec![name()]));
    account.traces.iter_mut().for_each(|t| (t.log, t.trial, t.near_name) = (name(), name(), name()));
    account.influence.iter_mut().for_each(|r| (r.log, r.remark) = (name(), name()));
    account.candidates.iter_mut().for_each(|c| (c.name, c.description) = (name(), name()));
    account.candidates.iter_mut().filter(|c| c.failed.is_some()).for_each(|c| c.failed = Some(name()));
    account.inputs.iter_mut().for_each(|i| i.column = name());
    for p in
        account.classical.iter_mut().flat_map(|c| &mut c.parameters).chain(&mut account.chosen.parameters)
    {
        (p.name, p.unit, p.remark) = (name(), name(), name());
    }
    account.classical.iter_mut().for_each(|c| (c.law, c.equation, c.remark) = (name(), name(), name()));
    (account.far, account.question, account.version) = (name(), name(), name());
    (account.warnings, account.recommendations) = (vec![name()], [name(), name()]);
    (account.chosen.name, account.chosen.description) = (name(), name());
    (account, evil)
}

/// Elements that have no end tag.
const VOID: [&str; 4] = ["meta", "br", "img", "link"];

/// Every element of a page as (tag, attributes), or what is wrong with it: a tag that is not closed in order, an
/// attribute without quotes, a bare `<`.
fn elements(page: &str) -> Result<Vec<(String, String)>, String> {
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
    for account in [simulated(20_000), many_trials(50, 2000)] {
        let rows: usize = account.traces.iter().map(|t| t.time_s.len()).sum();
        assert!(rows >= 100_000, "guard: the account is as large as the test says");
        let page = render(&account).unwrap();
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
fn every_element_is_closed_in_order_whatever_the_account() {
    for account in [simulated(300), many_trials(50, 40), bare(), hostile().0] {
        assert_eq!(elements(&render(&account).unwrap()).err(), None);
        assert_eq!(elements(&picture_svg(&account).unwrap()).err(), None);
    }
    assert!(elements("<p><b></p></b>").is_err(), "guard: the check can fail");
    assert!(elements("<p>a < b</p>").is_err(), "guard: the check can fail");
}

#[test]
fn hostile_names_stay_text() {
    let (account, evil) = hostile();
    let page = render(&account).unwrap();
    let picture = picture_svg(&account).unwrap();
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
fn the_same_account_gives_the_same_bytes() {
    assert_eq!(render(&simulated(500)).unwrap(), render(&simulated(500)).unwrap());
    assert_eq!(picture_svg(&simulated(500)).unwrap(), picture_svg(&simulated(500)).unwrap());
}

#[test]
fn no_numbers_no_folds_no_traces_still_make_a_page() {
    let mut accounts = vec![bare()];
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, 1e308, -1e308, 1e-320] {
        let mut account = simulated(60);
        account.far_range = bad;
        for t in &mut account.traces {
            for column in [&mut t.near, &mut t.far, &mut t.predicted, &mut t.half_width, &mut t.near_rate] {
                column.iter_mut().step_by(2).for_each(|v| *v = bad);
            }
            t.gate.iter_mut().chain(&mut t.since_reversal_s).for_each(|v| *v = bad);
        }
        account.traces[0].time_s.fill(bad);
        for c in &mut account.candidates {
            (c.rmse, c.percent_of_range, c.pearson, c.coverage95, c.rmse_in_sample) =
                (bad, bad, bad, bad, bad);
            c.fold_rmse.fill(bad);
        }
        account.influence.iter_mut().for_each(|r| r.influence = bad);
        account.logs.iter_mut().for_each(|l| (l.duration_s, l.interval_s) = (bad, bad));
        for c in &mut account.classical {
            (c.rmse, c.condition) = (bad, bad);
            c.parameters.iter_mut().for_each(|p| (p.value, p.low, p.high) = (bad, bad, -bad));
        }
        account.chosen.band_factor = bad;
        accounts.push(account);
    }
    for account in accounts {
        let page = render(&account).unwrap();
        assert_eq!(elements(&page).err(), None);
        for word in [">NaN", "NaN<", ">inf", "inf<", "NaN%", "inf%", "NaN ", "M NaN"] {
            assert!(!page.replace("isNaN", "").split("<script").next().unwrap().contains(word), "{word}");
        }
        picture_svg(&account).unwrap();
    }
}

#[test]
fn vectors_of_different_lengths_are_cut_not_trusted() {
    let mut account = simulated(200);
    account.traces[0].far.truncate(50);
    account.traces[1].near.clear();
    account.traces[2].scored.clear();
    account.traces[3].time_s.clear();
    account.traces[4].predicted.truncate(1);
    let page = render(&account).unwrap();
    assert_eq!(elements(&page).err(), None);
}

#[test]
fn one_log_and_one_model_are_enough() {
    let mut account = simulated(300);
    account.traces.truncate(1);
    account.logs.truncate(1);
    account.candidates.truncate(1);
    account.influence.clear();
    let page = render(&account).unwrap();
    assert!(page.contains("it needs at least four logs"));
    assert_eq!(data(&page)["records"].as_array().unwrap().len(), 1);
}

#[test]
fn the_chosen_model_is_marked_once_and_a_failed_one_says_why() {
    let mut account = simulated(100);
    account.candidates.reverse();
    let page = render(&account).unwrap();
    assert_eq!(page.matches("<span class=\"tag\">chosen</span>").count(), 1);
    assert!(page.contains("could not be fitted: stiffness left its bounds in 3 of 5 folds"));
    let place = |name: &str| page.find(&format!("<span class=\"name\">{name}</span>")).unwrap();
    assert!(
        place("clamp+net") < place("clamp") && place("linear") < place("lugre"),
        "best first, failed last"
    );
}

#[test]
fn a_band_that_fails_is_called_untrustworthy_in_the_first_sentence() {
    let mut account = simulated(100);
    account.candidates.iter_mut().for_each(|c| c.coverage95 = 0.61);
    assert!(render(&account).unwrap().contains("do not rely on the band"));
    assert!(!render(&simulated(100)).unwrap().contains("do not rely on the band"));
}

#[test]
fn simulated_data_are_labelled_and_measured_data_are_not() {
    let badge = "<span class=\"tag warn\">simulated data</span>";
    let mut account = simulated(100);
    assert!(render(&account).unwrap().contains(badge));
    assert!(picture_svg(&account).unwrap().contains("simulated data"));
    account.logs.iter_mut().for_each(|l| l.name = "bench.csv".to_owned());
    assert!(!render(&account).unwrap().contains(badge));
    account.logs[0].findings = vec!["Simulated with capstan play".to_owned()];
    assert!(render(&account).unwrap().contains(badge));
}

#[test]
fn a_gap_breaks_the_line_and_the_parts_of_a_log_are_one_record() {
    let account = simulated(400);
    let page = render(&account).unwrap();
    assert_eq!(account.traces.len(), 6, "guard: one log has two sequences");
    assert_eq!(data(&page)["records"].as_array().unwrap().len(), 5);
    let thumb = page.split("class=\"thumb\"").nth(2).unwrap();
    let line = thumb.split("class=\"measured\" d=\"").nth(1).unwrap().split('"').next().unwrap();
    assert_eq!(line.matches('M').count(), 2, "{line}");
}
