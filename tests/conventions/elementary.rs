//! Results are identical on every platform, so modules with compared numbers must not call the mathematical functions
//! of the C library. In the core, clippy checks this.

use super::independence::{code_without_comments, source_files};

/// Methods of `f64` that call the C library or have no specified precision.
const LIBM_METHODS: [&str; 22] = [
    "sin", "cos", "sin_cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "exp2", "ln",
    "log2", "log10", "powf", "powi", "hypot", "cbrt", "ln_1p", "exp_m1",
];

/// Returns the methods of this list that a source calls outside its tests.
fn libm_calls(text: &str) -> Vec<&'static str> {
    let text = text.split("#[cfg(test)]").next().unwrap_or_default();
    let is_called = |name: &&str| text.contains(&format!(".{name}(")) || text.contains(&format!("f64::{name}"));
    LIBM_METHODS.into_iter().filter(is_called).collect()
}

#[test]
fn logs_and_studies_use_portable_elementary_functions() {
    for path in source_files("crates/log", "src").into_iter().chain(source_files("src", "study")) {
        let calls = libm_calls(&code_without_comments(&path));
        assert!(calls.is_empty(), "{}: {calls:?}; use phalanx::numeric::elementary instead", path.display());
    }
}

#[test]
fn detects_calls_of_libm() {
    assert_eq!(libm_calls("let a = x.sin();\nlet b = f64::ln(x);\n"), ["sin", "ln"]);
    assert_eq!(libm_calls("sin(x) + scene.log().rate\n#[cfg(test)]\nx.cos()"), [""; 0]);
}
