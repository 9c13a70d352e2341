//! Documentation that is longer than a docstring.

#[doc = include_str!("accuracy.md")]
pub mod accuracy {}

#[doc = include_str!("clusters.md")]
pub mod clusters {}

#[doc = include_str!("design.md")]
pub mod design {}

#[doc = include_str!("design_work.md")]
pub mod design_work {}

#[doc = include_str!("engine.md")]
pub mod engine {}

#[doc = include_str!("equations.md")]
pub mod equations {}

#[doc = include_str!("errata.md")]
pub mod errata {}

#[doc = include_str!("explorer.md")]
pub mod explorer {}

#[doc = include_str!("glossary.md")]
pub mod glossary {}

#[doc = include_str!("grippers.md")]
pub mod grippers {}

#[doc = include_str!("hard.md")]
pub mod hard {}

#[doc = include_str!("integration.md")]
pub mod integration {}

#[doc = include_str!("laws.md")]
pub mod laws {}

#[doc = include_str!("limits.md")]
pub mod limits {}

#[doc = include_str!("python.md")]
pub mod python {}

#[doc = include_str!("robustness.md")]
pub mod robustness {}

#[doc = include_str!("scene_files.md")]
pub mod scene_files {}

#[doc = include_str!("scenes.md")]
pub mod scenes {}

#[doc = include_str!("stability.md")]
pub mod stability {}

#[doc = include_str!("verdicts.md")]
pub mod verdicts {}
