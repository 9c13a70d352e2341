//! What every published solver is as a contestant: it integrates, watched or not.

use crate::field::Watcher;
use crate::support::Contestant;
use crate::support::problem::Problem;
use crate::support::track::{Cost, Track};

/// A solver of another crate at one relative tolerance.
pub trait Published {
    const METHOD: &str;

    fn rtol(&self) -> f64;

    /// Integrates; a watcher looks at every step.
    fn integrate(&self, problem: &Problem, watcher: Option<&mut Watcher>) -> Result<Cost, String>;
}

impl<P: Published> Contestant for P {
    fn method(&self) -> &str {
        P::METHOD
    }

    fn rtol(&self) -> f64 {
        Published::rtol(self)
    }

    fn run(&self, problem: &Problem) -> Result<Cost, String> {
        self.integrate(problem, None)
    }

    fn follow(&self, problem: &Problem) -> Track {
        let mut watcher = Watcher::new(problem);
        let result = self.integrate(problem, Some(&mut watcher));
        watcher.finish(result)
    }
}
