//! Optimisation of designs over ranges of scene fields by simulation.
//!
//! A file defines the base scene, the variables with their bounds, the conditions under which each design runs, and
//! objectives and constraints on the result columns of a sweep. NSGA-II finds the front of several objectives, CMA-ES
//! the optimum of one. Every design has one sweep row per condition. Invalid scenes, failed simulations and designs
//! filtered by their statics count as constraint violations.
//!
//! A search depends only on its file and seed: it receives the scores of a generation in the order of its designs,
//! regardless of the order in which the runs end. An interrupted search therefore resumes from the stored rows without
//! a difference.
//!
//! | file | job |
//! |---|---|
//! | `raw`, `read`, `read_goals` | reading and checking of a file and its scene |
//! | `problem` | optimisation problem |
//! | `evaluate` | evaluation of a design from its runs |
//! | `score` | ranking of designs, fronts |
//! | `nsga2`, `cmaes`, `search` | search algorithms |
//! | `run` | simulation of all generations |
//! | `result` | designs, front and result table |

mod cmaes;
mod evaluate;
mod nsga2;
mod problem;
mod raw;
mod read;
mod read_goals;
mod result;
mod run;
mod score;
mod search;

pub use evaluate::DesignEvaluation;
pub use problem::{
    Algorithm, ColumnAggregation, ConditionAggregation, Constraint, Figure, Goal, Limit, Method, Objective,
    Optimisation, Variable,
};
pub use raw::schema;
pub use read::{load, parse};
pub use result::{Design, OptimisationResult, gain, is_front, table};
pub use run::{DesignMismatch, Listener, OptimisationRun, run};
pub use score::Score;
pub use search::Search;
