//! `modelDescription.xml` and `buildDescription.xml`.

use super::sources::Version;
use super::variables::{Interface, unit};
use crate::c::Content;
use crate::{ExportError, Name};
use sinew::predictor::Model;
use std::collections::BTreeMap;

const PROGRAM: &str = concat!("Sinew ", env!("CARGO_PKG_VERSION"));

/// One variable, in the order of the value references.
struct Variable {
    reference: usize,
    name: String,
    description: String,
    unit: Option<&'static str>,
    kind: Kind,
}

enum Kind {
    Time,
    Input { start: f64 },
    Number,
    Flag,
}

/// The description of a unit.
pub(super) fn model_description(
    model: &Model,
    name: &Name,
    content: Content,
    version: Version,
) -> Result<String, ExportError> {
    let interface = Interface::new(model, content);
    let variables = variables(&interface);
    let (far, member) = (&model.far, &model.provenance.member);
    let description = match interface.near {
        None => format!("{far} predicted by `{member}`"),
        Some(near) => format!("{} for a desired {far}, by `{member}`", model.inputs[near].column),
    };
    let (description, token) = (escaped(&description), interface.token()?);
    let name = name.as_str();
    let units = units(model);
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    match version {
        Version::Three => {
            text += &format!(
                "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"{name}\"\n  \
                 instantiationToken=\"{token}\" description=\"{description}\"\n  \
                 generationTool=\"{PROGRAM}\">\n  <CoSimulation modelIdentifier=\"{name}\"\n    \
                 canHandleVariableCommunicationStepSize=\"true\"\n    \
                 canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\"/>\n"
            );
        }
        Version::Two => {
            text += &format!(
                "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"{name}\" guid=\"{token}\"\n  \
                 description=\"{description}\"\n  \
                 generationTool=\"{PROGRAM}\">\n  <CoSimulation modelIdentifier=\"{name}\"\n    \
                 canHandleVariableCommunicationStepSize=\"true\"\n    \
                 canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\">\n    \
                 <SourceFiles><File name=\"{name}.c\"/><File name=\"fmi2.c\"/></SourceFiles>\n  \
                 </CoSimulation>\n"
            );
        }
    }
    if !units.is_empty() {
        text += &format!("  <UnitDefinitions>\n{units}  </UnitDefinitions>\n");
    }
    text += "  <DefaultExperiment startTime=\"0\" stepSize=\"0.001\"/>\n  <ModelVariables>\n";
    text += &variables.iter().map(|variable| variable.xml(version)).collect::<String>();
    text += "  </ModelVariables>\n  <ModelStructure>\n";
    text += &structure(&variables, version);
    Ok(text + "  </ModelStructure>\n</fmiModelDescription>\n")
}

/// How an importer compiles the sources of FMI 3.0.
pub(super) fn build_description(name: &Name) -> String {
    let name = name.as_str();
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiBuildDescription fmiVersion=\"3.0\">\n  \
         <BuildConfiguration modelIdentifier=\"{name}\">\n    <SourceFileSet language=\"C99\">\n      \
         <SourceFile name=\"{name}.c\"/>\n      <SourceFile name=\"fmi3.c\"/>\n    </SourceFileSet>\n  \
         </BuildConfiguration>\n</fmiBuildDescription>\n"
    )
}

fn variables(interface: &Interface<'_>) -> Vec<Variable> {
    let mut list = vec![Variable {
        reference: 0,
        name: "time".to_owned(),
        description: "time of the last sample".to_owned(),
        unit: Some("s"),
        kind: Kind::Time,
    }];
    let model = interface.model;
    let unit_of = |column: &str| unit(column).map(|(unit, _)| unit);
    let inputs = interface.columns().into_iter().zip(interface.input_names()).zip(interface.starts());
    for (k, ((column, name), start)) in inputs.enumerate() {
        let limits = &model.guards[k];
        let description = if interface.near == Some(k) {
            "desired".to_owned()
        } else {
            format!("{} to {} in training", limits.low, limits.high)
        };
        let (reference, unit) = (list.len(), unit_of(column));
        list.push(Variable { reference, name, description, unit, kind: Kind::Input { start } });
    }
    for (k, &(name, description, side)) in interface.numbers.iter().enumerate() {
        let column = interface.column_of(side);
        let description = match column {
            Some(column) if k == 0 => format!("{description}: {column}"),
            _ => description.to_owned(),
        };
        let (reference, unit) = (list.len(), column.and_then(unit_of));
        list.push(Variable { reference, name: name.to_owned(), description, unit, kind: Kind::Number });
    }
    for &(name, description) in interface.flags {
        let (name, description) = (name.to_owned(), description.to_owned());
        list.push(Variable { reference: list.len(), name, description, unit: None, kind: Kind::Flag });
    }
    list
}

impl Variable {
    fn xml(&self, version: Version) -> String {
        let (name, description) = (escaped(&self.name), escaped(&self.description));
        let unit = self.unit.map_or_else(String::new, |unit| format!(" unit=\"{}\"", escaped(unit)));
        let start =
            if let Kind::Input { start } = self.kind { format!(" start=\"{start}\"") } else { String::new() };
        let head =
            format!("name=\"{name}\" valueReference=\"{}\" description=\"{description}\"", self.reference);
        let (causality, variability) = match self.kind {
            Kind::Time => ("independent", "continuous"),
            Kind::Input { .. } => ("input", "continuous"),
            Kind::Number => ("output", "continuous"),
            Kind::Flag => ("output", "discrete"),
        };
        let initial = if causality == "output" { " initial=\"calculated\"" } else { "" };
        let head = format!("{head} causality=\"{causality}\" variability=\"{variability}\"{initial}");
        let flag = matches!(self.kind, Kind::Flag);
        match (version, flag) {
            (Version::Three, false) => format!("    <Float64 {head}{unit}{start}/>\n"),
            (Version::Three, true) => format!("    <Boolean {head}/>\n"),
            (Version::Two, false) => {
                format!("    <ScalarVariable {head}><Real{unit}{start}/></ScalarVariable>\n")
            }
            (Version::Two, true) => format!("    <ScalarVariable {head}><Boolean/></ScalarVariable>\n"),
        }
    }
}

/// Outputs and initial unknowns; every output depends on every input, which is the default.
fn structure(variables: &[Variable], version: Version) -> String {
    let outputs = || variables.iter().filter(|v| matches!(v.kind, Kind::Number | Kind::Flag));
    match version {
        Version::Three => {
            let line =
                |what: &str, v: &Variable| format!("    <{what} valueReference=\"{}\"/>\n", v.reference);
            let listed = outputs().map(|v| line("Output", v));
            listed.chain(outputs().map(|v| line("InitialUnknown", v))).collect()
        }
        Version::Two => {
            // Indices count from one.
            let list =
                outputs().map(|v| format!("<Unknown index=\"{}\"/>", v.reference + 1)).collect::<String>();
            format!("    <Outputs>{list}</Outputs>\n    <InitialUnknowns>{list}</InitialUnknowns>\n")
        }
    }
}

fn units(model: &Model) -> String {
    let columns = model.inputs.iter().map(|input| input.column.as_str()).chain([model.far.as_str()]);
    let mut used: BTreeMap<&str, &str> = columns.filter_map(unit).collect();
    used.insert("s", "s=\"1\"");
    let line = |(name, base): (&&str, &&str)| {
        format!("    <Unit name=\"{}\"><BaseUnit {base}/></Unit>\n", escaped(name))
    };
    used.iter().map(line).collect()
}

/// Text for an attribute; what XML cannot hold becomes a question mark.
fn escaped(text: &str) -> String {
    let mut safe = String::new();
    for c in text.chars() {
        match c {
            '&' => safe += "&amp;",
            '<' => safe += "&lt;",
            '>' => safe += "&gt;",
            '"' => safe += "&quot;",
            '\'' => safe += "&apos;",
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => safe.push('?'),
            c => safe.push(c),
        }
    }
    safe
}
