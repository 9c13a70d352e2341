//! The figures of a run, in the order and under the keys of the JSON document.
//!
//! Keys carry their SI unit; where there is no value the key is there and null. Keys are added over time, never renamed.

use serde::Serialize;

use super::check::RunCheckReport;
use crate::criteria::Criteria;
use crate::log::{construction_name, law_name, method_name, preset_name, stepping_name};
use crate::scene::{Engine, Integrator, Scene, Stepping};
use crate::trace::{ContactSample, Energy, Outcome, Sample, Site, SiteSummary, Work};

/// One run. All that is known only from the simulation is null if that could not even report how far it came.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunReport {
    /// Name of the scene.
    pub scene: String,
    /// `finger`.
    pub kind: &'static str,
    /// `analytic` or `engine`.
    pub model: String,
    /// Length asked for; `end_s` says how far the run came.
    pub duration_s: f64,
    /// Accepted steps.
    pub steps: Option<u64>,
    /// Wall time of the simulation: the one figure that differs between two runs of the same scene.
    pub wall_s: f64,
    #[serde(rename = "final")]
    pub last: Option<Final>,
    pub contacts: Option<Contacts>,
    /// Null without an object, without a grasp of it, or if the run was not completed.
    pub criteria: Option<Dynamics>,
    pub completed: bool,
    /// Time reached.
    pub end_s: Option<f64>,
    /// Null if the run was completed.
    pub error: Option<Failure>,
    pub energy: Option<Energies>,
    pub work: Option<WorkReport>,
    /// Settings of the analytic model; null for a run of the engine.
    pub integrator: Option<IntegratorUsed>,
    /// Settings of the engine model; null for a run of the analytic one.
    pub engine: Option<EngineUsed>,
    /// Largest opening of a joint of the engine; null for the analytic model, whose loop is closed by construction.
    pub loop_gap_m: Option<f64>,
    /// Path of the log as given; null if none was asked for.
    pub log: Option<String>,
    /// Path of the page; null if none was asked for.
    pub page: Option<String>,
    /// Null if the run was not checked.
    pub check: Option<RunCheckReport>,
}

/// The state at the end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Final {
    pub q11_rad: f64,
    pub q21_rad: f64,
    pub q22_rad: f64,
    pub qd11_rad_s: f64,
    pub qd21_rad_s: f64,
    pub q12_rad: f64,
    pub q13_rad: f64,
}

/// The three places where contact can be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Contacts {
    pub proximal: PhalanxReport,
    pub distal: PhalanxReport,
    pub limit: LimitReport,
}

/// One phalanx against the object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PhalanxReport {
    pub first_s: Option<f64>,
    pub touchdowns: u32,
    pub final_normal_n: f64,
    pub final_tangential_n: f64,
    pub peak_normal_n: f64,
    pub max_penetration_m: f64,
    pub impulse_n_s: f64,
}

/// The joint limit: the same figures for an angle and a torque.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LimitReport {
    pub first_s: Option<f64>,
    pub touchdowns: u32,
    pub final_torque_n_m: f64,
    pub peak_torque_n_m: f64,
    pub max_penetration_rad: f64,
    pub impulse_n_m_s: f64,
}

/// The dynamic criteria, see [`crate::criteria`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Dynamics {
    pub tts_s: Option<f64>,
    pub rebound_percent: Option<f64>,
    pub class: &'static str,
    pub t_geo_s: Option<f64>,
    pub lost_s: f64,
    pub statically_stable: bool,
}

/// Why a run ended early.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failure {
    pub time_s: f64,
    pub reason: String,
}

/// Energies and works at the end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Energies {
    pub kinetic_j: f64,
    pub gravity_j: f64,
    pub spring_j: f64,
    pub elastic_j: f64,
    pub dissipated_j: f64,
    pub motor_work_j: f64,
    pub balance_j: f64,
}

/// What the run cost beside its steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct WorkReport {
    pub rejected_steps: u64,
    pub rhs_evaluations: u64,
    pub jacobian_evaluations: u64,
    pub events: u64,
    /// Sub-steps of the engine's contact solver, and Newton iterations in them; 0 for the analytic model.
    pub contact_substeps: u64,
    pub newton_iterations: u64,
}

/// The integrator settings in force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct IntegratorUsed {
    pub preset: &'static str,
    pub method: &'static str,
    pub rtol: f64,
    pub atol_angle_rad: f64,
    pub atol_rate_rad_s: f64,
    pub max_steps: u64,
}

/// The engine settings in force; null is what the stepping does not have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EngineUsed {
    pub construction: &'static str,
    /// `scene`: the scene's contact laws; `rapier`: rapier's own rigid contact.
    pub law: &'static str,
    pub stepping: &'static str,
    pub step_s: Option<f64>,
    pub tolerance_m: Option<f64>,
    pub max_step_s: Option<f64>,
    pub iterations: u32,
    pub max_steps: u64,
}

impl RunReport {
    /// A run that reached its end.
    pub fn completed(scene: &Scene, model: &str, wall_s: f64, outcome: &Outcome, criteria: Option<Criteria>) -> Self {
        RunReport {
            criteria: criteria.map(Dynamics::from),
            completed: true,
            error: None,
            ..RunReport::up_to(scene, model, wall_s, Some(outcome))
        }
    }

    /// A run that broke off, with what is known of it up to then.
    pub fn failed(scene: &Scene, model: &str, wall_s: f64, failure: Failure, so_far: Option<&Outcome>) -> Self {
        RunReport { error: Some(failure), ..RunReport::up_to(scene, model, wall_s, so_far) }
    }

    fn up_to(scene: &Scene, model: &str, wall_s: f64, outcome: Option<&Outcome>) -> Self {
        let engine = model == "engine";
        RunReport {
            scene: scene.name.clone(),
            kind: "finger",
            model: model.to_string(),
            duration_s: scene.duration_s,
            steps: outcome.map(|outcome| outcome.work.steps),
            wall_s,
            last: outcome.map(|outcome| Final::from(&outcome.last)),
            contacts: outcome.map(Contacts::from),
            criteria: None,
            completed: false,
            end_s: outcome.map(|outcome| outcome.last.time_s),
            error: None,
            energy: outcome.map(|outcome| Energies::from(&outcome.last.energy)),
            work: outcome.map(|outcome| WorkReport::from(&outcome.work)),
            integrator: (!engine).then(|| IntegratorUsed::from(&scene.integrator)),
            engine: engine.then(|| EngineUsed::from(&scene.engine)),
            loop_gap_m: outcome.filter(|_| engine).map(|outcome| outcome.loop_gap_m),
            log: None,
            page: None,
            check: None,
        }
    }
}

impl From<&Outcome> for Contacts {
    fn from(outcome: &Outcome) -> Self {
        let limit = outcome.site(Site::Limit);
        Contacts {
            proximal: PhalanxReport::new(outcome.site(Site::Proximal), &outcome.last.proximal),
            distal: PhalanxReport::new(outcome.site(Site::Distal), &outcome.last.distal),
            limit: LimitReport {
                first_s: limit.first_s,
                touchdowns: limit.touchdowns,
                final_torque_n_m: outcome.last.limit.normal_n,
                peak_torque_n_m: limit.peak_normal_n,
                max_penetration_rad: limit.max_penetration_m,
                impulse_n_m_s: limit.impulse_n_s,
            },
        }
    }
}

impl PhalanxReport {
    fn new(site: &SiteSummary, last: &ContactSample) -> Self {
        PhalanxReport {
            first_s: site.first_s,
            touchdowns: site.touchdowns,
            final_normal_n: last.normal_n,
            final_tangential_n: last.tangential_n,
            peak_normal_n: site.peak_normal_n,
            max_penetration_m: site.max_penetration_m,
            impulse_n_s: site.impulse_n_s,
        }
    }
}

impl From<&Sample> for Final {
    fn from(sample: &Sample) -> Self {
        Final {
            q11_rad: sample.q11_rad,
            q21_rad: sample.q21_rad,
            q22_rad: sample.q22_rad,
            qd11_rad_s: sample.qd11_rad_s,
            qd21_rad_s: sample.qd21_rad_s,
            q12_rad: sample.q12_rad,
            q13_rad: sample.q13_rad,
        }
    }
}

impl From<&Energy> for Energies {
    fn from(energy: &Energy) -> Self {
        Energies {
            kinetic_j: energy.kinetic_j,
            gravity_j: energy.gravity_j,
            spring_j: energy.spring_j,
            elastic_j: energy.elastic_j,
            dissipated_j: energy.dissipated_j,
            motor_work_j: energy.motor_work_j,
            balance_j: energy.balance_j,
        }
    }
}

impl From<Criteria> for Dynamics {
    fn from(criteria: Criteria) -> Self {
        Dynamics {
            tts_s: criteria.tts_s,
            rebound_percent: criteria.rebound_percent,
            class: criteria.class.name(),
            t_geo_s: criteria.t_geo_s,
            lost_s: criteria.lost_s,
            statically_stable: criteria.statically_stable,
        }
    }
}

impl From<&Work> for WorkReport {
    fn from(work: &Work) -> Self {
        WorkReport {
            rejected_steps: work.rejected,
            rhs_evaluations: work.rhs_evaluations,
            jacobian_evaluations: work.jacobian_evaluations,
            events: work.events,
            contact_substeps: work.contact_substeps,
            newton_iterations: work.newton_iterations,
        }
    }
}

impl From<&Integrator> for IntegratorUsed {
    fn from(integrator: &Integrator) -> Self {
        IntegratorUsed {
            preset: preset_name(integrator.preset),
            method: method_name(integrator.method),
            rtol: integrator.rtol,
            atol_angle_rad: integrator.atol_angle_rad,
            atol_rate_rad_s: integrator.atol_rate_rad_s,
            max_steps: integrator.max_steps,
        }
    }
}

impl From<&Engine> for EngineUsed {
    fn from(engine: &Engine) -> Self {
        let (step_s, tolerance_m, max_step_s) = match engine.stepping {
            Stepping::Fixed { step_s } => (Some(step_s), None, None),
            Stepping::Adaptive { tolerance_m, max_step_s } => (None, Some(tolerance_m), Some(max_step_s)),
        };
        EngineUsed {
            construction: construction_name(engine.construction),
            law: law_name(engine.response),
            stepping: stepping_name(engine.stepping),
            step_s,
            tolerance_m,
            max_step_s,
            iterations: engine.iterations,
            max_steps: engine.max_steps,
        }
    }
}
