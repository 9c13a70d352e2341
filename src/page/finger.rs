//! The film of a finger.

use super::film::{Curve, Film, Mark, Plan, Scale, Shown, film, mark, plan};
use crate::drawing;
use crate::scene::Scene;
use crate::trace::{ContactSample, Event, Sample, Site};
use crate::validate::turned;
use crate::wording::Sheet;

/// A run of a finger as the page shows it; `summary` is what is said of it below.
///
/// Plotted angles are from −π to π, as in the series of a validation; poses are as they are.
pub fn finger_film(
    label: &str,
    scene: &Scene,
    samples: &[Sample],
    events: &[Event],
    summary: impl Into<Sheet>,
) -> Film {
    film(Shown {
        label,
        summary: summary.into(),
        drawing: drawing::finger(scene),
        samples,
        time_s: |sample| sample.time_s,
        poses: Box::new(|sample| drawing::finger_poses(scene, sample)),
        motions: Box::new(|sample| drawing::finger_motions(scene, sample)),
        contacts: match scene.object {
            None => Vec::new(),
            Some(_) => vec![
                (Site::Proximal.name().to_string(), Box::new(|sample: &Sample| sample.proximal)),
                (Site::Distal.name().to_string(), Box::new(|sample: &Sample| sample.distal)),
            ],
        },
        panels: panels(scene),
        marks: events.iter().map(of).collect(),
    })
}

fn of(event: &Event) -> Mark {
    let units = match event.site {
        Site::Proximal | Site::Distal => ["m/s", "N·s"],
        Site::Limit => ["rad/s", "N·m·s"],
    };
    mark(event.time_s, event.site.name(), event.kind, [event.approach_speed, event.impulse], units)
}

fn curve(name: &str, value: fn(&Sample) -> f64) -> Curve<'static, Sample> {
    Curve::new(name, value)
}

fn moving(name: &str, value: fn(&Sample) -> f64, rate: fn(&Sample) -> f64) -> Curve<'static, Sample> {
    Curve::new(name, value).with_rate(rate)
}

/// Both phalanges, where there is something to touch.
fn contacts(scene: &Scene, value: fn(&ContactSample) -> f64) -> Vec<Curve<'static, Sample>> {
    match scene.object {
        None => Vec::new(),
        Some(_) => vec![
            Curve::new("proximal", move |sample: &Sample| value(&sample.proximal)),
            Curve::new("distal", move |sample: &Sample| value(&sample.distal)),
        ],
    }
}

fn gaps(scene: &Scene) -> Vec<Curve<'static, Sample>> {
    let rates: [fn(&Sample) -> f64; 2] = [|s| s.proximal.gap_rate_m_s, |s| s.distal.gap_rate_m_s];
    contacts(scene, |contact| contact.gap_m).into_iter().zip(rates).map(|(gap, rate)| gap.with_rate(rate)).collect()
}

fn panels(scene: &Scene) -> Vec<Plan<'static, Sample>> {
    let law = &scene.contact;
    let friction = match (law.proximal.friction, law.distal.friction) {
        (None, None) => Vec::new(),
        _ => contacts(scene, |contact| contact.tangential_n),
    };
    let mut angles = vec![
        moving("q11", |s| turned(s.q11_rad), |s| s.qd11_rad_s),
        moving("q21", |s| turned(s.q21_rad), |s| s.qd21_rad_s),
        moving("q22", |s| turned(s.q22_rad), |s| s.qd22_rad_s),
    ];
    let mut torques = vec![curve("motor", |s| s.motor_torque_n_m)];
    if scene.limit.is_some() {
        angles.push(moving("to limit", |s| s.limit.gap_m, |s| s.limit.gap_rate_m_s));
        torques.push(curve("limit", |s| s.limit.normal_n));
    }
    vec![
        plan("Normal force", "N", Scale::Logarithmic, contacts(scene, |contact| contact.normal_n)),
        plan("Friction force", "N", Scale::Logarithmic, friction),
        plan("Gap", "m", Scale::Logarithmic, gaps(scene)),
        plan("Joint angle", "rad", Scale::Linear, angles),
        plan(
            "Joint rate",
            "rad/s",
            Scale::Linear,
            vec![curve("qd11", |s| s.qd11_rad_s), curve("qd21", |s| s.qd21_rad_s), curve("qd22", |s| s.qd22_rad_s)],
        ),
        plan(
            "Energy",
            "J",
            Scale::Linear,
            vec![
                curve("kinetic", |s| s.energy.kinetic_j),
                curve("motor work", |s| s.energy.motor_work_j),
                curve("dissipated", |s| s.energy.dissipated_j),
                curve("spring", |s| s.energy.spring_j),
                curve("contact", |s| s.energy.elastic_j),
                curve("gravity", |s| s.energy.gravity_j),
                curve("balance", |s| s.energy.balance_j),
            ],
        ),
        plan("Torque", "N·m", Scale::Linear, torques),
    ]
}
