//! What builds and tools need beside the source: CMake, Simulink, Arduino.

use super::template::Filling;
use crate::{ExportedFile, Name};
use sinew::predictor::Model;

/// Place, with `@` for the name, and template. Sources of other tools stand in folders of their own, so that
/// `cc *.c` compiles the example.
const FILES: [(&str, &str); 5] = [
    ("CMakeLists.txt", include_str!("templates/with/CMakeLists.txt")),
    ("simulink/simulink_wrapper.h", include_str!("templates/with/simulink_wrapper.h")),
    ("simulink/simulink_wrapper.c", include_str!("templates/with/simulink_wrapper.c")),
    ("simulink/sfunction_@.c", include_str!("templates/with/sfunction.c")),
    ("arduino/@/@.ino", include_str!("templates/with/sketch.ino")),
];

pub(super) fn files(model: &Model, name: &Name) -> Vec<ExportedFile> {
    let mut filling = Filling::default();
    filling.set("input_count", model.inputs.len());
    let file = |(place, template): (&str, &str)| {
        ExportedFile::text(place.replace('@', name.as_str()), filling.render(template, name))
    };
    FILES.into_iter().map(file).collect()
}
