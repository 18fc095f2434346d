use crate::drive::DriveParameters;

/// Tension of a cable from the current of its motor: in both directions, which is how a motor tells load from
/// friction, or while it winds in.
///
/// ```text
/// T = k n/r (i_o + i_w)/(eta + 1/eta)      i_o, i_w: means over the same travel, out and back
/// T = (k i_w - tau_c) eta n/r               where the encoder does not resolve that travel
/// ```
///
/// | symbol   | meaning                                                          | unit  |
/// |----------|------------------------------------------------------------------|-------|
/// | T        | tension at the drive's outlet where the winch stops                | N     |
/// | k, n, r  | torque constant, ratio, arm of the winch                           | Nm/A, 1, m |
/// | eta, tau_c | efficiency, friction without load                               | 1, Nm |
///
/// At rest the friction of the gear carries any part of the tension between both currents, so that a current
/// tells nothing before the winch turns. In the sum of both the friction without load cancels, and an
/// efficiency of 0.7 that is off by 0.06 makes 3 % of the tension.
///
/// # Assumes
/// The cable sticks in its sheath over the travel, so that its tension depends on the position alone.
///
/// # Source
/// Our own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CurrentTension {
    drive: DriveParameters,
    /// One count of the encoder, m.
    count: f64,
    /// Of the winch, m.
    travel: f64,
    /// Of a winch that turns, and of one that stands until the friction of its gear is overcome, m/s.
    speeds: [f64; 2],
    /// Whether it pays out first, and the currents of both directions tell.
    both: bool,
    part: Part,
    stroke: Stroke,
    /// Currents that count, A.
    paying_out: Mean,
    winding_in: Mean,
    /// Commanded, m/s.
    speed: f64,
}

/// How a winch has moved since the present part began.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Stroke {
    /// Where it began, m.
    from: f64,
    /// Since then, s.
    time: f64,
    /// Time for which it has turned, s.
    moving: f64,
    /// How far it has turned, m, and for how long it has not turned farther, s.
    farthest: f64,
    still: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Part {
    PayingOut,
    WindingIn,
    Done,
}

/// s: of the travel, and in which the friction of a gear is overcome.
const DURATION: f64 = 0.4;
/// s: from rest to a speed, so that little of the current accelerates the rotor.
const EASING: f64 = 0.05;
/// s: in which a winch that has begun to turn comes to its speed.
const SETTLING: f64 = 0.1;
/// Of the encoder: a motion, and a travel.
const COUNTS: [f64; 2] = [2.0, 8.0];
/// Travel over the stretch of the cable: its tension changes by a few percent.
const STRETCH: f64 = 0.015;
/// Change of the tension by a travel of so many counts that is resolved, over the tension.
const RESOLVED: f64 = 0.1;
/// Commanded travel that overcomes the friction of a gear over the travel, at most: beyond it the winch would
/// not begin to turn slowly.
const SLOW: f64 = 8.0;
/// s: a winch that has not turned by then is blocked.
const PATIENCE: f64 = 5.0;

impl CurrentTension {
    /// Of a cable at about this tension, N, with this compliance as a whole and of its free length at the
    /// winch, m/N, at a position of the winch, m.
    /// None where the encoder is too coarse for either: to see a motion would change the tension.
    pub(super) fn new(
        drive: &DriveParameters,
        tension: f64,
        compliance: [f64; 2],
        position: f64,
    ) -> Option<Self> {
        let turns = drive.reducer.ratio / drive.winch.arm(0);
        let count = core::f64::consts::TAU / (drive.encoder.counts * turns);
        let [whole, near] = compliance;
        let travel = (STRETCH * whole * tension).max(COUNTS[1] * count);
        let reversal = drive.reversal_travel_at(tension);
        let resolved = |compliance: f64| COUNTS[1] * count < RESOLVED * tension * compliance;
        let both = resolved(near) && reversal < SLOW * travel;
        let slow = travel / DURATION;
        resolved(whole).then_some(Self {
            drive: *drive,
            count,
            travel,
            speeds: [slow, slow.max(reversal / DURATION)],
            both,
            part: if both { Part::PayingOut } else { Part::WindingIn },
            stroke: Stroke { from: position, ..Stroke::default() },
            paying_out: Mean::default(),
            winding_in: Mean::default(),
            speed: 0.0,
        })
    }

    /// Speed of the winch, m/s, for the next `h` s, from its position, m, and current, A; what is missing is
    /// waited for.
    pub(super) fn step(&mut self, h: f64, position: f64, current: f64) -> f64 {
        self.stroke.time += h;
        if position.is_finite() && current.is_finite() {
            self.take(h, position, current);
        }
        let [turning, standing] = self.speeds;
        let speed = if self.stroke.moving > 0.0 { turning } else { standing };
        // Weak integral action takes longer to overcome the friction, and a drive with a coarse resolution of
        // its speed stands at a small one: both are asked for more with time.
        let speed = speed * (1.0 + self.stroke.time * self.stroke.time);
        let target = match self.part {
            Part::PayingOut => -speed,
            Part::WindingIn => speed,
            Part::Done => 0.0,
        };
        let most = h * speed / EASING;
        self.speed += (target - self.speed).clamp(-most, most);
        self.speed
    }

    fn take(&mut self, h: f64, position: f64, current: f64) {
        let stroke = &mut self.stroke;
        let moved = match self.part {
            Part::PayingOut => {
                stroke.from = stroke.from.max(position);
                stroke.from - position
            }
            Part::WindingIn => {
                stroke.from = stroke.from.min(position);
                position - stroke.from
            }
            Part::Done => return,
        };
        let turned = moved >= COUNTS[0] * self.count;
        if turned || stroke.moving > 0.0 {
            stroke.moving += h;
        }
        stroke.still = if moved >= stroke.farthest + self.count { 0.0 } else { stroke.still + h };
        stroke.farthest = if stroke.still == 0.0 { moved } else { stroke.farthest };
        let steady = stroke.moving >= SETTLING && stroke.still < SETTLING;
        // Both directions over the half of the travel that is farther out, the one alone over the later time.
        let [half, whole] = [0.5 * self.travel, self.travel];
        let (counts, ends) = match self.part {
            Part::PayingOut => (moved >= half, moved >= whole),
            _ if self.both => (turned, moved >= half),
            _ => (steady, h * self.winding_in.count >= 0.5 * DURATION),
        };
        let mean = if self.part == Part::PayingOut { &mut self.paying_out } else { &mut self.winding_in };
        if counts {
            mean.add(current);
        }
        if ends {
            self.part = if self.part == Part::PayingOut { Part::WindingIn } else { Part::Done };
            self.stroke = Stroke { from: position, ..Stroke::default() };
        }
    }

    /// The tension, N; none before the winch has turned and stands.
    pub(super) fn tension(&self) -> Option<f64> {
        if self.part != Part::Done || self.speed != 0.0 {
            return None;
        }
        let winding_in = self.winding_in.value();
        if !self.both {
            return Some(self.drive.tension_of(winding_in));
        }
        let efficiency = self.drive.reducer.efficiency;
        let torque = self.drive.motor.torque_constant * (self.paying_out.value() + winding_in);
        let turns = self.drive.reducer.ratio / self.drive.winch.arm(0);
        Some((torque * turns / (efficiency + 1.0 / efficiency)).max(0.0))
    }

    /// Whether the winch does not do what it is told.
    pub(super) fn stands(&self) -> bool {
        self.stroke.time > PATIENCE && self.part != Part::Done
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Mean {
    sum: f64,
    count: f64,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1.0;
    }

    fn value(&self) -> f64 {
        self.sum / self.count
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::{Drive, DriveCommand, Encoder, Reducer};

    /// The estimate for a winch on a spring, by a drive as it is known, and the tension in the end.
    fn measured(
        drive: DriveParameters,
        known: DriveParameters,
        (tension, period): (f64, f64),
        both: bool,
    ) -> (f64, f64) {
        let mut plant = Drive::new(drive, 1).unwrap();
        plant.settle(tension);
        // The cable sticks where the winch pays out, and slides as a whole where it only winds in.
        let compliance = [5e-3 / tension, 1.0 / 3e4];
        let (stiffness, mut moved) = (1.0 / compliance[usize::from(both)], 0.0);
        let mut reversal =
            CurrentTension::new(&known, tension, compliance, plant.reading().position).unwrap();
        assert_eq!(reversal.both, both);
        for _ in 0..4000 {
            if let Some(found) = reversal.tension() {
                return (found, tension + stiffness * moved);
            }
            let reading = plant.reading();
            let speed = reversal.step(period, reading.position, reading.current);
            for _ in 0..(period / 1e-3) as usize {
                let pulled = (tension + stiffness * moved).max(0.0);
                moved += plant.step(DriveCommand::Velocity(speed), pulled, 1e-3).moved;
            }
        }
        panic!("it never ends");
    }

    #[test]
    fn the_tension_is_found_whatever_the_friction_of_the_gear_is_taken_to_be() {
        let plant = DriveParameters { has_load_cell: false, ..DriveParameters::mc_am() };
        for (period, factor) in [(1e-3, 1.0), (4e-3, 0.5), (4e-3, 1.5), (1e-2, 1.2)] {
            let reducer = Reducer { friction: factor * plant.reducer.friction, ..plant.reducer };
            let known = DriveParameters { reducer, ..plant };
            for tension in [25.0, 60.0, 150.0] {
                let (found, truth) = measured(plant, known, (tension, period), true);
                assert!((found / truth - 1.0).abs() < 0.05, "{period} {factor} {tension}: {found} {truth}");
            }
        }
    }

    #[test]
    fn a_coarse_encoder_does_not_pay_out_and_the_gear_has_to_be_known() {
        let plant = DriveParameters { has_load_cell: false, ..DriveParameters::mc_am() };
        let encoder = Encoder { counts: 4096.0 / plant.reducer.ratio, ..plant.encoder };
        let plant = DriveParameters { encoder, ..plant };
        for tension in [15.0, 25.0, 50.0] {
            let (found, truth) = measured(plant, plant, (tension, 1e-3), false);
            assert!((found / truth - 1.0).abs() < 0.08, "{tension}: {found} {truth}");
        }
    }

    #[test]
    fn a_winch_that_is_jammed_stands() {
        let drive = DriveParameters::mc_am();
        let mut reversal = CurrentTension::new(&drive, 50.0, [1e-4, 3e-5], 0.1).unwrap();
        for _ in 0..4900 {
            reversal.step(1e-3, 0.1, 0.4);
            assert!(!reversal.stands() && reversal.tension().is_none());
        }
        for _ in 0..200 {
            // Nothing is read for a while: that changes nothing.
            reversal.step(1e-3, f64::NAN, f64::NAN);
        }
        assert!(reversal.stands());
    }
}
