//! Report of the stability map.

use super::{Cell, Stability, Verdict};
use crate::format::format_duration;
use crate::format::numbers::format_number;
use crate::format::report::{Report, ToReport, table};
use crate::text::csv;

impl Stability {
    /// Returns all runs of the engine as CSV, one per line. Unknown values are empty.
    pub fn csv(&self) -> String {
        csv(&self.cells)
    }
}

/// One table for each damping factor, and the reasons of failed cells.
impl ToReport for Stability {
    fn report(&self) -> Report {
        let Stability { scene, accuracy_rad, until_s, stiffness_si, damping_max_n_s_per_m, grid, .. } = self;
        let mut text = Report::from(format!(
            "{scene}: engine with fixed steps against the analytic reference, up to {}\nk = {} N/m^e, c_max = {} N·s/m \
             (proximal, distal), times the factors below\n",
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
