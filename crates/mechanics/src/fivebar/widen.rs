//! Extension of the five-bar's derivatives to a longer list of coordinates.

use super::dynamics::Terms;
use super::kinematics::{Directions, PassiveRates};
use crate::numeric::{Dual, map_array};

impl Directions<Dual<2>> {
    /// Extends the derivatives to a longer list of coordinates; those of the new coordinates are zero.
    #[inline(always)]
    pub fn widen<const W: usize>(&self) -> Directions<Dual<W>> {
        let Directions { e1, e2, e3, e4 } = *self;
        Directions {
            e1: map_array(e1, Dual::widen),
            e2: map_array(e2, Dual::widen),
            e3: map_array(e3, Dual::widen),
            e4: map_array(e4, Dual::widen),
        }
    }
}

impl PassiveRates<Dual<2>> {
    /// Extends the derivatives to a longer list of coordinates; those of the new coordinates are zero.
    #[inline(always)]
    pub fn widen<const W: usize>(&self) -> PassiveRates<Dual<W>> {
        PassiveRates {
            a3: map_array(self.a3, Dual::widen),
            a4: map_array(self.a4, Dual::widen),
            inverse_sine: self.inverse_sine.widen(),
        }
    }
}

impl Terms<Dual<2>> {
    /// Extends the derivatives to a longer list of coordinates; those of the new coordinates are zero.
    #[inline(always)]
    pub fn widen<const W: usize>(&self) -> Terms<Dual<W>> {
        Terms {
            pose: self.pose.widen(),
            rates: self.rates.widen(),
            mass: map_array(self.mass, Dual::widen),
            quadratic: map_array(self.quadratic, |row| map_array(row, Dual::widen)),
            gravity: map_array(self.gravity, Dual::widen),
        }
    }
}
