//! A synthetic machine: two links, three cables, known positions. It only has to move as the page's contract
//! says.

use serde_json::{Value, json};

/// Points of a cable, of them in the sheath; cables; bodies with the world.
const POINTS: usize = 24;
const SHEATH: usize = 14;
const CABLES: usize = 3;
const BODIES: usize = 3;
/// Length of a link, m.
const LINK: f64 = 0.3;
const MODES: [&str; 5] = ["off", "ready", "holding", "running", "safe_stop"];

/// Fields of a state: name, type, numbers.
const LAYOUT: [(&str, &str, usize); 21] = [
    ("time_s", "f64", 1),
    ("sequence", "f64", 1),
    ("mode", "u8", 1),
    ("fault", "u16", 1),
    ("flags", "u16", 1),
    ("speed", "f64", 1),
    ("body_pose", "f32", 7 * BODIES),
    ("reference_pose", "f32", 7 * BODIES),
    ("cable_points", "f32", 3 * POINTS * CABLES),
    ("cable_tension", "f32", POINTS * CABLES),
    ("cable_sliding", "u8", POINTS * CABLES),
    ("end_point", "f64", 3),
    ("end_point_reference", "f64", 3),
    ("joint_true", "f64", 2),
    ("joint_estimated", "f64", 2),
    ("joint_reference", "f64", 2),
    ("tension_in_n", "f64", CABLES),
    ("tension_out_estimated_n", "f64", CABLES),
    ("tension_out_n", "f64", CABLES),
    ("position_in_m", "f64", CABLES),
    ("winding_true_degc", "f64", CABLES),
];

/// What commands change.
#[derive(Debug, Clone)]
pub(crate) struct Machine {
    time: f64,
    sequence: f64,
    mode: usize,
    speed: f64,
    paused: bool,
    drag: Option<[f64; 2]>,
    angles: [f64; 2],
}

impl Default for Machine {
    fn default() -> Self {
        Self {
            time: 0.0,
            sequence: 0.0,
            mode: 3,
            speed: 1.0,
            paused: false,
            drag: None,
            angles: requested(0.0),
        }
    }
}

/// Unit of a field's numbers.
fn unit(field: &str) -> &'static str {
    match field {
        "time_s" => "s",
        "position_in_m" => "rad",
        "winding_true_degc" => "degC",
        name if name.starts_with("tension") => "N",
        name if name.starts_with("joint") => "rad",
        _ => "1",
    }
}

/// The two angles of the path, rad.
fn requested(time: f64) -> [f64; 2] {
    [0.4 + 0.3 * (1.3 * time).sin(), 0.9 + 0.4 * (1.9 * time).sin()]
}

/// Poses of the links and the end point.
fn place(angles: [f64; 2]) -> ([[f64; 7]; BODIES], [f64; 3]) {
    let (mut poses, mut at, mut angle) = ([[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]; BODIES], [0.0; 3], 0.0_f64);
    for (k, turn) in angles.into_iter().enumerate() {
        angle += turn;
        poses[k + 1] = [at[0], at[1], at[2], (angle / 2.0).cos(), 0.0, -(angle / 2.0).sin(), 0.0];
        at = [at[0] + LINK * angle.sin(), 0.0, at[2] - LINK * angle.cos()];
    }
    (poses, at)
}

impl Machine {
    /// The answer to `/scene`.
    pub(crate) fn scene() -> Value {
        let muscle = |k: usize| {
            json!({"name": format!("cable_{k}"), "tension_limits_n": [2.0, 60.0], "points": POINTS,
            "sheath_points": SHEATH, "sheath": {"length_m": 0.8, "bend_rad": 2.0, "mu": 0.12}, "winch": [-0.3, 0.0, -0.2]})
        };
        let joint = |k: usize, name: &str| json!({"name": name, "unit": "rad", "range": [-1.0, 2.0], "body": k, "axis": [0.0, -1.0, 0.0], "position": [0.0, 0.0, 0.0]});
        let bone = |k: usize| json!({"body": k, "kind": "bone", "size": [0.03, 0.12, 0.0], "position": [0.0, 0.0, -0.15], "quaternion": [1.0, 0.0, 0.0, 0.0], "wrap": false});
        // At the origin of the last body, so that its drawn place can be read.
        let ball = json!({"body": 2, "kind": "ellipsoid", "size": [0.035, 0.035, 0.035], "position": [0.0, 0.0, 0.0], "quaternion": [1.0, 0.0, 0.0, 0.0], "wrap": false});
        let path: Vec<[f64; 3]> = (0..90).map(|k| place(requested(0.1 * f64::from(k))).1).collect();
        let signals: Vec<Value> = (0..CABLES).map(|k| json!({"name": format!("position_in_m:cable_{k}"), "label": "winch position", "unit": "rad", "group": "winch",
            "muscle": k, "joint": null, "field": "position_in_m", "index": k, "simulated_truth": false})).collect();
        json!({"schema": "sinew.live/1", "machine": "two_links", "source": "twin", "simulated": true, "period_s": 0.001, "gravity": [0.0, 0.0, -9.81],
            "bodies": [{"name": "world", "parent": 0}, {"name": "upper_link", "parent": 0}, {"name": "lower_link", "parent": 1}],
            "shapes": [bone(1), bone(2), ball], "joints": [joint(1, "shoulder"), joint(2, "elbow")], "muscles": (0..CABLES).map(muscle).collect::<Value>(),
            "end_point": {"body": 2, "position": [0.0, 0.0, -LINK]}, "path": path, "path_name": "tour", "paths": ["tour", "sine"], "poses": {},
            "supervisor": {"modes": MODES, "faults": {}}, "variants": ["observer"], "events": [], "recording": null, "layout_revision": 1,
            "commands": ["mode", "path", "drag", "push", "payload", "fault", "speed", "step"],
            "layout": LAYOUT.iter().map(|(name, kind, count)| json!({"name": name, "type": kind, "count": count, "unit": unit(name)})).collect::<Value>(),
            "signals": signals})
    }

    /// Takes a command; the error names what is unknown.
    pub(crate) fn command(&mut self, message: &Value) -> Result<(), String> {
        match message["command"].as_str().unwrap_or_default() {
            "mode" => {
                let request = message["request"].as_str().unwrap_or_default();
                let modes = [
                    ("turn_off", 0),
                    ("get_ready", 1),
                    ("pretension", 1),
                    ("reset", 1),
                    ("hold", 2),
                    ("run", 3),
                    ("safe_stop", 4),
                ];
                self.mode = modes
                    .iter()
                    .find(|(name, _)| *name == request)
                    .map(|(_, code)| *code)
                    .ok_or(format!("no mode {request}"))?;
            }
            "speed" => {
                self.speed = message["factor"].as_f64().unwrap_or(1.0);
                self.paused = message["paused"] == true;
            }
            "step" => self.advance(0.001),
            "drag" => self.drag = Some([0, 2].map(|k| message["position"][k].as_f64().unwrap_or(0.0))),
            "drag_end" => self.drag = None,
            "path" | "push" | "payload" | "fault" => {}
            other => return Err(format!("no command `{other}`")),
        }
        Ok(())
    }

    /// Lets time pass.
    pub(crate) fn turn(&mut self, seconds: f64) {
        self.sequence += 1.0;
        if !self.paused {
            self.advance(seconds * self.speed);
        }
    }

    fn advance(&mut self, seconds: f64) {
        self.time += seconds;
        if self.mode != 3 && self.drag.is_none() {
            return;
        }
        // The angles of a point of two equal links; a point that is too far is approached.
        let goal = self.drag.map_or(requested(self.time), |[x, z]| {
            let distance = x.hypot(z).clamp(0.05, 1.99 * LINK);
            let bend = 2.0 * (distance / (2.0 * LINK)).acos();
            [x.atan2(-z) - bend / 2.0, bend]
        });
        for (angle, goal) in self.angles.iter_mut().zip(goal) {
            *angle += (goal - *angle) * (1.0 - (-seconds / 0.05).exp());
        }
    }

    /// A message with the state, and the poses in it as the page must find them.
    pub(crate) fn message(&self) -> (Vec<u8>, Vec<f64>) {
        let (poses, end) = place(self.angles);
        let (reference, end_wanted) = place(requested(self.time));
        let mut body = Vec::new();
        let mut sent = Vec::new();
        for (name, kind, count) in LAYOUT {
            for k in 0..count {
                let value = self.number(name, k, &poses, &reference, end, end_wanted);
                match kind {
                    #[expect(clippy::cast_possible_truncation, reason = "the format's precision")]
                    "f32" => body.extend((value as f32).to_le_bytes()),
                    "f64" => body.extend(value.to_le_bytes()),
                    #[expect(
                        clippy::cast_possible_truncation,
                        clippy::cast_sign_loss,
                        reason = "small codes"
                    )]
                    "u16" => body.extend((value as u16).to_le_bytes()),
                    #[expect(
                        clippy::cast_possible_truncation,
                        clippy::cast_sign_loss,
                        reason = "small codes"
                    )]
                    _ => body.push(value as u8),
                }
                if name == "body_pose" {
                    sent.push(value);
                }
            }
        }
        (framed(1, &body), sent)
    }

    fn number(
        &self,
        name: &str,
        k: usize,
        poses: &[[f64; 7]],
        reference: &[[f64; 7]],
        end: [f64; 3],
        end_wanted: [f64; 3],
    ) -> f64 {
        let phase = |cable: usize| 1.3 * self.time + 0.9 * cable as f64;
        let near = |cable: usize| 30.0 + 20.0 * phase(cable).sin();
        let far = |cable: usize| near(cable) * (-0.24 * (3.0 * phase(cable).cos()).tanh()).exp();
        let (cable, point) = (k / POINTS, k % POINTS);
        let fraction = (point as f64 / (SHEATH - 1) as f64).min(1.0);
        match name {
            "time_s" => self.time,
            "sequence" => self.sequence,
            "mode" => self.mode as f64,
            "flags" => f64::from(u8::from(self.paused)),
            "speed" => self.speed,
            "body_pose" => poses[k / 7][k % 7],
            "reference_pose" => reference[k / 7][k % 7],
            "cable_points" => cable_point(k / 3, poses)[k % 3],
            "cable_tension" => near(cable) + fraction * (far(cable) - near(cable)),
            "cable_sliding" if fraction < 0.6 => {
                if phase(cable).cos() > 0.0 {
                    1.0
                } else {
                    2.0
                }
            }
            "end_point" => end[k],
            "end_point_reference" => end_wanted[k],
            "joint_true" | "joint_estimated" => self.angles[k],
            "joint_reference" => requested(self.time)[k],
            "tension_in_n" => near(k),
            "tension_out_estimated_n" => 1.02 * far(k),
            "tension_out_n" => far(k),
            "position_in_m" => phase(k).sin(),
            "winding_true_degc" => 30.0 + k as f64,
            _ => 0.0,
        }
    }
}

/// A point of all cables: a bow from the winch, then along the links.
fn cable_point(index: usize, poses: &[[f64; 7]]) -> [f64; 3] {
    let (cable, k) = (index / POINTS, index % POINTS);
    let side = 0.03 * (cable as f64 - 1.0);
    let winch = [-0.3, 4.0 * side, -0.25];
    let gate = [-0.02, side, 0.04];
    if k < SHEATH {
        let u = k as f64 / (SHEATH - 1) as f64;
        let bow = 0.3 * (std::f64::consts::PI * u).sin();
        return std::array::from_fn(|i| winch[i] + u * (gate[i] - winch[i]) + if i == 2 { bow } else { 0.0 });
    }
    let u = (k - SHEATH + 1) as f64 / (POINTS - SHEATH) as f64;
    let elbow = [poses[2][0], side, poses[2][2]];
    std::array::from_fn(|i| gate[i] + u * (elbow[i] - gate[i]))
}

/// A message: head and body.
pub(crate) fn framed(kind: u16, body: &[u8]) -> Vec<u8> {
    let mut message = Vec::with_capacity(16 + body.len());
    message.extend(b"SNLV");
    message.extend(1_u16.to_le_bytes());
    message.extend(kind.to_le_bytes());
    message.extend(u32::try_from(body.len()).unwrap_or(u32::MAX).to_le_bytes());
    message.extend(1_u32.to_le_bytes());
    message.extend(body);
    message
}
