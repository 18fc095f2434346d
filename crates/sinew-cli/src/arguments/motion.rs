//! Arguments of a motion of a machine: what `sinew track` and `sinew run` share.

use super::machine::RootArgument;
use super::path::{PathArgument, PathParser};
use super::values::{compensation, number, workshop};
use clap::Args;
use sinew::machine::Workshop;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{INITIAL_REST_S, WrittenFault};
use std::path::PathBuf;

// The help of the verb stands with the verb: no documentation comment here.
#[derive(Debug, Args)]
pub(crate) struct MotionArguments {
    /// A machine's or robot's file, or the name of a built-in machine
    #[arg(default_value = "lm_arm")]
    pub(crate) model: PathBuf,
    #[command(flatten)]
    pub(crate) root: RootArgument,
    /// Desired motion: a closed path of the machine by NAME (lm_arm: sine, saddle), a tour, a position
    /// of the end point (m), a pose of the joints (rad or m), or a table of waypoints [default: the first
    /// named path, otherwise tour]
    #[arg(long, value_parser = PathParser,
        value_name = "NAME|tour|to:X,Y,Z|to-joints:JOINT=VALUE,..|joints:FILE.csv|FILE.csv")]
    pub(crate) path: Option<PathArgument>,
    /// Seconds for two turns of a closed path [default: 40], of a tour [default: as fast as feasible,
    /// half or a quarter as fast where simulated machines do not track it, at least 12], or for a
    /// point-to-point motion [default: 5], 2 to 3600; waypoints have times of their own
    #[arg(long, value_name = "SECONDS",
        value_parser = number("2 to 3600 s", |s| (2.0..=3600.0).contains(&s)))]
    pub(crate) duration: Option<f64>,
    /// Repeats of a closed path, 1 to 100 [default: 1]; an open path is tracked once
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
    pub(crate) repeats: Option<u32>,
    /// Disable iterative learning from repeat to repeat
    #[arg(long)]
    pub(crate) no_learning: bool,
    /// Start also a motion that simulated machines of the design do not track
    #[arg(long)]
    pub(crate) unverified: bool,
    /// Seconds at rest after the motion, 0 to 3600
    #[arg(long, value_name = "SECONDS", default_value_t = 3.0,
        value_parser = number("0 to 3600 s", |s| (0.0..=3600.0).contains(&s)))]
    pub(crate) hold: f64,
    /// Compensation of the cables' transmission losses
    #[arg(long, value_name = "NAME", default_value = "observer",
        value_parser = compensation(&CompensationVariant::ARM))]
    pub(crate) compensation: CompensationVariant,
    /// Mass carried at the end point, 0 to 100 kg; known to the controller [default: the machine's]
    #[arg(long, value_name = "KG", value_parser = number("0 to 100 kg", |kg| (0.0..=100.0).contains(&kg)))]
    pub(crate) payload: Option<f64>,
    #[arg(long, value_name = "COMPONENT:NAME[:MODE]@START[+DURATION]", help = fault_help())]
    pub(crate) fault: Vec<WrittenFault>,
    /// Gains of the controller (JSON, as `sinew machine tune` writes them) [default: derived for the
    /// motion]
    #[arg(long, value_name = "FILE.json")]
    pub(crate) gains: Option<PathBuf>,
    /// Geometry of the machine as the controller knows it, as `sinew calibrate` writes it
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) calibration: Option<PathBuf>,
    /// Frames of joints, centres of mass, radii, encoders and flex of a simulated machine as a workshop
    /// builds them, in place of the tolerances in the machine's file
    #[arg(long, value_name = "WORKSHOP", value_parser = workshop())]
    pub(crate) tolerances: Option<Workshop>,
    /// Seed of the arm's deviations from the model and of the sensor noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
}

fn fault_help() -> String {
    format!(
        "Inject a fault; may be given again. COMPONENT is cable, drive, winch, motor-encoder or load-cell \
         with the NAME of a muscle, or joint-encoder with that of a joint; sensors have a MODE: stuck, lost, \
         nan, jump=X, gain=X, drift=X (per s), saturation=X or noise=X (m, N, rad). friction, pretension \
         and stiffness of a muscle wear by MODE per cent over DURATION; \
         push moves a joint by a torque of MODE Nm; cycles:lost, cycles:late and cycles:stale are of the \
         control cycle. START and DURATION are in s; the run starts with {INITIAL_REST_S} s at rest"
    )
}
