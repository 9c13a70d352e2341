//! A paper of an optimisation: its picture, where a point of the front leads to its scene, and its tables.

use super::document::OptimisationReport;
use super::text::{self, compared};
use crate::study::optimize::Optimisation;
use crate::wording::report::Report;

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
        let gained =
            Report::section("What is gained")
                .and(compared(of, found, false).caption(
                    "The start beside the best; under an objective, by how much it is better than the start.",
                ));
        let mut members = Report::section("The front").words(
        "Each design of the front as a scene file: a click on its point in the picture, or on its number here, shows it below.",
    ).and(text::members(of, found, &found.front).caption("All designs of the front."));
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
