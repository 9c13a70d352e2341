//! Comparison of the criteria of both runs, which must agree like their trajectories.

use super::{Check, Recording};
use crate::check;
use crate::criteria::{Criteria, EPSILON_RAD, Fate, GraspCriteria, is_form_closed};
use crate::scene::Scene;
use crate::scene::keywords::SceneKind;
use crate::trace::Layout;

/// Largest difference of the number of lost contacts, as a fraction of the larger number or of [`MIN_LOSS_SCALE`],
/// whichever is larger. A difference of one always passes; a difference of two in four fails.
pub const MAX_LOST_CONTACTS_DIFFERENCE: f64 = 0.25;
/// Smallest denominator of [`MAX_LOST_CONTACTS_DIFFERENCE`].
pub const MIN_LOSS_SCALE: u32 = 4;
/// Largest difference of the time during which a contact is lost, as a fraction of the duration.
pub const MAX_LOST_TIME_DIFFERENCE: f64 = 0.02;

/// The value of a criterion in one model.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    Label(&'static str),
    /// Number in SI units; `None` if the run does not have the quantity.
    Number(Option<f64>),
}

/// One criterion in both models.
#[derive(Clone, Debug, PartialEq)]
pub struct Criterion {
    /// Key of its bound, with its unit.
    pub bound: &'static str,
    /// Name of the pair or contact; empty for criteria of the whole scene.
    pub subject: String,
    pub analytic: Value,
    pub engine: Value,
    /// Difference compared with the limit: 0 or 1 for labels, otherwise the absolute difference; infinite if only one
    /// model has a value.
    pub difference: f64,
    pub limit: f64,
}

impl Criterion {
    fn from_labels(bound: &'static str, [analytic, engine]: [&'static str; 2]) -> Self {
        let difference = if analytic == engine { 0.0 } else { 1.0 };
        let (analytic, engine) = (Value::Label(analytic), Value::Label(engine));
        Criterion { bound, subject: String::new(), analytic, engine, difference, limit: 0.0 }
    }

    fn from_numbers(bound: &'static str, [analytic, engine]: [Option<f64>; 2], limit: f64) -> Self {
        let difference = match (analytic, engine) {
            (Some(analytic), Some(engine)) => (engine - analytic).abs(),
            (None, None) => 0.0,
            _ => f64::INFINITY,
        };
        let (analytic, engine) = (Value::Number(analytic), Value::Number(engine));
        Criterion { bound, subject: String::new(), analytic, engine, difference, limit }
    }
}

/// Compares the criteria of both runs of a scene; empty if there are none, as for a finger without an object.
pub fn compare_criteria(scene: &Scene, analytic: &Recording, engine: &Recording) -> Vec<Criterion> {
    let runs = [analytic, engine];
    let criteria = runs.map(|run| run.run_criteria.as_ref());
    let [Some(analytic), Some(engine)] = criteria else { return Vec::new() };
    match scene.kind() {
        SceneKind::Finger => match (&analytic.criteria, &engine.criteria) {
            (Some(analytic), Some(engine)) => compare_finger(scene, analytic, engine),
            _ => Vec::new(),
        },
        SceneKind::Gripper => match (&analytic.grasp, &engine.grasp) {
            (Some(analytic), Some(engine)) => compare_gripper(scene, runs, [analytic, engine]),
            _ => Vec::new(),
        },
        SceneKind::Bodies => {
            let layout = Layout::from_system(&scene.system);
            let pairs = layout.contacts.iter().zip(analytic.rebounds.iter().zip(&engine.rebounds));
            let restitutions = pairs.map(|(contact, (analytic, engine))| {
                let values = [analytic, engine].map(|rebound| rebound.restitution());
                let restitution = Criterion::from_numbers("restitution", values, scene.bounds.restitution);
                (values, Criterion { subject: contact.name.clone(), ..restitution })
            });
            restitutions
                .filter(|(values, _)| values.iter().any(Option::is_some))
                .map(|(_, criterion)| criterion)
                .collect()
        }
    }
}

fn compare_finger(scene: &Scene, analytic: &Criteria, engine: &Criteria) -> Vec<Criterion> {
    let both = [analytic, engine];
    vec![
        Criterion::from_labels("class", both.map(|found| found.class.name())),
        Criterion::from_numbers("stability_time_s", both.map(|found| found.tts_s), scene.bounds.stability_time_s),
    ]
}

fn compare_gripper(scene: &Scene, runs: [&Recording; 2], both: [&GraspCriteria; 2]) -> Vec<Criterion> {
    let mut compared = vec![
        Criterion::from_labels("fate", both.map(|found| found.fate.name())),
        Criterion::from_numbers("stability_time_s", both.map(|found| found.tts_s), scene.bounds.stability_time_s),
    ];
    // Fingers that have released the object cannot be form-closed.
    let is_held = |found: &GraspCriteria| found.fate == Fate::Held && found.cycle.release_s.is_none();
    if both.into_iter().all(is_held) {
        let form_closed = runs.map(|run| match is_form_closed(scene, &run.outcome.last) {
            Some(true) => "yes",
            Some(false) => "no",
            None => "undecided",
        });
        compared.push(Criterion::from_labels("form_closed", form_closed));
    }
    let losses = both.map(|found| found.contacts.iter().map(|contact| contact.times_lost).sum::<u32>());
    let scale = losses[0].max(losses[1]).max(MIN_LOSS_SCALE);
    let lost = Criterion::from_numbers(
        "contacts_lost",
        losses.map(|count| Some(f64::from(count))),
        MAX_LOST_CONTACTS_DIFFERENCE,
    );
    compared.push(Criterion { difference: f64::from(losses[0].abs_diff(losses[1])) / f64::from(scale), ..lost });
    // Select the contact with the largest difference.
    let contacts = both[0].contacts.iter().zip(&both[1].contacts);
    let lost_times = contacts.map(|(a, b)| (a.id, [a.lost_s, b.lost_s]));
    let worst = lost_times.max_by(|(_, [a, b]), (_, [c, d])| (a - b).abs().total_cmp(&(c - d).abs()));
    compared.extend(worst.map(|(contact, times)| {
        let lost = Criterion::from_numbers("lost_time", times.map(Some), MAX_LOST_TIME_DIFFERENCE);
        Criterion { subject: contact.name().to_string(), difference: lost.difference / scene.duration_s, ..lost }
    }));
    compared
}

/// Returns why the criteria of two accurate runs of a scene may differ, so that they are reported without being judged;
/// `None` where they are judged.
pub fn reason_not_judged(scene: &Scene, reference: &check::Check) -> Option<&'static str> {
    let Scene { bounds, duration_s, .. } = scene;
    if scene.kind() != SceneKind::Bodies && bounds.until_s < *duration_s {
        Some("the runs are not compared to their end")
    } else if reference.verdict == check::Verdict::Chaotic {
        Some("the outcome is chaotic")
    } else if scene.kind() == SceneKind::Finger && bounds.angle_rad >= EPSILON_RAD {
        Some("the bound of the angles is not below the 0.2 deg band in which the finger counts as in position")
    } else {
        None
    }
}

/// Returns the criteria as bounds of the verdict: the worst of each kind.
pub fn criteria_checks(found: &[Criterion]) -> Vec<Check> {
    let mut checks: Vec<Check> = Vec::new();
    for Criterion { bound, difference, limit, .. } in found {
        match checks.iter_mut().find(|check| check.bound == *bound) {
            Some(check) => check.measured = check.measured.map(|worst| worst.max(*difference)),
            None => checks.push(Check { bound, meaning: meaning(bound), measured: Some(*difference), limit: *limit }),
        }
    }
    checks
}

fn meaning(bound: &str) -> &'static str {
    match bound {
        "class" => "class in both models: 0 equal, 1 different",
        "fate" => "fate of the object in both models: 0 equal, 1 different",
        "form_closed" => "form closure in both models: 0 equal, 1 different",
        "stability_time_s" => "difference of the time to stability",
        "contacts_lost" => "relative difference of the number of lost contacts",
        "lost_time" => "difference of the time during which a contact is lost, as a fraction of the duration",
        _ => "largest difference of a coefficient of restitution",
    }
}
