//! Pictures as SVG text; equal figures give equal bytes.
//!
//! | file | job |
//! |---|---|
//! | `svg` | SVG elements, paths and texts |
//! | `theme` | colours for light and dark backgrounds, and their CSS variables |
//! | `axis` | ranges and ticks, linear and logarithmic |
//! | `canvas` | titles, frames, markers, legends |
//! | `colours` | colour scales |
//! | `outline` | bodies as filled outlines, and arrows |
//! | `balance` | accelerations that a gripper's grasp withstands in all directions |
//! | `grasp` | a grasp at rest: fingers, forces, a free motion |
//! | `series` | charts and stacked panels of curves and markers with their legend |
//! | `sizing` | the test trajectory of a sizing, its springs and torques |

pub mod axis;
mod balance;
pub mod canvas;
pub mod colours;
mod grasp;
pub mod outline;
pub mod series;
mod sizing;
pub mod svg;
pub mod theme;

pub use balance::balance;
pub use canvas::PictureFormat;
pub use grasp::grasp;
pub use sizing::{sizing_spring_types, sizing_springs, sizing_trajectory};
pub use svg::PICTURE_MARK;
