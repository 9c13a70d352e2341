//! A differential campaign: random scenes over the whole law space, the everyday preset and the engine against the reference, the
//! reference against another family of methods, and all of them against a push of 1e-7 of what drives the scene.
//!
//!     cargo run --release --example campaign -- --scenes 10000 --seed 1
//!     cargo run --release --example campaign -- --family stick --scenes 100 --save findings
//!
//! Prints a table; saves what it finds as scenes.

#[path = "../../tests/judge/dice.rs"]
mod dice;
mod discs;
mod fingers;
#[path = "../../tests/judge/grippers.rs"]
mod grippers;
mod record;
mod trial;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use clap::Parser;
use dice::Dice;
use phalanx::scene::{Scene, parse_any};
use record::{Run, Setting, difference, record};
use trial::{Trial, Verdict, trial};

/// Makes the text of a scene.
type Family = fn(&mut Dice) -> String;

const FAMILIES: [(&str, Family); 5] = [
    ("mixed", fingers::mixed),
    ("soft", fingers::soft),
    ("stick", fingers::stick),
    ("discs", discs::text),
    ("grippers", grippers::text),
];

#[derive(Parser)]
struct Args {
    /// Scenes of every family
    #[arg(long, default_value_t = 100)]
    scenes: u64,
    /// Seed of the first scene
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only this family
    #[arg(long)]
    family: Option<String>,
    /// Leave the engine out
    #[arg(long)]
    no_engine: bool,
    /// Directory for the scenes that are not as they should be
    #[arg(long, value_name = "DIR")]
    save: Option<PathBuf>,
    /// A line for every scene that is not as it should be
    #[arg(long, short)]
    verbose: bool,
    /// Only these scene files instead of random ones
    #[arg(value_name = "SCENE")]
    files: Vec<PathBuf>,
}

/// How the error falls with the tolerance, and where along the path it first shows.
fn ladder(scene: &Scene, reference: &Run) {
    let settings = [1e-3, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 1e-7, 1e-8, 1e-9].map(Setting::Rtol);
    let engine = [10.0, 1.0, 0.1, 0.01].map(Setting::EngineAt);
    println!("    reference: {}", reference.story.iter().take(24).cloned().collect::<Vec<_>>().join(", "));
    for setting in settings.into_iter().chain(engine) {
        let run = record(scene, setting, 0.0);
        let error = difference(reference, &run);
        let shows = reference
            .path
            .iter()
            .zip(&run.path)
            .position(|(p, q)| p.iter().zip(q).any(|(x, y)| (x - y).abs() > 0.1 * error));
        let at = shows.map_or(f64::NAN, |i| reference.times[i]);
        println!("    {}", run.story.iter().take(24).cloned().collect::<Vec<_>>().join(", "));
        println!(
            "    {setting:?}: {error:.1e} from {at:.6} s on, {} steps, {} events, {:.1} ms",
            run.steps,
            run.events,
            1e3 * run.wall.as_secs_f64()
        );
    }
}

#[derive(Default)]
struct Tally {
    scenes: u64,
    refused: u64,
    verdicts: BTreeMap<Verdict, u64>,
    errors: Vec<f64>,
    engine_errors: Vec<f64>,
    slowest: Duration,
    walls: [f64; 3],
}

fn main() {
    let args = Args::parse();
    if !args.files.is_empty() {
        for file in &args.files {
            let text = std::fs::read_to_string(file).expect("a scene file");
            let scene = parse_any(&text, "scene.toml").unwrap_or_else(|error| panic!("{error}"));
            let result = trial(&scene, !args.no_engine);
            println!("{}", line(&file.display().to_string(), &result));
            if args.verbose {
                ladder(&scene, &result.reference);
            }
        }
        return;
    }
    for (name, text) in FAMILIES {
        if args.family.as_ref().is_none_or(|family| family == name) {
            let tally = family(name, text, &args);
            print(name, &tally);
        }
    }
}

fn family(name: &str, text: Family, args: &Args) -> Tally {
    let next = AtomicU64::new(args.seed);
    let tally = Mutex::new(Tally::default());
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= args.seed + args.scenes {
                        return;
                    }
                    let text = text(&mut Dice::new(seed));
                    let Ok(scene) = parse_any(&text, "random.toml") else {
                        tally.lock().expect("a tally").refused += 1;
                        continue;
                    };
                    let result = trial(&scene, !args.no_engine);
                    let mut tally = tally.lock().expect("a tally");
                    tally.take(&result);
                    let found = result.verdicts.iter().any(|v| *v != Verdict::Chaotic);
                    if found && args.verbose {
                        println!("{}", line(&format!("{name} {seed}"), &result));
                    }
                    if let Some(dir) = args.save.as_ref().filter(|_| found) {
                        save(dir, name, seed, &text, &result);
                    }
                }
            });
        }
    });
    tally.into_inner().expect("a tally")
}

fn line(name: &str, t: &Trial) -> String {
    let reasons: Vec<String> = t.verdicts.iter().map(Verdict::to_string).collect();
    let failure = |run: &Run| run.failure.as_ref().map_or(String::new(), |f| format!(" [{:.6}: {f}]", run.end_s));
    format!(
        "{name}: push {:.1e}, second {:.1e}, everyday {:.1e}, engine {:.1e}; {:.0}+{:.0} ms, {} and {} steps, {} and {} events{}{}; says {} / {}; {}",
        t.push,
        t.second,
        t.error,
        t.engine_error,
        1e3 * t.reference.wall.as_secs_f64(),
        1e3 * t.everyday.wall.as_secs_f64(),
        t.reference.steps,
        t.everyday.steps,
        t.reference.events,
        t.everyday.events,
        failure(&t.reference),
        failure(&t.everyday),
        t.says,
        t.engine_says,
        reasons.join("; ")
    )
}

fn save(dir: &Path, family: &str, seed: u64, text: &str, result: &Trial) {
    std::fs::create_dir_all(dir).expect("a directory");
    let head = line(&format!("{family} {seed}"), result);
    std::fs::write(dir.join(format!("{family}-{seed}.toml")), format!("# {head}\n{text}")).expect("written");
}

impl Tally {
    fn take(&mut self, t: &Trial) {
        self.scenes += 1;
        for verdict in &t.verdicts {
            *self.verdicts.entry(*verdict).or_default() += 1;
        }
        if !t.verdicts.contains(&Verdict::Chaotic) {
            self.errors.push(t.error);
            self.engine_errors.push(t.engine_error);
        }
        self.slowest = self.slowest.max(t.reference.wall);
        let walls = [Some(&t.reference), Some(&t.everyday), t.engine.as_ref()];
        for (sum, run) in self.walls.iter_mut().zip(walls) {
            *sum += run.map_or(0.0, |run| run.wall.as_secs_f64());
        }
    }
}

fn print(name: &str, tally: &Tally) {
    let quantiles = |errors: &[f64]| {
        let mut sorted = errors.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |p: f64| sorted.get(((sorted.len() as f64 - 1.0) * p) as usize).copied().unwrap_or(0.0);
        format!("median {:.1e}, 99 % {:.1e}, worst {:.1e}", at(0.5), at(0.99), at(1.0))
    };
    println!("== {name}: {} scenes, {} refused; slowest reference {:?}", tally.scenes, tally.refused, tally.slowest);
    let [reference, everyday, engine] = tally.walls.map(|sum| 1e3 * sum / tally.scenes.max(1) as f64);
    println!("   mean times: reference {reference:.2} ms, everyday {everyday:.3} ms, engine {engine:.2} ms");
    println!("   everyday error: {}", quantiles(&tally.errors));
    println!("   engine error:   {}", quantiles(&tally.engine_errors));
    for (verdict, count) in &tally.verdicts {
        println!("   {count:6} {verdict}");
    }
}
