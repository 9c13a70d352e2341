//! Pictures of a validation and of studies, as SVG text: the same figures give the same bytes. What they are drawn with, and the
//! pictures of a grasp at rest, are in the crate that shows runs.
//!
//! | file | job |
//! |---|---|
//! | `capture` | where an object ends, over where it lay |
//! | `closings` | angles of closings over time |
//! | `sizing` | the test trajectory of a sizing, its springs and torques |
//! | `speed_error` | wall time against error, every setting that was tried |
//! | `optimize` | designs by their objectives, and the front |
//! | `overlay` | two runs over time |
//! | `select` | what a selection left, and where |
//! | `stability` | map of verdicts over step, stiffness and damping |
//! | `step_size` | error of a contact force against the step size |
//! | `hold` | what a gripper holds: by direction, by frequency, or slip over load |
//! | `linkage` | the letters of scenes and results on the finger itself |
//! | `volume` | slices of grasp-state volumes |
//! | `difference` | difference of two runs over time |

mod capture;
mod closings;
mod difference;
mod hold;
mod linkage;
mod optimize;
mod overlay;
mod select;
mod sizing;
mod speed_error;
mod stability;
mod step_size;
mod volume;

use phalanx_show::plot::{axis, canvas, curve, outline, svg};

pub use capture::capture;
pub use closings::closings;
pub use difference::{Apart, Differences, Touches, difference, difference_of, paths_apart, touches};
pub use hold::hold;
pub use linkage::{Linkage, Spot, linkage};
pub use optimize::optimisation;
pub use overlay::{overlay, overlay_of};
pub use phalanx_show::plot::{Form, PICTURE_MARK, balance, colours, grasp, theme};
pub use select::{selection_classes, selection_criteria, selection_forces, selection_static, selection_variables};
pub use sizing::{sizing_spring_types, sizing_springs, sizing_trajectory};
pub use speed_error::speed_error;
pub use stability::stability;
pub use step_size::step_size;
pub use volume::{intersection_slices, volume_slices};
