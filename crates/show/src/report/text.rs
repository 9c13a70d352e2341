//! The summary of a run as text: short tables with units.

use super::check;
use super::document::{EffectiveSettings, Failure, RunReport};
use super::grasp::GraspReport;
use super::tables::{contacts, criteria_table, energies, grasp, states};
use crate::format::format_duration;
use crate::format::numbers::{G_M_S2, format_number};
use crate::format::{Report, ToReport};
use crate::scene::{Engine, Integrator, Keyword, Response, Stepping};

/// The complete summary, with a final line end.
impl ToReport for RunReport {
    fn report(&self) -> Report {
        let mut sections = vec![heading(self)];
        sections.extend(states(&self.states, self.end_s.unwrap_or_default()));
        sections.extend(self.contacts.as_ref().and_then(contacts));
        sections.extend(self.energy.as_ref().map(|energy| energies(energy, self.has_joints())));
        sections.extend(self.criteria.flatten().map(|criteria| criteria_table(&criteria)));
        let no_criteria = self.no_criteria.iter().flatten().filter(|_| self.completed);
        sections.extend(no_criteria.map(|reason| Report::from(format!("no class: {reason}\n"))));
        sections.extend(self.grasp.iter().flatten().map(grasp));
        sections.extend(check::summary_line(self.check.as_ref(), self.steps).map(Report::from));
        Report::join(sections)
    }
}

fn heading(report: &RunReport) -> Report {
    let has_joints = report.has_joints();
    let settings = report.integrator.as_ref().map(integrator);
    let settings = settings.or_else(|| report.engine.as_ref().map(|settings| engine(settings, has_joints)));
    let mut lines = vec![
        format!("{}: {} model{}", report.scene, report.model, settings.unwrap_or_default()),
        format!("{}{} of wall time", effort_line(report), format_duration(report.wall_s)),
    ];
    lines.extend(report.palm_peak_acceleration_m_s2.flatten().map(|peak_m_s2| {
        let [peak, peak_g] = [peak_m_s2, peak_m_s2 / G_M_S2].map(|peak| format_number(peak, 4));
        format!("the palm accelerates by up to {peak} m/s² ({peak_g} g)")
    }));
    let gap = report.loop_gap_m.flatten();
    lines.extend(gap.map(|gap_m| format!("joints open by at most {} µm", format_number(gap_m * 1e6, 3))));
    lines.extend(report.grasp.iter().flatten().find_map(GraspReport::ejected_s).map(|at_s| {
        format!("EJECTED: the object left the reach of both fingers at {}, which ends the run", format_duration(at_s))
    }));
    lines.extend(report.error.as_ref().map(|Failure { time_s, reason }| {
        let (end, duration) = (format_duration(*time_s), format_duration(report.duration_s));
        format!("NOT COMPLETED: stopped at {end} of {duration}: {reason}")
    }));
    lines.extend(report.warnings.iter().map(|warning| format!("Warning: {warning}")));
    for (name, path) in [("log", &report.log), ("samples", &report.csv), ("page", &report.page)] {
        lines.extend(path.as_ref().map(|path| format!("{name}: {path}")));
    }
    Report::from(lines.join("\n") + "\n")
}

pub fn integrator(EffectiveSettings(settings): &EffectiveSettings<Integrator>) -> String {
    format!(", {} (rtol {:e}, {} preset)", settings.method.keyword(), settings.rtol, settings.preset.keyword())
}

pub fn engine(EffectiveSettings(settings): &EffectiveSettings<Engine>, has_fingers: bool) -> String {
    let stepping = match settings.stepping {
        Stepping::Fixed { step_s } => format!("steps of {}", format_duration(step_s)),
        Stepping::Adaptive { tolerance_m, max_step_s } => {
            let what = if has_fingers { "joints" } else { "discs" };
            format!(
                "{what} within {} m per step, steps up to {}",
                format_number(tolerance_m, 3),
                format_duration(max_step_s)
            )
        }
    };
    let law = if matches!(settings.response, Response::Rapier { .. }) { ", rapier's own contact" } else { "" };
    match has_fingers {
        true => format!(
            ", {} construction ({stepping}, {} sweeps{law})",
            settings.construction.keyword(),
            settings.iterations
        ),
        false => format!(", {stepping}{law}"),
    }
}

fn effort_line(report: &RunReport) -> String {
    let (Some(end_s), Some(steps), Some(work)) = (report.end_s, report.steps, &report.work) else {
        return String::new();
    };
    let effort = match &report.engine {
        None => format!("{} evaluations, {} Jacobians", work.rhs_evaluations, work.jacobian_evaluations),
        Some(_) => {
            format!("{} contact sub-steps, {} Newton iterations", work.contact_substeps, work.newton_iterations)
        }
    };
    let (rejected, events) = (work.rejected, work.events);
    let plural = if events == 1 { "" } else { "s" };
    format!("{} in {steps} steps ({rejected} rejected), {effort}, {events} event{plural}; ", format_duration(end_s))
}
