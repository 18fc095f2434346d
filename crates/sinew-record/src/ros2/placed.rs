//! What says where something is: an element of `tf2_msgs/TFMessage`, and `geometry_msgs/PoseStamped`.

use super::cdr::{Cdr, CdrReader};

/// A frame, or a pose, in another frame at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placed<'a> {
    /// Since 1970, or another start of the clock, ns.
    pub(super) ns: i64,
    /// In which it is.
    pub(super) frame: &'a str,
    /// Its own; empty for a pose.
    pub(super) child: &'a str,
    /// m.
    pub(super) position: [f64; 3],
    /// x, y, z, w.
    pub(super) quaternion: [f64; 4],
}

impl<'a> Placed<'a> {
    /// As `geometry_msgs/TransformStamped`.
    pub(super) fn write(&self, message: &mut Cdr) {
        message.header(self.ns.max(0) as u64, self.frame);
        message.text(self.child);
        self.position.iter().chain(&self.quaternion).for_each(|x| message.f64(*x));
    }

    fn read(message: &mut CdrReader<'a>, has_child: bool) -> Option<Self> {
        let (ns, frame) = message.header()?;
        let child = if has_child { message.text()? } else { "" };
        let mut numbers = [0.0; 7];
        for number in &mut numbers {
            *number = message.f64()?;
        }
        let [x, y, z, quaternion @ ..] = numbers;
        Some(Self { ns, frame, child, position: [x, y, z], quaternion })
    }

    /// All of `tf2_msgs/TFMessage`; none where the bytes are another message.
    pub(super) fn of_transforms(bytes: &'a [u8]) -> Option<Vec<Self>> {
        let mut message = CdrReader::new(bytes)?;
        let count = message.length()?;
        let mut all = Vec::new();
        for _ in 0..count {
            all.push(Self::read(&mut message, true)?);
        }
        message.is_read().then_some(all)
    }

    /// `geometry_msgs/PoseStamped`, as above.
    pub(super) fn of_pose(bytes: &'a [u8]) -> Option<Vec<Self>> {
        let mut message = CdrReader::new(bytes)?;
        let pose = Self::read(&mut message, false)?;
        message.is_read().then_some(vec![pose])
    }
}
