//! Error of a contact force against the step size: one line per formulation, solid for the curve and faint for the
//! peak.

use super::{ERROR_LEVELS, Formulation, Row, StepSize};
use crate::plot::axis::Axis;
use crate::plot::canvas::{Marker, THIN_LINE};
use crate::plot::series::{Series, series_chart};
use crate::plot::theme::{AMBER, Colour, GREEN, ORANGE, SOFT};

const HEIGHT: f64 = 600.0;

impl StepSize {
    /// Draws errors over step size; errors of zero are omitted.
    pub fn picture(&self) -> String {
        let errors = self.rows.iter().flat_map(|row| [row.curve_max_error, row.peak_error]);
        let steps = self.rows.iter().map(|row| row.step_fraction);
        let x = Axis::logarithmic("step, part of the plotted time", steps, 12.0).with_margin();
        let y = Axis::logarithmic("error of the contact force, relative to its peak", errors.chain(ERROR_LEVELS), 12.0);
        let peak_marker = Marker::FaintLine { width: 3.0 };
        let mut series: Vec<Series> =
            ERROR_LEVELS.into_iter().map(|level| Series::horizontal(THIN_LINE, SOFT, level)).collect();
        for formulation in Formulation::ALL {
            let (marker, colour) = style(formulation);
            let error_curve = |marker, error: fn(&Row) -> f64| {
                let rows = self.rows.iter().filter(|row| row.formulation == formulation && error(row) > 0.0);
                Series::new(marker, colour, rows.map(|row| (row.step_fraction, error(row))))
            };
            series.push(error_curve(peak_marker, |row| row.peak_error));
            series.push(error_curve(THIN_LINE, |row| row.curve_max_error));
            series.push(error_curve(marker, |row| row.curve_max_error).named(formulation.name()));
        }
        series.push(Series::key(THIN_LINE, SOFT, "60, 10, 1, 0.01 %"));
        series.push(Series::key(peak_marker, SOFT, "faint: the peak only"));
        series_chart(&format!("{}: contact force against step size", self.scene), HEIGHT, &x, &y, &series)
    }
}

fn style(formulation: Formulation) -> (Marker, Colour) {
    match formulation {
        Formulation::EngineLaws => (Marker::Square, GREEN),
        Formulation::EngineRapier => (Marker::Cross, AMBER),
        Formulation::Analytic => (Marker::Circle, ORANGE),
    }
}
