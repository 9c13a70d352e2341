//! Reproducible random numbers, and quantities of scene texts.

use std::fmt::{Display, Write};

/// Pseudo-random number generator (splitmix64), seeded by its field.
pub struct Random(pub u64);

impl Random {
    /// A generator whose numbers have no relation to those of neighbouring seeds.
    pub fn for_seed(seed: u64) -> Self {
        Random(seed.wrapping_mul(0xd134_2543_de82_ef95))
    }

    /// Returns a number uniform in 0…1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Returns a number uniform in `low`…`high`.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Returns a number in `low`…`high` whose logarithm is uniform.
    pub fn log_within(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    /// Returns true with the given probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// Returns a random element.
    pub fn choose<T: Copy>(&mut self, items: &[T]) -> T {
        items[(self.unit() * items.len() as f64) as usize]
    }
}

/// Formats a value with its unit as a quoted string of a scene file.
pub fn quantity(value: f64, unit: impl Display) -> String {
    format!("\"{value:e} {unit}\"")
}

/// Formats a pair of quantities as an array of a scene file.
pub fn pair(values: [f64; 2], unit: &str) -> String {
    format!("[{}, {}]", quantity(values[0], unit), quantity(values[1], unit))
}

/// Appends a line of a section of a scene file.
pub fn key(text: &mut String, name: &str, value: impl Display) {
    let _ = writeln!(text, "{name} = {value}");
}
