//! Surfaces that muscles wrap around. OpenSim tries every surface of a path on every piece of it; here a
//! surface stands between two points: the piece that runs into it, over poses of the whole range.

use super::model::{self, Model, inverse, objects};
use crate::body::{Parts, PathElement, Poses, Robot, Site, TendonPath, Wrap, WrapKind};
use crate::description::attributes::{Attributes, shortened};
use crate::description::error::DescriptionError;
use crate::description::mjcf::Place;
use crate::description::orientation::{self, IDENTITY, dot};
use crate::muscle::{Geometry, Muscles};
use alloc::collections::BTreeMap;
use alloc::collections::btree_map::Entry;
use alloc::format;
use alloc::vec;
use alloc::vec::Vec;
use libm::cbrt;

/// A surface that a path may wrap around between two of its points.
pub(super) struct Around<'a> {
    pub(super) at: Attributes<'a>,
    pub(super) tendon: usize,
    pub(super) first: usize,
    pub(super) last: usize,
}

/// A surface of the file.
#[derive(Clone, Copy)]
struct Surface<'a> {
    at: Attributes<'a>,
    body: usize,
    place: Place,
    kind: WrapKind,
    radius: f64,
    /// Smallest and largest half axis of an ellipsoid.
    bounds: Option<[f64; 2]>,
    /// Half the length of a cylinder.
    half: f64,
    /// Direction of the side on which cables pass.
    side: Option<[f64; 3]>,
}

/// Poses in which paths are tried.
const POSES: usize = 256;

/// Places all surfaces in the paths.
pub(super) fn place<'a>(model: &mut Model<'a>, arounds: &[Around<'a>]) -> Result<(), DescriptionError> {
    if arounds.is_empty() {
        return Ok(());
    }
    let surfaces = surfaces(model)?;
    let mut wanted = Vec::new();
    for around in arounds {
        let name = around.at.required("wrap_object")?;
        let found = surfaces.get(name.rsplit('/').next().unwrap_or_default());
        let missing = || {
            around.at.error("wrap_object", format!("is `{name}`, but there is no wrap object of that name"))
        };
        if let Some(surface) = found.ok_or_else(missing)? {
            wanted.push((around, *surface));
        }
    }
    // An invalid robot is refused when all is read.
    let Ok(robot) = Robot::new(model.parts.clone()) else { return Ok(()) };
    let poses = tried(&robot);
    let mut votes: Vec<([usize; 3], usize, usize)> = Vec::new();
    for (index, (around, surface)) in wanted.iter().enumerate() {
        let TendonPath::Spatial(path) = &robot.parts().tendons[around.tendon].path else { continue };
        let mut cut = vec![[0_usize; 3]; path.len()];
        for (q, poses) in &poses {
            count(&robot, poses, q, path, around, surface, &mut cut);
        }
        let best = cut.iter().max().copied().unwrap_or_default();
        let lost = 100.0 * best[2] as f64 / poses.len().max(1) as f64;
        if best[..2] == [0, 0] {
            let what = "a <PathWrap> whose surface no pose tried brings into the way of its path is left out";
            model.left_out(around.at.element, "idle wrap", what, false);
        }
        let passed = |site: Option<&PathElement>| matches!(site, Some(PathElement::Site(site)) if robot.parts().sites[*site].active.is_some());
        let beside = cut.iter().position(|cut| *cut == best).unwrap_or_default();
        if best[..2] != [0, 0] && (passed(path.get(beside)) || passed(path.get(beside + 1))) {
            let what =
                "a <PathWrap> beside a <ConditionalPathPoint> is not read: its path goes straight there";
            model.left_out(around.at.element, "wrap beside a condition", what, true);
            continue;
        }
        // Behind a surface with a side every piece would be pulled to that side.
        let chosen = cut.iter().enumerate().filter(|(_, cut)| match surface.side {
            Some(_) => **cut == best && best[..2] != [0, 0],
            None => cut[0] > 0,
        });
        let chosen = chosen.filter(|(piece, _)| !passed(path.get(*piece)) && !passed(path.get(piece + 1)));
        if lost > 0.0 {
            let what = format!(
                "OpenSim pulls `{}` to the side of `{}` in {lost:.0} % of the poses tried where it goes straight here",
                model.parts.tendons[around.tendon].name,
                surface.at.text("name").unwrap_or_default()
            );
            model.left_out(around.at.element, &what, &what, false);
        }
        let chosen = chosen.map(|(piece, cut)| (*cut, index, piece)).collect::<Vec<_>>();
        votes.extend(if surface.side.is_some() { &chosen[..chosen.len().min(1)] } else { &chosen[..] });
    }
    // The surface that is in the way most often comes first: between two points there is place for one.
    votes.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut taken: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    let mut second = Vec::new();
    for (_, index, piece) in votes {
        let key = (wanted[index].0.tendon, piece);
        match taken.entry(key) {
            Entry::Occupied(_) => second.push((key, index)),
            Entry::Vacant(free) => {
                free.insert(index);
            }
        }
    }
    let before = model.parts.clone();
    put(model, &wanted, &taken);
    for (key, index) in second {
        let mut other = taken.clone();
        let first = other.insert(key, index).unwrap_or(index);
        let with_first = core::mem::replace(&mut model.parts, before.clone());
        put(model, &wanted, &other);
        let with_other = core::mem::replace(&mut model.parts, with_first);
        let off = differences(&model.parts, &with_other, &poses).map_or(0.0, |all| all[key.0]);
        let name = |index: usize| wanted[index].1.at.text("name").unwrap_or_default();
        let what = format!(
            "`{}` wraps around `{}` and `{}` between the same points, where there is place for one: it \
             goes around the first; around the second alone its length would differ by up to {:.2} mm",
            model.parts.tendons[key.0].name,
            name(first),
            name(index),
            1e3 * off
        );
        model.left_out(wanted[index].0.at.element, &what, &what, false);
    }
    ellipsoids(model, &surfaces, &poses);
    Ok(())
}

/// Puts surfaces into pieces of paths.
fn put(
    model: &mut Model<'_>,
    wanted: &[(&Around<'_>, Surface<'_>)],
    taken: &BTreeMap<(usize, usize), usize>,
) {
    for (&(tendon, piece), &index) in taken.iter().rev() {
        let element = add(model, &wanted[index].1);
        if let TendonPath::Spatial(path) = &mut model.parts.tendons[tendon].path {
            path.insert(piece + 1, element);
        }
    }
}

/// Largest difference of the length of every path between two robots.
fn differences(first: &Parts, second: &Parts, poses: &[(Vec<f64>, Poses)]) -> Option<Vec<f64>> {
    let lengths = |parts: &Parts| {
        let robot = Robot::new(parts.clone()).ok()?;
        let muscles = Muscles::new(&robot);
        let mut geometry = Geometry::new(&robot, &muscles);
        let read = |(q, _): &(Vec<f64>, Poses)| {
            muscles.evaluate(q, &mut geometry).map(|()| geometry.lengths().to_vec())
        };
        poses.iter().map(read).collect::<Result<Vec<_>, _>>().ok()
    };
    let mut most = vec![0.0_f64; first.tendons.len()];
    for (first, second) in lengths(first)?.iter().zip(&lengths(second)?) {
        for (most, (first, second)) in most.iter_mut().zip(first.iter().zip(second)) {
            *most = most.max((second - first).abs());
        }
    }
    Some(most)
}

/// All surfaces by name; `None`: not read, or not active.
fn surfaces<'a>(model: &mut Model<'a>) -> Result<BTreeMap<&'a str, Option<Surface<'a>>>, DescriptionError> {
    let mut surfaces = BTreeMap::new();
    for (body, element) in model.bodies.clone() {
        for at in objects(model.tree, element, "WrapObjectSet") {
            surfaces.insert(at.required("name")?, surface(model, at, model.placed[body])?);
        }
    }
    Ok(surfaces)
}

fn surface<'a>(
    model: &mut Model<'a>,
    at: Attributes<'a>,
    body: usize,
) -> Result<Option<Surface<'a>>, DescriptionError> {
    let radius = |key: &str, value: f64| match value {
        value if value > 0.0 => Ok(value),
        value => Err(at.error(key, format!("is {value}: expected a number > 0"))),
    };
    let one = || radius("radius", at.number_or("radius", 0.0)?);
    let kind = model.tree.elements[at.element].name.as_str();
    let (kind, radius, bounds) = match kind {
        "WrapCylinder" => (WrapKind::Cylinder, one()?, None),
        "WrapSphere" => (WrapKind::Sphere, one()?, None),
        "WrapEllipsoid" => {
            let [a, b, c] = at.array_or("dimensions", [0.0; 3])?;
            let least = radius("dimensions", a.min(b).min(c))?;
            (WrapKind::Sphere, cbrt(a * b * c), Some([least, a.max(b).max(c)]))
        }
        _ => {
            let what = format!("<{}> is not read: cables pass it by", shortened(kind));
            model.left_out(at.element, kind, &what, true);
            return Ok(None);
        }
    };
    let side = match at.text("quadrant").unwrap_or("all").trim_start_matches('+') {
        "all" | "unassigned" | "" => None,
        text => {
            let axis = ["x", "y", "z"].iter().position(|axis| *axis == text.trim_start_matches('-'));
            let expected = || {
                at.error("quadrant", format!("is `{}`: expected x, y, z, -x, -y, -z or all", shortened(text)))
            };
            let (axis, sign) = (axis.ok_or_else(expected)?, if text.starts_with('-') { -1.0 } else { 1.0 });
            Some(core::array::from_fn(|k| if k == axis { sign } else { 0.0 }))
        }
    };
    // The axis of a cylinder is no side of it.
    let side = side.filter(|side: &[f64; 3]| kind == WrapKind::Sphere || side[2] == 0.0);
    let active = at.flag("active", true)?;
    let half = if kind == WrapKind::Cylinder { at.number_or("length", 1.0)? / 2.0 } else { f64::INFINITY };
    let place = model::place(at, "xyz_body_rotation")?;
    Ok(active.then_some(Surface { at, body, place, kind, radius, bounds, half, side }))
}

/// Poses over the ranges of all joints.
fn tried(robot: &Robot) -> Vec<(Vec<f64>, Poses)> {
    let ranges: Vec<[f64; 2]> = robot
        .independent_joints()
        .iter()
        .map(|&joint| robot.parts().joints[joint].range.unwrap_or([0.0; 2]))
        .collect();
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut found = Vec::new();
    for _ in 0..POSES {
        let x: Vec<f64> = ranges.iter().map(|[low, high]| low + (high - low) * random()).collect();
        let mut poses = Poses::new(robot);
        if let Ok(q) = robot.pose_from_independent(&x)
            && robot.forward_kinematics(&q, &mut poses).is_ok()
        {
            found.push((q, poses));
        }
    }
    found
}

/// Counts for every piece of a path whether it runs into the surface, and whether it passes it on the wrong
/// side.
fn count(
    robot: &Robot,
    poses: &Poses,
    q: &[f64],
    path: &[PathElement],
    around: &Around<'_>,
    surface: &Surface<'_>,
    cut: &mut [[usize; 3]],
) {
    let body = robot.body_pose(poses, surface.body);
    let back = inverse(surface.place);
    let mut before: Option<(usize, [f64; 3])> = None;
    for (index, element) in path.iter().enumerate().take(around.last + 1).skip(around.first) {
        let PathElement::Site(site) = *element else { continue };
        let open = robot.parts().sites[site]
            .active
            .is_none_or(|(joint, [low, high])| (low..=high).contains(&q[robot.coordinates_of(joint).start]));
        if !open {
            continue;
        }
        let seen = back.point(body.local(robot.site_pose(poses, site).origin));
        if let Some((piece, start)) = before.replace((index, seen)) {
            let met = surface.meets(start, seen);
            cut[piece].iter_mut().zip(met).for_each(|(count, met)| *count += usize::from(met));
        }
    }
}

impl Surface<'_> {
    /// Whether a line between two points in its frame runs into it, whether it passes it on the wrong
    /// side, and whether OpenSim alone pulls it to the other.
    fn meets(&self, a: [f64; 3], b: [f64; 3]) -> [bool; 3] {
        let flat =
            |[x, y, z]: [f64; 3]| if self.kind == WrapKind::Cylinder { [x, y, 0.0] } else { [x, y, z] };
        let (e, way) = (flat(a), flat([b[0] - a[0], b[1] - a[1], b[2] - a[2]]));
        let squared = self.radius * self.radius;
        if dot(e, e) < squared || dot(flat(b), flat(b)) < squared || dot(way, way) == 0.0 {
            return [false; 3];
        }
        let t = -dot(e, way) / dot(way, way);
        let near: [f64; 3] = core::array::from_fn(|k| e[k] + t * way[k]);
        let along = a[2] + t * (b[2] - a[2]);
        let inner = t > 0.0 && t < 1.0 && along.abs() <= self.half;
        let hit = inner && dot(near, near) < squared;
        let Some(side) = self.side else { return [hit, false, false] };
        let beside = dot(side, near) < 0.0;
        // OpenSim pulls a line to the side; here that needs a side within half a turn of both ends.
        let [f, cross] = [flat(b), orientation::cross(e, flat(b))];
        let off = [dot(side, e) < 0.0, dot(side, f) < 0.0];
        let pulled = if off[0] && off[1] { true } else { off[0] != off[1] && beside };
        let turns = |a, b| dot(orientation::cross(a, b), cross) < 0.0;
        let kept = turns(e, side) && turns(side, f);
        [hit, inner && beside, !hit && pulled && !kept]
    }
}

/// The surface and its side among the parts, added where they are not there yet.
fn add(model: &mut Model<'_>, surface: &Surface<'_>) -> PathElement {
    let name = surface.at.text("name").unwrap_or_default();
    let known = model.parts.wraps.iter().position(|wrap| wrap.name == name);
    let wrap = known.unwrap_or_else(|| {
        let Surface { body, place: Place { position, orientation }, kind, radius, .. } = *surface;
        model.describe("wrap", model.parts.wraps.len(), surface.at.element);
        model.parts.wraps.push(Wrap { name: name.into(), body, kind, radius, position, orientation });
        model.parts.wraps.len() - 1
    });
    let side = surface.side.map(|side| {
        let name = format!("{name}:side");
        let known = model.parts.sites.iter().position(|site| site.name == name);
        known.unwrap_or_else(|| {
            let position = surface.place.point(side.map(|x| 2.0 * surface.radius * x));
            model.parts.sites.push(Site {
                name,
                body: surface.body,
                position,
                orientation: IDENTITY,
                active: None,
            });
            model.parts.sites.len() - 1
        })
    });
    PathElement::Wrap { wrap, side }
}

/// Warns of ellipsoids that spheres of the same volume stand for.
fn ellipsoids(
    model: &mut Model<'_>,
    surfaces: &BTreeMap<&str, Option<Surface<'_>>>,
    poses: &[(Vec<f64>, Poses)],
) {
    let bounds = |name: &str| surfaces.get(name).copied().flatten().and_then(|surface| surface.bounds);
    let Some(first) = model.parts.wraps.iter().find(|wrap| bounds(&wrap.name).is_some()) else { return };
    let element = surfaces[first.name.as_str()].map_or(0, |surface| surface.at.element);
    let of = |end: usize| {
        let mut parts = model.parts.clone();
        for wrap in &mut parts.wraps {
            wrap.radius = bounds(&wrap.name).map_or(wrap.radius, |bounds| bounds[end]);
        }
        parts
    };
    let off = differences(&of(0), &of(1), poses).unwrap_or_default();
    let Some((muscle, most)) = off.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)) else { return };
    let what = format!(
        "spheres of the same volume stand for ellipsoids: lengths around spheres of their smallest and \
            largest half axes differ by up to {:.2} mm (`{}`)",
        1e3 * most,
        model.parts.tendons[muscle].name
    );
    model.left_out(element, "ellipsoid", &what, false);
}
