//! Pictures of a validation and of studies as SVG text; equal figures give equal bytes. The drawing primitives and the
//! pictures of a grasp at rest are in `phalanx_show::plot`.
//!
//! | file | job |
//! |---|---|
//! | `capture` | final position of an object over its initial position |
//! | `speed_error` | wall time against error of all evaluated settings |
//! | `overlay` | two runs over time |
//! | `select` | results of a selection by criterion, class, force and variable |
//! | `hold` | loads that a gripper holds: by direction, by frequency, or slip over load |
//! | `linkage` | drawing of a finger with the symbols of scenes and results |
//! | `difference` | difference of two runs over time |

mod capture;
mod difference;
mod hold;
mod linkage;
mod overlay;
mod select;
mod speed_error;

use phalanx_show::plot::{axis, canvas, outline, series, svg};

pub use capture::capture;
pub(crate) use difference::{DifferencePlot, path_differences, plot_differences};
pub use difference::{difference, touchdowns};
pub use hold::hold;
pub use linkage::{LabelBox, Linkage, linkage};
pub use overlay::overlay;
pub(crate) use overlay::overlay_runs;
pub use phalanx_show::plot::{
    PICTURE_MARK, PictureFormat, balance, colours, grasp, sizing_spring_types, sizing_springs, sizing_trajectory, theme,
};
pub use select::{selection_classes, selection_criteria, selection_forces, selection_static, selection_variables};
pub use speed_error::speed_error;
