//! Tensions of both ends over time, and below them the tension along the cable with the slip front in it.

use std::fmt::Write;

/// The cable at one time.
pub(super) struct Frame {
    pub(super) time: f64,
    pub(super) tension_in: f64,
    pub(super) tension_out: f64,
    /// Along the cable, N, drive end first.
    pub(super) profile: Vec<f64>,
    /// Of every node in the last substep, m.
    pub(super) slips: Vec<f64>,
}

const WIDTH: f64 = 1040.0;
const LEFT: f64 = 90.0;
const CURVES: [f64; 2] = [96.0, 240.0];
const PROFILE: [f64; 2] = [400.0, 260.0];
/// Shades of the tension.
const SHADES: usize = 12;
/// Slip, m per substep of a quarter of a millisecond, that is seen as sliding: 0.1 mm/s.
const SLIDES: f64 = 2.5e-8;

/// The picture as SVG, in colours that read on light and dark pages alike.
pub(super) fn draw(frames: &[Frame]) -> String {
    let end = frames.last().map_or(1.0, |frame| frame.time);
    let most = frames
        .iter()
        .flat_map(|f| f.profile.iter().copied().chain([f.tension_in, f.tension_out]))
        .fold(1.0, f64::max);
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 1200 740\" width=\"1200\" height=\"740\" role=\"img\" \
         aria-label=\"Tensions of a simulated cable\" font-family=\"system-ui, sans-serif\" font-size=\"14\">\
         <rect x=\"0.5\" y=\"0.5\" width=\"1199\" height=\"739\" rx=\"12\" fill=\"#ffffff\" stroke=\"#d4d9df\"/>\
         <text x=\"28\" y=\"40\" font-size=\"20\" font-weight=\"600\" fill=\"#14181d\">One cable, both ends moved</text>\
         <rect x=\"1064\" y=\"22\" width=\"112\" height=\"22\" rx=\"11\" fill=\"#fff2e5\" stroke=\"#b4500b\"/>\
         <text x=\"1120\" y=\"37.5\" font-size=\"13\" text-anchor=\"middle\" fill=\"#8a3c06\">simulated data</text>",
    );
    legend(&mut svg);
    axes(&mut svg, end, most);
    curve(&mut svg, frames, end, most, |frame| frame.tension_in, "#8d949c");
    curve(&mut svg, frames, end, most, |frame| frame.tension_out, "#0a66c9");
    profile(&mut svg, frames, end, most);
    svg.push_str("</svg>\n");
    svg
}

fn legend(svg: &mut String) {
    svg.push_str(
        "<g fill=\"#4d5763\"><path d=\"M360 35h26\" stroke=\"#8d949c\" stroke-width=\"4\"/><text x=\"393\" y=\"40\">near \
         tension</text><path d=\"M500 35h26\" stroke=\"#0a66c9\" stroke-width=\"3\"/><text x=\"533\" y=\"40\">far tension</text>\
         <rect x=\"635\" y=\"29\" width=\"26\" height=\"12\" fill=\"#c2570a\"/><text x=\"668\" y=\"40\">slides toward the \
         motor</text><rect x=\"855\" y=\"29\" width=\"26\" height=\"12\" fill=\"#1b7f5c\"/><text x=\"888\" y=\"40\">slides \
         away</text></g>",
    );
}

/// Frames and labels of both panels; writing into a string cannot fail.
fn axes(svg: &mut String, end: f64, most: f64) {
    let bottom = PROFILE[0] + PROFILE[1];
    let _ = write!(
        svg,
        "<g fill=\"#4d5763\"><text x=\"28\" y=\"{}\">tension (N)</text><text x=\"28\" y=\"{}\">place along the cable</text>\
         <text x=\"{}\" y=\"{}\" text-anchor=\"end\">drive</text><text x=\"{}\" y=\"{bottom}\" text-anchor=\"end\">anchor</text>",
        CURVES[0] - 14.0,
        PROFILE[0] - 14.0,
        LEFT - 8.0,
        PROFILE[0] + 12.0,
        LEFT - 8.0,
    );
    for part in 0..=4 {
        let share = f64::from(part) / 4.0;
        let (x, y) = (LEFT + share * WIDTH, CURVES[0] + (1.0 - share) * CURVES[1]);
        let _ = write!(
            svg,
            "<text x=\"{}\" y=\"{:.1}\" dy=\"4.5\" text-anchor=\"end\">{:.0}</text><text x=\"{x:.1}\" y=\"{}\" \
             text-anchor=\"middle\">{:.1}</text>",
            LEFT - 8.0,
            y,
            share * most,
            bottom + 20.0,
            share * end
        );
    }
    let _ = write!(
        svg,
        "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">time (s)</text></g><path d=\"M{LEFT} {}v{}h{WIDTH}M{LEFT} {}v{}h{WIDTH}\" \
         fill=\"none\" stroke=\"#aeb6bf\"/>",
        LEFT + WIDTH,
        bottom + 42.0,
        CURVES[0],
        CURVES[1],
        PROFILE[0],
        PROFILE[1]
    );
}

fn curve(svg: &mut String, frames: &[Frame], end: f64, most: f64, of: fn(&Frame) -> f64, colour: &str) {
    let mut data = String::new();
    for frame in frames {
        let (x, y) = (LEFT + frame.time / end * WIDTH, CURVES[0] + (1.0 - of(frame) / most) * CURVES[1]);
        let _ = write!(data, "{}{x:.1} {y:.1}", if data.is_empty() { 'M' } else { 'L' });
    }
    let _ = write!(
        svg,
        "<path d=\"{data}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2.4\" stroke-linejoin=\"round\"/>"
    );
}

/// Tension as shades of blue, the sliding nodes as marks over them: their edge is the slip front.
fn profile(svg: &mut String, frames: &[Frame], end: f64, most: f64) {
    let mut shades = vec![String::new(); SHADES];
    let mut marks = [String::new(), String::new()];
    let mut before = 0.0;
    for frame in frames {
        let (x, width) = (LEFT + before / end * WIDTH, (frame.time - before) / end * WIDTH);
        before = frame.time;
        #[expect(clippy::cast_precision_loss, reason = "a few dozen cells")]
        let height = PROFILE[1] / frame.profile.len().max(1) as f64;
        let mut y = PROFILE[0];
        for tension in &frame.profile {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                clippy::cast_precision_loss,
                reason = "a share of a dozen"
            )]
            let shade = ((tension / most * SHADES as f64) as usize).min(SHADES - 1);
            // A little wider, so that neighbours leave no seam.
            let _ =
                write!(shades[shade], "M{x:.1} {y:.1}h{:.1}v{height:.1}h-{:.1}z", width + 0.3, width + 0.3);
            y += height;
        }
        for (node, slip) in (1_u32..).zip(&frame.slips) {
            if slip.abs() > SLIDES {
                let place = PROFILE[0] + f64::from(node) * height - 0.2 * height;
                let mark = &mut marks[usize::from(*slip < 0.0)];
                let _ = write!(mark, "M{x:.1} {place:.1}h{width:.1}v{:.1}h-{width:.1}z", 0.4 * height);
            }
        }
    }
    for (k, data) in shades.iter().enumerate().filter(|(_, data)| !data.is_empty()) {
        #[expect(clippy::cast_precision_loss, reason = "a dozen")]
        let opacity = 0.04 + 0.8 * (k as f64 + 0.5) / SHADES as f64;
        let _ = write!(svg, "<path d=\"{data}\" fill=\"#0a66c9\" fill-opacity=\"{opacity:.2}\"/>");
    }
    for (data, colour) in marks.iter().zip(["#c2570a", "#1b7f5c"]) {
        let _ = write!(svg, "<path d=\"{data}\" fill=\"{colour}\"/>");
    }
}
