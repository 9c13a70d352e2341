//! Report of the step-size study.

use super::{Crossing, ERROR_LEVELS, Formulation, Row, StepSize};
use crate::format::format_duration;
use crate::format::numbers::{format_number, row};
use crate::format::report::{Report, Table, ToReport, table};
use crate::text::csv;

impl StepSize {
    /// Returns all runs as CSV, one per line. Unknown values are empty.
    pub fn csv(&self) -> String {
        csv(&self.rows)
    }
}

impl ToReport for StepSize {
    fn report(&self) -> Report {
        let StepSize { scene, pair, peak_n, restitution, .. } = self;
        let mut text = Report::from(format!(
            "{scene}, {pair}: {} in contact of {} plotted, peak {} N, restitution {}\n\n",
            format_duration(self.contact_s),
            format_duration(self.plotted_s),
            format_number(*peak_n, 5),
            format_number(*restitution, 5)
        ));
        let header = row([
            "",
            "step, %",
            "step, µs",
            "steps",
            "time, ms",
            "peak, %",
            "curve rms, %",
            "curve max, %",
            "restitution",
        ]);
        let percent = |value: f64| format_number(100.0 * value, 3);
        let line = |run: &Row| {
            let tolerance = run.rtol.map_or(String::new(), |rtol| format!(", rtol {rtol:e}"));
            vec![
                format!("{}{tolerance}", run.formulation.name()),
                percent(run.step_fraction),
                format_number(run.step_s * 1e6, 3),
                run.steps.to_string(),
                format_number(run.wall_s * 1e3, 3),
                percent(run.peak_error),
                percent(run.curve_rms_error),
                percent(run.curve_max_error),
                format_number(run.restitution_error, 3),
            ]
        };
        let rows: Vec<_> = std::iter::once(header).chain(self.rows.iter().map(line)).collect();
        text.push(Table::new(&rows).key_columns(2));
        text.push_str("\nlargest step, % of the plotted time, with errors of the whole force curve below\n");
        let levels = ERROR_LEVELS.map(|level| format!("{} %", 100.0 * level));
        let header = std::iter::once(String::new()).chain(levels).collect();
        let line = |formulation: Formulation| {
            let cells = self.crossings.iter().filter(|crossing| crossing.formulation == formulation).map(step_cell);
            std::iter::once(formulation.name().to_string()).chain(cells).collect()
        };
        let rows: Vec<Vec<String>> = std::iter::once(header).chain(Formulation::ALL.map(line)).collect();
        text.push(table(&rows));
        text.push(Report::paragraph(
            "\nErrors are relative to the analytic model at its reference preset; force errors are relative to its peak. Forces of \
             the engine\nare interpolated linearly between its steps. rapier's own contact is rigid and has no finite force, so \
             impulse over step is used\ninstead. Steps of the analytic model are mean steps within the contact.\n",
        ));
        text
    }
}

fn step_cell(crossing: &Crossing) -> String {
    match crossing.step_fraction {
        None => "never".to_string(),
        Some(fraction) if crossing.at_least => format!("≥ {}", format_number(100.0 * fraction, 2)),
        Some(fraction) => format_number(100.0 * fraction, 2),
    }
}
