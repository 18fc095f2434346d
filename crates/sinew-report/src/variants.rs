//! Short names of the compensation variants in tables and plots.

use sinew_lab::CompensationVariant;

pub(super) fn label(variant: CompensationVariant) -> &'static str {
    match variant {
        CompensationVariant::None => "no compensation",
        CompensationVariant::Capstan => "static capstan",
        CompensationVariant::Paper => "the paper’s network",
        CompensationVariant::Inverted => "identified from the log alone, inverted",
        CompensationVariant::NoObserver => "encoders, no observer",
        CompensationVariant::NoDisturbanceObserver => "observer, no disturbance observer",
        CompensationVariant::Observer => "observer",
        CompensationVariant::Perfect => "true cable state",
    }
}
