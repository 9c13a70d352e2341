//! The designs of an optimisation by their objectives, and the best of them.

use std::collections::HashSet;

use super::axis::Axis;
use super::canvas::{
    BLACK, BLUE, DrawError, Entry, Frame, GREEN, GREY, LEGEND, Mark, ORANGE, WIDTH, frame, legend, line, picture,
    point, titled,
};
use crate::study::optimize::{Design, Found, Optimisation};
use crate::wording::Quantity;

const HEAD: u32 = 40;
const PANEL: u32 = 480;

/// A picture and where members of the front are on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Designs {
    pub svg: String,
    /// Number of the design, and its place in pixels; once for each panel.
    pub places: Vec<(u64, (i32, i32))>,
}

/// What is drawn of a design on a panel.
type Place<'a> = dyn Fn(&Design) -> Option<(f64, f64)> + 'a;

/// The picture. Of several objectives the first is compared with each of the others; of one, every design is shown in the order in which it
/// was looked at. Designs that miss a constraint are not shown, except the start.
pub fn optimisation(of: &Optimisation, found: &Found) -> Result<Designs, DrawError> {
    let quantities: Vec<Quantity> = of.objectives.iter().map(|of| Quantity::of(&of.figure.name)).collect();
    let value = |design: &Design, at: usize| Some(design.judged.values[at]? * quantities[at].scale);
    let mut places = Vec::new();
    let panels = (of.objectives.len() - 1).max(1) as u32;
    let svg = picture(HEAD + panels * PANEL, |area| {
        let mut rest = titled(area, &format!("{}: the designs that meet all constraints", of.name()))?;
        for panel in 0..panels as usize {
            let (body, below) = rest.split_vertically(PANEL);
            rest = below;
            let (left, right) = body.split_horizontally(WIDTH - LEGEND - 30);
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
            draw(&left, &right, of, found, &*place, labels, &mut places)?;
        }
        Ok(())
    })?;
    Ok(Designs { svg, places })
}

fn draw(
    left: &super::canvas::Area,
    right: &super::canvas::Area,
    of: &Optimisation,
    found: &Found,
    place: &Place,
    labels: [String; 2],
    places: &mut Vec<(u64, (i32, i32))>,
) -> Result<(), DrawError> {
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
    let mut chart = frame(left, &x, &y, true)?;
    // One mark a pixel is all that can be seen of thousands.
    let mut marked = HashSet::new();
    let fresh: Vec<&(f64, f64)> =
        all.iter().filter(|at| within(at)).filter(|at| marked.insert(pixel(&chart, **at))).collect();
    for &at in fresh {
        point(&mut chart, at, if all.len() > 5000 { Mark::Speck } else { Mark::SmallDot }, GREY)?;
    }
    if several {
        let mut path: Vec<(f64, f64)> = front.iter().filter_map(|design| place(design)).collect();
        path.sort_by(|a, b| a.0.total_cmp(&b.0));
        if of.objectives.len() == 2 && path.len() > 1 {
            line(&mut chart, path, Mark::Pale { width: 2 }, BLUE)?;
        }
    }
    for design in &front {
        if let Some(at) = place(design) {
            point(&mut chart, at, Mark::Circle, BLUE)?;
            places.push((design.number, pixel(&chart, at)));
        }
    }
    let out = found.designs.len() > found.feasible();
    let mut entries = vec![Entry::new(Mark::Circle, BLUE, if several { "front" } else { "best" })];
    entries.push(Entry::new(Mark::SmallDot, GREY, "other designs"));
    if let Some(at) = start {
        point(&mut chart, at, Mark::Triangle, ORANGE)?;
        let text = if found.start().is_feasible() { "start" } else { "start, misses a constraint" };
        entries.push(Entry::new(Mark::Triangle, ORANGE, text));
    }
    if let Some(at) = found.compromise().and_then(|index| place(&found.designs[index])) {
        point(&mut chart, at, Mark::Ring, GREEN)?;
        entries.push(Entry::new(Mark::Ring, GREEN, "compromise"));
    }
    legend(right, &entries)?;
    let mut notes = Vec::new();
    if out {
        notes.push(format!("{} miss a constraint", found.designs.len() - found.feasible()));
    }
    let beyond = all.iter().filter(|at| !within(at)).count();
    if beyond > 0 {
        notes.push(format!("{beyond} lie outside the picture"));
    }
    for (index, note) in notes.iter().enumerate() {
        let at = (10, 40 + 24 * (entries.len() + index) as i32);
        super::canvas::words_from(right, note, at, 13, BLACK)?;
    }
    Ok(())
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

/// The place of a point in pixels of the picture.
fn pixel(chart: &Frame, at: (f64, f64)) -> (i32, i32) {
    chart.backend_coord(&at)
}
