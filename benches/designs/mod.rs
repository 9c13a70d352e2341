//! A thousand random designs: whether the presets are right on all of them.
//!
//! | file | job |
//! |---|---|
//! | `sample` | random designs |
//! | `sweep` | presets against references |

pub mod sample;
pub mod sweep;
