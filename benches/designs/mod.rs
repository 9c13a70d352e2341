//! Accuracy of the presets on random designs.
//!
//! | file | job |
//! |---|---|
//! | `sample` | generator of random designs |
//! | `sweep` | accuracy and cost of the presets |

pub mod sample;
pub mod sweep;
