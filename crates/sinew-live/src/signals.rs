//! Signals of a machine at one time.

use sinew::control::arm::ArmCommand;
use sinew::control::supervisor::{Mode, NamedFault};
use sinew::twin::arm::ArmTruth;

/// What a control cycle has read, estimated and commanded.
#[derive(Debug, Clone, Copy)]
pub struct Observed<'a> {
    /// Since the first cycle, s.
    pub time: f64,
    /// Mode of the supervisor, and its fault.
    pub mode: Mode,
    /// See `mode`.
    pub fault: Option<NamedFault>,
    /// Delay of the wake-up and time that the cycle took, us; NaN on virtual time.
    pub cycle_us: [f64; 2],
    /// rad or m: `[joints]`.
    pub joint_reference: &'a [f64],
    /// Estimates.
    pub command: &'a ArmCommand<'a>,
    /// Of the load cells, N: `[muscles]`.
    pub tension_in: &'a [f64],
    /// m: `[muscles]`.
    pub winch_position: &'a [f64],
    /// Of a simulated machine.
    pub truth: Option<ArmTruth<'a>>,
}

/// Signals at one time; NaN where they are not known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Signals {
    /// s.
    pub(crate) time: f64,
    /// Number of the mode of the supervisor.
    pub(crate) mode: f64,
    /// Code of a fault, and index of its muscle or joint.
    pub(crate) fault: [f64; 2],
    /// As [`Observed::cycle_us`].
    pub(crate) cycle_us: [f64; 2],
    /// rad or m: `[joints]`.
    pub(crate) joint_reference: Vec<f64>,
    pub(crate) joint_estimated: Vec<f64>,
    pub(crate) joint_true: Vec<f64>,
    /// N: `[muscles]`.
    pub(crate) tension_in: Vec<f64>,
    pub(crate) tension_out_desired: Vec<f64>,
    pub(crate) tension_out_estimated: Vec<f64>,
    pub(crate) tension_out_true: Vec<f64>,
    /// m: `[muscles]`.
    pub(crate) winch_position: Vec<f64>,
    /// degC: `[muscles]`.
    pub(crate) motor_temperature: Vec<f64>,
}

/// Numbers before the joints'.
const HEAD: usize = 6;

impl Signals {
    /// Nothing is known.
    pub(crate) fn unknown([muscles, joints]: [usize; 2]) -> Self {
        let of = |count| vec![f64::NAN; count];
        Self {
            time: 0.0,
            mode: 0.0,
            fault: [0.0; 2],
            cycle_us: [f64::NAN; 2],
            joint_reference: of(joints),
            joint_estimated: of(joints),
            joint_true: of(joints),
            tension_in: of(muscles),
            tension_out_desired: of(muscles),
            tension_out_estimated: of(muscles),
            tension_out_true: of(muscles),
            winch_position: of(muscles),
            motor_temperature: of(muscles),
        }
    }

    /// The pose that is drawn: the true one where it is known, otherwise the estimated one, otherwise the reference.
    pub(crate) fn pose(&self) -> Option<&[f64]> {
        let known = |q: &&Vec<f64>| q.iter().all(|q| q.is_finite());
        let all = [&self.joint_true, &self.joint_estimated, &self.joint_reference];
        all.into_iter().find(known).map(Vec::as_slice)
    }

    /// Far tension of a muscle as far as it is known, N.
    pub(crate) fn far_tension(&self, muscle: usize) -> f64 {
        let [truth, estimated] =
            [&self.tension_out_true, &self.tension_out_estimated].map(|list| list[muscle]);
        if truth.is_finite() { truth } else { estimated }
    }

    /// Numbers of a cycle on their way to the page.
    pub(crate) fn words([muscles, joints]: [usize; 2]) -> usize {
        HEAD + 3 * joints + 5 * muscles
    }

    /// Writes what a cycle has observed. Nothing is allocated.
    ///
    /// # Shapes
    /// `words: [Signals::words(..)]`.
    pub(crate) fn write(words: &mut [f64], [muscles, joints]: [usize; 2], of: &Observed<'_>) {
        let fault = fault_numbers(of.fault);
        let head = [of.time, f64::from(of.mode as u8), fault[0], fault[1], of.cycle_us[0], of.cycle_us[1]];
        words[..HEAD].copy_from_slice(&head);
        let (angles, tensions) = words[HEAD..].split_at_mut(3 * joints);
        let known = of.truth.as_ref();
        let truth = known.map_or(&[][..], |truth| truth.q);
        for (row, values) in
            angles.chunks_exact_mut(joints.max(1)).zip([of.joint_reference, of.command.q, truth])
        {
            put(row, values.iter().copied());
        }
        let mut rows = tensions.chunks_exact_mut(muscles.max(1));
        let mut next = |values: &mut dyn Iterator<Item = f64>| {
            if let Some(row) = rows.next() {
                put(row, values);
            }
        };
        next(&mut of.tension_in.iter().copied());
        next(&mut of.command.desired_tension.iter().copied());
        next(&mut of.command.estimated_tension.iter().copied());
        let cables = known.map_or(&[][..], |truth| truth.cables);
        next(&mut cables.iter().map(|cable| cable.tension_out));
        next(&mut of.winch_position.iter().copied());
    }

    /// Takes what [`write`](Self::write) has written.
    pub(crate) fn read(&mut self, words: &[f64]) {
        let (muscles, joints) = (self.tension_in.len(), self.joint_reference.len());
        let mut rest = words;
        let mut take = |count: usize| {
            let (taken, after) = rest.split_at(count);
            rest = after;
            taken
        };
        let head = take(HEAD);
        (self.time, self.mode) = (head[0], head[1]);
        (self.fault, self.cycle_us) = ([head[2], head[3]], [head[4], head[5]]);
        for list in [&mut self.joint_reference, &mut self.joint_estimated, &mut self.joint_true] {
            list.copy_from_slice(take(joints));
        }
        for list in [
            &mut self.tension_in,
            &mut self.tension_out_desired,
            &mut self.tension_out_estimated,
            &mut self.tension_out_true,
            &mut self.winch_position,
        ] {
            list.copy_from_slice(take(muscles));
        }
    }
}

/// Numbers of a fault as [`Signals::fault`] holds them.
pub(crate) fn fault_numbers(fault: Option<NamedFault>) -> [f64; 2] {
    fault.map_or([0.0; 2], |fault| [f64::from(fault.code()), fault.index().unwrap_or_default() as f64])
}

/// Fills a row; NaN where there are fewer values.
fn put(row: &mut [f64], values: impl Iterator<Item = f64>) {
    row.iter_mut().zip(values.chain(std::iter::repeat(f64::NAN))).for_each(|(to, from)| *to = from);
}
