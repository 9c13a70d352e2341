//! Pictures as SVG text: the same figures give the same bytes.
//!
//! | file | job |
//! |---|---|
//! | `axis` | ranges and ticks, linear and logarithmic |
//! | `canvas` | fonts, colours, frames, legends beside the frames |
//! | `colours` | colour scales of a quantity |
//! | `curve` | lines of as many points as a picture can show |
//! | `dark` | the same colours for a dark ground |
//! | `outline` | bodies as filled outlines |
//! | `balance` | accelerations that a gripper's grasp bears, around all directions |
//! | `grasp` | a grasp at rest: fingers, forces, the motion that is free |

pub mod axis;
mod balance;
pub mod canvas;
pub mod colours;
pub mod curve;
mod dark;
mod grasp;
mod outline;

pub use balance::balance;
pub use canvas::{DrawError, PICTURE_MARK};
pub use grasp::grasp;
