//! What a log says of its run, for people.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::super::tables::{contacts, dynamics, energies, grasp, states};
use super::super::text::{engine, integrator};
use super::document::{MissingReport, ReplayReport};
use super::verify::verification_text;
use crate::wording::duration;
use crate::wording::{Report, Reported};

/// The whole summary, with a line end.
impl Reported for ReplayReport {
    fn report(&self) -> Report {
        let mut sections = vec![Report::from(heading(self))];
        let last = self.states.0.as_ref().zip(self.end_s);
        sections.extend(last.into_iter().flat_map(|(last, end_s)| states(last, end_s)));
        sections.extend(self.contacts.as_ref().and_then(contacts));
        sections.extend(self.energy.as_ref().map(|energy| energies(energy, self.has_joints())));
        if let Some(criteria) = &self.criteria {
            sections.push(dynamics(criteria));
        }
        sections.extend(self.grasp.as_ref().map(grasp));
        if let Some(verification) = &self.verification {
            sections.push(verification_text(verification));
        }
        Report::join(sections)
    }
}

fn heading(report: &ReplayReport) -> String {
    let known = |entry: &Option<String>| entry.clone().unwrap_or_else(|| "unknown".to_string());
    let asked = report.duration_s.map_or("an unknown time".to_string(), duration);
    let settings = report
        .integrator
        .as_ref()
        .map(integrator)
        .or_else(|| report.engine.as_ref().map(|used| engine(used, report.has_joints())));
    let mut text = format!(
        "{}: {} model{}\nread from {}\n",
        known(&report.scene),
        known(&report.model),
        settings.unwrap_or_default(),
        report.log
    );
    // Writing to a string cannot fail.
    let _ = match (&report.error, report.completed) {
        (Some(error), _) => {
            writeln!(text, "NOT COMPLETED: stopped at {} of {asked}: {}", duration(error.time_s), error.reason)
        }
        (None, Some(_)) => writeln!(text, "completed, {asked}"),
        (None, None) => match report.end_s {
            Some(end_s) => writeln!(text, "NOT COMPLETE: the log reaches {} of {asked}", duration(end_s)),
            None => writeln!(text, "NOT COMPLETE: no sample of {asked}"),
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
        let _ = write!(text, ", {} messages of channels that this phalanx does not know", report.unknown_messages);
    }
    text.push('\n');
    if let Some(csv) = &report.csv {
        let _ = writeln!(text, "samples: {csv}");
    }
    if let Some(page) = &report.page {
        let _ = writeln!(text, "page: {page}");
    }
    if let Some(entries) = &report.recovered {
        let _ = writeln!(text, "{}", recovered(entries));
    }
    for lost in &report.losses {
        let _ = writeln!(text, "LOST: {}", lost.what);
    }
    for MissingReport { topic, what, .. } in &report.missing {
        let _ = writeln!(text, "MISSING: {topic} {what}");
    }
    if let Some(withheld) = report.withheld() {
        let _ = writeln!(text, "{withheld}, for they need what is missing");
    }
    for warning in &report.warnings {
        let _ = writeln!(text, "Warning: {warning}");
    }
    text
}

/// What is said of a recovered log.
fn recovered(entries: &BTreeMap<String, String>) -> String {
    let entry = |key: &str| entries.get(key).map_or("unknown", String::as_str);
    format!("RECOVERED from {}: {}", entry("source"), entry("lost"))
}
