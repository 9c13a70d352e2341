//! A selection as tables for people.

use super::document::SelectionReport;
use crate::criteria::Class;
use crate::study::select::{CLASSES, Candidate, Ranked, Selection};
use crate::study::sweep::{Reason, Status};
use crate::units::Dimension;
use crate::wording::figures::{figure, resolved, row};
use crate::wording::quantity::Quantity;
use crate::wording::report::{Report, Reported, table};
use crate::wording::{condition_name, criterion_name, percent_of};

/// Tables: classes, what each criterion removed, and the best of those that are left.
impl Reported for SelectionReport<'_> {
    fn report(&self) -> Report {
        let SelectionReport { source, selection, most, .. } = self;
        let [runs, designs] = [runs(self.runs), designs(self.designs)];
        let mut text = Report::from(format!("{source}: {runs} of {designs}\n"));
        text.push_str(&unfinished(selection));
        text.push('\n');
        text.push(classes(selection));
        text.push_str(&reasons(selection));
        text.push('\n');
        text.push(criteria(selection));
        text.push('\n');
        text.push(ranking(selection, *most));
        text
    }
}

fn runs(count: usize) -> String {
    if count == 1 { "1 run".to_string() } else { format!("{count} runs") }
}

fn designs(count: usize) -> String {
    if count == 1 { "1 design".to_string() } else { format!("{count} designs") }
}

/// A warning if runs are missing; nothing else is known of them.
fn unfinished(selection: &Selection) -> String {
    match selection.missing_runs.len() {
        0 => String::new(),
        missing => format!(
            "{} up to the last are missing (first: run {}): the sweep was not finished, and they cannot be selected\n",
            runs(missing),
            selection.missing_runs[0]
        ),
    }
}

/// Static and dynamic classes, a column for each condition.
fn classes(selection: &Selection) -> Report {
    let head = std::iter::once("class".to_string()).chain(selection.conditions.iter().map(condition_name));
    let mut rows = vec![head.collect::<Vec<_>>()];
    let mut line = |name: &str, count: &dyn Fn(usize) -> (usize, usize)| {
        let cell = |condition: usize| {
            let (count, of) = count(condition);
            format!("{count} ({})", percent_of(count, of))
        };
        let cells = (0..selection.conditions.len()).map(cell);
        rows.push(std::iter::once(name.to_string()).chain(cells).collect());
    };
    for (index, status) in Status::ALL.into_iter().enumerate() {
        if status == Status::Completed || selection.classes.iter().any(|of| of.statuses[index] > 0) {
            line(status.name(), &|condition| {
                (selection.classes[condition].statuses[index], selection.classes[condition].runs)
            });
        }
    }
    let all = |condition: usize| selection.classes[condition].runs;
    if !selection.cannot_grasp.is_empty() {
        line("cannot grasp", &|condition| (selection.classes[condition].cannot_grasp, all(condition)));
    }
    line("statically stable", &|condition| (selection.classes[condition].statically_stable, all(condition)));
    line("form-closed", &|condition| (selection.classes[condition].form_closed, all(condition)));
    for (index, class) in CLASSES.into_iter().enumerate() {
        line(class.name(), &|condition| (selection.classes[condition].dynamic[index], all(condition)));
    }
    line("stable or semi-stable", &|condition| (selection.classes[condition].dynamically_stable(), all(condition)));
    table(&rows)
}

/// What decides the classes, and why some runs have none.
fn reasons(selection: &Selection) -> String {
    let mut text = String::new();
    if !selection.class_reasons.is_empty() {
        text.push_str("\nwhat decides the class (figures are those of the first run)\n");
    }
    for Reason { status, reason, runs, first_run } in &selection.class_reasons {
        text.push_str(&format!("{runs:>7} {status}, first run {first_run}: {reason}\n"));
    }
    if !selection.cannot_grasp.is_empty() {
        text.push_str("\nwithout a class (figures are those of the first run)\n");
    }
    for Reason { reason, runs, first_run, .. } in &selection.cannot_grasp {
        let rows = if *runs == 1 { "row" } else { "rows" };
        text.push_str(&format!("{runs:>7} {rows} cannot grasp, first run {first_run}: {reason}\n"));
    }
    text
}

/// What each criterion removed.
fn criteria(selection: &Selection) -> Report {
    let mut rows = vec![row(["criterion", "holds", "fails", "unknown", "left", "removed by it alone"])];
    for tally in &selection.tallies {
        let counts = [tally.holds, tally.fails, tally.unknown, tally.left, tally.only];
        let cells = counts.iter().map(usize::to_string);
        rows.push(std::iter::once(criterion_name(&tally.criterion)).chain(cells).collect());
    }
    let mut text = table(&rows);
    text.push_str(
        "\"left\" counts runs that meet this criterion and all above it; \"removed by it alone\" those that meet all the \
         others.\n",
    );
    text
}

/// The best ones with their figures, and the parts of r_WC.
fn ranking(selection: &Selection, most: usize) -> Report {
    if selection.ranking.is_empty() {
        return Report::from(nothing(selection));
    }
    let axes: Vec<(usize, Quantity)> = shown_axes(selection);
    let head = ["place", "run", "design"].into_iter().map(String::from);
    let head = head.chain(axes.iter().map(|(_, quantity)| quantity.label()));
    let figures = ["PFP, N", "tts, ms", "F21, N", "F22, N", "r(PFP)", "1−r(tts)", "1−r(F21)", "r(F22)", "r_WC"];
    let mut rows = vec![head.chain(figures.into_iter().map(String::from)).collect::<Vec<_>>()];
    let line = |ranked: &Ranked| {
        let run = &selection.runs[ranked.run_index];
        let force = |value: Option<f64>| value.map_or("–".to_string(), |n| figure(resolved(n, Dimension::Force), 4));
        let fixed = |value: f64| if value.is_nan() { "–".to_string() } else { format!("{value:.3}") };
        let mut cells = vec![ranked.place.to_string(), run.run.to_string(), run.design.to_string()];
        cells.extend(axes.iter().map(|(axis, quantity)| quantity.value(&run.axes[*axis], 4)));
        let tts_ms = run.tts_s.map_or("–".to_string(), |tts_s| figure(tts_s * 1e3, 4));
        cells.extend([force(run.pfp_n), tts_ms, force(run.f21_n), force(run.f22_n)]);
        let parts = ranked.parts;
        cells.extend([parts.pfp, parts.tts, parts.f21, parts.f22, ranked.r_wc].map(fixed));
        cells
    };
    rows.extend(selection.ranking.iter().take(most).map(line));
    let weights = selection.weights.named().map(|(name, weight)| format!("{name} {weight}")).join(", ");
    let best = format!(
        "{} of {} meet all criteria; best {} by r_WC (weights: {weights})\n",
        selection.ranking.len(),
        runs(selection.runs.len()),
        most.min(selection.ranking.len()),
    );
    Report::from(best).and(table(&rows)).and(equal(selection)).and(decided(selection, most))
}

/// What decides the class of those shown that are not stable.
fn decided(selection: &Selection, most: usize) -> String {
    let shown = selection.ranking.iter().take(most).map(|ranked| &selection.runs[ranked.run_index]);
    let line = |run: &Candidate| {
        let class = run.class.filter(|class| *class != Class::Stable)?;
        Some(format!("run {} is {}: {}\n", run.run, class.name(), run.class_reason.as_ref()?))
    };
    shown.filter_map(line).collect()
}

/// Axes that have more than one value.
fn shown_axes(selection: &Selection) -> Vec<(usize, Quantity)> {
    let axes = selection.axes.iter().enumerate().filter(|(_, axis)| axis.values.len() > 1);
    axes.map(|(index, axis)| (index, Quantity::of(&axis.column))).collect()
}

/// Which parts could not tell the selected ones apart.
fn equal(selection: &Selection) -> String {
    let all = |figure: fn(&crate::study::select::Candidate) -> Option<f64>| {
        let mut values = selection.ranking.iter().map(|ranked| figure(&selection.runs[ranked.run_index]));
        let first = values.next().flatten();
        values.all(|value| value == first)
    };
    let same: Vec<&str> = [
        ("PFP", all(|run| run.pfp_n)),
        ("tts", all(|run| run.tts_s)),
        ("F21", all(|run| run.f21_n)),
        ("F22", all(|run| run.f22_n)),
    ]
    .into_iter()
    .filter_map(|(name, same)| same.then_some(name))
    .collect();
    match (same.is_empty(), selection.ranking.len()) {
        (true, _) => String::new(),
        (false, 1) => {
            "Only one is left, so there is nothing to scale it against: every part counts as ½.\n".to_string()
        }
        (false, _) => format!("{} is the same for all selected: its part counts as ½ for each.\n", same.join(", ")),
    }
}

/// Which criterion removed the last, and what would be left without one of them.
fn nothing(selection: &Selection) -> String {
    let Some(last) = selection.emptied_by() else { return String::new() };
    let mut text = format!("no run meets all criteria: \"{}\" removed the last\n", criterion_name(&last.criterion));
    let alone: Vec<String> = selection
        .tallies
        .iter()
        .filter(|tally| tally.only > 0)
        .map(|tally| format!("{} without \"{}\"", tally.only, criterion_name(&tally.criterion)))
        .collect();
    text.push_str(&match alone.is_empty() {
        true => "leaving out a single criterion does not help: every run fails two or more\n".to_string(),
        false => format!("there would be {}\n", alone.join(", ")),
    });
    text
}
