//! Cables side by side, one per lane: their numbers and their state, stored so that one instruction serves all.

use super::law::CableLaw;
use super::parameters::Weakening;
use super::step::tanh_series;
use super::travel::Seen;
use alloc::vec;
use alloc::vec::Vec;

/// The same quantity of `N` cables; aligned so that eight lanes are one line of cache and one wide register.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(super) struct Row<const N: usize>(pub(super) [f64; N]);

impl<const N: usize> Row<N> {
    pub(super) const ZERO: Self = Self([0.0; N]);
}

/// Friction at one node of every lane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node<const N: usize> {
    /// `h_i`.
    pub(super) half: Row<N>,
    /// `tanh h_i`.
    pub(super) grip: Row<N>,
    /// `mu_v phi_i / 2`, s/m.
    pub(super) viscous: Row<N>,
    /// `d_i`, N s/m.
    pub(super) drag: Row<N>,
}

/// What a node remembers of its speed, where friction weakens with it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Memory<const N: usize> {
    /// `mu phi_i / 2` at high speed, and the part of `h_i` that does not weaken.
    pub(super) friction: Row<N>,
    pub(super) loss: Row<N>,
    /// Lagged speed `z_i`, m/s.
    pub(super) speed: Row<N>,
}

/// How friction weakens, per lane; a rise of zero where it does not.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weakenings<const N: usize> {
    pub(super) rise: Row<N>,
    /// `1/v_s`, s/m.
    pub(super) inverse_speed: Row<N>,
    pub(super) lag: Row<N>,
}

/// Displacements of both ends in one step, m, + toward the motor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion<const N: usize> {
    pub(super) motor: Row<N>,
    pub(super) anchor: Row<N>,
}

/// What the ends felt during the step, and what friction took.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ends<const N: usize> {
    pub(super) near: Row<N>,
    pub(super) far: Row<N>,
    pub(super) dissipated: Row<N>,
}

/// `N` cables with the same number of cells; everything else may differ from lane to lane.
#[derive(Debug, Clone)]
pub(super) struct LaneGroup<const N: usize> {
    /// As built; wraps are kept up to date.
    pub(super) laws: Vec<CableLaw>,
    pub(super) compliance: Vec<Row<N>>,
    pub(super) stiffness: Vec<Row<N>>,
    pub(super) nodes: Vec<Node<N>>,
    /// `2 T_d`, N.
    pub(super) fade: Row<N>,
    /// Where friction of any lane weakens, with one memory per node.
    pub(super) weakening: Option<Weakenings<N>>,
    pub(super) memory: Vec<Memory<N>>,
    /// Newton steps per time step.
    pub(super) iterations: usize,

    /// `T_j`, N: `[cells]`.
    pub(super) tension: Vec<Row<N>>,
    /// Displacement of the last step, m: winch, nodes, anchor: `[cells + 1]`.
    pub(super) slip: Vec<Row<N>>,
    /// Total stretch `e`, m; not above zero when slack.
    pub(super) stretch: Row<N>,
    /// `sum c T^2`, twice the elastic energy, J.
    pub(super) energy: Row<N>,

    /// Tensions that become those of the step if its certificate holds.
    pub(super) next: Vec<Row<N>>,
    /// Elimination: `x_i = known_i + up_i x_(i+1)`; the winch, node 0, does not move by it.
    pub(super) up: Vec<Row<N>>,
    pub(super) known: Vec<Row<N>>,
    /// One lane seen from one end.
    pub(super) column: Vec<Seen>,
}

impl<const N: usize> LaneGroup<N> {
    /// Slack cables of these laws, at most `N`, all with as many cells as the first; idle lanes copy the last law.
    pub(super) fn new(laws: &[CableLaw]) -> Self {
        let of = |lane: usize| &laws[lane.min(laws.len() - 1)];
        let row = |value: &dyn Fn(&CableLaw) -> f64| Row(core::array::from_fn(|lane| value(of(lane))));
        let cells = laws[0].cells();
        let mut lanes = Self {
            laws: (0..N).map(|lane| of(lane).clone()).collect(),
            compliance: (0..cells).map(|j| row(&|law| law.compliance[j])).collect(),
            stiffness: (0..cells).map(|j| row(&|law| 1.0 / law.compliance[j])).collect(),
            nodes: vec![
                Node { half: Row::ZERO, grip: Row::ZERO, viscous: Row::ZERO, drag: Row::ZERO };
                cells - 1
            ],
            fade: row(&|law| 2.0 * law.drag_fade),
            weakening: None,
            memory: vec![],
            iterations: 1,
            tension: vec![Row::ZERO; cells],
            slip: vec![Row::ZERO; cells + 1],
            stretch: Row::ZERO,
            energy: Row::ZERO,
            next: vec![Row::ZERO; cells],
            up: vec![Row::ZERO; cells],
            known: vec![Row::ZERO; cells],
            column: vec![Seen::default(); cells],
        };
        if laws.iter().any(|law| law.weakening.is_some()) {
            let still = Memory { friction: Row::ZERO, loss: Row::ZERO, speed: Row::ZERO };
            lanes.memory = vec![still; cells - 1];
            let or = |value: fn(&Weakening) -> f64, otherwise: f64| {
                row(&move |law| law.weakening.as_ref().map_or(otherwise, value))
            };
            lanes.weakening = Some(Weakenings {
                rise: or(|w| w.rise, 0.0),
                inverse_speed: or(|w| 1.0 / w.speed, 1.0),
                lag: or(|w| w.lag, 1.0),
            });
        }
        for lane in 0..N {
            for node in 0..cells - 1 {
                lanes.refresh(lane, node, 1.0);
            }
        }
        lanes
    }

    /// Writes one node of one lane from its law, its drag times `drag_factor`.
    pub(super) fn refresh(&mut self, lane: usize, node: usize, drag_factor: f64) {
        let law = self.laws[lane].nodes[node];
        let row = &mut self.nodes[node];
        row.half.0[lane] = law.friction + law.loss;
        row.grip.0[lane] = tanh_series(row.half.0[lane]);
        row.viscous.0[lane] = law.viscous;
        row.drag.0[lane] = law.drag * drag_factor;
        if let Some(memory) = self.memory.get_mut(node) {
            memory.friction.0[lane] = law.friction;
            memory.loss.0[lane] = law.loss;
        }
    }

    /// Stretch and energy of a lane from its tensions.
    pub(super) fn measure(&mut self, lane: usize) {
        let (mut stretch, mut energy) = (0.0, 0.0);
        for (tension, compliance) in self.tension.iter().zip(&self.compliance) {
            let (t, c) = (tension.0[lane], compliance.0[lane]);
            stretch += c * t;
            energy += c * t * t;
        }
        self.stretch.0[lane] = stretch;
        self.energy.0[lane] = energy;
    }
}
