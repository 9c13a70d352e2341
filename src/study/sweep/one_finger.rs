//! One run of a finger: scene, statics, simulation, row.

use super::row::{Cells, Row, Status};
use super::simulate::{NO_SAMPLES, refusal, simulated};
use super::{Filter, Study};
use crate::criteria::{AtRest, Class, Tracker, grasp_at_rest};
use crate::gripper::{SpringKind, total_mass};
use crate::scene::{self, Scene};
use crate::statics::{Equilibrium, form_closure, palm_force_each};
use crate::trace::{Outcome, Site};

/// What is known of a grasp before it is simulated, or why nothing is.
struct Statics {
    grasp: Result<AtRest, String>,
    form_closed: Result<bool, String>,
}

/// Makes one run of a study of fingers, of which `text` is the scene; `None` if it was told to stop.
pub(super) fn of_finger(
    study: &Study,
    run: u64,
    text: &str,
    mut cells: Cells,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Option<Row> {
    let scene = match scene::parse(text, "run.toml") {
        Ok(scene) => Scene { log: scene.log.without_grid(scene.duration_s), ..scene },
        Err(error) => return Some(cells.row(run, Status::Refused, &refusal(&error))),
    };
    let statics = statics(&scene);
    design(&mut cells, &scene, &statics);
    if let Some(reason) = filtered(&study.filter, &statics) {
        return Some(cells.row(run, Status::Filtered, &reason));
    }
    let grasp = statics.grasp.as_ref().ok();
    let tracker = grasp.map(|grasp| Tracker::new(grasp.angles()));
    simulated(study, run, &scene, cells, tracker, go_on, |cells, tracker, outcome| {
        let judged = tracker.as_ref().zip(grasp).map(|(tracker, grasp)| closing(cells, tracker, grasp, outcome));
        if judged == Some(false) { Some(NO_SAMPLES.to_string()) } else { unknown(&statics) }
    })
}

fn statics(scene: &Scene) -> Statics {
    let grasp = grasp_at_rest(scene);
    let closed = |grasp: &AtRest| match form_closure(&scene.finger().linkage, &grasp.end) {
        Ok(found) => Ok(found.closed),
        Err(error) => Err(error.to_string()),
    };
    Statics { form_closed: grasp.as_ref().map_err(String::clone).and_then(closed), grasp }
}

/// What the design is, and what its statics say.
fn design(cells: &mut Cells, scene: &Scene, statics: &Statics) {
    let lengths = &scene.finger().linkage.lengths;
    cells.set("l12_m", lengths.l12_m);
    cells.set("l21_m", lengths.l21_m);
    cells.set("l22_m", lengths.l22_m);
    cells.set("t22_m", lengths.t22_m);
    cells.set("mass_kg", total_mass(&scene.finger().linkage.bodies));
    // The torque that holds the grasp in the end, as in its statics.
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

/// What statics cannot say of a design, so that the row lacks these figures, and the class without a grasp.
fn unknown(statics: &Statics) -> Option<String> {
    let grasp = match &statics.grasp {
        Ok(grasp) => grasp,
        Err(reason) => return Some(reason.clone()),
    };
    let forces = grasp.forces.as_ref().err().map(|error| format!("no static forces: {error}"));
    let closed = statics.form_closed.as_ref().err().map(|error| format!("no form closure: {error}"));
    let reasons: Vec<String> = forces.into_iter().chain(closed).collect();
    (!reasons.is_empty()).then(|| reasons.join("; "))
}

/// What the simulation says of the grasp; `false` if there is nothing to judge.
fn closing(cells: &mut Cells, tracker: &Tracker, grasp: &AtRest, outcome: &Outcome) -> bool {
    let Some(criteria) = tracker.criteria(grasp.static_forces_n()) else { return false };
    cells.set("t_geo_s", criteria.t_geo_s);
    cells.set("tts_s", criteria.tts_s);
    cells.set("rebound_percent", criteria.rebound_percent);
    cells.set("class", criteria.class.name());
    cells.set("class_reason", criteria.class_reason.to_string());
    let forces_n = [outcome.last.contact(Site::Proximal).normal_n, outcome.last.contact(Site::Distal).normal_n];
    cells.set("f21_n", forces_n[0]);
    cells.set("f22_n", forces_n[1]);
    cells.set("pfp_n", palm_force_each(&grasp.end, forces_n, grasp.mu_static));
    cells.set("peak_f21_n", outcome.site(Site::Proximal).peak_normal_n);
    cells.set("peak_f22_n", outcome.site(Site::Distal).peak_normal_n);
    true
}

/// Why a run is not simulated, if so.
fn filtered(filter: &Filter, statics: &Statics) -> Option<String> {
    let forces = statics.grasp.as_ref().map_err(String::clone);
    let forces = forces.and_then(|grasp| grasp.forces.as_ref().map_err(ToString::to_string));
    let tests = [
        ("force positive", filter.force_positive, forces.clone().map(Equilibrium::is_force_positive)),
        ("palm force positive", filter.palm_force_positive, forces.map(Equilibrium::is_palm_force_positive)),
        ("form-closed", filter.form_closed, statics.form_closed.clone()),
    ];
    tests.into_iter().find_map(|(name, wanted, found)| match (wanted?, found) {
        (wanted, Ok(found)) if wanted == found => None,
        (true, Ok(_)) => Some(format!("not {name}")),
        (false, Ok(_)) => Some(name.to_string()),
        (_, Err(reason)) => Some(format!("cannot say whether it is {name}: {reason}")),
    })
}

/// The classes, from good to bad.
pub(super) const CLASSES: [Class; 4] = [Class::Stable, Class::SemiStable, Class::SemiUnstable, Class::Unstable];
