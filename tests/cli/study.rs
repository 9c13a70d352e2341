//! `phalanx study`: files and errors.

use std::fs;

use serde_json::Value;

use crate::support::cli::{
    EXPERIMENT_95, assert_rejected, directory, path_text, succeed, succeed_json, variant, write,
};

#[test]
fn command_writes_its_files() {
    let out = directory("study_stability");
    let args = "study stability scenes/experiment-95.toml --stiffness 1 --damping 1 --steps";
    let args = [&args.split(' ').collect::<Vec<_>>()[..], &["100 us,1 ms"]].concat();
    let output = succeed(&[&args[..], &["--out", path_text(&out)]].concat());
    let read = |name: &str| fs::read_to_string(out.join(name)).expect(name);
    assert_eq!(read("table.txt"), format!("Report by phalanx\n\n{output}"));
    let document: Value = serde_json::from_str(&read("stability.json")).expect("JSON");
    assert_eq!(document["grid"]["steps_s"], serde_json::json!([1e-3, 1e-4]));
    assert_eq!(read("stability.csv").lines().count(), 3);
    assert!(read("stability.svg").starts_with("<svg"));
    // A stricter bound changes the verdict.
    let strict = succeed_json(&[&args[..], &["--accurate", "1e-6 rad"]].concat());
    assert_eq!(strict["cells"][1]["verdict"], "inaccurate");
    assert_eq!(document["cells"][1]["verdict"], "accurate");
}

#[test]
fn rejects_unsuitable_scenes_and_grids() {
    let directory = directory("study_stability_refused");
    let rigid = variant(&directory, "rigid.toml", "[engine]\nlaw = \"rapier\"\nstepping = \"fixed\"\nstep = \"10 us\"");
    let anchor = fs::read_to_string(EXPERIMENT_95).expect("the reference scene");
    let undamped =
        anchor.replace("[contact.friction]", "[contact]\nstiffness_si = 0\nexponent = 2.2\n[contact.friction]");
    let undamped = write(&directory, "undamped.toml", &undamped);
    let cases: [(&[&str], &str); 13] = [
        (&["scenes/laws/step-size.toml"], "scene of discs"),
        (&["scenes/gripper/design-95.toml"], "scene of a gripper"),
        (&["scenes/free-swing.toml"], "has no contacts"),
        (&[&rigid], "rapier's own contact"),
        (&[&undamped, "--damping", "0"], "one of them above 0"),
        (&[EXPERIMENT_95, "--steps", "1e-3"], "no unit"),
        (&[EXPERIMENT_95, "--steps", "20 ms"], "not shorter than the run"),
        (&[EXPERIMENT_95, "--steps", "1e-300 s"], "takes more than 10000000 steps; use longer steps"),
        (&[EXPERIMENT_95, "--stiffness", "0,1"], "above 0"),
        (&[EXPERIMENT_95, "--stiffness", "1e301"], "must be finite"),
        (&[EXPERIMENT_95, "--damping=-1"], "0 or more"),
        (&[EXPERIMENT_95, "--damping", "1,1"], "twice"),
        (&[EXPERIMENT_95, "--accurate", "0 rad"], "more than 0"),
    ];
    for (args, message) in cases {
        assert_rejected(&[&["study", "stability"], args].concat(), &[message]);
    }
}
