//! Pictures as SVG text; equal figures give equal bytes.
//!
//! | file | job |
//! |---|---|
//! | `svg` | SVG elements, paths and texts |
//! | `theme` | colours for light and dark backgrounds, their CSS variables, and colour scales |
//! | `canvas` | titles, markers, legends, texts |
//! | `chart` | axes; charts and stacked panels of curves and markers with their legend |
//! | `outline` | bodies as filled outlines, and arrows |
//! | `grasp` | a grasp at rest: fingers, forces, a free motion; accelerations that it withstands in all directions |
//! | `sizing` | the test trajectory of a sizing, its springs and torques |

pub mod canvas;
pub mod chart;
mod grasp;
pub mod outline;
mod sizing;
pub mod svg;
pub mod theme;

pub use canvas::PictureFormat;
pub use grasp::{balance, grasp, mechanism_balance};
pub use sizing::sizing;
pub use svg::PICTURE_MARK;
