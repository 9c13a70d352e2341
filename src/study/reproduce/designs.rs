//! Masses, trajectories and statics of the designs, also as they would be by other sizings.

use super::ReproduceError;
use super::sizing::SizingFound;
use crate::criteria::at_rest;
use crate::gripper::{Bodies, Lengths};
use crate::scene::{Actuation, Scene, SpringKind, Template};
use crate::sizing::{Rule, Task, size};
use crate::statics::{NecessaryCount, form_closure};
use crate::study::select::Selection;
use crate::study::volume::{close, design};
use crate::table::{Table, TableError};

/// Torques that the thesis prints for design 95 (§4.3): they have no other source.
pub const PRINTED_MOTOR_N_M: f64 = 0.480;
pub const PRINTED_SPRING_N_M: f64 = 0.1326;

/// What the designs are, before they move.
#[derive(Clone, Debug, PartialEq)]
pub struct Designs {
    /// Of design 95.
    pub lengths: Lengths,
    pub bodies: Bodies,
    /// Smallest and largest of all designs.
    pub mass_kg: [f64; 2],
    pub trajectory_rad: [f64; 2],
    /// The count (1.19) of design 95.
    pub necessary: NecessaryCount,
    /// Form-closed designs if l21 has quarters of its range, as printed (errata 15).
    pub form_closed_quarters: usize,
    pub other_sizings: Vec<OtherSizing>,
}

/// Statically stable designs by one sizing, without and with friction.
#[derive(Clone, Debug, PartialEq)]
pub struct OtherSizing {
    pub name: &'static str,
    pub stable: [usize; 2],
}

/// Looks at the 192 designs; `scenes` are the runs of the study, first all without friction, then all with it.
pub fn designs(
    scenes: &[Scene],
    results: &Table,
    selection: &Selection,
    chosen: usize,
    sizing: &SizingFound,
) -> Result<Designs, ReproduceError> {
    let wrong = |error: TableError| ReproduceError::of("the designs")(&error);
    let ends = |name: &str| -> Result<[f64; 2], TableError> {
        let values = results.numbers(name)?.into_iter().flatten();
        Ok(values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]))
    };
    let finger = &scenes[chosen].finger().linkage;
    Ok(Designs {
        lengths: finger.lengths,
        bodies: finger.bodies,
        mass_kg: ends("mass_kg").map_err(wrong)?,
        trajectory_rad: ends("trajectory_rad").map_err(wrong)?,
        necessary: necessary(&scenes[chosen])?,
        form_closed_quarters: quarters()?,
        other_sizings: other_sizings(scenes, selection, sizing)?,
    })
}

fn necessary(scene: &Scene) -> Result<NecessaryCount, ReproduceError> {
    let error = ReproduceError::of("form closure");
    let object = scene.object().ok_or_else(|| error(&"there is no object"))?;
    let rest = at_rest(scene, object).map_err(|reason| error(&reason))?;
    Ok(form_closure(&scene.finger().linkage, &rest.end).map_err(|reason| error(&reason))?.necessary)
}

/// Form-closed designs of the space that §4.2 prints.
fn quarters() -> Result<usize, ReproduceError> {
    let template = Template::thesis();
    let mut closed = 0;
    for base_m in [0.012, 0.0155, 0.019, 0.0225] {
        for l21_fraction in [0.0, 0.25, 0.5, 0.75] {
            for phi22_deg in [90.0f64, 100.0, 110.0, 120.0] {
                for arm_ratio in [1.0 / 3.0, 0.5, 2.0 / 3.0] {
                    let of = design(&template, base_m, [l21_fraction, phi22_deg.to_radians(), arm_ratio]);
                    let found = close(&template, &of, Rule::Rigid)
                        .map_err(|error| ReproduceError::of("the designs in quarters")(&error))?;
                    closed += usize::from(found.sized.form_closed);
                }
            }
        }
    }
    Ok(closed)
}

/// Static stability by the sizing of the study, by the other rule, and with motor and spring as far off as they are printed
/// for design 95.
fn other_sizings(
    scenes: &[Scene],
    selection: &Selection,
    found: &SizingFound,
) -> Result<Vec<OtherSizing>, ReproduceError> {
    let ours = [0, 1].map(|condition| selection.classes.get(condition).map_or(0, |of| of.statically_stable));
    let (motor, spring) = (PRINTED_MOTOR_N_M / found.rigid.motor_n_m, PRINTED_SPRING_N_M / found.rigid.spring_n_m);
    let half = scenes.len() / 2;
    let count = |torques: &dyn Fn(&Scene) -> Result<[f64; 2], ReproduceError>| -> Result<[usize; 2], ReproduceError> {
        let mut stable = [0; 2];
        for (index, scene) in scenes.iter().enumerate() {
            let [motor_n_m, spring_n_m] = torques(scene)?;
            stable[usize::from(index >= half)] += usize::from(holds(scene, motor_n_m, spring_n_m)?);
        }
        Ok(stable)
    };
    let own = |scene: &Scene| sized(scene, Rule::Rigid);
    Ok(vec![
        OtherSizing { name: "this study: RMS over the rigid phase", stable: ours },
        OtherSizing { name: "RMS over all 10 ms", stable: count(&|scene| sized(scene, Rule::Whole))? },
        OtherSizing {
            name: "spring of every design stronger by the printed ratio of design 95",
            stable: count(&|scene| own(scene).map(|[m, s]| [m, s * spring]))?,
        },
        OtherSizing {
            name: "spring stronger and motor weaker by the printed ratios of design 95",
            stable: count(&|scene| own(scene).map(|[m, s]| [m * motor, s * spring]))?,
        },
    ])
}

/// Motor and spring by a rule.
fn sized(scene: &Scene, rule: Rule) -> Result<[f64; 2], ReproduceError> {
    let error = ReproduceError::of("another sizing");
    let object = scene.object().ok_or_else(|| error(&"there is no object"))?;
    let task = Task::thesis(object.placed());
    let sizing = size(&scene.finger().linkage, &task, rule).map_err(|reason| error(&reason))?;
    Ok([sizing.motor_n_m, sizing.spring_n_m])
}

/// Force positiveness with other torques.
fn holds(scene: &Scene, motor_n_m: f64, spring_n_m: f64) -> Result<bool, ReproduceError> {
    let mut other = scene.clone();
    other.finger_mut().motor.actuation = Actuation::Constant { torque_n_m: motor_n_m };
    if let Some(spring) = &mut other.finger_mut().spring {
        spring.kind = SpringKind::Constant { torque_n_m: spring_n_m };
    }
    let error = ReproduceError::of("static stability");
    let object = scene.object().ok_or_else(|| error(&"there is no object"))?;
    let rest = at_rest(&other, object).map_err(|reason| error(&reason))?;
    Ok(rest.forces.map_err(|reason| error(&reason))?.is_force_positive())
}
