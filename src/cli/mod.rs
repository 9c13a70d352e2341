//! The command line: arguments in, text out, an exit status.

pub mod scene;
