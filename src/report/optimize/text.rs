//! Tables for people.

use super::document::{OptimisationReport, chosen, scene_file};
use crate::report::sweep::reasons;
use crate::study::optimize::{Design, Found, Goal, Limit, Objective, Optimisation, gain};
use crate::study::select::CLASSES;
use crate::study::sweep::Status;
use crate::table::Value;
use crate::wording::figures::figure;
use crate::wording::quantity::Quantity;
use crate::wording::report::{Cell, Report, Reported, Table, Tone, table};

/// What is compared with the start, the front, and what it took.
impl Reported for OptimisationReport<'_> {
    fn report(&self) -> Report {
        let OptimisationReport { of, found, most, .. } = self;
        let mut text = Report::from(format!("{}\n\n", headline(of)));
        text.push(compared(of, found, self.scenes));
        if found.front.is_empty() {
            text.push(Report::paragraph(&format!("\n{}\n", nothing(of, found))));
        } else if of.objectives.len() > 1 {
            text.push('\n');
            text.push(front(of, found, *most));
        }
        text.push_str(&reasons(&self.reasons));
        text.push(Report::paragraph(&format!("\n{}\n", counts(self))));
        text
    }
}

/// What would be searched, without a run.
pub fn optimisation_list(of: &Optimisation) -> Report {
    let mut text = Report::from(format!("{}\n\n", headline(of)));
    let head = ["variable", "from", "to", "start"].map(String::from).to_vec();
    let line = |(variable, label): (&crate::study::optimize::Variable, String)| {
        let quantity = Quantity::of(&variable.column());
        let [from, to] = variable.bounds().map(|point| quantity.value(&point.value, 4));
        vec![label, from, to, quantity.value(&variable.start().value, 4)]
    };
    let rows = of.variables.iter().zip(variable_labels(of)).map(line);
    text.push(table(&std::iter::once(head).chain(rows).collect::<Vec<_>>()));
    for objective in &of.objectives {
        text.push_str(&format!("\nobjective   {}", objective_words(of, objective)));
    }
    for at in 0..of.constraints.len() {
        text.push_str(&format!("\nconstraint  {}", constraint_words(of, at)));
    }
    text.push_str(&format!("\n\nat most {} designs, {} runs\n", of.most_designs(), of.most_runs()));
    text
}

/// An objective in words.
fn objective_words(of: &Optimisation, objective: &Objective) -> String {
    let goal = if objective.goal == Goal::Min { "small" } else { "large" };
    let over = match (of.conditions(), objective.over) {
        (1, _) => "",
        (_, crate::study::optimize::Over::Worst) => ", the worst of all conditions",
        (_, crate::study::optimize::Over::Mean) => ", the mean of all conditions",
    };
    format!("{} {goal}{over}", objective.figure.name)
}

/// Names of the variables with their units: the last part of a path, and what stands before it where two end alike.
pub(super) fn variable_labels(of: &Optimisation) -> Vec<String> {
    let labels: Vec<String> = of.variables.iter().map(|of| Quantity::of(&of.column()).label()).collect();
    let one = |(variable, label): (&crate::study::optimize::Variable, &String)| {
        let above = variable.path().rsplit('.').nth(1);
        match (labels.iter().filter(|other| *other == label).count(), above) {
            (2.., Some(above)) => format!("{above}.{label}"),
            _ => label.clone(),
        }
    };
    of.variables.iter().zip(&labels).map(one).collect()
}

/// A constraint in words.
pub(super) fn constraint_words(of: &Optimisation, index: usize) -> String {
    let constraint = &of.constraints[index];
    let quantity = Quantity::of(&constraint.column);
    let said = |value: f64| {
        let gap = if quantity.unit.is_empty() { "" } else { " " };
        format!("{}{gap}{}", quantity.number(value, 6), quantity.unit)
    };
    let name = &quantity.name;
    match &constraint.limit {
        Limit::Between { at_least: Some(least), at_most: Some(most) } => {
            format!("{name} from {} to {}", said(*least), said(*most))
        }
        Limit::Between { at_least: Some(least), at_most: None } => format!("{name} ≥ {}", said(*least)),
        Limit::Between { at_most, .. } => format!("{name} ≤ {}", at_most.map_or(String::new(), said)),
        Limit::Flag(true) => name.clone(),
        Limit::Flag(false) => format!("not {name}"),
        Limit::Word(word) => format!("{name} {word}"),
        Limit::Class(rank) => format!("at least {}", CLASSES[*rank].name()),
    }
}

fn headline(of: &Optimisation) -> String {
    let conditions = match of.conditions() {
        1 => "one condition".to_string(),
        count => format!("{count} conditions"),
    };
    format!(
        "{}: {} model, {}, generations of {} designs, {conditions}",
        of.name(),
        of.study().model.name(),
        of.method.algorithm.name(),
        of.method.population
    )
}

/// The start beside the best ones: variables, objectives, what is gained, the worst of the constraints, and their `scenes`.
pub(super) fn compared(of: &Optimisation, found: &Found, scenes: bool) -> Table {
    let (chosen, labels) = (chosen(of, found), variable_labels(of));
    let mut designs: Vec<&Design> = vec![found.start()];
    designs.extend(chosen.iter().map(|(_, index)| &found.designs[*index]));
    let goal = |name: &str| of.objectives.iter().find(|of| name.strip_prefix("best ") == Some(&of.figure.name));
    let names = chosen.iter().map(|(name, _)| match goal(name) {
        Some(of) => format!("best {}", goal_of(of).name),
        None => name.clone(),
    });
    let head = ["design".to_string(), "start".to_string()].into_iter().chain(names).map(Cell::new).collect();
    let mut rows: Vec<Vec<Cell>> = vec![head];
    let mut line = |name: &str, cell: &dyn Fn(&Design) -> Cell| {
        rows.push(std::iter::once(Cell::new(name)).chain(designs.iter().map(|design| cell(design))).collect());
    };
    line("number", &|design| Cell::new(design.number.to_string()));
    for (at, variable) in of.variables.iter().enumerate() {
        let quantity = Quantity::of(&variable.column());
        line(&labels[at], &|design| Cell::new(quantity.value(&design.points[at].value, 4)));
    }
    for (at, objective) in of.objectives.iter().enumerate() {
        let quantity = goal_of(objective);
        line(&quantity.label(), &|design| match design.judged.values[at] {
            Some(value) => {
                Cell { figure: Some((objective.figure.name.clone(), value)), ..Cell::new(quantity.number(value, 5)) }
            }
            None => Cell::new("–"),
        });
        let start = found.start().judged.values[at];
        line("  gain, %", &|design| match gain(objective.goal, start, design.judged.values[at])
            .filter(|_| design.number != 1)
        {
            Some(share) => Cell {
                tone: if share >= 0.0 { Tone::Good } else { Tone::Bad },
                ..Cell::new(format!("{:+.1}", 100.0 * share).replace('-', "−"))
            },
            None => Cell::new(""),
        });
    }
    for (at, constraint) in of.constraints.iter().enumerate() {
        let quantity = Quantity::of(&constraint.column);
        line(&constraint_words(of, at), &|design| match &design.judged.worst[at] {
            Value::Flag(flag) => Cell::new(if *flag { "yes" } else { "no" }),
            value => Cell::new(quantity.value(value, 4)),
        });
    }
    line("meets all", &|design| Cell::new(if design.is_feasible() { "yes" } else { "no" }));
    if scenes {
        let files = designs[1..].iter().map(|design| scene_file(found, design));
        rows.push(["scene", "start.toml"].map(String::from).into_iter().chain(files).map(Cell::new).collect());
    }
    Table::new(&rows)
}

/// An objective, in the unit of its columns.
fn goal_of(objective: &Objective) -> Quantity {
    Quantity::new(&objective.figure.name, &objective.figure.holds)
}

/// Members of the front by their objectives and variables, their numbers leading to their scenes.
pub(super) fn members(of: &Optimisation, found: &Found, shown: &[usize]) -> Table {
    let quantities: Vec<Quantity> = of.variables.iter().map(|variable| Quantity::of(&variable.column())).collect();
    let goals: Vec<Quantity> = of.objectives.iter().map(goal_of).collect();
    let head = std::iter::once("design".to_string());
    let head = head.chain(goals.iter().map(Quantity::label)).chain(variable_labels(of)).map(Cell::new).collect();
    let row = |index: &usize| {
        let design = &found.designs[*index];
        let objectives = goals.iter().zip(&design.judged.values);
        let objectives = objectives.map(|(of, value)| value.map_or("–".to_string(), |value| of.number(value, 5)));
        let variables = quantities.iter().zip(&design.points).map(|(of, point)| of.value(&point.value, 4));
        let number = Cell { link: Some(format!("design-{}", design.number)), ..Cell::new(design.number.to_string()) };
        std::iter::once(number).chain(objectives.chain(variables).map(Cell::new)).collect()
    };
    let rows: Vec<Vec<Cell>> = std::iter::once(head).chain(shown.iter().map(row)).collect();
    Table::new(&rows)
}

/// Members of the front from end to end, at most so many.
fn front(of: &Optimisation, found: &Found, most: usize) -> Report {
    let shown = spread(&found.front, most);
    let of_all = if shown.len() < found.front.len() { format!(", {} of them", shown.len()) } else { String::new() };
    Report::from(format!("front: {} designs{of_all}\n", found.front.len())).and(members(of, found, &shown))
}

/// So many of a list, evenly, both ends among them.
fn spread(all: &[usize], most: usize) -> Vec<usize> {
    if all.len() <= most || most < 2 {
        return all.iter().copied().take(most.max(1)).collect();
    }
    (0..most).map(|at| all[at * (all.len() - 1) / (most - 1)]).collect()
}

/// Why there is no front.
fn nothing(of: &Optimisation, found: &Found) -> String {
    let least = found.designs.iter().min_by(|a, b| a.judged.score.violation.total_cmp(&b.judged.score.violation));
    let nearest = least.map_or(String::new(), |design| {
        let runs = design.judged.by_status.iter().sum::<u64>();
        let missed = of.constraints.iter().zip(&design.judged.worst).enumerate();
        let words: Vec<String> = missed
            .map(|(at, (constraint, worst))| {
                format!("{} ({})", constraint_words(of, at), Quantity::of(&constraint.column).value(worst, 4))
            })
            .collect();
        format!(
            " The nearest is design {} (violation {}, {} of {runs} runs completed): {}.",
            design.number,
            figure(design.judged.score.violation, 3),
            design.judged.by_status[0],
            words.join("; ")
        )
    });
    format!(
        "Not one of {} designs meets all constraints.{nearest} Widen the variables, loosen a constraint, or search longer.",
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
    let ended = if report.converged { ", converged" } else { "" };
    let now = &report.now;
    let best = match report.objectives.len() {
        1 => String::new(),
        _ => format!(", {} on the front", report.front.len()),
    };
    let mut text = format!(
        "{} designs in {} generations{ended}: {} meet all constraints{best}. {} runs: {}.",
        report.designs,
        report.generations,
        report.feasible_designs,
        report.runs,
        statuses.join(", ")
    );
    if now.runs < report.runs {
        text.push_str(&format!("\n{} runs were there already.", report.runs - now.runs));
    }
    if now.simulations > 0 {
        let threads = if now.threads == 1 { "1 thread".to_string() } else { format!("{} threads", now.threads) };
        text.push_str(&format!(
            "\n{} simulations in {} s on {threads}: {} a second.",
            now.simulations,
            figure(now.wall_s, 3),
            figure(now.simulations_per_s, 3)
        ));
    }
    text
}
