//! Formats a scene as a complete scene file, as simulated or as written. It parses back to the same scene bit for bit,
//! except for `source`.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::Value as Json;
use toml::de::DeTable;
use toml::{Table, Value};

use super::keys::{is_table, pair_element};
use super::keywords::SceneKind;
use super::locate::locate_problems;
use super::quantity::Word;
use super::schema::{effect, field, properties, schema_for, value_properties};
use super::settings::{
    BodiesSettings, Bounds, ContactOverride, ContactSettings, DifferentialSettings, FingerSettings, HalfPlaneSettings,
    MotorSettings, MoveSettings, SceneFile, SceneSettings, TableSettings, VibrationSettings,
};
use super::texts::{find, remove, texts, write_texts};
use super::value::ValueType;
use super::{DrivenFinger, PalmMotion, Scene, System, parse_any};
use crate::law::ContactLaw;
use crate::units::{self, Dimension, number};

/// Significant digits of derived values.
const DIGITS: usize = 6;

/// Sections that change a scene even if they are empty.
const OPTIONAL: [&str; 5] = ["design", "lengths", "half_plane", "table", "differential"];

/// Returns the scene as simulated, with all values.
pub fn show(scene: &Scene) -> String {
    let mut text = "# Scene with every default filled in; masses and lengths as simulated.\n".to_string();
    write_values(&mut text, schema_for(scene.kind()), &resolved(scene), "", &|value, value_type, _| {
        Some(toml_text(value, value_type, None))
    });
    text
}

/// The settings of a scene as simulated, by section, in SI units.
fn resolved(scene: &Scene) -> Table {
    Table::try_from(SceneFile::from(scene)).unwrap_or_default()
}

impl From<&Scene> for SceneFile {
    fn from(scene: &Scene) -> Self {
        let (system, kind) = (&scene.system, scene.kind());
        let mut file = SceneFile {
            top: SceneSettings {
                name: Some(scene.name.clone()),
                description: Some(scene.description.clone()).filter(|text| !text.is_empty()),
                kind: Some(Word(kind)),
                duration: scene.duration_s.into(),
                gravity: system.gravity_m_s2.map(Into::into),
                palm: Some(system.palm.is_some()),
                palm_width: Some(system.palm_width_m.into()),
                ..SceneSettings::default()
            },
            integrator: Some(scene.integrator),
            engine: Some(scene.engine),
            // A program may have shortened the run.
            validate: Some(Bounds { until_s: scene.bounds.until_s.min(scene.duration_s), ..scene.bounds }),
            criteria: Some(scene.thresholds),
            log: Some(scene.log),
            ..SceneFile::default()
        };
        match &system.fingers[..] {
            [] => {
                let discs = system.discs.iter().map(|disc| (disc.name.clone(), disc.into()));
                file.discs = Some(discs.collect());
                file.half_plane = system.palm.map(|ground| HalfPlaneSettings { level: ground.level_m.into() });
                file.finger.contact = system.between_discs.as_ref().map(contact);
            }
            [first, others @ ..] => {
                file.object = Some(system.object().into());
                let has_motor = system.differential.is_none();
                if others.iter().all(|finger| finger == first) {
                    file.finger = finger_settings(first, has_motor);
                } else {
                    let [right, left] = [0, 1].map(|side| finger_settings(&system.fingers[side], has_motor));
                    (file.right, file.left) = (Some(right), Some(left));
                }
                if kind == SceneKind::Gripper {
                    write_gripper(&mut file, system);
                }
            }
        }
        if let Some(motion) = &system.palm_motion {
            write_palm_motion(&mut file, motion);
        }
        file
    }
}

fn finger_settings(finger: &DrivenFinger, has_motor: bool) -> FingerSettings {
    let (linkage, bodies) = (&finger.linkage, &finger.linkage.bodies);
    let mut laws = contact(&finger.contact.proximal);
    laws.distal = (finger.contact.distal != finger.contact.proximal).then(|| (&finger.contact.distal).into());
    FingerSettings {
        half_width: Some(linkage.lengths.half_width_m.into()),
        assembly: Some(Word(linkage.assembly)),
        lengths: Some((&linkage.lengths).into()),
        bodies: Some(BodiesSettings {
            l11: (&bodies.l11).into(),
            l12: (&bodies.l12).into(),
            l21: (&bodies.l21).into(),
            l22: (&bodies.l22).into(),
        }),
        motor: has_motor.then(|| MotorSettings::from_motor(&finger.motor, finger.motor.inertia_kg_m2)),
        spring: Some(finger.spring.into()),
        limit: Some(finger.limit.into()),
        contact: Some(laws),
        initial: Some(finger.initial.into()),
        ..FingerSettings::default()
    }
}

/// The common law of all contacts.
fn contact(law: &ContactLaw) -> ContactSettings {
    let ContactOverride { law, friction, .. } = law.into();
    ContactSettings { law, friction, ..ContactSettings::default() }
}

/// Sets table, differential, and the contacts with palm and table of a gripper.
fn write_gripper(file: &mut SceneFile, system: &System) {
    let level = system.table.map(|table| table.level_m.into());
    file.table = Some(TableSettings { present: level.is_some(), level });
    file.differential = Some(match &system.differential {
        None => DifferentialSettings::default(),
        Some(differential) => {
            file.finger.motor = Some(MotorSettings::from_motor(&differential.motor, 0.0));
            DifferentialSettings {
                present: true,
                input_inertia: differential.motor.inertia_kg_m2.into(),
                seesaw_inertia: differential.seesaw_inertia_kg_m2.into(),
            }
        }
    });
    let [palm, table] = [system.palm, system.table].map(|plane| plane.and_then(|plane| plane.contact));
    // Fingers that differ would inherit the keys of a common friction law.
    let first = system.fingers[0].contact.proximal;
    let common = if file.finger.contact.is_some() { first } else { ContactLaw { friction: None, ..first } };
    let laws = file.finger.contact.get_or_insert_with(|| contact(&common));
    let differing = |law: Option<ContactLaw>| law.filter(|law| *law != common).map(|law| (&law).into());
    (laws.palm, laws.table) = (differing(palm), differing(table));
}

/// Sets moves, vibrations and path; those without a name are numbered.
fn write_palm_motion(file: &mut SceneFile, motion: &PalmMotion) {
    let name = |names: &[String], prefix: &str, index: usize| {
        let is_valid = |name: &&String| {
            name.starts_with(|first: char| first.is_ascii_alphabetic())
                && name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
        };
        names.get(index).filter(is_valid).cloned().unwrap_or_else(|| format!("{prefix}{}", index + 1))
    };
    let mut moves: BTreeMap<String, MoveSettings> = BTreeMap::new();
    for (index, item) in motion.moves.iter().enumerate() {
        moves.entry(name(&motion.names[0], "m", index)).or_default().add(item);
    }
    let mut vibrations: BTreeMap<String, VibrationSettings> = BTreeMap::new();
    for (index, item) in motion.vibrations.iter().enumerate() {
        vibrations.entry(name(&motion.names[1], "v", index)).or_default().add(item);
    }
    (file.moves, file.vibrations) = (Some(moves), Some(vibrations));
    file.path = motion.path.as_ref().map(Into::into);
}

/// Writes a table and its sections in the order of the schema; `line` returns the text of a value at a path, or `None`
/// to omit it.
fn write_values(
    text: &mut String,
    schema: &Json,
    values: &Table,
    path: &str,
    line: &impl Fn(&Value, &ValueType, &str) -> Option<String>,
) {
    let inner = |key: &str| if path.is_empty() { key.to_string() } else { format!("{path}.{key}") };
    // Writing to a string cannot fail.
    for (key, property) in value_properties(schema) {
        let is_set = |value: &&Value| {
            let items = value.as_array().map_or(std::slice::from_ref(*value), Vec::as_slice);
            !items.is_empty() && items.iter().all(|item| item.as_float().is_none_or(f64::is_finite))
        };
        let value = values.get(field(property)).filter(is_set).filter(|_| effect(property, schema, values).is_ok());
        let value = value.and_then(|value| line(value, &ValueType::from_schema(property), &inner(key)));
        value.into_iter().for_each(|value| _ = writeln!(text, "{key} = {value}"));
    }
    for (key, property) in tables(schema, values) {
        let Some(Value::Table(section)) = values.get(key) else { continue };
        let is_named_group = property.get("properties").is_none();
        if !is_named_group && (section.is_empty() || section.values().any(|value| !value.is_table())) {
            let _ = write!(text, "\n[{}]\n", inner(key));
        }
        write_values(text, property, section, &inner(key), line);
    }
}

/// Sections of a table in the order of the schema, with their schemas; those with free names in the order of names.
fn tables<'a>(schema: &'a Json, values: &'a Table) -> Vec<(&'a String, &'a Json)> {
    let named = schema.get("additionalProperties").filter(|each| each.is_object());
    let named = named.into_iter().flat_map(|each| values.keys().map(move |name| (name, each)));
    properties(schema).into_iter().filter(|(_, property)| is_table(property)).chain(named).collect()
}

/// Returns a value in SI units as TOML, with a number of significant digits; `None` for all digits.
fn toml_text(value: &Value, value_type: &ValueType, digits: Option<usize>) -> String {
    match (value, value_type) {
        (Value::Float(si), ValueType::Quantity(dimension)) => format!("\"{}\"", quantity(*si, *dimension, digits)),
        // A large number without decimal point would overflow TOML integers.
        (Value::Float(value), _) => {
            let text = number(round(*value, digits));
            if text.contains(['.', 'e']) { text } else { text + ".0" }
        }
        (Value::Array(items), ValueType::List(item_type, _)) => {
            let items: Vec<String> = items.iter().map(|item| toml_text(item, item_type, digits)).collect();
            format!("[{}]", items.join(", "))
        }
        _ => value.to_string(),
    }
}

fn round(value: f64, digits: Option<usize>) -> f64 {
    let digits = digits.map(|digits| format!("{value:.*e}", digits.saturating_sub(1)));
    digits.and_then(|text| text.parse().ok()).unwrap_or(value)
}

fn quantity(si: f64, dimension: Dimension, digits: Option<usize>) -> String {
    if digits.is_none() {
        return units::format(si, dimension);
    }
    // Smaller lengths and angles are rounding errors.
    let is_rounding_error = matches!(dimension, Dimension::Length | Dimension::Angle) && si.abs() < 1e-12;
    // A value rounded in radians is not round in degrees.
    if dimension == Dimension::Angle && si.to_degrees().abs() >= 0.1 {
        return format!("{} deg", number(round(si.to_degrees(), digits)));
    }
    let exact = units::format(if is_rounding_error { 0.0 } else { round(si, digits) }, dimension);
    match exact.split_once(' ').map(|(size, unit)| (size.parse::<f64>(), unit)) {
        Some((Ok(size), unit)) => format!("{} {unit}", number(round(size, digits))),
        _ => exact,
    }
}

/// Returns the source of the scene with every default added, and with derived values as comments. A scene that has been
/// changed since its source was read is shown in full as it is now.
pub fn show_written(scene: &Scene) -> String {
    let Ok(document) = DeTable::parse(&scene.source) else { return show(scene) };
    let (schema, resolved) = (schema_for(scene.kind()), resolved(scene));
    let written = texts(document.get_ref(), &scene.source);
    let mut complete = written.clone();
    complete.entry("name").or_insert_with(|| toml::Value::String(scene.name.clone()).to_string().into());
    add_defaults(&mut complete, schema, Some(&resolved));
    loop {
        let mut text = "# Scene as written, with every default filled in.\n".to_string();
        write_texts(&mut text, schema, &complete, "");
        match parse_any(&text, "scene.toml") {
            Ok(found) if found == (Scene { source: found.source.clone(), ..scene.clone() }) => {
                return text + &derived_values(schema, &resolved, &complete);
            }
            Ok(_) => return show(scene),
            // Some keys have no effect with the others.
            Err(error) => {
                let fields = locate_problems(&error).into_iter().filter_map(|problem| problem.field);
                let added: Vec<String> = fields.filter(|path| find(&written, path).is_none()).collect();
                if !added.iter().any(|path| remove(&mut complete, path)) {
                    return show(scene);
                }
                added.iter().for_each(|path| _ = remove(&mut complete, path));
            }
        }
    }
}

/// Adds the defaults of the schema that the resolved scene has; `resolved` is the same table of it.
fn add_defaults(complete: &mut Table, schema: &Json, resolved: Option<&Table>) {
    for (key, property) in value_properties(schema) {
        let value_type = ValueType::from_schema(property);
        let Some(si) = property.get("x-si").and_then(|si| Value::try_from(si).ok()) else { continue };
        let is_written =
            complete.keys().any(|known| known == key || pair_element(known).is_some_and(|(pair, _)| pair == key));
        let actual = resolved.and_then(|resolved| resolved.get(field(property)));
        if !is_written && actual.is_none_or(|actual| *actual == si) {
            let default = &property["default"];
            let text = if default.is_number() { toml_text(&si, &value_type, None) } else { json_text(default) };
            complete.insert(key.clone(), text.into());
        }
    }
    let names: Vec<(String, Json)> =
        tables(schema, complete).into_iter().map(|(key, property)| (key.clone(), property.clone())).collect();
    for (key, property) in names {
        let is_present = complete.contains_key(&key);
        let is_optional = OPTIONAL.contains(&key.as_str()) || property.get("x-overrides").is_some();
        if is_present || !is_optional && property.get("properties").is_some() {
            let mut section = complete.remove(&key).and_then(|section| section.as_table().cloned()).unwrap_or_default();
            let inner = resolved.and_then(|resolved| resolved.get(&key)?.as_table());
            add_defaults(&mut section, &property, inner);
            if is_present || !section.is_empty() {
                complete.insert(key, section.into());
            }
        }
    }
}

/// Formats a default of the schema as TOML, whose notation of texts, booleans and lists of them is that of JSON.
fn json_text(default: &Json) -> String {
    match default {
        Json::Array(items) => format!("[{}]", items.iter().map(json_text).collect::<Vec<_>>().join(", ")),
        other => other.to_string(),
    }
}

/// Returns the values derived from the scene, rounded, as comments.
fn derived_values(schema: &Json, resolved: &Table, complete: &Table) -> String {
    // A value may be given in a common section: that of both fingers, the common contact law, or the design for some
    // lengths.
    let is_given = |path: &str| {
        let common = ["right.", "left."].into_iter().find_map(|side| path.strip_prefix(side)).unwrap_or(path);
        let contacts = ["proximal", "distal", "palm", "table"];
        let contact = contacts.into_iter().find(|contact| common.starts_with(&format!("contact.{contact}.")));
        let law = contact.map_or(common.to_string(), |contact| common.replacen(&format!("{contact}."), "", 1));
        let design = common.replacen("lengths.", "design.", 1);
        [path, common, &law, &design].into_iter().any(|path| find(complete, path).is_some())
    };
    let mut text = String::new();
    write_values(&mut text, schema, resolved, "", &|value, value_type, path| {
        (!is_given(path)).then(|| toml_text(value, value_type, Some(DIGITS)))
    });
    // Headers without values are omitted.
    let sections = text.split("\n\n").filter(|section| section.contains(" = "));
    let lines: Vec<String> = sections
        .flat_map(|section| section.trim().lines())
        .map(|line| match line.starts_with('[') {
            true => format!("#\n# {line}\n"),
            false => format!("# {line}\n"),
        })
        .collect();
    if lines.is_empty() {
        return String::new();
    }
    format!("\n# Derived values, rounded (`scene show --resolved` shows all digits):\n{}", lines.concat())
}
