//! One run of a gripper: scene, simulation, row.

use super::Study;
use super::row::{Cells, Row, Status};
use super::simulate::{NO_SAMPLES, refusal, simulated};
use crate::criteria::{Fate, GraspCriteria, GraspTracker, LinkOverlaps, is_form_closed};
use crate::gripper::SpringKind;
use crate::scene::words::SceneKind;
use crate::scene::{self, Place, Scene, SceneError, Side};
use crate::trace::{Event, Outcome, Sample, Sink, SinkError, Wants};

/// Makes one run of a study of grippers, of which `text` is the scene; `None` if it was told to stop.
pub(super) fn of_gripper(
    study: &Study,
    run: u64,
    text: &str,
    mut cells: Cells,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Option<Row> {
    let scene = match gripper(text) {
        Ok(scene) => scene,
        Err(error) => return Some(cells.row(run, Status::Refused, &refusal(&error))),
    };
    design(&mut cells, &scene);
    let watch = Watch { grasp: GraspTracker::of(&scene), overlaps: LinkOverlaps::of(&scene) };
    simulated(study, run, &scene, cells, watch, go_on, |cells, watch, outcome| match watch.grasp.criteria() {
        Some(found) => {
            closing(cells, &scene, &found, outcome);
            let overlaps = watch.overlaps.iter().flat_map(LinkOverlaps::found);
            cells.set("link_overlap_m", overlaps.map(|overlap| overlap.depth_m).fold(0.0, f64::max));
            None
        }
        None => Some(NO_SAMPLES.to_string()),
    })
}

/// What a run is judged by.
struct Watch {
    grasp: GraspTracker,
    overlaps: Option<LinkOverlaps>,
}

impl Sink for Watch {
    fn wants(&self) -> Wants {
        Wants { energies: false, passive: true, peaks: true }
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.grasp.sample(sample)?;
        self.overlaps.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.grasp.event(event)
    }
}

/// The scene of a run.
fn gripper(text: &str) -> Result<Scene, SceneError> {
    let scene = scene::parse_any(text, "run.toml")?;
    match scene.kind() {
        SceneKind::Gripper => Ok(Scene { log: scene.log.without_grid(scene.duration_s), ..scene }),
        // The study has made sure of the kind.
        _ => Err(SceneError::Invalid { file: "run.toml".to_string(), text: text.to_string(), problems: Vec::new() }),
    }
}

fn design(cells: &mut Cells, scene: &Scene) {
    cells.set("palm_width_m", scene.system.palm_width_m);
    cells.set("x_start_m", scene.system.grasped().centre_m[0]);
    for side in Side::BOTH {
        let (of, name) = (scene.system.finger(side), |what: &str| format!("{}_{what}", side.word()));
        cells.set(&name("l21_m"), of.linkage.lengths.l21_m);
        // The torque in the end.
        let own = scene::torque(&of.motor.actuation, scene.duration_s).0;
        let input = scene.system.differential.as_ref().map(|of| scene::torque(&of.motor.actuation, scene.duration_s).0);
        cells.set(&name("motor_n_m"), own + 0.5 * input.unwrap_or(0.0));
        if let Some(SpringKind::Constant { torque_n_m }) = of.spring.map(|spring| spring.kind) {
            cells.set(&name("spring_n_m"), torque_n_m);
        }
    }
}

fn closing(cells: &mut Cells, scene: &Scene, found: &GraspCriteria, outcome: &Outcome) {
    let (last, end) = (&outcome.last, &found.end);
    cells.set("grasp", found.fate.name());
    cells.set("grasped_s", found.grasped_s);
    cells.set("tts_s", found.tts_s);
    cells.set("until_s", found.fate.until_s());
    cells.set("x_m", end.centre_m[0]);
    cells.set("y_m", end.centre_m[1]);
    cells.set("angle_rad", end.angle_rad);
    cells.set("offset_ratio", found.offset_ratio());
    cells.set("speed_m_s", found.end_speed_m_s());
    cells.set("slip_m", found.slip.map(|slip| slip.displacement_m));
    cells.set("slip_rad", found.slip.map(|slip| slip.rotation_rad));
    cells.set("contacts_lost", found.contacts.iter().map(|contact| i64::from(contact.times_lost)).sum::<i64>());
    cells.set("form_closed", is_form_closed(scene, last).filter(|_| found.fate == Fate::Held));
    let places = Place::ALL.into_iter().zip(outcome.contacts.iter().zip(&last.contacts));
    for (place, (summary, last)) in places.filter(|(place, (_, last))| !place.is_stop() && last.gap_m.is_finite()) {
        let name = place.name();
        cells.set(&format!("{name}_n"), last.normal_n);
        if place != Place::Table {
            cells.set(&format!("peak_{name}_n"), summary.peak_normal_n);
        }
        if let Place::Finger(..) = place {
            cells.set(&format!("{name}_first_s"), summary.first_s);
        }
    }
}
