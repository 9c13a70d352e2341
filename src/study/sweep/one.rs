//! One run: scene, statics, simulation, row.

use super::one_gripper::of_gripper;
use super::row::{Cells, Row, Status};
use super::{Filter, Study};
use crate::check::check;
use crate::criteria::{AtRest, Class, Tracker, at_rest};
use crate::gripper::{SpringKind, total_mass};
use crate::scene::words::SceneKind;
use crate::scene::{self, LogRates, Scene, SceneError};
use crate::statics::{Equilibrium, form_closure, palm_force_each};
use crate::table::Value;
use crate::trace::{self, Event, Outcome, RunError, Sample, Sink, SinkError, Site};

/// What is known of a grasp before it is simulated, or why nothing is.
struct Statics {
    grasp: Result<AtRest, String>,
    form_closed: Result<bool, String>,
}

/// Makes one run of a study; `None` if it was told to stop.
pub(super) fn one(study: &Study, run: u64, go_on: &(dyn Fn() -> bool + Sync)) -> Option<Row> {
    let points = study.points(run);
    let text = study.fill(&points);
    let first = [Value::Integer(run as i64), Value::Integer(study.design(run) as i64)];
    let mut cells =
        Cells::new(study.kind, first.into_iter().chain(points.into_iter().map(|point| point.value)).collect());
    if study.kind == SceneKind::Gripper {
        return of_gripper(study, run, &text, cells, go_on);
    }
    let scene = match scene::parse(&text, "run.toml") {
        // The criteria follow the steps: a grid between them would only cost.
        Ok(scene) => Scene { log: LogRates { numeric_hz: 1.0 / scene.duration_s, ..scene.log }, ..scene },
        Err(error) => return Some(cells.row(run, Status::Refused, &refusal(&error))),
    };
    let statics = statics(&scene);
    design(&mut cells, &scene, &statics);
    if let Some(reason) = filtered(&study.filter, &statics) {
        return Some(cells.row(run, Status::Filtered, &reason));
    }
    let grasp = statics.grasp.as_ref().ok();
    let mut watch = Watch { tracker: grasp.map(|grasp| Tracker::new(grasp.angles())), go_on };
    match trace::run(study.model, &scene, &mut watch) {
        Ok(outcome) => {
            if let Some((tracker, grasp)) = watch.tracker.as_ref().zip(grasp) {
                closing(&mut cells, tracker, grasp, &outcome);
            }
            cells.set("steps", outcome.work.steps as i64);
            if study.checked {
                let check = check(study.model, &scene, go_on);
                cells.set("check", check.verdict.name());
                cells.set("check_error_rad", check.errors.path);
            }
            // A check that was broken off is not one.
            go_on().then(|| cells.row(run, Status::Completed, ""))
        }
        Err(error) => unfinished(cells, run, error),
    }
}

/// The row of a run that did not get to its end; `None` if it was told to stop.
pub(super) fn unfinished(mut cells: Cells, run: u64, error: RunError) -> Option<Row> {
    if error.is_stop() {
        return None;
    }
    let reason = match error {
        RunError::Simulation { failure, so_far } => {
            cells.set("steps", so_far.work.steps as i64);
            format!("at {:.6} ms: {}", failure.time_s * 1e3, failure.reason)
        }
        RunError::Sink(error) => error.to_string(),
    };
    Some(cells.row(run, Status::Failed, &reason))
}

/// What is wrong with a scene, in one line: its place would be one in a text that nobody wrote.
pub(super) fn refusal(error: &SceneError) -> String {
    let messages: Vec<&str> = error.problems().iter().map(|problem| problem.message.as_str()).collect();
    if messages.is_empty() { error.to_string() } else { messages.join("; ") }
}

fn statics(scene: &Scene) -> Statics {
    let object = scene.object.ok_or_else(|| "there is no object".to_string());
    let grasp = object.and_then(|object| at_rest(scene, object).map_err(|error| error.to_string()));
    let closed = |grasp: &AtRest| match form_closure(&scene.finger, &grasp.end) {
        Ok(found) => Ok(found.closed),
        Err(error) => Err(error.to_string()),
    };
    Statics { form_closed: grasp.as_ref().map_err(String::clone).and_then(closed), grasp }
}

/// What the design is, and what its statics say.
fn design(cells: &mut Cells, scene: &Scene, statics: &Statics) {
    let lengths = &scene.finger.lengths;
    cells.set("l12_m", lengths.l12_m);
    cells.set("l21_m", lengths.l21_m);
    cells.set("l22_m", lengths.l22_m);
    cells.set("t22_m", lengths.t22_m);
    cells.set("mass_kg", total_mass(&scene.finger.bodies));
    // The torque that holds the grasp in the end, as in its statics.
    cells.set("motor_n_m", scene::torque(&scene.actuation, scene.duration_s).0);
    if let Some(SpringKind::Constant { torque_n_m }) = scene.spring.map(|spring| spring.kind) {
        cells.set("spring_n_m", torque_n_m);
    }
    if let Ok(grasp) = &statics.grasp {
        cells.set("trajectory_rad", grasp.end.posture.q11_rad - scene.initial.q11_rad);
        if let Ok(forces) = &grasp.forces {
            cells.set("static_f21_n", forces.f21_n);
            cells.set("static_f22_n", forces.f22_n);
            cells.set("static_pfp_n", forces.pfp_n);
            cells.set("force_positive", forces.is_force_positive());
        }
    }
    cells.set("form_closed", statics.form_closed.as_ref().ok().copied());
}

/// What the simulation says of the grasp.
fn closing(cells: &mut Cells, tracker: &Tracker, grasp: &AtRest, outcome: &Outcome) {
    let criteria = tracker.criteria(grasp.is_stable());
    cells.set("t_geo_s", criteria.t_geo_s);
    cells.set("tts_s", criteria.tts_s);
    cells.set("rebound_percent", criteria.rebound_percent);
    cells.set("class", criteria.class.name());
    let forces_n = [outcome.last.contact(Site::Proximal).normal_n, outcome.last.contact(Site::Distal).normal_n];
    cells.set("f21_n", forces_n[0]);
    cells.set("f22_n", forces_n[1]);
    cells.set("pfp_n", palm_force_each(&grasp.end, forces_n, grasp.mu_static));
    cells.set("peak_f21_n", outcome.site(Site::Proximal).peak_normal_n);
    cells.set("peak_f22_n", outcome.site(Site::Distal).peak_normal_n);
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

/// Listens to a run: its criteria, and whether it may go on.
struct Watch<'a> {
    tracker: Option<Tracker>,
    go_on: &'a (dyn Fn() -> bool + Sync),
}

impl Sink for Watch<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.tracker.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.tracker.event(event)
    }

    fn proceed(&self) -> bool {
        (self.go_on)()
    }
}

/// The classes, from good to bad.
pub(super) const CLASSES: [Class; 4] = [Class::Stable, Class::SemiStable, Class::SemiUnstable, Class::Unstable];
