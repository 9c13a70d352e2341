//! Units accepted in quantities.
//!
//! Conversion factors agree with the crate `uom` bit for bit, which a test verifies. The program does not depend on
//! `uom` itself: it would add 4 % to the build time.

use std::f64::consts::{PI, TAU};

/// One accepted spelling of a unit, in its canonical form (`*` for products, `^` for powers).
#[derive(Clone, Copy, Debug)]
pub struct Unit {
    pub name: &'static str,
    /// Value of the unit in SI units.
    pub factor: f64,
    /// Whether [`super::format`] may choose it.
    pub shown: bool,
}

/// Longest accepted time in any setting, including the duration of a run: one hour. A closing motion takes 10 ms.
pub const MAX_TIME_S: f64 = 3600.0;

/// The acceleration unit g, m/s², and the default gravity.
pub const G_M_S2: f64 = 9.81;

/// Properties of a dimension.
struct Properties {
    name: &'static str,
    example: &'static str,
    suffix: &'static str,
    max_si: f64,
    resolution_si: f64,
    units: &'static [Unit],
}

/// Defines the dimensions in their order with their properties.
macro_rules! dimensions {
    ($($dimension:ident: $name:literal, $example:literal, $suffix:literal, $max_si:expr, $resolution_si:expr,
        [$($unit:expr),* $(,)?])*) => {
        /// Physical dimension of a quantity.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Dimension {
            $($dimension),*
        }

        impl Dimension {
            /// All dimensions in their order.
            pub const ALL: [Dimension; [$($name),*].len()] = [$(Dimension::$dimension),*];

            fn properties(self) -> Properties {
                match self {
                    $(Dimension::$dimension => Properties {
                        name: $name,
                        example: $example,
                        suffix: $suffix,
                        max_si: $max_si,
                        resolution_si: $resolution_si,
                        units: const { &[$($unit),*] },
                    }),*
                }
            }
        }
    };
}

// Name, example, suffix, largest magnitude and resolution in SI units, and accepted units; the first unit is the SI unit.
dimensions! {
    Length: "a length", "15 mm", "m", 1e3, 1e-12,
        [unit("m", 1.0), read_only("cm", CENTI), unit("mm", MILLI), unit("um", 1e-6)]
    Angle: "an angle", "120 deg", "rad", 1e6, 1e-12,
        [unit("rad", 1.0), unit("deg", DEGREE), read_only("rev", TAU)]
    Time: "a time", "20 ms", "s", MAX_TIME_S, 0.0,
        [unit("s", 1.0), unit("ms", MILLI), unit("us", 1e-6)]
    Mass: "a mass", "4.28 g", "kg", 1e6, 0.0,
        [unit("kg", 1.0), unit("g", MILLI), read_only("mg", 1e-6)]
    Force: "a force", "5 N", "n", 1e12, 1e-9,
        // A torque per length is that of a controller that measures a length and drives a shaft.
        [unit("N", 1.0), unit("mN", MILLI), unit("kN", 1e3), read_only("uN", 1e-6), read_only("N*m/m", 1.0)]
    Torque: "a torque", "480 N*mm", "n_m", 1e12, 1e-12,
        [unit("N*m", 1.0), read_only("N*cm", CENTI), unit("N*mm", MILLI), read_only("mN*m", MILLI)]
    Speed: "a speed", "0.1 m/s", "m_s", 1e6, 1e-12,
        [unit("m/s", 1.0), read_only("cm/s", CENTI), read_only("mm/s", MILLI), read_only("um/s", 1e-6)]
    AngularRate: "an angular rate", "60 rad/s", "rad_s", 1e12, 1e-12,
        [unit("rad/s", 1.0), read_only("deg/s", DEGREE), read_only("rpm", TAU / 60.0), read_only("rev/s", TAU)]
    // `g` is also a mass: the expected dimension decides.
    Acceleration: "an acceleration", "9.81 m/s^2", "m_s2", 1e12, 0.0,
        [unit("m/s^2", 1.0), read_only("cm/s^2", CENTI), read_only("mm/s^2", MILLI), read_only("um/s^2", 1e-6),
            read_only("g", G_M_S2)]
    Density: "a density", "1070 kg/m^3", "kg_m3", 1e6, 0.0,
        [unit("kg/m^3", 1.0), read_only("g/cm^3", 1e3)]
    Inertia: "a moment of inertia", "200 g*mm^2", "kg_m2", 1e12, 0.0,
        [unit("kg*m^2", 1.0), read_only("kg*cm^2", CENTI * CENTI), read_only("kg*mm^2", MILLI * MILLI),
            read_only("g*cm^2", MILLI * CENTI * CENTI), unit("g*mm^2", MILLI * MILLI * MILLI)]
    Frequency: "a frequency", "10 kHz", "hz", 1e12, 0.0,
        [unit("Hz", 1.0), unit("kHz", 1e3), unit("MHz", 1e6)]
    // Rigid bodies are modelled with a modulus of 1e21 Pa.
    Pressure: "a pressure (modulus)", "2.3 GPa", "pa", 1e24, 0.0,
        [unit("Pa", 1.0), read_only("kPa", 1e3), unit("MPa", 1e6), unit("GPa", 1e9),
            read_only("N/mm^2", 1.0 / (MILLI * MILLI)), read_only("N/m^2", 1.0)]
    AngularStiffness: "a torsional stiffness", "0.3 N*m/rad", "n_m_per_rad", 1e24, 0.0,
        [unit("N*m/rad", 1.0), unit("N*mm/rad", MILLI), read_only("N*mm/deg", MILLI / DEGREE),
            read_only("N*m/deg", 1.0 / DEGREE), read_only("N*cm/rad", CENTI), read_only("mN*m/rad", MILLI)]
    LinearDamping: "a damping", "1e6 N*s/m", "n_s_per_m", 1e24, 0.0,
        [unit("N*s/m", 1.0), read_only("N*s/mm", 1.0 / MILLI), read_only("kg/s", 1.0), read_only("N*s/cm", 1.0 / CENTI)]
    AngularDamping: "a torsional damping", "1e9 N*m*s/rad", "n_m_s_per_rad", 1e24, 0.0,
        [unit("N*m*s/rad", 1.0), unit("N*mm*s/rad", MILLI), read_only("N*m*s", 1.0), read_only("N*mm*s", MILLI),
            read_only("N*cm*s/rad", CENTI), read_only("mN*m*s/rad", MILLI)]
    LinearStiffness: "a stiffness", "400 N/m", "n_per_m", 1e24, 0.0,
        [unit("N/m", 1.0), read_only("N/mm", 1.0 / MILLI), read_only("N/cm", 1.0 / CENTI), read_only("kN/m", 1e3)]
    LinearImpactDamping: "an impact damping of a contact", "0.3 s/m", "s_per_m", 1e12, 0.0,
        [unit("s/m", 1.0), read_only("s/mm", 1.0 / MILLI)]
    AngularImpactDamping: "an impact damping of a limit", "0.2 s/rad", "s_per_rad", 1e12, 0.0,
        [unit("s/rad", 1.0), read_only("s/deg", 1.0 / DEGREE)]
    // The damping of a controller that measures a speed and drives a shaft is a torque per speed.
    Impulse: "a torque per speed", "0.5 N*m*s/m", "n_s", 1e24, 0.0,
        [unit("N*s", 1.0), read_only("N*m*s/m", 1.0)]
    Voltage: "a voltage", "12 V", "v", 1e9, 1e-12,
        [unit("V", 1.0), read_only("mV", MILLI), read_only("kV", 1e3)]
    Current: "a current", "0.8 A", "a", 1e9, 1e-12,
        [unit("A", 1.0), unit("mA", MILLI)]
    Resistance: "a resistance", "3 ohm", "ohm", 1e12, 0.0,
        [unit("ohm", 1.0), read_only("mohm", MILLI), read_only("kohm", 1e3)]
    Inductance: "an inductance", "0.3 mH", "h", 1e6, 0.0,
        [unit("H", 1.0), unit("mH", MILLI), read_only("uH", 1e-6)]
    TorqueConstant: "a torque constant", "9 mN*m/A", "n_m_per_a", 1e6, 0.0,
        [unit("N*m/A", 1.0), unit("mN*m/A", MILLI)]
    BackEmf: "a back-EMF constant", "0.009 V*s/rad", "v_s_per_rad", 1e6, 0.0,
        [unit("V*s/rad", 1.0), read_only("mV*s/rad", MILLI), read_only("V/rpm", 60.0 / TAU)]
    AngularVoltage: "a voltage per angle", "20 V/rad", "v_per_rad", 1e24, 0.0,
        [unit("V/rad", 1.0), read_only("V/deg", 1.0 / DEGREE)]
    LinearVoltage: "a voltage per length", "800 V/m", "v_per_m", 1e24, 0.0,
        [unit("V/m", 1.0), read_only("V/mm", 1.0 / MILLI)]
    LinearVoltageDamping: "a voltage per speed", "5 V*s/m", "v_s_per_m", 1e24, 0.0,
        [unit("V*s/m", 1.0), read_only("V*s/mm", 1.0 / MILLI)]
}

impl Dimension {
    /// Name with article, for messages.
    pub fn name(self) -> &'static str {
        self.properties().name
    }

    /// Returns a typical value, for messages and the schema.
    pub fn example(self) -> &'static str {
        self.properties().example
    }

    /// Largest accepted magnitude, in SI units. It is far beyond any gripper, and small enough for computation and
    /// display.
    pub fn max_si(self) -> f64 {
        self.properties().max_si
    }

    /// Magnitude below which results are rounding errors, in SI units; 0 for dimensions that only inputs have.
    /// Positions and angles have a relative error of about 1e-16, and contact forces multiply it by a stiffness.
    pub fn resolution_si(self) -> f64 {
        self.properties().resolution_si
    }

    /// Suffix of names for the SI unit.
    pub fn suffix(self) -> &'static str {
        self.properties().suffix
    }

    /// Whether the quantity belongs to translation; only meaningful if there is a corresponding quantity of rotation.
    pub fn is_linear(self) -> bool {
        use Dimension as D;
        matches!(
            self,
            D::Length
                | D::Speed
                | D::Mass
                | D::Force
                | D::LinearStiffness
                | D::LinearDamping
                | D::LinearImpactDamping
                | D::Impulse
                | D::LinearVoltage
                | D::LinearVoltageDamping
        )
    }

    /// Accepted units; the first one is the SI unit.
    pub fn units(self) -> &'static [Unit] {
        self.properties().units
    }

    /// Accepted units as one text: `m, cm, mm, um`.
    pub(crate) fn unit_list(self) -> String {
        let names: Vec<&str> = self.units().iter().map(|unit| unit.name).collect();
        names.join(", ")
    }
}

const fn unit(name: &'static str, factor: f64) -> Unit {
    Unit { name, factor, shown: true }
}

/// Creates a unit that is accepted but not used in output.
const fn read_only(name: &'static str, factor: f64) -> Unit {
    Unit { name, factor, shown: false }
}

const MILLI: f64 = 1e-3;
const CENTI: f64 = 1e-2;
const DEGREE: f64 = PI / 180.0;

/// Returns the shortest decimal that parses back to the number, plain or with an exponent.
pub fn number(value: f64) -> String {
    let (plain, exponent) = (format!("{value}"), format!("{value:e}"));
    if plain.len() <= exponent.len() + 2 { plain } else { exponent }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Conversion factors of `uom` in the order of the table.
    fn uom_factors(dimension: Dimension) -> Vec<f64> {
        macro_rules! uom {
            ($quantity:ident, $module:ident: $($unit:ident),+) => {
                vec![$(uom::si::f64::$quantity::new::<uom::si::$module::$unit>(1.0).value),+]
            };
        }
        let length = uom!(Length, length: meter, centimeter, millimeter, micrometer);
        let angle = uom!(Angle, angle: radian, degree, revolution);
        let mass = uom!(Mass, mass: kilogram, gram, milligram);
        let torque = uom!(Torque, torque: newton_meter, newton_centimeter, newton_millimeter, millinewton_meter);
        let (cm, mm, degree, gram) = (length[1], length[2], angle[1], mass[1]);
        match dimension {
            Dimension::Length => length,
            Dimension::Angle => angle,
            Dimension::Time => uom!(Time, time: second, millisecond, microsecond),
            Dimension::Mass => mass,
            Dimension::Force => [uom!(Force, force: newton, millinewton, kilonewton, micronewton), vec![1.0]].concat(),
            Dimension::Torque => torque,
            Dimension::Speed => uom!(
                Velocity, velocity: meter_per_second, centimeter_per_second, millimeter_per_second, micrometer_per_second
            ),
            Dimension::AngularRate => uom!(
                AngularVelocity, angular_velocity: radian_per_second, degree_per_second, revolution_per_minute,
                revolution_per_second
            ),
            Dimension::Acceleration => {
                let uom = uom!(
                    Acceleration, acceleration: meter_per_second_squared, centimeter_per_second_squared,
                    millimeter_per_second_squared, micrometer_per_second_squared
                );
                // Scenes use 9.81 m/s²; standard gravity has more digits.
                [uom, vec![G_M_S2]].concat()
            }
            Dimension::Density => {
                uom!(MassDensity, mass_density: kilogram_per_cubic_meter, gram_per_cubic_centimeter)
            }
            Dimension::Inertia => [(1.0, 1.0), (1.0, cm), (1.0, mm), (gram, cm), (gram, mm)]
                .map(|(mass, radius)| mass * radius * radius)
                .to_vec(),
            Dimension::Frequency => uom!(Frequency, frequency: hertz, kilohertz, megahertz),
            Dimension::Pressure => {
                [uom!(Pressure, pressure: pascal, kilopascal, megapascal, gigapascal), vec![1.0 / (mm * mm), 1.0]]
                    .concat()
            }
            Dimension::AngularStiffness => {
                vec![torque[0], torque[2], torque[2] / degree, torque[0] / degree, torque[1], torque[3]]
            }
            Dimension::LinearDamping => vec![1.0, 1.0 / mm, 1.0, 1.0 / cm],
            Dimension::AngularDamping => [0, 2, 0, 2, 1, 3].map(|index| torque[index]).to_vec(),
            Dimension::LinearStiffness => vec![1.0, 1.0 / mm, 1.0 / cm, 1e3],
            Dimension::LinearImpactDamping => vec![1.0, 1.0 / mm],
            Dimension::AngularImpactDamping => vec![1.0, 1.0 / degree],
            Dimension::Impulse => vec![1.0; 2],
            Dimension::Voltage => uom!(ElectricPotential, electric_potential: volt, millivolt, kilovolt),
            Dimension::Current => uom!(ElectricCurrent, electric_current: ampere, milliampere),
            Dimension::Resistance => uom!(ElectricalResistance, electrical_resistance: ohm, milliohm, kiloohm),
            Dimension::Inductance => uom!(Inductance, inductance: henry, millihenry, microhenry),
            Dimension::TorqueConstant => vec![1.0, 1e-3],
            Dimension::BackEmf => vec![1.0, 1e-3, 60.0 / TAU],
            Dimension::AngularVoltage => vec![1.0, 1.0 / degree],
            Dimension::LinearVoltage | Dimension::LinearVoltageDamping => vec![1.0, 1.0 / mm],
        }
    }

    #[test]
    fn factors_agree_with_uom_and_the_first_unit_is_si() {
        let mut seen = std::collections::BTreeMap::new();
        for dimension in Dimension::ALL {
            let found: Vec<f64> = dimension.units().iter().map(|unit| unit.factor).collect();
            assert_eq!(found, uom_factors(dimension), "{dimension:?}");
            assert_eq!(found[0], 1.0, "{dimension:?}");
            for unit in dimension.units() {
                let other = seen.insert(unit.name, dimension);
                assert!(other.is_none() || unit.name == "g" && dimension == Dimension::Acceleration, "{}", unit.name);
            }
        }
    }
}
