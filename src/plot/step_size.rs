//! Error of a contact force against the step size: one line a formulation, whole for the curve and pale for the peak.

use super::axis::Axis;
use super::canvas::{Entry, Mark, THIN, chart, level, line, points};
use super::theme::{AMBER, Colour, GREEN, ORANGE, SOFT};
use crate::study::step_size::{Formulation, LEVELS, Row, StepSize};

const HEIGHT: f64 = 600.0;

/// The picture; errors of zero are not in it.
pub fn step_size(study: &StepSize) -> String {
    let errors = study.rows.iter().flat_map(|row| [row.curve_max_error, row.peak_error]);
    let x = Axis::decades("step, part of the plotted time", study.rows.iter().map(|row| row.step_fraction), 12.0)
        .with_room();
    let y = Axis::decades("error of the contact force, relative to its peak", errors.chain(LEVELS), 12.0);
    chart(&format!("{}: contact force against step size", study.scene), HEIGHT, &x, &y, |svg, on| {
        for of in LEVELS {
            level(svg, on, y.place(of), THIN, SOFT);
        }
        let pale = Mark::Pale { width: 3.0 };
        let mut entries = Vec::new();
        for formulation in Formulation::ALL {
            let (mark, colour) = style(formulation);
            let of = |error: fn(&Row) -> f64| -> Vec<(f64, f64)> {
                let rows = study.rows.iter().filter(|row| row.formulation == formulation && error(row) > 0.0);
                rows.map(|row| (x.place(row.step_fraction), y.place(error(row)))).collect()
            };
            line(svg, on, of(|row| row.peak_error), pale, colour);
            let places = of(|row| row.curve_max_error);
            line(svg, on, places.clone(), THIN, colour);
            points(svg, on, places, mark, colour);
            entries.push(Entry::new(mark, colour, formulation.name()));
        }
        entries.push(Entry::new(THIN, SOFT, "60, 10, 1, 0.01 %"));
        entries.push(Entry::new(pale, SOFT, "pale: the peak alone"));
        entries
    })
}

fn style(formulation: Formulation) -> (Mark, Colour) {
    match formulation {
        Formulation::EngineLaws => (Mark::Square, GREEN),
        Formulation::EngineRapier => (Mark::Cross, AMBER),
        Formulation::Analytic => (Mark::Circle, ORANGE),
    }
}
