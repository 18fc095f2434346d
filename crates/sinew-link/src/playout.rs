//! Set-points over jitter: time-stamped points to a continuous reference.

/// Queue of time-stamped points, played out after a fixed delay.
///
/// ```text
/// t_k = stamp_k + D
/// x(t) on [t_k, t_k+1]:   cubic Hermite polynomial through x_k, x_k+1 with slopes v_k, v_k+1
/// v_k+1 = clip((h_2 d_1 + h_1 d_2)/(h_1 + h_2), between 0 and 3 min(d_1, d_2)),   0 where d_1 d_2 <= 0
/// no next point:          x = x_k + v_k (s - s^2/(2 B)),   v = v_k (1 - s/B),   s = t - t_k < B;   then rest
/// ```
///
/// | symbol     | meaning                                                  | unit |
/// |------------|----------------------------------------------------------|------|
/// | D          | playout delay, that evens out jitter                     | s    |
/// | d_1, d_2   | slopes of the chords before and after a point             | 1/s  |
/// | h_1, h_2   | their durations                                          | s    |
/// | B          | time in which a motion without next point comes to rest  | s    |
///
/// Where the point after the next is not yet there, `v_k+1 = d_1`. A piece begins with the position and
/// velocity in which the one before ended, so that neither jumps whatever arrives; between points the
/// reference does not overshoot where the slopes are not carried over from an interruption. Limits of speed
/// and acceleration are the receiver's.
///
/// # Source
/// `fritsch1980` for the slopes; the delay as in playout buffers for speech, RFC 3550.
#[derive(Debug, Clone)]
pub struct Playout {
    values: usize,
    delay: u64,
    brake: u64,
    /// Points, ascending: a ring of times, and `[capacity x values]`.
    times: Box<[u64]>,
    numbers: Box<[f64]>,
    first: usize,
    queued: usize,
    motion: Motion,
    /// Ends of the present piece: `[values]` each.
    from: End,
    to: End,
    /// Time and output of the last sample.
    now: u64,
    x: Box<[f64]>,
    v: Box<[f64]>,
}

#[derive(Debug, Clone)]
struct End {
    time: u64,
    x: Box<[f64]>,
    v: Box<[f64]>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Motion {
    Piece,
    Brake,
    Rest,
}

/// What happened to a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pushed {
    /// It waits for its time.
    Queued,
    /// Its time has passed: dropped.
    Late,
    /// No room: dropped.
    Full,
}

/// What a sample is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Playing {
    /// Between two points.
    Following,
    /// Behind the last point, coming to rest.
    Braking,
    /// At rest.
    Resting,
}

impl Playout {
    /// At rest at zero; memory for `capacity` points of up to `max_values` numbers. `delay` and `brake` are
    /// in ns.
    #[must_use]
    pub fn new(max_values: usize, capacity: usize, delay: u64, brake: u64) -> Self {
        let zeros = || vec![0.0; max_values].into_boxed_slice();
        let end = || End { time: 0, x: zeros(), v: zeros() };
        Self {
            values: max_values,
            delay,
            brake: brake.max(1),
            times: vec![0; capacity.max(1)].into_boxed_slice(),
            numbers: vec![0.0; capacity.max(1) * max_values].into_boxed_slice(),
            first: 0,
            queued: 0,
            motion: Motion::Rest,
            from: end(),
            to: end(),
            now: 0,
            x: zeros(),
            v: zeros(),
        }
    }

    /// Forgets all points and rests at a position of as many numbers as the points to come have, up to the
    /// most.
    pub fn reset(&mut self, now: u64, position: &[f64]) {
        self.values = position.len().min(self.x.len());
        self.queued = 0;
        self.motion = Motion::Rest;
        self.now = now;
        self.x[..self.values].copy_from_slice(&position[..self.values]);
        self.v.fill(0.0);
    }

    /// Points that wait.
    #[must_use]
    pub fn queued(&self) -> usize {
        self.queued
    }

    /// Adds a point of a time stamp, ns, 0 for now; one of the same time is replaced.
    ///
    /// # Shapes
    /// `numbers: [values]`; a point of another length is dropped as [`Pushed::Full`].
    pub fn push(&mut self, now: u64, at_ns: u64, numbers: &[f64]) -> Pushed {
        let time = if at_ns == 0 { now } else { at_ns }.saturating_add(self.delay);
        if numbers.len() != self.values {
            return Pushed::Full;
        }
        if time < now || (time == now && self.delay > 0) || time <= self.now && self.motion == Motion::Piece {
            return Pushed::Late;
        }
        if self.motion == Motion::Piece && time <= self.to.time {
            return self.push_into_piece(time, numbers);
        }
        self.insert(time, numbers)
    }

    /// A point before the end of the present piece: the piece is planned anew from the present output.
    fn push_into_piece(&mut self, time: u64, numbers: &[f64]) -> Pushed {
        if time == self.to.time {
            return Pushed::Queued;
        }
        if self.queued + 1 >= self.times.len() {
            return Pushed::Full;
        }
        let (end, n) = (self.to.time, self.values);
        let x = core::mem::take(&mut self.to.x);
        self.insert(end, &x[..n]);
        self.to.x = x;
        self.insert(time, numbers);
        self.from.time = self.now;
        self.from.x[..n].copy_from_slice(&self.x[..n]);
        self.from.v[..n].copy_from_slice(&self.v[..n]);
        self.begin_piece();
        Pushed::Queued
    }

    fn slot(&self, k: usize) -> usize {
        (self.first + k) % self.times.len()
    }

    fn numbers_of(&self, slot: usize) -> &[f64] {
        let most = self.x.len();
        &self.numbers[slot * most..slot * most + self.values]
    }

    fn insert(&mut self, time: u64, numbers: &[f64]) -> Pushed {
        let mut place = self.queued;
        while place > 0 && self.times[self.slot(place - 1)] >= time {
            place -= 1;
        }
        let (most, n) = (self.x.len(), self.values);
        let slot = self.slot(place);
        let same = place < self.queued && self.times[slot] == time;
        if !same {
            if self.queued == self.times.len() {
                return Pushed::Full;
            }
            for k in (place..self.queued).rev() {
                let (from, to) = (self.slot(k), self.slot(k + 1));
                self.times[to] = self.times[from];
                self.numbers.copy_within(from * most..from * most + n, to * most);
            }
            self.queued += 1;
        }
        self.times[slot] = time;
        self.numbers[slot * most..slot * most + n].copy_from_slice(numbers);
        Pushed::Queued
    }

    /// Begins a piece from `from` to the first point of the queue, which is taken out.
    fn begin_piece(&mut self) {
        let (n, slot) = (self.values, self.slot(0));
        self.to.time = self.times[slot];
        let mut x = core::mem::take(&mut self.to.x);
        x[..n].copy_from_slice(self.numbers_of(slot));
        self.first = self.slot(1);
        self.queued -= 1;
        let seconds = |from: u64, to: u64| (to.saturating_sub(from)).max(1) as f64 * 1e-9;
        let h1 = seconds(self.from.time, self.to.time);
        let next = (self.queued > 0).then(|| self.slot(0));
        for k in 0..n {
            let d1 = (x[k] - self.from.x[k]) / h1;
            self.to.v[k] = next.map_or(d1, |slot| {
                let h2 = seconds(self.to.time, self.times[slot]);
                slope(d1, (self.numbers_of(slot)[k] - x[k]) / h2, h1, h2)
            });
        }
        self.to.x = x;
        self.motion = Motion::Piece;
    }

    /// Position and velocity at a time, ns, not before the one of the sample before.
    ///
    /// # Shapes
    /// `x, v: [values]`; further entries are left as they are.
    pub fn sample(&mut self, now: u64, x: &mut [f64], v: &mut [f64]) -> Playing {
        let now = now.max(self.now);
        let n = self.values;
        if self.motion != Motion::Piece && self.queued > 0 {
            self.from.time = self.now;
            self.from.x[..n].copy_from_slice(&self.x[..n]);
            self.from.v[..n].copy_from_slice(&self.v[..n]);
            self.begin_piece();
        }
        while self.motion == Motion::Piece && now >= self.to.time {
            core::mem::swap(&mut self.from, &mut self.to);
            if self.queued > 0 {
                self.begin_piece();
            } else {
                self.motion = Motion::Brake;
            }
        }
        if self.motion == Motion::Brake && now - self.from.time >= self.brake {
            let half = 0.5e-9 * self.brake as f64;
            for k in 0..n {
                self.x[k] = self.from.x[k] + half * self.from.v[k];
            }
            self.v.fill(0.0);
            self.motion = Motion::Rest;
        }
        match self.motion {
            Motion::Piece => self.interpolate(now),
            Motion::Brake => self.decelerate(now),
            Motion::Rest => {}
        }
        self.now = now;
        x.iter_mut().zip(&self.x[..n]).for_each(|(x, own)| *x = *own);
        v.iter_mut().zip(&self.v[..n]).for_each(|(v, own)| *v = *own);
        match self.motion {
            Motion::Piece => Playing::Following,
            Motion::Brake => Playing::Braking,
            Motion::Rest => Playing::Resting,
        }
    }

    fn interpolate(&mut self, now: u64) {
        let Self { from, to, .. } = self;
        let h = (to.time - from.time).max(1) as f64 * 1e-9;
        let s = (now.saturating_sub(from.time)) as f64 * 1e-9 / h;
        for k in 0..self.values {
            let (d, v0, v1) = (to.x[k] - from.x[k], h * from.v[k], h * to.v[k]);
            let (b, c) = (3.0 * d - 2.0 * v0 - v1, v0 + v1 - 2.0 * d);
            self.x[k] = from.x[k] + s * (v0 + s * (b + s * c));
            self.v[k] = (v0 + s * (2.0 * b + s * 3.0 * c)) / h;
        }
    }

    fn decelerate(&mut self, now: u64) {
        let (s, brake) = ((now - self.from.time) as f64 * 1e-9, self.brake as f64 * 1e-9);
        for k in 0..self.values {
            let (x, v) = (self.from.x[k], self.from.v[k]);
            self.x[k] = x + v * s * (1.0 - 0.5 * s / brake);
            self.v[k] = v * (1.0 - s / brake);
        }
    }
}

/// Slope at a point between two chords: of the parabola through the three points, as far as it leaves both
/// chords monotone.
fn slope(d1: f64, d2: f64, h1: f64, h2: f64) -> f64 {
    let parabola = (h2 * d1 + h1 * d2) / (h1 + h2);
    let most = 3.0 * d1.abs().min(d2.abs());
    if d1 * d2 > 0.0 && parabola.is_finite() { parabola.clamp(-most, most) } else { 0.0 }
}
