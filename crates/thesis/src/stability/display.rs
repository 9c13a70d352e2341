//! Map of verdicts as a picture, CSV and text.

use super::{Cell, Stability, Verdict};
use crate::format::format_duration;
use crate::format::numbers::format_number;
use crate::format::report::{Report, ToReport, table};
use crate::plot::canvas::{TITLE_HEIGHT, WIDTH, colour_key, picture, text_centred, text_right_of, text_width};
use crate::plot::svg::{Paint, Pixel, Svg};
use crate::plot::theme::{BROKEN, Colour, DOUBTFUL, FINE, INK, PAPER, SOFT};
use crate::text::csv;

/// Maximum number of panels side by side.
const MAX_COLUMNS: usize = 2;
const HEADER_HEIGHT: f64 = 34.0;
const FOOTER_HEIGHT: f64 = 52.0;
const LEFT_MARGIN: f64 = 82.0;
const RIGHT_MARGIN: f64 = 14.0;
const ROW_HEIGHT: f64 = 38.0;
const LEGEND_HEIGHT: f64 = 40.0;
const TEXT_SIZE: f64 = 14.0;

impl Stability {
    /// Returns all runs of the engine as CSV, one run per line. Unknown values are empty.
    pub fn csv(&self) -> String {
        csv(&self.cells)
    }

    /// Draws a panel for each damping factor. Its tiles, over step size and stiffness, contain the angle error.
    pub fn picture(&self) -> String {
        let panels = self.grid.damping_factors.len();
        let columns = MAX_COLUMNS.min(panels);
        let panel = HEADER_HEIGHT + FOOTER_HEIGHT + ROW_HEIGHT * self.grid.stiffness_factors.len() as f64;
        let width = WIDTH / columns as f64;
        let title = format!("{}: stability and accuracy of the engine", self.scene);
        picture(&title, TITLE_HEIGHT + LEGEND_HEIGHT + panel * panels.div_ceil(columns) as f64, |svg| {
            legend(svg, self);
            for damping in 0..panels {
                let origin = [width * (damping % columns) as f64, LEGEND_HEIGHT + panel * (damping / columns) as f64];
                svg.translated(origin, |svg| draw(svg, width, self, damping));
            }
        })
    }
}

/// Draws one panel of a width: step size increases to the right, stiffness upwards.
fn draw(svg: &mut Svg, width: f64, study: &Stability, damping: usize) {
    let grid = &study.grid;
    let columns = grid.steps_s.len();
    let width = width - LEFT_MARGIN - RIGHT_MARGIN;
    let edge = |column: usize| LEFT_MARGIN + (width * column as f64 / columns as f64).round();
    let size = TEXT_SIZE.min(((width / columns as f64 - 4.0) / text_width("0.0e−00", 1.0)).floor());
    let middle = LEFT_MARGIN + 0.5 * width;
    text_centred(svg, &format!("c_max × {}", factor(grid.damping_factors[damping])), [middle, 16.0], 16.0, INK);
    let foot = HEADER_HEIGHT + ROW_HEIGHT * grid.stiffness_factors.len() as f64;
    for (stiffness, &k) in grid.stiffness_factors.iter().enumerate() {
        let top = foot - ROW_HEIGHT * (stiffness + 1) as f64;
        text_centred(
            svg,
            &format!("k × {}", factor(k)),
            [0.5 * LEFT_MARGIN + 2.0, top + 0.5 * ROW_HEIGHT],
            TEXT_SIZE,
            INK,
        );
        for step in 0..columns {
            let corners = [[edge(columns - 1 - step), top], [edge(columns - step), top + ROW_HEIGHT]];
            cell(svg, study.cell(step, stiffness, damping), corners, size);
        }
    }
    for (step, &step_s) in grid.steps_s.iter().enumerate() {
        let middle_x = 0.5 * (edge(columns - 1 - step) + edge(columns - step));
        text_centred(svg, &format_duration(step_s), [middle_x, foot + 14.0], size, INK);
    }
    text_centred(svg, "step dt", [middle, foot + 34.0], TEXT_SIZE, INK);
}

fn cell(svg: &mut Svg, cell: &Cell, corners: [Pixel; 2], size: f64) {
    let (fill, ink) = colours(cell.verdict);
    svg.rectangle(corners, Paint::fill(fill).with_edge(PAPER));
    let error = match (cell.verdict, cell.angle_error_rad) {
        (Verdict::NotJudged, _) => "–".to_string(),
        (Verdict::Failed, None) => "failed".to_string(),
        (_, Some(rad)) => format!("{rad:.1e}").replace('-', "−"),
        (_, None) => "∞".to_string(),
    };
    text_centred(svg, &error, [0, 1].map(|k| 0.5 * (corners[0][k] + corners[1][k])), size, ink);
}

/// Draws the colours of the verdicts and the meaning of the figures in one line.
fn legend(svg: &mut Svg, study: &Stability) {
    let bound = format!("{:e} rad", study.accuracy_rad).replace('-', "−");
    let entries = Verdict::ALL.map(|verdict| match verdict {
        Verdict::Accurate => (verdict, format!("stable, within {bound}")),
        _ => (verdict, verdict.name().to_string()),
    });
    let verdicts_present = entries.iter().filter(|(verdict, _)| study.count(*verdict) > 0);
    let [x, y] = colour_key(
        svg,
        [16.0, 17.0],
        verdicts_present.map(|(verdict, text)| (colours(*verdict).0, text.as_str())),
        TEXT_SIZE,
    );
    text_right_of(svg, "figures: largest angle error, rad", [x, y], TEXT_SIZE, INK);
}

/// Fill and text colours: three levels of lightness, distinguishable in greyscale and with colour blindness.
fn colours(verdict: Verdict) -> (Colour, Colour) {
    match verdict {
        Verdict::Accurate => (FINE, INK),
        Verdict::Inaccurate => (DOUBTFUL, INK),
        Verdict::Failed => (BROKEN, PAPER),
        Verdict::NotJudged => (PAPER, SOFT),
    }
}

/// Formats a factor; long numbers have an exponent.
fn factor(value: f64) -> String {
    let plain_number = format!("{value}");
    if plain_number.len() > 4 { format!("{value:e}").replace('-', "−") } else { plain_number }
}

/// One table for each damping factor, and the reasons of failed cells.
impl ToReport for Stability {
    fn report(&self) -> Report {
        let Stability { scene, accuracy_rad, until_s, stiffness_si, damping_max_n_s_per_m, grid, .. } = self;
        let mut text = Report::from(format!(
            "{}: engine with fixed steps against the analytic reference, up to {}\nk = {} N/m^e, c_max = {} N·s/m \
             (proximal, distal), times the factors below\n",
            crate::scene::one_line(scene),
            format_duration(*until_s),
            pair(stiffness_si),
            pair(damping_max_n_s_per_m)
        ));
        for (damping, factor) in grid.damping_factors.iter().enumerate() {
            let header =
                ["k \\ dt".to_string()].into_iter().chain(grid.steps_s.iter().map(|&step_s| format_duration(step_s)));
            let mut rows = vec![header.chain(["determined to".to_string()]).collect::<Vec<_>>()];
            for (stiffness, k) in grid.stiffness_factors.iter().enumerate().rev() {
                let cells = (0..grid.steps_s.len()).map(|step| format_cell(self.cell(step, stiffness, damping)));
                let reference = self.reference(stiffness, damping);
                let determined = reference.sensitivity_rad.map_or("–".to_string(), |rad| format_number(rad, 2));
                rows.push([format!("× {k}")].into_iter().chain(cells).chain([determined]).collect());
            }
            text.push_str(&format!("\nc_max × {factor}\n"));
            text.push(table(&rows));
        }
        let counts = Verdict::ALL.map(|verdict| format!("{} {}", self.count(verdict), verdict.name()));
        let steps: u64 = self.cells.iter().map(|cell| cell.steps).sum();
        text.push_str(&format!(
            "\n{} cells: {}; {steps} steps in {} s\n",
            self.cells.len(),
            counts.join(", "),
            format_number(self.wall_s, 3)
        ));
        text.push_str(&reasons(self));
        text.push(Report::paragraph(&format!(
            "\nNumbers are the largest difference of a joint angle, in rad. Up to {accuracy_rad:e} a cell is accurate; above, it is \
             stable but\ninaccurate (in parentheses). \"failed\" is a run that was not completed or violated a stability criterion, \"–\" \
             one that is not\njudged. \"determined to\" is the change of the reference for a relative change of the motor torque of 1e-9.\n"
        )));
        text
    }
}

fn pair([proximal, distal]: &[f64; 2]) -> String {
    if proximal == distal { format!("{proximal:e}") } else { format!("{proximal:e}, {distal:e}") }
}

fn format_cell(cell: &Cell) -> String {
    let error = cell.angle_error_rad.map_or("–".to_string(), |rad| format!("{rad:.1e}"));
    match cell.verdict {
        Verdict::Accurate => error,
        Verdict::Inaccurate => format!("({error})"),
        Verdict::Failed => "failed".to_string(),
        Verdict::NotJudged => "–".to_string(),
    }
}

/// Returns one line for each run that failed or could not be judged.
fn reasons(study: &Stability) -> String {
    let references = study.references.iter().filter_map(|reference| {
        let reason = reference.reason.as_ref()?;
        let (stiffness, damping) = (reference.stiffness_factor, reference.damping_factor);
        Some(format!("  k × {stiffness}, c_max × {damping}, reference: {reason}\n"))
    });
    let cells = study.cells.iter().filter_map(|cell| {
        let reason = cell.reason.as_ref()?;
        let (verdict, step) = (cell.verdict.name(), format_duration(cell.step_s));
        Some(format!(
            "  k × {}, c_max × {}, dt {step}, {verdict}: {reason}\n",
            cell.stiffness_factor, cell.damping_factor
        ))
    });
    let lines: String = references.chain(cells).collect();
    if lines.is_empty() { lines } else { format!("\n{lines}") }
}
