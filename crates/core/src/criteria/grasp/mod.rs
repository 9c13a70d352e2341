//! Is the object held, and how? Criteria of every scene with an object and a hand, from samples and events alone.
//!
//! | file | job |
//! |---|---|
//! | `object` | the criteria |
//! | `tracker` | the sink: points, pairs and poses in parts of the run in which nothing changes |
//! | `grip` | whether contacts grip the object |
//! | `hold` | intervals in which it is gripped, carried, resting or free |
//! | `pairs` | histories of pairs, and their forces at the end |
//! | `pose` | poses in the frame of the base |
//! | `cycle` | largest travel, motion of the palm, brakes and release |
//! | `recent` | the last part of the run: creep and sliding |
//! | `fate` | the fate, with its reason |
//! | `actuators` | efforts, rates, powers and energies of the actuators |
//! | `firmness` | margin, form closure and Q1 at the end |

mod actuators;
mod cycle;
mod fate;
mod firmness;
mod grip;
mod hold;
mod object;
mod pairs;
mod pose;
mod recent;
mod tracker;

pub use actuators::{ActuatorCriteria, ActuatorTracker};
pub use cycle::{CycleCriteria, Travel};
pub use fate::Fate;
pub(crate) use firmness::contact_at_rest;
pub use firmness::{DIRECTIONS, Failure, Firmness, Margin, balanced_acceleration, firmness};
pub use hold::HoldState;
pub use object::{ObjectCriteria, Slip};
pub use pairs::PairCriteria;
pub use tracker::ObjectTracker;
