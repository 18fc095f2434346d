//! `modelDescription.xml` and `buildDescription.xml`.

use super::unit_of::BaseUnit;
use super::version::Version;
use crate::Name;
use std::collections::BTreeMap;

const PROGRAM: &str = concat!("Sinew ", env!("CARGO_PKG_VERSION"));

/// What a unit is, whatever it is made of.
pub(super) struct Description {
    pub(super) description: String,
    /// Tells units of different contents apart.
    pub(super) token: String,
    /// In the order of the value references: time, inputs, numbers, flags.
    pub(super) variables: Vec<Variable>,
    /// Usual length of a step, s.
    pub(super) step_s: f64,
    /// Whether it runs with the program alone; then its state cannot be copied.
    pub(super) needs_tool: bool,
}

/// One variable.
pub(super) struct Variable {
    pub(super) name: String,
    pub(super) description: String,
    pub(super) unit: Option<BaseUnit>,
    /// Terminal, and its name there.
    pub(super) terminal: Option<(String, String)>,
    pub(super) kind: VariableKind,
}

pub(super) enum VariableKind {
    Time,
    Input { start: f64 },
    Number,
    Flag,
}

impl Description {
    /// Start values of the inputs.
    pub(super) fn starts(&self) -> Vec<f64> {
        let start = |variable: &Variable| match variable.kind {
            VariableKind::Input { start } => Some(start),
            _ => None,
        };
        self.variables.iter().filter_map(start).collect()
    }

    /// Numbers and flags that come out.
    pub(super) fn outputs(&self) -> [usize; 2] {
        let count = |is: fn(&VariableKind) -> bool| self.variables.iter().filter(|v| is(&v.kind)).count();
        [count(|kind| matches!(kind, VariableKind::Number)), count(|kind| matches!(kind, VariableKind::Flag))]
    }

    /// `modelDescription.xml`.
    pub(super) fn xml(&self, name: &Name, version: Version) -> String {
        let Self { token, step_s, .. } = self;
        let (name, description) = (name.as_str(), escaped(&self.description));
        let tool = if self.needs_tool { " needsExecutionTool=\"true\"" } else { "" };
        let state =
            |word: &str| format!("\n    canGetAndSetFMU{word}=\"true\" canSerializeFMU{word}=\"true\"");
        let head =
            format!("modelIdentifier=\"{name}\"{tool}\n    canHandleVariableCommunicationStepSize=\"true\"");
        let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
        match version {
            Version::Three => {
                text += &format!(
                    "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"{name}\"\n  \
                     instantiationToken=\"{token}\" description=\"{description}\"\n  \
                     generationTool=\"{PROGRAM}\">\n  <CoSimulation {head}{}/>\n",
                    state("State")
                );
            }
            Version::Two => {
                let model =
                    if self.needs_tool { String::new() } else { format!("<File name=\"{name}.c\"/>") };
                text += &format!(
                    "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"{name}\" guid=\"{token}\"\n  \
                     description=\"{description}\"\n  \
                     generationTool=\"{PROGRAM}\">\n  <CoSimulation {head}{}>\n    \
                     <SourceFiles>{model}<File name=\"fmi2.c\"/></SourceFiles>\n  </CoSimulation>\n",
                    state("state")
                );
            }
        }
        text += &format!("  <UnitDefinitions>\n{}  </UnitDefinitions>\n", units(&self.variables));
        text +=
            &format!("  <DefaultExperiment startTime=\"0\" stepSize=\"{step_s}\"/>\n  <ModelVariables>\n");
        let variables = self.variables.iter().enumerate();
        text += &variables.map(|(k, variable)| variable.xml(k, version)).collect::<String>();
        text += "  </ModelVariables>\n  <ModelStructure>\n";
        text += &structure(&self.variables, version);
        text + "  </ModelStructure>\n</fmiModelDescription>\n"
    }

    /// How an importer compiles the sources of FMI 3.0.
    pub(super) fn build(&self, name: &Name) -> String {
        let name = name.as_str();
        let model = format!("      <SourceFile name=\"{name}.c\"/>\n");
        let model = if self.needs_tool { "" } else { &model };
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiBuildDescription fmiVersion=\"3.0\">\n  \
             <BuildConfiguration modelIdentifier=\"{name}\">\n    <SourceFileSet language=\"C99\">\n{model}      \
             <SourceFile name=\"fmi3.c\"/>\n    </SourceFileSet>\n  \
             </BuildConfiguration>\n</fmiBuildDescription>\n"
        )
    }
}

impl Variable {
    /// The time of the unit.
    pub(super) fn time() -> Self {
        let description = "time of the last sample".to_owned();
        let unit = Some(("s", "s=\"1\""));
        Self { name: "time".to_owned(), description, unit, terminal: None, kind: VariableKind::Time }
    }

    fn xml(&self, reference: usize, version: Version) -> String {
        let (name, description) = (escaped(&self.name), escaped(&self.description));
        let unit = self.unit.map_or_else(String::new, |(unit, _)| format!(" unit=\"{}\"", escaped(unit)));
        let start = if let VariableKind::Input { start } = self.kind {
            format!(" start=\"{start}\"")
        } else {
            String::new()
        };
        let head = format!("name=\"{name}\" valueReference=\"{reference}\" description=\"{description}\"");
        let (causality, variability) = match self.kind {
            VariableKind::Time => ("independent", "continuous"),
            VariableKind::Input { .. } => ("input", "continuous"),
            VariableKind::Number => ("output", "continuous"),
            VariableKind::Flag => ("output", "discrete"),
        };
        let initial = if causality == "output" { " initial=\"calculated\"" } else { "" };
        let head = format!("{head} causality=\"{causality}\" variability=\"{variability}\"{initial}");
        let flag = matches!(self.kind, VariableKind::Flag);
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
    let comes_out = |kind: &VariableKind| matches!(kind, VariableKind::Number | VariableKind::Flag);
    let outputs = || variables.iter().enumerate().filter(|(_, v)| comes_out(&v.kind)).map(|(k, _)| k);
    match version {
        Version::Three => {
            let line = |what: &str, k: usize| format!("    <{what} valueReference=\"{k}\"/>\n");
            let listed = outputs().map(|k| line("Output", k));
            listed.chain(outputs().map(|k| line("InitialUnknown", k))).collect()
        }
        Version::Two => {
            // Indices count from one.
            let list = outputs().map(|k| format!("<Unknown index=\"{}\"/>", k + 1)).collect::<String>();
            format!("    <Outputs>{list}</Outputs>\n    <InitialUnknowns>{list}</InitialUnknowns>\n")
        }
    }
}

fn units(variables: &[Variable]) -> String {
    let used: BTreeMap<&str, &str> = variables.iter().filter_map(|variable| variable.unit).collect();
    let line = |(name, base): (&&str, &&str)| {
        format!("    <Unit name=\"{}\"><BaseUnit {base}/></Unit>\n", escaped(name))
    };
    used.iter().map(line).collect()
}

/// Text for an attribute; what XML cannot hold becomes a question mark.
pub(super) fn escaped(text: &str) -> String {
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
