//! Text report of a validation: short tables with units.

use super::{ImpactPair, TOTAL, ValidationReport, figures};
use crate::format::format_duration;
use crate::format::numbers::{format_number, or_dash, row, zero_below_resolution};
use crate::format::report::{Report, Table, ToReport, table, table_of};
use crate::invariants::Finding;
use crate::scene::ObjectMotion;

use crate::trace::{ContactSummary, Model};
use crate::units::Dimension;
use crate::validate::{
    CRITERIA, Check, Cost, Criterion, LadderOptions, MEMBER_PERTURBATION, Recording, Statistics, Status, Value,
    configuration_name, ensemble_size,
};

impl ToReport for ValidationReport<'_> {
    fn report(&self) -> Report {
        Report::join([self.verdict_report(), self.ladder_report().into()])
    }
}

impl ValidationReport<'_> {
    /// Returns the verdict and the results it is based on.
    pub(crate) fn verdict_report(&self) -> Report {
        let (validation, found) = (self.validation, &self.validation.differences);
        let has_fingers = self.finger_count() > 0;
        if !has_fingers && !self.all {
            return self.short_report();
        }
        let base = if has_fingers { "the work of the motors" } else { "the largest energy" };
        let [energy, ratio] = [found.energy_created_j * 1e3, found.energy_created].map(|value| format_number(value, 3));
        let sections = [
            heading(self).into(),
            checks(&validation.verdict.checks),
            criteria(&validation.criteria, validation.reason_not_judged).into(),
            (violations("analytic", &validation.reference_invariants)
                + &violations("engine", &validation.engine_invariants))
                .into(),
            side_by_side(self),
            has_fingers.then(|| impacts(&self.impacts())).flatten().into(),
            validation.statistics.as_ref().map(statistics).into(),
            self.differences().tables(),
        ];
        Report::join(sections).with(format!("spurious energy: {energy} mJ, {ratio} of {base}\n"))
    }

    /// Returns the verdict with the largest differences.
    fn short_report(&self) -> Report {
        let validation = self.validation;
        let failed = violations("analytic", &validation.reference_invariants)
            + &violations("engine", &validation.engine_invariants);
        Report::join([
            heading(self).into(),
            checks(&validation.verdict.checks),
            criteria(&validation.criteria, validation.reason_not_judged).into(),
            failed.into(),
            largest_differences(self),
        ])
    }

    /// Returns the ladder and the list of files; `None` without either.
    pub(crate) fn ladder_report(&self) -> Option<Report> {
        let ladder = self.ladder.map(|options| settings(self, options));
        let files = self.files.as_ref().map(|(directory, files)| format!("in {directory}: {}\n", files.join(", ")));
        let report = Report::join([ladder.into(), files.into()]);
        (!report.is_empty()).then_some(report)
    }

    fn finger_count(&self) -> usize {
        self.schema.fingers.len()
    }
}

fn number(value: Option<f64>, digits: usize) -> String {
    or_dash(value, |value| format_number(value, digits))
}

fn heading(report: &ValidationReport) -> String {
    let ValidationReport { scene, validation, .. } = report;
    let passed = validation.verdict.passed();
    let setting = |model: Model, run: &Recording| {
        format!("{}, {} steps", configuration_name(&report.configuration(model)), run.outcome.work.steps)
    };
    // The quantity that is varied within the ensemble.
    let varied = if report.finger_count() == 0 { "speeds and gravity" } else { "motor torque" };
    format!(
        "{}: engine against analytic model: {}\nanalytic: {} (the reference)\nengine:   {} (the scene's settings)\n\
         compared up to {} of {}; differences are the worst of {} runs with {varied} varied in steps of \
         {MEMBER_PERTURBATION:e}\n{}",
        scene.display_name(),
        if passed { "within all bounds" } else { "OUT OF BOUNDS" },
        setting(Model::Analytic, &validation.reference),
        setting(Model::Engine, &validation.engine),
        format_duration(validation.until_s),
        format_duration(scene.duration_s),
        ensemble_size(scene),
        if passed { String::new() } else { format!("{}\n", advice(report)) },
    )
}

/// Returns which model to trust, and which setting of the engine passes.
fn advice(report: &ValidationReport) -> String {
    let unit = if report.finger_count() == 0 { "m" } else { "rad" };
    let agreement = match report.validation.reference_error() {
        Some(error) => format!("its two integration methods agree to {error:.1e} {unit}"),
        None => "its two integration methods could not be compared".to_string(),
    };
    if report.validation.trusted_model().is_none() {
        return format!("Neither model can be trusted: the analytic model is not a valid reference here; {agreement}.");
    }
    let engine = match report.validation.finer_configurations.last() {
        Some(finer) if finer.passed => format!("The engine passes with [engine] {}.", finer.setting),
        Some(finer) => format!("The engine does not pass with [engine] {} either.", finer.setting),
        None => "No finer setting of the engine was run.".to_string(),
    };
    format!("Trust the analytic model: {agreement}. {engine}")
}

fn checks(checks: &[Check]) -> Report {
    let mut rows = vec![row(["bound", "measured", "limit", ""])];
    rows.extend(checks.iter().map(|check| {
        let measured = match check.measured {
            Some(value) if value.is_infinite() => "missing in one".to_string(),
            Some(value) => format_number(value, 3),
            None => "none".to_string(),
        };
        let passed = if check.passed { "pass" } else { "FAIL" };
        row([&format!("{} ({})", check.bound, check.meaning), &measured, &format_number(check.limit, 3), passed])
    }));
    table(&rows)
}

/// Returns the criteria of both models side by side; `None` if there are none.
fn criteria(criteria: &[Criterion], reason_not_judged: Option<&str>) -> Option<Report> {
    let mut rows = vec![row(["criterion", "analytic", "engine"])];
    rows.extend(criteria.iter().filter_map(|criterion| {
        let kind = CRITERIA.iter().find(|kind| kind.bound == criterion.bound)?;
        let subject = criterion.subject.as_ref().map_or(String::new(), |name| format!("{} ", name.replace('_', " ")));
        let cell = |value: Value| match value {
            Value::Label(label) => label.to_string(),
            Value::Number(value) => number(value.map(|value| value * kind.scale), kind.digits),
        };
        Some(row([&format!("{subject}{}", kind.label), &cell(criterion.analytic), &cell(criterion.engine)]))
    }));
    let note = reason_not_judged.map_or(String::new(), |reason| format!("criteria are not judged: {reason}\n"));
    (rows.len() > 1).then(|| table(&rows).with(note.as_str()))
}

/// Lists the invariants that a model violated, one per line.
fn violations(model: &str, invariants: &[Finding]) -> String {
    let line =
        |found: &Finding| format!("invariant violated by the {model} model ({}): {found}\n", found.invariant.meaning());
    invariants.iter().filter(|found| found.is_violated()).map(line).collect()
}

/// Rows of the table of both models: column of a sample without the name of its component, label with the displayed
/// unit, displayed value per SI value, and number of digits.
type StateRow = (&'static str, &'static str, f64, usize);

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

const STATES: [StateRow; 13] = [
    ("q11_rad", "q11, deg", DEGREES, 8),
    ("q21_rad", "q21, deg", DEGREES, 8),
    ("q22_rad", "q22, deg", DEGREES, 8),
    ("qd11_rad_s", "qd11, rad/s", 1.0, 4),
    ("qd21_rad_s", "qd21, rad/s", 1.0, 4),
    ("x_m", "x, mm", 1e3, 8),
    ("y_m", "y, mm", 1e3, 8),
    ("angle_rad", "angle, deg", DEGREES, 8),
    ("vx_m_s", "vx, m/s", 1.0, 6),
    ("vy_m_s", "vy, m/s", 1.0, 6),
    ("spin_rad_s", "spin, rad/s", 1.0, 6),
    ("normal_n", "normal, N", 1.0, 7),
    ("tangential_n", "friction, N", 1.0, 4),
];

const ENERGIES: [StateRow; 4] = [
    ("kinetic_j", "kinetic energy, mJ", 1e3, 6),
    ("dissipated_j", "dissipated, mJ", 1e3, 6),
    ("motor_work_j", "work of the drives, mJ", 1e3, 6),
    ("balance_j", "balance, mJ", 1e3, 3),
];

/// Figures of a contact over the run: label, displayed value per SI value, number of digits (0: a count), value.
type ContactRow = (&'static str, f64, usize, fn(&ContactSummary) -> Option<f64>);

const CONTACTS: [ContactRow; 5] = [
    ("first contact, ms", 1e3, 8, |contact| contact.first_s),
    ("touch-downs", 1.0, 0, |contact| Some(contact.touchdowns.into())),
    ("impulse, mN·s", 1e3, 6, |contact| Some(contact.impulse_n_s)),
    ("peak, N", 1.0, 6, |contact| Some(contact.peak_normal_n)),
    ("depth, µm", 1e6, 6, |contact| contact.depth_m()),
];

/// Returns a table of the final state, the contacts and the energies of both models, with their differences. A single
/// finger shows all contacts, other scenes those that occurred.
fn side_by_side(report: &ValidationReport) -> Report {
    let (heading, lines) = lines(report);
    table(&[vec![heading], lines.iter().map(Line::cells).collect()].concat())
}

/// Number of rows in the table of the largest differences.
const MAX_DIFFERENCES: usize = 10;

/// Smaller values, in the displayed unit, count as this: 1 µm, 1 mm/s, 1 mN or 1 µJ. Those of a hand at rest are rounding errors.
const MIN_SIZE: f64 = 1e-3;

/// Returns the rows of [`side_by_side`] with the largest differences, relative to the largest value of the same quantity.
fn largest_differences(report: &ValidationReport) -> Report {
    let (heading, lines) = lines(report);
    let size = |line: &Line| line.analytic.abs().max((line.analytic + line.difference).abs());
    let largest = |label: &str| lines.iter().filter(|line| line.label == label).map(size).fold(0.0, f64::max);
    let relative = |line: &Line| line.difference.abs() / largest(line.label).max(MIN_SIZE);
    let mut ranked: Vec<(f64, &Line)> = lines.iter().map(|line| (relative(line), line)).collect();
    ranked.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let shown = ranked.iter().take(MAX_DIFFERENCES).map(|(_, line)| line.cells());
    let omitted = lines.len().saturating_sub(MAX_DIFFERENCES);
    let note =
        (omitted > 0).then(|| format!("the largest differences; --all prints {omitted} more rows and the paths\n"));
    table(&std::iter::once(heading).chain(shown).collect::<Vec<_>>()).with(note)
}

/// The heading and all rows of the table of both models.
fn lines<'a>(report: &'a ValidationReport<'_>) -> (Vec<String>, Vec<Line<'a>>) {
    let ValidationReport { scene, schema, validation, .. } = report;
    let channels = schema.channels();
    let runs = [&validation.reference.outcome, &validation.engine.outcome];
    let end_s = if report.finger_count() == 0 { validation.until_s } else { scene.duration_s };
    let heading = row([&format!("at {}", format_duration(end_s)), "analytic", "engine", "difference"]);
    let mut rows: Vec<Line<'a>> = Vec::new();
    let states = |component: &'a str, shown: &'static [StateRow]| -> Vec<Line<'a>> {
        let prefix = if component.is_empty() { String::new() } else { format!("{component}_") };
        let state = |&(name, label, scale, digits): &StateRow| {
            let channel = channels.iter().find(|channel| channel.name == format!("{prefix}{name}"))?;
            let [analytic, engine] = runs.map(|run| zero_below_resolution(channel.value(&run.last), Dimension::Length));
            let [analytic, difference] = [analytic, engine - analytic].map(|value| value * scale);
            Some(Line { component, label, analytic, difference, digits })
        };
        shown.iter().filter_map(state).collect()
    };
    schema.fingers.iter().for_each(|finger| rows.extend(states(finger, &STATES)));
    let is_fixed = scene.object().is_some_and(|object| object.motion == ObjectMotion::Fixed);
    schema.bodies.iter().filter(|_| !is_fixed).for_each(|body| rows.extend(states(body, &STATES)));
    for index in schema.surfaces() {
        let [Some(analytic), Some(engine)] = runs.map(|run| run.contacts.get(index)) else { continue };
        if report.finger_count() == 1 || analytic.touchdowns + engine.touchdowns > 0 {
            let name = &schema.contacts[index].name;
            rows.extend(states(name, &STATES));
            rows.extend(CONTACTS.iter().filter_map(|(label, scale, digits, value)| {
                let [analytic, engine] = [value(analytic)?, value(engine)?].map(|value| value * scale);
                Some(Line { component: name, label, analytic, difference: engine - analytic, digits: *digits })
            }));
        }
    }
    rows.extend(states("", &ENERGIES));
    (heading, rows)
}

/// A quantity of both models, in its displayed unit.
struct Line<'a> {
    component: &'a str,
    label: &'static str,
    analytic: f64,
    difference: f64,
    /// Number of digits; 0 for a count.
    digits: usize,
}

impl Line<'_> {
    fn cells(&self) -> Vec<String> {
        let Line { component, label, analytic, difference, digits } = *self;
        let format = |value: f64| if digits == 0 { format!("{value}") } else { format_number(value, digits) };
        let label = format!("{} {label}", component.replace('_', " "));
        row([label.trim_start(), &format(analytic), &format(analytic + difference), &format_number(difference, 3)])
    }
}

/// Maximum number of impacts in the table; the JSON document contains all.
const MAX_IMPACTS: usize = 12;

fn impacts(impacts: &[ImpactPair]) -> Option<Report> {
    let milli = |value: Option<f64>, digits: usize| number(value.map(|value| value * 1e3), digits);
    let difference = |impact: &ImpactPair| {
        let both = impact.analytic_n_s.zip(impact.engine_n_s).filter(|(analytic, _)| *analytic != 0.0);
        both.map(|(analytic, engine)| 100.0 * (engine / analytic - 1.0))
    };
    let table = table_of(
        impacts.iter().take(MAX_IMPACTS),
        &[
            ("impact", &|impact| impact.site.clone()),
            ("analytic, ms", &|impact| milli(impact.analytic_s, 7)),
            ("engine, ms", &|impact| milli(impact.engine_s, 7)),
            ("for, µs", &|impact| format_number(impact.window_s * 1e6, 5)),
            ("impulse: analytic, mN·s", &|impact| milli(impact.analytic_n_s, 5)),
            ("engine, mN·s", &|impact| milli(impact.engine_n_s, 5)),
            ("difference, %", &|impact| number(difference(impact), 3)),
        ],
    );
    let omitted = impacts.len().saturating_sub(MAX_IMPACTS);
    (!impacts.is_empty()).then(|| table.with((omitted > 0).then(|| format!("and {omitted} more\n"))))
}

fn statistics(found: &Statistics) -> Report {
    let heading = format!(
        "mean ± deviation from {} on, for {} of {} runs with torques over ±{} %",
        format_duration(found.from_s),
        found.completed,
        found.runs,
        format_number(100.0 * found.torque_spread, 2)
    );
    let with_deviation =
        |mean: f64, deviation: f64| format!("{} ± {}", format_number(mean, 4), format_number(deviation, 2));
    table_of(
        &found.statistics,
        &[
            (&heading, &|it| it.name.to_string()),
            ("analytic", &|it| with_deviation(it.analytic_mean, it.analytic_deviation)),
            ("engine", &|it| with_deviation(it.engine_mean, it.engine_deviation)),
            ("difference, standard errors", &|it| format_number(it.standard_errors, 2)),
        ],
    )
}

fn settings(report: &ValidationReport, options: LadderOptions) -> Report {
    let (schema, ladder) = (&report.schema, &report.validation.ladder);
    let mut rows = vec![
        row(["speed against error", "runs", "steps", "wall, ms", "× real", "× everyday"]),
        row(["", "", "", "", "time", "analytic"]),
    ];
    for (figure, _) in figures(&TOTAL, schema, None, 0) {
        for (line, part) in rows.iter_mut().zip(figure.1.split_inclusive(' ')) {
            line.push(part.trim_end().to_string());
        }
    }
    let (mut notes, mut family) = (String::new(), "");
    for setting in ladder {
        if setting.family != family {
            family = setting.family;
            rows.push(row([family]));
        }
        let is_scenes = if setting.is_from_scene { " *" } else { "" };
        let is_reference = if setting.is_reference { " (reference)" } else { "" };
        let name = format!("  {}{is_scenes}{is_reference}", setting.setting);
        let Cost { steps, wall_s, real_time_factor, analytic_factor, .. } = setting.cost;
        rows.push(match steps {
            Some(steps) => {
                let runs = if setting.is_reference { "–".to_string() } else { setting.ensemble_runs.to_string() };
                let cost = [wall_s.map(|wall_s| wall_s * 1e3), real_time_factor, analytic_factor];
                let errors = figures(&TOTAL, schema, setting.differences.as_ref(), 0);
                let cells = [name, runs, steps.to_string()].into_iter().chain(cost.map(|value| number(value, 3)));
                cells.chain(errors.map(|(figure, value)| figure.cell(value))).collect()
            }
            None => {
                let has_failed = setting.status == Status::Failed;
                let (cell, note) = if has_failed { ("failed", "") } else { ("omitted", "omitted, ") };
                let reason = setting.reason.as_deref().unwrap_or_default();
                notes.push_str(&format!("{family}, {}: {note}{reason}\n", setting.setting));
                row([&name, "–", "–", cell])
            }
        });
    }
    let mut text = Report::from(Table::new(&rows).header_rows(2));
    text.push_str(
        "largest differences from the reference over the runs; * the scene's settings; median wall time without a log\n",
    );
    if options.quick {
        text.push_str("omitted by --quick: fixed steps below 1e-5 s\n");
    }
    if ladder.iter().any(|setting| setting.status == Status::NoTime) {
        let limit = format_duration(options.time_s);
        text.push_str(&format!("settings were omitted to keep the ladder within {limit} (--ladder-time)\n"));
    }
    text.push_str(&notes);
    text
}
