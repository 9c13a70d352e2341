//! Films → JSON. Each column of numbers is kept once; one that does not change is one number long. A column is named by its index
//! in the run's table. Within a document columns are base64 of little-endian `f64`; beside one they are numbers in a row.

use std::collections::HashMap;

use base64::prelude::{BASE64_STANDARD, Engine};
use serde::Serialize;

use super::develop::{Body, Film, Mark, Panel, Scale, Series, Touch};
use crate::drawing::Shape;

#[derive(Serialize)]
struct Document<'a> {
    runs: Vec<Run<'a, String>>,
}

/// A run whose columns are `C`.
#[derive(Serialize)]
pub struct Run<'a, C> {
    label: &'a str,
    /// Samples here, and of the run before it was thinned out.
    samples: usize,
    recorded: usize,
    time_s: usize,
    bodies: Vec<Bodies<'a>>,
    contacts: Vec<Contact<'a>>,
    panels: Vec<Panels<'a>>,
    events: Vec<Event<'a>>,
    arrow_m_per_n: f64,
    longest_arrow_m: f64,
    extent_m: [[f64; 2]; 2],
    columns: Vec<C>,
}

#[derive(Serialize)]
struct Bodies<'a> {
    name: &'a str,
    part: &'static str,
    fixed: bool,
    shapes: Vec<Form<'a>>,
    x_m: usize,
    y_m: usize,
    angle_rad: usize,
    vx_m_s: usize,
    vy_m_s: usize,
    spin_rad_s: usize,
}

#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum Form<'a> {
    Polygon { corners_m: &'a [[f64; 2]] },
    Capsule { from_m: [f64; 2], to_m: [f64; 2], radius_m: f64 },
    Disc { radius_m: f64 },
    HalfPlane { level_m: f64 },
}

#[derive(Serialize)]
struct Contact<'a> {
    name: &'a str,
    gap_m: usize,
    gap_rate_m_s: usize,
    normal_n: usize,
    tangential_n: usize,
    point_x_m: usize,
    point_y_m: usize,
    normal_x: usize,
    normal_y: usize,
}

#[derive(Serialize)]
struct Panels<'a> {
    title: &'a str,
    unit: &'static str,
    logarithmic: bool,
    series: Vec<Line<'a>>,
}

#[derive(Serialize)]
struct Line<'a> {
    name: &'a str,
    values: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    rates: Option<usize>,
}

#[derive(Serialize)]
struct Event<'a> {
    time_s: f64,
    place: &'a str,
    kind: &'static str,
    figure: Option<f64>,
    unit: &'static str,
}

/// The columns of a run; each is there once.
#[derive(Default)]
struct Table {
    columns: Vec<Vec<f64>>,
    known: HashMap<Vec<u64>, usize>,
}

impl Table {
    fn put(&mut self, values: &[f64]) -> usize {
        let first = values.first().map(|value| value.to_bits());
        let constant = values.iter().all(|value| Some(value.to_bits()) == first);
        let written = if constant { &values[..values.len().min(1)] } else { values };
        let bits = written.iter().map(|value| value.to_bits()).collect();
        *self.known.entry(bits).or_insert_with(|| {
            self.columns.push(written.to_vec());
            self.columns.len() - 1
        })
    }
}

/// The JSON document of all runs, with everything in it.
pub fn json(films: &[Film]) -> String {
    let runs = films.iter().map(|film| run(film, |columns| columns.iter().map(|column| base64(column)).collect()));
    // Every key is a text and every number that may be infinite is in a column.
    serde_json::to_string(&Document { runs: runs.collect() }).expect("films can be written")
}

/// One run whose columns are put behind each other into `data`; it has where each begins there, and how long it is.
pub fn beside<'a>(film: &'a Film, data: &mut Vec<f64>) -> Run<'a, [usize; 2]> {
    let mut put = |column: Vec<f64>| {
        data.extend(&column);
        [data.len() - column.len(), column.len()]
    };
    run(film, |columns| columns.into_iter().map(&mut put).collect())
}

fn base64(values: &[f64]) -> String {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    BASE64_STANDARD.encode(bytes)
}

fn run<C>(film: &Film, kept: impl FnOnce(Vec<Vec<f64>>) -> Vec<C>) -> Run<'_, C> {
    let mut table = Table::default();
    Run {
        label: &film.label,
        samples: film.times_s.len(),
        recorded: film.recorded,
        time_s: table.put(&film.times_s),
        bodies: film.bodies.iter().map(|body| bodies(body, &mut table)).collect(),
        contacts: film.contacts.iter().map(|touch| contact(touch, &mut table)).collect(),
        panels: film.panels.iter().map(|panel| panels(panel, &mut table)).collect(),
        events: film.marks.iter().map(event).collect(),
        arrow_m_per_n: film.arrow_m_per_n,
        longest_arrow_m: film.longest_arrow_m,
        extent_m: film.extent_m,
        columns: kept(table.columns),
    }
}

fn bodies<'a>(body: &'a Body, table: &mut Table) -> Bodies<'a> {
    let form = |shape: &'a Shape| match shape {
        Shape::Polygon { corners_m } => Form::Polygon { corners_m },
        Shape::Capsule { from_m, to_m, radius_m } => {
            Form::Capsule { from_m: *from_m, to_m: *to_m, radius_m: *radius_m }
        }
        Shape::Disc { radius_m } => Form::Disc { radius_m: *radius_m },
        Shape::HalfPlane { level_m } => Form::HalfPlane { level_m: *level_m },
    };
    Bodies {
        name: &body.name,
        part: body.part,
        fixed: body.fixed,
        shapes: body.shapes.iter().map(form).collect(),
        x_m: table.put(&body.x_m),
        y_m: table.put(&body.y_m),
        angle_rad: table.put(&body.angle_rad),
        vx_m_s: table.put(&body.vx_m_s),
        vy_m_s: table.put(&body.vy_m_s),
        spin_rad_s: table.put(&body.spin_rad_s),
    }
}

fn contact<'a>(touch: &'a Touch, table: &mut Table) -> Contact<'a> {
    Contact {
        name: &touch.name,
        gap_m: table.put(&touch.gap_m),
        gap_rate_m_s: table.put(&touch.gap_rate_m_s),
        normal_n: table.put(&touch.normal_n),
        tangential_n: table.put(&touch.tangential_n),
        point_x_m: table.put(&touch.point_x_m),
        point_y_m: table.put(&touch.point_y_m),
        normal_x: table.put(&touch.normal_x),
        normal_y: table.put(&touch.normal_y),
    }
}

fn panels<'a>(panel: &'a Panel, table: &mut Table) -> Panels<'a> {
    Panels {
        title: &panel.title,
        unit: panel.unit,
        logarithmic: panel.scale == Scale::Logarithmic,
        series: panel
            .series
            .iter()
            .map(|Series { name, values, rates }| Line {
                name,
                values: table.put(values),
                rates: rates.as_ref().map(|rates| table.put(rates)),
            })
            .collect(),
    }
}

fn event(mark: &Mark) -> Event<'_> {
    let (figure, unit) = mark.figure.map_or((None, ""), |(figure, unit)| (Some(figure), unit));
    Event { time_s: mark.time_s, place: &mark.place, kind: mark.kind, figure, unit }
}
