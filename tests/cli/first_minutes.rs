//! First use of the program: a new scene, a run, and its page in the browser.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::support::cli::{
    EXPERIMENT_95, assert_contains, assert_rejected, assert_status, directory, path_in, path_text, signal, start,
    stderr, stdout, succeed, succeed_json, succeed_silently, variant, write,
};
use phalanx::scene;

/// Runs the command in a session without a screen or browser, except for the given variables.
fn phalanx_with_env(variables: &[(&str, &str)], args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
    for name in ["BROWSER", "DISPLAY", "WAYLAND_DISPLAY", "WSL_DISTRO_NAME"] {
        command.env_remove(name);
    }
    command.envs(variables.iter().copied()).args(args).output().expect("the binary starts")
}

/// Creates a program that records the page to open and exits with a status.
#[cfg(unix)]
fn fake_browser(directory: &Path, status: u8) -> String {
    use std::os::unix::fs::PermissionsExt;
    let script = format!("#!/bin/sh\nprintf '%s' \"$1\" > '{}/opened'\nexit {status}\n", directory.display());
    let path = write(directory, "browser", &script);
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("an executable file");
    path
}

#[test]
fn new_scene_runs_unchanged_and_has_comments() {
    let directory = directory("cli_new");
    let file = path_in(&directory, "my gripper.toml");
    let output = succeed_silently(&["new", &file]);
    assert!(output.starts_with(&format!("wrote {file}")), "{output}");

    let text = fs::read_to_string(&file).expect("the scene");
    assert_contains(&text, &["[design]", "[object]", "[motor]", "[spring]", "[contact.friction]", "[initial]"]);
    // The first line names the schema for editors, in the directory of the scene.
    assert!(text.starts_with("#:schema ./scene.schema.json\n#"), "{text}");
    let schema = directory.join("scene.schema.json");
    assert!(output.contains(&format!("phalanx schema scene > {}", schema.display())), "{output}");
    let values = text.lines().filter(|line| line.contains(" = ") && !line.starts_with('#'));
    assert!(values.count() >= 10 && text.matches('#').count() >= 20);
    let scene = scene::load(&file).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.name, "my gripper");
    // The scene equals experiment-95, whose outcome is known.
    assert_eq!(scene.finger().linkage, scene::load(EXPERIMENT_95).expect("experiment-95").finger().linkage);
    assert_eq!(succeed_json(&["run", &file])["criteria"]["class"], "stable");
}

#[test]
fn new_scene_does_not_replace_files() {
    let directory = directory("cli_new_refused");
    let existing = write(&directory, "mine.toml", "my work");
    let missing_path = directory.join("nowhere/scene.toml").display().to_string();
    for (file, part) in [
        (existing.as_str(), "a file or directory of that name already exists"),
        (directory.to_str().expect("UTF-8 path"), "a file or directory of that name already exists"),
        (missing_path.as_str(), "give a file in a directory where you may write"),
    ] {
        assert_rejected(&["new", file], &[file, part]);
    }
    assert_eq!(fs::read_to_string(&existing).expect("the file"), "my work");
}

#[test]
fn run_writes_page() {
    let directory = directory("cli_run_html");
    let place = |name: &str| path_in(&directory, name);
    for (scene, model) in
        [(EXPERIMENT_95, "analytic"), (EXPERIMENT_95, "engine"), ("scenes/laws/impact.toml", "analytic")]
    {
        let (page, log) = (place("run.html"), place("run.mcap"));
        let output = succeed_silently(&["run", scene, "--model", model, "--plot", &page, "--log", &log]);
        assert!(output.contains(&format!("\npage: {page}\n")), "{output}");
        let run_page = fs::read_to_string(&page).expect("the page");
        // Pages are shared, so they must not contain local paths.
        assert!(!run_page.contains(&directory.display().to_string()));
        // The page of the log contains the same data.
        succeed(&["replay", &log, "--plot", &page]);
        let log_page = fs::read_to_string(&page).expect("the page");
        let data = |html: &str| {
            html.split("id=\"data\">").nth(1).and_then(|rest| rest.split("</script>").next().map(String::from))
        };
        assert!(data(&run_page).is_some());
        assert_eq!(data(&run_page), data(&log_page), "{scene}, {model}");
        assert_eq!(succeed_json(&["run", scene, "--model", model, "--plot", &page])["page"], page.as_str());
    }
}

#[test]
fn page_of_stopped_run_says_not_completed() {
    let directory = directory("cli_run_html_stopped");
    let page = directory.join("run.html");
    let scene = variant(&directory, "few-steps.toml", "[integrator]\nmax_steps = 60");
    assert_status(&["run", &scene, "--plot", path_text(&page)], 3, &[]);
    assert!(fs::read_to_string(&page).expect("the page").contains("NOT COMPLETED"));
}

#[cfg(unix)]
#[test]
fn page_opens_in_session_browser() {
    let directory = directory("cli_open");
    let page = directory.join("run.html");
    let browser = fake_browser(&directory, 0);
    let args = ["run", EXPERIMENT_95, "--open", "--plot", path_text(&page)];
    let output = phalanx_with_env(&[("BROWSER", &browser)], &args);
    assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""));
    let opened_page = || fs::read_to_string(directory.join("opened")).expect("the browser was started");
    assert_eq!(Path::new(&opened_page()), page.canonicalize().expect("the page"));
    // Without a name the page is a temporary file, which is kept for the browser.
    let temporary = directory.join("tmp");
    fs::create_dir(&temporary).expect("a directory");
    let settings = [("BROWSER", browser.as_str()), ("TMPDIR", temporary.to_str().expect("UTF-8 path"))];
    let output = phalanx_with_env(&settings, &["run", EXPERIMENT_95, "--open"]);
    assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""));
    assert!(Path::new(&opened_page()).starts_with(temporary.canonicalize().expect("a directory")), "{}", opened_page());
    assert!(stdout(&output).contains("\npage: "), "{}", stdout(&output));
    assert!(fs::read_to_string(opened_page()).expect("the page").starts_with("<!DOCTYPE html>"));
}

#[cfg(unix)]
#[test]
fn saved_scene_runs_again() {
    use std::io::{BufRead, BufReader};
    use std::sync::mpsc::channel;
    use std::time::Duration;

    let directory = directory("cli_watch");
    let scene = write(&directory, "scene.toml", &fs::read_to_string(EXPERIMENT_95).expect("experiment-95"));
    let page = directory.join("run.html");
    let mut child = start(&["run", &scene, "--watch", "--no-check", "--plot", path_text(&page)]);
    let (send, lines) = channel();
    let errors = BufReader::new(child.stderr.take().expect("stderr"));
    let reader =
        std::thread::spawn(move || errors.lines().map_while(Result::ok).for_each(|line| drop(send.send(line))));
    let wait_for = |part: &str| {
        while !lines.recv_timeout(Duration::from_secs(60)).expect(part).contains(part) {}
    };
    wait_for("save the file to run again");
    let first = fs::read_to_string(&page).expect("the page");
    // An error is printed without ending the loop, and the corrected scene runs.
    write(&directory, "scene.toml", "[design]\nbase = 3\n");
    wait_for("error:");
    wait_for("save the file to run again");
    variant(&directory, "scene.toml", "[initial]\noffset = \"20 deg\"");
    wait_for("save the file to run again");
    assert_ne!(fs::read_to_string(&page).expect("the page"), first);
    signal(&child, "INT");
    assert_eq!(child.wait().expect("exit status").code(), Some(0));
    reader.join().expect("a finished reader");

    let output = phalanx_with_env(&[("BROWSER", "true")], &["run", &scene, "--watch", "--open"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("--plot FILE.html"), "{}", stderr(&output));
}

#[cfg(unix)]
#[test]
fn failing_browser_leaves_the_page() {
    let directory = directory("cli_open_fails");
    let page = directory.join("run.html");
    let browser = fake_browser(&directory, 4);
    let output =
        phalanx_with_env(&[("BROWSER", &browser)], &["run", EXPERIMENT_95, "--open", "--plot", path_text(&page)]);
    assert_eq!(output.status.code(), Some(3));
    assert_contains(stderr(&output), &["could not be opened", "run.html"]);
    assert!(page.exists() && stdout(&output).contains("stable"));
}

#[cfg(target_os = "linux")]
#[test]
fn missing_browser_is_reported_before_simulation() {
    for (settings, part) in [
        (&[][..], "has no screen"),
        (&[("BROWSER", "no-such-program")][..], "names no program"),
        (&[("DISPLAY", ":0"), ("PATH", "/nowhere")][..], "no xdg-open"),
    ] {
        let output = phalanx_with_env(settings, &["run", EXPERIMENT_95, "--open"]);
        assert_eq!((output.status.code(), stdout(&output)), (Some(2), ""));
        assert_contains(stderr(&output), &[part, "--plot FILE.html"]);
    }
}

#[test]
fn missing_explorer_module_error_names_install_command() {
    let command = "tools/explorer.sh --install";
    assert_rejected(&["explore", "--module", "nowhere.wasm.gz", "-o", "page.html"], &[command]);
    // The program contains the module if the target is installed first.
    assert_rejected(
        &["explore", "--module", "nowhere.wasm.gz", "-o", "page.html"],
        &["rustup target add wasm32-unknown-unknown"],
    );
}
