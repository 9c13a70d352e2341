//! Every invalid scene in `tests/broken` is rejected with exactly the message in the text file of the same name.
//!
//! `PHALANX_BLESS=1 cargo test --test scene broken` rewrites the messages; read the diff before committing it.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use phalanx::scene::{self, SceneError};

#[test]
fn every_broken_scene_is_rejected_with_its_message() {
    let update_expected = std::env::var_os("PHALANX_BLESS").is_some();
    let entries = fs::read_dir("tests/broken").expect("tests/broken").map(|entry| entry.expect("entry").path());
    let mut files: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
    files.sort();
    assert!(files.len() >= 30, "{} broken scenes", files.len());
    let (mut differing, mut messages) = (Vec::new(), BTreeSet::new());
    for file in files {
        let error = scene::load_any(&file).map(|scene| scene.name).expect_err("is accepted");
        assert!(!error.problems().is_empty(), "{}", file.display());
        for problem in error.problems() {
            assert!(!problem.message.is_empty() && !problem.help.is_empty(), "{problem:?}");
            assert!(!problem.message.ends_with('.') && !problem.help.contains("  "), "{problem:?}");
        }
        assert!(messages.insert(error.to_string()), "{} repeats", file.display());
        let message = format!("{error}\n").replace('\\', "/");
        let expected_file = file.with_extension("txt");
        if update_expected {
            fs::write(&expected_file, message).expect("write");
        } else if fs::read_to_string(&expected_file).unwrap_or_default() != message {
            differing.push(format!("{}:\n{message}", file.display()));
        }
    }
    assert!(differing.is_empty(), "{}", differing.join("\n"));
}

#[test]
fn unreadable_files_are_rejected() {
    let message = |path: &str| scene::load(path).expect_err(path).to_string();
    assert_eq!(
        message("scenes/no-such.toml"),
        "error: cannot read scene `scenes/no-such.toml`: there is no such file; check the path"
    );
    assert_eq!(
        message("scenes"),
        "error: cannot read scene `scenes`: it is a directory; name a scene file (.toml) in it"
    );
    let path = std::env::temp_dir().join(format!("phalanx-{}-not-utf8.toml", std::process::id()));
    fs::write(&path, b"name = \"a\"\n# caf\xe9\n").expect("write");
    let error = scene::load(&path).expect_err("not UTF-8");
    let _ = fs::remove_file(&path);
    assert!(matches!(error, SceneError::NotUtf8 { line: 2, column: 6, .. }), "{error:?}");
}
