//! Single settings that override the text of a scene: `FIELD=VALUE` as a line of a scene file.

use super::Layer;
use super::keys::pair_element;

const EXAMPLE: &str = "write FIELD=VALUE, such as contact.friction.mu_static=0.6";

/// Parses `FIELD=VALUE` into a line of a scene; `origin` is its name in messages. A value that is not TOML, such as `12
/// mm` or `torsional`, is taken as a string without quotes.
///
/// # Errors
/// Returns a message if the field is invalid or the value is missing.
pub fn parse_setting(origin: &str, text: &str) -> Result<Layer, String> {
    let (field, value) = text.split_once('=').ok_or(format!("there is no `=`: {EXAMPLE}"))?;
    setting_from_parts(origin, field, value)
}

/// Like [`parse_setting`], but field and value are separate arguments.
///
/// # Errors
/// See [`parse_setting`].
pub fn setting_from_parts(origin: &str, field: &str, value: &str) -> Result<Layer, String> {
    let (mut field, value) = (field.trim().to_string(), value.trim());
    if field.is_empty() || value.is_empty() {
        return Err(format!("there is no {}: {EXAMPLE}", if field.is_empty() { "field" } else { "value" }));
    }
    // The key of one element of a pair must be quoted.
    if pair_element(&field).is_some() {
        field.insert(field.rfind('.').map_or(0, |point| point + 1), '"');
        field.push('"');
    }
    if format!("{field} = 0").parse::<toml::Table>().is_err() || field.contains('\n') {
        return Err(format!(
            "`{field}` is not a field: write its sections and its key, separated by points: {EXAMPLE}"
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
    fn accepts_toml_values_and_unquoted_texts() {
        for (input, text) in [
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
            let found = parse_setting("--set", input).unwrap_or_else(|error| panic!("{input}: {error}"));
            let (found, text): (toml::Table, toml::Table) =
                (found.text.parse().expect("TOML"), text.replace("\n1", "1").parse().expect("TOML"));
            assert_eq!(found, text, "{input}");
        }
        for wrong in ["mu_static", "=1", "a=", "a b=1", "a..b=1", "[a]=1"] {
            assert!(parse_setting("--set", wrong).is_err(), "{wrong}");
        }
        assert!(setting_from_parts("set", "a=b", "1").is_err());
    }
}
