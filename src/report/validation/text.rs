//! The report of a validation for people: short tables with units.

use std::fmt::Write;

use super::document::{
    CheckReport, DifferencesReport, ImpactReport, JointErrors, ModelReport, SettingReport, Status, ValidationReport,
};
use super::invariants::FindingReport;
use super::statistics::statistics_text;
use crate::validate::turned;
use crate::wording::duration;
use crate::wording::figures::{figure, row};
use crate::wording::sheet::{Sheet, Table, table};

/// The whole report, with a line end.
pub fn validation_text(report: &ValidationReport) -> Sheet {
    let model = |model: &ModelReport| cost_of(&model.setting, model.steps, model.wall_s);
    let heading = heading(&Heading {
        scene: &report.scene,
        passed: report.passed,
        analytic: model(&report.analytic),
        engine: model(&report.engine),
        until_s: report.until_s,
        duration_s: report.duration_s,
        ensemble_runs: report.ensemble_runs,
        ensemble_step: report.ensemble_torque_step,
        apart: "motor torque",
        directory: report.directory.as_deref(),
        files: report.files.as_deref(),
    });
    let mut sections = vec![Sheet::from(heading), checks(&report.verdict)];
    let broken = broken([("analytic", &report.analytic.invariants), ("engine", &report.engine.invariants)]);
    if !broken.is_empty() {
        sections.push(Sheet::from(broken));
    }
    sections.push(side_by_side(report));
    if !report.impacts.is_empty() {
        sections.push(impacts(&report.impacts));
    }
    if let Some(statistics) = &report.statistics {
        sections.push(statistics_text(statistics));
    }
    sections.push(differences(&report.differences));
    let left_out = report.quick.then_some("fixed steps below 1e-5 s, reduced coordinates");
    sections.push(settings(&report.settings, &joint_columns(), left_out));
    Sheet::join(sections)
}

/// What a report begins with.
pub(super) struct Heading<'a> {
    pub scene: &'a str,
    pub passed: bool,
    pub analytic: String,
    pub engine: String,
    pub until_s: f64,
    pub duration_s: f64,
    pub ensemble_runs: usize,
    pub ensemble_step: f64,
    /// What differs from one run of the ensemble to the next.
    pub apart: &'a str,
    pub directory: Option<&'a str>,
    pub files: Option<&'a [String]>,
}

/// A model's setting, steps and wall time.
pub(super) fn cost_of(setting: &str, steps: Option<u64>, wall_s: Option<f64>) -> String {
    let steps = steps.map(|steps| format!(", {steps} steps")).unwrap_or_default();
    let wall = wall_s.map(|wall_s| format!(", {} of wall time", duration(wall_s))).unwrap_or_default();
    format!("{setting}{steps}{wall}")
}

pub(super) fn heading(of: &Heading<'_>) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{}: engine against analytic model: {}",
        of.scene,
        if of.passed { "within all bounds" } else { "OUT OF BOUNDS" }
    );
    let _ = writeln!(text, "analytic: {} (the reference)", of.analytic);
    let _ = writeln!(text, "engine:   {} (the scene's settings)", of.engine);
    let _ = writeln!(
        text,
        "compared up to {} of {}; differences are the worst of {} runs, {} {:e} apart",
        duration(of.until_s),
        duration(of.duration_s),
        of.ensemble_runs,
        of.apart,
        of.ensemble_step
    );
    if let (Some(directory), Some(files)) = (of.directory, of.files) {
        let _ = writeln!(text, "in {directory}: {}", files.join(", "));
    }
    text
}

pub(super) fn checks(checks: &[CheckReport]) -> Sheet {
    let mut rows = vec![row(["bound", "measured", "limit", ""])];
    for check in checks {
        let measured = match check.measured {
            Some(value) if value.is_infinite() => "missing in one".to_string(),
            Some(value) => figure(value, 3),
            None => "nothing there".to_string(),
        };
        let passed = if check.passed { "pass" } else { "FAIL" };
        rows.push(row([&format!("{} ({})", check.bound, check.meaning), &measured, &figure(check.limit, 3), passed]));
    }
    table(&rows)
}

/// The invariants that each model broke, a line each.
pub(super) fn broken(models: [(&str, &[FindingReport]); 2]) -> String {
    let mut text = String::new();
    for (name, invariants) in models {
        for found in invariants.iter().filter(|found| !found.held) {
            let _ = writeln!(text, "broken by the {name} model ({}): {}", found.meaning, found.line);
        }
    }
    text
}

fn side_by_side(report: &ValidationReport) -> Sheet {
    let (a, e) = (&report.analytic, &report.engine);
    let line = |name: &str, analytic: f64, engine: f64, digits: usize| {
        row([name, &figure(analytic, digits), &figure(engine, digits), &figure(engine - analytic, 3)])
    };
    let angle = |name: &str, analytic: f64, engine: f64| {
        let (analytic, difference) = (turned(analytic), turned(engine - analytic));
        line(name, analytic.to_degrees(), (analytic + difference).to_degrees(), 8)
    };
    let mut rows = vec![
        row([&format!("at {}", duration(report.duration_s)), "analytic", "engine", "difference"]),
        angle("q11, deg", a.last.q11_rad, e.last.q11_rad),
        angle("q21, deg", a.last.q21_rad, e.last.q21_rad),
        angle("q22, deg", a.last.q22_rad, e.last.q22_rad),
        line("qd11, rad/s", a.last.qd11_rad_s, e.last.qd11_rad_s, 4),
        line("qd21, rad/s", a.last.qd21_rad_s, e.last.qd21_rad_s, 4),
    ];
    let contacts =
        [("proximal", &a.contacts.proximal, &e.contacts.proximal), ("distal", &a.contacts.distal, &e.contacts.distal)];
    for (name, ours, theirs) in contacts {
        rows.push(line(&format!("{name} normal, N"), ours.final_normal_n, theirs.final_normal_n, 7));
        rows.push(line(&format!("{name} friction, N"), ours.final_tangential_n, theirs.final_tangential_n, 4));
    }
    for (name, ours, theirs) in contacts {
        if let (Some(ours), Some(theirs)) = (ours.first_s, theirs.first_s) {
            rows.push(line(&format!("{name} first touch, ms"), ours * 1e3, theirs * 1e3, 8));
        }
        let touchdowns = |count: u32| count.to_string();
        rows.push(row([&format!("{name} touch-downs"), &touchdowns(ours.touchdowns), &touchdowns(theirs.touchdowns)]));
        rows.push(line(&format!("{name} impulse, mN·s"), ours.impulse_n_s * 1e3, theirs.impulse_n_s * 1e3, 6));
        rows.push(line(&format!("{name} peak, N"), ours.peak_normal_n, theirs.peak_normal_n, 4));
    }
    rows.push(line("kinetic energy, mJ", a.energy.kinetic_j * 1e3, e.energy.kinetic_j * 1e3, 4));
    rows.push(line("dissipated, mJ", a.energy.dissipated_j * 1e3, e.energy.dissipated_j * 1e3, 6));
    rows.push(line("motor work, mJ", a.energy.motor_work_j * 1e3, e.energy.motor_work_j * 1e3, 6));
    rows.push(line("balance, mJ", a.energy.balance_j * 1e3, e.energy.balance_j * 1e3, 3));
    table(&rows)
}

/// More impacts than this make no table for people; the JSON document has them all.
const MOST_IMPACTS: usize = 12;

fn impacts(impacts: &[ImpactReport]) -> Sheet {
    let mut rows = vec![row([
        "impact",
        "analytic, ms",
        "engine, ms",
        "for, µs",
        "impulse: analytic, mN·s",
        "engine, mN·s",
        "difference, %",
    ])];
    let or_dash = |value: Option<f64>, digits: usize| value.map_or("–".to_string(), |value| figure(value, digits));
    for impact in impacts.iter().take(MOST_IMPACTS) {
        let relative = match (impact.analytic_n_s, impact.engine_n_s) {
            (Some(ours), Some(theirs)) if ours != 0.0 => Some(100.0 * (theirs / ours - 1.0)),
            _ => None,
        };
        rows.push(row([
            impact.site,
            &or_dash(impact.analytic_s.map(|s| s * 1e3), 7),
            &or_dash(impact.engine_s.map(|s| s * 1e3), 7),
            &figure(impact.window_s * 1e6, 5),
            &or_dash(impact.analytic_n_s.map(|n_s| n_s * 1e3), 5),
            &or_dash(impact.engine_n_s.map(|n_s| n_s * 1e3), 5),
            &or_dash(relative, 3),
        ]));
    }
    let mut text = table(&rows);
    if impacts.len() > MOST_IMPACTS {
        let _ = writeln!(text, "and {} more", impacts.len() - MOST_IMPACTS);
    }
    text
}

fn differences(found: &DifferencesReport) -> Sheet {
    let mut rows = vec![row(["difference", "max, rad", "at, ms", "RMS, rad", "at the end, rad", "rate RMS, rad/s"])];
    for (name, joint) in &found.joints {
        rows.push(row([
            name,
            &figure(joint.max_rad, 3),
            &figure(joint.max_at_s * 1e3, 5),
            &figure(joint.rms_rad, 3),
            &figure(joint.end_rad, 3),
            &figure(joint.rate_rms_rad_s, 3),
        ]));
    }
    let mut text = table(&rows);
    let _ = writeln!(
        text,
        "energy that came from nowhere: {} mJ, {} of the motor's work",
        figure(found.energy_created_j * 1e3, 3),
        figure(found.energy_created, 3)
    );
    text
}

/// Columns of the differences: two lines of heads, and the cells of a setting that was completed.
pub(super) struct Columns<E, const N: usize> {
    pub heads: [[&'static str; N]; 2],
    pub cells: fn(&E) -> [String; N],
}

/// A figure where there is one.
pub(super) fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("–".to_string(), |value| figure(value, digits))
}

/// A ratio in percent.
pub(super) fn percent(value: Option<f64>) -> String {
    number(value.map(|value| 100.0 * value), 2)
}

fn joint_columns() -> Columns<JointErrors, 6> {
    Columns {
        heads: [["angle,", "touch,", "impulse,", "force,", "gap,", "energy,"], ["rad", "µs", "%", "%", "µm", "%"]],
        cells: |errors| {
            let found = errors.differences.as_ref();
            let worst = |of: fn(&DifferencesReport) -> [Option<f64>; 2]| match found.map(of)? {
                [Some(a), Some(b)] => Some(a.max(b)),
                [a, b] => a.or(b),
            };
            [
                number(errors.angle_max_rad, 2),
                number(worst(|found| [found.proximal.first_touch_s, found.distal.first_touch_s]).map(|s| s * 1e6), 2),
                percent(worst(|found| [found.proximal.impulse, found.distal.impulse])),
                percent(worst(|found| [found.proximal.final_force, found.distal.final_force])),
                number(found.map(|found| found.loop_gap_m * 1e6), 2),
                percent(found.map(|found| found.energy_created)),
            ]
        },
    }
}

pub(super) fn settings<E, const N: usize>(
    settings: &[SettingReport<E>],
    columns: &Columns<E, N>,
    left_out: Option<&str>,
) -> Sheet {
    let mut text = Sheet::default();
    let mut rows = vec![
        row(["speed against error", "runs", "steps", "wall, ms", "× real", "× everyday"]),
        row(["", "", "", "", "time", "analytic"]),
    ];
    for (line, heads) in rows.iter_mut().zip(columns.heads) {
        line.extend(row(heads));
    }
    let mut notes = Vec::new();
    let mut family = "";
    for setting in settings {
        if setting.family != family {
            family = setting.family;
            rows.push(row([family]));
        }
        rows.push(cells(setting, columns));
        match (setting.status, &setting.reason) {
            (Status::Done, _) | (_, None) => {}
            (Status::Failed, Some(reason)) => notes.push(format!("{}, {}: {reason}", family, setting.setting)),
            (Status::TooLong, Some(reason)) => {
                notes.push(format!("{}, {}: left out, {reason}", family, setting.setting))
            }
        }
    }
    text.push(Table::new(&rows).heads(2));
    text.push_str(
        "largest differences from the reference over so many runs; * the scene's settings; median wall time, no log\n",
    );
    if let Some(left_out) = left_out {
        let _ = writeln!(text, "left out by --quick: {left_out}");
    }
    for note in notes {
        let _ = writeln!(text, "{note}");
    }
    text
}

fn cells<E, const N: usize>(setting: &SettingReport<E>, columns: &Columns<E, N>) -> Vec<String> {
    let mark = if setting.own { " *" } else { "" };
    let name = format!("  {}{mark}", setting.setting);
    let (Some(steps), Some(wall_s)) = (setting.steps, setting.wall_s) else {
        let word = if setting.status == Status::TooLong { "left out" } else { "failed" };
        return row([&name, "–", "–", word]);
    };
    let runs = if setting.reference { "–".to_string() } else { setting.ensemble_runs.to_string() };
    let mut cells = row([
        &name,
        &runs,
        &steps.to_string(),
        &figure(wall_s * 1e3, 3),
        &number(setting.real_time_factor, 3),
        &number(setting.analytic_factor, 3),
    ]);
    cells.extend((columns.cells)(&setting.errors));
    if setting.reference {
        cells[0].push_str(" (reference)");
    }
    cells
}
