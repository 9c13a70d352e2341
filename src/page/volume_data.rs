//! Volumes → JSON. Columns are base64 of little-endian numbers: `f32` for quantities (seven digits: the data file has all),
//! `u16` for reasons, bytes for flags.

use std::collections::{BTreeMap, HashMap};

use base64::prelude::{BASE64_STANDARD, Engine};
use serde::Serialize;

use crate::plot::colours;
use crate::plot::theme::Colour;
use crate::study::volume::{Axes, Point, Quantity, Sized, Volume, Worst};
use crate::wording;

/// Most values an axis has on the page; finer ones are thinned out.
pub const MOST_VALUES: usize = 40;

/// Bits of a point's flags, as the page's scripts have them.
const STABLE: u8 = 1;
const PALM: u8 = 2;
const CLOSED: u8 = 4;

#[derive(Serialize)]
struct Document<'a> {
    axes: [AxisData; 3],
    mu_static: Vec<f64>,
    quantities: [QuantityData; 7],
    colours: Colours,
    bases: Vec<Base>,
    /// How points became what is seen.
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
struct Base {
    base_m: f64,
    columns: BTreeMap<&'static str, String>,
    /// One more than the index of the reason why there is no finger; 0 where there is one.
    reason: String,
    reasons: Vec<String>,
    frictions: Vec<Friction>,
}

#[derive(Serialize)]
struct Friction {
    flags: String,
    columns: BTreeMap<&'static str, String>,
}

/// The document of volumes as they come from [`volumes`](crate::study::volume::volumes): bases slowest.
pub fn json(volumes: &[Volume], note: &str) -> String {
    let Some(first) = volumes.first() else { return "{}".to_string() };
    let mu_static: Vec<f64> =
        volumes.iter().take_while(|volume| volume.base_m == first.base_m).map(|volume| volume.mu_static).collect();
    let kept = kept(&first.axes);
    let Axes { l21_fraction, phi22_rad, arm_ratio } = &first.axes;
    let [l21, phi22, arm] = &kept;
    let values =
        |axis: &crate::study::volume::Axis, indices: &[usize]| indices.iter().map(|&i| axis.value(i)).collect();
    let document = Document {
        axes: [
            AxisData { name: "l21 in its range", unit: "", values: values(l21_fraction, l21) },
            AxisData { name: "φ22", unit: "rad", values: values(phi22_rad, phi22) },
            AxisData { name: "r_l", unit: "", values: values(arm_ratio, arm) },
        ],
        quantities: Quantity::ALL.map(quantity),
        colours: Colours {
            sequential: hex(&colours::SEQUENTIAL),
            negative: hex(&colours::NEGATIVE),
            positive: hex(&colours::POSITIVE),
            flag: hex(&colours::FLAG),
        },
        bases: volumes.chunks(mu_static.len()).map(|frictions| base(frictions, &kept)).collect(),
        mu_static,
        note,
    };
    serde_json::to_string(&document).expect("plain data with string keys")
}

/// The indices along each axis that are on the page.
fn kept(axes: &Axes) -> [Vec<usize>; 3] {
    [&axes.l21_fraction, &axes.phi22_rad, &axes.arm_ratio].map(|axis| axis.spread(MOST_VALUES))
}

/// Whether the page shows fewer points than there are.
pub fn is_thinned(axes: &Axes) -> bool {
    axes.resolution().into_iter().any(|points| points > MOST_VALUES)
}

fn quantity(quantity: Quantity) -> QuantityData {
    let shown = wording::Quantity::of(quantity.column());
    QuantityData {
        key: quantity.key(),
        column: quantity.column(),
        name: quantity.name(),
        unit: shown.unit,
        factor: shown.scale,
        signed: quantity == Quantity::Pfp,
        flag: quantity == Quantity::FormClosed,
        worst: match quantity.worst() {
            Worst::Smallest => "smallest",
            Worst::Largest => "largest",
        },
    }
}

/// A quantity of a design, whatever the friction.
type OfDesign = fn(&Sized) -> f64;

fn base(frictions: &[Volume], kept: &[Vec<usize>; 3]) -> Base {
    let points: Vec<Vec<&Point>> = frictions.iter().map(|volume| picked(volume, kept)).collect();
    let of_design = |value: OfDesign| {
        floats(points[0].iter().map(|point| point.state.as_ref().map_or(f64::NAN, |state| value(&state.sized))))
    };
    let columns: [(&'static str, OfDesign); 8] = [
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
    let mut places: HashMap<String, u16> = HashMap::new();
    let reason = points[0].iter().flat_map(|point| {
        let place = point.state.as_ref().err().map_or(0, |error| {
            let text = error.to_string();
            *places.entry(text).or_insert_with_key(|text| {
                reasons.push(text.clone());
                u16::try_from(reasons.len()).unwrap_or(u16::MAX)
            })
        });
        place.to_le_bytes()
    });
    let reason = BASE64_STANDARD.encode(reason.collect::<Vec<u8>>());
    Base {
        base_m: frictions[0].base_m,
        columns: columns.into_iter().map(|(name, value)| (name, of_design(value))).collect(),
        reason,
        reasons,
        frictions: points.iter().map(|points| friction(points)).collect(),
    }
}

fn friction(points: &[&Point]) -> Friction {
    let flags = points.iter().map(|point| {
        point.state.as_ref().map_or(0, |state| {
            let set = |is: bool, bit: u8| if is { bit } else { 0 };
            set(state.is_stable(), STABLE)
                | set(state.forces.is_palm_force_positive(), PALM)
                | set(state.sized.form_closed, CLOSED)
        })
    });
    let flags = BASE64_STANDARD.encode(flags.collect::<Vec<u8>>());
    let column = |quantity: Quantity| {
        let values = points.iter().map(|point| point.state.as_ref().map_or(f64::NAN, |state| quantity.value(state)));
        (quantity.column(), floats(values))
    };
    Friction { flags, columns: [Quantity::F21, Quantity::F22, Quantity::Pfp].map(column).into_iter().collect() }
}

/// The points at the kept indices, in the order of the volume.
fn picked<'a>(volume: &'a Volume, [l21, phi22, arm]: &[Vec<usize>; 3]) -> Vec<&'a Point> {
    let mut points = Vec::with_capacity(l21.len() * phi22.len() * arm.len());
    for &i in l21 {
        for &j in phi22 {
            points.extend(arm.iter().map(|&k| volume.point([i, j, k])));
        }
    }
    points
}

fn floats(values: impl Iterator<Item = f64>) -> String {
    BASE64_STANDARD.encode(values.flat_map(|value| (value as f32).to_le_bytes()).collect::<Vec<u8>>())
}

fn hex(colours: &[Colour]) -> Vec<String> {
    colours.iter().map(|colour| colour.to_string().to_lowercase()).collect()
}
