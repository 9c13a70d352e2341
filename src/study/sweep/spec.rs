//! Studies that start without designs, as in an optimisation: designs are added later, and each runs under the same
//! conditions.

use toml::Table;

use super::axis::{Axis, AxisValues};
use super::field::Field;
use super::template::Template;
use super::{Filter, Study};
use crate::scene::keywords::SceneKind;
use crate::trace::Model;

/// Everything about such a study except its designs.
pub(in crate::study) struct StudySpec {
    pub kind: SceneKind,
    pub name: String,
    pub description: String,
    pub model: Model,
    pub filter: Filter,
    /// Fields of a design.
    pub fields: Vec<Field>,
    /// Conditions of each design; all combinations are run.
    pub conditions: Vec<Axis>,
    pub scene: Table,
    /// The exact text of the base scene's file.
    pub base: String,
    /// The exact text of the study.
    pub source: String,
}

/// Builds the study without designs; [`Study::with_rows`] adds them.
///
/// # Errors
/// Returns an error if the base scene cannot be serialised.
pub(in crate::study) fn study_without_designs(spec: StudySpec) -> Result<Study, String> {
    let StudySpec { kind, name, description, model, filter, fields, conditions, scene, base, source } = spec;
    let all_fields = fields.iter().chain(conditions.iter().flat_map(|axis| &axis.fields));
    let template = Template::new(scene, &all_fields.map(|field| field.path.as_str()).collect::<Vec<_>>())?;
    let designs = Axis { fields, values: AxisValues::Rows(Vec::new()), repeats_designs: false };
    let axes = std::iter::once(designs).chain(conditions).collect();
    Ok(Study {
        kind,
        name,
        description,
        model,
        checked: false,
        filter,
        axes,
        sequence: None,
        template,
        runs: 0,
        source,
        base,
    })
}

impl Study {
    /// Sets the total number of runs expected.
    pub(in crate::study) fn with_run_count(mut self, runs: u64) -> Study {
        self.runs = runs;
        self
    }

    /// Number of conditions under which each design runs.
    pub(in crate::study) fn conditions(&self) -> u64 {
        self.loops().iter().filter(|level| level.repeats_designs).map(|level| level.len).product()
    }
}
