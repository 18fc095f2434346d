//! Attributes that joints and tendons share: linear coefficients and limits.

use super::import_state::Import;
use crate::description::attributes::Attributes;
use crate::description::error::DescriptionError;
use alloc::format;

/// A stiffness or damping; of a polynomial only its linear term is read.
pub(super) fn linear(
    import: &mut Import<'_>,
    at: Attributes<'_>,
    name: &'static str,
) -> Result<f64, DescriptionError> {
    let own = at.list(name, 1, 8)?.unwrap_or_default();
    let inherited = at.given.and_then(|given| given.get(name));
    let rest = inherited.into_iter().flat_map(|text| text.split_ascii_whitespace().skip(own.len().max(1)));
    if own.iter().skip(1).any(|x| *x != 0.0) || rest.into_iter().any(|word| word.parse() != Ok(0.0)) {
        let tag = at.tree.elements[at.element].name.as_str();
        let what = format!("`{name}` of a <{tag}> is a polynomial, all but its linear term is left out");
        import.without(at.element, &format!("{tag} {name} polynomial"), &what);
    }
    match own.first().copied().unwrap_or(0.0) {
        value if value < 0.0 => Err(at.error(name, format!("is {value}: expected a number >= 0"))),
        value => Ok(value),
    }
}

/// A range that is active: flagged as such, or given at all while limits are automatic.
pub(super) fn limits(
    at: Attributes<'_>,
    auto: bool,
    limited: &str,
    range: &str,
) -> Result<Option<[f64; 2]>, DescriptionError> {
    let given = at.array::<2>(range)?;
    let holds = match at.word(limited, &["false", "true", "auto"])? {
        Some(0) => false,
        Some(1) => true,
        _ => auto && given.is_some_and(|given| given.iter().any(|end| *end != 0.0)),
    };
    if !holds {
        return Ok(None);
    }
    let [low, high] = given.unwrap_or_default();
    if low < high {
        return Ok(Some([low, high]));
    }
    Err(at.error(range, format!("is `{low} {high}`: expected a low end below the high end")))
}
