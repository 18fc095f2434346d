//! Settings of the compiler element.

use crate::description::attributes::Attributes;
use crate::description::error::DescriptionError;
use crate::description::tree::Tree;
use alloc::format;
use alloc::string::{String, ToString};

/// Source of a body's inertia.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum InertiaFrom {
    Inertial,
    Geoms,
    Auto,
}

/// `compiler`, all of its elements merged.
#[derive(Debug, Clone)]
pub(super) struct Compiler {
    /// Radians in a unit of angle of the file.
    pub(super) radians: f64,
    pub(super) sequence: [u8; 3],
    pub(super) auto_limits: bool,
    pub(super) inertia_from: InertiaFrom,
    pub(super) inertia_groups: [f64; 2],
    pub(super) min_mass: f64,
    pub(super) min_inertia: f64,
    pub(super) balance: bool,
    /// Whether free bodies take the frame of their inertia.
    pub(super) align_free: bool,
    pub(super) total_mass: Option<f64>,
    /// Folder of meshes, relative to that of the model.
    pub(super) mesh_folder: String,
    /// Whether folders within the names of files are left out.
    pub(super) strip_path: bool,
}

impl Compiler {
    pub(super) fn read(tree: &Tree) -> Result<Compiler, DescriptionError> {
        let mut compiler = Compiler {
            radians: core::f64::consts::PI / 180.0,
            sequence: *b"xyz",
            auto_limits: true,
            inertia_from: InertiaFrom::Auto,
            inertia_groups: [0.0, 5.0],
            min_mass: 0.0,
            min_inertia: 0.0,
            balance: false,
            align_free: false,
            total_mass: None,
            mesh_folder: String::new(),
            strip_path: false,
        };
        for &element in &tree.elements[0].children {
            if tree.elements[element].name == "compiler" {
                compiler.merge(Attributes::own(tree, element))?;
            }
        }
        Ok(compiler)
    }

    fn merge(&mut self, at: Attributes<'_>) -> Result<(), DescriptionError> {
        if let Some(place) = at.word("angle", &["degree", "radian"])? {
            self.radians = if place == 0 { core::f64::consts::PI / 180.0 } else { 1.0 };
        }
        if at.word("coordinate", &["local", "global"])? == Some(1) {
            return Err(at.error("coordinate", "is `global`, which MuJoCo has given up: expected `local`"));
        }
        if let Some(text) = at.text("eulerseq") {
            let letters = <[u8; 3]>::try_from(text.as_bytes()).ok();
            let letters = letters.filter(|l| l.iter().all(|c| b"xyzXYZ".contains(c)));
            let expected =
                || at.error("eulerseq", format!("is `{text}`: expected three letters out of xyzXYZ"));
            self.sequence = letters.ok_or_else(expected)?;
        }
        if let Some(folder) = at.text("meshdir").or_else(|| at.text("assetdir")) {
            self.mesh_folder = folder.to_string();
        }
        self.strip_path = at.flag("strippath", self.strip_path)?;
        self.auto_limits = at.flag("autolimits", self.auto_limits)?;
        self.align_free = at.flag("alignfree", self.align_free)?;
        self.balance = at.flag("balanceinertia", self.balance)?;
        match at.word("inertiafromgeom", &["false", "true", "auto"])? {
            Some(0) => self.inertia_from = InertiaFrom::Inertial,
            Some(1) => self.inertia_from = InertiaFrom::Geoms,
            Some(_) => self.inertia_from = InertiaFrom::Auto,
            None => {}
        }
        self.inertia_groups = at.array_or("inertiagrouprange", self.inertia_groups)?;
        if at.text("boundmass").is_some() {
            self.min_mass = at.not_negative("boundmass")?;
        }
        if at.text("boundinertia").is_some() {
            self.min_inertia = at.not_negative("boundinertia")?;
        }
        if let Some(mass) = at.number("settotalmass")? {
            self.total_mass = (mass > 0.0).then_some(mass);
        }
        Ok(())
    }
}
