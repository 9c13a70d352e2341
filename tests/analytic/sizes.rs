//! Mechanisms of any size: a stack of boxes, a hand with many tendons, and a long chain, against small versions of them
//! in the engine model and against closed forms.

use phalanx::scene::{self, Preset, Scene};
use phalanx::trace::{Model, Sample};

use crate::support::laws::CollectSink;
use crate::support::runs::{assert_below, run_model};

const G: f64 = 9.81;

fn scene(text: &str, preset: Preset) -> Scene {
    let mut scene = scene::parse_any(text, "sizes.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
    scene.apply_preset(preset);
    scene
}

fn run(model: Model, scene: &Scene) -> CollectSink {
    run_model(model, scene).1
}

fn last(run: &CollectSink) -> &Sample {
    run.samples.last().expect("a sample")
}

/// Largest error of the energy balance over a run, as a fraction of the largest energy.
fn balance_error(run: &CollectSink) -> f64 {
    let largest = |of: &dyn Fn(&Sample) -> f64| run.samples.iter().map(of).fold(0.0, f64::max);
    let energy = largest(&|sample| {
        let energy = sample.energy();
        let parts = [energy.kinetic_j, energy.gravity_j, energy.spring_j, energy.elastic_j, energy.motor_work_j];
        parts.into_iter().map(f64::abs).fold(0.0, f64::max)
    });
    largest(&|sample| sample.energy().balance_j.abs()) / energy
}

/// Largest differences of the bodies of both samples: positions, m, and angles, rad. Without as many bodies in `b`, the
/// others are not compared.
fn difference(a: &Sample, b: &Sample) -> [f64; 2] {
    let [mut position, mut angle] = [0.0f64; 2];
    for (a, b) in a.bodies().zip(b.bodies()) {
        for axis in 0..2 {
            position = position.max((a.centre_m[axis] - b.centre_m[axis]).abs());
        }
        angle = angle.max((a.angle_rad - b.angle_rad).abs());
    }
    [position, angle]
}

/// Boxes with bristle friction on the ground, one on the other, each 4 mm narrower than the one below. They start without
/// penetration, with rates of ±0.1 m/s along the ground.
fn stack(boxes: usize, preset: Preset) -> Scene {
    let mut text = format!(
        "kind = \"mechanism\"\nduration = \"50 ms\"\ngravity = [\"0 m/s^2\", \"-{G} m/s^2\"]\n\
         [ground.outlines.floor]\ntype = \"half_plane\"\nnormal = [0, 1]\n\
         [laws.wood]\ntype = \"hunt_crossley\"\nstiffness = 1e7\nexponent = 1.5\ndamping = \"3 s/m\"\n\
         friction = {{ mu_static = 0.5, mu_dynamic = 0.4, law = \"bristle\", bristle_damping = \"100 N*s/m\" }}\n\
         [[contacts]]\nbetween = [\"box0\", \"ground.floor\"]\nlaw = \"wood\"\n"
    );
    for index in 0..boxes {
        let (width, height, rate) = (60 - 4 * index, 10 + 20 * index, if index % 2 == 0 { 0.1 } else { -0.1 });
        text += &format!(
            "[bodies.box{index}]\nmass = \"50 g\"\ninertia = \"7500 g*mm^2\"\n\
             start = {{ at = [\"0 mm\", \"{height} mm\"], velocity = [\"{rate} m/s\", \"0 m/s\"] }}\n\
             [bodies.box{index}.outlines.skin]\ntype = \"box\"\nsize = [\"{width} mm\", \"20 mm\"]\nrounding = \"1 mm\"\n"
        );
        if index > 0 {
            text += &format!("[[contacts]]\nbetween = [\"box{}\", \"box{index}\"]\nlaw = \"wood\"\n", index - 1);
        }
    }
    scene(&text, preset)
}

#[test]
fn eight_boxes_stand_on_each_other() {
    let run = run(Model::Analytic, &stack(8, Preset::Engineering));
    assert_below(balance_error(&run), 1e-5, "energy balance");
    // The ground carries the weight, and stops the fall.
    let impulse_n_s: f64 = last(&run).contacts().take(2).map(|contact| contact.impulse_n_s).sum();
    let momentum_n_s: f64 = last(&run).bodies().map(|body| 0.05 * body.velocity_m_s[1]).sum();
    let weight_n_s = 8.0 * 0.05 * G * 0.05;
    assert_below((impulse_n_s - weight_n_s - momentum_n_s).abs(), 1e-6 * weight_n_s, "impulse of the ground");
    for (index, body) in last(&run).bodies().enumerate() {
        let height_m = 0.01 + 0.02 * index as f64;
        assert!(body.centre_m[0].abs() < 3e-3 && body.angle_rad.abs() < 1e-3, "box {index}: {body:?}");
        assert_below((body.centre_m[1] - height_m).abs(), 3e-4, format!("box {index}"));
        assert_below(body.velocity_m_s[0].abs(), 0.02, format!("box {index} slides"));
    }
}

#[test]
fn two_boxes_agree_with_the_engine() {
    let scene = stack(2, Preset::Reference);
    let [analytic, engine] = [Model::Analytic, Model::Engine].map(|model| run(model, &scene));
    let [position, angle] = difference(last(&analytic), last(&engine));
    assert_below(balance_error(&analytic), 1e-7, "energy balance");
    assert_below(position, 1e-6, "positions");
    assert_below(angle, 1e-5, "angles");
}

/// Fingers of two phalanges side by side; names are in the order of the fingers. Two motors wind up two tendons of each: one closes the finger, the other one
/// pulls at its back.
fn hand(fingers: i32, preset: Preset) -> Scene {
    let mut text = "kind = \"mechanism\"\nduration = \"60 ms\"\n\
                    [laws.stop]\nstiffness = 2e4\ndamping = \"0.2 s/rad\"\n\
                    [laws.pad]\nstiffness = 1e6\ndamping = \"3 s/m\"\n\
                    friction = { mu_static = 0.5, mu_dynamic = 0.5, v_static = \"0.02 m/s\", v_dynamic = \"0.05 m/s\" }\n"
        .to_string();
    for n in 0..fingers {
        let x = 200 * n;
        text += &format!(
            "[bodies.f{n}_proximal]\nmass = \"30 g\"\ninertia = \"11000 g*mm^2\"\ncom = [\"33 mm\", \"0 mm\"]\n\
             [bodies.f{n}_proximal.outlines.pad]\ntype = \"capsule\"\nfrom = [\"10 mm\", \"0 mm\"]\nto = [\"55 mm\", \"0 mm\"]\n\
             radius = \"9 mm\"\n\
             [bodies.f{n}_distal]\nmass = \"18 g\"\ninertia = \"3600 g*mm^2\"\ncom = [\"22 mm\", \"0 mm\"]\n\
             [bodies.f{n}_distal.outlines.pad]\ntype = \"capsule\"\nfrom = [\"6 mm\", \"0 mm\"]\nto = [\"40 mm\", \"0 mm\"]\n\
             radius = \"8 mm\"\n\
             [ground.outlines.f{n}_disc]\ntype = \"disc\"\ncenter = [\"{} mm\", \"55 mm\"]\nradius = \"22 mm\"\n\
             [joints.f{n}_base]\nbodies = [\"ground\", \"f{n}_proximal\"]\npoints = [[\"{x} mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\n\
             offset = \"70 deg\"\nstart = \"0 deg\"\nlower = \"-1 deg\"\nstop = \"stop\"\n\
             [joints.f{n}_middle]\nbodies = [\"f{n}_proximal\", \"f{n}_distal\"]\n\
             points = [[\"62.5 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\nstart = \"0 deg\"\nlower = \"-1 deg\"\nstop = \"stop\"\n\
             [springs.f{n}_base]\njoint = \"f{n}_base\"\nstiffness = \"0.05 N*m/rad\"\nrest = \"-0.3 rad\"\n\
             damping = \"2e-4 N*m*s/rad\"\n\
             [springs.f{n}_middle]\njoint = \"f{n}_middle\"\nstiffness = \"0.12 N*m/rad\"\nrest = \"-1 rad\"\n\
             damping = \"2e-4 N*m*s/rad\"\n\
             [[contacts]]\npoints = \"ground.f{n}_disc\"\nfaces = [\"f{n}_proximal.pad\", \"f{n}_distal.pad\"]\nlaw = \"pad\"\n",
            x - 30
        );
        for (name, side, turn, torque) in
            [("flexor", 1, "cw", 0.30 + 0.02 * f64::from(n)), ("extensor", -1, "ccw", 0.02)]
        {
            let (exit, lever) = (x + 45 * side, 6 * side);
            text += &format!(
                "[bodies.f{n}_{name}_winch]\nmass = \"20 g\"\ninertia = \"4000 g*mm^2\"\n\
                 [joints.f{n}_{name}]\nbodies = [\"ground\", \"f{n}_{name}_winch\"]\n\
                 points = [[\"{exit} mm\", \"-2 mm\"], [\"0 mm\", \"0 mm\"]]\nstart = \"0 deg\"\narmature = \"1e-5 kg*m^2\"\n\
                 [tendons.f{n}_{name}]\nstiffness = \"2e5 N/m\"\ndamping = \"20 N*s/m\"\npretension = \"1 N\"\n\
                 path = [{{ eyelet = \"ground\", at = [\"{exit} mm\", \"-8 mm\"] }}, \
                 {{ pulley = \"ground\", at = [\"{x} mm\", \"0 mm\"], radius = \"8 mm\", turn = \"{turn}\" }}, \
                 {{ eyelet = \"f{n}_proximal\", at = [\"45 mm\", \"{lever} mm\"] }}, \
                 {{ eyelet = \"f{n}_distal\", at = [\"16 mm\", \"{lever} mm\"] }}]\n\
                 spools = [{{ joint = \"f{n}_{name}\", radius = \"6 mm\" }}]\n\
                 [actuators.f{n}_{name}_motor]\njoint = \"f{n}_{name}\"\ntorque = \"{torque} N*m\"\nno_load_speed = \"40 rad/s\"\n"
            );
        }
    }
    scene(&text, preset)
}

/// The fingers do not touch each other, so that each moves as it would alone.
#[test]
fn six_fingers_with_twelve_tendons_move_as_each_alone() {
    let all = run(Model::Analytic, &hand(6, Preset::Engineering));
    assert_below(balance_error(&all), 1e-5, "energy balance");
    let (all, alone) = (last(&all), run(Model::Analytic, &hand(1, Preset::Reference)));
    assert_eq!((all.counts().tendons, all.counts().actuators, all.counts().bodies), (12, 12, 24));
    let [position, angle] = difference(all, last(&alone));
    assert!(position < 1e-6 && angle < 1e-5, "{position:e} m, {angle:e} rad");
    let closed_rad = all.joint_state(0).angle_rad;
    assert!(closed_rad > 0.1, "the finger hardly moves: {closed_rad}");
}

#[test]
fn a_finger_with_two_tendons_agrees_with_the_engine() {
    let scene = hand(1, Preset::Reference);
    let [analytic, engine] = [Model::Analytic, Model::Engine].map(|model| run(model, &scene));
    let [position, angle] = difference(last(&analytic), last(&engine));
    assert_below(balance_error(&analytic), 1e-7, "energy balance");
    assert_below(position, 1e-6, "positions");
    assert_below(angle, 2e-5, "angles");
}

/// Rods of 20 mm and 10 g, the first one on a pin, in line at an angle from the downward direction.
fn chain(links: usize, angle_deg: f64, preset: Preset) -> Scene {
    let mut text = format!(
        "kind = \"mechanism\"\nduration = \"100 ms\"\ngravity = [\"0 m/s^2\", \"-{G} m/s^2\"]\n\
         [log]\njoint_forces = true\n"
    );
    for n in 0..links {
        let (before, point, start) = match n {
            0 => ("ground".to_string(), 0, angle_deg - 90.0),
            _ => (format!("link{:02}", n - 1), 20, 0.0),
        };
        text += &format!(
            "[bodies.link{n:02}]\nmass = \"10 g\"\ninertia = \"333.33333333333333 g*mm^2\"\ncom = [\"10 mm\", \"0 mm\"]\n\
             [joints.pin{n:02}]\nbodies = [\"{before}\", \"link{n:02}\"]\npoints = [[\"{point} mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\n\
             start = \"{start} deg\"\n"
        );
    }
    scene(&text, preset)
}

/// Each pin of a hanging chain carries the links below it, and nothing moves.
#[test]
fn a_chain_of_sixty_links_hangs() {
    let run = run(Model::Analytic, &chain(60, 0.0, Preset::Engineering));
    let last = last(&run);
    for n in 0..60 {
        let (joint, weight_n) = (last.joint_state(n), 0.01 * G * (60 - n) as f64);
        assert_below(joint.rate_rad_s.abs(), 1e-6, format!("pin {n}"));
        let [x, y] = joint.force_n;
        assert_below((x.hypot(y) - weight_n).abs(), 1e-6 * weight_n, format!("pin {n}: {joint:?}"));
    }
}

#[test]
fn a_chain_of_sixty_links_swings_without_loss() {
    let run = run(Model::Analytic, &chain(60, 20.0, Preset::Engineering));
    assert_below(balance_error(&run), 1e-5, "energy balance");
    let kinetic_j = last(&run).energy().kinetic_j;
    assert!(kinetic_j > 1e-3, "the chain hardly moves: {kinetic_j} J");
}

#[test]
fn a_chain_of_three_links_agrees_with_the_engine() {
    let scene = chain(3, 60.0, Preset::Reference);
    let [analytic, engine] = [Model::Analytic, Model::Engine].map(|model| run(model, &scene));
    let [position, angle] = difference(last(&analytic), last(&engine));
    assert_below(balance_error(&analytic), 1e-9, "energy balance");
    assert_below(position, 1e-6, "positions");
    assert_below(angle, 2e-5, "angles");
}
