//! Pictures of a validation and of studies as SVG text; equal figures give equal bytes. The drawing primitives and the
//! pictures of a grasp at rest are in `phalanx_show::plot`.
//!
//! | file | job |
//! |---|---|
//! | `capture` | final position of an object over its initial position |
//! | `closings` | joint angles over time in several closing motions |
//! | `sizing` | the test trajectory of a sizing, its springs and torques |
//! | `speed_error` | wall time against error of all evaluated settings |
//! | `overlay` | two runs over time |
//! | `select` | results of a selection by criterion, class, force and variable |
//! | `stability` | map of verdicts over step, stiffness and damping |
//! | `step_size` | error of a contact force against the step size |
//! | `hold` | loads that a gripper holds: by direction, by frequency, or slip over load |
//! | `linkage` | drawing of a finger with the symbols of scenes and results |
//! | `volume` | slices of grasp-state volumes |
//! | `difference` | difference of two runs over time |

mod capture;
mod closings;
mod difference;
mod hold;
mod linkage;
mod overlay;
mod select;
mod sizing;
mod speed_error;
mod stability;
mod step_size;
mod volume;

use phalanx_show::plot::{axis, canvas, curve, outline, series, svg};

pub use capture::capture;
pub use closings::closings;
pub use difference::{
    DifferenceCurve, DifferencePlot, TouchdownTimes, difference, path_differences, plot_differences, touchdowns,
};
pub use hold::hold;
pub use linkage::{LabelBox, Linkage, linkage};
pub use overlay::{overlay, overlay_runs};
pub use phalanx_show::plot::{PICTURE_MARK, PictureFormat, balance, colours, grasp, theme};
pub use select::{selection_classes, selection_criteria, selection_forces, selection_static, selection_variables};
pub use sizing::{sizing_spring_types, sizing_springs, sizing_trajectory};
pub use speed_error::speed_error;
pub use stability::stability;
pub use step_size::step_size;
pub use volume::{intersection_slices, volume_slices};
