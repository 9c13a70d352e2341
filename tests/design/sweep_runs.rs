//! Runs of a study: a row depends only on its run, and has a verdict or a reason.

use std::collections::HashSet;

use phalanx::criteria::static_grasp;
use phalanx::format::ToReport;
use phalanx::report::sweep::SelectionReport;
use phalanx::scene::{self, Preset};
use phalanx::study::select::{SelectionCriteria, select};
use phalanx::study::sweep::{AxisValue, Status, Study, in_memory_study, load, run_while, summary, table};
use phalanx::table::Table;
use phalanx::trace::{FingerContact, Model, run_analytic};

use crate::support::cli::assert_contains;
use crate::support::studies::{parse_study, run_rows, run_study};

/// The counts of the thesis are compared in `reproduce`.
#[test]
fn runs_of_the_thesis_equal_single_runs() {
    let study = load("scenes/studies/thesis.toml").expect("a shipped file");
    let table = run_study(&study);
    let [closed, positive] = ["form_closed", "force_positive"].map(|name| table.flags(name).expect(name));
    let classes = table.texts("class").expect("texts");
    assert_eq!((table.rows.len(), &closed[..192]), (384, &closed[192..]));
    // A statically unstable grasp is unstable regardless of the simulation.
    for (positive, class) in positive.iter().zip(&classes) {
        assert!(*positive == Some(true) || matches!(class, None | Some("unstable")));
    }

    // Design 95: a single run of the same scene gives the same results.
    let number = |name: &str| table.numbers(name).expect(name)[287 - 1].expect(name);
    assert!((number("motor_n_m") - 0.5165).abs() < 2e-4 && (number("spring_n_m") - 0.11772).abs() < 5e-6);
    let scene = scene::parse(&study.scene_text(287), "95.toml").expect("a scene");
    assert_eq!(scene.integrator.preset, Preset::Engineering);
    let outcome = run_analytic(&scene, &mut ()).expect("completes");
    assert_eq!(number("f21_n"), outcome.last.finger_contact(FingerContact::Proximal).normal_n);
    assert_eq!(number("peak_f22_n"), outcome.finger_contact(FingerContact::Distal).peak_normal_n);
    assert!((number("t22_m") - 12.857e-3).abs() < 5e-7);
    assert_eq!(classes[287 - 1], Some("stable"));
}

#[test]
fn a_preset_replaces_the_settings_of_the_integrator_in_all_runs() {
    let text = "scene = \"../mechanisms/two-pivot.toml\"\n[set]\nduration = \"40 ms\"\n[[axes]]\nfield = \
                \"bodies.object.mass\"\nvalues = [\"20 g\", \"80 g\"]\n";
    let study = parse_study(text);
    let mut drafts = study.clone();
    drafts.set_preset(Some(Preset::Draft)).expect("the analytic model has presets");
    assert_ne!(study.fingerprint(), drafts.fingerprint());
    let [everyday, draft] = [&study, &drafts].map(run_study);
    let steps = |table: &Table| table.numbers("steps").expect("numbers");
    for run in 0..2 {
        let mut scene = scene::parse_any(&study.scene_text(run as u64 + 1), "run.toml").expect("a scene");
        scene.apply_preset(Preset::Draft);
        let outcome = run_analytic(&scene, &mut ()).expect("completes");
        assert_eq!(steps(&draft)[run], Some(outcome.work.steps as f64));
        assert!(steps(&draft)[run] < steps(&everyday)[run].map(|steps| 0.7 * steps), "{run}");
    }
    assert_eq!(draft.texts("fate").expect("texts"), everyday.texts("fate").expect("texts"));

    drafts.model = Model::Engine;
    assert_contains(
        &drafts.set_preset(Some(Preset::Draft)).expect_err("no preset"),
        &["--preset is a setting of the analytic"],
    );
}

const MIXED: &str = "scene = \"../experiment-95.toml\"\n[set]\nintegrator.max_steps = 120\n[[axes]]\nfield = \
                     \"contact.friction.mu_static\"\nvalues = [-0.5, 0.0, 0.8]\n[[axes]]\nfield = \"design.phi22\"\nfrom = \"60 \
                     deg\"\nto = \"170 deg\"\ncount = 6\n[[axes]]\nfield = \"design.l21_fraction\"\nvalues = [0.0, 1.0, 1.5]\n";

#[test]
fn every_run_has_a_row_with_its_reason() {
    let study = parse_study(MIXED);
    let table = run_study(&study);
    let counts = summary(&table).expect("results of a sweep");
    let [completed, refused, failed] =
        [Status::Completed, Status::Refused, Status::Failed].map(|status| counts.count_with_status(status));
    assert!(refused >= 30 && failed > 0, "{counts:?}");
    assert_eq!((table.rows.len(), counts.by_status.iter().map(|(_, count)| count).sum::<u64>()), (54, 54));
    assert_eq!(counts.by_class.iter().map(|(_, count)| count).sum::<u64>(), completed);
    assert_eq!(counts.reasons.iter().map(|reason| reason.runs).sum::<u64>(), 54 - completed);

    let (status, reason) = (table.texts("status").expect("texts"), table.texts("reason").expect("texts"));
    let masses = table.numbers("mass_kg").expect("numbers");
    for (index, (status, reason)) in status.iter().zip(&reason).enumerate() {
        match (status.expect("every row has a status"), *reason) {
            ("completed", None) => {}
            ("refused", Some(reason)) => {
                let error = scene::parse(&study.scene_text(index as u64 + 1), "x.toml").expect_err("refused");
                assert!(error.problems().iter().all(|problem| reason.contains(problem.message.trim())), "{reason}");
                assert_eq!(masses[index], None);
            }
            ("failed", Some(reason)) => {
                assert!(reason.starts_with("at ") && reason.contains(" ms: "), "{reason}");
                assert!(masses[index].is_some());
            }
            other => panic!("{other:?}"),
        }
    }
    for words in ["mu_static` is -0.5", "l21_fraction` is 1.5", "budget of 120 steps"] {
        assert!(reason.iter().flatten().any(|reason| reason.contains(words)), "{words}");
    }
}

#[test]
fn results_are_independent_of_threads_and_order() {
    let study = parse_study(MIXED);
    let single_threaded = table(&study, &run_rows(&study, 1, &HashSet::new()));
    for threads in [2, 3, 8] {
        assert_eq!(table(&study, &run_rows(&study, threads, &HashSet::new())), single_threaded);
    }
    // Odd and even runs separately.
    let odd: HashSet<u64> = (1..=study.runs()).filter(|run| run % 2 == 1).collect();
    let even = run_rows(&study, 2, &odd);
    let done = even.iter().map(|row| row.run).collect();
    assert_eq!(table(&study, &[even, run_rows(&study, 2, &done)].concat()), single_threaded);

    // Runs stop on request.
    let run = |threads, last, keep_running: bool, max_rows: u64| {
        let mut rows = 0;
        run_while(&study, threads, 1..=last, &HashSet::new(), &|| keep_running, |_| {
            rows += 1;
            rows < max_rows
        })
    };
    let stats = run(2, u64::MAX, true, 10);
    assert!(!stats.complete && (10..=12).contains(&stats.runs), "{stats:?}");
    let stats = run(2, 7, true, u64::MAX);
    assert!(stats.complete && stats.runs == 7);
    let stats = run(1, u64::MAX, false, u64::MAX);
    assert!(!stats.complete && stats.runs == 0);
}

#[test]
fn a_filter_excludes_designs_from_simulation() {
    let with_filter = |filter: &str| {
        let text =
            include_str!("../../scenes/studies/thesis.toml").replace("from = 0\nto = 1\ncount = 4", "values = [1.0]");
        run_study(&parse_study(&format!("{text}\n[filter]\n{filter}\n")))
    };
    let table = with_filter("force_positive = true\nform_closed = true");
    let texts = |name: &str| table.texts(name).expect("texts");
    let (status, reason, classes) = (texts("status"), texts("reason"), texts("class"));
    let flags = ["force_positive", "form_closed"].map(|name| table.flags(name).expect(name));
    let steps = table.integers("steps").expect("integers");
    let mut filtered = 0;
    for index in 0..table.rows.len() {
        let accepted = flags.iter().all(|flags| flags[index] == Some(true));
        assert_eq!(status[index] == Some("filtered"), !accepted);
        assert_eq!(steps[index].is_none() && classes[index].is_none(), !accepted);
        assert!(accepted || matches!(reason[index], Some("not force positive" | "not form-closed")));
        filtered += usize::from(!accepted);
    }
    assert!(filtered > 20 && filtered < 96, "{filtered}");
    let open_only = with_filter("form_closed = false");
    let closed = open_only.flags("form_closed").expect("flags");
    let status = open_only.texts("status").expect("texts");
    assert!((0..96).all(|index| (status[index] == Some("filtered")) == (closed[index] == Some(true))));
}

#[test]
fn engine_and_analytic_model_agree() {
    let mut study = parse_study(
        "scene = \"../experiment-95.toml\"\n[[axes]]\nfield = \"contact.friction.mu_static\"\nvalues = [0.0, 0.8]\n[[axes]]\nfield = \
         \"design.base\"\nvalues = [\"15.5 mm\", \"15 mm\"]\n",
    );
    let analytic = run_study(&study);
    study.model = Model::Engine;
    let engine = run_study(&study);
    assert_eq!(engine, table(&study, &run_rows(&study, 1, &HashSet::new())), "results depend on the number of threads");
    for (name, tolerance) in [("tts_s", 1e-3), ("f21_n", 1e-4), ("f22_n", 1e-4), ("pfp_n", 1e-3), ("static_f21_n", 0.0)]
    {
        let [a, b] = [&analytic, &engine].map(|table| table.numbers(name).expect(name));
        for (a, b) in a.into_iter().zip(b) {
            let (a, b) = (a.expect("a figure"), b.expect("a figure"));
            assert!((a - b).abs() <= tolerance * a.abs(), "{name}: {a} and {b}");
        }
    }
    assert_eq!(analytic.texts("class").expect("texts"), engine.texts("class").expect("texts"));
    assert_ne!(analytic.integers("steps").expect("integers"), engine.integers("steps").expect("integers"));
}

#[test]
fn a_scene_without_an_object_has_a_row_without_a_grasp() {
    let table = run_study(&parse_study(
        "scene = \"../free-swing.toml\"\n[[axes]]\nfield = \"duration\"\nvalues = [\"1 ms\", \"2 ms\"]\n",
    ));
    let texts = |name: &str| table.texts(name).expect("texts");
    assert_eq!((texts("status"), texts("class")), (vec![Some("completed"); 2], vec![None; 2]));
    for name in ["static_f21_n", "tts_s", "f21_n", "pfp_n", "trajectory_rad"] {
        assert_eq!(table.numbers(name).expect(name), [None; 2], "{name}");
    }
    assert_eq!(texts("reason"), [Some("there is no object"); 2]);
    assert_eq!(summary(&table).expect("results of a sweep").no_class, 2);
    assert!(table.integers("steps").expect("integers").iter().all(|steps| steps.is_some_and(|steps| steps > 0)));
}

/// Asserts that every row has a verdict or a reason, and that only completed rows have a verdict. Returns the numbers
/// of rows with and without a verdict.
fn assert_verdict_or_reason(study: &Study, table: &Table, verdict: &str) -> [usize; 2] {
    let texts = |name: &str| table.texts(name).unwrap_or_else(|error| panic!("{name}: {error}"));
    let (status, reason, verdicts) = (texts("status"), texts("reason"), texts(verdict));
    for (index, verdict) in verdicts.iter().enumerate() {
        let describe = || format!("run {}:\n{}", index + 1, study.scene_text(index as u64 + 1));
        assert!(verdict.is_some() || reason[index].is_some(), "neither verdict nor reason in {}", describe());
        let may_have_verdict = status[index] == Some("completed");
        assert!(verdict.is_none() || may_have_verdict, "a verdict of an incomplete run: {}", describe());
    }
    let with_verdict = verdicts.iter().flatten().count();
    [with_verdict, verdicts.len() - with_verdict]
}

/// An axis over a range.
fn axis(field: &str, from: &str, to: &str, more: &str) -> String {
    let value = |text: &str| if text.contains(' ') { format!("\"{text}\"") } else { text.to_string() };
    format!("[[axes]]\nfield = \"{field}\"\nfrom = {}\nto = {}\n{more}\n", value(from), value(to))
}

/// Designs whose distal phalanx is too short, too long or too weak for the object.
fn short_phalanx_study() -> String {
    let scene = "name = \"short\"\n[scene]\nduration = \"40 ms\"\n\
                 lengths = { l11 = \"20 mm\", l21 = \"31 mm\", l22 = \"10 mm\", t22 = \"16 mm\", phi22 = \"115 deg\" }\n\
                 object = { radius = \"25 mm\", centre = [\"-21 mm\", \"25 mm\"] }\nmotor.torque = \"600 N*mm\"\n\
                 spring = { type = \"torsional\", preload = \"110 deg\", stiffness = \"60 N*mm/rad\" }\n\
                 contact.friction.mu_static = 0.5\n";
    let stiffness = axis("spring.stiffness", "20 N*mm/rad", "100 N*mm/rad", "count = 5");
    format!("{scene}{stiffness}{}", axis("lengths.t22", "8 mm", "26 mm", "count = 19"))
}

#[test]
fn designs_that_cannot_grasp_have_a_reason_and_are_counted() {
    let study = parse_study(&short_phalanx_study());
    let table = run_study(&study);
    let [with_verdict, without_verdict] = assert_verdict_or_reason(&study, &table, "class");
    assert_eq!((with_verdict, without_verdict), (65, 30));
    let (status, reason) = (table.texts("status").expect("texts"), table.texts("reason").expect("texts"));
    let (class, class_reason) = (table.texts("class").expect("texts"), table.texts("class_reason").expect("texts"));
    for (index, (class, class_reason)) in class.iter().zip(&class_reason).enumerate() {
        assert_eq!(class.is_some(), class_reason.is_some());
        let scene = scene::parse(&study.scene_text(index as u64 + 1), "run.toml").expect("a scene");
        let grasp = static_grasp(&scene, scene.object().expect("an object"));
        if status[index] == Some("completed") {
            // The reason is the same as in the report of a single run.
            assert_eq!(grasp.err().map(|error| error.to_string()).as_deref(), reason[index]);
        }
    }
    let counts = summary(&table).expect("results of a sweep");
    assert_eq!(counts.no_class, 26);
    let top_reason = &counts.reasons[0];
    assert_eq!((top_reason.status.as_str(), top_reason.runs, top_reason.first_run), ("completed", 26, 5));
    assert_contains(&top_reason.reason, &["the distal phalanx does not reach its contact: it is 12.0000 mm long"]);

    let selection = select(&table, &SelectionCriteria { form_closed: false, ..SelectionCriteria::default() });
    let selection = selection.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((selection.ranking.len(), selection.cannot_grasp[0].runs), (60, 26));
    let text = SelectionReport::new("short.csv", &selection, 3).report().to_string();
    assert_contains(&text, &["26 rows cannot grasp, first run 5: the distal phalanx does not reach its contact"]);
}

const LOG: &str = "spacing = \"log\"";

/// Wide ranges: most designs are refused, fail, cannot grasp, or have no valid statics.
fn wide_finger_study() -> String {
    let centres = "[[axes]]\nfield = \"object.centre\"\nvalues = [[\"-15.5 mm\", \"20 mm\"], [\"-40 mm\", \"10 mm\"], \
                   [\"-21 mm\", \"25 mm\"]]\n";
    let axes = [
        axis("lengths.l11", "4 mm", "40 mm", ""),
        axis("lengths.l21", "5 mm", "60 mm", ""),
        axis("lengths.l22", "2 mm", "30 mm", ""),
        axis("lengths.t22", "1 mm", "60 mm", ""),
        axis("lengths.phi22", "30 deg", "175 deg", ""),
        axis("object.radius", "1 mm", "60 mm", ""),
        centres.to_string(),
        axis("spring.torque", "1 N*mm", "1000 N*mm", LOG),
        axis("motor.torque", "1 N*mm", "5000 N*mm", LOG),
        axis("contact.friction.mu_static", "0", "2", ""),
    ];
    let scene = "[scene]\nduration = \"15 ms\"\nintegrator.max_steps = 600\nlengths = {}\nobject = {}\nspring = {}\nmotor = {}\n";
    format!("{scene}{}[sample]\ncount = 250\nseed = 7\n", axes.concat())
}

fn wide_gripper_study() -> String {
    let axes = [
        axis("design.base", "10 mm", "24 mm", ""),
        axis("object.radius", "14 mm", "22 mm", ""),
        axis("object.offset", "-6 mm", "6 mm", ""),
        axis("motor.torque", "1 N*mm", "5000 N*mm", LOG),
    ];
    let scene = "scene = \"../gripper/design-95.toml\"\nset = { duration = \"10 ms\", integrator.max_steps = 400 }\n";
    format!("{scene}{}[sample]\ncount = 60\nseed = 7\n", axes.concat())
}

#[test]
fn every_row_has_a_verdict_or_a_reason() {
    for (text, verdict) in [(wide_finger_study(), "class"), (wide_gripper_study(), "grasp")] {
        let study = parse_study(&text);
        let table = run_study(&study);
        let [with_verdict, without_verdict] = assert_verdict_or_reason(&study, &table, verdict);
        let counts = summary(&table).expect("results of a sweep");
        assert!(with_verdict > 10 && without_verdict > 10, "{with_verdict} {without_verdict}: {counts:?}");
        assert_eq!(counts.by_class.iter().map(|(_, count)| count).sum::<u64>(), with_verdict as u64);
        if verdict == "class" {
            assert!(counts.no_class > 10, "{counts:?}");
            // A selection accepts rows with missing figures.
            select(&table, &SelectionCriteria::default()).unwrap_or_else(|error| panic!("{error}"));
        }
    }
}

/// A study built in memory has the runs of a study file with the same rows, and reads values as in a scene.
#[test]
fn in_memory_rows_equal_rows_of_a_study_file() {
    let layers = scene::load_layers("scenes/experiment-95.toml".as_ref()).expect("a shipped scene");
    let study = |fields: &[&str]| in_memory_study(&layers, &[], fields, Model::Analytic);
    let empty = study(&["design.base", "contact.friction.mu_static"]).expect("fields of a scene");
    assert_eq!(empty.runs(), 0);
    let row = |row: [f64; 2]| {
        let values = empty.row_fields().iter().zip(row);
        values.map(|(field, si)| field.value_of_si(si).expect("a number")).collect::<Vec<AxisValue>>()
    };
    let rows = [[0.012, 0.0], [0.0145, 0.6], [0.5, 0.3]].map(row).to_vec();
    let in_memory = run_study(&empty.clone().with_rows(rows));
    let file = parse_study(
        "scene = \"../experiment-95.toml\"\n[[axes]]\nfields = [\"design.base\", \"contact.friction.mu_static\"]\n\
         rows = [[\"0.012 m\", 0.0], [\"0.0145 m\", 0.6], [\"0.5 m\", 0.3]]\n",
    );
    assert_eq!(in_memory, run_study(&file));
    // The finger cannot close with a base of 0.5 m.
    assert_eq!(in_memory.texts("status").expect("texts"), [Some("completed"), Some("completed"), Some("refused")]);

    for (fields, words) in [
        (&["design.bse"][..], "unknown key `bse` in [design]\n  = help: did you mean `base`?; keys in"),
        (&["design"], "is a table of a scene"),
        (&["design.base", "design.base"], "given twice"),
    ] {
        assert_contains(&study(fields).expect_err(words).to_string(), &[words]);
    }
    let study = study(&["design.base", "palm"]).expect("fields of a scene");
    let [base, palm] = study.row_fields() else { panic!("two fields") };
    assert_eq!(base.parse_toml("\"12 mm\"").expect("a length").value, base.value_of_si(0.012).expect("a length").value);
    assert_contains(&base.parse_toml("\"12 kg\"").expect_err("not a length"), &["kg"]);
    assert!(base.parse_toml("12 mm").is_err(), "a quantity requires quotes");
    assert!(base.value_of_si(f64::NAN).is_none() && palm.value_of_si(1.0).is_none(), "not numeric");
}
