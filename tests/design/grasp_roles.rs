//! Roles in a grasp: units of tests/anchors/grasp.json, defaults and keys.

use phalanx::law::{ContactLaw, Damping, NormalLaw};
use phalanx::mechanism::{
    Body, ContactPair, ForcePoint, Joint, JointKind, Mechanism, Outline, OutlineId, OutlineShape,
};
use phalanx::scene::{Scene, parse_any};
use phalanx::statics::{GraspKeys, NoGrasp, carries, default_base, grasp_roles, roles};
use serde_json::Value;

fn body(name: &str) -> Body {
    let shape = OutlineShape::Disc { center_m: [0.0; 2], radius_m: 0.01 };
    let outlines = vec![Outline { name: "skin".to_string(), shape }];
    Body { outlines, ..Body::new(name, 0.1, 1e-5) }
}

fn joint(bodies: [Option<usize>; 2]) -> Joint {
    Joint::new("joint", JointKind::Revolute, bodies, [[0.0; 2]; 2])
}

fn pair(points: OutlineId, face: OutlineId) -> ContactPair {
    let damping = Damping::Constant { n_s_per_m: 0.0 };
    let law = ContactLaw { normal: NormalLaw { stiffness_n_per_m_e: 1e6, exponent: 1.5, damping }, friction: None };
    ContactPair {
        name: None,
        points,
        face,
        law,
        rolling: None,
        force_point: ForcePoint::Face,
        is_reported_on_face: false,
    }
}

#[test]
fn the_base_of_role_units_is_the_last_body_that_branches() {
    let text = std::fs::read_to_string("tests/anchors/grasp.json").expect("the anchors");
    let anchors: Value = serde_json::from_str(&text).expect("valid JSON");
    let units = anchors["roles"].as_array().expect("a list");
    assert_eq!(units.len(), 4);
    for unit in units {
        let what = unit["what"].as_str().expect("a name");
        let mut mechanism = Mechanism { bodies: vec![body("object")], ..Mechanism::default() };
        let mut index_of = |name: &str| match mechanism.bodies.iter().position(|body| body.name == name) {
            _ if name == "ground" => None,
            Some(found) => Some(found),
            None => {
                mechanism.bodies.push(body(name));
                Some(mechanism.bodies.len() - 1)
            }
        };
        let pairs = unit["joints"].as_array().expect("a list");
        let joints: Vec<_> =
            pairs.iter().map(|pair| [0, 1].map(|k: usize| index_of(pair[k].as_str().expect("a name")))).collect();
        let touching = unit["bodies_with_a_pair"].as_array().expect("a list").iter();
        let touching: Vec<_> = touching.map(|name| index_of(name.as_str().expect("a name"))).collect();
        mechanism.joints = joints.into_iter().map(joint).collect();
        let outline = |body| OutlineId { body, outline: 0 };
        mechanism.contacts = touching.into_iter().map(|body| pair(outline(body), outline(Some(0)))).collect();
        let base = mechanism.body_name(default_base(&mechanism, 0, &[])).to_string();
        assert_eq!(base, unit["base"].as_str().expect("a name"), "{what}");
    }
}

const JAWS: &str = r#"
kind = "mechanism"
[bodies.left]
mass = "80 g"
inertia = "5000 g*mm^2"
guess = { at = ["-21 mm", "0 mm"] }
[bodies.left.outlines.pad]
type = "box"
size = ["10 mm", "20 mm"]
rounding = "1 mm"
[joints.left]
type = "prismatic"
bodies = ["ground", "left"]
points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
start = "-21 mm"
[bodies.cube]
mass = "200 g"
inertia = "11250 g*mm^2"
com = ["1 mm", "0 mm"]
[bodies.cube.outlines.skin]
type = "box"
size = ["30 mm", "40 mm"]
rounding = "1 mm"
[ground.outlines.floor]
type = "half_plane"
point = ["0 mm", "-20 mm"]
normal = [0, 1]
[ground.outlines.palm]
type = "disc"
center = ["0 mm", "60 mm"]
radius = "10 mm"
[laws.pad]
stiffness = 1e7
[[contacts]]
between = ["*", "cube"]
law = "pad"
"#;

fn jaws(more: &str) -> Scene {
    parse_any(&format!("{JAWS}{more}"), "jaws.toml").unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_pair_has_all_points_of_two_outlines() {
    let scene = jaws("");
    let roles = scene.grasp_roles().expect("a grasp");
    let mechanism = scene.mechanism.as_ref().expect("a mechanism");
    assert_eq!(mechanism.body_name(Some(roles.object)), "cube");
    let names: Vec<_> = roles.pairs.iter().map(|pair| (pair.name.as_str(), pair.points.len(), pair.is_hand)).collect();
    // Four corners of each of two boxes; a half plane and a disc have one direction.
    let expected =
        [("left.pad/cube.skin", 8, true), ("ground.floor/cube.skin", 4, true), ("ground.palm/cube.skin", 1, true)];
    assert_eq!(names.len(), 3);
    expected.into_iter().for_each(|pair| assert!(names.contains(&pair), "{pair:?}: {names:?}"));
    assert_eq!(roles.assumed_hand.len(), 2);
    // The farthest corner is that to the left: its core, and the rounding.
    let farthest = 15.0f64.hypot(19.0) + 1.0;
    assert!((roles.radius_m - 1e-3 * farthest).abs() < 1e-15, "{}", roles.radius_m);
    assert!((scene.thresholds.loss_force_n - 1e-3 * 0.2 * 9.81).abs() < 1e-18);
}

#[test]
fn keys_choose_object_base_surroundings_and_release() {
    let scene =
        jaws("[grasp]\nobject = \"cube\"\nbase = \"left\"\nsurroundings = [\"ground.f*\"]\nrelease = \"4 ms\"\n");
    let roles = scene.grasp_roles().expect("a grasp");
    let mechanism = scene.mechanism.as_ref().expect("a mechanism");
    assert_eq!(mechanism.body_name(roles.base), "left");
    // With a base other than the ground, all outlines of the ground are surroundings.
    assert_eq!(roles.pairs.iter().filter(|pair| pair.is_hand).count(), 1);
    assert!(roles.assumed_hand.is_empty());
    assert_eq!(scene.grasp.as_ref().and_then(|keys| keys.release_s), Some(4e-3));
    // As shown, the scene is the same.
    let shown = phalanx::scene::show(&scene);
    let again = parse_any(&shown, "jaws.toml").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(again, Scene { source: again.source.clone(), ..scene });

    let listed = jaws("[grasp]\nsurroundings = [\"ground.floor\"]\n").grasp_roles().expect("a grasp");
    let surroundings: Vec<_> = listed.pairs.iter().filter(|pair| !pair.is_hand).map(|pair| &pair.name).collect();
    assert_eq!(surroundings, ["ground.floor/cube.skin"]);
    // The other outline of the ground still counts as part of the hand, and the note says so.
    let palms: Vec<_> = listed.pairs.iter().filter(|pair| pair.name.starts_with("ground.palm")).collect();
    assert_eq!(listed.assumed_hand, palms.iter().map(|pair| pair.other).collect::<Vec<_>>());
    assert_eq!(listed.assumed_hand.len(), 1);
    let named = jaws("[grasp]\nbase = \"ground\"\n").grasp_roles().expect("a grasp");
    assert!(named.assumed_hand.is_empty());
}

#[test]
fn listed_outlines_do_not_decide_the_base() {
    // A palm on a lift with two fingers, and a shelf on a slider of its own.
    let bodies = ["object", "palm", "left", "right", "shelf"].map(body).to_vec();
    let joints = [[None, Some(1)], [Some(1), Some(2)], [Some(1), Some(3)], [None, Some(4)]].map(joint).to_vec();
    let outline = |body: usize| OutlineId { body: Some(body), outline: 0 };
    let contacts = vec![pair(outline(2), outline(0)), pair(outline(0), outline(3)), pair(outline(0), outline(4))];
    let mechanism = Mechanism { bodies, joints, contacts, ..Mechanism::default() };
    assert_eq!(default_base(&mechanism, 0, &[]), None);
    assert_eq!(default_base(&mechanism, 0, &[outline(4)]), Some(1));
    let keys = GraspKeys { surroundings: vec![outline(4)], ..GraspKeys::default() };
    let found = grasp_roles(&mechanism, &keys).expect("a grasp");
    assert_eq!((found.base, found.surroundings), (Some(1), vec![outline(4)]));
    assert!(!carries(&mechanism, (0, 1), &[]) && carries(&mechanism, (0, 1), &[outline(4)]));
    // On the ground as base, the shelf is not balanced with the object.
    let balanced = |surroundings: &[OutlineId]| roles(&mechanism, (0, None), surroundings, [].into_iter()).is_balanced;
    assert_eq!(balanced(&[]), [true, true, true, true, true]);
    assert_eq!(balanced(&[outline(4)]), [true, true, true, true, false]);
}

#[test]
fn scenes_without_a_grasp_have_a_reason() {
    let scene = jaws("");
    let mut mechanism = scene.mechanism.expect("a mechanism");
    let roles = |mechanism: &Mechanism| grasp_roles(mechanism, &GraspKeys::default());
    let half_plane = OutlineShape::HalfPlane { point_m: [0.0; 2], normal: [0.0, 1.0] };
    let with_half_plane = {
        let mut changed = mechanism.clone();
        let cube = changed.bodies.iter_mut().find(|body| body.name == "cube").expect("the cube");
        cube.outlines.push(Outline { name: "base".to_string(), shape: half_plane });
        changed
    };
    assert_eq!(roles(&with_half_plane), Err(NoGrasp::HalfPlane("cube.base".to_string())));
    // A second body without joints, with a contact.
    let count = mechanism.bodies.len();
    mechanism.bodies.push(body("ball"));
    let outline = |body| OutlineId { body: Some(body), outline: 0 };
    let left = mechanism.bodies.iter().position(|body| body.name == "left").expect("the jaw");
    mechanism.contacts.push(pair(outline(count), outline(left)));
    assert_eq!(roles(&mechanism), Err(NoGrasp::SeveralObjects(vec!["`cube`".to_string(), "`ball`".to_string()])));
    // One of them called `object` is the object.
    mechanism.bodies[count].name = "object".to_string();
    assert_eq!(roles(&mechanism).expect("a grasp").object, count);
    mechanism.joints.clear();
    assert_eq!(roles(&mechanism), Err(NoGrasp::Nothing));
}

#[test]
fn wrong_names_in_a_grasp_are_reported() {
    // A second jaw, which the first one does not carry.
    let right = "[bodies.right]\nmass = \"80 g\"\ninertia = \"5000 g*mm^2\"\n[bodies.right.outlines.pad]\ntype = \"disc\"\n\
                 radius = \"5 mm\"\n[joints.right]\ntype = \"prismatic\"\nbodies = [\"ground\", \"right\"]\n\
                 points = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\nstart = \"25 mm\"\n";
    for (keys, part) in [
        (
            "base = \"left\"",
            "`left`, which is not the base of the hand: joints connect other bodies that can touch `cube`",
        ),
        ("base = \"left\"", "name a body that carries all of them: `ground`"),
        ("release = \"0 s\"", "must be"),
        ("object = \"cub\"", "did you mean `cube`?"),
        ("base = \"cube\"\nobject = \"cube\"", "is the grasped body"),
        ("surroundings = [\"ground.flor\"]", "did you mean `ground.floor`?"),
    ] {
        let error =
            parse_any(&format!("{JAWS}{right}[grasp]\n{keys}\n"), "jaws.toml").expect_err("a wrong name").to_string();
        assert!(error.contains(part), "{keys}: {error}");
    }
}
