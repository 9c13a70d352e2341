//! HTML report of an optimisation: a plot, whose points link to the scenes of the front, and tables.

use super::document::OptimisationReport;
use super::text::{self, comparison_table};
use crate::format::report::Report;
use crate::study::optimize::Optimisation;

impl OptimisationReport<'_> {
    /// Creates the HTML report. `svg` is the plot, whose points link to `#design-N`. `scenes` contains the scene of
    /// each design of the front.
    pub fn paper(&self, svg: String, scenes: &[(u64, String)]) -> Report {
        let OptimisationReport { optimisation, found, .. } = self;
        let search = Report::section("Search").with_paragraph(format!(
        "{}{} model, {} with generations of {} designs, seed {}. {} designs in {} generations, each in {}; {} runs. {} designs meet all \
         constraints; {} of them are on the Pareto front: no other design is better in one objective and equal in the others.",
        match optimisation.description() {
            "" => String::new(),
            text => format!("{text} "),
        },
        capitalize(self.model),
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
        let plot = Report::section("Designs").with_figure("optimisation.svg", &caption(optimisation), svg);
        let gains = Report::section("Gains").with(
            comparison_table(optimisation, found, false)
                .caption("The start and the best designs; below each objective, the gain over the start."),
        );
        let mut front = Report::section("Pareto front").with_paragraph(
        "The scene file of each design of the front. A click on its point in the plot, or on its number here, leads to it.",
    ).with(text::front_table(optimisation, found, &found.front).caption("All designs of the front."));
        for (number, scene) in scenes {
            front = front.with_text(&format!("design-{number}"), &format!("Design {number}"), scene.clone());
        }
        Report { title: optimisation.name().to_string(), ..search.with(plot).with(gains).with(front) }
    }
}

fn capitalize(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

fn caption(optimisation: &Optimisation) -> String {
    match &optimisation.objectives[..] {
        [objective] => {
            format!("{} of every design that meets all constraints, in order of evaluation.", objective.figure.name)
        }
        _ => "Objectives of every design that meets all constraints, with the Pareto front, the start and the compromise."
            .to_string(),
    }
}
