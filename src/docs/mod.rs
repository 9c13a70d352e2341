//! Documentation that is longer than a docstring.

#[doc = include_str!("design.md")]
pub mod design {}

#[doc = include_str!("engine.md")]
pub mod engine {}

#[doc = include_str!("errata.md")]
pub mod errata {}

#[doc = include_str!("hard.md")]
pub mod hard {}

#[doc = include_str!("integration.md")]
pub mod integration {}

#[doc = include_str!("laws.md")]
pub mod laws {}

#[doc = include_str!("limits.md")]
pub mod limits {}

#[doc = include_str!("robustness.md")]
pub mod robustness {}

#[doc = include_str!("stability.md")]
pub mod stability {}
