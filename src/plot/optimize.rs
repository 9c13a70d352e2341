//! The designs of an optimisation by their objectives, and the best designs.

use std::collections::HashSet;

use super::axis::Axis;
use super::canvas::{
    Area, LEGEND_WIDTH, LegendEntry, Marker, TITLE_HEIGHT, WIDTH, fitted_text, frame, legend, line, picture, point,
    points,
};
use super::svg::{Pixel, Svg};
use super::theme::{BLUE, GREEN, ORANGE, SOFT};
use crate::format::Quantity;
use crate::study::optimize::{Design, Optimisation, OptimisationResult};

const PANEL_HEIGHT: f64 = 480.0;
/// Minimum distance in pixels between markers of designs that are not on the front.
const MIN_MARKER_DISTANCE: f64 = 5.0;

/// Coordinates of a design in a panel.
type PanelPosition<'a> = dyn Fn(&Design) -> Option<(f64, f64)> + 'a;

/// Draws the results of an optimisation. With several objectives, the first is plotted against each of the others; with
/// one, designs are plotted in the order of their evaluation. Designs that violate a constraint are omitted, except the
/// start. If `has_links`, designs of the front link to `#design-N`.
pub fn optimisation(study: &Optimisation, found: &OptimisationResult, has_links: bool) -> String {
    let quantities: Vec<Quantity> = study
        .objectives
        .iter()
        .map(|objective| Quantity::new(&objective.figure.name, &objective.figure.column_type))
        .collect();
    let value =
        |design: &Design, objective: usize| Some(design.evaluation.values[objective]? * quantities[objective].scale);
    let panels = (study.objectives.len() - 1).max(1);
    let title = format!("{}: the designs that meet all constraints", study.name());
    picture(&title, TITLE_HEIGHT + panels as f64 * PANEL_HEIGHT, |svg| {
        for panel in 0..panels {
            let (position, labels): (Box<PanelPosition>, [String; 2]) = match &quantities[..] {
                [single] => (
                    Box::new(|design| Some((design.number as f64, value(design, 0)?))),
                    ["design, in the order of evaluation".to_string(), single.label()],
                ),
                all => (
                    Box::new(move |design| Some((value(design, 0)?, value(design, panel + 1)?))),
                    [all[0].label(), all[panel + 1].label()],
                ),
            };
            let top = [0.0, PANEL_HEIGHT * panel as f64];
            svg.translated(top, |svg| {
                let front = draw(svg, study, found, &*position, labels);
                for (number, point_xy) in front.into_iter().filter(|_| has_links) {
                    svg.link(&format!("#design-{number}"), &format!("design {number}"), point_xy, 9.0);
                }
            });
        }
    })
}

/// Draws one panel and returns the members of the front with their pixels.
fn draw(
    svg: &mut Svg,
    study: &Optimisation,
    found: &OptimisationResult,
    position: &PanelPosition,
    labels: [String; 2],
) -> Vec<(u64, Pixel)> {
    let front: Vec<&Design> = found.front.iter().map(|&index| &found.designs[index]).collect();
    let feasible = found.designs.iter().filter(|design| design.is_feasible());
    let all: Vec<(f64, f64)> = feasible.filter_map(position).collect();
    let start = position(found.start());
    // Distant designs would compress the front: the range is that of the front and the start, enlarged by half.
    let visible_points = || front.iter().filter_map(|design| position(design)).chain(start);
    let has_several_objectives = study.objectives.len() > 1;
    let x = axis(
        &labels[0],
        visible_points().map(|point_xy| point_xy.0),
        all.iter().map(|point_xy| point_xy.0),
        has_several_objectives,
    );
    let y = axis(&labels[1], visible_points().map(|point_xy| point_xy.1), all.iter().map(|point_xy| point_xy.1), true);
    let is_in_range =
        |point_xy: &(f64, f64)| (x.from..=x.to).contains(&point_xy.0) && (y.from..=y.to).contains(&point_xy.1);
    let frame =
        frame(svg, Area { left: 0.0, top: 0.0, width: WIDTH - LEGEND_WIDTH, height: PANEL_HEIGHT }, &x, &y, true);
    // More than one marker within this distance, which is less than its width, would not be visible.
    let mut marked = HashSet::new();
    let mut is_visible =
        |point_xy: (f64, f64)| marked.insert(frame.pixel(point_xy).map(|pixels| (pixels / MIN_MARKER_DISTANCE) as i64));
    let visible = all.iter().copied().filter(|point_xy| is_in_range(point_xy) && is_visible(*point_xy));
    points(svg, &frame, visible, Marker::SmallDot, SOFT);
    let numbered: Vec<(u64, (f64, f64))> =
        front.iter().filter_map(|design| Some((design.number, position(design)?))).collect();
    if study.objectives.len() == 2 && numbered.len() > 1 {
        let mut path: Vec<(f64, f64)> = numbered.iter().map(|(_, point_xy)| *point_xy).collect();
        path.sort_by(|a, b| a.0.total_cmp(&b.0));
        line(svg, &frame, path, Marker::FaintLine { width: 2.0 }, BLUE);
    }
    points(svg, &frame, numbered.iter().map(|(_, point_xy)| *point_xy), Marker::Circle, BLUE);
    let has_infeasible = found.designs.len() > found.feasible_count();
    let mut entries =
        vec![LegendEntry::new(Marker::Circle, BLUE, if has_several_objectives { "front" } else { "best" })];
    entries.push(LegendEntry::new(Marker::SmallDot, SOFT, "other designs"));
    if let Some(point_xy) = start {
        point(svg, &frame, point_xy, Marker::Triangle, ORANGE);
        let text = if found.start().is_feasible() { "start" } else { "start, violates a constraint" };
        entries.push(LegendEntry::new(Marker::Triangle, ORANGE, text));
    }
    if let Some(point_xy) = found.compromise().and_then(|index| position(&found.designs[index])) {
        point(svg, &frame, point_xy, Marker::Ring, GREEN);
        entries.push(LegendEntry::new(Marker::Ring, GREEN, "compromise"));
    }
    legend(svg, [WIDTH - LEGEND_WIDTH, 0.0], LEGEND_WIDTH, &entries);
    let mut notes = Vec::new();
    if has_infeasible {
        notes.push(format!("{} violate a constraint", found.designs.len() - found.feasible_count()));
    }
    let outside_count = all.iter().filter(|point_xy| !is_in_range(point_xy)).count();
    if outside_count > 0 {
        notes.push(format!("{outside_count} lie outside the picture"));
    }
    for (index, note) in notes.iter().enumerate() {
        let point_xy = [WIDTH - LEGEND_WIDTH + 10.0, 40.0 + 24.0 * (entries.len() + index) as f64];
        fitted_text(svg, note, point_xy, 13.0, LEGEND_WIDTH - 16.0);
    }
    numbered.into_iter().map(|(number, point_xy)| (number, frame.pixel(point_xy))).collect()
}

/// Creates an axis over the values that must be visible, and over other values near them.
fn axis(
    label: &str,
    visible_points: impl Iterator<Item = f64>,
    all: impl Iterator<Item = f64>,
    is_limited: bool,
) -> Axis {
    let visible_points: Vec<f64> = visible_points.collect();
    let (low, high) = visible_points
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)));
    let margin = if high > low { 0.5 * (high - low) } else { 0.2 * low.abs() };
    let others = all.filter(|value| !is_limited || (low - margin..=high + margin).contains(value));
    let others: Vec<f64> = others.collect();
    Axis::linear(label, visible_points.into_iter().chain(others)).with_margin()
}
