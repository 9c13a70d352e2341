//! Single fields of a scene that are set besides its text: `FIELD=VALUE` as a line of a scene file.

use super::Layer;
use super::keys::element;

const EXAMPLE: &str = "write FIELD=VALUE, such as contact.friction.mu_static=0.6";

/// `FIELD=VALUE` as a line of a scene; `origin` is what messages call it. What is no TOML value, such as `12 mm` or `torsional`,
/// is a text without its quotes.
///
/// # Errors
/// What is no field, or has no value.
pub fn setting(origin: &str, text: &str) -> Result<Layer, String> {
    let (field, value) = text.split_once('=').ok_or(format!("there is no `=`: {EXAMPLE}"))?;
    setting_of(origin, field, value)
}

/// The same of a field and its value.
///
/// # Errors
/// As [`setting`].
pub fn setting_of(origin: &str, field: &str, value: &str) -> Result<Layer, String> {
    let (mut field, value) = (field.trim().to_string(), value.trim());
    if field.is_empty() || value.is_empty() {
        return Err(format!("there is no {}: {EXAMPLE}", if field.is_empty() { "field" } else { "value" }));
    }
    // One element of a pair: the key of a scene is quoted then.
    if element(&field).is_some() {
        field.insert(field.rfind('.').map_or(0, |point| point + 1), '"');
        field.push('"');
    }
    if format!("{field} = 0").parse::<toml::Table>().is_err() || field.contains('\n') {
        return Err(format!(
            "`{field}` is no field: name it by its sections and its key with points between: {EXAMPLE}"
        ));
    }
    let plain = format!("value = {value}");
    let value = match plain.parse::<toml::Table>() {
        Ok(found) if found.len() == 1 && !value.contains('\n') => value.to_string(),
        _ => toml::Value::from(value).to_string(),
    };
    Ok(Layer { file: origin.to_string(), text: format!("{field} = {value}") })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_as_in_a_file_or_are_texts() {
        for (given, text) in [
            ("contact.friction.mu_static=0.6", "contact.friction.mu_static = 0.6"),
            (" design.base = 12 mm ", "design.base = \"12 mm\""),
            ("design.base=\"12 mm\"", "design.base = \"12 mm\""),
            ("spring.type=torsional", "spring.type = \"torsional\""),
            ("palm=false", "palm = false"),
            ("gravity=[\"0 m/s^2\", \"0 m/s^2\"]", "gravity = [\"0 m/s^2\", \"0 m/s^2\"]"),
            ("gravity[1]=1 g", "\"gravity[1]\" = \"1 g\""),
            ("object.centre[0]=\"1 mm\"", "object.\"centre[0]\" = \"1 mm\""),
            ("name=a = b", "name = \"a = b\""),
            ("discs.\"a b\".radius=\"1 mm\"", "discs.\"a b\".radius = \"1 mm\""),
            ("name=1\n[motor]", "name = \"\"\"\n1\n[motor]\"\"\""),
        ] {
            let found = setting("--set", given).unwrap_or_else(|error| panic!("{given}: {error}"));
            let (found, text): (toml::Table, toml::Table) =
                (found.text.parse().expect("TOML"), text.replace("\n1", "1").parse().expect("TOML"));
            assert_eq!(found, text, "{given}");
        }
        for wrong in ["mu_static", "=1", "a=", "a b=1", "a..b=1", "[a]=1"] {
            assert!(setting("--set", wrong).is_err(), "{wrong}");
        }
        assert!(setting_of("set", "a=b", "1").is_err());
    }
}
