//! The files that a study is made of: whoever runs it elsewhere takes all of them along.

use std::path::{Path, PathBuf};

use toml::de::DeTable;

use super::error::StudyError;
use super::read::load;
use crate::scene::file::{layers, read};

/// The study's own file, and those of its base scene: what that extends first, itself last. The study is one that can be read.
///
/// # Errors
/// As [`load`](super::load).
pub fn files(path: &Path) -> Result<Vec<PathBuf>, StudyError> {
    load(path)?;
    Ok(sources(path))
}

/// The same of a study or a search that has been read; only its own file where that is a pipe.
pub fn sources(path: &Path) -> Vec<PathBuf> {
    let text = if path.is_file() { read(path).map_or_else(|_| String::new(), |(text, _)| text) } else { String::new() };
    let document = DeTable::parse(&text).ok();
    let base = document.as_ref().and_then(|document| document.get_ref().get("scene")?.get_ref().as_str());
    let base = base.map(|base| path.parent().unwrap_or(Path::new("")).join(base));
    let layers = base.and_then(|base| layers(&base).ok()).unwrap_or_default();
    std::iter::once(path.to_path_buf()).chain(layers.into_iter().map(|layer| PathBuf::from(layer.file))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_study_needs_its_scene_and_what_that_extends() {
        let directory = tempfile::tempdir().expect("a directory");
        let at = |name: &str| directory.path().join(name);
        std::fs::copy("scenes/experiment-95.toml", at("base.toml")).expect("copied");
        std::fs::write(at("own.toml"), "extends = \"base.toml\"\nduration = \"5 ms\"\n").expect("written");
        let axis = "[[axes]]\nfield = \"contact.friction.mu_static\"\nvalues = [0.1, 0.2]\n";
        std::fs::write(at("study.toml"), format!("scene = \"own.toml\"\n{axis}")).expect("written");
        let found = files(&at("study.toml")).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(found, ["study.toml", "base.toml", "own.toml"].map(at));
        assert!(files(&at("no.toml")).is_err());
    }
}
