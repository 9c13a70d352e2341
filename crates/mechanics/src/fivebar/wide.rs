//! What a five-bar has derivatives of, among those of a longer list of coordinates.

use super::dynamics::Terms;
use super::kinematics::{Directions, PassiveRates};
use crate::numeric::{Dual, from_each};

impl Directions<Dual<2>> {
    /// The same among the derivatives of a longer list of coordinates.
    #[inline(always)]
    pub fn widen<const W: usize>(&self) -> Directions<Dual<W>> {
        let Directions { e1, e2, e3, e4 } = *self;
        Directions {
            e1: from_each(e1, Dual::among),
            e2: from_each(e2, Dual::among),
            e3: from_each(e3, Dual::among),
            e4: from_each(e4, Dual::among),
        }
    }
}

impl PassiveRates<Dual<2>> {
    /// The same among the derivatives of a longer list of coordinates.
    #[inline(always)]
    pub fn widen<const W: usize>(&self) -> PassiveRates<Dual<W>> {
        PassiveRates {
            a3: from_each(self.a3, Dual::among),
            a4: from_each(self.a4, Dual::among),
            inverse_sine: self.inverse_sine.among(),
        }
    }
}

impl Terms<Dual<2>> {
    /// The same among the derivatives of a longer list of coordinates.
    #[inline(always)]
    pub fn widen<const W: usize>(&self) -> Terms<Dual<W>> {
        Terms {
            pose: self.pose.widen(),
            rates: self.rates.widen(),
            mass: from_each(self.mass, Dual::among),
            quadratic: from_each(self.quadratic, |row| from_each(row, Dual::among)),
            gravity: from_each(self.gravity, Dual::among),
        }
    }
}
