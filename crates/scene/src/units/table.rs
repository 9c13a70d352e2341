//! The closed list of units a quantity may be written in.

use uom::si::acceleration::{centimeter_per_second_squared, meter_per_second_squared, millimeter_per_second_squared};
use uom::si::angle::{degree, radian, revolution};
use uom::si::angular_velocity::{degree_per_second, radian_per_second, revolution_per_minute};
use uom::si::f64::{
    Acceleration, Angle, AngularVelocity, Force, Frequency, Length, Mass, MassDensity, Pressure, Time, Torque, Velocity,
};
use uom::si::force::{kilonewton, millinewton, newton};
use uom::si::frequency::{hertz, kilohertz, megahertz};
use uom::si::length::{centimeter, meter, micrometer, millimeter};
use uom::si::mass::{gram, kilogram, milligram};
use uom::si::mass_density::{gram_per_cubic_centimeter, kilogram_per_cubic_meter};
use uom::si::pressure::{gigapascal, kilopascal, megapascal, pascal};
use uom::si::time::{microsecond, millisecond, second};
use uom::si::torque::{millinewton_meter, newton_centimeter, newton_meter, newton_millimeter};
use uom::si::velocity::{centimeter_per_second, meter_per_second, millimeter_per_second};

/// One accepted spelling of a unit, in its canonical form (`*` for products, `^` for powers).
#[derive(Clone, Copy, Debug)]
pub struct Unit {
    pub name: &'static str,
    /// How many SI units it is.
    pub factor: fn() -> f64,
    /// Whether [`super::format`] may choose it.
    pub shown: bool,
}

/// The longest time, of a run as of anything else: an hour, for a closing takes 10 ms.
pub const LONGEST_S: f64 = 3600.0;

/// What a quantity measures.
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

    /// Name with its article, for messages.
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

    /// A typical value, for messages and the schema.
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

    /// The largest size of a value, in SI: far beyond any gripper, and small enough to be computed with and shown.
    pub const fn largest_si(self) -> f64 {
        match self {
            Dimension::Time => LONGEST_S,
            Dimension::Length => 1e3,
            Dimension::Speed | Dimension::Mass | Dimension::Density | Dimension::Angle => 1e6,
            Dimension::Force
            | Dimension::Torque
            | Dimension::AngularRate
            | Dimension::Acceleration
            | Dimension::Inertia
            | Dimension::Frequency => 1e12,
            // What is meant to be rigid is given a modulus of 1e21 Pa.
            Dimension::Pressure
            | Dimension::AngularStiffness
            | Dimension::LinearDamping
            | Dimension::AngularDamping => 1e24,
        }
    }

    /// The SI unit at the end of a name.
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

    /// Accepted units; the first is the SI one.
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

const fn unit(name: &'static str, factor: fn() -> f64) -> Unit {
    let shown = true;
    Unit { name, factor, shown }
}

/// A unit that is read but never chosen for output.
const fn read_only(name: &'static str, factor: fn() -> f64) -> Unit {
    let shown = false;
    Unit { name, factor, shown }
}

const LENGTH: &[Unit] = &[
    unit("m", || Length::new::<meter>(1.0).value),
    read_only("cm", || Length::new::<centimeter>(1.0).value),
    unit("mm", || Length::new::<millimeter>(1.0).value),
    unit("um", || Length::new::<micrometer>(1.0).value),
];

const ANGLE: &[Unit] = &[
    unit("rad", || Angle::new::<radian>(1.0).value),
    unit("deg", || Angle::new::<degree>(1.0).value),
    read_only("rev", || Angle::new::<revolution>(1.0).value),
];

const TIME: &[Unit] = &[
    unit("s", || Time::new::<second>(1.0).value),
    unit("ms", || Time::new::<millisecond>(1.0).value),
    unit("us", || Time::new::<microsecond>(1.0).value),
];

const MASS: &[Unit] = &[
    unit("kg", || Mass::new::<kilogram>(1.0).value),
    unit("g", || Mass::new::<gram>(1.0).value),
    read_only("mg", || Mass::new::<milligram>(1.0).value),
];

const FORCE: &[Unit] = &[
    unit("N", || Force::new::<newton>(1.0).value),
    unit("mN", || Force::new::<millinewton>(1.0).value),
    unit("kN", || Force::new::<kilonewton>(1.0).value),
];

const TORQUE: &[Unit] = &[
    unit("N*m", || Torque::new::<newton_meter>(1.0).value),
    read_only("N*cm", || Torque::new::<newton_centimeter>(1.0).value),
    unit("N*mm", || Torque::new::<newton_millimeter>(1.0).value),
    read_only("mN*m", || Torque::new::<millinewton_meter>(1.0).value),
];

const SPEED: &[Unit] = &[
    unit("m/s", || Velocity::new::<meter_per_second>(1.0).value),
    read_only("cm/s", || Velocity::new::<centimeter_per_second>(1.0).value),
    read_only("mm/s", || Velocity::new::<millimeter_per_second>(1.0).value),
];

const ANGULAR_RATE: &[Unit] = &[
    unit("rad/s", || AngularVelocity::new::<radian_per_second>(1.0).value),
    read_only("deg/s", || AngularVelocity::new::<degree_per_second>(1.0).value),
    read_only("rpm", || AngularVelocity::new::<revolution_per_minute>(1.0).value),
];

const ACCELERATION: &[Unit] = &[
    unit("m/s^2", || Acceleration::new::<meter_per_second_squared>(1.0).value),
    read_only("cm/s^2", || Acceleration::new::<centimeter_per_second_squared>(1.0).value),
    read_only("mm/s^2", || Acceleration::new::<millimeter_per_second_squared>(1.0).value),
];

const DENSITY: &[Unit] = &[
    unit("kg/m^3", || MassDensity::new::<kilogram_per_cubic_meter>(1.0).value),
    read_only("g/cm^3", || MassDensity::new::<gram_per_cubic_centimeter>(1.0).value),
];

const INERTIA: &[Unit] = &[
    unit("kg*m^2", || 1.0),
    read_only("kg*mm^2", || inertia(Mass::new::<kilogram>(1.0), Length::new::<millimeter>(1.0))),
    read_only("g*cm^2", || inertia(Mass::new::<gram>(1.0), Length::new::<centimeter>(1.0))),
    unit("g*mm^2", || inertia(Mass::new::<gram>(1.0), Length::new::<millimeter>(1.0))),
];

const FREQUENCY: &[Unit] = &[
    unit("Hz", || Frequency::new::<hertz>(1.0).value),
    unit("kHz", || Frequency::new::<kilohertz>(1.0).value),
    unit("MHz", || Frequency::new::<megahertz>(1.0).value),
];

const PRESSURE: &[Unit] = &[
    unit("Pa", || Pressure::new::<pascal>(1.0).value),
    read_only("kPa", || Pressure::new::<kilopascal>(1.0).value),
    unit("MPa", || Pressure::new::<megapascal>(1.0).value),
    unit("GPa", || Pressure::new::<gigapascal>(1.0).value),
    read_only("N/mm^2", || {
        let side = Length::new::<millimeter>(1.0);
        (Force::new::<newton>(1.0) / (side * side)).value
    }),
];

const ANGULAR_STIFFNESS: &[Unit] = &[
    unit("N*m/rad", || Torque::new::<newton_meter>(1.0).value),
    unit("N*mm/rad", || Torque::new::<newton_millimeter>(1.0).value),
    read_only("N*mm/deg", || (Torque::new::<newton_millimeter>(1.0) / Angle::new::<degree>(1.0)).value),
];

const LINEAR_DAMPING: &[Unit] = &[
    unit("N*s/m", || linear_damping(Length::new::<meter>(1.0))),
    read_only("N*s/mm", || linear_damping(Length::new::<millimeter>(1.0))),
    read_only("kg/s", || (Mass::new::<kilogram>(1.0) / Time::new::<second>(1.0)).value),
];

const ANGULAR_DAMPING: &[Unit] = &[
    unit("N*m*s/rad", || angular_damping(Torque::new::<newton_meter>(1.0))),
    unit("N*mm*s/rad", || angular_damping(Torque::new::<newton_millimeter>(1.0))),
    read_only("N*m*s", || angular_damping(Torque::new::<newton_meter>(1.0))),
    read_only("N*mm*s", || angular_damping(Torque::new::<newton_millimeter>(1.0))),
];

fn inertia(mass: Mass, radius: Length) -> f64 {
    (mass * radius * radius).value
}

fn linear_damping(length: Length) -> f64 {
    (Force::new::<newton>(1.0) * Time::new::<second>(1.0) / length).value
}

fn angular_damping(torque: Torque) -> f64 {
    (torque * Time::new::<second>(1.0)).value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_unit_is_si_and_names_are_unique() {
        let mut seen = std::collections::BTreeMap::new();
        for dimension in Dimension::ALL {
            assert_eq!((dimension.units()[0].factor)(), 1.0, "{dimension:?}");
            for unit in dimension.units() {
                assert!((unit.factor)() > 0.0);
                assert_eq!(seen.insert(unit.name, dimension), None, "{}", unit.name);
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
            let factor = (unit.factor)();
            assert!((factor / expected - 1.0).abs() < 1e-14, "{name}: {factor}");
        }
    }
}
