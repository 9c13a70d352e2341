//! Versions, licences and the contents of packages agree with the manifests.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn manifest(path: &str) -> toml::Table {
    read(path).parse().unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Returns a value of `[workspace.package]`.
fn workspace_value(key: &str) -> String {
    let table = manifest("Cargo.toml");
    table["workspace"]["package"][key].as_str().unwrap_or_else(|| panic!("no {key}")).to_string()
}

/// Manifests of the workspace except that of the root.
fn member_manifests() -> Vec<String> {
    let table = manifest("Cargo.toml");
    let members = table["workspace"]["members"].as_array().expect("a list");
    members.iter().map(|member| format!("{}/Cargo.toml", member.as_str().expect("a path"))).collect()
}

/// Packages and resolved dependencies of a lock file, for all platforms.
fn metadata(manifest: &str) -> Value {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["metadata", "--locked", "--format-version", "1", "--manifest-path"]).arg(root().join(manifest));
    let output = cargo.output().expect("cargo runs");
    assert!(output.status.success(), "{manifest}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

/// `1.89` is `(1, 89, 0)`.
fn parse_version(text: &str) -> (u32, u32, u32) {
    let mut numbers = text.split('.').map(|number| number.parse().unwrap_or_else(|_| panic!("version {text}")));
    let mut next = || numbers.next().unwrap_or(0);
    (next(), next(), next())
}

#[test]
fn one_minimum_rust_version_is_named_everywhere() {
    let version = workspace_value("rust-version");
    for path in member_manifests().into_iter().chain(["Cargo.toml".to_string()]) {
        let inherits = manifest(&path)["package"]["rust-version"]["workspace"].as_bool();
        assert_eq!(inherits, Some(true), "{path}");
    }
    for (path, sentence) in [
        ("crates/explorer/Cargo.toml", format!("rust-version = \"{version}\"")),
        ("README.md", format!("a Rust toolchain ({version} or later)")),
        ("book/pages/first-closing.md", format!("{version} or later")),
        (".github/workflows/ci.yml", format!("rustup toolchain install {version} ")),
    ] {
        assert!(read(path).contains(&sentence), "{path} does not contain `{sentence}`");
    }
}

#[test]
fn no_dependency_needs_a_later_rust_version() {
    let stated = workspace_value("rust-version");
    for manifest in ["Cargo.toml", "crates/explorer/Cargo.toml"] {
        for package in list(&metadata(manifest)["packages"]) {
            let Some(needed) = package["rust_version"].as_str() else { continue };
            assert!(
                parse_version(needed) <= parse_version(&stated),
                "{} {} needs Rust {needed}, but Cargo.toml states {stated}",
                package["name"],
                package["version"]
            );
        }
    }
}

#[test]
fn one_version_of_phalanx_is_named_everywhere() {
    let version = workspace_value("version");
    let separate = ["crates/explorer/Cargo.toml", "benches/solvers/Cargo.toml"];
    for path in separate {
        assert_eq!(manifest(path)["package"]["version"].as_str(), Some(&version[..]), "{path}");
    }
    for path in member_manifests().into_iter().chain(["Cargo.toml".to_string()]) {
        let table = manifest(&path);
        assert_eq!(table["package"]["version"]["workspace"].as_bool(), Some(true), "{path}");
        let Some(dependencies) = table.get("dependencies").and_then(toml::Value::as_table) else { continue };
        let is_published = table["package"].get("publish").is_none();
        for (name, dependency) in dependencies.iter().filter(|(name, _)| name.starts_with("phalanx") && is_published) {
            assert_eq!(dependency["version"].as_str(), Some(&version[..]), "{path}: {name}");
        }
    }
    for path in ["Cargo.lock", "benches/solvers/Cargo.lock", "crates/explorer/Cargo.lock", "tests/fuzz/Cargo.lock"] {
        for package in manifest(path)["package"].as_array().expect("packages") {
            let name = package["name"].as_str().expect("a name");
            if name.starts_with("phalanx") && name != "phalanx-fuzz" {
                assert_eq!(package["version"].as_str(), Some(&version[..]), "{path}: {name}");
            }
        }
    }
    let python = manifest("python/pyproject.toml");
    let dynamic = python["project"]["dynamic"].as_array().expect("a list");
    assert!(dynamic.iter().any(|key| key.as_str() == Some("version")), "the wheel has the version of its crate");
    assert!(read("CITATION.cff").contains(&format!("\nversion: {version}\n")), "CITATION.cff");
    let heading = read("CHANGELOG.md").lines().find(|line| line.starts_with("## ")).map(str::to_string);
    assert!(heading.is_some_and(|heading| heading.starts_with(&format!("## {version}"))), "CHANGELOG.md");
}

/// Names and versions of the packages of registries that are linked into programs on every platform.
fn linked_packages(manifest: &str, programs: &[&str]) -> BTreeSet<(String, String)> {
    let data = metadata(manifest);
    let package = |id: &Value| list(&data["packages"]).iter().find(|package| package["id"] == *id).expect("a package");
    let is_macro = |package: &Value| list(&package["targets"]).iter().any(|target| target["kind"][0] == "proc-macro");
    // Neither of one platform, nor of build scripts and tests.
    let is_linked = |kind: &Value| kind["kind"].is_null() && kind["target"].is_null();
    let is_program = |package: &&Value| programs.iter().any(|name| package["name"] == *name);
    let mut pending: Vec<&Value> =
        list(&data["packages"]).iter().filter(is_program).map(|found| &found["id"]).collect();
    let (mut seen, mut linked) = (BTreeSet::new(), BTreeSet::new());
    while let Some(id) = pending.pop() {
        let found = package(id);
        if is_macro(found) || !seen.insert(id.to_string()) {
            continue;
        }
        if !found["source"].is_null() {
            let text = |key: &str| found[key].as_str().expect("a text").to_string();
            linked.insert((text("name"), text("version")));
        }
        let node = list(&data["resolve"]["nodes"]).iter().find(|node| node["id"] == *id).expect("a node");
        let linked_dependencies =
            list(&node["deps"]).iter().filter(|dep| list(&dep["dep_kinds"]).iter().any(is_linked));
        pending.extend(linked_dependencies.map(|dependency| &dependency["pkg"]));
    }
    linked
}

/// `tools/third_party.py` writes the list.
#[test]
fn third_party_packages_are_listed_with_their_versions() {
    let text = read("THIRD-PARTY.txt");
    let (packages, _) = text.split_once("\n=====").expect("texts after the list");
    let listed: BTreeSet<(String, String)> = packages
        .lines()
        .filter(|line| line.contains("; text "))
        .filter_map(|line| {
            let mut words = line.split_whitespace().map(str::to_string);
            Some((words.next()?, words.next()?))
        })
        .collect();
    let mut linked = linked_packages("Cargo.toml", &["phalanx", "phalanx-python"]);
    linked.extend(linked_packages("crates/explorer/Cargo.toml", &["phalanx-explorer"]));
    assert!(linked.len() > 80, "only {} packages", linked.len());
    for (name, version) in &linked {
        let is_listed = listed.contains(&(name.clone(), version.clone()));
        assert!(is_listed, "THIRD-PARTY.txt does not list {name} {version}; run tools/third_party.py");
    }
    let locks = ["Cargo.lock", "crates/explorer/Cargo.lock"].map(manifest);
    for (name, version) in &listed {
        let is_same = |package: &toml::Value| {
            package["name"].as_str() == Some(name) && package["version"].as_str() == Some(version)
        };
        let is_locked = locks.iter().flat_map(|lock| lock["package"].as_array().expect("packages")).any(is_same);
        assert!(is_locked, "THIRD-PARTY.txt lists {name} {version}; run tools/third_party.py");
    }
}

/// Published packages contain the licences, which are links to those of the repository.
#[test]
fn every_package_has_the_licences() {
    let directories = member_manifests().into_iter().map(|path| path.replace("Cargo.toml", ""));
    for directory in directories {
        for name in ["LICENSE-APACHE", "LICENSE-MIT"] {
            assert_eq!(read(&format!("{directory}{name}")), read(name), "{directory}{name}");
        }
    }
    let included = manifest("Cargo.toml")["package"]["include"].to_string();
    for name in ["/LICENSE-*", "/THIRD-PARTY.txt", "/explorer.wasm.gz"] {
        assert!(included.contains(name), "Cargo.toml includes no {name}");
    }
}

/// Files that the sources of a published package embed are in the package.
#[test]
fn packages_contain_the_files_that_they_embed() {
    for (directory, package) in [("", "phalanx"), ("crates/thesis", "phalanx-thesis"), ("crates/log", "phalanx-log")] {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["package", "--list", "--allow-dirty", "--locked", "--offline", "--package", package]);
        let output = cargo.current_dir(root()).output().expect("cargo runs");
        assert!(output.status.success(), "{package}: {}", String::from_utf8_lossy(&output.stderr));
        let listed = String::from_utf8(output.stdout).expect("UTF-8").replace('\\', "/");
        let listed: BTreeSet<&str> = listed.lines().collect();
        for source in listed.iter().filter(|path| path.ends_with(".rs") && path.starts_with("src")) {
            let path = root().join(directory).join(source);
            let text = fs::read_to_string(&path).unwrap();
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            for embedded in embedded_files(code) {
                let file = path.with_file_name(&embedded).canonicalize();
                let file = file.unwrap_or_else(|error| panic!("{}: {embedded}: {error}", path.display()));
                let base = root().join(directory).canonicalize().unwrap();
                let relative = file.strip_prefix(base).unwrap_or(Path::new("..")).display().to_string();
                assert!(listed.contains(&relative.replace('\\', "/")[..]), "{package} lacks {embedded} of {source}");
            }
        }
        for required in ["README.md", "LICENSE-MIT", "LICENSE-APACHE"] {
            assert!(listed.contains(required), "{package} lacks {required}");
        }
    }
}

/// Literal paths in `include_str!` and `include_bytes!`.
fn embedded_files(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    for start in ["include_str!(\"", "include_bytes!(\""] {
        let after = code.split(start).skip(1);
        found.extend(after.filter_map(|rest| Some(rest.split_once('"')?.0.to_string())));
    }
    found
}

#[test]
fn finds_embedded_files() {
    assert_eq!(embedded_files(r#"a(include_str!("../x.md")) include_bytes!("b")"#), ["../x.md", "b"]);
}
