//! Figures of a comparison as text.

use crate::wording::figures::figure;

/// A figure where there is one.
pub(super) fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("–".to_string(), |value| figure(value, digits))
}

/// A ratio in percent.
pub(super) fn percent(value: Option<f64>) -> String {
    number(value.map(|value| 100.0 * value), 2)
}
