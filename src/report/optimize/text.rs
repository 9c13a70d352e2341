//! Text report of an optimisation.

use super::document::{OptimisationReport, scene_file, selected_designs};
use crate::format::numbers::format_number;
use crate::format::quantity::Quantity;
use crate::format::report::{Cell, CellStyle, Report, Table, ToReport, table};
use crate::report::sweep::reasons;
use crate::study::optimize::{Design, Goal, Limit, Objective, Optimisation, OptimisationResult, gain};
use crate::study::select::CLASSES;
use crate::study::sweep::Status;
use crate::table::Value;

/// Comparison with the start, Pareto front and number of runs.
impl ToReport for OptimisationReport<'_> {
    fn report(&self) -> Report {
        let OptimisationReport { optimisation, found, max_designs, .. } = self;
        let mut text = Report::from(format!("{}\n\n", headline(optimisation)));
        text.push(comparison_table(optimisation, found, self.has_scenes));
        if found.front.is_empty() {
            text.push(Report::paragraph(&format!("\n{}\n", no_front(optimisation, found))));
        } else if optimisation.objectives.len() > 1 {
            text.push('\n');
            text.push(front(optimisation, found, *max_designs));
        }
        text.push_str(&reasons(&self.reasons));
        text.push(Report::paragraph(&format!("\n{}\n", counts(self))));
        text
    }
}

/// Lists the search space, objectives and constraints without running the search.
pub fn optimisation_list(optimisation: &Optimisation) -> Report {
    let mut text = Report::from(format!("{}\n\n", headline(optimisation)));
    let header = ["variable", "from", "to", "start"].map(String::from).to_vec();
    let line = |(variable, label): (&crate::study::optimize::Variable, String)| {
        let quantity = Quantity::for_column(&variable.column());
        let [from, to] = variable.bounds().map(|point| quantity.value(&point.value, 4));
        vec![label, from, to, quantity.value(&variable.start().value, 4)]
    };
    let rows = optimisation.variables.iter().zip(variable_labels(optimisation)).map(line);
    text.push(table(&std::iter::once(header).chain(rows).collect::<Vec<_>>()));
    for objective in &optimisation.objectives {
        text.push_str(&format!("\nobjective   {}", describe_objective(optimisation, objective)));
    }
    for index in 0..optimisation.constraints.len() {
        text.push_str(&format!("\nconstraint  {}", describe_constraint(optimisation, index)));
    }
    text.push_str(&format!(
        "\n\nat most {} designs, {} runs\n",
        optimisation.max_design_count(),
        optimisation.max_runs()
    ));
    text
}

/// Describes an objective.
fn describe_objective(optimisation: &Optimisation, objective: &Objective) -> String {
    let goal = if objective.goal == Goal::Min { "small" } else { "large" };
    let over = match (optimisation.conditions(), objective.condition_aggregation) {
        (1, _) => "",
        (_, crate::study::optimize::ConditionAggregation::Worst) => ", worst of all conditions",
        (_, crate::study::optimize::ConditionAggregation::Mean) => ", mean of all conditions",
    };
    format!("{} {goal}{over}", objective.figure.name)
}

/// Returns the names of the variables with units: the last component of the path, preceded by its parent if the name is
/// not unique.
pub(super) fn variable_labels(optimisation: &Optimisation) -> Vec<String> {
    let labels: Vec<String> =
        optimisation.variables.iter().map(|variable| Quantity::for_column(&variable.column()).label()).collect();
    let unique_label = |(variable, label): (&crate::study::optimize::Variable, &String)| {
        let parent = variable.path().rsplit('.').nth(1);
        match (labels.iter().filter(|other| *other == label).count(), parent) {
            (2.., Some(parent)) => format!("{parent}.{label}"),
            _ => label.clone(),
        }
    };
    optimisation.variables.iter().zip(&labels).map(unique_label).collect()
}

/// Describes a constraint.
fn describe_constraint(optimisation: &Optimisation, index: usize) -> String {
    let constraint = &optimisation.constraints[index];
    let quantity = Quantity::for_column(&constraint.column);
    let formatted = |value: f64| {
        let gap = if quantity.unit.is_empty() { "" } else { " " };
        format!("{}{gap}{}", quantity.number(value, 6), quantity.unit)
    };
    let name = &quantity.name;
    match &constraint.limit {
        Limit::Between { at_least: Some(least), at_most: Some(most) } => {
            format!("{name} from {} to {}", formatted(*least), formatted(*most))
        }
        Limit::Between { at_least: Some(least), at_most: None } => format!("{name} ≥ {}", formatted(*least)),
        Limit::Between { at_most, .. } => format!("{name} ≤ {}", at_most.map_or(String::new(), formatted)),
        Limit::Flag(true) => name.clone(),
        Limit::Flag(false) => format!("not {name}"),
        Limit::Equals(word) => format!("{name} {word}"),
        Limit::Class(rank) => format!("at least {}", CLASSES[*rank].name()),
    }
}

fn headline(optimisation: &Optimisation) -> String {
    let conditions = match optimisation.conditions() {
        1 => "one condition".to_string(),
        count => format!("{count} conditions"),
    };
    format!(
        "{}: {} model, {}, generations of {} designs, {conditions}",
        optimisation.name(),
        optimisation.study().model.name(),
        optimisation.method.algorithm.name(),
        optimisation.method.population
    )
}

/// Returns a table of the start and the selected designs: variables, objectives, gains, worst constraint values, and
/// the scene files if `has_scenes`.
pub(super) fn comparison_table(optimisation: &Optimisation, found: &OptimisationResult, has_scenes: bool) -> Table {
    let (selected, labels) = (selected_designs(optimisation, found), variable_labels(optimisation));
    let mut designs: Vec<&Design> = vec![found.start()];
    designs.extend(selected.iter().map(|(_, index)| &found.designs[*index]));
    let objective_of = |role: &str| {
        optimisation.objectives.iter().find(|objective| role.strip_prefix("best ") == Some(&objective.figure.name))
    };
    let names = selected.iter().map(|(role, _)| match objective_of(role) {
        Some(objective) => format!("best {}", objective_quantity(objective).name),
        None => role.clone(),
    });
    let header = ["design".to_string(), "start".to_string()].into_iter().chain(names).map(Cell::new).collect();
    let mut rows: Vec<Vec<Cell>> = vec![header];
    let mut line = |name: &str, cell: &dyn Fn(&Design) -> Cell| {
        rows.push(std::iter::once(Cell::new(name)).chain(designs.iter().map(|design| cell(design))).collect());
    };
    line("number", &|design| Cell::new(design.number.to_string()));
    for (index, variable) in optimisation.variables.iter().enumerate() {
        let quantity = Quantity::for_column(&variable.column());
        line(&labels[index], &|design| Cell::new(quantity.value(&design.points[index].value, 4)));
    }
    for (index, objective) in optimisation.objectives.iter().enumerate() {
        let quantity = objective_quantity(objective);
        line(&quantity.label(), &|design| match design.evaluation.values[index] {
            Some(value) => {
                Cell { figure: Some((objective.figure.name.clone(), value)), ..Cell::new(quantity.number(value, 5)) }
            }
            None => Cell::new("–"),
        });
        let start = found.start().evaluation.values[index];
        line("  gain, %", &|design| match gain(objective.goal, start, design.evaluation.values[index])
            .filter(|_| design.number != 1)
        {
            Some(ratio) => Cell {
                style: if ratio >= 0.0 { CellStyle::Good } else { CellStyle::Bad },
                ..Cell::new(format!("{:+.1}", 100.0 * ratio).replace('-', "−"))
            },
            None => Cell::new(""),
        });
    }
    for (index, constraint) in optimisation.constraints.iter().enumerate() {
        let quantity = Quantity::for_column(&constraint.column);
        line(&describe_constraint(optimisation, index), &|design| match &design.evaluation.worst[index] {
            Value::Flag(flag) => Cell::new(if *flag { "yes" } else { "no" }),
            value => Cell::new(quantity.value(value, 4)),
        });
    }
    line("meets all", &|design| Cell::new(if design.is_feasible() { "yes" } else { "no" }));
    if has_scenes {
        let files = designs[1..].iter().map(|design| scene_file(found, design));
        rows.push(["scene", "start.toml"].map(String::from).into_iter().chain(files).map(Cell::new).collect());
    }
    Table::new(&rows)
}

/// Returns the quantity of an objective, in the unit of its columns.
fn objective_quantity(objective: &Objective) -> Quantity {
    Quantity::new(&objective.figure.name, &objective.figure.column_type)
}

/// Returns a table of designs of the front: objectives and variables. The numbers link to the scenes.
pub(super) fn front_table(optimisation: &Optimisation, found: &OptimisationResult, indices: &[usize]) -> Table {
    let quantities: Vec<Quantity> =
        optimisation.variables.iter().map(|variable| Quantity::for_column(&variable.column())).collect();
    let objectives: Vec<Quantity> = optimisation.objectives.iter().map(objective_quantity).collect();
    let labels = objectives.iter().map(Quantity::label).chain(variable_labels(optimisation));
    let header = std::iter::once("design".to_string()).chain(labels).map(Cell::new).collect();
    let row = |index: &usize| {
        let design = &found.designs[*index];
        let values = objectives.iter().zip(&design.evaluation.values);
        let values = values.map(|(quantity, value)| value.map_or("–".to_string(), |value| quantity.number(value, 5)));
        let variables = quantities.iter().zip(&design.points).map(|(quantity, point)| quantity.value(&point.value, 4));
        let number = Cell { link: Some(format!("design-{}", design.number)), ..Cell::new(design.number.to_string()) };
        std::iter::once(number).chain(values.chain(variables).map(Cell::new)).collect()
    };
    let rows: Vec<Vec<Cell>> = std::iter::once(header).chain(indices.iter().map(row)).collect();
    Table::new(&rows)
}

/// Returns a table of at most `max_designs` designs of the front, evenly spaced.
fn front(optimisation: &Optimisation, found: &OptimisationResult, max_designs: usize) -> Report {
    let shown = evenly_spaced(&found.front, max_designs);
    let count = if shown.len() < found.front.len() { format!(", {} shown", shown.len()) } else { String::new() };
    Report::from(format!("front: {} designs{count}\n", found.front.len())).with(front_table(
        optimisation,
        found,
        &shown,
    ))
}

/// Selects at most `count` entries of a list, evenly spaced and including both ends.
fn evenly_spaced(all: &[usize], count: usize) -> Vec<usize> {
    if all.len() <= count || count < 2 {
        return all.iter().copied().take(count.max(1)).collect();
    }
    (0..count).map(|index| all[index * (all.len() - 1) / (count - 1)]).collect()
}

/// Explains why there is no front.
fn no_front(optimisation: &Optimisation, found: &OptimisationResult) -> String {
    let least =
        found.designs.iter().min_by(|a, b| a.evaluation.score.violation.total_cmp(&b.evaluation.score.violation));
    let nearest = least.map_or(String::new(), |design| {
        let runs = design.evaluation.by_status.iter().sum::<u64>();
        let constraints = optimisation.constraints.iter().zip(&design.evaluation.worst).enumerate();
        let descriptions: Vec<String> = constraints
            .map(|(index, (constraint, worst))| {
                format!(
                    "{} ({})",
                    describe_constraint(optimisation, index),
                    Quantity::for_column(&constraint.column).value(worst, 4)
                )
            })
            .collect();
        format!(
            " The closest is design {} (violation {}, {} of {runs} runs completed): {}.",
            design.number,
            format_number(design.evaluation.score.violation, 3),
            design.evaluation.by_status[0],
            descriptions.join("; ")
        )
    });
    format!(
        "None of {} designs meets all constraints.{nearest} Widen the variables, relax a constraint, or search longer.",
        found.designs.len()
    )
}

fn counts(report: &OptimisationReport<'_>) -> String {
    let statuses: Vec<String> = Status::ALL
        .iter()
        .zip(report.found.by_status())
        .filter(|(_, count)| *count > 0)
        .map(|(status, count)| format!("{count} {}", status.name()))
        .collect();
    let converged = if report.is_converged { ", converged" } else { "" };
    let work = &report.work;
    let front = match report.objectives.len() {
        1 => String::new(),
        _ => format!(", {} on the front", report.front.len()),
    };
    let mut text = format!(
        "{} designs in {} generations{converged}: {} meet all constraints{front}. {} runs: {}.",
        report.designs,
        report.generations,
        report.feasible_designs,
        report.runs,
        statuses.join(", ")
    );
    if work.runs < report.runs {
        text.push_str(&format!("\n{} runs existed already.", report.runs - work.runs));
    }
    if work.simulations > 0 {
        let threads = if work.threads == 1 { "1 thread".to_string() } else { format!("{} threads", work.threads) };
        text.push_str(&format!(
            "\n{} simulations in {} s on {threads}: {} per second.",
            work.simulations,
            format_number(work.wall_s, 3),
            format_number(work.simulations_per_s, 3)
        ));
    }
    text
}
