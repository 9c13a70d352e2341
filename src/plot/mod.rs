//! Pictures of validations and studies as SVG text; equal figures give equal bytes. The drawing primitives and the
//! pictures of a grasp at rest are in `phalanx_show::plot`.

mod grippers;
mod linkage;
mod map;
mod runs;
mod selection;

use phalanx_show::plot::{canvas, chart, outline, svg};

pub use grippers::{capture, hold, offsets};
pub use linkage::{LabelBox, Linkage, linkage};
pub use map::map;
pub use phalanx_show::plot::{PICTURE_MARK, PictureFormat, balance, grasp, mechanism_balance, sizing, theme};
pub use runs::{difference, overlay, speed_error};
pub(crate) use runs::{overlay_runs, plot_differences};
pub use selection::selection;
