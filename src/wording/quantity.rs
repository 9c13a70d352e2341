//! Columns and keys as people read them: a short name, and a unit of everyday size.

use super::figures::figure;
use crate::table::Value;

/// How a column of SI values is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// The last part of the name without its unit: `base` of `design.base_m`.
    pub name: String,
    /// Empty for plain numbers.
    pub unit: &'static str,
    /// Shown value per SI value.
    pub scale: f64,
}

/// Suffixes of names, what they are shown in, and the factor; longer ones before those they end in.
const UNITS: [(&str, &str, f64); 19] = [
    ("_n_s_per_m", "N·s/m", 1.0),
    ("_kg_per_m3", "kg/m³", 1.0),
    ("_kg_m3", "kg/m³", 1.0),
    ("_kg_m2", "kg·m²", 1.0),
    ("_n_m_rad", "N·m/rad", 1.0),
    ("_rad_s2", "rad/s²", 1.0),
    ("_rad_s", "rad/s", 1.0),
    ("_m_s2", "m/s²", 1.0),
    ("_m_s", "m/s", 1.0),
    ("_n_m", "N·mm", 1e3),
    ("_n_s", "mN·s", 1e3),
    ("_percent", "%", 1.0),
    ("_rad", "°", 180.0 / std::f64::consts::PI),
    ("_kg", "g", 1e3),
    ("_hz", "Hz", 1.0),
    ("_j", "J", 1.0),
    ("_s", "ms", 1e3),
    ("_m", "mm", 1e3),
    ("_n", "N", 1.0),
];

impl Quantity {
    pub fn of(column: &str) -> Quantity {
        let last = column.rsplit('.').next().unwrap_or(column);
        match UNITS.iter().find(|(suffix, ..)| last.len() > suffix.len() && last.ends_with(suffix)) {
            Some(&(suffix, unit, scale)) => {
                Quantity { name: last[..last.len() - suffix.len()].to_string(), unit, scale }
            }
            None => Quantity { name: last.to_string(), unit: "", scale: 1.0 },
        }
    }

    /// Name and unit: `base, mm`.
    pub fn label(&self) -> String {
        if self.unit.is_empty() { self.name.clone() } else { format!("{}, {}", self.name, self.unit) }
    }

    /// A value without its unit.
    pub fn number(&self, value_si: f64, digits: usize) -> String {
        trimmed(&figure(value_si * self.scale, digits))
    }

    /// Any value without its unit; nothing is a dash.
    pub fn value(&self, value: &Value, digits: usize) -> String {
        match value {
            Value::Number(number) => self.number(*number, digits),
            Value::Integer(number) if self.scale != 1.0 => self.number(*number as f64, digits),
            Value::Missing => "–".to_string(),
            other => other.text(),
        }
    }

    /// A value with name and unit: `mu_static 0.8`, `base 15.5 mm`.
    pub fn said(&self, value: &Value) -> String {
        let gap = if self.unit.is_empty() || self.unit == "°" || self.unit == "%" { "" } else { " " };
        format!("{} {}{gap}{}", self.name, self.value(value, 4), self.unit)
    }
}

/// Without noughts at the end of a fraction.
fn trimmed(text: &str) -> String {
    if !text.contains('.') || text.contains('e') {
        return text.to_string();
    }
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lose_their_units_and_values_gain_handy_ones() {
        for (column, value, label, number) in [
            ("design.base_m", 0.0155, "base, mm", "15.5"),
            ("design.l21_fraction", 1.0 / 3.0, "l21_fraction", "0.3333"),
            ("design.phi22_rad", 120f64.to_radians(), "phi22, °", "120"),
            ("contact.friction.mu_static", 0.8, "mu_static", "0.8"),
            ("motor_n_m", 0.5165, "motor, N·mm", "516.5"),
            ("pfp_n", -3.0, "pfp, N", "-3"),
            ("tts_s", 6.9e-3, "tts, ms", "6.9"),
            ("mass_kg", 0.0, "mass, g", "0"),
            ("gravity_m_s2", 9.81, "gravity, m/s²", "9.81"),
            ("n", 2.0, "n", "2"),
        ] {
            let quantity = Quantity::of(column);
            assert_eq!((quantity.label().as_str(), quantity.number(value, 4).as_str()), (label, number));
        }
        assert_eq!(Quantity::of("design.base_m").said(&Value::Number(0.0155)), "base 15.5 mm");
        assert_eq!(Quantity::of("sizing").said(&Value::Text("rigid".into())), "sizing rigid");
    }
}
