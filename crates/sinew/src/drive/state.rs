//! What one drive does in a step, as straight lines of arithmetic: eight are then done at once.

use super::current_loop::CurrentLoop;
use super::exchange::DriveCommand;
use super::motor::{MotorState, Winding};
use super::parameters::DriveParameters;
use super::reducer::{Shaft, Turn};
use super::speed_control::{MeasuredShaft, SpeedControl};
use super::tension_loop::TensionLoop;
use crate::lanes::{abreast, abreast_as_it_is};
use crate::transmission::saturate;

/// What moves and warms in a drive, and what its loops remember.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DriveState {
    pub(super) motor: MotorState,
    /// Angle and speed of the motor's shaft, rad and rad/s.
    pub(super) angle: f64,
    pub(super) speed: f64,
    /// Angle of the winch, behind the backlash, rad.
    pub(super) winch: f64,
    /// Cable on the drum, m.
    pub(super) wound: f64,
    pub(super) current_loop: CurrentLoop,
    pub(super) speed_control: SpeedControl,
    pub(super) tension_loop: TensionLoop,
    pub(super) mode: Mode,
    /// Asked of the motor, Nm.
    pub(super) torque: f64,
}

abreast!(DriveStateRows of DriveState {
    MotorState: motor;
    f64: angle speed winch wound torque;
    CurrentLoop: current_loop;
    SpeedControl: speed_control;
    TensionLoop: tension_loop;
    Mode: mode
});

/// Which loop is closed. As wide as a number, so that lanes of both are vectorised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub(super) enum Mode {
    Free,
    Velocity,
    Tension,
}
abreast_as_it_is!(Mode);

/// A command as the loops take it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Asked {
    pub(super) mode: Mode,
    /// Whether the amplifier is on.
    pub(super) on: bool,
    /// A, m/s or N.
    pub(super) value: f64,
    /// m/s.
    pub(super) feed: f64,
}
abreast!(AskedRows of Asked { Mode: mode; bool: on; f64: value feed });

impl Asked {
    /// Off.
    pub(super) const NOTHING: Self = Self { mode: Mode::Free, on: false, value: 0.0, feed: 0.0 };

    /// Commands that are not finite switch off; without a load cell a tension command holds the winch.
    pub(super) fn new(command: DriveCommand, has_load_cell: bool) -> Self {
        let asked = |mode, value| Self { mode, on: true, value, feed: 0.0 };
        match command {
            DriveCommand::Current(current) if current.is_finite() => asked(Mode::Free, current),
            DriveCommand::Velocity(velocity) if velocity.is_finite() => asked(Mode::Velocity, velocity),
            DriveCommand::Tension { .. } if !has_load_cell => asked(Mode::Velocity, 0.0),
            DriveCommand::Tension { tension, feed } if tension.is_finite() && feed.is_finite() => {
                Self { feed, ..asked(Mode::Tension, tension) }
            }
            _ => Self::NOTHING,
        }
    }
}

/// Winding and shaft after a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Powered {
    pub(super) turn: Turn,
    pub(super) winding: Winding,
    /// J.
    pub(super) electrical: f64,
}
impl Powered {
    /// Of a drive that does nothing.
    pub(super) const NONE: Self = Self {
        turn: Turn { speed: 0.0, lost: 0.0 },
        winding: Winding { mean: 0.0, heat: 0.0, to_air: 0.0 },
        electrical: 0.0,
    };
}

abreast!(PoweredRows of Powered { Turn: turn; Winding: winding; f64: electrical });

impl DriveState {
    /// Changes the mode without a jump and sets the [torque](Self::torque) for the next `h` s.
    #[inline(always)]
    pub(super) fn command(&mut self, p: &DriveParameters, asked: Asked, measured: MeasuredShaft, h: f64) {
        let before = self.mode;
        self.mode = asked.mode;
        if asked.mode == Mode::Free {
            let most = p.motor.peak_current;
            self.torque = p.motor.torque_constant * asked.value.max(-most).min(most);
            return;
        }
        if before == Mode::Free {
            self.speed_control.take_over(self.speed);
        }
        let mut velocity = asked.value;
        if asked.mode == Mode::Tension {
            if before != Mode::Tension {
                self.tension_loop.reset();
            }
            let desired = saturate(asked.value, p.min_tension, p.max_tension);
            velocity = self.tension_loop.speed(desired, measured.tension, asked.feed, h);
        }
        self.torque = self.speed_control.torque(p, velocity, measured, h);
    }

    /// Winding and shaft, coupled implicitly: the back-EMF is that of the speed at the end of the step. With
    /// the amplifier off the circuit is open and carries no current.
    #[inline(always)]
    pub(super) fn power(&mut self, p: &DriveParameters, on: bool, load: f64, h: f64) -> Powered {
        let (motor, k) = (&p.motor, p.motor.torque_constant);
        let shaft = Shaft { inertia: motor.inertia, speed: self.speed, angle: self.angle };
        if !on {
            let turn = p.reducer.turn(shaft, 0.0, 0.0, load, h);
            let returned = self.motor.open(motor);
            return Powered { turn, winding: self.motor.drive(0.0, h), electrical: -returned };
        }
        let (lag, most, before) = (self.motor.lag(), motor.peak_current, self.motor.current);
        let amperes = (self.torque / k).max(-most).min(most);
        let mut beside = self.current_loop.voltage(motor, amperes, before, lag.left);
        let mut turn = p.reducer.turn(shaft, k * self.motor.mean(beside), 0.0, load, h);
        let full = motor.voltage.copysign(beside + k * turn.speed);
        if (beside + k * turn.speed).abs() <= motor.voltage {
            self.current_loop.integrate(motor, amperes, before);
        } else {
            // The voltage is saturated: the back-EMF reduces the current and acts as a brake.
            let brake = k * k * (1.0 - lag.mean) / self.motor.resistance();
            turn = p.reducer.turn(shaft, k * self.motor.mean(full), brake, load, h);
            beside = full - k * turn.speed;
        }
        let winding = self.motor.drive(beside, h);
        Powered { turn, winding, electrical: (beside + k * turn.speed) * winding.mean * h }
    }

    /// Advances shaft and winch, which turns `per_ratio` as fast, but for the backlash.
    #[inline(always)]
    pub(super) fn advance(&mut self, backlash: f64, turned: f64, per_ratio: f64, tension: f64, h: f64) {
        self.speed = turned;
        self.angle += h * turned;
        let behind = self.angle * per_ratio;
        let half = 0.5 * backlash;
        // A cable under tension keeps the winch on one flank.
        self.winch =
            if tension > 0.0 { behind - half } else { saturate(self.winch, behind - half, behind + half) };
    }
}
