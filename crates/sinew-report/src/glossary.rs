//! Terms that pages explain where a reader points at them.

/// Terms in lower case, as they stand in pages, and what they mean.
pub(super) const GLOSSARY: &[(&str, &str)] = &[
    (
        "friction angle",
        "Coefficient of friction times the angle by which a sheath bends, mu phi: the tension falls to exp(-mu phi).",
    ),
    (
        "dead band",
        "What passes after a reversal before the far end follows: travel of the winch, or an angle of the joint.",
    ),
    ("presliding", "Small displacements of a loaded cable before all of it slides."),
    ("pretension", "Tension of a cable at rest, which keeps it from going slack."),
    ("cross-validated", "Judged on logs, or parts of them, that the fit has not seen."),
    ("fold", "A part of the logs that is held out in turn, to judge a fit of the others."),
    ("95 % band", "Interval about a prediction that held 95 % of the samples which the fit had not seen."),
    ("coverage", "Fraction of the samples that lie within the band."),
    ("specimen", "One cable or machine as it was built, with friction, stiffness and errors of its own."),
    ("near side", "The end of a cable at its motor, where the sensors are."),
    ("far side", "The end of a cable at its load, which is not measured in operation."),
    ("observer", "An estimator: a model that measurements correct as it runs."),
    (
        "moment arm",
        "Torque at a joint per newton of tension; also the change of a muscle's length per radian.",
    ),
    ("backlash compensation", "Travel that a winch adds at a reversal, so that the far end follows sooner."),
    ("locked winches", "Motors at rest, so that only the cables stretch."),
    ("phase margin", "Phase that a control loop can lose before it oscillates."),
    ("iterative learning", "Errors of one repeat correct the commands of the next."),
    (
        "capstan",
        "Law of a cable around a drum: the ratio of its tensions grows exponentially with the angle.",
    ),
    (
        "clamp cell",
        "Element with hysteresis whose output stands until one of two bounds, which follow the input, moves it.",
    ),
    ("stribeck", "Friction that falls as sliding becomes faster."),
    ("reversal", "Change of a cable's direction, at which friction changes its sign."),
    ("rmse", "Root mean square error."),
];
