//! A state message: what is drawn and plotted of the signals at one time.

use crate::drawing::{Drawing, POINTS, SHEATH_POINTS};
use crate::layout::Layout;
use crate::signals::Signals;
use sinew::Error;
use sinew::machine::Machine;
use sinew_session::signals::Signal;

/// Flags of a state.
pub(crate) const PAUSED: u16 = 1;
pub(crate) const BEHIND: u16 = 2;
pub(crate) const SILENT: u16 = 4;

/// Tension, N, and sliding, 0 sticks, 1 toward the motor, 2 away, of every point of all cables.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Along {
    pub(crate) tension: Vec<f64>,
    pub(crate) sliding: Vec<f64>,
}

impl Along {
    /// Between the two ends, where no more is known: from the near tension to the far tension without the
    /// pretension, which acts behind the sheath, in proportion to itself as in capstan friction.
    pub(crate) fn between_ends(machine: &Machine, now: &Signals) -> Self {
        let mut tension = Vec::with_capacity(machine.muscles.len() * POINTS);
        for (k, muscle) in machine.muscles.iter().enumerate() {
            let (near, far) = (now.muscle(Signal::TensionIn, k), now.far_tension(k));
            let end = far - muscle.cable.pretension;
            let (first, last) = (near.max(0.0), end.max(0.0));
            for point in 0..POINTS {
                let fraction = point as f64 / SHEATH_POINTS as f64;
                tension.push(if point >= SHEATH_POINTS {
                    far
                } else if first > 0.0 && last > 0.0 {
                    first * (last / first).powf(fraction)
                } else {
                    first + fraction * (last - first)
                });
            }
        }
        Self { sliding: vec![0.0; tension.len()], tension }
    }
}

/// What a state message is made of.
#[derive(Debug)]
pub(crate) struct Frame<'a> {
    pub(crate) revision: u32,
    pub(crate) sequence: u64,
    pub(crate) flags: u16,
    /// Time of the source over real time.
    pub(crate) speed: f64,
    pub(crate) now: &'a Signals,
    pub(crate) along: &'a Along,
    /// Of a second machine beside the first.
    pub(crate) second: Option<&'a Signals>,
}

impl Frame<'_> {
    /// The message.
    ///
    /// # Errors
    /// As [`Drawing::evaluate`].
    pub(crate) fn message(&self, layout: &Layout, drawing: &mut Drawing) -> Result<Vec<u8>, Error> {
        let [mut poses, mut ghost, mut points, mut poses_2] = [const { Vec::new() }; 4];
        let (mut end_reference, mut end_2) = (None, None);
        if let Some(q) = self.second.and_then(Signals::pose) {
            drawing.evaluate(q)?;
            drawing.bodies(&mut poses_2);
            end_2 = drawing.end_point();
        }
        if let Some(q) = self.now.reference() {
            drawing.evaluate(q)?;
            drawing.bodies(&mut ghost);
            end_reference = drawing.end_point();
        }
        match self.now.pose() {
            Some(q) => drawing.evaluate(q)?,
            None => drawing.evaluate_start()?,
        }
        drawing.bodies(&mut poses);
        drawing.cables(&mut points)?;
        let end = drawing.end_point();
        Ok(layout.state(self.revision, |name, out| match name {
            "sequence" => out.push(self.sequence as f64),
            "flags" => out.push(f64::from(self.flags)),
            "speed" => out.push(self.speed),
            "body_pose" => out.extend(&poses),
            "reference_pose" => out.extend(&ghost),
            "body_pose_2" => out.extend(&poses_2),
            "cable_points" => out.extend(&points),
            "cable_tension" => out.extend(&self.along.tension),
            "cable_sliding" => out.extend(&self.along.sliding),
            "end_point" => out.extend(end.into_iter().flatten()),
            "end_point_reference" => out.extend(end_reference.into_iter().flatten()),
            "end_point_2" => out.extend(end_2.into_iter().flatten()),
            name => signal(name, self.now, self.second, out),
        }))
    }
}

/// The numbers of a field that is a signal, not drawn geometry.
fn signal(name: &str, now: &Signals, second: Option<&Signals>, out: &mut Vec<f64>) {
    match name {
        "joint_2" => out.extend(second.and_then(Signals::pose).into_iter().flatten()),
        "tension_out_2" => {
            let far =
                second.map(|second| (0..second.frame.layout().sizes()[0]).map(|k| second.far_tension(k)));
            out.extend(far.into_iter().flatten());
        }
        name => now.field(name, out),
    }
}

/// End points of the machine and its reference, and of the second machine, for a row of a history.
pub(crate) struct HistoryRow<'a> {
    pub(crate) now: &'a Signals,
    pub(crate) second: Option<&'a Signals>,
}

impl HistoryRow<'_> {
    /// Adds the fields of the layout that are plotted.
    ///
    /// # Errors
    /// As [`Drawing::evaluate`].
    pub(crate) fn write(
        &self,
        layout: &Layout,
        drawing: &mut Drawing,
        out: &mut Vec<u8>,
    ) -> Result<(), Error> {
        let mut end = |q: Option<&[f64]>| {
            let Some(q) = q else { return Ok(None) };
            drawing.evaluate(q)?;
            Ok::<_, Error>(drawing.end_point())
        };
        let requested = end(self.now.reference())?;
        let (first, second) = (end(self.now.pose())?, end(self.second.and_then(Signals::pose))?);
        layout.history_row(out, |name, out| match name {
            "end_point" => out.extend(first.into_iter().flatten()),
            "end_point_reference" => out.extend(requested.into_iter().flatten()),
            "end_point_2" => out.extend(second.into_iter().flatten()),
            name => signal(name, self.now, self.second, out),
        });
        Ok(())
    }
}
