//! Robots whose files are spread over folders, and what may not be read.

use sinew::random::Random;
use sinew_lab::machine_file::{load_robot, mesh_bytes};
use std::fs::{create_dir_all, write};
use std::path::{Path, PathBuf};

const BODY: &str = "<mujoco><worldbody><body name=\"b\"><joint name=\"j\"/>\
    <inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/></body></worldbody></mujoco>";

fn model(included: &str) -> String {
    format!("<mujoco>\n<include file=\"{included}\"/></mujoco>")
}

/// A folder some levels below another one.
fn below(random: &mut Random, root: &Path) -> PathBuf {
    let levels = (random.unit() * 4.0) as usize;
    (0..levels).fold(root.to_owned(), |at, _| at.join(["a", "b", "c"][(random.unit() * 3.0) as usize]))
}

/// The way from one folder to a file, both below a root.
fn way(root: &Path, from: &Path, to: &Path) -> String {
    let up = from.strip_prefix(root).unwrap().components().count();
    format!("{}{}", "../".repeat(up), to.strip_prefix(root).unwrap().display())
}

#[test]
fn files_anywhere_below_a_root_are_found_and_none_outside_of_it() {
    let temporary = tempfile::tempdir().unwrap();
    let home = temporary.path().canonicalize().unwrap();
    write(home.join("secret.xml"), BODY).unwrap();
    write(home.join("secret.stl"), "solid").unwrap();
    let mut random = Random::new(5);
    for layout in 0..60 {
        let root = home.join(format!("layout{layout}"));
        let [folder, beside, mesh] = [(); 3].map(|()| below(&mut random, &root));
        for folder in [&folder, &beside, &mesh.join("package")] {
            create_dir_all(folder).unwrap();
        }
        write(beside.join("part.xml"), BODY).unwrap();
        write(mesh.join("package/m.stl"), "solid").unwrap();
        let (robot, part) = (folder.join("robot.xml"), beside.join("part.xml"));
        let include = |name: &str, root: Option<&Path>| {
            write(&robot, model(name)).unwrap();
            load_robot(&robot, None, root).map(|_| ()).map_err(|error| error.to_string())
        };
        let mesh_of = |name: &str, root: Option<&Path>| mesh_bytes(&robot, name, root);
        // As it lies, from any root that holds it, with and without its own path.
        let name = way(&root, &folder, &part);
        for root in [None, Some(root.as_path()), Some(home.as_path())] {
            include(&name, root).unwrap();
            mesh_of(&way(&home, &folder, &mesh.join("package/m.stl")), root.or(Some(&home))).unwrap();
        }
        include(&part.display().to_string(), Some(&root)).unwrap();
        assert_eq!(mesh_of("package://package/m.stl", Some(&root)).unwrap(), b"solid");
        // Not what lies outside: named with file, line, path and root.
        #[cfg(unix)]
        {
            let link = |to: &Path, name: &str| std::os::unix::fs::symlink(to, folder.join(name)).unwrap();
            link(&home.join("secret.xml"), "link.xml");
            link(&home.join("secret.stl"), "link.stl");
            link(&home, "up");
        }
        let secret = home.join("secret.xml");
        let mut outside = vec![way(&home, &folder, &secret), secret.display().to_string()];
        outside.extend(
            cfg!(unix).then_some(["link.xml", "up/secret.xml"]).into_iter().flatten().map(String::from),
        );
        outside.push("../../../../../../../../../etc/passwd".to_owned());
        for name in &outside {
            let refused = include(name, Some(&root)).unwrap_err();
            let told = [robot.display().to_string() + ":2", root.display().to_string()];
            assert!(told.iter().all(|word| refused.contains(word)), "{name}: {refused}");
            let name = name.replace(".xml", ".stl");
            for name in [name.clone(), format!("file://{name}"), format!("package://{name}")] {
                let refused = mesh_of(&name, Some(&root)).unwrap_err();
                assert!(refused.contains(root.to_str().unwrap()), "{name}: {refused}");
            }
        }
        for name in ["link.xml", "/etc/passwd", "../../../../../../../../../../etc/passwd"] {
            include(name, None).unwrap_err();
            mesh_of(&name.replace(".xml", ".stl"), None).unwrap_err();
        }
    }
}
