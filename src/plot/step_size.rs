//! Error of a contact force against the step size: one line a formulation, whole for the curve and pale for the peak.

use plotters::style::RGBColor;

use super::axis::Axis;
use super::canvas::{
    AMBER, DrawError, Entry, GREEN, GREY, LEGEND, Mark, ORANGE, WIDTH, frame, legend, line, picture, point, titled,
};
use crate::study::step_size::{Formulation, LEVELS, Row, StepSize};

const HEIGHT: u32 = 600;

/// The picture; errors of zero are not in it.
pub fn step_size(study: &StepSize) -> Result<String, DrawError> {
    let errors = study.rows.iter().flat_map(|row| [row.curve_max_error, row.peak_error]);
    let x = Axis::decades("step, part of the plotted time", study.rows.iter().map(|row| row.step_fraction), 12.0)
        .with_room();
    let y = Axis::decades("error of the contact force, relative to its peak", errors.chain(LEVELS), 12.0);
    picture(HEIGHT, |area| {
        let rest = titled(area, &format!("{}: contact force against step size", study.scene))?;
        let (left, right) = rest.split_horizontally(WIDTH - LEGEND - 40);
        let mut chart = frame(&left, &x, &y, true)?;
        for level in LEVELS {
            line(&mut chart, vec![(x.from, y.place(level)), (x.to, y.place(level))], Mark::Line { width: 1 }, GREY)?;
        }
        let mut entries = Vec::new();
        for formulation in Formulation::ALL {
            let (mark, colour) = style(formulation);
            let of = |error: fn(&Row) -> f64| -> Vec<(f64, f64)> {
                let rows = study.rows.iter().filter(|row| row.formulation == formulation && error(row) > 0.0);
                rows.map(|row| (x.place(row.step_fraction), y.place(error(row)))).collect()
            };
            line(&mut chart, of(|row| row.peak_error), Mark::Pale { width: 3 }, colour)?;
            let places = of(|row| row.curve_max_error);
            line(&mut chart, places.clone(), Mark::Line { width: 1 }, colour)?;
            for at in places {
                point(&mut chart, at, mark, colour)?;
            }
            entries.push(Entry::new(mark, colour, formulation.name()));
        }
        entries.push(Entry::new(Mark::Line { width: 1 }, GREY, "60, 10, 1, 0.01 %"));
        entries.push(Entry::new(Mark::Pale { width: 3 }, GREY, "pale: the peak alone"));
        legend(&right, &entries)
    })
}

fn style(formulation: Formulation) -> (Mark, RGBColor) {
    match formulation {
        Formulation::EngineLaws => (Mark::Square, GREEN),
        Formulation::EngineRapier => (Mark::Cross, AMBER),
        Formulation::Analytic => (Mark::Circle, ORANGE),
    }
}
