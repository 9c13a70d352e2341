//! Study files: what they say is what is run, and what is wrong with them is named with its place.

use phalanx::scene;
use phalanx::study::sweep::{Study, columns, load, parse, schema};
use phalanx::table::{Kind, Value};

/// A study of design 95 with these lines behind it.
fn study(more: &str) -> Study {
    let text = format!("scene = \"../experiment-95.toml\"\n{more}");
    parse(&text, "scenes/studies/study.toml").unwrap_or_else(|error| panic!("{error}"))
}

fn message(more: &str) -> String {
    let text = format!("scene = \"../experiment-95.toml\"\n{more}");
    parse(&text, "scenes/studies/study.toml").expect_err(more).to_string()
}

fn values(study: &Study, run: u64) -> Vec<Value> {
    study.points(run).into_iter().map(|point| point.value).collect()
}

fn numbers(study: &Study, run: u64) -> Vec<f64> {
    let number = |value| match value {
        Value::Number(number) => number,
        other => panic!("{other:?}"),
    };
    values(study, run).into_iter().map(number).collect()
}

#[test]
fn the_thesis_runs_192_designs_twice_with_the_last_axis_fastest() {
    let study = load("scenes/studies/thesis.toml").expect("ships");
    assert_eq!((study.runs(), study.designs()), (384, 192));
    let names: Vec<String> = columns(&study).into_iter().map(|column| column.name).collect();
    assert_eq!(
        names[..8],
        [
            "run",
            "design",
            "contact.friction.mu_static",
            "design.base_m",
            "design.l21_fraction",
            "design.phi22_rad",
            "design.arm_ratio",
            "l12_m"
        ]
    );
    assert_eq!(numbers(&study, 1), [0.0, 0.012, 0.0, 90f64.to_radians(), 1.0 / 3.0]);
    assert_eq!(numbers(&study, 2), [0.0, 0.012, 0.0, 90f64.to_radians(), 0.5]);
    assert_eq!(numbers(&study, 95), [0.0, 0.0155, 1.0, 120f64.to_radians(), 0.5]);
    assert_eq!(numbers(&study, 287), [0.8, 0.0155, 1.0, 120f64.to_radians(), 0.5]);
    assert_eq!(numbers(&study, 384), [0.8, 0.0225, 1.0, 120f64.to_radians(), 2.0 / 3.0]);
    assert_eq!([1, 95, 192, 193, 287, 384].map(|run| study.design(run)), [1, 95, 192, 1, 95, 192]);
}

#[test]
fn every_run_is_the_scene_its_values_say() {
    let study = study(
        "[set]\nduration = \"30 ms\"\nmotor.torque = \"500 N*mm\"\n[[axes]]\nfield = \"contact.friction.mu_static\"\nvalues = [0, \
         0.4]\n[[axes]]\nfields = [\"design.base\", \"spring.torque\"]\nrows = [[\"15 mm\", \"120 N*mm\"], [\"16 mm\", \"0.13 \
         N*m\"]]\n[[axes]]\nfield = \"palm\"\nvalues = [true, false]\n[[axes]]\nfield = \"integrator.preset\"\nvalues = \
         [\"engineering\", \"reference\"]\n[[axes]]\nfield = \"gravity\"\nvalues = [[\"0 m/s^2\", \"9.81 m/s^2\"], [\"0 \
         m/s^2\", \"0 m/s^2\"]]\n[[axes]]\nfield = \"integrator.max_steps\"\nvalues = [1000]\n",
    );
    assert_eq!((study.runs(), study.designs()), (32, 32));
    let kinds: Vec<Kind> = columns(&study)[2..9].iter().map(|column| column.kind).collect();
    use Kind::{Flag, Integer, Number, Text};
    assert_eq!(kinds, [Number, Number, Number, Flag, Text, Text, Integer]);
    let last = scene::parse(&study.scene_text(32), "last.toml").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(last.finger().contact.proximal.friction.expect("given").mu_static, 0.4);
    assert_eq!((last.duration_s, last.system.palm.is_some(), last.system.gravity_m_s2), (0.03, false, [0.0, 0.0]));
    assert_eq!((last.integrator.rtol, last.integrator.max_steps), (1e-11, 1000));
    assert_eq!(last.object().expect("given").centre_m[0], -0.016);
    assert_eq!(values(&study, 32)[1..3], [Value::Number(0.016), Value::Number(0.13)]);
    let first = scene::parse(&study.scene_text(1), "first.toml").unwrap_or_else(|error| panic!("{error}"));
    assert!(first.system.palm.is_some() && first.system.gravity_m_s2[1] == 9.81);
}

#[test]
fn ranges_are_grids_or_samples() {
    let range = "[[axes]]\nfield = \"design.base\"\nfrom = \"12 mm\"\nto = \"22.5 mm\"\n";
    let grid = study(&format!("{range}count = 4\n"));
    assert_eq!([1, 2, 3, 4].map(|run| numbers(&grid, run)[0]), [0.012, 0.0155, 0.019, 0.0225]);
    let log = study("[[axes]]\nfield = \"contact.stiffness_si\"\nfrom = 1e6\nto = 1e9\ncount = 4\nspacing = \"log\"\n");
    assert_eq!([1, 2, 3, 4].map(|run| numbers(&log, run)[0]), [1e6, 1e7, 1e8, 1e9]);

    // Grid and sample together: every value of the grid gets all points.
    let mixed = format!(
        "[[axes]]\nfield = \"design.arm_ratio\"\nfrom = 0.3\nto = 0.6\n[[axes]]\nfield = \"contact.friction.mu_static\"\nvalues = \
         [0, 0.8]\nagain = true\n{range}[sample]\ncount = 100\n"
    );
    let sampled = study(&mixed);
    assert_eq!((sampled.runs(), sampled.designs()), (200, 100));
    for run in 1..=100 {
        let [(ratio, mu, base), (again, other_mu, same)] = [run, run + 100].map(|run| {
            let [ratio, mu, base] = numbers(&sampled, run)[..] else { panic!("three axes") };
            (ratio, mu, base)
        });
        assert_eq!((ratio, base, mu, other_mu), (again, same, 0.0, 0.8));
        assert_eq!(sampled.design(run), sampled.design(run + 100));
        assert!((0.3..0.6).contains(&ratio) && (0.012..0.0225).contains(&base));
        // What stands in the results is what the scene has, bit for bit.
        let scene = scene::parse(&sampled.scene_text(run), "run.toml").unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scene.object().expect("given").centre_m[0], -base);
    }
    let bases = |study: &Study| (1..=100).map(|run| numbers(study, run)[2]).collect::<Vec<_>>();
    let other = study(&mixed.replace("count = 100", "count = 100\nseed = 2"));
    let latin = study(&mixed.replace("count = 100", "count = 100\nmethod = \"latin-hypercube\""));
    assert_ne!(bases(&sampled), bases(&other));
    let mut slices: Vec<i64> = bases(&latin).iter().map(|base| ((base - 0.012) / 0.0105 * 100.0) as i64).collect();
    slices.sort_unstable();
    assert!(slices.into_iter().eq(0..100));
}

#[test]
fn mistakes_are_named_with_their_place() {
    let axis = |body: &str| format!("[[axes]]\n{body}\n");
    for (more, place, words) in [
        (
            axis("field = \"design.bas\"\nvalues = [\"1 mm\"]"),
            ":3:9",
            &["unknown key `bas` in [design]", "did you mean `base`?"][..],
        ),
        (
            axis("field = \"mu_static\"\nvalues = [0]"),
            ":3:9",
            &["unknown key `mu_static`", "belongs in [contact.friction]"],
        ),
        (axis("field = \"design\"\nvalues = [0]"), ":3:9", &["is a table", "\"design.base\""]),
        (axis("field = \"duration.x\"\nvalues = [0]"), ":3:9", &["`duration` is a single value"]),
        (
            axis("field = \"design.base\"\nvalues = [\"12 mm\", 15]"),
            ":4:20",
            &["`design.base` is a bare number", "m, cm, mm, um"],
        ),
        (axis("field = \"design.base\"\nvalues = [\"12 ms\"]"), ":4:11", &["12 ms is a time", "a length is wanted"]),
        (axis("field = \"spring.type\"\nvalues = [\"constnt\"]"), ":4:11", &["did you mean \"constant\"?"]),
        (axis("field = \"palm\"\nvalues = [1]"), ":4:11", &["must be true or false"]),
        (axis("field = \"palm\"\nfrom = true\nto = false"), ":4:8", &["has no range"]),
        (axis("field = \"design.arm_ratio\"\nvalues = [0.5, 0.5]"), ":4:16", &["twice"]),
        (axis("field = \"design.arm_ratio\"\nvalues = []"), ":4:10", &["`values` is empty"]),
        (axis("field = \"design.arm_ratio\"\nvalues = 3"), ":4:10", &["must be a list"]),
        (axis("field = \"design.arm_ratio\"\nfrom = 0.3\nto = 0.5"), ":4:8", &["no `count`", "[sample]"]),
        (axis("field = \"design.arm_ratio\"\nfrom = 0.3\nto = 0.3\ncount = 3"), ":5:6", &["ends where it begins"]),
        (axis("field = \"design.arm_ratio\"\nfrom = 0.3\nto = 0.5\ncount = 1"), ":6:9", &["from 2 to"]),
        (
            axis("field = \"design.arm_ratio\"\nfrom = 0\nto = 1\ncount = 3\nspacing = \"log\""),
            ":7:11",
            &["not above 0"],
        ),
        (axis("field = \"design.arm_ratio\"\nfrom = 0"), ":2:1", &["`to` is missing"]),
        (axis("field = \"design.arm_ratio\""), ":2:1", &["`values` is missing"]),
        (axis("values = [1]"), ":2:1", &["`field` is missing"]),
        (axis("field = \"palm\"\nvalue = [true]"), ":4:1", &["unknown key `value`", "did you mean `values`?"]),
        (axis("fields = [\"palm\", \"half_width\"]\nrows = [[true]]"), ":4:9", &["a row has 1 values, but 2 fields"]),
        (
            axis("field = \"palm\"\nvalues = [true]\n[[axes]]\nfield = \"palm\"\nvalues = [false]"),
            ":6:9",
            &["varied by two axes"],
        ),
        ("[axes]\nfield = \"palm\"\n".to_string(), ":2:2", &["[[axes]]"]),
        ("model = \"engin\"\n".to_string(), ":2:9", &["did you mean \"engine\"?"]),
        ("[sample]\ncount = 10\n".to_string(), ":2:1", &["has no range"]),
        ("[sample]\nmethod = \"halton\"\n".to_string(), ":2:1", &["`count` is missing"]),
        ("[filter]\nform_close = true\n".to_string(), ":3:1", &["did you mean `form_closed`?"]),
        ("[set]\ndesign.base = \"1 kg\"\n".to_string(), ":3:15", &["a mass", "a length is wanted"]),
        ("[set]\ndesin.base = \"1 mm\"\n".to_string(), ":3:1", &["unknown key `desin`", "did you mean `design`?"]),
        ("kind = 3\n".to_string(), ":2:1", &["unknown key `kind`"]),
        ("x = \n".to_string(), ":2:5", &["not valid TOML"]),
    ] {
        let found = message(&more);
        assert!(found.contains(&format!("scenes/studies/study.toml{place}\n")), "{place} of\n{more}in\n{found}");
        for word in words {
            assert!(found.contains(word), "{word} in\n{found}");
        }
        assert!(found.contains("= help: "), "{found}");
    }
}

#[test]
fn mistakes_of_the_base_scene_are_named_in_its_own_file() {
    let of = |text: &str| parse(text, "scenes/studies/study.toml").expect_err(text).to_string();
    let found = of("scene = \"../no-such.toml\"\n");
    assert!(found.contains("study.toml:1:9") && found.contains("there is no such file"), "{found}");
    let found = of("scene = \"../laws/spring.toml\"\n");
    assert!(found.contains("laws/spring.toml:") && found.contains("a sweep simulates fingers"), "{found}");
    let axis = |field| format!("[[axes]]\nfield = \"discs.ball.{field}\"\nvalues = [\"1 mm\", \"2 mm\"]\n");
    let found = of(&format!("scene = \"../laws/spring.toml\"\n{}", axis("radius")));
    assert!(found.contains("a sweep simulates fingers"), "{found}");
    let found = of(&format!("scene = \"../laws/spring.toml\"\n{}", axis("raduis")));
    assert!(found.contains("keys in [discs.ball]: acceleration, centre"), "{found}");
    let found = of("[scene]\ndesign.base = 3\n");
    assert!(found.contains("study.toml:2:15") && found.contains("`scene.design.base` is a bare number"), "{found}");
    let found = of("name = \"x\"\n");
    assert!(found.contains("`scene` is missing"), "{found}");
    let found = of("scene = 3\n");
    assert!(found.contains("study.toml:1:9") && found.contains("`scene` is a bare number"), "{found}");
    let found = load("scenes/studies/none.toml").expect_err("there is none").to_string();
    assert!(found.contains("cannot read study") && found.contains("there is no such file"), "{found}");
}

#[test]
fn more_runs_than_anybody_can_make_are_refused() {
    let axis = |field: &str| format!("[[axes]]\nfield = \"{field}\"\nfrom = 0.1\nto = 0.9\ncount = 1000\n");
    let fields = ["design.arm_ratio", "design.l21_fraction", "contact.friction.mu_static"].map(axis).concat();
    assert_eq!(study(&fields).runs(), 1_000_000_000);
    // The last run is found as soon as the first.
    assert_eq!(numbers(&study(&fields), 1_000_000_000), [0.9; 3]);
    let all = format!("{fields}{}", axis("contact.friction.mu_dynamic"));
    assert_eq!(study(&all).runs(), phalanx::limits::MOST_SHARDED_RUNS);
    let more = format!("{all}[[axes]]\nfield = \"palm\"\nvalues = [true, false]\n");
    assert!(message(&more).contains("more than 1000000000000 runs"));
    let sample = |method: &str, count: u64| {
        format!(
            "[[axes]]\nfield = \"design.arm_ratio\"\nfrom = 0.3\nto = 0.6\n[sample]\nmethod = \"{method}\"\ncount = {count}\n"
        )
    };
    assert_eq!(study(&sample("halton", 5_000_000_000)).runs(), 5_000_000_000);
    let found = message(&sample("latin-hypercube", 1_000_001));
    assert!(found.contains("at most 1000000 points") && found.contains("\"halton\" or \"random\""), "{found}");
    assert!(message(&sample("random", 1_000_000_000_001)).contains("too many to be run"));
}

#[test]
fn studies_differ_by_text_scene_and_model() {
    let one = study("[[axes]]\nfield = \"palm\"\nvalues = [true, false]\n");
    let other = study("[[axes]]\nfield = \"palm\"\nvalues = [false, true]\n");
    let mut engine = one.clone();
    engine.model = phalanx::trace::Model::Engine;
    let prints = [&one, &other, &engine].map(Study::fingerprint);
    assert!(prints[0] != prints[1] && prints[0] != prints[2], "{prints:?}");
    assert_eq!(one.fingerprint(), one.clone().fingerprint());
}

#[test]
fn the_schema_knows_what_shipped_studies_say() {
    let schema: serde_json::Value = serde_json::from_str(&schema()).expect("JSON");
    let keys = schema["properties"].as_object().expect("a table");
    for file in ["thesis", "sample", "capture"] {
        let text = std::fs::read_to_string(format!("scenes/studies/{file}.toml")).expect("ships");
        let study: toml::Table = text.parse().expect("TOML");
        assert!(study.keys().all(|key| keys.contains_key(key)), "{file}");
        load(format!("scenes/studies/{file}.toml")).unwrap_or_else(|error| panic!("{error}"));
    }
    assert!(schema["properties"]["axes"]["items"]["properties"]["again"].is_object());
    // Of a finger or of a gripper.
    for (of, first) in [("set", 0), ("scene", 1)] {
        let kinds = &schema["properties"][of]["anyOf"];
        assert!(kinds[first]["properties"]["design"].is_object(), "{of}");
        assert!(kinds[first + 1]["properties"]["palm_width"].is_object(), "{of}");
    }
}
