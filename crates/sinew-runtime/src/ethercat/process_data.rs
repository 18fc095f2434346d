//! Process data of all devices: where it stands in the logical addresses of the master, and how many devices
//! take part in its exchange.
//!
//! ```text
//! inputs of all devices | outputs of all devices        both in the order on the wire, from address 0
//! ```
//!
//! Inputs are read alone, at the beginning of a cycle; the writing of the outputs reads them once more.

use super::bring_up::OpGroup;
use core::ops::Range;
use ethercrab::error::Error;
use ethercrab::{Command, MainDevice, SubDeviceState};

/// Octets of one frame for process data and the headers of its datagrams, beside those of Ethernet and
/// EtherCAT.
const FRAME: usize = 1498;
/// Header and working counter of a datagram.
const DATAGRAM: usize = 12;
/// The datagram that distributes the time of the reference clock.
const CLOCK_DATAGRAM: usize = DATAGRAM + 8;

/// Process data of the devices on the wire.
#[derive(Debug, Clone)]
pub(super) struct ProcessData {
    inputs: Vec<u8>,
    /// Within the logical addresses, inputs and outputs: `[devices]`.
    places: Vec<[Range<usize>; 2]>,
    /// Datagrams that read the inputs.
    reads: Vec<Read>,
    /// Working counter of the writing, all devices in OP.
    written: u16,
}

#[derive(Debug, Clone)]
struct Read {
    range: Range<usize>,
    /// Devices whose inputs it touches and that answer.
    expected: u16,
}

impl ProcessData {
    /// Of a group whose addresses are configured; `clocked`: with a reference clock.
    pub(super) fn new(main: &MainDevice<'_>, group: &OpGroup, devices: usize, clocked: bool) -> Self {
        let lengths = |k| {
            group
                .subdevice(main, k)
                .map_or([0, 0], |device| [device.inputs_raw().len(), device.outputs_raw().len()])
        };
        let lengths: Vec<[usize; 2]> = (0..devices).map(lengths).collect();
        let mut end = 0;
        let mut place = |length: usize| {
            end += length;
            end - length..end
        };
        let inputs: Vec<_> = lengths.iter().map(|[length, _]| place(*length)).collect();
        let outputs: Vec<_> = lengths.iter().map(|[_, length]| place(*length)).collect();
        let [inputs_end, end] = [&inputs, &outputs].map(|places| places.last().map_or(0, |place| place.end));
        let places: Vec<[Range<usize>; 2]> = inputs.into_iter().zip(outputs).map(|(a, b)| [a, b]).collect();
        let reads = pieces(inputs_end, FRAME - DATAGRAM, FRAME - DATAGRAM);
        // A device adds 1 for inputs that are read and 2 for outputs that are written.
        let first = FRAME - DATAGRAM - if clocked { CLOCK_DATAGRAM } else { 0 };
        let written = pieces(end.max(inputs_end), first, FRAME - DATAGRAM)
            .flat_map(|piece| {
                places
                    .iter()
                    .map(move |[inputs, outputs]| {
                        u16::from(touch(inputs, &piece)) + 2 * u16::from(touch(outputs, &piece))
                    })
                    .collect::<Vec<_>>()
            })
            .sum();
        let reads = reads.map(|range| Read { range, expected: 0 }).collect();
        let mut data = Self { inputs: vec![0; inputs_end], places, reads, written };
        data.expect(&[]);
        data
    }

    /// Adapts what is expected to the states of the devices: those below SAFE-OP do not answer. States that
    /// are not known count as OP.
    pub(super) fn expect(&mut self, states: &[SubDeviceState]) {
        let Self { places, reads, .. } = self;
        for read in reads {
            let answers = |(k, [inputs, _]): &(usize, &[Range<usize>; 2])| {
                let state = states.get(*k).copied().unwrap_or(SubDeviceState::Op);
                matches!(state, SubDeviceState::SafeOp | SubDeviceState::Op) && touch(inputs, &read.range)
            };
            read.expected = places.iter().enumerate().filter(answers).count() as u16;
        }
    }

    /// Working counter of an exchange in which every device takes part.
    pub(super) fn written(&self) -> u16 {
        self.written
    }

    /// Inputs of a device by its position on the wire, of the last reading.
    pub(super) fn inputs(&self, position: usize) -> &[u8] {
        self.places.get(position).and_then(|[inputs, _]| self.inputs.get(inputs.clone())).unwrap_or_default()
    }

    /// Reads all inputs.
    ///
    /// # Errors
    /// [`Error::WorkingCounter`] where another number of devices took part than expected.
    pub(super) async fn read(&mut self, main: &MainDevice<'_>) -> Result<(), Error> {
        for Read { range, expected } in &self.reads {
            let inputs = self.inputs.get_mut(range.clone()).ok_or(Error::Internal)?;
            // At addresses of inputs alone, reading and writing (LRW) is reading.
            let command = Command::lrw(range.start as u32).with_wkc(*expected);
            let answer = command.send_receive_slice(main, &*inputs).await?;
            inputs.copy_from_slice(answer.get(..inputs.len()).ok_or(Error::Internal)?);
        }
        Ok(())
    }
}

/// Consecutive pieces of `0..end`, the first one and the others of these lengths at most.
fn pieces(end: usize, first: usize, others: usize) -> impl Iterator<Item = Range<usize>> {
    let mut start = 0;
    core::iter::from_fn(move || {
        let length = (end - start).min(if start == 0 { first } else { others });
        start += length;
        (length > 0).then(|| start - length..start)
    })
}

/// Whether two ranges have something in common.
fn touch(a: &Range<usize>, b: &Range<usize>) -> bool {
    a.start.max(b.start) < a.end.min(b.end)
}
