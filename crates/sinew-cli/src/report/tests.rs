//! The page as a whole: what it may weigh, load and survive.

use super::fixture::{many_trials, simulated};
use super::{picture_svg, render};
use sinew_identify::account::Account;

#[test]
#[ignore = "writes pictures for a person to look at"]
fn write_the_reports_to_look_at() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/report");
    std::fs::create_dir_all(&folder).unwrap();
    for (name, account) in [("logs", simulated(3000)), ("trials", many_trials(50, 2000)), ("bare", bare())] {
        std::fs::write(folder.join(format!("{name}.html")), render(&account).unwrap()).unwrap();
        std::fs::write(folder.join(format!("{name}.svg")), picture_svg(&account).unwrap()).unwrap();
    }
}

fn bare() -> Account {
    let mut account = simulated(10);
    account.traces.clear();
    account.logs.clear();
    account.candidates.clear();
    account.influence.clear();
    account.classical.clear();
    account.warnings.clear();
    account.chosen.parameters.clear();
    account.inputs.clear();
    account.folds = 0;
    account.far_range = f64::NAN;
    account.advice = [String::new(), String::new()];
    account
}
