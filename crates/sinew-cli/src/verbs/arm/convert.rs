//! `sinew arm convert`.

use super::model::{Format, load_robot, print_warnings};
use crate::arguments::ConvertArguments;
use crate::error::Error;
use crate::output::{print, refuse_overwrite, write_all};
use sinew::description::{to_mjcf, to_toml};

pub(crate) fn run(arguments: &ConvertArguments) -> Result<(), Error> {
    let output = &arguments.output;
    refuse_overwrite([&arguments.input].into_iter().chain(&arguments.muscles), std::slice::from_ref(output))?;
    let kind = Format::of(output)?;
    if kind == Format::Urdf {
        let expected = ".toml or .xml, because URDF has no cables";
        return Err(Error::RobotFormat { file: output.clone(), expected });
    }
    let loaded = load_robot(&arguments.input, arguments.muscles.as_deref())?;
    print_warnings(&loaded.warnings);
    let parts = loaded.robot.parts();
    let text = if kind == Format::Toml { to_toml(parts) } else { to_mjcf(parts) };
    write_all(&[(output.clone(), text.as_bytes())])?;
    let (bodies, joints, muscles) = (parts.bodies.len() - 1, parts.joints.len(), parts.tendons.len());
    print(&format!(
        "Written: {bodies} bodies, {joints} joints and {muscles} muscles to {}\n",
        output.display()
    ))
}
