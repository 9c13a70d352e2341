//! The figures of a run, in the order and under the keys of the JSON document.
//!
//! Keys carry their SI unit; where there is no value the key is there and null. Keys are added over time, never renamed.

use serde::Serialize;

use super::Tally;
use crate::criteria::Criteria;
use crate::scene::{Integrator, Method, Preset, Scene};
use crate::trace::{ContactSample, Outcome, Sample, Site, SiteSummary, Work};

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunReport {
    /// Name of the scene.
    pub scene: String,
    /// `analytic` or `engine`.
    pub model: String,
    /// Length asked for; `end_s` says how far the run came.
    pub duration_s: f64,
    /// Accepted steps; null if the run was not completed, as `work` is.
    pub steps: Option<u64>,
    /// Wall time of the simulation: the one figure that differs between two runs of the same scene.
    pub wall_s: f64,
    #[serde(rename = "final")]
    pub last: Option<Final>,
    pub contacts: Contacts,
    /// Null without an object, without a grasp of it, or if the run was not completed.
    pub criteria: Option<Dynamics>,
    pub completed: bool,
    pub end_s: f64,
    /// Null if the run was completed.
    pub error: Option<Failure>,
    pub energy: Option<Energies>,
    pub work: Option<WorkReport>,
    pub integrator: IntegratorUsed,
    /// Path of the log as given; null if none was asked for.
    pub log: Option<String>,
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

impl RunReport {
    /// A run that reached its end.
    pub fn completed(scene: &Scene, model: &str, wall_s: f64, outcome: &Outcome, criteria: Option<Criteria>) -> Self {
        RunReport {
            criteria: criteria.map(Dynamics::from),
            completed: true,
            steps: Some(outcome.work.steps),
            work: Some(WorkReport::from(&outcome.work)),
            ..RunReport::up_to(scene, model, wall_s, Some(&outcome.last), &outcome.sites)
        }
    }

    /// A run that broke off: what is known of it up to then.
    pub fn failed(scene: &Scene, model: &str, wall_s: f64, failure: Failure, tally: &Tally) -> Self {
        RunReport {
            error: Some(failure),
            ..RunReport::up_to(scene, model, wall_s, tally.last.as_ref(), &tally.sites)
        }
    }

    fn up_to(scene: &Scene, model: &str, wall_s: f64, last: Option<&Sample>, sites: &[SiteSummary; 3]) -> Self {
        RunReport {
            scene: scene.name.clone(),
            model: model.to_string(),
            duration_s: scene.duration_s,
            steps: None,
            wall_s,
            last: last.map(Final::from),
            contacts: Contacts::new(sites, last),
            criteria: None,
            completed: false,
            end_s: last.map_or(0.0, |sample| sample.time_s),
            error: None,
            energy: last.map(Energies::from),
            work: None,
            integrator: IntegratorUsed::from(&scene.integrator),
            log: None,
        }
    }
}

impl Contacts {
    fn new(sites: &[SiteSummary; 3], last: Option<&Sample>) -> Self {
        let site = |site: Site| &sites[site as usize];
        Contacts {
            proximal: PhalanxReport::new(site(Site::Proximal), last.map(|sample| &sample.proximal)),
            distal: PhalanxReport::new(site(Site::Distal), last.map(|sample| &sample.distal)),
            limit: LimitReport {
                first_s: site(Site::Limit).first_s,
                touchdowns: site(Site::Limit).touchdowns,
                final_torque_n_m: last.map_or(0.0, |sample| sample.limit.torque_n_m),
                peak_torque_n_m: site(Site::Limit).peak_normal_n,
                max_penetration_rad: site(Site::Limit).max_penetration_m,
                impulse_n_m_s: site(Site::Limit).impulse_n_s,
            },
        }
    }
}

impl PhalanxReport {
    fn new(site: &SiteSummary, last: Option<&ContactSample>) -> Self {
        PhalanxReport {
            first_s: site.first_s,
            touchdowns: site.touchdowns,
            final_normal_n: last.map_or(0.0, |contact| contact.normal_n),
            final_tangential_n: last.map_or(0.0, |contact| contact.tangential_n),
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

impl From<&Sample> for Energies {
    fn from(sample: &Sample) -> Self {
        let energy = &sample.energy;
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
        }
    }
}

impl From<&Integrator> for IntegratorUsed {
    fn from(integrator: &Integrator) -> Self {
        IntegratorUsed {
            preset: match integrator.preset {
                Preset::Engineering => "engineering",
                Preset::Reference => "reference",
            },
            method: match integrator.method {
                Method::Rodas5p => "rodas5p",
                Method::RadauIIa5 => "radau_iia5",
            },
            rtol: integrator.rtol,
            atol_angle_rad: integrator.atol_angle_rad,
            atol_rate_rad_s: integrator.atol_rate_rad_s,
            max_steps: integrator.max_steps,
        }
    }
}
