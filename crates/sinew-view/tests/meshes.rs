//! Files of triangles: read, placed, reduced, and refused with a reason.
#![allow(clippy::unwrap_used, reason = "a test fails by a panic")]

use sinew::body::{Body, MeshGeom, Parts, Robot};
use sinew_view::{meshes, shapes};
use std::fmt::Write as _;
use std::path::Path;

/// The twelve triangles of a box from the origin to `[a, b, c]`, corners anticlockwise from outside.
fn cuboid([a, b, c]: [f32; 3]) -> Vec<[[f32; 3]; 3]> {
    let corner = |k: usize| [a * (k & 1) as f32, b * (k >> 1 & 1) as f32, c * (k >> 2 & 1) as f32];
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|[p, q, r, s]| [[*p, *q, *r], [*p, *r, *s]]);
    triangles.map(|triangle: [usize; 3]| triangle.map(corner)).collect()
}

fn binary_stl(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend(u32::try_from(triangles.len()).unwrap().to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        bytes.extend(triangle.iter().flatten().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn ascii_stl(triangles: &[[[f32; 3]; 3]]) -> String {
    let mut text = "solid box\n".to_owned();
    for triangle in triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        triangle.iter().for_each(|[x, y, z]| writeln!(text, "vertex {x} {y} {z}").unwrap());
        text += "endloop\nendfacet\n";
    }
    text + "endsolid box\n"
}

fn obj(triangles: &[[[f32; 3]; 3]]) -> String {
    let mut text = "mtllib none.mtl\no box\n".to_owned();
    triangles.iter().flatten().for_each(|[x, y, z]| writeln!(text, "v {x} {y} {z}").unwrap());
    (0..triangles.len()).for_each(|k| writeln!(text, "f {} {} {}", 3 * k + 1, 3 * k + 2, 3 * k + 3).unwrap());
    text
}

fn mesh(file: &str) -> MeshGeom {
    MeshGeom {
        body: 1,
        file: file.to_owned(),
        scale: [1.0; 3],
        reference_position: [0.0; 3],
        reference_orientation: [1.0, 0.0, 0.0, 0.0],
        position: [0.0; 3],
        orientation: [1.0, 0.0, 0.0, 0.0],
        surface: None,
    }
}

fn robot(meshes: Vec<MeshGeom>) -> Robot {
    let body = |name: &str| Body {
        name: name.to_owned(),
        parent: 0,
        position: if name == "link" { [0.0, 0.0, 1.0] } else { [0.0; 3] },
        orientation: [1.0, 0.0, 0.0, 0.0],
        mass: 1.0,
        center_of_mass: [0.0; 3],
        inertia: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
        gravity_compensation: 0.0,
    };
    let mut world = body("world");
    (world.mass, world.inertia) = (0.0, [0.0; 6]);
    Robot::new(Parts { bodies: vec![world, body("link")], meshes, ..Parts::default() }).unwrap()
}

fn read_meshes(robot: &mut Robot, folder: &Path) -> Vec<String> {
    sinew_view::read_meshes(robot, &mut |file| {
        std::fs::read(folder.join(file)).map_err(|error| format!("cannot be read: {error}"))
    })
}

/// Six times the enclosed volume, positive where the triangles face outwards.
fn volume(robot: &Robot, index: usize) -> f64 {
    let surface = robot.parts().meshes[index].surface.as_ref().unwrap();
    let corner = |k: u32| surface.vertices[k as usize].map(f64::from);
    let of = |t: &[u32; 3]| {
        let [a, b, c] = t.map(corner);
        a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    surface.triangles.iter().map(of).sum()
}

#[test]
fn every_format_gives_the_same_box() {
    let folder = tempfile::tempdir().unwrap();
    let triangles = cuboid([0.1, 0.2, 0.4]);
    std::fs::write(folder.path().join("a.stl"), binary_stl(&triangles)).unwrap();
    std::fs::write(folder.path().join("b.STL"), ascii_stl(&triangles)).unwrap();
    std::fs::write(folder.path().join("c.obj"), obj(&triangles)).unwrap();
    let mut robot = robot(vec![mesh("a.stl"), mesh("b.STL"), mesh("c.obj"), mesh("a.stl")]);
    assert!(read_meshes(&mut robot, folder.path()).is_empty());
    for index in 0..4 {
        let surface = robot.parts().meshes[index].surface.as_ref().unwrap();
        assert_eq!((surface.vertices.len(), surface.triangles.len()), (8, 12), "{index}");
        assert!((volume(&robot, index) - 6.0 * 0.008).abs() < 1e-7, "{index}: {}", volume(&robot, index));
    }
    let (shapes, encoded) = (shapes(robot.parts()), meshes(robot.parts()));
    assert_eq!(encoded.len(), 3, "a file that is used twice is sent once");
    let used: Vec<_> = shapes.iter().map(|shape| (shape.kind, shape.mesh)).collect();
    assert_eq!(
        used,
        [("mesh", Some(0)), ("mesh", Some(1)), ("mesh", Some(2)), ("mesh", Some(0))],
        "no bone beside"
    );
    for (k, (size, place)) in shapes[0].size.iter().zip(shapes[0].position).enumerate() {
        let half = [0.05, 0.1, 0.2][k];
        assert!((size - half).abs() < 1e-8 && (place - half).abs() < 1e-8, "{:?}", shapes[0]);
        let corners = shapes[0].corners().map(|corner| corner[k]);
        let [low, high] = [f64::min, f64::max].map(|of| corners.iter().copied().reduce(of).unwrap());
        assert!(low.abs() < 1e-8 && (high - 2.0 * half).abs() < 1e-8, "{corners:?}");
    }
}

#[test]
fn scale_mirror_and_reference_are_those_of_mujoco() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.stl"), binary_stl(&cuboid([100.0, 200.0, 400.0]))).unwrap();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let placed = MeshGeom {
        scale: [1e-3, -1e-3, 1e-3],
        reference_position: [100.0, 0.0, 0.0],
        // z of the shape is x of the file.
        reference_orientation: [half, 0.0, half, 0.0],
        ..mesh("a.stl")
    };
    let mut robot = robot(vec![placed]);
    assert!(read_meshes(&mut robot, folder.path()).is_empty());
    assert!((volume(&robot, 0) - 6.0 * 0.008).abs() < 1e-7, "mirrored and still facing outwards");
    let shape = &shapes(robot.parts())[0];
    // x runs from -400 to 0 in the shape's frame, y from 0 to -200, z from -100 to 0.
    for (k, (size, place)) in shape.size.iter().zip(shape.position).enumerate() {
        let (half, centre) = ([0.2, 0.1, 0.05][k], [-0.2, -0.1, -0.05][k]);
        assert!((size - half).abs() < 1e-7 && (place - centre).abs() < 1e-7, "{shape:?}");
    }
}

#[test]
fn many_triangles_become_few_and_small_parts_stay_whole_enough() {
    let folder = tempfile::tempdir().unwrap();
    let tiles = |n: usize| -> Vec<[[f32; 3]; 3]> {
        (0..n * n)
            .map(|k| {
                let (x, y) = ((k % n) as f32 / n as f32, (k / n) as f32 / n as f32);
                [[x, y, 0.0], [x + 1.0 / n as f32, y, 0.0], [x, y + 1.0 / n as f32, 0.1]]
            })
            .collect()
    };
    std::fs::write(folder.path().join("large.stl"), binary_stl(&tiles(400))).unwrap();
    std::fs::write(folder.path().join("small.stl"), binary_stl(&cuboid([0.1; 3]))).unwrap();
    let mut robot = robot(vec![mesh("large.stl"), mesh("small.stl")]);
    assert!(read_meshes(&mut robot, folder.path()).is_empty());
    let count = |index: usize| robot.parts().meshes[index].surface.as_ref().unwrap().triangles.len();
    assert!((3_000..=20_000).contains(&count(0)), "{}", count(0));
    assert_eq!(count(1), 12);
    let bytes = serde_json::to_string(&meshes(robot.parts())).unwrap().len();
    assert!(bytes < 700_000, "{bytes}");
}

#[test]
fn what_is_no_mesh_is_named_once_and_the_body_keeps_its_bone() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    let whole = binary_stl(&cuboid([0.1; 3]));
    write("cut.stl", &whole[..whole.len() - 30]);
    write("empty.stl", &binary_stl(&[]));
    write("nan.stl", &binary_stl(&[[[f32::NAN; 3]; 3]]));
    write("far.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    write("text.obj", b"hello\xff\xfe");
    write("shape.dae", b"<COLLADA/>");
    for (file, words) in [
        ("cut.stl", "is no STL"),
        ("empty.stl", "holds no triangle"),
        ("nan.stl", "not finite"),
        ("far.obj", ""),
        ("text.obj", ""),
        ("shape.dae", "expected a mesh in STL, OBJ or MSH"),
        ("none.stl", "cannot be read"),
    ] {
        let mut robot = robot(vec![mesh(file), mesh(file)]);
        let problems = read_meshes(&mut robot, folder.path());
        assert_eq!(problems.len(), 1, "{file}: {problems:?}");
        assert!(problems[0].starts_with(file) && problems[0].contains(words), "{problems:?}");
        assert!(meshes(robot.parts()).is_empty());
        assert!(shapes(robot.parts()).iter().all(|shape| shape.kind != "mesh"));
    }
}

/// Bytes at random in place of those of a file never end in a panic.
#[test]
fn damaged_files_are_read_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut state = 7_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let triangles = cuboid([0.1, 0.2, 0.3]);
    for (name, whole) in [
        ("a.stl", binary_stl(&triangles)),
        ("b.stl", ascii_stl(&triangles).into_bytes()),
        ("c.obj", obj(&triangles).into_bytes()),
    ] {
        for _ in 0..300 {
            let mut bytes = whole.clone();
            for _ in 0..1 + random(6) {
                let at = random(bytes.len());
                bytes[at] = random(256) as u8;
            }
            bytes.truncate(bytes.len() - random(bytes.len() / 2));
            std::fs::write(folder.path().join(name), &bytes).unwrap();
            let mut robot = robot(vec![mesh(name)]);
            let problems = read_meshes(&mut robot, folder.path());
            let read = robot.parts().meshes[0].surface.is_some();
            assert_eq!(problems.len(), usize::from(!read));
            serde_json::to_string(&shapes(robot.parts())).unwrap();
        }
    }
}
