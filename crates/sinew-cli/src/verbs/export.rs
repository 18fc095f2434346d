//! `sinew export`.

use super::read_model;
use crate::answer::{Answer, Content};
use crate::arguments::{ExportArguments, ExportForm, General};
use crate::error::Error;
use crate::output::{Folder, refuse_overwrite, write_all};
use sinew::compensator::CompensatorSettings;
use sinew::predictor::Model;
use sinew_export::{ExportedFile, Name, c, fmu, onnx};
use std::path::{Path, PathBuf};

pub(crate) fn run(arguments: &ExportArguments, general: &General) -> Result<Answer, Error> {
    let name = name(arguments)?;
    let model = read_model(&arguments.model)?;
    let mut folders = vec![Folder::open(&arguments.out)?];
    let (files, note) = files(&model, &name, arguments)?;
    let places: Vec<PathBuf> = files.iter().map(|file| arguments.out.join(&file.path)).collect();
    for parent in places.iter().filter_map(|place| place.parent()).filter(|parent| *parent != arguments.out) {
        folders.push(Folder::open(parent)?);
    }
    refuse_overwrite([&arguments.model], &places, general.no_clobber)?;
    let contents: Vec<_> = places.into_iter().zip(files.iter().map(|file| file.bytes.as_slice())).collect();
    let written = write_all(&contents)?;
    let content = if general.json {
        Content::json(&serde_json::json!({
            "far": model.far, "member": model.provenance.member, "name": name.as_str(), "note": note,
        }))?
    } else {
        let inputs: Vec<&str> = model.inputs.iter().map(|input| input.column.as_str()).collect();
        Content::Text(format!("`{}` from {}; {note}\n", model.far, inputs.join(", ")))
    };
    Ok(Answer::done(content, written))
}

fn name(arguments: &ExportArguments) -> Result<Name, Error> {
    let stem = arguments.model.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    Ok(Name::new(arguments.name.as_deref().or(stem.as_deref()).unwrap_or_default())?)
}

/// The files, and how to go on.
fn files(
    model: &Model,
    name: &Name,
    arguments: &ExportArguments,
) -> Result<(Vec<ExportedFile>, String), Error> {
    let (content, option) = if arguments.inverse {
        let settings = CompensatorSettings { rate: arguments.max_rate, ..CompensatorSettings::default() };
        (c::Content::Compensator(settings), "--inverse DESIRED.csv")
    } else {
        (c::Content::Predictor, "LOG.csv")
    };
    let version = match arguments.to {
        ExportForm::C => {
            let note = format!("cc {}.c example.c -lm && ./a.out {option}", name.as_str());
            return Ok((c::files(model, name, content)?, note));
        }
        ExportForm::Fmu => fmu::Version::Three,
        ExportForm::Fmu2 => fmu::Version::Two,
        ExportForm::Onnx => {
            let note = "onnxruntime: feed next_state as state, from zeros".to_owned();
            return Ok((vec![onnx::file(model, name, content)?], note));
        }
    };
    let binary = fmu::compile(model, name, content, version, Path::new("cc"))?;
    let note = match &binary {
        Some(_) => format!("binary for {}, sources for all", fmu::PLATFORM),
        None => "sources alone: no C compiler `cc` was found here".to_owned(),
    };
    Ok((vec![fmu::file(model, name, content, version, binary.as_deref())?], note))
}
