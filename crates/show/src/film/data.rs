//! Films → JSON. Each column of numbers is kept once; one that does not change is one number long. A column is named by its index
//! in the run's table. Within a document columns are base64 of little-endian `f64`; beside one they are numbers in a row.

use std::collections::HashMap;

use base64::prelude::{BASE64_STANDARD, Engine};
use serde::Serialize;

use super::develop::{Body, Film, Mark, Panel, Series, Touch};

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
    bodies: Vec<Body<usize>>,
    contacts: Vec<Touch<usize>>,
    panels: Vec<Panel<usize>>,
    events: Vec<Event<'a>>,
    arrow_m_per_n: f64,
    longest_arrow_m: f64,
    extent_m: [[f64; 2]; 2],
    columns: Vec<C>,
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
        bodies: film.bodies.iter().map(|of| body(of, &mut table)).collect(),
        contacts: film.contacts.iter().map(|of| touch(of, &mut table)).collect(),
        panels: film.panels.iter().map(|of| panel(of, &mut table)).collect(),
        events: film.marks.iter().map(event).collect(),
        arrow_m_per_n: film.arrow_m_per_n,
        longest_arrow_m: film.longest_arrow_m,
        extent_m: film.extent_m,
        columns: kept(table.columns),
    }
}

fn body(body: &Body, table: &mut Table) -> Body<usize> {
    Body {
        name: body.name.clone(),
        part: body.part,
        fixed: body.fixed,
        shapes: body.shapes.clone(),
        x_m: table.put(&body.x_m),
        y_m: table.put(&body.y_m),
        angle_rad: table.put(&body.angle_rad),
        vx_m_s: table.put(&body.vx_m_s),
        vy_m_s: table.put(&body.vy_m_s),
        spin_rad_s: table.put(&body.spin_rad_s),
    }
}

fn touch(touch: &Touch, table: &mut Table) -> Touch<usize> {
    Touch {
        name: touch.name.clone(),
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

fn panel(panel: &Panel, table: &mut Table) -> Panel<usize> {
    let mut series = |of: &Series| Series {
        name: of.name.clone(),
        values: table.put(&of.values),
        rates: of.rates.as_ref().map(|rates| table.put(rates)),
    };
    Panel {
        title: panel.title.clone(),
        unit: panel.unit,
        scale: panel.scale,
        series: panel.series.iter().map(&mut series).collect(),
    }
}

fn event(mark: &Mark) -> Event<'_> {
    let (figure, unit) = mark.figure.map_or((None, ""), |(figure, unit)| (Some(figure), unit));
    Event { time_s: mark.time_s, place: &mark.place, kind: mark.kind, figure, unit }
}
