//! Documentation that is longer than a docstring, behind three doors.
//!
//! * **Learn.** The tutorial: `book/pages/index.md`, and its chapters for users of MuJoCo, ADAMS and Simscape.
//! * **Look up.** [Scene files](scene_files), [shipped scenes](scenes), [Python](python), [studies], [clusters], the
//!   [explorer], [grippers], the [design work](design_work) and its [criteria](design), the [costs] of settings,
//!   [limits] and the [glossary]. `phalanx help` and `phalanx man` describe the commands.
//! * **Trust.** [Accuracy](accuracy), [verdicts], [hard cases](hard), contact [laws], [integration], the [engine] and
//!   its [stability], [robustness], [equations] and [errata].
//!
//! Each fact stands on one page; other pages link to it.

/// Declares an empty module for each page, whose documentation is the page.
macro_rules! pages {
    ($($name:ident),* $(,)?) => {
        $(#[doc = include_str!(concat!(stringify!($name), ".md"))] pub mod $name {})*
    };
}

// Pages to look up.
pages! {
    clusters, costs, design, design_work, explorer, glossary, grippers, limits, python, scene_files, scenes, studies,
}

// Pages on which trust in the results rests.
pages! {
    accuracy, engine, equations, errata, hard, integration, laws, robustness, stability, verdicts,
}
