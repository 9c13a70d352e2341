//! Cells of tables, and figures of a chosen number of digits.

/// Cells of a row.
pub fn row<const N: usize>(cells: [&str; N]) -> Vec<String> {
    cells.map(String::from).to_vec()
}

/// A number with so many significant digits: plain from 1e-3 to 1e6, with an exponent beyond.
pub fn figure(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".to_string();
    }
    if !value.is_finite() {
        return "–".to_string();
    }
    let decimals = digits.saturating_sub(1);
    // Through the rounded form: 9.9996 with four digits has two digits before the point.
    let scientific = format!("{value:.decimals$e}");
    let exponent: i32 = scientific.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0);
    if !(-3..6).contains(&exponent) {
        return scientific;
    }
    let places = usize::try_from(decimals as i32 - exponent).unwrap_or(0);
    format!("{value:.places$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_keep_their_digits() {
        for (value, expected) in [
            (0.0, "0"),
            (23.60921, "23.609"),
            (9.99996, "10.000"),
            (-0.0012345678, "-0.0012346"),
            (98765.4321, "98765"),
            (1.5e-9, "1.5000e-9"),
            (f64::INFINITY, "–"),
        ] {
            assert_eq!(figure(value, 5), expected);
        }
    }
}
