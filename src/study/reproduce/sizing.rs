//! Spring and motor of design 95, and what place and type of the spring do in all designs (thesis §3.3.2).

use std::f64::consts::FRAC_PI_2;

use super::ReproduceError;
use crate::scene::{self, Scene};
use crate::sizing::{Profile, ProfilePoint, Sizing, Task, profile};

/// The finger of Figs. 3.2 and 3.3.
const EXAMPLE: &str =
    "sizing = \"rigid\"\n[design]\nbase = \"12 mm\"\nl21 = \"18.9 mm\"\nphi22 = \"100 deg\"\narm_ratio = 0.5\n";

/// How far a torsional spring is turned where the finger is straight: a right angle. The thesis does not say.
const PRELOAD_RAD: f64 = FRAC_PI_2;

/// Samples of the example's profile, and of one that is only looked at.
const SAMPLES: usize = 400;
const FEW_SAMPLES: usize = 60;

/// What sizing finds.
#[derive(Clone, Debug, PartialEq)]
pub struct SizingFound {
    /// Design 95 by both rules.
    pub rigid: Sizing,
    pub whole: Sizing,
    /// The finger of Figs. 3.2 and 3.3.
    pub example: Profile,
    /// Designs whose weakest springs are the last two of the four places.
    pub best_places: usize,
    /// Designs where a constant spring never asks for more torque than a torsional one.
    pub constant_better: usize,
    pub designs: usize,
}

/// Sizes design 95, the example, and every one of these designs.
pub fn sizing(designs: &[Scene], chosen: &Scene) -> Result<SizingFound, ReproduceError> {
    let example = scene::parse(EXAMPLE, "example.toml").map_err(|error| ReproduceError::of("the example")(&error))?;
    let chosen = profiled(chosen, FEW_SAMPLES)?;
    let mut found = SizingFound {
        rigid: chosen.rigid,
        whole: chosen.whole,
        example: profiled(&example, SAMPLES)?,
        best_places: 0,
        constant_better: 0,
        designs: designs.len(),
    };
    for design in designs {
        let profile = profiled(design, FEW_SAMPLES)?;
        let [s1, s2, s3, s4] = profile.placements_n_m;
        found.best_places += usize::from(s3.max(s4) < s1.min(s2));
        // Up to the contact both springs are alike, but for rounding.
        let better =
            |point: &ProfilePoint| point.constant_n_m <= point.torsional_n_m + 1e-12 * point.torsional_n_m.abs();
        found.constant_better += usize::from(profile.points.iter().all(better));
    }
    Ok(found)
}

fn profiled(scene: &Scene, samples: usize) -> Result<Profile, ReproduceError> {
    let error = ReproduceError::of("the sizing");
    let object = scene.object().ok_or_else(|| error(&"there is no object"))?;
    let task = Task::thesis(object.placed());
    profile(&scene.finger().linkage, &task, PRELOAD_RAD, samples).map_err(|reason| error(&reason))
}
