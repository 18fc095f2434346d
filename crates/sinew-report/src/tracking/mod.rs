//! Tracking with a machine: errors and where they come from, path, joints, tensions and lengths, as a section
//! of the reproduction or as a page of its own.

mod marks;
mod plots;
#[cfg(test)]
pub(crate) mod sample;
mod table;
mod view;
mod words;

use super::error::Error;
use super::plot::Plot;
use super::scene::{POINTS, SceneData, SceneFigure, Scenery, Sweep, path, scene_script};
use super::shell::{SHELL, Shell};
use askama::Template;
use plots::{Family, Plotter};
use sinew::muscle::MuscleDynamics;
use sinew_lab::signals::Signal;
use table::Row;
pub use view::{Gear, Injected, TrackView};
pub use words::response;

/// Smallest and largest number of poses of the machine that the view plays.
const POSES: [usize; 2] = [20, 240];

#[derive(Template)]
#[template(path = "tracking.html")]
struct Section {
    heading: String,
    lead: String,
    columns: Vec<&'static str>,
    rows: Vec<Row>,
    sources: Vec<String>,
    scene: Option<SceneFigure>,
    end_point: Vec<Plot>,
    over_repeats: Option<Plot>,
    joints: Family,
    joint_errors: Family,
    tensions: Family,
    drives: Family,
    lengths: Family,
    means: Vec<Plot>,
    errors: Family,
    remarks: Vec<String>,
    incidents: Vec<String>,
    /// Muscle, efficiency, friction.
    gears: Vec<[String; 3]>,
    paper: bool,
}

#[derive(Template)]
#[template(path = "track.html")]
struct Page<'a> {
    shell: Shell,
    scene_script: String,
    title: &'a str,
    amount: &'a str,
    /// What failed and what came of it, a sentence or two for every injected fault.
    answers: Vec<String>,
    verdict: String,
    section: String,
    gears: bool,
    end_point: bool,
    /// Whether the machine or its path is drawn.
    drawn: bool,
}

/// The section, to be put into a page.
pub(crate) fn section(view: &TrackView<'_>) -> Result<String, Error> {
    let plotter = Plotter::new(view);
    let section = Section {
        heading: view.heading.clone(),
        lead: view.lead.clone(),
        columns: table::columns(view, plotter.has_end_point()),
        rows: table::rows(view, plotter.has_end_point()),
        sources: words::sources(view),
        scene: scene(view, plotter.has_end_point())?,
        end_point: if plotter.has_end_point() { plotter.end_point() } else { Vec::new() },
        over_repeats: if plotter.has_end_point() { plotter.over_repeats() } else { None },
        joints: plotter.joints(),
        joint_errors: plotter.joint_errors(),
        tensions: plotter.tensions(),
        drives: plotter.drives(),
        lengths: plotter.lengths(),
        means: plotter.means(),
        errors: plotter.length_errors(),
        remarks: words::remarks(view, plotter.has_end_point()),
        incidents: words::incidents(view),
        gears: view.gears.iter().map(words::gear).collect(),
        paper: view.paper,
    };
    Ok(section.render()?)
}

/// The paths of the end point, and the machine at times of the run.
fn scene(view: &TrackView<'_>, has_end_point: bool) -> Result<Option<SceneFigure>, Error> {
    let mut data = SceneData::default();
    let mut entries = Vec::new();
    if has_end_point {
        let step = view.trace.len().div_ceil(1500).max(1);
        let rows = || view.trace.iter().step_by(step);
        data.paths.push(path("measured", "reference", rows().map(|row| row.end_point_reference_m)));
        data.paths.push(path("predicted", "true", rows().map(|row| row.end_point_m)));
        entries = vec![
            ("measured", "path of the end point, reference"),
            ("predicted", "path of the end point, true"),
        ];
    }
    if let Some(robot) = view.robot {
        let mut scenery = Scenery::new(robot);
        let mut model = MuscleDynamics::new(robot)?;
        data.fixed = Some(scenery.fixed());
        let mut step = 1;
        let mut sweep =
            Sweep { name: "time of the run".into(), unit: "s".into(), at: Vec::new(), frames: Vec::new() };
        if let Some(row) = view.trace.first() {
            model.evaluate(row.frame.of(Signal::JointTrue))?;
            data.poses.push(("start".to_owned(), scenery.pose(model.coordinates())?));
            let points = scenery.points() + 3 * robot.parts().bodies.len();
            step = view.trace.len().div_ceil((POINTS / points.max(1)).clamp(POSES[0], POSES[1])).max(1);
        }
        for row in view.trace.iter().step_by(step) {
            model.evaluate(row.frame.of(Signal::JointTrue))?;
            sweep.frames.push(scenery.pose(model.coordinates())?);
            sweep.at.push(row.time_s);
        }
        data.sweeps.push(sweep);
    }
    if data.fixed.is_none() && data.paths.is_empty() {
        return Ok(None);
    }
    let caption = "The true pose at the chosen time of the run.";
    let caption = if view.robot.is_some() { caption } else { "Paths of the end point." };
    let start = usize::from(view.robot.is_some());
    SceneFigure::new("The machine and the path of its end point", caption, &data, start, &entries).map(Some)
}

/// A page of its own.
///
/// # Errors
/// [`Error`] where the page could not be written, or the trace is not of the machine.
pub fn page(view: &TrackView<'_>, title: &str, amount: &str) -> Result<String, Error> {
    let end_point = Plotter::new(view).has_end_point();
    let page = Page {
        shell: SHELL,
        scene_script: scene_script(),
        title,
        amount,
        answers: words::answers(view.injected, view.tracking.get(&view.drawn)),
        verdict: words::verdict(view.tracking.get(&view.drawn)),
        section: section(view)?,
        gears: !view.gears.is_empty(),
        end_point,
        drawn: end_point || view.robot.is_some(),
    };
    Ok(page.render()?)
}
