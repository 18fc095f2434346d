//! The only file with `unsafe`: MuJoCo's structures as slices, the callbacks, the registration.
//!
//! # Safety
//! What all blocks rely on:
//! - The loader gave addresses of functions of MuJoCo with the signatures that [`Connect`] states, and
//!   offsets that it compared with the addresses of MuJoCo's own arrays; callbacks run only after a
//!   registration with them.
//! - MuJoCo calls with a valid `mjModel` and, where there is one, an `mjData` made for it, of which no other
//!   thread writes the same arrays. The arrays have the lengths that the comments of `mjmodel.h` and
//!   `mjdata.h` state; arrays of `mjModel` and `mjData`, and of the latter among each other, do not overlap.
//! - No panic leaves a callback.
#![allow(unsafe_code, reason = "a foreign interface: pointers in, slices out")]

use crate::cable::Cables;
use crate::layout::{Field, Layout};
use crate::plugin::{Plugin, Setup};
use crate::sheath::Sheaths;
use crate::text::Config;
use crate::view::{Data, Model};
use crate::wiring::hash_of;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::OnceLock;

type Address = *const c_void;
type GetConfig = unsafe extern "C" fn(Address, c_int, *const c_char) -> *const c_char;
type Register = unsafe extern "C" fn(*const Registration) -> c_int;
type Warn = unsafe extern "C" fn(*const c_char, ...);

/// What the loader hands over, as a structure of C.
#[repr(C)]
struct Connect {
    /// `int mjp_registerPlugin(const mjpPlugin*)`.
    register: Option<Register>,
    /// `const char* mj_getPluginConfig(const mjModel*, int, const char*)`.
    get_config: Option<GetConfig>,
    /// `void mju_warning(const char*, ...)`.
    warn: Option<Warn>,
    /// Offset and width of every field, in the order of [`fields`](crate::fields).
    places: *const [i64; 2],
    count: usize,
}

/// MuJoCo as it is loaded.
struct Connection {
    layout: Layout,
    /// Slots of the plugins, in the order of [`REGISTRATIONS`].
    slots: [c_int; 2],
    get_config: GetConfig,
    warn: Warn,
}

static CONNECTION: OnceLock<Connection> = OnceLock::new();

/// Address of `int connect(const Connect*, char* message, size_t size)`.
///
/// ```text
/// struct Connect { mjp_registerPlugin, mj_getPluginConfig, mju_warning, int64_t places[count][2], size_t count }
/// ```
///
/// Registers both plugins with the MuJoCo that is loaded; returns 0, or -1 with the reason in `message`. A
/// place is the offset of a field of [`fields`](crate::fields) in bytes, -1 where it does not exist, and the
/// width of its number, negative for `double`; 8 for addresses. A second call of a process does nothing.
#[must_use]
pub fn connect_address() -> usize {
    connect as *const () as usize
}

unsafe extern "C" fn connect(given: *const Connect, message: *mut c_char, size: usize) -> c_int {
    let done = catch_unwind(|| {
        // SAFETY: the loader passes a valid structure whose `places` has `count` entries.
        let given = unsafe { given.as_ref() }.ok_or("no structure")?;
        let (Some(register), Some(get_config), Some(warn)) = (given.register, given.get_config, given.warn)
        else {
            return Err("a function of MuJoCo is missing".to_owned());
        };
        if CONNECTION.get().is_some() {
            return Ok(());
        }
        // SAFETY: as above.
        let places = unsafe { slice(given.places, given.count) };
        let layout = Layout::new(places)?;
        // SAFETY: `register` is `mjp_registerPlugin`, which copies the structure; its texts are static.
        let slots = REGISTRATIONS.each_ref().map(|registration| unsafe { register(registration) });
        if slots.iter().any(|slot| *slot < 0) {
            return Err("MuJoCo refused the plugin".to_owned());
        }
        let connection = Connection { layout, slots, get_config, warn };
        CONNECTION.set(connection).map_err(|_| "two threads connect at once".to_owned())
    });
    let Err(text) = done.unwrap_or_else(|_| Err("internal error".into())) else { return 0 };
    let text: Vec<u8> = text.bytes().filter(|byte| *byte != 0).take(size.saturating_sub(1)).collect();
    if size > 0 && !message.is_null() {
        // SAFETY: the loader's buffer has `size` bytes; the text and its end are no longer.
        unsafe {
            message.cast::<u8>().copy_from_nonoverlapping(text.as_ptr(), text.len());
            message.add(text.len()).write(0);
        }
    }
    -1
}

/// `mjpPlugin` up to `advance`; what follows is zero in it, more of it than any version has.
#[repr(C)]
struct Registration {
    name: *const c_char,
    attribute_count: c_int,
    attributes: *const *const c_char,
    capabilities: c_int,
    stage: c_int,
    nstate: unsafe extern "C" fn(Address, c_int) -> c_int,
    nsensordata: usize,
    init: unsafe extern "C" fn(Address, Address, c_int) -> c_int,
    destroy: usize,
    copy: usize,
    reset: unsafe extern "C" fn(Address, *mut f64, *mut c_void, c_int),
    compute: unsafe extern "C" fn(Address, Address, c_int, c_int),
    advance: unsafe extern "C" fn(Address, Address, c_int),
    others: [usize; 24],
}

// SAFETY: immutable, with addresses of static texts and functions alone.
unsafe impl Sync for Registration {}

/// Addresses of static texts.
#[repr(transparent)]
struct Texts<const N: usize>([*const c_char; N]);

// SAFETY: as above.
unsafe impl<const N: usize> Sync for Texts<N> {}

static SHEATH_ATTRIBUTES: Texts<1> = Texts([Sheaths::ATTRIBUTES[0].as_ptr()]);

static CABLE_ATTRIBUTES: Texts<3> =
    Texts([Cables::ATTRIBUTES[0].as_ptr(), Cables::ATTRIBUTES[1].as_ptr(), Cables::ATTRIBUTES[2].as_ptr()]);

static REGISTRATIONS: [Registration; 2] = [
    registration::<Sheaths>(SHEATH_ATTRIBUTES.0.as_ptr()),
    registration::<Cables>(CABLE_ATTRIBUTES.0.as_ptr()),
];

const fn registration<P: Plugin>(attributes: *const *const c_char) -> Registration {
    /// `mjPLUGIN_ACTUATOR`.
    const ACTUATOR: c_int = 1;
    Registration {
        name: P::NAME.as_ptr(),
        attribute_count: P::ATTRIBUTES.len() as c_int,
        attributes,
        capabilities: ACTUATOR,
        stage: 0,
        nstate: nstate::<P>,
        nsensordata: 0,
        init: init::<P>,
        destroy: 0,
        copy: 0,
        reset,
        compute: compute::<P>,
        advance: advance::<P>,
        others: [0; 24],
    }
}

unsafe extern "C" fn nstate<P: Plugin>(model: Address, instance: c_int) -> c_int {
    let count = catch_unwind(|| {
        let (connection, instance) = (CONNECTION.get()?, usize::try_from(instance).ok()?);
        // SAFETY: MuJoCo's call, see above. Arrays that are not filled yet are read only as numbers.
        let view = unsafe { connection.model(model) };
        let config = connection.config::<P>(model, instance);
        c_int::try_from(P::state_len(&view, instance, &config)).ok()
    });
    // A configuration without meaning is refused by `init`, which can say so.
    count.ok().flatten().unwrap_or(0)
}

unsafe extern "C" fn init<P: Plugin>(model: Address, data: Address, instance: c_int) -> c_int {
    let Some(connection) = CONNECTION.get() else { return -1 };
    let done = catch_unwind(AssertUnwindSafe(|| {
        let instance = usize::try_from(instance).map_err(|_| "no such instance")?;
        // SAFETY: MuJoCo's call, see above. Of the data, which is being made, only `plugin_data` is used.
        let (view, words) = unsafe { (connection.model(model), connection.plugin_data(data, model)) };
        let word = words.get_mut(instance).ok_or("no such instance")?;
        let configs = connection.configs::<P>(model, &view, instance);
        // Every model is checked, one that hashes like another, too.
        let wiring = P::wire(&Setup { model: &view, instance, configs: &configs })?;
        let hash = hash_of(&view, instance, &configs);
        P::wirings().with_borrow_mut(|wirings| wirings.put(hash, wiring));
        *word = hash as usize;
        Ok::<(), String>(())
    }));
    match done.unwrap_or_else(|_| Err("internal error".into())) {
        Ok(()) => 0,
        Err(text) => {
            connection.warn(&format!("{}: {text}", P::NAME.to_string_lossy()));
            -1
        }
    }
}

unsafe extern "C" fn reset(model: Address, state: *mut f64, _: *mut c_void, instance: c_int) {
    let _ = catch_unwind(|| {
        let (connection, instance) = (CONNECTION.get()?, usize::try_from(instance).ok()?);
        // SAFETY: MuJoCo's call, see above; `state` has the numbers that `nstate` told.
        unsafe {
            let counts: &[i32] =
                connection.array(model, Field::PluginStatenum, connection.number(model, Field::Nplugin));
            let count = usize::try_from(*counts.get(instance)?).ok()?;
            slice_mut(state, count).fill(0.0);
        }
        Some(())
    });
}

unsafe extern "C" fn compute<P: Plugin>(model: Address, data: Address, instance: c_int, _: c_int) {
    // SAFETY: MuJoCo's call, see above.
    unsafe { step::<P>(model, data, instance, P::compute) }
}

unsafe extern "C" fn advance<P: Plugin>(model: Address, data: Address, instance: c_int) {
    // SAFETY: MuJoCo's call, see above.
    unsafe { step::<P>(model, data, instance, P::advance) }
}

/// One call of a step.
unsafe fn step<P: Plugin>(
    model: Address,
    data: Address,
    instance: c_int,
    work: fn(&mut P, &Model<'_>, &mut Data<'_>, usize),
) {
    let (Some(connection), Ok(instance)) = (CONNECTION.get(), usize::try_from(instance)) else { return };
    let done = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: handed on.
        let (view, mut state) = unsafe { (connection.model(model), connection.data(data, model)) };
        let hash = state.plugin_data.get(instance).copied().unwrap_or(0) as u64;
        connection
            .with::<P>(model, &view, instance, hash, |plugin| work(plugin, &view, &mut state, instance));
    }));
    if done.is_err() {
        connection.warn(&format!("{}: internal error", P::NAME.to_string_lossy()));
    }
}

impl Connection {
    fn warn(&self, text: &str) {
        if let Ok(text) = CString::new(text.replace('\0', " ")) {
            // SAFETY: `mju_warning` with a format and the text that it asks for.
            unsafe { (self.warn)(c"%s".as_ptr(), text.as_ptr()) }
        }
    }

    /// Runs `work` with the wiring of this model on this thread, derived where the thread does not have it.
    fn with<P: Plugin>(
        &self,
        model: Address,
        view: &Model<'_>,
        instance: usize,
        hash: u64,
        work: impl FnOnce(&mut P),
    ) {
        let configs = || self.configs::<P>(model, view, instance);
        let hash = if hash == 0 { hash_of(view, instance, &configs()) } else { hash };
        P::wirings().with_borrow_mut(|wirings| {
            let wire = || P::wire(&Setup { model: view, instance, configs: &configs() });
            // What `init` accepted does not fail.
            if let Ok(wiring) = wirings.get(hash, wire) {
                work(wiring);
            }
        });
    }

    /// Configurations of the instances of a plugin up to this one.
    fn configs<P: Plugin>(&self, model: Address, view: &Model<'_>, instance: usize) -> Vec<Config> {
        let slot = view.plugin.get(instance);
        let same = |other: &usize| view.plugin.get(*other) == slot;
        (0..=instance).filter(same).map(|other| self.config::<P>(model, other)).collect()
    }

    fn config<P: Plugin>(&self, model: Address, instance: usize) -> Config {
        let value = |key: &&CStr| {
            // SAFETY: `mj_getPluginConfig` of a valid model; it returns null or a text of the model.
            let text = unsafe { (self.get_config)(model, instance as c_int, key.as_ptr()) };
            if text.is_null() {
                return String::new();
            }
            // SAFETY: as above.
            unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
        };
        P::ATTRIBUTES.iter().map(value).collect()
    }

    /// A number of a structure as 64-bit integer; zero where the version lacks it.
    unsafe fn number(&self, of: Address, field: Field) -> usize {
        let Some((offset, width)) = self.layout.place(field) else { return 0 };
        // SAFETY: the place of a number of this width.
        let value = unsafe {
            let at = of.cast::<u8>().add(offset);
            if width == 4 { i64::from(at.cast::<i32>().read()) } else { at.cast::<i64>().read() }
        };
        usize::try_from(value).unwrap_or(0)
    }

    unsafe fn real(&self, of: Address, field: Field) -> f64 {
        let Some((offset, _)) = self.layout.place(field) else { return 0.0 };
        // SAFETY: the place of a `double`.
        unsafe { of.cast::<u8>().add(offset).cast::<f64>().read() }
    }

    /// The address in a field of a structure; null where the version lacks it.
    unsafe fn address<T>(&self, of: Address, field: Field) -> *mut T {
        let Some((offset, _)) = self.layout.place(field) else { return std::ptr::null_mut() };
        // SAFETY: the place of an address.
        unsafe { of.cast::<u8>().add(offset).cast::<*mut T>().read() }
    }

    unsafe fn array<'a, T>(&self, of: Address, field: Field, count: usize) -> &'a [T] {
        // SAFETY: handed on.
        unsafe { slice(self.address::<T>(of, field), count) }
    }

    unsafe fn array_mut<'a, T>(&self, of: Address, field: Field, count: usize) -> &'a mut [T] {
        // SAFETY: handed on.
        unsafe { slice_mut(self.address::<T>(of, field), count) }
    }

    unsafe fn plugin_data<'a>(&self, data: Address, model: Address) -> &'a mut [usize] {
        // SAFETY: handed on.
        unsafe { self.array_mut(data, Field::PluginData, self.number(model, Field::Nplugin)) }
    }

    /// Numbers of actuators and of their forces: both are that of the controls before MuJoCo 4.
    unsafe fn actuators(&self, m: Address) -> (usize, usize) {
        // SAFETY: handed on.
        unsafe {
            let nu = self.number(m, Field::Nu);
            let or_nu = |field| if self.layout.place(field).is_some() { self.number(m, field) } else { nu };
            (or_nu(Field::Nactuator), or_nu(Field::Nout))
        }
    }

    unsafe fn model<'a>(&self, m: Address) -> Model<'a> {
        // SAFETY: handed on.
        unsafe {
            let (actuators, forces) = self.actuators(m);
            let tendons = self.number(m, Field::Ntendon);
            let plugins = self.number(m, Field::Nplugin);
            Model {
                timestep: self.real(m, Field::Timestep),
                integrator: self.number(m, Field::Integrator) as i64,
                actuators,
                tendons,
                tendon_frictionloss: self.array(m, Field::TendonFrictionloss, tendons),
                trntype: self.array(m, Field::ActuatorTrntype, actuators),
                trnid: self.array(m, Field::ActuatorTrnid, 2 * actuators),
                outadr: self.array(m, Field::ActuatorOutadr, actuators),
                ctrladr: self.array(m, Field::ActuatorCtrladr, actuators),
                actadr: self.array(m, Field::ActuatorActadr, actuators),
                actnum: self.array(m, Field::ActuatorActnum, actuators),
                actuator_plugin: self.array(m, Field::ActuatorPlugin, actuators),
                gear: self.array(m, Field::ActuatorGear, 6 * forces),
                forcelimited: self.array(m, Field::ActuatorForcelimited, actuators),
                forcerange: self.array(m, Field::ActuatorForcerange, 2 * actuators),
                plugin: self.array(m, Field::Plugin, plugins),
                cables: self.slots[1],
                stateadr: self.array(m, Field::PluginStateadr, plugins),
                names: self.array(m, Field::Names, self.number(m, Field::Nnames)),
                name_tendonadr: self.array(m, Field::NameTendonadr, tendons),
            }
        }
    }

    unsafe fn data<'a>(&self, d: Address, m: Address) -> Data<'a> {
        // SAFETY: handed on.
        unsafe {
            let tendons = self.number(m, Field::Ntendon);
            let points = self.number(m, Field::Nwrap);
            let rows = self.number(d, Field::Nefc);
            let first = self.number(d, Field::NE);
            let in_islands = if self.number(d, Field::Nisland) > 0 { rows } else { 0 };
            Data {
                identity: d as usize,
                time: self.real(d, Field::Time),
                act: self.array(d, Field::Act, self.number(m, Field::Na)),
                ctrl: self.array(d, Field::Ctrl, self.number(m, Field::Nu)),
                plugin_state: self.array_mut(d, Field::PluginState, self.number(m, Field::Npluginstate)),
                plugin_data: self.plugin_data(d, m),
                ten_wrapadr: self.array(d, Field::TenWrapadr, tendons),
                ten_wrapnum: self.array(d, Field::TenWrapnum, tendons),
                ten_length: self.array(d, Field::TenLength, tendons),
                ten_velocity: self.array(d, Field::TenVelocity, tendons),
                wrap_obj: self.array(d, Field::WrapObj, 2 * points),
                wrap_xpos: self.array(d, Field::WrapXpos, 6 * points),
                actuator_force: self.array_mut(d, Field::ActuatorForce, self.actuators(m).1),
                friction_rows: first..first + self.number(d, Field::NF),
                efc_type: self.array(d, Field::EfcType, rows),
                efc_id: self.array(d, Field::EfcId, rows),
                efc_frictionloss: self.array_mut(d, Field::EfcFrictionloss, rows),
                iefc_frictionloss: self.array_mut(d, Field::IefcFrictionloss, in_islands),
                map_efc2iefc: self.array(d, Field::MapEfc2iefc, in_islands),
            }
        }
    }
}

/// A slice of what may be null where there is nothing.
unsafe fn slice<'a, T>(at: *const T, count: usize) -> &'a [T] {
    if at.is_null() || count == 0 {
        return &[];
    }
    // SAFETY: the caller knows `count` values at this address.
    unsafe { std::slice::from_raw_parts(at, count) }
}

/// As [`slice`], to be written.
unsafe fn slice_mut<'a, T>(at: *mut T, count: usize) -> &'a mut [T] {
    if at.is_null() || count == 0 {
        return &mut [];
    }
    // SAFETY: the caller knows `count` values at this address, which nobody else uses meanwhile.
    unsafe { std::slice::from_raw_parts_mut(at, count) }
}
