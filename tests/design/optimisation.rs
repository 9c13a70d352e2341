//! Study files of optimisations: what they describe, and the messages and locations of their problems.

use std::path::PathBuf;

use phalanx::scene::{locate_problems, parse_layers, show_written};
use phalanx::study::optimisation::{
    Aggregation, Algorithm, Constraint, Goal, Method, Optimisation, Over, load, parse, schema,
};
use phalanx::study::sweep::StudyError;

const FILE: &str = "scenes/studies/study.toml";
const HEAD: &str = "scene = \"../experiment-95.toml\"\n";
const VARIABLE: &str = "[[variables]]\nfield = \"design.base\"\nfrom = \"12 mm\"\nto = \"20 mm\"\n";
const OBJECTIVE: &str = "[[objectives]]\ncolumn = \"tts_s\"\n";

fn study(text: &str) -> Optimisation {
    parse(text, FILE).unwrap_or_else(|error| panic!("{error}"))
}

/// A valid study with these additional lines.
fn more(lines: &str) -> String {
    format!("{HEAD}{VARIABLE}{OBJECTIVE}{lines}")
}

#[test]
fn the_shipped_studies_are_valid_and_the_schema_has_their_keys() {
    let schema: serde_json::Value = serde_json::from_str(&schema()).expect("JSON");
    for (name, variables, conditions) in
        [("optimize-95", 4, 1), ("optimize-95-wide", 8, 1), ("optimize-95-fastest", 8, 1), ("optimize-2f85", 4, 2)]
    {
        let study = load(format!("scenes/studies/{name}.toml")).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((&study.name[..], study.variables.len(), study.conditions.len()), (name, variables, conditions));
        assert!(study.keys.keys().all(|key| schema["properties"].get(key).is_some()), "{name}");
        assert!(study.verdict.is_some(), "{name}");
        parse_layers(&study.scene, &[]).unwrap_or_else(|error| panic!("{error}"));
    }
    let properties = &schema["properties"];
    assert_eq!(properties["objectives"]["items"]["properties"]["over"]["enum"], serde_json::json!(["worst", "mean"]));
    let conditions = &properties["conditions"]["items"];
    assert!(conditions["properties"].get("again").is_none() && conditions["properties"].get("rows").is_some());
    assert!(properties["set"].is_object() && properties["scene"]["anyOf"].is_array());
}

#[test]
fn all_sections_are_read() {
    let found = study(&format!(
        "{HEAD}{VARIABLE}[[variables]]\nfield = \"contact.stiffness_si\"\nfrom = 1e6\nto = 1e10\nspacing = \"log\"\nstart = \
         1e8\n[[conditions]]\nfield = \"contact.friction.mu_static\"\nvalues = [0.4, 0.8]\n[[conditions]]\nfields = [\"palm\", \
         \"gravity\"]\nrows = [[true, [\"0 m/s^2\", \"9.81 m/s^2\"]], [true, [\"0 m/s^2\", \"0 m/s^2\"]]]\n{OBJECTIVE}[[objectives]]\n\
         columns = [\"peak_f21_n\", \"peak_f22_n\"]\nof = \"sum\"\ngoal = \"max\"\nover = \"mean\"\n[[constraints]]\ncolumn = \
         \"tts_s\"\nat_most = \"8 ms\"\n[[constraints]]\ncolumn = \"class\"\nat_least = \"semi-stable\"\n[[constraints]]\ncolumn = \
         \"form_closed\"\nequals = true\n[[constraints]]\ncolumn = \"pfp_n\"\nat_least = 3\nat_most = \"0.02 kN\"\n"
    ));
    assert_eq!((&found.name[..], found.verdict), ("study", Some("class")));
    assert_eq!(found.method, Method { algorithm: Algorithm::Nsga2, population: 64, generations: 50, seed: 1 });
    let second = &found.objectives[1];
    assert_eq!(second.name, "sum_peak_f21_n_peak_f22_n");
    assert_eq!((second.of, second.goal, second.over), (Aggregation::Sum, Goal::Max, Over::Mean));
    let of = |column: &str| Constraint { column: column.to_string(), ..Constraint::default() };
    assert_eq!(
        found.constraints,
        [
            Constraint { at_most: Some(0.008), ..of("tts_s") },
            Constraint { worst_class: Some(1), ..of("class") },
            Constraint { equals: Some(true.into()), ..of("form_closed") },
            Constraint { at_least: Some(3.0), at_most: Some(20.0), ..of("pfp_n") },
        ]
    );
    // The start value is the text of the base scene; other values are in the unit of the study.
    let [base, stiffness] = &found.variables[..] else { panic!("two variables") };
    assert_eq!([base.start_fraction, 0.5].map(|x| base.value_at(x).text), ["\"15.5 mm\"", "\"16.0 mm\""]);
    assert_eq!([0.0, 1.0].map(|x| base.si_at(x)), [0.012, 0.02]);
    assert!((stiffness.start_fraction - 0.5).abs() < 1e-15 && stiffness.is_log() && !base.is_log());
    // All combinations, the last condition fastest.
    let texts = |index: usize| found.conditions[index].iter().map(|(_, value)| &value.text[..]).collect::<Vec<_>>();
    assert_eq!(found.conditions.len(), 4);
    assert_eq!(texts(1), ["0.4", "true", "[\"0 m/s^2\", \"0 m/s^2\"]"]);
    assert_eq!(texts(2)[0], "0.8");
    // A single objective is optimised with CMA-ES.
    let single =
        study(&more("[[conditions]]\nfield = \"contact.friction.mu_static\"\nfrom = 0.2\nto = 0.8\ncount = 3\n"));
    assert_eq!(single.method, Method { algorithm: Algorithm::CmaEs, population: 4, generations: 100, seed: 1 });
    assert_eq!([0, 1, 2].map(|index| &single.conditions[index][0].1.text[..]), ["0.2", "0.5", "0.8"]);
}

#[test]
fn the_scene_extends_a_file_and_has_start_values() {
    let text = std::fs::read_to_string("scenes/studies/optimize-2f85.toml").expect("a shipped file");
    let files = |name: &str| study(name).files;
    assert!(files(&text).contains(&PathBuf::from("scenes/studies/../real/2f85-pinch.toml")), "{:?}", files(&text));
    // The values of [set] and the start values are in the base scene, which may lack them.
    let found = study(&format!(
        "{HEAD}{OBJECTIVE}[set]\ndesign.arm_ratio = 0.4\n[[variables]]\nfield = \"design.l21\"\nfrom = \"18 mm\"\nto = \"26 \
         mm\"\nstart = \"22 mm\"\n"
    ));
    let scene = parse_layers(&found.scene, &[]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.finger().linkage.lengths.l21_m, 0.022);
    assert_eq!(found.variables[0].start_fraction, 0.5);
    assert!(show_written(&scene).contains("arm_ratio = 0.4"));
}

#[test]
fn reports_problems_with_their_location() {
    let objective = |lines: &str| format!("{HEAD}{VARIABLE}[[objectives]]\n{lines}");
    let variable = |lines: &str| format!("{HEAD}{OBJECTIVE}[[variables]]\n{lines}");
    let constraint = |lines: &str| more(&format!("[[constraints]]\n{lines}"));
    let friction = |lines: &str| more(&format!("[[conditions]]\nfield = \"contact.friction.mu_static\"\n{lines}"));
    let base = |lines: &str| variable(&format!("field = \"design.base\"\n{lines}"));
    for (text, location, field, words) in [
        (format!("{HEAD}{OBJECTIVE}"), "", "", "[[variables]] is missing … from and to"),
        (format!("{HEAD}{VARIABLE}"), "", "", "[[objectives]] is missing … column = \"tts_s\""),
        (format!("variables = []\n{HEAD}{OBJECTIVE}"), "", "", "[[variables]] is missing"),
        (format!("{VARIABLE}{OBJECTIVE}"), "", "", "`scene` is missing … or write it in a table [scene]"),
        (more("[[axes]]\nfield = \"palm\"\n"), ":8:3", "axes[0]", "unknown key `axes` … conditions, constraints"),
        (more("[objective]\nname = \"a\"\n"), ":8:2", "objective", "did you mean `objectives`?"),
        (more("[conditions]\nfield = \"palm\"\n"), ":8:2", "conditions", "[[conditions]]"),
        (format!("name = 3\n{}", more("")), ":1:8", "name", "`name` is a bare number … must be a string"),
        (format!("model = \"engin\"\n{}", more("")), ":1:9", "model", "did you mean \"engine\"?"),
        (more("[method]\npopulaton = 8\n"), ":9:1", "method.populaton", "did you mean `population`?"),
        (more("[filter]\nform_closed = 1\n"), ":9:15", "filter.form_closed", "must be true or false"),
        ("a = [".to_string(), ":1:6", "", "not valid TOML"),
        // The base scene.
        (format!("scene = \"no.toml\"\n{VARIABLE}{OBJECTIVE}"), ":1:9", "scene", "no.toml: there is no such file"),
        (
            format!("{VARIABLE}{OBJECTIVE}[scene.design]\nbas = \"1 mm\"\n"),
            ":8:1",
            "scene.design.bas",
            "unknown key `bas`",
        ),
        (format!("{VARIABLE}{OBJECTIVE}[scene]\npalm = 3\n"), ":8:8", "scene.palm", "must be true or false"),
        (format!("{VARIABLE}{OBJECTIVE}[scene]\npalm = true\n"), ":7:1", "scene", "is missing"),
        (more("[set]\ndesign.base = \"1 m\"\n"), ":9:15", "set.design.base", "base is 1000.0000 mm, but must be below"),
        // Variables.
        (variable("from = 1\nto = 2\n"), ":4:1", "variables[0]", "`field` is missing"),
        (variable("field = \"design.bas\"\nfrom = 1\nto = 2\n"), ":5:9", "variables[0].field", "did you mean `base`?"),
        (variable("field = \"palm\"\nfrom = true\nto = false\n"), ":6:8", "variables[0].from", "has no range"),
        (base("from = \"1 mm\"\n"), ":4:1", "variables[0]", "`to` is missing … both ends"),
        (base(""), ":4:1", "variables[0]", "`from` is missing … both ends"),
        (base("from = 1\nto = \"2 mm\"\n"), ":6:8", "variables[0].from", "m, cm, mm, um"),
        (base("from = \"9 mm\"\nto = \"9 mm\"\n"), ":7:6", "variables[0].to", "are equal"),
        (base("from = \"0 m\"\nto = \"1 m\"\nspacing = \"log\"\n"), ":8:11", "variables[0].spacing", "not above 0"),
        (
            base("from = \"0 m\"\nto = \"1 m\"\nspacing = \"lin\"\n"),
            ":8:11",
            "variables[0].spacing",
            "\"linear\", \"log\"",
        ),
        (
            base("from = \"12 mm\"\nto = \"15 mm\"\n"),
            ":5:9",
            "variables[0].field",
            "start value of `design.base`, 15.5 mm, is outside … start = ..",
        ),
        (
            base("from = \"12 mm\"\nto = \"15 mm\"\nstart = \"16 mm\"\n"),
            ":8:9",
            "variables[0].start",
            "start value of `design.base`, 16 mm, is outside",
        ),
        (
            base("from = \"12 mm\"\nto = \"2 m\"\nstart = \"1 m\"\n"),
            ":8:9",
            "variables[0].start",
            "base is 1000.0000 mm, but must be below",
        ),
        (base("from = \"12 mm\"\nto = \"15 mm\"\nstart = true\n"), ":8:9", "variables[0].start", "expected a length"),
        (
            variable("field = \"design.l21\"\nfrom = \"12 mm\"\nto = \"18 mm\"\n"),
            ":5:9",
            "variables[0].field",
            "no start value for `design.l21` … start = ..",
        ),
        (more(VARIABLE), ":9:9", "variables[1].field", "declared twice"),
        // Conditions.
        (
            more("[[conditions]]\nfield = \"design.base\"\nvalues = [\"12 mm\"]\n"),
            ":9:9",
            "conditions[0].field",
            "both a variable and a condition",
        ),
        (
            friction("values = [0.1]\nfields = [\"palm\"]\n"),
            ":11:10",
            "conditions[0].fields",
            "both `field` and `fields`",
        ),
        (more("[[conditions]]\nvalues = [1]\n"), ":8:1", "conditions[0]", "`field` is missing"),
        (
            friction("values = [0.1]\n[[conditions]]\nfield = \"contact.friction.mu_static\"\nvalues = [0.2]\n"),
            ":12:9",
            "conditions[1].field",
            "by two conditions",
        ),
        (friction(""), ":8:1", "conditions[0]", "`values` is missing"),
        (friction("from = 0\nto = 1\n"), ":8:1", "conditions[0]", "`count` is missing"),
        (friction("from = 0\nto = 1\ncount = 1\n"), ":12:9", "conditions[0].count", "2 to 1000000"),
        (friction("values = [0.1, true]\n"), ":10:16", "conditions[0].values", "must be a plain number"),
        (friction("values = [0.1, 0.1]\n"), ":10:16", "conditions[0].values", "twice"),
        (friction("values = [0.1]\nagain = true\n"), ":11:1", "conditions[0].again", "unknown key `again`"),
        (friction("values = [0.1]\ncount = 3\n"), ":11:9", "conditions[0].count", "`count` has no effect"),
        (more("[[conditions]]\nfields = [\"palm\", 3]\n"), ":9:19", "conditions[0].fields", "must be a string"),
        (more("[[conditions]]\nfields = [\"palm\"]\n"), ":8:1", "conditions[0]", "`rows` is missing"),
        (
            more("[[conditions]]\nfields = [\"palm\", \"half_width\"]\nrows = [[true]]\n"),
            ":10:9",
            "conditions[0].rows",
            "a row has 1 values, but 2 fields",
        ),
        // Objectives.
        (objective("column = \"tts\"\n"), ":7:10", "objectives[0].column", "no column `tts` … did you mean `tts_s`?"),
        (objective("column = \"class\"\n"), ":7:10", "objectives[0].column", "is not numeric … [[constraints]]"),
        (objective("goal = \"min\"\n"), ":6:1", "objectives[0]", "`column` is missing"),
        (
            objective("column = \"tts_s\"\ngoal = \"smallest\"\n"),
            ":8:8",
            "objectives[0].goal",
            "allowed: \"min\", \"max\"",
        ),
        (
            objective("column = \"tts_s\"\ncolumns = [\"tts_s\"]\n"),
            ":8:11",
            "objectives[0].columns",
            "both `column` and",
        ),
        (objective("columns = []\n"), ":7:11", "objectives[0].columns", "is empty"),
        (objective("columns = [\"tts_s\", 3]\n"), ":7:21", "objectives[0].columns", "must be a string"),
        (objective("column = \"tts_s\"\nname = \"design.base_m\"\n"), ":6:1", "objectives[0]", "two columns"),
        (more(OBJECTIVE), ":8:1", "objectives[1]", "two columns `tts_s` … name = .."),
        // Constraints.
        (constraint("at_least = 1\n"), ":8:1", "constraints[0]", "`column` is missing"),
        (constraint("column = \"clas\"\n"), ":9:10", "constraints[0].column", "did you mean `class`?"),
        (constraint("column = \"pfp_n\"\n"), ":8:1", "constraints[0]", "has no limit … at_least = .. or at_most"),
        (
            constraint("column = \"rebound_percent\"\nat_most = \"5 mm\"\n"),
            ":10:11",
            "constraints[0].at_most",
            "a plain number",
        ),
        (constraint("column = \"tts_s\"\nat_most = \"8 mm\"\n"), ":10:11", "constraints[0].at_most", "expected a time"),
        (constraint("column = \"tts_s\"\nat_most = inf\n"), ":10:11", "constraints[0].at_most", "expected a time"),
        (
            constraint("column = \"pfp_n\"\nat_least = 3\nat_most = 2\n"),
            ":11:11",
            "constraints[0].at_most",
            "at least 3 and at most 2",
        ),
        (constraint("column = \"pfp_n\"\nequals = 3\n"), ":10:10", "constraints[0].equals", "`equals` has no effect"),
        (
            constraint("column = \"class\"\nat_least = \"stabel\"\n"),
            ":10:12",
            "constraints[0].at_least",
            "no class \"stabel\" … did you mean `stable`? … semi-unstable, unstable",
        ),
        (
            constraint("column = \"form_closed\"\nequals = \"yes\"\n"),
            ":10:10",
            "constraints[0].equals",
            "contains true or false … without quotes",
        ),
        (
            constraint("column = \"status\"\nequals = 3\n"),
            ":10:10",
            "constraints[0].equals",
            "contains text … in quotes",
        ),
        (
            constraint("column = \"form_closed\"\nat_least = true\n"),
            ":10:12",
            "constraints[0].at_least",
            "has no effect",
        ),
        (
            constraint("column = \"pfp_n\"\nat_least = 1\n[[constraints]]\ncolumn = \"pfp_n\"\nat_most = 2\n"),
            ":12:10",
            "constraints[1].column",
            "two constraints on `pfp_n` … combine",
        ),
        // Filter and method.
        (
            more("[filter]\nform_closed = true\n")
                .replace("experiment-95", "gripper/offset")
                .replace("design.base", "palm_width")
                .replace("12 mm\"\nto = \"20", "1 mm\"\nto = \"900"),
            ":8:1",
            "filter",
            "[filter] concerns the statics of one finger",
        ),
        (more("[method]\nalgorithm = \"nsga\"\n"), ":9:13", "method.algorithm", "did you mean \"nsga2\"?"),
        (more("[method]\npopulation = 2\n"), ":9:14", "method.population", "a whole number from 4"),
        (more("[method]\ngenerations = 0\n"), ":9:15", "method.generations", "a whole number from 1"),
        (more("[method]\npopulation = 1000\ngenerations = 1000\n"), ":8:1", "method", "more than 1000000 runs"),
        (
            more("[[objectives]]\ncolumn = \"pfp_n\"\n[method]\nalgorithm = \"cma-es\"\n"),
            ":11:13",
            "method.algorithm",
            "one objective … nsga2",
        ),
    ] {
        let error = parse(&text, FILE).expect_err(&text);
        let message = error.to_string();
        assert!(message.contains(&format!("{FILE}{location}\n")), "{location} of\n{text}in\n{message}");
        for word in words.split(" … ").chain(["= help: "]) {
            assert!(message.contains(word), "{word} in\n{message}");
        }
        let StudyError::Invalid(error) = error else { panic!("{message}") };
        let found = locate_problems(&error)[0].field.clone().unwrap_or_default();
        assert_eq!(found, field, "{message}");
    }
    // All problems are reported together.
    let error = parse(&more("[method]\npopulaton = 8\nseed = \"a\"\n"), FILE).expect_err("two").to_string();
    assert!(error.contains(&format!("{FILE}:9:1\n")) && error.contains(&format!("{FILE}:10:8\n")), "{error}");
    let error = load("scenes/studies/none.toml").expect_err("no such file").to_string();
    assert!(error.contains("cannot read study") && error.contains("there is no such file"), "{error}");
}

#[test]
fn problems_of_the_base_scene_are_in_its_own_file() {
    let text = std::fs::read_to_string("scenes/studies/optimize-2f85.toml").expect("a shipped file");
    for (from, to, words) in [
        ("real/2f85-pinch", "real/2f85-pich", "cannot read the scene … 2f85-pich.toml … study.toml:10:11"),
        ("+ palm *", "+ plam *", "unknown parameter `plam` … study.toml:20:"),
        ("field = \"parameters.link\"", "field = \"parameters.lnk\"", "did you mean `link` … study.toml:45:9"),
        ("driver = \"31.767 mm\"", "driver = \"31.767 deg\"", "study.toml:22:16 … is a length, but … is an angle"),
    ] {
        let error = parse(&text.replacen(from, to, 1), FILE).expect_err(to).to_string();
        for word in words.split(" … ") {
            assert!(error.contains(word), "{word} in\n{error}");
        }
    }
}
