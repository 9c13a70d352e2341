//! One run: scene, statics, simulation, row.

use super::row::{Cells, Row, Status};
use super::{Filter, Study};
use crate::criteria::{Class, FinalAngles, Tracker};
use crate::gripper::{Circle, FinalPosture, SpringKind, final_posture, total_mass};
use crate::scene::{self, Scene, SceneError};
use crate::statics::{Equilibrium, drive_loads, equilibrium, form_closure, palm_force};
use crate::table::Value;
use crate::trace::{self, Event, RunError, Sample, Sink, SinkError, Site};

/// What is known of a grasp before it is simulated.
struct AtRest {
    end: Result<FinalPosture, String>,
    equilibrium: Result<Equilibrium, String>,
    form_closed: Result<bool, String>,
    /// Of the proximal contact.
    mu_static: f64,
}

/// Makes one run of a study; `None` if it was told to stop.
pub(super) fn one(study: &Study, run: u64, go_on: &(dyn Fn() -> bool + Sync)) -> Option<Row> {
    let points = study.points(run);
    let text = study.fill(&points);
    let first = [Value::Integer(run as i64), Value::Integer(study.design(run) as i64)];
    let mut cells = Cells::new(first.into_iter().chain(points.into_iter().map(|point| point.value)).collect());
    let scene = match scene::parse(&text, "run.toml") {
        Ok(scene) => scene,
        Err(error) => return Some(cells.row(run, Status::Refused, &refusal(&error))),
    };
    let at_rest = at_rest(&scene);
    design(&mut cells, &scene, &at_rest);
    if let Some(reason) = filtered(&study.filter, &at_rest) {
        return Some(cells.row(run, Status::Filtered, &reason));
    }
    let angles =
        at_rest.end.as_ref().ok().map(|end| FinalAngles { q11_rad: end.posture.q11_rad, q21_rad: end.posture.q21_rad });
    let mut watch = Watch { tracker: angles.map(Tracker::new), go_on };
    match trace::run(study.model, &scene, &mut watch) {
        Ok(outcome) => {
            if let Some(tracker) = &watch.tracker {
                // Where statics say nothing, nothing speaks against what is seen to hold.
                let stable = at_rest.equilibrium.as_ref().map_or(true, Equilibrium::is_force_positive);
                let criteria = tracker.criteria(stable);
                cells.set("t_geo_s", criteria.t_geo_s);
                cells.set("tts_s", criteria.tts_s);
                cells.set("rebound_percent", criteria.rebound_percent);
                cells.set("class", criteria.class.name());
            }
            if scene.object.is_some() {
                let [f21_n, f22_n] = [outcome.last.proximal.normal_n, outcome.last.distal.normal_n];
                cells.set("f21_n", f21_n);
                cells.set("f22_n", f22_n);
                if let Ok(end) = &at_rest.end {
                    cells.set("pfp_n", palm_force(end, f21_n, f22_n, at_rest.mu_static));
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

fn at_rest(scene: &Scene) -> AtRest {
    let mu_static = scene.contact.proximal.friction.map_or(0.0, |law| law.mu_static);
    let end = scene.object.ok_or_else(|| "there is no object".to_string()).and_then(|object| {
        let disc = Circle { radius_m: object.radius_m, centre_m: object.centre_m };
        final_posture(&scene.finger.lengths, scene.finger.assembly, disc).map_err(|error| error.to_string())
    });
    // With the torque that holds the grasp in the end.
    let motor_n_m = scene::torque(&scene.actuation, scene.duration_s).0;
    let forces = |end: &FinalPosture| {
        let loads = drive_loads(&scene.finger, end, motor_n_m, scene.spring.as_ref())?;
        equilibrium(&scene.finger, end, loads, mu_static)
    };
    AtRest {
        equilibrium: end.as_ref().map_err(String::clone).and_then(|end| forces(end).map_err(|error| error.to_string())),
        form_closed: end.as_ref().map_err(String::clone).and_then(|end| {
            form_closure(&scene.finger, end).map(|found| found.closed).map_err(|error| error.to_string())
        }),
        end,
        mu_static,
    }
}

/// What the design is, and what its statics say.
fn design(cells: &mut Cells, scene: &Scene, at_rest: &AtRest) {
    let lengths = &scene.finger.lengths;
    cells.set("l12_m", lengths.l12_m);
    cells.set("l21_m", lengths.l21_m);
    cells.set("l22_m", lengths.l22_m);
    cells.set("t22_m", lengths.t22_m);
    cells.set("mass_kg", total_mass(&scene.finger.bodies));
    if let Ok(end) = &at_rest.end {
        cells.set("trajectory_rad", end.posture.q11_rad - scene.initial.q11_rad);
    }
    cells.set("motor_n_m", scene::torque(&scene.actuation, scene.duration_s).0);
    if let Some(SpringKind::Constant { torque_n_m }) = scene.spring.map(|spring| spring.kind) {
        cells.set("spring_n_m", torque_n_m);
    }
    if let Ok(forces) = &at_rest.equilibrium {
        cells.set("static_f21_n", forces.f21_n);
        cells.set("static_f22_n", forces.f22_n);
        cells.set("static_pfp_n", forces.pfp_n);
        cells.set("force_positive", forces.is_force_positive());
    }
    if let Ok(closed) = at_rest.form_closed {
        cells.set("form_closed", closed);
    }
}

/// Why a run is not simulated, if so.
fn filtered(filter: &Filter, at_rest: &AtRest) -> Option<String> {
    let forces = at_rest.equilibrium.as_ref();
    let tests = [
        ("force positive", filter.force_positive, forces.map(Equilibrium::is_force_positive)),
        ("palm force positive", filter.palm_force_positive, forces.map(Equilibrium::is_palm_force_positive)),
        ("form-closed", filter.form_closed, at_rest.form_closed.as_ref().copied()),
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
