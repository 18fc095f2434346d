//! Parameters and state of several cables, one per SIMD lane, as a structure of arrays.

use super::law::CableLaw;
use super::travel::CellView;
use super::weakening::{Weakening, WeakeningForm};
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
    pub(super) half_angle: Row<N>,
    /// `tanh h_i`.
    pub(super) tanh_half: Row<N>,
    /// `mu_v phi_i / 2`, s/m.
    pub(super) viscous: Row<N>,
    /// `d_i` of the law, N s/m.
    pub(super) drag: Row<N>,
}

/// State of a node whose friction weakens with speed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Memory<const N: usize> {
    /// `mu phi_i / 2` at high speed, and the part of `h_i` that does not weaken.
    pub(super) friction: Row<N>,
    pub(super) loss: Row<N>,
    /// Lagged speed `z_i`, m/s.
    pub(super) speed: Row<N>,
}

/// Parameters of velocity weakening per lane; a rise of zero where there is none.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weakenings<const N: usize> {
    pub(super) rise: Row<N>,
    /// `1/v_s`, s/m.
    pub(super) inverse_speed: Row<N>,
    pub(super) lag: Row<N>,
    pub(super) form: [WeakeningForm; N],
    /// Whether all have this form, which a compiler can vectorise.
    pub(super) all_rational: bool,
}

impl<const N: usize> Weakenings<N> {
    /// Factors on friction at these lagged speeds, m/s: [`Weakening::factor`] with the inverse of its speed.
    #[inline(always)]
    pub(super) fn factors(&self, speed: &Row<N>) -> Row<N> {
        let mut factors = Row::<N>::ZERO;
        if self.all_rational {
            for k in 0..N {
                let ratio = speed.0[k] * self.inverse_speed.0[k];
                factors.0[k] = WeakeningForm::Rational.factor(self.rise.0[k], ratio);
            }
        } else {
            for k in 0..N {
                let ratio = speed.0[k] * self.inverse_speed.0[k];
                factors.0[k] = self.form[k].factor(self.rise.0[k], ratio);
            }
        }
        factors
    }
}

/// Recoverable creep of the cells.
#[derive(Debug, Clone)]
pub(super) struct Creep<const N: usize> {
    /// `kappa`, 1.
    pub(super) fraction: Row<N>,
    /// `tau`, s; infinite where a cable does not creep.
    pub(super) time: Row<N>,
    /// `x_j`, m: `[cells]`.
    pub(super) crept: Vec<Row<N>>,
}

/// Displacements of both ends in one step, m, + toward the motor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion<const N: usize> {
    pub(super) motor: Row<N>,
    pub(super) anchor: Row<N>,
}

/// Tensions at the ends after the step, and the energy dissipated in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ends<const N: usize> {
    pub(super) near: Row<N>,
    pub(super) far: Row<N>,
    pub(super) dissipated: Row<N>,
}

/// `N` cables with the same number of cells; everything else may differ from lane to lane.
#[derive(Debug, Clone)]
pub(super) struct LaneGroup<const N: usize> {
    /// Laws as built, with current wraps.
    pub(super) laws: Vec<CableLaw>,
    pub(super) compliance: Vec<Row<N>>,
    pub(super) stiffness: Vec<Row<N>>,
    pub(super) nodes: Vec<Node<N>>,
    /// `2 T_d`, N.
    pub(super) fade: Row<N>,
    /// Drag as a multiple of the law's.
    pub(super) drag_factor: Row<N>,
    /// Present where friction of any lane weakens, with one memory per node.
    pub(super) weakening: Option<Weakenings<N>>,
    pub(super) memory: Vec<Memory<N>>,
    /// Present where a cable of any lane creeps.
    pub(super) creep: Option<Creep<N>>,
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

    /// Tensions of the step before they are accepted.
    pub(super) next_tension: Vec<Row<N>>,
    /// Thomas algorithm after forward elimination: `x_i = rhs_i + super_i x_(i+1)`; row 0, the winch, is
    /// zero.
    pub(super) superdiagonal: Vec<Row<N>>,
    pub(super) right_hand_side: Vec<Row<N>>,
    /// Cells of one lane in the order from one end.
    pub(super) cells_from_end: Vec<CellView>,
}

impl<const N: usize> LaneGroup<N> {
    /// Slack cables of these laws, at most `N`, all with as many cells as the first; idle lanes copy the last
    /// law.
    pub(super) fn new(laws: &[CableLaw]) -> Self {
        let of = |lane: usize| &laws[lane.min(laws.len() - 1)];
        let row = |value: &dyn Fn(&CableLaw) -> f64| Row(core::array::from_fn(|lane| value(of(lane))));
        let cells = laws[0].cells();
        let mut lanes = Self {
            laws: (0..N).map(|lane| of(lane).clone()).collect(),
            compliance: (0..cells).map(|j| row(&|law| law.compliance[j])).collect(),
            stiffness: (0..cells).map(|j| row(&|law| 1.0 / law.compliance[j])).collect(),
            nodes: vec![
                Node {
                    half_angle: Row::ZERO,
                    tanh_half: Row::ZERO,
                    viscous: Row::ZERO,
                    drag: Row::ZERO
                };
                cells - 1
            ],
            fade: row(&|law| 2.0 * law.drag_fade),
            drag_factor: Row([1.0; N]),
            weakening: None,
            memory: vec![],
            creep: None,
            iterations: 1,
            tension: vec![Row::ZERO; cells],
            slip: vec![Row::ZERO; cells + 1],
            stretch: Row::ZERO,
            energy: Row::ZERO,
            next_tension: vec![Row::ZERO; cells],
            superdiagonal: vec![Row::ZERO; cells],
            right_hand_side: vec![Row::ZERO; cells],
            cells_from_end: vec![CellView::default(); cells],
        };
        if laws.iter().any(|law| law.weakening.is_some()) {
            let still = Memory { friction: Row::ZERO, loss: Row::ZERO, speed: Row::ZERO };
            lanes.memory = vec![still; cells - 1];
            let or = |value: fn(&Weakening) -> f64, otherwise: f64| {
                row(&move |law| law.weakening.as_ref().map_or(otherwise, value))
            };
            let form = core::array::from_fn(|k| {
                laws.get(k).and_then(|law| law.weakening).map_or(WeakeningForm::default(), |w| w.form)
            });
            lanes.weakening = Some(Weakenings {
                rise: or(|w| w.rise, 0.0),
                inverse_speed: or(|w| 1.0 / w.speed, 1.0),
                lag: or(|w| w.lag, 1.0),
                form,
                all_rational: form == [WeakeningForm::Rational; N],
            });
        }
        for lane in 0..N {
            for node in 0..cells - 1 {
                lanes.refresh(lane, node);
            }
        }
        lanes
    }

    /// Takes over the state of lanes of the same laws, with their wraps, bends and drag; creep is not part of
    /// it. Nothing is allocated.
    pub(super) fn copy_state(&mut self, from: &Self) {
        self.nodes.copy_from_slice(&from.nodes);
        self.memory.copy_from_slice(&from.memory);
        self.tension.copy_from_slice(&from.tension);
        self.slip.copy_from_slice(&from.slip);
        self.drag_factor = from.drag_factor;
        self.stretch = from.stretch;
        self.energy = from.energy;
    }

    /// Writes one node of one lane from its law.
    pub(super) fn refresh(&mut self, lane: usize, node: usize) {
        let law = self.laws[lane].nodes[node];
        let row = &mut self.nodes[node];
        row.half_angle.0[lane] = law.half_angle();
        row.tanh_half.0[lane] = law.tanh_half();
        row.viscous.0[lane] = law.viscous;
        row.drag.0[lane] = law.drag;
        if let Some(memory) = self.memory.get_mut(node) {
            memory.friction.0[lane] = law.friction;
            memory.loss.0[lane] = law.loss;
        }
    }

    /// Stretch and energy of a lane from its tensions.
    pub(super) fn update_stretch_and_energy(&mut self, lane: usize) {
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
