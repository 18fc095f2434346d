//! `sinew example`.

use crate::answer::{Answer, Content};
use crate::arguments::{ExampleArguments, ExampleName, General};
use crate::error::Error;
use crate::output::{Folder, refuse_overwrite, write_all};
use clap::ValueEnum;
use sinew_lab::simulated::demo_logs;
use std::fmt::Write;

/// What to begin with behind one door.
struct Example {
    about: &'static str,
    files: Vec<(&'static str, String)>,
    commands: [&'static str; 3],
}

pub(crate) fn run(arguments: &ExampleArguments, general: &General) -> Result<Answer, Error> {
    let Some(name) = arguments.name else { return list(general) };
    let (example, name) = (example(name), spelling(name));
    let out = arguments.out.clone().unwrap_or_else(|| name.clone().into());
    let folder = Folder::open(&out)?;
    let commands: String = example.commands.map(|command| format!("  {command}\n")).concat();
    let notes = format!("{}\n\n{commands}", example.about);
    let mut files = example.files;
    files.push(("README.txt", notes.clone()));
    let files: Vec<_> = files.iter().map(|(name, text)| (folder.file(name), text.as_bytes())).collect();
    let places: Vec<_> = files.iter().map(|(place, _)| place.clone()).collect();
    refuse_overwrite([], &places, general.no_clobber)?;
    let written = write_all(&files)?;
    let content = if general.json {
        Content::json(&serde_json::json!({ "name": name, "commands": example.commands }))?
    } else {
        Content::Text(format!("{notes}\nThe commands are for the folder {}.\n", out.display()))
    };
    Ok(Answer::done(content, written))
}

/// The examples, one a line.
fn list(general: &General) -> Result<Answer, Error> {
    let all = ExampleName::value_variants().iter().map(|name| (spelling(*name), example(*name).about));
    let content = if general.json {
        let all: Vec<_> =
            all.map(|(name, about)| serde_json::json!({ "name": name, "about": about })).collect();
        Content::json(&serde_json::json!({ "examples": all }))?
    } else {
        // Writing to a string cannot fail.
        Content::Text(all.fold(String::new(), |mut text, (name, about)| {
            let _ = writeln!(text, "{name:<10}{about}");
            text
        }))
    };
    Ok(Answer::done(content, Vec::new()))
}

/// As it is typed.
fn spelling(name: ExampleName) -> String {
    name.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
}

fn example(name: ExampleName) -> Example {
    match name {
        ExampleName::Bench => Example {
            about: "SIMULATED logs of a cable whose both ends are measured: fit a model, score it on another day, \
                    predict.",
            files: bench(),
            commands: [
                "sinew identify simulated_day_1.csv simulated_day_2.csv simulated_day_3.csv simulated_day_4.csv \
                 --model observer,hybrid,linear --out model",
                "sinew evaluate model/model.json simulated_day_5.csv",
                "sinew predict model/model.json simulated_day_5.csv --out far.csv",
            ],
        },
        ExampleName::Hand => Example {
            about: "A hand of joints alone: give it cords and drives, see what limits it, move it in simulation.",
            files: vec![("hand.urdf", sinew_models::HAND_URDF.to_owned())],
            commands: [
                "sinew machine new hand.urdf --pulleys 8mm --out hand.toml",
                "sinew machine tune hand.toml",
                "sinew track hand.toml --report hand.html",
            ],
        },
        ExampleName::Training => Example {
            about: "Python: a tendon finger in MuJoCo with and without sheaths, a policy with and without friction.",
            files: vec![
                ("tendon_hand.py", include_str!("../../examples/training/tendon_hand.py").to_owned()),
                ("train_policy.py", include_str!("../../examples/training/train_policy.py").to_owned()),
            ],
            commands: ["pip install mujoco gymnasium", "python tendon_hand.py", "python train_policy.py 20"],
        },
        ExampleName::Bus => Example {
            about: "A leg on serial servos or CAN: run it simulated, scan a port, run the real one.",
            files: vec![("leg.toml", bus())],
            commands: [
                "sinew run leg.toml --bus chain --virtual-time --duration 10",
                "sinew servos scan /dev/ttyUSB0",
                "sinew run leg.toml --bus servos --interface /dev/ttyUSB0 --duration 10",
            ],
        },
    }
}

/// Four days to fit and one to judge.
fn bench() -> Vec<(&'static str, String)> {
    let names = [
        "simulated_day_1.csv",
        "simulated_day_2.csv",
        "simulated_day_3.csv",
        "simulated_day_4.csv",
        "simulated_day_5.csv",
    ];
    names.into_iter().zip(demo_logs(1).into_iter().map(|(_, text)| text)).collect()
}

/// A leg without load cells and encoders at its joints, as servos and drives on CAN move it.
fn bus() -> String {
    let leg = sinew_models::PLANAR_LEG;
    leg.replacen("name = \"planar_leg\"\n", "name = \"bus_leg\"\nperiod_s = 0.004\n", 1)
        + "\n# As nothing else is said, every muscle has a device, with the ids 1, 2, ... in their order.\n\
           [every_transmission]\nload_cell = \"none\"\n\n[every_joint_encoder]\nnone = true\n"
}
