//! Comparison of measured differences and of the criteria of both runs with the bounds of the scene.

use serde::Serialize;

use super::{Differences, MAX_STANDARD_ERRORS, Recording, Statistics, largest};
use crate::check;
use crate::criteria::{Criteria, EPSILON_RAD, Fate, ObjectCriteria, Rebound, firmness};
use crate::invariants::Finding;
use crate::scene::{Bounds, Scene};
use crate::trace::Schema;

/// Largest allowed error of the reference, as a fraction of the largest allowed error of the engine.
pub(crate) const MAX_REFERENCE_ERROR_SHARE: f64 = 0.1;
/// Bounds that do not depend on the engine. If one fails, the analytic model is not a valid reference.
pub(crate) const REFERENCE_BOUNDS: [&str; 2] = ["reference", "analytic_invariants"];
/// Largest difference of the number of lost contacts, as a fraction of the larger number or of [`MIN_LOSS_SCALE`],
/// whichever is larger. A difference of one always passes; a difference of two in four fails.
pub(crate) const MAX_LOST_CONTACTS_DIFFERENCE: f64 = 0.25;
/// Smallest denominator of [`MAX_LOST_CONTACTS_DIFFERENCE`].
pub(crate) const MIN_LOSS_SCALE: u32 = 4;
/// Largest difference of the time during which a contact is lost, as a fraction of the duration.
pub(crate) const MAX_LOST_TIME_DIFFERENCE: f64 = 0.02;

/// One bound and the measured value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Check {
    /// The key of the bound, with its unit.
    pub bound: &'static str,
    /// Description of the measured quantity.
    pub meaning: &'static str,
    /// Measured value. `None` if the scene does not have the quantity; infinite if only one of the models has it.
    pub measured: Option<f64>,
    pub limit: f64,
    /// Whether the bound holds. It always holds for a quantity that the scene does not have.
    pub passed: bool,
}

impl Check {
    fn new(bound: &'static str, meaning: &'static str, measured: Option<f64>, limit: f64) -> Self {
        Check { bound, meaning, measured, limit, passed: measured.is_none_or(|measured| measured <= limit) }
    }
}

/// The verdict: all bounds with their measured values.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Verdict {
    pub checks: Vec<Check>,
}

impl Verdict {
    /// Whether every bound holds.
    pub fn passed(&self) -> bool {
        self.checks.iter().all(|check| check.passed)
    }

    /// Whether at least one of these bounds fails.
    pub fn fails(&self, bounds: &[&str]) -> bool {
        self.checks.iter().any(|check| bounds.contains(&check.bound) && !check.passed)
    }
}

/// Judges the differences of the engine with the settings of the scene: angles and positions, and the final forces of
/// fingers or the peak forces of mechanisms.
pub fn check_bounds(found: &Differences, bounds: &Bounds) -> Verdict {
    let (has_fingers, has_bodies) = (found.has_fingers(), !found.turn.is_empty());
    let [angle, position, impulse] = match has_fingers {
        true => [
            "largest difference of a joint angle",
            "largest position difference of the object",
            "relative difference of the impulse of an impact",
        ],
        false => [
            "largest difference of the angle of a body",
            "largest position difference of a body",
            "relative difference of the impulse of a pair",
        ],
    };
    let contact_time = "largest difference of a first contact";
    let final_force = "relative difference of a normal force at the end";
    let peak_force = "relative difference of a largest normal force";
    let all = [
        (true, "angle_rad", angle, Some(found.angle_max()), bounds.angle_rad),
        (has_bodies, "position_m", position, Some(found.centre_max()), bounds.position_m),
        (true, "contact_time_s", contact_time, largest(&found.contact_time_s), bounds.contact_time_s),
        (has_fingers, "final_force", final_force, largest(&found.final_force), bounds.final_force),
        (true, "impulse", impulse, largest(&found.impulse), bounds.impulse),
        (!has_fingers, "peak_force", peak_force, largest(&found.peak_force), bounds.peak_force),
        (true, "loop_gap_m", "largest opening of a joint", Some(found.loop_gap_m), bounds.loop_gap_m),
    ];
    let checks = all.into_iter().filter(|(is_applicable, ..)| *is_applicable);
    let check = |(_, bound, meaning, measured, limit)| Check::new(bound, meaning, measured, limit);
    Verdict { checks: checks.map(check).collect() }
}

/// What a verdict is based on besides the differences of the engine.
pub(super) struct Evidence<'a> {
    pub reference_check: &'a check::Check,
    /// Largest allowed error of the engine, in the unit of the check of the reference.
    pub path_bound: f64,
    /// Criteria of the two runs; empty if they are not judged.
    pub criteria: &'a [Criterion],
    pub reference_invariants: &'a [Finding],
    pub engine_invariants: &'a [Finding],
    pub statistics: Option<&'a Statistics>,
}

/// Judges the differences of the engine and the evidence. The error of the reference is limited to a fraction of that
/// of the engine; a reference that could not be checked fails.
pub(super) fn judge(found: &Differences, bounds: &Bounds, evidence: &Evidence) -> Verdict {
    let worst = |found: &[Finding]| found.iter().map(Finding::ratio_to_limit).fold(0.0, f64::max);
    let reference = match evidence.reference_check.verdict {
        check::Verdict::Unknown => f64::INFINITY,
        _ => evidence.reference_check.errors.path / evidence.path_bound,
    };
    let of_reference = "difference of the reference from another method, as a fraction of the bound of the engine";
    let of_invariants = "worst invariant, as a fraction of its limit";
    let of_statistics = "largest difference of a mean over many runs, in standard errors";
    let mut checks = check_bounds(found, bounds).checks;
    checks.extend(criteria_checks(evidence.criteria));
    checks.extend([
        Check::new("reference", of_reference, Some(reference), MAX_REFERENCE_ERROR_SHARE),
        Check::new("analytic_invariants", of_invariants, Some(worst(evidence.reference_invariants)), 1.0),
        Check::new("engine_invariants", of_invariants, Some(worst(evidence.engine_invariants)), 1.0),
    ]);
    let statistics = evidence.statistics.map(Statistics::worst);
    checks.extend(statistics.map(|worst| Check::new("statistics", of_statistics, Some(worst), MAX_STANDARD_ERRORS)));
    Verdict { checks }
}

/// A criterion that both models must agree on.
pub(crate) struct CriterionKind {
    /// Key of the bound of the criterion, with its unit.
    pub bound: &'static str,
    pub meaning: &'static str,
    /// Name in tables, with the displayed unit.
    pub label: &'static str,
    /// Factor from SI units to the displayed unit.
    pub scale: f64,
    pub digits: usize,
}

/// All criteria, in the order of their bounds in a verdict.
pub(crate) const CRITERIA: [CriterionKind; 8] = [
    kind("class", "class in both models: 0 equal, 1 different", ("class", 1.0, 5)),
    kind("fate", "fate of the object in both models: 0 equal, 1 different", ("fate", 1.0, 5)),
    kind("stability_time_s", "difference of the time to stability", ("time to stability, ms", 1e3, 8)),
    kind(
        "fate_time_s",
        "difference of the time at which the object was released, was lost or left the hand",
        ("lost at, ms", 1e3, 8),
    ),
    kind("form_closed", "form closure in both models: 0 equal, 1 different", ("form-closed", 1.0, 1)),
    kind("contacts_lost", "relative difference of the number of lost contacts", ("contacts lost", 1.0, 6)),
    kind(
        "lost_time",
        "difference of the time during which a contact is lost, as a fraction of the duration",
        ("lost for, ms", 1e3, 5),
    ),
    kind("restitution", "largest difference of a coefficient of restitution", ("restitution", 1.0, 5)),
];

const fn kind(
    bound: &'static str,
    meaning: &'static str,
    (label, scale, digits): (&'static str, f64, usize),
) -> CriterionKind {
    CriterionKind { bound, meaning, label, scale, digits }
}

/// The value of a criterion in one model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Value {
    Label(&'static str),
    /// Number in SI units; `None` if the run does not have the quantity.
    Number(Option<f64>),
}

/// One criterion in both models.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Criterion {
    /// Key of the bound of the criterion, with its unit.
    #[serde(rename = "criterion")]
    pub bound: &'static str,
    /// Name of the pair or contact; `None` for criteria of the whole scene.
    #[serde(rename = "of")]
    pub subject: Option<String>,
    pub analytic: Value,
    pub engine: Value,
    /// Difference that is compared with the limit: 0 or 1 for labels, otherwise the absolute difference. Infinite if
    /// only one model has a value.
    pub difference: f64,
    pub limit: f64,
}

impl Criterion {
    fn from_labels(bound: &'static str, [analytic, engine]: [&'static str; 2]) -> Self {
        let difference = if analytic == engine { 0.0 } else { 1.0 };
        let (analytic, engine) = (Value::Label(analytic), Value::Label(engine));
        Criterion { bound, subject: None, analytic, engine, difference, limit: 0.0 }
    }

    fn from_numbers(bound: &'static str, [analytic, engine]: [Option<f64>; 2], limit: f64) -> Self {
        let difference = match (analytic, engine) {
            (Some(analytic), Some(engine)) => (engine - analytic).abs(),
            (None, None) => 0.0,
            _ => f64::INFINITY,
        };
        let (analytic, engine) = (Value::Number(analytic), Value::Number(engine));
        Criterion { bound, subject: None, analytic, engine, difference, limit }
    }
}

/// Compares the criteria of the two runs of a scene; empty if there are none, as for a finger without an object.
pub fn compare_criteria(scene: &Scene, analytic: &Recording, engine: &Recording) -> Vec<Criterion> {
    let (Some(analytic), Some(engine)) = (&analytic.run_criteria, &engine.run_criteria) else { return Vec::new() };
    match (&analytic.criteria, &engine.criteria, &analytic.grasp, &engine.grasp) {
        (Some(analytic), Some(engine), ..) => compare_finger(scene, [analytic, engine]),
        (.., Some(analytic), Some(engine)) => compare_grasps(scene, [analytic, engine]),
        _ => {
            let schema = Schema::from_scene(scene);
            let contacts = schema.contacts.into_iter().zip(analytic.rebounds.iter().zip(&engine.rebounds));
            let restitutions = contacts.filter_map(|(contact, (analytic, engine))| {
                let values = [analytic, engine].map(Rebound::restitution);
                let found = Criterion::from_numbers("restitution", values, scene.bounds.restitution);
                let has_value = values.iter().any(Option::is_some);
                has_value.then_some(Criterion { subject: Some(contact.name), ..found })
            });
            restitutions.collect()
        }
    }
}

fn compare_finger(scene: &Scene, both: [&Criteria; 2]) -> Vec<Criterion> {
    vec![
        Criterion::from_labels("class", both.map(|found| found.class.name())),
        Criterion::from_numbers("stability_time_s", both.map(|found| found.tts_s), scene.bounds.stability_time_s),
    ]
}

/// Compares the grasps of an object.
fn compare_grasps(scene: &Scene, both: [&ObjectCriteria; 2]) -> Vec<Criterion> {
    let limit_s = scene.bounds.stability_time_s;
    let mut compared = vec![
        Criterion::from_labels("fate", both.map(|found| found.fate.name())),
        Criterion::from_numbers("stability_time_s", both.map(|found| found.tts_s), limit_s),
    ];
    let lost_at_s = both.map(|found| found.fate.lost_at_s());
    if lost_at_s.iter().any(Option::is_some) {
        compared.push(Criterion::from_numbers("fate_time_s", lost_at_s, limit_s));
    }
    if both.into_iter().all(|found| matches!(found.fate, Fate::Held | Fate::Carried)) {
        let form_closed = both.map(|found| match firmness(scene, found).and_then(|firmness| firmness.form_closed) {
            Some(true) => "yes",
            Some(false) => "no",
            None => "undecided",
        });
        compared.push(Criterion::from_labels("form_closed", form_closed));
    }
    let pairs = both[0].pairs.iter().zip(&both[1].pairs);
    let lost_times = pairs.map(|(a, b)| (a.name.clone(), [a.lost_s, b.lost_s]));
    compared.extend(compare_losses(scene, both.map(ObjectCriteria::contacts_lost), lost_times));
    compared
}

/// Compares the numbers of losses, and the time for which the contact with the largest difference was lost.
fn compare_losses(
    scene: &Scene,
    losses: [u32; 2],
    lost_times: impl Iterator<Item = (String, [f64; 2])>,
) -> Vec<Criterion> {
    let scale = losses[0].max(losses[1]).max(MIN_LOSS_SCALE);
    let counts = losses.map(|count| Some(f64::from(count)));
    let lost = Criterion::from_numbers("contacts_lost", counts, MAX_LOST_CONTACTS_DIFFERENCE);
    let count = Criterion { difference: f64::from(losses[0].abs_diff(losses[1])) / f64::from(scale), ..lost };
    let worst = lost_times.max_by(|(_, [a, b]), (_, [c, d])| (a - b).abs().total_cmp(&(c - d).abs()));
    let time = worst.map(|(contact, times)| {
        let lost = Criterion::from_numbers("lost_time", times.map(Some), MAX_LOST_TIME_DIFFERENCE);
        let subject = Some(contact);
        Criterion { subject, difference: lost.difference / scene.duration_s, ..lost }
    });
    std::iter::once(count).chain(time).collect()
}

/// Returns the reason why the criteria of two accurate runs of a scene may differ. They are then reported without being
/// judged. `None` if they are judged.
pub fn reason_not_judged(scene: &Scene, reference: &check::Check) -> Option<&'static str> {
    let Scene { bounds, duration_s, .. } = scene;
    if scene.has_joints() && bounds.until_s < *duration_s {
        Some("the runs are not compared to their end")
    } else if reference.verdict == check::Verdict::Chaotic {
        Some("the outcome is chaotic")
    } else if scene.finger_count() == 1 && bounds.angle_rad >= EPSILON_RAD {
        Some("the bound of the angles is not below the 0.2 deg band in which the finger counts as in position")
    } else {
        None
    }
}

/// Returns the criteria as bounds of the verdict: for each kind, the worst criterion.
pub fn criteria_checks(found: &[Criterion]) -> Vec<Check> {
    let check = |&CriterionKind { bound, meaning, .. }: &CriterionKind| {
        let of_bound = found.iter().filter(|criterion| criterion.bound == bound);
        let limit = of_bound.clone().next()?.limit;
        Some(Check::new(bound, meaning, of_bound.map(|criterion| criterion.difference).reduce(f64::max), limit))
    };
    CRITERIA.iter().filter_map(check).collect()
}
