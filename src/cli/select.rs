//! `phalanx select`: which designs of a sweep meet the criteria, and which of them is best.

use std::path::{Path, PathBuf};
use std::slice;

use clap::Args;

use super::output::answer;
use super::own::Form;
use super::saved::save;
use super::targets::{Kind, reserve};
use super::{Failure, Status};
use crate::criteria::Class;
use crate::plot;
use crate::report::select::{SelectionReport, ranking_table};
use crate::study::select::{
    Bound, CLASSES, SelectError, Selection, SelectionCriteria, Side, Weights, class_named, select,
};
use crate::table::{self, Table, TableError};
use crate::units::{self, Dimension};
use crate::wording::Reported;

/// Choose designs from the results of a sweep: criteria, classes, ranking.
///
/// A run is selected if it is statically stable, form-closed, dynamically stable or semi-stable, and has a palm force PFP
/// of 0 or more from its final simulated forces (thesis, section 4.3); each of these can be left out or changed, and any
/// column of numbers can be bounded.
///
/// The selected are ranked by r_WC (thesis, eq. 4.2), the weighted mean of r(PFP), 1 − r(tts), 1 − r(F21) and r(F22), each scaled from
/// its smallest to its largest value over the selected; a part that is the same for all counts as 1/2.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx select results.csv\n  phalanx select results.parquet --class stable --max-tts \"8 ms\" \
                  --out selection\n  phalanx select results.csv --no-form-closed --min-pfp \"5 N\" --best 20\n  phalanx select \
                  results.csv --bound \"motor_n_m <= 0.5\" --bound \"mass_kg <= 0.024\" --ranking best.csv\n  phalanx select results.csv --weights \
                  pfp=2,tts=1,f21=0,f22=0 --json\n\nExit status: 0 done; 1 no run meets the criteria; 2 bad input; 3 files \
                  could not be written."
)]
pub struct SelectArgs {
    /// Results of `phalanx sweep` (.csv or .parquet)
    results: PathBuf,

    /// The worst dynamic class allowed: stable, semi-stable, semi-unstable, or unstable for any
    #[arg(long, value_name = "CLASS", default_value = "semi-stable", value_parser = class)]
    class: Class,

    /// Take grasps that are not form-closed too
    #[arg(long)]
    no_form_closed: bool,

    /// Take grasps that are not statically stable too; their dynamic class is unstable, so give --class unstable as well
    #[arg(long)]
    no_static: bool,

    /// Least palm force PFP, with its unit [default: 0 N]
    #[arg(long, value_name = "FORCE", value_parser = force, conflicts_with = "no_pfp")]
    min_pfp: Option<f64>,

    /// Take any palm force
    #[arg(long)]
    no_pfp: bool,

    /// Longest time to stability, with its unit
    #[arg(long, value_name = "TIME", value_parser = time)]
    max_tts: Option<f64>,

    /// Largest rebound, in percent
    #[arg(long, value_name = "PERCENT", value_parser = percent)]
    max_rebound: Option<f64>,

    /// Bound any column of numbers, "COLUMN >= VALUE" or "COLUMN <= VALUE", in the unit of its name; may be given again
    #[arg(long, value_name = "BOUND", value_parser = bound)]
    bound: Vec<Bound>,

    /// What the parts of r_WC count; parts not named count 0
    #[arg(long, value_name = "PART=WEIGHT,…", default_value = "pfp=1,tts=1,f21=1,f22=1", value_parser = weights)]
    weights: Weights,

    /// How many of the best to print
    #[arg(long, value_name = "NUMBER", default_value_t = 10, value_parser = count)]
    best: usize,

    /// Write all selected runs there, best first, with place, r_WC and its parts before the columns of the results
    #[arg(long, value_name = "FILE.csv|.parquet")]
    ranking: Option<PathBuf>,

    /// Write selection.txt, .json, ranking.csv and pictures there: criteria.svg (what each removed), classes.svg and
    /// static.svg (designs by variable and class), forces.svg, variables.svg; the directory is made if need be
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &SelectArgs) -> Result<Status, Failure> {
    if let Some(path) = &args.ranking {
        table::format(path).map_err(Failure::bad_input)?;
    }
    let ranking = ("--ranking", args.ranking.as_deref(), Kind::File(Form::Ranking));
    let results = slice::from_ref(&args.results);
    let folder = reserve(&[("the table of results", results)], &[ranking], ("--out", args.out.as_deref(), &FILES))?;
    let results = table::read(&args.results).map_err(Failure::bad_input)?;
    let selection = select(&results, &criteria(args)).map_err(|error| match error {
        SelectError::Table(_) | SelectError::Weight { .. } | SelectError::NoWeight => Failure::bad_input(error),
        other => Failure::bad_input(format!("{}: {other}", args.results.display())),
    })?;
    let source = args.results.display().to_string();
    if let Some(path) = &args.ranking {
        table::write(path, &ranking_table(&results, &selection)).map_err(unwritten)?;
    }
    if let Some(folder) = folder {
        folder.fill(|out| write(out, &source, &results, &selection))?;
    }
    answer(&SelectionReport::new(&source, &selection, args.best), args.json)?;
    Ok(if selection.ranking.is_empty() { Status::CheckFailed } else { Status::Done })
}

/// What was asked for.
fn criteria(args: &SelectArgs) -> SelectionCriteria {
    let given = |column: &str, side: Side, value: Option<f64>| {
        value.map(|value| Bound { column: column.to_string(), side, value })
    };
    let pfp_n = if args.no_pfp { None } else { Some(args.min_pfp.unwrap_or(0.0)) };
    let usual = [
        given("pfp_n", Side::AtLeast, pfp_n),
        given("tts_s", Side::AtMost, args.max_tts),
        given("rebound_percent", Side::AtMost, args.max_rebound),
    ];
    SelectionCriteria {
        force_positive: !args.no_static,
        form_closed: !args.no_form_closed,
        least_class: Some(args.class),
        bounds: usual.into_iter().flatten().chain(args.bound.iter().cloned()).collect(),
        weights: args.weights,
    }
}

/// Everything that is in the directory in the end.
const FILES: [&str; 8] = [
    "selection.txt",
    "selection.json",
    "ranking.csv",
    "criteria.svg",
    "classes.svg",
    "static.svg",
    "forces.svg",
    "variables.svg",
];

/// The files of `--out`; the text, which says what there is, comes last.
fn write(out: &Path, source: &str, results: &Table, selection: &Selection) -> Result<(), Failure> {
    // A picture is given to others: it is named by the file alone.
    let title = Path::new(source).file_name().map_or(source.to_string(), |name| name.to_string_lossy().into_owned());
    for (file, picture) in [
        ("criteria.svg", plot::selection_criteria(&title, selection)),
        ("classes.svg", plot::selection_classes(&title, selection)),
        ("static.svg", plot::selection_static(&title, selection)),
        ("forces.svg", plot::selection_forces(&title, selection)),
        ("variables.svg", plot::selection_variables(&title, results, selection)),
    ] {
        save(&out.join(file), &picture)?;
    }
    table::write(&out.join("ranking.csv"), &ranking_table(results, selection)).map_err(unwritten)?;
    let report = SelectionReport::new(source, selection, usize::MAX);
    save(&out.join("selection.json"), &report.json())?;
    save(&out.join("selection.txt"), &report.report().to_string())
}

fn unwritten(error: TableError) -> Failure {
    Failure::incomplete(error)
}

fn count(text: &str) -> Result<usize, String> {
    text.parse().map_err(|_| "expected a number of runs from 0, such as 10".to_string())
}

fn class(text: &str) -> Result<Class, String> {
    class_named(text).ok_or_else(|| format!("expected {}", CLASSES.map(Class::name).join(", ")))
}

fn force(text: &str) -> Result<f64, String> {
    units::parse(text, Dimension::Force).map_err(|error| error.to_string())
}

fn time(text: &str) -> Result<f64, String> {
    match units::parse(text, Dimension::Time) {
        Ok(time_s) if time_s > 0.0 => Ok(time_s),
        Ok(_) => Err("a time to stability is longer than 0; expected a time such as \"8 ms\"".to_string()),
        Err(error) => Err(error.to_string()),
    }
}

fn percent(text: &str) -> Result<f64, String> {
    let value = text.trim().trim_end_matches('%').trim_end().parse::<f64>();
    value
        .ok()
        .filter(|value| value.is_finite() && *value >= 0.0)
        .ok_or("expected percent from 0, such as 2.5".to_string())
}

fn bound(text: &str) -> Result<Bound, String> {
    let wanted = "expected a column, >= or <=, and a number in the unit of the column, such as \"mass_kg <= 0.024\"";
    let (side, sign) = match (text.find(">="), text.find("<=")) {
        (Some(at), None) => (Side::AtLeast, at),
        (None, Some(at)) => (Side::AtMost, at),
        _ => return Err(wanted.to_string()),
    };
    let (column, value) = (text[..sign].trim(), text[sign + 2..].trim());
    let number = value.parse::<f64>().ok().filter(|value| value.is_finite());
    match number {
        Some(value) if !column.is_empty() => Ok(Bound { column: column.to_string(), side, value }),
        _ => Err(wanted.to_string()),
    }
}

fn weights(text: &str) -> Result<Weights, String> {
    let wanted = "expected parts and weights from 0, such as pfp=2,tts=1,f21=0,f22=0";
    let mut weights = Weights { pfp: 0.0, tts: 0.0, f21: 0.0, f22: 0.0 };
    let mut named: Vec<&str> = Vec::new();
    for item in text.split(',') {
        let (name, value) = item.split_once('=').ok_or(wanted)?;
        let (name, value) = (name.trim(), value.trim().parse::<f64>().map_err(|_| wanted)?);
        if named.contains(&name) {
            return Err(format!("{name} is there twice; {wanted}"));
        }
        if !(value.is_finite() && value >= 0.0) {
            return Err(format!("the weight of {name} is {value}; {wanted}"));
        }
        *match name {
            "pfp" => &mut weights.pfp,
            "tts" => &mut weights.tts,
            "f21" => &mut weights.f21,
            "f22" => &mut weights.f22,
            _ => return Err(format!("there is no part `{name}`; {wanted}")),
        } = value;
        named.push(name);
    }
    match weights.named().iter().any(|(_, weight)| *weight > 0.0) {
        true => Ok(weights),
        false => Err(format!("all weights are 0; {wanted}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_and_weights_are_read_and_checked() {
        let expected = Bound { column: "mass_kg".to_string(), side: Side::AtMost, value: 0.024 };
        assert_eq!(bound("mass_kg<=0.024"), Ok(expected.clone()));
        assert_eq!(bound(" mass_kg  <= 24e-3 "), Ok(expected));
        assert_eq!(bound("pfp_n>=-1").map(|bound| (bound.side, bound.value)), Ok((Side::AtLeast, -1.0)));
        for text in ["mass_kg", "mass_kg<0.1", "<=3", "mass_kg<=", "mass_kg<=24 g", "a>=1<=2", "mass_kg<=nan"] {
            assert!(bound(text).is_err_and(|error| error.contains("such as")), "{text}");
        }
        assert_eq!(weights("tts=2, pfp=1"), Ok(Weights { pfp: 1.0, tts: 2.0, f21: 0.0, f22: 0.0 }));
        for (text, message) in
            [("tts", "such as"), ("tts=-1", "-1"), ("tts=1,tts=2", "twice"), ("mass=1", "no part"), ("tts=0", "all")]
        {
            assert!(weights(text).is_err_and(|error| error.contains(message)), "{text}");
        }
    }
}
