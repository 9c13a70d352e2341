//! Sweeps one parameter of a scene in memory and prints the outcomes as a table. All fields of a
//! [`Scene`](phalanx::scene::Scene) can be changed like this; `phalanx sweep` runs grids of parameters on all processors.
//!
//! `cargo run --release --example torque`

use std::error::Error;

use phalanx::prelude::*;
use phalanx::scene::Profile;

/// Result of one closing.
pub struct Row {
    pub torque_n_m: f64,
    /// First contact of the distal phalanx; `None` if there is none.
    pub first_s: Option<f64>,
    pub peak_n: f64,
    /// Normal forces of both phalanges at the end.
    pub last_n: [f64; 2],
}

/// Simulates closings with several motor torques.
pub fn sweep() -> Result<Vec<Row>, Box<dyn Error>> {
    let mut scene = scene::load("scenes/experiment-95.toml")?;
    let mut rows = Vec::new();
    for torque_n_m in [0.4, 0.5, 0.6, 0.7, 0.8] {
        scene.finger_mut().motor.actuation = Profile::Constant { value: torque_n_m };
        let outcome = run(Model::Analytic, &scene, &mut ())?;
        let distal = outcome.finger_contact(FingerContact::Distal);
        let last_n = [
            outcome.last.finger_contact(FingerContact::Proximal).normal_n,
            outcome.last.finger_contact(FingerContact::Distal).normal_n,
        ];
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
