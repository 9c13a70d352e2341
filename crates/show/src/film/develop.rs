//! Everything the page knows of a run: what is drawn, what is plotted, and when something happens.

use serde::{Serialize, Serializer};

use super::thin::{MOST_SAMPLES, kept};
use crate::drawing::{Drawing, Pose, Shape};
use crate::trace::{Event, EventKind, Sample};
use crate::wording::Report;

/// A run as the page shows it. Every list of values has one for each time.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// What tells it from the other run: its model, or the variant.
    pub label: String,
    /// What is said of it below.
    pub summary: Report,
    /// Samples of the run before it was thinned out.
    pub recorded: usize,
    /// In order; two may share one.
    pub times_s: Vec<f64>,
    pub bodies: Vec<Body>,
    pub contacts: Vec<Touch>,
    pub panels: Vec<Panel>,
    pub marks: Vec<Mark>,
    /// Length of a force arrow where arrows are to scale, and the longest.
    pub arrow_m_per_n: f64,
    pub longest_arrow_m: f64,
    /// Lower left and upper right corner of what is to be seen.
    pub extent_m: [[f64; 2]; 2],
}

/// A body and where its frame is. Values over time are `C`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Body<C = Vec<f64>> {
    pub name: String,
    /// Kind of body, for its colour: `driver`, `object`, …
    pub part: &'static str,
    pub fixed: bool,
    pub shapes: Vec<Shape>,
    pub x_m: C,
    pub y_m: C,
    pub angle_rad: C,
    /// How fast these three change, for what lies between samples.
    pub vx_m_s: C,
    pub vy_m_s: C,
    pub spin_rad_s: C,
}

/// A place of contact: as [`ContactSample`](crate::trace::ContactSample) has it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Touch<C = Vec<f64>> {
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
    /// What it is first shown on; the reader may switch.
    #[serde(rename = "logarithmic")]
    pub scale: Scale,
    pub series: Vec<Series<C>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    Linear,
    /// Linear about 0, logarithmic beyond: shows 8 N beside 8 kN, and their signs.
    Logarithmic,
}

/// Whether it is logarithmic.
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
    /// Their time derivative, where a sample has it: without it nobody knows the curve between samples, which may be 0.1 ms
    /// and half a millimetre apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rates: Option<C>,
}

/// Something that happens.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    pub time_s: f64,
    /// Where: a contact, or the joint limit.
    pub place: String,
    /// What.
    pub kind: &'static str,
    /// A figure that says how much, with its SI unit; `None` where there is none.
    pub figure: Option<(f64, &'static str)>,
}

/// How a sample has a number.
pub(super) type Value<'a> = Box<dyn Fn(&Sample) -> f64 + 'a>;

/// A curve before it has values: its name, and how a sample has it and, maybe, its rate.
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

/// A panel before it has values; left out where it has no curves.
pub(super) struct Plan<'a> {
    pub title: &'static str,
    pub unit: &'static str,
    pub scale: Scale,
    pub curves: Vec<Curve<'a>>,
}

pub(super) fn plan<'a>(title: &'static str, unit: &'static str, scale: Scale, curves: Vec<Curve<'a>>) -> Plan<'a> {
    Plan { title, unit, scale, curves }
}

/// Where the bodies of a sample are.
pub(super) type Poses<'a> = Box<dyn Fn(&Sample) -> Vec<Pose> + 'a>;

/// What a scene has to show.
pub(super) struct Shown<'a> {
    pub label: &'a str,
    pub summary: Report,
    pub drawing: Drawing,
    pub samples: &'a [Sample],
    pub poses: Poses<'a>,
    /// Their time derivatives.
    pub motions: Poses<'a>,
    /// Contacts that are drawn: their names, and their indices.
    pub contacts: Vec<(String, usize)>,
    pub panels: Vec<Plan<'a>>,
    pub marks: Vec<Mark>,
}

/// Samples → film, thinned out where they are too many.
pub(super) fn develop(shown: Shown<'_>) -> Film {
    let times: Vec<f64> = shown.samples.iter().map(|sample| sample.time_s).collect();
    let keep = match times.len() <= MOST_SAMPLES {
        true => (0..times.len()).collect(),
        false => thinned(&shown, &times),
    };
    let samples: Vec<&Sample> = keep.iter().map(|&index| &shown.samples[index]).collect();
    let column = |value: &dyn Fn(&Sample) -> f64| samples.iter().map(|sample| value(sample)).collect::<Vec<f64>>();

    let poses: Vec<Vec<Pose>> = samples.iter().map(|sample| (shown.poses)(sample)).collect();
    let motions: Vec<Vec<Pose>> = samples.iter().map(|sample| (shown.motions)(sample)).collect();
    let place = |index: usize, value: fn(&Pose) -> f64| poses.iter().map(|all| value(&all[index])).collect();
    let motion = |index: usize, value: fn(&Pose) -> f64| motions.iter().map(|all| value(&all[index])).collect();
    let body = |(index, body): (usize, crate::drawing::Body)| Body {
        name: body.name,
        part: part(body.part),
        fixed: body.fixed,
        shapes: body.shapes,
        x_m: place(index, |pose| pose.position_m[0]),
        y_m: place(index, |pose| pose.position_m[1]),
        angle_rad: place(index, |pose| pose.angle_rad),
        vx_m_s: motion(index, |rate| rate.position_m[0]),
        vy_m_s: motion(index, |rate| rate.position_m[1]),
        spin_rad_s: motion(index, |rate| rate.angle_rad),
    };
    let touch = |(name, index): &(String, usize)| Touch {
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
    let panel = |plan: &Plan<'_>| Panel {
        title: plan.title.to_string(),
        unit: plan.unit,
        scale: plan.scale,
        series: plan.curves.iter().map(series).collect(),
    };
    Film {
        label: shown.label.to_string(),
        summary: shown.summary,
        recorded: times.len(),
        times_s: keep.iter().map(|&index| times[index]).collect(),
        contacts: shown.contacts.iter().map(touch).collect(),
        panels: shown.panels.iter().filter(|plan| !plan.curves.is_empty()).map(panel).collect(),
        marks: shown.marks,
        arrow_m_per_n: shown.drawing.arrow_m_per_n,
        longest_arrow_m: shown.drawing.longest_arrow_m,
        extent_m: shown.drawing.extent_m,
        bodies: shown.drawing.bodies.into_iter().enumerate().map(body).collect(),
    }
}

fn thinned(shown: &Shown<'_>, times: &[f64]) -> Vec<usize> {
    let curves = shown.panels.iter().flat_map(|plan| &plan.curves);
    let values: Vec<Vec<f64>> = curves.map(|curve| shown.samples.iter().map(&curve.value).collect()).collect();
    let force = |sample: &Sample| shown.contacts.iter().map(|(_, index)| sample.contacts[*index].normal_n).sum();
    let weight: Vec<f64> = shown.samples.iter().map(force).collect();
    let events: Vec<f64> = shown.marks.iter().map(|mark| mark.time_s).collect();
    kept(times, &events, &values, &weight, MOST_SAMPLES)
}

fn part(part: crate::drawing::Part) -> &'static str {
    use crate::drawing::Part;
    match part {
        Part::Driver => "driver",
        Part::Coupler => "coupler",
        Part::Proximal => "proximal",
        Part::Distal => "distal",
        Part::Object => "object",
        Part::Palm => "palm",
        Part::Disc => "disc",
    }
}

/// An event at a place of this name; `angular` is whether its gap is an angle.
pub(super) fn mark(event: &Event, place: &str, angular: bool) -> Mark {
    let [speed_unit, impulse_unit] = if angular { ["rad/s", "N·m·s"] } else { ["m/s", "N·s"] };
    let figure = match event.kind {
        EventKind::TouchDown => Some((event.approach_speed, speed_unit)),
        EventKind::LiftOff => Some((event.impulse, impulse_unit)),
        EventKind::Reload | EventKind::Slips | EventKind::Sticks => None,
    };
    Mark { time_s: event.time_s, place: place.to_string(), kind: event.kind.name(), figure }
}
