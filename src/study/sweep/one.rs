//! One run: scene, statics, simulation, row.

use super::row::{Cells, Row, Status};
use super::{Filter, Study};
use crate::criteria::{AtRest, Class, Tracker, at_rest};
use crate::gripper::{SpringKind, total_mass};
use crate::scene::{self, LogRates, Scene, SceneError};
use crate::statics::{Equilibrium, StaticsError, form_closure, palm_force_each};
use crate::table::Value;
use crate::trace::{self, Event, RunError, Sample, Sink, SinkError, Site};

/// What is known of a grasp before it is simulated, or why nothing is.
type Known = Result<(AtRest, Result<bool, StaticsError>), String>;

/// Makes one run of a study; `None` if it was told to stop.
pub(super) fn one(study: &Study, run: u64, go_on: &(dyn Fn() -> bool + Sync)) -> Option<Row> {
    let points = study.points(run);
    let text = study.fill(&points);
    let first = [Value::Integer(run as i64), Value::Integer(study.design(run) as i64)];
    let mut cells = Cells::new(first.into_iter().chain(points.into_iter().map(|point| point.value)).collect());
    let scene = match scene::parse(&text, "run.toml") {
        // The criteria follow the steps: a grid between them would only cost.
        Ok(scene) => Scene { log: LogRates { numeric_hz: 1.0 / scene.duration_s, ..scene.log }, ..scene },
        Err(error) => return Some(cells.row(run, Status::Refused, &refusal(&error))),
    };
    let known = known(&scene);
    design(&mut cells, &scene, &known);
    if let Some(reason) = filtered(&study.filter, &known) {
        return Some(cells.row(run, Status::Filtered, &reason));
    }
    let grasp = known.as_ref().ok().map(|(at_rest, _)| at_rest);
    let mut watch = Watch { tracker: grasp.map(|grasp| Tracker::new(grasp.angles())), go_on };
    match trace::run(study.model, &scene, &mut watch) {
        Ok(outcome) => {
            if let Some((tracker, grasp)) = watch.tracker.as_ref().zip(grasp) {
                let criteria = tracker.criteria(grasp.is_stable());
                cells.set("t_geo_s", criteria.t_geo_s);
                cells.set("tts_s", criteria.tts_s);
                cells.set("rebound_percent", criteria.rebound_percent);
                cells.set("class", criteria.class.name());
            }
            if scene.object.is_some() {
                let [f21_n, f22_n] = [outcome.last.proximal.normal_n, outcome.last.distal.normal_n];
                cells.set("f21_n", f21_n);
                cells.set("f22_n", f22_n);
                if let Some(grasp) = grasp {
                    cells.set("pfp_n", palm_force_each(&grasp.end, [f21_n, f22_n], grasp.mu_static));
                }
                cells.set("peak_f21_n", outcome.site(Site::Proximal).peak_normal_n);
                cells.set("peak_f22_n", outcome.site(Site::Distal).peak_normal_n);
            }
            cells.set("steps", outcome.work.steps as i64);
            Some(cells.row(run, Status::Completed, ""))
        }
        Err(error) if error.is_stop() => None,
        Err(RunError::Simulation { failure, so_far }) => {
            cells.set("steps", so_far.work.steps as i64);
            let reason = format!("at {:.6} ms: {}", failure.time_s * 1e3, failure.reason);
            Some(cells.row(run, Status::Failed, &reason))
        }
        Err(RunError::Sink(error)) => Some(cells.row(run, Status::Failed, &error.to_string())),
    }
}

/// What is wrong with a scene, in one line: its place would be one in a text that nobody wrote.
fn refusal(error: &SceneError) -> String {
    let messages: Vec<&str> = error.problems().iter().map(|problem| problem.message.as_str()).collect();
    if messages.is_empty() { error.to_string() } else { messages.join("; ") }
}

/// The grasp at rest, and whether it is form-closed.
fn known(scene: &Scene) -> Known {
    let object = scene.object.ok_or_else(|| "there is no object".to_string())?;
    let at_rest = at_rest(scene, object).map_err(|error| error.to_string())?;
    let closed = form_closure(&scene.finger, &at_rest.end).map(|found| found.closed);
    Ok((at_rest, closed))
}

/// What the design is, and what its statics say.
fn design(cells: &mut Cells, scene: &Scene, known: &Known) {
    let lengths = &scene.finger.lengths;
    cells.set("l12_m", lengths.l12_m);
    cells.set("l21_m", lengths.l21_m);
    cells.set("l22_m", lengths.l22_m);
    cells.set("t22_m", lengths.t22_m);
    cells.set("mass_kg", total_mass(&scene.finger.bodies));
    cells.set("motor_n_m", scene::torque(&scene.actuation, scene.duration_s).0);
    if let Some(SpringKind::Constant { torque_n_m }) = scene.spring.map(|spring| spring.kind) {
        cells.set("spring_n_m", torque_n_m);
    }
    let Ok((grasp, closed)) = known else { return };
    cells.set("trajectory_rad", grasp.end.posture.q11_rad - scene.initial.q11_rad);
    if let Ok(forces) = &grasp.forces {
        cells.set("static_f21_n", forces.f21_n);
        cells.set("static_f22_n", forces.f22_n);
        cells.set("static_pfp_n", forces.pfp_n);
        cells.set("force_positive", forces.is_force_positive());
    }
    if let Ok(closed) = closed {
        cells.set("form_closed", *closed);
    }
}

/// Why a run is not simulated, if so.
fn filtered(filter: &Filter, known: &Known) -> Option<String> {
    let known = known.as_ref();
    let forces =
        known.map_err(String::clone).and_then(|(grasp, _)| grasp.forces.as_ref().map_err(StaticsError::to_string));
    let closed =
        known.map_err(String::clone).and_then(|(_, closed)| closed.as_ref().copied().map_err(StaticsError::to_string));
    let tests = [
        ("force positive", filter.force_positive, forces.clone().map(Equilibrium::is_force_positive)),
        ("palm force positive", filter.palm_force_positive, forces.map(Equilibrium::is_palm_force_positive)),
        ("form-closed", filter.form_closed, closed),
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

/// Names of the classes, from good to bad.
pub(super) const CLASSES: [Class; 4] = [Class::Stable, Class::SemiStable, Class::SemiUnstable, Class::Unstable];
