//! What a five-bar has derivatives of, among those of a longer list of coordinates.

use super::dynamics::Terms;
use super::kinematics::{Directions, PassiveRates};
use crate::numeric::Dual;

impl Directions<Dual<2>> {
    /// The same among the derivatives of a longer list of coordinates.
    #[inline(always)]
    pub fn widen<const W: usize>(&self) -> Directions<Dual<W>> {
        let Directions { e1, e2, e3, e4 } = *self;
        Directions {
            e1: e1.map(Dual::among),
            e2: e2.map(Dual::among),
            e3: e3.map(Dual::among),
            e4: e4.map(Dual::among),
        }
    }
}

impl PassiveRates<Dual<2>> {
    /// The same among the derivatives of a longer list of coordinates.
    #[inline(always)]
    pub fn widen<const W: usize>(&self) -> PassiveRates<Dual<W>> {
        PassiveRates {
            a3: self.a3.map(Dual::among),
            a4: self.a4.map(Dual::among),
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
            mass: self.mass.map(Dual::among),
            quadratic: self.quadratic.map(|row| row.map(Dual::among)),
            gravity: self.gravity.map(Dual::among),
        }
    }
}
