//! Values of the flags of `phalanx volume`.

use clap::ValueEnum;
use clap::builder::PossibleValue;

use crate::limits::MOST_THREADS;
use crate::study::volume::Quantity;
use crate::units::{self, Dimension};

/// Values of one flag, in the order given.
#[derive(Clone, Debug, PartialEq)]
pub struct List(pub Vec<f64>);

/// Limits of an axis, the lower one first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits(pub f64, pub f64);

/// Points along the three axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resolution(pub [usize; 3]);

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DataArg {
    /// Comma-separated values: text that everything reads
    Csv,
    /// Columns in binary: smaller, and read at once by data tools
    Parquet,
}

impl ValueEnum for Quantity {
    fn value_variants<'a>() -> &'a [Self] {
        &Quantity::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let help = match self {
            Quantity::Pfp => "Palm force positiveness, N: below 0 the fingers would pull the object off the palm",
            Quantity::F21 => "Normal force of the proximal phalanx, N",
            Quantity::F22 => "Normal force of the distal phalanx, N",
            Quantity::Spring => "Torque of the spring, N·mm",
            Quantity::Motor => "Torque of the motor, N·mm",
            Quantity::Mass => "Mass of a finger, g",
            Quantity::FormClosed => "Whether the object cannot move even without friction",
        };
        Some(PossibleValue::new(self.key()).help(help))
    }
}

/// Lengths between commas.
pub fn bases(text: &str) -> Result<List, String> {
    list(text, "lengths such as \"12 mm, 15.5 mm\"", |item| match units::parse(item, Dimension::Length) {
        Ok(base_m) if base_m > 0.0 => Ok(base_m),
        Ok(_) => Err(format!("`{item}`: a base must be more than 0")),
        Err(error) => Err(error.to_string()),
    })
}

/// Coefficients between commas.
pub fn frictions(text: &str) -> Result<List, String> {
    list(text, "coefficients such as 0,0.4,0.8", |item| {
        number(item).filter(|mu| *mu >= 0.0).ok_or(format!("`{item}` is no coefficient from 0"))
    })
}

/// One number of points, or three.
pub fn resolution(text: &str) -> Result<Resolution, String> {
    let expected = "expected a number of points from 1 for all axes, such as 20, or three for l21, phi22 and the arm ratio, \
                    such as 20,31,20";
    let points = |item: &str| match item.trim().parse::<usize>() {
        Ok(points) if points > 0 => Ok(points),
        _ => Err(format!("`{}` is no number of points; {expected}", item.trim())),
    };
    match text.split(',').map(points).collect::<Result<Vec<_>, _>>()?[..] {
        [all] => Ok(Resolution([all; 3])),
        [l21, phi22, arm] => Ok(Resolution([l21, phi22, arm])),
        ref given => Err(format!("{} numbers of points were given; {expected}", given.len())),
    }
}

/// Limits within 0 and 1.
pub fn fraction_limits(text: &str) -> Result<Limits, String> {
    limits(text, "two numbers within 0 and 1, such as 0,1", |item| {
        number(item).filter(|part| (0.0..=1.0).contains(part)).ok_or(format!("`{item}` is no number within 0 and 1"))
    })
}

/// Limits between 0 and 180°.
pub fn angle_limits(text: &str) -> Result<Limits, String> {
    limits(text, "two angles such as \"90 deg, 120 deg\"", |item| match units::parse(item, Dimension::Angle) {
        Ok(angle) if angle > 0.0 && angle < std::f64::consts::PI => Ok(angle),
        Ok(_) => Err(format!("`{item}`: phi22 must lie between 0 and 180 deg, both excluded")),
        Err(error) => Err(error.to_string()),
    })
}

/// Limits above 0.
pub fn ratio_limits(text: &str) -> Result<Limits, String> {
    limits(text, "two numbers above 0, such as 0.333,0.667", |item| {
        number(item).filter(|ratio| *ratio > 0.0).ok_or(format!("`{item}` is no number above 0"))
    })
}

/// A number of threads.
pub fn threads(text: &str) -> Result<usize, String> {
    let number = text.parse().ok().filter(|threads| (1..=MOST_THREADS).contains(threads));
    number.ok_or_else(|| format!("expected a number of threads from 1 to {MOST_THREADS}; leave it out for all cores"))
}

/// A number of threads, where 0 stands for all cores.
pub fn threads_or_all(text: &str) -> Result<usize, String> {
    if text == "0" { Ok(0) } else { threads(text) }
}

fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|value: &f64| value.is_finite())
}

/// Two values between commas, the lower one first.
fn limits(text: &str, wanted: &str, read: impl Fn(&str) -> Result<f64, String>) -> Result<Limits, String> {
    let values = items(text, wanted, read)?;
    match values[..] {
        [from, to] if from <= to => Ok(Limits(from, to)),
        [_, _] => Err(format!("the first limit is above the second; expected {wanted}")),
        _ => Err(format!(
            "{} value{} given; expected {wanted}",
            values.len(),
            if values.len() == 1 { " was" } else { "s were" }
        )),
    }
}

/// Values between commas; each may be there once.
fn list(text: &str, wanted: &str, read: impl Fn(&str) -> Result<f64, String>) -> Result<List, String> {
    let values = items(text, wanted, read)?;
    Ok(List(values))
}

fn items(text: &str, wanted: &str, read: impl Fn(&str) -> Result<f64, String>) -> Result<Vec<f64>, String> {
    let values = text.split(',').map(|item| read(item.trim())).collect::<Result<Vec<_>, _>>();
    values.map_err(|message| format!("{message}; expected {wanted}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_with_their_units() {
        assert_eq!(bases("12 mm, 15.5 mm"), Ok(List(vec![0.012, 0.0155])));
        assert_eq!(frictions("0,0.4"), Ok(List(vec![0.0, 0.4])));
        assert_eq!(resolution("7"), Ok(Resolution([7; 3])));
        assert_eq!(resolution("7, 1,20"), Ok(Resolution([7, 1, 20])));
        assert_eq!(fraction_limits("0.25,1"), Ok(Limits(0.25, 1.0)));
        assert_eq!(angle_limits("90 deg, 1.7 rad"), Ok(Limits(90f64.to_radians(), 1.7)));
        assert_eq!(threads("2"), Ok(2));
    }

    #[test]
    fn what_is_wrong_is_said_with_an_example() {
        for (message, part) in [
            (bases("12").unwrap_err(), "no unit"),
            (bases("12 mm,,1 mm").unwrap_err(), "number"),
            (bases("0 mm").unwrap_err(), "more than 0"),
            (frictions("-0.1").unwrap_err(), "from 0"),
            (frictions("nan").unwrap_err(), "from 0"),
            (resolution("0").unwrap_err(), "from 1"),
            (resolution("20,20").unwrap_err(), "2 numbers"),
            (resolution("many").unwrap_err(), "`many`"),
            (fraction_limits("0,1.5").unwrap_err(), "within 0 and 1"),
            (fraction_limits("1,0").unwrap_err(), "above the second"),
            (fraction_limits("0.5").unwrap_err(), "1 value was"),
            (angle_limits("90,120").unwrap_err(), "no unit"),
            (angle_limits("0 deg, 90 deg").unwrap_err(), "both excluded"),
            (ratio_limits("0,1").unwrap_err(), "above 0"),
            (threads("0").unwrap_err(), "from 1"),
        ] {
            assert!(
                message.contains(part) && (message.contains("such as") || message.contains("expected")),
                "{message}"
            );
        }
    }
}
