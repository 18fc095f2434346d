//! `sinew servos scan`.

use crate::answer::{Answer, Content, Outcome};
use crate::arguments::{General, ServosScanArguments};
use crate::error::Error;
use crate::table::table;
use sinew_runtime::Ttys;
use sinew_runtime::servos::protocol::Protocol;
use sinew_runtime::servos::{BAUD, FoundServo, ServoError, scan, sts};

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
    let content = if general.json { Content::json(&json(&found))? } else { Content::Text(text(&found)) };
    Ok(Answer { outcome: Outcome::new(!found.is_empty()), content, written: Vec::new() })
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

fn text(found: &[(u32, FoundServo)]) -> String {
    if found.is_empty() {
        return "no servo answers; check power, wiring and --baud\n".to_owned();
    }
    let rows: Vec<Vec<String>> = found
        .iter()
        .map(|(rate, servo)| {
            let model = servo.model().unwrap_or_else(|| format!("unknown {}", protocol(servo)));
            let alert = if servo.alert { "hardware error" } else { "" };
            let numbers = [servo.number.to_string(), servo.firmware.to_string(), alert.to_owned()];
            [servo.id.to_string(), rate.to_string(), model].into_iter().chain(numbers).collect()
        })
        .collect();
    table(&["id", "bit/s", "model", "number", "firmware", ""], &rows, 6)
}
