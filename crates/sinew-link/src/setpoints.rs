//! Commands: mode requests and set-points.

use crate::wire::{
    CommandHead, MAX_POINTS, MAX_VALUES, POINT_BYTES, PointHead, Reader, Writer, points_per_command,
};
use crate::{Rejection, Request, SetpointKind};

/// What a client asks of the machine, in memory of fixed size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// Mode that is asked for.
    pub request: Request,
    /// Lock-step: the machine's time up to which it may go, ns; else 0.
    pub advance_to_ns: u64,
    /// Set-points, possibly none.
    pub setpoints: Setpoints,
}

impl Command {
    /// As the body of a Command packet.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = vec![0; CommandHead::SIZE + POINT_BYTES];
        let mut writer = Writer::new(&mut bytes);
        // A command has room in a packet, whose body is not longer.
        let written = write(self, &mut writer).map_or(0, |()| writer.written());
        bytes.truncate(written);
        bytes
    }

    /// From the body of a Command packet.
    ///
    /// # Errors
    /// Why it is none.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Rejection> {
        read(&mut Reader::new(bytes))
    }

    /// A request without set-points, or with none at all a sign of life.
    #[must_use]
    pub fn from_request(request: Request) -> Self {
        Self { request, advance_to_ns: 0, setpoints: Setpoints::none() }
    }
}

/// Time-stamped points of one kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setpoints {
    kind: SetpointKind,
    values: usize,
    points: usize,
    at_ns: [u64; MAX_POINTS],
    numbers: [f64; POINT_BYTES / 8],
}

impl Setpoints {
    /// No set-points.
    #[must_use]
    pub fn none() -> Self {
        Self::new(SetpointKind::None, 0)
    }

    /// No points yet, with this many numbers each. More than [`MAX_VALUES`] leave no room for any point.
    #[must_use]
    pub fn new(kind: SetpointKind, values: usize) -> Self {
        Self { kind, values, points: 0, at_ns: [0; MAX_POINTS], numbers: [0.0; POINT_BYTES / 8] }
    }

    /// What the numbers are.
    #[must_use]
    pub fn kind(&self) -> SetpointKind {
        self.kind
    }

    /// Numbers per point.
    #[must_use]
    pub fn values(&self) -> usize {
        self.values
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points
    }

    /// Whether there is no point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points == 0
    }

    /// Adds a point; false where it has another number of values or the packet is full.
    ///
    /// # Shapes
    /// `numbers: [values]`.
    pub fn push(&mut self, at_ns: u64, numbers: &[f64]) -> bool {
        let n = self.values;
        let fits = n > 0 && n <= MAX_VALUES && self.points < points_per_command(n) && numbers.len() == n;
        if fits {
            self.at_ns[self.points] = at_ns;
            self.numbers[self.points * n..(self.points + 1) * n].copy_from_slice(numbers);
            self.points += 1;
        }
        fits
    }

    /// Time stamps, ns, and numbers of the points.
    pub fn iter(&self) -> impl Iterator<Item = (u64, &[f64])> {
        let numbers = self.numbers[..self.points * self.values].chunks_exact(self.values.max(1));
        self.at_ns[..self.points].iter().copied().zip(numbers)
    }
}

/// Writes the body of a command.
pub(crate) fn write(command: &Command, writer: &mut Writer<'_>) -> Option<()> {
    let Setpoints { kind, values, points, .. } = command.setpoints;
    let head = CommandHead {
        request: command.request.number(),
        setpoint: kind.number(),
        values: values as u16,
        points: points as u16,
        padding: [0; 2],
        advance_to_ns: command.advance_to_ns,
    };
    head.write(writer)?;
    for (at_ns, numbers) in command.setpoints.iter() {
        PointHead { at_ns }.write(writer)?;
        for number in numbers {
            writer.put(*number)?;
        }
    }
    Some(())
}

/// Reads the body of a command; codes, counts, finite numbers and ascending time stamps are checked.
///
/// # Errors
/// The first reason that applies.
pub(crate) fn read(reader: &mut Reader<'_>) -> Result<Command, Rejection> {
    let head = CommandHead::read(reader).ok_or(Rejection::Length)?;
    let (values, points) = (usize::from(head.values), usize::from(head.points));
    let request = Request::from_number(head.request).ok_or(Rejection::Code)?;
    let kind = SetpointKind::from_number(head.setpoint).ok_or(Rejection::Code)?;
    if head.padding != [0; 2] {
        return Err(Rejection::Code);
    }
    let some = kind != SetpointKind::None;
    if values > MAX_VALUES || some != (values > 0) || some != (points > 0) {
        return Err(Rejection::Count);
    }
    if some && points > points_per_command(values) {
        return Err(Rejection::Count);
    }
    let mut setpoints = Setpoints::new(kind, values);
    for (at_ns, numbers) in
        setpoints.at_ns.iter_mut().zip(setpoints.numbers.chunks_mut(values.max(1))).take(points)
    {
        *at_ns = PointHead::read(reader).ok_or(Rejection::Length)?.at_ns;
        for number in numbers {
            *number = reader.take().ok_or(Rejection::Length)?;
        }
    }
    setpoints.points = points;
    if !reader.is_empty() {
        return Err(Rejection::Length);
    }
    if !setpoints.iter().all(|(_, numbers)| numbers.iter().all(|number| number.is_finite())) {
        return Err(Rejection::NonFinite);
    }
    let times = &setpoints.at_ns[..points];
    if times.windows(2).any(|pair| pair[0] >= pair[1] || pair[0] == 0) {
        return Err(Rejection::OutOfRange);
    }
    Ok(Command { request, advance_to_ns: head.advance_to_ns, setpoints })
}
