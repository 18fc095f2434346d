//! From the tension wanted at the anchor to the tension that the drive must pull with.

use crate::Error;
use crate::predictor::{CableModel, CableObserver, CableSample};
use crate::transmission::Perceptron;
use crate::transmission::cable::CableLaw;
use alloc::boxed::Box;

/// What a compensator is told every millisecond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wish {
    /// Tension wanted at the anchor, N.
    pub tension_out: f64,
    /// Speed at which the cable is known to be wanted, m/s, + toward the motor: its sign says which way it slides.
    pub velocity: f64,
    /// What the sensors say.
    pub sample: CableSample,
}

/// What the drive is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pull {
    /// Tension at the drive, N.
    pub tension: f64,
    /// Speed at which the cable is going to stretch under it, m/s: the winch must turn that much faster.
    pub stretching: f64,
}

/// A way from [`Wish`] to the tension at the drive.
#[derive(Debug, Clone)]
pub enum Compensation {
    /// None: the drive pulls with what is wanted at the anchor.
    None,
    /// Eqs. 7 and 8 with the sign of the reference: one angle and the pretension.
    Capstan {
        /// `mu phi - ln eta`.
        friction_angle: f64,
        /// N.
        pretension: f64,
    },
    /// The paper's network (17): what to add, from wanted tension and speed; bend and length of the sheath are constant.
    Network(Perceptron),
    /// The observer: the static inverse of its law, corrected by what it believes of the far end.
    Observer(Box<ObserverCompensation>),
}

impl Compensation {
    /// What the drive shall do after this sample, `interval` seconds after the one before.
    pub fn pull(&mut self, interval: f64, wish: &Wish) -> Pull {
        let tension = match self {
            Self::Observer(observer) => return observer.pull(interval, wish),
            Self::None => wish.tension_out,
            Self::Capstan { friction_angle, pretension } => {
                let factor = libm::exp(direction(wish.velocity) * *friction_angle);
                ((wish.tension_out - *pretension) * factor).max(0.0)
            }
            Self::Network(network) => {
                let inputs = [wish.tension_out, wish.velocity];
                wish.tension_out + network.evaluate(&inputs).unwrap_or(0.0)
            }
        };
        Pull { tension, stretching: 0.0 }
    }

    /// What it believes of the far end, N; none where it believes nothing.
    #[must_use]
    pub fn estimate(&self) -> Option<f64> {
        match self {
            Self::Observer(observer) => Some(observer.far),
            _ => None,
        }
    }
}

fn direction(velocity: f64) -> f64 {
    if velocity >= 0.0 { 1.0 } else { -1.0 }
}

/// Static inverse of the cable's law plus an integral of what the observer sees missing at the far end.
///
/// ```text
/// T_in* = (T_out* - T_0) e^(s A) + s D |v| k(s A) + e^(s A) z,    k(a) = (e^a - 1)/a
/// z <- z + h/t_z (T_out* - T^_out)     while sliding the wanted way and the observer knows its state
/// ```
///
/// | symbol | meaning                                                        | unit  |
/// |--------|----------------------------------------------------------------|-------|
/// | A, T_0, D | friction angle, pretension and drag of the identified cable   | 1, N, N s/m |
/// | s, v   | direction and speed of the reference                             | 1, m/s |
/// | T^_out | the observer's estimate                                          | N     |
/// | t_z    | 0.4 s                                                             | s     |
///
/// # Source
/// Our own.
#[derive(Debug, Clone)]
pub struct ObserverCompensation {
    observer: CableObserver,
    friction_angle: f64,
    pretension: f64,
    drag: f64,
    missing: f64,
    last_direction: f64,
    since_reversal: f64,
    far: f64,
    /// Stretch per near tension while the whole cable slides toward the motor, and away, m/N.
    compliance: [f64; 2],
    last_wanted: Option<f64>,
}

/// Time over which what is missing is added, s.
const RESET_TIME: f64 = 0.4;
/// Most that may be missing, N.
const MOST_MISSING: f64 = 40.0;
/// After a reversal the far end cannot follow for a while, and says nothing about what is missing, s.
const BLIND: f64 = 0.3;

impl ObserverCompensation {
    /// A compensation by what was identified.
    ///
    /// # Errors
    /// As [`CableModel::law`].
    pub fn new(model: &CableModel) -> Result<Self, Error> {
        let law = model.law()?;
        Ok(Self {
            observer: CableObserver::new(model)?,
            friction_angle: law.friction_angle(),
            pretension: law.pretension(),
            drag: model.parameters.drag,
            missing: 0.0,
            last_direction: 0.0,
            since_reversal: 0.0,
            far: 0.0,
            compliance: [1.0, -1.0].map(|s| compliance(&law, s)),
            last_wanted: None,
        })
    }

    fn pull(&mut self, interval: f64, wish: &Wish) -> Pull {
        let estimate = self.observer.step(interval, &wish.sample);
        self.far = estimate.far;
        let s = direction(wish.velocity);
        if s.to_bits() != self.last_direction.to_bits() {
            // What was missing one way was missing in friction: the other way it is too much.
            (self.last_direction, self.since_reversal) = (s, 0.0);
            self.missing = 0.0;
        }
        self.since_reversal += interval;
        if estimate.known && self.since_reversal > BLIND {
            let rate = interval / RESET_TIME * (wish.tension_out - estimate.far);
            self.missing = (self.missing + rate).clamp(-MOST_MISSING, MOST_MISSING);
        }
        let angle = s * self.friction_angle;
        let factor = libm::exp(angle);
        let spread = if angle.abs() > 1e-6 { (factor - 1.0) / angle } else { 1.0 };
        let drag = s * self.drag * wish.velocity.abs() * spread;
        let tension = ((wish.tension_out - self.pretension + self.missing) * factor + drag).max(0.0);
        let rate = self.last_wanted.map_or(0.0, |last| (wish.tension_out - last) / interval);
        self.last_wanted = Some(wish.tension_out);
        let compliance = self.compliance[usize::from(s < 0.0)];
        Pull { tension, stretching: compliance * factor * rate }
    }
}

/// `sum_j c_j T_j/T_in` with friction everywhere at work in one direction, spread evenly over the nodes, m/N.
fn compliance(law: &CableLaw, s: f64) -> f64 {
    let cells = law.compliance();
    let nodes = (cells.len() - 1).max(1) as f64;
    let share = |j: usize| libm::exp(-s * law.friction_angle() * j as f64 / nodes);
    cells.iter().enumerate().map(|(j, c)| c * share(j)).sum()
}
