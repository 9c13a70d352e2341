//! Documentation that is longer than a docstring.

/// Declares an empty module for each page, whose documentation is the page.
macro_rules! pages {
    ($($name:ident),* $(,)?) => {
        $(#[doc = include_str!(concat!(stringify!($name), ".md"))] pub mod $name {})*
    };
}

pages! {
    accuracy, clusters, costs, design, design_work, engine, equations, errata, explorer, glossary, grippers, hard,
    integration, laws, limits, python, robustness, scene_files, scenes, stability, studies, verdicts,
}
