//! The best designs over ranges of fields, simulated (what a grid of a sweep can only come near).
//!
//! A file names the base scene, the variables with their bounds, the conditions under which each design runs, objectives and
//! constraints on the columns of a sweep's results. NSGA-II finds the front of several objectives, CMA-ES the best of one. Every design
//! is a row of a sweep for each condition: a scene that is not valid, a simulation that does not end, and a design that is filtered
//! for its statics are designs that violate constraints, and are counted.
//!
//! A search is a function of its file and seed: it is asked for a generation and told of it in the order of its designs, whatever the
//! order in which they were found. So one that was ended goes on from the rows that are there, the same way.
//!
//! | file | job |
//! |---|---|
//! | `raw`, `read`, `read_goals` | a file and its scene, checked |
//! | `problem` | what is optimised |
//! | `judge` | what the runs of a design say of it |
//! | `score` | which of two designs is better, fronts |
//! | `nsga2`, `cmaes`, `search` | the searches |
//! | `run` | generation after generation |
//! | `found` | the designs, the front, the table of both |

mod cmaes;
mod found;
mod judge;
mod nsga2;
mod problem;
mod raw;
mod read;
mod read_goals;
mod run;
mod score;
mod search;

pub use found::{Design, Found, gain, is_front, table};
pub use judge::Judged;
pub use problem::{Algorithm, Constraint, Figure, Goal, Limit, Method, Objective, Of, Optimisation, Over, Variable};
pub use raw::schema;
pub use read::{load, parse};
pub use run::{Listener, Optimised, OtherDesign, run};
pub use score::Score;
pub use search::Search;
