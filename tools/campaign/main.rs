//! A differential campaign: random scenes of all kinds over decades of masses, stiffness, damping and friction. It compares the
//! default run and the engine with the reference, the reference with another family of methods, and all of them with a
//! perturbation of 1e-7 of the drives; and the verdicts of the checks with the errors.
//!
//!     cargo run --release --example campaign -- --family mixed,discs --scenes 10000
//!     cargo run --release --example campaign -- --family stick --scenes 100 --save findings
//!     cargo run --release --example campaign -- --family jaws --seed 7 --print
//!
//! Prints a table; saves scenes with findings. A run of more than a minute is aborted.

mod record;
mod scenes;
mod trial;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Parser;
use clap::builder::PossibleValuesParser;
use phalanx::scene::{Scene, parse_any};
use record::{Run, Setting, difference, record};
use scenes::{FAMILIES, scene_text};
use trial::{Trial, Verdict, is_explained, run_trial};

/// Name of a scene in messages.
const FILE: &str = "random.toml";

#[derive(Parser)]
struct Args {
    /// Families of scenes, separated by commas
    #[arg(long, value_name = "NAME", value_delimiter = ',', default_value = "all", value_parser = families())]
    family: Vec<String>,
    /// First seed of each family
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    first: u64,
    /// Number of scenes per family
    #[arg(long, value_name = "N", default_value_t = 100)]
    scenes: u64,
    /// Only this seed
    #[arg(long, conflicts_with_all = ["first", "scenes"])]
    seed: Option<u64>,
    /// Print the scenes instead of running them; with --save, write them as files
    #[arg(long)]
    print: bool,
    /// Directory for scenes with findings
    #[arg(long, value_name = "DIR")]
    save: Option<PathBuf>,
    /// Skip the engine
    #[arg(long)]
    no_engine: bool,
    /// Print a line for each scene with findings
    #[arg(long, short)]
    verbose: bool,
    /// Run these scene files instead of random scenes
    #[arg(value_name = "SCENE")]
    files: Vec<PathBuf>,
}

fn families() -> PossibleValuesParser {
    PossibleValuesParser::new(std::iter::once("all").chain(FAMILIES.map(|(name, _)| name)))
}

/// Prints the error at several tolerances, and the time at which it first appears.
fn print_tolerance_sweep(scene: &Scene, reference: &Run) {
    let settings = [1e-3, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 1e-7, 1e-8, 1e-9].map(Setting::Rtol);
    let engine = [10.0, 1.0, 0.1, 0.01].map(Setting::EngineTolerance);
    println!("    reference: {}", reference.event_log.iter().take(24).cloned().collect::<Vec<_>>().join(", "));
    for setting in settings.into_iter().chain(engine) {
        let run = record(scene, setting, 0.0);
        let error = difference(reference, &run);
        let first_index = reference
            .path
            .iter()
            .zip(&run.path)
            .position(|(p, q)| p.iter().zip(q).any(|(x, y)| (x - y).abs() > 0.1 * error));
        let time_s = first_index.map_or(f64::NAN, |i| reference.times[i]);
        println!("    {}", run.event_log.iter().take(24).cloned().collect::<Vec<_>>().join(", "));
        println!(
            "    {setting:?}: {error:.1e} from {time_s:.6} s on, {} steps, {} events, {:.1} ms",
            run.steps,
            run.events,
            1e3 * run.wall_time.as_secs_f64()
        );
    }
}

/// What the table says about a scene.
struct Record {
    family: &'static str,
    seed: u64,
    /// Columns of [`COUNTS`] that count it.
    counted: Vec<&'static str>,
    findings: Vec<&'static str>,
    /// Reason of an early end.
    reason: Option<String>,
    /// Errors of the default run and of the engine where the check of the default run is sure.
    errors: Option<[f64; 2]>,
    /// Times of the reference, the default run and the engine.
    times_s: [f64; 3],
}

/// Columns of the table.
const COUNTS: [&str; 9] = [
    "with contact",
    "deep contact",
    "sure",
    "uncertain",
    "chaotic",
    "unknown",
    "ended early",
    "refused",
    "engine sure",
];

fn main() {
    let mut args = Args::parse();
    if let Some(seed) = args.seed {
        (args.first, args.scenes) = (seed, 1);
    }
    for file in &args.files {
        let text = std::fs::read_to_string(file).expect("a scene file");
        let scene = parse_any(&text, FILE).unwrap_or_else(|error| panic!("{error}"));
        let result = run_trial(&scene, !args.no_engine);
        println!("{}", describe(&file.display().to_string(), &result));
        if args.verbose {
            print_tolerance_sweep(&scene, &result.reference);
        }
    }
    if !args.files.is_empty() {
        return;
    }
    let is_chosen = |name: &&str| args.family.iter().any(|family| family == name || family == "all");
    let chosen: Vec<&str> = FAMILIES.map(|(name, _)| name).into_iter().filter(is_chosen).collect();
    let seeds = args.first..args.first + args.scenes;
    if args.print {
        for (name, seed) in chosen.iter().flat_map(|name| seeds.clone().map(move |seed| (name, seed))) {
            match &args.save {
                Some(dir) => save(dir, name, seed, &scene_text(name, seed)),
                None => print!("{}", scene_text(name, seed)),
            }
        }
        return;
    }
    let tasks: Vec<(&str, u64)> = chosen.iter().flat_map(|name| seeds.clone().map(move |seed| (*name, seed))).collect();
    let (next, records) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some((family, seed)) = tasks.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let record = run_scene(family, *seed, &args);
                    records.lock().expect("no panic in other threads").push(record);
                }
            });
        }
    });
    print(&chosen, &records.into_inner().expect("no panic in other threads"));
}

fn run_scene(family: &'static str, seed: u64, args: &Args) -> Record {
    let text = scene_text(family, seed);
    let result = parse_any(&text, FILE).map(|scene| run_trial(&scene, !args.no_engine));
    let (record, line) = match result {
        Ok(trial) => (judged(family, seed, &trial), describe(&format!("{family} {seed}"), &trial)),
        Err(error) => {
            let findings =
                if is_explained(&error, FILE) { vec![] } else { vec!["refused without a reason or a remedy"] };
            let counted = vec!["refused"];
            let record = Record { family, seed, counted, findings, reason: None, errors: None, times_s: [0.0; 3] };
            (record, error.to_string())
        }
    };
    if args.verbose && !record.findings.is_empty() {
        println!("{line}");
    }
    if let Some(dir) = args.save.as_ref().filter(|_| !record.findings.is_empty()) {
        save(dir, family, seed, &format!("# {}\n{text}", line.replace('\n', "\n# ")));
    }
    record
}

fn judged(family: &'static str, seed: u64, trial: &Trial) -> Record {
    let Trial { preset, reference, engine, .. } = trial;
    let outcome = if preset.failure.is_some() { "ended early" } else { trial.analytic_verdict };
    let touches = preset.contacts.iter().any(|contact| contact.touchdowns > 0);
    let is_engine_sure = trial.engine_verdict == "sure";
    let columns =
        [("with contact", touches), ("deep contact", trial.is_deep), (outcome, true), ("engine sure", is_engine_sure)];
    let findings = trial.verdicts.iter().filter(|verdict| **verdict != Verdict::Chaotic);
    let time_s = |run: Option<&Run>| run.map_or(0.0, |run| run.wall_time.as_secs_f64());
    Record {
        family,
        seed,
        counted: columns.into_iter().filter(|(_, is_counted)| *is_counted).map(|(name, _)| name).collect(),
        findings: findings.map(|verdict| verdict.text()).collect(),
        reason: preset.failure.as_ref().map(ToString::to_string),
        errors: (outcome == "sure").then_some([trial.error, trial.engine_error]),
        times_s: [Some(reference), Some(preset), engine.as_ref()].map(time_s),
    }
}

fn describe(name: &str, trial: &Trial) -> String {
    let reasons: Vec<&str> = trial.verdicts.iter().map(|verdict| verdict.text()).collect();
    let failure = |run: &Run| run.failure.as_ref().map_or(String::new(), |f| format!(" [{:.6}: {f}]", run.end_s));
    format!(
        "{name}: perturbation {:.1e}, second method {:.1e}, default {:.1e}, engine {:.1e}; {:.0}+{:.0} ms, {} and {} steps, {} and {} events{}{}; verdicts {} / {}; {}",
        trial.perturbation,
        trial.second,
        trial.error,
        trial.engine_error,
        1e3 * trial.reference.wall_time.as_secs_f64(),
        1e3 * trial.preset.wall_time.as_secs_f64(),
        trial.reference.steps,
        trial.preset.steps,
        trial.reference.events,
        trial.preset.events,
        failure(&trial.reference),
        failure(&trial.preset),
        trial.analytic_verdict,
        trial.engine_verdict,
        reasons.join("; ")
    )
}

fn save(dir: &Path, family: &str, seed: u64, text: &str) {
    std::fs::create_dir_all(dir).expect("a directory");
    std::fs::write(dir.join(format!("{family}-{seed}.toml")), text).expect("written");
}

/// Prints a table with one row per family, and the findings by their kind.
fn print(families: &[&str], records: &[Record]) {
    let titles = ["default error: median, 99 %, largest", "engine error", "reference, default, engine (ms)"];
    println!(
        "| family | scenes | {} | {} |\n{}|",
        COUNTS.join(" | "),
        titles.join(" | "),
        "|---".repeat(COUNTS.len() + 5)
    );
    for name in families.iter().chain(&["all"]) {
        let chosen: Vec<&Record> = records.iter().filter(|record| [record.family, "all"].contains(name)).collect();
        let count = |column: &str| chosen.iter().filter(|record| record.counted.contains(&column)).count().to_string();
        let quantiles = [0, 1].map(|model| {
            let mut sorted: Vec<f64> = chosen.iter().filter_map(|record| Some(record.errors?[model])).collect();
            sorted.sort_by(f64::total_cmp);
            let quantile = |p: f64| sorted.get(((sorted.len() as f64 - 1.0) * p) as usize).copied().unwrap_or(f64::NAN);
            format!("{:.1e}, {:.1e}, {:.1e}", quantile(0.5), quantile(0.99), quantile(1.0))
        });
        let mean_ms =
            |run: usize| 1e3 * chosen.iter().map(|record| record.times_s[run]).sum::<f64>() / chosen.len() as f64;
        let times = [0, 1, 2].map(|run| format!("{:.1}", mean_ms(run))).join(", ");
        let counts = COUNTS.map(count).join(" | ");
        println!("| {name} | {} | {counts} | {} | {times} |", chosen.len(), quantiles.join(" | "));
    }
    println!(
        "\nErrors are the largest along a path, in rad, radii, 20 mm or m, where the check of the default run is sure."
    );
    let mut scenes: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    for record in records {
        for finding in record.findings.iter().copied().chain(record.reason.as_deref()) {
            scenes.entry(finding).or_default().insert(format!("{} {}", record.family, record.seed));
        }
    }
    for (finding, scenes) in scenes {
        println!("{} x {finding}: {}", scenes.len(), scenes.into_iter().collect::<Vec<_>>().join(", "));
    }
}
