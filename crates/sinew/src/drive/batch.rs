use super::exchange::{DriveCommand, DriveReading, DriveStep};
use super::lanes::DriveLanes;
use super::machine::Drive;
use crate::dispatch::InstructionSet;
use alloc::vec::Vec;

/// Drives in a group.
const LANES: usize = 8;
/// Fewer are stepped one by one: a group costs what it costs, however many of its lanes are used.
const FEWEST: usize = 3;

/// Drives of a machine, eight in SIMD lanes: bit for bit the same as as many [`Drive`]s.
#[derive(Debug, Clone)]
pub(crate) struct DriveBatch {
    groups: Vec<DriveLanes<LANES>>,
    /// Drives left over, stepped one by one.
    rest: Vec<DriveLanes<1>>,
    count: usize,
    instructions: InstructionSet,
}

impl DriveBatch {
    /// These drives.
    pub(crate) fn new(drives: &[Drive]) -> Self {
        let (mut groups, mut rest) = (Vec::new(), Vec::new());
        for chunk in drives.chunks(LANES) {
            let lanes: Vec<&DriveLanes<1>> = chunk.iter().map(|drive| &drive.lane).collect();
            if lanes.len() < FEWEST {
                rest.extend(lanes.into_iter().cloned());
            } else {
                groups.push(DriveLanes::gathered(&lanes));
            }
        }
        Self { groups, rest, count: drives.len(), instructions: InstructionSet::detect() }
    }

    /// [`Drive::step`] of every drive, the results in `steps`; `of` gives a drive's command and the tension
    /// at its outlet, N.
    pub(crate) fn step(
        &mut self,
        mut of: impl FnMut(usize) -> (DriveCommand, f64),
        h: f64,
        steps: &mut [DriveStep],
    ) {
        let Self { groups, rest, instructions, .. } = self;
        let (mut first, mut steps) = (0, steps);
        for group in groups {
            let (now, others) = steps.split_at_mut(LANES.min(steps.len()));
            group.step(*instructions, |k| of(first + k), h, now);
            (first, steps) = (first + now.len(), others);
        }
        for (lane, step) in rest.iter_mut().zip(steps.chunks_mut(1)) {
            lane.step(InstructionSet::Baseline, |_| of(first), h, step);
            first += 1;
        }
    }

    /// [`Drive::reading`] of one.
    pub(crate) fn reading(&self, drive: usize) -> DriveReading {
        match self.groups.get(drive / LANES) {
            Some(group) => group.reading(drive % LANES),
            None => self.rest[drive - LANES * self.groups.len()].reading(0),
        }
    }

    /// [`Drive::winding`] of one; NaN for an index out of range.
    pub(crate) fn winding(&self, drive: usize) -> f64 {
        if drive >= self.count {
            return f64::NAN;
        }
        match self.groups.get(drive / LANES) {
            Some(group) => group.winding(drive % LANES),
            None => self.rest[drive - LANES * self.groups.len()].winding(0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::{DriveFault, DriveParameters};
    use crate::random::Random;
    use std::format;

    /// Parameters that differ in everything, some of a drive that is soon hot, empty or short of voltage.
    fn parameters(random: &mut Random) -> DriveParameters {
        let mut p = DriveParameters::mc_am();
        let mut factor = |most: f64| libm::exp(most * (2.0 * random.unit() - 1.0));
        for number in [
            &mut p.motor.torque_constant,
            &mut p.motor.resistance,
            &mut p.motor.inertia,
            &mut p.motor.voltage,
            &mut p.reducer.ratio,
            &mut p.reducer.friction,
            &mut p.reducer.backlash,
            &mut p.winch.radius,
            &mut p.encoder.counts,
            &mut p.load_cell.noise,
            &mut p.acceleration,
        ] {
            *number *= factor(0.5);
        }
        p.motor.inductance *= if factor(1.0) > 1.5 { 0.0 } else { factor(3.0) };
        p.motor.winding_capacity *= if random.unit() < 0.3 { 1e-3 } else { 1.0 };
        p.winch.turns_per_layer *= if random.unit() < 0.5 { 0.04 } else { 1.0 };
        p.reducer.efficiency = 0.3 + 0.7 * random.unit();
        p.winch.layers = 1 + (8.0 * random.unit() * random.unit()) as u8;
        p.delay_ms = 3.0 * random.unit() * random.unit();
        p.has_load_cell = random.unit() < 0.8;
        p.load_cell.resolution *= f64::from(random.unit() < 0.8);
        p
    }

    fn command(random: &mut Random) -> DriveCommand {
        let value = random.normal();
        match (16.0 * random.unit()) as u8 {
            0 => DriveCommand::Off,
            1 => DriveCommand::Brake,
            2..5 => DriveCommand::Current(10.0 * value),
            5..10 => DriveCommand::Velocity(0.3 * value),
            10 => DriveCommand::Velocity(f64::NAN),
            11 => DriveCommand::Tension { tension: 50.0, feed: f64::INFINITY },
            _ => DriveCommand::Tension { tension: 200.0 + 200.0 * value, feed: 0.02 * value },
        }
    }

    #[test]
    fn drives_at_once_are_each_drive_alone_to_the_bit_on_every_instruction_set() {
        let (mut faults, mut moved, mut random) = ([0; 3], 0.0, Random::new(5));
        for count in (1..=19).chain([8, 15]) {
            let drive = |k| Drive::in_steps(parameters(&mut random), k, 1e-3).unwrap();
            let mut alone: Vec<Drive> = (0..count).map(drive).collect();
            alone.iter_mut().for_each(|drive| drive.settle(100.0 * random.normal()));
            // Their rings of delayed readings begin at different places.
            for (k, drive) in alone.iter_mut().enumerate() {
                (0..k % 3).for_each(|_| drive.stand(50.0));
            }
            let sets = InstructionSet::available();
            let batch = |instructions| DriveBatch { instructions, ..DriveBatch::new(&alone) };
            let mut batches: Vec<DriveBatch> = sets.into_iter().map(batch).collect();
            let mut commands: Vec<_> = alone.iter().map(|_| command(&mut random)).collect();
            for step in 0..400 {
                // The length of a step changes once.
                let h = if step < 300 { 1e-3 } else { 5e-4 };
                let tensions: Vec<f64> = alone
                    .iter()
                    .map(|_| match random.unit() {
                        x if x < 0.1 => 0.0,
                        x if x < 0.12 => f64::NAN,
                        x => 500.0 * x,
                    })
                    .collect();
                for command in &mut commands {
                    if random.unit() < 0.02 {
                        *command = self::command(&mut random);
                    }
                }
                let mut told = std::vec![DriveStep::STANDING; alone.len()];
                let mut expected = Vec::new();
                for ((drive, command), tension) in alone.iter_mut().zip(&commands).zip(&tensions) {
                    let step = drive.step(*command, *tension, h);
                    moved += step.moved.abs();
                    for (count, fault) in faults.iter_mut().zip([
                        matches!(step.fault, Some(DriveFault::Hot { .. })),
                        step.fault == Some(DriveFault::DrumFull),
                        step.fault == Some(DriveFault::DrumEmpty),
                    ]) {
                        *count += usize::from(fault);
                    }
                    expected.push((step, drive.reading(), drive.winding()));
                }
                for batch in &mut batches {
                    batch.step(|k| (commands[k], tensions[k]), h, &mut told);
                    let told: Vec<_> = told
                        .iter()
                        .enumerate()
                        .map(|(k, s)| (*s, batch.reading(k), batch.winding(k)))
                        .collect();
                    assert_eq!(format!("{told:?}"), format!("{expected:?}"), "{count} drives, step {step}");
                }
            }
            assert!(batches[0].winding(alone.len()).is_nan());
        }
        assert!(faults.iter().all(|count| *count > 100) && moved > 10.0, "{faults:?} {moved}");
    }
}
