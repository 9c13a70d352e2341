//! The thesis's grasp-state volumes: 4 bases × 3 frictions × 20³ points, 96,000 of them, 32,000 designs sized and closed.
//!
//!     cargo bench --bench volume
//!     cargo bench --bench volume -- --designs 1000        (nothing else: for counting instructions)

use std::hint::black_box;
use std::time::Instant;

use clap::Parser;
use phalanx::gripper::{Assembly, Design, Finger, bodies, final_posture, lengths};
use phalanx::scene::Template;
use phalanx::sizing::{Rule, size};
use phalanx::statics::form_closure;
use phalanx::study::volume::{Axes, VolumeRequest, close, design, hold, volumes};

#[derive(Debug, Parser)]
struct Args {
    /// Repetitions that are timed
    #[arg(long, default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..))]
    repetitions: u32,

    /// Most threads
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..))]
    threads: u32,

    /// Build, size, close and hold (with three frictions) this many designs and do nothing else
    #[arg(long, value_name = "N")]
    designs: Option<usize>,

    /// What cargo bench adds
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() {
    let args = Args::parse();
    if let Some(designs) = args.designs {
        return points_only(designs);
    }
    parts(args.repetitions);
    for rule in [Rule::Rigid, Rule::Whole] {
        scaling(rule, &args);
    }
}

/// The designs of the thesis's volume of one base, over and over.
fn each_design(count: usize, mut use_it: impl FnMut(&Template, &Design)) {
    let template = Template::thesis();
    let axes = Axes::thesis([20; 3]);
    for index in 0..count {
        // A stride that is prime to the number of points: any number of designs is spread over the volume.
        use_it(&template, &design(&template, 0.0155, axes.at(index * 4_813 % axes.len())));
    }
}

fn points_only(designs: usize) {
    each_design(designs, |template, design| {
        let closed = close(template, design, Rule::Rigid).expect("every design of the thesis has a finger");
        for mu_static in [0.0, 0.4, 0.8] {
            black_box(hold(&closed, mu_static)).expect("and holds");
        }
    });
}

/// What of a design takes how long, on one thread.
fn parts(repetitions: u32) {
    const DESIGNS: usize = 2_000;
    let finger = |template: &Template, design: &Design| {
        let lengths = lengths(design).expect("a finger");
        let bodies = bodies(&lengths, template.density_kg_m3, template.depth_m).expect("with masses");
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
        black_box(form_closure(&finger, &end)).expect("an answer");
    }) - ended;
    let all = time(&|template, design| {
        black_box(close(template, design, Rule::Rigid)).expect("a closed finger");
    });
    let held = time(&|template, design| {
        let closed = close(template, design, Rule::Rigid).expect("a closed finger");
        for mu_static in [0.0, 0.4, 0.8] {
            black_box(hold(&closed, mu_static)).expect("forces");
        }
    }) - all;
    println!("| of one design, one thread | time (µs) |\n|---|---|");
    for (name, micros) in [
        ("lengths and masses", built),
        ("final posture", ended - built),
        ("sizing, rigid", sized(Rule::Rigid)),
        ("sizing, whole", sized(Rule::Whole)),
        ("form closure", closed),
        ("forces at three frictions", held),
        ("all of it, rigid", all + held),
    ] {
        println!("| {name} | {micros:.2} |");
    }
}

/// All volumes on one thread, two, and so on.
fn scaling(rule: Rule, args: &Args) {
    let request = VolumeRequest { rule, ..VolumeRequest::thesis() };
    let points = request.bases_m.len() * request.mu_static.len() * request.axes.len();
    println!(
        "\n| {points} points, {rule:?} sizing | time (s), median / min | points a second | against one thread |\n|---|---|---|---|"
    );
    let threads: Vec<u32> = (1..=args.threads).collect();
    let mut times = vec![Vec::new(); threads.len()];
    // In turn, so that what disturbs the machine disturbs all.
    for _ in 0..args.repetitions {
        for (&threads, times) in threads.iter().zip(&mut times) {
            let start = Instant::now();
            black_box(volumes(&request, threads as usize)).expect("the thesis's volumes");
            times.push(start.elapsed().as_secs_f64());
        }
    }
    let mut one = None;
    for (threads, times) in threads.iter().zip(times) {
        let least = times.iter().copied().fold(f64::INFINITY, f64::min);
        let middle = median(times);
        let one = *one.get_or_insert(middle);
        let name = if *threads == 1 { "thread" } else { "threads" };
        println!(
            "| {threads} {name} | {middle:.3} / {least:.3} | {:.0} | {:.2} |",
            points as f64 / middle,
            one / middle
        );
    }
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
