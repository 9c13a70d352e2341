//! Formats a scene as a complete scene file, as simulated or as written. It parses back to the same scene bit for bit,
//! except for `source`.

use serde::Serialize;
use serde_json::Value as Json;
use toml::de::DeTable;
use toml::{Table, Value};

use super::keys::{is_table, join, pair_element};
use super::locate::locate_problems;
use super::schema::{effect, field, properties, schema_for, value_properties};
use super::settings::{self, table};
use super::texts::{find, remove, texts, write_texts};
use super::value::ValueType;
use super::{Bounds, Differential, DrivenFinger, Keyword, Scene, System, parse_any};
use crate::law::ContactLaw;
use crate::units::{self, Dimension, number};

/// Significant digits of derived values.
const DIGITS: usize = 6;

/// Sections that change a scene even if they are empty.
const OPTIONAL: [&str; 5] = ["design", "lengths", "half_plane", "table", "differential"];

/// Returns the scene as simulated, with all values.
pub fn show(scene: &Scene) -> String {
    let mut text = "# Scene with every default filled in; masses and lengths as simulated.\n".to_string();
    let schema = schema_for(scene.kind());
    let exact = |value: &Value, value_type: &ValueType, _: &str| Some(toml_text(value, value_type, None));
    write_texts(&mut text, schema, &to_texts(schema, &resolved(scene), "", &exact), "");
    text
}

/// The settings of a scene as simulated, by section, in SI units.
fn resolved(scene: &Scene) -> Table {
    let system = &scene.system;
    // A program may have shortened the run.
    let validate = Bounds { until_s: scene.bounds.until_s.min(scene.duration_s), ..scene.bounds };
    let gravity: Vec<f64> = system.gravity_m_s2.into();
    let mut file = table([
        ("name", scene.name.as_str().into()),
        ("kind", scene.kind().keyword().into()),
        ("duration", scene.duration_s.into()),
        ("gravity", gravity.into()),
        ("palm", system.palm.is_some().into()),
        ("palm_width", system.palm_width_m.into()),
        ("integrator", serialized(&scene.integrator)),
        ("engine", serialized(&scene.engine)),
        ("validate", serialized(&validate)),
        ("criteria", serialized(&scene.thresholds)),
        ("log", serialized(&scene.log)),
    ]);
    if !scene.description.is_empty() {
        file.insert("description".into(), scene.description.as_str().into());
    }
    match &system.fingers[..] {
        [] => {
            let discs: Table =
                system.discs.iter().map(|disc| (disc.name.clone(), settings::disc(disc).into())).collect();
            file.insert("discs".into(), discs.into());
            let ground = system.palm.map(|ground| table([("level", ground.level_m.into())]).into());
            file.extend(ground.map(|ground| ("half_plane".to_string(), ground)));
            file.extend(system.between_discs.map(|law| ("contact".to_string(), settings::contact(&law).into())));
        }
        [first, others @ ..] => {
            file.insert("object".into(), settings::object(system.object()).into());
            let has_motor = system.differential.is_none();
            if others.iter().all(|finger| finger == first) {
                file.extend(finger(first, has_motor));
            } else {
                for (side, driven) in system.fingers_by_side() {
                    file.insert(side.name().into(), finger(driven, has_motor).into());
                }
            }
            if !others.is_empty() {
                add_gripper(&mut file, system);
            }
        }
    }
    file.extend(system.palm_motion.iter().flat_map(settings::palm_motion));
    file
}

fn serialized(section: &impl Serialize) -> Value {
    Value::try_from(section).unwrap_or_else(|_| Table::new().into())
}

fn finger(finger: &DrivenFinger, has_motor: bool) -> Table {
    let linkage = &finger.linkage;
    let mut contact = settings::contact(&finger.contact.proximal);
    if finger.contact.distal != finger.contact.proximal {
        contact.insert("distal".into(), settings::contact(&finger.contact.distal).into());
    }
    let mut sections = table([
        ("half_width", linkage.lengths.half_width_m.into()),
        ("assembly", linkage.assembly.keyword().into()),
        ("lengths", settings::lengths(&linkage.lengths).into()),
        ("bodies", settings::bodies(&linkage.bodies).into()),
        ("spring", settings::spring(finger.spring).into()),
        ("limit", settings::limit(finger.limit).into()),
        ("contact", contact.into()),
        ("initial", settings::initial(&finger.initial).into()),
    ]);
    if has_motor {
        sections.insert("motor".into(), settings::motor(&finger.motor, finger.motor.inertia_kg_m2).into());
    }
    sections
}

/// Adds table, differential, and the contacts with palm and table of a gripper.
fn add_gripper(file: &mut Table, system: &System) {
    let level_m = system.table.map_or(f64::NAN, |table| table.level_m);
    let mut differential = table([("present", system.differential.is_some().into())]);
    if let Some(Differential { motor, seesaw_inertia_kg_m2 }) = &system.differential {
        let [input, seesaw] = [motor.inertia_kg_m2, *seesaw_inertia_kg_m2].map(Value::from);
        differential.extend(table([("input_inertia", input), ("seesaw_inertia", seesaw)]));
        file.insert("motor".into(), settings::motor(motor, 0.0).into());
    }
    file.insert("differential".into(), differential.into());
    let present = system.table.is_some().into();
    file.insert("table".into(), table([("present", present), ("level", level_m.into())]).into());
    // Fingers that differ would inherit the keys of a common friction law.
    let first = system.fingers[0].contact.proximal;
    let common = if file.contains_key("contact") { first } else { ContactLaw { friction: None, ..first } };
    let laws = file.entry("contact").or_insert_with(|| settings::contact(&common).into());
    for (key, plane) in [("palm", system.palm), ("table", system.table)] {
        let law = plane.and_then(|plane| plane.contact).filter(|law| *law != common);
        let law = law.map(|law| (key.to_string(), Value::from(settings::contact(&law))));
        laws.as_table_mut().into_iter().for_each(|laws| laws.extend(law.clone()));
    }
}

/// Returns the texts of a table in SI units and its sections; `text` returns the text of a value at a path, or `None` to
/// omit it.
fn to_texts(
    schema: &Json,
    values: &Table,
    path: &str,
    text: &impl Fn(&Value, &ValueType, &str) -> Option<String>,
) -> Table {
    let is_set = |value: &&Value| {
        let items = value.as_array().map_or(std::slice::from_ref(*value), Vec::as_slice);
        !items.is_empty() && items.iter().all(|item| item.as_float().is_none_or(f64::is_finite))
    };
    let value = |(key, property): (&String, &Json)| {
        let value = values.get(field(property)).filter(is_set).filter(|_| effect(property, schema, values).is_ok())?;
        Some((key.clone(), text(value, &ValueType::from_schema(property), &join(path, key))?.into()))
    };
    let section = |(key, property): (&String, &Json)| {
        let section = to_texts(property, values.get(key)?.as_table()?, &join(path, key), text);
        // A group of sections with free names has no values of its own.
        (!section.is_empty() || property.get("properties").is_some()).then(|| (key.clone(), section.into()))
    };
    value_properties(schema).filter_map(value).chain(tables(schema, values).into_iter().filter_map(section)).collect()
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
            // Other values have the notation of JSON, with spaces between the items of lists.
            let in_json = || default.to_string().replace("\",\"", "\", \"");
            let text = if default.is_number() { toml_text(&si, &value_type, None) } else { in_json() };
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

/// The settings of a scene with a contact law by the contact to which it belongs, where the contacts differ: [contact] is
/// then not the section of this name in the scene as written.
fn by_contact(resolved: &Table) -> Table {
    let mut file = resolved.clone();
    let differs = ["right", "left"].iter().any(|side| file.contains_key(*side));
    for (key, section) in &mut file {
        let contact = if key == "contact" { Some(section) } else { section.get_mut("contact") };
        let Some(Value::Table(laws)) = contact else { continue };
        let (others, law): (Table, Table) =
            std::mem::take(laws).into_iter().partition(|(key, _)| ["distal", "palm", "table"].contains(&key.as_str()));
        match (others.contains_key("distal"), key == "contact" && differs) {
            (true, _) => laws.extend([("proximal".to_string(), law.into())]),
            (false, true) => {}
            (false, false) => laws.extend(law),
        }
        laws.extend(others);
    }
    file
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
    let derived = to_texts(schema, &by_contact(resolved), "", &|value, value_type, path| {
        (!is_given(path)).then(|| toml_text(value, value_type, Some(DIGITS)))
    });
    write_texts(&mut text, schema, &derived, "");
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
