//! The cable in its sheath, discretised along its length: capstan friction at nodes, elastic cells between
//! them, no mass.
//!
//! ```text
//! winch p_m --[cell 0]--(node 1)--[cell 1]--(node 2)-- ... --(node M-1)--[cell M-1]-- anchor p_a
//! T_j = (u_j - u_(j+1) + e_j0)/c_j >= 0,   c_j = rho length_j,   u_0 = p_m,  u_M = p_a
//! T_in: tension of cell 0,   T_out: tension of cell M-1, plus T_0
//! slip at node i:   T_(i-1) - T_i = S_i tanh(s_i h_i + g_i v_i),   S_i = T_(i-1) + T_i,   s_i = sign(v_i)
//!                   h_i = (mu phi_i - ln eta_i)/2,   g_i = mu_v phi_i/2 + d_i/(S_i + 2 T_d)
//! stick:            v_i = 0   while   |T_(i-1) - T_i| <= S_i tanh(h_i)
//! ```
//!
//! | symbol | unit | meaning                                                              |
//! |--------|------|----------------------------------------------------------------------|
//! | u_i, v_i | m, m/s | displacement and speed of the cable at node i, + toward the motor  |
//! | T_j, c_j | N, m/N | tension and compliance of cell j                                   |
//! | h_i    | 1    | half friction angle: sliding changes the tension by exactly `e^(2 h_i)`  |
//! | d_i    | N s/m | grease drag of the sheath that the node stands for, fading below `T_d`  |
//! | T_0    | N    | constant force in parallel at the anchor; conservative                 |
//!
//! One time step is implicit: the balance of every node is linearised at the displacements of the last step
//! (an active-set Newton step for stick and slip), the tridiagonal system is solved by the Thomas algorithm,
//! and tensions are scaled to the exact total stretch. One Newton step per millisecond is enough because a
//! slip front passes less than a node per step at up to 0.3 m/s. The energy balance of every step is checked;
//! a lane that created energy is recomputed by exact play sweeps of both ends, which conserve the stretch and
//! are passive from any state.
//!
//! Against a reference of 202 cells and 0.1 ms, at 0.02 to 0.12 m/s with reversals, slack and dither
//! (`tests/cable`), 12 cells err by at most 0.07 N rms and 0.3 N at worst in `T_out`, 0.41 N rms in `T_in`;
//! 16 cells by half of that.
//!
//! # Assumes
//! No mass: waves pass in less than a step. A cable cannot push, so slack is slack everywhere. Friction along
//! the sheath is Coulomb's; presliding comes from the elasticity of the free cable and of the part that the
//! slip front has passed.
//!
//! # Departs
//! The efficiency of (7) is one more friction angle at the first node, not a gain: that keeps it dissipative.
//! The elongation of (10) is measured from zero tension, not from `T_0`: the difference is a constant length.
//!
//! # Source
//! `yuan2023`, eqs. 2, 7 and 10, spread along the cable; front propagation as in play operators,
//! `brokate1996`; the time step and its energy check are original.

#[cfg(test)]
mod bare;
mod batch;
mod creep;
mod dispatch;
mod elementary;
mod ends;
mod lane;
mod lane_group;
mod law;
mod parameters;
mod path;
mod repair;
mod single;
mod steady;
mod step;
mod travel;
mod weakening;

pub use batch::CableBatch;
pub use ends::{EndMotion, EndTensions};
pub use law::{CableLaw, NodeLaw};
pub use parameters::CableParameters;
pub use path::{CablePath, Segment};
pub use single::Cable;
pub(crate) use steady::BothDirections;
pub use steady::SteadySliding;
pub use weakening::{Weakening, WeakeningForm};
