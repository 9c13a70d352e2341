//! A paper of an optimisation: its picture, where a point of the front leads to its scene, and its tables.

use super::document::{OptimisationReport, chosen};
use super::text::{constraint_words, variable_labels};
use crate::study::optimize::{Found, Goal, Optimisation, gain};
use crate::table::Value;
use crate::wording::figures::figure;
use crate::wording::quantity::Quantity;
use crate::wording::report::{Cell, Report, Tone};

impl OptimisationReport<'_> {
    /// The paper. `svg`: the picture, whose points lead to `#design-N`; `scenes`: the scene of each member of the front.
    pub fn paper(&self, svg: String, scenes: &[(u64, String)]) -> Report {
        let OptimisationReport { of, found, .. } = self;
        let about = Report::section("What was searched").words(format!(
        "{}{} model, {} with generations of {} designs, seed {}. {} designs in {} generations, each under {}; {} runs. {} designs meet all \
         constraints, {} of them are on the front: no other design is better by one objective and as good by the others.",
        match of.description() {
            "" => String::new(),
            text => format!("{text} "),
        },
        capital(self.model),
        self.algorithm,
        self.population,
        self.seed,
        self.designs,
        self.generations,
        if self.conditions == 1 { "one condition".to_string() } else { format!("{} conditions", self.conditions) },
        self.runs,
        self.feasible_designs,
        self.front.len()
    ));
        let picture = Report::section("The designs").figure("optimisation.svg", &caption(of), svg);
        let gained = Report::section("What is gained").table(
            "The start beside the best; under an objective, by how much it is better than the start.",
            &head(of, found),
            rows(of, found),
        );
        let mut members = Report::section("The front").words(
        "Each design of the front as a scene file: a click on its point in the picture, or on its number here, shows it below.",
    );
        let names: Vec<String> = std::iter::once("design".to_string())
            .chain(of.objectives.iter().map(|of| Quantity::of(&of.figure.name).label()))
            .chain(variable_labels(of))
            .collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        members = members.table("All designs of the front.", &names, front(of, found));
        for (number, scene) in scenes {
            members = members.text(&format!("design-{number}"), &format!("Design {number}"), scene.clone());
        }
        Report { title: of.name().to_string(), ..about.and(picture).and(gained).and(members) }
    }
}

fn capital(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

fn caption(of: &Optimisation) -> String {
    match &of.objectives[..] {
        [one] => {
            format!("{} of every design that meets all constraints, in the order they were looked at.", one.figure.name)
        }
        _ => "Every design that meets all constraints by its objectives; the front, the start, and the compromise."
            .to_string(),
    }
}

fn head(of: &Optimisation, found: &Found) -> Vec<&'static str> {
    let several = of.objectives.len() > 1;
    let name = |(name, _): &(String, usize)| match (name.as_str(), several) {
        ("compromise", _) => "compromise",
        (_, true) => "best by one",
        (_, false) => "best",
    };
    ["", "start"].into_iter().chain(chosen(of, found).iter().map(name)).collect()
}

fn rows(of: &Optimisation, found: &Found) -> Vec<Vec<Cell>> {
    let (start, labels) = (found.start(), variable_labels(of));
    let mut designs = vec![start];
    designs.extend(chosen(of, found).into_iter().map(|(_, index)| &found.designs[index]));
    let line = |name: String, cells: Vec<Cell>| std::iter::once(Cell::new(name)).chain(cells).collect::<Vec<_>>();
    let mut rows =
        vec![line("design".to_string(), designs.iter().map(|design| Cell::new(design.number.to_string())).collect())];
    for (at, variable) in of.variables.iter().enumerate() {
        let quantity = Quantity::of(&variable.column());
        let cells = designs.iter().map(|design| Cell::new(quantity.value(&design.points[at].value, 4)));
        rows.push(line(labels[at].clone(), cells.collect()));
    }
    for (at, objective) in of.objectives.iter().enumerate() {
        let quantity = Quantity::of(&objective.figure.name);
        let goal = if objective.goal == Goal::Min { "small" } else { "large" };
        let cell = |value: Option<f64>| match value {
            Some(value) => {
                Cell { figure: Some((objective.figure.name.clone(), value)), ..Cell::new(quantity.number(value, 5)) }
            }
            None => Cell::new("–"),
        };
        let cells = designs.iter().map(|design| cell(design.judged.values[at]));
        rows.push(line(format!("{} ({goal})", quantity.label()), cells.collect()));
        let gained = |value: Option<f64>| match gain(objective.goal, start.judged.values[at], value) {
            Some(0.0) | None => Cell::new(""),
            Some(share) => Cell {
                tone: if share > 0.0 { Tone::Good } else { Tone::Bad },
                ..Cell::new(format!("{}{} %", if share > 0.0 { "+" } else { "−" }, figure(100.0 * share.abs(), 3)))
            },
        };
        rows.push(line(
            "gain over the start".to_string(),
            designs.iter().map(|design| gained(design.judged.values[at])).collect(),
        ));
    }
    for (at, constraint) in of.constraints.iter().enumerate() {
        let quantity = Quantity::of(&constraint.column);
        let cell = |value: &Value| {
            Cell::new(match value {
                Value::Flag(true) => "yes".to_string(),
                Value::Flag(false) => "no".to_string(),
                value => quantity.value(value, 4),
            })
        };
        rows.push(line(
            constraint_words(of, at),
            designs.iter().map(|design| cell(&design.judged.worst[at])).collect(),
        ));
    }
    rows
}

fn front(of: &Optimisation, found: &Found) -> Vec<Vec<Cell>> {
    let row = |&index: &usize| {
        let design = &found.designs[index];
        let objectives = of.objectives.iter().zip(&design.judged.values).map(|(of, value)| {
            let quantity = Quantity::of(&of.figure.name);
            Cell::new(value.map_or("–".to_string(), |value| quantity.number(value, 5)))
        });
        let variables = of.variables.iter().zip(&design.points);
        let variables = variables.map(|(of, point)| Cell::new(Quantity::of(&of.column()).value(&point.value, 4)));
        let number = Cell { link: Some(format!("design-{}", design.number)), ..Cell::new(design.number.to_string()) };
        std::iter::once(number).chain(objectives).chain(variables).collect()
    };
    found.front.iter().map(row).collect()
}
