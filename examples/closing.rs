//! Simulates a scene file and prints the contact times and forces of both phalanges.
//!
//! `cargo run --release --example closing`

use std::error::Error;

use phalanx::prelude::*;

/// Simulates a closing with the analytic model.
pub fn closing() -> Result<Outcome, Box<dyn Error>> {
    let scene = scene::load("scenes/experiment-95.toml")?;
    // The sink `()` ignores all samples; only the outcome is used.
    Ok(run(Model::Analytic, &scene, &mut ())?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let outcome = closing()?;
    for (contact, last) in [
        (FingerContact::Proximal, outcome.last.finger_contact(FingerContact::Proximal)),
        (FingerContact::Distal, outcome.last.finger_contact(FingerContact::Distal)),
    ] {
        let summary = outcome.finger_contact(contact);
        let Some(first_s) = summary.first_s else {
            println!("{:9} never touches the object", contact.name());
            continue;
        };
        println!(
            "{:9} touches at {:.4} ms, with a peak force of {:.1} N and a final force of {:.3} N",
            contact.name(),
            first_s * 1e3,
            summary.peak_normal_n,
            last.normal_n,
        );
    }
    println!("{} steps, energy balance {:.1e} J", outcome.work.steps, outcome.last.energy().balance_j);
    Ok(())
}
