//! Distributed clocks (ETG.1000.4, 6.8): SYNC0 of the drives, and a cycle that keeps pace with the devices'
//! clocks.
//!
//! ```text
//! reference device's time --FRMW in every cycle--> all devices      drives take their set-points over at SYNC0
//! phase of the cycle in that time --proportional-integral--> length of the next period
//! ```

use super::bring_up::{FIRST_STATION, PreOpPdiGroup, protocol};
use super::error::EthercatError;
use ethercrab::error::Error;
use ethercrab::{Command, MainDevice, RegisterAddress};
use sinew_session::ClockReport;

/// Cyclic operation and SYNC0, register 0x0981.
const CYCLIC_SYNC0: u8 = 0x03;
/// Difference of a device's time to the reference, register 0x092C: magnitude, and bit 31 for its sign.
const TIME_DIFFERENCE: u16 = 0x092c;
const MAGNITUDE: u32 = 0x7fff_ffff;
/// From the configuration to the first pulse, ns: the devices reach SAFE-OP meanwhile.
const START_DELAY: u64 = 100_000_000;
/// SYNC0 comes when this fraction of a period has passed: 1/2. The set-points arrive before, and a late frame
/// still does.
const SYNC0_FRACTION: u64 = 2;

/// Fraction of a difference in phase that one period corrects; the integral fraction is its square over four:
/// critical damping.
const FRACTION: f64 = 1.0 / 64.0;
/// Longest correction of one period beside that of the drift, and largest difference that is accepted, as
/// fractions of the period: a cycle that was woken late says nothing about the clocks.
const MAX_STEP: f64 = 0.02;
const MAX_DIFFERENCE: f64 = 0.05;
/// Largest drift between the computer's clock and the devices', as a fraction: far above that of quartz.
const MAX_DRIFT: f64 = 1e-3;

/// Clocks of the devices on the wire; none where no device has one.
#[derive(Debug, Clone)]
pub(super) struct Clocks {
    /// Control period, ns.
    period: f64,
    /// Devices with a clock, by their position; the first is the reference.
    devices: Vec<usize>,
    /// Time of the reference, without the overflows of its lower 32 bits, less that of a beginning of a
    /// cycle, ns.
    time: u64,
    last: u32,
    /// By which the next period is longer, ns: for the phase, and for the drift.
    step: f64,
    drift: f64,
    /// Differences in phase since the run began: number, mean square, largest, ns.
    differences: [f64; 3],
    report: ClockReport,
    /// Device whose difference is read next.
    next: usize,
}

/// Starts SYNC0 of the devices at the given positions, all with a clock of the group in the present time.
///
/// # Errors
/// [`EthercatError::Protocol`] names the device that refuses a register.
pub(super) async fn start(
    main: &MainDevice<'_>,
    group: &PreOpPdiGroup,
    desired: &[(usize, &str)],
    period: u64,
) -> Result<Option<Clocks>, EthercatError> {
    let clocked = group.iter(main).enumerate().filter(|(_, device)| device.dc_support().any());
    let devices: Vec<usize> = clocked.map(|(position, _)| position).collect();
    let Some(reference) = devices.first() else { return Ok(None) };
    let reference = group.subdevice(main, *reference).map_err(protocol("finding the reference clock"))?;
    let now: u64 = reference
        .register_read(RegisterAddress::DcSystemTime)
        .await
        .map_err(protocol("reading the reference clock"))?;
    let first = (now + START_DELAY) / period * period;
    let mut synchronized = 0;
    for (position, name) in desired {
        let during = || protocol(format!("starting SYNC0 of {name}"));
        let device = group.subdevice(main, *position).map_err(during())?;
        if !device.dc_support().enhanced() {
            continue;
        }
        device.register_write(RegisterAddress::DcSyncActive, 0_u8).await.map_err(during())?;
        device.register_write(RegisterAddress::DcSyncStartTime, first).await.map_err(during())?;
        device.register_write(RegisterAddress::DcSync0CycleTime, period as u32).await.map_err(during())?;
        device.register_write(RegisterAddress::DcSyncActive, CYCLIC_SYNC0).await.map_err(during())?;
        synchronized += 1;
    }
    // A cycle begins half a period before the pulse.
    let begin = first - period / SYNC0_FRACTION;
    Ok(Some(Clocks {
        period: period as f64,
        devices,
        time: now.wrapping_sub(begin),
        last: now as u32,
        step: 0.0,
        drift: 0.0,
        differences: [0.0; 3],
        report: ClockReport { synchronized, ..ClockReport::default() },
        next: 0,
    }))
}

impl Clocks {
    /// Takes the time of the reference over, which a frame read `since` ns after the beginning of the cycle.
    pub(super) fn follow(&mut self, reference: u64, since: u64) {
        let difference = self.difference(reference, since);
        let accepted = difference.clamp(-MAX_DIFFERENCE * self.period, MAX_DIFFERENCE * self.period);
        let (step, drift) = (MAX_STEP * self.period, MAX_DRIFT * self.period);
        self.drift = (self.drift - FRACTION * FRACTION / 4.0 * accepted).clamp(-drift, drift);
        self.step = (-FRACTION * accepted).clamp(-step, step);

        let [count, square, most] = &mut self.differences;
        *count += 1.0;
        *square += (difference * difference - *square) / *count;
        *most = most.max(difference.abs());
    }

    /// From the moment at which a frame read the time of the reference to the next beginning of a cycle, ns.
    pub(super) fn until_begin(&mut self, reference: u64) -> u64 {
        let late = self.difference(reference, 0);
        (if late > 0.0 { self.period - late } else { -late }) as u64
    }

    /// From the beginning of the cycle in the time of the reference to where it should be, ns, within half a
    /// period.
    fn difference(&mut self, reference: u64, since: u64) -> f64 {
        let low = reference as u32;
        self.time = self.time.wrapping_add(u64::from(low.wrapping_sub(self.last)));
        self.last = low;
        let began = self.time.wrapping_sub(since).cast_signed() as f64;
        began - (began / self.period).round() * self.period
    }

    /// Time by which the next period is longer than its nominal length, ns.
    pub(super) fn correction(&self) -> i64 {
        (self.step + self.drift).round() as i64
    }

    /// The device whose difference to the reference is read next, by its position on the wire.
    pub(super) fn next_device(&mut self) -> Option<usize> {
        self.next = (self.next + 1) % self.devices.len().max(1);
        self.devices.get(self.next).copied()
    }

    /// Takes over the difference of a device to the reference, as in its register.
    pub(super) fn record_difference(&mut self, register: u32) {
        self.report.device_difference_ns = self.report.device_difference_ns.max(register & MAGNITUDE);
    }

    /// Since the run began.
    pub(super) fn report(&self) -> ClockReport {
        let [_, square, most] = self.differences;
        ClockReport {
            drift_ppm: -1e6 * self.drift / self.period,
            phase_rms_us: 1e-3 * square.sqrt(),
            phase_max_us: 1e-3 * most,
            ..self.report
        }
    }

    /// The run begins.
    pub(super) fn forget_differences(&mut self) {
        self.differences = [0.0; 3];
        self.report.device_difference_ns = 0;
    }
}

/// The register that holds the difference of a device's time to the reference.
pub(super) async fn read_difference(main: &MainDevice<'_>, position: usize) -> Result<u32, Error> {
    Command::fprd(FIRST_STATION + position as u16, TIME_DIFFERENCE).receive(main).await
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 1e6;

    fn clocks() -> Clocks {
        Clocks {
            period: PERIOD,
            devices: vec![0],
            time: 0,
            last: 0,
            step: 0.0,
            drift: 0.0,
            differences: [0.0; 3],
            report: ClockReport::default(),
            next: 0,
        }
    }

    #[test]
    fn the_cycle_follows_a_clock_that_drifts_and_overflows() {
        for drift_ppm in [-80.0, 0.0, 35.0, 200.0] {
            let mut clocks = clocks();
            let (mut computer, mut cycle) = (0.0, 0);
            while cycle < 20_000 {
                // A clock that has only 32 bits overflows every 4.3 s.
                let since = if cycle == 0 { 0.0 } else { 40_000.0 };
                let reference =
                    u64::from(((computer + since) * (1.0 + 1e-6 * drift_ppm) + 330_000.0) as u64 as u32);
                if cycle == 0 {
                    computer += clocks.until_begin(reference) as f64 - PERIOD;
                } else {
                    clocks.follow(reference, 40_000);
                }
                if cycle == 3000 {
                    clocks.forget_differences();
                }
                computer += PERIOD + clocks.correction() as f64;
                cycle += 1;
            }
            let report = clocks.report();
            assert!((report.drift_ppm - drift_ppm).abs() < 1.0, "{drift_ppm}: {report:?}");
            assert!(report.phase_max_us < 0.2, "{drift_ppm}: {report:?}");
        }
    }

    #[test]
    fn cycles_that_are_woken_late_do_not_move_the_phase() {
        let mut clocks = clocks();
        let mut computer = 0.0;
        for cycle in 0..5000 {
            let late = if cycle % 97 == 0 { 450_000.0 } else { 0.0 };
            clocks.follow((computer + late) as u64, 0);
            computer += PERIOD + clocks.correction() as f64;
            let phase = computer - (computer / PERIOD).round() * PERIOD;
            assert!(phase.abs() < 3000.0, "{cycle}: {phase} ns");
        }
    }
}
