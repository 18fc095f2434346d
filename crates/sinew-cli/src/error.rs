//! What ends the program early, and with which exit code.

use crate::table_error::TableError;
use sinew::description::machine::Places;
use sinew_identify::{ColumnRole, Error as IdentifyError};
use sinew_lab::arm::{LateFault, UnknownPart};
use sinew_lab::machine_file::{MachineFileError, TextFileError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// What to do about an address that cannot be listened on.
fn bind_hint(error: &sinew_live::LiveError) -> &'static str {
    match error {
        sinew_live::LiveError::Address { .. } => {
            "; --bind ADDRESS:PORT chooses another, port 0 any that is free"
        }
        _ => "",
    }
}

/// One error; its message names the place, the value and what was expected.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// Between a log and a model.
    #[error("{error}{hint}", error = .0, hint = flag_hint(.0))]
    Identify(#[from] IdentifyError),
    /// What cannot be exported.
    #[error(transparent)]
    Export(#[from] sinew_export::ExportError),
    /// An experiment in simulation.
    #[error(transparent)]
    Experiment(#[from] sinew_lab::Error),
    /// A run on a bus.
    #[error(transparent)]
    Runtime(#[from] sinew_runtime::Error),
    /// A link to a client or machine.
    #[error(transparent)]
    Link(#[from] sinew_link::Error),
    /// A node of ROS 2 that does not start.
    #[error(transparent)]
    Ros(#[from] sinew_ros::Error),
    /// A page that cannot be served.
    #[error("{0}{hint}", hint = bind_hint(.0))]
    Page(#[from] sinew_live::LiveError),
    /// What cannot be done with this machine or shown of it, in words.
    #[error("{0}")]
    Shown(String),
    /// A machine on EtherCAT that does not start.
    #[error(transparent)]
    Ethercat(#[from] sinew_runtime::ethercat::EthercatError),
    /// A machine with servos that does not start.
    #[error(transparent)]
    Servos(#[from] sinew_runtime::servos::ServoError),
    /// A machine on CAN that does not start.
    #[error(transparent)]
    Can(#[from] sinew_runtime::can::CanError),
    /// A bus that does not start.
    #[error(transparent)]
    Bus(#[from] sinew_runtime::BusError),
    /// An interface on which no frames can be exchanged.
    #[error(transparent)]
    Interface(#[from] sinew_segment::RawSocketError),
    /// A simulated device that contradicts itself.
    #[error(transparent)]
    Device(#[from] sinew_segment::DescriptionError),
    /// A sensor that no device of the machine file measures.
    #[error(
        "{0}: no device of the machine file measures it: expected a channel with it, or load_cell = \"none\" or none = \
         true where there is none"
    )]
    Unmeasured(String),
    /// A file with devices that a machine does not have.
    #[error("--device {}: none of its {described} devices is one of the machine file's: {expected}", file.display())]
    ForeignDevices {
        /// The file.
        file: PathBuf,
        /// Number of devices in it.
        described: usize,
        /// The identities in the machine file.
        expected: String,
    },
    /// A model file that cannot be used.
    #[error("{}: {source}", file.display())]
    Model {
        /// The file.
        file: PathBuf,
        /// Why.
        source: Box<sinew::predictor::ModelFileError>,
    },
    /// A recording that would have no end, or that waits for a writer.
    #[error("{}: expected a file on disk, got a device or a pipe", file.display())]
    NotOnDisk {
        /// The file.
        file: PathBuf,
    },
    /// A recording that cannot be written or read.
    #[error("{}: {source}", file.display())]
    Recording {
        /// The file.
        file: PathBuf,
        /// Why.
        source: Box<sinew_record::Error>,
    },
    /// A value refused by the physics.
    #[error(transparent)]
    Physics(#[from] sinew::Error),
    /// A robot file that cannot be used.
    #[error(transparent)]
    Description(Box<sinew::description::DescriptionError>),
    /// A machine or robot file whose extension names no format that can be read.
    #[error(transparent)]
    UnknownFormat(MachineFileError),
    /// A robot file whose extension names no format that can be written.
    #[error("{}: expected a robot file ending in {expected}", file.display())]
    RobotFormat {
        /// The file.
        file: PathBuf,
        /// The extensions of this direction, and other choices.
        expected: &'static str,
    },
    /// `--muscles` with a robot file that has muscles of its own.
    #[error("{}: contains its muscles: expected --muscles with a .urdf file only", file.display())]
    MusclesTwice {
        /// The robot's file.
        file: PathBuf,
    },
    /// A file of gains that cannot be read.
    #[error("{}: {place}: {source}", file.display())]
    GainsFile {
        /// The file.
        file: PathBuf,
        /// Line and key.
        place: String,
        /// What is wrong there.
        source: serde_json::Error,
    },
    /// A name that no part of the robot has, or none of that kind; with the flag that has it.
    #[error("{0} {1}")]
    UnknownPart(&'static str, UnknownPart),
    /// A fault that begins when the run is over.
    #[error("--fault {0}")]
    LateFault(#[from] LateFault),
    /// A row of a table that cannot be used.
    #[error("{}: {source}", file.display())]
    Table {
        /// The file.
        file: PathBuf,
        /// Where and why.
        source: TableError,
    },
    /// A table with too few rows.
    #[error("{}: expected at least 2 {what}, got {got}", file.display())]
    TooFewRows {
        /// The file.
        file: PathBuf,
        /// What a row is.
        what: &'static str,
        /// Number of rows.
        got: usize,
    },
    /// Waypoints through which no path leads.
    #[error("{}: {source}", file.display())]
    Waypoints {
        /// The file.
        file: PathBuf,
        /// Why.
        source: Box<sinew::Error>,
    },
    /// A file of a study that cannot be used.
    #[error("{}: {problem}", file.display())]
    StudyFile {
        /// The file.
        file: PathBuf,
        /// Line, key, expectation and value.
        problem: String,
    },
    /// A file of tension problems that cannot be used.
    #[error("{}: {problem}", file.display())]
    TensionProblems {
        /// The file.
        file: PathBuf,
        /// Place, expectation and value.
        problem: String,
    },
    /// A flag whose value contradicts another argument.
    #[error("{flag} {value}: expected {expected}")]
    Argument {
        /// The flag.
        flag: &'static str,
        /// The value as given.
        value: String,
        /// What would do.
        expected: &'static str,
    },
    /// A path that a robot cannot track.
    #[error("--path {path}: {infeasibility}{}", needed(*long_enough))]
    Infeasible {
        /// The path as given.
        path: String,
        /// When and why.
        infeasibility: Box<sinew::trajectory::Infeasibility>,
        /// A duration with which it could, s.
        long_enough: Option<f64>,
    },
    /// A payload with which a robot cannot track its path.
    #[error("--payload {payload} kg: {infeasibility}")]
    Overloaded {
        /// The payload as given, kg.
        payload: f64,
        /// When and why.
        infeasibility: Box<sinew::trajectory::Infeasibility>,
    },
    /// A motion that simulated machines of the design do not track.
    #[error(
        "{motion}: simulated machines of this design do not track this motion: {reason}; {}--unverified \
            starts it nevertheless",
        if *.slowed { "nor at half and a quarter of its speed; " } else { "a slower motion may help, and " }
    )]
    Untracked {
        /// Flag and value of the payload or path.
        motion: String,
        /// What stopped one of them.
        reason: String,
        /// Whether slower motions were simulated as well.
        slowed: bool,
    },
    /// A file whose text cannot be used.
    #[error(transparent)]
    Text(TextFileError),
    /// A file that cannot be read.
    #[error("{}: cannot be read: {source}", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// An output that exists and may not be replaced.
    #[error("{}: exists already: expected another place, or {remedy}", file.display())]
    Exists {
        /// The file.
        file: PathBuf,
        /// The change of the command line that replaces it.
        remedy: &'static str,
    },
    /// A machine file to write whose name is that of another format.
    #[error("{}: expected a machine file ending in .toml", file.display())]
    MachineFormat {
        /// The file.
        file: PathBuf,
    },
    /// An output that would replace an input of the same run.
    #[error("{}: cannot be written: it is read by this run; expected another place", file.display())]
    OutputIsInput {
        /// The file.
        file: PathBuf,
    },
    /// Two outputs of one run in one place.
    #[error("{}: cannot be written: two results would be written there", file.display())]
    OutputTwice {
        /// The file.
        file: PathBuf,
    },
    /// A file or folder that cannot be written.
    #[error("{}: cannot be written: {source}", file.display())]
    Unwritable {
        /// The file.
        file: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The report could not be made.
    #[error(transparent)]
    Report(#[from] sinew_report::error::Error),
    /// A result could not be written as JSON.
    #[error("the result could not be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A result could not be written as CSV.
    #[error("the result could not be written as CSV: {0}")]
    Csv(#[from] csv::Error),
    /// Standard output is closed or full.
    #[error("standard output: {0}")]
    Stdout(io::Error),
    /// The handler of Ctrl-C cannot be installed.
    #[error("the interrupt handler could not be set: {0}")]
    Interrupt(#[from] ctrlc::Error),
    /// The simulation made no log.
    #[error("the demo's simulation: expected at least one log, got none")]
    NoSimulatedLog,
}

impl From<TextFileError> for Error {
    fn from(error: TextFileError) -> Self {
        match error {
            TextFileError::Unreadable { file, source } => Self::Unreadable { file, source },
            other => Self::Text(other),
        }
    }
}

impl From<MachineFileError> for Error {
    fn from(error: MachineFileError) -> Self {
        match error {
            MachineFileError::Text(error) => error.into(),
            MachineFileError::MusclesTwice { file } => Self::MusclesTwice { file },
            MachineFileError::Description(error) => Self::Description(error),
            unknown @ MachineFileError::Format { .. } => Self::UnknownFormat(unknown),
        }
    }
}

impl From<sinew::description::DescriptionError> for Error {
    fn from(error: sinew::description::DescriptionError) -> Self {
        Self::Description(Box::new(error))
    }
}

/// Whether an error names a part of the machine.
fn names_part(error: sinew::Error) -> bool {
    matches!(error, sinew::Error::Part { .. } | sinew::Error::PartOutOfDomain { .. })
}

/// What a motion that is too fast would need.
fn needed(duration: Option<f64>) -> String {
    duration.map_or_else(String::new, |duration| format!("; --duration {duration} is long enough"))
}

impl Error {
    /// What the physics refuses of a machine, with file, line and key of the part.
    pub(crate) fn at(self, places: &Places) -> Self {
        match self {
            Self::Physics(error) | Self::Experiment(sinew_lab::Error::Physics(error)) => {
                places.error(error).into()
            }
            other => other,
        }
    }

    /// The same of a part alone: other numbers may be those of an argument.
    pub(crate) fn of_part(self, places: &Places) -> Self {
        match &self {
            Self::Physics(error) | Self::Experiment(sinew_lab::Error::Physics(error))
                if names_part(*error) =>
            {
                self.at(places)
            }
            _ => self,
        }
    }

    /// Exit code where the system, not the input, is the cause.
    pub(crate) const SYSTEM: u8 = 1;
    /// Exit code for bad input, the same as clap's for arguments.
    pub(crate) const BAD_INPUT: u8 = 2;
    /// Exit code where the input is good and the result is not what was asked for.
    pub(crate) const NOT_AS_ASKED: u8 = 3;

    /// 1 where the system is the cause, 2 where the input is, 3 for a motion that cannot or would not be
    /// tracked.
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::Unwritable { .. }
            | Self::Stdout(_)
            | Self::Interrupt(_)
            | Self::Report(_)
            | Self::Json(_)
            | Self::Csv(_)
            | Self::Export(sinew_export::ExportError::Compiler { .. })
            | Self::NoSimulatedLog => Self::SYSTEM,
            Self::Recording { source, .. } if source.is_of_the_system() => Self::SYSTEM,
            Self::Unreadable { source, .. } | Self::Identify(IdentifyError::Unreadable { source, .. }) => {
                reading_code(source)
            }
            Self::Infeasible { .. } | Self::Overloaded { .. } | Self::Untracked { .. } => Self::NOT_AS_ASKED,
            Self::Runtime(sinew_runtime::Error::Clock(_))
            | Self::Ethercat(sinew_runtime::ethercat::EthercatError::Link { .. }) => Self::SYSTEM,
            Self::Interface(sinew_segment::RawSocketError::NoInterface { .. }) => Self::BAD_INPUT,
            Self::Interface(_) => Self::SYSTEM,
            Self::Bus(sinew_runtime::BusError::System(_)) => Self::SYSTEM,
            Self::Servos(sinew_runtime::servos::ServoError::Port { source, .. })
            | Self::Can(sinew_runtime::can::CanError::Port { source, .. }) => reading_code(source),
            Self::Link(error) => link_code(error),
            Self::Page(_)
            | Self::Ros(
                sinew_ros::Error::Dds { .. }
                | sinew_ros::Error::Thread(_)
                | sinew_ros::Error::NoReader { .. },
            ) => Self::SYSTEM,
            _ => Self::BAD_INPUT,
        }
    }

    /// Wraps an error of a recording.
    pub(crate) fn recording(file: &Path) -> impl Fn(sinew_record::Error) -> Self {
        let file = file.to_owned();
        move |source| Self::Recording { file: file.clone(), source: Box::new(source) }
    }

    /// A name in the value of a flag that is none of those that are known.
    pub(crate) fn unknown(flag: &'static str, given: &str, kind: &'static str, known: Vec<String>) -> Self {
        Self::UnknownPart(flag, UnknownPart { given: given.to_owned(), kind, known })
    }

    /// Wraps an error of a file's table.
    pub(crate) fn table(file: &Path) -> impl Fn(TableError) -> Self {
        let file = file.to_owned();
        move |source| Self::Table { file: file.clone(), source }
    }
}

/// A key file that is wrong is bad input, and so is an address without a key; a socket that fails is not.
fn link_code(error: &sinew_link::Error) -> u8 {
    use sinew_link::{Error as LinkError, KeyFileError};
    match error {
        LinkError::KeyFile(KeyFileError::File { source, .. })
            if source.kind() == ErrorKind::AlreadyExists =>
        {
            Error::BAD_INPUT
        }
        LinkError::KeyFile(KeyFileError::File { source, .. }) => reading_code(source),
        LinkError::Socket { .. } | LinkError::NoAnswer { .. } | LinkError::Refused { .. } => Error::SYSTEM,
        LinkError::Random(_) | LinkError::Thread(_) | LinkError::KeyFile(KeyFileError::Random { .. }) => {
            Error::SYSTEM
        }
        _ => Error::BAD_INPUT,
    }
}

/// A wrong name is bad input; missing permission or a failing device is not.
fn reading_code(source: &io::Error) -> u8 {
    match source.kind() {
        ErrorKind::NotFound
        | ErrorKind::IsADirectory
        | ErrorKind::NotADirectory
        | ErrorKind::InvalidInput
        | ErrorKind::InvalidData => Error::BAD_INPUT,
        _ => Error::SYSTEM,
    }
}

/// The flag that resolves the error, where one does: the library names roles, the program has flags for them.
fn flag_hint(error: &IdentifyError) -> String {
    let flag = match error {
        IdentifyError::NoFar { .. } => role_flag(ColumnRole::Far),
        IdentifyError::NoInputs { .. } => "--effort COL,.., --motion COL,.., --anchor COL or --given COL,..",
        IdentifyError::Ambiguous { role, .. } | IdentifyError::MissingRole { role, .. } => role_flag(*role),
        IdentifyError::StackedTrials { .. } => role_flag(ColumnRole::Trial),
        IdentifyError::OneGroup { .. } | IdentifyError::GroupChanges { .. } => role_flag(ColumnRole::Group),
        IdentifyError::UnknownModel { .. } => "--model NAME,..",
        IdentifyError::UnknownLog { .. } => "--keep LOG,..",
        _ => return String::new(),
    };
    format!(" (set by {flag})")
}

fn role_flag(role: ColumnRole) -> &'static str {
    match role {
        ColumnRole::Far => "--far COL",
        ColumnRole::Effort => "--effort COL,..",
        ColumnRole::Motion => "--motion COL,..",
        ColumnRole::Anchor => "--anchor COL",
        ColumnRole::Given => "--given COL,..",
        ColumnRole::Time => "--time COL",
        ColumnRole::Trial => "--trial COL",
        ColumnRole::Group => "--group COL",
        ColumnRole::Ignored => "--ignore COL,..",
    }
}
