//! Words of the command line for choices that the core knows.

use clap::ValueEnum;

use crate::sizing::Rule;
use crate::trace::Model;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ModelArg {
    /// Closed-form Lagrange model with its own stiff integrator
    Analytic,
    /// Rigid-body engine with the same contact laws
    Engine,
}

impl From<ModelArg> for Model {
    fn from(word: ModelArg) -> Self {
        match word {
            ModelArg::Analytic => Model::Analytic,
            ModelArg::Engine => Model::Engine,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RuleArg {
    /// RMS of the net motor torque until the proximal contact
    Rigid,
    /// RMS over all the trajectory, against the constant spring
    Whole,
}

impl From<RuleArg> for Rule {
    fn from(word: RuleArg) -> Self {
        match word {
            RuleArg::Rigid => Rule::Rigid,
            RuleArg::Whole => Rule::Whole,
        }
    }
}
