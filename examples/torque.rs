//! A scene changed in memory: one parameter is swept, and the outcomes make a table. Everything in a
//! [`Scene`](phalanx::scene::Scene) can be set like this; `phalanx sweep` does the same for whole grids on all processors.
//!
//! `cargo run --release --example torque`

use std::error::Error;

use phalanx::scene::{self, Actuation};
use phalanx::trace::{Model, Site, run};

/// One closing.
pub struct Row {
    pub torque_n_m: f64,
    /// Of the distal phalanx; none if it never gets there.
    pub first_s: Option<f64>,
    pub peak_n: f64,
    /// Forces of both phalanges in the end.
    pub last_n: [f64; 2],
}

/// The closing of a shipped scene by motors of several strengths.
pub fn sweep() -> Result<Vec<Row>, Box<dyn Error>> {
    let mut scene = scene::load("scenes/experiment-95.toml")?;
    let mut rows = Vec::new();
    for torque_n_m in [0.4, 0.5, 0.6, 0.7, 0.8] {
        scene.finger_mut().motor.actuation = Actuation::Constant { torque_n_m };
        let outcome = run(Model::Analytic, &scene, &mut ())?;
        let distal = outcome.site(Site::Distal);
        let last_n = [outcome.last.contact(Site::Proximal).normal_n, outcome.last.contact(Site::Distal).normal_n];
        rows.push(Row { torque_n_m, first_s: distal.first_s, peak_n: distal.peak_normal_n, last_n });
    }
    Ok(rows)
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("torque     distal touch  distal peak  F21 at the end  F22 at the end");
    for Row { torque_n_m, first_s, peak_n, last_n: [f21, f22] } in sweep()? {
        let first = first_s.map_or("never".to_string(), |first_s| format!("{:.3} ms", first_s * 1e3));
        println!("{torque_n_m:.1} N·m {first:>15} {peak_n:>10.1} N {f21:>13.2} N {f22:>13.2} N");
    }
    Ok(())
}
