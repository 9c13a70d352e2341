//! The `phalanx` command; see [`phalanx::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    phalanx::cli::main()
}
