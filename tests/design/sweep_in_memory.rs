//! Studies built in memory: their runs equal those of a study file with the same rows.

use phalanx::scene::load_layers;
use phalanx::study::sweep::{AxisValue, InMemoryStudyError, in_memory_study};
use phalanx::trace::Model;

use crate::support::studies::{parse_study, run_study};

const SCENE: &str = "scenes/experiment-95.toml";
const FIELDS: [&str; 2] = ["design.base", "contact.friction.mu_static"];

fn design_95_layers() -> Vec<phalanx::scene::Layer> {
    load_layers(SCENE.as_ref()).expect("a shipped scene")
}

#[test]
fn in_memory_rows_equal_rows_of_a_study_file() {
    let empty = in_memory_study(&design_95_layers(), &[], &FIELDS, Model::Analytic).expect("fields of a scene");
    assert_eq!(empty.runs(), 0);
    let numbers = [[0.012, 0.0], [0.0145, 0.6], [0.5, 0.3]];
    let to_value = |(field, si): (usize, &f64)| empty.row_fields()[field].value_of_si(*si).expect("a number");
    let values: Vec<Vec<AxisValue>> =
        numbers.iter().map(|row| row.iter().enumerate().map(to_value).collect()).collect();
    let in_memory = run_study(&empty.with_rows(values));
    let file = parse_study(
        "scene = \"../experiment-95.toml\"\n[[axes]]\nfields = [\"design.base\", \"contact.friction.mu_static\"]\n\
         rows = [[\"0.012 m\", 0.0], [\"0.0145 m\", 0.6], [\"0.5 m\", 0.3]]\n",
    );
    assert_eq!(in_memory, run_study(&file));
    let status = in_memory.texts("status").expect("texts");
    // The finger cannot close with a base of 0.5 m.
    assert_eq!(status, [Some("completed"), Some("completed"), Some("refused")]);
}

#[test]
fn rejects_invalid_fields() {
    let rejection = |fields: &[&str]| match in_memory_study(&design_95_layers(), &[], fields, Model::Analytic) {
        Err(InMemoryStudyError::Field { message, help }) => format!("{message}; {help}"),
        other => panic!("{other:?}"),
    };
    assert!(rejection(&["design.bse"]).starts_with("unknown key `bse` in [design]; did you mean `base`?; keys in"));
    assert!(rejection(&["design"]).contains("is a table of a scene"));
    assert!(rejection(&["design.base", "design.base"]).contains("given twice"));
}

#[test]
fn parses_values_as_in_a_scene() {
    let study = in_memory_study(&design_95_layers(), &[], &["design.base", "palm", "integrator.rtol"], Model::Analytic);
    let study = study.expect("fields of a scene");
    let [base, palm, _] = study.row_fields() else { panic!("three fields") };
    assert_eq!(base.parse_toml("\"12 mm\"").expect("a length").value, base.value_of_si(0.012).expect("a length").value);
    assert!(base.parse_toml("\"12 kg\"").expect_err("not a length").contains("kg"));
    assert!(base.parse_toml("12 mm").is_err(), "a quantity requires quotes");
    assert!(base.value_of_si(f64::NAN).is_none());
    assert!(palm.value_of_si(1.0).is_none(), "not a numeric field");
}
