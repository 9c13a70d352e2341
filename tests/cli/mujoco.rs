//! Models for MuJoCo: an XML parser and, where it is installed, MuJoCo read every one of them.

use std::collections::{BTreeMap, HashSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use phalanx::mechanism::{JointCombination, Mechanism, Spring, SpringKind};
use phalanx::mjcf::{MujocoModel, mujoco_model};
use phalanx::scene::{self, Scene};
use phalanx::trace::{self, Model};
use roxmltree::{Document, Node};
use serde_json::json;

use crate::support::cli::directory;
use crate::support::random::Random;
use crate::support::scenes::scene_text;
use crate::support::scenes::trees::{random_mechanism, random_variant};

/// Elements of a model in each of MuJoCo's namespaces.
const NAMESPACES: [(&str, &[&str]); 8] = [
    ("body", &["body"]),
    ("joint", &["joint"]),
    ("geom", &["geom"]),
    ("site", &["site"]),
    ("tendon", &["fixed", "spatial"]),
    ("actuator", &["general", "motor"]),
    ("constraint", &["connect", "tendon"]),
    ("mesh", &["mesh"]),
];

/// Checks what MuJoCo requires: unique names, references to existing names, finite numbers, planes of fixed bodies, and a
/// key frame of the right size.
fn assert_well_formed(source: &str, xml: &str) {
    let document = Document::parse(xml).unwrap_or_else(|error| panic!("{source}: {error}\n{xml}"));
    let all = || document.descendants().filter(Node::is_element);
    let mut names: BTreeMap<&str, HashSet<&str>> = BTreeMap::new();
    for (space, tags) in NAMESPACES {
        for node in all().filter(|node| tags.contains(&node.tag_name().name())) {
            let Some(name) = node.attribute("name") else { continue };
            assert!(names.entry(space).or_default().insert(name), "{source}: two {space}s {name:?}");
        }
    }
    assert!(!names["body"].contains("world"), "{source}");
    for node in all() {
        for attribute in node.attributes() {
            let is_number = |text: &str| {
                ["inf", "nan", "-inf"].iter().all(|word| !text.to_lowercase().split(' ').any(|part| part == *word))
            };
            assert!(
                attribute.name() == "name" || attribute.name() == "model" || is_number(attribute.value()),
                "{source}: {attribute:?}"
            );
            let space = match (node.tag_name().name(), attribute.name()) {
                ("joint", "joint") | ("general" | "motor", "joint") => "joint",
                ("general" | "motor", "tendon") | ("tendon", "tendon1") => "tendon",
                ("connect", "body1" | "body2") => "body",
                ("pair", "geom1" | "geom2") => "geom",
                ("geom", "mesh") => "mesh",
                ("site", "site") => "site",
                _ => continue,
            };
            let exists = names.get(space).is_some_and(|names| names.contains(attribute.value()));
            assert!(exists, "{source}: no {space} {:?}", attribute.value());
        }
        if node.attribute("type") == Some("plane") {
            assert_eq!(node.parent().expect("a body").tag_name().name(), "worldbody", "{source}: a plane that moves");
        }
    }
    let key = all().find(|node| node.tag_name().name() == "key").expect("a key frame");
    let bodies = all().find(|node| node.tag_name().name() == "worldbody").expect("bodies");
    let joints = bodies.descendants().filter(|node| node.tag_name().name() == "joint").count();
    let actuators = names.get("actuator").map_or(0, HashSet::len);
    for (list, count) in [("qpos", joints), ("qvel", joints), ("ctrl", actuators)] {
        let found = key.attribute(list).map_or(0, |numbers| numbers.split(' ').count());
        assert_eq!(found, count, "{source}: {list}");
    }
}

/// The shipped scenes of all kinds but discs that do not rotate, which have models too.
fn shipped() -> Vec<(String, Scene)> {
    let directories = ["scenes", "scenes/gripper", "scenes/hard", "scenes/laws", "scenes/mechanisms", "scenes/real"];
    let files = directories
        .into_iter()
        .flat_map(|directory| fs::read_dir(directory).expect("scenes"))
        .map(|file| file.expect("a file").path());
    let mut files: Vec<PathBuf> =
        files.filter(|path| path.extension().is_some_and(|extension| extension == "toml")).collect();
    files.sort();
    let read = |path: &PathBuf| {
        let name = path.to_string_lossy().into_owned();
        (name, phalanx::scene::load_any(path).expect("a shipped scene"))
    };
    files.iter().map(read).collect()
}

fn export(name: &str, mechanism: &Mechanism, duration_s: f64) -> MujocoModel {
    mujoco_model(name, mechanism, duration_s).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Names that scenes cannot have, but mechanisms of the library: equal, reserved, with markup, control characters and
/// non-characters.
fn rename(mechanism: &mut Mechanism, random: &mut Random) {
    let names = [
        "jaws",
        "world",
        "ground",
        "a\"b",
        "<b>&'",
        "\u{1b}[31m",
        "\u{fffe}\u{202e}",
        "a b",
        "x.from",
        "jaws.spring",
        "ü\n",
        "",
    ];
    let mut pick = |name: &mut String| *name = random.choose(&names).to_owned();
    mechanism.bodies.iter_mut().for_each(|body| {
        pick(&mut body.name);
        body.outlines.iter_mut().for_each(|outline| pick(&mut outline.name));
    });
    mechanism.joints.iter_mut().for_each(|joint| pick(&mut joint.name));
    mechanism.couplings.iter_mut().for_each(|coupling| pick(&mut coupling.name));
    mechanism.springs.iter_mut().for_each(|spring| pick(&mut spring.name));
    mechanism.actuators.iter_mut().for_each(|actuator| pick(&mut actuator.name));
}

/// Random mechanisms: joints, dyads, couplings and components on several joints, prescribed motion, every second one with
/// names that scenes cannot have; and falling bodies with outlines of all kinds.
fn random_models(count: u64) -> Vec<(String, MujocoModel)> {
    let mut all = Vec::new();
    for seed in 0..count {
        let mut mechanism = random_variant(seed);
        let name = format!("variant{seed}");
        if seed % 2 == 1 {
            rename(&mut mechanism, &mut Random(seed));
        }
        match mujoco_model(&name, &mechanism, 0.02) {
            Ok(model) => all.push((name, model)),
            Err(error) => assert!(error.to_string().contains("prismatic joint"), "{name}: {error}"),
        }
    }
    for seed in 0..count {
        let scene = scene::parse_any(&scene_text("falling", seed), "falling.toml").expect("a scene");
        all.push((
            format!("falling{seed}"),
            export("falling", &scene.mechanism().expect("a mechanism"), scene.duration_s),
        ));
    }
    all
}

/// Parts that MuJoCo refused: equal names of a coupling, a spring and an actuator; a spring on a joint that closes a loop;
/// a half plane of a moving body.
const PARTS: &str = r#"
kind = "mechanism"
name = "\u001b[31mred<b>&\"'\u202e-->]]>\u000d\nX: y"
duration = "5 ms"
[bodies.right]
mass = "30 g"
inertia = "3000 g*mm^2"
outlines.face = { type = "half_plane", normal = [-1, 0] }
[bodies.left]
mass = "30 g"
inertia = "3000 g*mm^2"
[bodies.world]
mass = "50 g"
inertia = "5625 g*mm^2"
start = { at = ["-50 mm", "0 mm"] }
outlines.skin = { type = "disc", radius = "15 mm" }
[joints.right]
type = "prismatic"
bodies = ["ground", "right"]
points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
start = "10 mm"
friction = "1 N"
static_friction = "2 N"
friction_stiffness = "1e4 N/m"
[joints.left]
type = "prismatic"
bodies = ["ground", "left"]
points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
[couplings.jaws]
joints = ["right", "left"]
factors = [1, 1]
[springs.jaws]
type = "linear"
bodies = ["left", "right"]
points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
stiffness = "100 N/m"
rest = "30 mm"
[actuators.jaws]
joints = ["right", "left"]
factors = [0.5, -0.5]
force = "1 N"
limit = "0.5 N"
no_load_speed = "2 m/s"
[actuators.servo]
joints = ["right", "left"]
factors = [1, -1]
offset = "5 mm"
target = "10 mm"
kp = "200 N/m"
kd = "2 N*s/m"
rate = "500 Hz"
no_load_speed = "1 m/s"
[laws.pad]
stiffness = 1e6
[[contacts]]
between = ["world", "right"]
law = "pad"
rolling_arm = "0.1 mm"
"#;

/// A four-bar with everything on the joints that close its loop.
fn loaded_loop() -> Mechanism {
    let text = fs::read_to_string("scenes/mechanisms/four-bar.toml").expect("a scene");
    let scene = scene::parse_any(&text, "four-bar.toml").expect("a scene");
    let mut mechanism = scene.mechanism.expect("a mechanism");
    let joints: Vec<usize> = (0..mechanism.joints.len()).collect();
    for joint in &mut mechanism.joints {
        (joint.damping, joint.armature) = (1e-3, 1e-6);
    }
    for joint in joints {
        let on = JointCombination { terms: vec![(joint, 1.0)], offset: 0.1 };
        mechanism.springs.push(Spring {
            name: format!("spring{joint}"),
            kind: SpringKind::Torsional { on, preload: 0.01 },
            stiffness: 0.1,
            damping: 0.0,
            rest: -1.1,
        });
    }
    mechanism
}

#[test]
fn models_are_well_formed() {
    for (name, scene) in shipped() {
        let mechanism = scene.mechanism().expect("a mechanism");
        assert_well_formed(&name, &export(&scene.name, &mechanism, scene.duration_s).xml);
    }
    for (name, model) in random_models(40) {
        assert_well_formed(&name, &model.xml);
    }
    assert_well_formed("loop", &export("loop", &loaded_loop(), 1.0).xml);
}

/// Everything that a model lacks is named, and what it has is in the units of MuJoCo.
#[test]
fn losses_are_named() {
    let scene = scene::parse_any(PARTS, "parts.toml").expect("a scene");
    let model = export(&scene.name, &scene.mechanism().expect("a mechanism"), scene.duration_s);
    assert_well_formed("parts", &model.xml);
    let omissions = model.omissions.join("\n");
    for part in [
        "own soft constraints",
        "couplings, are soft constraints",
        "friction of the joint right is a constant 2 N, without its smaller value in motion (1 N), the rates over which it changes, \
         its bristle",
        "controller of the actuator servo is continuous: its rate of 500 Hz is missing",
        "no-load speed of the actuator servo is missing",
        "rolling resistance of world.skin and right.face is missing",
        "half plane right.face is a box",
    ] {
        assert!(omissions.contains(part), "{part}: {omissions}");
    }
    assert!(!omissions.contains("actuator jaws"), "{omissions}");
    // kp (target − (sum − offset)), and the torque τ − |τ| q̇/ω₀ within its limit.
    for part in ["biasprm=\"1 -200 -2\"", "biasprm=\"0 0 -0.25\" ctrlrange=\"-0.5 0.5\"", "type=\"box\" pos=\"1 0 0\""]
    {
        assert!(model.xml.contains(part), "{part}: {}", model.xml);
    }
    let omissions = export("loop", &loaded_loop(), 1.0).omissions.join("\n");
    assert!(omissions.contains("closes a loop: missing is its damping, armature"), "{omissions}");
    assert!(omissions.contains("is missing, because the joint"), "{omissions}");
    let mut discs = random_variant(0);
    discs.bodies[0].inertia_kg_m2 = f64::INFINITY;
    let error = mujoco_model("discs", &discs, 1.0).expect_err("a body that does not rotate");
    assert!(error.to_string().contains("does not rotate"), "{error}");
    discs.bodies[0].inertia_kg_m2 = 1e-16;
    assert!(mujoco_model("discs", &discs, 1.0).expect_err("a light body").to_string().contains("too light"));
}

/// A lossy spindle with a motor and feedback, a geared arm with an applied voltage, and a rotor that turns with two joints.
const DRIVES: &str = r#"
kind = "mechanism"
duration = "5 ms"
gravity = ["0 m/s^2", "0 m/s^2"]
[bodies.jaw]
mass = "80 g"
inertia = "20 kg*mm^2"
guess = { at = ["40 mm", "0 mm"] }
points.tip.at = ["-5 mm", "1 mm"]
[bodies.arm]
mass = "80 g"
inertia = "20 kg*mm^2"
[bodies.hand]
mass = "80 g"
inertia = "20 kg*mm^2"
[ground.points.pivot]
at = ["0 mm", "3 mm"]
[joints.slide]
type = "prismatic"
bodies = ["ground", "jaw"]
points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
start = "40 mm"
[joints.arm]
bodies = ["ground", "arm"]
points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
start = "0 deg"
armature = "1e-5 kg*m^2"
[joints.hand]
bodies = ["arm", "hand"]
points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
start = "0 deg"
[actuators.grip]
joint = "slide"
lead = "4 mm"
rotor = "1 g*cm^2"
efficiency = 0.7
target = "30 mm"
kp = "20 V/mm"
rate = "2 kHz"
motor = { torque_constant = "9 mN*m/A", resistance = "3 ohm", voltage = "12 V", inductance = "0.3 mH" }
feedback = { distance = ["ground.pivot", "jaw.tip"] }
[actuators.turn]
joint = "arm"
gear = 30
rotor = "1 g*cm^2"
motor = { torque_constant = "9 mN*m/A", resistance = "3 ohm", voltage = "12 V", current_limit = "2 A" }
[actuators.both]
joints = ["arm", "hand"]
factors = [1, 1]
gear = 10
rotor = "1 g*cm^2"
efficiency = 0.5
loss_stiffness = "100 N*m/rad"
torque = "5 N*mm"
[actuators.direct]
joint = "hand"
torque = "5 N*mm"
[limits.play]
joints = ["arm", "hand"]
factors = [1, -0.5]
upper = "60 deg"
stop = "stop"
[laws.stop]
stiffness = 1e6
"#;

#[test]
fn losses_of_drives_are_named() {
    let scene = scene::parse_any(DRIVES, "drives.toml").unwrap_or_else(|error| panic!("{error}"));
    let model = export(&scene.name, &scene.mechanism().expect("a mechanism"), scene.duration_s);
    assert_well_formed("drives", &model.xml);
    let of = |name: &str| -> Vec<&String> {
        model.omissions.iter().filter(|sentence| sentence.contains(&format!("the actuator {name}"))).collect()
    };
    for (name, parts) in [
        (
            "grip",
            &[
                "the loss of the gear",
                "the inductance",
                "the voltage limit",
                "which measures a distance, is missing: its control is a torque",
            ][..],
        ),
        ("turn", &[]),
        ("both", &["the rotor", "the loss of the gear"]),
        ("direct", &[]),
    ] {
        let found = of(name);
        assert_eq!(found.len(), parts.len(), "{name}: {found:?}");
        for part in parts {
            assert!(found.iter().any(|sentence| sentence.contains(part)), "{name}, {part}: {found:?}");
        }
    }
    // n² J beside the armature, the gear, k_t/R, −k_t k_e/R, and the limit k_t i of the torque; and the sum with its limit.
    for part in [
        "armature=\"9.999",
        "biasprm=\"0 0 -2.69",
        "gear=\"30\" forcerange=\"-0.018 0.018\"",
        "<fixed name=\"play\" range=\"-1000 1.047",
    ] {
        assert!(model.xml.contains(part), "{part}: {}", model.xml);
    }
}

/// A Python in which `import mujoco` works: `$MUJOCO_PYTHON`.
fn load_in_mujoco(directory: &Path) {
    let python = std::env::var("MUJOCO_PYTHON").expect("MUJOCO_PYTHON names a Python with the package mujoco");
    let output = Command::new(python).arg("tools/mujoco_load.py").arg(directory).output().expect("Python starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    println!("{text}");
    assert!(output.status.success(), "{text}");
}

/// End of a run of the analytic model of a mechanism: the positions of its joints and free bodies, by their names in the model.
fn end(mechanism: &Mechanism, duration_s: f64) -> Option<serde_json::Value> {
    let mut scene =
        scene::parse_any("kind = \"mechanism\"\n[bodies.a]\nmass = \"1 g\"\ninertia = \"1 g*mm^2\"\n", "any.toml")
            .ok()?;
    (scene.mechanism, scene.duration_s, scene.integrator.rtol) = (Some(mechanism.clone()), duration_s, 1e-10);
    let outcome = trace::run(Model::Analytic, &scene, &mut ()).ok()?;
    // Contacts and limits have other laws.
    if outcome.contacts.iter().any(|contact| contact.first_s.is_some()) {
        return None;
    }
    let joints = mechanism.joints.iter().enumerate();
    let angles = joints.map(|(index, joint)| (joint.name.clone(), json!(outcome.last.joint_state(index).angle_rad)));
    let bodies = mechanism.bodies.iter().enumerate().filter(|(_, body)| body.is_reported);
    let poses = bodies.flat_map(|(index, body)| {
        let state = outcome.last.body(index);
        let pose = [("x", state.centre_m[0]), ("y", state.centre_m[1]), ("angle", state.angle_rad)];
        pose.map(|(axis, value)| (format!("{}.{axis}", body.name), json!(value)))
    });
    Some(angles.chain(poses).collect::<serde_json::Map<_, _>>().into())
}

/// MuJoCo reads all models. Models that lack nothing that acts move as the analytic model does: to 1e-5 within 4 ms.
#[test]
#[ignore = "needs MuJoCo: MUJOCO_PYTHON names a Python in which `import mujoco` works"]
fn mujoco_reads_all_models() {
    let directory = directory("mujoco-models");
    let write = |name: &str, text: &str| fs::write(directory.join(name), text).expect("written");
    for (name, scene) in shipped() {
        let mechanism = scene.mechanism().expect("a mechanism");
        write(&format!("{}.xml", name.replace('/', "-")), &export(&scene.name, &mechanism, scene.duration_s).xml);
    }
    for (name, model) in random_models(200) {
        write(&format!("{name}.xml"), &model.xml);
    }
    let scene = scene::parse_any(PARTS, "parts.toml").expect("a scene");
    write("parts.xml", &export(&scene.name, &scene.mechanism().expect("a mechanism"), scene.duration_s).xml);
    write("loop.xml", &export("loop", &loaded_loop(), 1.0).xml);
    let (mut compared, duration_s) = (0, 4e-3);
    for seed in 0..300 {
        let mut mechanism = random_variant(seed);
        if seed % 3 == 0 {
            mechanism = random_mechanism(seed);
        }
        // What MuJoCo does not have is left out in both models.
        (mechanism.tendons, mechanism.rotors) = Default::default();
        mechanism.actuators.iter_mut().for_each(|actuator| actuator.brake = None);
        mechanism.joints.iter_mut().for_each(|joint| joint.friction = None);
        mechanism.contacts.clear();
        let is_fixed = mechanism.bodies.iter().all(|body| body.motion.is_none());
        let Ok(model) = mujoco_model("random", &mechanism, duration_s) else { continue };
        let lacks =
            |omission: &String| !["soft constraints", "changes over time"].iter().any(|part| omission.contains(part));
        let is_complete = is_fixed && !model.omissions.iter().any(lacks);
        let Some(end) = is_complete.then(|| end(&mechanism, duration_s)).flatten() else { continue };
        write(&format!("end{seed}.xml"), &model.xml);
        write(&format!("end{seed}.json"), &json!({ "time_s": duration_s, "end": end }).to_string());
        compared += 1;
    }
    assert!(compared > 40, "{compared}");
    load_in_mujoco(&directory);
}
