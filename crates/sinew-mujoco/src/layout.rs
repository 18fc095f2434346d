//! Fields of MuJoCo's structures that the plugins read or write, and where they are.

/// What a field holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FieldKind {
    /// An integer of 32 or 64 bits, or a `double`, as the width given with the offset says.
    Number,
    /// The address of an array of `double`.
    Reals,
    /// The address of an array of 32-bit integers.
    Integers,
    /// The address of an array of bytes.
    Bytes,
    /// The address of an array of integers of the size of an address.
    Words,
}

/// One field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FieldName {
    /// `STRUCTURE.field`, or `STRUCTURE.member.field`.
    pub path: &'static str,
    /// What it holds.
    pub kind: FieldKind,
    /// Whether every supported version of MuJoCo has it.
    pub required: bool,
}

macro_rules! fields {
    ($($name:ident $path:literal $kind:ident $required:literal,)*) => {
        /// Index of a field in the table of offsets.
        #[derive(Debug, Clone, Copy)]
        pub(crate) enum Field { $($name),* }

        const FIELDS: &[FieldName] =
            &[$(FieldName { path: $path, kind: FieldKind::$kind, required: $required }),*];
    };
}

fields! {
    Timestep "mjModel.opt.timestep" Number true,
    Integrator "mjModel.opt.integrator" Number true,
    Nu "mjModel.nu" Number true,
    Nactuator "mjModel.nactuator" Number false,
    Nout "mjModel.nout" Number false,
    Na "mjModel.na" Number true,
    Ntendon "mjModel.ntendon" Number true,
    Nwrap "mjModel.nwrap" Number true,
    Nplugin "mjModel.nplugin" Number true,
    Npluginstate "mjModel.npluginstate" Number true,
    Nnames "mjModel.nnames" Number true,
    TendonFrictionloss "mjModel.tendon_frictionloss" Reals true,
    ActuatorTrntype "mjModel.actuator_trntype" Integers true,
    ActuatorTrnid "mjModel.actuator_trnid" Integers true,
    ActuatorOutadr "mjModel.actuator_outadr" Integers false,
    ActuatorCtrladr "mjModel.actuator_ctrladr" Integers false,
    ActuatorActadr "mjModel.actuator_actadr" Integers true,
    ActuatorActnum "mjModel.actuator_actnum" Integers true,
    ActuatorPlugin "mjModel.actuator_plugin" Integers true,
    ActuatorGear "mjModel.actuator_gear" Reals true,
    ActuatorForcelimited "mjModel.actuator_forcelimited" Bytes true,
    ActuatorForcerange "mjModel.actuator_forcerange" Reals true,
    Plugin "mjModel.plugin" Integers true,
    PluginStateadr "mjModel.plugin_stateadr" Integers true,
    PluginStatenum "mjModel.plugin_statenum" Integers true,
    Names "mjModel.names" Bytes true,
    NameTendonadr "mjModel.name_tendonadr" Integers true,
    NF "mjData.nf" Number true,
    NE "mjData.ne" Number true,
    Nefc "mjData.nefc" Number true,
    Nisland "mjData.nisland" Number true,
    Time "mjData.time" Number true,
    Act "mjData.act" Reals true,
    Ctrl "mjData.ctrl" Reals true,
    PluginState "mjData.plugin_state" Reals true,
    PluginData "mjData.plugin_data" Words true,
    TenWrapadr "mjData.ten_wrapadr" Integers true,
    TenWrapnum "mjData.ten_wrapnum" Integers true,
    TenLength "mjData.ten_length" Reals true,
    TenVelocity "mjData.ten_velocity" Reals true,
    WrapObj "mjData.wrap_obj" Integers true,
    WrapXpos "mjData.wrap_xpos" Reals true,
    ActuatorForce "mjData.actuator_force" Reals true,
    EfcType "mjData.efc_type" Integers true,
    EfcId "mjData.efc_id" Integers true,
    EfcFrictionloss "mjData.efc_frictionloss" Reals true,
    IefcFrictionloss "mjData.iefc_frictionloss" Reals false,
    MapEfc2iefc "mjData.map_efc2iefc" Integers false,
}

/// The fields in the order in which [`connect_address`](crate::connect_address) takes their places.
#[must_use]
pub fn fields() -> &'static [FieldName] {
    FIELDS
}

/// Where a field is.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// Bytes from the beginning of its structure.
    offset: usize,
    /// Bytes of a number; the sign marks a `double`.
    width: i64,
}

/// Places of all fields in the version of MuJoCo that is loaded.
#[derive(Debug)]
pub(crate) struct Layout {
    places: Vec<Option<Place>>,
}

impl Layout {
    /// Places as the loader has them: offset, negative where the field does not exist, and width of the
    /// number in bytes, negative for a `double`.
    pub(crate) fn new(given: &[[i64; 2]]) -> Result<Self, String> {
        if given.len() != FIELDS.len() {
            return Err(format!("{} fields have places, expected {}", given.len(), FIELDS.len()));
        }
        let place = |(field, &[offset, width]): (&FieldName, &[i64; 2])| {
            let Ok(offset) = usize::try_from(offset) else {
                let missing = || format!("this version of MuJoCo has no field {}", field.path);
                return if field.required { Err(missing()) } else { Ok(None) };
            };
            let allowed: &[i64] = if field.kind == FieldKind::Number { &[4, 8, -8] } else { &[8] };
            if !allowed.contains(&width) {
                return Err(format!("field {} is {width} bytes wide, expected {allowed:?}", field.path));
            }
            Ok(Some(Place { offset, width }))
        };
        Ok(Self { places: FIELDS.iter().zip(given).map(place).collect::<Result<_, _>>()? })
    }

    /// Offset of a field and the width of its number; nothing where this version lacks it.
    pub(crate) fn place(&self, field: Field) -> Option<(usize, i64)> {
        self.places[field as usize].map(|place| (place.offset, place.width))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_that_are_missing_or_of_another_width_are_refused_by_name() {
        let mut given = vec![[8, 8]; FIELDS.len()];
        assert!(Layout::new(&given).is_ok());
        given[Field::Nout as usize] = [-1, 8];
        assert!(Layout::new(&given).unwrap().place(Field::Nout).is_none());
        given[Field::Ntendon as usize] = [-1, 8];
        assert!(Layout::new(&given).unwrap_err().contains("mjModel.ntendon"));
        given[Field::Ntendon as usize] = [8, 2];
        assert!(Layout::new(&given).unwrap_err().contains("mjModel.ntendon"));
        assert!(Layout::new(&given[1..]).is_err());
    }
}
