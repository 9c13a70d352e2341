//! Values of flags of `phalanx volume`, and their parsers.

use clap::ValueEnum;
use clap::builder::PossibleValue;

use crate::limits::MAX_THREADS;
use crate::study::volume::Quantity;
use crate::units::{self, Dimension};

/// Values of one flag, in the given order.
#[derive(Clone, Debug, PartialEq)]
pub struct ValueList(pub Vec<f64>);

/// Limits of an axis, the lower one first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisLimits(pub f64, pub f64);

/// Number of points along the three axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resolution(pub [usize; 3]);

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DataArg {
    /// Comma-separated values: text that any program reads
    Csv,
    /// Binary columns: smaller and faster to read with data tools
    Parquet,
}

impl ValueEnum for Quantity {
    fn value_variants<'a>() -> &'a [Self] {
        &Quantity::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let help = match self {
            Quantity::Pfp => "Palm force positiveness, N; if negative, the fingers would pull the object off the palm",
            Quantity::F21 => "Normal force of the proximal phalanx, N",
            Quantity::F22 => "Normal force of the distal phalanx, N",
            Quantity::Spring => "Torque of the spring, N·mm",
            Quantity::Motor => "Torque of the motor, N·mm",
            Quantity::Mass => "Mass of a finger, g",
            Quantity::FormClosed => "Whether the object is immobilised even without friction",
        };
        Some(PossibleValue::new(self.key()).help(help))
    }
}

/// Parses comma-separated lengths.
pub fn parse_bases(text: &str) -> Result<ValueList, String> {
    parse_list(text, "lengths such as \"12 mm, 15.5 mm\"", |item| match units::parse(item, Dimension::Length) {
        Ok(base_m) if base_m > 0.0 => Ok(base_m),
        Ok(_) => Err(format!("`{item}`: the base must be more than 0")),
        Err(error) => Err(error.to_string()),
    })
}

/// Parses comma-separated coefficients.
pub fn parse_frictions(text: &str) -> Result<ValueList, String> {
    parse_list(text, "coefficients such as 0,0.4,0.8", |item| {
        parse_number(item).filter(|mu| *mu >= 0.0).ok_or(format!("`{item}` is not a coefficient of 0 or more"))
    })
}

/// Parses one number of points, or three.
pub fn parse_resolution(text: &str) -> Result<Resolution, String> {
    let expected = "expected one number of points for all axes, such as 20, or three numbers for l21, phi22 and the arm ratio, \
                    such as 20,31,20; each must be 1 or more";
    let points = |item: &str| match item.trim().parse::<usize>() {
        Ok(points) if points > 0 => Ok(points),
        _ => Err(format!("`{}` is not a valid number of points; {expected}", item.trim())),
    };
    match text.split(',').map(points).collect::<Result<Vec<_>, _>>()?[..] {
        [all] => Ok(Resolution([all; 3])),
        [l21, phi22, arm] => Ok(Resolution([l21, phi22, arm])),
        ref counts => Err(format!("{} numbers of points were given; {expected}", counts.len())),
    }
}

/// Parses limits between 0 and 1.
pub fn parse_fraction_limits(text: &str) -> Result<AxisLimits, String> {
    parse_limits(text, "two numbers between 0 and 1, such as 0,1", |item| {
        parse_number(item)
            .filter(|fraction| (0.0..=1.0).contains(fraction))
            .ok_or(format!("`{item}` is not a number between 0 and 1"))
    })
}

/// Parses limits between 0 and 180°.
pub fn parse_angle_limits(text: &str) -> Result<AxisLimits, String> {
    parse_limits(text, "two angles such as \"90 deg, 120 deg\"", |item| match units::parse(item, Dimension::Angle) {
        Ok(angle) if angle > 0.0 && angle < std::f64::consts::PI => Ok(angle),
        Ok(_) => Err(format!("`{item}`: phi22 must be between 0 and 180 deg, both excluded")),
        Err(error) => Err(error.to_string()),
    })
}

/// Parses limits above 0.
pub fn parse_ratio_limits(text: &str) -> Result<AxisLimits, String> {
    parse_limits(text, "two numbers above 0, such as 0.333,0.667", |item| {
        parse_number(item).filter(|ratio| *ratio > 0.0).ok_or(format!("`{item}` is not a number above 0"))
    })
}

/// Parses a number of threads.
pub fn parse_threads(text: &str) -> Result<usize, String> {
    let number = text.parse().ok().filter(|threads| (1..=MAX_THREADS).contains(threads));
    number
        .ok_or_else(|| format!("expected a number of threads from 1 to {MAX_THREADS}; omit the flag to use all cores"))
}

/// Parses a number of threads; 0 selects all cores.
pub fn parse_threads_or_all(text: &str) -> Result<usize, String> {
    if text == "0" { Ok(0) } else { parse_threads(text) }
}

fn parse_number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|value: &f64| value.is_finite())
}

/// Parses two comma-separated values, the lower one first.
fn parse_limits(text: &str, expected: &str, read: impl Fn(&str) -> Result<f64, String>) -> Result<AxisLimits, String> {
    let values = parse_items(text, expected, read)?;
    match values[..] {
        [from, to] if from <= to => Ok(AxisLimits(from, to)),
        [_, _] => Err(format!("the first limit is greater than the second; expected {expected}")),
        _ => Err(format!(
            "{} value{} given; expected {expected}",
            values.len(),
            if values.len() == 1 { " was" } else { "s were" }
        )),
    }
}

/// Parses comma-separated values.
fn parse_list(text: &str, expected: &str, read: impl Fn(&str) -> Result<f64, String>) -> Result<ValueList, String> {
    Ok(ValueList(parse_items(text, expected, read)?))
}

fn parse_items(text: &str, expected: &str, read: impl Fn(&str) -> Result<f64, String>) -> Result<Vec<f64>, String> {
    let values = text.split(',').map(|item| read(item.trim())).collect::<Result<Vec<_>, _>>();
    values.map_err(|message| format!("{message}; expected {expected}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_values_with_units() {
        assert_eq!(parse_bases("12 mm, 15.5 mm"), Ok(ValueList(vec![0.012, 0.0155])));
        assert_eq!(parse_frictions("0,0.4"), Ok(ValueList(vec![0.0, 0.4])));
        assert_eq!(parse_resolution("7"), Ok(Resolution([7; 3])));
        assert_eq!(parse_resolution("7, 1,20"), Ok(Resolution([7, 1, 20])));
        assert_eq!(parse_fraction_limits("0.25,1"), Ok(AxisLimits(0.25, 1.0)));
        assert_eq!(parse_angle_limits("90 deg, 1.7 rad"), Ok(AxisLimits(90f64.to_radians(), 1.7)));
        assert_eq!(parse_threads("2"), Ok(2));
    }

    #[test]
    fn error_messages_include_an_example() {
        for (message, part) in [
            (parse_bases("12").unwrap_err(), "no unit"),
            (parse_bases("12 mm,,1 mm").unwrap_err(), "number"),
            (parse_bases("0 mm").unwrap_err(), "more than 0"),
            (parse_frictions("-0.1").unwrap_err(), "0 or more"),
            (parse_frictions("nan").unwrap_err(), "0 or more"),
            (parse_resolution("0").unwrap_err(), "1 or more"),
            (parse_resolution("20,20").unwrap_err(), "2 numbers"),
            (parse_resolution("many").unwrap_err(), "`many`"),
            (parse_fraction_limits("0,1.5").unwrap_err(), "between 0 and 1"),
            (parse_fraction_limits("1,0").unwrap_err(), "greater than the second"),
            (parse_fraction_limits("0.5").unwrap_err(), "1 value was"),
            (parse_angle_limits("90,120").unwrap_err(), "no unit"),
            (parse_angle_limits("0 deg, 90 deg").unwrap_err(), "both excluded"),
            (parse_ratio_limits("0,1").unwrap_err(), "above 0"),
            (parse_threads("0").unwrap_err(), "from 1"),
        ] {
            assert!(
                message.contains(part) && (message.contains("such as") || message.contains("expected")),
                "{message}"
            );
        }
    }
}
