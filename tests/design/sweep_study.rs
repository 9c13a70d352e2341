//! Study files: their runs, and the messages and locations of their problems.

use phalanx::scene::{self, Scene};
use phalanx::study::sweep::{Study, StudyError, columns, load, parse, schema};
use phalanx::table::{Kind, Value};

use crate::support::cli::assert_contains;

/// Study of design 95 with these additional lines.
fn try_study(lines: &str) -> Result<Study, StudyError> {
    parse(&format!("scene = \"../experiment-95.toml\"\n{lines}"), "scenes/studies/study.toml")
}

fn study(lines: &str) -> Study {
    try_study(lines).unwrap_or_else(|error| panic!("{error}"))
}

/// Error message of such a study.
fn message(lines: &str) -> String {
    try_study(lines).expect_err(lines).to_string()
}

fn numbers(study: &Study, run: u64) -> Vec<f64> {
    study.field_values(run).iter().map(|value| value.value.as_number().expect("a number")).collect()
}

fn scene_of(study: &Study, run: u64) -> Scene {
    scene::parse(&study.scene_text(run), "run.toml").unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn the_thesis_study_has_192_designs_under_two_conditions() {
    let study = load("scenes/studies/thesis.toml").expect("a shipped file");
    assert_eq!((study.runs(), study.designs()), (384, 192));
    let names: Vec<String> = columns(&study).into_iter().map(|column| column.name).collect();
    let axes = "contact.friction.mu_static design.base_m design.l21_fraction design.phi22_rad design.arm_ratio";
    assert_eq!(names[..8].join(" "), format!("run design {axes} l12_m"));
    assert_eq!(numbers(&study, 1), [0.0, 0.012, 0.0, 90f64.to_radians(), 1.0 / 3.0]);
    assert_eq!(numbers(&study, 2), [0.0, 0.012, 0.0, 90f64.to_radians(), 0.5]);
    assert_eq!(numbers(&study, 95), [0.0, 0.0155, 1.0, 120f64.to_radians(), 0.5]);
    assert_eq!(numbers(&study, 287), [0.8, 0.0155, 1.0, 120f64.to_radians(), 0.5]);
    assert_eq!(numbers(&study, 384), [0.8, 0.0225, 1.0, 120f64.to_radians(), 2.0 / 3.0]);
    assert_eq!([1, 95, 192, 193, 287, 384].map(|run| study.design(run)), [1, 95, 192, 1, 95, 192]);
}

#[test]
fn each_run_has_the_values_of_its_axes() {
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
    let [first, last] = [1, 32].map(|run| scene_of(&study, run));
    assert_eq!(last.finger().contact.proximal.friction.expect("given").mu_static, 0.4);
    assert_eq!((last.duration_s, last.hand.palm.is_some(), last.hand.gravity_m_s2), (0.03, false, [0.0, 0.0]));
    assert_eq!((last.integrator.rtol, last.integrator.max_steps), (1e-11, 1000));
    assert_eq!(last.object().expect("given").centre_m[0], -0.016);
    let values: Vec<Value> = study.field_values(32).into_iter().map(|value| value.value).collect();
    assert_eq!(values[1..3], [Value::Number(0.016), Value::Number(0.13)]);
    assert!(first.hand.palm.is_some() && first.hand.gravity_m_s2[1] == 9.81);
    // A field replaces those that exclude it, here `design.l21_fraction`.
    let length = self::study("[[axes]]\nfield = \"design.l21\"\nvalues = [\"22 mm\"]\n");
    assert_eq!(scene_of(&length, 1).finger().linkage.lengths.l21_m, 0.022);
}

#[test]
fn ranges_become_grids_or_samples() {
    let range = "[[axes]]\nfield = \"design.base\"\nfrom = \"12 mm\"\nto = \"22.5 mm\"\n";
    let grid = study(&format!("{range}count = 4\n"));
    assert_eq!([1, 2, 3, 4].map(|run| numbers(&grid, run)[0]), [0.012, 0.0155, 0.019, 0.0225]);
    // Values have the unit of the study, without rounding errors.
    assert!(
        [(1, "\"12.0 mm\""), (2, "\"15.5 mm\"")].into_iter().all(|(run, base)| grid.scene_text(run).contains(base))
    );
    let two_units = study(&format!("{}count = 3\n", range.replace("22.5 mm", "2 cm")));
    assert!(two_units.scene_text(2).contains("\"0.016 m\""), "{}", two_units.scene_text(2));
    let fraction =
        |count| study(&format!("[[axes]]\nfield = \"design.l21_fraction\"\nfrom = 0\nto = 1\ncount = {count}\n"));
    assert_eq!((numbers(&fraction(11), 4), numbers(&fraction(4), 2)), (vec![0.3], vec![1.0 / 3.0]));
    let log = study("[[axes]]\nfield = \"contact.stiffness_si\"\nfrom = 1e6\nto = 1e9\ncount = 4\nspacing = \"log\"\n");
    assert_eq!([1, 2, 3, 4].map(|run| numbers(&log, run)[0]), [1e6, 1e7, 1e8, 1e9]);

    // Grid and sample together: all points are run for every value of the grid.
    let mixed = format!(
        "[[axes]]\nfield = \"design.arm_ratio\"\nfrom = 0.3\nto = 0.6\n[[axes]]\nfield = \"contact.friction.mu_static\"\nvalues = \
         [0, 0.8]\nagain = true\n{range}[sample]\ncount = 100\n"
    );
    let sampled = study(&mixed);
    assert_eq!((sampled.runs(), sampled.designs()), (200, 100));
    for run in 1..=100 {
        let [(ratio, mu, base), (other_ratio, other_mu, other_base)] = [run, run + 100].map(|run| {
            let [ratio, mu, base] = numbers(&sampled, run)[..] else { panic!("three axes") };
            (ratio, mu, base)
        });
        assert_eq!((ratio, base, mu, other_mu), (other_ratio, other_base, 0.0, 0.8));
        assert_eq!(sampled.design(run), sampled.design(run + 100));
        assert!((0.3..0.6).contains(&ratio) && (0.012..0.0225).contains(&base));
        // The value in the results equals that of the scene, bit for bit.
        assert_eq!(scene_of(&sampled, run).object().expect("given").centre_m[0], -base);
    }
    let bases = |study: &Study| (1..=100).map(|run| numbers(study, run)[2]).collect::<Vec<_>>();
    let other = study(&mixed.replace("count = 100", "count = 100\nseed = 2"));
    let latin = study(&mixed.replace("count = 100", "count = 100\nmethod = \"latin-hypercube\""));
    assert_ne!(bases(&sampled), bases(&other));
    let mut strata: Vec<i64> = bases(&latin).iter().map(|base| ((base - 0.012) / 0.0105 * 100.0) as i64).collect();
    strata.sort_unstable();
    assert!(strata.into_iter().eq(0..100));
}

#[test]
fn reports_problems_with_their_location() {
    let axis = |body: &str| format!("[[axes]]\n{body}\n");
    let field = |name: &str, body: &str| axis(&format!("field = \"{name}\"\n{body}"));
    let ratio = |body: &str| field("design.arm_ratio", body);
    for (lines, location, words) in [
        (field("design.bas", "values = [\"1 mm\"]"), ":3:9", "unknown key `bas` in [design] … did you mean `base`?"),
        (field("mu_static", "values = [0]"), ":3:9", "unknown key `mu_static` … belongs in [contact.friction]"),
        (field("design", "values = [0]"), ":3:9", "is a table … \"design.base\""),
        (field("duration.x", "values = [0]"), ":3:9", "`duration` is a single value"),
        (field("design.base", "values = [\"12 mm\", 15]"), ":4:20", "`design.base` is a bare number … m, cm, mm, um"),
        (field("design.base", "values = [\"12 ms\"]"), ":4:11", "12 ms is a time … expected a length"),
        (field("spring.type", "values = [\"constnt\"]"), ":4:11", "did you mean \"constant\"?"),
        (field("palm", "values = [1]"), ":4:11", "must be true or false"),
        (field("palm", "from = true\nto = false"), ":4:8", "has no range"),
        (field("palm", "value = [true]"), ":4:1", "unknown key `value` … did you mean `values`?"),
        (field("palm", "values = [true]\ncount = 3"), ":5:9", "`count` has no effect together with `values`"),
        (field("palm", "rows = [[true]]\nvalues = [true]"), ":4:8", "`rows` has no effect"),
        (field("palm", "values = [true]\nfields = [\"palm\"]"), ":5:10", "both `field` and `fields`"),
        (ratio("values = [0.5, 0.5]"), ":4:16", "twice"),
        (ratio("values = []"), ":4:10", "`axes.values` is empty"),
        ("set = 3".to_string(), ":2:7", "`set` is a single value, but must be a table"),
        ("sets = 3".to_string(), ":2:1", "sample, scene, set"),
        (ratio("values = 3"), ":4:10", "must be a list"),
        (ratio("from = 0.3\nto = 0.5"), ":4:8", "no `count` … [sample]"),
        (ratio("from = 0.3\nto = 0.3\ncount = 3"), ":5:6", "are equal"),
        (ratio("from = 0.3\nto = 0.5\ncount = 1"), ":6:9", "from 2 to"),
        (ratio("from = 0.3\nto = 0.5\ncount = 0"), ":6:9", "a whole number from 1"),
        (ratio("from = 0\nto = 1\ncount = 3\nspacing = \"log\""), ":7:11", "not above 0"),
        (ratio("from = 0\nto = 1\ncount = 3\nspacing = \"lin\""), ":7:11", "\"lin\" is not … \"linear\", \"log\""),
        (ratio("from = 0\nto = 1\nagain = true\n[sample]\ncount = 3"), ":6:9", "cannot repeat the same designs"),
        (ratio("from = 0"), ":2:1", "`to` is missing"),
        (ratio(""), ":2:1", "`values` is missing"),
        (axis("values = [1]"), ":2:1", "`field` is missing"),
        (axis("fields = [\"palm\", \"half_width\"]"), ":2:1", "`rows` is missing"),
        (axis("fields = [\"palm\", 3]\nrows = [[true, 1]]"), ":3:19", "must be a string"),
        (axis("fields = [\"palm\", \"palm\"]\nrows = [[true, true]]"), ":3:19", "given twice"),
        (axis("fields = [\"palm\", \"half_width\"]\nrows = [[true]]"), ":4:9", "a row has 1 values, but 2 fields"),
        (
            axis("field = \"palm\"\nvalues = [true]\n[[axes]]\nfield = \"palm\"\nvalues = [false]"),
            ":6:9",
            "varied by two axes",
        ),
        ("[axes]\nfield = \"palm\"\n".to_string(), ":2:2", "[[axes]]"),
        ("model = \"engin\"\n".to_string(), ":2:9", "did you mean \"engine\"?"),
        ("[sample]\ncount = 10\n".to_string(), ":2:1", "has no range"),
        ("[sample]\nmethod = \"halton\"\n".to_string(), ":2:1", "`count` is missing"),
        ("[filter]\nform_close = true\n".to_string(), ":3:1", "did you mean `form_closed`?"),
        ("[filter]\nform_closed = 1\n".to_string(), ":3:15", "must be true or false"),
        ("[set]\ndesign.base = \"1 kg\"\n".to_string(), ":3:15", "a mass … expected a length"),
        ("[set]\ndesin.base = \"1 mm\"\n".to_string(), ":3:1", "unknown key `desin` … did you mean `design`?"),
        ("name = 3\n".to_string(), ":2:8", "`name` is a bare number … must be a string"),
        ("kind = 3\n".to_string(), ":2:1", "unknown key `kind`"),
        ("x = \n".to_string(), ":2:5", "not valid TOML"),
    ] {
        let error = message(&lines);
        assert!(error.contains(&format!("scenes/studies/study.toml{location}\n")), "{location} of\n{lines}in\n{error}");
        for word in words.split(" … ").chain(["= help: "]) {
            assert!(error.contains(word), "{word} in\n{error}");
        }
    }
}

#[test]
fn reports_problems_of_the_base_scene_in_its_own_file() {
    for (text, parts) in [
        ("scene = \"../no-such.toml\"\n", ["study.toml:1:9", "there is no such file"]),
        ("[scene]\ndesign.base = 3\n", ["study.toml:2:15", "`scene.design.base` is a bare number"]),
        ("name = \"x\"\n", ["study.toml", "`scene` is missing"]),
        ("scene = 3\n", ["study.toml:1:9", "`scene` is a bare number"]),
    ] {
        assert_contains(&parse(text, "scenes/studies/study.toml").expect_err(text).to_string(), &parts);
    }
    let message = load("scenes/studies/none.toml").expect_err("no such file").to_string();
    assert_contains(&message, &["cannot read study", "there is no such file"]);
}

#[test]
fn rejects_too_many_runs() {
    let axis = |field: &str| format!("[[axes]]\nfield = \"{field}\"\nfrom = 0.1\nto = 0.9\ncount = 1000\n");
    let fields = ["design.arm_ratio", "design.l21_fraction", "contact.friction.mu_static"].map(axis).concat();
    assert_eq!(study(&fields).runs(), 1_000_000_000);
    // The last run is available without enumerating the others.
    assert_eq!(numbers(&study(&fields), 1_000_000_000), [0.9; 3]);
    let maximal = format!("{fields}{}", axis("contact.friction.mu_dynamic"));
    assert_eq!(study(&maximal).runs(), phalanx::limits::MAX_SHARDED_RUNS);
    let excessive = format!("{maximal}[[axes]]\nfield = \"palm\"\nvalues = [true, false]\n");
    assert!(message(&excessive).contains("more than 1000000000000 runs"));
    let sample = |method: &str, count: u64| {
        format!(
            "[[axes]]\nfield = \"design.arm_ratio\"\nfrom = 0.3\nto = 0.6\n[sample]\nmethod = \"{method}\"\ncount = {count}\n"
        )
    };
    assert_eq!(study(&sample("halton", 5_000_000_000)).runs(), 5_000_000_000);
    let error = message(&sample("latin-hypercube", 1_000_001));
    assert!(error.contains("at most 1000000 points") && error.contains("\"halton\" or \"random\""), "{error}");
    assert!(message(&sample("random", 1_000_000_000_001)).contains("too large"));
}

#[test]
fn fingerprint_depends_on_text_and_model() {
    let [first, second] = ["true, false", "false, true"]
        .map(|values| study(&format!("[[axes]]\nfield = \"palm\"\nvalues = [{values}]\n")));
    let mut engine = first.clone();
    engine.model = phalanx::trace::Model::Engine;
    let [original, other_text, other_model] = [&first, &second, &engine].map(Study::fingerprint);
    assert!(original != other_text && original != other_model && original == first.clone().fingerprint());
}

#[test]
fn the_schema_covers_the_shipped_studies() {
    let schema: serde_json::Value = serde_json::from_str(&schema()).expect("JSON");
    let keys = schema["properties"].as_object().expect("a table");
    for file in ["thesis", "sample", "capture", "2f85-map"] {
        let text = std::fs::read_to_string(format!("scenes/studies/{file}.toml")).expect("a shipped file");
        let study: toml::Table = text.parse().expect("TOML");
        assert!(study.keys().all(|key| keys.contains_key(key)), "{file}");
        load(format!("scenes/studies/{file}.toml")).unwrap_or_else(|error| panic!("{error}"));
    }
    assert!(schema["properties"]["axes"]["items"]["properties"]["again"].is_object());
    // Schemas of all kinds of scene: a finger, discs, a gripper, a mechanism.
    for (key, first) in [("set", 0), ("scene", 1)] {
        let kinds = &schema["properties"][key]["anyOf"];
        for (index, of_kind) in ["design", "discs", "palm_width", "joints"].into_iter().enumerate() {
            assert!(kinds[first + index]["properties"][of_kind].is_object(), "{key}: {of_kind}");
        }
    }
}
