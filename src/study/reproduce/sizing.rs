//! Sizing of spring and motor of design 95, and the influence of placement and type of the spring for all designs
//! (thesis §3.3.2).

use std::f64::consts::FRAC_PI_2;

use super::ReproduceError;
use crate::scene::{self, Scene};
use crate::sizing::{Profile, ProfilePoint, Sizing, Task, profile};

/// The finger of Figs. 3.2 and 3.3.
const EXAMPLE: &str =
    "sizing = \"rigid\"\n[design]\nbase = \"12 mm\"\nl21 = \"18.9 mm\"\nphi22 = \"100 deg\"\narm_ratio = 0.5\n";

/// Deflection of a torsional spring for the straight finger: a right angle. The thesis does not specify it.
const PRELOAD_RAD: f64 = FRAC_PI_2;

/// Number of samples of the example's profile.
const SAMPLES: usize = 400;
/// Number of samples of a profile that is evaluated but not plotted.
const FEW_SAMPLES: usize = 60;

/// Results of the sizing.
#[derive(Clone, Debug, PartialEq)]
pub struct SizingFound {
    /// Design 95 by the rigid-phase rule.
    pub rigid: Sizing,
    /// Design 95 by the rule over the whole closing.
    pub whole: Sizing,
    /// The finger of Figs. 3.2 and 3.3.
    pub example: Profile,
    /// Number of designs whose two weakest springs are the last two of the four placements.
    pub last_placements_weakest: usize,
    /// Number of designs in which a constant spring never requires more torque than a torsional one.
    pub constant_spring_weaker: usize,
    pub designs: usize,
}

/// Sizes design 95, the example, and every one of these designs.
pub fn sizing(designs: &[Scene], chosen: &Scene) -> Result<SizingFound, ReproduceError> {
    let example =
        scene::parse(EXAMPLE, "example.toml").map_err(|error| ReproduceError::in_step("the example")(&error))?;
    let chosen = sizing_profile(chosen, FEW_SAMPLES)?;
    let mut found = SizingFound {
        rigid: chosen.rigid,
        whole: chosen.whole,
        example: sizing_profile(&example, SAMPLES)?,
        last_placements_weakest: 0,
        constant_spring_weaker: 0,
        designs: designs.len(),
    };
    for design in designs {
        let profile = sizing_profile(design, FEW_SAMPLES)?;
        let [s1, s2, s3, s4] = profile.placements_n_m;
        found.last_placements_weakest += usize::from(s3.max(s4) < s1.min(s2));
        // Up to the contact both springs are equal except for rounding.
        let is_weaker =
            |point: &ProfilePoint| point.constant_n_m <= point.torsional_n_m + 1e-12 * point.torsional_n_m.abs();
        found.constant_spring_weaker += usize::from(profile.points.iter().all(is_weaker));
    }
    Ok(found)
}

fn sizing_profile(scene: &Scene, samples: usize) -> Result<Profile, ReproduceError> {
    let error = ReproduceError::in_step("the sizing");
    let object = scene.object().ok_or_else(|| error(&"there is no object"))?;
    let task = Task::thesis(object.placed());
    profile(&scene.finger().linkage, &task, PRELOAD_RAD, samples).map_err(|reason| error(&reason))
}
