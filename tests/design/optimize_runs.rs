//! `phalanx optimize`: gains of a search, reproducibility for any number of threads and after interruptions, and output files.

#![cfg(unix)]

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::support::cli::{directory, json, phalanx, stderr, stdout, write};
use phalanx::criteria::static_grasp;
use phalanx::scene;
use phalanx::study::optimize::{self, Design, Listener, Optimisation, load, run};
use phalanx::study::sweep::{Row, Status};
use phalanx::table::{self, Value};

/// Writes a search for design 95 with two objectives and few, small generations.
fn write_small_study(directory: &Path, population: usize, generations: usize) -> String {
    shortened("optimize-95", directory, population, generations)
}

/// Writes a shipped search with few, small generations.
fn shortened(name: &str, directory: &Path, population: usize, generations: usize) -> String {
    let text = fs::read_to_string(format!("scenes/studies/{name}.toml")).expect("ships");
    let (head, _) = text.split_once("[method]").expect("a method");
    write(
        directory,
        "small.toml",
        &format!("{head}[method]\npopulation = {population}\ngenerations = {generations}\nseed = 3\n"),
    )
}

fn search(study: &str, out: &Path, options: &[&str]) -> Output {
    let mut args = vec!["optimize", study, "--out", out.to_str().expect("text")];
    args.extend(options);
    phalanx(&args)
}

fn assert_success(output: &Output) {
    assert_eq!(output.status.code(), Some(0), "{}{}", stdout(output), stderr(output));
}

fn with_suffix(out: &Path, ending: &str) -> PathBuf {
    PathBuf::from(out.to_str().expect("text").replace(".csv", ending))
}

struct RowCounter(u64);

impl Listener for RowCounter {
    fn row(&mut self, _: &Row) -> bool {
        self.0 += 1;
        true
    }

    fn generation(&mut self, _: &[Design]) {}
}

fn run_all(optimisation: &Optimisation, threads: usize) -> optimize::OptimisationResult {
    let outcome = run(optimisation, threads, Vec::new(), &|| true, &mut RowCounter(0)).expect("no known runs");
    outcome.result.expect("completed")
}

#[test]
fn short_search_improves_design_95_under_its_own_criteria() {
    let directory = directory("optimize_gain");
    let optimisation =
        load(shortened("optimize-95-wide", &directory, 32, 20)).unwrap_or_else(|error| panic!("{error}"));
    let result = run_all(&optimisation, 2);
    let start = result.start();
    assert!(start.is_feasible(), "design 95 satisfies its criteria: {:?}", start.evaluation);
    // The thesis reports 6.54 ms for run 287, the time to stability of this design.
    let tts = |design: &Design| design.evaluation.values[0].expect("a time to stability");
    assert!((tts(start) - 6.54e-3).abs() < 0.02e-3, "{}", tts(start));
    let best = &result.designs[result.best(0).expect("a front")];
    assert!(tts(best) < 0.85 * tts(start), "{} against {}", tts(best), tts(start));
    let palm_force = |design: &Design| design.evaluation.values[1].expect("a palm force");
    let largest_force = &result.designs[result.best(1).expect("a front")];
    assert!(
        palm_force(largest_force) > palm_force(start),
        "{} against {}",
        palm_force(largest_force),
        palm_force(start)
    );
    // No other design is at least as good in both objectives as a design on the front.
    let weakly_dominates = |a: &Design, b: &Design| tts(a) <= tts(b) && palm_force(a) >= palm_force(b);
    for &index in &result.front {
        let dominates = |other: &Design| other.is_feasible() && weakly_dominates(other, &result.designs[index]);
        let count = result.designs.iter().filter(|other| dominates(other)).count();
        assert_eq!(count, 1, "only the design itself");
    }
    // A run of the design's scene alone reproduces the result.
    for &index in result.front.iter().take(3) {
        let design = &result.designs[index];
        let scene = write(&directory, "one.toml", &optimisation.scene_text(&design.points));
        let output = phalanx(&["run", &scene, "--json"]);
        assert_success(&output);
        let repeated_s = json(&output)["criteria"]["tts_s"].as_f64().expect("a time");
        assert!((repeated_s - tts(design)).abs() < 1e-12, "{repeated_s} {}", tts(design));
    }
}

#[test]
fn results_do_not_depend_on_threads_and_known_runs_are_not_repeated() {
    let directory = directory("optimize_threads");
    let optimisation = load(write_small_study(&directory, 16, 5)).unwrap_or_else(|error| panic!("{error}"));
    let single_threaded = run_all(&optimisation, 1);
    assert!(single_threaded == run_all(&optimisation, 3), "the number of threads changes the result");
    assert_eq!(single_threaded.designs.len(), 80);
    let numbers: HashSet<u64> = single_threaded.designs.iter().map(|design| design.number).collect();
    assert_eq!(numbers.len(), 80);

    // Collect all rows of a search, then resume it from half of them.
    struct RowCollector(Vec<Vec<Value>>);
    impl Listener for RowCollector {
        fn row(&mut self, row: &Row) -> bool {
            self.0.push(row.cells.clone());
            true
        }
        fn generation(&mut self, _: &[Design]) {}
    }
    let mut collected = RowCollector(Vec::new());
    run(&optimisation, 2, Vec::new(), &|| true, &mut collected).expect("no known runs");
    assert_eq!(collected.0.len(), 80);
    let half: Vec<Vec<Value>> = collected.0.iter().step_by(2).cloned().collect();
    let mut counter = RowCounter(0);
    let resumed = run(&optimisation, 2, half, &|| true, &mut counter).expect("rows of this search");
    assert_eq!((resumed.runs, counter.0), (40, 40));
    assert!(resumed.result.expect("completed") == single_threaded);
    // Rows of another search are rejected.
    let mut other_rows = collected.0.clone();
    other_rows[20][2] = Value::Number(0.0123456);
    assert!(run(&optimisation, 2, other_rows, &|| true, &mut RowCounter(0)).is_err());
}

/// The lightest finger does not reach its object. It is infeasible although its run completes.
#[test]
fn design_that_cannot_grasp_is_infeasible() {
    let directory = directory("optimize_ungraspable");
    let text = "[scene]\nduration = \"20 ms\"\nmotor.torque = \"600 N*mm\"\nspring.torque = \"150 N*mm\"\n[scene.lengths]\nl11 = \"20 \
                mm\"\nl21 = \"31 mm\"\nl22 = \"10 mm\"\nt22 = \"16 mm\"\nphi22 = \"115 deg\"\n[scene.object]\nradius = \"25 \
                mm\"\ncentre = [\"-21 mm\", \"25 mm\"]\n[[variables]]\nfield = \"lengths.t22\"\nfrom = \"11 mm\"\nto = \"26 \
                mm\"\n[[objectives]]\ncolumn = \"mass_kg\"\n[method]\nalgorithm = \"cma-es\"\npopulation = 6\ngenerations = 6\nseed \
                = 1\n";
    let optimisation = load(write(&directory, "light.toml", text)).unwrap_or_else(|error| panic!("{error}"));
    let result = run_all(&optimisation, 2);
    let grasps = |design: &Design| {
        let scene = scene::parse(&optimisation.scene_text(&design.points), "one.toml").expect("a scene");
        static_grasp(&scene, scene.object().expect("an object")).is_ok()
    };
    let grasping = result.designs.iter().filter(|design| grasps(design)).count();
    assert!(grasping > 5 && result.designs.len() - grasping > 5, "{grasping} of {}", result.designs.len());
    assert!(result.designs.iter().all(|design| design.is_feasible() == grasps(design)));
    assert!(grasps(&result.designs[result.best(0).expect("a best design")]));
}

#[test]
fn worst_condition_counts_and_refused_runs_are_counted() {
    let directory = directory("optimize_conditions");
    let scene = fs::canonicalize("scenes/experiment-95.toml").expect("ships");
    let text = format!(
        "scene = \"{}\"\n[[variables]]\nfield = \"design.base\"\nfrom = \"5 mm\"\nto = \"40 mm\"\n[[conditions]]\nfield = \
         \"contact.friction.mu_static\"\nvalues = [0.0, 0.8]\n[[objectives]]\ncolumn = \"tts_s\"\n[[objectives]]\ncolumn = \
         \"pfp_n\"\ngoal = \"max\"\nover = \"mean\"\n[[constraints]]\ncolumn = \"f22_n\"\nat_least = 1.0\n[method]\npopulation = \
         16\ngenerations = 3\n",
        scene.display()
    );
    let out = directory.join("out.csv");
    let output = search(&write(&directory, "conditions.toml", &text), &out, &["--json"]);
    assert_success(&output);
    let document = json(&output);
    assert_eq!(document["runs"], 96);
    assert!(document["by_status"]["refused"].as_u64().expect("a count") >= 2, "{}", document["by_status"]);
    let (designs, runs) =
        (table::read(&out).expect("written"), table::read(&with_suffix(&out, ".runs.csv")).expect("written"));
    assert_eq!((designs.rows.len(), runs.rows.len()), (48, 96));
    let (tts, pfp) = (designs.numbers("tts_s").expect("a column"), designs.numbers("pfp_n").expect("a column"));
    let worst = designs.numbers("worst_f22_n").expect("a column");
    let feasible = designs.flags("feasible").expect("a column");
    let run_values = |name: &str| runs.numbers(name).expect("a column");
    let (run_tts, run_pfp, run_f22) = (run_values("tts_s"), run_values("pfp_n"), run_values("f22_n"));
    let status = runs.texts("status").expect("a column");
    let mut compared = 0;
    for design in 0..48 {
        let pair = [2 * design, 2 * design + 1];
        let both = |column: &[Option<f64>]| Some([column[pair[0]]?, column[pair[1]]?]);
        let worst_tts = both(&run_tts).map(|[a, b]| a.max(b));
        assert_eq!(tts[design], worst_tts);
        assert_eq!(pfp[design], both(&run_pfp).map(|[a, b]| 0.5 * (a + b)));
        if let Some([a, b]) = both(&run_f22) {
            assert_eq!(worst[design], Some(a.min(b)));
            compared += 1;
        }
        let completed = pair.iter().all(|&run| status[run] == Some(Status::Completed.name()));
        let expected = completed
            && worst_tts.is_some()
            && pfp[design].is_some()
            && worst[design].is_some_and(|force_n| force_n >= 1.0);
        assert_eq!(feasible[design], Some(expected), "design {}", design + 1);
    }
    assert!(compared > 20, "{compared}");
}

#[test]
fn resumed_search_writes_the_same_bytes_as_an_uninterrupted_one() {
    let directory = directory("optimize_kill");
    let study = write_small_study(&directory, 24, 12);
    let uninterrupted = directory.join("uninterrupted.csv");
    assert_success(&search(&study, &uninterrupted, &["--threads", "1"]));
    let out = directory.join("killed.csv");
    let partial = with_suffix(&out, ".runs.csv.partial.csv");
    let lines = |path: &Path| fs::read(path).map_or(0, |bytes| bytes.iter().filter(|byte| **byte == b'\n').count());
    for (kill, rows) in [30, 90, 170].into_iter().enumerate() {
        let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
        command
            .args(["optimize", &study, "--threads", "2", "--out"])
            .arg(&out)
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let mut child = command.spawn().expect("the binary starts");
        let deadline = Instant::now() + Duration::from_secs(60);
        while lines(&partial) < rows {
            assert!(
                Instant::now() < deadline && child.try_wait().expect("a child").is_none(),
                "{} rows",
                lines(&partial)
            );
            sleep(Duration::from_millis(1));
        }
        if kill < 2 {
            child.kill().expect("killed");
            child.wait().expect("ended");
        } else {
            let kill_status = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
            assert!(kill_status.expect("kill is installed").success());
            let output = child.wait_with_output().expect("ends");
            assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
            let message = stderr(&output);
            assert!(
                message.contains("interrupted by SIGINT") && message.contains("the same command resumes"),
                "{message}"
            );
        }
        assert!(!out.exists() && partial.exists());
    }
    let stored_runs = lines(&partial) as u64 - 2;
    let output = search(&study, &out, &["--json"]);
    assert_success(&output);
    assert_eq!(json(&output)["now"]["runs"].as_u64(), Some(24 * 12 - stored_runs));
    for ending in [".csv", ".runs.csv"] {
        let [uninterrupted_bytes, resumed_bytes] =
            [&uninterrupted, &out].map(|out| fs::read(with_suffix(out, ending)).expect("written"));
        assert!(uninterrupted_bytes == resumed_bytes, "{ending} differs after kills");
    }
    assert!(!partial.exists());

    // A complete search is not run again, except with --restart; results of another file are rejected.
    let output = search(&study, &out, &["--json"]);
    assert!(stderr(&output).contains("nothing was run"), "{}", stderr(&output));
    assert_eq!(json(&output)["now"]["runs"], 0);
    let output = search(&study, &out, &["--json", "--restart"]);
    assert_eq!(json(&output)["now"]["runs"], 288);
    let text = fs::read_to_string(&study).expect("readable").replace("seed = 3", "seed = 4");
    let output = search(&write(&directory, "other.toml", &text), &out, &[]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("another study"), "{}", stderr(&output));
}

#[test]
fn plot_page_and_scenes_show_the_front() {
    let directory = directory("optimize_files");
    let study = write_small_study(&directory, 16, 6);
    let [out, plot, page, scenes] =
        ["front.parquet", "front.svg", "front.html", "scenes"].map(|name| directory.join(name));
    let text = |path: &Path| path.to_str().expect("text").to_string();
    let files = ["--plot", &text(&plot), "--html", &text(&page), "--scenes", &text(&scenes)].map(String::from);
    let files: Vec<&str> = files.iter().map(String::as_str).collect();
    let output = search(&study, &out, &files);
    assert_success(&output);
    let report = stdout(&output);
    for fragment in ["best tts", "best pfp", "gain, %", "16 designs", "meets all", "front:", "at least semi-stable"] {
        assert!(report.contains(fragment), "{fragment} in\n{report}");
    }
    let designs = table::read(&out).expect("written");
    let on_front: Vec<i64> = designs
        .integers("design")
        .expect("a column")
        .into_iter()
        .zip(designs.flags("front").expect("a column"))
        .filter_map(|(number, front)| number.filter(|_| front == Some(true)))
        .collect();
    assert!(on_front.len() >= 3, "{on_front:?}");
    let page = fs::read_to_string(&page).expect("written");
    let picture = fs::read_to_string(&plot).expect("written");
    assert!(picture.contains("prefers-color-scheme:dark") && picture.contains("compromise"));
    for number in &on_front {
        // The point in the plot links to the scene, which equals the scene file.
        assert!(page.contains(&format!("<a href=\"#design-{number}\"><circle")), "{number}");
        assert!(page.contains(&format!("id=\"design-{number}\"")), "{number}");
        let scene = fs::read_to_string(scenes.join(format!("design-{number:02}.toml"))).expect("written");
        assert!(page.contains(&scene.replace('"', "&quot;")), "{scene}");
        assert!(scene.starts_with(&format!("# Design {number} of the search \"optimize-95\"")), "{scene}");
    }
    assert_eq!(page.matches("<a href=\"#design-").count(), 2 * on_front.len(), "in the plot and in the table");
    let files = report.lines().find(|line| line.starts_with("scene ")).expect("files of the designs that are compared");
    let compromise = scenes.join(files.split_whitespace().last().expect("the compromise"));
    assert!(fs::read_to_string(&compromise).expect("written").contains("\"optimize-95\", the compromise:"));
    let best = scenes.join(format!("design-{:02}.toml", on_front[0]));
    for scene in [best, scenes.join("start.toml")] {
        assert_success(&phalanx(&["run", &text(&scene)]));
    }
    // Foreign files are not replaced.
    let other_file = write(&directory, "mine.csv", "a,b\n1,2\n");
    let output = search(&study, Path::new(&other_file), &[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("not replaced"), "{}", stderr(&output));
}

#[test]
fn search_without_a_feasible_design_reports_the_closest() {
    let directory = directory("optimize_nothing");
    let study = write_small_study(&directory, 8, 2);
    let text = fs::read_to_string(&study).expect("readable").replace("at_least = 0.0", "at_least = 1000.0");
    let out = directory.join("out.csv");
    let output = search(&write(&directory, "none.toml", &text), &out, &[]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let report = stdout(&output);
    assert!(
        report.contains("None of 16 designs meets all constraints") && report.contains("The closest is design"),
        "{report}"
    );
    assert!(out.exists(), "the evaluated designs are written");
}

#[test]
fn units_do_not_depend_on_column_names() {
    let directory = directory("optimize_units");
    let scene = fs::canonicalize("scenes/torsional-spring.toml").expect("ships");
    let text = format!(
        "scene = {scene:?}\n[[variables]]\nfield = \"spring.stiffness\"\nfrom = \"40 N*mm/rad\"\nto = \"160 N*mm/rad\"\n[[objectives]]\n\
         column = \"tts_s\"\n[[objectives]]\ncolumns = [\"peak_f21_n\", \"peak_f22_n\"]\nname = \"peak\"\n[method]\npopulation = 4\n\
         generations = 1\n"
    );
    let (study, out, page) =
        (write(&directory, "spring.toml", &text), directory.join("s.csv"), directory.join("s.html"));
    let output = search(&study, &out, &["--html", page.to_str().expect("text")]);
    assert_success(&output);
    let any = ["--no-form-closed", "--no-static", "--no-pfp", "--class", "unstable"];
    let runs = with_suffix(&out, ".runs.csv");
    let selected = phalanx(&[&["select", runs.to_str().expect("text")][..], &any].concat());
    let page = fs::read_to_string(&page).expect("written");
    for (output, label) in [
        (stdout(&output), "stiffness, N·mm/rad      60"),
        (stdout(&output), "peak, N"),
        (page.as_str(), "stiffness, N·mm/rad"),
        (page.as_str(), "peak, N"),
        (stdout(&selected), "stiffness, N·mm/rad"),
    ] {
        assert!(output.contains(label), "{label}\n{output}");
    }
}

#[test]
fn search_can_be_interrupted_before_its_first_run() {
    let directory = directory("optimize_setup");
    let optimisation = load(write_small_study(&directory, 2000, 1)).expect("a valid file");
    let (calls, mut counter) = (std::sync::atomic::AtomicU64::new(0), RowCounter(0));
    let keep_running = || calls.fetch_add(1, std::sync::atomic::Ordering::Relaxed) < 100;
    let outcome = run(&optimisation, 1, Vec::new(), &keep_running, &mut counter).expect("no known runs");
    assert!(outcome.result.is_none() && counter.0 == 0, "{} runs", counter.0);
}
