//! Functional mock-up units for co-simulation, FMI 3.0 and 2.0: around the exported C of a model, or around a
//! plant that a process of the program simulates.

mod binary;
mod description;
mod plant;
mod terminals;
mod unit_of;
mod variables;
mod version;
mod zip;

pub use binary::PLATFORM;
pub use plant::{Plant, Port};
pub use version::Version;

use crate::c::{self, Content, Filling, double};
use crate::{ExportError, ExportedFile, Name};
use description::Description;
use sinew::predictor::Model;
use std::path::Path;
use variables::Interface;

/// A unit before it is packed.
#[derive(Debug)]
pub struct Unit {
    name: Name,
    version: Version,
    sources: Vec<ExportedFile>,
    /// Everything but sources and binaries.
    rest: Vec<ExportedFile>,
}

impl Unit {
    /// A model's predictor or compensator.
    ///
    /// # Errors
    /// As [`c::library`].
    pub fn of_model(
        model: &Model,
        name: &Name,
        content: Content,
        version: Version,
    ) -> Result<Self, ExportError> {
        let library = Vec::from(c::library(model, name, content)?);
        let interface = Interface::new(model, content);
        let mut filling = Filling::default();
        filling.when("inverse", interface.near.is_some());
        filling.when("cable", model.estimator.law.cable.is_some());
        filling.set("failure", "no sample was taken");
        Self::new(name, version, &interface.description()?, filling, library)
    }

    /// A plant that the program `sinew` simulates in a process of its own.
    ///
    /// # Errors
    /// [`ExportError::Archive`] for a plant without inputs or outputs.
    pub fn of_plant(plant: &Plant, name: &Name, version: Version) -> Result<Self, ExportError> {
        if plant.inputs.is_empty() || plant.outputs.is_empty() {
            return Err(ExportError::Archive("a plant needs inputs and outputs".to_owned()));
        }
        let mut filling = Filling::default();
        filling.when("plant", true);
        filling.set("failure", "the program sinew did not do it; what it said is on standard error");
        let mut unit = Self::new(name, version, &plant.description(), filling, Vec::new())?;
        unit.rest.push(ExportedFile::text("resources/plant.json", plant.file.clone()));
        Ok(unit)
    }

    fn new(
        name: &Name,
        version: Version,
        description: &Description,
        mut filling: Filling,
        mut sources: Vec<ExportedFile>,
    ) -> Result<Self, ExportError> {
        let starts = description.starts();
        filling.set("inputs", starts.len());
        let start = |x: f64| if x.is_nan() { "NAN".to_owned() } else { double(x) };
        filling.set("starts", starts.into_iter().map(start).collect::<Vec<_>>().join(", "));
        filling.set("token", &description.token);
        let [numbers, flags] = description.outputs();
        filling.set("numbers", numbers);
        filling.set("flags", flags);
        let mut rest = vec![ExportedFile::text("modelDescription.xml", description.xml(name, version))];
        if version == Version::Three {
            rest.push(ExportedFile::text("terminalsAndIcons/terminalsAndIcons.xml", description.terminals()));
            rest.push(ExportedFile::text("sources/buildDescription.xml", description.build(name)));
        }
        sources.push(ExportedFile::text("core.h", filling.render(include_str!("templates/core.h"), name)));
        let text = filling.render(&version.template(), name);
        sources.push(ExportedFile::text(format!("{}.c", version.stem()), text));
        Ok(Self { name: name.clone(), version, sources, rest })
    }

    /// The sources, which importers compile.
    #[must_use]
    pub fn sources(&self) -> &[ExportedFile] {
        &self.sources
    }

    /// The shared library of the unit for this machine; none where there is no such compiler.
    ///
    /// # Errors
    /// [`ExportError::Compiler`] with what the compiler says, where it fails.
    pub fn compile(&self, compiler: &Path) -> Result<Option<Vec<u8>>, ExportError> {
        binary::compile(&self.sources, compiler)
    }

    /// `NAME.fmu`: description, sources, and the binary of [`compile`](Self::compile) where there is one.
    ///
    /// # Errors
    /// [`ExportError::Archive`] beyond the sizes of an archive.
    pub fn file(&self, binary: Option<&[u8]>) -> Result<ExportedFile, ExportError> {
        let mut entries = self.rest.clone();
        let sources = self.sources.iter().cloned();
        entries.extend(sources.map(|s| ExportedFile { path: format!("sources/{}", s.path), ..s }));
        if let Some(bytes) = binary {
            let path = format!("binaries/{}", binary::place(&self.name, self.version));
            entries.push(ExportedFile { path, bytes: bytes.to_vec() });
        }
        Ok(ExportedFile { path: format!("{}.fmu", self.name.as_str()), bytes: zip::archive(&entries)? })
    }
}
