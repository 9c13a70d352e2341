//! The file of an optimisation as it is written. Doc comments become the descriptions of the JSON Schema.

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::Value as Json;

use super::problem::{Algorithm, Goal, Of, Over};
use crate::scene::entry::{Entry, Section};
use crate::scene::kinds::{Choice, Count, Text, Words};
use crate::study::sweep::{Anything, List, RawAxis, RawFilter, Spacing, schema_of_study, schema_text};
use crate::trace::Model;

/// An optimisation: a scene, the fields of it that may change, what is to be made small or large, and what has to hold.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(title = "phalanx optimisation")]
pub struct RawOptimisation {
    /// Name in reports. Default: the file's name without its extension.
    pub name: Entry<Text>,
    /// What the optimisation is for.
    pub description: Entry<Text>,
    /// The base scene, from which the search begins and with which its results are compared: a file, seen from the directory
    /// of this one, or a table [scene] with the keys of a scene.
    pub scene: Entry<Text>,
    /// The model that simulates.
    #[schemars(extend("default" = "analytic"))]
    pub model: Entry<Choice<Model>>,
    /// What may change, and within which bounds.
    pub variables: Vec<Section<RawVariable>>,
    /// Under what every design runs, in all combinations: friction, offsets, tolerances. Written like the axes of a sweep.
    pub conditions: Vec<Section<RawAxis>>,
    /// What is to be made small or large.
    pub objectives: Vec<Section<RawObjective>>,
    /// What has to hold under every condition.
    pub constraints: Vec<Section<RawConstraint>>,
    pub filter: Section<RawFilter>,
    pub method: Section<RawMethod>,
}

/// One variable: a field of numbers or quantities and its range.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawVariable {
    /// Field of a scene, such as "design.base" or "spring.torque".
    pub field: Entry<Text>,
    /// One bound.
    pub from: Entry<Anything>,
    /// The other bound.
    pub to: Entry<Anything>,
    /// How the search sees the range.
    #[schemars(extend("default" = "linear"))]
    pub spacing: Entry<Choice<Spacing>>,
    /// Where the search begins. Default: the value in the base scene.
    pub start: Entry<Anything>,
}

/// One objective: a column of a sweep's results over all conditions.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawObjective {
    /// Column of numbers, such as "tts_s" or "peak_f21_n".
    pub column: Entry<Text>,
    /// Several columns, of which `of` takes one figure.
    pub columns: Entry<List>,
    /// What is taken of several columns.
    #[schemars(extend("default" = "largest"))]
    pub of: Entry<Choice<Of>>,
    /// Which way is better.
    #[schemars(extend("default" = "min"))]
    pub goal: Entry<Choice<Goal>>,
    /// What is taken of several conditions.
    #[schemars(extend("default" = "worst"))]
    pub over: Entry<Choice<Over>>,
    /// Column of the results; it should end in its unit. Default: the column, or what is taken of several.
    pub name: Entry<Text>,
}

/// One constraint, which has to hold under every condition.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawConstraint {
    /// Column of a sweep's results, such as "class", "form_closed" or "pfp_n".
    pub column: Entry<Text>,
    /// Smallest value allowed, a number in the column's unit or a quantity; of `class` the worst class allowed.
    pub at_least: Entry<Anything>,
    /// Largest value allowed.
    pub at_most: Entry<Anything>,
    /// What a column of words or of true and false has to say.
    pub equals: Entry<Anything>,
}

/// How it is searched.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawMethod {
    /// "nsga2" finds the front of several objectives, "cma-es" the best of one. Default: by the number of objectives.
    pub algorithm: Entry<Choice<Algorithm>>,
    /// Designs of a generation. Default: 64 with nsga2, 4 + 3 ln n for n variables with cma-es.
    pub population: Entry<Count>,
    /// How many generations at most; cma-es ends before where it has converged. Default: 50 with nsga2, 100 with cma-es.
    pub generations: Entry<Count>,
    /// Another seed searches otherwise; the same seed finds the same, whatever the number of threads.
    #[schemars(extend("default" = 1))]
    pub seed: Entry<Count>,
}

impl Words for Goal {
    const WORDS: &'static [(&'static str, Self)] = &[("min", Goal::Min), ("max", Goal::Max)];
}

impl Words for Over {
    const WORDS: &'static [(&'static str, Self)] = &[("worst", Over::Worst), ("mean", Over::Mean)];
}

impl Words for Of {
    const WORDS: &'static [(&'static str, Self)] =
        &[("largest", Of::Largest), ("smallest", Of::Smallest), ("sum", Of::Sum)];
}

impl Words for Algorithm {
    const WORDS: &'static [(&'static str, Self)] = &[("nsga2", Algorithm::Nsga2), ("cma-es", Algorithm::CmaEs)];
}

/// JSON Schema of the files of optimisations, as text.
pub fn schema() -> String {
    schema_text(schema_json())
}

/// The schema by which unknown keys are found. A [scene] or [set] that is a table is judged as a scene, not by this.
pub(super) fn schema_json() -> Json {
    schema_of_study::<RawOptimisation>("optimisation")
}
