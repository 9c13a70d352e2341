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
        // On slices, so that it is compiled once.
        let finite = |all: &[f64]| all.iter().all(|x| x.is_finite());
        finite(&self.q) && finite(&self.v) && finite(&self.z)
    }
}
