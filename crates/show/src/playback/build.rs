//! The data of a run that a page shows: bodies, plotted curves and events.

use std::collections::HashMap;

use serde::Serialize;

use super::contacts::{ShownContact, display_name, shown_contacts};
use super::decimate::{MAX_SAMPLES, select_samples};
use super::panels::{PanelPlan, Scale, panels};
use crate::drawing::{Drawing, DrawnBody, FramePose};
use crate::format::Report;
use crate::format::object::Named;
use crate::scene::Scene;
use crate::trace::schema::{Quantity, State};
use crate::trace::{ContactSample, Event, EventKind, Sample, Schema};

/// Index of a column of numbers in [`Playback::columns`].
pub type Column = usize;

/// A run in the form in which the page shows it. Values over time are stored as columns of numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Playback {
    /// Label that distinguishes the runs of a page: the model or the variant.
    pub label: String,
    /// Summary of the run, shown below the animation.
    #[serde(skip)]
    pub summary: Report,
    /// The grasp of an object; `None` without a grasp, or if the run was not completed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grasp: Option<PlayedGrasp>,
    /// Number of samples in the playback.
    pub samples: usize,
    /// Number of samples of the run before decimation.
    pub recorded: usize,
    /// Times of the samples, ascending. Two samples may have the same time.
    pub time_s: Column,
    pub bodies: Vec<PlayedBody>,
    pub contacts: Vec<ContactSeries>,
    pub panels: Vec<Panel>,
    #[serde(rename = "events")]
    pub event_markers: Vec<EventMarker>,
    /// Length of a force arrow per newton, m/N, as long as arrows are to scale.
    pub arrow_m_per_n: f64,
    /// Maximum length of a force arrow, m.
    pub longest_arrow_m: f64,
    /// Lower left and upper right corner of the view, m.
    pub extent_m: [[f64; 2]; 2],
    /// Whether the view is initially turned by 180°, because gravity points up. Views of fingers are not turned,
    /// because their objects lie on the palm.
    pub is_turned: bool,
    /// The distinct columns. A column contains one value per sample, or a single value if all are equal.
    #[serde(skip)]
    pub columns: Vec<Vec<f64>>,
}

/// A grasp in the form in which a page shows it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlayedGrasp {
    /// The answer in one sentence.
    pub answer: String,
    /// States in order of time. Each state lasts up to the next one; the last state lasts to the end of the run.
    pub states: Vec<PlayedState>,
}

/// A state of the object: `gripped`, `carried`, `resting` or `free`. After the release the state is not judged and is
/// called `released`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PlayedState {
    pub from_s: f64,
    pub name: &'static str,
}

impl Playback {
    /// Returns the playback with the grasp of the run.
    #[must_use]
    pub fn with_grasp(self, grasp: Option<PlayedGrasp>) -> Self {
        Playback { grasp, ..self }
    }
}

/// A body. It has columns for the pose of its frame (`x_m`, `y_m`, `angle_rad`) and for the time derivatives of the
/// pose, which are used to interpolate between samples.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlayedBody {
    #[serde(flatten)]
    pub body: DrawnBody,
    #[serde(flatten)]
    pub columns: Named<Column>,
}

/// The columns of a contact, by the keys of its quantities. The points of a pair of outlines are combined into one
/// contact.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactSeries {
    pub name: String,
    #[serde(flatten)]
    pub columns: Named<Column>,
}

/// Curves that share an axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Panel {
    pub title: &'static str,
    /// SI unit of its values, such as `rad`, `N`, `m`, `J`.
    pub unit: &'static str,
    /// Initial scale, which the reader can change.
    #[serde(rename = "logarithmic")]
    pub scale: Scale,
    pub series: Vec<Series>,
}

/// One curve.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Series {
    pub name: String,
    pub values: Column,
    /// Column of the time derivatives of the values, if samples contain them. They are used to interpolate between
    /// samples, which may be 0.1 ms and half a millimetre apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rates: Option<Column>,
}

/// An event shown on the page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EventMarker {
    pub time_s: f64,
    /// Name of the contact or of the joint limit.
    #[serde(rename = "place")]
    pub location: String,
    /// Name of the contact in samples, if it differs from `location`, as for a point of a pair of outlines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub point: Option<String>,
    /// Kind of the event.
    pub kind: &'static str,
    /// Approach speed or impulse; `None` if this kind of event has neither.
    pub figure: Option<f64>,
    /// SI unit of the figure.
    pub unit: &'static str,
}

/// Quantities of contacts that a page does not show.
const NOT_SHOWN: [&str; 3] = ["slip_m_s", "impulse_n_s", "sliding_power_w"];

/// Key of a coordinate of a pose, and the function that extracts it.
type Coordinate = (&'static str, fn(&FramePose) -> f64);

const POSITIONS: [Coordinate; 3] =
    [("x_m", |pose| pose.position_m[0]), ("y_m", |pose| pose.position_m[1]), ("angle_rad", |pose| pose.angle_rad)];
const RATES: [Coordinate; 3] = [
    ("vx_m_s", |rate| rate.position_m[0]),
    ("vy_m_s", |rate| rate.position_m[1]),
    ("spin_rad_s", |rate| rate.angle_rad),
];
/// The distinct columns of a run.
#[derive(Default)]
struct ColumnTable {
    columns: Vec<Vec<f64>>,
    indices: HashMap<Vec<u64>, Column>,
}

impl ColumnTable {
    fn push(&mut self, values: impl Iterator<Item = f64>) -> Column {
        let mut values: Vec<f64> = values.collect();
        if values.windows(2).all(|pair| pair[0].to_bits() == pair[1].to_bits()) {
            values.truncate(1);
        }
        let bits = values.iter().map(|value| value.to_bits()).collect();
        *self.indices.entry(bits).or_insert_with(|| {
            self.columns.push(values);
            self.columns.len() - 1
        })
    }
}

/// Builds the playback of a run. `summary` is shown below the playback. A run with more than [`MAX_SAMPLES`] samples is
/// decimated.
///
/// Pairs without contact are omitted if other pairs have contact.
pub fn build_playback(
    label: &str,
    scene: &Scene,
    samples: &[Sample],
    events: &[Event],
    summary: impl Into<Report>,
) -> Playback {
    let schema = Schema::from_scene(scene);
    let contacts = shown_contacts(scene, samples, events);
    let panels = panels(scene, &schema, &contacts);
    let selected = selected_samples(samples, events, &contacts, &panels);

    let mut table = ColumnTable::default();
    let time_s = table.push(selected.iter().map(|sample| sample.time_s));
    let drawing = Drawing::from_scene(scene);
    let poses: Vec<Vec<FramePose>> = selected.iter().map(|sample| drawing.poses(sample)).collect();
    let rates: Vec<Vec<FramePose>> = selected.iter().map(|sample| drawing.velocities(sample)).collect();
    let body = |(index, body): (usize, DrawnBody)| {
        let quantities =
            POSITIONS.iter().map(|quantity| (quantity, &poses)).chain(RATES.iter().map(|rate| (rate, &rates)));
        let column = |((key, value), all): (&Coordinate, &Vec<Vec<FramePose>>)| {
            (key.to_string(), table.push(all.iter().map(|poses| value(&poses[index]))))
        };
        PlayedBody { body, columns: quantities.map(column).collect() }
    };
    let bodies = drawing.bodies.into_iter().enumerate().map(body).collect();
    let contact = |contact: &ShownContact| {
        let states: Vec<_> = selected.iter().map(|sample| contact.state(sample).values()).collect();
        let column = |(index, quantity): (usize, &Quantity)| {
            (quantity.key.to_string(), table.push(states.iter().map(|values| values[index])))
        };
        let quantities = ContactSample::QUANTITIES.iter().enumerate();
        let shown = quantities.filter(|(_, quantity)| !NOT_SHOWN.contains(&quantity.key));
        ContactSeries { name: contact.name.clone(), columns: shown.map(column).collect() }
    };
    let event_marker = |event: &Event| {
        let shown = contacts.iter().find(|contact| contact.contains(event.contact));
        let name = display_name(scene, &schema.contacts[event.contact].name);
        let location = shown.map_or_else(|| name.clone(), |contact| contact.name.clone());
        event_marker(event, location, name, schema.contacts[event.contact].is_angular)
    };
    let event_markers = events.iter().map(event_marker).collect();
    let contacts = contacts.iter().map(contact).collect();
    let panel = |PanelPlan { title, unit, scale, curves }: PanelPlan| {
        let series = curves.into_iter().map(|curve| Series {
            name: curve.name,
            values: table.push(selected.iter().map(|sample| (curve.value)(sample))),
            rates: curve.rate.map(|rate| table.push(selected.iter().map(|sample| rate(sample)))),
        });
        Panel { title, unit, scale, series: series.collect() }
    };
    Playback {
        label: label.to_string(),
        summary: summary.into(),
        grasp: None,
        samples: selected.len(),
        recorded: samples.len(),
        time_s,
        bodies,
        contacts,
        panels: panels.into_iter().map(panel).collect(),
        event_markers,
        arrow_m_per_n: drawing.arrow_m_per_n,
        longest_arrow_m: drawing.longest_arrow_m,
        extent_m: drawing.extent_m,
        is_turned: scene.mechanism.as_ref().is_some_and(|mechanism| mechanism.gravity_m_s2[1] > 0.0),
        columns: table.columns,
    }
}

fn selected_samples<'a>(
    samples: &'a [Sample],
    events: &[Event],
    contacts: &[ShownContact],
    panels: &[PanelPlan],
) -> Vec<&'a Sample> {
    if samples.len() <= MAX_SAMPLES {
        return samples.iter().collect();
    }
    let curves = panels.iter().flat_map(|plan| &plan.curves);
    let values: Vec<Vec<f64>> = curves.map(|curve| samples.iter().map(&curve.value).collect()).collect();
    let force = |sample: &Sample| contacts.iter().map(|contact| contact.state(sample).normal_n).sum();
    let weight: Vec<f64> = samples.iter().map(force).collect();
    let times: Vec<f64> = samples.iter().map(|sample| sample.time_s).collect();
    let events: Vec<f64> = events.iter().map(|event| event.time_s).collect();
    let selected = select_samples(&times, &events, &values, &weight, MAX_SAMPLES);
    selected.into_iter().map(|index| &samples[index]).collect()
}

/// Builds the marker of an event at a shown contact, whose name in samples is `name`; `is_angular` states whether its
/// gap is an angle.
fn event_marker(event: &Event, location: String, name: String, is_angular: bool) -> EventMarker {
    let [speed_unit, impulse_unit] = if is_angular { ["rad/s", "N·m·s"] } else { ["m/s", "N·s"] };
    let (figure, unit) = match event.kind {
        EventKind::TouchDown => (Some(event.approach_speed), speed_unit),
        EventKind::LiftOff => (Some(event.impulse), impulse_unit),
        EventKind::Reload | EventKind::Slips | EventKind::Sticks => (None, ""),
    };
    let point = Some(name).filter(|name| *name != location);
    EventMarker { time_s: event.time_s, location, point, kind: event.kind.name(), figure, unit }
}
