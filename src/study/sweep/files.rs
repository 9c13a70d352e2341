//! Files of a study. All of them are required to run it on another machine.

use std::path::{Path, PathBuf};

use toml::de::DeTable;

use super::error::StudyError;
use super::read::load;
use crate::scene::file::{load_layers, read};

/// Files of a valid study: its own, then those that its base scene extends, then the base scene.
///
/// # Errors
/// See [`load`](super::load).
pub fn files(path: &Path) -> Result<Vec<PathBuf>, StudyError> {
    load(path)?;
    Ok(source_files(path))
}

/// Files of a study that has been read; only its own file if that is a pipe.
pub fn source_files(path: &Path) -> Vec<PathBuf> {
    let text = if path.is_file() { read(path).map_or_else(|_| String::new(), |(text, _)| text) } else { String::new() };
    let document = DeTable::parse(&text).ok();
    let base = document.as_ref().and_then(|document| document.get_ref().get("scene")?.get_ref().as_str());
    let base = base.map(|base| path.parent().unwrap_or(Path::new("")).join(base));
    let layers = base.and_then(|base| load_layers(&base).ok()).unwrap_or_default();
    std::iter::once(path.to_path_buf()).chain(layers.into_iter().map(|layer| PathBuf::from(layer.file))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_the_base_scene_and_the_scenes_it_extends() {
        let directory = tempfile::tempdir().expect("a directory");
        let in_directory = |name: &str| directory.path().join(name);
        std::fs::copy("scenes/experiment-95.toml", in_directory("base.toml")).expect("copied");
        std::fs::write(in_directory("own.toml"), "extends = \"base.toml\"\nduration = \"5 ms\"\n").expect("written");
        let axis = "[[axes]]\nfield = \"contact.friction.mu_static\"\nvalues = [0.1, 0.2]\n";
        std::fs::write(in_directory("study.toml"), format!("scene = \"own.toml\"\n{axis}")).expect("written");
        let paths = files(&in_directory("study.toml")).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(paths, ["study.toml", "base.toml", "own.toml"].map(in_directory));
        assert!(files(&in_directory("no.toml")).is_err());
    }
}
