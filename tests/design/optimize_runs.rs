//! `phalanx optimize`: what a search gains, that it is the same on any number of threads and after kills, and what it writes.

#![cfg(unix)]

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::support::cli::{directory, json, phalanx, stderr, stdout, write};
use phalanx::criteria::at_rest;
use phalanx::scene;
use phalanx::study::optimize::{self, Design, Listener, Optimisation, load, run};
use phalanx::study::sweep::{Row, Status};
use phalanx::table::{self, Value};

/// Design 95 by two objectives, few and short generations.
fn small(directory: &Path, population: usize, generations: usize) -> String {
    shortened("optimize-95", directory, population, generations)
}

/// A shipped search with few and short generations.
fn shortened(name: &str, directory: &Path, population: usize, generations: usize) -> String {
    let text = fs::read_to_string(format!("scenes/studies/{name}.toml")).expect("ships");
    let (before, _) = text.split_once("[method]").expect("a method");
    write(
        directory,
        "small.toml",
        &format!("{before}[method]\npopulation = {population}\ngenerations = {generations}\nseed = 3\n"),
    )
}

fn search(study: &str, out: &Path, more: &[&str]) -> Output {
    let mut args = vec!["optimize", study, "--out", out.to_str().expect("text")];
    args.extend(more);
    phalanx(&args)
}

fn done(output: &Output) {
    assert_eq!(output.status.code(), Some(0), "{}{}", stdout(output), stderr(output));
}

fn beside(out: &Path, ending: &str) -> PathBuf {
    PathBuf::from(out.to_str().expect("text").replace(".csv", ending))
}

struct Deaf(u64);

impl Listener for Deaf {
    fn row(&mut self, _: &Row) -> bool {
        self.0 += 1;
        true
    }

    fn generation(&mut self, _: &[Design]) {}
}

fn all(of: &Optimisation, threads: usize) -> optimize::Found {
    let found = run(of, threads, Vec::new(), &|| true, &mut Deaf(0)).expect("nothing was known");
    found.found.expect("nobody ended it")
}

#[test]
fn a_short_search_beats_design_95_under_its_own_criteria() {
    let directory = directory("optimize_gain");
    let of = load(shortened("optimize-95-wide", &directory, 32, 20)).unwrap_or_else(|error| panic!("{error}"));
    let found = all(&of, 2);
    let start = found.start();
    assert!(start.is_feasible(), "design 95 meets its criteria: {:?}", start.judged);
    // Its time to stability in the thesis' study, run 287.
    let tts = |design: &Design| design.judged.values[0].expect("it comes to rest");
    assert!((tts(start) - 6.54e-3).abs() < 0.02e-3, "{}", tts(start));
    let best = &found.designs[found.best(0).expect("a front")];
    assert!(tts(best) < 0.85 * tts(start), "{} against {}", tts(best), tts(start));
    let pressed = |design: &Design| design.judged.values[1].expect("a palm force");
    let hardest = &found.designs[found.best(1).expect("a front")];
    assert!(pressed(hardest) > pressed(start), "{} against {}", pressed(hardest), pressed(start));
    // The front is one: nobody on it beats another, and nobody beside it beats one on it.
    let compared = |a: &Design, b: &Design| tts(a) <= tts(b) && pressed(a) >= pressed(b);
    for &index in &found.front {
        let beaten = |other: &Design| other.is_feasible() && compared(other, &found.designs[index]);
        let by = found.designs.iter().filter(|other| beaten(other)).count();
        assert_eq!(by, 1, "by nobody but itself");
    }
    // Each of the front is feasible by its own scene, run alone.
    for &index in found.front.iter().take(3) {
        let design = &found.designs[index];
        let scene = write(&directory, "one.toml", &of.scene_text(&design.points));
        let output = phalanx(&["run", &scene, "--json"]);
        done(&output);
        let again = json(&output)["criteria"]["tts_s"].as_f64().expect("a time");
        assert!((again - tts(design)).abs() < 1e-12, "{again} {}", tts(design));
    }
}

#[test]
fn threads_change_nothing_and_what_was_known_is_not_run_again() {
    let directory = directory("optimize_threads");
    let of = load(small(&directory, 16, 5)).unwrap_or_else(|error| panic!("{error}"));
    let one = all(&of, 1);
    assert!(one == all(&of, 3), "the number of threads shows");
    assert_eq!(one.designs.len(), 80);
    let numbers: HashSet<u64> = one.designs.iter().map(|design| design.number).collect();
    assert_eq!(numbers.len(), 80);

    // All rows of a search, half of them known to another one.
    struct Keeping(Vec<Vec<Value>>);
    impl Listener for Keeping {
        fn row(&mut self, row: &Row) -> bool {
            self.0.push(row.cells.clone());
            true
        }
        fn generation(&mut self, _: &[Design]) {}
    }
    let mut kept = Keeping(Vec::new());
    run(&of, 2, Vec::new(), &|| true, &mut kept).expect("nothing was known");
    assert_eq!(kept.0.len(), 80);
    let half: Vec<Vec<Value>> = kept.0.iter().step_by(2).cloned().collect();
    let mut deaf = Deaf(0);
    let again = run(&of, 2, half, &|| true, &mut deaf).expect("rows of this search");
    assert_eq!((again.runs, deaf.0), (40, 40));
    assert!(again.found.expect("nobody ended it") == one);
    // Rows of another search are refused rather than taken for those of this one.
    let mut foreign = kept.0.clone();
    foreign[20][2] = Value::Number(0.0123456);
    assert!(run(&of, 2, foreign, &|| true, &mut Deaf(0)).is_err());
}

/// The lightest finger is one that does not reach its object: it is infeasible although its run is complete.
#[test]
fn a_design_that_cannot_grasp_is_infeasible() {
    let directory = directory("optimize_ungraspable");
    let text = "[scene]\nduration = \"20 ms\"\nmotor.torque = \"600 N*mm\"\nspring.torque = \"150 N*mm\"\n[scene.lengths]\nl11 = \"20 \
                mm\"\nl21 = \"31 mm\"\nl22 = \"10 mm\"\nt22 = \"16 mm\"\nphi22 = \"115 deg\"\n[scene.object]\nradius = \"25 \
                mm\"\ncentre = [\"-21 mm\", \"25 mm\"]\n[[variables]]\nfield = \"lengths.t22\"\nfrom = \"11 mm\"\nto = \"26 \
                mm\"\n[[objectives]]\ncolumn = \"mass_kg\"\n[method]\nalgorithm = \"cma-es\"\npopulation = 6\ngenerations = 6\nseed \
                = 1\n";
    let of = load(write(&directory, "light.toml", text)).unwrap_or_else(|error| panic!("{error}"));
    let found = all(&of, 2);
    let grasps = |design: &Design| {
        let scene = scene::parse(&of.scene_text(&design.points), "one.toml").expect("a scene");
        at_rest(&scene, scene.object().expect("an object")).is_ok()
    };
    let grasping = found.designs.iter().filter(|design| grasps(design)).count();
    assert!(grasping > 5 && found.designs.len() - grasping > 5, "{grasping} of {}", found.designs.len());
    assert!(found.designs.iter().all(|design| design.is_feasible() == grasps(design)));
    assert!(grasps(&found.designs[found.best(0).expect("a best")]));
}

#[test]
fn conditions_count_by_the_worst_and_refusals_are_counted() {
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
    done(&output);
    let document = json(&output);
    assert_eq!(document["runs"], 96);
    assert!(document["by_status"]["refused"].as_u64().expect("a count") >= 2, "{}", document["by_status"]);
    let (designs, runs) =
        (table::read(&out).expect("written"), table::read(&beside(&out, ".runs.csv")).expect("written"));
    assert_eq!((designs.rows.len(), runs.rows.len()), (48, 96));
    let (tts, pfp) = (designs.numbers("tts_s").expect("there"), designs.numbers("pfp_n").expect("there"));
    let worst = designs.numbers("worst_f22_n").expect("there");
    let feasible = designs.flags("feasible").expect("there");
    let of = |name: &str| runs.numbers(name).expect("there");
    let (run_tts, run_pfp, run_f22) = (of("tts_s"), of("pfp_n"), of("f22_n"));
    let status = runs.texts("status").expect("there");
    let mut compared = 0;
    for design in 0..48 {
        let pair = [2 * design, 2 * design + 1];
        let both = |column: &[Option<f64>]| Some([column[pair[0]]?, column[pair[1]]?]);
        let worse = both(&run_tts).map(|[a, b]| a.max(b));
        assert_eq!(tts[design], worse);
        assert_eq!(pfp[design], both(&run_pfp).map(|[a, b]| 0.5 * (a + b)));
        if let Some([a, b]) = both(&run_f22) {
            assert_eq!(worst[design], Some(a.min(b)));
            compared += 1;
        }
        let completed = pair.iter().all(|&run| status[run] == Some(Status::Completed.name()));
        let meets = completed && worse.is_some() && pfp[design].is_some() && worst[design].is_some_and(|of| of >= 1.0);
        assert_eq!(feasible[design], Some(meets), "design {}", design + 1);
    }
    assert!(compared > 20, "{compared}");
}

#[test]
fn killed_and_started_again_it_ends_with_the_bytes_of_an_undisturbed_one() {
    let directory = directory("optimize_kill");
    let study = small(&directory, 24, 12);
    let undisturbed = directory.join("undisturbed.csv");
    done(&search(&study, &undisturbed, &["--threads", "1"]));
    let out = directory.join("killed.csv");
    let partial = beside(&out, ".runs.csv.partial.csv");
    let lines = |path: &Path| fs::read(path).map_or(0, |bytes| bytes.iter().filter(|byte| **byte == b'\n').count());
    for (kill, rows) in [30, 90, 170].into_iter().enumerate() {
        let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
        command
            .args(["optimize", &study, "--threads", "2", "--out"])
            .arg(&out)
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let mut child = command.spawn().expect("the binary starts");
        let patience = Instant::now() + Duration::from_secs(60);
        while lines(&partial) < rows {
            assert!(
                Instant::now() < patience && child.try_wait().expect("a child").is_none(),
                "{} rows",
                lines(&partial)
            );
            sleep(Duration::from_millis(1));
        }
        if kill < 2 {
            child.kill().expect("killed");
            child.wait().expect("ended");
        } else {
            let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
            assert!(sent.expect("kill is there").success());
            let output = child.wait_with_output().expect("ends");
            assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
            let message = stderr(&output);
            assert!(
                message.contains("interrupted by SIGINT") && message.contains("the same command goes on"),
                "{message}"
            );
        }
        assert!(!out.exists() && partial.exists());
    }
    let there = lines(&partial) as u64 - 2;
    let output = search(&study, &out, &["--json"]);
    done(&output);
    assert_eq!(json(&output)["now"]["runs"].as_u64(), Some(24 * 12 - there));
    for ending in [".csv", ".runs.csv"] {
        let [one, other] = [&undisturbed, &out].map(|out| fs::read(beside(out, ending)).expect("written"));
        assert!(one == other, "{ending} differs after kills");
    }
    assert!(!partial.exists());

    // Complete, it is not run again; begun anew, it is; of another file it is not the result.
    let output = search(&study, &out, &["--json"]);
    assert!(stderr(&output).contains("nothing was run"), "{}", stderr(&output));
    assert_eq!(json(&output)["now"]["runs"], 0);
    let output = search(&study, &out, &["--json", "--restart"]);
    assert_eq!(json(&output)["now"]["runs"], 288);
    let text = fs::read_to_string(&study).expect("there").replace("seed = 3", "seed = 4");
    let output = search(&write(&directory, "other.toml", &text), &out, &[]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("another study"), "{}", stderr(&output));
}

#[test]
fn pictures_pages_and_scenes_are_of_the_front() {
    let directory = directory("optimize_files");
    let study = small(&directory, 16, 6);
    let [out, plot, page, scenes] =
        ["front.parquet", "front.svg", "front.html", "scenes"].map(|name| directory.join(name));
    let text = |path: &Path| path.to_str().expect("text").to_string();
    let files = ["--plot", &text(&plot), "--html", &text(&page), "--scenes", &text(&scenes)].map(String::from);
    let files: Vec<&str> = files.iter().map(String::as_str).collect();
    let output = search(&study, &out, &files);
    done(&output);
    let said = stdout(&output);
    for word in ["best tts", "best pfp", "gain, %", "16 designs", "meets all", "front:", "at least semi-stable"] {
        assert!(said.contains(word), "{word} in\n{said}");
    }
    let designs = table::read(&out).expect("written");
    let on_front: Vec<i64> = designs
        .integers("design")
        .expect("there")
        .into_iter()
        .zip(designs.flags("front").expect("there"))
        .filter_map(|(number, front)| number.filter(|_| front == Some(true)))
        .collect();
    assert!(on_front.len() >= 3, "{on_front:?}");
    let page = fs::read_to_string(&page).expect("written");
    let picture = fs::read_to_string(&plot).expect("written");
    assert!(picture.contains("prefers-color-scheme:dark") && picture.contains("compromise"));
    for number in &on_front {
        // The point in the picture leads to the scene, which is the file.
        assert!(page.contains(&format!("<a href=\"#design-{number}\"><circle")), "{number}");
        assert!(page.contains(&format!("id=\"design-{number}\"")), "{number}");
        let scene = fs::read_to_string(scenes.join(format!("design-{number:02}.toml"))).expect("written");
        assert!(page.contains(&scene.replace('"', "&quot;")), "{scene}");
        assert!(scene.starts_with(&format!("# Design {number} of the search \"optimize-95\"")), "{scene}");
    }
    assert_eq!(page.matches("<a href=\"#design-").count(), 2 * on_front.len(), "in the picture and in the table");
    let files = said.lines().find(|line| line.starts_with("scene ")).expect("files of the designs that are compared");
    let compromise = scenes.join(files.split_whitespace().last().expect("the compromise"));
    assert!(fs::read_to_string(&compromise).expect("written").contains("\"optimize-95\", the compromise:"));
    let best = scenes.join(format!("design-{:02}.toml", on_front[0]));
    for scene in [best, scenes.join("start.toml")] {
        done(&phalanx(&["run", &text(&scene)]));
    }
    // Nothing of others is replaced.
    let mine = write(&directory, "mine.csv", "a,b\n1,2\n");
    let output = search(&study, Path::new(&mine), &[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("left alone"), "{}", stderr(&output));
}

#[test]
fn a_search_that_finds_nothing_says_what_was_nearest() {
    let directory = directory("optimize_nothing");
    let study = small(&directory, 8, 2);
    let text = fs::read_to_string(&study).expect("there").replace("at_least = 0.0", "at_least = 1000.0");
    let out = directory.join("out.csv");
    let output = search(&write(&directory, "none.toml", &text), &out, &[]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let said = stdout(&output);
    assert!(
        said.contains("Not one of 16 designs meets all constraints") && said.contains("The nearest is design"),
        "{said}"
    );
    assert!(out.exists(), "what was looked at is written all the same");
}

#[test]
fn units_are_those_of_fields_and_columns_however_they_are_called() {
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
    done(&output);
    let any = ["--no-form-closed", "--no-static", "--no-pfp", "--class", "unstable"];
    let runs = beside(&out, ".runs.csv");
    let selected = phalanx(&[&["select", runs.to_str().expect("text")][..], &any].concat());
    let page = fs::read_to_string(&page).expect("written");
    for (said, label) in [
        (stdout(&output), "stiffness, N·mm/rad      60"),
        (stdout(&output), "peak, N"),
        (page.as_str(), "stiffness, N·mm/rad"),
        (page.as_str(), "peak, N"),
        (stdout(&selected), "stiffness, N·mm/rad"),
    ] {
        assert!(said.contains(label), "{label}\n{said}");
    }
}

#[test]
fn a_search_is_ended_before_its_first_run_too() {
    let directory = directory("optimize_setup");
    let of = load(small(&directory, 2000, 1)).expect("sound");
    let (asked, mut heard) = (std::sync::atomic::AtomicU64::new(0), Deaf(0));
    let go_on = || asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed) < 100;
    let ended = run(&of, 1, Vec::new(), &go_on, &mut heard).expect("no other search");
    assert!(ended.found.is_none() && heard.0 == 0, "{} runs", heard.0);
}
