//! Output of a command that returns its text instead of printing it.

/// Text for both output streams, and the result of a command.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CommandOutput {
    pub stdout: String,
    pub stderr: String,
    /// Whether all input was valid.
    pub is_valid: bool,
}
