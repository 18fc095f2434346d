//! What an environment is made of, for a simulator of many worlds: as JSON, in the order of its muscles.

use serde_json::{Value, json};
use sinew::Error;
use sinew::body::PathElement;
use sinew::body::TendonPath;
use sinew::drive::{Drive, DriveParameters};
use sinew::machine::Task as Space;
use sinew::transmission::cable::{CableLaw, NodeLaw, WeakeningForm};
use sinew::twin::arm::Failure;
use sinew_gym::{Actuation, Environment, EnvironmentDesign};

/// What all environments of a design share.
pub(crate) fn design(design: &EnvironmentDesign) -> Result<Value, Error> {
    let (machine, settings) = (design.machine(), design.settings());
    let parts = machine.robot.parts();
    let (site, axes) = match machine.task {
        Space::EndPoint { site, axes } => (Some(parts.sites[site].name.as_str()), axes),
        Space::Joints => (None, [false; 3]),
    };
    let encoders: Vec<f64> = design
        .encoded()
        .iter()
        .filter_map(|k| machine.encoders[*k].map(|encoder| encoder.resolution))
        .collect();
    let (parts_of_cycle, step) = design.steps_of_cycle();
    let drives = machine.muscles.iter().map(|muscle| drive(&muscle.drive));
    Ok(json!({
        "actuation": match settings.actuation {
            Actuation::Torque => 0,
            Actuation::Speed => 1,
            Actuation::Tension => 2,
        },
        "cycles": design.cycles(), "parts": parts_of_cycle, "step_s": step,
        "interval_s": 1e-3 * f64::from(settings.interval_ms), "steps": settings.steps,
        "effort": settings.effort, "longest_delay_ms": design.longest_delay_ms(), "half_error": design.half_error(),
        "site": site, "axes": axes, "ranges": design.ranges(), "encoded": design.encoded(),
        "resolutions": encoders, "drives": drives.collect::<Result<Vec<_>, _>>()?,
    }))
}

/// The numbers of a drive.
fn drive(drive: &DriveParameters) -> Result<Value, Error> {
    let DriveParameters { motor, reducer, winch, encoder, load_cell, .. } = drive;
    let arms: Vec<f64> = (0..winch.layers).map(|layer| winch.arm(layer)).collect();
    // Where the winch stands and what the encoder counts in the beginning, half of the drum wound.
    let begin = Drive::new(*drive, 0)?;
    Ok(json!({
        "torque_constant": motor.torque_constant, "resistance": motor.resistance,
        "inductance": motor.inductance, "inertia": motor.inertia, "voltage": motor.voltage,
        "peak_current": motor.peak_current, "top_speed": motor.top_speed,
        "winding_to_housing": motor.winding_to_housing, "housing_to_air": motor.housing_to_air,
        "winding_capacity": motor.winding_capacity, "housing_capacity": motor.housing_capacity,
        "hottest": motor.hottest, "ratio": reducer.ratio, "efficiency": reducer.efficiency,
        "friction": reducer.friction, "viscous": reducer.viscous, "backlash": reducer.backlash,
        "ripple": reducer.ripple, "ripple_per_turn": reducer.ripple_per_turn,
        "full": winch.full(), "wound": begin.wound(), "arms": arms,
        "counts": encoder.counts, "zero": encoder.zero,
        "offset": load_cell.offset, "noise": load_cell.noise, "resolution": load_cell.resolution,
        "range": load_cell.range, "has_load_cell": f64::from(u8::from(drive.has_load_cell)),
        "acceleration": drive.acceleration, "max_tension": drive.max_tension,
        "min_tension": drive.min_tension,
    }))
}

/// The episode that an environment is in, at its beginning.
pub(crate) fn episode(environment: &Environment) -> Result<Value, Error> {
    let (design, twin) = (environment.design(), environment.twin());
    let (specimen, truth) = (twin.specimen(), twin.truth());
    let parts = specimen.robot.parts();
    let cells = design.resolution().cells;
    let laws = specimen.cables.iter().map(|cable| cable.law(cells)).collect::<Result<Vec<_>, _>>()?;
    let cables: Vec<Value> = laws
        .iter()
        .zip(&specimen.cables)
        .map(|(law, cable)| {
            let breaks = cable.effects.breakage.map_or(f64::MAX, |breakage| breakage.tension);
            law_of(law, cable.parameters.friction, breaks)
        })
        .collect();
    let sheath = |tendon: &sinew::body::Tendon| {
        let TendonPath::Spatial(elements) = &tendon.path else { return Value::Null };
        let first = elements.iter().find_map(|element| match element {
            PathElement::Site(site) => Some(*site),
            _ => None,
        });
        let axis = tendon.sheath.as_ref().and_then(|sheath| sheath.end_axis);
        match first.zip(axis) {
            Some((site, axis)) => json!([parts.bodies[parts.sites[site].body].name, axis]),
            None => Value::Null,
        }
    };
    let pushes = twin.faults().iter().filter_map(|fault| match fault.failure {
        Failure::Push { joint, torque } => Some(json!([fault.start, fault.duration, joint, torque])),
        _ => None,
    });
    let encoders = design.encoded().iter().filter_map(|k| specimen.encoders[*k]);
    let targets = environment.targets()?;
    Ok(json!({
        "mjcf": sinew::description::to_mjcf(parts),
        "pose": specimen.robot.pose_from_independent(truth.q)?,
        "tension_n": truth.cables.iter().map(|cable| cable.tension_out).collect::<Vec<_>>(),
        "cables": cables,
        "sheaths": parts.tendons.iter().map(sheath).collect::<Vec<_>>(),
        "stops": twin.stops().map(|stop| stop.map(|x| x.clamp(-1e30, 1e30))).collect::<Vec<_>>(),
        "winches": specimen.winches,
        "gains": specimen.drives.iter().map(|drive| drive.load_cell.gain).collect::<Vec<_>>(),
        "delays_ms": specimen.drives.iter().map(|drive| drive.delay_ms).collect::<Vec<_>>(),
        "encoders": encoders.map(|e| [e.zero, e.eccentricity[0], e.eccentricity[1]]).collect::<Vec<_>>(),
        "delay_ms": environment.delay_ms(),
        "seed": environment.seed(),
        "pushes": pushes.collect::<Vec<_>>(),
        "targets": targets.iter().map(|target| [&target.pose[..], &target.rate, &target.point].concat()).collect::<Vec<_>>(),
    }))
}

/// A cable as built.
fn law_of(law: &CableLaw, friction: f64, breaks: f64) -> Value {
    let column = |of: fn(&NodeLaw) -> f64| law.nodes().iter().map(of).collect::<Vec<_>>();
    let (node, wrap) = law.last_pulley().unwrap_or((0, 0.0));
    let slow = law.weakening().map_or([0.0, 1.0, 1.0, 0.0], |slow| {
        [slow.rise, slow.speed, slow.lag, f64::from(u8::from(slow.form == WeakeningForm::Gaussian))]
    });
    let [_, fade] = law.drag();
    json!({
        "compliance": law.compliance(), "friction": column(|node| node.friction),
        "loss": column(|node| node.loss), "viscous": column(|node| node.viscous),
        "drag": column(|node| node.drag), "drag_fade": fade, "pretension": law.pretension(),
        "pulley": node, "wrap": wrap, "mu": friction, "weakening": slow, "breaks": breaks,
    })
}
