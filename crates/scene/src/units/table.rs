//! Units accepted in quantities.
//!
//! Conversion factors agree with the crate `uom` bit for bit, which a test verifies. The program does not depend on
//! `uom` itself: it would add 4 % to the build time.

use std::f64::consts::{PI, TAU};

/// One accepted spelling of a unit, in its canonical form (`*` for products, `^` for powers).
#[derive(Clone, Copy, Debug)]
pub struct Unit {
    pub name: &'static str,
    /// The unit in SI units.
    pub factor: f64,
    /// Whether [`super::format`] may choose it.
    pub shown: bool,
}

/// Longest time accepted, of a run or in any setting: one hour, whereas a closing motion takes 10 ms.
pub const MAX_TIME_S: f64 = 3600.0;

/// The acceleration unit g, m/s², and the default gravity.
pub const G_M_S2: f64 = 9.81;

/// Physical dimension of a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    Length,
    Angle,
    Time,
    Mass,
    Force,
    Torque,
    Speed,
    AngularRate,
    Acceleration,
    Density,
    Inertia,
    Frequency,
    Pressure,
    AngularStiffness,
    LinearDamping,
    AngularDamping,
}

impl Dimension {
    pub const ALL: [Dimension; 16] = [
        Dimension::Length,
        Dimension::Angle,
        Dimension::Time,
        Dimension::Mass,
        Dimension::Force,
        Dimension::Torque,
        Dimension::Speed,
        Dimension::AngularRate,
        Dimension::Acceleration,
        Dimension::Density,
        Dimension::Inertia,
        Dimension::Frequency,
        Dimension::Pressure,
        Dimension::AngularStiffness,
        Dimension::LinearDamping,
        Dimension::AngularDamping,
    ];

    /// Name with article, for messages.
    pub const fn name(self) -> &'static str {
        match self {
            Dimension::Length => "a length",
            Dimension::Angle => "an angle",
            Dimension::Time => "a time",
            Dimension::Mass => "a mass",
            Dimension::Force => "a force",
            Dimension::Torque => "a torque",
            Dimension::Speed => "a speed",
            Dimension::AngularRate => "an angular rate",
            Dimension::Acceleration => "an acceleration",
            Dimension::Density => "a density",
            Dimension::Inertia => "a moment of inertia",
            Dimension::Frequency => "a frequency",
            Dimension::Pressure => "a pressure (modulus)",
            Dimension::AngularStiffness => "a torsional stiffness",
            Dimension::LinearDamping => "a damping",
            Dimension::AngularDamping => "a torsional damping",
        }
    }

    /// Returns a typical value, for messages and the schema.
    pub const fn example(self) -> &'static str {
        match self {
            Dimension::Length => "15 mm",
            Dimension::Angle => "120 deg",
            Dimension::Time => "20 ms",
            Dimension::Mass => "4.28 g",
            Dimension::Force => "5 N",
            Dimension::Torque => "480 N*mm",
            Dimension::Speed => "0.1 m/s",
            Dimension::AngularRate => "60 rad/s",
            Dimension::Acceleration => "9.81 m/s^2",
            Dimension::Density => "1070 kg/m^3",
            Dimension::Inertia => "200 g*mm^2",
            Dimension::Frequency => "10 kHz",
            Dimension::Pressure => "2.3 GPa",
            Dimension::AngularStiffness => "0.3 N*m/rad",
            Dimension::LinearDamping => "1e6 N*s/m",
            Dimension::AngularDamping => "1e9 N*m*s/rad",
        }
    }

    /// Largest magnitude accepted, in SI units: far beyond any gripper, and small enough to compute with and to show.
    pub const fn max_si(self) -> f64 {
        match self {
            Dimension::Time => MAX_TIME_S,
            Dimension::Length => 1e3,
            Dimension::Speed | Dimension::Mass | Dimension::Density | Dimension::Angle => 1e6,
            Dimension::Force
            | Dimension::Torque
            | Dimension::AngularRate
            | Dimension::Acceleration
            | Dimension::Inertia
            | Dimension::Frequency => 1e12,
            // Rigid bodies are modelled with a modulus of 1e21 Pa.
            Dimension::Pressure
            | Dimension::AngularStiffness
            | Dimension::LinearDamping
            | Dimension::AngularDamping => 1e24,
        }
    }

    /// Magnitude below which results are rounding errors, in SI units: positions and angles have a relative error of
    /// about 1e-16, and contact forces multiply it by a stiffness. 0 for dimensions of inputs only.
    pub const fn resolution_si(self) -> f64 {
        match self {
            Dimension::Force => 1e-9,
            Dimension::Length | Dimension::Angle | Dimension::Torque | Dimension::Speed | Dimension::AngularRate => {
                1e-12
            }
            _ => 0.0,
        }
    }

    /// Suffix of names for the SI unit.
    pub const fn suffix(self) -> &'static str {
        match self {
            Dimension::Length => "m",
            Dimension::Angle => "rad",
            Dimension::Time => "s",
            Dimension::Mass => "kg",
            Dimension::Force => "n",
            Dimension::Torque => "n_m",
            Dimension::Speed => "m_s",
            Dimension::AngularRate => "rad_s",
            Dimension::Acceleration => "m_s2",
            Dimension::Density => "kg_m3",
            Dimension::Inertia => "kg_m2",
            Dimension::Frequency => "hz",
            Dimension::Pressure => "pa",
            Dimension::AngularStiffness => "n_m_per_rad",
            Dimension::LinearDamping => "n_s_per_m",
            Dimension::AngularDamping => "n_m_s_per_rad",
        }
    }

    /// Accepted units; the first is the SI unit.
    pub const fn units(self) -> &'static [Unit] {
        match self {
            Dimension::Length => LENGTH,
            Dimension::Angle => ANGLE,
            Dimension::Time => TIME,
            Dimension::Mass => MASS,
            Dimension::Force => FORCE,
            Dimension::Torque => TORQUE,
            Dimension::Speed => SPEED,
            Dimension::AngularRate => ANGULAR_RATE,
            Dimension::Acceleration => ACCELERATION,
            Dimension::Density => DENSITY,
            Dimension::Inertia => INERTIA,
            Dimension::Frequency => FREQUENCY,
            Dimension::Pressure => PRESSURE,
            Dimension::AngularStiffness => ANGULAR_STIFFNESS,
            Dimension::LinearDamping => LINEAR_DAMPING,
            Dimension::AngularDamping => ANGULAR_DAMPING,
        }
    }

    /// Accepted units as one text: `m, cm, mm, um`.
    pub fn unit_list(self) -> String {
        let names: Vec<&str> = self.units().iter().map(|u| u.name).collect();
        names.join(", ")
    }
}

const fn unit(name: &'static str, factor: f64) -> Unit {
    let shown = true;
    Unit { name, factor, shown }
}

/// Creates a unit that is accepted but not used in output.
const fn read_only(name: &'static str, factor: f64) -> Unit {
    let shown = false;
    Unit { name, factor, shown }
}

const MILLI: f64 = 1e-3;
const CENTI: f64 = 1e-2;
const DEGREE: f64 = PI / 180.0;

const LENGTH: &[Unit] = &[unit("m", 1.0), read_only("cm", CENTI), unit("mm", MILLI), unit("um", 1e-6)];

const ANGLE: &[Unit] = &[unit("rad", 1.0), unit("deg", DEGREE), read_only("rev", TAU)];

const TIME: &[Unit] = &[unit("s", 1.0), unit("ms", MILLI), unit("us", 1e-6)];

const MASS: &[Unit] = &[unit("kg", 1.0), unit("g", MILLI), read_only("mg", 1e-6)];

const FORCE: &[Unit] = &[unit("N", 1.0), unit("mN", MILLI), unit("kN", 1e3), read_only("uN", 1e-6)];

const TORQUE: &[Unit] = &[unit("N*m", 1.0), read_only("N*cm", CENTI), unit("N*mm", MILLI), read_only("mN*m", MILLI)];

const SPEED: &[Unit] = &[unit("m/s", 1.0), read_only("cm/s", CENTI), read_only("mm/s", MILLI), read_only("um/s", 1e-6)];

const ANGULAR_RATE: &[Unit] =
    &[unit("rad/s", 1.0), read_only("deg/s", DEGREE), read_only("rpm", TAU / 60.0), read_only("rev/s", TAU)];

/// `g` is also a mass: the expected dimension decides.
const ACCELERATION: &[Unit] = &[
    unit("m/s^2", 1.0),
    read_only("cm/s^2", CENTI),
    read_only("mm/s^2", MILLI),
    read_only("um/s^2", 1e-6),
    read_only("g", G_M_S2),
];

const DENSITY: &[Unit] = &[unit("kg/m^3", 1.0), read_only("g/cm^3", 1e3)];

const INERTIA: &[Unit] = &[
    unit("kg*m^2", 1.0),
    read_only("kg*cm^2", CENTI * CENTI),
    read_only("kg*mm^2", MILLI * MILLI),
    read_only("g*cm^2", MILLI * CENTI * CENTI),
    unit("g*mm^2", MILLI * MILLI * MILLI),
];

const FREQUENCY: &[Unit] = &[unit("Hz", 1.0), unit("kHz", 1e3), unit("MHz", 1e6)];

const PRESSURE: &[Unit] = &[
    unit("Pa", 1.0),
    read_only("kPa", 1e3),
    unit("MPa", 1e6),
    unit("GPa", 1e9),
    read_only("N/mm^2", 1.0 / (MILLI * MILLI)),
    read_only("N/m^2", 1.0),
];

const ANGULAR_STIFFNESS: &[Unit] = &[
    unit("N*m/rad", 1.0),
    unit("N*mm/rad", MILLI),
    read_only("N*mm/deg", MILLI / DEGREE),
    read_only("N*m/deg", 1.0 / DEGREE),
    read_only("N*cm/rad", CENTI),
    read_only("mN*m/rad", MILLI),
];

const LINEAR_DAMPING: &[Unit] =
    &[unit("N*s/m", 1.0), read_only("N*s/mm", 1.0 / MILLI), read_only("kg/s", 1.0), read_only("N*s/cm", 1.0 / CENTI)];

const ANGULAR_DAMPING: &[Unit] = &[
    unit("N*m*s/rad", 1.0),
    unit("N*mm*s/rad", MILLI),
    read_only("N*m*s", 1.0),
    read_only("N*mm*s", MILLI),
    read_only("N*cm*s/rad", CENTI),
    read_only("mN*m*s/rad", MILLI),
];

#[cfg(test)]
mod tests {
    use super::*;
    use uom::si::acceleration::{
        centimeter_per_second_squared, meter_per_second_squared, micrometer_per_second_squared,
        millimeter_per_second_squared,
    };
    use uom::si::angle::{degree, radian, revolution};
    use uom::si::angular_velocity::{
        degree_per_second, radian_per_second, revolution_per_minute, revolution_per_second,
    };
    use uom::si::f64::{
        Acceleration, Angle, AngularVelocity, Force, Frequency, Length, Mass, MassDensity, Pressure, Time, Torque,
        Velocity,
    };
    use uom::si::force::{kilonewton, micronewton, millinewton, newton};
    use uom::si::frequency::{hertz, kilohertz, megahertz};
    use uom::si::length::{centimeter, meter, micrometer, millimeter};
    use uom::si::mass::{gram, kilogram, milligram};
    use uom::si::mass_density::{gram_per_cubic_centimeter, kilogram_per_cubic_meter};
    use uom::si::pressure::{gigapascal, kilopascal, megapascal, pascal};
    use uom::si::time::{microsecond, millisecond, second};
    use uom::si::torque::{millinewton_meter, newton_centimeter, newton_meter, newton_millimeter};
    use uom::si::velocity::{centimeter_per_second, meter_per_second, micrometer_per_second, millimeter_per_second};

    /// Conversion factors of `uom` in the order of the table.
    fn uom_factors(dimension: Dimension) -> Vec<f64> {
        macro_rules! quantities {
            ($quantity:ident: $($unit:ident),+) => { vec![$($quantity::new::<$unit>(1.0).value),+] };
        }
        let (force, time) = (Force::new::<newton>(1.0), Time::new::<second>(1.0));
        let [heavy, light] = [Mass::new::<kilogram>(1.0), Mass::new::<gram>(1.0)];
        let [m, cm, mm] = [Length::new::<meter>(1.0), Length::new::<centimeter>(1.0), Length::new::<millimeter>(1.0)];
        let [long, short] = [Torque::new::<newton_meter>(1.0), Torque::new::<newton_millimeter>(1.0)];
        let [middle, weak] = [Torque::new::<newton_centimeter>(1.0), Torque::new::<millinewton_meter>(1.0)];
        match dimension {
            Dimension::Length => quantities!(Length: meter, centimeter, millimeter, micrometer),
            Dimension::Angle => quantities!(Angle: radian, degree, revolution),
            Dimension::Time => quantities!(Time: second, millisecond, microsecond),
            Dimension::Mass => quantities!(Mass: kilogram, gram, milligram),
            Dimension::Force => quantities!(Force: newton, millinewton, kilonewton, micronewton),
            Dimension::Torque => {
                quantities!(Torque: newton_meter, newton_centimeter, newton_millimeter, millinewton_meter)
            }
            Dimension::Speed => {
                quantities!(Velocity: meter_per_second, centimeter_per_second, millimeter_per_second, micrometer_per_second)
            }
            Dimension::AngularRate => {
                quantities!(AngularVelocity: radian_per_second, degree_per_second, revolution_per_minute, revolution_per_second)
            }
            Dimension::Acceleration => {
                let mut all = quantities!(
                    Acceleration: meter_per_second_squared, centimeter_per_second_squared, millimeter_per_second_squared,
                    micrometer_per_second_squared
                );
                // Scenes use 9.81 m/s²; standard gravity has more digits.
                all.push(G_M_S2);
                all
            }
            Dimension::Density => quantities!(MassDensity: kilogram_per_cubic_meter, gram_per_cubic_centimeter),
            Dimension::Inertia => [(heavy, m), (heavy, cm), (heavy, mm), (light, cm), (light, mm)]
                .map(|(mass, radius)| (mass * radius * radius).value)
                .to_vec(),
            Dimension::Frequency => quantities!(Frequency: hertz, kilohertz, megahertz),
            Dimension::Pressure => {
                let mut all = quantities!(Pressure: pascal, kilopascal, megapascal, gigapascal);
                all.extend([mm, m].map(|side| (force / (side * side)).value));
                all
            }
            Dimension::AngularStiffness => {
                let per_degree = [short, long].map(|torque| (torque / Angle::new::<degree>(1.0)).value);
                [[long.value, short.value], per_degree, [middle.value, weak.value]].concat()
            }
            Dimension::LinearDamping => {
                vec![
                    (force * time / m).value,
                    (force * time / mm).value,
                    (heavy / time).value,
                    (force * time / cm).value,
                ]
            }
            Dimension::AngularDamping => {
                [long, short, long, short, middle, weak].map(|torque| (torque * time).value).to_vec()
            }
        }
    }

    #[test]
    fn factors_agree_with_uom() {
        for dimension in Dimension::ALL {
            let found: Vec<f64> = dimension.units().iter().map(|unit| unit.factor).collect();
            assert_eq!(found, uom_factors(dimension), "{dimension:?}");
        }
    }

    #[test]
    fn first_unit_is_si_and_names_are_unique() {
        let mut seen = std::collections::BTreeMap::new();
        for dimension in Dimension::ALL {
            assert_eq!(dimension.units()[0].factor, 1.0, "{dimension:?}");
            for unit in dimension.units() {
                assert!(unit.factor > 0.0);
                let other = seen.insert(unit.name, dimension);
                assert!(other.is_none() || unit.name == "g" && dimension == Dimension::Acceleration, "{}", unit.name);
            }
        }
    }

    #[test]
    fn factors_match_hand_worked_values() {
        for (name, expected) in [
            ("um", 1e-6),
            ("deg", std::f64::consts::PI / 180.0),
            ("us", 1e-6),
            ("N*mm", 1e-3),
            ("g*mm^2", 1e-9),
            ("kg*mm^2", 1e-6),
            ("g*cm^2", 1e-7),
            ("rpm", std::f64::consts::TAU / 60.0),
            ("g/cm^3", 1e3),
            ("N/mm^2", 1e6),
            ("N*mm/deg", 0.18 / std::f64::consts::PI),
            ("N*s/mm", 1e3),
            ("N*mm*s/rad", 1e-3),
        ] {
            let unit = Dimension::ALL.iter().flat_map(|d| d.units()).find(|u| u.name == name).expect(name);
            let factor = unit.factor;
            assert!((factor / expected - 1.0).abs() < 1e-14, "{name}: {factor}");
        }
    }
}
