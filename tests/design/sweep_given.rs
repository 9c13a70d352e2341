//! Studies of rows that a program has: the same runs as those of a study file with the same rows.

use std::collections::HashSet;

use phalanx::scene::layers;
use phalanx::study::sweep::{GivenError, Point, Row, Status, given, parse, run};
use phalanx::trace::Model;

const SCENE: &str = "scenes/experiment-95.toml";
const FIELDS: [&str; 2] = ["design.base", "contact.friction.mu_static"];

fn rows(study: &phalanx::study::sweep::Study) -> Vec<Row> {
    let mut rows = Vec::new();
    run(study, 2, &HashSet::new(), |row| rows.push(row));
    rows.sort_by_key(|row| row.run);
    rows
}

fn layers_of_95() -> Vec<phalanx::scene::Layer> {
    layers(SCENE.as_ref()).expect("a shipped scene")
}

#[test]
fn rows_of_a_program_run_as_those_of_a_file() {
    let empty = given(&layers_of_95(), &[], &FIELDS, Model::Analytic).expect("fields of a scene");
    assert_eq!(empty.runs(), 0);
    let numbers = [[0.012, 0.0], [0.0145, 0.6], [0.5, 0.3]];
    let point = |(at, si): (usize, &f64)| empty.row_fields()[at].at(*si).expect("a number");
    let points: Vec<Vec<Point>> = numbers.iter().map(|row| row.iter().enumerate().map(point).collect()).collect();
    let ours = rows(&empty.with_rows(points));
    let file = parse(
        "scene = \"experiment-95.toml\"\n[[axes]]\nfields = [\"design.base\", \"contact.friction.mu_static\"]\n\
         rows = [[\"0.012 m\", 0.0], [\"0.0145 m\", 0.6], [\"0.5 m\", 0.3]]\n",
        "scenes/rows.toml",
    );
    let theirs = rows(&file.expect("a study"));
    assert_eq!(ours, theirs);
    assert_eq!(ours.len(), 3);
    assert_eq!(ours[0].status, Status::Completed);
    assert_eq!(ours[2].status, Status::Refused, "a base of half a metre closes on nothing");
}

#[test]
fn what_is_no_field_is_said() {
    let refused = |fields: &[&str]| match given(&layers_of_95(), &[], fields, Model::Analytic) {
        Err(GivenError::Field { message, help }) => format!("{message}; {help}"),
        other => panic!("{other:?}"),
    };
    assert!(refused(&["design.bse"]).starts_with("unknown key `bse` in [design]; did you mean `base`?; keys in"));
    assert!(refused(&["design"]).contains("is a table of a scene"));
    assert!(refused(&["design.base", "design.base"]).contains("there twice"));
}

#[test]
fn values_are_read_as_in_a_scene() {
    let study = given(&layers_of_95(), &[], &["design.base", "palm", "integrator.rtol"], Model::Analytic);
    let study = study.expect("fields of a scene");
    let [base, palm, _] = study.row_fields() else { panic!("three fields") };
    assert_eq!(base.parsed("\"12 mm\"").expect("a length").value, base.at(0.012).expect("a length").value);
    assert!(base.parsed("\"12 kg\"").expect_err("no length").contains("kg"));
    assert!(base.parsed("12 mm").is_err(), "a quantity has quotes");
    assert!(base.at(f64::NAN).is_none());
    assert!(palm.at(1.0).is_none(), "no number");
}
