//! `sinew servos scan`.

use crate::answer::Answer;
use crate::arguments::{General, ServosScanArguments};
use crate::error::Error;
use crate::table::table;
use crate::verbs::beside_file::{Beside, Expected, answer};
use crate::verbs::machine_source::load_machine;
use sinew_runtime::Ttys;
use sinew_runtime::servos::protocol::Protocol;
use sinew_runtime::servos::{BAUD, FoundServo, ServoDevice, ServoError, scan, sts};

pub(super) fn run(arguments: &ServosScanArguments, general: &General) -> Result<Answer, Error> {
    let port = arguments.port.display().to_string();
    let refused = |source| ServoError::Port { port: port.clone(), source };
    let (mut lines, mut found) = (Ttys::default(), Vec::new());
    let rates = &arguments.baud.0;
    lines.open(&port, rates.first().copied().unwrap_or(1_000_000)).map_err(refused)?;
    for &rate in rates {
        // Of many rates an adapter may not have some.
        if lines.set_baud(0, rate).map_err(refused).is_err() && rates.len() > 1 {
            continue;
        }
        for (protocol, known) in [(Protocol::Dynamixel, &BAUD), (Protocol::Feetech, &sts::BAUD)] {
            if known.contains(&rate) {
                let servos = scan(&mut lines, protocol, (0, rate)).map_err(refused)?;
                found.extend(servos.into_iter().map(|servo| (rate, servo)));
            }
        }
    }
    let beside = arguments.machine.as_deref().map(|file| {
        let (_, devices) = load_machine(file, None, arguments.root.dir.as_deref())?;
        let on_port =
            devices.of::<ServoDevice>().iter().filter(|of| of.port.as_ref().is_none_or(|at| *at == port));
        let expected: Vec<Expected> = on_port.map(|device| expected(device, &found)).collect();
        let ids: Vec<u8> = found.iter().map(|(_, servo)| servo.id).collect();
        Ok::<_, Error>(Beside::new(&expected, &ids))
    });
    let beside = beside.transpose()?;
    answer(!found.is_empty(), json(&found), |beside| text(&found, beside), beside.as_ref(), general)
}

/// A servo of the machine file, whose model and rate are compared with what has answered.
fn expected(device: &ServoDevice, found: &[(u32, FoundServo)]) -> Expected {
    let (model, baud) = (&device.model, device.baud);
    let seen = found.iter().find(|(_, servo)| servo.id == device.id);
    let differs = seen.and_then(|(rate, servo)| {
        if model.number.is_some_and(|own| own != servo.number) {
            Some(format!("there {}", model.name))
        } else {
            (*rate != baud).then(|| format!("there at {baud} bit/s"))
        }
    });
    Expected { id: device.id, name: device.name.clone(), differs }
}

fn json(found: &[(u32, FoundServo)]) -> serde_json::Value {
    let servos: Vec<_> = found
        .iter()
        .map(|(rate, servo)| {
            serde_json::json!({
                "id": servo.id, "baud": rate, "protocol": protocol(servo), "model": servo.model(), "model_number": servo.number,
                "firmware": servo.firmware, "hardware_error": servo.alert,
            })
        })
        .collect();
    serde_json::json!({ "found": servos })
}

fn protocol(servo: &FoundServo) -> &'static str {
    match servo.protocol {
        Protocol::Dynamixel => "dynamixel",
        Protocol::Feetech => "feetech",
    }
}

fn text(found: &[(u32, FoundServo)], beside: Option<&Beside>) -> String {
    if found.is_empty() {
        return "no servo answers; check power, wiring and --baud\n".to_owned();
    }
    let rows: Vec<Vec<String>> = found
        .iter()
        .enumerate()
        .map(|(k, (rate, servo))| {
            let model = servo.model().unwrap_or_else(|| format!("unknown {}", protocol(servo)));
            let alert = if servo.alert { "hardware error" } else { "" };
            let numbers = [servo.number.to_string(), servo.firmware.to_string(), alert.to_owned()];
            let of_file = beside.map(|beside| beside.names[k].clone());
            [servo.id.to_string(), rate.to_string(), model]
                .into_iter()
                .chain(numbers)
                .chain(of_file)
                .collect()
        })
        .collect();
    let columns = ["id", "bit/s", "model", "number", "firmware", "", "machine file"];
    match beside {
        None => table(&columns[..6], &rows, 6),
        Some(beside) => table(&columns, &rows, 7) + &beside.text(),
    }
}
