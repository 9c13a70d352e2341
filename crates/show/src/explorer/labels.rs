//! Labels for the keys of figures, and their values in common units.

use crate::format::format_duration;
use crate::format::numbers::{format_number, zero_below_resolution};
use crate::units::Dimension;

/// Suffixes of keys and their units; a suffix that ends with another one comes before it.
const UNITS: [(&str, &str); 13] = [
    ("_n_m_s", "N·m·s"),
    ("_rad_s", "rad/s"),
    ("_m_s", "m/s"),
    ("_n_m", "N·m"),
    ("_n_s", "N·s"),
    ("_m_s2", "m/s²"),
    ("_percent", "%"),
    ("_rad", "rad"),
    ("_hz", "Hz"),
    ("_s", "s"),
    ("_n", "N"),
    ("_m", "m"),
    ("_j", "J"),
];
/// Labels of some figures.
const NAMES: [(&str, &str); 17] = [
    ("tts", "time to stability"),
    ("t_geo", "in position"),
    ("lost", "lost to rebounds"),
    ("first", "first contact"),
    ("touchdowns", "touch-downs"),
    ("final_normal", "end force"),
    ("final_tangential", "end friction"),
    ("final_torque", "end torque"),
    ("peak_normal", "peak force"),
    ("peak_torque", "peak torque"),
    ("max_penetration", "deepest"),
    ("statically_stable", "statically stable"),
    ("end", "end of the run"),
    ("motor_work", "motor work"),
    ("grasped", "grasped"),
    ("force_closure", "force closure"),
    ("form_closed", "form-closed"),
];
/// SI prefixes, largest first.
const PREFIXES: [(f64, &str); 5] = [(1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n")];
/// Units with SI prefixes.
const PREFIXED: [&str; 6] = ["N", "m", "J", "N·m", "N·s", "N·m·s"];
/// Significant digits of a figure.
const DIGITS: usize = 4;

/// Returns the unit that the suffix of a key stands for; empty for a key without a unit.
pub fn unit(key: &str) -> &'static str {
    UNITS.iter().find(|(ending, _)| key.ends_with(ending)).map_or("", |(_, unit)| unit)
}

/// Label of a key: `contacts.distal.peak_normal_n` becomes `distal: peak force`.
pub fn label(key: &str) -> String {
    let ending = UNITS.iter().find(|(ending, _)| key.ends_with(ending)).map_or("", |(ending, _)| ending);
    let stem = key.strip_suffix(ending).unwrap_or(key);
    let parts: Vec<String> = stem
        .split('.')
        .filter(|part| !["contacts", "criteria", "grasp", "fingers"].contains(part))
        .map(|part| {
            NAMES.iter().find(|(name, _)| *name == part).map_or(part.replace('_', " "), |(_, label)| label.to_string())
        })
        .collect();
    match parts.split_last() {
        Some((last, before)) if !before.is_empty() => format!("{}: {last}", before.join(" ")),
        _ => parts.concat(),
    }
}

/// Formats a value with its unit.
pub fn format_value(key: &str, value: f64) -> String {
    let dimension =
        Dimension::ALL.into_iter().find(|candidate| candidate.units()[0].name.replace('*', "·") == unit(key));
    let value = dimension.map_or(value, |dimension| zero_below_resolution(value, dimension));
    match unit(key) {
        "" if value.fract() == 0.0 && value.abs() < 1e6 => format!("{value:.0}"),
        "" => format_number(value, DIGITS),
        "s" if value >= 0.0 => format_duration(value),
        "rad" => format!("{}°", format_number(value.to_degrees(), DIGITS)),
        unit if PREFIXED.contains(&unit) => {
            let size = value.abs();
            let fits = PREFIXES.iter().find(|(factor, _)| size >= *factor);
            let (factor, prefix) = fits.copied().unwrap_or(if size == 0.0 { (1.0, "") } else { (1e-9, "n") });
            format!("{} {prefix}{unit}", format_number(value / factor, DIGITS))
        }
        unit => format!("{} {unit}", format_number(value, DIGITS)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_keys_and_formats_values_with_units() {
        for (key, value, expected_label, expected_text) in [
            ("contacts.distal.peak_normal_n", 170_075.2, "distal: peak force", "170.1 kN"),
            ("criteria.tts_s", 0.006_883_746, "time to stability", "6.88375 ms"),
            ("contacts.limit.impulse_n_m_s", 0.000_244_1, "limit: impulse", "244.1 µN·m·s"),
            ("criteria.rebound_percent", 1.234_56, "rebound", "1.235 %"),
            ("final.q11_rad", 0.017_453_292_519_943_295, "final: q11", "1.000°"),
            ("energy.balance_j", 0.0, "energy: balance", "0 J"),
            ("contacts.palm.final_tangential_n", 8.2036e-11, "palm: end friction", "0 N"),
            ("contacts.distal.touchdowns", 2.0, "distal: touch-downs", "2"),
        ] {
            assert_eq!(
                (label(key).as_str(), format_value(key, value).as_str()),
                (expected_label, expected_text),
                "{key}"
            );
        }
    }
}
