//! A scene of discs, changed in memory: how much of its speed a disc keeps when it bounces off another one.
//!
//! `cargo run --release --example restitution`

use std::error::Error;

use phalanx::criteria::Rebounds;
use phalanx::scene::{self, DiscMotion};
use phalanx::trace::{Model, run};

/// Speeds before and after, in m/s, and the peak force in N.
pub struct Bounce {
    pub approach_m_s: f64,
    pub separation_m_s: f64,
    pub peak_n: f64,
}

/// The same disc thrown at the same plate, faster and faster.
pub fn bounces() -> Result<Vec<Bounce>, Box<dyn Error>> {
    let mut scene = scene::load_any("scenes/laws/impact.toml")?;
    let mut found = Vec::new();
    for speed_m_s in [1.0, 2.0, 4.0] {
        let hammer = scene.system.discs.iter_mut().find(|disc| disc.name == "hammer").ok_or("there is no hammer")?;
        if let DiscMotion::Free { velocity_m_s, .. } = &mut hammer.motion {
            *velocity_m_s = [speed_m_s, 0.0];
        }
        // This sink keeps what the impacts were like.
        let mut rebounds = Rebounds::of(&scene.system);
        let outcome = run(Model::Analytic, &scene, &mut rebounds)?;
        if let [pair] = rebounds.pairs()
            && let (Some(approach_m_s), Some(separation_m_s)) = (pair.approach_m_s, pair.separation_m_s)
        {
            found.push(Bounce { approach_m_s, separation_m_s, peak_n: outcome.contacts[0].peak_normal_n });
        }
    }
    Ok(found)
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("approach      separation    kept     peak force");
    for Bounce { approach_m_s, separation_m_s, peak_n } in bounces()? {
        let kept = 100.0 * separation_m_s / approach_m_s;
        println!("{approach_m_s:.3} m/s   {separation_m_s:>8.4} m/s  {kept:>6.2} %  {peak_n:>8.2} N");
    }
    Ok(())
}
