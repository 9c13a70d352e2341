//! `[parameters]`, expressions, and entries of lists as fields, in all kinds of scene.

use phalanx::scene::{self, Layer, Scene, parse_any, parse_layers, parse_setting, show_written};

use crate::support::cli::assert_contains;
use crate::{DESIGN, DRIVE, assert_round_trip, finger_with, parse};

/// Asserts that two texts are the same scene, bit for bit, except for their source.
#[track_caller]
fn assert_same(found: &str, expected: &str) -> Scene {
    let (mut found, expected) = (parse(found), parse(expected));
    let read = found.clone();
    found.source.clone_from(&expected.source);
    // `{:?}` of different `f64` values differs.
    assert_eq!(format!("{found:?}"), format!("{expected:?}"));
    read
}

/// The error of a text.
#[track_caller]
fn error(text: &str) -> String {
    parse_any(text, "test.toml").expect_err(text).to_string()
}

fn layers(text: &str, settings: &[&str]) -> Result<Scene, scene::SceneError> {
    let file = Layer { file: "own.toml".into(), text: text.into() };
    let settings: Vec<Layer> = settings.iter().map(|text| parse_setting("--set", text).expect(text)).collect();
    parse_layers(&[file], &settings)
}

/// The text with settings, as a scene named like the others.
#[track_caller]
fn with(text: &str, settings: &[&str]) -> Scene {
    let scene = layers(text, settings).unwrap_or_else(|error| panic!("{error}"));
    Scene { name: "test".into(), source: String::new(), ..scene }
}

#[track_caller]
fn assert_equal_with(text: &str, settings: &[&str], expected: &str) {
    let expected = Scene { source: String::new(), ..parse(expected) };
    assert_eq!(format!("{:?}", with(text, settings)), format!("{expected:?}"), "{settings:?}");
}

/// A linkage with lists of all forms.
const LINKAGE: &str = r#"kind = "mechanism"
duration = "10 ms"
gravity = ["0 m/s^2", "-9.81 m/s^2"]
[parameters]
crank = "40 mm"
spread = "20 mm"
ratio = 0.6
coupler = "= crank * ratio + 2 mm"
[mirror]
from = "right"
to = "left"
[bodies.right_crank]
density = "1070 kg/m^3"
depth = "= spread / 4"
guess = { at = ["10 mm", "0 mm"], angle = "= acos((spread - 5 mm) / (2 * crank))" }
[bodies.right_crank.outlines.bar]
type = "polygon"
vertices = [["0 mm", "= -2 mm"], ["= crank", "-2 mm"], ["= crank", "2 mm"], ["0 mm", "= 0.5 * 4 mm"]]
[bodies.ball]
mass = "5 g"
inertia = "= 0.4 * 5 g * (3 mm)^2"
start = { at = ["0 mm", "= coupler + 100 mm"] }
[bodies.ball.outlines.rim]
type = "disc"
radius = "3 mm"
[joints.right_pin]
bodies = ["ground", "right_crank"]
points = [["= spread / 2", "0 mm"], ["0 mm", "0 mm"]]
start = "= acos((spread - 5 mm) / (2 * crank))"
start_rate = "= 3 m/s / crank * 1 rad"
[actuators.right_motor]
joint = "right_pin"
times = ["0 ms", "= 2 * 2.5 ms"]
targets = ["0 deg", "= acos((spread - 5 mm) / (2 * crank))"]
kp = "= 10 N*mm / 2 deg"
limit = "0.2 N*m"
[laws.pad]
stiffness = 1e7
friction = { mu_static = "= ratio / 2", law = "regularised" }
[laws.soft]
stiffness = "= 1e4 * 10"
[[contacts]]
between = ["ball", "right_crank.bar"]
law = "pad"
"#;

/// The same scene without expressions.
fn linkage_in_numbers() -> String {
    // Numbers in SI units have the same bits as the expressions.
    let angle = format!("{:?} rad", phalanx::numeric::elementary::acos((0.02 - 0.005) / (2.0 * 0.04)));
    let coupler = 0.04 * 0.6 + 0.002;
    LINKAGE
        .split("[parameters]")
        .map(|part| part.split_once("[mirror]").map_or(part.to_string(), |(_, rest)| format!("[mirror]{rest}")))
        .collect::<String>()
        .replace("= acos((spread - 5 mm) / (2 * crank))", &angle)
        .replace("= spread / 4", &format!("{:?} m", 0.02 / 4.0))
        .replace("= -2 mm", "-2 mm")
        .replace("= crank", "40 mm")
        .replace("= 0.5 * 4 mm", "2 mm")
        .replace("= 0.4 * 5 g * (3 mm)^2", &format!("{:?} kg*m^2", 0.4 * 0.005 * (0.003 * 0.003)))
        .replace("= coupler + 100 mm", &format!("{:?} m", coupler + 0.1))
        .replace("= spread / 2", "10 mm")
        .replace("= 3 m/s / crank * 1 rad", &format!("{:?} rad/s", 3.0 / 0.04))
        .replace("= 2 * 2.5 ms", "5 ms")
        .replace("= 10 N*mm / 2 deg", &format!("{:?} N*m/rad", 0.01 / 2f64.to_radians()))
        .replace("\"= ratio / 2\"", "0.3")
        .replace("\"= 1e4 * 10\"", "1e5")
}

#[test]
fn expressions_stand_for_values_in_all_kinds_of_scene() {
    // A finger: quantities, angles and plain numbers.
    let finger = "[parameters]\nbase = \"15.5 mm\"\nfraction = 1\nbend = \"= 2 * 60 deg\"\n[design]\nbase = \"= base\"\nl21_fraction = \"= fraction\"\n\
                  phi22 = \"= bend\"\narm_ratio = \"= fraction / 2\"\n";
    let in_numbers = DESIGN.replace("120 deg", &format!("{:?} rad", 2.0 * 60f64.to_radians()));
    assert_round_trip(&assert_same(&format!("{finger}{DRIVE}"), &format!("{in_numbers}{DRIVE}")));
    // A gripper: fingers that differ, lists, and whole numbers.
    let gripper = |head: &str, right: &str, gravity: &str, steps: &str| {
        let integrator = format!("[integrator]\nmax_steps = {steps}\n");
        let motor = format!(
            "[right.motor]\nprofile = \"table\"\ntimes = [\"0 ms\", \"4 ms\"]\ntorques = [\"0 N*m\", \"{right}\"]\n"
        );
        format!("kind = \"gripper\"\ngravity = [\"0 m/s^2\", \"{gravity}\"]\n{head}{DESIGN}{DRIVE}{motor}{integrator}")
    };
    let torque = "[parameters]\ntorque = \"0.48 N*m\"\ng0 = \"9.81 m/s^2\"\n";
    assert_round_trip(&assert_same(
        &gripper(torque, "= 1.5 * torque", "= -g0", "\"= 10 * 1e3\""),
        &gripper("", &format!("{:?} N*m", 1.5 * 0.48), "-9.81 m/s^2", "10000"),
    ));
    // Discs.
    let discs = |head: &str, radius: &str, speed: &str| {
        format!(
            "kind = \"bodies\"\n{head}[half_plane]\n[discs.ball]\nradius = \"{radius}\"\ncentre = [\"0 mm\", \"{radius}\"]\nmass = \"1 g\"\n\
             velocity = [\"0 m/s\", \"{speed}\"]\n[contact]\nstiffness_si = 1e6\n"
        )
    };
    let size = "[parameters]\nsize = \"10 mm\"\nfall = \"1.25 mm\"\n";
    let speed = format!("-{:?} m/s", (2.0 * 9.81f64 * 0.00125).sqrt());
    assert_round_trip(&assert_same(
        &discs(size, "= size", "= -sqrt(2 * 9.81 m/s^2 * fall)"),
        &discs("", "10 mm", &speed),
    ));
    // A mechanism: nested lists, mirrored parts, laws; the images have the same values.
    let linkage = assert_same(LINKAGE, &linkage_in_numbers());
    assert_round_trip(&linkage);
    let mechanism = linkage.mechanism.expect("a mechanism");
    let points = |name: &str| mechanism.joints.iter().find(|joint| joint.name == name).expect(name).points_m;
    assert!(points("right_pin").contains(&[0.01, 0.0]) && points("left_pin").contains(&[-0.01, 0.0]));
}

#[test]
fn an_object_with_an_outline_and_a_template_have_expressions() {
    let gripper = format!(
        "kind = \"gripper\"\n[parameters]\nwidth = \"30 mm\"\n{DESIGN}{DRIVE}[object]\nradius = \"19.3 mm\"\nheight = \"20 mm\"\nangle = \"3 deg\"\n\
         [object.outline]\ntype = \"box\"\nsize = [\"= width\", \"= width - 2 mm\"]\nrounding = \"3 mm\"\n"
    );
    assert_round_trip(&assert_same(&gripper, &gripper.replace("= width - 2 mm", "28 mm").replace("= width", "30 mm")));
    let text = format!("[parameters]\nratio = 0.5\n{DESIGN}{DRIVE}[initial]\noffset = \"= 50 deg * ratio\"\n");
    let template = scene::parse_template(&text, "test.toml").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(template.opening_rad, 25f64.to_radians());
}

#[test]
fn parameters_are_inherited_and_set() {
    let scene = |files: &[&str], settings: &[&str]| {
        let files: Vec<Layer> =
            files.iter().map(|text| Layer { file: "test.toml".into(), text: text.to_string() }).collect();
        let settings: Vec<Layer> = settings.iter().map(|text| parse_setting("--set", text).expect(text)).collect();
        parse_layers(&files, &settings)
    };
    let crank_m = |files: &[&str], settings: &[&str]| {
        let scene = scene(files, settings).unwrap_or_else(|error| panic!("{error}"));
        let mechanism = scene.mechanism.as_ref().expect("a mechanism");
        let crank = mechanism.bodies.iter().find(|body| body.name == "right_crank").expect("a crank");
        let depth_and_length = crank.mass_kg / (1070.0 * 0.004);
        let ball = mechanism.bodies.iter().find(|body| body.name == "ball").expect("a ball");
        [depth_and_length, ball.pose[1]]
    };
    let near = |found: [f64; 2], expected: [f64; 2]| {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{found:?} {expected:?}");
    };
    near(crank_m(&[LINKAGE], &[]), [0.04 * 0.005, 0.126]);
    // An extending scene changes one parameter, adds another one, and uses both.
    let extending = "extends = \"a.toml\"\n[parameters]\nspread = \"= crank / 4\"\ngap = \"1 mm\"\n[bodies.ball.start]\nat = [\"0 mm\", \"= 0.2 m + gap\"]\n";
    near(crank_m(&[LINKAGE, extending], &[]), [0.04 * 0.0025, 0.201]);
    // Settings replace values and expressions, by values or by expressions.
    near(
        crank_m(&[LINKAGE, extending], &["parameters.crank=48 mm", "parameters.gap= = 3 * 1 mm"]),
        [0.048 * 0.003, 0.203],
    );
    near(crank_m(&[LINKAGE], &["parameters.coupler=30 mm"]), [0.04 * 0.005, 0.13]);
    near(crank_m(&[LINKAGE], &["parameters.coupler== crank*0.5"]), [0.04 * 0.005, 0.12]);
    near(crank_m(&[LINKAGE], &["bodies.ball.start.at[1]== coupler * 5"]), [0.04 * 0.005, 0.13]);
    // Only files define parameters.
    for (setting, words) in [
        (
            "parameters.crnk=42 mm",
            ["unknown parameter `crnk`", "did you mean `crank`?", "coupler, crank, ratio, spread", "--set:1:12"],
        ),
        (
            "parameters.crank=42 mn",
            ["`parameters.crank`: `42 mn` is not a number with a known unit", "--set:1:20", "a value", "= 2 * crank"],
        ),
        (
            "parameters.crank=42 s",
            ["`42 s`", "coupler", "`crank * ratio` is a time, but `2 mm` is a length", "own.toml"],
        ),
        (
            "parameters.crank== spread +",
            ["a value is missing before the end", "--set:1:31", "`parameters.crank`", "expected a value"],
        ),
    ] {
        let error = layers(LINKAGE, &[setting]).expect_err(setting).to_string();
        let words = if setting.ends_with("42 s") { &words[1..] } else { &words[..] };
        assert_contains(&error, words);
    }
    let error = layers(&format!("{DESIGN}{DRIVE}"), &["parameters.x=1"]).expect_err("no parameters").to_string();
    assert_contains(&error, &["unknown parameter `x`", "this scene has no parameters"]);
    // Names of parameters do not replace each other like keys of the same name.
    let finger = format!(
        "{DESIGN}{DRIVE}[parameters]\ntorque = 1\ntimes = 2\ntype = 3\n[contact.friction]\nmu_static = \"= times / 10 + type\"\n"
    );
    let mu = with(&finger, &["parameters.type=4", "parameters.torque=5"])
        .finger()
        .contact
        .proximal
        .friction
        .expect("friction")
        .mu_static;
    assert_eq!(mu, 2.0 / 10.0 + 4.0);
}

#[test]
fn entries_of_lists_are_fields() {
    let replaced = |from: &str, to: &str| {
        assert!(LINKAGE.contains(from), "{from}");
        LINKAGE.replacen(from, to, 1)
    };
    for (setting, from, to) in [
        ("joints.right_pin.points[0][0]=11 mm", "points = [[\"= spread / 2\"", "points = [[\"11 mm\""),
        (
            "joints.right_pin.points[1]=[\"1 mm\", \"2 mm\"]",
            "[\"0 mm\", \"0 mm\"]]\nstart",
            "[\"1 mm\", \"2 mm\"]]\nstart",
        ),
        (
            "actuators.right_motor.targets[1]=20 deg",
            "\"0 deg\", \"= acos((spread - 5 mm) / (2 * crank))\"",
            "\"0 deg\", \"20 deg\"",
        ),
        ("actuators.right_motor.times[1]== 7 ms", "= 2 * 2.5 ms", "7 ms"),
        (
            "bodies.right_crank.outlines.bar.vertices[2][1]=2.5 mm",
            "[\"= crank\", \"2 mm\"]",
            "[\"= crank\", \"2.5 mm\"]",
        ),
        ("gravity[1]=-1 g", "-9.81 m/s^2", "-9.81 m/s^2"),
        ("gravity[0]=1 m/s^2", "\"0 m/s^2\"", "\"1 m/s^2\""),
        ("bodies.right_crank.guess.at[0]=9 mm", "[\"10 mm\", \"0 mm\"]", "[\"9 mm\", \"0 mm\"]"),
        ("contacts[0].law=soft", "law = \"pad\"", "law = \"soft\""),
    ] {
        assert_equal_with(LINKAGE, &[setting], &replaced(from, to));
    }
    // An entry and an entry of it; a later setting of the list replaces those of its entries.
    let pin = "joints.right_pin.points";
    let both = [format!("{pin}[0]=[\"1 mm\", \"2 mm\"]"), format!("{pin}[0][1]=3 mm")];
    let both: Vec<&str> = both.iter().map(String::as_str).collect();
    let first = "points = [[\"= spread / 2\", \"0 mm\"]";
    assert_equal_with(LINKAGE, &both, &replaced(first, "points = [[\"1 mm\", \"3 mm\"]"));
    let reversed: Vec<&str> = both.iter().rev().copied().collect();
    assert_equal_with(LINKAGE, &reversed, &replaced(first, "points = [[\"1 mm\", \"2 mm\"]"));
    // In a file, an entry is a quoted key; an extending scene sets it, too.
    let in_file = replaced("start_rate", "\"points[0][0]\" = \"12 mm\"\nstart_rate");
    assert_same(&in_file, &replaced("[[\"= spread / 2\"", "[[\"12 mm\""));
    // Entries of lists of tables.
    let tendon = "kind = \"mechanism\"\n[bodies.link]\nmass = \"10 g\"\ninertia = \"1000 g*mm^2\"\n[joints.pin]\nbodies = [\"ground\", \"link\"]\n\
                  points = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\nstart = \"0 deg\"\n[tendons.t]\npath = [{ eyelet = \"ground\", at = [\"0 mm\", \"50 mm\"] }, \
                  { eyelet = \"link\", at = [\"20 mm\", \"0 mm\"] }]\nspools = [{ joint = \"pin\", radius = \"4 mm\" }]\n\
                  [actuators.pull]\ntendon = \"t\"\ntension = \"1 N\"\n";
    assert_equal_with(tendon, &["tendons.t.spools[0].radius=5 mm"], &tendon.replace("\"4 mm\"", "\"5 mm\""));
    assert_equal_with(tendon, &["tendons.t.path[1].at[0]=21 mm"], &tendon.replace("\"20 mm\"", "\"21 mm\""));
    for (text, setting, words) in [
        (
            LINKAGE,
            "joints.right_pin.points[2]=1",
            &[
                "`joints.right_pin.points` has 2 entries",
                "numbered from 0, so there is no `joints.right_pin.points[2]`",
                "--set:1:18",
            ][..],
        ),
        (
            LINKAGE,
            "joints.right_pin.points[0][5]=1 mm",
            &["`joints.right_pin.points[0]` has 2 entries", "no such entry"],
        ),
        (
            LINKAGE,
            "actuators.right_motor.torques[0]=1 N*m",
            &["`actuators.right_motor.torques` is not given in this scene, so it has no entries"],
        ),
        (LINKAGE, "actuators.right_motor.limit[0]=1 N*m", &["`actuators.right_motor.limit` is not a list"]),
        (LINKAGE, "contacts[1].law=soft", &["`contacts` has 1 entry, `contacts[0]`"]),
        (LINKAGE, "contacts[0].lw=soft", &["unknown key `lw` in [contacts]", "did you mean `law`?"]),
        (LINKAGE, "joints.right_pin.pionts[0]=1 mm", &["unknown key `pionts[0]` in [joints.right_pin]"]),
        (LINKAGE, "joints.right_pin.points[0][1]=1 s", &["1 s is a time; expected a length", "--set:1:35"]),
        (tendon, "tendons.t.spools[3].radius=5 mm", &["`tendons.t.spools` has 1 entry"]),
        (tendon, "tendons.t.spools[0].radius=5 s", &["5 s is a time", "--set:1:32"]),
    ] {
        assert_contains(&layers(text, &[setting]).expect_err(setting).to_string(), words);
    }
}

#[test]
fn shown_scenes_keep_expressions_and_print_their_values() {
    let shown = show_written(&parse(LINKAGE));
    for line in [
        "[parameters]",
        "coupler = \"= crank * ratio + 2 mm\"  # 26 mm",
        "crank = \"40 mm\"",
        "ratio = 0.6",
        "points = [[\"= spread / 2\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]  # [[10 mm, 0 mm], [0 mm, 0 mm]]",
        "start = \"= acos((spread - 5 mm) / (2 * crank))\"  # 79.1931 deg",
        "mu_static = \"= ratio / 2\"  # 0.3",
        "stiffness = \"= 1e4 * 10\"  # 1e5",
        "inertia = \"= 0.4 * 5 g * (3 mm)^2\"  # 18 g*mm^2",
    ] {
        assert!(shown.lines().any(|shown| shown == line), "{line}\n{shown}");
    }
    // The shown scene is the same one, and shown again the same.
    assert_same(&shown, LINKAGE);
    assert_eq!(
        show_written(&parse(&shown)).lines().skip(1).collect::<Vec<_>>(),
        shown.lines().skip(1).collect::<Vec<_>>()
    );
    // A description that begins with an equals sign is text, and names in lists do not break the comment.
    let text = format!("description = \"= 2\\u0007 +\"\n[parameters]\nx = 1\n{DESIGN}{DRIVE}");
    let scene = parse(&text);
    assert_eq!(scene.description, "= 2\u{7} +");
    assert_same(&show_written(&scene), &text);
    // An entry of a pair with a default is shown with the other one.
    let text = format!("{DESIGN}{DRIVE}").replacen("[design]", "\"gravity[0]\" = \"1 m/s^2\"\n[design]", 1);
    let shown = show_written(&parse(&text));
    assert_contains(&shown, &["gravity = [\"0 m/s^2\", \"9.81 m/s^2\"]\n\"gravity[0]\" = \"1 m/s^2\"\n"]);
    assert_same(&shown, &text);
    // With settings of entries.
    let changed = with(LINKAGE, &["joints.right_pin.points[0][0]== spread / 4", "parameters.spread=24 mm"]);
    assert!(changed.mechanism.is_some());
}

#[test]
fn errors_of_parameters_are_reported_once_and_together() {
    let text = format!(
        "{DESIGN}{DRIVE}[parameters]\na = \"= b + 1\"\nb = \"= c\"\nc = \"= a\"\nd = \"= a + e\"\ne = \"= f\"\nf = \"= f\"\nbad = \"5 mn\"\nworse = [1]\n\
         sin = 1\npi = 3\n\"a-b\" = 1\nfine = 2\n[contact.friction]\nmu_static = \"= bad + a\"\nmu_dynamic = \"= fine - 3\"\n"
    );
    let error = error(&text);
    assert_contains(
        &error,
        &[
            "the parameters use each other in a circle: a → b → c → a",
            "the parameters use each other in a circle: f → f",
            "`parameters.bad`: `5 mn` is not a number with a known unit",
            "`parameters.worse` is a list, but must be a single value",
            "`sin` cannot be the name of a parameter",
            "`pi` cannot be the name of a parameter",
            "`a-b` cannot be the name of a parameter",
            "`contact.friction.mu_dynamic` is = fine - 3 = -1, but must be at least 0",
            "test.toml: 8 problems",
        ],
    );
    let circle = "a = \"= b\"\nb = \"= c\"\nc = \"= b\"\n";
    let text = format!("{DESIGN}{DRIVE}[parameters]\n{circle}");
    assert_contains(&self::error(&text), &["in a circle: b → c → b", ":13:5"]);
    // A long chain in the order of names needs no recursion.
    let chain: String = (0..999).map(|i| format!("p{i:03} = \"= p{:03} + 1\"\n", i + 1)).collect();
    let scene =
        finger_with(&format!("[parameters]\n{chain}p999 = 1\n[contact.friction]\nmu_static = \"= p000 / 1000\"\n"));
    assert_eq!(scene.finger().contact.proximal.friction.expect("friction").mu_static, 1.0);
    let many: String = (0..1001).map(|i| format!("p{i} = 1\n")).collect();
    assert_contains(&self::error(&format!("{DESIGN}{DRIVE}[parameters]\n{many}")), &["more than 1000 parameters"]);
}

#[test]
fn results_of_expressions_are_checked_like_values() {
    for (lines, words) in [
        (
            "half_width = \"= 2\"",
            &["`half_width`: `= 2` is a number; expected a length", "multiply it by `1 m`", "test.toml:1:14"][..],
        ),
        ("half_width = \"= 2 ms\"", &["`= 2 ms` is a time; expected a length"]),
        ("half_width = \"= 1 mm * 1 mm\"", &["is a quantity in m^2; expected a length"]),
        ("half_width = \"= 1 mm - 2 mm\"", &["`half_width` is = 1 mm - 2 mm = -1 mm, but must be above 0"]),
        ("half_width = \"= 1e6 m\"", &["`half_width`: `= 1e6 m = 1e6 m` is too large: a length may be 1000 m at most"]),
        (
            "half_width = \"= x\"",
            &["`half_width`: unknown parameter `x`", "this scene has no parameters", "test.toml:1:17"],
        ),
        (
            "half_width = \"= y\"\nparameters.x = 1",
            &["`half_width`: unknown parameter `y`", "parameters of this scene: x"],
        ),
        ("half_width = '= (1 mm'", &["`half_width`: a parenthesis is not closed", "test.toml:1:17"]),
        ("half_width = \"\\u003d (1 mm\"", &["a parenthesis is not closed", "test.toml:1:14"]),
        (
            "gravity = [\"0 m/s^2\", \"= 1 g\"]",
            &["`gravity`: `= 1 g` is a mass; expected an acceleration", "test.toml:1:23"],
        ),
        ("palm = \"= 1\"", &["`palm` is a string, but must be true or false"]),
        ("integrator.max_steps = \"= 2.5\"", &["`integrator.max_steps`: `= 2.5` is 2.5, but must be a whole number"]),
        ("integrator.max_steps = \"= 1 mm\"", &["is a length; expected a number"]),
        ("contact.friction.mu_static = \"= 30 deg\"", &["is an angle; expected a number", "`1 rad`"]),
        ("parameters = 3", &["`parameters` is a single value, but must be a table"]),
        ("parameters.a = true", &["`parameters.a` is a boolean, but must be a single value"]),
        ("parameters.a = inf", &["`parameters.a` is not a finite number"]),
        ("parameters.a = { b = 1 }", &["`parameters.a` is a table, but must be a single value"]),
        ("parameters.a = \"1e6 m\"", &["`parameters.a`: `1e6 m` is too large"]),
    ] {
        let error = error(&format!("{lines}\n{DESIGN}{DRIVE}"));
        assert_contains(&error, words);
        assert!(error.contains("= help: "), "{error}");
    }
    // Dimensions that depend on other keys.
    let joint = |stiffness: &str| {
        LINKAGE.to_string() + &format!("[springs.coil]\njoint = \"right_pin\"\nstiffness = \"{stiffness}\"\n")
    };
    parse(&joint("= 2 N*m/rad"));
    parse(&joint("= 1 N*m / 20 deg"));
    assert_contains(&error(&joint("= 2 N/m * 1")), &["springs.coil.stiffness"]);
    assert_contains(&error(&joint("= 2 N*m")), &["is a torque; expected a torsional stiffness or a stiffness"]);
}

/// Unused parameters and those without a named dimension are no errors, also in scenes without other expressions.
#[test]
fn any_parameter_may_be_defined() {
    let scene = finger_with("[parameters]\narea = \"= 2 mm * 3 mm\"\nunused = \"4 N\"\nroot = \"= sqrt(area)\"\n");
    let shown = show_written(&scene);
    for line in ["area = \"= 2 mm * 3 mm\"  # 6e-6 m^2", "root = \"= sqrt(area)\"  # 2.44949 mm", "unused = \"4 N\""] {
        assert!(shown.lines().any(|shown| shown == line), "{line}\n{shown}");
    }
}
