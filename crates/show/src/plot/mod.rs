//! Pictures as SVG text: the same figures give the same bytes.
//!
//! | file | job |
//! |---|---|
//! | `svg` | elements, paths, texts: an SVG as text |
//! | `theme` | colours, and what stands for them on a dark ground and in a page |
//! | `axis` | ranges and ticks, linear and logarithmic |
//! | `canvas` | titles, frames, marks, legends beside the frames |
//! | `colours` | colour scales of a quantity |
//! | `curve` | lines of as many points as a picture can show |
//! | `outline` | bodies as filled outlines, and arrows |
//! | `balance` | accelerations that a gripper's grasp bears, around all directions |
//! | `grasp` | a grasp at rest: fingers, forces, the motion that is free |

pub mod axis;
mod balance;
pub mod canvas;
pub mod colours;
pub mod curve;
mod grasp;
pub mod outline;
pub mod svg;
pub mod theme;

pub use balance::balance;
pub use canvas::Form;
pub use grasp::grasp;
pub use svg::PICTURE_MARK;
