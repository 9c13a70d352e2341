//! Ranges and ticks of axes. Logarithmic axes are linear in the exponent, so that the same frame serves both kinds.

/// An axis: its label with its unit, its range and its ticks, all in plotted coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    pub label: String,
    pub from: f64,
    pub to: f64,
    pub ticks: Vec<f64>,
    /// Minor ticks between the ticks.
    pub minor_ticks: Vec<f64>,
    pub is_logarithmic: bool,
}

/// Approximate number of ticks of a linear axis.
const TICKS: f64 = 5.0;

/// Tick distance that divides a range into about five parts: 1, 2 or 5 times a power of ten.
pub(crate) fn round_step(range: f64) -> f64 {
    let raw_step = range / TICKS;
    let power = 10f64.powf(raw_step.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().find(|&m| m * power >= raw_step).unwrap_or(10.0) * power
}

impl Axis {
    /// Creates a linear axis over all finite values, with a small margin.
    pub fn linear(label: &str, values: impl IntoIterator<Item = f64>) -> Axis {
        let (low, high) = range(values).unwrap_or((0.0, 1.0));
        let margin = if high > low { 0.04 * (high - low) } else { 0.5 * high.abs().max(1e-12) };
        Axis::from_range(label, low - margin, high + margin)
    }

    /// Creates a linear axis from one value to another.
    pub fn from_range(label: &str, from: f64, to: f64) -> Axis {
        let step = round_step(to - from);
        let ticks = (((from / step).ceil() as i64)..=((to / step).floor() as i64)).map(|k| k as f64 * step).collect();
        Axis { label: label.to_string(), from, to, ticks, minor_ticks: Vec::new(), is_logarithmic: false }
    }

    /// Creates a logarithmic axis over all positive values, in whole decades. If there are more than `decades`, the
    /// lowest are cut off.
    pub fn logarithmic(label: &str, values: impl IntoIterator<Item = f64>, decades: f64) -> Axis {
        let exponents = values.into_iter().filter(|&v| v > 0.0).map(f64::log10);
        let (low, high) = range(exponents).unwrap_or((-1.0, 0.0));
        let to = high.ceil().max(low.floor() + 1.0);
        let from = low.floor().max(to - decades);
        let exponent_range = from as i64..=to as i64;
        let minor_ticks = exponent_range.clone().flat_map(|k| (2..10).map(move |m| k as f64 + f64::from(m).log10()));
        Axis {
            label: label.to_string(),
            from,
            to,
            ticks: exponent_range.map(|k| k as f64).collect(),
            minor_ticks: minor_ticks.filter(|&v| v < to).collect(),
            is_logarithmic: true,
        }
    }

    /// Returns this axis with a margin at both ends, for markers at the ends.
    pub fn with_margin(mut self) -> Axis {
        let margin = 0.02 * (self.to - self.from);
        (self.from, self.to) = (self.from - margin, self.to + margin);
        self
    }

    /// Coordinate of a value on this axis. On a logarithmic axis values beyond its range are clamped to it.
    pub fn coordinate(&self, value: f64) -> f64 {
        match self.is_logarithmic {
            true if value > 0.0 => value.log10().clamp(self.from, self.to),
            true => self.from,
            false => value,
        }
    }

    /// Label of a tick.
    pub fn tick_label(&self, tick: f64) -> String {
        if self.is_logarithmic {
            return format!("10{}", superscript(tick.round() as i64));
        }
        let step = self.ticks.windows(2).map(|pair| pair[1] - pair[0]).next().unwrap_or(1.0);
        let decimals = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
        format!("{tick:.decimals$}").replace('-', "−")
    }
}

/// Smallest and largest of the finite values.
fn range(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    values.into_iter().filter(|v| v.is_finite()).fold(None, |found, v| match found {
        None => Some((v, v)),
        Some((low, high)) => Some((f64::min(low, v), f64::max(high, v))),
    })
}

fn superscript(exponent: i64) -> String {
    let digit = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' | '4'..='9' => char::from_u32('⁰' as u32 + (c as u32 - '0' as u32)).unwrap_or(c),
        other => other,
    };
    exponent.to_string().chars().map(digit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_within_the_range() {
        let axis = Axis::linear("t, ms", [0.0, 20.0]);
        assert_eq!(axis.ticks, [0.0, 5.0, 10.0, 15.0, 20.0]);
        assert_eq!(axis.tick_label(5.0), "5");
        let axis = Axis::from_range("gap, mm", -0.31, 0.29);
        assert!(axis.ticks.iter().all(|&tick| (-0.31..=0.29).contains(&tick)) && axis.ticks.len() >= 3);
        assert_eq!(axis.tick_label(-0.2), "−0.2");
    }

    #[test]
    fn logarithmic_axis_covers_values_and_cuts_off_the_lowest_decades() {
        let axis = Axis::logarithmic("", [3e-7, 2e-3, 0.0, f64::INFINITY], 12.0);
        assert_eq!((axis.from, axis.to), (-7.0, -2.0));
        assert_eq!(axis.tick_label(-7.0), "10⁻⁷");
        assert_eq!(axis.coordinate(0.0), -7.0);
        let axis = Axis::logarithmic("", [1e-20, 1e-3], 6.0);
        assert_eq!((axis.from, axis.to), (-9.0, -3.0));
    }
}
