//! Accuracy and cost of the engine model, measured against the analytic model.
//!
//! The *reference* is the analytic model at [`Preset::Reference`](crate::scene::Preset). [`validate`] compares the
//! engine at the scene's own settings with the reference and judges it by the scene's bounds. On request,
//! [`run_ladder`] compares and times a ladder of other solver configurations of both models without judging them.
//!
//! **Ensemble.** The position of an integrator's steps relative to an impact is arbitrary, so a single run may be
//! accurate by chance. The error of a configuration is therefore the worst over [`ENSEMBLE_SIZE`] runs (grippers:
//! [`GRIPPER_ENSEMBLE_SIZE`]) whose motor torques differ by parts in 1e9. Each run has its own reference.
//! Configurations that take long are run once; the report states the number of runs.
//!
//! **Criteria.** The criteria of both runs are compared as well: class, fate, time to stability, lost contacts, form
//! closure, restitution ([`Criterion`]).
//!
//! **Compared quantities.** Joint angles (modulo a full turn) and rates at every step of the engine, with the reference
//! interpolated between its dense samples; forces at the end of the run; times of first contact; the normal impulse of
//! every impact up to its lift-off, or in the first [`IMPACT_S`] of a lasting contact, where each model counts from its
//! own touch-down; the opening of the engine's joints; spurious energy.
//!
//! For scenes of discs: positions of the discs, times of first contact, impulse and peak force of every pair, up to
//! `until`. The members of the ensemble differ in speeds and gravity.
//!
//! | file | content |
//! |---|---|
//! | `scenes` | variants of a scene that a validation runs, and its bounds |
//! | `recording` | a sink that stores a whole run, on a grid dense enough for interpolation |
//! | `ensemble` | the members of the ensemble: the scene with slightly changed motor torque, or speeds and gravity |
//! | `statistics` | means over many runs, for trajectories that are too sensitive to be compared |
//! | `impacts` | normal impulse of every impact, measured during a run |
//! | `running_difference` | maximum, RMS and final value of a difference over a run |
//! | `difference` | all differences between a run and its reference |
//! | `memory` | limit on the number of stored samples |
//! | `criteria` | comparison of the criteria of both runs |
//! | `ladder` | the solver configurations of the ladder |
//! | `cost` | wall time of a configuration, next to that of the analytic model at its engineering preset |
//! | `validation` | the validation of a scene: verdict and ladder |
//! | `verdict` | measured differences against bounds |

mod cost;
mod criteria;
mod difference;
mod ensemble;
mod impacts;
mod ladder;
mod memory;
mod recording;
mod running_difference;
mod scenes;
mod statistics;
mod validation;
mod verdict;

pub use crate::numeric::plane::wrap_angle;
pub use cost::{Cost, measure_cost};
pub use criteria::{
    Criterion, MAX_LOST_CONTACTS_DIFFERENCE, MAX_LOST_TIME_DIFFERENCE, MIN_LOSS_SCALE, Value, compare_criteria,
    criteria_checks, reason_not_judged,
};
pub use difference::{Comparison, CoordinateError, Differences, compare, coordinate_errors, largest};
pub use ensemble::{ENSEMBLE_SIZE, GRIPPER_ENSEMBLE_SIZE, MEMBER_PERTURBATION, ensemble_member, ensemble_size};
pub use impacts::{IMPACT_S, Impact, Impacts};
pub use ladder::{
    Family, MAX_PREDICTED_STEPS, Settings, SolverConfiguration, configuration_name, engine_keys, finer_configurations,
    ladder_configurations, reference_configuration, scene_configuration,
};
pub use memory::check_sample_count;
pub use recording::{Recording, record, record_cancellable};
pub use running_difference::{Angle, Rate, RunningDifference};
pub use scenes::{
    check_invariants, compared_scene, path_bound, reference_scene, sampled_scene, scene_sampled_at_steps,
};
pub use statistics::{
    MAX_STANDARD_ERRORS, MeanAndDeviation, STATISTIC_NAMES, STATISTICS_RUNS, Statistic, Statistics, TORQUE_SPREAD,
    compare_statistics,
};
pub use validation::{
    Evaluation, LADDER_TIME_S, LadderOptions, LadderRow, Progress, SyncKeepRunning, Validation, ValidationError,
    run_ladder, validate,
};
pub use verdict::{Check, Verdict, check_bounds};
