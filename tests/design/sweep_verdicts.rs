//! Every row of a sweep has a verdict or a reason for any design.

use phalanx::criteria::static_grasp;
use phalanx::format::ToReport;
use phalanx::report::sweep::SelectionReport;
use phalanx::scene;
use phalanx::study::select::{SelectionCriteria, select};
use phalanx::study::sweep::{Study, summary};
use phalanx::table::Table;

use crate::support::cli::assert_contains;
use crate::support::studies::{parse_study, run_study};

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
