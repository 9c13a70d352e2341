//! The first minutes with the program: a new scene, a run, its page on the screen.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::support::cli::{ANCHOR, directory, json, phalanx, stderr, stdout, variant, write};
use phalanx::scene;

/// The command in a session that has no screen and no browser, but for what is set here.
fn with(settings: &[(&str, &str)], args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
    for name in ["BROWSER", "DISPLAY", "WAYLAND_DISPLAY", "WSL_DISTRO_NAME"] {
        command.env_remove(name);
    }
    command.envs(settings.iter().copied()).args(args).output().expect("the binary starts")
}

/// A program that writes down what it was asked to open, and ends with a status.
#[cfg(unix)]
fn browser(directory: &Path, status: u8) -> String {
    use std::os::unix::fs::PermissionsExt;
    let script = format!("#!/bin/sh\nprintf '%s' \"$1\" > '{}/opened'\nexit {status}\n", directory.display());
    let path = write(directory, "browser", &script);
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("an executable file");
    path
}

#[test]
fn a_new_scene_runs_as_it_is_and_says_what_can_be_changed() {
    let directory = directory("cli_new");
    let place = directory.join("my gripper.toml");
    let file = place.to_str().expect("text");
    let output = phalanx(&["new", file]);
    assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""));
    assert!(stdout(&output).starts_with(&format!("wrote {file}")), "{}", stdout(&output));

    let text = fs::read_to_string(&place).expect("the scene");
    for section in ["[design]", "[object]", "[motor]", "[spring]", "[contact.friction]", "[initial]"] {
        assert!(text.contains(section), "{section}");
    }
    let values = text.lines().filter(|line| line.contains(" = ") && !line.starts_with('#'));
    assert!(values.count() >= 10 && text.matches('#').count() >= 20);
    let scene = scene::load(&place).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.name, "my gripper");
    // It is the anchor, whose outcome is known.
    assert_eq!(scene.finger().linkage, scene::load(ANCHOR).expect("the anchor").finger().linkage);
    let output = phalanx(&["run", file, "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(json(&output)["criteria"]["class"], "stable");
}

#[test]
fn a_new_scene_replaces_nothing() {
    let directory = directory("cli_new_refused");
    let mine = write(&directory, "mine.toml", "my work");
    let nowhere = directory.join("nowhere/scene.toml").display().to_string();
    for (file, part) in [
        (mine.as_str(), "something of that name already"),
        (directory.to_str().expect("text"), "something of that name already"),
        (nowhere.as_str(), "give a file in a directory where you may write"),
    ] {
        let output = phalanx(&["new", file]);
        assert_eq!((output.status.code(), stdout(&output)), (Some(2), ""), "{file}");
        assert!(stderr(&output).contains(file) && stderr(&output).contains(part), "{}", stderr(&output));
    }
    assert_eq!(fs::read_to_string(&mine).expect("the file"), "my work");
}

#[test]
fn a_run_writes_its_page() {
    let directory = directory("cli_run_html");
    let place = |name: &str| directory.join(name).to_str().expect("text").to_string();
    for (scene, model) in [(ANCHOR, "analytic"), (ANCHOR, "engine"), ("scenes/laws/impact.toml", "analytic")] {
        let (page, log) = (place("run.html"), place("run.mcap"));
        let output = phalanx(&["run", scene, "--model", model, "--html", &page, "--log", &log]);
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""));
        assert!(stdout(&output).contains(&format!("\npage: {page}\n")), "{}", stdout(&output));
        let of_run = fs::read_to_string(&page).expect("the page");
        // Given to others, it does not say where it was made.
        assert!(!of_run.contains(&directory.display().to_string()));
        // The same film as the page of the log.
        let output = phalanx(&["replay", &log, "--html", &page]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let of_log = fs::read_to_string(&page).expect("the page");
        let data = |html: &str| {
            html.split("id=\"data\">").nth(1).and_then(|rest| rest.split("</script>").next().map(String::from))
        };
        assert!(data(&of_run).is_some());
        assert_eq!(data(&of_run), data(&of_log), "{scene}, {model}");
        let output = phalanx(&["run", scene, "--model", model, "--html", &page, "--json"]);
        assert_eq!(json(&output)["page"], page.as_str());
    }
}

#[test]
fn a_run_that_stops_shows_how_far_it_came() {
    let directory = directory("cli_run_html_stopped");
    let page = directory.join("run.html");
    let scene = variant(&directory, "few-steps.toml", "[integrator]\nmax_steps = 60");
    let output = phalanx(&["run", &scene, "--html", page.to_str().expect("text")]);
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    assert!(fs::read_to_string(&page).expect("the page").contains("NOT COMPLETED"));
}

#[cfg(unix)]
#[test]
fn the_page_is_opened_with_the_browser_of_the_session() {
    let directory = directory("cli_open");
    let page = directory.join("run.html");
    let browser = browser(&directory, 0);
    let output = with(&[("BROWSER", &browser)], &["run", ANCHOR, "--open", "--html", page.to_str().expect("text")]);
    assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""));
    let opened = || fs::read_to_string(directory.join("opened")).expect("the browser was started");
    assert_eq!(Path::new(&opened()), page.canonicalize().expect("the page"));
    // Without a name it is a temporary file, which stays for the browser.
    let temporary = directory.join("tmp");
    fs::create_dir(&temporary).expect("a directory");
    let settings = [("BROWSER", browser.as_str()), ("TMPDIR", temporary.to_str().expect("text"))];
    let output = with(&settings, &["run", ANCHOR, "--open"]);
    assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""));
    assert!(Path::new(&opened()).starts_with(temporary.canonicalize().expect("a directory")), "{}", opened());
    assert!(stdout(&output).contains("\npage: "), "{}", stdout(&output));
    assert!(fs::read_to_string(opened()).expect("the page").starts_with("<!DOCTYPE html>"));
}

/// What `--watch` prints, as it comes.
#[cfg(unix)]
#[test]
fn a_scene_that_is_saved_is_run_again() {
    use std::io::{BufRead, BufReader};
    use std::process::Stdio;
    use std::sync::mpsc::channel;
    use std::time::Duration;

    let directory = directory("cli_watch");
    let scene = write(&directory, "scene.toml", &fs::read_to_string(ANCHOR).expect("the anchor"));
    let page = directory.join("run.html");
    let mut child = Command::new(env!("CARGO_BIN_EXE_phalanx"))
        .args(["run", &scene, "--watch", "--no-check", "--html", page.to_str().expect("text")])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary starts");
    let (send, lines) = channel();
    let errors = BufReader::new(child.stderr.take().expect("stderr"));
    let reader =
        std::thread::spawn(move || errors.lines().map_while(Result::ok).for_each(|line| drop(send.send(line))));
    let wait_for = |part: &str| {
        while !lines.recv_timeout(Duration::from_secs(60)).expect(part).contains(part) {}
    };
    wait_for("save it and it runs again");
    let first = fs::read_to_string(&page).expect("the page");
    // A mistake is told, and does not end it; its correction runs.
    write(&directory, "scene.toml", "[design]\nbase = 3\n");
    wait_for("error:");
    wait_for("save it and it runs again");
    variant(&directory, "scene.toml", "[initial]\noffset = \"20 deg\"");
    wait_for("save it and it runs again");
    assert_ne!(fs::read_to_string(&page).expect("the page"), first);
    let asked = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    assert!(asked.success());
    assert_eq!(child.wait().expect("an end").code(), Some(0));
    reader.join().expect("all was read");

    let output = with(&[("BROWSER", "true")], &["run", &scene, "--watch", "--open"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("--html FILE.html"), "{}", stderr(&output));
}

#[cfg(unix)]
#[test]
fn a_browser_that_fails_leaves_the_page() {
    let directory = directory("cli_open_fails");
    let page = directory.join("run.html");
    let browser = browser(&directory, 4);
    let output = with(&[("BROWSER", &browser)], &["run", ANCHOR, "--open", "--html", page.to_str().expect("text")]);
    assert_eq!(output.status.code(), Some(3));
    assert!(
        stderr(&output).contains("could not be opened") && stderr(&output).contains("run.html"),
        "{}",
        stderr(&output)
    );
    assert!(page.exists() && stdout(&output).contains("stable"));
}

#[cfg(target_os = "linux")]
#[test]
fn without_a_browser_nothing_is_simulated_and_the_way_out_is_said() {
    for (settings, part) in [
        (&[][..], "has no screen"),
        (&[("BROWSER", "no-such-program")][..], "names no program"),
        (&[("DISPLAY", ":0"), ("PATH", "/nowhere")][..], "no xdg-open"),
    ] {
        let output = with(settings, &["run", ANCHOR, "--open"]);
        assert_eq!((output.status.code(), stdout(&output)), (Some(2), ""));
        assert!(stderr(&output).contains(part) && stderr(&output).contains("--html FILE.html"), "{}", stderr(&output));
    }
}

#[test]
fn the_explorer_without_its_module_names_the_command_of_the_readme() {
    let output = phalanx(&["explore", "--module", "nowhere.wasm.gz", "-o", "page.html"]);
    let command = "tools/explorer.sh --install";
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains(command), "{}", stderr(&output));
    let readme = include_str!("../../README.md");
    let places = ["\ncargo install --path . --locked\n", command, "\nphalanx explore\n"].map(|of| readme.find(of));
    assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{places:?}");
}
