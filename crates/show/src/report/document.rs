//! A run: the JSON document of its figures in order, and the summary as short tables with units.
//!
//! Keys contain their SI unit; a missing value is null. Keys may be added, but are never renamed.

use serde::{Serialize, Serializer};

use super::check::{self, RunCheckReport};
use super::contacts::Contacts;
use super::object::ObjectReport;
use super::states::States;
use super::tables;
use crate::criteria::{CableEvent, Criteria, ObjectCriteria, Rebound, scene_static_grasp};
use crate::format::numbers::{G_M_S2, format_number};
use crate::format::{Report, ToReport, format_duration};
use crate::playback::PlayedGrasp;
use crate::scene::schema::{SettingsSection, columns};
use crate::scene::{Engine, Integrator, Keyword, Response, Scene, Stepping, one_line};
use crate::statics::NoGrasp;
use crate::trace::{Energy, Model, Outcome, Schema, Work};

/// Report of one run. If the simulation failed without a partial outcome, all results are null. Keys that do not apply
/// to the kind of scene are omitted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunReport {
    /// Name of the scene.
    pub scene: String,
    /// `finger`, `bodies` or `gripper`.
    pub kind: &'static str,
    /// Whether bodies are connected by joints.
    #[serde(skip)]
    pub has_joints: bool,
    /// `analytic` or `engine`.
    pub model: &'static str,
    /// Requested duration, s; the time reached is `end_s`.
    pub duration_s: f64,
    /// Accepted steps.
    pub steps: Option<u64>,
    /// Wall time of the simulation, s. It is the only figure that differs between two runs of the same scene.
    pub wall_s: f64,
    /// Final states of fingers and bodies.
    #[serde(flatten)]
    pub states: States,
    pub contacts: Option<Contacts>,
    /// Lift-offs of cables from pulleys, and their returns; omitted without any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cable_events: Vec<CableEvent>,
    /// Criteria of a finger; null if there is no object, if the finger cannot grasp it, or if the run was not
    /// completed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub criteria: Option<Option<Criteria>>,
    /// Reason why a finger with an object has no criteria; null if it has criteria.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_criteria: Option<Option<String>>,
    /// Fate of the object of a hand; null if the run was not completed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grasp: Option<Option<Box<ObjectReport>>>,
    /// Reason why a mechanism with a hand has no fate, and what to do; omitted without a reason.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_grasp: Option<String>,
    pub completed: bool,
    /// Time reached, s.
    pub end_s: Option<f64>,
    /// Largest acceleration of the centre of a gripper's palm during `duration_s`, m/s²; null if the palm does not
    /// move.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub palm_peak_acceleration_m_s2: Option<Option<f64>>,
    /// Reason and time of the failure; null if the run was completed.
    pub error: Option<Failure>,
    pub energy: Option<Energy>,
    /// Reasons to doubt the results; empty for a valid run.
    pub warnings: Vec<String>,
    pub work: Option<Work>,
    /// Settings of the analytic model; null for a run of the engine.
    #[serde(serialize_with = "serialize_settings")]
    pub integrator: Option<Integrator>,
    /// Settings of the engine model; null for a run of the analytic model.
    #[serde(serialize_with = "serialize_settings")]
    pub engine: Option<Engine>,
    /// Largest gap of a joint of the engine, m; only with fingers. Null for the analytic model, whose loop is closed by
    /// construction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loop_gap_m: Option<Option<f64>>,
    /// Path of the log, as given by the user; null if no log was requested.
    pub log: Option<String>,
    /// Path of the page; null if no page was requested.
    pub page: Option<String>,
    /// Path of the table of samples, as given by the user; null if no table was requested.
    pub csv: Option<String>,
    /// Accuracy check; null if the run was not checked.
    pub check: Option<RunCheckReport>,
    /// Content of the text. The JSON document always contains everything.
    #[serde(skip)]
    pub detail: Detail,
}

/// Content of the summary of a grasp, in addition to its answer and its pairs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Detail {
    /// Whether it contains the contacts point by point.
    pub points: bool,
    /// Whether it contains the states of all bodies and joints.
    pub all: bool,
}

/// Time and reason of the early end of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failure {
    pub time_s: f64,
    pub reason: String,
}

/// Serialises the settings of one model as used in the run, by name. Settings that other settings make irrelevant are
/// null.
pub fn serialize_settings<T: SettingsSection, S: Serializer>(settings: &Option<T>, out: S) -> Result<S::Ok, S::Error> {
    match settings {
        Some(settings) => out.collect_map(columns(settings)),
        None => out.serialize_none(),
    }
}

/// The results of a run that are available.
#[derive(Clone, Copy, Debug)]
pub struct RunData<'a> {
    pub wall_s: f64,
    pub outcome: Option<&'a Outcome>,
    /// Criteria of a finger; `None` if its run was not completed.
    pub criteria: Option<Criteria>,
    /// Criteria of the object that a hand grasps.
    pub grasp: Option<&'a ObjectCriteria>,
    /// Rebounds of pairs of discs.
    pub rebounds: &'a [Rebound],
    /// Lift-offs of cables from pulleys, and their returns.
    pub cable_events: &'a [CableEvent],
    /// Reasons to doubt the results.
    pub warnings: &'a [String],
}

/// Returns the reason why the run of a finger has no criteria; `None` if it has criteria or there is no object.
fn no_criteria(scene: &Scene, completed: bool) -> Option<String> {
    scene.object()?;
    match scene_static_grasp(scene) {
        _ if !completed => Some("the run was not completed".to_string()),
        Err(reason) => Some(format!("the finger cannot grasp this object: {reason}")),
        Ok(_) => None,
    }
}

impl RunReport {
    /// Builds the report of a completed run, or of a run up to its failure `error`.
    pub fn new(scene: &Scene, model: Model, data: &RunData<'_>, error: Option<Failure>) -> Self {
        let (engine, outcome) = (model == Model::Engine, data.outcome);
        let (schema, count) = (Schema::from_scene(scene), scene.finger_count());
        let (finger, gripper) = (count == 1, count == 2);
        let palm = scene.hand.palm_motion.as_ref();
        let criteria = data.criteria.filter(|_| error.is_none());
        let roles = scene.grasp_roles();
        let no_grasp = roles
            .as_ref()
            .err()
            // Scenes without a section [grasp] need no grasp.
            .filter(|reason| **reason != NoGrasp::Nothing || scene.grasp.is_some())
            .map(|reason| format!("no grasp: {reason}"));
        RunReport {
            scene: scene.name.clone(),
            kind: scene.kind.keyword(),
            has_joints: scene.has_joints(),
            model: model.name(),
            duration_s: scene.duration_s,
            steps: outcome.map(|outcome| outcome.work.steps),
            wall_s: data.wall_s,
            states: States::new(&schema, outcome, Some(scene)),
            contacts: outcome.map(|outcome| Contacts::new(&schema, outcome, data.rebounds)),
            cable_events: data.cable_events.to_vec(),
            criteria: finger.then_some(criteria),
            no_criteria: finger.then(|| no_criteria(scene, error.is_none()).filter(|_| criteria.is_none())),
            grasp: roles.is_ok().then(|| data.grasp.map(|found| Box::new(ObjectReport::new(found, Some(scene))))),
            no_grasp,
            completed: error.is_none(),
            end_s: outcome.map(|outcome| outcome.last.time_s),
            palm_peak_acceleration_m_s2: gripper
                .then(|| palm.map(|motion| motion.peak_acceleration_m_s2([0.0; 2], scene.duration_s))),
            error,
            energy: outcome.map(|outcome| outcome.last.energy()),
            warnings: data.warnings.to_vec(),
            work: outcome.map(|outcome| outcome.work),
            integrator: (!engine).then_some(scene.integrator),
            engine: engine.then_some(scene.engine),
            loop_gap_m: scene.has_joints().then(|| outcome.filter(|_| engine).map(|outcome| outcome.loop_gap_m)),
            log: None,
            page: None,
            csv: None,
            check: None,
            detail: Detail::default(),
        }
    }

    /// The report on the grasp of an object.
    pub fn object(&self) -> Option<&ObjectReport> {
        self.grasp.as_ref()?.as_deref()
    }

    /// The grasp in the form in which a page shows it.
    pub fn played_grasp(&self) -> Option<PlayedGrasp> {
        self.object().map(ObjectReport::played)
    }

    /// The summary of a grasp: the answer first, then pairs, then what else there is.
    fn grasp_report(&self, grasp: &ObjectReport) -> Report {
        let Detail { points, all } = self.detail;
        let mut sections =
            vec![Report::from(grasp.heading()), self.heading().into(), grasp.pairs(self.contacts.as_ref())];
        sections.extend(self.contacts.as_ref().map(|contacts| {
            if points {
                tables::contacts(contacts)
            } else {
                tables::contacts(&contacts.touched_without(|index| grasp.has_point(index)))
            }
        }));
        sections.extend([
            tables::cable_events(&self.cable_events).into(),
            grasp.actuators().into(),
            grasp.motion().into(),
        ]);
        let end_s = self.end_s.unwrap_or_default();
        match all {
            true => sections.extend(tables::states(&self.states, end_s)),
            false => {
                let (object, base) = (&grasp.criteria.object, &grasp.criteria.base);
                let shown = self.states.bodies_without_joints([object, base]);
                sections.push(tables::bodies_of(&shown, end_s));
            }
        }
        sections.extend([
            self.energy.map(|energy| tables::energies(&energy, self.has_joints)).into(),
            check::summary_line(self.check.as_ref(), self.steps).into(),
        ]);
        let omitted = match (points, all) {
            (false, false) => Some("--points prints single contact points, --all the states of all bodies and joints"),
            (true, false) => Some("--all prints the states of all bodies and joints"),
            (_, true) => None,
        };
        sections.push(omitted.map(|flags| format!("{flags}\n")).into());
        Report::join(sections)
    }
}

/// The complete summary, with a final line end.
impl ToReport for RunReport {
    fn report(&self) -> Report {
        if let Some(grasp) = self.object() {
            return self.grasp_report(grasp);
        }
        let no_criteria = self.no_criteria.as_ref().and_then(Option::as_ref).filter(|_| self.completed);
        let mut sections = vec![Report::from(self.heading())];
        sections.extend(tables::states(&self.states, self.end_s.unwrap_or_default()));
        sections.extend([
            self.contacts.as_ref().map(tables::contacts).into(),
            tables::cable_events(&self.cable_events).into(),
            self.energy.map(|energy| tables::energies(&energy, self.has_joints)).into(),
            self.criteria.flatten().as_ref().map(tables::criteria).into(),
            no_criteria.map(|reason| format!("no class: {reason}\n")).into(),
            self.no_grasp.as_ref().map(|reason| format!("{reason}\n")).into(),
            check::summary_line(self.check.as_ref(), self.steps).into(),
        ]);
        Report::join(sections)
    }
}

impl RunReport {
    fn heading(&self) -> String {
        let settings = settings_text(self.integrator.as_ref(), self.engine.as_ref(), self.has_joints);
        let mut lines = vec![
            format!("{}: {} model{settings}", one_line(&self.scene), self.model),
            format!("{}{} of wall time", self.effort(), format_duration(self.wall_s)),
        ];
        lines.extend(self.palm_peak_acceleration_m_s2.flatten().map(|peak_m_s2| {
            let [peak, peak_g] = [peak_m_s2, peak_m_s2 / G_M_S2].map(|peak| format_number(peak, 4));
            format!("the palm accelerates by up to {peak} m/s² ({peak_g} g)")
        }));
        let gap = self.loop_gap_m.flatten();
        lines.extend(gap.map(|gap_m| format!("joints open by at most {} µm", format_number(gap_m * 1e6, 3))));
        let ends_early = self.error.is_none() && self.end_s.is_some_and(|end_s| end_s < self.duration_s);
        lines.extend(self.object().filter(|_| ends_early).and_then(ObjectReport::leaving));
        lines.extend(self.error.as_ref().map(|error| error.text(&format_duration(self.duration_s))));
        lines.extend(self.warnings.iter().map(|warning| format!("Warning: {warning}")));
        for (name, path) in [("log", &self.log), ("samples", &self.csv), ("page", &self.page)] {
            lines.extend(path.as_ref().map(|path| format!("{name}: {}", one_line(path))));
        }
        lines.join("\n") + "\n"
    }

    fn effort(&self) -> String {
        let (Some(end_s), Some(steps), Some(work)) = (self.end_s, self.steps, &self.work) else {
            return String::new();
        };
        let effort = match &self.engine {
            None => format!("{} evaluations, {} Jacobians", work.rhs_evaluations, work.jacobian_evaluations),
            Some(_) => {
                format!("{} contact sub-steps, {} Newton iterations", work.contact_substeps, work.newton_iterations)
            }
        };
        let (rejected, events) = (work.rejected, work.events);
        let plural = if events == 1 { "" } else { "s" };
        format!("{} in {steps} steps ({rejected} rejected), {effort}, {events} event{plural}; ", format_duration(end_s))
    }
}

impl Failure {
    /// Describes the failure of a run of the requested duration.
    pub fn text(&self, requested: &str) -> String {
        format!("NOT COMPLETED: stopped at {} of {requested}: {}", format_duration(self.time_s), self.reason)
    }
}

/// Describes the settings of the model; empty if they are unknown.
pub fn settings_text(integrator: Option<&Integrator>, engine: Option<&Engine>, has_joints: bool) -> String {
    if let Some(Integrator { method, rtol, preset, .. }) = integrator {
        return format!(", {} (rtol {rtol:e}, {} preset)", method.keyword(), preset.keyword());
    }
    let Some(settings) = engine else { return String::new() };
    let stepping = match settings.stepping {
        Stepping::Fixed { step_s } => format!("steps of {}", format_duration(step_s)),
        Stepping::Adaptive { tolerance_m, max_step_s } => format!(
            "{} within {} m per step, steps up to {}",
            if has_joints { "joints" } else { "bodies" },
            format_number(tolerance_m, 3),
            format_duration(max_step_s)
        ),
    };
    let law = if matches!(settings.response, Response::Rapier { .. }) { ", rapier's own contact" } else { "" };
    let sweeps = if has_joints { format!(", {} sweeps", settings.iterations) } else { String::new() };
    format!(", {stepping}{sweeps}{law}")
}
