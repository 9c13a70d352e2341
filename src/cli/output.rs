//! Writing to stdout and stderr without a panic when the reader has gone.

use std::io::{self, ErrorKind, Write};

use super::Failure;

/// Prints to stdout. A reader that has seen enough (`| head`) is no error.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::incomplete(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints a message to stderr, as far as that takes it.
pub fn complain(message: &str) {
    let _ = writeln!(io::stderr().lock(), "{message}");
}
