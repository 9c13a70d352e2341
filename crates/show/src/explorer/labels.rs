//! Keys of figures in words, and their values with units of everyday size.

use crate::units::Dimension;
use crate::wording::duration;
use crate::wording::figures::{figure, resolved};

/// Endings of keys and the units they stand for; the longest first, where one ends another.
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
/// What some figures are called.
const NAMES: [(&str, &str); 17] = [
    ("tts", "time to stability"),
    ("t_geo", "in position"),
    ("lost", "lost to rebounds"),
    ("first", "first touch"),
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
/// Prefixes of units, largest first.
const PREFIXES: [(f64, &str); 5] = [(1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n")];
/// Units that take them.
const PREFIXED: [&str; 6] = ["N", "m", "J", "N·m", "N·s", "N·m·s"];
/// Digits of a figure.
const DIGITS: usize = 4;

/// The unit that a key ends with; none of a plain number or word.
pub fn unit(key: &str) -> &'static str {
    UNITS.iter().find(|(ending, _)| key.ends_with(ending)).map_or("", |(_, unit)| unit)
}

/// A key in words: `contacts.distal.peak_normal_n` is `distal: peak force`.
pub fn label(key: &str) -> String {
    let ending = UNITS.iter().find(|(ending, _)| key.ends_with(ending)).map_or("", |(ending, _)| ending);
    let bare = key.strip_suffix(ending).unwrap_or(key);
    let parts: Vec<String> = bare
        .split('.')
        .filter(|part| !["contacts", "criteria", "grasp", "fingers"].contains(part))
        .map(|part| {
            NAMES.iter().find(|(name, _)| *name == part).map_or(part.replace('_', " "), |(_, said)| said.to_string())
        })
        .collect();
    match parts.split_last() {
        Some((last, before)) if !before.is_empty() => format!("{}: {last}", before.join(" ")),
        _ => parts.concat(),
    }
}

/// A figure for people.
pub fn text(key: &str, value: f64) -> String {
    let dimension = Dimension::ALL.into_iter().find(|of| of.units()[0].name.replace('*', "·") == unit(key));
    let value = dimension.map_or(value, |of| resolved(value, of));
    match unit(key) {
        "" if value.fract() == 0.0 && value.abs() < 1e6 => format!("{value:.0}"),
        "" => figure(value, DIGITS),
        "s" if value >= 0.0 => duration(value),
        "rad" => format!("{}°", figure(value.to_degrees(), DIGITS)),
        unit if PREFIXED.contains(&unit) => {
            let size = value.abs();
            let fits = PREFIXES.iter().find(|(factor, _)| size >= *factor);
            let (factor, prefix) = fits.copied().unwrap_or(if size == 0.0 { (1.0, "") } else { (1e-9, "n") });
            format!("{} {prefix}{unit}", figure(value / factor, DIGITS))
        }
        unit => format!("{} {unit}", figure(value, DIGITS)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_in_words_and_values_with_their_units() {
        for (key, value, said, shown) in [
            ("contacts.distal.peak_normal_n", 170_075.2, "distal: peak force", "170.1 kN"),
            ("criteria.tts_s", 0.006_883_746, "time to stability", "6.88375 ms"),
            ("contacts.limit.impulse_n_m_s", 0.000_244_1, "limit: impulse", "244.1 µN·m·s"),
            ("criteria.rebound_percent", 1.234_56, "rebound", "1.235 %"),
            ("final.q11_rad", 0.017_453_292_519_943_295, "final: q11", "1.000°"),
            ("energy.balance_j", 0.0, "energy: balance", "0 J"),
            ("contacts.palm.final_tangential_n", 8.2036e-11, "palm: end friction", "0 N"),
            ("contacts.distal.touchdowns", 2.0, "distal: touch-downs", "2"),
        ] {
            assert_eq!((label(key).as_str(), text(key, value).as_str()), (said, shown), "{key}");
        }
    }
}
