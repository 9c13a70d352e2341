//! Studies whose designs are found one after the other, and run under the same conditions each.

use toml::Table;

use super::axis::{Axis, Points};
use super::field::Field;
use super::template::Template;
use super::{Filter, Study};
use crate::scene::words::SceneKind;
use crate::trace::Model;

/// What is known of such a study before there is a design.
pub(in crate::study) struct Designs {
    pub kind: SceneKind,
    pub name: String,
    pub description: String,
    pub model: Model,
    pub filter: Filter,
    /// What makes a design.
    pub fields: Vec<Field>,
    /// Under which each design runs, all combinations; they make no new designs.
    pub conditions: Vec<Axis>,
    /// The base scene, and the text of its file.
    pub scene: Table,
    pub base: String,
    /// The exact text of the study.
    pub source: String,
}

/// The study without a design, see [`Study::with_rows`].
///
/// # Errors
/// Why scenes cannot be written.
pub(in crate::study) fn of_designs(of: Designs) -> Result<Study, String> {
    let Designs { kind, name, description, model, filter, fields, conditions, scene, base, source } = of;
    let all = fields.iter().chain(conditions.iter().flat_map(|axis| &axis.fields));
    let template = Template::new(scene, &all.map(|field| field.path.as_str()).collect::<Vec<_>>())?;
    let first = Axis { fields, points: Points::Given(Vec::new()), again: false };
    let axes = std::iter::once(first).chain(conditions).collect();
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
    /// The same, for as many runs as there may be in the end.
    pub(in crate::study) fn expecting(mut self, runs: u64) -> Study {
        self.runs = runs;
        self
    }

    /// How often each design runs.
    pub(in crate::study) fn conditions(&self) -> u64 {
        self.loops().iter().filter(|of| of.again).map(|of| of.len).product()
    }
}
