//! Functional mock-up units through their C interface: the same bits, and errors for what is called wrongly.

use crate::bits::{bytes, predicted};
use crate::compiler::{compile, compilers, one_in_turn, run};
use crate::models::{Kind, model};
use crate::samples::Row;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sinew::compensator::{Compensator, CompensatorSettings};
use sinew::predictor::{Model, Sample};
use sinew::transmission::Sliding;
use sinew_export::c::Content;
use sinew_export::{Name, fmu};

const PREDICTOR: Content = Content::Predictor;

/// Calls in the wrong order first, then steps over rows from standard input; ends with 1 and a line where a
/// call does not do what it should.
const DRIVER: &str = r#"
#include "THE_UNIT"
#include <stdio.h>
#define MUST(condition) if (!(condition)) { fprintf(stderr, "line %d: %s\n", __LINE__, #condition); return 1; }
int main(void)
{
    unsigned references[EXPORTED_PORTS], outputs[NUMBERS], flags[FLAG_COUNT], wrong = 99;
    double row[2 + EXPORTED_PORTS], out[NUMBERS + 1], time_s = 0.0, number = 0.0;
    size_t size = 0;
    int first = 1, k;
    void *unit = MAKE("TOKEN"), *other = MAKE("TOKEN"), *state = NULL, *copy = NULL;
    static BYTE saved[sizeof(exported_data)];
    for (k = 0; k < EXPORTED_PORTS; k++) { references[k] = (unsigned)k + 1u; }
    for (k = 0; k < NUMBERS; k++) { outputs[k] = EXPORTED_PORTS + 1u + (unsigned)k; }
    for (k = 0; k < FLAG_COUNT; k++) { flags[k] = EXPORTED_PORTS + 1u + NUMBERS + (unsigned)k; }
    MUST(MAKE("another") == NULL);
    MUST(unit != NULL && other != NULL);
    MUST(STEP(unit, 0.0, 0.1) == ERROR);
    MUST(LEAVE(unit) == ERROR);
    MUST(STEP(NULL, 0.0, 0.1) == ERROR);
    MUST(GET(unit, &wrong, 1, &number) == ERROR);
    MUST(SET(unit, outputs, 1, &number) == ERROR);
    MUST(RESTORE(unit, NULL) == ERROR);
    MUST(ENTER(unit, 0.0) == 0);
    MUST(ENTER(unit, 0.0) == ERROR);
    while (fread(row, sizeof row, 1, stdin) == 1) {
        FLAG raised[FLAG_COUNT];
        MUST(SET(unit, references, EXPORTED_PORTS, row + 2) == 0);
        if (first) {
            MUST(LEAVE(unit) == 0);
            MUST(STEP(unit, 0.0, 0.0) == ERROR);
            MUST(STEP(unit, 0.0, -1.0) == ERROR);
            MUST(STEP(unit, 5.0, 0.1) == ERROR);
        } else {
            MUST(STEP(unit, time_s, row[1] - time_s) == 0);
        }
        first = 0;
        time_s = row[1];
        /* The state moves to another instance and back. */
        MUST(SAVE(unit, &state) == 0);
        MUST(SIZE(unit, state, &size) == 0 && size == sizeof saved);
        MUST(PACK(unit, state, saved, size) == 0);
        MUST(UNPACK(other, saved, size - 1, &copy) == ERROR);
        MUST(UNPACK(other, saved, size, &copy) == 0);
        MUST(RESTORE(other, copy) == 0);
        MUST(GET(other, outputs, NUMBERS, out) == 0);
        MUST(FLAGS(other, flags, FLAG_COUNT, raised) == 0);
        out[NUMBERS] = 0.0;
        for (k = 0; k < FLAG_COUNT; k++) { out[NUMBERS] += raised[k] ? (double)(1u << k) : 0.0; }
        MUST(fwrite(out, sizeof out, 1, stdout) == 1);
    }
    MUST(DROP(unit, &state) == 0 && DROP(other, &copy) == 0);
    RELEASE(unit);
    RELEASE(other);
    return 0;
}
"#;

const THREE: &str = r#"
#define MAKE(t) fmi3InstantiateCoSimulation("x", t, "", false, false, false, false, NULL, 0, NULL, NULL, NULL)
#define ENTER(i, t) fmi3EnterInitializationMode(i, false, 0.0, t, false, 0.0)
#define LEAVE fmi3ExitInitializationMode
static bool event, terminate, early;
static double last;
#define STEP(i, t, h) fmi3DoStep(i, t, h, true, &event, &terminate, &early, &last)
#define GET(i, r, n, v) fmi3GetFloat64(i, r, n, v, n)
#define SET(i, r, n, v) fmi3SetFloat64(i, r, n, v, n)
#define FLAGS(i, r, n, v) fmi3GetBoolean(i, r, n, v, n)
#define FLAG bool
#define BYTE uint8_t
#define ERROR fmi3Error
#define SAVE fmi3GetFMUState
#define RESTORE fmi3SetFMUState
#define DROP fmi3FreeFMUState
#define SIZE fmi3SerializedFMUStateSize
#define PACK fmi3SerializeFMUState
#define UNPACK fmi3DeserializeFMUState
#define RELEASE fmi3FreeInstance
#define STOP fmi3Terminate
#define AGAIN fmi3Reset
"#;

const TWO: &str = r#"
#define MAKE(t) fmi2Instantiate("x", 1, t, "", NULL, 0, 0)
#define ENTER(i, t) (fmi2SetupExperiment(i, 0, 0.0, t, 0, 0.0) == 0 ? fmi2EnterInitializationMode(i) : fmi2Error)
#define LEAVE fmi2ExitInitializationMode
#define STEP(i, t, h) fmi2DoStep(i, t, h, 1)
#define GET fmi2GetReal
#define SET fmi2SetReal
#define FLAGS fmi2GetBoolean
#define FLAG fmi2Boolean
#define BYTE char
#define ERROR fmi2Error
#define SAVE fmi2GetFMUstate
#define RESTORE fmi2SetFMUstate
#define DROP fmi2FreeFMUstate
#define SIZE fmi2SerializedFMUstateSize
#define PACK fmi2SerializeFMUstate
#define UNPACK fmi2DeSerializeFMUstate
#define RELEASE fmi2FreeInstance
#define STOP fmi2Terminate
#define AGAIN fmi2Reset
"#;

/// Rows whose time runs on: what an importer cannot do otherwise. Steps of powers of two add without
/// rounding.
fn rows(count: usize, random: &mut ChaCha8Rng) -> Vec<Row> {
    let rows = crate::samples::rows(count, random).into_iter().enumerate();
    rows.map(|(k, row)| Row { reset: false, time_s: k as f64 / 1024.0, ..row }).collect()
}

/// Compares what units of both versions give with what is expected: so many numbers, then the flags as one.
/// Each version is compiled by another compiler, in rotation.
fn compare(
    model: &Model,
    (content, turn): (Content, usize),
    rows: &[u8],
    [numbers, flags]: [usize; 2],
    expected: &[u8],
) {
    let name = Name::new("exported").unwrap();
    for (version, stem, calls) in [(fmu::Version::Three, "fmi3.c", THREE), (fmu::Version::Two, "fmi2.c", TWO)]
    {
        let unit = fmu::Unit::of_model(model, &name, content, version).unwrap();
        let calls = format!("#define NUMBERS {numbers}\n#define FLAG_COUNT {flags}\n{calls}");
        let folder = driven(&unit, stem, &calls, DRIVER);
        for compiler in one_in_turn(compilers(), turn + version as usize) {
            let flags = ["-std=c99", "-O1", SANITIZERS, "-fno-sanitize-recover=all"];
            compile(compiler, folder.path(), &["exported.c", "driver.c"], &flags);
            let got = run(folder.path(), rows, &[]);
            assert!(got == expected, "{} {version:?}", model.provenance.member);
        }
    }
}

#[test]
fn units_of_both_versions_give_the_bits_of_the_library_and_refuse_wrong_calls() {
    for (kind, seed) in [(Kind::HybridObserver, 1), (Kind::HybridCell, 2), (Kind::AxisForce, 3)] {
        let mut random = ChaCha8Rng::seed_from_u64(seed as u64);
        let model = model(kind, &mut random);
        let rows = rows(1500, &mut random);
        compare(&model, (PREDICTOR, seed), &bytes(&rows), [3, 5], &flat(&predicted(&model, &rows)));
    }
}

#[test]
fn units_that_command_give_the_bits_of_the_compensator() {
    for (kind, seed) in [(Kind::Observer, 4), (Kind::HybridCell, 5), (Kind::AxisMotion, 6)] {
        let mut random = ChaCha8Rng::seed_from_u64(seed as u64);
        let model = model(kind, &mut random);
        let rows = rows(300, &mut random);
        let settings = CompensatorSettings { rate: Some(50.0), ..CompensatorSettings::default() };
        let mut compensator = Compensator::new(model.clone(), &settings).unwrap();
        let near = compensator.near();
        // Something was measured in stretches of rows; behind the inputs stands what is desired, and for a
        // cable the direction that is expected.
        let cable = model.estimator.law.cable.is_some();
        let asked = rows.iter().enumerate().map(|(k, row)| {
            let (mut inputs, mut desired) = (row.inputs, vec![row.inputs[near]]);
            inputs[near] = if k % 40 < 15 { 0.9 * desired[0] } else { f64::NAN };
            desired.extend(cable.then_some([0.0, 0.5, -2.0, f64::NAN][k / 25 % 4]));
            (Row { inputs, ..*row }, desired)
        });
        let asked: Vec<(Row, Vec<f64>)> = asked.collect();
        let command = |(row, desired): &(Row, Vec<f64>)| {
            let direction = desired.get(1).and_then(|direction| Sliding::from_velocity(*direction));
            compensator.expect_sliding(direction);
            let u = compensator.step(&Sample { time_s: row.time_s, inputs: &row.inputs }, desired[0]);
            let set = u.flags.named().into_iter().enumerate();
            let flags: u32 = set.map(|(k, (_, set))| u32::from(set) << k).sum();
            [u.value, u.low, u.high, u.mean, u.standard_deviation, u.gate, f64::from(flags)].map(f64::to_bits)
        };
        let expected: Vec<[u64; 7]> = asked.iter().map(command).collect();
        let row = |(row, desired): &(Row, Vec<f64>)| {
            let desired = desired.iter().flat_map(|x| x.to_ne_bytes());
            bytes(&[*row]).into_iter().chain(desired).collect::<Vec<_>>()
        };
        let rows: Vec<u8> = asked.iter().flat_map(row).collect();
        compare(&model, (Content::Compensator(settings), seed), &rows, [6, 7], &flat(&expected));
    }
}

/// Calls at random, in any order and with any arguments, for some seconds; sanitizers end it at a mistake.
const FUZZ: &str = r#"
#include "THE_UNIT"
#include <stdio.h>
#include <time.h>
static unsigned long long seed = 1;
static unsigned draw(unsigned n)
{
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return (unsigned)(seed >> 33) % n;
}
static double number(void)
{
    static const double odd[] = {0.0, -0.0, 1e-3, 1e300, -1e300, 5e-324, NAN, INFINITY, -INFINITY, 1.0};
    return draw(3) ? (double)draw(1000) / 1000.0 : odd[draw(10)];
}
int main(int count, char **arguments)
{
    static BYTE bytes[1 << 16];
    void *units[4] = {NULL}, *states[4] = {NULL};
    double times[4] = {0.0};
    unsigned references[8], calls = 0, k;
    size_t packed = sizeof(exported_data);
    double values[8];
    FLAG flags[8];
    const time_t end = time(NULL) + (count > 1 ? atoi(arguments[1]) : 1);
    while (calls++ % 256u || time(NULL) <= end) {
        const unsigned at = draw(4), n = draw(9), to = draw(4);
        void *const i = units[at];
        size_t size = draw(3) ? packed : draw(draw(3) ? 2 * (unsigned)packed + 1 : (unsigned)sizeof bytes);
        for (k = 0; k < 8; k++) {
            references[k] = draw(20) ? draw(16) : draw(4294967295u);
            values[k] = number();
        }
        switch (draw(17)) {
        case 0: if (i == NULL) { units[at] = MAKE(draw(9) ? "TOKEN" : "x"); } break;
        case 1: if (draw(9) == 0) { RELEASE(i); units[at] = NULL; } break;
        case 2: ENTER(i, draw(4) ? times[at] : number()); break;
        case 3: LEAVE(i); break;
        case 4: GET(i, references, n, values); break;
        case 5: SET(i, references, n, values); break;
        case 6: FLAGS(i, references, n, flags); break;
        case 7: SAVE(i, &states[to]); break;
        case 8: RESTORE(i, states[to]); break;
        case 9: DROP(i, &states[to]); break;
        case 10: SIZE(i, states[to], &size); break;
        case 11:
            if (states[to] != NULL && SIZE(i, states[to], &size) == 0 && size <= sizeof bytes) {
                packed = size;
            }
            PACK(i, states[to], bytes, draw(3) ? packed : draw((unsigned)packed));
            break;
        case 12:
            if (draw(9) == 0) { bytes[draw((unsigned)packed)] = (BYTE)draw(256); }
            UNPACK(i, bytes, size, &states[to]);
            break;
        case 13: STOP(i); break;
        case 14: if (draw(9) == 0) { AGAIN(i); times[at] = 0.0; } break;
        default: {
            const double step = draw(8) ? 1e-3 : number();
            if (STEP(i, draw(8) ? times[at] : number(), step) == 0) { times[at] += step; }
        }
        }
    }
    for (k = 0; k < 4; k++) {
        void *const any = MAKE("TOKEN");
        DROP(any, &states[k]);
        RELEASE(any);
    }
    for (k = 0; k < 4; k++) { RELEASE(units[k]); }
    printf("%u calls\n", calls);
    return 0;
}
"#;

/// For a second with one of the compilers, or for ten minutes with each where `SINEW_LONG` is set.
fn call_at_random(version: fmu::Version, of_plant: bool) {
    let (seconds, compilers) = match std::env::var_os("SINEW_LONG") {
        Some(_) => ("600", compilers()),
        None => ("1", one_in_turn(compilers(), version as usize + usize::from(of_plant))),
    };
    let name = Name::new("exported").unwrap();
    let model = model(Kind::HybridObserver, &mut ChaCha8Rng::seed_from_u64(8));
    let (unit, files) = if of_plant {
        (fmu::Unit::of_plant(&plant(), &name, version), vec!["driver.c"])
    } else {
        (fmu::Unit::of_model(&model, &name, PREDICTOR, version), vec!["exported.c", "driver.c"])
    };
    let (stem, calls) = if version == fmu::Version::Three { ("fmi3.c", THREE) } else { ("fmi2.c", TWO) };
    let folder = driven(&unit.unwrap(), stem, calls, FUZZ);
    std::fs::write(folder.path().join("process.c"), PROCESS).unwrap();
    for compiler in compilers {
        compile(compiler, folder.path(), &["process.c"], &["-O1"]);
        std::fs::rename(folder.path().join("program"), folder.path().join("sinew")).unwrap();
        let flags = ["-w", "-O1", "-g", SANITIZERS, "-fno-sanitize-recover=all"];
        compile(compiler, folder.path(), &files, &flags);
        let mut program = std::process::Command::new(folder.path().join("program"));
        program.arg(seconds).env("PATH", folder.path());
        let said = crate::compiler::run_program(program, &[]);
        println!("{compiler} {version:?} {files:?}: {}", String::from_utf8_lossy(&said));
    }
}

#[test]
fn random_calls_never_crash_a_unit_of_fmi_3() {
    call_at_random(fmu::Version::Three, false);
}

#[test]
fn random_calls_never_crash_a_unit_of_fmi_2() {
    call_at_random(fmu::Version::Two, false);
}

#[test]
fn random_calls_never_crash_a_plant_of_fmi_3() {
    call_at_random(fmu::Version::Three, true);
}

#[test]
fn random_calls_never_crash_a_plant_of_fmi_2() {
    call_at_random(fmu::Version::Two, true);
}

/// In the place of `sinew export serve` for [`plant`]: answers anything, and sometimes ends in between.
const PROCESS: &str = r#"
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>
int main(void)
{
    double asked[2], answer[4] = {0.0}, row[2] = {1e-3, 0.5}, count;
    unsigned seed = (unsigned)getpid();
    while (fwrite(answer, sizeof answer, 1, stdout) == 1) {
        if (answer[0] < 0.5 && asked[0] == -5.0) {
            for (count = (double)(seed % 9u), fwrite(&count, 8, 1, stdout); count > 0.5; count -= 1.0) {
                fwrite(row, sizeof row, 1, stdout);
            }
        }
        fflush(stdout);
        if (fread(asked, sizeof asked, 1, stdin) != 1) { return 0; }
        if (asked[0] == -6.0) {
            for (fread(&count, 8, 1, stdin); count > 0.5 && fread(row, sizeof row, 1, stdin) == 1; count -= 1.0) {}
        }
        seed = seed * 1103515245u + 12345u;
        if (seed >> 16 & 255u) { answer[0] = (seed >> 24) < 20u ? 1.0 : 0.0; } else { return 1; }
        answer[1] = (double)seed;
    }
    return 1;
}
"#;

/// A folder with the sources of a unit and a program that calls it.
fn driven(unit: &fmu::Unit, stem: &str, calls: &str, driver: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let interface = unit.sources().iter().find(|file| file.path == stem).unwrap();
    let text = std::str::from_utf8(&interface.bytes).unwrap();
    let token = text.split("strcmp(token, \"").nth(1).unwrap().split('"').next().unwrap();
    let driver =
        driver.replace("#include <stdio.h>", &format!("#include <math.h>\n#include <stdio.h>\n{calls}"));
    let driver = driver.replace("THE_UNIT", stem).replace("TOKEN", token);
    for file in unit.sources() {
        std::fs::write(folder.path().join(&file.path), &file.bytes).unwrap();
    }
    std::fs::write(folder.path().join("driver.c"), driver).unwrap();
    folder
}

const SANITIZERS: &str = "-fsanitize=address,undefined";

/// A plant whose process is not there.
pub(crate) fn plant() -> fmu::Plant {
    let port = |part: &str, name: &str| fmu::Port {
        part: part.to_owned(),
        name: name.to_owned(),
        description: "a number".to_owned(),
        start: 0.25,
    };
    fmu::Plant {
        description: "nothing".to_owned(),
        file: "{}".to_owned(),
        step_s: 1e-3,
        inputs: vec![port("motor", "speed_m_s")],
        outputs: vec![port("motor", "position_m"), port("joint", "angle_rad")],
        flags: vec![port("motor", "broken")],
    }
}

/// Starts, steps and frees a unit whose program is not on PATH.
const ALONE: &str = r#"
#include "THE_UNIT"
#include <stdio.h>
#define MUST(condition) if (!(condition)) { fprintf(stderr, "line %d: %s\n", __LINE__, #condition); return 1; }
int main(void)
{
    unsigned input = 1, output = 2, flag = 4, wrong = 5;
    double number = 7.0;
    FLAG raised;
    size_t size = 0;
    void *unit = MAKE("TOKEN"), *other = MAKE("TOKEN"), *state = NULL, *copy = NULL;
    MUST(MAKE("another") == NULL);
    MUST(unit != NULL && other != NULL);
    MUST(GET(unit, &input, 1, &number) == 0 && number == 0.25);
    number = 0.5;
    MUST(SET(unit, &input, 1, &number) == 0 && SET(unit, &output, 1, &number) == ERROR);
    MUST(FLAGS(unit, &flag, 1, &raised) == 0 && !raised && FLAGS(unit, &wrong, 1, &raised) == ERROR);
    static BYTE bytes[4096];
    MUST(SAVE(unit, &state) == 0 && SIZE(unit, state, &size) == 0 && SIZE(other, state, &size) == ERROR);
    MUST(PACK(unit, state, bytes, size - 1) == ERROR && PACK(unit, state, bytes, size) == 0);
    MUST(UNPACK(other, bytes, size - 1, &copy) == ERROR && copy == NULL);
    MUST(UNPACK(other, bytes, size, &copy) == 0 && RESTORE(other, copy) == 0 && DROP(other, &copy) == 0);
    number = 7.0;
    MUST(GET(other, &input, 1, &number) == 0 && number == 0.5);
    bytes[size - 1] ^= 1;
    MUST(UNPACK(other, bytes, size, &copy) == ERROR);
    MUST(ENTER(unit, 0.0) == 0);
    MUST(LEAVE(unit) == ERROR);
    MUST(STEP(unit, 0.0, 0.1) == ERROR);
    /* Before its start, a unit is the same in every process. */
    MUST(RESTORE(other, state) == ERROR && RESTORE(unit, state) == 0 && ENTER(unit, 0.0) == 0);
    MUST(DROP(unit, &state) == 0 && state == NULL && RESTORE(unit, NULL) == ERROR);
    RELEASE(unit);
    RELEASE(other);
    RELEASE(NULL);
    return 0;
}
"#;

#[test]
fn a_unit_of_a_plant_whose_program_is_missing_refuses_to_start() {
    let name = Name::new("exported").unwrap();
    for (version, stem, calls) in [(fmu::Version::Three, "fmi3.c", THREE), (fmu::Version::Two, "fmi2.c", TWO)]
    {
        let unit = fmu::Unit::of_plant(&plant(), &name, version).unwrap();
        let folder = driven(&unit, stem, calls, ALONE);
        for compiler in compilers() {
            let flags = ["-std=c99", "-O1", SANITIZERS, "-fno-sanitize-recover=all"];
            compile(compiler, folder.path(), &["driver.c"], &flags);
            let mut alone = std::process::Command::new(folder.path().join("program"));
            alone.env("PATH", folder.path());
            crate::compiler::run_program(alone, &[]);
        }
    }
}

fn flat<const N: usize>(rows: &[[u64; N]]) -> Vec<u8> {
    rows.iter().flatten().flat_map(|bits| bits.to_ne_bytes()).collect()
}

#[test]
fn a_unit_without_a_compiler_holds_its_sources() {
    let model = model(Kind::Cell, &mut ChaCha8Rng::seed_from_u64(1));
    let name = Name::new("knee").unwrap();
    for version in [fmu::Version::Three, fmu::Version::Two] {
        let unit = fmu::Unit::of_model(&model, &name, PREDICTOR, version).unwrap();
        assert_eq!(unit.compile("no-such-compiler".as_ref()).unwrap(), None);
        let unit = unit.file(None).unwrap();
        assert_eq!(unit.path, "knee.fmu");
        let holds = |path: &str| unit.bytes.windows(path.len()).any(|bytes| bytes == path.as_bytes());
        assert!(holds("modelDescription.xml") && holds("sources/knee.c") && !holds("binaries"));
    }
}
