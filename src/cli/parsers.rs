//! Value parsers of flags; their messages name what is allowed, with an example. `expected` describes the values of a
//! flag with an example.

use std::fs;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf, is_separator};
use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::limits::MAX_THREADS;
use crate::scene::{Axis, Preset};
use crate::sizing::Rule;
use crate::study::hold::axis_name;
use crate::trace::Model;
use crate::units::{self, Dimension};

/// Returns a parser of a quantity that must be positive. `example` begins with its article: `a time such as "40 ms"`.
pub(crate) fn positive(
    dimension: Dimension,
    example: &'static str,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| match units::parse(text, dimension) {
        Ok(value) if value > 0.0 => Ok(value),
        Ok(_) => Err(format!("must be more than 0; expected {example}")),
        Err(error) => Err(format!("{error}; give {example}")),
    }
}

/// Returns a parser of a length or an angle that must be positive, with its dimension.
pub(crate) fn size(
    example: &'static str,
) -> impl Fn(&str) -> Result<(f64, Dimension), String> + Clone + Send + Sync + 'static {
    move |text| {
        let angle = units::parse(text, Dimension::Angle).ok().filter(|angle| *angle > 0.0);
        match angle.filter(|_| units::parse(text, Dimension::Length).is_err()) {
            Some(angle_rad) => Ok((angle_rad, Dimension::Angle)),
            None => Ok((positive(Dimension::Length, example)(text)?, Dimension::Length)),
        }
    }
}

/// Returns a parser of one of the coordinates of a pose.
pub(crate) fn axis() -> impl TypedValueParser<Value = Axis> {
    choice([Axis::X, Axis::Y, Axis::Angle].map(|axis| (axis_name(axis), "", axis)))
}

/// Returns a parser of a quantity of either sign.
pub(crate) fn quantity(dimension: Dimension) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| units::parse(text, dimension).map_err(|error| error.to_string())
}

/// Returns a parser of a number that must be accepted. `expected` describes the accepted numbers.
pub(crate) fn number<T: FromStr + Clone + Send + Sync + 'static>(
    is_accepted: fn(&T) -> bool,
    expected: &'static str,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static {
    move |text| text.trim().parse().ok().filter(is_accepted).ok_or_else(|| format!("expected {expected}"))
}

/// Returns a parser of a count within a range.
pub(crate) fn count(
    range: RangeInclusive<usize>,
    example: &'static str,
) -> impl Fn(&str) -> Result<usize, String> + Clone + Send + Sync + 'static {
    move |text| match text.trim().parse() {
        Ok(count) if range.contains(&count) => Ok(count),
        _ => Err(format!("expected a number from {} to {}, such as {example}", range.start(), range.end())),
    }
}

/// Returns a parser of one of several named values, each with its name and its help, which may be empty.
pub(crate) fn choice<T: Clone + Send + Sync + 'static, const N: usize>(
    choices: [(&'static str, &'static str, T); N],
) -> impl TypedValueParser<Value = T> {
    let values = choices.each_ref().map(|(name, help, _)| match help.is_empty() {
        true => PossibleValue::new(*name),
        false => PossibleValue::new(*name).help(*help),
    });
    PossibleValuesParser::new(values).map(move |name| {
        choices.iter().find(|(known, ..)| *known == name).expect("one of the possible values").2.clone()
    })
}

pub(crate) fn model() -> impl TypedValueParser<Value = Model> {
    choice([
        (
            "analytic",
            "Lagrange equations with loops closed in closed form, and a stiff integrator of its own",
            Model::Analytic,
        ),
        ("engine", "Rigid-body engine with the same contact laws", Model::Engine),
    ])
}

pub(crate) fn preset() -> impl TypedValueParser<Value = Preset> {
    choice([
        ("draft", "For searches and learning: errors of up to 1e-3 rad or parts of a length", Preset::Draft),
        ("engineering", "For everyday runs", Preset::Engineering),
        ("reference", "For comparisons, with tight tolerances", Preset::Reference),
    ])
}

pub(crate) fn rule() -> impl TypedValueParser<Value = Rule> {
    choice([
        ("rigid", "RMS of the net motor torque until the proximal contact", Rule::Rigid),
        ("whole", "RMS over the whole trajectory, against the constant spring", Rule::Whole),
    ])
}

/// Returns a parser of two comma-separated values, the lower one first, each read by `read`.
pub(crate) fn limits(
    expected: &'static str,
    read: impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static,
) -> impl Fn(&str) -> Result<[f64; 2], String> + Clone + Send + Sync + 'static {
    move |text| match text.split(',').map(&read).collect::<Result<Vec<_>, _>>()?[..] {
        [from, to] if from <= to => Ok([from, to]),
        [_, _] => Err(format!("the first limit is greater than the second; expected {expected}")),
        [_] => Err(format!("1 value was given; expected {expected}")),
        ref values => Err(format!("{} values were given; expected {expected}", values.len())),
    }
}

/// Extensions of pictures that this program draws itself.
pub(crate) const PICTURE: &[&str] = if cfg!(feature = "png") { &["svg", "png", "html"] } else { &["svg", "html"] };

/// Returns a parser of the file of a picture, whose name ends in one of these extensions.
pub(crate) fn picture(
    extensions: &'static [&'static str],
) -> impl Fn(&str) -> Result<PathBuf, String> + Clone + Send + Sync + 'static {
    move |text| {
        let extension = Path::new(text).extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        // A pipe or a device may have any name; directories are refused with the other targets.
        let is_special = text.ends_with(is_separator) || fs::metadata(text).is_ok_and(|found| !found.is_file());
        if is_special || extensions.contains(&extension) {
            return Ok(text.into());
        }
        let allowed = extensions.iter().map(|each| format!(".{each}")).collect::<Vec<_>>().join(", ");
        let allowed = allowed.replace(", .html", " or .html");
        let remedy = match extension {
            "png" if extensions.contains(&"svg") => {
                "; this program was built without the feature `png` (cargo install --features png), which releases have; \
                 browsers, Inkscape and rsvg-convert convert .svg to .png"
            }
            _ => "",
        };
        Err(format!("the name must end in {allowed}{remedy}"))
    }
}

/// Parses a number of threads; 0 selects all cores.
pub(crate) fn parse_threads(text: &str) -> Result<usize, String> {
    let threads = text.parse().ok().filter(|threads| *threads <= MAX_THREADS);
    threads.ok_or_else(|| format!("expected a number of threads from 1 to {MAX_THREADS}, or 0 for all cores"))
}
