//! Kinds of the commands of a drive, for the unit of their numbers.

/// Which kinds of commands with a number a drive was given.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct CommandKinds([bool; 3]);

/// Units by the number of the kind: speed, tension, current.
const UNITS: [&str; 3] = ["m/s", "N", "A"];

impl CommandKinds {
    /// Takes note of a kind, as the signal `command_kind` has it.
    pub(super) fn see(&mut self, kind: f64) {
        if let Some(seen) = (0..UNITS.len()).find(|k| (kind - *k as f64).abs() < 0.5) {
            self.0[seen] = true;
        }
    }

    /// Unit of the numbers: of several kinds `m/s or N`.
    pub(super) fn unit(self) -> String {
        let seen = UNITS.iter().zip(self.0).filter(|(_, seen)| *seen).map(|(unit, _)| *unit);
        match seen.collect::<Vec<_>>().as_slice() {
            [] => "1".to_owned(),
            units => units.join(" or "),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_is_that_of_the_kinds_that_were_given() {
        let unit = |kinds: &[f64]| {
            let mut all = CommandKinds::default();
            kinds.iter().for_each(|kind| all.see(*kind));
            all.unit()
        };
        assert_eq!(unit(&[0.0, 0.0]), "m/s");
        assert_eq!(unit(&[1.0, f64::NAN, 1.0]), "N");
        assert_eq!(unit(&[0.0, 1.0]), "m/s or N");
        assert_eq!(unit(&[f64::NAN]), "1");
    }
}
