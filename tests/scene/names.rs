//! Names of scenes: one check for all of them, images of [mirror] included, and different names for all columns.

use std::collections::HashSet;

use phalanx::scene;
use phalanx::trace::Schema;

use crate::parse;
use crate::support::random::Random;

/// A slider with a mirror.
fn slider(from: &str, to: &str) -> String {
    format!(
        "kind = \"mechanism\"\nduration = \"5 ms\"\n[mirror]\nfrom = {from}\nto = {to}\n[bodies.right_jaw]\nmass = \"80 g\"\ninertia \
         = \"20000 g*mm^2\"\nguess = {{ at = [\"40 mm\", \"20 mm\"] }}\n[joints.right]\ntype = \"prismatic\"\nbodies = [\"ground\", \
         \"right_jaw\"]\npoints = [[\"0 mm\", \"20 mm\"], [\"0 mm\", \"0 mm\"]]\nstart = \"40 mm\"\n"
    )
}

/// `to` is the beginning of names, and `from` must be the beginning of one.
#[test]
fn names_of_mirror_images_are_checked() {
    parse(&slider("\"right\"", "\"left\""));
    parse(&slider("\"right\"", "\"l2_x\""));
    for to in [
        "a,b",
        "\\\"><evil a=\\\"",
        "a b",
        "a.b",
        "a/b",
        "2nd",
        "_l",
        "l\\n",
        "\\u001b[31m",
        "\\u202el",
        "é",
        "a-b",
        "a[0]",
    ] {
        let error =
            scene::parse_any(&slider("\"right\"", &format!("\"{to}\"")), "test.toml").expect_err(to).to_string();
        assert!(
            error.contains("cannot be a name in `mirror.to`") && error.contains("use a letter followed by"),
            "{to}: {error}"
        );
        let is_raw = |c: char| c.is_control() && c != '\n' || c == '\u{202e}';
        assert!(!error.contains(is_raw) && !error.contains("<evil a=\"\n"), "{to}: {error:?}");
    }
    for (from, near) in [("rigth", "right"), ("rihgt", "right"), ("jaw", "right_jaw"), ("right_", "right"), ("", "")] {
        let error =
            scene::parse_any(&slider(&format!("\"{from}\""), "\"left\""), "test.toml").expect_err(from).to_string();
        let is_typo =
            error.contains("`mirror.from` matches no name") && error.contains(&format!("did you mean `{near}"));
        assert!(is_typo || from.is_empty() && error.contains("`mirror.from` is empty"), "{from}: {error}");
    }
    // The image of a body cannot be the ground.
    let error =
        scene::parse_any(&slider("\"right_jaw\"", "\"ground\""), "test.toml").expect_err("a ground").to_string();
    assert!(error.contains("`ground` cannot be the name of a body"), "{error}");
}

/// A mechanism of sliders, pins, tendons, actuators and bodies with names from short lists, so that many columns collide.
fn mechanism_of_names(random: &mut Random) -> String {
    let words =
        ["a", "a_angle", "a_rate", "a_point", "a_force", "q1", "q", "qd1", "a_upper", "time", "kinetic", "a_angle_rad"];
    let mut text = "kind = \"mechanism\"\nduration = \"1 ms\"\n[laws.stop]\nstiffness = 1e4\n".to_owned();
    let pick = |random: &mut Random| {
        let mut all: Vec<&str> = words.to_vec();
        (0..4).map(|_| all.remove((random.unit() * all.len() as f64) as usize)).collect::<Vec<_>>()
    };
    let [bodies, joints, others] = [(); 3].map(|()| pick(random));
    for (body, joint) in bodies.iter().zip(&joints) {
        let kind = random.choose(&["revolute", "prismatic"]);
        let limit = if kind == "revolute" { "1 rad" } else { "1 m" };
        text += &format!(
            "[bodies.{body}]\nmass = \"1 g\"\ninertia = \"1 g*mm^2\"\n[joints.{joint}]\ntype = \"{kind}\"\nbodies = [\"ground\", \
             \"{body}\"]\npoints = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\nupper = \"{limit}\"\nstop = \"stop\"\nstart = \"0 {}\"\n",
            &limit[2..]
        );
    }
    for (name, body) in others.iter().zip(&bodies) {
        text += &format!(
            "[tendons.{name}]\npath = [{{ eyelet = \"ground\", at = [\"0 mm\", \"50 mm\"] }}, {{ eyelet = \"{body}\" }}]\n\
             [actuators.{name}]\ntendon = \"{name}\"\ntension = \"1 N\"\n"
        );
    }
    text
}

/// Columns have different names, whatever the subjects are called, with and without the forces of joints.
#[test]
fn columns_have_different_names() {
    let mut random = Random(57);
    let mut renamed = 0;
    for _ in 0..200 {
        let text = mechanism_of_names(&mut random);
        let schema = Schema::from_scene(&parse(&text));
        let names =
            |schema: &Schema| -> Vec<String> { schema.channels().into_iter().map(|channel| channel.name).collect() };
        let all = names(&schema);
        let unique: HashSet<&String> = all.iter().collect();
        assert_eq!(unique.len(), all.len(), "{all:?}\n{text}");
        renamed += usize::from(all.iter().any(|name| name.starts_with("body_") || name.starts_with("tendon_")));
        let without = names(&Schema { has_joint_forces: false, ..schema });
        assert!(without.iter().all(|name| unique.contains(name)), "{without:?}");
    }
    assert!(renamed > 100, "{renamed}");
    // Earlier subjects keep their names.
    let text = "kind = \"mechanism\"\n[bodies.arm]\nmass = \"1 g\"\ninertia = \"1 g*mm^2\"\n[joints.arm_angle]\nbodies = [\"ground\", \
                \"arm\"]\npoints = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\nstart = \"0 deg\"\n";
    let columns: Vec<String> =
        Schema::from_scene(&parse(text)).channels().into_iter().map(|channel| channel.name).collect();
    for name in ["arm_angle_rad", "body_arm_angle_rad", "body_arm_x_m"] {
        assert!(columns.iter().any(|column| column == name), "{name}: {columns:?}");
    }
}
