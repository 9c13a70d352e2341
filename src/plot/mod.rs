//! Pictures of a validation and of studies, as SVG text: the same figures give the same bytes.
//!
//! | file | job |
//! |---|---|
//! | `axis` | ranges and ticks, linear and logarithmic |
//! | `balance` | accelerations that a gripper's grasp bears, around all directions |
//! | `canvas` | fonts, colours, frames, legends beside the frames |
//! | `capture` | where an object ends, over where it lay |
//! | `closings` | angles of closings over time |
//! | `dark` | the same colours for a dark ground |
//! | `curve` | lines of as many points as a picture can show |
//! | `sizing` | the test trajectory of a sizing, its springs and torques |
//! | `speed_error` | wall time against error, every setting that was tried |
//! | `optimize` | designs by their objectives, and the front |
//! | `overlay`, `overlay_gripper`, `overlay_panel` | two runs over time |
//! | `select` | what a selection left, and where |
//! | `stability` | map of verdicts over step, stiffness and damping |
//! | `step_size` | error of a contact force against the step size |
//! | `grasp` | a grasp at rest: fingers, forces, the motion that is free |
//! | `outline` | bodies as filled outlines |
//! | `hold` | what a gripper holds: by direction, by frequency, or slip over load |
//! | `linkage` | the letters of scenes and results on the finger itself |
//! | `volume` | slices of grasp-state volumes |
//! | `colours` | colour scales of a quantity |
//! | `difference` | difference of two runs over time |

mod axis;
mod balance;
mod canvas;
mod capture;
mod closings;
pub mod colours;
mod curve;
mod dark;
mod difference;
mod grasp;
mod hold;
mod linkage;
mod optimize;
mod outline;
mod overlay;
mod overlay_gripper;
mod overlay_panel;
mod select;
mod sizing;
mod speed_error;
mod stability;
mod step_size;
mod volume;

pub use balance::balance;
pub use canvas::{DrawError, PICTURE_MARK};
pub use capture::capture;
pub use closings::closings;
pub use difference::{Apart, Differences, Touches, difference, difference_of, paths_apart, touches};
pub use grasp::grasp;
pub use hold::hold;
pub use linkage::{Linkage, Spot, linkage};
pub use optimize::{Designs, optimisation};
pub use overlay::{overlay, overlay_of};
pub use select::{selection_classes, selection_criteria, selection_forces, selection_static, selection_variables};
pub use sizing::{sizing_spring_types, sizing_springs, sizing_trajectory};
pub use speed_error::speed_error;
pub use stability::stability;
pub use step_size::step_size;
pub use volume::{intersection_slices, volume_slices};
