//! Contents of an optimisation file. Doc comments become descriptions of the JSON Schema.

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::Value as Json;

use super::problem::{Algorithm, ColumnAggregation, ConditionAggregation, Goal};
use crate::scene::entry::{Entry, Section};
use crate::scene::value_kinds::{Choice, Count, Keyword, Text};
use crate::study::sweep::{AnyValue, RawAxis, RawFilter, Spacing, ValueList, scene_study_schema_text, study_schema};
use crate::trace::Model;

/// An optimisation: a base scene, variables, objectives and constraints.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(title = "phalanx optimisation")]
pub struct RawOptimisation {
    /// Name in reports. Default: the file's name without its extension.
    pub name: Entry<Text>,
    /// Description of the optimisation.
    pub description: Entry<Text>,
    /// Base scene, from which the search starts and with which its results are compared: a file, relative to the
    /// directory of this file, or a table [scene] with the keys of a scene.
    pub scene: Entry<Text>,
    /// Simulation model.
    #[schemars(extend("default" = "analytic"))]
    pub model: Entry<Choice<Model>>,
    /// Fields to vary, with their bounds.
    pub variables: Vec<Section<RawVariable>>,
    /// Conditions under which every design runs, in all combinations, such as friction, offsets or tolerances. Same
    /// format as the axes of a sweep.
    pub conditions: Vec<Section<RawAxis>>,
    /// Figures to minimise or maximise.
    pub objectives: Vec<Section<RawObjective>>,
    /// Requirements under every condition.
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
    /// One bound of the range.
    pub from: Entry<AnyValue>,
    /// The other bound of the range.
    pub to: Entry<AnyValue>,
    /// Spacing of the range in the search.
    #[schemars(extend("default" = "linear"))]
    pub spacing: Entry<Choice<Spacing>>,
    /// Start value of the search. Default: the value in the base scene.
    pub start: Entry<AnyValue>,
}

/// One objective: a column of the results of a sweep, aggregated over all conditions.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawObjective {
    /// Numeric column, such as "tts_s" or "peak_f21_n".
    pub column: Entry<Text>,
    /// Several columns, aggregated by `of`.
    pub columns: Entry<ValueList>,
    /// Aggregation of several columns.
    #[schemars(extend("default" = "largest"))]
    pub of: Entry<Choice<ColumnAggregation>>,
    /// Direction: minimise or maximise.
    #[schemars(extend("default" = "min"))]
    pub goal: Entry<Choice<Goal>>,
    /// Aggregation over several conditions.
    #[schemars(extend("default" = "worst"))]
    pub over: Entry<Choice<ConditionAggregation>>,
    /// Column name in the results; it should end in its unit. Default: the column, or the aggregation followed by the
    /// columns.
    pub name: Entry<Text>,
}

/// One constraint, which must be satisfied under every condition.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawConstraint {
    /// Column of a sweep's results, such as "class", "form_closed" or "pfp_n".
    pub column: Entry<Text>,
    /// Smallest value allowed: a number in the column's unit or a quantity. For the column `class`: the worst class
    /// allowed.
    pub at_least: Entry<AnyValue>,
    /// Largest value allowed.
    pub at_most: Entry<AnyValue>,
    /// Required value of a text or boolean column.
    pub equals: Entry<AnyValue>,
}

/// Search method.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawMethod {
    /// "nsga2" finds the front of several objectives, "cma-es" the best of one. Default: by the number of objectives.
    pub algorithm: Entry<Choice<Algorithm>>,
    /// Number of designs per generation. Default: 64 with nsga2, 4 + 3 ln n for n variables with cma-es.
    pub population: Entry<Count>,
    /// Maximum number of generations; cma-es ends earlier when it has converged. Default: 50 with nsga2, 100 with
    /// cma-es.
    pub generations: Entry<Count>,
    /// Seed of the random numbers. Equal seeds give equal results for any number of threads.
    #[schemars(extend("default" = 1))]
    pub seed: Entry<Count>,
}

impl Keyword for Goal {
    const KEYWORDS: &'static [(&'static str, Self)] = &[("min", Goal::Min), ("max", Goal::Max)];
}

impl Keyword for ConditionAggregation {
    const KEYWORDS: &'static [(&'static str, Self)] =
        &[("worst", ConditionAggregation::Worst), ("mean", ConditionAggregation::Mean)];
}

impl Keyword for ColumnAggregation {
    const KEYWORDS: &'static [(&'static str, Self)] = &[
        ("largest", ColumnAggregation::Largest),
        ("smallest", ColumnAggregation::Smallest),
        ("sum", ColumnAggregation::Sum),
    ];
}

impl Keyword for Algorithm {
    const KEYWORDS: &'static [(&'static str, Self)] = &[("nsga2", Algorithm::Nsga2), ("cma-es", Algorithm::CmaEs)];
}

/// Returns the JSON Schema of optimisation files as text.
pub fn schema() -> String {
    scene_study_schema_text(schema_json())
}

/// Returns the schema used to find unknown keys. A table [scene] or [set] is checked as a scene instead.
pub(super) fn schema_json() -> Json {
    study_schema::<RawOptimisation>("optimisation")
}
