//! Short names and common units of columns and keys.

use super::sweep::{FieldType, column_type};
use crate::table::Value;
use crate::units::Dimension;
use phalanx_show::format::numbers::{format_number, zero_below_resolution};

/// Format in which a column of SI values is displayed.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnFormat {
    /// Last part of the name without its unit, such as `base` for `design.base_m`.
    pub name: String,
    /// Displayed unit; empty for plain numbers.
    pub unit: &'static str,
    /// Factor from SI units to the displayed unit.
    pub scale: f64,
    dimension: Option<Dimension>,
}

/// Display unit of a dimension, and the factor from SI.
fn display_unit(dimension: Dimension) -> (&'static str, f64) {
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
        Dimension::Impulse => ("N·s", 1.0),
        Dimension::Voltage => ("V", 1.0),
        Dimension::Current => ("A", 1.0),
        Dimension::Resistance => ("ohm", 1.0),
        Dimension::Inductance => ("mH", 1e3),
        Dimension::TorqueConstant => ("mN·m/A", 1e3),
        Dimension::BackEmf => ("V·s/rad", 1.0),
        Dimension::AngularVoltage => ("V/rad", 1.0),
        Dimension::LinearVoltage => ("V/m", 1.0),
        Dimension::LinearVoltageDamping => ("V·s/m", 1.0),
        Dimension::LinearStiffness => ("N/m", 1.0),
        Dimension::LinearImpactDamping => ("s/m", 1.0),
        Dimension::AngularImpactDamping => ("s/rad", 1.0),
    }
}

impl ColumnFormat {
    pub(crate) fn for_column(column: &str) -> ColumnFormat {
        ColumnFormat::new(column, &column_type(column).unwrap_or(FieldType::Number))
    }

    /// Returns the format of a column or key with values of this type. The unit depends on the dimension of the type,
    /// not on the name.
    pub fn new(name: &str, field_type: &FieldType) -> ColumnFormat {
        let last = name.rsplit('.').next().unwrap_or(name);
        let (suffix, (unit, scale), dimension) = match field_type {
            FieldType::Quantity(dimension) => (dimension.suffix(), display_unit(*dimension), Some(*dimension)),
            FieldType::Percent => ("percent", ("%", 1.0), None),
            _ => ("", ("", 1.0), None),
        };
        let unprefixed =
            last.strip_suffix(suffix).and_then(|last| last.strip_suffix('_')).filter(|_| !suffix.is_empty());
        ColumnFormat { name: unprefixed.unwrap_or(last).to_string(), unit, scale, dimension }
    }

    /// Name and unit, such as `base, mm`.
    pub fn label(&self) -> String {
        if self.unit.is_empty() { self.name.clone() } else { format!("{}, {}", self.name, self.unit) }
    }

    /// Formats a number without its unit.
    pub fn number(&self, value_si: f64, digits: usize) -> String {
        trim_trailing_zeros(&format_number(
            self.dimension.map_or(value_si, |dimension| zero_below_resolution(value_si, dimension)) * self.scale,
            digits,
        ))
    }

    /// Formats any value without its unit; a missing value is a dash.
    pub fn value(&self, value: &Value, digits: usize) -> String {
        match value {
            Value::Number(number) => self.number(*number, digits),
            Value::Integer(number) if self.scale != 1.0 => self.number(*number as f64, digits),
            Value::Missing => "–".to_string(),
            other => other.text(),
        }
    }

    /// Formats a value with name and unit: `mu_static 0.8`, `base 15.5 mm`.
    pub(crate) fn name_and_value(&self, value: &Value) -> String {
        let gap = if self.unit.is_empty() || self.unit == "°" || self.unit == "%" { "" } else { " " };
        format!("{} {}{gap}{}", self.name, self.value(value, 4), self.unit)
    }
}

fn trim_trailing_zeros(text: &str) -> String {
    if !text.contains('.') || text.contains('e') {
        return text.to_string();
    }
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_names_without_unit_and_values_in_common_units() {
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
            let quantity = ColumnFormat::for_column(column);
            assert_eq!((quantity.label().as_str(), quantity.number(value, 4).as_str()), (label, number));
        }
        assert_eq!(ColumnFormat::for_column("design.base_m").name_and_value(&Value::Number(0.0155)), "base 15.5 mm");
        assert_eq!(ColumnFormat::for_column("sizing").name_and_value(&Value::Text("rigid".into())), "sizing rigid");
    }
}
