//! The settings: their page in the documentation, their defaults, and their records in a log.

use std::fs;
use std::path::Path;

use phalanx::scene::keywords::SceneKind;
use phalanx::scene::schema::{markdown, record, restore, top_level};
use phalanx::scene::section::{Key, Section};
use phalanx::scene::{Bounds, Engine, Keyword, Response, Stepping};

const BEGIN: &str = "<!-- settings: PHALANX_BLESS=1 cargo test --test scene settings -->\n";
const END: &str = "<!-- end of settings -->\n";

/// The tables of the documentation match the program.
#[test]
fn the_documented_settings_are_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/docs/scene_files.md");
    let page = fs::read_to_string(&path).expect("the page");
    let (head, rest) = page.split_once(BEGIN).expect("the first marker");
    let (_, tail) = rest.split_once(END).expect("the second marker");
    let generated = format!("{head}{BEGIN}\n{}\n{END}{tail}", markdown());
    if std::env::var_os("PHALANX_BLESS").is_some() {
        fs::write(&path, generated).expect("the page");
        return;
    }
    assert!(
        page == generated,
        "the settings have changed; PHALANX_BLESS=1 cargo test --test scene settings rewrites the page"
    );
}

/// Calls `check` for every key with a default.
fn for_each_default(section: &Section, path: &str, check: &mut impl FnMut(&str, &Key)) {
    for key in section.keys().iter().filter(|key| key.schema.get("default").is_some()) {
        check(&format!("{path}.{}", key.name), key);
    }
    let named = section.named().map(|each| ("NAME", each));
    for (name, section) in section.subsections().iter().map(|(name, section)| (*name, section)).chain(named) {
        for_each_default(section, &format!("{path}.{name}"), check);
    }
}

/// Every default of the schema is an allowed value, and those of the tolerances are the ones of the program.
#[test]
fn defaults_are_valid() {
    for kind in SceneKind::ALL {
        let mut count = 0;
        for_each_default(top_level(kind), kind.keyword(), &mut |path, key| {
            count += 1;
            let si = key.default.as_ref().unwrap_or_else(|| panic!("{path}: {}", key.schema["default"]));
            assert!(key.allows(si), "{path}: {si}");
        });
        assert!(count > 20, "{count}");
        let bounds = toml::Table::try_from(Bounds::defaults_for_run(kind, 1.0)).expect("a table");
        for key in top_level(kind).subsection("validate").expect("bounds").keys() {
            let value = &bounds[key.field];
            assert!(key.default.as_ref().is_none_or(|si| si == value), "{kind:?} {}: {value:?}", key.name);
        }
    }
}

/// The record of settings in a log contains only those with an effect, and restores them bit for bit.
#[test]
fn recorded_settings_are_restored() {
    let fixed = Engine { stepping: Stepping::Fixed { step_s: 1e-5 / 3.0 }, iterations: 7, ..Engine::DEFAULT };
    let rapier = Engine { response: Response::Rapier { friction: 0.1 + 0.2, restitution: 0.5 }, ..fixed };
    for (engine, has, lacks) in [
        (Engine::DEFAULT, "engine_tolerance_m", "engine_step_s"),
        (fixed, "engine_step_s", "engine_max_step_s"),
        (rapier, "engine_restitution", "engine_tolerance_m"),
    ] {
        let recorded = record(&engine);
        let entry = |name: &str| recorded.iter().find(|(known, _)| known == name).map(|(_, text)| text.clone());
        assert!(entry(has).is_some() && entry(lacks).is_none(), "{recorded:?}");
        let restored =
            restore(|name| entry(name).ok_or(name.to_string()), |name, value, allowed| name + &value + &allowed);
        assert_eq!(restored, Ok(engine));
        let negative = restore::<Engine, _>(
            |name| Ok(if name == "engine_max_steps" { "0".to_string() } else { entry(name).expect("recorded") }),
            |name, value, allowed| format!("{name} = {value}: {allowed}"),
        );
        assert_eq!(negative, Err("engine_max_steps = 0: a whole number from 1".to_string()));
    }
}
