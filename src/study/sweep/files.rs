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
    let (text, _) = read(path).map_err(StudyError::Invalid)?;
    let document = DeTable::parse(&text).ok();
    let base = document.as_ref().and_then(|document| document.get_ref().get("scene")?.get_ref().as_str());
    let mut files = vec![path.to_path_buf()];
    if let Some(base) = base {
        let base = path.parent().unwrap_or(Path::new("")).join(base);
        files.extend(layers(&base).map_err(StudyError::Invalid)?.into_iter().map(|layer| PathBuf::from(layer.file)));
    }
    Ok(files)
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
