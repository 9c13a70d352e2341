//! Result columns of a study: of five-bar hands those of [`super::hands`]; of other scenes the criteria of the grasp, then what
//! the schema of the scene names.

use std::cell::OnceCell;
use std::sync::Arc;

use super::hands::{FINGER_FIGURES, Figure, GRIPPER_FIGURES, HandFigures};
use crate::criteria::{ActuatorCriteria, ActuatorTracker, Firmness, Margin, ObjectCriteria, ObjectTracker, firmness};
use crate::mechanism::OutlinePair;
use crate::scene::Scene;
use crate::table::Value;
use crate::trace::schema::SubjectKind;
use crate::trace::{Channel, ContactSample, Outcome, RequiredData, Sample, Schema, Sink, SinkError};

/// Names of the result columns of fingers or of grippers, in order.
pub(super) fn hand_columns(fingers: usize) -> Vec<&'static str> {
    fn names<R: ?Sized>(figures: &'static HandFigures<R>) -> Vec<&'static str> {
        let of = |figures: &'static [Figure<R>]| figures.iter().map(|figure| &figure.name[..]);
        of(&figures.design).chain(BEFORE).chain(of(&figures.run)).chain(AFTER).collect()
    }
    if fingers == 2 { names(&GRIPPER_FIGURES) } else { names(&FINGER_FIGURES) }
}

/// Result columns of any scene before and after the figures of a run.
const BEFORE: [&str; 2] = ["status", "reason"];
const AFTER: [&str; 3] = ["steps", "check", "check_error_rad"];

/// What the runs of a study have in common, and the names of its result columns.
#[derive(Clone, Debug)]
pub(in crate::study) enum Figures {
    /// Of this number of five-bar fingers.
    Hand(usize),
    /// Of a scene of any other kind.
    Scene(Box<SceneFigures>),
}

/// The result columns of a study.
#[derive(Clone, Debug)]
pub(in crate::study) struct Results {
    pub figures: Figures,
    /// Channels whose smallest and largest values are columns.
    pub extrema: Vec<Channel>,
    /// Names of the columns, in order.
    pub names: Arc<[String]>,
}

impl Results {
    /// Returns the columns of studies of a scene. `only` selects some figures; if it is empty, all are included. For
    /// the channels in `extrema`, smallest and largest values are added.
    ///
    /// # Errors
    /// Returns an unknown figure or channel, together with all known names.
    pub fn of(scene: &Scene, only: &[String], extrema: &[String]) -> Result<Self, UnknownFigure> {
        let mut figures = match scene.finger_count() {
            0 => Figures::Scene(Box::new(SceneFigures::of(scene))),
            fingers => Figures::Hand(fingers),
        };
        let channels = if extrema.is_empty() { Vec::new() } else { Schema::from_scene(scene).channels() };
        let channel = |(index, name): (usize, &String)| {
            let known = channels.iter().find(|channel| channel.name == *name).cloned();
            let names = || channels.iter().map(|channel| channel.name.clone()).collect();
            known.ok_or_else(|| UnknownFigure { key: "extrema", index, name: name.clone(), known: names() })
        };
        let extrema = extrema.iter().enumerate().map(channel).collect::<Result<Vec<Channel>, _>>()?;
        let of_extrema = extrema.iter().flat_map(|channel| Extrema::columns(&channel.name));
        let names: Vec<String> = match &figures {
            Figures::Hand(fingers) => hand_columns(*fingers).into_iter().map(String::from).chain(of_extrema).collect(),
            Figures::Scene(scene) => {
                let before = BEFORE.into_iter().chain(scene.names()).map(String::from);
                before.chain(of_extrema).chain(AFTER.map(String::from)).collect()
            }
        };
        if let Some((index, name)) = only.iter().enumerate().find(|(_, name)| !names.contains(name)) {
            return Err(UnknownFigure { key: "columns", index, name: name.clone(), known: names });
        }
        let is_common = |name: &str| BEFORE.contains(&name) || AFTER.contains(&name);
        let is_extremum = |name: &str| {
            extrema.iter().any(|channel| Extrema::columns(&channel.name).iter().any(|column| column == name))
        };
        let is_selected =
            |name: &String| only.is_empty() || only.contains(name) || is_common(name) || is_extremum(name);
        let names: Arc<[String]> = names.into_iter().filter(is_selected).collect();
        if let Figures::Scene(of_scene) = &mut figures {
            // Others need not be computed; the margin solves linear programs.
            of_scene.columns.retain(|(name, _)| names.contains(name));
        }
        Ok(Results { figures, extrema, names })
    }

    /// Removes the columns that already exist for the fields of the axes.
    pub fn without(mut self, fields: &[String]) -> Self {
        self.names = self.names.iter().filter(|name| !fields.contains(name)).cloned().collect();
        self
    }

    /// Returns the result columns of a hand, without extrema.
    pub fn of_hand(fingers: usize) -> Self {
        let names = hand_columns(fingers).into_iter().map(String::from).collect();
        Results { figures: Figures::Hand(fingers), extrema: Vec::new(), names }
    }
}

/// An unknown name in `[results]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::study) struct UnknownFigure {
    pub key: &'static str,
    /// Index of the name in the list under `key`.
    pub index: usize,
    pub name: String,
    pub known: Vec<String>,
}

/// Where the value of a column comes from.
#[derive(Clone, Debug)]
enum Source {
    Fate,
    FateReason,
    TimeToStability,
    Slip,
    Margin,
    FormClosed,
    /// Largest normal force of a pair of the hand and the object.
    PeakNormal,
    Grip,
    /// Of the pair with this index.
    FirstTouch(usize),
    Normal(usize),
    Friction(usize),
    PairPeak(usize),
    Impulse(usize),
    /// Of the actuator with this index.
    LargestEffort(usize),
    Energy(usize),
    /// Number of the last sample.
    Final(Channel),
}

/// Columns of a grasp.
const GRASP: [(&str, Source); 8] = [
    ("fate", Source::Fate),
    ("fate_reason", Source::FateReason),
    ("tts_s", Source::TimeToStability),
    ("slip_m", Source::Slip),
    ("margin_m_s2", Source::Margin),
    ("form_closed", Source::FormClosed),
    ("peak_normal_n", Source::PeakNormal),
    ("grip_n", Source::Grip),
];

/// The figures of a scene, and where they come from.
#[derive(Clone, Debug)]
pub(in crate::study) struct SceneFigures {
    schema: Schema,
    pairs: Vec<OutlinePair>,
    /// Names of the columns with their sources, in order.
    columns: Vec<(String, Source)>,
}

impl SceneFigures {
    /// Returns the figures of a scene: those of its grasp, of all pairs and of actuators, and the final state.
    pub fn of(scene: &Scene) -> Self {
        let mechanism = scene.judged_mechanism();
        let roles = scene.grasp_roles().ok();
        let pairs = mechanism.outline_pairs(roles.as_ref().map(|roles| roles.object));
        // The forces in joints would be computed in every step for their values at the end.
        let schema = Schema { has_joint_forces: false, ..Schema::from_scene(scene) };
        let grasp = GRASP.into_iter().filter(|_| roles.is_some()).map(|(name, source)| (name.to_string(), source));
        let mut columns: Vec<(String, Source)> = grasp.collect();
        for (index, OutlinePair { name, .. }) in pairs.iter().enumerate() {
            columns.extend([
                (format!("{name}_first_s"), Source::FirstTouch(index)),
                (format!("{name}_normal_n"), Source::Normal(index)),
                (format!("{name}_friction_n"), Source::Friction(index)),
                (format!("{name}_peak_n"), Source::PairPeak(index)),
                (format!("{name}_impulse_n_s"), Source::Impulse(index)),
            ]);
        }
        for (index, ActuatorCriteria { name, is_linear, .. }) in
            ActuatorTracker::for_scene(scene).actuators().iter().enumerate()
        {
            let unit = if *is_linear { "n" } else { "n_m" };
            columns.push((format!("{name}_largest_{unit}"), Source::LargestEffort(index)));
            columns.push((format!("{name}_energy_j"), Source::Energy(index)));
        }
        use SubjectKind::{CableElement, Contact, Energy, Limit};
        let is_final = |kind: SubjectKind| !matches!(kind, Contact | Limit | Energy | CableElement);
        let subjects = schema.subjects().into_iter().filter(|subject| is_final(subject.kind));
        let channels: Vec<Channel> =
            subjects.flat_map(|subject| subject.channels().map(|(_, channel)| channel).collect::<Vec<_>>()).collect();
        columns.extend(channels.into_iter().map(|channel| (channel.name.clone(), Source::Final(channel))));
        SceneFigures { schema, pairs, columns }
    }

    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|(name, _)| &name[..])
    }

    /// Whether a scene has the bodies, joints, contacts and actuators of these figures.
    pub fn fit(&self, scene: &Scene) -> bool {
        self.schema.has_subjects_of(scene)
    }

    /// Creates the sink that computes the figures of a run.
    pub fn tracker(scene: &Scene) -> FigureTracker {
        (ObjectTracker::for_scene(scene), ActuatorTracker::for_scene(scene))
    }

    /// Returns the figures of a completed run, each with its name.
    pub fn values(&self, scene: &Scene, (grasp, actuators): &FigureTracker, outcome: &Outcome) -> Vec<(&str, Value)> {
        let run = Run {
            scene,
            outcome,
            grasp: grasp.as_ref().and_then(ObjectTracker::criteria),
            firmness: OnceCell::new(),
            actuators: actuators.actuators(),
            pairs: &self.pairs,
        };
        self.columns.iter().map(|(name, source)| (&name[..], run.value(source))).collect()
    }
}

/// Computes what the figures of a run need: the criteria of the grasp, and those of the actuators.
pub(super) type FigureTracker = (Option<ObjectTracker>, ActuatorTracker);

/// A completed run.
struct Run<'a> {
    scene: &'a Scene,
    outcome: &'a Outcome,
    grasp: Option<ObjectCriteria>,
    firmness: OnceCell<Option<Firmness>>,
    actuators: &'a [ActuatorCriteria],
    pairs: &'a [OutlinePair],
}

impl Run<'_> {
    fn value(&self, source: &Source) -> Value {
        let of_grasp = |value: &dyn Fn(&ObjectCriteria) -> Value| self.grasp.as_ref().map_or(Value::Missing, value);
        match source {
            Source::Fate => of_grasp(&|grasp| grasp.fate.name().into()),
            Source::FateReason => of_grasp(&|grasp| grasp.reason.clone().into()),
            Source::TimeToStability => of_grasp(&|grasp| grasp.tts_s.into()),
            Source::Slip => of_grasp(&|grasp| grasp.slip.map(|slip| slip.displacement_m).into()),
            Source::Margin => self.firmness().map(|firmness| margin_m_s2(&firmness.driven)).into(),
            Source::FormClosed => self.firmness().and_then(|firmness| firmness.form_closed).into(),
            Source::PeakNormal => of_grasp(&|grasp| {
                let of_hand = grasp.pairs.iter().filter(|pair| pair.is_hand);
                let same_name = of_hand.filter_map(|pair| self.pairs.iter().find(|known| known.name == pair.name));
                same_name.map(|pair| self.peak_n(pair)).fold(0.0, f64::max).into()
            }),
            Source::Grip => of_grasp(&|grasp| grasp.grip_n().into()),
            Source::FirstTouch(pair) => {
                let touches = self.pairs[*pair].points.iter().filter_map(|point| self.outcome.contacts[*point].first_s);
                touches.reduce(f64::min).into()
            }
            Source::Normal(pair) => self.at_end(*pair, |contact| contact.normal_n).into(),
            Source::Friction(pair) => self.at_end(*pair, |contact| contact.tangential_n).into(),
            Source::PairPeak(pair) => self.peak_n(&self.pairs[*pair]).into(),
            Source::Impulse(pair) => {
                let impulse = |point: &usize| self.outcome.contacts[*point].impulse_n_s;
                self.pairs[*pair].points.iter().map(impulse).sum::<f64>().into()
            }
            Source::LargestEffort(actuator) => self.actuators[*actuator].largest_effort.into(),
            Source::Energy(actuator) => self.actuators[*actuator].energy_j.into(),
            Source::Final(channel) => Some(channel.value(&self.outcome.last)).filter(|value| value.is_finite()).into(),
        }
    }

    /// How firmly the object is held; computed once, because it solves linear programs.
    fn firmness(&self) -> Option<&Firmness> {
        let firmness = || self.grasp.as_ref().and_then(|grasp| firmness(self.scene, grasp));
        self.firmness.get_or_init(firmness).as_ref()
    }

    /// Sum over the points of a pair at the end of the run.
    fn at_end(&self, pair: usize, of: impl Fn(&ContactSample) -> f64) -> f64 {
        self.pairs[pair].points.iter().map(|point| of(&self.outcome.last.contact(*point))).sum()
    }

    /// Largest normal force of a point of a pair.
    fn peak_n(&self, pair: &OutlinePair) -> f64 {
        pair.points.iter().map(|point| self.outcome.contacts[*point].peak_normal_n).fold(0.0, f64::max)
    }
}

/// The smallest acceleration of a margin; infinite if any acceleration is balanced, missing if it is not decided.
fn margin_m_s2(margin: &Margin) -> Option<f64> {
    match margin {
        Margin::Any => Some(f64::INFINITY),
        Margin::Limited { acceleration_m_s2, .. } => Some(*acceleration_m_s2),
        Margin::NotAtRest { .. } => Some(0.0),
        Margin::Undecided { .. } => None,
    }
}

/// Least and largest values of channels over a run, at the ends of its steps and where a force or a depth is largest.
#[derive(Clone, Debug)]
pub(super) struct Extrema {
    channels: Vec<Channel>,
    /// Least and largest value of each channel.
    found: Vec<[f64; 2]>,
}

impl Extrema {
    pub fn of(channels: Vec<Channel>) -> Self {
        Extrema { found: vec![[f64::INFINITY, f64::NEG_INFINITY]; channels.len()], channels }
    }

    /// Names of the two columns for a channel.
    pub fn columns(channel: &str) -> [String; 2] {
        ["least", "largest"].map(|which| format!("{which}_{channel}"))
    }

    /// Values of the columns, each with the name of its column.
    pub fn values(&self) -> Vec<(String, Value)> {
        let of_channel = |(channel, found): (&Channel, &[f64; 2])| {
            let value = |value: f64| Value::from(Some(value).filter(|value| value.is_finite()));
            let [least, largest] = Self::columns(&channel.name);
            [(least, value(found[0])), (largest, value(found[1]))]
        };
        self.channels.iter().zip(&self.found).flat_map(of_channel).collect()
    }
}

impl Sink for Extrema {
    fn required_data(&self) -> RequiredData {
        if self.channels.is_empty() { RequiredData::NONE } else { RequiredData { grid: false, ..RequiredData::ALL } }
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        for (channel, [least, largest]) in self.channels.iter().zip(&mut self.found) {
            let value = channel.value(sample);
            (*least, *largest) = (least.min(value), largest.max(value));
        }
        Ok(())
    }

    /// Forces and depths have their extrema within steps.
    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sample(sample)
    }
}
