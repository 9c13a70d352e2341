//! What commands report: documents of plain figures, and how they are said to people.
//!
//! A run and a grasp are reported by the crate that shows them; here is what studies and logs come to besides.

pub mod capture;
pub mod hold;
mod hold_text;
pub mod optimize;
pub mod replay;
pub mod reproduce;
pub mod select;
pub mod simulated;
pub mod sizing;
pub mod stability;
pub mod step_size;
pub mod sweep;
pub mod validation;
pub mod volume;
pub mod volume_points;

pub use phalanx_show::report::*;
