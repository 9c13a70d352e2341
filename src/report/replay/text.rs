//! Text report of a log.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::super::tables::{contacts, criteria_table, energies, grasp, states};
use super::super::text::{engine, integrator};
use super::document::{MissingTopicReport, ReplayReport};
use super::verify::verification_report;
use crate::format::format_duration;
use crate::format::{Report, ToReport};

impl ToReport for ReplayReport {
    fn report(&self) -> Report {
        let mut sections = vec![Report::from(heading(self))];
        let last = self.states.0.as_ref().zip(self.end_s);
        sections.extend(last.into_iter().flat_map(|(last, end_s)| states(last, end_s)));
        sections.extend(self.contacts.as_ref().and_then(contacts));
        sections.extend(self.energy.as_ref().map(|energy| energies(energy, self.has_joints())));
        if let Some(criteria) = &self.criteria {
            sections.push(criteria_table(criteria));
        }
        sections.extend(self.grasp.as_ref().map(grasp));
        if let Some(verification) = &self.verification {
            sections.push(verification_report(verification));
        }
        Report::join(sections)
    }
}

fn heading(report: &ReplayReport) -> String {
    let or_unknown = |entry: &Option<String>| entry.clone().unwrap_or_else(|| "unknown".to_string());
    let requested = report.duration_s.map_or("an unknown time".to_string(), format_duration);
    let settings = report
        .integrator
        .as_ref()
        .map(integrator)
        .or_else(|| report.engine.as_ref().map(|used| engine(used, report.has_joints())));
    let mut text = format!(
        "{}: {} model{}\nread from {}\n",
        or_unknown(&report.scene),
        or_unknown(&report.model),
        settings.unwrap_or_default(),
        report.log
    );
    // Writing to a string cannot fail.
    let _ = match (&report.error, report.completed) {
        (Some(error), _) => {
            writeln!(
                text,
                "NOT COMPLETED: stopped at {} of {requested}: {}",
                format_duration(error.time_s),
                error.reason
            )
        }
        (None, Some(_)) => writeln!(text, "completed, {requested}"),
        (None, None) => match report.end_s {
            Some(end_s) => writeln!(text, "NOT COMPLETE: the log reaches {} of {requested}", format_duration(end_s)),
            None => writeln!(text, "NOT COMPLETE: the log contains no sample of the {requested} run"),
        },
    };
    let plural = |count: u64| if count == 1 { "" } else { "s" };
    let _ = write!(
        text,
        "{} sample{}, {} event{}",
        report.samples,
        plural(report.samples),
        report.events,
        plural(report.events)
    );
    if report.unknown_messages > 0 {
        let _ = write!(text, ", {} messages of channels unknown to this version of phalanx", report.unknown_messages);
    }
    text.push('\n');
    if let Some(csv) = &report.csv {
        let _ = writeln!(text, "samples: {csv}");
    }
    if let Some(page) = &report.page {
        let _ = writeln!(text, "page: {page}");
    }
    if let Some(entries) = &report.recovered {
        let _ = writeln!(text, "{}", recovery_line(entries));
    }
    for loss in &report.losses {
        let _ = writeln!(text, "LOST: {}", loss.description);
    }
    for MissingTopicReport { topic, defect, .. } in &report.missing {
        let _ = writeln!(text, "MISSING: {topic} {defect}");
    }
    if let Some(withheld_results) = report.withheld_results() {
        let _ = writeln!(text, "{withheld_results}, because they depend on missing data");
    }
    for warning in &report.warnings {
        let _ = writeln!(text, "Warning: {warning}");
    }
    text
}

/// Describes the recovery of a log.
fn recovery_line(entries: &BTreeMap<String, String>) -> String {
    let entry = |key: &str| entries.get(key).map_or("unknown", String::as_str);
    format!("RECOVERED from {}: {}", entry("source"), entry("lost"))
}
