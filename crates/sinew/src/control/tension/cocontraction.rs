//! How tight the muscles are kept against each other.

use crate::Error;
use crate::error::within;

/// Reference tensions for a desired co-contraction.
///
/// ```text
/// F_ref = F_min + c (F_max - F_min)
/// ```
///
/// | symbol | argument   | unit | domain      | meaning                                          |
/// |--------|------------|------|-------------|--------------------------------------------------|
/// | c      | `level`    | 1    | 0 to 1      | 0: as slack as allowed; 1: as tight as allowed   |
/// | F_min  | `minimum`  | N    | <= `maximum`| minimum tension of each muscle                     |
/// | F_max  | `maximum`  | N    |             | greatest tension of each muscle                  |
///
/// As the reference of a [`Problem`](super::Problem) it acts in the null space of `R^T` only: the torque
/// stays what it is, and what the torque leaves free comes as close to the level as the weights say. Muscles
/// whose stiffness grows with tension make stiffer joints that way. For a level in N, fill the reference with
/// it: limits are kept in any case.
///
/// # Errors
/// [`Error::OutOfDomain`] names the level, [`Error::WrongLength`] the slice.
///
/// # Example
/// ```
/// let mut reference = [0.0; 2];
/// sinew::control::tension::cocontract(0.25, &[20.0, 20.0], &[400.0, 100.0], &mut reference)?;
/// assert_eq!(reference, [115.0, 40.0]);
/// # Ok::<(), sinew::Error>(())
/// ```
pub fn cocontract(level: f64, minimum: &[f64], maximum: &[f64], reference: &mut [f64]) -> Result<(), Error> {
    within("level", "within 0 to 1", level, (0.0..=1.0).contains(&level))?;
    let expected = reference.len();
    for (name, list) in [("minimum", minimum), ("maximum", maximum)] {
        if list.len() != expected {
            return Err(Error::WrongLength { name, expected, got: list.len() });
        }
    }
    for ((reference, low), high) in reference.iter_mut().zip(minimum).zip(maximum) {
        *reference = low + level * (high - low);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::cocontract;

    #[test]
    fn the_level_is_the_share_of_the_way_from_slack_to_tight() {
        let (minimum, maximum) = ([20.0, 5.0], [400.0, 105.0]);
        for (level, expected) in [(0.0, minimum), (0.25, [115.0, 30.0]), (1.0, maximum)] {
            let mut reference = [f64::NAN; 2];
            cocontract(level, &minimum, &maximum, &mut reference).unwrap();
            assert!(reference.iter().zip(expected).all(|(got, expected)| (got - expected).abs() < 1e-13));
        }
        for level in [-0.1, 1.1, f64::NAN] {
            assert!(cocontract(level, &minimum, &maximum, &mut [0.0; 2]).is_err());
        }
        assert!(cocontract(0.5, &minimum[..1], &maximum, &mut [0.0; 2]).is_err());
    }
}
