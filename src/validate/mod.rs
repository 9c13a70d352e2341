//! How far the engine model is from the analytic one, and what accuracy costs: speed against error.
//!
//! The *reference* is the analytic model at [`Preset::Reference`](crate::scene::Preset). The engine at the scene's own
//! settings is compared with it and judged by the scene's bounds: [`validate`]. A ladder of other settings of both models
//! is compared and timed, but not judged, where it is wanted: [`climb`].
//!
//! **Ensemble.** Where an integrator's steps fall relative to an impact is luck, and one run may be right by it. The
//! error of a setting is therefore the worst over [`MEMBERS`] runs (grippers: [`GRIPPER_MEMBERS`]) whose motor torque differs by
//! parts in 1e9, each against a reference of its own. Settings that take long are run once, and say so.
//!
//! **Criteria.** The criteria of both runs are compared as well: class, fate, time to stability, lost contacts, form closure,
//! restitution ([`Criterion`]).
//!
//! **What is compared.** Joint angles (a whole turn apart is the same) and rates at every step of the engine, the
//! reference interpolated between its dense samples; forces at the end of the run; times of first touch; the normal
//! impulse of every impact up to its lift-off, or in the first [`IMPACT_S`] of a contact that stays, each model counted
//! from its own touch-down; the opening of the engine's joints; energy that came from nowhere.
//!
//! Of scenes of discs: places of the discs, times of first touch, impulse and peak of every pair, up to `until`; the
//! members of the ensemble differ in speeds and gravity.
//!
//! | file | job |
//! |---|---|
//! | `subject` | what a validation does to a scene: settings, members, bounds |
//! | `recording` | the reference: a sink that keeps a run, on a grid dense enough to interpolate in |
//! | `ensemble` | the members: the same scene with its motor torque, or its speeds and gravity, a little changed |
//! | `statistics` | means over many runs, where trajectories are too sensitive to be compared |
//! | `impacts` | normal impulse of every impact, as a run goes by |
//! | `track` | differences of angles and rates along the way |
//! | `difference` | everything in which a run differs from its reference |
//! | `room` | what fits into memory |
//! | `criteria` | what both runs are judged by, side by side |
//! | `ladder` | the settings that are tried |
//! | `cost` | wall time of a setting, beside that of the everyday analytic run |
//! | `study` | the validation of a scene: verdict, and ladder |
//! | `verdict` | measured against bounds |

mod cost;
mod criteria;
mod difference;
mod ensemble;
mod impacts;
mod ladder;
mod recording;
mod room;
mod statistics;
mod study;
mod subject;
mod track;
mod verdict;

pub use crate::numeric::plane::turned;
pub use cost::{Cost, cost};
pub use criteria::{Criterion, FEW_LOSSES, LOST_SHARE, LOST_TIME_SHARE, Value, checks, criteria, unjudged};
pub use difference::{Comparison, Differences, Off, compare, largest, off};
pub use ensemble::{GRIPPER_MEMBERS, MEMBERS, TORQUE_STEP, member, members};
pub use impacts::{IMPACT_S, Impact, Impacts};
pub use ladder::{Family, LONGEST_STEPS, Rung, Settings, finer_settings, keys, ladder, name, of_reference, own};
pub use recording::{Recording, record, record_while};
pub use room::refuse_too_fine;
pub use statistics::{FIGURES, MOST_ERRORS, RUNS, SPREAD, Spread, Statistic, Statistics, statistics};
pub use study::{Climb, LADDER_TIME_S, Progress, Row, StudyError, Tried, Validation, Wanted, climb, validate};
pub use subject::{compared, invariants, path_bound, reference, sampled, steps_only};
pub use track::{Angle, Rate, Track};
pub use verdict::{Check, Verdict, verdicts};
