//! Ranges and ticks. Logarithmic axes are linear in the exponent, so that one kind of frame serves both.

/// An axis: its label with its unit, its range and its ticks, all in plotted coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    pub label: String,
    pub from: f64,
    pub to: f64,
    pub ticks: Vec<f64>,
    /// Fine lines between the ticks.
    pub between: Vec<f64>,
    pub log: bool,
}

/// Ticks of a linear axis, about.
const TICKS: f64 = 5.0;

/// 1, 2 or 5 times a power of ten: what a range is divided into some five parts by.
pub fn round_step(range: f64) -> f64 {
    let raw = range / TICKS;
    let power = 10f64.powf(raw.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().find(|&m| m * power >= raw).unwrap_or(10.0) * power
}

impl Axis {
    /// A linear axis over all finite values, a little wider than they are.
    pub fn linear(label: &str, values: impl IntoIterator<Item = f64>) -> Axis {
        let (low, high) = range(values).unwrap_or((0.0, 1.0));
        let margin = if high > low { 0.04 * (high - low) } else { 0.5 * high.abs().max(1e-12) };
        Axis::over(label, low - margin, high + margin)
    }

    /// A linear axis from one value to another.
    pub fn over(label: &str, from: f64, to: f64) -> Axis {
        let step = round_step(to - from);
        let ticks = (((from / step).ceil() as i64)..=((to / step).floor() as i64)).map(|k| k as f64 * step).collect();
        Axis { label: label.to_string(), from, to, ticks, between: Vec::new(), log: false }
    }

    /// A logarithmic axis over all positive values, from decade to decade, at most `decades` of them: the lowest are
    /// cut off.
    pub fn decades(label: &str, values: impl IntoIterator<Item = f64>, decades: f64) -> Axis {
        let exponents = values.into_iter().filter(|&v| v > 0.0).map(f64::log10);
        let (low, high) = range(exponents).unwrap_or((-1.0, 0.0));
        let to = high.ceil().max(low.floor() + 1.0);
        let from = low.floor().max(to - decades);
        let whole = from as i64..=to as i64;
        let between = whole.clone().flat_map(|k| (2..10).map(move |m| k as f64 + f64::from(m).log10()));
        Axis {
            label: label.to_string(),
            from,
            to,
            ticks: whole.map(|k| k as f64).collect(),
            between: between.filter(|&v| v < to).collect(),
            log: true,
        }
    }

    /// The same axis with some room at both ends, for marks that lie on them.
    pub fn with_room(mut self) -> Axis {
        let room = 0.02 * (self.to - self.from);
        (self.from, self.to) = (self.from - room, self.to + room);
        self
    }

    /// Where a value is on this axis; what is below a logarithmic one lies on its foot.
    pub fn place(&self, value: f64) -> f64 {
        match self.log {
            true if value > 0.0 => value.log10().clamp(self.from, self.to),
            true => self.from,
            false => value,
        }
    }

    /// The text at a tick.
    pub fn text(&self, tick: f64) -> String {
        if self.log {
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
    fn ticks_are_round_and_inside() {
        let axis = Axis::linear("t, ms", [0.0, 20.0]);
        assert_eq!(axis.ticks, [0.0, 5.0, 10.0, 15.0, 20.0]);
        assert_eq!(axis.text(5.0), "5");
        let axis = Axis::over("gap, mm", -0.31, 0.29);
        assert!(axis.ticks.iter().all(|&tick| (-0.31..=0.29).contains(&tick)) && axis.ticks.len() >= 3);
        assert_eq!(axis.text(-0.2), "−0.2");
    }

    #[test]
    fn decades_hold_the_values_and_cut_off_the_lowest() {
        let axis = Axis::decades("", [3e-7, 2e-3, 0.0, f64::INFINITY], 12.0);
        assert_eq!((axis.from, axis.to), (-7.0, -2.0));
        assert_eq!(axis.text(-7.0), "10⁻⁷");
        assert_eq!(axis.place(0.0), -7.0);
        let axis = Axis::decades("", [1e-20, 1e-3], 6.0);
        assert_eq!((axis.from, axis.to), (-9.0, -3.0));
    }
}
