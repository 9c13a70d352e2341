//! Writes playbacks as JSON. Equal columns of numbers are stored once, and a constant column has a single number.
//! Columns are referenced by their index in the run's table. In a document they are base64 of little-endian `f64`;
//! outside of one they are consecutive numbers in an array.

use std::collections::HashMap;

use base64::prelude::{BASE64_STANDARD, Engine};
use serde::Serialize;

use super::build::{Body, ContactSeries, EventMarker, Panel, Playback, Series};

#[derive(Serialize)]
struct Document<'a> {
    runs: Vec<Run<'a, String>>,
}

/// A run with columns of type `C`.
#[derive(Serialize)]
pub struct Run<'a, C> {
    label: &'a str,
    /// Number of samples in this document.
    samples: usize,
    /// Number of samples of the run before decimation.
    recorded: usize,
    time_s: usize,
    bodies: Vec<Body<usize>>,
    contacts: Vec<ContactSeries<usize>>,
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
    #[serde(rename = "place")]
    location: &'a str,
    kind: &'static str,
    figure: Option<f64>,
    unit: &'static str,
}

/// The distinct columns of a run.
#[derive(Default)]
struct ColumnTable {
    columns: Vec<Vec<f64>>,
    indices: HashMap<Vec<u64>, usize>,
}

impl ColumnTable {
    fn push_column(&mut self, values: &[f64]) -> usize {
        let first = values.first().map(|value| value.to_bits());
        let constant = values.iter().all(|value| Some(value.to_bits()) == first);
        let stored_values = if constant { &values[..values.len().min(1)] } else { values };
        let bits = stored_values.iter().map(|value| value.to_bits()).collect();
        *self.indices.entry(bits).or_insert_with(|| {
            self.columns.push(stored_values.to_vec());
            self.columns.len() - 1
        })
    }
}

/// Returns the self-contained JSON document of all runs.
pub fn to_json(playbacks: &[Playback]) -> String {
    let runs =
        playbacks.iter().map(|playback| run(playback, |columns| columns.iter().map(|column| base64(column)).collect()));
    // Serialisation cannot fail: every key is a string, and every number that may be infinite is in a column.
    serde_json::to_string(&Document { runs: runs.collect() }).expect("a playback is plain data with string keys")
}

/// Appends the columns of a run to `data` and returns the run, which refers to each column by its offset and length.
pub fn append_run<'a>(playback: &'a Playback, data: &mut Vec<f64>) -> Run<'a, [usize; 2]> {
    let mut push_column = |column: Vec<f64>| {
        data.extend(&column);
        [data.len() - column.len(), column.len()]
    };
    run(playback, |columns| columns.into_iter().map(&mut push_column).collect())
}

fn base64(values: &[f64]) -> String {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    BASE64_STANDARD.encode(bytes)
}

fn run<C>(playback: &Playback, encode: impl FnOnce(Vec<Vec<f64>>) -> Vec<C>) -> Run<'_, C> {
    let mut table = ColumnTable::default();
    Run {
        label: &playback.label,
        samples: playback.times_s.len(),
        recorded: playback.recorded,
        time_s: table.push_column(&playback.times_s),
        bodies: playback.bodies.iter().map(|item| body(item, &mut table)).collect(),
        contacts: playback.contacts.iter().map(|item| contact(item, &mut table)).collect(),
        panels: playback.panels.iter().map(|item| panel(item, &mut table)).collect(),
        events: playback.event_markers.iter().map(event).collect(),
        arrow_m_per_n: playback.arrow_m_per_n,
        longest_arrow_m: playback.longest_arrow_m,
        extent_m: playback.extent_m,
        columns: encode(table.columns),
    }
}

fn body(body: &Body, table: &mut ColumnTable) -> Body<usize> {
    Body {
        name: body.name.clone(),
        role: body.role,
        fixed: body.fixed,
        shapes: body.shapes.clone(),
        x_m: table.push_column(&body.x_m),
        y_m: table.push_column(&body.y_m),
        angle_rad: table.push_column(&body.angle_rad),
        vx_m_s: table.push_column(&body.vx_m_s),
        vy_m_s: table.push_column(&body.vy_m_s),
        spin_rad_s: table.push_column(&body.spin_rad_s),
    }
}

fn contact(contact: &ContactSeries, table: &mut ColumnTable) -> ContactSeries<usize> {
    ContactSeries {
        name: contact.name.clone(),
        gap_m: table.push_column(&contact.gap_m),
        gap_rate_m_s: table.push_column(&contact.gap_rate_m_s),
        normal_n: table.push_column(&contact.normal_n),
        tangential_n: table.push_column(&contact.tangential_n),
        point_x_m: table.push_column(&contact.point_x_m),
        point_y_m: table.push_column(&contact.point_y_m),
        normal_x: table.push_column(&contact.normal_x),
        normal_y: table.push_column(&contact.normal_y),
    }
}

fn panel(panel: &Panel, table: &mut ColumnTable) -> Panel<usize> {
    let mut series = |source: &Series| Series {
        name: source.name.clone(),
        values: table.push_column(&source.values),
        rates: source.rates.as_ref().map(|rates| table.push_column(rates)),
    };
    Panel {
        title: panel.title.clone(),
        unit: panel.unit,
        scale: panel.scale,
        series: panel.series.iter().map(&mut series).collect(),
    }
}

fn event(marker: &EventMarker) -> Event<'_> {
    let (figure, unit) = marker.figure.map_or((None, ""), |(figure, unit)| (Some(figure), unit));
    Event { time_s: marker.time_s, location: &marker.location, kind: marker.kind, figure, unit }
}
