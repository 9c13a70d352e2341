//! `phalanx thesis select`: selects and ranks the designs of a sweep.

use std::path::{Path, PathBuf};
use std::slice;

use clap::Args;

use super::output::{FileKind, OutputArgs, print_result, reserve, save};
use super::parsers::{number, positive, quantity};
use super::{Failure, Status};
use crate::criteria::Class;
use crate::format::ToReport;
use crate::plot;
use crate::report::sweep::{SelectionReport, ranking_table};
use crate::study::select::{
    Bound, PerTerm, SelectError, Selection, SelectionCriteria, Side, TERMS, Weights, parse_class, select,
};
use crate::table::{self, Table};
use crate::units::Dimension;

/// Select and rank designs from the results of a sweep by criteria and classes.
///
/// A run is selected if it is statically stable, form-closed, dynamically stable or semi-stable, and has a palm force
/// PFP of 0 or more from its final simulated forces (thesis, section 4.3). Each criterion can be disabled or changed,
/// and any numeric column can be bounded.
///
/// Selected runs are ranked by r_WC (thesis, eq. 4.2), the weighted mean of r(PFP), 1 − r(tts), 1 − r(F21) and r(F22).
/// Each term is scaled from its smallest to its largest value over the selected runs; a term that is equal for all runs
/// counts as 1/2.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx thesis select results.csv\n  phalanx thesis select results.parquet --class stable --max-tts \"8 ms\" \
                  --out selection\n  phalanx thesis select results.csv --no-form-closed --min-pfp \"5 N\" --best 20\n  phalanx thesis select \
                  results.csv --bound \"motor_n_m <= 0.5\" --bound \"mass_kg <= 0.024\" --ranking best.csv\n  phalanx thesis select results.csv --weights \
                  pfp=2,tts=1,f21=0,f22=0 --json\n\n--out writes selection.txt, .json, ranking.csv and plots: criteria.svg (runs removed by each criterion), classes.svg and \
                  static.svg (designs by variable and class), forces.svg, variables.svg. Exit status: 0 done; 1 no run meets the criteria; 2 bad input; 3 files \
                  could not be written."
)]
pub(crate) struct SelectArgs {
    /// Results of `phalanx sweep` (.csv or .parquet)
    results: PathBuf,

    /// Worst allowed dynamic class: stable, semi-stable, semi-unstable, or unstable for any class
    #[arg(long, value_name = "CLASS", default_value = "semi-stable", value_parser = parse_class_arg)]
    class: Class,

    /// Also select grasps that are not form-closed
    #[arg(long)]
    no_form_closed: bool,

    /// Also select grasps that are not statically stable; their dynamic class is unstable, so --class unstable is
    /// needed too
    #[arg(long)]
    no_static: bool,

    /// Smallest palm force PFP, with its unit [default: 0 N]
    #[arg(long, value_name = "FORCE", value_parser = quantity(Dimension::Force), conflicts_with = "no_pfp")]
    min_pfp: Option<f64>,

    /// Allow any palm force
    #[arg(long)]
    no_pfp: bool,

    /// Longest time to stability, with its unit
    #[arg(long, value_name = "TIME", value_parser = positive(Dimension::Time, "a time such as \"8 ms\""))]
    max_tts: Option<f64>,

    /// Largest rebound, in percent
    #[arg(long, value_name = "PERCENT", value_parser = parse_percent)]
    max_rebound: Option<f64>,

    /// Bound a numeric column: "COLUMN >= VALUE" or "COLUMN <= VALUE", in the unit in its name; can be repeated
    #[arg(long, value_name = "BOUND", value_parser = parse_bound)]
    bound: Vec<Bound>,

    /// Weights of the terms of r_WC; omitted terms have weight 0
    #[arg(long, value_name = "TERM=WEIGHT,…", default_value = "pfp=1,tts=1,f21=1,f22=1", value_parser = parse_weights)]
    weights: Weights,

    /// Number of best runs to print
    #[arg(long, value_name = "NUMBER", default_value_t = 10, value_parser = number(|_: &usize| true, COUNT))]
    best: usize,

    /// Write all selected runs to this file, best first, with place, r_WC and its terms before the columns of the
    /// results
    #[arg(long, value_name = "FILE.csv|.parquet")]
    ranking: Option<PathBuf>,

    #[command(flatten)]
    output: OutputArgs,
}

/// Accepted values in messages.
const COUNT: &str = "a number of runs, 0 or more, such as 10";

pub(super) fn run(args: &SelectArgs) -> Result<Status, Failure> {
    if let Some(path) = &args.ranking {
        table::format(path).map_err(Failure::bad_input)?;
    }
    let ranking = ("--ranking", args.ranking.as_deref(), FileKind::Table);
    let results = slice::from_ref(&args.results);
    let files = [&FILES[..], &PICTURES].concat();
    let directory = reserve(&[("the table of results", results)], &[ranking], (args.output.out.as_deref(), &files))?;
    let results = table::read(&args.results).map_err(Failure::bad_input)?;
    let selection = select(&results, &build_criteria(args)).map_err(|error| match error {
        SelectError::Table(_) | SelectError::Weight { .. } | SelectError::NoWeight => Failure::bad_input(error),
        other => Failure::bad_input(format!("{}: {other}", args.results.display())),
    })?;
    let source = args.results.display().to_string();
    if let Some(path) = &args.ranking {
        table::write(path, &ranking_table(&results, &selection)).map_err(Failure::incomplete)?;
    }
    directory.write_with(|out| write_files(out, &source, &results, &selection))?;
    print_result(&SelectionReport::new(&source, &selection, args.best), args.output.json)?;
    Ok(if selection.ranking.is_empty() { Status::CheckFailed } else { Status::Done })
}

fn build_criteria(args: &SelectArgs) -> SelectionCriteria {
    let pfp_n = if args.no_pfp { None } else { Some(args.min_pfp.unwrap_or(0.0)) };
    let flags = [
        ("pfp_n", Side::AtLeast, pfp_n),
        ("tts_s", Side::AtMost, args.max_tts),
        ("rebound_percent", Side::AtMost, args.max_rebound),
    ];
    let of_flags = flags.into_iter().filter_map(|(column, side, value)| Some((column.to_string(), side, value?)));
    let of_flags = of_flags.map(|(column, side, value)| Bound { column, side, value });
    SelectionCriteria {
        force_positive: !args.no_static,
        form_closed: !args.no_form_closed,
        worst_class: Some(args.class),
        bounds: of_flags.chain(args.bound.iter().cloned()).collect(),
        weights: args.weights,
    }
}

/// Files in the output directory.
const FILES: [&str; 3] = ["selection.txt", "selection.json", "ranking.csv"];
const PICTURES: [&str; 5] = ["criteria.svg", "classes.svg", "static.svg", "forces.svg", "variables.svg"];

/// Writes the files of `--out`; the text report is written last.
fn write_files(out: &Path, source: &str, results: &Table, selection: &Selection) -> Result<(), Failure> {
    // Plots are shared, so their titles contain the file name without its directory.
    let title = Path::new(source).file_name().map_or(source.to_string(), |name| name.to_string_lossy().into_owned());
    let pictures = plot::selection(&title, results, selection);
    PICTURES.iter().zip(&pictures).try_for_each(|(file, picture)| save(&out.join(file), picture))?;
    table::write(&out.join("ranking.csv"), &ranking_table(results, selection)).map_err(Failure::incomplete)?;
    let report = SelectionReport::new(source, selection, usize::MAX);
    save(&out.join("selection.json"), &report.json())?;
    save(&out.join("selection.txt"), &report.report().to_string())
}

fn parse_class_arg(text: &str) -> Result<Class, String> {
    parse_class(text).ok_or_else(|| format!("expected {}", Class::ALL.map(Class::name).join(", ")))
}

fn parse_percent(text: &str) -> Result<f64, String> {
    let is_percentage = |value: &f64| value.is_finite() && *value >= 0.0;
    number(is_percentage, "a percentage of 0 or more, such as 2.5")(text.trim().trim_end_matches('%'))
}

fn parse_bound(text: &str) -> Result<Bound, String> {
    let expected = "expected a column, >= or <=, and a number in the unit of the column, such as \"mass_kg <= 0.024\"";
    let (side, column, value) = match (text.split_once(">="), text.split_once("<=")) {
        (Some((column, value)), None) => (Side::AtLeast, column.trim(), value),
        (None, Some((column, value))) => (Side::AtMost, column.trim(), value),
        _ => return Err(expected.to_string()),
    };
    match value.trim().parse() {
        Ok(value) if f64::is_finite(value) && !column.is_empty() => {
            Ok(Bound { column: column.to_string(), side, value })
        }
        _ => Err(expected.to_string()),
    }
}

fn parse_weights(text: &str) -> Result<Weights, String> {
    let expected = "expected terms with weights of 0 or more, such as pfp=2,tts=1,f21=0,f22=0";
    let mut weights: [Option<f64>; TERMS.len()] = [None; TERMS.len()];
    for item in text.split(',') {
        let (name, value) = item.split_once('=').ok_or(expected)?;
        let (name, value) = (name.trim(), value.trim().parse::<f64>().map_err(|_| expected)?);
        if !(value.is_finite() && value >= 0.0) {
            return Err(format!("the weight of {name} is {value}; {expected}"));
        }
        let Some(term) = TERMS.iter().position(|term| term.key == name) else {
            return Err(format!("there is no term `{name}`; {expected}"));
        };
        if weights[term].replace(value).is_some() {
            return Err(format!("{name} is given twice; {expected}"));
        }
    }
    match weights.iter().flatten().any(|weight| *weight > 0.0) {
        true => Ok(PerTerm(weights.map(Option::unwrap_or_default))),
        false => Err(format!("all weights are 0; {expected}")),
    }
}
