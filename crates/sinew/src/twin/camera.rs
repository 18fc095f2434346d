//! A camera that sees markers, with the faults of real ones.
//!
//! ```text
//! y = (1 + sigma) (R (x + a sin(k x)) + t) + noise + outlier,    stamped  t_exposure + delay + jitter N(0, 1)
//! ```

use crate::body::{Pose, Poses, Robot};
use crate::error::{Error, within};
use crate::machine::Marker;
use crate::random::Random;
use alloc::vec::Vec;

/// Numbers of a camera; `Default` is a good one of 30 Hz.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraParameters {
    /// Of the world in its frame: turn and place. Its z is the direction in which it looks.
    pub world: Pose,
    /// Frames per second, Hz, > 0.
    pub rate: f64,
    /// Standard deviation of a coordinate across the view, m; three times that along it.
    pub noise: f64,
    /// Stamp minus exposure, s.
    pub delay: f64,
    /// Standard deviation of the same, s.
    pub jitter: f64,
    /// Relative error of all lengths.
    pub scale: f64,
    /// Amplitude of a smooth distortion, m.
    pub distortion: f64,
    /// Fraction of points that are 5 to 80 mm off.
    pub outliers: f64,
    /// Fraction of points that are missing.
    pub dropouts: f64,
    /// Fraction of frames in which two markers have each other's names.
    pub swapped: f64,
    /// When it is moved, s, and by what, m; infinite for never.
    pub moved: (f64, [f64; 3]),
    /// Whether its y axis has the wrong sign.
    pub mirrored: bool,
}

impl CameraParameters {
    /// A good one that looks at a machine of a size, m, from the side.
    #[must_use]
    pub fn looking_at(size: f64) -> Self {
        // Along -y and a little down.
        let (sine, cosine) = libm::sincos(0.3);
        let axes = [[-1.0, 0.0, 0.0], [0.0, sine, -cosine], [0.0, -cosine, -sine]];
        Self {
            world: Pose { axes, origin: [0.05 * size, -0.1 * size, 3.0 * size] },
            rate: 30.0,
            noise: 3e-4,
            delay: 0.03,
            jitter: 2e-3,
            scale: 0.0,
            distortion: 1e-4,
            outliers: 0.0,
            dropouts: 0.0,
            swapped: 0.0,
            moved: (f64::INFINITY, [0.0; 3]),
            mirrored: false,
        }
    }
}

/// A point as a camera sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// Its stamp, s.
    pub time: f64,
    /// Index of the marker.
    pub marker: usize,
    /// In the camera's frame, m.
    pub position: [f64; 3],
}

/// A camera in operation.
#[derive(Debug, Clone)]
pub struct Camera {
    parameters: CameraParameters,
    /// Where the markers are in truth.
    markers: Vec<Marker>,
    random: Random,
    frames: u64,
}

impl Camera {
    /// A camera that sees these markers, each where its standard deviation lets it be.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a rate that is not positive.
    pub fn new(parameters: CameraParameters, markers: &[Marker], seed: u64) -> Result<Self, Error> {
        within("rate of a camera", "a number > 0", parameters.rate, parameters.rate > 0.0)?;
        let mut random = Random::new(seed ^ 0x6361_6d65_7261_0001);
        let mut markers = markers.to_vec();
        for marker in &mut markers {
            marker.position.iter_mut().for_each(|x| *x += marker.position_sd * random.normal());
        }
        Ok(Self { parameters, markers, random, frames: 0 })
    }

    /// Where the markers are in truth.
    #[must_use]
    pub fn markers(&self) -> &[Marker] {
        &self.markers
    }

    /// Whether the next frame is exposed at or before a time, s.
    #[must_use]
    pub fn is_due(&self, time: f64) -> bool {
        self.frames as f64 / self.parameters.rate <= time
    }

    /// Exposes a frame of a machine with these poses at a time, s.
    pub fn expose(&mut self, time: f64, robot: &Robot, poses: &Poses, seen: &mut Vec<Sighting>) {
        self.frames += 1;
        let Self { parameters: p, markers, random, .. } = self;
        let stamp = time + p.delay + p.jitter * random.normal();
        let first = seen.len();
        for (marker, place) in markers.iter().enumerate() {
            let mut x = robot.body_pose(poses, place.body).point(place.position);
            if p.distortion != 0.0 {
                let along = [x[1], x[2], x[0]];
                x = core::array::from_fn(|k| x[k] + p.distortion * libm::sin(9.0 * along[k] + k as f64));
            }
            let mut y = p.world.point(x);
            if time >= p.moved.0 {
                y = core::array::from_fn(|k| y[k] + p.moved.1[k]);
            }
            let noise: [f64; 3] = core::array::from_fn(|_| p.noise * random.normal());
            y = core::array::from_fn(|k| (1.0 + p.scale) * y[k] + noise[k] * [1.0, 1.0, 3.0][k]);
            let (lost, off) = (random.unit() < p.dropouts, random.unit() < p.outliers);
            let far = 5e-3 + 75e-3 * random.unit();
            let direction: [f64; 3] = core::array::from_fn(|_| random.normal());
            if off {
                let length = libm::sqrt(direction.iter().map(|x| x * x).sum()).max(1e-9);
                y = core::array::from_fn(|k| y[k] + far * direction[k] / length);
            }
            if p.mirrored {
                y[1] = -y[1];
            }
            if !lost {
                seen.push(Sighting { time: stamp, marker, position: y });
            }
        }
        if random.unit() < p.swapped && seen.len() >= first + 2 {
            let other = first + 1 + (random.bits() % (seen.len() - first - 1) as u64) as usize;
            let name = seen[first].marker;
            seen[first].marker = seen[other].marker;
            seen[other].marker = name;
        }
    }
}
