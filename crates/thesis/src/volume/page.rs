//! Data of the page of volumes as JSON. Columns are little-endian numbers in base64: `f32` for quantities (seven
//! digits; the data file has full precision), `u16` for reasons, bytes for flags.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

use base64::prelude::{BASE64_STANDARD, Engine};
use serde_json::{Value, json};

use super::point::{COLUMNS, DESIGN_COLUMNS, FLAGS, GraspState, Point, Quantity};
use super::{Axes, Volume};
use crate::plot::colours;
use crate::plot::theme::Colour;
use crate::text::column_unit;

/// Maximum number of values of an axis on the page; a finer axis is subsampled.
const MAX_AXIS_VALUES: usize = 40;

/// Returns the data of the page for volumes in the order of [`volumes`](super::volumes), as a JSON document. Equal
/// volumes give equal bytes.
pub fn page_data(volumes: &[Volume]) -> String {
    let Some(first) = volumes.first() else { return "{}".to_string() };
    let of_first_base = volumes.iter().take_while(|volume| volume.base_m == first.base_m);
    let mu_static: Vec<f64> = of_first_base.map(|volume| volume.mu_static).collect();
    let shown = first.axes.all().map(|axis| axis.spaced_indices(MAX_AXIS_VALUES));
    let axes =
        [("l21 in its range", ""), ("φ22", "rad"), ("r_l", "")].into_iter().zip(first.axes.all()).zip(&shown).map(
            |(((name, unit), axis), indices)| {
                let values: Vec<f64> = indices.iter().map(|&index| axis.value(index)).collect();
                json!({ "name": name, "unit": unit, "values": values })
            },
        );
    json!({
        "axes": axes.collect::<Vec<_>>(),
        "bases": volumes.chunks(mu_static.len()).map(|frictions| base(frictions, &shown)).collect::<Vec<_>>(),
        "mu_static": mu_static,
        "quantities": Quantity::ALL.map(quantity),
        "colours": {
            "sequential": hex(&colours::SEQUENTIAL),
            "negative": hex(&colours::NEGATIVE),
            "positive": hex(&colours::POSITIVE),
            "flag": hex(&colours::FLAG),
        },
        "note": note(&first.axes),
    })
    .to_string()
}

/// Describes which of the computed points the page contains.
fn note(axes: &Axes) -> String {
    let [l21, phi22, arm] = axes.resolution();
    let content = match axes.resolution().into_iter().any(|points| points > MAX_AXIS_VALUES) {
        true => {
            "reduced for this page: a subset of the values of each axis, including the first and the last. Shares in the viewer \
             refer to the points shown; the tables below count all points"
        }
        false => "all on this page",
    };
    format!(
        "{l21} × {phi22} × {arm} points per volume, {content}. Numbers on this page have seven digits; the data file has full \
         precision."
    )
}

fn quantity(quantity: Quantity) -> Value {
    let [key, column, name] = quantity.names();
    let (unit, factor) = column_unit(column);
    json!({
        "key": key,
        "column": column,
        "name": name,
        "unit": unit,
        "factor": factor,
        "signed": quantity == Quantity::Pfp,
        "flag": quantity == Quantity::FormClosed,
        "worst": if quantity.is_largest_worst() { "largest" } else { "smallest" },
    })
}

/// Returns the designs of one base. `reason` is 0 for each existing finger, otherwise 1 + the index in `reasons`.
fn base(frictions: &[Volume], shown: &[Vec<usize>; 3]) -> Value {
    let points: Vec<Vec<&Point>> = frictions.iter().map(|volume| shown_points(volume, shown)).collect();
    let mut reasons: Vec<String> = Vec::new();
    let mut numbers: HashMap<String, u16> = HashMap::new();
    let reason = points[0].iter().flat_map(|point| {
        let number = point.as_ref().err().map_or(0, |error| {
            *numbers.entry(error.to_string()).or_insert_with_key(|text| {
                reasons.push(text.clone());
                u16::try_from(reasons.len()).unwrap_or(u16::MAX)
            })
        });
        number.to_le_bytes()
    });
    let reason = BASE64_STANDARD.encode(reason.collect::<Vec<u8>>());
    let friction = |points: &Vec<&Point>| {
        // The first flag is the lowest bit, as in the scripts of the page.
        let bits = |state: &GraspState| FLAGS.iter().rev().fold(0, |bits, (_, test)| 2 * bits + u8::from(test(state)));
        let flags: Vec<u8> = points.iter().map(|point| point.as_ref().map_or(0, bits)).collect();
        json!({ "flags": BASE64_STANDARD.encode(flags), "columns": columns(DESIGN_COLUMNS..COLUMNS.len(), points) })
    };
    json!({
        "base_m": frictions[0].base_m,
        "columns": columns(0..DESIGN_COLUMNS, &points[0]),
        "reason": reason,
        "reasons": reasons,
        "frictions": points.iter().map(friction).collect::<Vec<_>>(),
    })
}

/// Returns the points at the given indices along each axis, in the order of the volume.
fn shown_points<'a>(volume: &'a Volume, [l21, phi22, arm]: &[Vec<usize>; 3]) -> Vec<&'a Point> {
    let mut points = Vec::with_capacity(l21.len() * phi22.len() * arm.len());
    for &i in l21 {
        for &j in phi22 {
            points.extend(arm.iter().map(|&k| &volume.points[volume.axes.index([i, j, k])]));
        }
    }
    points
}

/// Returns some of the [`COLUMNS`] by name.
fn columns(range: Range<usize>, points: &[&Point]) -> BTreeMap<&'static str, String> {
    let encode = |value: fn(&GraspState) -> f64| {
        let values = points.iter().map(|point| point.as_ref().map_or(f64::NAN, value) as f32);
        BASE64_STANDARD.encode(values.flat_map(f32::to_le_bytes).collect::<Vec<u8>>())
    };
    COLUMNS[range].iter().map(|&(name, value)| (name, encode(value))).collect()
}

fn hex(colours: &[Colour]) -> Vec<String> {
    colours.iter().map(|colour| colour.to_string().to_lowercase()).collect()
}
