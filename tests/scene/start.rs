//! Starts of mechanisms: contacts that are listed once, overlaps and excesses that are refused, consistent starts.

use std::f64::consts::PI;

use phalanx::mechanism::{AssemblyError, Mechanism, Pose, assemble};
use phalanx::scene::{self, Scene};
use phalanx::trace::{self, Model};

use crate::parse;
use crate::support::random::Random;
use crate::support::scenes::trees::random_mechanism;

#[track_caller]
fn refused(text: &str, parts: &[&str]) -> String {
    let error = scene::parse_any(text, "test.toml").expect_err(text).to_string();
    parts.iter().for_each(|part| assert!(error.contains(part), "no {part:?} in {error}"));
    error
}

/// Two discs of 10 g that meet at 1 m/s, with these contacts.
fn meeting_discs(contacts: &str, mirror: bool) -> Scene {
    let body = |name: &str, sign: f64| {
        format!(
            "[bodies.{name}]\nmass = \"10 g\"\ninertia = \"100 g*mm^2\"\nstart = {{ at = [\"{} mm\", \"0 mm\"], velocity = \
             [\"{} m/s\", \"0 m/s\"] }}\noutlines.pad = {{ type = \"disc\", radius = \"10 mm\" }}\n",
            sign * 10.3,
            sign * -0.5
        )
    };
    let right = if mirror { "[mirror]\nfrom = \"left\"\nto = \"right\"\n".to_owned() } else { body("right", 1.0) };
    parse(&format!(
        "kind = \"mechanism\"\nduration = \"3 ms\"\n{right}{}[laws.l]\nstiffness = 1e6\n{contacts}",
        body("left", -1.0)
    ))
}

/// Two outlines touch once, however they are listed: 11.954 N and 522.8 µm, the closed form of ½ μ v² = ⅖ k δ^2.5.
#[test]
fn a_pair_of_outlines_is_one_contact() {
    let entry = |a: &str, b: &str| format!("[[contacts]]\nbetween = [\"{a}\", \"{b}\"]\nlaw = \"l\"\n");
    let directed = |a: &str, b: &str| format!("[[contacts]]\npoints = \"{a}\"\nface = \"{b}\"\nlaw = \"l\"\n");
    let (left, right) = ("left.pad", "right.pad");
    let depth_m = (2.5 * 0.5 * 5e-3 / 1e6f64).powf(0.4);
    for (contacts, mirror) in [
        (entry(left, right), false),
        (entry(right, left), false),
        (entry(left, right), true),
        (entry("*.pad", "*.pad"), false),
        (entry("*.pad", "*.pad"), true),
        (entry("*", "*"), true),
        (entry(left, right) + &entry(right, left), false),
        (entry(left, right) + &entry("left", "right"), true),
        (directed(left, right) + &directed(right, left), false),
        (directed(right, left), true),
    ] {
        let scene = meeting_discs(&contacts, mirror);
        let outcome = trace::run(Model::Analytic, &scene, &mut ()).expect("a run");
        let [contact] = &outcome.contacts[..] else { panic!("{contacts}: {:?}", outcome.contacts) };
        assert!((contact.peak_normal_n / 11.954 - 1.0).abs() < 1e-4, "{contacts}: {contact:?}");
        assert!((contact.max_penetration_m / depth_m - 1.0).abs() < 1e-4, "{contacts}: {contact:?}");
    }
}

/// All kinds of outlines in all ways of listing them have the contacts of one entry; different laws are refused.
#[test]
fn pairs_of_all_outlines_are_listed_once() {
    let outlines = [
        "type = \"disc\", radius = \"5 mm\"",
        "type = \"capsule\", from = [\"0 mm\", \"0 mm\"], to = [\"9 mm\", \"0 mm\"], radius = \"2 mm\"",
        "type = \"box\", size = [\"8 mm\", \"9 mm\"], rounding = \"1 mm\"",
        "type = \"ellipse\", semi_axes = [\"5 mm\", \"4 mm\"]",
        "type = \"half_plane\", point = [\"0 mm\", \"-40 mm\"], normal = [0, 1]",
    ];
    let body = |name: &str, x: i32, outline: &str| {
        format!(
            "[bodies.{name}]\nmass = \"1 g\"\ninertia = \"1 g*mm^2\"\nstart = {{ at = [\"{x} mm\", \"0 mm\"] }}\noutlines.o = \
             {{ {outline} }}\n"
        )
    };
    let entry = |a: &str, b: &str, law: &str| format!("[[contacts]]\nbetween = [\"{a}\", \"{b}\"]\nlaw = \"{law}\"\n");
    let laws = "[laws.l]\nstiffness = 1e6\n[laws.m]\nstiffness = 2e6\n";
    for (first, a) in outlines.iter().enumerate() {
        for (second, b) in
            outlines.iter().enumerate().filter(|(second, _)| *second + first < 6 && (first, *second) != (3, 3))
        {
            let scene = |contacts: String| {
                format!("kind = \"mechanism\"\n{laws}{}{}{contacts}", body("a", -20, a), body("b", 20, b))
            };
            let names = |contacts: String| {
                let scene = parse(&scene(contacts));
                let mechanism = scene.mechanism.expect("a mechanism");
                let contacts = mechanism.point_contacts().into_iter();
                let mut names: Vec<String> = contacts
                    .map(|of| format!("{} {}", of.name, mechanism.contacts[of.pair].law.normal.exponent))
                    .collect();
                // Two discs touch in either direction.
                names.iter_mut().filter(|_| [first, second] == [0, 0]).for_each(|name| *name = "discs".to_owned());
                names.sort();
                names
            };
            if (first, second) == (4, 4) {
                continue;
            }
            let once = names(entry("a.o", "b.o", "l"));
            for contacts in [
                entry("b.o", "a.o", "l"),
                entry("*.o", "*.o", "l"),
                entry("a.o", "b.o", "l") + &entry("b.o", "a.o", "l"),
                entry("*", "b", "l") + &entry("a", "*", "l"),
            ] {
                assert_eq!(names(contacts.clone()), once, "{contacts}");
            }
            for other in [entry("b.o", "a.o", "m"), entry("b.o", "a.o", "l") + "at = \"middle\"\n"] {
                let text = scene(entry("a.o", "b.o", "l") + &other);
                refused(&text, &["listed twice", "`contacts[1]`", "`contacts[0]`", "remove the pair from one of them"]);
            }
        }
    }
}

/// Overlaps of more than 1 mm at the start are refused with their depth, by closed forms.
#[test]
fn deep_overlaps_at_the_start_are_refused() {
    let mut random = Random(57);
    for _ in 0..60 {
        let radii = [random.within(2.0, 40.0), random.within(2.0, 40.0)];
        let depth_mm = random.choose(&[-1.0f64, 0.5, 0.99, 1.01, 2.0, 5.0]).min(0.9 * radii[0]);
        let direction = random.within(-PI, PI);
        let (first, distance) = match random.choose(&[0, 1, 2]) {
            0 => (format!("type = \"disc\", radius = \"{} mm\"", radii[0]), radii[0] + radii[1] - depth_mm),
            1 => (
                format!("type = \"half_plane\", normal = [{}, {}]", direction.cos(), direction.sin()),
                radii[1] - depth_mm,
            ),
            _ => (
                format!(
                    "type = \"box\", size = [\"{0} mm\", \"300 mm\"], rounding = \"1 mm\", angle = \"{direction} rad\"",
                    2.0 * radii[0]
                ),
                radii[0] + radii[1] - depth_mm,
            ),
        };
        let [x, y] = [distance * direction.cos(), distance * direction.sin()];
        let text = format!(
            "kind = \"mechanism\"\nduration = \"1 ms\"\n[bodies.a]\nmass = \"1 kg\"\ninertia = \"1 kg*m^2\"\noutlines.o = {{ {first} }}\n\
             [bodies.b]\nmass = \"1 kg\"\ninertia = \"1 kg*m^2\"\nstart = {{ at = [\"{x} mm\", \"{y} mm\"] }}\noutlines.o = {{ type = \
             \"disc\", radius = \"{} mm\" }}\n[laws.l]\nstiffness = 1e6\n[[contacts]]\nbetween = [\"a\", \"b\"]\nlaw = \"l\"\n",
            radii[1]
        );
        if depth_mm > 1.0 {
            refused(
                &text,
                &[&format!("{} mm inside", (1e4 * depth_mm).round() / 1e4), "at most 1 mm", "remove the pair"],
            );
        } else {
            parse(&text);
        }
    }
}

/// The object of a gripper that is a large disc, and one that is no object.
#[test]
fn an_outlined_object_must_fit_between_the_fingers() {
    let gripper = |outline: &str| {
        let text = std::fs::read_to_string("scenes/gripper/design-95.toml").expect("a scene");
        format!("{text}\n[object.outline]\n{outline}\n")
    };
    refused(&gripper("type = \"disc\"\nradius = \"60 mm\""), &["starts", "mm inside", "but at most 1 mm is allowed"]);
    parse(&gripper("type = \"disc\"\nradius = \"20 mm\""));
    let error =
        refused(&gripper("type = \"half_plane\"\nnormal = [0, 1]"), &["is a half plane", "write a closed outline"]);
    assert!(!error.contains("inf"), "{error}");
}

/// A joint that starts beyond a limit is refused: of both kinds, on both sides, driven or determined by others.
#[test]
fn starts_beyond_limits_are_refused() {
    let pin = |keys: &str| {
        format!(
            "kind = \"mechanism\"\nduration = \"10 ms\"\n[bodies.a]\nmass = \"10 g\"\ninertia = \"1000 g*mm^2\"\n[joints.j]\nbodies = \
             [\"ground\", \"a\"]\npoints = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\nstop = \"stop\"\n{keys}\n[laws.stop]\n\
             stiffness = 2e4\n"
        )
    };
    refused(
        &pin("start = \"0 rad\"\nupper = \"-1 rad\""),
        &["57.2958 deg beyond its upper limit", "is 0 deg", "at most -57.2958 deg"],
    );
    refused(
        &pin("start = \"3 rad\"\nlower = \"3.1 rad\""),
        &["5.7296 deg beyond its lower limit", "at least 177.6169 deg"],
    );
    refused(&pin("start = \"0.002 rad\"\nupper = \"0 rad\""), &["beyond its upper limit"]);
    parse(&pin("start = \"0.0005 rad\"\nupper = \"0 rad\""));
    parse(&pin("start = \"0 rad\"\nupper = \"0 rad\""));
    let slide = "type = \"prismatic\"\n";
    refused(&pin(&format!("{slide}start = \"12 mm\"\nupper = \"10 mm\"")), &["2 mm beyond its upper limit"]);
    refused(&pin(&format!("{slide}start = \"9.8 mm\"\nlower = \"10 mm\"")), &["0.2 mm beyond its lower limit"]);
    parse(&pin(&format!("{slide}start = \"10 mm\"\nlower = \"10 mm\"")));
    // An image is not reported beside its original.
    let mirrored = format!("{}[mirror]\nfrom = \"j\"\nto = \"k\"\n", pin("start = \"1 rad\"\nupper = \"0 rad\""));
    let mirrored = mirrored.replace("[bodies.a]", "[bodies.j]").replace("\"a\"", "\"j\"");
    let error = refused(&mirrored, &["the joint `j` starts 57.2958 deg beyond"]);
    assert_eq!(error.matches("beyond its").count(), 1, "{error}");
    // A joint whose coordinate follows from others.
    let four_bar = std::fs::read_to_string("scenes/mechanisms/four-bar.toml").expect("a scene");
    let limited = |limit: &str| {
        four_bar.replace(
            "[joints.rocker]",
            &format!("[laws.stop]\nstiffness = 1e4\n[joints.rocker]\nstop = \"stop\"\n{limit}"),
        )
    };
    let rocker = parse(&four_bar).mechanism.expect("a mechanism");
    let index = rocker.joints.iter().position(|joint| joint.name == "rocker").expect("the rocker");
    let start_rad = assemble(&rocker).expect("a start").joint(&rocker.joints[index]).0;
    refused(
        &limited(&format!("upper = \"{} rad\"", start_rad - 0.1)),
        &["the joint `rocker` starts 5.7296 deg beyond"],
    );
    parse(&limited(&format!("upper = \"{} rad\"", start_rad + 0.1)));
}

/// A hand on a slider, whose coupled jaws both have a start.
fn coupled_jaws(right: &str) -> String {
    let jaw = |name: &str, start: &str| {
        format!(
            "[bodies.{name}]\nmass = \"50 g\"\ninertia = \"2e-5 kg*m^2\"\n[joints.{name}]\ntype = \"prismatic\"\nbodies = [\"hand\", \
             \"{name}\"]\npoints = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\nstart = {start}\n"
        )
    };
    format!(
        "kind = \"mechanism\"\nduration = \"10 ms\"\n[bodies.hand]\nmass = \"1 kg\"\ninertia = \"1e-3 kg*m^2\"\n[joints.base]\ntype = \
         \"prismatic\"\nbodies = [\"ground\", \"hand\"]\npoints = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\nstart = \"0 mm\"\n\
         [couplings.c]\njoints = [\"left\", \"right\"]\nfactors = [1, 1]\n[actuators.left]\njoint = \"left\"\nforce = \"10 N\"\n{}{}",
        jaw("left", "\"-25 mm\""),
        jaw("right", right)
    )
}

/// Consistent starts are accepted; others differ in the digits of the message.
#[test]
fn starts_that_agree_are_accepted() {
    let agreeing = parse(&coupled_jaws("\"25 mm\""));
    let without = parse(&coupled_jaws("\"25 mm\"").replace("start = \"25 mm\"\n", ""));
    let ends = [&agreeing, &without].map(|scene| {
        [Model::Analytic, Model::Engine]
            .map(|model| trace::run(model, scene, &mut ()).expect("a run").last.joint_state(1).angle_rad)
    });
    for (found, expected) in ends[0].iter().zip(ends[1]) {
        assert!((found - expected).abs() < 1e-12, "{ends:?}");
    }
    refused(&coupled_jaws("\"26 mm\""), &["is 26 mm, but", "(25 mm)"]);
    refused(&coupled_jaws("\"25.00001 mm\""), &["is 25.00001 mm, but", "(25"]);
    refused(
        &coupled_jaws("\"25 mm\"\nstart_rate = \"1 m/s\""),
        &["has the rate 1000 mm/s", "(0 mm/s)", "write this rate"],
    );
}

/// Starts of all joints at the coordinates of the assembly are accepted, and one that differs is refused: 150 random
/// mechanisms.
#[test]
fn starts_of_all_joints_of_random_mechanisms_are_accepted() {
    let mut redundant = 0;
    for seed in 0..150 {
        let mechanism = random_mechanism(seed);
        let start = assemble(&mechanism).expect("a start");
        let mut all = mechanism.clone();
        for joint in &mut all.joints {
            let (value, rate) = start.joint(joint);
            (joint.start, joint.start_rate) = (Some(value), rate);
        }
        let again = assemble(&all).unwrap_or_else(|error| panic!("{seed}: {error}"));
        let difference = |a: &[Pose], b: &[Pose]| {
            a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        assert!(difference(&start.poses, &again.poses) < 1e-9, "{seed}: {}", difference(&start.poses, &again.poses));
        assert!(difference(&start.rates, &again.rates) < 1e-6, "{seed}: {}", difference(&start.rates, &again.rates));
        let Some(&joint) = again.implied.first() else { continue };
        redundant += 1;
        let shifted = |by: f64| -> Result<_, AssemblyError> {
            let mut other: Mechanism = all.clone();
            *other.joints[joint].start.as_mut().expect("a start") += by;
            assemble(&other)
        };
        let message = shifted(1e-7).expect_err("another start").to_string();
        let values: Vec<&str> =
            message.split(['(', ')', ' ', ',']).filter(|word| word.parse::<f64>().is_ok()).collect();
        assert!(values.len() >= 2 && values[0] != values[1], "{seed}: {message}");
    }
    assert!(redundant > 30, "{redundant}");
}

/// The wrong sign of a coupling folds a parallelogram: the coupling is named as a cause.
#[test]
fn a_coupling_that_folds_a_loop_is_named() {
    let text = r#"
kind = "mechanism"
[mirror]
from = "right"
to = "left"
[bodies.right_crank]
mass = "10 g"
inertia = "1000 g*mm^2"
guess = { at = ["9 mm", "0 mm"], angle = "-45 deg" }
[bodies.right_rocker]
mass = "10 g"
inertia = "1000 g*mm^2"
guess = { at = ["29 mm", "0 mm"], angle = "-45 deg" }
[bodies.right_coupler]
mass = "20 g"
inertia = "3000 g*mm^2"
guess = { at = ["37 mm", "-28 mm"] }
[joints.right_crank]
bodies = ["ground", "right_crank"]
points = [["9 mm", "0 mm"], ["0 mm", "0 mm"]]
start = "-45 deg"
[joints.right_rocker]
bodies = ["ground", "right_rocker"]
points = [["29 mm", "0 mm"], ["0 mm", "0 mm"]]
[joints.right_inner]
bodies = ["right_crank", "right_coupler"]
points = [["40 mm", "0 mm"], ["0 mm", "0 mm"]]
[joints.right_outer]
bodies = ["right_rocker", "right_coupler"]
points = [["40 mm", "0 mm"], ["20 mm", "0 mm"]]
[couplings.gears]
joints = ["right_crank", "left_crank"]
factors = [1, 1]
"#;
    refused(text, &["left_", "coupling `gears`", "factors"]);
    parse(&text.replace("factors = [1, 1]", "factors = [1, -1]"));
}

/// The only distances of the mechanism are rounding errors of a computed centre of mass: they are no length scale, against which
/// the guess would be wrong.
#[test]
fn rounding_errors_are_no_length_of_a_mechanism() {
    let scene = parse(
        "kind = \"mechanism\"\nduration = \"1 ms\"\n[bodies.jaw]\nmass = \"280 g\"\ninertia = \"2e4 g*mm^2\"\n\
         com = [\"1e-14 mm\", \"0 mm\"]\nguess = { at = [\"1.0397847671410872e1 mm\", \"0 mm\"] }\n[joints.rail]\n\
         type = \"prismatic\"\nbodies = [\"ground\", \"jaw\"]\npoints = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\n\
         start = \"1.0397847671410873e-2 m\"\n",
    );
    let start = assemble(scene.mechanism.as_ref().expect("a mechanism")).expect("a start");
    assert!((start.poses[0][0] - 1.0397847671410873e-2).abs() < 1e-15, "{:?}", start.poses);
}
