//! Criteria of a run in both models: what the runs are judged by must agree, not only their paths.

use super::{Check, Recording};
use crate::check;
use crate::criteria::{Criteria, EPSILON_RAD, Fate, GraspCriteria, is_form_closed};
use crate::scene::Scene;
use crate::scene::words::SceneKind;
use crate::trace::Layout;

/// Largest difference of the number of lost contacts, as a part of the larger number, which counts as [`FEW_LOSSES`] at least: one more
/// or one less is no disagreement, two of four are.
pub const LOST_SHARE: f64 = 0.25;
/// See [`LOST_SHARE`].
pub const FEW_LOSSES: u32 = 4;
/// Largest difference of the time that a contact was lost, as a part of the run.
pub const LOST_TIME_SHARE: f64 = 0.02;

/// A criterion of one model.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    Word(&'static str),
    /// In SI; `None` where the run has none.
    Figure(Option<f64>),
}

/// One criterion in both models.
#[derive(Clone, Debug, PartialEq)]
pub struct Criterion {
    /// Key of its bound, with its unit.
    pub bound: &'static str,
    /// What it is of: the name of a pair or contact; empty of the whole.
    pub of: String,
    pub analytic: Value,
    pub engine: Value,
    /// What is compared with the limit: 0 or 1 of words, otherwise the size of the difference; infinite where one model has none.
    pub difference: f64,
    pub limit: f64,
}

impl Criterion {
    fn word(bound: &'static str, [analytic, engine]: [&'static str; 2]) -> Self {
        let difference = if analytic == engine { 0.0 } else { 1.0 };
        let (analytic, engine) = (Value::Word(analytic), Value::Word(engine));
        Criterion { bound, of: String::new(), analytic, engine, difference, limit: 0.0 }
    }

    fn figure(bound: &'static str, [analytic, engine]: [Option<f64>; 2], limit: f64) -> Self {
        let difference = match (analytic, engine) {
            (Some(analytic), Some(engine)) => (engine - analytic).abs(),
            (None, None) => 0.0,
            _ => f64::INFINITY,
        };
        let (analytic, engine) = (Value::Figure(analytic), Value::Figure(engine));
        Criterion { bound, of: String::new(), analytic, engine, difference, limit }
    }
}

/// The criteria of both runs of a scene; empty where there are none, as of a finger without an object.
pub fn criteria(scene: &Scene, analytic: &Recording, engine: &Recording) -> Vec<Criterion> {
    let runs = [analytic, engine];
    let judged = runs.map(|run| run.judged.as_ref());
    let [Some(ours), Some(theirs)] = judged else { return Vec::new() };
    match scene.kind() {
        SceneKind::Finger => match (&ours.criteria, &theirs.criteria) {
            (Some(ours), Some(theirs)) => finger(scene, ours, theirs),
            _ => Vec::new(),
        },
        SceneKind::Gripper => match (&ours.grasp, &theirs.grasp) {
            (Some(ours), Some(theirs)) => gripper(scene, runs, [ours, theirs]),
            _ => Vec::new(),
        },
        SceneKind::Bodies => {
            let layout = Layout::of(&scene.system);
            let pairs = layout.contacts.iter().zip(ours.rebounds.iter().zip(&theirs.rebounds));
            let restitutions = pairs.map(|(contact, (ours, theirs))| {
                let found = [ours, theirs].map(|rebound| rebound.restitution());
                let restitution = Criterion::figure("restitution", found, scene.bounds.restitution);
                (found, Criterion { of: contact.name.clone(), ..restitution })
            });
            restitutions.filter(|(found, _)| found.iter().any(Option::is_some)).map(|(_, found)| found).collect()
        }
    }
}

fn finger(scene: &Scene, ours: &Criteria, theirs: &Criteria) -> Vec<Criterion> {
    let both = [ours, theirs];
    vec![
        Criterion::word("class", both.map(|found| found.class.name())),
        Criterion::figure("stability_time_s", both.map(|found| found.tts_s), scene.bounds.stability_time_s),
    ]
}

fn gripper(scene: &Scene, runs: [&Recording; 2], both: [&GraspCriteria; 2]) -> Vec<Criterion> {
    let mut all = vec![
        Criterion::word("fate", both.map(|found| found.fate.name())),
        Criterion::figure("stability_time_s", both.map(|found| found.tts_s), scene.bounds.stability_time_s),
    ];
    // Fingers that have let go hold nothing.
    let holds = |found: &GraspCriteria| found.fate == Fate::Held && found.cycle.releases_s.is_none();
    if both.into_iter().all(holds) {
        let closed = runs.map(|run| match is_form_closed(scene, &run.outcome.last) {
            Some(true) => "yes",
            Some(false) => "no",
            None => "undecided",
        });
        all.push(Criterion::word("form_closed", closed));
    }
    let times = both.map(|found| found.contacts.iter().map(|contact| contact.times_lost).sum::<u32>());
    let most = times[0].max(times[1]).max(FEW_LOSSES);
    let lost = Criterion::figure("contacts_lost", times.map(|times| Some(f64::from(times))), LOST_SHARE);
    all.push(Criterion { difference: f64::from(times[0].abs_diff(times[1])) / f64::from(most), ..lost });
    // Of the contact that differs most.
    let contacts = both[0].contacts.iter().zip(&both[1].contacts);
    let apart = contacts.map(|(a, b)| (a.place, [a.lost_s, b.lost_s]));
    let worst = apart.max_by(|(_, [a, b]), (_, [c, d])| (a - b).abs().total_cmp(&(c - d).abs()));
    all.extend(worst.map(|(place, times)| {
        let lost = Criterion::figure("lost_time", times.map(Some), LOST_TIME_SHARE);
        Criterion { of: place.name().to_string(), difference: lost.difference / scene.duration_s, ..lost }
    }));
    all
}

/// Why the criteria of two right runs of a scene may differ, so that they are reported without being judged; `None` where they are
/// judged.
pub fn unjudged(scene: &Scene, reference: &check::Check) -> Option<&'static str> {
    let Scene { bounds, duration_s, .. } = scene;
    if scene.kind() != SceneKind::Bodies && bounds.until_s < *duration_s {
        Some("the runs are not compared to their end")
    } else if reference.verdict == check::Verdict::Chaotic {
        Some("the outcome is chaotic")
    } else if scene.kind() == SceneKind::Finger && bounds.angle_rad >= EPSILON_RAD {
        Some("the bound of the angles is no smaller than the band of 0.2 deg in which the finger is in position")
    } else {
        None
    }
}

/// The criteria as bounds of the verdict: the worst of each kind.
pub fn checks(found: &[Criterion]) -> Vec<Check> {
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
        "class" => "class in both models: 0 the same, 1 another",
        "fate" => "fate of the object in both models: 0 the same, 1 another",
        "form_closed" => "form closure in both models: 0 the same, 1 another",
        "stability_time_s" => "difference of the time to stability",
        "contacts_lost" => "difference of the number of lost contacts, as a part of it",
        "lost_time" => "difference of the time a contact was lost, as a part of the run",
        _ => "largest difference of a coefficient of restitution",
    }
}
