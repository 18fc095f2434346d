//! Messages of a recording; `schemas/` describes them.

use prost::Message;

/// See `schemas/sinew/record.proto`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct BlockMessage {
    #[prost(uint64, tag = "1")]
    pub(crate) first: u64,
    #[prost(uint32, tag = "2")]
    pub(crate) count: u32,
    #[prost(message, repeated, tag = "3")]
    pub(crate) fast: Vec<Column>,
    #[prost(message, repeated, tag = "4")]
    pub(crate) slow: Vec<Column>,
    #[prost(bytes = "vec", tag = "5")]
    pub(crate) cycle_checks: Vec<u8>,
    #[prost(fixed32, repeated, tag = "6")]
    pub(crate) command_checks: Vec<u32>,
    #[prost(fixed32, repeated, tag = "7")]
    pub(crate) reference_checks: Vec<u32>,
    #[prost(uint64, tag = "8")]
    pub(crate) dropped: u64,
    #[prost(message, repeated, tag = "9")]
    pub(crate) link: Vec<LinkInput>,
    #[prost(uint64, tag = "10")]
    pub(crate) dropped_link: u64,
    #[prost(uint32, repeated, tag = "11")]
    pub(crate) grids: Vec<u32>,
}

/// See `schemas/sinew/record.proto`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct LinkInput {
    #[prost(uint64, tag = "1")]
    pub(crate) at_ns: u64,
    #[prost(bytes = "vec", tag = "2")]
    pub(crate) command: Vec<u8>,
}

/// See `schemas/sinew/record.proto`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct Column {
    #[prost(sint64, tag = "1")]
    pub(crate) first: i64,
    #[prost(uint32, tag = "2")]
    pub(crate) mode: u32,
    #[prost(bytes = "vec", tag = "3")]
    pub(crate) residuals: Vec<u8>,
}

/// `google.protobuf.Timestamp`.
#[derive(Clone, Copy, PartialEq, Message)]
pub(crate) struct Timestamp {
    #[prost(int64, tag = "1")]
    pub(crate) seconds: i64,
    #[prost(int32, tag = "2")]
    pub(crate) nanos: i32,
}

impl Timestamp {
    /// From ns since the epoch.
    pub(crate) fn from_ns(ns: u64) -> Self {
        Self { seconds: (ns / 1_000_000_000).cast_signed(), nanos: (ns % 1_000_000_000) as i32 }
    }
}

/// `foxglove.Vector3` and `foxglove.Point3`.
#[derive(Clone, Copy, PartialEq, Message)]
pub(crate) struct Vector3 {
    #[prost(double, tag = "1")]
    pub(crate) x: f64,
    #[prost(double, tag = "2")]
    pub(crate) y: f64,
    #[prost(double, tag = "3")]
    pub(crate) z: f64,
}

impl Vector3 {
    /// From x, y, z.
    pub(crate) fn from_array([x, y, z]: [f64; 3]) -> Self {
        Self { x, y, z }
    }
}

/// `foxglove.Quaternion`.
#[derive(Clone, Copy, PartialEq, Message)]
pub(crate) struct Quaternion {
    #[prost(double, tag = "1")]
    pub(crate) x: f64,
    #[prost(double, tag = "2")]
    pub(crate) y: f64,
    #[prost(double, tag = "3")]
    pub(crate) z: f64,
    #[prost(double, tag = "4")]
    pub(crate) w: f64,
}

/// `foxglove.FrameTransform`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct FrameTransform {
    #[prost(message, optional, tag = "1")]
    pub(crate) timestamp: Option<Timestamp>,
    #[prost(string, tag = "2")]
    pub(crate) parent_frame_id: String,
    #[prost(string, tag = "3")]
    pub(crate) child_frame_id: String,
    #[prost(message, optional, tag = "4")]
    pub(crate) translation: Option<Vector3>,
    #[prost(message, optional, tag = "5")]
    pub(crate) rotation: Option<Quaternion>,
}

/// `foxglove.FrameTransforms`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct FrameTransforms {
    #[prost(message, repeated, tag = "1")]
    pub(crate) transforms: Vec<FrameTransform>,
}

/// `foxglove.Color`.
#[derive(Clone, Copy, PartialEq, Message)]
pub(crate) struct Color {
    #[prost(double, tag = "1")]
    pub(crate) r: f64,
    #[prost(double, tag = "2")]
    pub(crate) g: f64,
    #[prost(double, tag = "3")]
    pub(crate) b: f64,
    #[prost(double, tag = "4")]
    pub(crate) a: f64,
}

/// `foxglove.LinePrimitive`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct LinePrimitive {
    /// 0 strip, 1 loop, 2 pairs.
    #[prost(int32, tag = "1")]
    pub(crate) kind: i32,
    #[prost(double, tag = "3")]
    pub(crate) thickness: f64,
    #[prost(bool, tag = "4")]
    pub(crate) scale_invariant: bool,
    #[prost(message, repeated, tag = "5")]
    pub(crate) points: Vec<Vector3>,
    #[prost(message, optional, tag = "6")]
    pub(crate) color: Option<Color>,
}

/// `foxglove.SceneEntity`, with lines only.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct SceneEntity {
    #[prost(message, optional, tag = "1")]
    pub(crate) timestamp: Option<Timestamp>,
    #[prost(string, tag = "2")]
    pub(crate) frame_id: String,
    #[prost(string, tag = "3")]
    pub(crate) id: String,
    #[prost(bool, tag = "5")]
    pub(crate) frame_locked: bool,
    #[prost(message, repeated, tag = "11")]
    pub(crate) lines: Vec<LinePrimitive>,
}

/// `foxglove.SceneUpdate`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct SceneUpdate {
    #[prost(message, repeated, tag = "2")]
    pub(crate) entities: Vec<SceneEntity>,
}

/// `foxglove.Log`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct Log {
    #[prost(message, optional, tag = "1")]
    pub(crate) timestamp: Option<Timestamp>,
    /// 2 information, 3 warning, 4 error.
    #[prost(int32, tag = "2")]
    pub(crate) level: i32,
    #[prost(string, tag = "3")]
    pub(crate) message: String,
    #[prost(string, tag = "4")]
    pub(crate) name: String,
}
