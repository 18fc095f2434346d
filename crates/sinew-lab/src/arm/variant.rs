use super::calibrate::calibrate_networks;
use crate::Error;
use sinew::control::arm::{ActuationMode, ArmGains, CableStateSource};
use sinew::control::compensation::Compensation;
use sinew::predictor::CableModel;
use sinew::twin::arm::ArmSpecimen;

/// Ways to control an arm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Variant {
    /// The paper's, without compensation: drives pull with what is wanted at the anchors.
    None,
    /// The paper's, with one friction angle and a pretension for every muscle (7, 8).
    Capstan,
    /// The paper's, with its networks (17).
    Paper,
    /// Winches by encoders and an integral: no tension at the anchors is known.
    NoObserver,
    /// Winches by the observers of the cables, without the disturbance observer of the joints.
    NoDisturbance,
    /// Winches by the observers of the cables.
    Observer,
    /// The same with a network for every cable that corrects its observer.
    ObserverNetwork,
    /// Winches by the true state of the cables: the yardstick.
    Perfect,
}

/// Payload with which the bandwidth is half, kg: by trial on three arms, both paths in 11.5 s, 0.1 to 0.45 kg.
const CALMED_KG: f64 = 0.45;

impl Variant {
    /// All of them, the default in its place.
    pub const ALL: [Self; 8] = [
        Self::None,
        Self::Capstan,
        Self::Paper,
        Self::NoObserver,
        Self::NoDisturbance,
        Self::Observer,
        Self::ObserverNetwork,
        Self::Perfect,
    ];

    /// Its name in reports and flags.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Capstan => "capstan",
            Self::Paper => "paper",
            Self::NoObserver => "no_observer",
            Self::Observer => "observer",
            Self::ObserverNetwork => "observer_network",
            Self::NoDisturbance => "no_disturbance_observer",
            Self::Perfect => "perfect",
        }
    }

    /// The one of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|variant| variant.name() == name)
    }

    /// With a payload, kg, the controller tries less hard: friction grows with the tensions that carry it, and what is
    /// stiff swings between the two ways a cable can slide.
    pub(super) fn gains(self, payload: f64) -> ArmGains {
        let mut gains = ArmGains::lm_arm();
        let share = payload / CALMED_KG;
        gains.bandwidth.iter_mut().for_each(|bandwidth| *bandwidth /= 1.0 + share * share);
        if self == Self::NoObserver {
            gains = gains.without_tension_estimates();
        }
        if self == Self::NoDisturbance {
            gains.disturbance_bandwidth.fill(0.0);
            // Nor any other integral.
            gains.pre_travel_integral = 0.0;
        }
        gains
    }

    /// How tensions are brought to the anchors, with what was identified.
    pub(super) fn way(
        self,
        specimen: &ArmSpecimen,
        models: &[CableModel],
        seed: u64,
    ) -> Result<ActuationMode, Error> {
        let knowledge = match self {
            Self::None => return Ok(ActuationMode::DriveTension(vec![Compensation::None; models.len()])),
            Self::Capstan => {
                let capstan = |model: &CableModel| {
                    Ok(Compensation::Capstan {
                        friction_angle: model.law()?.friction_angle(),
                        pretension: model.parameters.pretension,
                    })
                };
                return Ok(ActuationMode::DriveTension(
                    models.iter().map(capstan).collect::<Result<_, Error>>()?,
                ));
            }
            Self::Paper => {
                let networks = calibrate_networks(specimen, seed)?;
                let each = networks.into_iter().map(|network| Compensation::Network(Box::new(network)));
                return Ok(ActuationMode::DriveTension(each.collect()));
            }
            Self::NoObserver => CableStateSource::Encoders,
            Self::Observer | Self::ObserverNetwork | Self::NoDisturbance => CableStateSource::Observer,
            Self::Perfect => CableStateSource::Oracle,
        };
        Ok(ActuationMode::WinchSpeed(knowledge))
    }
}
