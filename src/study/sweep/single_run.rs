//! A single run of a finger or a gripper: scene, statics, simulation, row.

use super::row::{Cells, Row, Status};
use super::{Filter, Study};
use crate::check::check;
use crate::criteria::{
    Fate, GraspCriteria, GraspTracker, LinkOverlaps, StaticGrasp, Tracker, is_form_closed, scene_static_grasp,
};
use crate::gripper::{SpringKind, total_mass};
use crate::scene::keywords::SceneKind;
use crate::scene::{self, GripperContact, Scene, SceneError, Side};
use crate::statics::{Equilibrium, form_closure, palm_force_with_mu};
use crate::table::Value;
use crate::trace::{self, Cancellable, Event, FingerContact, Outcome, RequiredData, RunError, Sample, Sink, SinkError};

/// Reason for a missing verdict of a completed run without samples.
const NO_SAMPLES: &str = "the run has no duration, so it has no verdict";

/// Performs one run of a study; `None` if it was interrupted.
pub(super) fn run_one(study: &Study, run: u64, keep_running: &(dyn Fn() -> bool + Sync)) -> Option<Row> {
    let values = study.field_values(run);
    let text = study.fill(&values);
    let numbers = [Value::Integer(run as i64), Value::Integer(study.design(run) as i64)];
    let cells = Cells::new(study.kind, numbers.into_iter().chain(values.into_iter().map(|value| value.value)));
    let scene = match scene::parse_any(&text, "run.toml") {
        // The kind was checked when the study was read, unless an axis changes it.
        Ok(scene) if scene.kind() != study.kind => Err("the scene is of another kind".to_string()),
        Ok(scene) => Ok(Scene { log: scene.log.without_sample_grid(scene.duration_s), ..scene }),
        Err(error) => Err(problem_messages(&error)),
    };
    match scene {
        Err(reason) => Some(cells.row(run, Status::Refused, &reason)),
        Ok(scene) if study.kind == SceneKind::Gripper => run_gripper(study, run, &scene, cells, keep_running),
        Ok(scene) => run_finger(study, run, &scene, cells, keep_running),
    }
}

/// Problems of a scene in one line, without their location in the generated text.
pub(in crate::study) fn problem_messages(error: &SceneError) -> String {
    let messages: Vec<&str> = error.problems().iter().map(|problem| problem.message.as_str()).collect();
    if messages.is_empty() { error.to_string() } else { messages.join("; ") }
}

/// Simulates a scene, checks the run if the study requires it, and returns its row; `None` if it was interrupted.
/// `set_results` sets the cells from the sink and the outcome and returns the reason if figures or the verdict are
/// missing.
fn simulate_row<S: Sink>(
    study: &Study,
    run: u64,
    scene: &Scene,
    mut cells: Cells,
    mut sink: S,
    keep_running: &(dyn Fn() -> bool + Sync),
    set_results: impl FnOnce(&mut Cells, &S, &Outcome) -> Option<String>,
) -> Option<Row> {
    let outcome = match trace::run(study.model, scene, &mut Cancellable { sink: &mut sink, keep_running }) {
        Ok(outcome) => outcome,
        Err(error) if error.is_stop() => return None,
        Err(RunError::Simulation { failure, partial_outcome }) => {
            cells.set("steps", partial_outcome.work.steps as i64);
            let reason = format!("at {:.6} ms: {}", failure.time_s * 1e3, failure.reason);
            return Some(cells.row(run, Status::Failed, &reason));
        }
        Err(RunError::Sink(error)) => return Some(cells.row(run, Status::Failed, &error.to_string())),
    };
    let reason = set_results(&mut cells, &sink, &outcome);
    cells.set("steps", outcome.work.steps as i64);
    if study.checked {
        let check = check(study.model, scene, keep_running);
        cells.set("check", check.verdict.name());
        cells.set("check_error_rad", check.errors.path);
    }
    // An interrupted check is invalid.
    keep_running().then(|| cells.row(run, Status::Completed, &reason.unwrap_or_default()))
}

/// Statics of a grasp by a finger, or the reasons why they cannot be computed.
struct Statics {
    grasp: Result<StaticGrasp, String>,
    form_closed: Result<bool, String>,
}

fn run_finger(
    study: &Study,
    run: u64,
    scene: &Scene,
    mut cells: Cells,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Option<Row> {
    let grasp = scene_static_grasp(scene);
    let is_closed = |grasp: &StaticGrasp| match form_closure(&scene.finger().linkage, &grasp.end) {
        Ok(closure) => Ok(closure.closed),
        Err(error) => Err(error.to_string()),
    };
    let statics = Statics { form_closed: grasp.as_ref().map_err(String::clone).and_then(is_closed), grasp };
    set_finger(&mut cells, scene, &statics);
    if let Some(reason) = filter_reason(&study.filter, &statics) {
        return Some(cells.row(run, Status::Filtered, &reason));
    }
    let grasp = statics.grasp.as_ref().ok();
    let tracker = grasp.map(|grasp| Tracker::new(grasp.final_angles()));
    simulate_row(study, run, scene, cells, tracker, keep_running, |cells, tracker, outcome| {
        let has_samples =
            tracker.as_ref().zip(grasp).map(|(tracker, grasp)| set_closing(cells, tracker, grasp, outcome));
        if has_samples == Some(false) { Some(NO_SAMPLES.to_string()) } else { missing_statics_reason(&statics) }
    })
}

/// Sets the cells of a finger and its statics.
fn set_finger(cells: &mut Cells, scene: &Scene, statics: &Statics) {
    let finger = scene.finger();
    let lengths = &finger.linkage.lengths;
    cells.set("l12_m", lengths.l12_m);
    cells.set("l21_m", lengths.l21_m);
    cells.set("l22_m", lengths.l22_m);
    cells.set("t22_m", lengths.t22_m);
    cells.set("mass_kg", total_mass(&finger.linkage.bodies));
    // Like the static analysis, this uses the torque at the end of the run.
    cells.set("motor_n_m", scene::torque(&finger.motor.actuation, scene.duration_s).0);
    if let Some(SpringKind::Constant { torque_n_m }) = finger.spring.map(|spring| spring.kind) {
        cells.set("spring_n_m", torque_n_m);
    }
    if let Ok(grasp) = &statics.grasp {
        cells.set("trajectory_rad", grasp.end.posture.q11_rad - finger.initial.q11_rad);
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

/// Sets the cells of the simulation of a finger; `false` if it has no samples.
fn set_closing(cells: &mut Cells, tracker: &Tracker, grasp: &StaticGrasp, outcome: &Outcome) -> bool {
    let Some(criteria) = tracker.criteria(grasp.static_forces_n()) else { return false };
    cells.set("t_geo_s", criteria.t_geo_s);
    cells.set("tts_s", criteria.tts_s);
    cells.set("rebound_percent", criteria.rebound_percent);
    cells.set("class", criteria.class.name());
    cells.set("class_reason", criteria.class_reason.to_string());
    let contacts = [FingerContact::Proximal, FingerContact::Distal];
    let forces_n = contacts.map(|contact| outcome.last.finger_contact(contact).normal_n);
    let peaks_n = contacts.map(|contact| outcome.finger_contact(contact).peak_normal_n);
    cells.set("f21_n", forces_n[0]);
    cells.set("f22_n", forces_n[1]);
    cells.set("pfp_n", palm_force_with_mu(&grasp.end, forces_n, grasp.mu_static));
    cells.set("peak_f21_n", peaks_n[0]);
    cells.set("peak_f22_n", peaks_n[1]);
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

/// Sink that evaluates the grasp of a gripper and the overlaps of its links.
struct GripperSink {
    grasp: GraspTracker,
    overlaps: Option<LinkOverlaps>,
}

impl Sink for GripperSink {
    fn required_data(&self) -> RequiredData {
        RequiredData { energies: false, joint_forces: false, passive: true, peaks: true }
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.grasp.sample(sample)?;
        self.overlaps.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.grasp.event(event)
    }
}

fn run_gripper(
    study: &Study,
    run: u64,
    scene: &Scene,
    mut cells: Cells,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Option<Row> {
    cells.set("palm_width_m", scene.system.palm_width_m);
    cells.set("x_start_m", scene.system.grasped().centre_m[0]);
    // Time-dependent torques are reported at the end of the run.
    let torque_n_m = |actuation| scene::torque(actuation, scene.duration_s).0;
    let input_n_m = scene.system.differential.as_ref().map_or(0.0, |input| torque_n_m(&input.motor.actuation));
    for side in Side::BOTH {
        let finger = scene.system.finger(side);
        let column = |quantity: &str| format!("{}_{quantity}", side.name());
        cells.set(&column("l21_m"), finger.linkage.lengths.l21_m);
        cells.set(&column("motor_n_m"), torque_n_m(&finger.motor.actuation) + 0.5 * input_n_m);
        if let Some(SpringKind::Constant { torque_n_m }) = finger.spring.map(|spring| spring.kind) {
            cells.set(&column("spring_n_m"), torque_n_m);
        }
    }
    let sink = GripperSink { grasp: GraspTracker::for_scene(scene), overlaps: LinkOverlaps::for_scene(scene) };
    simulate_row(study, run, scene, cells, sink, keep_running, |cells, sink, outcome| match sink.grasp.criteria() {
        Some(criteria) => {
            set_grasp(cells, scene, &criteria, outcome);
            let overlaps = sink.overlaps.iter().flat_map(LinkOverlaps::overlaps);
            cells.set("link_overlap_m", overlaps.map(|overlap| overlap.depth_m).fold(0.0, f64::max));
            None
        }
        None => Some(NO_SAMPLES.to_string()),
    })
}

/// Sets the cells of the simulation of a gripper.
fn set_grasp(cells: &mut Cells, scene: &Scene, criteria: &GraspCriteria, outcome: &Outcome) {
    let (last, end) = (&outcome.last, &criteria.end);
    cells.set("grasp", criteria.fate.name());
    cells.set("grasped_s", criteria.grasped_s);
    cells.set("tts_s", criteria.tts_s);
    cells.set("until_s", criteria.fate.lost_at_s());
    cells.set("x_m", end.centre_m[0]);
    cells.set("y_m", end.centre_m[1]);
    cells.set("angle_rad", end.angle_rad);
    cells.set("offset_ratio", criteria.offset_ratio());
    cells.set("speed_m_s", criteria.end_speed_m_s());
    cells.set("slip_m", criteria.slip.map(|slip| slip.displacement_m));
    cells.set("slip_rad", criteria.slip.map(|slip| slip.rotation_rad));
    cells.set("contacts_lost", criteria.contacts.iter().map(|contact| i64::from(contact.times_lost)).sum::<i64>());
    cells.set("form_closed", is_form_closed(scene, last).filter(|_| criteria.fate == Fate::Held));
    let contacts = GripperContact::ALL.into_iter().zip(outcome.contacts.iter().zip(last.contacts()));
    for (contact, (summary, last)) in
        contacts.filter(|(contact, (_, last))| !contact.is_stop() && last.gap_m.is_finite())
    {
        let name = contact.name();
        cells.set(&format!("{name}_n"), last.normal_n);
        if contact != GripperContact::Table {
            cells.set(&format!("peak_{name}_n"), summary.peak_normal_n);
        }
        if let GripperContact::Finger(..) = contact {
            cells.set(&format!("{name}_first_s"), summary.first_s);
        }
    }
}
