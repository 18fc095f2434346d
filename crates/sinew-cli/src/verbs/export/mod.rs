//! `sinew export`.

mod plant;
mod serve;

use super::read_model;
use crate::answer::{Answer, Content};
use crate::arguments::{ExportArguments, ExportForm, ExportVerb, General, ModelExportArguments, UnitForm};
use crate::arguments::{MachineExportArguments, TwinExportArguments, UnitArguments};
use crate::error::Error;
use crate::output::{Folder, refuse_overwrite, write_all};
use crate::progress::Progress;
use plant::PlantFile;
use sinew::compensator::CompensatorSettings;
use sinew::predictor::Model;
use sinew_export::{ExportedFile, Name, c, fmu, onnx};
use std::path::{Path, PathBuf};

/// What a unit takes time for.
const STAGE: &str = "writing and compiling";

pub(crate) fn run(arguments: &ExportArguments, general: &General) -> Result<Answer, Error> {
    match (&arguments.plant, &arguments.model) {
        (Some(ExportVerb::Twin(arguments)), _) => Progress::during(STAGE, || twin(arguments, general)),
        (Some(ExportVerb::Machine(arguments)), _) => Progress::during(STAGE, || machine(arguments, general)),
        (Some(ExportVerb::Serve { file }), _) => serve::run(file),
        (None, Some(arguments)) => Progress::during(STAGE, || model(arguments, general)),
        // The parser asks for a model where there is no verb.
        (None, None) => Ok(Answer::done(Content::Text(String::new()), Vec::new())),
    }
}

fn model(arguments: &ModelExportArguments, general: &General) -> Result<Answer, Error> {
    let name = name(arguments.name.as_deref(), &arguments.model)?;
    let model = read_model(&arguments.model)?;
    let (out, read) = (&arguments.out, [&arguments.model]);
    let folder = Folder::open(out)?;
    let (files, note) = files(&model, &name, arguments)?;
    let inputs: Vec<&str> = model.inputs.iter().map(|input| input.column.as_str()).collect();
    let said = serde_json::json!({
        "far": model.far, "member": model.provenance.member, "name": name.as_str(), "note": note,
    });
    let text = format!("`{}` from {}; {note}\n", model.far, inputs.join(", "));
    written(&files, out, read, (text, &said), general).inspect(|_| drop(folder))
}

fn twin(arguments: &TwinExportArguments, general: &General) -> Result<Answer, Error> {
    let plant = PlantFile::Cable { specimen: arguments.specimen.text.clone(), start_n: arguments.start };
    unit(&plant, Path::new("cable"), &arguments.unit, general)
}

fn machine(arguments: &MachineExportArguments, general: &General) -> Result<Answer, Error> {
    let source = super::machine_source::load(&arguments.machine, arguments.root.dir.as_deref())?.source;
    let plant = PlantFile::Machine { source, seed: arguments.seed };
    unit(&plant, &arguments.machine, &arguments.unit, general)
}

/// The unit of a plant, which is built once here: what cannot be simulated is refused now.
fn unit(file: &PlantFile, of: &Path, arguments: &UnitArguments, general: &General) -> Result<Answer, Error> {
    let name = name(arguments.name.as_deref(), of)?;
    let version = match arguments.to {
        UnitForm::Fmu => fmu::Version::Three,
        UnitForm::Fmu2 => fmu::Version::Two,
    };
    let folder = Folder::open(&arguments.out)?;
    let plant = file.build()?.describe(serde_json::to_string(file)?);
    let unit = fmu::Unit::of_plant(&plant, &name, version)?;
    let (file, note) = packed(&unit)?;
    let read: [&PathBuf; 0] = [];
    let note = format!("{note}; runs where `sinew` is found on PATH");
    let said = serde_json::json!({"name": name.as_str(), "simulated": true, "note": note});
    let text = format!("{}; {note}\n", plant.description);
    written(&[file], &arguments.out, read, (text, &said), general).inspect(|_| drop(folder))
}

/// Writes the files of an export below a folder.
fn written<'a>(
    files: &[ExportedFile],
    out: &Path,
    read: impl IntoIterator<Item = &'a PathBuf>,
    (text, said): (String, &serde_json::Value),
    general: &General,
) -> Result<Answer, Error> {
    let places: Vec<PathBuf> = files.iter().map(|file| out.join(&file.path)).collect();
    let parents = places.iter().filter_map(|place| place.parent()).filter(|parent| *parent != out);
    let _folders = parents.map(Folder::open).collect::<Result<Vec<_>, _>>()?;
    refuse_overwrite(read, &places, general.no_clobber)?;
    let contents: Vec<_> = places.into_iter().zip(files.iter().map(|file| file.bytes.as_slice())).collect();
    let written = write_all(&contents)?;
    let content = if general.json { Content::json(said)? } else { Content::Text(text) };
    Ok(Answer::done(content, written))
}

/// The name that was given, or that of a file.
fn name(given: Option<&str>, file: &Path) -> Result<Name, Error> {
    let stem = file.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    Ok(Name::new(given.or(stem.as_deref()).unwrap_or_default())?)
}

/// The files, and how to go on.
fn files(
    model: &Model,
    name: &Name,
    arguments: &ModelExportArguments,
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
    let (file, note) = packed(&fmu::Unit::of_model(model, name, content, version)?)?;
    Ok((vec![file], note))
}

/// The unit with a binary for this machine where there is a compiler, and which it has.
fn packed(unit: &fmu::Unit) -> Result<(ExportedFile, String), Error> {
    let binary = unit.compile(Path::new("cc"))?;
    let note = match &binary {
        Some(_) => format!("binary for {}, sources for all", fmu::PLATFORM),
        None => "sources alone: no C compiler `cc` was found here".to_owned(),
    };
    Ok((unit.file(binary.as_deref())?, note))
}
