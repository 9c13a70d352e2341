//! Formats a scene as a complete scene file, as simulated or as written. It parses back to the same scene bit for bit,
//! except for `source`.

use serde::Serialize;
use toml::de::DeTable;
use toml::{Table, Value};

use super::compose::{find, remove, texts, write_texts};
use super::error::locate_problems;
use super::keys::{join, pair_element};
use super::keywords::SceneKind;
use super::schema::top_level;
use super::section::{Key, Section};
use super::sections::{bodies, drive, law, list, mechanism, motion, table};
use super::value::ValueType;
use super::{Bounds, Differential, Hand, HandFinger, Keyword, Scene, parse_any};
use crate::gripper::{Body, Lengths};
use crate::law::ContactLaw;
use crate::units::{self, Dimension, number};

/// Significant digits of derived values.
const DIGITS: usize = 6;

/// Sections that change a scene even if they are empty.
const OPTIONAL: [&str; 5] = ["design", "lengths", "half_plane", "table", "differential"];

/// Returns the scene as simulated, with all values.
pub fn show(scene: &Scene) -> String {
    let mut text = "# Scene with every default filled in; masses and lengths as simulated.\n".to_string();
    let schema = top_level(scene.kind);
    let exact = |value: &Value, value_type: &ValueType, _: &str| Some(toml_text(value, value_type, None));
    write_texts(&mut text, schema, &to_texts(schema, &resolved(scene), "", &exact), "");
    text
}

/// The settings of a scene as simulated, by section, in SI units.
fn resolved(scene: &Scene) -> Table {
    let hand = &scene.hand;
    // A program may have shortened the run.
    let validate = Bounds { until_s: scene.bounds.until_s.min(scene.duration_s), ..scene.bounds };
    let gravity: Vec<f64> = scene.mechanism.as_ref().map_or(hand.gravity_m_s2, |of| of.gravity_m_s2).into();
    let mut file = table([
        ("name", scene.name.as_str().into()),
        ("kind", scene.kind.keyword().into()),
        ("duration", scene.duration_s.into()),
        ("gravity", gravity.into()),
        ("palm", hand.palm.is_some().into()),
        ("palm_width", hand.palm_width_m.into()),
        ("integrator", serialized(&scene.integrator)),
        ("engine", serialized(&scene.engine)),
        ("validate", serialized(&validate)),
        ("criteria", serialized(&scene.thresholds)),
        ("log", serialized(&scene.log)),
    ]);
    if !scene.description.is_empty() {
        file.insert("description".into(), scene.description.as_str().into());
    }
    if let Some(mechanism) = &scene.mechanism {
        file.extend(match scene.kind {
            SceneKind::Bodies => bodies::discs_settings(mechanism),
            _ => mechanism::mechanism_settings(mechanism),
        });
        return file;
    }
    match &hand.fingers[..] {
        [] => {}
        [first, others @ ..] => {
            file.insert("object".into(), bodies::object_settings(hand.object.as_ref()).into());
            let has_motor = hand.differential.is_none();
            if others.iter().all(|finger| finger == first) {
                file.extend(finger(first, has_motor));
            } else {
                for (side, driven) in hand.fingers_by_side() {
                    file.insert(side.name().into(), finger(driven, has_motor).into());
                }
            }
            if !others.is_empty() {
                add_gripper(&mut file, hand);
            }
        }
    }
    file.extend(hand.palm_motion.iter().flat_map(motion::palm_motion_settings));
    file
}

fn serialized(section: &impl Serialize) -> Value {
    Value::try_from(section).unwrap_or_else(|_| Table::new().into())
}

fn finger(finger: &HandFinger, has_motor: bool) -> Table {
    let HandFinger { linkage, contact: laws, initial, .. } = finger;
    let Lengths { l11_m, l12_m, l21_m, l22_m, t22_m, phi22_rad, half_width_m } = linkage.lengths;
    let lengths = [l11_m, l12_m, l21_m, l22_m, t22_m, phi22_rad].map(Value::from);
    let lengths = ["l11", "l12", "l21", "l22", "t22", "phi22"].map(String::from).into_iter().zip(lengths);
    let bodies = [
        ("l11", linkage.bodies.l11),
        ("l12", linkage.bodies.l12),
        ("l21", linkage.bodies.l21),
        ("l22", linkage.bodies.l22),
    ];
    let bodies = bodies.map(|(name, Body { mass_kg, com_m, inertia_kg_m2 })| {
        (name, table([("mass", mass_kg.into()), ("com", list(com_m)), ("inertia", inertia_kg_m2.into())]).into())
    });
    let start = [
        ("q11", initial.q11_rad.into()),
        ("q21", initial.q21_rad.into()),
        ("qd11", initial.qd11_rad_s.into()),
        ("qd21", initial.qd21_rad_s.into()),
    ];
    let mut contact = law::contact_settings(&laws.proximal);
    if laws.distal != laws.proximal {
        contact.insert("distal".into(), law::contact_settings(&laws.distal).into());
    }
    let mut sections = table([
        ("half_width", half_width_m.into()),
        ("assembly", linkage.assembly.keyword().into()),
        ("lengths", Table::from_iter(lengths).into()),
        ("bodies", table(bodies).into()),
        ("spring", drive::spring_settings(finger.spring).into()),
        ("limit", law::limit_settings(finger.limit).into()),
        ("contact", contact.into()),
        ("initial", table(start).into()),
    ]);
    if has_motor {
        sections.insert("motor".into(), drive::motor_settings(&finger.motor, finger.motor.inertia_kg_m2).into());
    }
    sections
}

/// Adds table, differential, and the contacts with palm and table of a gripper.
fn add_gripper(file: &mut Table, hand: &Hand) {
    let level_m = hand.table.map_or(f64::NAN, |table| table.level_m);
    let mut differential = table([("present", hand.differential.is_some().into())]);
    if let Some(Differential { motor, seesaw_inertia_kg_m2 }) = &hand.differential {
        let [input, seesaw] = [motor.inertia_kg_m2, *seesaw_inertia_kg_m2].map(Value::from);
        differential.extend(table([("input_inertia", input), ("seesaw_inertia", seesaw)]));
        file.insert("motor".into(), drive::motor_settings(motor, 0.0).into());
    }
    file.insert("differential".into(), differential.into());
    let present = hand.table.is_some().into();
    file.insert("table".into(), table([("present", present), ("level", level_m.into())]).into());
    // Fingers that differ would inherit the keys of a common friction law.
    let first = hand.fingers[0].contact.proximal;
    let common = if file.contains_key("contact") { first } else { ContactLaw { friction: None, ..first } };
    let laws = file.entry("contact").or_insert_with(|| law::contact_settings(&common).into());
    for (key, plane) in [("palm", hand.palm), ("table", hand.table)] {
        let law = plane.and_then(|plane| plane.contact).filter(|law| *law != common);
        let law = law.map(|law| (key.to_string(), Value::from(law::contact_settings(&law))));
        laws.as_table_mut().into_iter().for_each(|laws| laws.extend(law.clone()));
    }
}

/// Returns the texts of a table in SI units and its sections; `text` returns the text of a value at a path, or `None` to
/// omit it.
fn to_texts(
    schema: &Section,
    values: &Table,
    path: &str,
    text: &impl Fn(&Value, &ValueType, &str) -> Option<String>,
) -> Table {
    let is_set = |value: &&Value| {
        let items = value.as_array().map_or(std::slice::from_ref(*value), Vec::as_slice);
        !items.is_empty() && items.iter().all(|item| item.as_float().is_none_or(f64::is_finite))
    };
    let is_linear = values.get("linear").and_then(Value::as_bool).unwrap_or(false);
    let value = |key: &Key| {
        let value = values.get(key.field).filter(is_set).filter(|_| schema.effect(key, values).is_ok())?;
        let value_type = key.value_type.of_joint(is_linear);
        Some((key.name.to_string(), text(value, &value_type, &join(path, key.name))?.into()))
    };
    let subsection = |(name, schema): (String, &Section)| {
        let texts = to_texts(schema, values.get(&name)?.as_table()?, &join(path, &name), text);
        // A group of sections with free names has no values of its own.
        (!texts.is_empty() || schema.named().is_none()).then(|| (name, texts.into()))
    };
    let list = |(name, schema): &(&str, Section)| {
        let items = values.get(*name)?.as_array()?.iter().filter_map(Value::as_table);
        let texts: Vec<Value> = items.map(|item| to_texts(schema, item, &join(path, name), text).into()).collect();
        (!texts.is_empty()).then(|| (name.to_string(), texts.into()))
    };
    let sections = tables(schema, values).into_iter().filter_map(subsection);
    schema.keys().iter().filter_map(value).chain(sections).chain(schema.lists().iter().filter_map(list)).collect()
}

/// Sections of a table in the order of the schema, with their schemas; those with free names in the order of names.
fn tables<'a>(schema: &'a Section, values: &Table) -> Vec<(String, &'a Section)> {
    let named = schema.named().into_iter().flat_map(|each| values.keys().map(move |name| (name.clone(), each)));
    schema.subsections().iter().map(|(name, section)| (name.to_string(), section)).chain(named).collect()
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
    let (schema, resolved) = (top_level(scene.kind), resolved(scene));
    let written = texts(document.get_ref(), &scene.source);
    let mut complete = written.clone();
    complete.entry("name").or_insert_with(|| toml::Value::String(scene.name.clone()).to_string().into());
    add_defaults(&mut complete, schema, Some(&resolved));
    loop {
        let mut text = "# Scene as written, with every default filled in.\n".to_string();
        write_texts(&mut text, schema, &complete, "");
        match parse_any(&text, "scene.toml") {
            Ok(found) if found == (Scene { source: found.source.clone(), ..scene.clone() }) => {
                // All values of a mechanism are given.
                let derived = if scene.kind == SceneKind::Mechanism {
                    String::new()
                } else {
                    derived_values(schema, &resolved, &complete)
                };
                return text + &derived;
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
fn add_defaults(complete: &mut Table, schema: &Section, resolved: Option<&Table>) {
    for key in schema.keys() {
        let Some(si) = &key.default else { continue };
        let is_element = |known: &str| pair_element(known).is_some_and(|(pair, _)| pair == key.name);
        let is_written = complete.keys().any(|known| known == key.name || is_element(known));
        let actual = resolved.and_then(|resolved| resolved.get(key.field));
        if !is_written && actual.is_none_or(|actual| actual == si) {
            let default = &key.schema["default"];
            // Other values have the notation of JSON, with spaces between the items of lists.
            let in_json = || default.to_string().replace("\",\"", "\", \"");
            let text = if default.is_number() { toml_text(si, &key.value_type, None) } else { in_json() };
            complete.insert(key.name.to_string(), text.into());
        }
    }
    for (name, schema) in tables(schema, complete) {
        let is_present = complete.contains_key(&name);
        let is_optional = OPTIONAL.contains(&name.as_str()) || schema.schema.get("x-overrides").is_some();
        if is_present || !is_optional && schema.named().is_none() {
            let mut section =
                complete.remove(&name).and_then(|section| section.as_table().cloned()).unwrap_or_default();
            let inner = resolved.and_then(|resolved| resolved.get(&name)?.as_table());
            add_defaults(&mut section, schema, inner);
            if is_present || !section.is_empty() {
                complete.insert(name, section.into());
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
fn derived_values(schema: &Section, resolved: &Table, complete: &Table) -> String {
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
