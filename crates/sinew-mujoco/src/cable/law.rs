//! The law of one cable from its configuration.

use crate::text::number;
use sinew::transmission::cable::{CableLaw, CableParameters, CablePath, Segment};

/// A cable with the tension at which it begins.
#[derive(Debug, Clone)]
pub(crate) struct Written {
    path: CablePath,
    parameters: CableParameters,
    /// Tension at the anchor when the simulation begins, N.
    pub(crate) start: f64,
}

const KEYS: &str = "free, sheath, pulley, friction, viscous_s_per_m, efficiency, drag_n_s_per_m, \
    drag_fade_n, pretension_n, compliance_per_n, sheath_compliance_per_n, start_n";

impl Written {
    /// From the pairs of an entry; segments of the path in their order. Friction and compliance have no
    /// default.
    pub(crate) fn read(pairs: &[(&str, &str)]) -> Result<Self, String> {
        let mut segments = Vec::new();
        let nothing = CableParameters {
            friction: f64::NAN,
            viscous: 0.0,
            efficiency: 1.0,
            drag: 0.0,
            drag_fade: 5.0,
            pretension: 0.0,
            compliance: f64::NAN,
            sheath_compliance: 0.0,
            weakening: None,
        };
        let (mut parameters, mut start, mut seen) = (nothing, None, Vec::new());
        for (key, text) in pairs {
            if let Some(segment) = segment(key, text)? {
                segments.push(segment);
                continue;
            }
            let value = number(key, text)?;
            match *key {
                "friction" => parameters.friction = value,
                "viscous_s_per_m" => parameters.viscous = value,
                "efficiency" => parameters.efficiency = value,
                "drag_n_s_per_m" => parameters.drag = value,
                "drag_fade_n" => parameters.drag_fade = value,
                "pretension_n" => parameters.pretension = value,
                "compliance_per_n" => parameters.compliance = value,
                "sheath_compliance_per_n" => parameters.sheath_compliance = value,
                "start_n" => start = Some(value),
                _ => return Err(format!("unknown key {key}, expected one of {KEYS}")),
            }
            if seen.contains(key) {
                return Err(format!("{key} is given twice"));
            }
            seen.push(*key);
        }
        for (key, value) in [("friction", parameters.friction), ("compliance_per_n", parameters.compliance)] {
            if value.is_nan() {
                return Err(format!("{key} is missing"));
            }
        }
        parameters.validate().map_err(|error| error.to_string())?;
        let path = CablePath::new(segments).map_err(|error| error.to_string())?;
        let start = start.unwrap_or(parameters.pretension);
        if start < parameters.pretension {
            return Err(format!("start_n must be at least pretension_n, but is {start}"));
        }
        Ok(Self { path, parameters, start })
    }

    /// The law, cut into cells.
    pub(crate) fn law(&self, cells: usize) -> Result<CableLaw, String> {
        CableLaw::new(&self.path, &self.parameters, cells).map_err(|error| error.to_string())
    }
}

/// `free=LENGTH`, `sheath=LENGTH/BEND`, `sheath=LENGTH/BEND/CURVATURE/...`, `pulley=WRAP`.
fn segment(key: &str, text: &str) -> Result<Option<Segment>, String> {
    let parts = || text.split('/').map(|part| number(key, part)).collect::<Result<Vec<_>, _>>();
    Ok(Some(match key {
        "free" => Segment::Free { length: number(key, text)? },
        "pulley" => Segment::Pulley { wrap: number(key, text)? },
        "sheath" => match parts()?.as_slice() {
            [length, bend, curvature @ ..] => {
                Segment::Sheath { length: *length, bend: *bend, curvature: curvature.to_vec() }
            }
            _ => return Err(format!("sheath={text}: expected LENGTH/BEND")),
        },
        _ => return Ok(None),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: [(&str, &str); 6] = [
        ("free", "0.1"),
        ("sheath", "0.8/3/1/2"),
        ("pulley", "0.5"),
        ("free", "0.2"),
        ("friction", "0.1"),
        ("compliance_per_n", "1e-4"),
    ];

    #[test]
    fn a_path_is_read_in_its_order_and_nothing_else_is_there() {
        let written = Written::read(&GOOD).unwrap();
        assert_eq!(written.path.segments().len(), 4);
        let law = written.law(8).unwrap();
        assert!(
            (law.friction_angle() - 0.35).abs() < 1e-12 && law.pretension() == 0.0 && written.start == 0.0
        );
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (pairs, part) in [
            (vec![("friction", "0.1")], "compliance_per_n is missing"),
            (vec![("mu", "0.1")], "unknown key mu"),
            (vec![("sheath", "0.1")], "LENGTH/BEND"),
            (vec![("friction", "x")], "finite number"),
        ] {
            assert!(Written::read(&pairs).unwrap_err().contains(part), "{part}");
        }
        let with = |more: (&'static str, &'static str)| {
            Written::read(&[&GOOD[..], &[more]].concat()).map(|_| ()).unwrap_err()
        };
        assert!(with(("friction", "0.2")).contains("twice"));
        assert!(with(("efficiency", "2")).contains("efficiency"));
        assert!(with(("start_n", "-1")).contains("start_n"));
        assert!(with(("pulley", "1")).contains("free"));
    }
}
