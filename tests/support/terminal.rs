//! Runs the binary in a terminal of a given width, or without a terminal.

use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, Command, Output, Stdio};
use std::thread;

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};

/// Marks the end of the output of a terminal; no command prints this byte.
const END: u8 = 0;

/// Output of a command on a terminal and on the other stream, which is a pipe.
pub struct TerminalOutput {
    pub screen: String,
    pub other_stream: String,
    pub status: Option<i32>,
}

/// Opens a pseudo-terminal. Returns the controller, from which the output is read, and the terminal end.
pub fn open_terminal(columns: u16) -> (File, File) {
    let controller = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
    grantpt(&controller).expect("access to the terminal");
    unlockpt(&controller).expect("an open terminal");
    let size = Winsize { ws_row: 40, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 };
    tcsetwinsize(&controller, size).expect("a terminal of that size");
    let name = ptsname(&controller, Vec::new()).expect("the name of the terminal").into_string().expect("text");
    let terminal_end = OpenOptions::new().read(true).write(true).open(name).expect("the terminal end");
    (File::from(controller), terminal_end)
}

/// A command without the environment variables that set width and colours, on a terminal of a fixed type.
pub fn command(args: &[&str], settings: &[(&str, &str)]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
    // If CI is set, colours are used on a dumb terminal too.
    for name in ["COLUMNS", "NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "CI"] {
        command.env_remove(name);
    }
    command.args(args).stdin(Stdio::null()).env("TERM", "xterm-256color").envs(settings.iter().copied());
    command
}

/// Starts a command with stdout, or with stderr, on a terminal; the other stream is a pipe. Returns the two ends of the
/// terminal too.
pub fn spawn_on_terminal(mut command: Command, stderr_on_terminal: bool, columns: u16) -> (Child, File, File) {
    let (controller, terminal_end) = open_terminal(columns);
    let output_end = terminal_end.try_clone().expect("a second handle of the terminal end");
    match stderr_on_terminal {
        false => command.stdout(output_end).stderr(Stdio::piped()),
        true => command.stderr(output_end).stdout(Stdio::piped()),
    };
    (command.spawn().expect("the binary starts"), controller, terminal_end)
}

/// Runs a command with stdout on a terminal of the given width.
pub fn run_on_terminal(columns: u16, settings: &[(&str, &str)], args: &[&str]) -> TerminalOutput {
    collect_output(spawn_on_terminal(command(args, settings), false, columns))
}

/// Runs a command with stderr on a terminal.
pub fn run_with_stderr_on_terminal(args: &[&str]) -> TerminalOutput {
    collect_output(spawn_on_terminal(command(args, &[]), true, 100))
}

fn collect_output((mut child, controller, mut terminal_end): (Child, File, File)) -> TerminalOutput {
    let mut pipe: Box<dyn Read + Send> = match (child.stdout.take(), child.stderr.take()) {
        (Some(stdout), _) => Box::new(stdout),
        (None, Some(stderr)) => Box::new(stderr),
        (None, None) => Box::new(std::io::empty()),
    };
    let other_stream = thread::spawn(move || {
        let mut text = String::new();
        pipe.read_to_string(&mut text).map(|_| text)
    });
    // If the terminal end is closed, the controller may report the end before all output is read: the kernel checks for
    // input first, then for closed ends. Therefore END marks the end of the output, and the terminal end stays open
    // until END has been read.
    let status = thread::spawn(move || {
        let status = child.wait().expect("ended").code();
        terminal_end.write_all(&[END]).expect("a readable terminal");
        (status, terminal_end)
    });
    let mut bytes = Vec::new();
    BufReader::new(controller).read_until(END, &mut bytes).expect("an open terminal");
    assert_eq!(bytes.pop(), Some(END), "the terminal ended without END");
    let other_stream = other_stream.join().expect("read").expect("text");
    let (status, _theirs) = status.join().expect("joined");
    TerminalOutput { screen: String::from_utf8(bytes).expect("text").replace("\r\n", "\n"), other_stream, status }
}

/// Runs a command without a terminal.
pub fn run_piped(settings: &[(&str, &str)], args: &[&str]) -> Output {
    command(args, settings).output().expect("the binary starts")
}
