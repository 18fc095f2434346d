//! Structure of every page: one design, names of what can be focused, at least two labels per axis, no
//! request.

use super::elements;
use super::fixture::simulated;
use crate::robot::{ArmCurves, ArmJump, MuscleRow, RobotView};
use crate::scene::{SceneData, Scenery};
use crate::tracking::{Gear, TrackView, sample::row};
use sinew::body::Robot;
use sinew_identify::gear::{GearFit, Interval};
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{
    ErrorSpread, JointShare, LargestError, MuscleSpread, TraceRow, TrackIncident, TrackOutcome,
    TrackingNumbers,
};
use std::collections::BTreeMap;

fn robot(text: &str) -> Robot {
    sinew::description::robot_from_toml("m", text, &mut |_| Err(String::new())).unwrap().0
}

fn leg() -> Robot {
    robot(sinew_models::PLANAR_LEG)
}

/// A page of a robot with one moment arm that jumps.
fn robot_page(name: &str) -> String {
    let leg = leg();
    let mut scenery = Scenery::new(&leg);
    let pose = scenery.pose(&leg.reference_pose()).unwrap();
    let scene = SceneData {
        fixed: Some(scenery.fixed()),
        poses: vec![("reference".to_owned(), pose)],
        ..SceneData::default()
    };
    let at: Vec<f64> = (0..61).map(|k| -0.5 + 0.02 * f64::from(k)).collect();
    let arms = at.iter().map(|q| if *q < 0.31 { 0.03 } else { 0.04 + 0.01 * q }).collect();
    let view = RobotView {
        name: name.to_owned(),
        mass_kg: [1.7, 1.7],
        bodies: 3,
        joints: 2,
        muscles: vec![MuscleRow {
            name: name.to_owned(),
            length_m: 0.3,
            travel_m: 0.05,
            strongest: "knee".to_owned(),
            arm_m: [0.03, 0.045],
            wrap_rad: [0.0, 1.2],
        }],
        poses: 512,
        curves: vec![ArmCurves {
            joint: "knee".to_owned(),
            slides: false,
            at,
            arms: vec![(0, arms)],
            jumps: vec![ArmJump { muscle: 0, at: 0.305, arm: [0.03, 0.0431] }],
        }],
        scene,
        start: 0,
    };
    crate::robot::page(&view).unwrap()
}

fn numbers(end_point: bool) -> TrackingNumbers {
    let spread = ErrorSpread { mean: 1e-3, std: 2e-4, max: 3e-3 };
    let fraction = JointShare {
        joint: "knee".to_owned(),
        error_rad: Some(4e-3),
        error_m: None,
        end_point_m: end_point.then_some(2.5e-3),
        since_reversal_s: Some(0.12),
    };
    TrackingNumbers {
        ended: TrackOutcome::Completed,
        reason: None,
        joints: vec![],
        joint_error_rad: None,
        joint_error_m: None,
        closure_error_m: None,
        off_manifold_rad: None,
        end_point_error_m: spread,
        unseen_error_m: spread,
        end_point_error_per_repeat_m: vec![spread],
        hold: None,
        muscle_length_error_m: MuscleSpread { mean: 1e-4, std: 1e-5 },
        per_muscle: vec![1e-4],
        per_muscle_std: vec![4e-5],
        tension_limits_n: vec![[15.0, 300.0]],
        end_point_limit_m: end_point.then_some(0.02),
        largest_errors: vec![LargestError {
            time_s: 7.5,
            end_point_error_m: end_point.then_some(3e-3),
            unseen_error_m: end_point.then_some(4e-4),
            joints: vec![fraction],
            feasible: true,
        }],
        min_anchor_tension_n: 15.0,
        longest_slack_s: 0.0,
        max_drive_tension_n: 41.0,
        stopped_s: None,
        stopped_by: None,
        modes: Vec::new(),
        health: Vec::new(),
        incidents: vec![TrackIncident {
            from_s: 4.0,
            until_s: 4.01,
            kind: "sensor_lost".to_owned(),
            what: "joint encoder of knee".to_owned(),
            answer: "bridged".to_owned(),
        }],
    }
}

fn gear(muscle: &str) -> Gear {
    let [efficiency, friction] =
        [0.7, 4e-3].map(|value| Interval { value, low: 0.9 * value, high: 1.1 * value });
    Gear { muscle: muscle.to_owned(), losses: GearFit { efficiency, friction } }
}

/// A page of a run, with an end point or of joints alone.
fn track_page(end_point: bool, name: &str) -> String {
    let wave = |t: f64| 0.3 * (1.3 * t).sin();
    let mut trace: Vec<TraceRow> = (0..900).map(|k| row(0.01 * f64::from(k), wave)).collect();
    if !end_point {
        trace
            .iter_mut()
            .for_each(|row| (row.end_point_reference_m, row.end_point_m) = ([f64::NAN; 3], [f64::NAN; 3]));
    }
    let view = TrackView {
        heading: "Errors".to_owned(),
        lead: String::new(),
        tracking: &BTreeMap::from([(CompensationVariant::Observer, numbers(end_point))]),
        trace: &trace,
        drawn: CompensationVariant::Observer,
        names: &[name.to_owned()],
        joints: &["knee".to_owned()],
        joint_units: &["rad".to_owned()],
        gears: &[gear(name)],
        injected: &[],
        repeats: 1,
        paper: end_point,
        robot: None,
    };
    crate::tracking::page(&view, "a run", "simulated").unwrap()
}

fn pages() -> Vec<(&'static str, String)> {
    vec![
        ("identification", crate::render(&simulated(400)).unwrap()),
        ("robot", robot_page("leg")),
        ("track", track_page(true, "hamstrings")),
        ("track of joints", track_page(false, "hamstrings")),
    ]
}

/// The value of an attribute.
fn attribute<'a>(attributes: &'a str, name: &str) -> Option<&'a str> {
    let start = attributes.find(&format!("{name}=\""))? + name.len() + 2;
    attributes[start..].split('"').next()
}

#[test]
fn every_page_has_the_bar_the_theme_the_contents_and_the_print_style() {
    for (name, page) in pages() {
        let found = elements(&page).unwrap();
        let has = |tag: &str, part: &str| found.iter().any(|(t, a)| t == tag && a.contains(part));
        assert!(has("header", "class=\"bar\"") && has("button", "id=\"theme\""), "{name}");
        assert!(has("nav", "aria-label=\"Contents\"") && has("main", "id=\"main\""), "{name}");
        assert!(has("html", "lang=\"en\"") && page.contains("@media print"), "{name}");
        let ids: Vec<&str> =
            found.iter().filter_map(|(_, a)| attribute(a, " id").or(attribute(a, "id"))).collect();
        let links = found.iter().filter(|(tag, _)| tag == "a").filter_map(|(_, a)| attribute(a, "href"));
        for link in links {
            assert!(ids.contains(&link.trim_start_matches('#')), "{name}: {link} leads nowhere");
        }
        let mut once = ids.clone();
        once.sort_unstable();
        once.dedup();
        assert_eq!(once.len(), ids.len(), "{name}: an id stands twice");
    }
}

#[test]
fn every_axis_has_two_labels_and_every_plot_a_name() {
    for (name, page) in pages() {
        let plots: Vec<&str> = page.split("<div class=\"plot ").skip(1).collect();
        assert!(!plots.is_empty(), "{name}");
        for plot in plots {
            let part = |from: &str, to: &str| plot.split(from).nth(1).unwrap().split(to).next().unwrap();
            assert!(!part("aria-label=\"", "\"").is_empty());
            for axis in ["y-ticks", "x-ticks"] {
                let labels = part(&format!("<div class=\"{axis}\">"), "</div>").matches("<span").count();
                assert!(labels > 1 || plot.starts_with("trace named"), "{name}: {axis} has {labels} labels");
            }
        }
    }
}

#[test]
fn the_errors_of_a_run_without_an_end_point_are_those_of_its_joints() {
    let [with, without] = [true, false].map(|end_point| track_page(end_point, "hamstrings"));
    assert!(with.contains("end point: mean, mm") && !with.contains("joints: mean, mrad"));
    assert!(without.contains("joints: mean, mrad") && !without.contains("end point: mean, mm"));
    assert!(with.contains("zero offsets alone") && !without.contains("zero offsets alone"));
}

#[test]
fn every_line_of_a_plot_is_named_or_a_grid() {
    for (name, page) in pages() {
        for plot in page.split("<div class=\"area\">").skip(1) {
            let svg = plot.split("</svg>").next().unwrap();
            for path in svg.split("<path ").skip(1) {
                let class = attribute(path, "class").unwrap();
                let plain = ["grid", "zero", "dots", "beyond"].contains(&class);
                assert!(plain || path.contains("data-name=\""), "{name}: {class}");
            }
        }
    }
}

#[test]
fn every_table_can_scroll_and_every_view_is_reached_by_the_keyboard() {
    for (name, page) in pages() {
        let tables = page.matches("<table").count();
        assert_eq!(page.matches("<div class=\"table\" role=\"group\"").count(), tables, "{name}");
        for (_, attributes) in elements(&page).unwrap().iter().filter(|(tag, _)| tag == "canvas") {
            assert!(attributes.contains("tabindex=\"0\"") && attributes.contains("aria-label="), "{name}");
        }
        assert!(
            !page.contains("addEventListener(\"wheel\", (e) => { e.preventDefault"),
            "{name}: the wheel scrolls"
        );
    }
}

#[test]
fn names_of_a_robot_and_a_run_stay_text() {
    let evil = "\"'><script>alert(1)</script><img src=x onerror=alert(1)>";
    for page in [robot_page(evil), track_page(true, evil)] {
        assert!(!page.contains("<script>alert") && !page.contains("<img"));
        assert_eq!(elements(&page).err(), None);
    }
}

#[test]
fn pages_of_robots_and_runs_ask_for_nothing_and_are_the_same_each_time() {
    for (name, page) in pages() {
        assert!(page.contains("default-src 'none'"), "{name}");
        for call in ["url(", "@import", "fetch(", "XMLHttpRequest", "import("] {
            assert!(!page.contains(call), "{name}: {call}");
        }
        assert!(page.len() < 3_000_000, "{name}: {} bytes", page.len());
    }
    assert_eq!(pages(), pages());
}

#[test]
fn a_run_names_what_its_largest_errors_consist_of() {
    // Numbers and their units stay on one line.
    let page = track_page(true, "hamstrings").replace('\u{a0}', " ");
    for words in [
        "3.00 mm at 7.50 s: knee is off by 4.00 mrad, which alone makes 2.50 mm along the error, 0.12 s \
            after it reversed.",
        "zero offsets of the encoders account for 0.40 mm",
        "hardware",
        "difference",
    ] {
        assert!(page.contains(words), "{words}");
    }
    let joints = track_page(false, "hamstrings").replace('\u{a0}', " ");
    assert!(joints.contains("At 7.50 s: knee is off by 4.00 mrad, 0.12 s after it reversed."));
    assert!(!joints.contains("id=\"figure11\"") && !joints.contains("NaN\"") && !joints.contains(">NaN"));
}

#[test]
fn a_jump_of_a_moment_arm_is_marked_and_interrupts_its_curve() {
    let page = robot_page("leg");
    assert!(page.contains("class=\"dots jump\" data-name=\"jump\""));
    assert!(page.contains("leg: from 30.0 to 43.1\u{202f}mm at knee = 0.3050\u{202f}rad"));
    let curve =
        page.split("class=\"m0 d0\" data-name=\"leg\" d=\"").nth(1).unwrap().split('"').next().unwrap();
    assert_eq!(curve.matches('M').count(), 2, "{curve}");
}

#[test]
fn spikes_that_are_not_scored_do_not_set_the_scale() {
    let ends = |page: &str| {
        let ends = page.split("data-ends=\"").nth(1).unwrap().split('"').next().unwrap().to_owned();
        ends.split(' ').map(|x| x.parse::<f64>().unwrap()).collect::<Vec<f64>>()
    };
    let (clean, mut spiked) = (simulated(400), simulated(400));
    for trace in &mut spiked.traces {
        let unscored: Vec<usize> = (0..trace.scored.len()).filter(|i| !trace.scored[*i]).collect();
        assert!(!unscored.is_empty(), "guard");
        unscored.into_iter().for_each(|i| (trace.far[i], trace.near[i]) = (500.0, -900.0));
    }
    let (clean, spiked) = (crate::render(&clean).unwrap(), crate::render(&spiked).unwrap());
    for (a, b) in ends(&clean).into_iter().zip(ends(&spiked)) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
}

#[test]
fn every_input_is_drawn() {
    let page = crate::render(&simulated(400)).unwrap();
    let data = page.split("id=\"data\">").nth(1).unwrap().split("</script>").next().unwrap();
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    assert_eq!(data["inputs"].as_array().unwrap().len(), 2);
    assert!(data["records"][0]["inputs"][1].as_str().unwrap().len() > 100);
    assert!(page.contains("aria-label=\"stroke (mm) over time\""), "also without the script");
}
