//! The table of settings: its page in the documentation, its defaults, and setting single fields.

use std::fs;
use std::path::Path;

use phalanx::gripper::Design;
use phalanx::scene::keywords::SceneKind;
use phalanx::scene::schema::schema_for;
use phalanx::scene::table::bounds::Bounds;
use phalanx::scene::table::drive::{MotorSettings, ShaftSettings, SpringSettings};
use phalanx::scene::table::finger::{InitialSettings, MaterialSettings};
use phalanx::scene::table::law::{ContactSettings, LimitSettings};
use phalanx::scene::table::object::ObjectSettings;
use phalanx::scene::table::{self, SettingsSection};
use phalanx::scene::{Engine, Integrator, LogRates};

const BEGIN: &str = "<!-- settings: PHALANX_BLESS=1 cargo test --test scene settings -->\n";
const END: &str = "<!-- end of settings -->\n";

/// The tables of the documentation match the program.
#[test]
fn the_documented_settings_are_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/docs/scene_files.md");
    let page = fs::read_to_string(&path).expect("the page");
    let (head, rest) = page.split_once(BEGIN).expect("the first marker");
    let (_, tail) = rest.split_once(END).expect("the second marker");
    let generated = format!("{head}{BEGIN}\n{}\n{END}{tail}", table::markdown());
    if std::env::var_os("PHALANX_BLESS").is_some() {
        fs::write(&path, generated).expect("the page");
        return;
    }
    assert!(
        page == generated,
        "the settings have changed; PHALANX_BLESS=1 cargo test --test scene settings rewrites the page"
    );
}

/// A documented default is the value of an empty section.
#[test]
fn setting_a_documented_default_changes_nothing() {
    fn check<T: SettingsSection>(path: &str) {
        for kind in SceneKind::ALL {
            let schema = &schema_for(kind)["properties"][path]["properties"];
            for field in T::FIELDS.iter().filter(|field| field.metadata().scene_kinds.contains(&kind)) {
                let (key, defaults) = (field.metadata().key, T::defaults_for(kind));
                // Lists can be set only in files.
                let Some(default) = schema[key].get("default").filter(|default| !default.is_array()) else { continue };
                let text = default.as_str().map_or_else(|| default.to_string(), str::to_string);
                let mut modified = defaults.clone();
                assert_eq!(table::set(&mut modified, path, key, &text), Ok(true), "{path}.{key}");
                if field.get(&mut defaults.clone()).is_some() {
                    assert_eq!(field.get(&mut modified), field.get(&mut defaults.clone()), "{path}.{key}");
                }
            }
        }
    }
    check::<Integrator>("integrator");
    check::<Engine>("engine");
    check::<Bounds>("validate");
    check::<LogRates>("log");
    check::<ContactSettings>("contact");
    check::<LimitSettings>("limit");
    check::<Design>("design");
    check::<ObjectSettings>("object");
    check::<MaterialSettings>("material");
    check::<InitialSettings>("initial");
    check::<MotorSettings>("motor");
    check::<ShaftSettings>("motor");
    check::<SpringSettings>("spring");
}

/// A value that applies only to one variant of a setting selects this variant.
#[test]
fn setting_a_field_selects_its_variant() {
    let mut engine = Engine::defaults();
    for (key, text, column) in [("step", "10 us", "engine_step_s"), ("tolerance", "1 um", "engine_tolerance_m")] {
        assert_eq!(table::set(&mut engine, "engine", key, text), Ok(true));
        let recorded = table::record("engine", &engine);
        assert!(recorded.iter().any(|(name, _)| name == column), "{recorded:?}");
    }
    assert_eq!(table::set(&mut engine, "engine", "step", "0 us"), Ok(false));
    for (key, text, expected) in [("step", "1", "has no unit"), ("pace", "1", "has no `pace`")] {
        let error = table::set(&mut engine, "engine", key, text).expect_err("a bad value");
        assert!(error.contains(expected), "{error}");
    }
}
