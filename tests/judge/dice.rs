//! Random choices for scene texts, the same every time for a seed.

use std::fmt::Display;

/// splitmix64.
pub struct Dice(u64);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Dice(seed.wrapping_mul(0xd134_2543_de82_ef95))
    }

    /// Uniform in 0…1.
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in `low`…`high`.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Every decade from `low` to `high` as likely as the other.
    pub fn decades(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    /// True in a share of all cases.
    pub fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }

    pub fn pick<T: Copy>(&mut self, among: &[T]) -> T {
        among[(self.unit() * among.len() as f64) as usize]
    }
}

/// A value with its unit, in the quotes of a scene file.
pub fn quantity(value: f64, unit: impl Display) -> String {
    format!("\"{value:e} {unit}\"")
}

/// A pair of them.
pub fn pair(values: [f64; 2], unit: &str) -> String {
    format!("[{}, {}]", quantity(values[0], unit), quantity(values[1], unit))
}
