//! A model and its data as the plugins see them: slices, filled in by `abi`.

use std::ffi::CStr;

/// Transmission through a tendon, `mjTRN_TENDON`.
pub(crate) const TENDON_TRANSMISSION: i32 = 3;
/// Friction of a tendon among the constraints, `mjCNSTR_FRICTION_TENDON`.
pub(crate) const TENDON_FRICTION: i32 = 2;
/// Runge-Kutta of order four, `mjINT_RK4`.
pub(crate) const RUNGE_KUTTA: i64 = 1;

/// Parts of `mjModel`.
pub(crate) struct Model<'a> {
    pub(crate) timestep: f64,
    pub(crate) integrator: i64,
    pub(crate) actuators: usize,
    pub(crate) tendons: usize,
    pub(crate) tendon_frictionloss: &'a [f64],
    pub(crate) trntype: &'a [i32],
    pub(crate) trnid: &'a [i32],
    /// Address of an actuator's first force; empty where it is the actuator's index.
    pub(crate) outadr: &'a [i32],
    /// Address of an actuator's first control; empty where it is the actuator's index.
    pub(crate) ctrladr: &'a [i32],
    pub(crate) actadr: &'a [i32],
    pub(crate) actnum: &'a [i32],
    pub(crate) actuator_plugin: &'a [i32],
    pub(crate) gear: &'a [f64],
    pub(crate) forcelimited: &'a [u8],
    pub(crate) forcerange: &'a [f64],
    /// Registered plugin of every instance.
    pub(crate) plugin: &'a [i32],
    /// The registered plugin of cables.
    pub(crate) cables: i32,
    pub(crate) stateadr: &'a [i32],
    pub(crate) names: &'a [u8],
    pub(crate) name_tendonadr: &'a [i32],
}

/// Parts of `mjData`.
pub(crate) struct Data<'a> {
    /// Tells this `mjData` from others that live at the same time.
    pub(crate) identity: usize,
    pub(crate) time: f64,
    pub(crate) act: &'a [f64],
    pub(crate) ctrl: &'a [f64],
    pub(crate) plugin_state: &'a mut [f64],
    pub(crate) plugin_data: &'a mut [usize],
    pub(crate) ten_wrapadr: &'a [i32],
    pub(crate) ten_wrapnum: &'a [i32],
    pub(crate) ten_length: &'a [f64],
    pub(crate) ten_velocity: &'a [f64],
    pub(crate) wrap_obj: &'a [i32],
    pub(crate) wrap_xpos: &'a [f64],
    pub(crate) actuator_force: &'a mut [f64],
    /// First friction constraint and the one behind the last.
    pub(crate) friction_rows: std::ops::Range<usize>,
    pub(crate) efc_type: &'a [i32],
    pub(crate) efc_id: &'a [i32],
    pub(crate) efc_frictionloss: &'a mut [f64],
    /// The same rows in the order of islands; both empty where there are no islands.
    pub(crate) iefc_frictionloss: &'a mut [f64],
    pub(crate) map_efc2iefc: &'a [i32],
}

/// An index as MuJoCo writes it; nothing for -1.
pub(crate) fn index(value: Option<&i32>) -> Option<usize> {
    value.and_then(|&value| usize::try_from(value).ok())
}

impl Model<'_> {
    /// Name of a tendon; empty for one without.
    pub(crate) fn tendon_name(&self, tendon: usize) -> String {
        let from = index(self.name_tendonadr.get(tendon)).and_then(|at| self.names.get(at..));
        let name = from.and_then(|bytes| CStr::from_bytes_until_nul(bytes).ok());
        name.map_or(String::new(), |name| name.to_string_lossy().into_owned())
    }

    /// Tendon on which an actuator pulls.
    pub(crate) fn tendon_of(&self, actuator: usize) -> Option<usize> {
        let on_tendon = self.trntype.get(actuator) == Some(&TENDON_TRANSMISSION);
        index(self.trnid.get(2 * actuator)).filter(|&tendon| on_tendon && tendon < self.tendons)
    }

    /// Whether an actuator is a cable.
    pub(crate) fn is_cable(&self, actuator: usize) -> bool {
        let instance = index(self.actuator_plugin.get(actuator));
        instance.and_then(|instance| self.plugin.get(instance)) == Some(&self.cables)
    }

    /// Address of an actuator's force in `actuator_force`; its gear stands at six times that.
    pub(crate) fn force_address(&self, actuator: usize) -> usize {
        index(self.outadr.get(actuator)).unwrap_or(actuator)
    }

    /// Length of a tendon per length of an actuator's transmission.
    pub(crate) fn gear_of(&self, address: usize) -> f64 {
        self.gear.get(6 * address).copied().unwrap_or(0.0)
    }

    /// Range of an actuator's force, whether or not MuJoCo applies it; nothing where it is empty.
    pub(crate) fn range_of(&self, actuator: usize) -> Option<[f64; 2]> {
        let range = self.forcerange.get(2 * actuator..2 * actuator + 2)?;
        (range[0] < range[1]).then(|| [range[0], range[1]])
    }
}
