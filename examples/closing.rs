//! A scene file in, a closing out: which phalanx touches when, how hard, and what the grasp is like in the end.
//!
//! `cargo run --release --example closing`

use std::error::Error;

use phalanx::scene;
use phalanx::trace::{Model, Outcome, Site, run};

/// The closing of a shipped scene, in the analytic model.
pub fn closing() -> Result<Outcome, Box<dyn Error>> {
    let scene = scene::load("scenes/experiment-95.toml")?;
    // `()` listens to nothing: what remains is the outcome.
    Ok(run(Model::Analytic, &scene, &mut ())?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let outcome = closing()?;
    for (site, now) in
        [(Site::Proximal, outcome.last.contact(Site::Proximal)), (Site::Distal, outcome.last.contact(Site::Distal))]
    {
        let summary = outcome.site(site);
        let Some(first_s) = summary.first_s else {
            println!("{:9} never touches the object", site.name());
            continue;
        };
        println!(
            "{:9} touches at {:.4} ms, presses with {:.1} N at most and with {:.3} N in the end",
            site.name(),
            first_s * 1e3,
            summary.peak_normal_n,
            now.normal_n,
        );
    }
    println!("{} steps, energy balance {:.1e} J", outcome.work.steps, outcome.last.energy.balance_j);
    Ok(())
}
