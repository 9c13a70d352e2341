//! Grasp-state volumes of the thesis: 4 bases × 3 friction coefficients × 20³ points, i.e. 96,000 points and 32,000 sized and
//! closed designs.
//!
//!     cargo bench --bench volume
//!     cargo bench --bench volume -- --designs 1000        (for counting instructions)

use std::hint::black_box;
use std::time::Instant;

use clap::Parser;
use phalanx::gripper::{Assembly, Design, Finger, bodies, final_posture, lengths};
use phalanx::parallel::Monitor;
use phalanx::scene::Template;
use phalanx::sizing::{Rule, size};
use phalanx::statics::form_closure;
use phalanx::thesis::volume::{Axes, VolumeRequest, close_finger, design_at, solve_grasp, volumes};

#[derive(Debug, Parser)]
struct Args {
    /// Number of timed repetitions
    #[arg(long, default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..))]
    repetitions: u32,

    /// Largest number of threads
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..))]
    threads: u32,

    /// Only build, size, close and evaluate (with three friction coefficients) this many designs
    #[arg(long, value_name = "N")]
    designs: Option<usize>,

    /// Flag added by cargo bench
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() {
    let args = Args::parse();
    if let Some(designs) = args.designs {
        return process_designs(designs);
    }
    time_stages(args.repetitions);
    for rule in [Rule::Rigid, Rule::Whole] {
        scaling(rule, &args);
    }
}

/// Calls `action` for `count` designs of the thesis's volume of one base.
fn each_design(count: usize, mut action: impl FnMut(&Template, &Design)) {
    let template = Template::thesis();
    let axes = Axes::thesis([20; 3]);
    for index in 0..count {
        // The stride is coprime to the number of points, so any number of designs is spread over the volume.
        action(&template, &design_at(&template, 0.0155, axes.at(index * 4_813 % axes.len())));
    }
}

fn process_designs(designs: usize) {
    each_design(designs, |template, design| {
        let closed = close_finger(template, design, Rule::Rigid).expect("every design of the thesis has a finger");
        for mu_static in [0.0, 0.4, 0.8] {
            black_box(solve_grasp(&closed, mu_static)).expect("forces");
        }
    });
}

/// Prints the times of the stages of a design on one thread.
fn time_stages(repetitions: u32) {
    const DESIGNS: usize = 2_000;
    let finger = |template: &Template, design: &Design| {
        let lengths = lengths(design).expect("a finger");
        let bodies = bodies(&lengths, template.density_kg_m3, template.depth_m).expect("masses");
        Finger { lengths, bodies, assembly: Assembly::Reference }
    };
    let time = |work: &dyn Fn(&Template, &Design)| {
        let timed = (0..repetitions).map(|_| {
            let start = Instant::now();
            each_design(DESIGNS, |template, design| work(template, design));
            start.elapsed().as_secs_f64() / DESIGNS as f64 * 1e6
        });
        median(timed.collect())
    };
    let built = time(&|template, design| {
        black_box(finger(template, design));
    });
    let ended = time(&|template, design| {
        let finger = finger(template, design);
        black_box(final_posture(&finger.lengths, finger.assembly, template.task(design).object)).expect("a grasp");
    });
    let sized = |rule| {
        time(&|template, design| {
            black_box(size(&finger(template, design), &template.task(design), rule)).expect("a sizing");
        }) - built
    };
    let closed = time(&|template, design| {
        let finger = finger(template, design);
        let end = final_posture(&finger.lengths, finger.assembly, template.task(design).object).expect("a grasp");
        black_box(form_closure(&finger, &end)).expect("a decision");
    }) - ended;
    let all = time(&|template, design| {
        black_box(close_finger(template, design, Rule::Rigid)).expect("a closed finger");
    });
    let forces = time(&|template, design| {
        let closed = close_finger(template, design, Rule::Rigid).expect("a closed finger");
        for mu_static in [0.0, 0.4, 0.8] {
            black_box(solve_grasp(&closed, mu_static)).expect("forces");
        }
    }) - all;
    println!("| stage of one design, one thread | time (µs) |\n|---|---|");
    for (name, micros) in [
        ("lengths and masses", built),
        ("final posture", ended - built),
        ("sizing, rigid", sized(Rule::Rigid)),
        ("sizing, whole", sized(Rule::Whole)),
        ("form closure", closed),
        ("forces at three frictions", forces),
        ("total, rigid", all + forces),
    ] {
        println!("| {name} | {micros:.2} |");
    }
}

/// Prints the times of all volumes for each number of threads.
fn scaling(rule: Rule, args: &Args) {
    let request = VolumeRequest { rule, ..VolumeRequest::thesis() };
    let points = request.bases_m.len() * request.mu_static.len() * request.axes.len();
    println!(
        "\n| {points} points, {rule:?} sizing | time (s), median / min | points per second | speed-up |\n|---|---|---|---|"
    );
    let threads: Vec<u32> = (1..=args.threads).collect();
    let mut times = vec![Vec::new(); threads.len()];
    // Interleaved, so that disturbances of the machine affect all thread counts.
    for _ in 0..args.repetitions {
        for (&threads, times) in threads.iter().zip(&mut times) {
            let start = Instant::now();
            black_box(volumes(&request, threads as usize, &Monitor::silent(&|| true))).expect("the thesis's volumes");
            times.push(start.elapsed().as_secs_f64());
        }
    }
    let mut single_thread = None;
    for (threads, times) in threads.iter().zip(times) {
        let min = times.iter().copied().fold(f64::INFINITY, f64::min);
        let median_s = median(times);
        let single_thread_s = *single_thread.get_or_insert(median_s);
        let name = if *threads == 1 { "thread" } else { "threads" };
        println!(
            "| {threads} {name} | {median_s:.3} / {min:.3} | {:.0} | {:.2} |",
            points as f64 / median_s,
            single_thread_s / median_s
        );
    }
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
