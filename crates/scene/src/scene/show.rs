//! Formats a scene as a complete scene file, as simulated or as written. It parses back to the same scene bit for bit,
//! except for `source`.

use serde_json::{Value as Json, json};
use toml::de::{DeTable, DeValue};
use toml::{Spanned, Table, Value};

use super::compose::{find, remove, texts, write_texts};
use super::error::locate_problems;
use super::field::split_entries;
use super::keys::join;
use super::keywords::SceneKind;
use super::parameters::Parameters;
use super::schema::top_level;
use super::section::{Key, Section};
use super::sections::{bodies, drive, extend, law, mechanism, motion};
use super::value::ValueType;
use super::{Bounds, Differential, Hand, HandFinger, Keyword, Scene, Thresholds, parse_any};
use crate::gripper::{Body, Lengths};
use crate::law::ContactLaw;
use crate::units::{self, Dimension, Measured, is_expression, number};

/// Significant digits of derived values.
const DIGITS: usize = 6;

/// First line of a scene as written.
const HEAD: &str = "# Scene as written, with every default filled in.\n";

/// Sections that change a scene even if they are empty.
const OPTIONAL: [&str; 7] = ["design", "lengths", "half_plane", "table", "differential", "grasp", "feedback"];

/// Returns the scene as simulated, with all values, in the form of a scene file.
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
    let mut file = json!({
        "name": scene.name,
        "description": Some(&scene.description).filter(|text| !text.is_empty()),
        "kind": scene.kind,
        "duration": scene.duration_s,
        "gravity": scene.mechanism.as_ref().map_or(hand.gravity_m_s2, |of| of.gravity_m_s2),
        "palm": hand.palm.is_some(),
        "palm_width": hand.palm_width_m,
        "integrator": scene.integrator,
        "engine": scene.engine,
        "validate": validate,
        // A mechanism without a grasp has none.
        "criteria": Some(scene.thresholds).filter(|thresholds| hand.fingers.len() > 1 || *thresholds != Thresholds::NONE),
        "log": scene.log,
    });
    match (&scene.mechanism, scene.kind) {
        (Some(mechanism), SceneKind::Bodies) => extend(&mut file, bodies::discs_settings(mechanism)),
        (Some(mechanism), _) => {
            extend(&mut file, mechanism::mechanism_settings(mechanism));
            file["grasp"] = scene.grasp.as_ref().map(|keys| mechanism::grasp_settings(keys, mechanism)).into();
        }
        (None, _) => add_hand(&mut file, hand),
    }
    let file = to_toml(file).and_then(|file| file.try_into().ok());
    file.unwrap_or_default()
}

/// Converts settings to TOML. Values that are missing or not finite, which are null, are omitted.
fn to_toml(settings: Json) -> Option<Value> {
    Some(match settings {
        Json::Null => return None,
        Json::Bool(flag) => flag.into(),
        Json::Number(number) => number.as_i64().map(Value::from).or(number.as_f64().map(Value::from))?,
        Json::String(text) => text.into(),
        Json::Array(items) => items.into_iter().map(to_toml).collect::<Option<Vec<_>>>()?.into(),
        Json::Object(settings) => {
            let settings = settings.into_iter().filter_map(|(key, value)| Some((key, to_toml(value)?)));
            settings.collect::<Table>().into()
        }
    })
}

/// Adds fingers, object, table, differential and motion of the palm.
fn add_hand(file: &mut Json, hand: &Hand) {
    let Some((first, others)) = hand.fingers.split_first() else { return };
    file["object"] = bodies::object_settings(hand.object.as_ref());
    let has_motor = hand.differential.is_none();
    if others.iter().all(|finger| finger == first) {
        extend(file, finger(first, has_motor));
    } else {
        for (side, driven) in hand.fingers_by_side() {
            file[side.name()] = finger(driven, has_motor);
        }
    }
    if !others.is_empty() {
        add_gripper(file, hand);
    }
    if let Some(motion) = &hand.palm_motion {
        extend(file, motion::palm_motion_settings(motion, None));
    }
}

fn finger(finger: &HandFinger, has_motor: bool) -> Json {
    let HandFinger { linkage, contact: laws, initial, motor, .. } = finger;
    let Lengths { l11_m, l12_m, l21_m, l22_m, t22_m, phi22_rad, half_width_m } = linkage.lengths;
    let body = |body: Body| json!({ "mass": body.mass_kg, "com": body.com_m, "inertia": body.inertia_kg_m2 });
    let mut contact = law::contact_settings(&laws.proximal);
    if laws.distal != laws.proximal {
        contact["distal"] = law::contact_settings(&laws.distal);
    }
    json!({
        "half_width": half_width_m,
        "assembly": linkage.assembly.keyword(),
        "lengths": { "l11": l11_m, "l12": l12_m, "l21": l21_m, "l22": l22_m, "t22": t22_m, "phi22": phi22_rad },
        "bodies": {
            "l11": body(linkage.bodies.l11),
            "l12": body(linkage.bodies.l12),
            "l21": body(linkage.bodies.l21),
            "l22": body(linkage.bodies.l22),
        },
        "motor": has_motor.then(|| drive::motor_settings(motor, motor.inertia_kg_m2)),
        "spring": drive::spring_settings(finger.spring),
        "limit": law::limit_settings(finger.limit),
        "contact": contact,
        "initial": {
            "q11": initial.q11_rad,
            "q21": initial.q21_rad,
            "qd11": initial.qd11_rad_s,
            "qd21": initial.qd21_rad_s,
        },
    })
}

/// Adds table, differential, and the contacts with palm and table of a gripper.
fn add_gripper(file: &mut Json, hand: &Hand) {
    file["differential"] = match &hand.differential {
        None => json!({ "present": false }),
        Some(Differential { motor, seesaw_inertia_kg_m2 }) => {
            file["motor"] = drive::motor_settings(motor, 0.0);
            json!({
                "present": true,
                "input_inertia": motor.inertia_kg_m2,
                "seesaw_inertia": seesaw_inertia_kg_m2,
            })
        }
    };
    file["table"] = json!({ "present": hand.table.is_some(), "level": hand.table.map(|table| table.level_m) });
    // Fingers that differ would inherit the keys of a common friction law.
    let first = hand.fingers[0].contact.proximal;
    let has_common = file.get("contact").is_some();
    let common = if has_common { first } else { ContactLaw { friction: None, ..first } };
    if !has_common {
        file["contact"] = law::contact_settings(&common);
    }
    for (key, plane) in [("palm", hand.palm), ("table", hand.table)] {
        if let Some(law) = plane.and_then(|plane| plane.contact).filter(|law| *law != common) {
            file["contact"][key] = law::contact_settings(&law);
        }
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
    let is_set = |value: &&Value| value.as_array().is_none_or(|items| !items.is_empty());
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

/// Returns the source of the scene with all defaults added, and with derived values as comments. If the scene has been
/// changed since its source was read, it is written as it is now, with all values.
pub fn show_written(scene: &Scene) -> String {
    let Ok(document) = DeTable::parse(&scene.source) else { return show(scene) };
    let (schema, resolved) = (top_level(scene.kind), resolved(scene));
    let written = texts(document.get_ref(), &scene.source);
    let parameters = Parameters::read(document.get_ref()).0;
    let mut complete = written.clone();
    complete.entry("name").or_insert_with(|| toml::Value::String(scene.name.clone()).to_string().into());
    add_defaults(&mut complete, schema, Some(&resolved));
    loop {
        let mut text = HEAD.to_string();
        write_texts(&mut text, schema, &complete, "");
        match parse_any(&text, "scene.toml") {
            Ok(found) if found == (Scene { source: found.source.clone(), ..scene.clone() }) => {
                // All values of a mechanism are given.
                let derived = if scene.kind == SceneKind::Mechanism {
                    String::new()
                } else {
                    derived_values(schema, &resolved, &complete)
                };
                annotate(&mut complete, &parameters);
                let mut text = HEAD.to_string();
                write_texts(&mut text, schema, &complete, "");
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

/// Adds the values of expressions as comments behind them.
fn annotate(texts: &mut Table, parameters: &Parameters) {
    for (_, value) in texts {
        match value {
            Value::Table(inner) => annotate(inner, parameters),
            Value::Array(items) => {
                items.iter_mut().filter_map(Value::as_table_mut).for_each(|inner| annotate(inner, parameters));
            }
            Value::String(text) => {
                let values = DeValue::parse(text).ok().and_then(|value| evaluated(&value, parameters));
                values.into_iter().for_each(|values| *text += &format!("  # {values}"));
            }
            _ => {}
        }
    }
}

/// A value with the results of its expressions; `None` without expressions.
fn evaluated(value: &Spanned<DeValue<'_>>, parameters: &Parameters) -> Option<String> {
    match value.get_ref() {
        DeValue::String(text) if is_expression(text) => {
            let found = parameters.value(text)?;
            let rounded = || Measured { si: round(found.si, Some(DIGITS)), ..found }.to_string();
            Some(found.dimension().map_or_else(rounded, |dimension| quantity(found.si, dimension, Some(DIGITS))))
        }
        DeValue::Array(items) => {
            let values: Vec<Option<String>> = items.iter().map(|item| evaluated(item, parameters)).collect();
            values.iter().any(Option::is_some).then_some(())?;
            let text =
                |(item, value): (&Spanned<DeValue<'_>>, Option<String>)| value.unwrap_or_else(|| plain(item.get_ref()));
            Some(format!("[{}]", items.iter().zip(values).map(text).collect::<Vec<_>>().join(", ")))
        }
        _ => None,
    }
}

/// A value without quotes, on one line.
fn plain(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => text.escape_debug().to_string(),
        DeValue::Array(items) => {
            format!("[{}]", items.iter().map(|item| plain(item.get_ref())).collect::<Vec<_>>().join(", "))
        }
        DeValue::Integer(number) => number.as_str().to_string(),
        DeValue::Float(number) => number.as_str().to_string(),
        _ => "..".to_string(),
    }
}

/// Adds the defaults of the schema that the resolved scene has; `resolved` is the same table of it.
fn add_defaults(complete: &mut Table, schema: &Section, resolved: Option<&Table>) {
    for key in schema.keys() {
        let Some(si) = &key.default else { continue };
        let is_element = |known: &str| split_entries(known).is_some_and(|(list, _)| list == key.name);
        // A written entry replaces that of the default.
        let has_entry = complete.keys().any(|known| is_element(known));
        let actual = resolved.and_then(|resolved| resolved.get(key.field));
        if !complete.contains_key(key.name) && (has_entry || actual.is_none_or(|actual| actual == si)) {
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
            // A parameter is no section.
            if complete.get(&name).is_some_and(Value::is_str) {
                continue;
            }
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
