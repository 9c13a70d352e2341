//! Derivatives of the shipped mechanisms at their ends: which are given, and whether they agree with differences of runs.

use crate::gradient::{differences, mechanism, parameter};
use crate::support::runs::{assert_below, assert_near};
use phalanx::gradient::{Gradient, gradient};
use phalanx::mechanism::{Command, Mechanism};
use phalanx::scene::{self, Scene};
use phalanx::trace::{Channel, Model, record};

/// Multiplies a property of a mechanism.
type Multiply = Box<dyn Fn(&mut Mechanism, f64)>;

struct Change {
    name: String,
    apply: Multiply,
}

fn change(name: String, apply: impl Fn(&mut Mechanism, f64) + 'static) -> Change {
    Change { name, apply: Box::new(apply) }
}

/// Stiffnesses of springs and tendons, dampings and frictions of joints, efforts and gains of actuators, masses of the
/// first and the last body, and friction of contacts.
fn changes(mechanism: &Mechanism) -> Vec<Change> {
    let mut all = Vec::new();
    for (i, spring) in mechanism.springs.iter().enumerate().filter(|(_, spring)| spring.stiffness > 0.0).take(2) {
        all.push(change(format!("stiffness of {}", spring.name), move |m, x| m.springs[i].stiffness *= x));
    }
    if let Some(i) = mechanism.joints.iter().position(|joint| joint.damping > 0.0) {
        all.push(change(format!("damping of {}", mechanism.joints[i].name), move |m, x| m.joints[i].damping *= x));
    }
    if let Some(i) = mechanism.joints.iter().position(|joint| joint.friction.is_some()) {
        all.push(change(format!("friction of {}", mechanism.joints[i].name), move |m, x| {
            let law = m.joints[i].friction.as_mut().expect("friction");
            (law.mu_static, law.mu_dynamic) = (law.mu_static * x, law.mu_dynamic * x);
        }));
    }
    for (i, actuator) in mechanism.actuators.iter().enumerate().take(2) {
        let what = if matches!(actuator.command, Command::Effort(_)) { "effort" } else { "target" };
        all.push(change(format!("{what} of {}", actuator.name), move |m, x| {
            let profile = m.actuators[i].command.profile_mut();
            *profile = profile.scaled(x);
        }));
        if matches!(actuator.command, Command::Servo { .. }) {
            all.push(change(format!("gains of {}", actuator.name), move |m, x| {
                let Command::Servo { kp, kd, .. } = &mut m.actuators[i].command else { return };
                (*kp, *kd) = (*kp * x, *kd * x);
            }));
        }
        if actuator.limit.is_some() {
            all.push(change(format!("limit of {}", actuator.name), move |m, x| {
                m.actuators[i].limit = m.actuators[i].limit.map(|limit| limit * x);
            }));
        }
    }
    for (i, tendon) in mechanism.tendons.iter().enumerate().take(2) {
        if tendon.stiffness_n_per_m > 0.0 {
            all.push(change(format!("stiffness of {}", tendon.name), move |m, x| m.tendons[i].stiffness_n_per_m *= x));
        }
        if tendon.actuator.is_some() {
            all.push(change(format!("tension of {}", tendon.name), move |m, x| {
                let actuator = m.tendons[i].actuator.as_mut().expect("an actuator");
                actuator.tension = actuator.tension.scaled(x);
            }));
        }
    }
    let mut bodies: Vec<usize> =
        (0..mechanism.bodies.len()).filter(|i| mechanism.bodies[*i].motion.is_none()).collect();
    bodies.drain(1..bodies.len().saturating_sub(1).max(1));
    for i in bodies {
        all.push(change(format!("mass of {}", mechanism.bodies[i].name), move |m, x| {
            m.bodies[i].mass_kg *= x;
            m.bodies[i].inertia_kg_m2 *= x;
        }));
    }
    if mechanism.contacts.iter().any(|contact| contact.law.friction.is_some()) {
        all.push(change("friction of contacts".to_string(), |m, x| {
            for law in m.contacts.iter_mut().filter_map(|contact| contact.law.friction.as_mut()) {
                (law.mu_static, law.mu_dynamic) = (law.mu_static * x, law.mu_dynamic * x);
            }
        }));
    }
    all
}

/// What became of the derivatives of the end by a property, with a description.
enum Verdict {
    Refused(String),
    /// Largest difference from differences of runs, relative to the scale of its channel.
    Given(f64, String),
    /// Some differences of runs are less accurate than needed to judge.
    Unjudged(String),
}

/// Relative changes of a property in differences of runs; the one with the smallest error counts. The next one follows where
/// some errors are not small.
const CHANGES: [f64; 3] = [1e-3, 1e-4, 1e-5];
/// Largest error of differences of runs, relative to the scale of a channel, that judge its derivative.
const MAX_DIFFERENCE_ERROR: f64 = 1e-3;
/// Largest error of a derivative, relative to the scale of its channel. The largest one that was measured is 1.5e-5.
const MAX_ERROR: f64 = 5e-5;

/// Names and scales of all channels: the largest value along the run, and at least 1e-4 of that of its unit. A
/// property that is multiplied by 1 + ε changes them by about ε times the scale.
fn scales(scene: &Scene) -> Vec<(String, f64)> {
    let (_, recording) = record(Model::Analytic, scene).unwrap_or_else(|error| panic!("{error}"));
    let largest = |channel: &Channel| {
        let values = recording.column(&channel.name).expect("a column").iter();
        values.filter(|value| value.is_finite()).fold(0.0_f64, |largest, value| largest.max(value.abs()))
    };
    let channels: Vec<(&Channel, f64)> =
        recording.channels().iter().map(|channel| (channel, largest(channel))).collect();
    let of_unit = |unit: &str| {
        channels
            .iter()
            .filter(|(channel, _)| channel.unit == unit)
            .fold(0.0_f64, |largest, (_, value)| largest.max(*value))
    };
    channels.iter().map(|(channel, value)| (channel.name.clone(), value.max(1e-4 * of_unit(channel.unit)))).collect()
}

/// A property of a scene as a parameter of value 1.
fn factor<'a>(scene: &'a Scene, change: &'a Change) -> phalanx::gradient::Parameter<'a> {
    parameter(1.0, |factor| {
        let mut changed = scene.clone();
        (change.apply)(changed.mechanism.as_mut().expect("a mechanism"), factor);
        changed
    })
}

fn gradient_by(scene: &Scene, change: &Change) -> Result<Gradient, String> {
    let found = gradient(scene, &[factor(scene, change)], &|| true);
    let found = found.map_err(|error| error.to_string())?.remove(0);
    match &found.end.reason {
        Some(reason) => Err(reason.clone()),
        None => Ok(found),
    }
}

fn judge(scene: &Scene, change: &Change) -> Verdict {
    let found = match gradient_by(scene, change) {
        Ok(found) => found,
        Err(reason) => return Verdict::Refused(reason),
    };
    let factor = factor(scene, change);
    let scales = scales(scene);
    let mut ends: Vec<[f64; 2]> = vec![[f64::NAN, f64::INFINITY]; scales.len()];
    for change in CHANGES {
        let found = differences(&factor, change, |(end, _)| end.clone());
        ends.iter_mut().zip(found).filter(|(best, found)| found[1] < best[1]).for_each(|(best, found)| *best = found);
        if ends.iter().zip(&scales).all(|(end, (channel, scale))| {
            channel == "balance_j" || end[1] <= 0.1 * MAX_ERROR * scale.max(end[0].abs())
        }) {
            break;
        }
    }
    let (mut largest, mut unjudged) = ((0.0_f64, String::new()), (0.0_f64, String::new()));
    for ([difference, error], (channel, scale)) in ends.into_iter().zip(scales) {
        // The balance of energies is 0; its derivatives are those of the errors of runs.
        let Some(derivative) = found.end.values.get(&channel).filter(|_| channel != "balance_j") else { continue };
        let scale = scale.max(difference.abs());
        let describe = || format!("{channel}: {derivative:e}, differences {difference:e} ± {error:e}, scale {scale:e}");
        if error / scale > MAX_DIFFERENCE_ERROR {
            if error / scale > unjudged.0 {
                unjudged = (error / scale, describe());
            }
            continue;
        }
        let off = ((derivative - difference).abs() - 3.0 * error).max(0.0) / scale;
        if off > largest.0 {
            largest = (off, describe());
        }
    }
    match unjudged.0 > 0.0 && largest.0 < MAX_ERROR {
        true => Verdict::Unjudged(unjudged.1),
        false => Verdict::Given(largest.0, largest.1),
    }
}

fn load(file: &str) -> Scene {
    scene::load_any(format!("scenes/{file}.toml")).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
#[ignore = "takes minutes"]
fn derivatives_of_shipped_mechanisms() {
    let only = std::env::var("PHALANX_SCENE").unwrap_or_default();
    let folders = ["mechanisms", "real"].map(|folder| std::fs::read_dir(format!("scenes/{folder}")).expect("a folder"));
    let files = folders.into_iter().flatten().map(|entry| entry.expect("an entry").path());
    let mut files: Vec<_> = files.filter(|path| path.to_string_lossy().contains(&only)).collect();
    files.sort();
    let (mut count, mut refused, mut unjudged, mut wrong) = (0, 0, 0, Vec::new());
    for file in files {
        let mut scene = scene::load_any(&file).unwrap_or_else(|error| panic!("{error}"));
        if let Ok(d) = std::env::var("PHALANX_DUR") {
            scene.duration_s = d.parse().unwrap();
        }
        let only_change = std::env::var("PHALANX_CHANGE").unwrap_or_default();
        let Some(mechanism) = &scene.mechanism else { continue };
        for change in changes(mechanism) {
            if !change.name.contains(&only_change) {
                continue;
            }
            let verdict = judge(&scene, &change);
            let property = format!("{}: {}", file.display(), change.name);
            count += 1;
            match verdict {
                Verdict::Refused(reason) => {
                    println!("{property}: refused, {reason}");
                    refused += 1;
                }
                Verdict::Unjudged(channel) => {
                    println!("{property}: not judged, {channel}");
                    unjudged += 1;
                }
                Verdict::Given(error, channel) => {
                    println!("{property}: error {error:e}, {channel}");
                    wrong.extend((error > MAX_ERROR).then_some(property));
                }
            }
        }
    }
    println!(
        "{count} derivatives: {refused} refused, {unjudged} partly beyond the accuracy of differences, {wrong:?} wrong"
    );
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// Derivatives that were refused because of rounding: of quantities that are 0 by geometry or have come to rest, at
/// touch-downs of parallel sides, after kinks of set points.
#[test]
fn derivatives_of_shipped_mechanisms_are_given() {
    for (file, name, duration_s) in [
        ("mechanisms/andrews", "effort of motor", 0.003),
        ("mechanisms/four-bar", "stiffness of torsion", 0.05),
        ("mechanisms/jaws", "limit of left", 0.036),
    ] {
        let scene = Scene { duration_s, ..load(file) };
        let all = changes(scene.mechanism.as_ref().expect("a mechanism"));
        let change = all.iter().find(|change| change.name == name).expect("a change");
        match judge(&scene, change) {
            Verdict::Given(error, channel) => assert_below(error, MAX_ERROR, format!("{file}, {name}: {channel}")),
            Verdict::Refused(text) | Verdict::Unjudged(text) => panic!("{file}, {name}: {text}"),
        }
    }
}

/// A finger of two phalanges that a tendon closes on a disc, and its stiffness by which nothing moves at the end.
#[test]
fn a_hand_at_rest_has_derivatives() {
    let scene = mechanism(include_str!("tendon.toml"));
    let stiffness = change("stiffness".to_string(), |m, x| m.springs[1].stiffness *= x);
    let found = gradient_by(&scene, &stiffness).unwrap_or_else(|reason| panic!("{reason}"));
    // By N·m/rad, from differences of runs.
    let derivative = found.end.values["right_middle_rad"] / 0.05;
    assert_near(derivative, -0.59866, 1e-4, "the angle of the middle joint");
}
