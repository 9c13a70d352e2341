//! Charts described by their series: curves and markers with their legend, in one frame or in stacked panels. Logarithmic
//! axes are linear in the exponent, so that the same frame serves both kinds.

use super::canvas::{
    LEGEND_WIDTH, LegendEntry, Marker, THIN_LINE, TITLE_HEIGHT, WIDTH, centred_style, fitting_size, horizontal_legend,
    legend, markers, picture, text_centred, text_left_of, text_right_of,
};
use super::svg::{Paint, Path, Pixel, Svg, TEXT_SIZE, TextStyle};
use super::theme::{Colour, FAINT, INK, LINE, SOFT};

/// Coordinates (x, y) of a point in a frame.
pub type PlotPoint = (f64, f64);

/// Height of the tick labels and the axis label below a frame.
const AXIS_HEIGHT: f64 = 50.0;
/// Margin below a frame without axis labels.
const BOTTOM_MARGIN: f64 = 12.0;
const LEFT_MARGIN: f64 = 86.0;
const TOP_MARGIN: f64 = 8.0;
const RIGHT_MARGIN: f64 = 12.0;
/// Height of a legend above stacked panels.
const TOP_LEGEND_HEIGHT: f64 = 34.0;

/// An axis: a label with the unit, a range, and ticks. Range and ticks are in plotted coordinates.
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

    /// Creates a logarithmic axis over all positive values, in whole decades. If there are more than `decades` decades,
    /// the lowest ones are cut off.
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

    /// Returns this axis with a margin at both ends, so that markers at the ends are visible.
    pub fn with_margin(mut self) -> Axis {
        let margin = 0.02 * (self.to - self.from);
        (self.from, self.to) = (self.from - margin, self.to + margin);
        self
    }

    /// Coordinate of a value on this axis. On a logarithmic axis, values outside the range are clamped to it.
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
    let digit = |c: char| c.to_digit(10).and_then(|digit| "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().nth(digit as usize));
    exponent.to_string().chars().map(|c| digit(c).unwrap_or('⁻')).collect()
}

/// Number of columns in which a decimated line retains its ends and extremes.
const COLUMNS: usize = 1200;

/// A curve, or a set of equal markers, in the units of the axes.
pub struct Series {
    pub marker: Marker,
    pub colour: Colour,
    pub points: Vec<PlotPoint>,
    /// Text in the legend.
    pub name: Option<String>,
}

impl Series {
    /// Creates a series of points without an entry in the legend.
    pub fn new(marker: Marker, colour: Colour, points: impl IntoIterator<Item = PlotPoint>) -> Series {
        Series { marker, colour, points: points.into_iter().collect(), name: None }
    }

    /// Creates an entry of the legend without points.
    pub fn key(marker: Marker, colour: Colour, name: impl Into<String>) -> Series {
        Series::new(marker, colour, []).named(name)
    }

    /// Creates a curve from points (time in s, value). The curve is drawn over the time in ms, with the resolution of a
    /// picture.
    pub fn over_time(marker: Marker, colour: Colour, points: impl Iterator<Item = PlotPoint>) -> Series {
        let finite = points.filter(|(_, value)| value.is_finite());
        Series::new(marker, colour, decimate(finite.map(|(time_s, value)| (time_s * 1e3, value)).collect()))
    }

    /// Creates a thin line over the whole height of the frame.
    pub fn vertical(colour: Colour, x: f64) -> Series {
        Series::new(THIN_LINE, colour, [(x, f64::NEG_INFINITY), (x, f64::INFINITY)])
    }

    /// Creates a line over the whole width of the frame.
    pub fn horizontal(marker: Marker, colour: Colour, y: f64) -> Series {
        Series::new(marker, colour, [(f64::NEG_INFINITY, y), (f64::INFINITY, y)])
    }

    /// Returns the series with an entry in the legend.
    pub fn named(self, name: impl Into<String>) -> Series {
        Series { name: Some(name.into()), ..self }
    }
}

/// Pixel of a point in an area (left, top, width, height); coordinates beyond an axis are clamped to its end.
fn pixel([left, top, width, height]: [f64; 4], [x_axis, y_axis]: [&Axis; 2], (x, y): PlotPoint) -> Pixel {
    let fraction = |axis: &Axis, value: f64| ((value - axis.from) / (axis.to - axis.from)).clamp(0.0, 1.0);
    [left + width * fraction(x_axis, x), top + height * (1.0 - fraction(y_axis, y))]
}

/// Draws a frame with its axes and series, and the legend of the series to the right of `width`. `has_labels` states
/// whether the horizontal axis has labels. Series with the same name share one entry of the legend.
fn draw(svg: &mut Svg, top: f64, [width, height]: [f64; 2], x: &Axis, y: &Axis, has_labels: bool, series: &[Series]) {
    let below = if has_labels { AXIS_HEIGHT } else { BOTTOM_MARGIN };
    let frame_height = height - TOP_MARGIN - below;
    let area = [LEFT_MARGIN, top + TOP_MARGIN, width - LEFT_MARGIN - RIGHT_MARGIN, frame_height];
    let pixel = |point: PlotPoint| pixel(area, [x, y], point);
    let vertical = |coordinate: f64| [pixel((coordinate, y.from)), pixel((coordinate, y.to))];
    let horizontal = |coordinate: f64| [pixel((x.from, coordinate)), pixel((x.to, coordinate))];
    for (colour, across, above) in [(FAINT, &x.minor_ticks, &y.minor_ticks), (LINE, &x.ticks, &y.ticks)] {
        let lines = across.iter().copied().map(vertical).chain(above.iter().copied().map(horizontal));
        svg.path(&lines.fold(Path::default(), |path, ends| path.with_polyline(&ends)), Paint::line(colour, 1.0));
    }
    let [corner, end] = horizontal(y.from);
    let mut axes = Path::default().with_polyline(&[pixel((x.from, y.to)), corner, end]);
    for [[left, middle], _] in y.ticks.iter().map(|tick| horizontal(*tick)) {
        axes = axes.with_polyline(&[[left - 5.0, middle], [left, middle]]);
    }
    for [[middle, bottom], _] in x.ticks.iter().map(|tick| vertical(*tick)) {
        axes = axes.with_polyline(&[[middle, bottom], [middle, bottom + 5.0]]);
    }
    svg.path(&axes, Paint::line(SOFT, 1.0));
    for tick in &y.ticks {
        let [left, middle] = horizontal(*tick)[0];
        text_left_of(svg, &y.tick_label(*tick), [left - 9.0, middle], TEXT_SIZE, INK);
    }
    let size = fitting_size(&y.label, TEXT_SIZE, height - 8.0);
    let style = TextStyle { is_vertical: true, ..centred_style(size, INK) };
    svg.text(&y.label, [16.0, area[1] + 0.5 * frame_height], style);
    if has_labels {
        for tick in &x.ticks {
            let [middle, bottom] = vertical(*tick)[0];
            text_centred(svg, &x.tick_label(*tick), [middle, bottom + 15.0], TEXT_SIZE, INK);
        }
        let size = fitting_size(&x.label, TEXT_SIZE, area[2]);
        text_centred(svg, &x.label, [LEFT_MARGIN + 0.5 * area[2], corner[1] + 38.0], size, INK);
    }
    let mut entries: Vec<LegendEntry> = Vec::new();
    for Series { marker, colour, points, name } in series {
        if !points.is_empty() {
            let pixels = points.iter().map(|point| pixel((x.coordinate(point.0), y.coordinate(point.1))));
            markers(svg, &pixels.collect::<Vec<_>>(), *marker, *colour);
        }
        if let Some(name) = name.as_ref().filter(|name| !entries.iter().any(|(.., text)| text == *name)) {
            entries.push((*marker, *colour, name.clone()));
        }
    }
    legend(svg, [width, top], LEGEND_WIDTH, &entries);
}

/// Draws a picture of a single frame, with the legend of its series.
pub fn series_chart(title: &str, height: f64, x: &Axis, y: &Axis, series: &[Series]) -> String {
    picture(title, height, |svg| draw(svg, 0.0, [WIDTH - LEGEND_WIDTH, height - TITLE_HEIGHT], x, y, true, series))
}

/// One of several stacked panels.
pub struct Panel {
    /// Text above the panel.
    pub heading: Option<String>,
    pub y: Axis,
    pub series: Vec<Series>,
}

/// Draws a picture of stacked panels with a common horizontal axis, whose labels are below the last panel. `heights`
/// are the height of a heading, and that of a panel without axis labels. `common` is the legend of all panels, at the
/// top; named series have a legend to the right of their panel.
pub fn panel_chart(title: &str, x: &Axis, heights: [f64; 2], common: &[LegendEntry], panels: &[Panel]) -> String {
    let [heading, panel_height] = heights;
    let above = if common.is_empty() { 0.0 } else { TOP_LEGEND_HEIGHT };
    let has_legends = panels.iter().any(|panel| panel.series.iter().any(|series| series.name.is_some()));
    let width = if has_legends { WIDTH - LEGEND_WIDTH } else { WIDTH };
    let height = above + (heading + panel_height) * panels.len() as f64 + AXIS_HEIGHT;
    picture(title, TITLE_HEIGHT + height, |svg| {
        horizontal_legend(svg, common);
        for (index, panel) in panels.iter().enumerate() {
            let is_last = index + 1 == panels.len();
            let top = above + (heading + panel_height) * index as f64 + heading;
            if let Some(text) = &panel.heading {
                text_right_of(svg, text, [LEFT_MARGIN, top - 0.5 * heading + 2.0], 15.0, INK);
            }
            let height = panel_height + if is_last { AXIS_HEIGHT } else { 0.0 };
            draw(svg, top, [width, height], x, &panel.y, is_last, &panel.series);
        }
    })
}

/// Retains the first, lowest, highest and last point of every column; `points` must be sorted by x.
fn decimate(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let (Some(&(from, _)), Some(&(to, _))) = (points.first(), points.last()) else { return points };
    if points.len() <= 4 * COLUMNS || to <= from {
        return points;
    }
    let column = |x: f64| ((x - from) / (to - from) * COLUMNS as f64) as usize;
    let mut decimated = Vec::with_capacity(4 * COLUMNS);
    for group in points.chunk_by(|a, b| column(a.0) == column(b.0)) {
        let low = (0..group.len()).min_by(|&a, &b| group[a].1.total_cmp(&group[b].1)).unwrap_or(0);
        let high = (0..group.len()).max_by(|&a, &b| group[a].1.total_cmp(&group[b].1)).unwrap_or(0);
        let mut chosen = [0, low.min(high), low.max(high), group.len() - 1].to_vec();
        chosen.dedup();
        decimated.extend(chosen.into_iter().map(|index| group[index]));
    }
    decimated
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

    #[test]
    fn points_beyond_an_axis_are_clamped_to_its_end() {
        let axis = Axis::from_range("", 0.0, 1.0);
        let pixel = |point| pixel([10.0, 20.0, 100.0, 50.0], [&axis, &axis], point);
        assert_eq!([(0.5, 0.5), (2.0, -1.0)].map(pixel), [[60.0, 45.0], [110.0, 70.0]]);
    }

    #[test]
    fn decimation_retains_ends_and_spikes() {
        let mut points: Vec<(f64, f64)> = (0..100_000).map(|k| (f64::from(k), 1.0)).collect();
        points[54_321].1 = 7.0;
        points[54_325].1 = -7.0;
        let decimated_points = decimate(points.clone());
        assert!(decimated_points.len() <= 4 * COLUMNS + 4);
        assert_eq!((decimated_points[0], decimated_points[decimated_points.len() - 1]), (points[0], points[99_999]));
        assert!(decimated_points.contains(&points[54_321]) && decimated_points.contains(&points[54_325]));
        assert!(decimated_points.is_sorted_by(|a, b| a.0 <= b.0));
    }
}
