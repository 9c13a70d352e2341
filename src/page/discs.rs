//! The film of a scene of discs.

use super::film::{Contact, Curve, Film, Mark, Plan, Scale, Shown, film, mark, plan};
use crate::drawing;
use crate::scene::BodiesScene;
use crate::trace::ContactSample;
use crate::trace::bodies::{BodiesEvent, BodiesSample, DiscState};
use crate::wording::Sheet;

/// A quantity of a disc, by its name.
type OfDisc = (&'static str, fn(&DiscState) -> f64, Option<fn(&DiscState) -> f64>);

/// Pairs that are shown where none touches.
const IDLE_PAIRS: usize = 6;

/// A run of discs as the page shows it; `summary` is what is said of it below. Pairs that never touch are left out where
/// others do.
pub fn discs_film(
    label: &str,
    scene: &BodiesScene,
    samples: &[BodiesSample],
    events: &[BodiesEvent],
    summary: impl Into<Sheet>,
) -> Film {
    let names: Vec<String> = scene.pairs().into_iter().map(|pair| scene.pair_name(pair)).collect();
    let shown = touching(names.len(), samples, events);
    let pair = |index: usize| {
        let contact: Contact<'_, BodiesSample> = Box::new(move |sample| sample.contacts[index]);
        (names[index].clone(), contact)
    };
    film(Shown {
        label,
        summary: summary.into(),
        drawing: drawing::discs(scene),
        samples,
        time_s: |sample| sample.time_s,
        poses: Box::new(|sample| drawing::disc_poses(scene, sample)),
        motions: Box::new(|sample| drawing::disc_motions(scene, sample)),
        contacts: shown.iter().map(|&index| pair(index)).collect(),
        panels: panels(scene, &names, &shown),
        marks: events.iter().map(|event| of(event, &names)).collect(),
    })
}

fn of(event: &BodiesEvent, names: &[String]) -> Mark {
    let figures = [event.approach_m_s, event.impulse_n_s];
    mark(event.time_s, &names[event.pair], event.kind, figures, ["m/s", "N·s"])
}

/// Indices of the pairs that touch, or of the first few if none does.
fn touching(pairs: usize, samples: &[BodiesSample], events: &[BodiesEvent]) -> Vec<usize> {
    let presses = |pair: usize| samples.iter().any(|sample| sample.contacts[pair].normal_n > 0.0);
    let touches = |pair: &usize| events.iter().any(|event| event.pair == *pair) || presses(*pair);
    let found: Vec<usize> = (0..pairs).filter(touches).collect();
    if found.is_empty() { (0..pairs.min(IDLE_PAIRS)).collect() } else { found }
}

fn panels<'a>(scene: &BodiesScene, names: &[String], shown: &[usize]) -> Vec<Plan<'a, BodiesSample>> {
    let of_pairs = |value: fn(&ContactSample) -> f64| -> Vec<Curve<'a, BodiesSample>> {
        let of = |&pair: &usize| -> Curve<'a, BodiesSample> {
            Curve::new(&names[pair], move |sample: &BodiesSample| value(&sample.contacts[pair]))
        };
        shown.iter().map(of).collect::<Vec<_>>()
    };
    let gaps = of_pairs(|contact| contact.gap_m)
        .into_iter()
        .zip(shown)
        .map(|(gap, &pair)| gap.with_rate(move |sample: &BodiesSample| sample.contacts[pair].gap_rate_m_s));
    let of_discs = |quantities: &[OfDisc]| -> Vec<Curve<'a, BodiesSample>> {
        let moving = scene.discs.iter().enumerate().filter(|(_, disc)| disc.motion.moves());
        let mut curves: Vec<Curve<'a, BodiesSample>> = Vec::new();
        for (index, disc) in moving {
            for &(quantity, value, rate) in quantities {
                let name = format!("{} {quantity}", disc.name);
                let curve = Curve::new(name, move |sample: &BodiesSample| value(&sample.discs[index]));
                curves.push(match rate {
                    Some(rate) => curve.with_rate(move |sample| rate(&sample.discs[index])),
                    None => curve,
                });
            }
        }
        curves
    };
    let friction = match scene.contact.friction {
        Some(_) => of_pairs(|contact| contact.tangential_n),
        None => Vec::new(),
    };
    let energy = |name: &str, value: fn(&BodiesSample) -> f64| -> Curve<'a, BodiesSample> { Curve::new(name, value) };
    vec![
        plan("Normal force", "N", Scale::Linear, of_pairs(|contact| contact.normal_n)),
        plan("Friction force", "N", Scale::Linear, friction),
        plan("Gap", "m", Scale::Linear, gaps.collect()),
        plan(
            "Place",
            "m",
            Scale::Linear,
            of_discs(&[
                ("x", |disc| disc.centre_m[0], Some(|disc| disc.velocity_m_s[0])),
                ("y", |disc| disc.centre_m[1], Some(|disc| disc.velocity_m_s[1])),
            ]),
        ),
        plan(
            "Velocity",
            "m/s",
            Scale::Linear,
            of_discs(&[("vx", |disc| disc.velocity_m_s[0], None), ("vy", |disc| disc.velocity_m_s[1], None)]),
        ),
        plan("Spin", "rad/s", Scale::Linear, of_discs(&[("spin", |disc| disc.spin_rad_s, None)])),
        plan(
            "Energy",
            "J",
            Scale::Linear,
            vec![
                energy("kinetic", |s| s.energy.kinetic_j),
                energy("drive work", |s| s.energy.motor_work_j),
                energy("dissipated", |s| s.energy.dissipated_j),
                energy("contact", |s| s.energy.elastic_j),
                energy("gravity", |s| s.energy.gravity_j),
                energy("balance", |s| s.energy.balance_j),
            ],
        ),
    ]
}
