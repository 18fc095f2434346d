//! Shapes of bodies from MJCF, URDF and TOML, and back.

use super::parts;
use sinew::body::{Geom, GeomKind, Robot};
use sinew::description::{from_mjcf, from_toml, from_urdf, to_mjcf, to_toml};

const LEG: &str = r#"<mujoco>
  <worldbody>
    <geom type="plane" size="1 1 0.1"/>
    <body name="thigh">
      <joint name="hip" type="hinge" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.05" density="1000"/>
      <geom name="pulley" type="cylinder" size="0.03 0.01" mass="0"/>
      <geom name="skid" type="sphere" size="0.02" pos="0.1 0 0" mass="0"/>
      <site name="a" pos="0.05 0 0.1"/>
      <body name="shank" pos="0 0 -0.4">
        <geom type="box" size="0.01 0.02 0.2" quat="0 1 0 0" mass="1"/>
        <geom type="ellipsoid" size="0.03 0.02 0.01" mass="0.1"/>
        <site name="b" pos="0.05 0 -0.1"/>
      </body>
    </body>
  </worldbody>
  <tendon><spatial name="t"><site site="a"/><geom geom="pulley"/><site site="b"/></spatial></tendon>
</mujoco>"#;

#[test]
fn shapes_are_read_with_their_bodies_and_a_surface_of_a_cable_is_none() {
    let parts = parts(LEG);
    let found: Vec<(usize, GeomKind, [f64; 3])> =
        parts.geoms.iter().map(|geom| (geom.body, geom.kind, geom.size)).collect();
    let expected = [
        (1, GeomKind::Capsule, [0.05, 0.2, 0.0]),
        (1, GeomKind::Sphere, [0.02, 0.0, 0.0]),
        (2, GeomKind::Box, [0.01, 0.02, 0.2]),
        (2, GeomKind::Ellipsoid, [0.03, 0.02, 0.01]),
    ];
    assert_eq!(found, expected);
    assert!((parts.geoms[0].position[2] + 0.2).abs() < 1e-12, "between its ends");
    assert_eq!(parts.wraps.len(), 1);
}

#[test]
fn shapes_survive_mjcf_and_toml_and_add_no_mass() {
    let parts = parts(LEG);
    let again = from_mjcf("m.xml", &to_mjcf(&parts), &mut |_| Err(String::new())).unwrap();
    assert_eq!(again.parts.geoms, parts.geoms);
    assert_eq!(again.parts.bodies, parts.bodies);
    let toml = from_toml("m.toml", &to_toml(&parts)).unwrap();
    assert_eq!(toml.parts.geoms, parts.geoms);
    Robot::new(toml.parts).unwrap();
}

#[test]
fn a_capsule_between_two_points_is_the_one_of_mjcf() {
    let toml = "name = \"leg\"\n[[body]]\nname = \"thigh\"\nparent = \"world\"\nmass_kg = \
        1.0\ninertia_kg_m2 = [1, 1, 1]\n\
                [[geom]]\nbody = \"thigh\"\nkind = \"capsule\"\nsize_m = [0.05]\nends_m = [0, 0, -0.4, 0, 0, 0]\n";
    let found = from_toml("leg.toml", toml).unwrap().parts.geoms;
    assert_eq!(found, parts(LEG).geoms[..1]);
    for (wrong, words) in [
        ("kind = \"cone\"", "expected one of `sphere`, `capsule`, `cylinder`, `ellipsoid`, `box`"),
        ("kind = \"box\"", "expected a capsule or a cylinder with one size"),
        ("kind = \"capsule\"\nposition_m = [0, 0, 0]", "expected one of them"),
    ] {
        let error =
            from_toml("leg.toml", &toml.replace("kind = \"capsule\"", wrong)).unwrap_err().to_string();
        assert!(error.contains(words) && error.contains("leg.toml"), "{error}");
    }
    let short = toml.replace("size_m = [0.05]\nends_m = [0, 0, -0.4, 0, 0, 0]", "size_m = [0.05]");
    assert!(from_toml("leg.toml", &short).unwrap_err().to_string().contains("expected 2 numbers > 0"));
    let point = toml.replace("-0.4", "0");
    assert!(from_toml("leg.toml", &point).unwrap_err().to_string().contains("both ends in one point"));
}

#[test]
fn the_shapes_of_urdf_links_are_their_visuals() {
    let urdf = r#"<robot name="r"><link name="base"><visual><geometry><mesh filename="a.stl"/></geometry></visual></link>
      <link name="arm"><visual><origin xyz="0 0 0.1"/><geometry><cylinder radius="0.02" length="0.2"/></geometry></visual>
      <visual><geometry><box size="0.1 0.2 0.3"/></geometry></visual></link>
      <joint name="j" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
      <limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"#;
    let found = from_urdf("r.urdf", urdf, None).unwrap().parts.geoms;
    let geom =
        |kind, size, position| Geom { body: 2, kind, size, position, orientation: [1.0, 0.0, 0.0, 0.0] };
    let expected = [
        geom(GeomKind::Cylinder, [0.02, 0.1, 0.0], [0.0, 0.0, 0.1]),
        geom(GeomKind::Box, [0.05, 0.1, 0.15], [0.0; 3]),
    ];
    assert_eq!(found, expected);
}

#[test]
fn a_shape_of_a_robot_is_finite_and_has_a_body() {
    let valid = parts(LEG);
    let refused = |change: fn(&mut Geom)| {
        let mut parts = valid.clone();
        change(&mut parts.geoms[0]);
        Robot::new(parts).unwrap_err().to_string()
    };
    assert!(refused(|geom| geom.body = 9).contains("body"));
    assert!(refused(|geom| geom.size[1] = f64::NAN).contains("size"));
    assert!(refused(|geom| geom.size[0] = 0.0).contains("size"));
    assert!(refused(|geom| geom.position[2] = f64::INFINITY).contains("position"));
}

const MESHES: &str = r#"<mujoco>
  <compiler meshdir="../shapes/"/>
  <default><mesh scale="0.001 0.001 0.001"/></default>
  <asset>
    <mesh file="bones/radius.stl"/>
    <mesh name="shell" file="Shell.OBJ" scale="1 -1 1" refpos="1 2 3" refquat="0 2 0 0"/>
    <mesh name="inline" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>
  </asset>
  <worldbody>
    <body name="arm">
      <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
      <geom mesh="radius" pos="0 0 0.1" group="2"/>
      <geom type="capsule" size="0.1 0.2" group="3" density="0"/>
      <body name="hand">
        <geom type="mesh" mesh="shell" quat="0 0 3 0" density="0"/>
        <geom type="mesh" mesh="inline" density="0"/>
      </body>
      <body name="hook"><geom size="0.1" group="4" density="0"/></body>
    </body>
  </worldbody>
</mujoco>"#;

#[test]
fn files_of_triangles_are_named_and_placed_as_mujoco_does() {
    let found = from_mjcf("m.xml", MESHES, &mut |_| Err(String::new())).unwrap();
    let [radius, shell] = &found.parts.meshes[..] else { panic!("{:?}", found.parts.meshes) };
    assert_eq!((radius.body, radius.file.as_str()), (1, "../shapes/bones/radius.stl"));
    assert_eq!((radius.scale, radius.position), ([0.001; 3], [0.0, 0.0, 0.1]));
    assert_eq!((shell.body, shell.file.as_str()), (2, "../shapes/Shell.OBJ"));
    assert_eq!((shell.scale, shell.reference_position), ([1.0, -1.0, 1.0], [1.0, 2.0, 3.0]));
    assert!(shell.reference_orientation[1] > 1.0 - 1e-12, "{shell:?}");
    assert!(shell.orientation[2] > 1.0 - 1e-12, "{shell:?}");
    assert!(found.warnings.iter().any(|warning| warning.what.contains("no file")), "{:?}", found.warnings);
    // Shapes for collisions are hidden where there are others, as in MuJoCo's viewer.
    assert!(found.parts.geoms.is_empty(), "{:?}", found.parts.geoms);
    let alone = MESHES.replace("group=\"2\"", "group=\"3\"").replace("mesh=\"shell\"", "mesh=\"inline\"");
    let alone = from_mjcf("m.xml", &alone, &mut |_| Err(String::new())).unwrap().parts;
    assert_eq!((alone.geoms.len(), alone.meshes.len()), (2, 1));
    Robot::new(found.parts).unwrap();
    let stripped = MESHES.replace("meshdir=", "strippath=\"true\" assetdir=");
    let stripped = from_mjcf("m.xml", &stripped, &mut |_| Err(String::new())).unwrap();
    assert_eq!(stripped.parts.meshes[0].file, "../shapes/radius.stl");
}

#[test]
fn files_of_triangles_in_urdf_keep_their_origin_and_scale() {
    let urdf = r#"<robot name="r"><link name="base"><visual><origin xyz="0 0 1" rpy="0 0 0"/>
        <geometry><mesh filename="package://arm/meshes/base.stl" scale="0.1 0.1 0.1"/></geometry></visual></link></robot>"#;
    let found = from_urdf("r.urdf", urdf, None).unwrap().parts.meshes;
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].body, found[0].file.as_str()), (1, "package://arm/meshes/base.stl"));
    assert_eq!((found[0].scale, found[0].position), ([0.1; 3], [0.0, 0.0, 1.0]));
}

/// Triangles of a body with a hole in it, and no symmetry.
const CORNERS: &str = "0.1 0 0 -0.08 0.01 0 0 0.12 0 0.01 -0.09 0 0 0 0.15 0.02 0 -0.05";
const FACES: &str = "0 2 4 2 1 4 1 3 4 3 0 4 2 0 5 1 2 5 3 1 5";

/// A body with these triangles, given in the model or in a file.
fn meshed(source: &str, law: &str, geom: &str) -> String {
    format!(
        "<mujoco><asset><mesh name=\"m\" {source} scale=\"1 -1.5 1\" refpos=\"0.01 0.02 0.03\" \
         refquat=\"1 0.2 0 0\" {law}/></asset><worldbody><body><joint/><geom type=\"mesh\" mesh=\"m\" \
         pos=\"0.3 0 0\" quat=\"1 0 1 0\" {geom}/></body></worldbody></mujoco>"
    )
}

#[test]
fn mass_and_inertia_of_meshes_are_those_of_mujoco() {
    // By MuJoCo 4.0.0, with a density of 500 kg/m^3, of a shell kg/m^2.
    let enclosed = (
        0.857_130_263_768_111,
        [0.301_462_598_255_402_56, 0.012_799_817_362_419_684, 0.005_298_881_235_980_222],
        [
            2.622_197_518_041_271_5e-3,
            1.727_453_850_260_129_6e-3,
            2.982_272_783_048_890_7e-3,
            -1.209_318_446_749e-4,
            6.406_169_089e-6,
            4.700_003_262e-5,
        ],
    );
    let surface = (
        44.247_526_732_190_444,
        [0.302_834_179_539_486_66, 0.010_944_852_800_137_883, 0.005_365_917_945_402_739],
        [
            0.223_760_542_219_309_9,
            0.148_717_673_108_915_95,
            0.254_738_649_360_837_84,
            -0.011_528_407_426_32,
            4.227_881_165_024e-4,
            4.062_505_090_931_6e-3,
        ],
    );
    let hull = (
        0.942_500_034_170_225,
        [0.299_735_770_036_359_1, 0.018_548_767_045_871_51, 0.002_616_046_964_743_965],
        [
            3.073_695_991_146_492e-3,
            1.861_906_030_247_235_6e-3,
            3.387_352_372_207_711e-3,
            -3.748_091_896_079e-5,
            -3.963_704_861_778e-5,
            1.768_018_166_821_8e-4,
        ],
    );
    let inline = format!("vertex=\"{CORNERS}\" face=\"{FACES}\"");
    let corners = format!("vertex=\"{CORNERS}\"");
    let numbers = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
    let lines = |letter: &str, text: &str, add: i32| -> String {
        let numbers: Vec<String> = match add {
            0 => numbers(text),
            _ => numbers(text).iter().map(|k| (k.parse::<i32>().unwrap() + add).to_string()).collect(),
        };
        numbers.chunks(3).map(|three| format!("{letter} {}\n", three.join(" "))).collect()
    };
    let file = lines("v", CORNERS, 0) + &lines("f", FACES, 1);
    let near = |a: f64, b: f64, size: f64| (a - b).abs() < 1e-9 * size;
    for source in [inline.as_str(), "file=\"m.stl\"", &corners] {
        let of_faces = source != corners;
        for (law, (mass, center, tensor)) in [
            ("", if of_faces { enclosed } else { hull }),
            ("inertia=\"exact\"", if of_faces { enclosed } else { hull }),
            ("inertia=\"legacy\"", if of_faces { enclosed } else { hull }),
            ("inertia=\"convex\"", hull),
            ("inertia=\"shell\"", surface),
        ]
        .into_iter()
        .filter(|(law, _)| of_faces || !law.contains("shell"))
        {
            let text = meshed(source, law, "density=\"500\"");
            let found = from_mjcf("m.xml", &text, &mut |name| {
                assert_eq!(name, "m.stl");
                Ok(file.clone())
            });
            let body = found.unwrap().parts.bodies[1].clone();
            // MuJoCo's hull is 1e-7 off the corners that it is made of.
            let slack = if !of_faces || law.contains("convex") { 1e3 } else { 1.0 };
            let near = |a: f64, b: f64, size: f64| near(a, b, slack * size);
            assert!(near(body.mass, mass, mass), "{source} {law}: {} kg", body.mass);
            assert!(
                (0..3).all(|i| near(body.center_of_mass[i], center[i], 1.0)),
                "{:?}",
                body.center_of_mass
            );
            assert!((0..6).all(|i| near(body.inertia[i], tensor[i], tensor[2])), "{:?}", body.inertia);
        }
        let text = meshed(source, "", "mass=\"2\"");
        let body = from_mjcf("m.xml", &text, &mut |_| Ok(file.clone())).unwrap().parts.bodies[1].clone();
        let (mass, _, tensor) = if of_faces { enclosed } else { hull };
        assert!(near(body.mass, 2.0, 2.0) && near(body.inertia[0], tensor[0] * 2.0 / mass, 1.0));
    }
}

#[test]
fn a_mesh_whose_mass_is_needed_and_not_known_is_refused_with_its_line_and_the_way_out() {
    let error = |source: &str, law: &str, geom: &str, file: Result<String, String>| {
        from_mjcf("m.xml", &meshed(source, law, geom), &mut |_| file.clone()).unwrap_err().to_string()
    };
    let inline = format!("vertex=\"{CORNERS}\" face=\"{FACES}\"");
    let none = Err("cannot be read".to_owned());
    for (source, law, geom, file, words) in [
        ("file=\"m.stl\"", "", "", none.clone(), "`m.stl`: cannot be read"),
        ("file=\"m.stl\"", "", "", Ok("v 0 0\n".to_owned()), "line `v 0 0`"),
        ("builtin=\"sphere\" params=\"1\"", "", "", none.clone(), "expected a file, or vertices"),
        ("vertex=\"0 0 0 1 0 0 0 1 0 1 1 0\"", "", "", none.clone(), "corners in one plane"),
        (&*inline.replace("3 1 5", "3 1 9"), "", "", none.clone(), "corner 9"),
        (&*inline, "inertia=\"solid\"", "", none.clone(), "solid"),
    ] {
        let error = error(source, law, geom, file);
        assert!(error.starts_with("m.xml:1:") && error.contains(words), "{error}");
    }
    // Nothing is read of a mesh without mass, nor where the body says its inertia.
    let massless = meshed("file=\"m.stl\"", "", "density=\"0\"")
        .replace("</body>", "<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/></body>");
    assert!(from_mjcf("m.xml", &massless, &mut |_| Err("is not asked for".to_owned())).is_ok());
}
