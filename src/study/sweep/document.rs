//! Documents of study files: their keys, positions in them, and the base scene. Types, units and unknown keys are checked against
//! the JSON Schema that is derived from the structure of the file; positions in messages are looked up in the parsed document.

use std::ops::Range as Span;
use std::path::{Path, PathBuf};

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value as Json, json};
use toml::de::{DeTable, DeValue, Deserializer};
use toml::{Spanned, Table};

use super::base_scene::{
    Base, base_from_layers, base_from_section, check_scene, check_values, insert_at_path, merge, scene_kind,
};
use crate::scene::check::Checker;
use crate::scene::keywords::SceneKind;
use crate::scene::parameters::{Parameters, unknown};
use crate::scene::parse::syntax_problem;
use crate::scene::schema::{file_schema, unwrap_lines};
use crate::scene::{
    EXTENDS, Keyword, Layer, PARAMETERS, Part, Problem, SceneError, keys, load_extended_in, load_layers, read,
};
use crate::units::is_expression;

/// The key that contains the base scene.
pub const SCENE: &str = "scene";
/// The table of fields that the study replaces.
const SET: &str = "set";

/// Error in a study. It is formatted like an error in a scene: `error:`, location, source line and help.
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

/// Returns the text of a study file, and its name for messages.
pub fn read_study(path: &Path) -> Result<(String, String), StudyError> {
    read(path).map_err(|error| match error {
        SceneError::Read { file, reason } => StudyError::Read { file, reason },
        error => error.into(),
    })
}

/// Resolves a path relative to the directory of a study file.
pub fn beside(study: &Path, path: &str) -> PathBuf {
    study.parent().unwrap_or(Path::new("")).join(path)
}

/// Default name of a study: the file name without its extension.
pub fn default_name(file_name: &str) -> String {
    let stem = Path::new(file_name).file_stem().map(|stem| stem.to_string_lossy().into_owned());
    stem.filter(|stem| !stem.trim().is_empty()).unwrap_or_else(|| "study".to_string())
}

/// Returns the JSON Schema of study files with this structure. `[scene]` and `[set]` accept the keys of all kinds of
/// scene.
pub fn schema<T: JsonSchema>() -> String {
    let mut schema = own_schema::<T>();
    let kinds = SceneKind::ALL.map(file_schema);
    let of_any_kind: Vec<Json> = std::iter::once(json!({ "type": "string" })).chain(kinds.clone()).collect();
    let scene = &mut schema["properties"][SCENE];
    *scene = json!({ "description": scene["description"], "anyOf": of_any_kind });
    let set = "Fields of the base scene that the study replaces in every run.";
    schema["properties"][SET] = json!({ "description": set, "anyOf": kinds });
    format!("{schema:#}\n")
}

/// Schema of a study file without [scene] and [set], which are checked as scenes.
fn own_schema<T: JsonSchema>() -> Json {
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
    let mut schema = settings.into_generator().into_root_schema_for::<T>().to_value();
    unwrap_lines(&mut schema);
    remove_empty_defaults(&mut schema);
    schema
}

/// Schema of a list of values of any type.
pub fn any_list(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "array", "minItems": 1 })
}

/// Schema of a value that is checked against its field at a later time.
pub fn any_value(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": ["string", "number"] })
}

/// A study file whose keys have been checked. It collects the problems of their values.
pub struct Document<'a> {
    pub file_name: &'a str,
    /// The keys without [scene] and [set].
    values: DeTable<'a>,
    inline: Option<Spanned<DeTable<'a>>>,
    set: Option<Spanned<DeTable<'a>>>,
    /// Kind of the base scene; a finger until the base scene has been read.
    pub kind: SceneKind,
    /// Texts of the base scene, after those that it extends; the last one is the study if the scene is a part of it.
    layers: Vec<Layer>,
    pub checker: Checker<'a>,
}

/// The problem of a scene that is given instead of a study: it has no base scene, but a key of scenes at its top level.
fn scene_given(values: &DeTable<'_>, file_name: &str) -> Option<Problem> {
    if values.contains_key(SCENE) {
        return None;
    }
    let key = ["kind", EXTENDS, "duration", "design", "lengths", "bodies"]
        .into_iter()
        .find_map(|key| values.get_key_value(key))?;
    let name = Path::new(file_name).file_name().map_or_else(|| file_name.into(), |name| name.to_string_lossy());
    let help = format!(
        "write a study that names it: scene = \"{name}\", and the fields to vary; scenes/studies contains examples"
    );
    Some(Problem::new(Some(key.0.span()), "this file is a scene, not a study", "a key of scenes", help))
}

impl<'a> Document<'a> {
    /// Reads the keys of a study file. `file_name` appears in messages, and the path of the base scene is relative to
    /// its directory.
    pub fn read<T: DeserializeOwned + JsonSchema>(text: &'a str, file_name: &'a str) -> Result<(T, Self), SceneError> {
        let invalid = |problems| invalid(text, file_name, problems);
        let mut values = DeTable::parse(text).map_err(|error| invalid(vec![syntax_problem(&error)]))?;
        if let Some(problem) = scene_given(values.get_ref(), file_name) {
            return Err(invalid(vec![problem]));
        }
        let [inline, set] = [SCENE, SET].map(|key| take_table(values.get_mut(), key));
        let mut schema = own_schema::<T>();
        // A table [set] has been taken out; messages list the key and reject other values.
        schema["properties"][SET] = json!({ "type": "object", "properties": {} });
        let allowed = keys::KeySchemas { kind: "study", schema: &schema, other_kinds: &Vec::new };
        let checker = Checker::new(text, keys::remove_unknown(values.get_mut(), &allowed));
        check_values(values.get_ref(), &schema, "", &checker);
        let problems = checker.into_problems();
        let file = T::deserialize(Deserializer::from(values.clone())).map_err(|error| {
            invalid(if problems.is_empty() { vec![syntax_problem(&error)] } else { problems.clone() })
        })?;
        let (values, checker) = (values.into_inner(), Checker::new(text, problems));
        let document =
            Document { file_name, values, inline, set, kind: SceneKind::Finger, layers: Vec::new(), checker };
        Ok((file, document))
    }

    /// Reads the base scene, from the file `scene` or from the table [scene], and merges [set] into it; `None` if there
    /// is neither.
    pub fn read_base(&mut self, scene: &str) -> Result<Option<Base>, SceneError> {
        let Some(base) = self.read_scene(scene)? else { return Ok(None) };
        self.kind = base.kind;
        Ok(Some(self.set(base)))
    }

    fn read_scene(&mut self, scene: &str) -> Result<Option<Base>, SceneError> {
        let own = Layer { file: self.file_name.to_string(), text: self.checker.text.to_string() };
        match self.inline.clone() {
            Some(inline) if inline.get_ref().contains_key(EXTENDS) => {
                self.layers = load_extended_in(own, Some(SCENE))?;
                base_from_section(&self.layers, SCENE).map(Some)
            }
            Some(inline) => {
                self.layers = vec![own];
                let kind = scene_kind(inline.get_ref());
                self.checker = self.take_checker().with_parameters(inline.get_ref());
                let table = check_scene(inline, SCENE, kind, &self.checker);
                Ok(Some(Base { table, kind, parameters: self.checker.parameters.clone(), text: String::new() }))
            }
            None if scene.is_empty() => {
                let help = "name the base scene: scene = \"experiment-95.toml\", or write it in a table [scene]";
                Ok(self.missing(SCENE, "", help))
            }
            None => {
                self.layers = load_layers(&beside(Path::new(self.file_name), scene)).map_err(|error| match error {
                    SceneError::Read { file, reason } => {
                        let message = format!("cannot read the base scene {file}: {reason}");
                        let help = "name a scene file; its path is relative to the directory of the study";
                        self.invalid(vec![Problem::new(self.span(SCENE), message, "this file", help)])
                    }
                    error => error,
                })?;
                base_from_layers(&self.layers, &[]).map(Some)
            }
        }
    }

    /// Returns the texts of the base scene with other values for some fields. They are its files, unchanged, and a last
    /// text that extends them with [scene], [set] and the values.
    pub fn scene_layers(&self, fields: Vec<(Vec<Part>, toml::Value)>) -> Vec<Layer> {
        let table = |section: &Option<Spanned<DeTable<'a>>>| {
            let section = section.clone().map(|section| Table::deserialize(Deserializer::from(section)));
            section.and_then(Result::ok).unwrap_or_default()
        };
        let mut own = table(&self.inline);
        own.remove(EXTENDS);
        merge(&mut own, table(&self.set));
        fields.into_iter().for_each(|(path, value)| insert_at_path(&mut own, &path, value));
        let own = Layer { file: self.file_name.to_string(), text: own.to_string() };
        self.layers.iter().filter(|layer| layer.file != self.file_name).cloned().chain([own]).collect()
    }

    /// Position of a field of the base scene in [scene] or [set]. If the field is not there, it is the position of the
    /// innermost part of its path.
    pub fn scene_span(&self, field: &str) -> Option<Span<usize>> {
        let in_section = |section: &Spanned<DeTable<'a>>| {
            let (mut table, mut found) = (Some(section.get_ref()), (0, section.span()));
            for name in field.split(['.', '[']) {
                let Some(value) = table.and_then(|table| table.get(name)) else { break };
                (table, found) = (value.get_ref().as_table(), (found.0 + 1, value.span()));
            }
            found
        };
        let sections = [&self.set, &self.inline].into_iter().flatten().map(in_section);
        let deepest = sections.max_by_key(|(depth, _)| *depth).filter(|(depth, _)| *depth > 0 || self.inline.is_some());
        deepest.map(|(_, span)| span).or_else(|| self.span(SCENE))
    }

    /// The study file, and the files of the base scene.
    pub fn files(&self) -> Vec<PathBuf> {
        let of_scene = self.layers.iter().rev().filter(|layer| layer.file != self.file_name);
        [self.file_name].into_iter().chain(of_scene.map(|layer| &layer.file[..])).map(PathBuf::from).collect()
    }

    /// Keys of the study file without [scene] and [set].
    pub fn keys(&self) -> Table {
        Table::deserialize(Deserializer::from(Spanned::new(0..0, self.values.clone()))).unwrap_or_default()
    }

    /// Returns the error that consists of these problems.
    pub fn invalid(&self, problems: Vec<Problem>) -> SceneError {
        invalid(self.checker.text, self.file_name, problems)
    }

    /// Checks that no problem has been found.
    ///
    /// # Errors
    /// Returns the problems found so far.
    pub fn check(&mut self) -> Result<(), SceneError> {
        match self.checker.is_clean() {
            true => Ok(()),
            false => {
                let problems = self.take_checker().into_problems();
                Err(self.invalid(problems))
            }
        }
    }

    fn take_checker(&mut self) -> Checker<'a> {
        let text = self.checker.text;
        std::mem::replace(&mut self.checker, Checker::new(text, Vec::new()))
    }

    /// Reports a filter if the scene is not a finger.
    pub fn check_filter(&self) {
        if self.kind != SceneKind::Finger && self.span("filter").is_some() {
            let kind = self.kind.keyword();
            let message =
                format!("[filter] concerns the statics of one finger, but the base scene is of kind \"{kind}\"");
            let help = "remove it: the results contain the fate and the form closure of every grasp";
            self.refuse::<()>("filter", message, "has no effect", help);
        }
    }

    /// Returns the value at a path such as `axes.0.values.2`.
    pub fn value(&self, path: &str) -> Option<&Spanned<DeValue<'a>>> {
        let mut names = path.split('.');
        let mut value = self.values.get(names.next()?)?;
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
    pub fn span(&self, path: &str) -> Option<Span<usize>> {
        self.value(path).map(Spanned::span)
    }

    /// Returns the items of the list at a path.
    pub fn items(&self, path: &str) -> &[Spanned<DeValue<'a>>] {
        self.value(path).and_then(|value| value.get_ref().as_array()).map_or(&[], |items| items)
    }

    pub fn refuse<T>(&self, path: &str, message: impl Into<String>, label: &str, help: impl Into<String>) -> Option<T> {
        self.checker.push(Problem::new(self.span(path), message, label, help));
        None
    }

    pub fn missing<T>(&self, key: &str, table: &str, help: &str) -> Option<T> {
        self.checker.report_missing_at(key, self.span(table), help);
        None
    }

    /// Merges the table [set] into the base scene.
    fn set(&mut self, mut base: Base) -> Base {
        self.checker.parameters = base.parameters.clone();
        let Some(set) = self.set.clone() else { return base };
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
}

fn invalid(text: &str, file_name: &str, problems: Vec<Problem>) -> SceneError {
    SceneError::Invalid { file: file_name.to_string(), text: text.to_string(), problems }
}

/// Returns the first names of a list, and the number of the remaining ones, as text.
pub fn list_first(names: &[String]) -> String {
    let (shown, others) = names.split_at(names.len().min(MAX_NAMES));
    let others = if others.is_empty() { String::new() } else { format!(" and {} more", others.len()) };
    shown.join(", ") + &others
}

/// Number of names that a message lists.
const MAX_NAMES: usize = 20;

/// Returns the suggestion of a similar name; empty if there is none.
pub fn similar(name: &str, known: &[String]) -> String {
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
