//! Study files: their structure, and the study that they describe; studies built in memory. Types, units and unknown keys are checked against
//! the JSON Schema that is derived from the structure; positions in messages are looked up in the parsed document.

use std::ops::Range as Span;
use std::path::{Path, PathBuf};

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::{Value as Json, json};
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer};

use super::axis::{Axis, AxisValue, AxisValues, Field, Range, Spacing};
use super::base_scene::{
    Base, Template, base_from_layers, base_from_section, check_scene, check_values, merge, scene_kind,
};
use super::figures::{Results, UnknownFigure};
use super::run::problem_messages;
use super::sequence::{MAX_HALTON_AXES, Method, Sequence};
use super::{Filter, MAX_RUNS, MAX_SHARDED_RUNS, Study};
use crate::scene::check::Checker;
use crate::scene::keywords::SceneKind;
use crate::scene::parameters::{Parameters, unknown};
use crate::scene::parse::syntax_problem;
use crate::scene::quantity::Word;
use crate::scene::schema::{file_schema, unwrap_lines};
use crate::scene::written::type_name;
use crate::scene::{
    EXTENDS, Keyword, Layer, PARAMETERS, Problem, Scene, SceneError, keys, load_extended_in, load_layers, parse_any,
    parse_layers, read,
};
use crate::trace::Model;
use crate::units::is_expression;

/// Error in a study. Formatted like an error of a scene: `error:`, location, source line and help.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StudyError {
    #[error("error: cannot read study `{file}`: {reason}")]
    Read { file: String, reason: String },
    /// The study or its base scene is invalid.
    #[error(transparent)]
    Invalid(#[from] SceneError),
    /// An unknown or duplicate field of a study built in memory.
    #[error("error: {message}\n  = help: {help}")]
    Field { message: String, help: String },
}

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
    axes: Vec<AxisTable>,
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

/// One axis: values or a range of one field, or rows of values of several fields. The values of fields are read from the
/// document.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct AxisTable {
    /// Scene field, such as "design.base" or "contact.friction.mu_static".
    field: String,
    /// Fields that vary together; requires `rows`.
    #[schemars(length(min = 1))]
    fields: Vec<String>,
    /// Values, written as in a scene.
    #[schemars(schema_with = "any_list")]
    values: Vec<IgnoredAny>,
    /// Rows of values, one value for each of `fields`.
    #[schemars(schema_with = "any_list")]
    rows: Vec<IgnoredAny>,
    /// First value of a range.
    #[schemars(schema_with = "any_value")]
    from: Option<IgnoredAny>,
    /// Last value of a range.
    #[schemars(schema_with = "any_value")]
    to: Option<IgnoredAny>,
    /// Number of values of the range including both ends. Without it, [sample] determines the values.
    #[schemars(with = "u64", range(min = 1))]
    count: Option<u64>,
    /// Spacing of the values of a range.
    #[schemars(extend("default" = "linear"))]
    spacing: Spacing,
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

/// Schema of a list of values of any type.
fn any_list(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "array", "minItems": 1 })
}

/// Schema of a value that is checked against its field later.
fn any_value(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": ["string", "number"] })
}

/// JSON Schema of study files. `[scene]` and `[set]` accept the keys of any scene.
pub fn schema() -> String {
    let mut schema = own_schema();
    let kinds = SceneKind::ALL.map(file_schema);
    let of_any_kind: Vec<Json> = std::iter::once(json!({ "type": "string" })).chain(kinds.clone()).collect();
    let scene = &mut schema["properties"]["scene"];
    *scene = json!({ "description": scene["description"], "anyOf": of_any_kind });
    let set = "Fields of the base scene that the study replaces in every run.";
    schema["properties"]["set"] = json!({ "description": set, "anyOf": kinds });
    format!("{schema:#}\n")
}

/// Schema of a study file without [scene] and [set], which are checked as scenes.
fn own_schema() -> Json {
    /// Removes the values of omitted keys, which are not defaults.
    fn remove_empty_defaults(schema: &mut Json) {
        if let Json::Object(map) = schema {
            if map.get("default").is_some_and(|default| ["", "[]", "\"\"", "null"].contains(&&*default.to_string())) {
                map.remove("default");
            }
            map.values_mut().for_each(remove_empty_defaults);
        }
    }
    let settings = SchemaSettings::draft07().for_deserialize().with(|settings| settings.inline_subschemas = true);
    let mut schema = settings.into_generator().into_root_schema_for::<StudyFile>().to_value();
    unwrap_lines(&mut schema);
    remove_empty_defaults(&mut schema);
    schema
}

/// Files of a study that has been read: its own, then those that its base scene extends, then the base scene; only its
/// own file if that is a pipe.
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

/// The key of the base scene.
const SCENE: &str = "scene";

/// A path relative to the directory of a study file.
fn beside(study: &Path, path: &str) -> PathBuf {
    study.parent().unwrap_or(Path::new("")).join(path)
}

/// Reads and checks a study file and the base scene it names.
///
/// # Errors
/// Returns an error if the study or its base scene is invalid; the message contains file, line and column.
pub fn load(path: impl AsRef<Path>) -> Result<Study, StudyError> {
    let (text, file) = read(path.as_ref()).map_err(|error| match error {
        SceneError::Read { file, reason } => StudyError::Read { file, reason },
        error => error.into(),
    })?;
    parse(&text, &file)
}

/// Parses the text of a study. `file_name` appears in messages and determines the default name and the directory of the
/// base scene.
pub fn parse(text: &str, file_name: &str) -> Result<Study, StudyError> {
    let invalid = |problems| SceneError::Invalid { file: file_name.to_string(), text: text.to_string(), problems };
    let mut document = DeTable::parse(text).map_err(|error| invalid(vec![syntax_problem(&error)]))?;
    let [inline, set] = [SCENE, "set"].map(|key| take_table(document.get_mut(), key));
    let mut schema = own_schema();
    // A table [set] has been taken out; messages list the key and reject other values.
    schema["properties"]["set"] = json!({ "type": "object", "properties": {} });
    let allowed = keys::KeySchemas { kind: "study", schema: &schema, other_kinds: &Vec::new };
    let checker = Checker::new(text, keys::remove_unknown(document.get_mut(), &allowed));
    check_values(document.get_ref(), &schema, "", &checker);
    let problems = checker.into_problems();
    let study = StudyFile::deserialize(Deserializer::from(document.clone()))
        .map_err(|error| invalid(if problems.is_empty() { vec![syntax_problem(&error)] } else { problems.clone() }))?;
    let checker = Checker::new(text, problems);
    let mut reader = Reader { document: document.get_ref(), kind: SceneKind::Finger, checker };
    let path = Path::new(file_name);
    let base = match inline {
        Some(inline) if inline.get_ref().contains_key(EXTENDS) => {
            let layer = Layer { file: file_name.to_string(), text: text.to_string() };
            Some(base_from_section(&load_extended_in(layer, Some(SCENE))?, SCENE)?)
        }
        Some(inline) => {
            reader.kind = scene_kind(inline.get_ref());
            reader.checker = reader.checker.with_parameters(inline.get_ref());
            let table = check_scene(inline, "scene", reader.kind, &reader.checker);
            Some(Base { table, kind: reader.kind, parameters: reader.checker.parameters.clone(), text: String::new() })
        }
        None if study.scene.is_empty() => {
            let help = "name the base scene: scene = \"experiment-95.toml\", or write it in a table [scene]";
            reader.missing("scene", "", help)
        }
        None => {
            let layers = load_layers(&beside(path, &study.scene)).map_err(|error| match error {
                SceneError::Read { file, reason } => {
                    let message = format!("cannot read the base scene {file}: {reason}");
                    let help = "name a scene file; its path is relative to the directory of the study";
                    invalid(vec![Problem::new(reader.span("scene"), message, "this file", help)])
                }
                error => error,
            })?;
            Some(base_from_layers(&layers, &[])?)
        }
    };
    reader.kind = base.as_ref().map_or(SceneKind::Finger, |base| base.kind);
    let base = base.map(|base| reader.set(base, set));
    let axes = reader.read_axes(&study.axes, base.as_ref());
    let sequence = reader.read_sample(&study, &axes);
    if reader.kind != SceneKind::Finger && reader.span("filter").is_some() {
        let kind = reader.kind.keyword();
        let message = format!("[filter] concerns the statics of one finger, but the base scene is of kind \"{kind}\"");
        let help = "remove it: the results contain the fate and the form closure of every grasp";
        reader.refuse::<()>("filter", message, "has no effect", help);
    }
    let points = sequence.as_ref().map_or(1, Sequence::count);
    let runs = axes.iter().filter_map(Axis::len).chain([points]).try_fold(1u64, u64::checked_mul);
    let runs = runs.filter(|total| *total <= MAX_SHARDED_RUNS);
    if reader.checker.is_clean() && runs.is_none() {
        let message = format!("the study has more than {MAX_SHARDED_RUNS} runs");
        reader.refuse::<()>("", message, "", "remove values, or sample the axes: [sample]");
    }
    let (Some(base), Some(runs), true) = (base, runs, reader.checker.is_clean()) else {
        return Err(invalid(reader.checker.into_problems()).into());
    };
    let unusable = |reason: String| StudyError::Read { file: file_name.to_string(), reason };
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let stem = stem.filter(|stem| !stem.trim().is_empty()).unwrap_or_else(|| "study".to_string());
    let varies_outline =
        axes.iter().flat_map(|axis| &axis.fields).any(|field| field.path.starts_with("object.outline"));
    let is_hand = base.is_hand() && !varies_outline;
    let mut found = Study {
        results: Results::of_hand(base.kind.fingers()),
        name: if study.name.is_empty() { stem } else { study.name },
        description: study.description,
        model: study.model.0,
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
            invalid(vec![Problem::new(reader.span("scene"), message, "this base scene", help)])
        })?;
        found.results =
            Results::of(&scene, &columns, &extrema).map_err(|UnknownFigure { key, index, name, known }| {
                let path = format!("results.{key}.{index}");
                let help = format!("{}the names are {}", similar(&name, &known), list_first(&known));
                let message =
                    format!("`{name}` is no {} of this study", if key == "columns" { "figure" } else { "channel" });
                let span = reader.span(&path);
                invalid(vec![Problem::new(span, message, "unknown name", help)])
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

/// The first names of a list, and the number of the others.
fn list_first(names: &[String]) -> String {
    let (shown, others) = names.split_at(names.len().min(MAX_NAMES));
    let others = if others.is_empty() { String::new() } else { format!(" and {} more", others.len()) };
    shown.join(", ") + &others
}

/// Number of names that a message lists.
const MAX_NAMES: usize = 20;

/// The suggestion of a similar name, if there is one.
fn similar(name: &str, known: &[String]) -> String {
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    keys::closest_match(name, &known).map_or_else(String::new, |near| format!("did you mean `{near}`? "))
}

/// Removes and returns a table of the document. A value of another type stays and is reported later.
fn take_table<'a>(document: &mut DeTable<'a>, key: &str) -> Option<Spanned<DeTable<'a>>> {
    document.get(key).filter(|value| matches!(value.get_ref(), DeValue::Table(_)))?;
    let value = document.remove(key)?;
    let span = value.span();
    if let DeValue::Table(table) = value.into_inner() { Some(Spanned::new(span, table)) } else { None }
}

/// Whether an expression in a table contains this name.
fn uses(table: &DeTable<'_>, name: &str) -> bool {
    fn in_value(value: &DeValue<'_>, name: &str) -> bool {
        match value {
            DeValue::Table(table) => uses(table, name),
            DeValue::Array(items) => items.iter().any(|item| in_value(item.get_ref(), name)),
            DeValue::String(text) if is_expression(text) => {
                text.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == name)
            }
            _ => false,
        }
    }
    table.values().any(|value| in_value(value.get_ref(), name))
}

/// Reads the tables of a study file and collects their problems.
struct Reader<'a> {
    document: &'a DeTable<'a>,
    /// Kind of the base scene.
    kind: SceneKind,
    checker: Checker<'a>,
}

impl Reader<'_> {
    /// The value at a path such as `axes.0.values.2`.
    fn value(&self, path: &str) -> Option<&Spanned<DeValue<'_>>> {
        let mut names = path.split('.');
        let mut value = self.document.get(names.next()?)?;
        for name in names {
            value = match value.get_ref() {
                DeValue::Table(table) => table.get(name)?,
                DeValue::Array(items) => items.get(name.parse::<usize>().ok()?)?,
                _ => return None,
            };
        }
        Some(value)
    }

    /// Position of the value at a path.
    fn span(&self, path: &str) -> Option<Span<usize>> {
        self.value(path).map(Spanned::span)
    }

    /// The items of the list at a path.
    fn items(&self, path: &str) -> &[Spanned<DeValue<'_>>] {
        self.value(path).and_then(|value| value.get_ref().as_array()).map_or(&[], |items| items)
    }

    fn refuse<T>(&self, path: &str, message: impl Into<String>, label: &str, help: impl Into<String>) -> Option<T> {
        self.checker.push(Problem::new(self.span(path), message, label, help));
        None
    }

    fn missing<T>(&self, key: &str, table: &str, help: &str) -> Option<T> {
        self.checker.report_missing_at(key, self.span(table), help);
        None
    }

    /// Merges the table [set] into the base scene.
    fn set(&mut self, mut base: Base, set: Option<Spanned<DeTable<'_>>>) -> Base {
        self.checker.parameters = base.parameters.clone();
        let Some(set) = set else { return base };
        if let Some(section) = set.get_ref().get(PARAMETERS)
            && let Some(of_set) = section.get_ref().as_table()
        {
            for name in of_set.keys().filter(|name| base.parameters.get(name.get_ref()).is_none()) {
                if !uses(set.get_ref(), name.get_ref()) {
                    let (label, help) = unknown(name.get_ref(), &base.parameters.names());
                    let name_of = name.get_ref().escape_debug();
                    let message = format!("unknown parameter `{name_of}`, which no expression of [set] uses");
                    let help = format!("use it in [set], as in mu_static = \"= {name_of}\", or remove it; {help}");
                    self.checker.push(Problem::new(Some(name.span()), message, label, help));
                }
            }
            base.parameters = self.read_parameters(&base, section.span(), of_set);
            self.checker.parameters = base.parameters.clone();
        }
        let table = check_scene(set, "set", self.kind, &self.checker);
        merge(&mut base.table, table);
        base
    }

    /// Evaluates the parameters of the base scene together with those of [set]. Those of the base scene that become invalid
    /// are reported at the section of [set].
    fn read_parameters(&self, base: &Base, section: Span<usize>, of_set: &DeTable<'_>) -> Parameters {
        let of_base = base.table.get(PARAMETERS).map_or_else(String::new, |section| format!("{section}"));
        let text = format!("{PARAMETERS} = {of_base}");
        let document = DeTable::parse(&text).map_or_else(|_| DeTable::new(), Spanned::into_inner);
        let of_base = document.get(PARAMETERS).and_then(|section| section.get_ref().as_table());
        let mut all = DeTable::new();
        for (name, value) in of_base.into_iter().flatten() {
            all.insert(
                Spanned::new(section.clone(), name.get_ref().clone()),
                Spanned::new(section.clone(), value.get_ref().clone()),
            );
        }
        for (name, value) in of_set {
            all.remove(name.get_ref().as_ref());
            all.insert(name.clone(), value.clone());
        }
        let mut scene = DeTable::new();
        scene.insert(
            Spanned::new(section.clone(), PARAMETERS.into()),
            Spanned::new(section.clone(), DeValue::Table(all)),
        );
        let (parameters, problems) = Parameters::read(&scene);
        self.checker.extend(problems);
        parameters
    }

    /// Reads all valid axes. A study without axes runs its scene once.
    fn read_axes(&self, tables: &[AxisTable], base: Option<&Base>) -> Vec<Axis> {
        let (mut axes, Some(base)): (Vec<Axis>, _) = (Vec::new(), base) else { return Vec::new() };
        for (index, table) in tables.iter().enumerate() {
            let path = format!("axes.{index}");
            let Some(axis) = self.read_axis(&path, table, base) else { continue };
            for Field { path: field, .. } in &axis.fields {
                if axes.iter().flat_map(|other| &other.fields).any(|other| other.path == *field) {
                    let key = if table.field.is_empty() { "fields" } else { "field" };
                    let help = "keep one of the axes, with all values of the field";
                    let message = format!("`{field}` is varied by two axes");
                    self.refuse::<()>(&format!("{path}.{key}"), message, "repeated here", help);
                }
            }
            axes.push(axis);
        }
        axes
    }

    fn read_axis(&self, path: &str, table: &AxisTable, base: &Base) -> Option<Axis> {
        let at = |key: &str| format!("{path}.{key}");
        let is_single = !table.field.is_empty();
        if is_single && !table.fields.is_empty() {
            let message = "an axis has both `field` and `fields`";
            return self.refuse(&at("fields"), message, "repeated here", "keep one of them");
        }
        let mut fields: Vec<Field> = Vec::new();
        for (index, name) in table.fields.iter().chain(is_single.then_some(&table.field)).enumerate() {
            let path = if is_single { at("field") } else { at(&format!("fields.{index}")) };
            match base.field(name) {
                Ok(field) if fields.iter().any(|other| other.path == field.path) => {
                    let message = format!("`{name}` is given twice");
                    return self.refuse(&path, message, "repeated here", "remove one of them");
                }
                Ok(field) => fields.push(field),
                Err(Problem { message, label, help, .. }) => {
                    let is_parameter = name.split_once('.').is_some_and(|(section, _)| section == PARAMETERS);
                    let help = if is_parameter { format!("{help}, and a study in [set.parameters]") } else { help };
                    return self.refuse(&path, message, &label, help);
                }
            }
        }
        // The base scene need not have the field; then the first value decides its dimension.
        let written = |index: usize| {
            let rows = if is_single { format!("{path}.values.0") } else { format!("{path}.rows.0.{index}") };
            self.value(&rows).or_else(|| self.value(&at("from"))).and_then(|value| value.get_ref().as_str())
        };
        let no_parameters = Parameters::default();
        let narrow = |(index, field): (usize, Field)| field.narrowed(written(index), &no_parameters);
        let fields: Vec<Field> = fields.into_iter().enumerate().map(narrow).collect();
        let Some(first) = fields.first() else {
            return self.missing("field", path, "name the field of the scene that varies: field = \"design.base\"");
        };
        let (unused, reason): (&[&str], _) = match (is_single, table.values.is_empty()) {
            (false, _) => {
                let reason = "in an axis of several fields, whose values are `rows`";
                (&["values", "from", "to", "count", "spacing"], reason)
            }
            (true, true) => (&["rows"], "in an axis of one field, whose values are `values`"),
            (true, false) => (&["rows", "from", "to", "count", "spacing"], "together with `values`"),
        };
        for key in unused {
            self.checker.report_unused_at(key, self.span(&at(key)), reason);
        }
        let values = match (is_single, table.values.is_empty()) {
            (false, _) => self.read_rows(path, &fields)?,
            (true, true) => self.read_range(path, first, table)?,
            (true, false) => self.read_values(path, first)?,
        };
        Some(Axis { fields, values, repeats_designs: table.again })
    }

    fn read_rows(&self, path: &str, fields: &[Field]) -> Option<AxisValues> {
        let rows = self.items(&format!("{path}.rows"));
        if rows.is_empty() {
            let help = "give a row of values for each run: rows = [[\"480 N*mm\", \"132.6 N*mm\"], ..]";
            return self.missing("rows", path, help);
        }
        let count = fields.len();
        let read_row = |(index, row): (usize, &Spanned<DeValue<'_>>)| {
            let message = match row.get_ref() {
                DeValue::Array(values) if values.len() == count => {
                    return fields.iter().zip(values).map(|(field, value)| self.read_value(field, value)).collect();
                }
                DeValue::Array(values) => format!("a row has {} values, but {count} fields vary", values.len()),
                other => format!("a row is {}, but must be a list", type_name(other)),
            };
            let help = "write one value for each of `fields`, in their order";
            self.refuse(&format!("{path}.rows.{index}"), message, &format!("{count} values"), help)
        };
        rows.iter().enumerate().map(read_row).collect::<Option<_>>().map(AxisValues::Rows)
    }

    fn read_values(&self, path: &str, field: &Field) -> Option<AxisValues> {
        let rows = self
            .items(&format!("{path}.values"))
            .iter()
            .map(|value| self.read_value(field, value).map(|value| vec![value]));
        let rows: Vec<Vec<AxisValue>> = rows.collect::<Option<_>>()?;
        if let Some(index) = (0..rows.len()).find(|&index| rows[..index].contains(&rows[index])) {
            let message = format!("`{}` has the value {} twice", field.path, rows[index][0].text);
            return self.refuse(&format!("{path}.values.{index}"), message, "repeated here", "remove one of them");
        }
        Some(AxisValues::Rows(rows))
    }

    /// Reads the range of an axis of one field: a grid if it has a count.
    fn read_range(&self, path: &str, field: &Field, table: &AxisTable) -> Option<AxisValues> {
        let refuse = |key: &str, message: &str, label: &str, help: &str| {
            self.refuse(&format!("{path}.{key}"), message, label, help)
        };
        let name = &field.path;
        let [from, to] = ["from", "to"].map(|key| self.value(&format!("{path}.{key}")));
        let (from, to) = match (from, to) {
            (Some(from), Some(to)) => (from, to),
            (None, None) => {
                return self.missing("values", path, "give values = [..], or a range: from, to and count");
            }
            (from, _) => {
                let key = if from.is_none() { "from" } else { "to" };
                return self.missing(key, path, "a range requires both ends: from and to");
            }
        };
        let [Some(from), Some(to)] = [from, to].map(|end| self.read_value(field, end)) else { return None };
        let Some(range) = Range::between(field, &from, &to, table.spacing) else {
            let message = format!("`{name}` has no range, because it is not numeric");
            return refuse("from", &message, "not a quantity or a number", "list its values: values = [..]");
        };
        if range.from == range.to {
            let message = format!("the ends of the range of `{name}` are equal");
            return refuse("to", &message, "equal to `from`", "give another end, or a single value: values = [..]");
        }
        if table.spacing == Spacing::Log && !(range.from > 0.0 && range.to > 0.0) {
            let message = format!("the range of `{name}` is not above 0, as spacing = \"log\" requires");
            let help = "change the range, or use spacing = \"linear\"";
            return refuse("spacing", &message, "requires values above 0", help);
        }
        match table.count {
            None if table.again => {
                let message = format!("the sampled axis `{name}` cannot repeat the same designs");
                refuse("again", &message, "a sampled axis", "remove `again`, or give `count` or `values`")
            }
            None => Some(AxisValues::Range(range)),
            Some(count @ 2..=1_000_000) => Some(AxisValues::Rows(range.grid(count))),
            Some(count) => {
                let message = format!("the range of `{name}` has {count} values, but must have from 2 to 1000000");
                refuse("count", &message, "from 2 to 1000000", "give another count")
            }
        }
    }

    fn read_value(&self, field: &Field, value: &Spanned<DeValue<'_>>) -> Option<AxisValue> {
        field.read(value).map_err(|problems| self.checker.extend(problems)).ok()
    }

    fn read_sample(&self, study: &StudyFile, axes: &[Axis]) -> Option<Sequence> {
        let SampleTable { method, count, seed } = &study.sample;
        let ranges = axes.iter().filter(|axis| axis.len().is_none()).count();
        if self.span("sample").is_none() {
            let is_range = |axis: &AxisTable| axis.from.is_some() && axis.to.is_some() && axis.count.is_none();
            if let Some(index) = study.axes.iter().position(is_range) {
                let help = "give the number of values: count = 10, or sample all ranges: [sample] with count = 1000";
                let message = "a range has no `count`, and there is no [sample]";
                self.refuse::<()>(&format!("axes.{index}.from"), message, "count required", help);
            }
            return None;
        }
        let Some(count) = *count else {
            return self.missing("count", "sample", "give the number of points: count = 1000");
        };
        if count > MAX_SHARDED_RUNS {
            let message = format!("`sample.count` is {count}, which is too large");
            return self.refuse("sample.count", message, "too many", format!("take at most {MAX_SHARDED_RUNS} points"));
        }
        // Every part of a study shuffles the slices of all points in memory before its first run.
        if *method == Method::LatinHypercube && count > MAX_RUNS {
            let message = format!("`sample.count` is {count}, but a latin-hypercube has at most {MAX_RUNS} points");
            let help = "take fewer, or use method = \"halton\" or \"random\", whose points need no memory";
            return self.refuse("sample.count", message, "too many for this method", help);
        }
        if ranges == 0 && axes.len() == study.axes.len() {
            let help = "give an axis with `from` and `to` but without `count`, or remove [sample]";
            self.refuse::<()>("sample", "[sample] has no range to sample", "nothing to sample", help);
        }
        if *method == Method::Halton && ranges > MAX_HALTON_AXES {
            let message = format!("a halton sample has at most {MAX_HALTON_AXES} axes, but the study has {ranges}");
            self.refuse::<()>("sample.method", message, "too many axes", "use method = \"latin-hypercube\"");
        }
        Some(Sequence::new(*method, count, seed.unwrap_or(1), ranges))
    }
}

/// Builds a study of these scene fields without rows; each row that [`Study::with_rows`] adds is a design.
///
/// `layers` are the texts of the scene and the scenes it extends, `settings` additional fields, as for
/// `scene::parse_layers`. The scene may lack the fields of the rows.
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
        let scene = parse_layers(layers, settings, parse_any)?;
        Results::of(&scene, &[], &[]).map_err(|unknown| invalid(unknown.name, String::new()))?
    };
    let template = Template::new(base.table, fields.iter());
    let columns: Vec<String> = fields.iter().map(Field::column).collect();
    Ok(Study {
        results: results.without(&columns),
        name: String::new(),
        description: String::new(),
        model,
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
    /// Fields of the first axis, in the order of a row.
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
