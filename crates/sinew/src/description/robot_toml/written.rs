//! The file as written: keys and types; values are validated later.

use crate::description::domain::LARGEST;
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use serde::Deserialize;
use toml::Spanned;

/// A finite number: TOML also has `nan` and `inf`.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(try_from = "f64")]
pub(super) struct Finite(pub(super) f64);

impl TryFrom<f64> for Finite {
    type Error = &'static str;

    fn try_from(value: f64) -> Result<Finite, &'static str> {
        if !value.is_finite() {
            Err("expected a finite number")
        } else if value.abs() > LARGEST {
            Err("expected a number of magnitude up to 1e12")
        } else {
            Ok(Finite(value))
        }
    }
}

/// As many numbers as expected: an array alone would ignore those beyond its length.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(try_from = "Vec<Finite>")]
pub(super) struct Numbers<const N: usize>(pub(super) [f64; N]);

impl<const N: usize> TryFrom<Vec<Finite>> for Numbers<N> {
    type Error = String;

    fn try_from(list: Vec<Finite>) -> Result<Self, String> {
        let numbers: Vec<f64> = list.into_iter().map(|number| number.0).collect();
        numbers.try_into().map(Self).map_err(|_| format!("expected {N} numbers"))
    }
}

pub(super) type Vector<const N: usize> = Option<Numbers<N>>;

/// `[xx, yy, zz]` or `[xx, yy, zz, xy, xz, yz]`.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(try_from = "Vec<Finite>")]
pub(super) struct Inertia(pub(super) [f64; 6]);

impl TryFrom<Vec<Finite>> for Inertia {
    type Error = &'static str;

    fn try_from(list: Vec<Finite>) -> Result<Self, &'static str> {
        let numbers: Vec<f64> = list.into_iter().map(|number| number.0).collect();
        match numbers[..] {
            [xx, yy, zz] => Ok(Self([xx, yy, zz, 0.0, 0.0, 0.0])),
            [xx, yy, zz, xy, xz, yz] => Ok(Self([xx, yy, zz, xy, xz, yz])),
            _ => Err("expected 3 or 6 numbers"),
        }
    }
}

/// Its keys are checked by name before: those of a machine file may stand beside these.
#[derive(Debug, Deserialize)]
pub(super) struct File {
    #[serde(default)]
    pub(super) name: String,
    pub(super) gravity_m_per_s2: Vector<3>,
    #[serde(default)]
    pub(super) body: Vec<Spanned<Body>>,
    #[serde(default)]
    pub(super) joint: Vec<Spanned<Joint>>,
    #[serde(default)]
    pub(super) site: Vec<Spanned<Site>>,
    #[serde(default)]
    pub(super) wrap: Vec<Spanned<Wrap>>,
    #[serde(default)]
    pub(super) geom: Vec<Spanned<Geom>>,
    #[serde(default)]
    pub(super) muscle: Vec<Spanned<Muscle>>,
    #[serde(default)]
    pub(super) coupling: Vec<Spanned<Coupling>>,
    #[serde(default)]
    pub(super) actuator: Vec<Spanned<Actuator>>,
    #[serde(default)]
    pub(super) key: Vec<Spanned<Key>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Body {
    pub(super) name: String,
    pub(super) parent: Option<String>,
    pub(super) position_m: Vector<3>,
    pub(super) orientation_wxyz: Vector<4>,
    pub(super) mass_kg: Option<Finite>,
    pub(super) center_of_mass_m: Vector<3>,
    pub(super) inertia_kg_m2: Option<Inertia>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum JointKind {
    Hinge,
    Slide,
    Ball,
    Free,
}

/// Keys in `rad` and `nm` belong to hinges and balls, those in `m` and `n` to slides.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Joint {
    pub(super) name: String,
    pub(super) body: String,
    pub(super) kind: JointKind,
    pub(super) anchor_m: Vector<3>,
    pub(super) axis: Vector<3>,
    pub(super) reference_rad: Option<Finite>,
    pub(super) reference_m: Option<Finite>,
    pub(super) range_rad: Vector<2>,
    pub(super) range_m: Vector<2>,
    pub(super) armature_kg_m2: Option<Finite>,
    pub(super) armature_kg: Option<Finite>,
    pub(super) damping_nm_s_per_rad: Option<Finite>,
    pub(super) damping_n_s_per_m: Option<Finite>,
    pub(super) friction_nm: Option<Finite>,
    pub(super) friction_n: Option<Finite>,
    pub(super) stiffness_nm_per_rad: Option<Finite>,
    pub(super) stiffness_n_per_m: Option<Finite>,
    pub(super) spring_reference_rad: Option<Finite>,
    pub(super) spring_reference_m: Option<Finite>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Site {
    pub(super) name: String,
    pub(super) body: String,
    pub(super) position_m: Vector<3>,
    pub(super) orientation_wxyz: Vector<4>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum WrapKind {
    Sphere,
    Cylinder,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Wrap {
    pub(super) name: String,
    pub(super) body: String,
    pub(super) kind: WrapKind,
    pub(super) radius_m: Finite,
    pub(super) position_m: Vector<3>,
    pub(super) orientation_wxyz: Vector<4>,
}

/// A shape of a body for drawings: with `ends_m` along the line between these points, else at `position_m`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Geom {
    pub(super) body: String,
    /// `sphere`, `capsule`, `cylinder`, `ellipsoid` or `box`.
    pub(super) kind: String,
    /// Radius; radius and half length; half lengths. With `ends_m` without the length.
    pub(super) size_m: Vec<Finite>,
    /// Both ends of a capsule or cylinder: x, y, z, x, y, z.
    pub(super) ends_m: Vector<6>,
    pub(super) position_m: Vector<3>,
    pub(super) orientation_wxyz: Vector<4>,
}

/// One of `site`, `wrap` (with `side`, if the side matters), `pulley`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PathElement {
    pub(super) site: Option<String>,
    pub(super) wrap: Option<String>,
    pub(super) side: Option<String>,
    pub(super) pulley: Option<Finite>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Term {
    pub(super) joint: String,
    pub(super) coefficient: Finite,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Sheath {
    pub(super) length_m: Finite,
    pub(super) bend_rad: Finite,
    pub(super) end_axis: Vector<3>,
}

/// Spatial with a `path`, or fixed with a weighted sum of `joints`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Muscle {
    pub(super) name: String,
    pub(super) path: Option<Vec<PathElement>>,
    pub(super) joints: Option<Vec<Term>>,
    pub(super) sheath: Option<Sheath>,
    pub(super) length_range_m: Vector<2>,
    pub(super) damping_n_s_per_m: Option<Finite>,
    pub(super) stiffness_n_per_m: Option<Finite>,
    pub(super) spring_length_m: Vector<2>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Coupling {
    pub(super) follower: String,
    pub(super) leader: Option<String>,
    pub(super) coefficients: Numbers<5>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Actuator {
    pub(super) name: String,
    pub(super) muscle: String,
    /// The MJCF element: `motor`, `muscle`, `general`...
    pub(super) kind: String,
    /// Force at the muscle per unit of control; negative for a pulling force.
    pub(super) gear: Finite,
    /// For a motor of gear -1 the limits of the tension at the anchor, N.
    pub(super) control_range: Vector<2>,
    pub(super) force_range_n: Vector<2>,
    /// Gain, bias and dynamics as MJCF's attributes.
    #[serde(default)]
    pub(super) law: BTreeMap<String, String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Key {
    pub(super) name: String,
    /// All coordinates, joints in order, rad or m; quaternions `[w, x, y, z]`.
    pub(super) q: Vec<Finite>,
}
