//! The map of stability as tables, JSON and CSV.

use crate::study::stability::{Cell, Stability, Verdict};
use crate::wording::duration;
use crate::wording::figures::figure;
use crate::wording::report::{Report, Reported, table};

/// Tables for people: one for each damping factor, and what failed and why.
impl Reported for Stability {
    fn report(&self) -> Report {
        let Stability { scene, accuracy_rad, until_s, stiffness_si, damping_max_n_s_per_m, grid, .. } = self;
        let mut text = Report::from(format!(
            "{scene}: engine with fixed steps against the analytic reference, up to {}\nk = {} N/m^e, c_max = {} N·s/m \
             (proximal, distal), times the factors below\n",
            duration(*until_s),
            pair(stiffness_si),
            pair(damping_max_n_s_per_m)
        ));
        for (damping, factor) in grid.damping_factors.iter().enumerate() {
            let head = ["k \\ dt".to_string()].into_iter().chain(grid.steps_s.iter().map(|&step_s| duration(step_s)));
            let mut rows = vec![head.chain(["determined to".to_string()]).collect::<Vec<_>>()];
            for (stiffness, k) in grid.stiffness_factors.iter().enumerate().rev() {
                let cells = (0..grid.steps_s.len()).map(|step| shown(self.cell(step, stiffness, damping)));
                let reference = self.reference(stiffness, damping);
                let determined = reference.sensitivity_rad.map_or("–".to_string(), |rad| figure(rad, 2));
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
            figure(self.wall_s, 3)
        ));
        text.push_str(&reasons(self));
        text.push(Report::paragraph(&format!(
            "\nFigures are the largest difference of a joint angle, in rad; within {accuracy_rad:e} a cell is accurate, beyond it \
             stable but\ninaccurate: (in brackets). \"failed\" is a run that broke off or broke what stability means, \"–\" one that is not \
             judged.\n\"determined to\" is by how much the reference changes if the motor torque changes by 1e-9.\n"
        )));
        text
    }
}

fn pair([proximal, distal]: &[f64; 2]) -> String {
    if proximal == distal { format!("{proximal:e}") } else { format!("{proximal:e}, {distal:e}") }
}

fn shown(cell: &Cell) -> String {
    let error = cell.angle_error_rad.map_or("–".to_string(), |rad| format!("{rad:.1e}"));
    match cell.verdict {
        Verdict::Accurate => error,
        Verdict::Inaccurate => format!("({error})"),
        Verdict::Failed => "failed".to_string(),
        Verdict::NotJudged => "–".to_string(),
    }
}

/// One line for each run that failed or could not be judged.
fn reasons(study: &Stability) -> String {
    let references = study.references.iter().filter_map(|of| {
        let reason = of.reason.as_ref()?;
        Some(format!("  k × {}, c_max × {}, reference: {reason}\n", of.stiffness_factor, of.damping_factor))
    });
    let cells = study.cells.iter().filter_map(|of| {
        let reason = of.reason.as_ref()?;
        let (verdict, step) = (of.verdict.name(), duration(of.step_s));
        Some(format!("  k × {}, c_max × {}, dt {step}, {verdict}: {reason}\n", of.stiffness_factor, of.damping_factor))
    });
    let lines: String = references.chain(cells).collect();
    if lines.is_empty() { lines } else { format!("\n{lines}") }
}

/// All runs of the engine, one a line; what is unknown is empty.
pub fn stability_csv(study: &Stability) -> String {
    let mut text = "step_s,stiffness_factor,damping_factor,verdict,angle_error_rad,energy_created_j,energy_created,\
                    energy_balance,loop_gap_m,steps,contact_substeps,wall_s,reason\n"
        .to_string();
    for cell in &study.cells {
        let error = cell.angle_error_rad.map_or(String::new(), |rad| format!("{rad:e}"));
        let reason = cell.reason.as_ref().map_or(String::new(), |reason| reason.replace('"', "\"\""));
        text.push_str(&format!(
            "{:e},{:e},{:e},{},{error},{:e},{:e},{:e},{:e},{},{},{:e},\"{reason}\"\n",
            cell.step_s,
            cell.stiffness_factor,
            cell.damping_factor,
            cell.verdict.key(),
            cell.energy_created_j,
            cell.energy_created,
            cell.energy_balance,
            cell.loop_gap_m,
            cell.steps,
            cell.contact_substeps,
            cell.wall_s
        ));
    }
    text
}
