//! A thousand random designs: whether the presets are right on all of them.
//!
//! | file | job |
//! |---|---|
//! | `sample` | random designs |
//! | `sizing` | motor and spring sized to the finger |
//! | `sweep` | presets against references |

pub mod sample;
pub mod sizing;
pub mod sweep;
