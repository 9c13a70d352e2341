//! A horizontal strip of cells, one for each design, for any number of designs.

use crate::plot::canvas::tiles;
use crate::plot::svg::{Paint, Pixel, Svg};
use crate::plot::theme::{Colour, SOFT};

/// Draws adjacent cells in a rectangle, each in the colour of its index in the palette.
///
/// With more cells than pixels, a column of pixels shows the shares of its cells, stacked in the order of the palette.
pub(crate) fn strip(svg: &mut Svg, [[left, top], [right, bottom]]: [Pixel; 2], cells: &[usize], palette: &[Colour]) {
    if cells.is_empty() || right <= left {
        return;
    }
    let columns = cells.len().min((right - left) as usize);
    let shares = |column: usize| {
        let column_cells = &cells[column * cells.len() / columns..(column + 1) * cells.len() / columns];
        let ends = (0..palette.len()).map(|colour| {
            let up_to = column_cells.iter().filter(|&&cell| cell <= colour).count();
            top + ((bottom - top) * up_to as f64 / column_cells.len() as f64).round()
        });
        ends.collect::<Vec<f64>>()
    };
    let all: Vec<Vec<f64>> = (0..columns).map(shares).collect();
    let edge = |column: usize| left + (right - left) * column as f64 / columns as f64;
    let (mut tiles_to_draw, mut from) = (Vec::new(), 0);
    // Equal adjacent columns are drawn as one.
    for alike in all.chunk_by(|a, b| a == b) {
        let (start, end) = (edge(from), edge(from + alike.len()));
        let mut above = top;
        for (&below, &colour) in alike[0].iter().zip(palette) {
            if below > above {
                tiles_to_draw.push(([[start, above], [end, below]], colour));
            }
            above = below;
        }
        from += alike.len();
    }
    tiles(svg, tiles_to_draw);
    svg.polyline(&[[left, bottom], [right, bottom]], Paint::line(SOFT, 1.0));
}
