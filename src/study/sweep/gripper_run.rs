//! A single run of a gripper: scene, simulation, row.

use super::Study;
use super::row::{Cells, Row, Status};
use super::simulate::{NO_SAMPLES, problem_messages, simulate_row};
use crate::criteria::{Fate, GraspCriteria, GraspTracker, LinkOverlaps, is_form_closed};
use crate::gripper::SpringKind;
use crate::scene::keywords::SceneKind;
use crate::scene::{self, GripperContact, Scene, SceneError, Side};
use crate::trace::{Event, Outcome, RequiredData, Sample, Sink, SinkError};

/// Makes one run of a study of grippers from the text of its scene; `None` if it was interrupted.
pub(super) fn run_gripper(
    study: &Study,
    run: u64,
    text: &str,
    mut cells: Cells,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Option<Row> {
    let scene = match parse_gripper(text) {
        Ok(scene) => scene,
        Err(error) => return Some(cells.row(run, Status::Refused, &problem_messages(&error))),
    };
    set_design(&mut cells, &scene);
    let sink = GripperSink { grasp: GraspTracker::for_scene(&scene), overlaps: LinkOverlaps::for_scene(&scene) };
    simulate_row(study, run, &scene, cells, sink, keep_running, |cells, sink, outcome| match sink.grasp.criteria() {
        Some(criteria) => {
            set_results(cells, &scene, &criteria, outcome);
            let overlaps = sink.overlaps.iter().flat_map(LinkOverlaps::overlaps);
            cells.set("link_overlap_m", overlaps.map(|overlap| overlap.depth_m).fold(0.0, f64::max));
            None
        }
        None => Some(NO_SAMPLES.to_string()),
    })
}

/// Sink that evaluates the grasp and the overlaps of links.
struct GripperSink {
    grasp: GraspTracker,
    overlaps: Option<LinkOverlaps>,
}

impl Sink for GripperSink {
    fn required_data(&self) -> RequiredData {
        RequiredData { energies: false, passive: true, peaks: true }
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.grasp.sample(sample)?;
        self.overlaps.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.grasp.event(event)
    }
}

/// Parses the scene of a run.
fn parse_gripper(text: &str) -> Result<Scene, SceneError> {
    let scene = scene::parse_any(text, "run.toml")?;
    match scene.kind() {
        SceneKind::Gripper => Ok(Scene { log: scene.log.without_sample_grid(scene.duration_s), ..scene }),
        // The kind was checked when the study was read.
        _ => Err(SceneError::Invalid { file: "run.toml".to_string(), text: text.to_string(), problems: Vec::new() }),
    }
}

/// Sets the cells of the design.
fn set_design(cells: &mut Cells, scene: &Scene) {
    cells.set("palm_width_m", scene.system.palm_width_m);
    cells.set("x_start_m", scene.system.grasped().centre_m[0]);
    for side in Side::BOTH {
        let finger = scene.system.finger(side);
        let column = |quantity: &str| format!("{}_{quantity}", side.name());
        cells.set(&column("l21_m"), finger.linkage.lengths.l21_m);
        // Time-dependent torques are reported at the end of the run.
        let finger_torque_n_m = scene::torque(&finger.motor.actuation, scene.duration_s).0;
        let differential = scene.system.differential.as_ref();
        let input_torque_n_m =
            differential.map(|differential| scene::torque(&differential.motor.actuation, scene.duration_s).0);
        cells.set(&column("motor_n_m"), finger_torque_n_m + 0.5 * input_torque_n_m.unwrap_or(0.0));
        if let Some(SpringKind::Constant { torque_n_m }) = finger.spring.map(|spring| spring.kind) {
            cells.set(&column("spring_n_m"), torque_n_m);
        }
    }
}

/// Sets the cells of the simulation.
fn set_results(cells: &mut Cells, scene: &Scene, criteria: &GraspCriteria, outcome: &Outcome) {
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
    let contacts = GripperContact::ALL.into_iter().zip(outcome.contacts.iter().zip(&last.contacts));
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
