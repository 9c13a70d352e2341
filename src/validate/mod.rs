//! Accuracy and cost of the engine model, measured against the analytic model.
//!
//! The *reference* is the analytic model at [`Preset::Reference`](crate::scene::Preset). [`validate`] compares the
//! engine at the scene's own settings with the reference and judges it by the scene's bounds. On request,
//! [`run_ladder`] compares and times a ladder of other solver configurations of both models without judging them.
//!
//! **Ensemble.** The position of an integrator's steps relative to an impact is arbitrary, so a single run may be
//! accurate by chance. The error of a configuration is therefore the worst over `ENSEMBLE_SIZE` runs (grippers:
//! `GRIPPER_ENSEMBLE_SIZE`) whose motor torques differ by parts in 1e9. Each run has its own reference.
//! Configurations that take long are run once; the report states the number of runs.
//!
//! **Criteria.** The criteria of both runs are compared as well: class, fate, time to stability, lost contacts, form
//! closure, restitution ([`Criterion`]).
//!
//! **Compared quantities.** Joint angles and rates at every step of the engine, with the reference
//! interpolated between its dense samples; forces at the end of the run; times of first contact; the normal impulse of
//! every impact up to its lift-off, or in the first [`IMPACT_S`] of a lasting contact, where each model counts from its
//! own touch-down; the opening of the engine's joints; spurious energy.
//!
//! For mechanisms: positions of the bodies, times of first contact, impulse and peak force of every contact; without
//! joints up to `until`. The members of the ensemble differ in the actuation, springs, speeds and gravity.

mod configuration;
mod difference;
mod ladder;
mod recording;
mod scenes;
mod statistics;
mod validation;
mod verdict;

pub use configuration::{
    Cost, Family, LadderRow, SolverConfiguration, Status, ladder_configurations, reference_configuration,
};
pub(crate) use configuration::{configuration_name, finer_configurations, scene_configuration};
pub(crate) use difference::coordinate_errors;
pub use difference::{Angle, Comparison, CoordinateError, Differences, compare, largest};
pub use ladder::{LADDER_TIME_S, LadderOptions, run_ladder};
pub(crate) use recording::record_cancellable;
pub use recording::{IMPACT_S, Impact, Impacts, Recording, record};
pub(crate) use scenes::{MEMBER_PERTURBATION, ensemble_member, ensemble_size, path_bound};
pub use scenes::{
    check_invariants, check_sample_count, compared_scene, reference_scene, sampled_scene, scene_sampled_at_steps,
};
pub use statistics::{MAX_STANDARD_ERRORS, Statistic, Statistics, compare_statistics};
pub use validation::{FinerConfiguration, Validation, ValidationError, validate};
pub(crate) use verdict::CRITERIA;
pub use verdict::{
    Check, Criterion, Value, Verdict, check_bounds, compare_criteria, criteria_checks, reason_not_judged,
};
