//! A band of cells in a row, one for each design, however many there are; and keys for their colours.

use plotters::style::RGBColor;

use crate::plot::canvas::{Area, BLACK, DrawError, GREY, Pixel, line_between, tile, tile_plain, words_from};

/// Colours of cells beside those of the canvas. Lightness alone keeps them apart too.
pub const PALE_BLUE: RGBColor = RGBColor(178, 211, 233);
pub const NEUTRAL: RGBColor = RGBColor(216, 216, 216);

/// Width of a letter of a text of size 1, a little generous.
const LETTER: f64 = 0.56;

/// Draws cells side by side from one corner to the other, each in the colour of its number.
///
/// With more cells than pixels a column of pixels shows the shares of its cells, one above the other, in the order of the
/// palette.
pub fn strip(
    area: &Area,
    [(left, top), (right, bottom)]: [Pixel; 2],
    cells: &[usize],
    palette: &[RGBColor],
) -> Result<(), DrawError> {
    if cells.is_empty() || right <= left {
        return Ok(());
    }
    let columns = cells.len().min((right - left) as usize);
    let shares = |column: usize| {
        let of = &cells[column * cells.len() / columns..(column + 1) * cells.len() / columns];
        let ends = (0..palette.len()).map(|colour| {
            let up_to = of.iter().filter(|&&cell| cell <= colour).count();
            top + ((bottom - top) as f64 * up_to as f64 / of.len() as f64).round() as i32
        });
        ends.collect::<Vec<i32>>()
    };
    let all: Vec<Vec<i32>> = (0..columns).map(shares).collect();
    let edge = |column: usize| left + ((right - left) as usize * column / columns) as i32;
    let mut from = 0;
    // Columns that look the same are one.
    for alike in all.chunk_by(|a, b| a == b) {
        let (start, end) = (edge(from), edge(from + alike.len()));
        let mut above = top;
        for (&below, &colour) in alike[0].iter().zip(palette) {
            if below > above {
                tile_plain(area, [(start, above), (end, below)], colour)?;
            }
            above = below;
        }
        from += alike.len();
    }
    let (low, high) = ((left, bottom), (right, bottom));
    line_between(area, [low, high], GREY)
}

/// Colours with their words, side by side, in as many lines as it takes.
pub fn key(area: &Area, entries: &[(RGBColor, &str)], size: u32) -> Result<(), DrawError> {
    let width = area.dim_in_pixel().0 as i32;
    let (mut x, mut y) = (16, 14);
    for (colour, text) in entries {
        let long = 30 + text_width(text, size) + 20;
        if x + long > width && x > 16 {
            (x, y) = (16, y + 24);
        }
        tile(area, [(x, y - 8), (x + 22, y + 8)], *colour, GREY)?;
        words_from(area, text, (x + 30, y), size, BLACK)?;
        x += long;
    }
    Ok(())
}

/// About how wide a text is, in pixels.
pub fn text_width(text: &str, size: u32) -> i32 {
    (text.chars().count() as f64 * LETTER * f64::from(size)).ceil() as i32
}

/// A text that is no wider than that, with an ellipsis where something is left out.
pub fn shortened(text: &str, size: u32, width: i32) -> String {
    let most = (f64::from(width) / (LETTER * f64::from(size))) as usize;
    if text.chars().count() <= most {
        return text.to_string();
    }
    let start: String = text.chars().take(most.saturating_sub(1)).collect();
    format!("{}…", start.trim_end())
}
