//! Signals over time in pairs, as a page of their own.

use super::envelope::{self, ENVELOPE};
use super::error::Error;
use super::format::fixed;
use super::plot::{Legend, Plot};
use super::scale::{Axis, padded, settled};
use super::shell::{SHELL, Shell};
use super::svg_path::vertical_lines;
use askama::Template;

/// A page of signals.
#[derive(Debug)]
pub struct SignalPage {
    /// Of the page.
    pub title: String,
    /// Kind of the page, in its head.
    pub kind: &'static str,
    /// Below the title.
    pub amount: String,
    /// The result in a sentence.
    pub verdict: String,
    /// Whether the data are simulated.
    pub simulated: bool,
    /// In their order.
    pub groups: Vec<Group>,
    /// Modes and faults with the times at which they begin, s.
    pub states: Vec<(f64, String)>,
    /// Times at which a fault is first reported, s.
    pub faults: Vec<f64>,
}

/// Signals with the same time and meaning.
#[derive(Debug)]
pub struct Group {
    /// Heading.
    pub heading: String,
    /// Below it.
    pub lead: String,
    /// Names of the two lines of every plot; an empty one for a single line.
    pub legend: [String; 2],
    /// Time of the frame, s.
    pub time: Vec<f64>,
    /// One picture each.
    pub plots: Vec<Signals>,
}

/// Two signals in one picture.
#[derive(Debug)]
pub struct Signals {
    /// Name and unit.
    pub title: String,
    /// As long as the time, or empty.
    pub lines: [Vec<f64>; 2],
}

#[derive(Template)]
#[template(path = "signals.html")]
struct Page<'a> {
    shell: Shell,
    page: &'a SignalPage,
    groups: Vec<Drawn<'a>>,
    /// Time and words.
    states: Vec<[String; 2]>,
}

struct Drawn<'a> {
    id: usize,
    group: &'a Group,
    legend: Legend,
    plots: Vec<Plot>,
}

/// Styles of the two lines of a picture.
const LINES: [&str; 2] = ["measured", "predicted"];
/// Class and name of the marks of faults.
const FAULT: (&str, &str) = ("fault", "fault reported");

/// The page.
///
/// # Errors
/// Those of the template.
pub fn page(page: &SignalPage) -> Result<String, Error> {
    let groups = page.groups.iter().enumerate().map(|(id, group)| {
        let plots: Vec<Plot> = group.plots.iter().map(|signals| plot(group, signals, &page.faults)).collect();
        let names = LINES.into_iter().zip(group.legend.iter().map(String::as_str));
        let mut names: Vec<_> = names.filter(|(_, name)| !name.is_empty()).collect();
        let drawn = [ENVELOPE, FAULT].into_iter();
        names.extend(drawn.filter(|(class, _)| plots.iter().any(|plot| plot.has(class))));
        let legend = Legend::new(&names);
        Drawn { id, group, legend, plots }
    });
    let states = page.states.iter().map(|(from, words)| [fixed(*from, 3), words.clone()]).collect();
    let all = Page { shell: SHELL, page, groups: groups.collect(), states };
    Ok(all.render()?)
}

fn plot(group: &Group, signals: &Signals, faults: &[f64]) -> Plot {
    let ends = (group.time.first().copied().unwrap_or(0.0), group.time.last().copied().unwrap_or(1.0));
    let x = Axis::new(ends, 5);
    let finite = signals.lines.iter().flatten().copied().filter(|x| x.is_finite());
    let range = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    let y = Axis::new(padded(settled(range), 0.05), 3);
    let title = signals.title.clone();
    let mut plot =
        Plot::new("trace low", title.clone(), (&x, "time (s)".to_owned()), (&y, title)).without_legend();
    let within = faults.iter().map(|time| x.at(*time)).filter(|at| (0.0..=1.0).contains(at));
    plot.draw(FAULT.0, FAULT.1, vertical_lines(within));
    let names = LINES.into_iter().zip(group.legend.iter().map(String::as_str));
    for (line, values) in names.zip(&signals.lines) {
        let points = group.time.iter().copied().zip(values.iter().copied()).collect();
        envelope::draw(&mut plot, line, points, (&x, &y));
    }
    plot
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_in_a_legend_stands_beside_its_line_and_states_have_their_times() {
        let group = |legend: [&str; 2]| Group {
            heading: "Joints".into(),
            lead: String::new(),
            legend: legend.map(str::to_owned),
            time: vec![0.0, 1.0],
            plots: vec![Signals { title: "hip (rad)".into(), lines: [vec![0.0, 1.0], vec![0.0, 1.1]] }],
        };
        let groups = vec![group(["reference", "true"]), group(["command", ""])];
        let (title, amount, verdict) = ("a run".into(), String::new(), String::new());
        let states = vec![(0.0, "hold".to_owned()), (4.25, "run; load cell of knee".to_owned())];
        let kind = "recording";
        let html = page(&SignalPage {
            title,
            kind,
            amount,
            verdict,
            simulated: true,
            groups,
            states,
            faults: vec![0.5],
        })
        .unwrap();
        assert!(html.contains(r#"<path class="fault" data-name="fault reported" d="M2000 0v2000"/>"#));
        assert!(html.contains(r#"<th scope="row">4.250</th><td>run; load cell of knee</td>"#));
        let entries = [("measured", "reference"), ("predicted", "true"), ("measured", "command")];
        for (class, name) in entries.into_iter().chain([FAULT]) {
            let entry = format!(r#"<path class="{class}" d="M2 6h30"/></svg>{name}</span>"#);
            assert!(html.contains(&entry), "{name}");
        }
        assert!(!html.contains("</svg></span>"));
    }
}
