//! The shapes that other files describe, read where a machine is sampled.

use sinew::body::Robot;
use sinew_lab::machine_file::mesh_bytes;
use std::path::Path;

/// Reads the mesh files of a robot, whose own file is `path`, in the root, and warns of those that cannot
/// be read.
pub(crate) fn read_meshes(robot: &mut Robot, path: &Path, root: Option<&Path>) {
    let problems = sinew_view::read_meshes(robot, &mut |file| mesh_bytes(path, file, root));
    let more = problems.len().saturating_sub(MOST);
    for problem in problems.iter().take(MOST) {
        tell!("warning: {problem}");
    }
    if more > 0 {
        tell!("warning: {more} more meshes cannot be drawn");
    }
}

/// Warnings that are written out.
const MOST: usize = 3;
