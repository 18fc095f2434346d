//! Models that attach others, and copies.

use super::{refused, world};
use sinew::body::{Parts, PathElement, Robot, TendonPath};
use sinew::description::{DescriptionError, from_mjcf};

/// A finger with its tendon, in degrees; its proximal link alone holds a tendon of its own.
const FINGER: &str = r#"<mujoco model="finger"><compiler eulerseq="zyx"/><worldbody><site name="base" pos="0 0 1"/>
    <body name="link" pos="0.1 0 0" euler="90 0 0"><joint name="j" axis="0 1 0" range="-30 60"/>
      <geom size="0.01" mass="0.1"/><site name="a" pos="0 0 0.01"/><site name="b" pos="0.02 0 0.01"/>
      <body name="tip" pos="0.05 0 0"><joint name="k" axis="0 1 0"/><geom size="0.01" mass="0.05"/>
        <site name="c" pos="0.02 0 0.01"/></body></body></worldbody>
    <tendon><spatial name="long"><site site="base"/><site site="c"/></spatial>
      <spatial name="short"><site site="a"/><site site="c"/></spatial></tendon>
    <equality><joint joint1="k" joint2="j"/></equality>
    <actuator><motor name="m" tendon="short"/></actuator></mujoco>"#;

fn read(text: &str) -> Result<Parts, DescriptionError> {
    from_mjcf("robot.xml", text, &mut |name| match name {
        "parts/finger.xml" => Ok(FINGER.to_owned()),
        "circle.xml" => Ok(attaching("circle.xml", "<attach model=\"f\" prefix=\"x\"/>")),
        _ => Err(format!("{name} is not here")),
    })
    .map(|found| found.parts)
}

fn attaching(file: &str, body: &str) -> String {
    format!(
        "<mujoco>\n<compiler angle=\"radian\"/><asset><model name=\"f\" file=\"{file}\"/></asset>\n\
         <worldbody>\n{body}\n</worldbody>\n</mujoco>"
    )
}

fn is_near(a: [f64; 3], b: [f64; 3]) -> bool {
    (0..3).all(|i| (a[i] - b[i]).abs() < 1e-12)
}

fn names<T>(of: &[T], name: fn(&T) -> &str) -> Vec<&str> {
    of.iter().map(name).collect()
}

#[test]
fn a_body_is_attached_with_what_is_below_it_and_refers_to_nothing_else() {
    let text = attaching(
        "parts/finger.xml",
        "<body name=\"palm\"><geom size=\"1\"/><joint name=\"j\"/><frame pos=\"1 0 0\" euler=\"0 0 1.5707963267948966\">\
         <attach model=\"f\" body=\"link\" prefix=\"one_\"/></frame><body name=\"between\"/>\
         <attach model=\"f\" body=\"link\" prefix=\"two_\"/></body>",
    );
    let parts = read(&text).unwrap();
    assert_eq!(
        names(&parts.bodies, |body| &body.name),
        ["world", "palm", "one_link", "one_tip", "between", "two_link", "two_tip"]
    );
    assert_eq!(names(&parts.joints, |joint| &joint.name), ["j", "one_j", "one_k", "two_j", "two_k"]);
    assert_eq!(parts.joints.iter().map(|joint| joint.body).collect::<Vec<_>>(), [1, 2, 3, 5, 6]);
    assert_eq!(names(&parts.tendons, |tendon| &tendon.name), ["one_short", "two_short"]);
    assert_eq!(names(&parts.actuators, |actuator| &actuator.name), ["one_m", "two_m"]);
    assert_eq!(parts.actuators[1].tendon, 1);
    let followers: Vec<_> = parts.couplings.iter().map(|c| (c.follower, c.leader)).collect();
    assert_eq!(followers, [(2, Some(1)), (4, Some(3))]);
    // The frame of the outer model in radians, the body's own in degrees and another order of angles.
    assert!(
        is_near(parts.bodies[2].position, [1.0, 0.1, 0.0])
            && is_near(parts.bodies[5].position, [0.1, 0.0, 0.0])
    );
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let [w, x, y, z] = parts.bodies[2].orientation;
    assert!(
        w.abs() < 1e-12 && is_near([x, y, z.abs()], [0.0, 0.0, 1.0]),
        "{:?}",
        parts.bodies[2].orientation
    );
    assert!((parts.bodies[5].orientation[0] - half).abs() < 1e-12);
    assert!((parts.joints[1].range.unwrap()[1] - 60.0_f64.to_radians()).abs() < 1e-12);
    assert!((parts.bodies[6].mass - 0.05).abs() < 1e-15);
    let TendonPath::Spatial(path) = &parts.tendons[1].path else { panic!() };
    let sites = path.iter().map(|element| match element {
        PathElement::Site(site) => parts.sites[*site].name.as_str(),
        _ => "",
    });
    assert_eq!(sites.collect::<Vec<_>>(), ["two_a", "two_c"]);
    Robot::new(parts).unwrap();
}

#[test]
fn all_of_a_model_is_attached_to_the_world() {
    let parts = read(&attaching(
        "parts/finger.xml",
        "<frame pos=\"0 0 2\"><attach model=\"f\" prefix=\"\"/></frame>",
    ))
    .unwrap();
    assert_eq!(names(&parts.bodies, |body| &body.name), ["world", "link", "tip"]);
    assert_eq!(names(&parts.tendons, |tendon| &tendon.name), ["long", "short"]);
    let base = parts.sites.iter().find(|site| site.name == "base").unwrap();
    assert!(base.body == 0 && is_near(base.position, [0.0, 0.0, 3.0]));
    assert!(is_near(parts.bodies[1].position, [0.1, 0.0, 2.0]));
}

#[test]
fn copies_of_what_is_attached_and_models_without_a_name() {
    let text = attaching(
        "parts/finger.xml",
        "<replicate count=\"2\" offset=\"1 0 0\" sep=\"-\">\
         <attach model=\"finger\" body=\"link\" prefix=\"p_\"/></replicate>",
    );
    let text = text.replace("name=\"f\" ", "");
    let parts = read(&text).unwrap();
    assert_eq!(
        names(&parts.bodies, |body| &body.name),
        ["world", "p_link-0", "p_tip-0", "p_link-1", "p_tip-1"]
    );
    assert_eq!(names(&parts.tendons, |tendon| &tendon.name), ["p_short-0", "p_short-1"]);
    assert!(is_near(parts.bodies[3].position, [1.1, 0.0, 0.0]));
    let error = read(&text.replace("model=\"finger\"", "model=\"thumb\"")).unwrap_err().to_string();
    assert!(error.contains("`thumb`"), "{error}");
    let own = text.replace("<attach", "<attach suffix=\"x\"");
    assert!(read(&own).unwrap_err().to_string().contains("suffix"));
}

#[test]
fn what_cannot_be_attached_is_refused_at_its_place() {
    let refuses = |file: &str, attach: &str, words: &[&str]| {
        let error = read(&attaching(file, attach)).unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    let finger = "parts/finger.xml";
    refuses(finger, "<attach model=\"g\"/>", &["robot.xml:4", "`g`", "<model>"]);
    refuses(finger, "<attach model=\"f\" body=\"palm\"/>", &["robot.xml:4", "`palm`"]);
    refuses(finger, "<body><attach model=\"f\"/></body>", &["robot.xml:4", "body", "world"]);
    refuses(
        finger,
        "<attach model=\"f\" body=\"tip\"/><attach model=\"f\" body=\"tip\"/>",
        &["robot.xml:4", "the body `tip`"],
    );
    refuses("none.xml", "<attach model=\"f\"/>", &["robot.xml:2", "none.xml is not here"]);
    refuses("circle.xml", "<attach model=\"f\" prefix=\"y\"/>", &["circle.xml", "attach each other"]);
}

#[test]
fn copies_of_tendons_stand_in_the_order_of_their_replicates() {
    let text = r#"<mujoco><worldbody><site name="o"/>
        <replicate count="2" offset="1 0 0"><body name="p"><joint/><geom size="1"/><site name="a"/></body></replicate>
        <replicate count="2" offset="1 0 0"><body name="q"><joint/><geom size="1"/><site name="b"/></body></replicate>
        </worldbody><tendon><spatial name="s"><site site="o"/><site site="a"/></spatial>
        <spatial name="t"><site site="o"/><site site="b"/></spatial></tendon></mujoco>"#;
    assert_eq!(names(&read(text).unwrap().tendons, |tendon| &tendon.name), ["s0", "s1", "t0", "t1"]);
}

#[test]
fn a_free_body_in_the_frame_of_its_inertia_is_refused() {
    refused(
        &world("<body><freejoint align=\"true\"/><geom size=\"1\"/></body>"),
        3,
        &["align", "principal axes"],
    );
    let all = |align: &str| {
        format!(
            "<mujoco><compiler alignfree=\"true\"/><worldbody>\n<body><freejoint {align}/><geom size=\"1\"/></body>\
             </worldbody></mujoco>"
        )
    };
    refused(&all(""), 2, &["align"]);
    assert!(read(&all("align=\"false\"")).is_ok());
}
