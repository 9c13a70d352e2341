//! A single run of a finger: scene, statics, simulation, row.

use super::row::{Cells, Row, Status};
use super::simulate::{NO_SAMPLES, problem_messages, simulate_row};
use super::{Filter, Study};
use crate::criteria::{Class, StaticGrasp, Tracker, scene_static_grasp};
use crate::gripper::{SpringKind, total_mass};
use crate::scene::{self, Scene};
use crate::statics::{Equilibrium, form_closure, palm_force_with_mu};
use crate::trace::{FingerContact, Outcome};

/// Statics of a grasp, or the reasons why they cannot be computed.
struct Statics {
    grasp: Result<StaticGrasp, String>,
    form_closed: Result<bool, String>,
}

/// Makes one run of a study of fingers from the text of its scene; `None` if it was interrupted.
pub(super) fn run_finger(
    study: &Study,
    run: u64,
    text: &str,
    mut cells: Cells,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Option<Row> {
    let scene = match scene::parse(text, "run.toml") {
        Ok(scene) => Scene { log: scene.log.without_sample_grid(scene.duration_s), ..scene },
        Err(error) => return Some(cells.row(run, Status::Refused, &problem_messages(&error))),
    };
    let statics = compute_statics(&scene);
    set_design(&mut cells, &scene, &statics);
    if let Some(reason) = filter_reason(&study.filter, &statics) {
        return Some(cells.row(run, Status::Filtered, &reason));
    }
    let grasp = statics.grasp.as_ref().ok();
    let tracker = grasp.map(|grasp| Tracker::new(grasp.final_angles()));
    simulate_row(study, run, &scene, cells, tracker, keep_running, |cells, tracker, outcome| {
        let has_samples =
            tracker.as_ref().zip(grasp).map(|(tracker, grasp)| set_results(cells, tracker, grasp, outcome));
        if has_samples == Some(false) { Some(NO_SAMPLES.to_string()) } else { missing_statics_reason(&statics) }
    })
}

fn compute_statics(scene: &Scene) -> Statics {
    let grasp = scene_static_grasp(scene);
    let is_closed = |grasp: &StaticGrasp| match form_closure(&scene.finger().linkage, &grasp.end) {
        Ok(closure) => Ok(closure.closed),
        Err(error) => Err(error.to_string()),
    };
    Statics { form_closed: grasp.as_ref().map_err(String::clone).and_then(is_closed), grasp }
}

/// Sets the cells of the design and its statics.
fn set_design(cells: &mut Cells, scene: &Scene, statics: &Statics) {
    let lengths = &scene.finger().linkage.lengths;
    cells.set("l12_m", lengths.l12_m);
    cells.set("l21_m", lengths.l21_m);
    cells.set("l22_m", lengths.l22_m);
    cells.set("t22_m", lengths.t22_m);
    cells.set("mass_kg", total_mass(&scene.finger().linkage.bodies));
    // Like the static analysis, this uses the torque at the end of the run.
    cells.set("motor_n_m", scene::torque(&scene.finger().motor.actuation, scene.duration_s).0);
    if let Some(SpringKind::Constant { torque_n_m }) = scene.finger().spring.map(|spring| spring.kind) {
        cells.set("spring_n_m", torque_n_m);
    }
    if let Ok(grasp) = &statics.grasp {
        cells.set("trajectory_rad", grasp.end.posture.q11_rad - scene.finger().initial.q11_rad);
        if let Ok(forces) = &grasp.forces {
            cells.set("static_f21_n", forces.f21_n);
            cells.set("static_f22_n", forces.f22_n);
            cells.set("static_pfp_n", forces.pfp_n);
            cells.set("force_positive", forces.is_force_positive());
        }
    }
    cells.set("form_closed", statics.form_closed.as_ref().ok().copied());
}

/// Reasons for missing static figures, and for a missing class if there is no grasp.
fn missing_statics_reason(statics: &Statics) -> Option<String> {
    let grasp = match &statics.grasp {
        Ok(grasp) => grasp,
        Err(reason) => return Some(reason.clone()),
    };
    let forces = grasp.forces.as_ref().err().map(|error| format!("no static forces: {error}"));
    let form_closure = statics.form_closed.as_ref().err().map(|error| format!("no form closure: {error}"));
    let reasons: Vec<String> = forces.into_iter().chain(form_closure).collect();
    (!reasons.is_empty()).then(|| reasons.join("; "))
}

/// Sets the cells of the simulation; `false` if it has no samples.
fn set_results(cells: &mut Cells, tracker: &Tracker, grasp: &StaticGrasp, outcome: &Outcome) -> bool {
    let Some(criteria) = tracker.criteria(grasp.static_forces_n()) else { return false };
    cells.set("t_geo_s", criteria.t_geo_s);
    cells.set("tts_s", criteria.tts_s);
    cells.set("rebound_percent", criteria.rebound_percent);
    cells.set("class", criteria.class.name());
    cells.set("class_reason", criteria.class_reason.to_string());
    let forces_n =
        [outcome.last.contact(FingerContact::Proximal).normal_n, outcome.last.contact(FingerContact::Distal).normal_n];
    cells.set("f21_n", forces_n[0]);
    cells.set("f22_n", forces_n[1]);
    cells.set("pfp_n", palm_force_with_mu(&grasp.end, forces_n, grasp.mu_static));
    cells.set("peak_f21_n", outcome.finger_contact(FingerContact::Proximal).peak_normal_n);
    cells.set("peak_f22_n", outcome.finger_contact(FingerContact::Distal).peak_normal_n);
    true
}

/// Returns the reason why the filter excludes a run, if it does.
fn filter_reason(filter: &Filter, statics: &Statics) -> Option<String> {
    let forces = statics.grasp.as_ref().map_err(String::clone);
    let forces = forces.and_then(|grasp| grasp.forces.as_ref().map_err(ToString::to_string));
    let tests = [
        ("force positive", filter.force_positive, forces.clone().map(Equilibrium::is_force_positive)),
        ("palm force positive", filter.palm_force_positive, forces.map(Equilibrium::is_palm_force_positive)),
        ("form-closed", filter.form_closed, statics.form_closed.clone()),
    ];
    tests.into_iter().find_map(|(name, required, actual)| match (required?, actual) {
        (required, Ok(actual)) if required == actual => None,
        (true, Ok(_)) => Some(format!("not {name}")),
        (false, Ok(_)) => Some(name.to_string()),
        (_, Err(reason)) => Some(format!("cannot determine whether it is {name}: {reason}")),
    })
}

/// Dynamic classes from best to worst.
pub(super) const CLASSES: [Class; 4] = [Class::Stable, Class::SemiStable, Class::SemiUnstable, Class::Unstable];
