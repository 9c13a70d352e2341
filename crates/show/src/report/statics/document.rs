//! The JSON document of the static analysis of a finger, with units in the keys.

use serde::Serialize;

use super::closure::ClosureReport;
use crate::grasp::finger::{Contact, Drive, Forces, Grasp};
use crate::gripper::{FingerContact, Placement, SpringKind};
use crate::statics::{Ejection, Equilibrium};

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StaticsReport {
    pub scene: String,
    #[serde(rename = "final")]
    pub end: FinalPostureReport,
    pub drive: DriveReport,
    /// One for each requested friction coefficient.
    pub forces: Vec<ForcesReport>,
    /// Forces per 1 N·m of motor torque without spring and friction.
    pub forces_per_n_m: [f64; 3],
    pub form_closure: ClosureReport,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub svg: Option<String>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FinalPostureReport {
    pub q11_rad: f64,
    pub q21_rad: f64,
    pub q12_rad: f64,
    pub q22_rad: f64,
    pub phi_c_rad: f64,
    pub proximal: Contact,
    pub distal: Contact,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriveReport {
    pub motor_n_m: f64,
    /// Minimum motor torque at which the distal phalanx pushes.
    pub motor_min_n_m: Option<f64>,
    pub spring: Option<SpringReport>,
    /// Generalised forces of motor and spring on (q11, q21).
    pub loads_n_m: [f64; 2],
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpringReport {
    #[serde(rename = "type")]
    pub kind: &'static str,
    pub placement: &'static str,
    pub torque_n_m: f64,
    /// Generalised forces on (q11, q21).
    pub loads_n_m: [f64; 2],
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ForcesReport {
    /// Friction coefficients of the proximal and the distal contact.
    pub mu_static: [f64; 2],
    pub f21_n: f64,
    pub f22_n: f64,
    pub pfp_n: f64,
    pub force_positive: bool,
    pub palm_force_positive: bool,
    /// Phalanges that lose contact: "none", "proximal", "distal" or "both".
    pub ejection: &'static str,
    pub birglen: BirglenReport,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BirglenReport {
    pub jacobian_m: [[f64; 2]; 2],
    pub transmission: [[f64; 2]; 2],
    pub transmission_inverse: [[f64; 2]; 2],
    pub torques_n_m: [f64; 2],
    pub forces_n: [f64; 2],
    /// f − (F21, F22).
    pub difference_n: [f64; 2],
}

impl StaticsReport {
    pub fn new(grasp: &Grasp) -> Self {
        let [proximal, distal] = grasp.contacts;
        let posture = &grasp.end.posture;
        let unit_torque_forces = &grasp.unit_torque_forces;
        Self {
            scene: grasp.scene.clone(),
            end: FinalPostureReport {
                q11_rad: posture.q11_rad,
                q21_rad: posture.q21_rad,
                q12_rad: posture.q12_rad,
                q22_rad: posture.q22_rad,
                phi_c_rad: grasp.end.phi_c_rad,
                proximal,
                distal,
            },
            drive: drive(&grasp.drive),
            forces: grasp.forces.iter().map(forces).collect(),
            forces_per_n_m: [unit_torque_forces.f21_n, unit_torque_forces.f22_n, unit_torque_forces.pfp_n],
            form_closure: ClosureReport::new(&grasp.closure, &grasp.palm),
            svg: None,
        }
    }
}

fn drive(drive: &Drive) -> DriveReport {
    let spring = drive.spring.map(|spring_at_rest| SpringReport {
        kind: match spring_at_rest.spring.kind {
            SpringKind::Constant { .. } => "constant",
            SpringKind::Torsional { .. } => "torsional",
        },
        placement: placement(spring_at_rest.spring.placement),
        torque_n_m: spring_at_rest.torque_n_m,
        loads_n_m: spring_at_rest.loads_n_m,
    });
    let Drive { motor_n_m, motor_min_n_m, loads_n_m, .. } = *drive;
    DriveReport { motor_n_m, motor_min_n_m, spring, loads_n_m }
}

/// Name of the placement in scene files.
fn placement(placement: Placement) -> &'static str {
    match placement {
        Placement::Phalanges => "q22",
        Placement::DrivenCoupler => "q12",
        Placement::GroundLinks => "q21-q11",
        Placement::CouplerDistal => "q11+q12-(q21+q22)",
    }
}

fn forces(forces: &Forces) -> ForcesReport {
    let Forces { mu_static, equilibrium, birglen } = forces;
    let Equilibrium { f21_n, f22_n, pfp_n } = *equilibrium;
    ForcesReport {
        mu_static: *mu_static,
        f21_n,
        f22_n,
        pfp_n,
        force_positive: equilibrium.is_force_positive(),
        palm_force_positive: equilibrium.is_palm_force_positive(),
        ejection: match equilibrium.ejection() {
            Ejection::None => "none",
            Ejection::Proximal => FingerContact::Proximal.name(),
            Ejection::Distal => FingerContact::Distal.name(),
            Ejection::Both => "both",
        },
        birglen: BirglenReport {
            jacobian_m: birglen.jacobian_m,
            transmission: birglen.transmission,
            transmission_inverse: birglen.transmission_inverse,
            torques_n_m: birglen.torques_n_m,
            forces_n: birglen.forces_n,
            difference_n: [birglen.forces_n[0] - f21_n, birglen.forces_n[1] - f22_n],
        },
    }
}
