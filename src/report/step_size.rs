//! The study of step sizes as tables, JSON and CSV.

use crate::study::step_size::{Crossing, Formulation, LEVELS, Row, StepSize};
use crate::wording::duration;
use crate::wording::figures::{figure, row};
use crate::wording::report::{Report, Reported, Table, table};

/// Tables for people.
impl Reported for StepSize {
    fn report(&self) -> Report {
        let StepSize { scene, pair, peak_n, restitution, .. } = self;
        let mut text = Report::from(format!(
            "{scene}, {pair}: {} in contact of {} plotted, peak {} N, restitution {}\n\n",
            duration(self.contact_s),
            duration(self.plotted_s),
            figure(*peak_n, 5),
            figure(*restitution, 5)
        ));
        let head = row([
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
        let percent = |value: f64| figure(100.0 * value, 3);
        let line = |of: &Row| {
            let setting = of.rtol.map_or(String::new(), |rtol| format!(", rtol {rtol:e}"));
            vec![
                format!("{}{setting}", of.formulation.name()),
                percent(of.step_fraction),
                figure(of.step_s * 1e6, 3),
                of.steps.to_string(),
                figure(of.wall_s * 1e3, 3),
                percent(of.peak_error),
                percent(of.curve_rms_error),
                percent(of.curve_max_error),
                figure(of.restitution_error, 3),
            ]
        };
        let rows: Vec<_> = std::iter::once(head).chain(self.rows.iter().map(line)).collect();
        text.push(Table::new(&rows).keys(2));
        text.push_str("\nstep, % of the plotted time, from which on the whole force curve is right to\n");
        let levels = LEVELS.map(|level| format!("{} %", 100.0 * level));
        let head = std::iter::once(String::new()).chain(levels).collect();
        let line = |of: Formulation| {
            let cells = self.crossings.iter().filter(|crossing| crossing.formulation == of).map(step);
            std::iter::once(of.name().to_string()).chain(cells).collect()
        };
        let rows: Vec<Vec<String>> = std::iter::once(head).chain(Formulation::ALL.map(line)).collect();
        text.push(table(&rows));
        text.push(Report::paragraph(
            "\nErrors are against the analytic model at its reference preset, of forces relative to its peak. Forces of the \
             engine are\nknown at its steps and joined by straight lines; rapier's own contact is rigid and has no finite force: \
             impulse over step\nstands in for it. Steps of the analytic model are mean ones within the contact.\n",
        ));
        text
    }
}

fn step(crossing: &Crossing) -> String {
    match crossing.step_fraction {
        None => "never".to_string(),
        Some(fraction) if crossing.at_least => format!("≥ {}", figure(100.0 * fraction, 2)),
        Some(fraction) => figure(100.0 * fraction, 2),
    }
}

/// All runs, one a line.
pub fn step_size_csv(study: &StepSize) -> String {
    let mut text = "formulation,rtol,step_s,step_fraction,steps,wall_s,peak_error,curve_rms_error,curve_max_error,\
                    restitution_error\n"
        .to_string();
    for row in &study.rows {
        let rtol = row.rtol.map_or(String::new(), |rtol| format!("{rtol:e}"));
        text.push_str(&format!(
            "\"{}\",{rtol},{:e},{:e},{},{:e},{:e},{:e},{:e},{:e}\n",
            row.formulation.name(),
            row.step_s,
            row.step_fraction,
            row.steps,
            row.wall_s,
            row.peak_error,
            row.curve_rms_error,
            row.curve_max_error,
            row.restitution_error
        ));
    }
    text
}
