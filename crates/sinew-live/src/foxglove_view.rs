//! The same machine in Foxglove: bodies, cables with their tension, all signals. It is watched there, not
//! commanded.

use crate::error::LiveError;
use crate::layout::unpack;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, FrameTransform, FrameTransforms, LinePrimitive, Point3, Pose,
    Quaternion, SceneEntity, SceneUpdate, SpherePrimitive, Timestamp, TriangleListPrimitive, Vector3,
    line_primitive,
};
use foxglove::{Channel, ChannelBuilder, Context, RawChannel, WebSocketServer, WebSocketServerHandle};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::SystemTime;

/// Pictures between two messages of poses and signals, of cables, of bodies: 30, 15 and 1 a second.
const SIGNALS_EVERY: u64 = 2;
const CABLES_EVERY: u64 = 4;
const BODIES_EVERY: u64 = 60;
const WORLD: &str = "world";
const BODY: Color = Color { r: 0.72, g: 0.72, b: 0.7, a: 1.0 };

/// A server of Foxglove's protocol beside the page; it ends when it is dropped.
pub(crate) struct FoxgloveView {
    server: Option<WebSocketServerHandle>,
    /// Its channels are known to clients as long as it lives.
    _context: Arc<Context>,
    frames: Channel<FrameTransforms>,
    bodies: Channel<SceneUpdate>,
    cables: Channel<SceneUpdate>,
    signals: Arc<RawChannel>,
    scene: Value,
    revision: Option<u32>,
    count: u64,
}

impl FoxgloveView {
    /// Listens on a loopback address: the protocol knows no token.
    ///
    /// # Errors
    /// [`LiveError::Foxglove`].
    pub(crate) fn start(address: SocketAddr) -> Result<Self, LiveError> {
        let refused = |reason: String| LiveError::Foxglove { address, reason };
        if !address.ip().is_loopback() {
            let reason = "expected a loopback address: Foxglove's protocol knows no token";
            return Err(refused(reason.to_owned()));
        }
        let context = Context::new();
        let scene = |topic: &str| ChannelBuilder::new(topic).context(&context).build::<SceneUpdate>();
        let (bodies, cables) = (scene("/sinew/bodies"), scene("/sinew/cables"));
        let frames = ChannelBuilder::new("/tf").context(&context).build::<FrameTransforms>();
        let signals = ChannelBuilder::new("/sinew/signals").message_encoding("json").context(&context);
        let signals = signals.build_raw().map_err(|error| refused(error.to_string()))?;
        let server = WebSocketServer::new().name("sinew").context(&context);
        let server = server.bind(address.ip().to_string(), address.port()).start_blocking();
        let server = Some(server.map_err(|error| refused(error.to_string()))?);
        Ok(Self {
            server,
            _context: context,
            frames,
            bodies,
            cables,
            signals,
            scene: Value::Null,
            revision: None,
            count: 0,
        })
    }

    /// Where it listens.
    pub(crate) fn port(&self) -> u16 {
        self.server.as_ref().map_or(0, WebSocketServerHandle::port)
    }

    /// Shows a picture: the scene's answer and its newest state message.
    pub(crate) fn show(&mut self, revision: u32, scene: &str, state: &[u8]) {
        if self.server.as_ref().is_none_or(|server| server.client_count() == 0) {
            return;
        }
        if self.revision != Some(revision) {
            self.scene = serde_json::from_str(scene).unwrap_or_default();
            self.revision = Some(revision);
            self.count = 0;
        }
        let due = |every: u64| self.count.is_multiple_of(every);
        let (signals, cables, bodies) = (due(SIGNALS_EVERY), due(CABLES_EVERY), due(BODIES_EVERY));
        self.count += 1;
        let fields = unpack(&self.scene["layout"], state.get(16..).unwrap_or_default());
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let now = Timestamp::new(u32::try_from(now.as_secs()).unwrap_or(u32::MAX), now.subsec_nanos());
        if bodies {
            self.bodies.log(&self.body_shapes(now));
        }
        if signals {
            self.frames.log(&self.poses(&fields, now));
            self.signals.log(self.values(&fields).to_string().as_bytes());
        }
        if cables {
            self.cables.log(&self.cable_lines(&fields, now));
        }
    }

    fn names(&self, list: &str) -> Vec<&str> {
        let names = self.scene[list].as_array().into_iter().flatten();
        names.map(|item| item["name"].as_str().unwrap_or_default()).collect()
    }

    fn poses(&self, fields: &BTreeMap<String, Vec<f64>>, now: Timestamp) -> FrameTransforms {
        let poses = fields.get("body_pose").map_or(&[][..], Vec::as_slice);
        let named = self.names("bodies").into_iter().zip(poses.chunks_exact(7)).skip(1);
        let transform = |(name, pose): (&str, &[f64])| FrameTransform {
            timestamp: Some(now),
            parent_frame_id: WORLD.to_owned(),
            child_frame_id: name.to_owned(),
            translation: Some(Vector3 { x: pose[0], y: pose[1], z: pose[2] }),
            rotation: Some(Quaternion { w: pose[3], x: pose[4], y: pose[5], z: pose[6] }),
        };
        FrameTransforms { transforms: named.map(transform).collect() }
    }

    /// Time, mode, fault, end point, and what is known of every joint and muscle by its name.
    fn values(&self, fields: &BTreeMap<String, Vec<f64>>) -> Value {
        let supervisor = &self.scene["supervisor"];
        let number = |name: &str| fields.get(name).and_then(|values| values.first()).copied().unwrap_or(0.0);
        let mut all = Map::new();
        all.insert("simulated".to_owned(), self.scene["simulated"].clone());
        all.insert("mode".to_owned(), supervisor["modes"][number("mode") as usize].clone());
        all.insert(
            "fault".to_owned(),
            supervisor["faults"][(number("fault") as u16).to_string()]["kind"].clone(),
        );
        let (joints, muscles) = (self.names("joints"), self.names("muscles"));
        for (name, values) in fields {
            let named = |names: &[&str]| -> Value {
                names
                    .iter()
                    .zip(values)
                    .map(|(name, value)| ((*name).to_owned(), json!(value)))
                    .collect::<Map<_, _>>()
                    .into()
            };
            let value = match name.as_str() {
                "mode" | "fault" | "fault_index" | "flags" | "sequence" => continue,
                name if name.starts_with("cable_") || name.contains("_pose") => continue,
                name if name.starts_with("joint") => named(&joints),
                name if name.starts_with("end_point") => named(&["x", "y", "z"]),
                _ if values.len() == 1 => json!(values[0]),
                _ => named(&muscles),
            };
            all.insert(name.clone(), value);
        }
        Value::Object(all)
    }

    /// A line a cable, coloured from blue without tension to red at the muscle's limit.
    fn cable_lines(&self, fields: &BTreeMap<String, Vec<f64>>, now: Timestamp) -> SceneUpdate {
        let of = |name: &str| fields.get(name).map_or(&[][..], Vec::as_slice);
        let (mut points, mut tensions) = (of("cable_points").chunks_exact(3), of("cable_tension").iter());
        let muscles = self.scene["muscles"].as_array().into_iter().flatten();
        let line = |muscle: &Value| {
            let count = muscle["points"].as_u64().unwrap_or(0) as usize;
            let highest = muscle["tension_limits_n"][1].as_f64().filter(|n| *n > 0.0).unwrap_or(1.0);
            let at = points.by_ref().take(count).map(|p| Point3 { x: p[0], y: p[1], z: p[2] });
            let at: Vec<Point3> = at.collect();
            let colour = |tension: &f64| {
                let fraction = (tension / highest).clamp(0.0, 1.0);
                let fraction = if fraction.is_finite() { fraction } else { 0.0 };
                Color { r: fraction, g: 0.3, b: 1.0 - fraction, a: 1.0 }
            };
            LinePrimitive {
                r#type: line_primitive::Type::LineStrip as i32,
                thickness: 3.0,
                scale_invariant: true,
                colors: tensions.by_ref().take(at.len()).map(colour).collect(),
                points: at,
                ..LinePrimitive::default()
            }
        };
        let entity = SceneEntity { lines: muscles.map(line).collect(), ..entity("cables", WORLD, now) };
        SceneUpdate { deletions: Vec::new(), entities: vec![entity] }
    }

    /// The shapes of every body in its frame; surfaces that cables wrap are left out.
    fn body_shapes(&self, now: Timestamp) -> SceneUpdate {
        let shapes: Vec<&Value> = self.scene["shapes"].as_array().into_iter().flatten().collect();
        let of_body = |(k, name): (usize, &str)| {
            let mut entity = entity(&format!("body {name}"), if k == 0 { WORLD } else { name }, now);
            for shape in shapes.iter().filter(|shape| shape["body"] == k && shape["wrap"] != true) {
                add(&mut entity, shape, &self.scene["meshes"]);
            }
            entity
        };
        let entities = self.names("bodies").into_iter().enumerate().map(of_body);
        SceneUpdate { deletions: Vec::new(), entities: entities.collect() }
    }
}

impl Drop for FoxgloveView {
    fn drop(&mut self) {
        if let Some(server) = self.server.take() {
            server.stop().wait_blocking();
        }
    }
}

fn entity(id: &str, frame: &str, now: Timestamp) -> SceneEntity {
    SceneEntity {
        timestamp: Some(now),
        frame_id: frame.to_owned(),
        id: id.to_owned(),
        frame_locked: true,
        ..SceneEntity::default()
    }
}

/// Triangles of a mesh of the scene: corners, and three indices each.
fn triangles(mesh: &Value) -> Option<(Vec<Point3>, Vec<u32>)> {
    let bytes = |name: &str| STANDARD.decode(mesh[name].as_str()?).ok();
    let number =
        |four: &[u8]| <[u8; 4]>::try_from(four).map_or(f64::NAN, |four| f32::from_le_bytes(four).into());
    let numbers: Vec<f64> = bytes("vertices")?.chunks_exact(4).map(number).collect();
    let corners = numbers.chunks_exact(3).map(|p| Point3 { x: p[0], y: p[1], z: p[2] });
    let indices = bytes("triangles")?;
    let indices = indices.chunks_exact(2).map(|two| u32::from(u16::from_le_bytes([two[0], two[1]])));
    Some((corners.collect(), indices.collect()))
}

/// Adds a shape of the scene to an entity.
fn add(entity: &mut SceneEntity, shape: &Value, meshes: &Value) {
    let number = |value: &Value| value.as_f64().unwrap_or(0.0);
    let three = |list: &Value| [0, 1, 2].map(|k| number(&list[k]));
    let [x, y, z] = three(&shape["position"]);
    let turn = &shape["quaternion"];
    let [qw, qx, qy, qz] = [0, 1, 2, 3].map(|k| number(&turn[k]));
    let pose = Some(Pose {
        position: Some(Vector3 { x, y, z }),
        orientation: Some(Quaternion { x: qx, y: qy, z: qz, w: qw }),
    });
    let [a, b, c] = three(&shape["size"]);
    let size = |x: f64, y: f64, z: f64| Some(Vector3 { x: 2.0 * x, y: 2.0 * y, z: 2.0 * z });
    let color = Some(BODY);
    match shape["kind"].as_str() {
        Some("sphere") => entity.spheres.push(SpherePrimitive { pose, size: size(a, a, a), color }),
        Some("ellipsoid") => entity.spheres.push(SpherePrimitive { pose, size: size(a, b, c), color }),
        Some("box") => entity.cubes.push(CubePrimitive { pose, size: size(a, b, c), color }),
        Some("cylinder" | "capsule" | "bone") => entity.cylinders.push(CylinderPrimitive {
            pose,
            size: size(a, a, b),
            bottom_scale: 1.0,
            top_scale: 1.0,
            color,
        }),
        Some("mesh") => {
            let mesh = shape["mesh"].as_u64().and_then(|k| triangles(&meshes[usize::try_from(k).ok()?]));
            if let Some((points, indices)) = mesh {
                entity.triangles.push(TriangleListPrimitive {
                    pose,
                    points,
                    color,
                    indices,
                    ..Default::default()
                });
            }
        }
        _ => {}
    }
}
