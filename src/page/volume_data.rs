//! Volumes → JSON. Columns are little-endian numbers in base64: `f32` for quantities (seven digits; the data file has
//! full precision), `u16` for reasons, bytes for flags.

use std::collections::{BTreeMap, HashMap};

use base64::prelude::{BASE64_STANDARD, Engine};
use serde::Serialize;

use crate::format;
use crate::plot::colours;
use crate::plot::theme::Colour;
use crate::study::volume::{Axes, Point, Quantity, SizedFinger, Volume, WorstCase};

/// Maximum number of values of an axis on the page; a finer axis is subsampled.
pub const MAX_AXIS_VALUES: usize = 40;

/// Flag of a point with a stable grasp. The scripts of the page define the same flags.
const FLAG_STABLE: u8 = 1;
/// Flag of a point at which the palm force is positive.
const FLAG_PALM: u8 = 2;
/// Flag of a point with form closure.
const FLAG_CLOSED: u8 = 4;

#[derive(Serialize)]
struct Document<'a> {
    axes: [AxisData; 3],
    mu_static: Vec<f64>,
    quantities: [QuantityData; 7],
    colours: Colours,
    bases: Vec<BaseData>,
    /// Which of the computed points are included.
    note: &'a str,
}

#[derive(Serialize)]
struct AxisData {
    name: &'static str,
    unit: &'static str,
    values: Vec<f64>,
}

#[derive(Serialize)]
struct QuantityData {
    key: &'static str,
    column: &'static str,
    name: &'static str,
    unit: &'static str,
    factor: f64,
    signed: bool,
    flag: bool,
    worst: &'static str,
}

#[derive(Serialize)]
struct Colours {
    sequential: Vec<String>,
    negative: Vec<String>,
    positive: Vec<String>,
    flag: Vec<String>,
}

/// The designs of one base.
#[derive(Serialize)]
struct BaseData {
    base_m: f64,
    columns: BTreeMap<&'static str, String>,
    /// For each point: 0 if the finger exists, otherwise 1 + the index in `reasons`.
    reason: String,
    reasons: Vec<String>,
    frictions: Vec<FrictionData>,
}

#[derive(Serialize)]
struct FrictionData {
    flags: String,
    columns: BTreeMap<&'static str, String>,
}

/// Serialises volumes in the order of [`volumes`](crate::study::volume::volumes): the base varies slowest.
pub fn to_json(volumes: &[Volume], note: &str) -> String {
    let Some(first) = volumes.first() else { return "{}".to_string() };
    let mu_static: Vec<f64> =
        volumes.iter().take_while(|volume| volume.base_m == first.base_m).map(|volume| volume.mu_static).collect();
    let shown_indices = shown_indices(&first.axes);
    let Axes { l21_fraction, phi22_rad, arm_ratio } = &first.axes;
    let [l21, phi22, arm] = &shown_indices;
    let values =
        |axis: &crate::study::volume::Axis, indices: &[usize]| indices.iter().map(|&i| axis.value(i)).collect();
    let document = Document {
        axes: [
            AxisData { name: "l21 in its range", unit: "", values: values(l21_fraction, l21) },
            AxisData { name: "φ22", unit: "rad", values: values(phi22_rad, phi22) },
            AxisData { name: "r_l", unit: "", values: values(arm_ratio, arm) },
        ],
        quantities: Quantity::ALL.map(quantity_data),
        colours: Colours {
            sequential: hex_colours(&colours::SEQUENTIAL),
            negative: hex_colours(&colours::NEGATIVE),
            positive: hex_colours(&colours::POSITIVE),
            flag: hex_colours(&colours::FLAG),
        },
        bases: volumes.chunks(mu_static.len()).map(|frictions| base_data(frictions, &shown_indices)).collect(),
        mu_static,
        note,
    };
    serde_json::to_string(&document).expect("plain data with string keys")
}

/// Indices along each axis that are included in the page.
fn shown_indices(axes: &Axes) -> [Vec<usize>; 3] {
    [&axes.l21_fraction, &axes.phi22_rad, &axes.arm_ratio].map(|axis| axis.spaced_indices(MAX_AXIS_VALUES))
}

/// Whether the page contains only a subset of the points.
pub fn is_thinned(axes: &Axes) -> bool {
    axes.resolution().into_iter().any(|points| points > MAX_AXIS_VALUES)
}

fn quantity_data(quantity: Quantity) -> QuantityData {
    let displayed = format::Quantity::for_column(quantity.column());
    QuantityData {
        key: quantity.key(),
        column: quantity.column(),
        name: quantity.name(),
        unit: displayed.unit,
        factor: displayed.scale,
        signed: quantity == Quantity::Pfp,
        flag: quantity == Quantity::FormClosed,
        worst: match quantity.worst() {
            WorstCase::Smallest => "smallest",
            WorstCase::Largest => "largest",
        },
    }
}

/// A quantity of a design that does not depend on friction.
type DesignValue = fn(&SizedFinger) -> f64;

fn base_data(frictions: &[Volume], shown_indices: &[Vec<usize>; 3]) -> BaseData {
    let points: Vec<Vec<&Point>> = frictions.iter().map(|volume| select_points(volume, shown_indices)).collect();
    let design_column = |value: DesignValue| {
        encode_f32(points[0].iter().map(|point| point.state.as_ref().map_or(f64::NAN, |state| value(&state.sized))))
    };
    let columns: [(&'static str, DesignValue); 8] = [
        ("l11_m", |sized| sized.lengths.l11_m),
        ("l12_m", |sized| sized.lengths.l12_m),
        ("l21_m", |sized| sized.lengths.l21_m),
        ("l22_m", |sized| sized.lengths.l22_m),
        ("t22_m", |sized| sized.lengths.t22_m),
        ("mass_kg", |sized| sized.mass_kg),
        ("motor_n_m", |sized| sized.sizing.motor_n_m),
        ("spring_n_m", |sized| sized.sizing.spring_n_m),
    ];
    let mut reasons: Vec<String> = Vec::new();
    let mut reason_indices: HashMap<String, u16> = HashMap::new();
    let reason = points[0].iter().flat_map(|point| {
        let reason_index = point.state.as_ref().err().map_or(0, |error| {
            let text = error.to_string();
            *reason_indices.entry(text).or_insert_with_key(|text| {
                reasons.push(text.clone());
                u16::try_from(reasons.len()).unwrap_or(u16::MAX)
            })
        });
        reason_index.to_le_bytes()
    });
    let reason = BASE64_STANDARD.encode(reason.collect::<Vec<u8>>());
    BaseData {
        base_m: frictions[0].base_m,
        columns: columns.into_iter().map(|(name, value)| (name, design_column(value))).collect(),
        reason,
        reasons,
        frictions: points.iter().map(|points| friction_data(points)).collect(),
    }
}

fn friction_data(points: &[&Point]) -> FrictionData {
    let flags = points.iter().map(|point| {
        point.state.as_ref().map_or(0, |state| {
            let set = |flag: bool, bit: u8| if flag { bit } else { 0 };
            set(state.is_stable(), FLAG_STABLE)
                | set(state.forces.is_palm_force_positive(), FLAG_PALM)
                | set(state.sized.form_closed, FLAG_CLOSED)
        })
    });
    let flags = BASE64_STANDARD.encode(flags.collect::<Vec<u8>>());
    let column = |quantity: Quantity| {
        let values = points.iter().map(|point| point.state.as_ref().map_or(f64::NAN, |state| quantity.value(state)));
        (quantity.column(), encode_f32(values))
    };
    FrictionData { flags, columns: [Quantity::F21, Quantity::F22, Quantity::Pfp].map(column).into_iter().collect() }
}

/// Returns the points at the given indices, in the order of the volume.
fn select_points<'a>(volume: &'a Volume, [l21, phi22, arm]: &[Vec<usize>; 3]) -> Vec<&'a Point> {
    let mut points = Vec::with_capacity(l21.len() * phi22.len() * arm.len());
    for &i in l21 {
        for &j in phi22 {
            points.extend(arm.iter().map(|&k| volume.point([i, j, k])));
        }
    }
    points
}

fn encode_f32(values: impl Iterator<Item = f64>) -> String {
    BASE64_STANDARD.encode(values.flat_map(|value| (value as f32).to_le_bytes()).collect::<Vec<u8>>())
}

fn hex_colours(colours: &[Colour]) -> Vec<String> {
    colours.iter().map(|colour| colour.to_string().to_lowercase()).collect()
}
