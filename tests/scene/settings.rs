//! The table of settings: its page in the documentation, and what it says of defaults.

use std::fs;
use std::path::Path;

use phalanx::gripper::Design;
use phalanx::scene::schema::schema_of;
use phalanx::scene::table::bounds::Bounds;
use phalanx::scene::table::drive::{Motor, Shaft, Springs};
use phalanx::scene::table::finger::{Material, Start};
use phalanx::scene::table::law::{Contact, Limit};
use phalanx::scene::table::object::Object;
use phalanx::scene::table::{self, Table};
use phalanx::scene::words::SceneKind;
use phalanx::scene::{Engine, Integrator, LogRates};

const BEGIN: &str = "<!-- settings: PHALANX_BLESS=1 cargo test --test scene settings -->\n";
const END: &str = "<!-- end of settings -->\n";

/// The tables of the documentation are those of the program.
#[test]
fn the_page_has_the_table_of_settings() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/docs/scene_files.md");
    let page = fs::read_to_string(&path).expect("the page");
    let (head, rest) = page.split_once(BEGIN).expect("where the settings begin");
    let (_, tail) = rest.split_once(END).expect("where they end");
    let made = format!("{head}{BEGIN}\n{}\n{END}{tail}", table::markdown());
    if std::env::var_os("PHALANX_BLESS").is_some() {
        fs::write(&path, made).expect("the page");
        return;
    }
    assert!(
        page == made,
        "the settings have changed: PHALANX_BLESS=1 cargo test --test scene settings writes the page"
    );
}

/// A default, however it is said, is what the section has without it.
#[test]
fn defaults_are_what_a_scene_has_that_says_nothing() {
    fn check<T: Table>(path: &str) {
        for kind in SceneKind::ALL {
            let schema = &schema_of(kind)["properties"][path]["properties"];
            for line in T::LINES.iter().filter(|line| line.about().of.contains(&kind)) {
                let (key, usual) = (line.about().key, T::usual_in(kind));
                // Lists are set in files only.
                let Some(default) = schema[key].get("default").filter(|default| !default.is_array()) else { continue };
                let text = default.as_str().map_or_else(|| default.to_string(), str::to_string);
                let mut with = usual.clone();
                assert_eq!(table::set(&mut with, path, key, &text), Ok(true), "{path}.{key}");
                if line.get(&mut usual.clone()).is_some() {
                    assert_eq!(line.get(&mut with), line.get(&mut usual.clone()), "{path}.{key}");
                }
            }
        }
    }
    check::<Integrator>("integrator");
    check::<Engine>("engine");
    check::<Bounds>("validate");
    check::<LogRates>("log");
    check::<Contact>("contact");
    check::<Limit>("limit");
    check::<Design>("design");
    check::<Object>("object");
    check::<Material>("material");
    check::<Start>("initial");
    check::<Motor>("motor");
    check::<Shaft>("motor");
    check::<Springs>("spring");
}

/// A value that has a meaning beside a choice only brings the choice with it.
#[test]
fn a_field_that_is_set_brings_its_choice() {
    let mut engine = Engine::usual();
    for (key, text, column) in [("step", "10 us", "engine_step_s"), ("tolerance", "1 um", "engine_tolerance_m")] {
        assert_eq!(table::set(&mut engine, "engine", key, text), Ok(true));
        let recorded = table::record("engine", &engine);
        assert!(recorded.iter().any(|(name, _)| name == column), "{recorded:?}");
    }
    assert_eq!(table::set(&mut engine, "engine", "step", "0 us"), Ok(false));
    for (key, text, said) in [("step", "1", "has no unit"), ("pace", "1", "has no `pace`")] {
        let error = table::set(&mut engine, "engine", key, text).expect_err("a bad value");
        assert!(error.contains(said), "{error}");
    }
}
