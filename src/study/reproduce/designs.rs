//! Masses, trajectories and statics of the designs, also with other sizings.

use super::ReproduceError;
use super::sizing::SizingFound;
use crate::criteria::static_grasp;
use crate::gripper::{Bodies, Lengths};
use crate::scene::{Actuation, Scene, SpringKind, Template};
use crate::sizing::{Rule, Task, size};
use crate::statics::{NecessaryCount, form_closure};
use crate::study::select::Selection;
use crate::study::volume::{close_finger, design_at};
use crate::table::{Table, TableError};

/// Motor torque that the thesis prints for design 95 (§4.3); it has no other source.
pub const PRINTED_MOTOR_N_M: f64 = 0.480;
/// Spring torque that the thesis prints for design 95 (§4.3); it has no other source.
pub const PRINTED_SPRING_N_M: f64 = 0.1326;

/// Static properties of the designs.
#[derive(Clone, Debug, PartialEq)]
pub struct Designs {
    /// Lengths of design 95.
    pub lengths: Lengths,
    /// Bodies of design 95.
    pub bodies: Bodies,
    /// Smallest and largest mass of all designs.
    pub mass_kg: [f64; 2],
    /// Smallest and largest trajectory of all designs.
    pub trajectory_rad: [f64; 2],
    /// Necessary condition (1.19) for form closure of design 95.
    pub necessary_count: NecessaryCount,
    /// Number of form-closed designs if l21 takes quarters of its range, as printed (errata 15).
    pub form_closed_quarters: usize,
    pub other_sizings: Vec<OtherSizing>,
}

/// Number of statically stable designs with another sizing, without and with friction.
#[derive(Clone, Debug, PartialEq)]
pub struct OtherSizing {
    pub name: &'static str,
    pub stable: [usize; 2],
}

/// Evaluates the 192 designs. `scenes` are the runs of the study, first all without friction, then all with friction.
pub fn designs(
    scenes: &[Scene],
    results: &Table,
    selection: &Selection,
    chosen: usize,
    sizing: &SizingFound,
) -> Result<Designs, ReproduceError> {
    let table_error = |error: TableError| ReproduceError::in_step("the designs")(&error);
    let extremes = |name: &str| -> Result<[f64; 2], TableError> {
        let values = results.numbers(name)?.into_iter().flatten();
        Ok(values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]))
    };
    let finger = &scenes[chosen].finger().linkage;
    Ok(Designs {
        lengths: finger.lengths,
        bodies: finger.bodies,
        mass_kg: extremes("mass_kg").map_err(table_error)?,
        trajectory_rad: extremes("trajectory_rad").map_err(table_error)?,
        necessary_count: necessary_count(&scenes[chosen])?,
        form_closed_quarters: form_closed_in_quarters()?,
        other_sizings: other_sizings(scenes, selection, sizing)?,
    })
}

fn necessary_count(scene: &Scene) -> Result<NecessaryCount, ReproduceError> {
    let error = ReproduceError::in_step("form closure");
    let object = scene.object().ok_or_else(|| error(&"there is no object"))?;
    let rest = static_grasp(scene, object).map_err(|reason| error(&reason))?;
    Ok(form_closure(&scene.finger().linkage, &rest.end).map_err(|reason| error(&reason))?.necessary)
}

/// Returns the number of form-closed designs of the design space printed in §4.2.
fn form_closed_in_quarters() -> Result<usize, ReproduceError> {
    let template = Template::thesis();
    let mut closed = 0;
    for base_m in [0.012, 0.0155, 0.019, 0.0225] {
        for l21_fraction in [0.0, 0.25, 0.5, 0.75] {
            for phi22_deg in [90.0f64, 100.0, 110.0, 120.0] {
                for arm_ratio in [1.0 / 3.0, 0.5, 2.0 / 3.0] {
                    let design = design_at(&template, base_m, [l21_fraction, phi22_deg.to_radians(), arm_ratio]);
                    let finger = close_finger(&template, &design, Rule::Rigid)
                        .map_err(|error| ReproduceError::in_step("the designs in quarters")(&error))?;
                    closed += usize::from(finger.sized.form_closed);
                }
            }
        }
    }
    Ok(closed)
}

/// Evaluates static stability with the sizing of the study, with the other rule, and with motor and spring torques
/// scaled by the printed ratios of design 95.
fn other_sizings(
    scenes: &[Scene],
    selection: &Selection,
    found: &SizingFound,
) -> Result<Vec<OtherSizing>, ReproduceError> {
    let stable_in_study =
        [0, 1].map(|condition| selection.classes.get(condition).map_or(0, |counts| counts.statically_stable));
    let (motor_ratio, spring_ratio) =
        (PRINTED_MOTOR_N_M / found.rigid.motor_n_m, PRINTED_SPRING_N_M / found.rigid.spring_n_m);
    let scenes_per_condition = scenes.len() / 2;
    let count = |torques: &dyn Fn(&Scene) -> Result<[f64; 2], ReproduceError>| -> Result<[usize; 2], ReproduceError> {
        let mut stable = [0; 2];
        for (index, scene) in scenes.iter().enumerate() {
            let [motor_n_m, spring_n_m] = torques(scene)?;
            stable[usize::from(index >= scenes_per_condition)] +=
                usize::from(is_force_positive(scene, motor_n_m, spring_n_m)?);
        }
        Ok(stable)
    };
    let rigid_torques = |scene: &Scene| size_torques(scene, Rule::Rigid);
    Ok(vec![
        OtherSizing { name: "this study: RMS over the rigid phase", stable: stable_in_study },
        OtherSizing { name: "RMS over all 10 ms", stable: count(&|scene| size_torques(scene, Rule::Whole))? },
        OtherSizing {
            name: "spring of every design stronger by the printed ratio of design 95",
            stable: count(&|scene| rigid_torques(scene).map(|[motor, spring]| [motor, spring * spring_ratio]))?,
        },
        OtherSizing {
            name: "spring stronger and motor weaker by the printed ratios of design 95",
            stable: count(&|scene| {
                rigid_torques(scene).map(|[motor, spring]| [motor * motor_ratio, spring * spring_ratio])
            })?,
        },
    ])
}

/// Returns motor and spring torque by a sizing rule.
fn size_torques(scene: &Scene, rule: Rule) -> Result<[f64; 2], ReproduceError> {
    let error = ReproduceError::in_step("another sizing");
    let object = scene.object().ok_or_else(|| error(&"there is no object"))?;
    let task = Task::thesis(object.placed());
    let sizing = size(&scene.finger().linkage, &task, rule).map_err(|reason| error(&reason))?;
    Ok([sizing.motor_n_m, sizing.spring_n_m])
}

/// Returns whether the grasp is force-positive with other torques.
fn is_force_positive(scene: &Scene, motor_n_m: f64, spring_n_m: f64) -> Result<bool, ReproduceError> {
    let mut other = scene.clone();
    other.finger_mut().motor.actuation = Actuation::Constant { torque_n_m: motor_n_m };
    if let Some(spring) = &mut other.finger_mut().spring {
        spring.kind = SpringKind::Constant { torque_n_m: spring_n_m };
    }
    let error = ReproduceError::in_step("static stability");
    let object = scene.object().ok_or_else(|| error(&"there is no object"))?;
    let rest = static_grasp(&other, object).map_err(|reason| error(&reason))?;
    Ok(rest.forces.map_err(|reason| error(&reason))?.is_force_positive())
}
