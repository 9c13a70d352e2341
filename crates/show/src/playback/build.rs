//! The data of a run that a page shows: bodies, plotted curves and events.

use serde::{Serialize, Serializer};

use super::decimate::{MAX_SAMPLES, select_samples};
use crate::drawing::{Drawing, Pose, Shape};
use crate::format::Report;
use crate::trace::{Event, EventKind, Sample};

/// A run as the page shows it. Every list of values has one value per time.
#[derive(Clone, Debug, PartialEq)]
pub struct Playback {
    /// Label that distinguishes the runs of a page: the model or the variant.
    pub label: String,
    /// Summary of the run, shown below the animation.
    pub summary: Report,
    /// Number of samples of the run before decimation.
    pub recorded: usize,
    /// Times of the samples, ascending; two samples may have the same time.
    pub times_s: Vec<f64>,
    pub bodies: Vec<Body>,
    pub contacts: Vec<ContactSeries>,
    pub panels: Vec<Panel>,
    pub event_markers: Vec<EventMarker>,
    /// Length of a force arrow per newton, where arrows are to scale.
    pub arrow_m_per_n: f64,
    /// Maximum length of a force arrow.
    pub longest_arrow_m: f64,
    /// Lower left and upper right corner of the view.
    pub extent_m: [[f64; 2]; 2],
}

/// A body and the pose of its frame. Values over time are `C`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Body<C = Vec<f64>> {
    pub name: String,
    /// Kind of body, which decides its colour: `driver`, `object`, …
    #[serde(rename = "part")]
    pub role: &'static str,
    pub fixed: bool,
    pub shapes: Vec<Shape>,
    pub x_m: C,
    pub y_m: C,
    pub angle_rad: C,
    /// Time derivatives of these three, for interpolation between samples.
    pub vx_m_s: C,
    pub vy_m_s: C,
    pub spin_rad_s: C,
}

/// A contact over time, with the quantities of a [`ContactSample`](crate::trace::ContactSample).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactSeries<C = Vec<f64>> {
    pub name: String,
    pub gap_m: C,
    pub gap_rate_m_s: C,
    pub normal_n: C,
    pub tangential_n: C,
    pub point_x_m: C,
    pub point_y_m: C,
    pub normal_x: C,
    pub normal_y: C,
}

/// Curves that share an axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Panel<C = Vec<f64>> {
    pub title: String,
    /// SI unit of its values, such as `rad`, `N`, `m`, `J`.
    pub unit: &'static str,
    /// Initial scale; the reader may switch.
    #[serde(rename = "logarithmic")]
    pub scale: Scale,
    pub series: Vec<Series<C>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    Linear,
    /// Linear about 0, logarithmic beyond: shows 8 N and 8 kN in one plot, with their signs.
    Logarithmic,
}

/// Serialised as whether the scale is logarithmic.
impl Serialize for Scale {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bool(*self == Scale::Logarithmic)
    }
}

/// One curve.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Series<C = Vec<f64>> {
    pub name: String,
    pub values: C,
    /// Time derivatives of the values, if samples have them. They are needed to interpolate between samples, which may
    /// be 0.1 ms and half a millimetre apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rates: Option<C>,
}

/// An event shown on the page.
#[derive(Clone, Debug, PartialEq)]
pub struct EventMarker {
    pub time_s: f64,
    /// Name of the contact or of the joint limit.
    pub location: String,
    /// Kind of event.
    pub kind: &'static str,
    /// Approach speed or impulse with its SI unit, if the kind of event has one.
    pub figure: Option<(f64, &'static str)>,
}

/// Function that extracts a number from a sample.
pub(super) type Value<'a> = Box<dyn Fn(&Sample) -> f64 + 'a>;

/// A curve before evaluation: its name and the functions that extract its value and, optionally, its rate from a
/// sample.
pub(super) struct Curve<'a> {
    pub name: String,
    pub value: Value<'a>,
    pub rate: Option<Value<'a>>,
}

impl<'a> Curve<'a> {
    pub fn new(name: impl Into<String>, value: impl Fn(&Sample) -> f64 + 'a) -> Self {
        Curve { name: name.into(), value: Box::new(value), rate: None }
    }

    pub fn with_rate(self, rate: impl Fn(&Sample) -> f64 + 'a) -> Self {
        Curve { rate: Some(Box::new(rate)), ..self }
    }
}

/// A panel before evaluation; omitted if it has no curves.
pub(super) struct PanelPlan<'a> {
    pub title: &'static str,
    pub unit: &'static str,
    pub scale: Scale,
    pub curves: Vec<Curve<'a>>,
}

pub(super) fn panel_plan<'a>(
    title: &'static str,
    unit: &'static str,
    scale: Scale,
    curves: Vec<Curve<'a>>,
) -> PanelPlan<'a> {
    PanelPlan { title, unit, scale, curves }
}

/// Returns the poses of all bodies in a sample.
pub(super) type Poses<'a> = Box<dyn Fn(&Sample) -> Vec<Pose> + 'a>;

/// Input of [`build`]: the samples of a run and how to show them.
pub(super) struct PlaybackSource<'a> {
    pub label: &'a str,
    pub summary: Report,
    pub drawing: Drawing,
    pub samples: &'a [Sample],
    pub poses: Poses<'a>,
    /// Time derivatives of the poses.
    pub motions: Poses<'a>,
    /// Names and indices of the contacts that are drawn.
    pub contacts: Vec<(String, usize)>,
    pub panels: Vec<PanelPlan<'a>>,
    pub event_markers: Vec<EventMarker>,
}

/// Builds the playback of a run; more than [`MAX_SAMPLES`] samples are decimated.
pub(super) fn build(source: PlaybackSource<'_>) -> Playback {
    let times: Vec<f64> = source.samples.iter().map(|sample| sample.time_s).collect();
    let selected = match times.len() <= MAX_SAMPLES {
        true => (0..times.len()).collect(),
        false => thin_out(&source, &times),
    };
    let samples: Vec<&Sample> = selected.iter().map(|&index| &source.samples[index]).collect();
    let column = |value: &dyn Fn(&Sample) -> f64| samples.iter().map(|sample| value(sample)).collect::<Vec<f64>>();

    let poses: Vec<Vec<Pose>> = samples.iter().map(|sample| (source.poses)(sample)).collect();
    let motions: Vec<Vec<Pose>> = samples.iter().map(|sample| (source.motions)(sample)).collect();
    let pose_column = |index: usize, value: fn(&Pose) -> f64| poses.iter().map(|all| value(&all[index])).collect();
    let rate_column = |index: usize, value: fn(&Pose) -> f64| motions.iter().map(|all| value(&all[index])).collect();
    let body = |(index, body): (usize, crate::drawing::Body)| Body {
        name: body.name,
        role: role_name(body.role),
        fixed: body.fixed,
        shapes: body.shapes,
        x_m: pose_column(index, |pose| pose.position_m[0]),
        y_m: pose_column(index, |pose| pose.position_m[1]),
        angle_rad: pose_column(index, |pose| pose.angle_rad),
        vx_m_s: rate_column(index, |rate| rate.position_m[0]),
        vy_m_s: rate_column(index, |rate| rate.position_m[1]),
        spin_rad_s: rate_column(index, |rate| rate.angle_rad),
    };
    let touch = |(name, index): &(String, usize)| ContactSeries {
        name: name.clone(),
        gap_m: column(&|sample| sample.contacts[*index].gap_m),
        gap_rate_m_s: column(&|sample| sample.contacts[*index].gap_rate_m_s),
        normal_n: column(&|sample| sample.contacts[*index].normal_n),
        tangential_n: column(&|sample| sample.contacts[*index].tangential_n),
        point_x_m: column(&|sample| sample.contacts[*index].point_m[0]),
        point_y_m: column(&|sample| sample.contacts[*index].point_m[1]),
        normal_x: column(&|sample| sample.contacts[*index].normal[0]),
        normal_y: column(&|sample| sample.contacts[*index].normal[1]),
    };
    let series = |Curve { name, value, rate }: &Curve<'_>| Series {
        name: name.clone(),
        values: column(value.as_ref()),
        rates: rate.as_ref().map(|rate| column(rate.as_ref())),
    };
    let panel = |plan: &PanelPlan<'_>| Panel {
        title: plan.title.to_string(),
        unit: plan.unit,
        scale: plan.scale,
        series: plan.curves.iter().map(series).collect(),
    };
    Playback {
        label: source.label.to_string(),
        summary: source.summary,
        recorded: times.len(),
        times_s: selected.iter().map(|&index| times[index]).collect(),
        contacts: source.contacts.iter().map(touch).collect(),
        panels: source.panels.iter().filter(|plan| !plan.curves.is_empty()).map(panel).collect(),
        event_markers: source.event_markers,
        arrow_m_per_n: source.drawing.arrow_m_per_n,
        longest_arrow_m: source.drawing.longest_arrow_m,
        extent_m: source.drawing.extent_m,
        bodies: source.drawing.bodies.into_iter().enumerate().map(body).collect(),
    }
}

fn thin_out(source: &PlaybackSource<'_>, times: &[f64]) -> Vec<usize> {
    let curves = source.panels.iter().flat_map(|plan| &plan.curves);
    let values: Vec<Vec<f64>> = curves.map(|curve| source.samples.iter().map(&curve.value).collect()).collect();
    let force = |sample: &Sample| source.contacts.iter().map(|(_, index)| sample.contacts[*index].normal_n).sum();
    let weight: Vec<f64> = source.samples.iter().map(force).collect();
    let events: Vec<f64> = source.event_markers.iter().map(|marker| marker.time_s).collect();
    select_samples(times, &events, &values, &weight, MAX_SAMPLES)
}

fn role_name(role: crate::drawing::BodyRole) -> &'static str {
    use crate::drawing::BodyRole;
    match role {
        BodyRole::Driver => "driver",
        BodyRole::Coupler => "coupler",
        BodyRole::Proximal => "proximal",
        BodyRole::Distal => "distal",
        BodyRole::Object => "object",
        BodyRole::Palm => "palm",
        BodyRole::Disc => "disc",
    }
}

/// Builds the marker of an event at the contact `location`; `is_angular` states whether its gap is an angle.
pub(super) fn event_marker(event: &Event, location: &str, is_angular: bool) -> EventMarker {
    let [speed_unit, impulse_unit] = if is_angular { ["rad/s", "N·m·s"] } else { ["m/s", "N·s"] };
    let figure = match event.kind {
        EventKind::TouchDown => Some((event.approach_speed, speed_unit)),
        EventKind::LiftOff => Some((event.impulse, impulse_unit)),
        EventKind::Reload | EventKind::Slips | EventKind::Sticks => None,
    };
    EventMarker { time_s: event.time_s, location: location.to_string(), kind: event.kind.name(), figure }
}
