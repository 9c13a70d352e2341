//! `--set FIELD=VALUE`: single fields of a scene, given on the command line and read as in a file.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::scene::{self, AnyScene, Layer, Scene, SceneError, Template};

/// Fields of the scene, set besides.
#[derive(Clone, Debug, Default, Args)]
pub struct SetArgs {
    /// Set a field of the scene, such as contact.friction.mu_static=0.6 or design.base="12 mm", in place of what its file says;
    /// may be given several times
    #[arg(long = "set", value_name = "FIELD=VALUE", value_parser = line)]
    set: Vec<Layer>,
}

impl SetArgs {
    /// The scene in a file, of either kind, with these fields.
    pub fn load_any(&self, path: &Path) -> Result<AnyScene, SceneError> {
        scene::load_any_with(path, &self.set)
    }

    /// The scene of a finger in a file, with these fields.
    pub fn load(&self, path: &Path) -> Result<Scene, SceneError> {
        scene::load_with(path, &self.set)
    }

    /// A shipped scene, given as text, with these fields.
    pub fn parse_any(&self, text: &str, file: &str) -> Result<AnyScene, SceneError> {
        let own = Layer { file: file.to_string(), text: text.to_string() };
        scene::parse_layers(&[own], &self.set, scene::parse_any)
    }

    /// These fields, and then others: lines of a scene.
    pub fn and(&self, more: &[String]) -> Self {
        let more = more.iter().map(|text| Layer { file: "the study".to_string(), text: text.clone() });
        SetArgs { set: self.set.iter().cloned().chain(more).collect() }
    }

    pub fn is_empty(&self) -> bool {
        self.set.is_empty()
    }

    /// What the designs of a study have in common, with these fields.
    pub fn load_template(&self, path: &Path) -> Result<Template, SceneError> {
        scene::load_template_with(path, &self.set)
    }
}

/// The files that a scene is made of; only itself where they cannot be told.
pub fn files(scene: &Path) -> Vec<PathBuf> {
    let layers = scene::layers(scene).unwrap_or_default();
    let files: Vec<PathBuf> = layers.into_iter().map(|layer| layer.file.into()).collect();
    if files.is_empty() { vec![scene.to_path_buf()] } else { files }
}

/// One field as a line of a scene. What is no TOML value, such as 12 mm or torsional, is a text without its quotes.
fn line(text: &str) -> Result<Layer, String> {
    let example = "write FIELD=VALUE, such as contact.friction.mu_static=0.6";
    let (field, value) = text.split_once('=').ok_or(format!("there is no `=`: {example}"))?;
    let (field, value) = (field.trim(), value.trim());
    if field.is_empty() || value.is_empty() {
        return Err(format!("there is no {}: {example}", if field.is_empty() { "field" } else { "value" }));
    }
    if format!("{field} = 0").parse::<toml::Table>().is_err() || field.contains('\n') {
        return Err(format!(
            "`{field}` is no field: name it by its sections and its key with points between: {example}"
        ));
    }
    let plain = format!("value = {value}");
    let value = match plain.parse::<toml::Table>() {
        Ok(found) if found.len() == 1 && !value.contains('\n') => value.to_string(),
        _ => toml::Value::from(value).to_string(),
    };
    Ok(Layer { file: "--set".to_string(), text: format!("{field} = {value}") })
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
            ("name=a = b", "name = \"a = b\""),
            ("discs.\"a b\".radius=\"1 mm\"", "discs.\"a b\".radius = \"1 mm\""),
            ("name=1\n[motor]", "name = \"\"\"\n1\n[motor]\"\"\""),
        ] {
            let found = line(given).unwrap_or_else(|error| panic!("{given}: {error}"));
            let (found, text): (toml::Table, toml::Table) =
                (found.text.parse().expect("TOML"), text.replace("\n1", "1").parse().expect("TOML"));
            assert_eq!(found, text, "{given}");
        }
        for wrong in ["mu_static", "=1", "a=", "a b=1", "a..b=1", "[a]=1"] {
            assert!(line(wrong).is_err(), "{wrong}");
        }
    }
}
