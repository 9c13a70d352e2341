//! Maps of a study over two of its axes: the verdict of every run, and one figure. A third axis gives panels side by side.

use super::canvas::{
    TITLE_HEIGHT, WIDTH, colour_key, picture, text_centred, text_left_of, text_right_of, tiles, truncated,
};
use super::svg::{Paint, Pixel, Svg};
use super::theme::{
    BLUE, BROKEN, Colour, DOUBTFUL, FINE, INK, NEUTRAL, PALE_BLUE, PAPER, PURPLE, SOFT, Scale, VERDICTS,
};
use crate::criteria::{Class, Fate};
use crate::study::quantity::ColumnFormat;
use crate::study::sweep::{FieldType, Study, result_type};
use crate::table::{Table, Value};

const LEFT: f64 = 96.0;
const GAP: f64 = 18.0;
const PANEL_HEIGHT: f64 = 250.0;
/// Height of the text above a panel, and of the labels below it.
const HEADING: f64 = 24.0;
const LABELS: f64 = 46.0;
const KEY_HEIGHT: f64 = 34.0;
const TEXT_SIZE: f64 = 14.0;
const SMALL_TEXT_SIZE: f64 = 12.0;

/// Largest number of panels side by side, and the number of labels of an axis.
const MAX_PANELS: usize = 8;
const MAX_LABELS: usize = 8;
/// Steps of the key of a figure.
const KEY_STEPS: usize = 5;

/// Colours of fates, in the order of their names.
const FATES: [Colour; Fate::NAMES.len()] = [BLUE, PALE_BLUE, FINE, DOUBTFUL, BROKEN, PURPLE, NEUTRAL];

/// A column with the values that it takes, in order.
struct MapAxis {
    format: ColumnFormat,
    cells: Vec<usize>,
    values: Vec<Value>,
}

impl MapAxis {
    fn new(table: &Table, column: &str, field_type: &FieldType) -> Option<Self> {
        let index = table.columns.iter().position(|known| known.name == column)?;
        let mut values: Vec<Value> = Vec::new();
        for row in &table.rows {
            if !values.contains(&row[index]) {
                values.push(row[index].clone());
            }
        }
        if values.iter().all(|value| value.as_number().is_some()) {
            let number = |value: &Value| value.as_number().unwrap_or_default();
            values.sort_by(|a, b| number(a).total_cmp(&number(b)));
        }
        let cell = |row: &Vec<Value>| values.iter().position(|value| *value == row[index]).unwrap_or(0);
        let cells = table.rows.iter().map(cell).collect();
        Some(MapAxis { format: ColumnFormat::new(column, field_type), cells, values })
    }

    fn len(&self) -> usize {
        self.values.len()
    }

    fn text(&self, index: usize) -> String {
        self.format.value(&self.values[index], 4)
    }
}

/// Draws two maps over the axes of a study: the verdicts, and a figure. The figure is the margin of a grasp, or else
/// the time to stability.
///
/// # Errors
/// Returns the reason why the study has no map.
pub fn map(study: &Study, table: &Table) -> Result<String, String> {
    if study.is_sampled() {
        return Err("a map needs axes with `values` or `count`, but [sample] takes points between them".to_string());
    }
    let axes = study.axis_fields().filter_map(|field| MapAxis::new(table, &field.column(), &field.field_type));
    let axes: Vec<MapAxis> = axes.filter(|axis| axis.len() > 1).collect();
    let (x, y, panel) = match &axes[..] {
        [x, y] => (x, y, None),
        [x, y, panel] if panel.len() <= MAX_PANELS => (x, y, Some(panel)),
        [_, _, panel] => {
            return Err(format!(
                "a map has at most {MAX_PANELS} panels, but the third axis has {} values; make it the first axis, or take \
                 fewer values",
                panel.len()
            ));
        }
        other => {
            return Err(format!(
                "a map needs two axes with several values, and at most a third one for its panels, but the study has {}",
                other.len()
            ));
        }
    };
    let has = |name: &str| table.columns.iter().any(|column| column.name == name);
    let Some(verdict) = ["fate", "grasp", "class"].into_iter().find(|name| has(name)) else {
        return Err("the results have no fate and no class; a map shows them".to_string());
    };
    let figure = ["margin_m_s2", "tts_s"].into_iter().find(|name| has(name));
    let verdicts = table.texts(verdict).map_err(|error| error.to_string())?;
    let status = table.texts("status").map_err(|error| error.to_string())?;
    let palette: Vec<(&str, Colour)> = match verdict {
        "class" => Class::ALL.map(Class::name).into_iter().zip(VERDICTS).collect(),
        _ => Fate::NAMES.into_iter().zip(FATES).collect(),
    };
    let colours: Vec<Colour> = verdicts
        .iter()
        .map(|name| palette.iter().find(|(known, _)| Some(*known) == *name).map_or(PAPER, |(_, colour)| *colour))
        .collect();
    let used = |(_, colour): &&(&str, Colour)| colours.contains(colour);
    let mut key: Vec<(Colour, &str)> = palette.iter().filter(used).map(|(name, colour)| (*colour, *name)).collect();
    if colours.contains(&PAPER) {
        let is_complete = status.iter().all(|status| *status == Some("completed"));
        key.push((PAPER, if is_complete { "no verdict" } else { "not completed" }));
    }
    let numbers = figure.map(|name| table.numbers(name)).transpose().map_err(|error| error.to_string())?;
    let panels = panel.map_or(1, MapAxis::len);
    let row_height = HEADING + PANEL_HEIGHT + LABELS + KEY_HEIGHT;
    let rows = 1 + usize::from(numbers.is_some());
    let grid = Grid { x, y, panel, panels };
    Ok(picture(&format!("{}: {verdict}", study.name), TITLE_HEIGHT + row_height * rows as f64, |svg| {
        grid.draw(svg, 0.0, &colours);
        colour_key(svg, [LEFT, row_height - 0.5 * KEY_HEIGHT], key, TEXT_SIZE);
        let Some((figure, numbers)) = figure.zip(numbers) else { return };
        let finite = || numbers.iter().flatten().copied().filter(|value| value.is_finite());
        let scale = Scale::from_values(finite(), false);
        let [from, to] = scale.range();
        // An infinite margin has the colour of the largest.
        let colour = |value: &Option<f64>| value.map_or(PAPER, |value| scale.colour(value.clamp(from, to)));
        grid.draw(svg, row_height, &numbers.iter().map(colour).collect::<Vec<_>>());
        let format = ColumnFormat::new(figure, &result_type(figure));
        let steps = (0..=KEY_STEPS).map(|step| from + (to - from) * step as f64 / KEY_STEPS as f64);
        let mut texts: Vec<(Colour, String)> =
            steps.map(|value| (scale.colour(value), format.number(value, 3))).collect();
        if let Some((_, first)) = texts.first_mut() {
            *first = format!("{}: {first}", format.label());
        }
        if numbers.iter().any(Option::is_none) {
            texts.push((PAPER, "none".to_string()));
        }
        let key = texts.iter().map(|(colour, text)| (*colour, text.as_str()));
        colour_key(svg, [LEFT, 2.0 * row_height - 0.5 * KEY_HEIGHT], key, TEXT_SIZE);
    }))
}

/// The cells of a map.
struct Grid<'a> {
    x: &'a MapAxis,
    y: &'a MapAxis,
    panel: Option<&'a MapAxis>,
    panels: usize,
}

impl Grid<'_> {
    /// Draws all panels with the colour of every row.
    fn draw(&self, svg: &mut Svg, top: f64, colours: &[Colour]) {
        let width = (WIDTH - LEFT - GAP * self.panels as f64) / self.panels as f64;
        let above = top + HEADING;
        let cell_size = [width / self.x.len() as f64, PANEL_HEIGHT / self.y.len() as f64];
        for index in 0..self.panels {
            let left = LEFT + (width + GAP) * index as f64;
            let corner = |[column, row]: [usize; 2]| -> Pixel {
                [left + cell_size[0] * column as f64, above + PANEL_HEIGHT - cell_size[1] * row as f64]
            };
            let rows = (0..colours.len()).filter(|row| self.panel.is_none_or(|panel| panel.cells[*row] == index));
            let tile = |row: usize| {
                let [column, line] = [self.x.cells[row], self.y.cells[row]];
                let ([left, bottom], [right, top]) = (corner([column, line]), corner([column + 1, line + 1]));
                ([[left, top], [right, bottom]], colours[row])
            };
            tiles(svg, rows.map(tile));
            let frame = Paint::line(SOFT, 1.0);
            svg.rectangle([[left, above], [left + width, above + PANEL_HEIGHT]], frame);
            if let Some(panel) = self.panel {
                let text = panel.format.name_and_value(&panel.values[index]);
                let text = truncated(&text, TEXT_SIZE, width);
                text_centred(svg, &text, [left + 0.5 * width, top + 0.5 * HEADING], TEXT_SIZE, INK);
            }
            let fitting = (width / 48.0).floor().max(1.0) as usize;
            for column in labelled(self.x.len(), MAX_LABELS.min(fitting)) {
                let [middle, _] = corner([column, 0]);
                let at = [middle + 0.5 * cell_size[0], above + PANEL_HEIGHT + 12.0];
                text_centred(svg, &self.x.text(column), at, SMALL_TEXT_SIZE, INK);
            }
            let below = [left + 0.5 * width, above + PANEL_HEIGHT + 32.0];
            text_centred(svg, &truncated(&self.x.format.label(), TEXT_SIZE, width), below, TEXT_SIZE, INK);
        }
        for row in labelled(self.y.len(), MAX_LABELS) {
            let middle = above + PANEL_HEIGHT - cell_size[1] * (row as f64 + 0.5);
            text_left_of(svg, &self.y.text(row), [LEFT - 8.0, middle], SMALL_TEXT_SIZE, INK);
        }
        let label = truncated(&self.y.format.label(), TEXT_SIZE, LEFT + 0.4 * WIDTH);
        text_right_of(svg, &label, [8.0, top + 0.5 * HEADING], TEXT_SIZE, INK);
    }
}

/// Indices of the values that have a label: the first, the last and others at equal distances.
fn labelled(count: usize, most: usize) -> Vec<usize> {
    let step = count.div_ceil(most.max(1)).max(1);
    (0..count).step_by(step).collect()
}
