//! What a verification before the start says on the terminal.

use sinew_lab::arm::{Verified, VerifiedTour};

/// Says that a tour was slowed from `given` s, and why.
pub(super) fn tell_slowed(tour: &VerifiedTour, given: f64) {
    if let Some(reason) = &tour.slowed {
        tell!(
            "The tour takes {:.0} s instead of {given:.0} s, in which simulated machines of this design do \
                not track it: {reason}",
            tour.trajectory.duration(),
        );
    }
}

/// Warns of a motion that simulated machines of the design do not track well, or not at all.
pub(super) fn warn(verified: &Verified) {
    match verified {
        Verified::Tracks(_) => (),
        Verified::Inaccurate(_, reason) => tell!(
            "warning: simulated machines of this design come to the end of this motion, but not well: \
                {reason}; `sinew machine tune` names what limits each joint"
        ),
        Verified::Fails(reason) => {
            tell!("warning: simulated machines of this design do not track this motion: {reason}");
        }
    }
}
