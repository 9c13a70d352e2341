//! Forces in joints: against the Newton–Euler equations of free bodies, and against the engine model, whose joint forces
//! are the multipliers of its constraints.

use crate::support::runs::Random;
use nalgebra::{SMatrix, SVector};
use phalanx::fivebar::dynamics::absolute_rates;
use phalanx::fivebar::joint_forces::{LinkLoads, LinkMotion, joint_forces};
use phalanx::fivebar::kinematics::{directions, passive_bias, passive_rates};
use phalanx::gripper::{Body, Finger};
use phalanx::scene;
use phalanx::trace::{Model, record};

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn turned([x, y]: [f64; 2], [c, s]: [f64; 2]) -> [f64; 2] {
    [c * x - s * y, s * x + c * y]
}

/// A body with its acceleration, its loads, and its joints: index, sign of the joint force, position.
struct FreeBody {
    body: Body,
    com_m: [f64; 2],
    acceleration: [f64; 2],
    angular_acceleration: f64,
    force_n: ([f64; 2], [f64; 2]),
    torque_n_m: f64,
    joints: Vec<(usize, f64, [f64; 2])>,
}

/// Solves the twelve equations of four free bodies for the forces in five joints and the torques on l11 and l21.
fn free_body_forces(bodies: &[FreeBody; 4], gravity: [f64; 2]) -> [[f64; 2]; 5] {
    let (mut a, mut b) = (SMatrix::<f64, 12, 12>::zeros(), SVector::<f64, 12>::zeros());
    for (index, free) in bodies.iter().enumerate() {
        let row = 3 * index;
        let (force, point) = free.force_n;
        let arm_to = |point: [f64; 2]| [point[0] - free.com_m[0], point[1] - free.com_m[1]];
        for axis in 0..2 {
            b[row + axis] = free.body.mass_kg * (free.acceleration[axis] - gravity[axis]) - force[axis];
        }
        b[row + 2] =
            free.body.inertia_kg_m2 * free.angular_acceleration - free.torque_n_m - cross(arm_to(point), force);
        for (joint, sign, point) in &free.joints {
            let arm = arm_to(*point);
            a[(row, 2 * joint)] += sign;
            a[(row + 1, 2 * joint + 1)] += sign;
            a[(row + 2, 2 * joint)] -= sign * arm[1];
            a[(row + 2, 2 * joint + 1)] += sign * arm[0];
        }
        if index < 2 {
            a[(row + 2, 10 + index)] = 1.0;
        }
    }
    let x = a.full_piv_lu().solve(&b).expect("a regular system");
    std::array::from_fn(|joint| [x[2 * joint], x[2 * joint + 1]])
}

#[test]
fn random_fingers_agree_with_free_bodies() {
    let mut random = Random(5);
    let (mut compared, mut worst) = (0, 0.0f64);
    while compared < 1000 {
        let finger: Finger = random.finger();
        let gamma = if random.within(0.0, 1.0) < 0.5 { 1.0 } else { -1.0 };
        let q = [random.within(-3.0, 3.0), random.within(-3.0, 3.0)];
        let pose = directions(&finger.lengths, gamma, q);
        let sine = cross(pose.e3, pose.e4);
        if sine.is_nan() || sine.abs() < 0.2 {
            continue;
        }
        compared += 1;
        let (v, qdd) = ([0, 1].map(|_| random.within(-400.0, 400.0)), [0, 1].map(|_| random.within(-1e5, 1e5)));
        let gravity = [0, 1].map(|_| random.within(-10.0, 10.0));
        let passive = passive_rates(&finger.lengths, &pose);
        let rates = absolute_rates(&passive, v);
        let bias = passive_bias(&finger.lengths, &pose, &passive);
        let second = |row: [f64; 2], curvature: [f64; 4]| {
            row[0] * qdd[0] + row[1] * qdd[1] + (0..4).map(|k| curvature[k] * rates[k] * rates[k]).sum::<f64>()
        };
        let accelerations = [qdd[0], qdd[1], second(passive.a3, bias.b3), second(passive.a4, bias.b4)];
        let lengths = &finger.lengths;
        let along = |direction: [f64; 2], length: f64| direction.map(|x| length * x);
        let (a12, a22) = (along(pose.e1, lengths.l11_m), along(pose.e2, lengths.l21_m));
        let coupler = along(pose.e3, lengths.l12_m);
        let a13 = [a12[0] + coupler[0], a12[1] + coupler[1]];
        // Acceleration of a point at `arm` from a point with acceleration `of`.
        let moved = |of: [f64; 2], arm: [f64; 2], k: usize| {
            [
                of[0] - accelerations[k] * arm[1] - rates[k] * rates[k] * arm[0],
                of[1] + accelerations[k] * arm[0] - rates[k] * rates[k] * arm[1],
            ]
        };
        let contacts = [(); 2].map(|()| [0, 1].map(|_| random.within(-50.0, 50.0)));
        let points = [(); 2].map(|()| [0, 1].map(|_| random.within(-0.05, 0.05)));
        let torques = [random.within(-1.0, 1.0), random.within(-1.0, 1.0)];
        let none = ([0.0; 2], [0.0; 2]);
        let free = |k: usize, body: Body, joint: [f64; 2], of: [f64; 2], direction, force_n, torque_n_m, joints| {
            let arm = turned(body.com_m, direction);
            FreeBody {
                body,
                com_m: [joint[0] + arm[0], joint[1] + arm[1]],
                acceleration: moved(of, arm, k),
                angular_acceleration: accelerations[k],
                force_n,
                torque_n_m,
                joints,
            }
        };
        let (ground, still) = ([0.0; 2], [0.0; 2]);
        let (at12, at22) = (moved(still, a12, 0), moved(still, a22, 1));
        let loaded = |k: usize| (contacts[k], points[k]);
        let links = &finger.bodies;
        let bodies = [
            free(0, links.l11, ground, still, pose.e1, none, 0.0, vec![(0, 1.0, ground), (2, -1.0, a12)]),
            free(1, links.l21, ground, still, pose.e2, loaded(0), 0.0, vec![(1, 1.0, ground), (3, -1.0, a22)]),
            free(2, links.l12, a12, at12, pose.e3, none, torques[0], vec![(2, 1.0, a12), (4, -1.0, a13)]),
            free(3, links.l22, a22, at22, pose.e4, loaded(1), torques[1], vec![(3, 1.0, a22), (4, 1.0, a13)]),
        ];
        let expected = free_body_forces(&bodies, gravity);
        let arm = [points[1][0] - a22[0], points[1][1] - a22[1]];
        let loads = LinkLoads {
            gravity_m_s2: gravity,
            proximal_n: contacts[0],
            distal_n: contacts[1],
            distal_moment_n_m: cross(arm, contacts[1]),
            torques_n_m: torques,
        };
        let found = joint_forces(&finger, &pose, &LinkMotion { rates, accelerations }, &loads);
        let scale = expected.iter().flatten().fold(0.0f64, |largest, force| largest.max(force.abs()));
        for (a, b) in found.iter().flatten().zip(expected.iter().flatten()) {
            worst = worst.max((a - b).abs() / scale);
        }
    }
    println!("largest relative difference: {worst:e}");
    assert!(worst < 1e-10, "{worst:e}");
}

/// The models compute joint forces in different ways. They differ most within impacts, whose forces change within
/// microseconds.
#[test]
fn both_models_agree_on_the_forces_in_joints() {
    for (file, median_bound, end_bound) in [
        ("scenes/experiment-95.toml", 1e-4, 1e-3),
        ("scenes/experiment-95-cad.toml", 1e-4, 1e-3),
        ("scenes/experiment-95-bristle.toml", 1e-4, 1e-3),
        ("scenes/torsional-spring.toml", 1e-4, 1e-3),
        ("scenes/long-fingers.toml", 1e-4, 1e-3),
        ("scenes/other-assembly.toml", 1e-4, 1e-3),
        ("scenes/gripper/design-95.toml", 5e-4, 1e-3),
        ("scenes/gripper/offset.toml", 5e-4, 1e-3),
        ("scenes/gripper/cycle-shaken.toml", 5e-4, 1e-3),
    ] {
        let scene = scene::load_any(file).unwrap_or_else(|error| panic!("{error}"));
        let [analytic, engine] = [Model::Analytic, Model::Engine]
            .map(|model| record(model, &scene).unwrap_or_else(|error| panic!("{file}: {error}")).1);
        let forces: Vec<&str> = analytic
            .channels()
            .iter()
            .map(|channel| channel.name.as_str())
            .filter(|name| name.contains("_force_"))
            .collect();
        assert_eq!(forces.len(), 10 * scene.hand.fingers.len());
        let value =
            |recording: &phalanx::trace::Recording, name: &str, index: usize| recording.column(name).unwrap()[index];
        // Instants that both models sample.
        let common: Vec<(usize, usize)> = analytic
            .time()
            .iter()
            .enumerate()
            .filter_map(|(index, time)| {
                let other = engine.time().partition_point(|other| other < time);
                (engine.time().get(other) == Some(time)).then_some((index, other))
            })
            .collect();
        assert!(common.len() > 100, "{file}: {}", common.len());
        let scale = forces
            .iter()
            .flat_map(|name| common.iter().map(|&(index, _)| value(&analytic, name, index).abs()))
            .fold(0.0, f64::max);
        let difference = |&(index, other): &(usize, usize)| {
            forces.iter().fold(0.0f64, |largest, name| {
                largest.max((value(&analytic, name, index) - value(&engine, name, other)).abs())
            }) / scale
        };
        let mut all: Vec<f64> = common.iter().map(difference).collect();
        // Largest forces over all samples, also within impacts.
        let peak = |recording: &phalanx::trace::Recording, name: &&str| {
            recording.column(name).unwrap().iter().fold(0.0f64, |largest, force| largest.max(force.abs()))
        };
        let peaks = forces.iter().map(|name| [&analytic, &engine].map(|recording| peak(recording, name)));
        let largest = peaks.clone().flatten().fold(0.0, f64::max);
        let peak_difference = peaks.map(|[a, b]| (a - b).abs() / largest).fold(0.0, f64::max);
        let at_end = all[all.len() - 1];
        all.sort_by(f64::total_cmp);
        let median = all[all.len() / 2];
        println!(
            "{file}: {} instants, scale {scale:.3} N, median {median:.1e}, end {at_end:.1e}, worst {:.1e}, peaks of {largest:.0} N {peak_difference:.1e}",
            all.len(),
            all[all.len() - 1]
        );
        // The models sample an impact at different instants: at the extremes of its contacts, but not of joint forces.
        assert!(peak_difference < 0.2, "{file}: peaks differ by {peak_difference:e}");
        assert!(
            scale > 0.0 && median < median_bound && at_end < end_bound,
            "{file}: median {median:e}, end {at_end:e}"
        );
    }
}

/// Forces and moments of the joints at the end of a run, by name.
fn forces_at_end(model: Model, text: &str, joints: &[&str]) -> Vec<[f64; 3]> {
    let scene = scene::parse_any(text, "sliders.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
    let recording = record(model, &scene).unwrap_or_else(|error| panic!("{error}")).1;
    let last = |name: String| *recording.column(&name).unwrap_or_else(|| panic!("{name}")).last().expect("a sample");
    // A pin transmits no moment.
    let of = |joint: &&str| {
        let moment = format!("{joint}_moment_n_m");
        let has_moment = recording.column(&moment).is_some();
        let [x, y] = ["x", "y"].map(|axis| last(format!("{joint}_force_{axis}_n")));
        [x, y, if has_moment { last(moment) } else { 0.0 }]
    };
    joints.iter().map(of).collect()
}

/// A slider with a spring, and its closed form: across the axis, the force of the joint balances weight and spring, and its
/// moment about the joint balances theirs.
#[test]
fn a_slider_at_any_angle_transmits_the_force_across_its_axis() {
    for degrees in (-180..=180).step_by(15) {
        let axis = f64::from(degrees).to_radians();
        // The axis passes through (−30, 0) mm.
        let text = format!(
            "kind = \"mechanism\"\nduration = \"50 ms\"\ngravity = [\"3 m/s^2\", \"-9.81 m/s^2\"]\n[bodies.left]\n\
             mass = \"300 g\"\ninertia = \"1e5 g*mm^2\"\ncom = [\"5 mm\", \"2 mm\"]\n[joints.left]\ntype = \"prismatic\"\n\
             bodies = [\"ground\", \"left\"]\npoints = [[\"-30 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\naxis = \"{degrees} deg\"\n\
             start = \"-500 mm\"\ndamping = \"2 N*s/m\"\n[springs.s]\ntype = \"linear\"\nbodies = [\"ground\", \"left\"]\n\
             points = [[\"0 mm\", \"-200 mm\"], [\"3 mm\", \"0 mm\"]]\nstiffness = \"100 N/m\"\nrest = \"100 mm\"\n"
        );
        let scene = scene::parse_any(&text, "slider.toml").unwrap_or_else(|error| panic!("{error}"));
        let recording = record(Model::Analytic, &scene).unwrap_or_else(|error| panic!("{error}")).1;
        let last = |name: &str| *recording.column(name).unwrap_or_else(|| panic!("{name}")).last().expect("a sample");
        let q = last("left_position_m");
        let origin = [-0.03 + q * axis.cos(), q * axis.sin()];
        let (arm, end) = ([0.005, 0.002], [origin[0] + 0.003, origin[1]]);
        let weight = [0.3 * 3.0, -0.3 * 9.81];
        let between = [-end[0], -0.2 - end[1]];
        let length = between[0].hypot(between[1]);
        let pull = between.map(|part| 100.0 * (length - 0.1) * part / length);
        let across = [-axis.sin(), axis.cos()];
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let force = -dot([weight[0] + pull[0], weight[1] + pull[1]], across);
        // The body does not turn. The force along the axis acts at the joint, and its inertia at the centre of mass.
        let damping = -2.0 * last("left_rate_m_s");
        let along = dot([weight[0] + pull[0], weight[1] + pull[1]], [axis.cos(), axis.sin()]) + damping;
        let inertia = [along * axis.cos(), along * axis.sin()];
        let moment = cross(arm, inertia) - cross(arm, weight) - cross([0.003, 0.0], pull);
        let found = ["left_force_x_n", "left_force_y_n", "left_moment_n_m"].map(last);
        let expected = [force * across[0], force * across[1], moment];
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9, "{degrees}: {found} {expected}");
        }
        if degrees == 90 {
            assert!((found[0] + 2.483).abs() < 5e-4 && (found[2] - 0.00896).abs() < 5e-6, "{found:?}");
        }
    }
}

/// A slider on a slider, and a crank that drives a block along another one, turned by an angle with their gravity.
fn turned_sliders(degrees: f64) -> String {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let at = |x: f64, y: f64| format!("[\"{:e} mm\", \"{:e} mm\"]", cos * x - sin * y, sin * x + cos * y);
    let gravity = [cos * 3.0 + sin * 9.81, sin * 3.0 - cos * 9.81];
    let body = |name: &str, [x, y]: [f64; 2], angle: f64, com: [f64; 2]| {
        format!(
            "[bodies.{name}]\nmass = \"80 g\"\ninertia = \"2e4 g*mm^2\"\ncom = [\"{} mm\", \"{} mm\"]\nguess = {{ at = {}, angle = \"{:e} deg\" }}\n",
            com[0],
            com[1],
            at(x, y),
            degrees + angle
        )
    };
    let (pin, block) = ([30.0 * 0.8, 30.0 * 0.6], 30.0 * 0.8 + (80.0f64 * 80.0 - 18.0 * 18.0).sqrt());
    let rod_angle = (-18.0f64 / 80.0).asin().to_degrees();
    format!(
        "kind = \"mechanism\"\nduration = \"20 ms\"\ngravity = [\"{:e} m/s^2\", \"{:e} m/s^2\"]\n{}{}{}{}{}\
         [joints.first]\ntype = \"prismatic\"\nbodies = [\"ground\", \"first\"]\npoints = [{}, [\"0 mm\", \"0 mm\"]]\n\
         axis = \"{degrees:e} deg\"\noffset = \"{degrees:e} deg\"\nstart = \"20 mm\"\nstart_rate = \"0.3 m/s\"\ndamping = \"2 N*s/m\"\n\
         [joints.second]\ntype = \"prismatic\"\nbodies = [\"first\", \"second\"]\npoints = [[\"5 mm\", \"3 mm\"], [\"1 mm\", \"0 mm\"]]\n\
         axis = \"90 deg\"\nstart = \"10 mm\"\nstart_rate = \"-0.2 m/s\"\n\
         [springs.between]\ntype = \"linear\"\nbodies = [\"ground\", \"second\"]\npoints = [{}, [\"3 mm\", \"1 mm\"]]\n\
         stiffness = \"200 N/m\"\nrest = \"30 mm\"\n\
         [joints.crank]\nbodies = [\"ground\", \"crank\"]\npoints = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\n\
         offset = \"{degrees:e} deg\"\nstart = \"{:e} deg\"\nstart_rate = \"15 rad/s\"\n\
         [joints.pin]\nbodies = [\"crank\", \"rod\"]\npoints = [[\"30 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\n\
         [joints.wrist]\nbodies = [\"rod\", \"block\"]\npoints = [[\"80 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\n\
         [joints.slide]\ntype = \"prismatic\"\nbodies = [\"ground\", \"block\"]\npoints = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\n\
         axis = \"{degrees:e} deg\"\noffset = \"{degrees:e} deg\"\n",
        gravity[0],
        gravity[1],
        body("first", [220.0, 100.0], 0.0, [5.0, 2.0]),
        body("second", [220.0, 110.0], 0.0, [2.0, 8.0]),
        body("crank", [0.0, 0.0], 36.869897645844, [12.0, 0.0]),
        body("rod", pin, rod_angle, [40.0, 1.0]),
        body("block", [block, 0.0], 0.0, [3.0, 1.0]),
        at(200.0, 100.0),
        at(200.0, 160.0),
        36.869897645844,
    )
}

/// Turned mechanisms have turned forces, and those of the engine: sliders of moving bodies, and in a dyad.
#[test]
fn forces_of_sliders_turn_with_the_mechanism() {
    let joints = ["first", "second", "crank", "pin", "wrist", "slide"];
    let expected = forces_at_end(Model::Analytic, &turned_sliders(17.0), &joints);
    let scale = expected.iter().flatten().fold(0.0f64, |largest, part| largest.max(part.abs()));
    assert!(scale > 1.0 && expected.iter().all(|[x, y, _]| x.hypot(*y) > 0.01 * scale), "{expected:?}");
    let mut worst = 0.0f64;
    for degrees in (-180..=180).step_by(15).map(f64::from) {
        let found = forces_at_end(Model::Analytic, &turned_sliders(degrees), &joints);
        let (sin, cos) = (degrees - 17.0).to_radians().sin_cos();
        for ([x, y, moment], found) in expected.iter().zip(found) {
            let turned = turned([*x, *y], [cos, sin]);
            let errors = [found[0] - turned[0], found[1] - turned[1], (found[2] - moment) / 0.03];
            worst = errors.iter().fold(worst, |worst, error| worst.max(error.abs() / scale));
        }
    }
    println!("largest relative difference: {worst:e}");
    assert!(worst < 1e-12, "{worst:e}");
    let [analytic, engine] =
        [Model::Analytic, Model::Engine].map(|model| forces_at_end(model, &turned_sliders(90.0), &joints));
    for (a, b) in analytic.iter().flatten().zip(engine.iter().flatten()) {
        assert!((a - b).abs() < 2e-3 * scale, "{analytic:?} {engine:?}");
    }
}
