//! Study files: their structure, and the study that they describe; studies built in memory.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Deserialize;
use toml::de::DeTable;

use super::axis::{Axis, AxisValue, AxisValues, Field};
use super::axis_table::AxisTable;
use super::base_scene::{Base, Template, base_from_layers};
use super::document::{self, Document, SCENE, StudyError, beside, default_name, list_first, read_study, similar};
use super::figures::{Results, UnknownFigure};
use super::run::problem_messages;
use super::sequence::{MAX_HALTON_AXES, Method, Sequence};
use super::{Filter, MAX_RUNS, MAX_SHARDED_RUNS, Study};
use crate::scene::quantity::Word;
use crate::scene::{Layer, Problem, Scene, load_extended_in, load_layers, parse_any, parse_layers, read};
use crate::trace::Model;

/// A study: a base scene, the fields that vary, and the runs to simulate.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(title = "phalanx study")]
struct StudyFile {
    /// Name in reports. Default: the file name without its extension.
    name: String,
    /// Purpose of the study.
    description: String,
    /// The base scene: a path relative to the directory of this file, or a table [scene] with the keys of a scene, which may
    /// extend another one. It may lack the fields of the axes.
    scene: String,
    /// Simulation model.
    model: Word<Model>,
    /// Fields that vary; all combinations are run, the last axis fastest.
    axes: Vec<SweepAxis>,
    sample: SampleTable,
    filter: Filter,
    results: ResultsTable,
}

/// Columns of the results.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct ResultsTable {
    /// The figures that are columns, beside those of the axes and `status`, `reason`, `steps`, `check` and `check_error_rad`.
    /// Default: all.
    columns: Vec<String>,
    /// Channels of the run, such as "object_y_m", whose least and largest values are columns: "least_object_y_m" and
    /// "largest_object_y_m".
    extrema: Vec<String>,
}

/// One axis: values or a range of one field, or rows of values of several fields.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default)]
struct SweepAxis {
    #[serde(flatten)]
    axis: AxisTable,
    /// Whether the axis repeats the same designs under other conditions instead of making new designs.
    again: bool,
}

/// Sample points of all ranges without `count`. Every combination of the other axes is run with all points.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct SampleTable {
    /// "halton": low discrepancy, and a longer sample contains the shorter one; "latin-hypercube": one point in
    /// every slice of every axis; "random": independent points.
    #[schemars(extend("default" = "halton"))]
    method: Method,
    /// Number of points. Required.
    #[schemars(with = "u64", range(min = 1))]
    count: Option<u64>,
    /// Seed of the points.
    #[schemars(with = "u64", range(min = 1), extend("default" = 1))]
    seed: Option<u64>,
}

/// Returns the JSON Schema of study files. `[scene]` and `[set]` accept the keys of all kinds of scene.
pub fn schema() -> String {
    document::schema::<StudyFile>()
}

/// Returns the files of a study that has been read: the study file, then the files that its base scene extends, then
/// the base scene. If the study file is a pipe, it is the only one.
pub fn source_files(path: &Path) -> Vec<PathBuf> {
    let text = if path.is_file() { read(path).map_or_else(|_| String::new(), |(text, _)| text) } else { String::new() };
    let document = DeTable::parse(&text).ok();
    let base = document.as_ref().and_then(|document| document.get_ref().get(SCENE)?.get_ref().as_str());
    let mut layers = match base {
        Some(base) => load_layers(&beside(path, base)),
        None => load_extended_in(Layer { file: path.display().to_string(), text: text.clone() }, Some(SCENE)),
    }
    .unwrap_or_default();
    layers.retain(|layer| Path::new(&layer.file) != path);
    std::iter::once(path.to_path_buf()).chain(layers.into_iter().map(|layer| PathBuf::from(layer.file))).collect()
}

/// Reads and checks a study file and the base scene that it names.
///
/// # Errors
/// Returns an error if the study or its base scene is invalid; the message contains file, line and column.
pub fn load(path: impl AsRef<Path>) -> Result<Study, StudyError> {
    let (text, file) = read_study(path.as_ref())?;
    parse(&text, &file)
}

/// Parses the text of a study. `file_name` appears in messages. It also determines the default name, and the directory
/// to which the path of the base scene is relative.
pub fn parse(text: &str, file_name: &str) -> Result<Study, StudyError> {
    let (study, mut document) = Document::read::<StudyFile>(text, file_name)?;
    let base = document.read_base(&study.scene)?;
    let axes = read_axes(&document, &study.axes, base.as_ref());
    let sequence = read_sample(&document, &study, &axes);
    document.check_filter();
    let points = sequence.as_ref().map_or(1, Sequence::count);
    let runs = axes.iter().filter_map(Axis::len).chain([points]).try_fold(1u64, u64::checked_mul);
    let runs = runs.filter(|total| *total <= MAX_SHARDED_RUNS);
    if document.checker.is_clean() && runs.is_none() {
        let message = format!("the study has more than {MAX_SHARDED_RUNS} runs");
        document.refuse::<()>("", message, "", "remove values, or sample the axes: [sample]");
    }
    document.check()?;
    // Whatever is missing has been reported.
    let (Some(base), Some(runs)) = (base, runs) else { return Err(document.invalid(Vec::new()).into()) };
    let unusable = |reason: String| StudyError::Read { file: file_name.to_string(), reason };
    let varies_outline =
        axes.iter().flat_map(|axis| &axis.fields).any(|field| field.path.starts_with("object.outline"));
    let is_hand = base.is_hand() && !varies_outline;
    let mut found = Study {
        results: Results::of_hand(base.kind.fingers()),
        name: if study.name.is_empty() { default_name(file_name) } else { study.name },
        description: study.description,
        model: study.model.0,
        preset: None,
        checked: false,
        filter: study.filter,
        template: Template::new(base.table, axes.iter().flat_map(|axis| &axis.fields)).map_err(unusable)?,
        axes,
        sequence,
        runs,
        source: text.to_string(),
        base: base.text,
    };
    let ResultsTable { columns, extrema } = study.results;
    if !is_hand || !columns.is_empty() || !extrema.is_empty() {
        let scene = first_scene(&found).map_err(|reason| {
            let message = format!("none of the first scenes of the study is valid: {reason}");
            let help = "correct the base scene, or the values of the axes";
            document.invalid(vec![Problem::new(document.span(SCENE), message, "this base scene", help)])
        })?;
        found.results =
            Results::of(&scene, &columns, &extrema).map_err(|UnknownFigure { key, index, name, known }| {
                let path = format!("results.{key}.{index}");
                let help = format!("{}the names are {}", similar(&name, &known), list_first(&known));
                let message =
                    format!("`{name}` is no {} of this study", if key == "columns" { "figure" } else { "channel" });
                document.invalid(vec![Problem::new(document.span(&path), message, "unknown name", help)])
            })?;
    }
    let fields: Vec<String> = found.fields().map(|(column, _)| column).collect();
    found.results = found.results.without(&fields);
    Ok(found)
}

/// Number of runs among which a valid scene is sought.
const MAX_TRIED: u64 = 1000;

/// The scene of the first run whose scene is valid. All scenes of a study have the same parts, so that its results have the
/// same columns.
fn first_scene(study: &Study) -> Result<Scene, String> {
    let mut reason = None;
    for run in 1..=study.runs().min(MAX_TRIED) {
        match parse_any(&study.scene_text(run), "run.toml") {
            Ok(scene) => return Ok(scene),
            Err(error) => _ = reason.get_or_insert_with(|| problem_messages(&error)),
        }
    }
    Err(reason.unwrap_or_else(|| "it has no runs".to_string()))
}

/// Reads all valid axes. A study without axes runs its scene once.
fn read_axes(document: &Document<'_>, tables: &[SweepAxis], base: Option<&Base>) -> Vec<Axis> {
    let (mut axes, Some(base)): (Vec<Axis>, _) = (Vec::new(), base) else { return Vec::new() };
    for (index, SweepAxis { axis: table, again }) in tables.iter().enumerate() {
        let path = format!("axes.{index}");
        let Some(axis) = document.read_axis(&path, table, base) else { continue };
        for Field { path: field, .. } in &axis.fields {
            if axes.iter().flat_map(|other| &other.fields).any(|other| other.path == *field) {
                let help = "keep one of the axes, with all values of the field";
                let message = format!("`{field}` is varied by two axes");
                document.refuse::<()>(&format!("{path}.{}", table.key()), message, "repeated here", help);
            }
        }
        if *again && axis.len().is_none() {
            let message = format!("the sampled axis `{}` cannot repeat the same designs", table.field);
            let help = "remove `again`, or give `count` or `values`";
            document.refuse::<()>(&format!("{path}.again"), message, "a sampled axis", help);
        }
        axes.push(Axis { repeats_designs: *again, ..axis });
    }
    axes
}

fn read_sample(document: &Document<'_>, study: &StudyFile, axes: &[Axis]) -> Option<Sequence> {
    let SampleTable { method, count, seed } = &study.sample;
    let ranges = axes.iter().filter(|axis| axis.len().is_none()).count();
    if document.span("sample").is_none() {
        if let Some(index) = study.axes.iter().position(|axis| axis.axis.is_range()) {
            let help = "give the number of values: count = 10, or sample all ranges: [sample] with count = 1000";
            let message = "a range has no `count`, and there is no [sample]";
            document.refuse::<()>(&format!("axes.{index}.from"), message, "count required", help);
        }
        return None;
    }
    let Some(count) = *count else {
        return document.missing("count", "sample", "give the number of points: count = 1000");
    };
    if count > MAX_SHARDED_RUNS {
        let message = format!("`sample.count` is {count}, which is too large");
        return document.refuse("sample.count", message, "too many", format!("take at most {MAX_SHARDED_RUNS} points"));
    }
    // Every part of a study shuffles the slices of all points in memory before its first run.
    if *method == Method::LatinHypercube && count > MAX_RUNS {
        let message = format!("`sample.count` is {count}, but a latin-hypercube has at most {MAX_RUNS} points");
        let help = "take fewer, or use method = \"halton\" or \"random\", whose points need no memory";
        return document.refuse("sample.count", message, "too many for this method", help);
    }
    if ranges == 0 && axes.len() == study.axes.len() {
        let help = "give an axis with `from` and `to` but without `count`, or remove [sample]";
        document.refuse::<()>("sample", "[sample] has no range to sample", "nothing to sample", help);
    }
    if *method == Method::Halton && ranges > MAX_HALTON_AXES {
        let message = format!("a halton sample has at most {MAX_HALTON_AXES} axes, but the study has {ranges}");
        document.refuse::<()>("sample.method", message, "too many axes", "use method = \"latin-hypercube\"");
    }
    Some(Sequence::new(*method, count, seed.unwrap_or(1), ranges))
}

/// Builds a study of these scene fields without rows. Each row that [`Study::with_rows`] adds is a design.
///
/// `layers` are the texts of the scene and of the scenes it extends; `settings` are additional fields. Both are as for
/// `scene::parse_layers`. The fields of the rows may be missing in the scene.
pub fn in_memory_study(
    layers: &[Layer],
    settings: &[Layer],
    paths: &[&str],
    model: Model,
) -> Result<Study, StudyError> {
    let base = base_from_layers(layers, settings)?;
    let invalid = |message: String, help: String| StudyError::Field { message, help };
    let mut fields: Vec<Field> = Vec::new();
    for path in paths {
        let field = base
            .field(path)
            .map_err(|Problem { message, label, help, .. }| invalid(message, format!("{label}; {help}")))?;
        if fields.iter().any(|other| other.path == field.path) {
            return Err(invalid(format!("the field `{path}` is given twice"), "remove one of them".to_string()));
        }
        fields.push(field);
    }
    let results = if base.is_hand() {
        Results::of_hand(base.kind.fingers())
    } else {
        let scene = parse_layers(layers, settings)?;
        Results::of(&scene, &[], &[]).map_err(|unknown| invalid(unknown.name, String::new()))?
    };
    let template = Template::new(base.table, fields.iter());
    let columns: Vec<String> = fields.iter().map(Field::column).collect();
    Ok(Study {
        results: results.without(&columns),
        name: String::new(),
        description: String::new(),
        model,
        preset: None,
        checked: false,
        filter: Filter::default(),
        template: template.map_err(|reason| invalid(reason, "give other fields".to_string()))?,
        axes: vec![Axis { fields, values: AxisValues::Rows(Vec::new()), repeats_designs: false }],
        sequence: None,
        runs: 0,
        source: String::new(),
        base: base.text,
    })
}

impl Study {
    /// Fields of the first axis, in the order of the values in a row.
    pub fn row_fields(&self) -> &[Field] {
        self.axes.first().map_or(&[], |axis| &axis.fields)
    }

    /// Sets the rows of values of the first axis. Each row is a design.
    ///
    /// # Panics
    /// Panics if the length of a row differs from the number of fields, or if there are more than [`MAX_RUNS`] runs.
    pub fn with_rows(mut self, rows: Vec<Vec<AxisValue>>) -> Study {
        assert!(rows.iter().all(|row| row.len() == self.row_fields().len()), "one value for each field");
        if let Some(first) = self.axes.first_mut() {
            first.values = AxisValues::Rows(rows);
        }
        self.runs = self.designs();
        assert!(self.runs <= MAX_RUNS, "at most {MAX_RUNS} runs");
        self
    }
}
