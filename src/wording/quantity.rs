//! Columns and keys as people read them: a short name, and a unit of everyday size.

use super::figures::{figure, resolved};
use crate::study::sweep::{Holds, held_by};
use crate::table::Value;
use crate::units::Dimension;

/// How a column of SI values is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// The last part of the name without its unit: `base` of `design.base_m`.
    pub name: String,
    /// Empty for plain numbers.
    pub unit: &'static str,
    /// Shown value per SI value.
    pub scale: f64,
    dimension: Option<Dimension>,
}

/// What a quantity is shown in, and the factor.
fn shown(dimension: Dimension) -> (&'static str, f64) {
    match dimension {
        Dimension::Length => ("mm", 1e3),
        Dimension::Angle => ("°", 180.0 / std::f64::consts::PI),
        Dimension::Time => ("ms", 1e3),
        Dimension::Mass => ("g", 1e3),
        Dimension::Force => ("N", 1.0),
        Dimension::Torque => ("N·mm", 1e3),
        Dimension::Speed => ("m/s", 1.0),
        Dimension::AngularRate => ("rad/s", 1.0),
        Dimension::Acceleration => ("m/s²", 1.0),
        Dimension::Density => ("kg/m³", 1.0),
        Dimension::Inertia => ("g·mm²", 1e9),
        Dimension::Frequency => ("Hz", 1.0),
        Dimension::Pressure => ("MPa", 1e-6),
        Dimension::AngularStiffness => ("N·mm/rad", 1e3),
        Dimension::LinearDamping => ("N·s/m", 1.0),
        Dimension::AngularDamping => ("N·m·s/rad", 1.0),
    }
}

impl Quantity {
    /// Of a column of results.
    pub fn of(column: &str) -> Quantity {
        Quantity::new(column, &held_by(column).unwrap_or(Holds::Number))
    }

    /// Of what holds such values: their unit is that of their dimension, however they are called.
    pub fn new(name: &str, holds: &Holds) -> Quantity {
        let last = name.rsplit('.').next().unwrap_or(name);
        let (suffix, (unit, scale), dimension) = match holds {
            Holds::Quantity(of) => (of.suffix(), shown(*of), Some(*of)),
            Holds::Percent => ("percent", ("%", 1.0), None),
            _ => ("", ("", 1.0), None),
        };
        let bare = last.strip_suffix(suffix).and_then(|last| last.strip_suffix('_')).filter(|_| !suffix.is_empty());
        Quantity { name: bare.unwrap_or(last).to_string(), unit, scale, dimension }
    }

    /// Name and unit: `base, mm`.
    pub fn label(&self) -> String {
        if self.unit.is_empty() { self.name.clone() } else { format!("{}, {}", self.name, self.unit) }
    }

    /// A value without its unit.
    pub fn number(&self, value_si: f64, digits: usize) -> String {
        trimmed(&figure(self.dimension.map_or(value_si, |of| resolved(value_si, of)) * self.scale, digits))
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
            ("pfp_n", -8e-11, "pfp, N", "0"),
            ("rebound_percent", 2.5, "rebound, %", "2.5"),
            ("spring.stiffness_n_m_per_rad", 0.0844, "stiffness, N·mm/rad", "84.4"),
            ("limit.damping_n_m_s_per_rad", 1e9, "damping, N·m·s/rad", "1.000e9"),
            ("n", 2.0, "n", "2"),
            ("of_nobody_n_m", 2.0, "of_nobody_n_m", "2"),
        ] {
            let quantity = Quantity::of(column);
            assert_eq!((quantity.label().as_str(), quantity.number(value, 4).as_str()), (label, number));
        }
        assert_eq!(Quantity::of("design.base_m").said(&Value::Number(0.0155)), "base 15.5 mm");
        assert_eq!(Quantity::of("sizing").said(&Value::Text("rigid".into())), "sizing rigid");
    }
}
