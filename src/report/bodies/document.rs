//! The figures of a run of discs: the finger's document with discs for joints and a contact for every pair.

use std::collections::BTreeMap;

use serde::Serialize;

use super::super::check::RunCheckReport;
use super::super::document::{Energies, EngineUsed, Failure, IntegratorUsed, WorkReport};
use crate::criteria::Rebound;
use crate::scene::{BodiesScene, DiscMotion};
use crate::trace::bodies::{BodiesOutcome, DiscState};
use crate::trace::{ContactSample, Model, SiteSummary};

/// One run; see [`RunReport`](crate::report::RunReport) for the keys that both have.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodiesReport {
    pub scene: String,
    /// `bodies`.
    pub kind: &'static str,
    pub model: &'static str,
    pub duration_s: f64,
    pub steps: Option<u64>,
    pub wall_s: f64,
    /// Discs by their names, as they are at the end.
    pub discs: Option<BTreeMap<String, DiscReport>>,
    /// Pairs by their names, such as `hammer-anvil` or `hammer-plane`.
    pub contacts: Option<BTreeMap<String, PairReport>>,
    pub completed: bool,
    pub end_s: Option<f64>,
    pub error: Option<Failure>,
    pub energy: Option<Energies>,
    pub work: Option<WorkReport>,
    pub integrator: Option<IntegratorUsed>,
    pub engine: Option<EngineUsed>,
    pub log: Option<String>,
    pub page: Option<String>,
    /// Null if the run was not checked.
    pub check: Option<RunCheckReport>,
}

/// A disc at the end of the run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DiscReport {
    /// `free`, `driven` or `fixed`.
    pub motion: &'static str,
    pub x_m: f64,
    pub y_m: f64,
    pub angle_rad: f64,
    pub vx_m_s: f64,
    pub vy_m_s: f64,
    pub spin_rad_s: f64,
}

/// A pair of surfaces: the keys of a finger's contact, and its first impact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PairReport {
    pub first_s: Option<f64>,
    pub touchdowns: u32,
    /// Forces on the first disc of the pair's name, along the normal from its partner to it and the tangent to the left.
    pub final_normal_n: f64,
    pub final_tangential_n: f64,
    pub peak_normal_n: f64,
    pub max_penetration_m: f64,
    pub impulse_n_s: f64,
    /// Of the first impact: closing speed at the touch-down, parting speed at the lift-off, and their ratio; null where
    /// there was none.
    pub approach_m_s: Option<f64>,
    pub separation_m_s: Option<f64>,
    pub restitution: Option<f64>,
}

impl BodiesReport {
    /// A run with what is known of it: all of it, or up to where it broke off.
    pub fn new(
        scene: &BodiesScene,
        model: Model,
        wall_s: f64,
        outcome: Option<&BodiesOutcome>,
        rebounds: &[Rebound],
        error: Option<Failure>,
    ) -> Self {
        let engine = model == Model::Engine;
        BodiesReport {
            scene: scene.name.clone(),
            kind: "bodies",
            model: model.name(),
            duration_s: scene.duration_s,
            steps: outcome.map(|outcome| outcome.work.steps),
            wall_s,
            discs: outcome.map(|outcome| discs(scene, outcome)),
            contacts: outcome.map(|outcome| contacts(scene, outcome, rebounds)),
            completed: error.is_none(),
            end_s: outcome.map(|outcome| outcome.last.time_s),
            error,
            energy: outcome.map(|outcome| Energies::from(&outcome.last.energy)),
            work: outcome.map(|outcome| WorkReport::from(&outcome.work)),
            integrator: (!engine).then(|| IntegratorUsed::from(&scene.integrator)),
            engine: engine.then(|| EngineUsed::from(&scene.engine)),
            log: None,
            page: None,
            check: None,
        }
    }
}

/// Discs by name.
pub(in crate::report) fn discs(scene: &BodiesScene, outcome: &BodiesOutcome) -> BTreeMap<String, DiscReport> {
    let names: Vec<String> = scene.discs.iter().map(|disc| disc.name.clone()).collect();
    discs_of(&names, Some(scene), &outcome.last.discs)
}

/// Discs that have these names, in order; how they move is `unknown` without a scene that has them.
pub(in crate::report) fn discs_of(
    names: &[String],
    scene: Option<&BodiesScene>,
    states: &[DiscState],
) -> BTreeMap<String, DiscReport> {
    let motion = |name: &str| match scene?.discs.iter().find(|disc| disc.name == name)?.motion {
        DiscMotion::Fixed => Some("fixed"),
        DiscMotion::Driven { .. } => Some("driven"),
        DiscMotion::Free { .. } => Some("free"),
    };
    let report = |motion, state: &DiscState| DiscReport {
        motion,
        x_m: state.centre_m[0],
        y_m: state.centre_m[1],
        angle_rad: state.angle_rad,
        vx_m_s: state.velocity_m_s[0],
        vy_m_s: state.velocity_m_s[1],
        spin_rad_s: state.spin_rad_s,
    };
    let discs = names.iter().zip(states);
    discs.map(|(name, state)| (name.clone(), report(motion(name).unwrap_or("unknown"), state))).collect()
}

/// Pairs by name; without rebounds these are left out.
pub(in crate::report) fn contacts(
    scene: &BodiesScene,
    outcome: &BodiesOutcome,
    rebounds: &[Rebound],
) -> BTreeMap<String, PairReport> {
    let names: Vec<String> = scene.pairs().into_iter().map(|pair| scene.pair_name(pair)).collect();
    contacts_of(&names, outcome, rebounds)
}

/// Pairs that have these names, in order.
pub(in crate::report) fn contacts_of(
    names: &[String],
    outcome: &BodiesOutcome,
    rebounds: &[Rebound],
) -> BTreeMap<String, PairReport> {
    let pairs = names.iter().zip(&outcome.pairs).zip(&outcome.last.contacts).enumerate();
    pairs
        .map(|(index, ((name, summary), last))| {
            let rebound = rebounds.get(index).copied().unwrap_or_default();
            (name.clone(), PairReport::new(summary, last, &rebound))
        })
        .collect()
}

impl PairReport {
    fn new(summary: &SiteSummary, last: &ContactSample, rebound: &Rebound) -> Self {
        PairReport {
            first_s: summary.first_s,
            touchdowns: summary.touchdowns,
            final_normal_n: last.normal_n,
            final_tangential_n: last.tangential_n,
            peak_normal_n: summary.peak_normal_n,
            max_penetration_m: summary.max_penetration_m,
            impulse_n_s: summary.impulse_n_s,
            approach_m_s: rebound.approach_m_s,
            separation_m_s: rebound.separation_m_s,
            restitution: rebound.restitution(),
        }
    }
}
