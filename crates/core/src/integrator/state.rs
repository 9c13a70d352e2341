//! Coordinates, their rates, and quadratures.

/// Coordinates, their rates, and quadratures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<const N: usize, const Z: usize> {
    pub q: [f64; N],
    pub v: [f64; N],
    pub z: [f64; Z],
}

impl<const N: usize, const Z: usize> State<N, Z> {
    pub fn is_finite(&self) -> bool {
        self.q.iter().chain(&self.v).chain(&self.z).all(|x| x.is_finite())
    }
}
