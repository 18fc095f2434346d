use crate::transmission::Sliding;

/// What is known of the direction in which a cable slides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SlidingState {
    /// It slides in this direction.
    Slides(Sliding),
    /// It rests, and may have slid either way before: tensions that both directions allow.
    Either,
}

/// How the cables of a machine slide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CableMotion<'a> {
    /// Unknown: every cable may have slid either way before.
    Either,
    /// As these velocities of the joints move them; a cable that they do not move may have slid either way.
    /// `[joints]`
    Along(&'a [f64]),
    /// Without friction in the sheaths.
    Frictionless,
}

/// Range of the tension at an anchor while the tension of its drive is within a range, N; none where no
/// tension is possible in every state.
///
/// ```text
/// toward the motor      T_out = T_in exp(-A) + T_0
/// away from the motor   T_out = T_in exp(+A) + T_0
/// either                the intersection of both ranges
/// ```
///
/// | symbol | argument     | unit | domain | meaning                                    |
/// |--------|--------------|------|--------|--------------------------------------------|
/// | T_in   | `drive`      | N    | >= 0   | least and largest tension at the drive      |
/// | A      | `angle`      | 1    | >= 0   | friction angle of the whole cable           |
/// | T_0    | `pretension` | N    | >= 0   | tension at the anchor without the drive's   |
///
/// # Assumes
/// The whole cable slides slowly: no viscous friction, no static friction above the sliding one. A cable that
/// rests holds any tension between those of the two directions.
///
/// # Example
/// ```
/// use sinew::control::capability::{SlidingState, anchor_limits};
/// use sinew::transmission::Sliding;
/// let ends = [Sliding::TowardMotor, Sliding::AwayFromMotor]
///     .map(|sliding| anchor_limits([2.0, 300.0], 1.0, 5.0, SlidingState::Slides(sliding)).expect("a range"));
/// // Both directions differ by exp(2 A).
/// assert!(((ends[1][1] - 5.0) / (ends[0][1] - 5.0) - 2.0_f64.exp()).abs() < 1e-12);
/// let both = anchor_limits([2.0, 300.0], 1.0, 5.0, SlidingState::Either).expect("a range");
/// assert_eq!(both, [ends[1][0], ends[0][1]]);
/// ```
///
/// # Source
/// `yuan2023`, eq. 7.
#[must_use]
pub fn anchor_limits(drive: [f64; 2], angle: f64, pretension: f64, state: SlidingState) -> Option<[f64; 2]> {
    let through =
        |sliding: Sliding| drive.map(|tension| tension * libm::exp(-sliding.sign() * angle) + pretension);
    match state {
        SlidingState::Slides(sliding) => Some(through(sliding)),
        SlidingState::Either => {
            let ([_, most], [least, _]) = (through(Sliding::TowardMotor), through(Sliding::AwayFromMotor));
            (least <= most).then_some([least, most])
        }
    }
}
