//! Changes a scene of discs in memory and prints the restitution of an impact.
//!
//! `cargo run --release --example restitution`

use std::error::Error;

use phalanx::criteria::Rebounds;
use phalanx::prelude::*;

/// Approach and separation speed, m/s, and peak force, N.
pub struct Bounce {
    pub approach_m_s: f64,
    pub separation_m_s: f64,
    pub peak_n: f64,
}

/// Simulates impacts of a disc with increasing speed.
pub fn bounces() -> Result<Vec<Bounce>, Box<dyn Error>> {
    let mut scene = scene::load_any("scenes/laws/impact.toml")?;
    let mut bounces = Vec::new();
    for speed_m_s in [1.0, 2.0, 4.0] {
        let mechanism = scene.mechanism.as_mut().ok_or("the scene has fingers")?;
        let hammer = mechanism.bodies.iter_mut().find(|body| body.name == "hammer").ok_or("there is no hammer")?;
        hammer.rate = [speed_m_s, 0.0, 0.0];
        // This sink records the first impact of each pair.
        let mut rebounds = Rebounds::for_mechanism(mechanism).ok_or("the mechanism has joints")?;
        let outcome = run(Model::Analytic, &scene, &mut rebounds)?;
        if let [pair] = rebounds.pairs()
            && let (Some(approach_m_s), Some(separation_m_s)) = (pair.approach_m_s, pair.separation_m_s)
        {
            bounces.push(Bounce { approach_m_s, separation_m_s, peak_n: outcome.contacts[0].peak_normal_n });
        }
    }
    Ok(bounces)
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("approach      separation    ratio    peak force");
    for Bounce { approach_m_s, separation_m_s, peak_n } in bounces()? {
        let percent = 100.0 * separation_m_s / approach_m_s;
        println!("{approach_m_s:.3} m/s   {separation_m_s:>8.4} m/s  {percent:>6.2} %  {peak_n:>8.2} N");
    }
    Ok(())
}
