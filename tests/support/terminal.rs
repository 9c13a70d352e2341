//! Runs the binary in a terminal of a chosen width, or without one.

use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, Command, Output, Stdio};
use std::thread;

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};

/// What no command prints: what was shown on a terminal ends here.
const END: u8 = 0;

/// What a command showed on a terminal, and what went to the other stream.
pub struct Seen {
    pub screen: String,
    pub other: String,
    pub status: Option<i32>,
}

/// The two ends of a terminal: what is shown is read from the first.
pub fn terminal(columns: u16) -> (File, File) {
    let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
    grantpt(&ours).expect("a terminal for us");
    unlockpt(&ours).expect("an open terminal");
    let size = Winsize { ws_row: 40, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 };
    tcsetwinsize(&ours, size).expect("a terminal of that size");
    let name = ptsname(&ours, Vec::new()).expect("its name").into_string().expect("text");
    let theirs = OpenOptions::new().read(true).write(true).open(name).expect("its other end");
    (File::from(ours), theirs)
}

/// Whatever is set around the tests says nothing about widths, colours and the kind of the terminal.
pub fn command(args: &[&str], settings: &[(&str, &str)]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
    // CI is one of them: where it is set, colours are taken to be wanted on a dumb terminal too.
    for name in ["COLUMNS", "NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "CI"] {
        command.env_remove(name);
    }
    command.args(args).stdin(Stdio::null()).env("TERM", "xterm-256color").envs(settings.iter().copied());
    command
}

/// Starts a command with stdout, or with stderr, on a terminal, whose two ends come with it. The other stream is a pipe.
pub fn start(mut command: Command, errors: bool, columns: u16) -> (Child, File, File) {
    let (ours, theirs) = terminal(columns);
    let its = theirs.try_clone().expect("the same end again");
    match errors {
        false => command.stdout(its).stderr(Stdio::piped()),
        true => command.stderr(its).stdout(Stdio::piped()),
    };
    (command.spawn().expect("the binary starts"), ours, theirs)
}

/// Runs a command with stdout on a terminal of so many columns.
pub fn on_terminal(columns: u16, settings: &[(&str, &str)], args: &[&str]) -> Seen {
    seen(start(command(args, settings), false, columns))
}

/// Runs a command with stderr on a terminal.
pub fn errors_on_terminal(args: &[&str]) -> Seen {
    seen(start(command(args, &[]), true, 100))
}

fn seen((mut child, ours, mut theirs): (Child, File, File)) -> Seen {
    let mut pipe: Box<dyn Read + Send> = match (child.stdout.take(), child.stderr.take()) {
        (Some(stdout), _) => Box::new(stdout),
        (None, Some(stderr)) => Box::new(stderr),
        (None, None) => Box::new(std::io::empty()),
    };
    let other = thread::spawn(move || {
        let mut text = String::new();
        pipe.read_to_string(&mut text).map(|_| text)
    });
    // A terminal whose other end is closed may end before all that was written to it was read: the kernel looks for input first, and
    // then whether the end is closed. So ours says itself when the command has ended, and stays open until that has been read.
    let status = thread::spawn(move || {
        let status = child.wait().expect("ended").code();
        theirs.write_all(&[END]).expect("a terminal that is read");
        (status, theirs)
    });
    let mut bytes = Vec::new();
    BufReader::new(ours).read_until(END, &mut bytes).expect("an open terminal");
    assert_eq!(bytes.pop(), Some(END), "the terminal ended by itself");
    let other = other.join().expect("read").expect("text");
    let (status, _theirs) = status.join().expect("waited for");
    Seen { screen: String::from_utf8(bytes).expect("text").replace("\r\n", "\n"), other, status }
}

/// Runs a command without a terminal.
pub fn piped(settings: &[(&str, &str)], args: &[&str]) -> Output {
    command(args, settings).output().expect("the binary starts")
}
