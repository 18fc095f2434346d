//! One cable as a picture: tensions of both ends over time, tension and slip along the cable, and hysteresis
//! loops.

use super::colours::Colours;
use super::scale::Axis;
use std::fmt::Write;

/// The cable at one time.
pub struct Frame {
    /// Time since the start, s.
    pub time: f64,
    /// Of the winch, m.
    pub motor: f64,
    /// Tension at the drive, N.
    pub tension_in: f64,
    /// Tension at the anchor, N.
    pub tension_out: f64,
    /// Along the cable, N, drive end first.
    pub profile: Vec<f64>,
    /// Of every node in the last substep, m.
    pub slips: Vec<f64>,
}

/// Left, top, width and height of a panel.
struct Panel([f64; 4]);

const CURVES: Panel = Panel([70.0, 96.0, 720.0, 240.0]);
const PROFILE: Panel = Panel([70.0, 410.0, 720.0, 250.0]);
const LOOP: Panel = Panel([890.0, 96.0, 270.0, 240.0]);
const TRAVEL: Panel = Panel([890.0, 410.0, 270.0, 250.0]);
/// Shades of the tension.
const SHADES: usize = 12;
/// Minimum slip of a sliding node, m per substep of 0.25 ms: 0.1 mm/s.
const MIN_SLIP: f64 = 2.5e-8;

/// The picture as SVG.
pub fn draw(frames: &[Frame], title: &str, colours: &Colours) -> String {
    let range = |of: fn(&Frame) -> f64| {
        frames.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
    };
    let most = |of: fn(&Frame) -> f64| (0.0, 1.03 * range(of).1.max(1.0));
    let time = Axis::new((0.0, frames.last().map_or(1.0, |frame| frame.time)), 6);
    let (near, far) = (Axis::new(most(|f| f.tension_in), 4), Axis::new(most(|f| f.tension_out), 4));
    let tension = Axis::new(most(|f| f.tension_in.max(f.tension_out)), 4);
    let travel = Axis::new(range(|f| 1e3 * f.motor), 4);
    let mut svg = Svg { text: head(title, colours), colours };
    svg.axes(&CURVES, None, (&tension, "tension (N)"));
    svg.curve(&CURVES, frames, (&time, |f| f.time), (&tension, |f| f.tension_in), colours.near);
    svg.curve(&CURVES, frames, (&time, |f| f.time), (&tension, |f| f.tension_out), colours.far);
    svg.axes(&LOOP, Some((&near, "near tension (N)")), (&far, "far tension (N)"));
    svg.curve(&LOOP, frames, (&near, |f| f.tension_in), (&far, |f| f.tension_out), colours.far);
    svg.axes(&TRAVEL, Some((&travel, "winch travel (mm)")), (&tension, "tension (N)"));
    svg.curve(&TRAVEL, frames, (&travel, |f| 1e3 * f.motor), (&tension, |f| f.tension_in), colours.near);
    svg.curve(&TRAVEL, frames, (&travel, |f| 1e3 * f.motor), (&tension, |f| f.tension_out), colours.far);
    svg.profile(frames, &time);
    svg.text.push_str("</svg>\n");
    svg.text
}

/// Frame, title and legend.
fn head(title: &str, c: &Colours) -> String {
    let Colours { card, line, ink, soft, near, far, toward, away, .. } = c;
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 1200 740\" role=\"img\" \
            aria-label=\"Tensions of a simulated cable\" font-family=\"system-ui, sans-serif\" \
            font-size=\"14\"><rect x=\"0.5\" y=\"0.5\" width=\"1199\" height=\"739\" rx=\"12\" \
            fill=\"{card}\" stroke=\"{line}\" stroke-opacity=\"0.5\"/><text x=\"28\" y=\"40\" \
            font-size=\"18\" font-weight=\"600\" fill=\"{ink}\">{title}</text><rect x=\"1064\" y=\"22\" \
            width=\"112\" height=\"22\" rx=\"11\" fill=\"none\" stroke=\"{toward}\"/><text x=\"1120\" \
            y=\"37.5\" font-size=\"13\" text-anchor=\"middle\" fill=\"{toward}\">simulated data</text><g \
            fill=\"{soft}\"><path d=\"M360 35h26\" stroke=\"{near}\" stroke-width=\"3\"/><text x=\"393\" \
            y=\"40\">near tension</text><path d=\"M500 35h26\" stroke=\"{far}\" stroke-width=\"3\"/><text \
            x=\"533\" y=\"40\">far tension</text><rect x=\"635\" y=\"29\" width=\"26\" height=\"12\" \
            fill=\"{toward}\"/><text x=\"668\" y=\"40\">slides toward the motor</text><rect x=\"855\" \
            y=\"29\" width=\"26\" height=\"12\" fill=\"{away}\"/><text x=\"888\" y=\"40\">slides \
            away</text></g>"
    )
}

/// A picture being drawn; writing into a string cannot fail.
struct Svg<'a> {
    text: String,
    colours: &'a Colours,
}

impl Svg<'_> {
    fn axes(
        &mut self,
        Panel([left, top, width, height]): &Panel,
        x: Option<(&Axis, &str)>,
        y: (&Axis, &str),
    ) {
        let (soft, line) = (self.colours.soft, self.colours.line);
        let _ = write!(
            self.text,
            "<path d=\"M{left} {top}v{height}h{width}\" fill=\"none\" stroke=\"{line}\"/><g \
                fill=\"{soft}\"><text x=\"{:.0}\" y=\"{:.0}\">{}</text>",
            left - 42.0,
            top - 14.0,
            y.1
        );
        for (value, label) in y.0.ticks() {
            let (x, y) = (left - 8.0, top + (1.0 - y.0.at(value)) * height);
            let _ = write!(
                self.text,
                "<text x=\"{x}\" y=\"{y:.1}\" dy=\"4.5\" text-anchor=\"end\">{label}</text>"
            );
        }
        if let Some((axis, label)) = x {
            self.across(axis, label, [*left, top + height, *width]);
        }
        self.text.push_str("</g>");
    }

    fn across(&mut self, axis: &Axis, label: &str, [left, bottom, width]: [f64; 3]) {
        for (value, label) in axis.ticks() {
            let (x, y) = (left + axis.at(value) * width, bottom + 20.0);
            let _ = write!(self.text, "<text x=\"{x:.1}\" y=\"{y}\" text-anchor=\"middle\">{label}</text>");
        }
        let (x, y) = (left + width, bottom + 40.0);
        let _ = write!(self.text, "<text x=\"{x}\" y=\"{y}\" text-anchor=\"end\">{label}</text>");
    }

    fn curve(
        &mut self,
        Panel([left, top, width, height]): &Panel,
        frames: &[Frame],
        x: (&Axis, fn(&Frame) -> f64),
        y: (&Axis, fn(&Frame) -> f64),
        colour: &str,
    ) {
        let mut data = String::new();
        for frame in frames {
            let x = left + x.0.at((x.1)(frame)) * width;
            let y = top + (1.0 - y.0.at((y.1)(frame))) * height;
            let _ = write!(data, "{}{x:.1} {y:.1}", if data.is_empty() { 'M' } else { 'L' });
        }
        let _ = write!(
            self.text,
            "<path d=\"{data}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2.2\" \
                stroke-linejoin=\"round\"/>"
        );
    }

    /// Tension as shades with marks on the sliding nodes, whose edge is the slip front.
    fn profile(&mut self, frames: &[Frame], time: &Axis) {
        let Panel([left, top, width, height]) = PROFILE;
        let most = frames.iter().flat_map(|f| f.profile.iter().copied()).fold(1.0, f64::max);
        let mut shades = vec![String::new(); SHADES];
        let mut marks = [String::new(), String::new()];
        #[expect(clippy::cast_precision_loss, reason = "a few dozen cells")]
        let cell = height / frames.first().map_or(1, |frame| frame.profile.len().max(1)) as f64;
        let ends: Vec<f64> = frames.iter().map(|frame| left + time.at(frame.time) * width).collect();
        let rows = frames.first().map_or(0, |frame| frame.profile.len());
        for row in 0..rows {
            #[expect(clippy::cast_precision_loss, reason = "a few dozen cells")]
            let y = top + row as f64 * cell;
            let of = |frame: &Frame| Some(shade(frame.profile.get(row)? / most));
            for (from, to, k) in runs(frames, &ends, left, of) {
                // Slightly wider, so that neighbours leave no seam.
                let wide = to - from + 0.3;
                let _ = write!(shades[k], "M{from:.1} {y:.1}h{wide:.1}v{cell:.1}h-{wide:.1}z");
            }
            let sliding = |frame: &Frame| {
                let slip = frame.slips.get(row).filter(|slip| slip.abs() > MIN_SLIP)?;
                Some(usize::from(*slip < 0.0))
            };
            for (from, to, k) in runs(frames, &ends, left, sliding) {
                let (place, wide) = (y + 0.8 * cell, to - from);
                let _ = write!(marks[k], "M{from:.1} {place:.1}h{wide:.1}v{:.1}h-{wide:.1}z", 0.4 * cell);
            }
        }
        let Colours { soft, line, far, toward, away, .. } = self.colours;
        let mut scale = String::new();
        for (k, data) in shades.iter().enumerate() {
            #[expect(clippy::cast_precision_loss, reason = "a dozen")]
            let place = k as f64;
            #[expect(clippy::cast_precision_loss, reason = "a dozen")]
            let opacity = 0.04 + 0.8 * (place + 0.5) / SHADES as f64;
            let fill = format!("fill=\"{far}\" fill-opacity=\"{opacity:.2}\"");
            if !data.is_empty() {
                let _ = write!(self.text, "<path d=\"{data}\" {fill}/>");
            }
            let (x, y) = (left + width - 176.0 + 9.0 * place, top - 26.0);
            let _ = write!(scale, "<path d=\"M{x:.0} {y:.0}h9v12h-9z\" {fill}/>");
        }
        for (data, colour) in marks.iter().zip([toward, away]) {
            let _ = write!(self.text, "<path d=\"{data}\" fill=\"{colour}\"/>");
        }
        let bottom = top + height;
        let _ = write!(
            self.text,
            "<path d=\"M{left} {top}v{height}h{width}\" fill=\"none\" stroke=\"{line}\"/><g \
                fill=\"{soft}\"><text x=\"28\" y=\"{}\">position along the cable</text><text x=\"{}\" \
                y=\"{}\" text-anchor=\"end\">drive</text><text x=\"{}\" y=\"{bottom}\" \
                text-anchor=\"end\">anchor</text>",
            top - 14.0,
            left - 8.0,
            top + 12.0,
            left - 8.0,
        );
        // The scale of the shades, above the picture.
        let (right, y) = (left + width, top - 15.0);
        let _ = write!(
            self.text,
            "<text x=\"{:.0}\" y=\"{y:.0}\" text-anchor=\"end\">tension along the cable, 0</text><text \
                x=\"{:.0}\" y=\"{y:.0}\">{most:.0} N</text>",
            right - 184.0,
            right - 60.0,
        );
        self.across(time, "time (s)", [left, bottom, width]);
        let _ = write!(self.text, "</g>{scale}");
    }
}

/// Consecutive frames of one kind: their interval on the page, and the kind.
fn runs(
    frames: &[Frame],
    ends: &[f64],
    left: f64,
    of: impl Fn(&Frame) -> Option<usize>,
) -> Vec<(f64, f64, usize)> {
    let mut runs: Vec<(f64, f64, usize)> = Vec::new();
    let mut from = left;
    let mut last = None;
    for (frame, end) in frames.iter().zip(ends) {
        let kind = of(frame);
        match (kind, runs.last_mut()) {
            (Some(_), Some(run)) if kind == last => run.1 = *end,
            (Some(kind), _) => runs.push((from, *end, kind)),
            (None, _) => {}
        }
        (from, last) = (*end, kind);
    }
    runs
}

/// Shade of a fraction of the largest tension.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "a fraction of a dozen"
)]
fn shade(fraction: f64) -> usize {
    ((fraction * SHADES as f64) as usize).min(SHADES - 1)
}
