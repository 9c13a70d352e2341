//! Studies of scenes of any kind: their columns, which follow from the criteria and the schema, equal those of single runs.

use phalanx::criteria::{Margin, ObjectTracker, firmness};
use phalanx::plot::map;
use phalanx::scene::{self, Scene};
use phalanx::study::sweep::{Study, StudyError, columns, parse, summary};
use phalanx::table::{Kind, Table, Value};
use phalanx::trace::{RequiredData, Sample, Schema, Sink, SinkError, run_analytic};

use crate::support::cli::assert_contains;
use crate::support::studies::{parse_study, run_study};

/// A gripper whose object is gripped, and one with too little friction.
const PADS: &str = r#"
scene = "../mechanisms/two-pivot.toml"
[[axes]]
field = "bodies.object.mass"
values = ["20 g", "60 g"]
[[axes]]
field = "laws.rubber.friction.mu_static"
values = [0.3, 0.6]
"#;

fn names(study: &Study) -> Vec<String> {
    columns(study).into_iter().map(|column| column.name).collect()
}

fn cell<'a>(table: &'a Table, row: usize, name: &str) -> &'a Value {
    let index =
        table.columns.iter().position(|column| column.name == name).unwrap_or_else(|| panic!("no column {name}"));
    &table.rows[row][index]
}

fn number(table: &Table, row: usize, name: &str) -> f64 {
    cell(table, row, name).as_number().unwrap_or_else(|| panic!("{name}: {:?}", cell(table, row, name)))
}

fn scene_of(study: &Study, run: u64) -> Scene {
    scene::parse_any(&study.scene_text(run), "run.toml").unwrap_or_else(|error| panic!("{error}"))
}

fn message(text: &str) -> String {
    let error: StudyError = parse(text, "scenes/studies/study.toml").expect_err(text);
    error.to_string()
}

#[test]
fn rows_of_a_grasp_equal_single_runs() {
    let study = parse_study(PADS);
    let table = run_study(&study);
    assert_eq!(table.rows.len(), 4);
    for row in 0..4 {
        let scene = scene_of(&study, row as u64 + 1);
        let mut tracker = ObjectTracker::for_scene(&scene).expect("a grasp");
        let outcome = run_analytic(&scene, &mut tracker).expect("completes");
        let grasp = tracker.criteria().expect("a duration");
        assert_eq!(cell(&table, row, "status"), &Value::from("completed"));
        assert_eq!(cell(&table, row, "fate"), &Value::from(grasp.fate.name()));
        assert_eq!(cell(&table, row, "fate_reason"), &Value::from(grasp.reason.as_str()));
        assert_eq!(number(&table, row, "tts_s"), grasp.tts_s.expect("held"));
        assert_eq!(number(&table, row, "grip_n"), grasp.grip_n());
        let Margin::Limited { acceleration_m_s2, .. } = firmness(&scene, &grasp).expect("held").driven else {
            panic!("the margin is limited")
        };
        assert_eq!(number(&table, row, "margin_m_s2"), acceleration_m_s2);
        for pair in &grasp.pairs {
            let normal_n = number(&table, row, &format!("{}_normal_n", pair.name));
            assert!((normal_n - pair.normal_n).abs() <= 1e-12 * pair.normal_n.abs(), "{}: {normal_n}", pair.name);
            let first_s = cell(&table, row, &format!("{}_first_s", pair.name)).as_number();
            assert_eq!(first_s.is_some(), pair.first_s.is_some(), "{}", pair.name);
        }
        // The final state by the names of channels.
        for channel in
            Schema::from_scene(&scene).channels().iter().filter(|channel| channel.name.starts_with("object_"))
        {
            assert_eq!(number(&table, row, &channel.name), channel.value(&outcome.last), "{}", channel.name);
        }
        let motor = grasp.actuators.iter().find(|actuator| actuator.name == "motor").expect("a motor");
        assert_eq!(number(&table, row, "motor_largest_n_m"), motor.largest_effort);
        assert_eq!(number(&table, row, "motor_energy_j"), motor.energy_j);
    }
    let counts = summary(&table).expect("results of a sweep");
    assert_eq!(counts.by_class.get("held"), Some(&4), "{counts:?}");
    assert_eq!(counts.no_class, 0);
}

/// Heights of the object at the ends of the steps.
#[derive(Default)]
struct Heights(Vec<f64>);

impl Sink for Heights {
    fn required_data(&self) -> RequiredData {
        RequiredData { grid: false, ..RequiredData::ALL }
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0.push(sample.body(0).centre_m[1]);
        Ok(())
    }
}

#[test]
fn a_study_selects_columns_and_adds_extrema() {
    let text = "[scene]\nkind = \"bodies\"\nduration = \"200 ms\"\ngravity = [\"0 m/s^2\", \"-9.81 m/s^2\"]\n[scene.discs.ball]\nradius = \
                \"10 mm\"\nmass = \"10 g\"\ncentre = [\"0 mm\", \"30 mm\"]\n[scene.discs.floor]\nradius = \"50 mm\"\nmotion = \
                \"fixed\"\ncentre = [\"0 mm\", \"-50 mm\"]\n[[axes]]\nfield = \"gravity\"\nvalues = [[\"0 m/s^2\", \"-9.81 m/s^2\"], \
                [\"0 m/s^2\", \"-3 m/s^2\"]]\n[results]\ncolumns = [\"ball_vy_m_s\"]\nextrema = [\"ball_y_m\"]\n";
    let study = parse_study(text);
    let expected =
        "run design gravity status reason ball_vy_m_s least_ball_y_m largest_ball_y_m steps check check_error_rad";
    assert_eq!(names(&study).join(" "), expected);
    let table = run_study(&study);
    for row in 0..2 {
        let mut heights = Heights::default();
        run_analytic(&scene_of(&study, row as u64 + 1), &mut heights).expect("completes");
        let least = heights.0.iter().copied().fold(f64::INFINITY, f64::min);
        // The lowest point is that of the largest depth, within a step.
        let found = number(&table, row, "least_ball_y_m");
        assert!(found <= least && found > least - 1e-4, "{found} {least}");
        assert_eq!(number(&table, row, "largest_ball_y_m"), 0.03);
    }
    // No class and no fate: nothing is counted as without one.
    let counts = summary(&table).expect("results of a sweep");
    assert!(counts.by_class.iter().next().is_none() && counts.no_class == 0, "{counts:?}");
}

#[test]
fn columns_of_fingers_can_be_selected() {
    let text =
        "scene = \"../experiment-95.toml\"\n[results]\ncolumns = [\"tts_s\", \"class\"]\nextrema = [\"q11_rad\"]\n";
    let study = parse_study(text);
    assert_eq!(
        names(&study).join(" "),
        "run design status reason tts_s class steps check check_error_rad least_q11_rad largest_q11_rad"
    );
    let table = run_study(&study);
    let whole = run_study(&parse_study("scene = \"../experiment-95.toml\"\n"));
    for name in ["tts_s", "class", "status", "steps"] {
        assert_eq!(cell(&table, 0, name), cell(&whole, 0, name), "{name}");
    }
    assert!(number(&table, 0, "least_q11_rad") < number(&table, 0, "largest_q11_rad"));
}

#[test]
fn an_axis_with_the_name_of_a_result_replaces_it() {
    let text = "scene = \"../gripper/design-95.toml\"\n[set]\nduration = \"1 ms\"\n[[axes]]\nfield = \"palm_width\"\nvalues = [\"31 mm\", \
                \"32 mm\"]\n";
    let study = parse_study(text);
    let names = names(&study);
    assert_eq!(names.iter().filter(|name| *name == "palm_width_m").count(), 1, "{names:?}");
    let table = run_study(&study);
    assert_eq!([0, 1].map(|row| number(&table, row, "palm_width_m")), [0.031, 0.032]);
    assert_eq!(columns(&study)[2].kind, Kind::Number);
}

#[test]
fn an_outlined_object_makes_the_columns_of_a_mechanism() {
    let text = "scene = \"../gripper/hold.toml\"\n[set]\nduration = \"20 ms\"\nobject.outline = { type = \"disc\", radius = \"20 mm\" }\n";
    let study = parse_study(text);
    let names = names(&study);
    assert!(names.iter().any(|name| name == "fate") && names.iter().any(|name| name == "object_x_m"), "{names:?}");
    let table = run_study(&study);
    assert_eq!(cell(&table, 0, "status"), &Value::from("completed"), "{:?}", cell(&table, 0, "reason"));
    assert_eq!(cell(&table, 0, "fate"), &Value::from("held"));
}

#[test]
fn problems_of_results_and_scenes_name_the_remedy() {
    let unknown = message(&format!("{PADS}[results]\ncolumns = [\"fate\", \"grip\"]\n"));
    assert_contains(&unknown, &["`grip` is no figure of this study", "did you mean `grip_n`?", "study.toml:10"]);
    let unknown = message(&format!("{PADS}[results]\nextrema = [\"object_z_m\"]\n"));
    assert_contains(
        &unknown,
        &[
            "`object_z_m` is no channel of this study",
            "did you mean `object_x_m`?",
            "time_s, left_driver_rad",
            "and 146 more",
        ],
    );
    let filter = message(&format!("{PADS}[filter]\nform_closed = true\n"));
    assert_contains(&filter, &["base scene is of kind \"mechanism\"", "remove it"]);
    let broken = message(&PADS.replace("laws.rubber.friction.mu_static", "laws.tyre.friction.mu_static"));
    assert_contains(&broken, &["none of the first scenes of the study is valid", "`laws.tyre.stiffness` is missing"]);
}

#[test]
fn a_run_with_other_parts_is_refused_in_its_row() {
    let text = "scene = \"../gripper/hold.toml\"\n[set]\nduration = \"1 ms\"\nobject.outline = { type = \"disc\", radius = \"20 mm\" \
                }\n[[axes]]\nfield = \"object.motion\"\nvalues = [\"free\", \"fixed\"]\n";
    let table = run_study(&parse_study(text));
    assert_eq!(cell(&table, 0, "status"), &Value::from("completed"));
    assert_eq!(cell(&table, 1, "status"), &Value::from("refused"));
    let reason = cell(&table, 1, "reason").as_text().expect("a reason");
    assert_contains(reason, &["other bodies, joints, actuators or contacts", "a study of its own"]);
}

#[test]
fn a_map_shows_verdicts_and_margins_over_two_axes() {
    let study = parse_study(PADS);
    let table = run_study(&study);
    let picture = map(&study, &table).unwrap_or_else(|error| panic!("{error}"));
    assert_contains(
        &picture,
        &[">mu_static<", ">mass, g<", ">held<", "margin, m/s²: ", ">20<", ">60<", ">0.3<", ">0.6<"],
    );
    // Four runs of one fate are one path; its colour is also that of the key.
    assert!(!picture.contains(">dropped<"), "only fates that occur are in the key");
    // Without a margin, the time to stability is the figure.
    let text = format!("{PADS}[results]\ncolumns = [\"fate\", \"tts_s\"]\n");
    let study = parse_study(&text);
    let picture = map(&study, &run_study(&study)).unwrap_or_else(|error| panic!("{error}"));
    assert_contains(&picture, &["tts, ms: ", ">held<"]);
}

#[test]
fn a_study_without_a_map_says_why() {
    let map_of = |text: &str| {
        let study = parse_study(text);
        map(&study, &run_study(&study)).expect_err(text)
    };
    let short = "scene = \"../mechanisms/two-pivot.toml\"\n[set]\nduration = \"1 ms\"\n";
    let masses = "[[axes]]\nfield = \"bodies.object.mass\"\nvalues = [\"20 g\", \"60 g\"]\n";
    assert_contains(&map_of(&format!("{short}{masses}")), &["needs two axes", "has 1"]);
    let sampled = "[[axes]]\nfield = \"laws.rubber.friction.mu_static\"\nfrom = 0.1\nto = 0.9\n[sample]\ncount = 2\n";
    assert_contains(&map_of(&format!("{short}{masses}{sampled}")), &["[sample] takes points between them"]);
    let friction =
        "[[axes]]\nfield = \"laws.rubber.friction.mu_static\"\nvalues = [0.1, 0.2]\n[results]\ncolumns = [\"tts_s\"]\n";
    assert_contains(&map_of(&format!("{short}{masses}{friction}")), &["no fate and no class"]);
}

/// The scene of a run, without what depends on how its study is written.
fn resolved(study: &Study, run: u64) -> String {
    scene::show(&scene_of(study, run))
}

#[test]
fn a_study_defines_parameters() {
    let set = "scene = \"../mechanisms/two-pivot.toml\"\n[set]\nduration = \"20 ms\"\n";
    let by_fields = parse_study(&format!(
        "{set}[[axes]]\nfields = [\"laws.rubber.friction.mu_static\", \"bodies.object.start.at[0]\", \
         \"bodies.object.mass\"]\nrows = [[0.3, \"2 mm\", \"60 g\"], [0.5, \"2 mm\", \"100 g\"]]\n"
    ));
    let by_parameters = parse_study(&format!(
        "{set}bodies.object.mass = \"= mass\"\nbodies.object.start.at = [\"= offset\", \"120 mm\"]\n\
         laws.rubber.friction.mu_static = \"= mu\"\n[set.parameters]\nmu = 0.4\nmass = \"= 200 g * mu\"\noffset = \"2 mm\"\n\
         [[axes]]\nfields = [\"parameters.mu\", \"parameters.mass\"]\nrows = [[0.3, \"60 g\"], [0.5, \"100 g\"]]\n"
    ));
    for run in 1..=2 {
        assert_eq!(resolved(&by_parameters, run), resolved(&by_fields, run));
    }
    let axis = "[[axes]]\nfield = \"parameters.mu\"\nvalues = [0.3, 0.5]\n";
    let derived = parse_study(&format!(
        "{set}bodies.object.mass = \"= mass\"\n[set.parameters]\nmu = 0.4\nmass = \"= 200 g * mu\"\n{axis}"
    ));
    assert_eq!(names(&derived)[2], "parameters.mu");
    let masses = [1, 2].map(|run| scene_of(&derived, run).mechanism.expect("a mechanism").bodies[0].mass_kg);
    let of_fields = [1, 2].map(|run| scene_of(&by_fields, run).mechanism.expect("a mechanism").bodies[0].mass_kg);
    assert_eq!(masses, of_fields);
    // A definition that nothing uses is a mistyped name; values are checked with all parameters.
    let of = |text: &str| message(&format!("{set}{text}{axis}"));
    assert_contains(
        &of("parameters.mu = 0.4\n"),
        &["unknown parameter `mu`, which no expression of [set] uses", "study.toml:4:12", "= help: use it in [set]"],
    );
    assert_contains(
        &of("bodies.object.mass = \"= mu\"\n"),
        &["unknown parameter `mu`", "study.toml:4:25", "study.toml:6:9", "and a study in [set.parameters]"],
    );
    assert_contains(
        &of("bodies.object.mass = \"= mu\"\nparameters.mu = 0.4\n"),
        &["`set.bodies.object.mass`", "a mass", "study.toml:4:"],
    );
    assert_contains(
        &of("bodies.object.mass = \"= 1 g * mu\"\nparameters.mu = \"= mu\"\n"),
        &["in a circle: mu → mu", "study.toml:5:17", "give one of them a value"],
    );
}

#[test]
fn the_scene_of_a_study_extends_a_file() {
    let axis = "[[axes]]\nfield = \"bodies.object.mass\"\nvalues = [\"20 g\", \"60 g\"]\n";
    let by_file =
        "scene = \"../mechanisms/two-pivot.toml\"\n[set]\nduration = \"20 ms\"\nlaws.rubber.friction.mu_static = 0.4\n";
    let head = "[scene]\nextends = \"../mechanisms/two-pivot.toml\"\nduration = \"20 ms\"\n";
    let extending =
        parse_study(&format!("{head}parameters.mu = 0.4\nlaws.rubber.friction.mu_static = \"= mu\"\n{axis}"));
    let by_file = parse_study(&format!("{by_file}{axis}"));
    for run in 1..=2 {
        assert_eq!(resolved(&extending, run), resolved(&by_file, run));
    }
    // The scene that it extends determines the results, too.
    assert!(extending.base.contains("right_driver"), "{}", extending.base);
    let of = |text: &str| message(&format!("{head}{text}{axis}"));
    assert_contains(
        &of("bodies.objekt.mass = \"20 g\"\nlaws.rubber.friction.mu_sttaic = 0.4\n"),
        &["unknown key `mu_sttaic`", "did you mean `mu_static`?", "study.toml:5:22"],
    );
    assert_contains(
        &of("laws.rubber.friction.mu_static = \"= my\"\nparameters.mu = 0.4\n"),
        &["unknown parameter `my`", "study.toml:4:37", "did you mean `mu`?"],
    );
    let missing = message(&format!("[scene]\nextends = \"two-pivots.toml\"\n{axis}"));
    assert_contains(
        &missing,
        &["cannot read the scene scenes/studies/two-pivots.toml", "study.toml:2:11", "relative to"],
    );
    let itself = message(&format!("[scene]\nextends = \"../mechanisms/four-bar.toml\"\nduration = 3\n{axis}"));
    assert_contains(&itself, &["`duration` is a bare number", "study.toml:3:12"]);
}

#[test]
fn a_scene_given_as_a_study_is_one_problem() {
    for file in ["scenes/mechanisms/two-pivot.toml", "scenes/real/2f85-lift.toml", "scenes/experiment-95.toml"] {
        let text = std::fs::read_to_string(file).expect("a scene");
        let error = parse(&text, file).expect_err("a scene").to_string();
        assert_contains(&error, &["this file is a scene, not a study", "write a study that names it: scene = \""]);
        assert_eq!(error.matches("error:").count(), 1, "{error}");
    }
}

/// The dimension of these fields depends on a joint or a law: on whether it turns or slides.
#[test]
fn fields_of_several_dimensions_have_columns_of_numbers() {
    for (field, value, si, column) in [
        ("joints.crank.damping", "0.1 N*mm*s/rad", 1e-4, "joints.crank.damping_n_m_s_per_rad"),
        ("joints.crank.start", "10 deg", 10f64.to_radians(), "joints.crank.start_rad"),
        ("springs.coil.stiffness", "5 N*mm/rad", 5e-3, "springs.coil.stiffness_n_m_per_rad"),
        ("springs.coil.rest", "5 deg", 5f64.to_radians(), "springs.coil.rest_rad"),
        ("actuators.servo.kp", "5 N/mm", 5e3, "actuators.servo.kp_n_per_m"),
        ("actuators.servo.targets[1]", "4 mm", 4e-3, "actuators.servo.targets[1]_m"),
        ("joints.slide.damping", "2 N*s/m", 2.0, "joints.slide.damping_n_s_per_m"),
        ("joints.slide.start", "1 mm", 1e-3, "joints.slide.start_m"),
    ] {
        let scene = r#"
[scene]
kind = "mechanism"
duration = "1 ms"
[scene.bodies.crank]
mass = "10 g"
inertia = "10 g*mm^2"
[scene.bodies.block]
mass = "10 g"
inertia = "10 g*mm^2"
[scene.joints.crank]
bodies = ["ground", "crank"]
at = ["0 mm", "0 mm"]
[scene.joints.slide]
type = "prismatic"
bodies = ["ground", "block"]
at = ["0 mm", "0 mm"]
axis = "0 deg"
start = "0 mm"
[scene.springs.coil]
joint = "crank"
stiffness = "1 N*mm/rad"
[scene.actuators.servo]
joint = "slide"
times = ["0 ms", "1 ms"]
targets = ["0 mm", "2 mm"]
kp = "1 N/mm"
"#;
        let text = format!("{scene}[[axes]]\nfield = \"{field}\"\nvalues = [\"{value}\"]\n");
        let study = parse(&text, "scenes/studies/study.toml").unwrap_or_else(|error| panic!("{error}"));
        let found = &columns(&study)[2];
        assert_eq!((&found.name[..], found.kind), (column, Kind::Number), "{field}");
        let Some(read) = study.field_values(1)[0].value.as_number() else { panic!("{field} is not a number") };
        assert!((read - si).abs() <= 1e-12 * si, "{field}: {read}");
        let range = format!(
            "{scene}[[axes]]\nfield = \"{field}\"\nfrom = \"{value}\"\nto = \"{}\"\ncount = 2\n",
            value.replacen(|c: char| c.is_ascii_digit(), "3", 1)
        );
        let study = parse(&range, "scenes/studies/study.toml").unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((study.runs(), &columns(&study)[2].name[..]), (2, column), "{field}");
    }
}
