//! A differential campaign: random scenes over the whole space of contact laws. It compares the default run and the engine with
//! the reference, the reference with another family of methods, and all of them with a perturbation of 1e-7 of the drives.
//!
//!     cargo run --release --example campaign -- --scenes 10000 --seed 1
//!     cargo run --release --example campaign -- --family stick --scenes 100 --save findings
//!
//! Prints a table; saves scenes with findings.

mod discs;
mod fingers;
#[path = "../../tests/validation/grippers.rs"]
mod grippers;
#[path = "../../tests/support/random.rs"]
mod random;
mod record;
mod trial;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use clap::Parser;
use phalanx::scene::{Scene, parse_any};
use random::Random;
use record::{Run, Setting, difference, record};
use trial::{Trial, Verdict, run_trial};

/// Generator of scene texts.
type Family = fn(&mut Random) -> String;

const FAMILIES: [(&str, Family); 5] = [
    ("mixed", fingers::mixed),
    ("soft", fingers::soft),
    ("stick", fingers::stick),
    ("discs", discs::scene_text),
    ("grippers", grippers::scene_text),
];

#[derive(Parser)]
struct Args {
    /// Number of scenes per family
    #[arg(long, default_value_t = 100)]
    scenes: u64,
    /// Seed of the first scene
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Run only this family
    #[arg(long)]
    family: Option<String>,
    /// Skip the engine
    #[arg(long)]
    no_engine: bool,
    /// Directory for scenes with findings
    #[arg(long, value_name = "DIR")]
    save: Option<PathBuf>,
    /// Print a line for each scene with findings
    #[arg(long, short)]
    verbose: bool,
    /// Run these scene files instead of random scenes
    #[arg(value_name = "SCENE")]
    files: Vec<PathBuf>,
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

#[derive(Default)]
struct Summary {
    scenes: u64,
    invalid: u64,
    verdicts: BTreeMap<Verdict, u64>,
    errors: Vec<f64>,
    engine_errors: Vec<f64>,
    slowest: Duration,
    wall_times: [f64; 3],
}

fn main() {
    let args = Args::parse();
    if !args.files.is_empty() {
        for file in &args.files {
            let text = std::fs::read_to_string(file).expect("a scene file");
            let scene = parse_any(&text, "scene.toml").unwrap_or_else(|error| panic!("{error}"));
            let result = run_trial(&scene, !args.no_engine);
            println!("{}", describe(&file.display().to_string(), &result));
            if args.verbose {
                print_tolerance_sweep(&scene, &result.reference);
            }
        }
        return;
    }
    for (name, generate) in FAMILIES {
        if args.family.as_ref().is_none_or(|family| family == name) {
            let summary = run_family(name, generate, &args);
            print(name, &summary);
        }
    }
}

fn run_family(name: &str, generate: Family, args: &Args) -> Summary {
    let next = AtomicU64::new(args.seed);
    let summary = Mutex::new(Summary::default());
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= args.seed + args.scenes {
                        return;
                    }
                    let text = generate(&mut Random::for_seed(seed));
                    let Ok(scene) = parse_any(&text, "random.toml") else {
                        summary.lock().expect("no panic in other threads").invalid += 1;
                        continue;
                    };
                    let result = run_trial(&scene, !args.no_engine);
                    let mut summary = summary.lock().expect("no panic in other threads");
                    summary.add(&result);
                    let has_findings = result.verdicts.iter().any(|v| *v != Verdict::Chaotic);
                    if has_findings && args.verbose {
                        println!("{}", describe(&format!("{name} {seed}"), &result));
                    }
                    if let Some(dir) = args.save.as_ref().filter(|_| has_findings) {
                        save(dir, name, seed, &text, &result);
                    }
                }
            });
        }
    });
    summary.into_inner().expect("no panic in other threads")
}

fn describe(name: &str, trial: &Trial) -> String {
    let reasons: Vec<String> = trial.verdicts.iter().map(Verdict::to_string).collect();
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

fn save(dir: &Path, family: &str, seed: u64, text: &str, result: &Trial) {
    std::fs::create_dir_all(dir).expect("a directory");
    let head = describe(&format!("{family} {seed}"), result);
    std::fs::write(dir.join(format!("{family}-{seed}.toml")), format!("# {head}\n{text}")).expect("written");
}

impl Summary {
    fn add(&mut self, trial: &Trial) {
        self.scenes += 1;
        for verdict in &trial.verdicts {
            *self.verdicts.entry(*verdict).or_default() += 1;
        }
        if !trial.verdicts.contains(&Verdict::Chaotic) {
            self.errors.push(trial.error);
            self.engine_errors.push(trial.engine_error);
        }
        self.slowest = self.slowest.max(trial.reference.wall_time);
        let wall_times = [Some(&trial.reference), Some(&trial.preset), trial.engine.as_ref()];
        for (sum, run) in self.wall_times.iter_mut().zip(wall_times) {
            *sum += run.map_or(0.0, |run| run.wall_time.as_secs_f64());
        }
    }
}

fn print(name: &str, summary: &Summary) {
    let quantiles = |errors: &[f64]| {
        let mut sorted = errors.to_vec();
        sorted.sort_by(f64::total_cmp);
        let quantile = |p: f64| sorted.get(((sorted.len() as f64 - 1.0) * p) as usize).copied().unwrap_or(0.0);
        format!("median {:.1e}, 99 % {:.1e}, worst {:.1e}", quantile(0.5), quantile(0.99), quantile(1.0))
    };
    println!(
        "== {name}: {} scenes, {} invalid; slowest reference {:?}",
        summary.scenes, summary.invalid, summary.slowest
    );
    let [reference, preset, engine] = summary.wall_times.map(|sum| 1e3 * sum / summary.scenes.max(1) as f64);
    println!("   mean times: reference {reference:.2} ms, default {preset:.3} ms, engine {engine:.2} ms");
    println!("   default error:  {}", quantiles(&summary.errors));
    println!("   engine error:   {}", quantiles(&summary.engine_errors));
    for (verdict, count) in &summary.verdicts {
        println!("   {count:6} {verdict}");
    }
}
