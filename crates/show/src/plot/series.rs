//! Charts described by their series: curves and markers with their legend, in one frame or in stacked panels.

use super::axis::Axis;
use super::canvas::{
    AXIS_HEIGHT, Area, Frame, LEFT_MARGIN, LEGEND_WIDTH, LegendEntry, Marker, PlotPoint, THIN_LINE, TITLE_HEIGHT,
    WIDTH, frame, legend, markers, picture, text_right_of,
};
use super::svg::Svg;
use super::theme::{Colour, INK};

/// Number of columns in which a decimated line retains its ends and extremes.
const COLUMNS: usize = 1200;

/// A curve, or markers of one kind, in the units of the axes.
pub struct Series {
    pub marker: Marker,
    pub colour: Colour,
    pub points: Vec<PlotPoint>,
    /// Text in the legend.
    pub name: Option<String>,
}

impl Series {
    /// Points without an entry in the legend.
    pub fn new(marker: Marker, colour: Colour, points: impl IntoIterator<Item = PlotPoint>) -> Series {
        Series { marker, colour, points: points.into_iter().collect(), name: None }
    }

    /// An entry of the legend without points.
    pub fn key(marker: Marker, colour: Colour, name: impl Into<String>) -> Series {
        Series::new(marker, colour, []).named(name)
    }

    /// Points (time in s, value), as a curve over the time in ms with the resolution of a picture.
    pub fn over_time(marker: Marker, colour: Colour, points: impl Iterator<Item = PlotPoint>) -> Series {
        let finite = points.filter(|(_, value)| value.is_finite());
        Series::new(marker, colour, decimate(finite.map(|(time_s, value)| (time_s * 1e3, value)).collect()))
    }

    /// A thin line over the whole height of the frame.
    pub fn vertical(colour: Colour, x: f64) -> Series {
        Series::new(THIN_LINE, colour, [(x, f64::NEG_INFINITY), (x, f64::INFINITY)])
    }

    /// A line over the whole width of the frame.
    pub fn horizontal(marker: Marker, colour: Colour, y: f64) -> Series {
        Series::new(marker, colour, [(f64::NEG_INFINITY, y), (f64::INFINITY, y)])
    }

    /// Adds an entry in the legend.
    pub fn named(self, name: impl Into<String>) -> Series {
        Series { name: Some(name.into()), ..self }
    }

    fn draw(&self, svg: &mut Svg, frame: &Frame) {
        let pixel = |&(x, y): &PlotPoint| frame.pixel((frame.x.coordinate(x), frame.y.coordinate(y)));
        markers(svg, &self.points.iter().map(pixel).collect::<Vec<_>>(), self.marker, self.colour);
    }
}

/// Draws all series in a frame and returns their legend; equal names have one entry.
fn draw_all(svg: &mut Svg, frame: &Frame, series: &[Series]) -> Vec<LegendEntry> {
    let mut entries: Vec<LegendEntry> = Vec::new();
    for each in series {
        if !each.points.is_empty() {
            each.draw(svg, frame);
        }
        if let Some(name) = each.name.as_ref().filter(|name| !entries.iter().any(|entry| entry.text == **name)) {
            entries.push(LegendEntry::new(each.marker, each.colour, name));
        }
    }
    entries
}

/// Draws a picture of one frame with the legend of its series.
pub fn series_chart(title: &str, height: f64, x: &Axis, y: &Axis, series: &[Series]) -> String {
    picture(title, height, |svg| {
        let area = Area { left: 0.0, top: 0.0, width: WIDTH - LEGEND_WIDTH, height: height - TITLE_HEIGHT };
        let frame = frame(svg, area, x, y, true);
        let entries = draw_all(svg, &frame, series);
        legend(svg, [WIDTH - LEGEND_WIDTH, 0.0], LEGEND_WIDTH, &entries);
    })
}

/// One of several stacked panels.
pub struct Panel {
    /// Text above the panel.
    pub heading: Option<String>,
    pub y: Axis,
    pub series: Vec<Series>,
}

/// Schema of stacked panels, in pixels.
pub struct Stack {
    /// Height of the area above the panels.
    pub top: f64,
    /// Height of the headings.
    pub heading: f64,
    /// Height of each panel, without axis labels.
    pub panel: f64,
    /// Whether each panel has a legend on its right.
    pub has_legends: bool,
}

impl Stack {
    /// Height of all panels.
    pub fn height(&self, panels: usize) -> f64 {
        self.top + (self.heading + self.panel) * panels as f64 + AXIS_HEIGHT
    }

    /// Draws panels over a common horizontal axis, whose labels are below the last panel.
    pub fn draw(&self, svg: &mut Svg, x: &Axis, panels: &[Panel]) {
        let width = if self.has_legends { WIDTH - LEGEND_WIDTH } else { WIDTH };
        for (index, panel) in panels.iter().enumerate() {
            let is_last = index + 1 == panels.len();
            let top = self.top + (self.heading + self.panel) * index as f64 + self.heading;
            if let Some(heading) = &panel.heading {
                text_right_of(svg, heading, [LEFT_MARGIN, top - 0.5 * self.heading + 2.0], 15.0, INK);
            }
            let height = self.panel + if is_last { AXIS_HEIGHT } else { 0.0 };
            let frame = frame(svg, Area { left: 0.0, top, width, height }, x, &panel.y, is_last);
            let entries = draw_all(svg, &frame, &panel.series);
            if self.has_legends {
                legend(svg, [width, top], LEGEND_WIDTH, &entries);
            }
        }
    }
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
