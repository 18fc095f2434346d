//! What a design says about itself before anything is simulated: poses in which its muscles are too weak,
//! poses that it leaves by itself, and wraps that its tolerances may undo.

use crate::error::Error;
use crate::output::one_line;
use crate::table::number;
use serde::Serialize;
use sinew::control::arm::{LeastStable, UnheldPose, least_stable_pose, unheld_poses};
use sinew::machine::{Clearance, Machine, NegativeStiffness};
use sinew::trajectory::Equilibrium;
use sinew::transmission::cable::CableLaw;

/// Co-contractions at which stability is given: the controller's, and a quarter of the range of the tensions.
const COCONTRACTIONS: [f64; 2] = [0.0, 0.25];

/// The least stable of the sampled poses, winches held; what is printed with `--json`.
#[derive(Debug, Serialize)]
pub(super) struct LockedWinches {
    cocontraction: f64,
    /// Smallest eigenvalue of M^-1 K.
    eigenvalue_per_s2: f64,
    /// At which the machine leaves the pose; 0 where it stays.
    unstable_rate_per_s: f64,
    /// Of the independent joints.
    pose: Vec<f64>,
    joint: String,
    /// The muscle whose moment arms change most unfavourably; none where that is gravity.
    muscle: Option<String>,
}

/// What of the motion of a machine with fewer motors than joints its cables control; what is printed with
/// `--json`.
#[derive(Debug, Serialize)]
pub(super) struct Underactuated {
    controllable: usize,
    joints: usize,
    /// Joints that follow others in the middle of the ranges.
    follows: Vec<Follows>,
    /// Least stiffness of the joints at constant lengths over the sampled poses.
    least_stiffness_nm_per_rad: f64,
    /// The joint that moves most there, and the pose.
    softest: String,
    softest_pose: Vec<f64>,
    /// Least and largest tension against springs and gravity over the sampled poses: `[muscles]`.
    tensions_n: Vec<[f64; 2]>,
}

/// `joint` moves `ratio` times as far as `leader` when the cable of `muscle` moves slowly.
#[derive(Debug, Serialize)]
struct Follows {
    muscle: String,
    joint: String,
    leader: String,
    ratio: f64,
}

/// Of a machine with its payload in the body.
#[derive(Debug)]
pub(super) struct DesignChecks {
    /// One of every co-contraction; none where no pose is held.
    pub(super) locked_winches: Vec<LockedWinches>,
    /// Poses in which no tensions within their limits hold it, and the number of all sampled ones.
    unheld: [usize; 2],
    /// None where motors hold every joint.
    pub(super) underactuated: Option<Underactuated>,
    pub(super) warnings: Vec<String>,
}

impl DesignChecks {
    pub(super) fn new(machine: &Machine, laws: &[CableLaw], poses: &[Vec<f64>]) -> Result<Self, Error> {
        let mut warnings = Vec::new();
        // First: a cable that has lost its wrap may be why the muscles are too weak.
        let lost = machine.clearances(poses)?.into_iter().filter(Clearance::is_lost);
        warnings.extend(
            lost.map(|clearance| lost_wrap(machine, &clearance, clearance.pose.map(|index| &poses[index]))),
        );
        let unheld = unheld_poses(machine, laws, poses)?;
        warnings.extend(too_weak(machine, &unheld, poses));
        let mut locked_winches = Vec::new();
        for cocontraction in COCONTRACTIONS {
            let Some(found) = least_stable_pose(machine, laws, poses, cocontraction)? else { continue };
            let held = LockedWinches::new(machine, &found, &poses[found.index], cocontraction);
            if cocontraction == 0.0 && found.stability.rate() > machine.rules.bandwidth {
                warnings.push(format!("with locked winches, {}", held.sentence(machine, unheld.is_empty())));
            }
            locked_winches.push(held);
        }
        let underactuated = Underactuated::new(machine, poses)?;
        Ok(Self { underactuated, locked_winches, unheld: [unheld.len(), poses.len()], warnings })
    }

    /// On standard error, one per line.
    pub(super) fn print_warnings(&self) {
        for warning in &self.warnings {
            tell!("warning: {}", one_line(warning));
        }
    }

    /// A paragraph.
    pub(super) fn text(&self, machine: &Machine) -> String {
        let mut text = self.underactuated.as_ref().map_or(String::new(), Underactuated::text);
        text += "Winches held, cables sliding freely\n";
        for held in &self.locked_winches {
            text += &format!("  {}\n", held.sentence(machine, self.unheld[0] == 0));
        }
        match self.unheld {
            [0, _] => {}
            [unheld, all] if unheld == all => {
                text += "  tensions within their limits hold none of the sampled poses\n";
            }
            [unheld, all] => {
                text +=
                    &format!("  tensions within their limits do not hold {unheld} of {all} sampled poses\n");
            }
        }
        text
    }
}

/// Part of the largest motion of a cable's joints below which a joint does not take part.
const TAKES_PART: f64 = 1e-3;

impl Underactuated {
    fn new(machine: &Machine, poses: &[Vec<f64>]) -> Result<Option<Self>, Error> {
        let Some(mut equilibrium) = Equilibrium::new(&machine.robot)? else { return Ok(None) };
        let parts = machine.robot.parts();
        let joints = machine.robot.independent_joints();
        let name = |joint: usize| parts.joints[joints[joint]].name.clone();
        let (mut softest, mut tensions) =
            ((f64::INFINITY, 0, 0), vec![[f64::INFINITY, 0.0_f64]; parts.tendons.len()]);
        let mut follows = Vec::new();
        for (index, pose) in poses.iter().enumerate() {
            let mut pose = pose.clone();
            equilibrium.settle(&mut pose)?;
            let motion = equilibrium.motion();
            if let Some((stiffness, joint)) = motion.least_stiffness().filter(|(least, _)| *least < softest.0)
            {
                softest = (stiffness, joint, index);
            }
            for ([least, most], tension) in tensions.iter_mut().zip(equilibrium.tension()) {
                (*least, *most) = (least.min(*tension), most.max(*tension));
            }
            if index == 1.min(poses.len() - 1) {
                for (muscle, moved) in motion.leading().iter().zip(motion.per_length()) {
                    let largest = moved.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                    let mut taking = (0..moved.len()).filter(|&j| moved[j].abs() > TAKES_PART * largest);
                    let Some(leader) = taking.next() else { continue };
                    follows.extend(taking.map(|joint| Follows {
                        muscle: parts.tendons[*muscle].name.clone(),
                        joint: name(joint),
                        leader: name(leader),
                        ratio: moved[joint] / moved[leader],
                    }));
                }
            }
        }
        Ok(Some(Self {
            controllable: equilibrium.motion().count(),
            joints: joints.len(),
            follows,
            least_stiffness_nm_per_rad: softest.0,
            softest: name(softest.1),
            softest_pose: poses[softest.2].clone(),
            tensions_n: tensions,
        }))
    }

    /// A paragraph.
    fn text(&self) -> String {
        let Self { controllable, joints, .. } = self;
        let mut text =
            format!("Fewer motors than joints: {controllable} of {joints} coordinates are controlled\n");
        for Follows { muscle, joint, leader, ratio } in &self.follows {
            let [muscle, joint, leader] = [muscle, joint, leader].map(|name| one_line(name));
            text += &format!("  {joint} follows {} x {leader} ({muscle})\n", number(Some(*ratio)));
        }
        let least = number(Some(self.least_stiffness_nm_per_rad));
        text + &format!(
            "  least stiffness at constant lengths {least} Nm/rad, mostly of {}\n\n",
            one_line(&self.softest)
        )
    }
}

impl LockedWinches {
    fn new(machine: &Machine, found: &LeastStable, pose: &[f64], cocontraction: f64) -> Self {
        let parts = machine.robot.parts();
        let stability = &found.stability;
        Self {
            cocontraction,
            eigenvalue_per_s2: stability.eigenvalue,
            unstable_rate_per_s: stability.rate(),
            pose: pose.to_vec(),
            joint: parts.joints[machine.robot.independent_joints()[stability.joint]].name.clone(),
            muscle: match stability.cause {
                NegativeStiffness::Muscle(muscle) => Some(parts.tendons[muscle].name.clone()),
                NegativeStiffness::Gravity => None,
            },
        }
    }

    fn sentence(&self, machine: &Machine, all_held: bool) -> String {
        let tensions = if self.cocontraction == 0.0 {
            "at the minimum tensions".to_owned()
        } else {
            format!("at a co-contraction of {}", number(Some(self.cocontraction)))
        };
        if self.eigenvalue_per_s2 >= 0.0 {
            let frequency = number(Some(self.eigenvalue_per_s2.sqrt()));
            let sampled = if all_held { "sampled" } else { "held" };
            return format!(
                "{tensions} it stays in every {sampled} pose; the softest motion, mostly of `{}`, has \
                    {frequency} rad/s",
                self.joint
            );
        }
        let cause = self.muscle.as_ref().map_or(
            "gravity outweighs the stiffness of the cables".to_owned(),
            |muscle| {
                format!(
                    "the moment arm of `{muscle}` grows as it shortens; guide the cable closer to the joint, \
                    or make it shorter or stiffer"
                )
            },
        );
        let rate = number(Some(self.unstable_rate_per_s));
        let slow = self.unstable_rate_per_s <= machine.rules.bandwidth;
        let slow = if slow { ", below the bandwidth of the joints" } else { "" };
        format!(
            "{tensions} it leaves the pose {} by itself, mostly `{}`, at a rate of {rate} 1/s{slow}: {cause}",
            in_words(machine, &self.pose),
            self.joint
        )
    }
}

/// The pose in which most is missing, and the limits to look at; nothing where every pose is held.
fn too_weak(machine: &Machine, unheld: &[UnheldPose], poses: &[Vec<f64>]) -> Option<String> {
    let worst = unheld.iter().max_by(|a, b| a.missing.abs().total_cmp(&b.missing.abs()))?;
    let joint = &machine.robot.parts().joints[machine.robot.independent_joints()[worst.joint]];
    let unit = joint.kind.torque_unit();
    let [missing, needed] = [worst.missing, worst.needed].map(|torque| number(Some(torque.abs())));
    let count = if unheld.len() == poses.len() {
        "any sampled pose".to_owned()
    } else {
        format!("{} of {} sampled poses", unheld.len(), poses.len())
    };
    Some(format!(
        "muscles too weak to hold {count}: in the pose {} `{}` lacks {missing} of {needed} {unit}; the \
            limits are those of the drives and of `control_range` (anchor N from, to)",
        in_words(machine, &poses[worst.index]),
        joint.name
    ))
}

fn lost_wrap(machine: &Machine, clearance: &Clearance, pose: Option<&Vec<f64>>) -> String {
    let parts = machine.robot.parts();
    let (site, wrap) = (&parts.sites[clearance.site], &parts.wraps[clearance.wrap]);
    let moving = pose.map_or(String::new(), |pose| format!(" in the pose {}", in_words(machine, pose)));
    let millimetres = |metres: f64| number(Some(1e3 * metres));
    let beside = format!("muscle `{}`: site `{}`", parts.tendons[clearance.muscle].name, site.name);
    if clearance.least < 0.0 {
        return format!(
            "{beside} lies {} mm within the surface `{}`{moving}: the cable does not wrap it there",
            millimetres(-clearance.least),
            wrap.name
        );
    }
    format!(
        "{beside} is {} mm clear of the surface `{}`{moving}, and an attachment tolerance of {} mm moves it \
            by up to {} mm: a machine built within it may lose the wrap",
        millimetres(clearance.least),
        wrap.name,
        millimetres(machine.attachment_tolerance()),
        millimetres(clearance.displacement)
    )
}

/// The coordinates of the independent joints by name.
fn in_words(machine: &Machine, pose: &[f64]) -> String {
    let parts = machine.robot.parts();
    let joints = machine.robot.independent_joints().into_iter().zip(pose);
    let each = joints.map(|(index, at)| {
        let joint = &parts.joints[index];
        let unit = joint.kind.unit();
        format!("{} {} {unit}", joint.name, number(Some(*at)))
    });
    each.collect::<Vec<_>>().join(", ")
}
