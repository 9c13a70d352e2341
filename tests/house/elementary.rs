//! What is computed has the same digits on every platform: nothing of the C library in rooms whose numbers are compared. In the core clippy
//! sees to that, of itself.

use super::independence::{code, sources_of};

/// Methods of `f64` that are the C library's, or not said to be the same everywhere.
const OTHERS: [&str; 22] = [
    "sin", "cos", "sin_cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "exp2", "ln",
    "log2", "log10", "powf", "powi", "hypot", "cbrt", "ln_1p", "exp_m1",
];

/// Those of them that a source calls, beside its tests.
fn called(text: &str) -> Vec<&'static str> {
    let text = text.split("#[cfg(test)]").next().unwrap_or_default();
    let is = |name: &&str| text.contains(&format!(".{name}(")) || text.contains(&format!("f64::{name}"));
    OTHERS.into_iter().filter(is).collect()
}

#[test]
fn logs_and_studies_take_the_functions_of_the_core() {
    for path in sources_of("crates/log", "src").into_iter().chain(sources_of("src", "study")) {
        let found = called(&code(&path));
        assert!(found.is_empty(), "{}: {found:?}, which phalanx::numeric::elementary has", path.display());
    }
}

#[test]
fn others_would_be_seen() {
    assert_eq!(called("let a = x.sin();\nlet b = f64::ln(x);\n"), ["sin", "ln"]);
    assert_eq!(called("sin(x) + scene.log().rate\n#[cfg(test)]\nx.cos()"), [""; 0]);
}
