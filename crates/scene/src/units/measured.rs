//! Numbers with a dimension that follows from a computation: exponents of the base units.

use std::fmt;

use super::{Dimension, format, number};

/// Exponents of metre, kilogram, second, radian and ampere. They are doubled, because of square roots.
///
/// An angle is a dimension of its own. Arc lengths and the speeds of rotating points contain a radian as a factor;
/// lengths and speeds do not. Therefore a radian times a length counts as a length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exponents(pub(super) [i32; 5]);

const BASE_UNITS: [&str; 5] = ["m", "kg", "s", "rad", "A"];

impl Exponents {
    pub(super) const NUMBER: Self = Exponents([0; 5]);
    pub(super) const ANGLE: Self = Exponents([0, 0, 0, 2, 0]);

    /// Exponents of a dimension, from the name of its SI unit; `None` is a plain number.
    fn of(dimension: Option<Dimension>) -> Self {
        let Some(dimension) = dimension else { return Self::NUMBER };
        let unit = dimension.units()[0].name;
        let (top, bottom) = unit.split_once('/').unwrap_or((unit, ""));
        let factors = top.split('*').map(|factor| (factor, 2)).chain([(bottom, -2)]);
        factors.fold(Self::NUMBER, |product, (factor, sign)| {
            let (name, power) = factor.split_once('^').unwrap_or((factor, "1"));
            let of_name = match name {
                "N" => [1, 1, -2, 0, 0],
                "Pa" => [-1, 1, -2, 0, 0],
                "Hz" => [0, 0, -1, 0, 0],
                "V" => [2, 1, -3, 0, -1],
                "ohm" => [2, 1, -3, 0, -2],
                "H" => [2, 1, -2, 0, -2],
                _ => BASE_UNITS.map(|base| i32::from(base == name)),
            };
            product.plus(Exponents(of_name), sign * power.parse().unwrap_or(1))
        })
    }

    /// Exponents of a product with another quantity to a power.
    pub(super) fn plus(self, other: Self, power: i32) -> Self {
        Exponents(std::array::from_fn(|i| self.0[i].saturating_add(other.0[i].saturating_mul(power))))
    }

    /// Whether quantities with these exponents can be added and compared.
    pub(super) fn agrees(self, other: Self) -> bool {
        let ([length, .., angle, current], of_other) = (self.0, other.0);
        self.0[..3] == of_other[..3]
            && current == of_other[4]
            && (angle == of_other[3] || length != 0 && angle >= 0 && of_other[3] >= 0)
    }

    /// The dimension with exactly these exponents.
    fn dimension(self) -> Option<Dimension> {
        Dimension::ALL.into_iter().find(|dimension| Self::of(Some(*dimension)) == self)
    }

    /// Name with article, for messages.
    pub(super) fn name(self) -> String {
        match self.dimension() {
            Some(dimension) => dimension.name().to_string(),
            None if self == Self::NUMBER => "a number".to_string(),
            None => format!("a quantity in {self}"),
        }
    }
}

impl fmt::Display for Exponents {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let factor = |(unit, exponent): (&str, i32)| match exponent.abs() {
            2 => unit.to_string(),
            doubled => format!("{unit}^{}", f64::from(doubled) / 2.0),
        };
        let all = || BASE_UNITS.into_iter().zip(self.0);
        let top: Vec<String> = all().filter(|(_, exponent)| *exponent > 0).map(factor).collect();
        let bottom = all().filter(|(_, exponent)| *exponent < 0).map(|found| format!("/{}", factor(found)));
        write!(f, "{}{}", if top.is_empty() { "1".to_string() } else { top.join("*") }, bottom.collect::<String>())
    }
}

/// A finite number in SI units with its dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    pub si: f64,
    pub exponents: Exponents,
}

impl Measured {
    /// Creates a value of this dimension; `None` is a plain number.
    pub fn new(si: f64, dimension: Option<Dimension>) -> Self {
        Measured { si, exponents: Exponents::of(dimension) }
    }

    /// Whether this can be a value of a dimension; `None` is a plain number.
    pub fn is(&self, dimension: Option<Dimension>) -> bool {
        self.exponents.agrees(Exponents::of(dimension))
    }

    /// The dimension with exactly these exponents; `None` for a plain number, or for a dimension without a name.
    pub fn dimension(&self) -> Option<Dimension> {
        self.exponents.dimension()
    }

    pub fn is_number(&self) -> bool {
        self.exponents == Exponents::NUMBER
    }

    /// Name of the dimension, with its article, for messages.
    pub fn name(&self) -> String {
        self.exponents.name()
    }
}

impl fmt::Display for Measured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.dimension() {
            Some(dimension) => f.write_str(&format(self.si, dimension)),
            None if self.is_number() => f.write_str(&number(self.si)),
            None => write!(f, "{} {}", number(self.si), self.exponents),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// If a value allows several dimensions, the exponents of an expression determine which one is meant, so all
    /// dimensions must differ.
    #[test]
    fn dimensions_have_different_exponents_and_the_units_of_their_names() {
        for first in Dimension::ALL {
            assert_eq!(Measured::new(1.0, Some(first)).dimension(), Some(first));
            for second in Dimension::ALL.into_iter().filter(|second| *second != first) {
                assert!(!Measured::new(1.0, Some(first)).is(Some(second)), "{first:?} {second:?}");
            }
            assert!(!Measured::new(1.0, Some(first)).is(None), "{first:?}");
        }
        for (dimension, units) in [
            (Dimension::AngularStiffness, "m^2*kg/s^2/rad"),
            (Dimension::Pressure, "kg/m/s^2"),
            (Dimension::Density, "kg/m^3"),
            (Dimension::Frequency, "1/s"),
            (Dimension::AngularImpactDamping, "s/rad"),
        ] {
            assert_eq!(Exponents::of(Some(dimension)).to_string(), units);
        }
        assert_eq!(Exponents([1, 0, -3, 0, 0]).to_string(), "m^0.5/s^1.5");
    }
}
