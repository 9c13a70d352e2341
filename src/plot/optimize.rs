//! The designs of an optimisation by their objectives, and the best of them.

use std::collections::HashSet;

use super::axis::Axis;
use super::canvas::{Area, Entry, HEAD, LEGEND, Mark, WIDTH, fitted, frame, legend, line, picture, point, points};
use super::svg::{Pixel, Svg};
use super::theme::{BLUE, GREEN, ORANGE, SOFT};
use crate::study::optimize::{Design, Found, Optimisation};
use crate::wording::Quantity;

const PANEL: f64 = 480.0;
/// Pixels between marks of designs that are not on the front.
const APART: f64 = 5.0;

/// What is drawn of a design on a panel.
type Place<'a> = dyn Fn(&Design) -> Option<(f64, f64)> + 'a;

/// The picture. Of several objectives the first is compared with each of the others; of one, every design is shown in the order in which it
/// was looked at. Designs that miss a constraint are not shown, except the start. Where it is `linked`, the front's leads to `#design-N`.
pub fn optimisation(of: &Optimisation, found: &Found, linked: bool) -> String {
    let quantities: Vec<Quantity> =
        of.objectives.iter().map(|of| Quantity::new(&of.figure.name, &of.figure.holds)).collect();
    let value = |design: &Design, at: usize| Some(design.judged.values[at]? * quantities[at].scale);
    let panels = (of.objectives.len() - 1).max(1);
    let title = format!("{}: the designs that meet all constraints", of.name());
    picture(&title, HEAD + panels as f64 * PANEL, |svg| {
        for panel in 0..panels {
            let (place, labels): (Box<Place>, [String; 2]) = match &quantities[..] {
                [one] => (
                    Box::new(|design| Some((design.number as f64, value(design, 0)?))),
                    ["design, in the order they were looked at".to_string(), one.label()],
                ),
                all => (
                    Box::new(move |design| Some((value(design, 0)?, value(design, panel + 1)?))),
                    [all[0].label(), all[panel + 1].label()],
                ),
            };
            let top = [0.0, PANEL * panel as f64];
            svg.moved(top, |svg| {
                let front = draw(svg, of, found, &*place, labels);
                for (number, at) in front.into_iter().filter(|_| linked) {
                    svg.link(&format!("#design-{number}"), &format!("design {number}"), at, 9.0);
                }
            });
        }
    })
}

/// One panel; the members of the front and where they are on it.
fn draw(svg: &mut Svg, of: &Optimisation, found: &Found, place: &Place, labels: [String; 2]) -> Vec<(u64, Pixel)> {
    let front: Vec<&Design> = found.front.iter().map(|&index| &found.designs[index]).collect();
    let feasible = found.designs.iter().filter(|design| design.is_feasible());
    let all: Vec<(f64, f64)> = feasible.filter_map(place).collect();
    let start = place(found.start());
    // What lies far off would press the front into a corner: the range is that of the front and the start, and half of it more.
    let shown = || front.iter().filter_map(|design| place(design)).chain(start);
    let several = of.objectives.len() > 1;
    let x = axis(&labels[0], shown().map(|at| at.0), all.iter().map(|at| at.0), several);
    let y = axis(&labels[1], shown().map(|at| at.1), all.iter().map(|at| at.1), true);
    let within = |at: &(f64, f64)| (x.from..=x.to).contains(&at.0) && (y.from..=y.to).contains(&at.1);
    let on = frame(svg, Area { left: 0.0, top: 0.0, width: WIDTH - LEGEND, height: PANEL }, &x, &y, true);
    // Of thousands no more can be seen than one mark on so many pixels, which is less than a mark is wide.
    let mut marked = HashSet::new();
    let mut is_fresh = |at: (f64, f64)| marked.insert(on.pixel(at).map(|pixels| (pixels / APART) as i64));
    let fresh = all.iter().copied().filter(|at| within(at) && is_fresh(*at));
    points(svg, &on, fresh, Mark::SmallDot, SOFT);
    let numbered: Vec<(u64, (f64, f64))> =
        front.iter().filter_map(|design| Some((design.number, place(design)?))).collect();
    if of.objectives.len() == 2 && numbered.len() > 1 {
        let mut path: Vec<(f64, f64)> = numbered.iter().map(|(_, at)| *at).collect();
        path.sort_by(|a, b| a.0.total_cmp(&b.0));
        line(svg, &on, path, Mark::Pale { width: 2.0 }, BLUE);
    }
    points(svg, &on, numbered.iter().map(|(_, at)| *at), Mark::Circle, BLUE);
    let out = found.designs.len() > found.feasible();
    let mut entries = vec![Entry::new(Mark::Circle, BLUE, if several { "front" } else { "best" })];
    entries.push(Entry::new(Mark::SmallDot, SOFT, "other designs"));
    if let Some(at) = start {
        point(svg, &on, at, Mark::Triangle, ORANGE);
        let text = if found.start().is_feasible() { "start" } else { "start, misses a constraint" };
        entries.push(Entry::new(Mark::Triangle, ORANGE, text));
    }
    if let Some(at) = found.compromise().and_then(|index| place(&found.designs[index])) {
        point(svg, &on, at, Mark::Ring, GREEN);
        entries.push(Entry::new(Mark::Ring, GREEN, "compromise"));
    }
    legend(svg, [WIDTH - LEGEND, 0.0], LEGEND, &entries);
    let mut notes = Vec::new();
    if out {
        notes.push(format!("{} miss a constraint", found.designs.len() - found.feasible()));
    }
    let beyond = all.iter().filter(|at| !within(at)).count();
    if beyond > 0 {
        notes.push(format!("{beyond} lie outside the picture"));
    }
    for (index, note) in notes.iter().enumerate() {
        let at = [WIDTH - LEGEND + 10.0, 40.0 + 24.0 * (entries.len() + index) as f64];
        fitted(svg, note, at, 13.0, LEGEND - 16.0);
    }
    numbered.into_iter().map(|(number, at)| (number, on.pixel(at))).collect()
}

/// An axis over what has to be seen, and as much of the others as is near.
fn axis(label: &str, shown: impl Iterator<Item = f64>, all: impl Iterator<Item = f64>, near: bool) -> Axis {
    let shown: Vec<f64> = shown.collect();
    let (low, high) =
        shown.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), of| (low.min(*of), high.max(*of)));
    let room = if high > low { 0.5 * (high - low) } else { 0.2 * low.abs() };
    let others = all.filter(|of| !near || (low - room..=high + room).contains(of));
    let others: Vec<f64> = others.collect();
    Axis::linear(label, shown.into_iter().chain(others)).with_room()
}
