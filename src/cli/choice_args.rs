//! Value enums of the command line for enums of the simulation core.

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
    fn from(arg: ModelArg) -> Self {
        match arg {
            ModelArg::Analytic => Model::Analytic,
            ModelArg::Engine => Model::Engine,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RuleArg {
    /// RMS of the net motor torque until the proximal contact
    Rigid,
    /// RMS over the whole trajectory, against the constant spring
    Whole,
}

impl From<RuleArg> for Rule {
    fn from(arg: RuleArg) -> Self {
        match arg {
            RuleArg::Rigid => Rule::Rigid,
            RuleArg::Whole => Rule::Whole,
        }
    }
}
