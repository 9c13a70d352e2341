//! Reading of optimisation files, and messages for invalid ones.

use phalanx::study::optimize::{Algorithm, ConditionAggregation, Goal, Limit, load, parse, schema};
use phalanx::study::sweep::columns;

const HEAD: &str = "scene = \"../experiment-95.toml\"\n";
const VARIABLE: &str = "[[variables]]\nfield = \"design.base\"\nfrom = \"12 mm\"\nto = \"2 cm\"\n";
const OBJECTIVE: &str = "[[objectives]]\ncolumn = \"tts_s\"\n";

fn message(text: &str) -> String {
    parse(text, "scenes/studies/study.toml").expect_err(text).to_string()
}

#[test]
fn reads_all_sections_of_a_file() {
    let optimisation = parse(
        &format!(
            "{HEAD}{VARIABLE}[[variables]]\nfield = \"contact.stiffness_si\"\nfrom = 1e6\nto = 1e10\nspacing = \"log\"\nstart = \
             1e8\n[[conditions]]\nfield = \"contact.friction.mu_static\"\nvalues = [0.4, 0.8]\n[[conditions]]\nfields = [\"palm\", \
             \"gravity\"]\nrows = [[true, [\"0 m/s^2\", \"9.81 m/s^2\"]], [true, [\"0 m/s^2\", \"0 m/s^2\"]]]\n{OBJECTIVE}\
             [[objectives]]\ncolumns = [\"peak_f21_n\", \"peak_f22_n\"]\nof = \"sum\"\ngoal = \"max\"\nover = \"mean\"\n\
             [[constraints]]\ncolumn = \"tts_s\"\nat_most = \"8 ms\"\n[[constraints]]\ncolumn = \"class\"\nat_least = \
             \"semi-stable\"\n[[constraints]]\ncolumn = \"form_closed\"\nequals = true\n"
        ),
        "scenes/studies/study.toml",
    )
    .unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(
        (optimisation.name(), optimisation.conditions(), optimisation.method.algorithm),
        ("study", 4, Algorithm::Nsga2)
    );
    assert_eq!(optimisation.max_runs(), 4 * optimisation.method.population * optimisation.method.generations);
    assert_eq!(optimisation.objectives[1].figure.name, "sum_peak_f21_n_peak_f22_n");
    assert_eq!(
        (optimisation.objectives[1].goal, optimisation.objectives[1].condition_aggregation),
        (Goal::Max, ConditionAggregation::Mean)
    );
    assert_eq!(optimisation.constraints[0].limit, Limit::Between { at_least: None, at_most: Some(0.008) });
    assert_eq!(
        (&optimisation.constraints[1].limit, &optimisation.constraints[2].limit),
        (&Limit::Class(1), &Limit::Flag(true))
    );
    let names: Vec<String> = columns(optimisation.study()).into_iter().map(|column| column.name).collect();
    assert_eq!(names[2..6], ["design.base_m", "contact.stiffness_si", "contact.friction.mu_static", "palm"]);
    // The start value is the text of the base scene.
    assert_eq!(optimisation.variables[0].start().text, "\"15.5 mm\"");
    // A single objective is optimised with CMA-ES.
    let parsed = parse(&format!("{HEAD}{VARIABLE}{OBJECTIVE}"), "study.toml").err();
    assert!(parsed.is_some(), "the path of the scene is relative to the directory of the file");
    let parsed = parse(&format!("{HEAD}{VARIABLE}{OBJECTIVE}"), "scenes/studies/one.toml").expect("a valid file");
    assert_eq!((parsed.method.algorithm, parsed.method.population), (Algorithm::CmaEs, 4));
}

#[test]
fn errors_name_the_location() {
    let with = |more: &str| format!("{HEAD}{VARIABLE}{OBJECTIVE}{more}");
    let objective = |more: &str| format!("{HEAD}{VARIABLE}[[objectives]]\n{more}");
    let constraint = |more: &str| with(&format!("[[constraints]]\n{more}"));
    let variable = |more: &str| format!("{HEAD}{OBJECTIVE}[[variables]]\n{more}");
    for (text, location, fragments) in [
        (format!("{HEAD}{OBJECTIVE}"), "", &["there are no [[variables]]"][..]),
        (format!("{HEAD}{VARIABLE}"), "", &["there are no [[objectives]]"]),
        (variable("field = \"design.bas\"\nfrom = 1\nto = 2\n"), ":5:9", &["did you mean `base`?"]),
        (variable("field = \"palm\"\nfrom = true\nto = false\n"), ":6:8", &["has no range"]),
        (variable("field = \"design.base\"\nfrom = \"1 mm\"\n"), ":4:1", &["`to` is missing"]),
        (
            variable("field = \"design.base\"\nfrom = \"12 mm\"\nto = \"15 mm\"\n"),
            ":5:9",
            &["start value", "15.5 mm, is outside its range"],
        ),
        (
            variable("field = \"design.l11\"\nfrom = \"12 mm\"\nto = \"18 mm\"\n"),
            ":5:9",
            &["no start value for `design.l11`", "start = .."],
        ),
        (with(VARIABLE), ":9:9", &["declared twice"]),
        (
            with("[[conditions]]\nfield = \"design.base\"\nvalues = [\"12 mm\"]\n"),
            ":9:9",
            &["both a variable and a condition"],
        ),
        (
            with("[[conditions]]\nfield = \"contact.friction.mu_static\"\nfrom = 0\nto = 1\n"),
            ":8:1",
            &["`count` is missing"],
        ),
        (
            with("[[conditions]]\nfield = \"palm\"\nvalues = [true]\nagain = true\n"),
            ":11:9",
            &["`again` has no effect"],
        ),
        (objective("column = \"tts\"\n"), ":7:10", &["no column `tts`", "did you mean \"tts_s\"?"]),
        (objective("column = \"class\"\n"), ":7:10", &["is not numeric", "[[constraints]]"]),
        (objective("goal = \"min\"\n"), ":6:1", &["`column` is missing"]),
        (objective("column = \"tts_s\"\ngoal = \"smallest\"\n"), ":8:8", &["allowed: \"min\", \"max\""]),
        (objective("column = \"tts_s\"\ncolumns = [\"tts_s\"]\n"), ":8:11", &["both `column` and `columns`"]),
        (objective("columns = [\"tts_s\", 3]\n"), ":7:21", &["contains a bare number"]),
        (objective("column = \"tts_s\"\nname = \"design.base_m\"\n"), ":8:8", &["two columns `design.base_m`"]),
        (with(OBJECTIVE), ":9:10", &["two columns `tts_s`", "name = .."]),
        (constraint("column = \"pfp_n\"\n"), ":8:1", &["at_least = .. or at_most"]),
        (constraint("column = \"rebound_percent\"\nat_most = \"5 mm\"\n"), ":10:11", &["a plain number"]),
        (constraint("column = \"tts_s\"\nat_most = \"8 mm\"\n"), ":10:11", &["expected a time"]),
        (constraint("column = \"pfp_n\"\nat_least = 3\nat_most = 2\n"), ":11:11", &["at least 3 and at most 2"]),
        (constraint("column = \"pfp_n\"\nequals = 3\nat_least = 1\n"), ":10:10", &["`equals` has no effect"]),
        (constraint("column = \"class\"\nat_least = \"stabel\"\n"), ":10:12", &["did you mean \"stable\"?"]),
        (constraint("column = \"form_closed\"\nequals = \"yes\"\n"), ":10:10", &["true or false"]),
        (constraint("column = \"form_closed\"\nat_least = true\n"), ":10:12", &["`at_least` has no effect"]),
        (
            constraint("column = \"pfp_n\"\nat_least = 1\n[[constraints]]\ncolumn = \"pfp_n\"\nat_most = 2\n"),
            ":12:10",
            &["two constraints on `pfp_n`"],
        ),
        (with("[method]\nalgorithm = \"nsga\"\n"), ":9:13", &["did you mean \"nsga2\"?"]),
        (with("[method]\npopulation = 2\n"), ":9:14", &["at least 4"]),
        (with("[method]\npopulation = 1000\ngenerations = 1000\n"), ":8:1", &["more than 1000000 runs"]),
        (
            with("[[objectives]]\ncolumn = \"pfp_n\"\n[method]\nalgorithm = \"cma-es\"\n"),
            ":11:13",
            &["one objective", "nsga2"],
        ),
        (with("[[axes]]\nfield = \"palm\"\n"), ":8:3", &["unknown key `axes`"]),
    ] {
        let error = message(&text);
        assert!(error.contains(&format!("scenes/studies/study.toml{location}")), "{location} of\n{text}in\n{error}");
        for fragment in fragments {
            assert!(error.contains(fragment), "{fragment} in\n{error}");
        }
        assert!(error.contains("= help: "), "{error}");
    }
}

#[test]
fn schema_contains_the_keys_of_shipped_files() {
    let schema: serde_json::Value = serde_json::from_str(&schema()).expect("JSON");
    let keys = schema["properties"].as_object().expect("a table");
    for (file, variables) in [("optimize-95", 4), ("optimize-95-wide", 8), ("optimize-95-fastest", 8)] {
        let path = format!("scenes/studies/{file}.toml");
        let text: toml::Table = std::fs::read_to_string(&path).expect("ships").parse().expect("TOML");
        assert!(text.keys().all(|key| keys.contains_key(key)), "{file}");
        let optimisation = load(&path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((optimisation.name(), optimisation.variables.len()), (file, variables));
    }
    assert!(schema["properties"]["objectives"]["items"]["properties"]["over"].is_object());
    assert!(schema["properties"]["scene"]["anyOf"][1]["properties"]["design"].is_object());
}
