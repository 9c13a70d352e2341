//! Time as an unevaluated sum of two floating-point numbers.

/// A time that can advance by steps below its own resolution. At a stiff joint limit, repeated impacts have a time
/// scale of 1e-12 s, and their events are located a million times more finely. The last digit of a time of 1e-2 s is
/// 2e-18 s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    time: f64,
    remainder: f64,
}

impl Clock {
    pub fn at(time: f64) -> Self {
        Self { time, remainder: 0.0 }
    }

    pub fn now(&self) -> f64 {
        self.time
    }

    /// Advances by `h` (Knuth's two-sum).
    pub fn advance(&mut self, h: f64) {
        let small = h + self.remainder;
        let sum = self.time + small;
        let virtual_part = sum - self.time;
        self.remainder = (self.time - (sum - virtual_part)) + (small - virtual_part);
        self.time = sum;
    }

    /// Time left until `stop`.
    pub fn until(&self, stop: f64) -> f64 {
        (stop - self.time) - self.remainder
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accumulates_steps_below_its_resolution() {
        let mut clock = Clock::at(0.01);
        for _ in 0..1_000_000 {
            clock.advance(1e-19);
        }
        assert!((clock.now() - (0.01 + 1e-13)).abs() < 4e-18);
        assert!((clock.until(0.02) - (0.01 - 1e-13)).abs() < 4e-18);
    }
}
