//! Text report of a selection.

use super::document::SelectionReport;
use crate::criteria::Class;
use crate::format::numbers::{format_number, row, zero_below_resolution};
use crate::format::quantity::Quantity;
use crate::format::report::{Report, ToReport, table};
use crate::format::{condition_name, criterion_name, percent_of};
use crate::study::select::{CLASSES, Candidate, Ranked, Selection};
use crate::study::sweep::{Reason, Status};
use crate::units::Dimension;

/// Tables of classes, criteria and the best remaining runs.
impl ToReport for SelectionReport<'_> {
    fn report(&self) -> Report {
        let SelectionReport { source, selection, max_ranked, .. } = self;
        let [runs, designs] = [count_runs(self.runs), count_designs(self.designs)];
        let mut text = Report::from(format!("{source}: {runs} of {designs}\n"));
        text.push_str(&missing_runs(selection));
        text.push('\n');
        text.push(classes(selection));
        text.push_str(&reasons(selection));
        text.push('\n');
        text.push(criteria(selection));
        text.push('\n');
        text.push(ranking(selection, *max_ranked));
        text
    }
}

fn count_runs(count: usize) -> String {
    if count == 1 { "1 run".to_string() } else { format!("{count} runs") }
}

fn count_designs(count: usize) -> String {
    if count == 1 { "1 design".to_string() } else { format!("{count} designs") }
}

/// Returns a warning if runs are missing from the results.
fn missing_runs(selection: &Selection) -> String {
    match selection.missing_runs.len() {
        0 => String::new(),
        missing => format!(
            "{} before the last are missing (first: run {}): the sweep is not finished, and they cannot be selected\n",
            count_runs(missing),
            selection.missing_runs[0]
        ),
    }
}

/// Returns a table of static and dynamic classes with a column for each condition.
fn classes(selection: &Selection) -> Report {
    let header = std::iter::once("class".to_string()).chain(selection.conditions.iter().map(condition_name));
    let mut rows = vec![header.collect::<Vec<_>>()];
    let mut line = |name: &str, count: &dyn Fn(usize) -> (usize, usize)| {
        let cell = |condition: usize| {
            let (count, total) = count(condition);
            format!("{count} ({})", percent_of(count, total))
        };
        let cells = (0..selection.conditions.len()).map(cell);
        rows.push(std::iter::once(name.to_string()).chain(cells).collect());
    };
    for (index, status) in Status::ALL.into_iter().enumerate() {
        if status == Status::Completed || selection.classes.iter().any(|counts| counts.statuses[index] > 0) {
            line(status.name(), &|condition| {
                (selection.classes[condition].statuses[index], selection.classes[condition].runs)
            });
        }
    }
    let runs = |condition: usize| selection.classes[condition].runs;
    if !selection.cannot_grasp.is_empty() {
        line("cannot grasp", &|condition| (selection.classes[condition].cannot_grasp, runs(condition)));
    }
    line("statically stable", &|condition| (selection.classes[condition].statically_stable, runs(condition)));
    line("form-closed", &|condition| (selection.classes[condition].form_closed, runs(condition)));
    for (index, class) in CLASSES.into_iter().enumerate() {
        line(class.name(), &|condition| (selection.classes[condition].dynamic[index], runs(condition)));
    }
    line("stable or semi-stable", &|condition| (selection.classes[condition].dynamically_stable(), runs(condition)));
    table(&rows)
}

/// Returns the reasons for the classes, and why some runs have none.
fn reasons(selection: &Selection) -> String {
    let mut text = String::new();
    if !selection.class_reasons.is_empty() {
        text.push_str("\nreasons for the class (numbers from the first run)\n");
    }
    for Reason { status, reason, runs, first_run } in &selection.class_reasons {
        text.push_str(&format!("{runs:>7} {status}, first run {first_run}: {reason}\n"));
    }
    if !selection.cannot_grasp.is_empty() {
        text.push_str("\nwithout a class (numbers from the first run)\n");
    }
    for Reason { reason, runs, first_run, .. } in &selection.cannot_grasp {
        let rows = if *runs == 1 { "row" } else { "rows" };
        text.push_str(&format!("{runs:>7} {rows} cannot grasp, first run {first_run}: {reason}\n"));
    }
    text
}

/// Returns a table of the runs that each criterion removed.
fn criteria(selection: &Selection) -> Report {
    let mut rows = vec![row(["criterion", "holds", "fails", "unknown", "left", "removed by it alone"])];
    for tally in &selection.tallies {
        let counts = [tally.holds, tally.fails, tally.unknown, tally.remaining, tally.removed_alone];
        let cells = counts.iter().map(usize::to_string);
        rows.push(std::iter::once(criterion_name(&tally.criterion)).chain(cells).collect());
    }
    let mut text = table(&rows);
    text.push_str(
        "\"left\" counts runs that meet this criterion and all above it; \"removed by it alone\" counts runs that meet all \
         others.\n",
    );
    text
}

/// Returns a table of the best runs with their values and the terms of r_WC.
fn ranking(selection: &Selection, max_ranked: usize) -> Report {
    if selection.ranking.is_empty() {
        return Report::from(no_selection(selection));
    }
    let axes: Vec<(usize, Quantity)> = varied_axes(selection);
    let header = ["rank", "run", "design"].into_iter().map(String::from);
    let header = header.chain(axes.iter().map(|(_, quantity)| quantity.label()));
    let columns = ["PFP, N", "tts, ms", "F21, N", "F22, N", "r(PFP)", "1−r(tts)", "1−r(F21)", "r(F22)", "r_WC"];
    let mut rows = vec![header.chain(columns.into_iter().map(String::from)).collect::<Vec<_>>()];
    let line = |ranked: &Ranked| {
        let run = &selection.runs[ranked.run_index];
        let force = |value: Option<f64>| {
            value.map_or("–".to_string(), |n| format_number(zero_below_resolution(n, Dimension::Force), 4))
        };
        let fixed = |value: f64| if value.is_nan() { "–".to_string() } else { format!("{value:.3}") };
        let mut cells = vec![ranked.rank.to_string(), run.run.to_string(), run.design.to_string()];
        cells.extend(axes.iter().map(|(axis, quantity)| quantity.value(&run.axes[*axis], 4)));
        let tts_ms = run.tts_s.map_or("–".to_string(), |tts_s| format_number(tts_s * 1e3, 4));
        cells.extend([force(run.pfp_n), tts_ms, force(run.f21_n), force(run.f22_n)]);
        let terms = ranked.terms;
        cells.extend([terms.pfp, terms.tts, terms.f21, terms.f22, ranked.r_wc].map(fixed));
        cells
    };
    rows.extend(selection.ranking.iter().take(max_ranked).map(line));
    let weights = selection.weights.named().map(|(name, weight)| format!("{name} {weight}")).join(", ");
    let best = format!(
        "{} of {} meet all criteria; best {} by r_WC (weights: {weights})\n",
        selection.ranking.len(),
        count_runs(selection.runs.len()),
        max_ranked.min(selection.ranking.len()),
    );
    Report::from(best).with(table(&rows)).with(equal_terms(selection)).with(class_reasons(selection, max_ranked))
}

/// Returns the reasons for the class of the displayed runs that are not stable.
fn class_reasons(selection: &Selection, max_ranked: usize) -> String {
    let shown = selection.ranking.iter().take(max_ranked).map(|ranked| &selection.runs[ranked.run_index]);
    let line = |run: &Candidate| {
        let class = run.class.filter(|class| *class != Class::Stable)?;
        Some(format!("run {} is {}: {}\n", run.run, class.name(), run.class_reason.as_ref()?))
    };
    shown.filter_map(line).collect()
}

/// Returns the axes with more than one value.
fn varied_axes(selection: &Selection) -> Vec<(usize, Quantity)> {
    let axes = selection.axes.iter().enumerate().filter(|(_, axis)| axis.values.len() > 1);
    axes.map(|(index, axis)| (index, Quantity::for_column(&axis.column))).collect()
}

/// Reports the terms that are equal for all selected runs.
fn equal_terms(selection: &Selection) -> String {
    let is_equal = |value: fn(&crate::study::select::Candidate) -> Option<f64>| {
        let mut values = selection.ranking.iter().map(|ranked| value(&selection.runs[ranked.run_index]));
        let first = values.next().flatten();
        values.all(|value| value == first)
    };
    let equal: Vec<&str> = [
        ("PFP", is_equal(|run| run.pfp_n)),
        ("tts", is_equal(|run| run.tts_s)),
        ("F21", is_equal(|run| run.f21_n)),
        ("F22", is_equal(|run| run.f22_n)),
    ]
    .into_iter()
    .filter_map(|(name, is_equal)| is_equal.then_some(name))
    .collect();
    match (equal.is_empty(), selection.ranking.len()) {
        (true, _) => String::new(),
        (false, 1) => "Only one run is left, so its terms cannot be scaled: every term counts as ½.\n".to_string(),
        (false, _) => format!("equal for all selected runs: {}; the term counts as ½ for each\n", equal.join(", ")),
    }
}

/// Reports which criterion removed the last run, and what would be left without a single criterion.
fn no_selection(selection: &Selection) -> String {
    let Some(last) = selection.emptied_by() else { return String::new() };
    let mut text = format!("no run meets all criteria: \"{}\" removed the last run\n", criterion_name(&last.criterion));
    let sole_failures: Vec<String> = selection
        .tallies
        .iter()
        .filter(|tally| tally.removed_alone > 0)
        .map(|tally| format!("{} without \"{}\"", tally.removed_alone, criterion_name(&tally.criterion)))
        .collect();
    text.push_str(&match sole_failures.is_empty() {
        true => "omitting a single criterion does not help: every run fails two or more\n".to_string(),
        false => format!("runs that would be left: {}\n", sole_failures.join(", ")),
    });
    text
}
