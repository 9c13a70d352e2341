//! Fingers on their discs, at random and of the thesis's grid.

use std::fmt::Debug;

pub use super::random::Random;
use phalanx::gripper::{
    Assembly, Design, FinalPosture, Finger, Lengths, Placement, ProximalLength, Spring, SpringKind, bodies, disc,
    final_posture, lengths,
};
use phalanx::shape::{Placed, reach};
use phalanx::statics::{Certificate, FormClosure, Kind, Unilateral};

/// A finger that holds its disc.
#[derive(Clone, Debug)]
pub struct Grasp {
    pub finger: Finger,
    pub disc: Placed,
    pub end: FinalPosture,
}

/// The grasp of a design; `None` if these numbers make none.
pub fn grasp(design: &Design) -> Option<Grasp> {
    let lengths = lengths(design).ok()?;
    let finger = Finger { lengths, bodies: bodies(&lengths, 1070.0, 0.04).ok()?, assembly: Assembly::Reference };
    let disc = disc(design);
    let end = final_posture(&lengths, Assembly::Reference, disc).ok()?;
    Some(Grasp { finger, disc, end })
}

/// The same grasp with phalanges that are lines: the disc grows by what they lost.
pub fn without_width(grasp: &Grasp) -> Grasp {
    let w = grasp.finger.lengths.half_width_m;
    let finger = Finger { lengths: Lengths { half_width_m: 0.0, ..grasp.finger.lengths }, ..grasp.finger };
    let disc = Placed::disc(reach(&grasp.disc.shape) + w, grasp.disc.centre_m);
    let end = final_posture(&finger.lengths, finger.assembly, disc).expect("tangent to the same virtual circle");
    Grasp { finger, disc, end }
}

pub fn constant_spring(torque_n_m: f64) -> Spring {
    Spring { kind: SpringKind::Constant { torque_n_m }, placement: Placement::Phalanges }
}

impl Random {
    /// The next design within the ranges of the thesis (§3.4) that makes a grasp.
    pub fn grasp(&mut self) -> Grasp {
        loop {
            let base_m = self.within(0.012, 0.0225);
            let l21 = ProximalLength::Fraction(self.within(0.0, 1.0));
            let phi22_rad = self.within(90.0, 120.0).to_radians();
            let design = Design::thesis(base_m, l21, phi22_rad, self.within(1.0 / 3.0, 2.0 / 3.0));
            if let Some(grasp) = grasp(&design) {
                return grasp;
            }
        }
    }
}

/// A certificate proves what it says, by plain sums over the rows and columns of U.
#[track_caller]
pub fn check<R: Copy + Debug + Into<Kind>>(u: &Unilateral<R>, found: &FormClosure<R>) {
    match &found.certificate {
        Certificate::Multipliers { values, residual } => {
            assert!(found.closed && found.rank == u.unknowns.len());
            assert!(values.iter().all(|&lambda| lambda > 0.0), "{values:?}");
            for (j, unknown) in u.unknowns.iter().enumerate() {
                let terms: Vec<f64> = values.iter().enumerate().map(|(i, l)| l * u.row(i)[j]).collect();
                let size = terms.iter().map(|t| t.abs()).fold(0.0, f64::max);
                assert!(terms.iter().sum::<f64>().abs() < 1e-9 * size, "{unknown:?}: {terms:?}");
            }
            assert!(*residual < 1e-12, "{residual:e}");
        }
        Certificate::Motion { values, rates, residual } => {
            assert!(!found.closed);
            assert!(values.iter().any(|v| v.abs() > 1e-9), "{values:?}");
            let largest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
            let speed = largest(&mut values.iter().zip(&u.scale).map(|(w, scale)| w * scale));
            for (i, row) in u.rows.iter().enumerate() {
                let terms: Vec<f64> = values.iter().zip(u.row(i)).map(|(w, u)| w * u).collect();
                let size = speed * largest(&mut u.row(i).iter().zip(&u.scale).map(|(u, scale)| u / scale));
                let sum = terms.iter().sum::<f64>();
                assert!(sum >= -1e-9 * size, "{row:?}: {terms:?}");
                assert!((sum - rates[i]).abs() <= 1e-12 * size);
            }
            assert!(*residual < 1e-12, "{residual:e}");
        }
    }
}
