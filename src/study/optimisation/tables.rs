//! Structure of the study file of an optimisation. The values of fields and limits are read from the document.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use crate::scene::quantity::Word;
use crate::study::sweep::{AxisTable, Filter, Spacing, any_value};
use crate::trace::Model;

/// An optimisation: a base scene, variables, objectives and constraints.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(title = "phalanx optimisation")]
pub(super) struct OptimisationFile {
    /// Name in reports. Default: the file name without its extension.
    pub name: String,
    /// Description of the optimisation.
    pub description: String,
    /// Base scene, from which the search starts and with which its results are compared. It is a path relative to the
    /// directory of this file, or a table [scene] with the keys of a scene, which may extend another scene. Variables
    /// that have a start value may be missing in it.
    pub scene: String,
    /// Simulation model.
    pub model: Word<Model>,
    /// Fields to vary, with their bounds.
    pub variables: Vec<VariableTable>,
    /// Conditions under which every design is run, in all combinations, such as friction or offsets.
    pub conditions: Vec<AxisTable>,
    /// Figures that are minimised or maximised.
    pub objectives: Vec<ObjectiveTable>,
    /// Requirements that must be met under every condition.
    pub constraints: Vec<ConstraintTable>,
    pub filter: Filter,
    pub method: MethodTable,
}

/// A field that the search varies.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct VariableTable {
    /// Scene field, such as "design.base" or "spring.torque".
    pub field: String,
    /// One bound of the range.
    #[schemars(schema_with = "any_value")]
    pub from: Option<IgnoredAny>,
    /// The other bound of the range.
    #[schemars(schema_with = "any_value")]
    pub to: Option<IgnoredAny>,
    /// Spacing of the values of the range.
    #[schemars(extend("default" = "linear"))]
    pub spacing: Spacing,
    /// Start value of the search. Default: the value in the base scene.
    #[schemars(schema_with = "any_value")]
    pub start: Option<IgnoredAny>,
}

/// A figure to minimise or maximise.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct ObjectiveTable {
    /// Numeric column of a run, such as "tts_s" or "peak_f21_n".
    pub column: String,
    /// Several columns, aggregated by `of`.
    #[schemars(length(min = 1))]
    pub columns: Vec<String>,
    /// Aggregation of several columns.
    #[schemars(extend("default" = "largest"))]
    pub of: Aggregation,
    /// Direction: minimise or maximise.
    #[schemars(extend("default" = "min"))]
    pub goal: Goal,
    /// Aggregation over several conditions.
    #[schemars(extend("default" = "worst"))]
    pub over: Over,
    /// Name of the column in the results; it should end in its unit. Default: the column, or the aggregation followed
    /// by the columns.
    pub name: String,
}

/// A requirement under every condition.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct ConstraintTable {
    /// Column of a run, such as "class", "form_closed" or "pfp_n".
    pub column: String,
    /// Smallest allowed value: a number in the unit of the column, or a quantity. For the column `class`: the worst
    /// allowed class.
    #[schemars(schema_with = "any_value")]
    pub at_least: Option<IgnoredAny>,
    /// Largest allowed value.
    #[schemars(schema_with = "any_value")]
    pub at_most: Option<IgnoredAny>,
    /// Required value of a text or boolean column.
    #[schemars(schema_with = "text_or_flag")]
    pub equals: Option<IgnoredAny>,
}

/// Schema of a required value.
fn text_or_flag(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": ["string", "boolean"] })
}

/// Search method.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct MethodTable {
    /// "nsga2" finds the front of several objectives, "cma-es" the best design for one objective. Default: chosen by
    /// the number of objectives.
    #[schemars(with = "Algorithm")]
    pub algorithm: Option<Algorithm>,
    /// Number of designs per generation; about ten times the number of variables is usual. Default: 64 with nsga2, 4 + 3 ln n
    /// for n variables with cma-es.
    #[schemars(with = "u64", range(min = 4))]
    pub population: Option<u64>,
    /// Maximum number of generations; cma-es ends earlier when it has converged. Default: 50 with nsga2, 100 with cma-es.
    #[schemars(with = "u64", range(min = 1))]
    pub generations: Option<u64>,
    /// Seed of the random numbers.
    #[schemars(with = "u64", range(min = 0), extend("default" = 1))]
    pub seed: Option<u64>,
}

/// Aggregation of several columns of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Aggregation {
    #[default]
    Largest,
    Smallest,
    Sum,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Goal {
    #[default]
    Min,
    Max,
}

/// Aggregation of the values under several conditions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Over {
    #[default]
    Worst,
    Mean,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Algorithm {
    Nsga2,
    CmaEs,
}
