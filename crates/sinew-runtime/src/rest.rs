//! How every bus ends a run: its drives are brought to rest on a ramp, then lose their power.

use sinew::drive::{DriveCommand, DriveParameters};
use sinew_session::{Exchange, Feedback, Plant};

/// In which drives come to rest, for which they stand then, and in which they lose their power, at most, ns.
const BRAKE_TIME: u64 = 500_000_000;
const STAND_TIME: u64 = 20_000_000;
const DISABLE_TIME: u64 = 200_000_000;

/// Fraction of a drive's acceleration with which it brakes before it is disabled, as in a safe stop.
const BRAKING_FRACTION: f64 = 0.4;

/// The speed, m/s, that follows the one that was commanded last on the way to rest, `h` s later: never a
/// step.
pub(crate) fn braked_speed(parameters: &DriveParameters, commanded: f64, h: f64) -> f64 {
    let most = BRAKING_FRACTION * parameters.acceleration * h;
    commanded - commanded.clamp(-most, most)
}

/// Drives on a bus, for [`bring_to_rest`].
pub(crate) trait Drives: Plant {
    /// Number of muscles and of independent joints.
    fn dimensions(&self) -> [usize; 2];

    /// The next speeds on the way to rest, by muscle; whether all winches are told to stand.
    fn slow_down(&self, commands: &mut [DriveCommand]) -> bool;

    /// Whether the last exchange shows every drive, and that none has power.
    fn are_without_power(&self, last: Exchange) -> bool;

    /// Writes outside of a control cycle, and lets the rest of the period pass.
    fn write_and_wait(&mut self, commands: &[DriveCommand]);

    /// Cycles of a time, ns; at least as many as its drives need for a change of state.
    fn cycles_of(&self, time: u64) -> u64;
}

/// Brings all drives to rest on a ramp, then takes their power.
pub(crate) fn bring_to_rest(bus: &mut impl Drives) {
    let [muscles, joints] = bus.dimensions();
    let mut feedback = Feedback::new(muscles, joints);
    let mut commands = vec![DriveCommand::Velocity(0.0); muscles];
    let mut stood = 0;
    for _ in 0..bus.cycles_of(BRAKE_TIME) {
        bus.read(&mut feedback);
        let standing = bus.slow_down(&mut commands);
        bus.write_and_wait(&commands);
        stood = if standing { stood + 1 } else { 0 };
        if stood >= bus.cycles_of(STAND_TIME) {
            break;
        }
    }
    commands.fill(DriveCommand::Off);
    for _ in 0..bus.cycles_of(DISABLE_TIME) {
        let last = bus.read(&mut feedback);
        if bus.are_without_power(last) {
            break;
        }
        bus.write_and_wait(&commands);
    }
}
