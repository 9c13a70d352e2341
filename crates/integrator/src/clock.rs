//! Time as an unevaluated sum of two numbers.

/// A time that steps far below its own resolution still move: the hammering of a stiff joint limit has a scale of 1e-12 s,
/// and its events are located a million times finer, beside a time of 1e-2 s whose last digit is 2e-18 s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    time: f64,
    rest: f64,
}

impl Clock {
    pub fn at(time: f64) -> Self {
        Self { time, rest: 0.0 }
    }

    pub fn now(&self) -> f64 {
        self.time
    }

    /// Advances by `h` (two-sum of Knuth).
    pub fn advance(&mut self, h: f64) {
        let small = h + self.rest;
        let sum = self.time + small;
        let back = sum - self.time;
        self.rest = (self.time - (sum - back)) + (small - back);
        self.time = sum;
    }

    /// Time left until `stop`.
    pub fn until(&self, stop: f64) -> f64 {
        (stop - self.time) - self.rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiny_steps_add_up() {
        let mut clock = Clock::at(0.01);
        for _ in 0..1_000_000 {
            clock.advance(1e-19);
        }
        assert!((clock.now() - (0.01 + 1e-13)).abs() < 4e-18);
        assert!((clock.until(0.02) - (0.01 - 1e-13)).abs() < 4e-18);
    }
}
