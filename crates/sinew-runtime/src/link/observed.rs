use sinew::control::supervisor::{Mode, NamedFault, SupervisorCommand};
use sinew::drive::DriveCommand;
use sinew_link::Snapshot;
use sinew_link::wire::flags;
use sinew_session::Feedback;

/// Writes what a cycle has read and commanded into a state; a number that is missing stays as it was and is flagged.
pub(super) fn write(
    snapshot: &mut Snapshot,
    period: f64,
    command: &SupervisorCommand<'_>,
    feedback: &Feedback,
) {
    snapshot.mode = mode(command.mode);
    snapshot.fault = command.fault.map_or([0; 2], fault);
    let mut complete = true;
    for (k, joint) in snapshot.joints_mut().iter_mut().enumerate() {
        // The estimated pose is that of the controller; without it the encoders' one.
        let estimated = command.arm.q[k];
        let position = if estimated.is_finite() { estimated } else { feedback.joint[k] };
        let before = joint.position;
        complete &= keep(&mut joint.position, position);
        joint.velocity = (joint.position - before) / period;
        keep(&mut joint.reference, command.reference.q[k]);
    }
    for (k, muscle) in snapshot.muscles_mut().iter_mut().enumerate() {
        complete &= keep(&mut muscle.tension_in, feedback.tension[k]);
        complete &= keep(&mut muscle.motor_position, feedback.motor[k]);
        keep(&mut muscle.tension_out, command.arm.estimated_tension[k]);
        let commanded = match command.arm.drives[k] {
            DriveCommand::Velocity(velocity) => velocity,
            DriveCommand::Tension { tension, .. } => tension,
            _ => 0.0,
        };
        keep(&mut muscle.command, commanded);
    }
    snapshot.flags = if complete { 0 } else { flags::READING_MISSING };
}

/// False where the number is not finite; the one before is kept then.
fn keep(place: &mut f64, number: f64) -> bool {
    if number.is_finite() {
        *place = number;
    }
    number.is_finite()
}

fn mode(mode: Mode) -> sinew_link::Mode {
    sinew_link::Mode::of(mode as u8).unwrap_or(sinew_link::Mode::Fault)
}

fn fault(named: NamedFault) -> [u16; 2] {
    [named.code(), named.index().unwrap_or(0) as u16]
}

#[cfg(test)]
mod tests {
    use sinew::control::supervisor::{Mode, Request};

    #[test]
    fn codes_on_the_wire_mean_what_the_supervisor_means() {
        assert_eq!(Mode::ALL.len(), sinew_link::Mode::ALL.len());
        for mode in Mode::ALL {
            assert_eq!(super::mode(mode).name(), format!("{mode:?}"));
        }
        assert_eq!(Request::ALL.len(), sinew_link::Request::ALL.len());
        for request in sinew_link::Request::ALL {
            let own = Request::from_number(request.number()).expect("a request of the supervisor");
            assert_eq!(request.name(), format!("{own:?}"));
            assert_eq!(sinew_link::Request::of(own as u8), Some(*request));
        }
    }
}
