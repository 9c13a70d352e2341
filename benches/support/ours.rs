//! The integrators of this crate.

use phalanx::analytic::{FingerMode, GUARDS, Model, QUADRATURES, SiteState};
use phalanx::integrator::{
    Counters, End, Method as Stepper, Observer, Options, RadauOrRodas, Reason, Rodas5p, State, Step, StepTools,
    Tolerances, integrate,
};
use phalanx::scene::{Integrator, Method, Preset};

use super::Contestant;
use super::problem::Problem;
use super::track::{Cost, Ended, GRID_S, Track};

/// Budget of steps: thirty times what the tightest tolerance here takes.
const MAX_STEPS: u64 = 1_000_000;

/// A method of this crate with its tolerances.
#[derive(Clone, Debug)]
pub struct Ours {
    pub method: Method,
    pub tolerances: Tolerances,
    pub preset: Option<&'static str>,
}

impl Ours {
    pub fn new(method: Method, rtol: f64, atol_angle: f64, atol_rate: f64) -> Self {
        Self { method, tolerances: Tolerances { atol_q: atol_angle, atol_v: atol_rate, rtol_v: rtol }, preset: None }
    }

    /// A method at one point of the sweep over tolerances.
    pub fn at(method: Method, rtol: f64) -> Self {
        let (angle, rate) = super::absolute(rtol);
        Self::new(method, rtol, angle, rate)
    }

    /// The settings a user names.
    pub fn preset(preset: Preset) -> Self {
        let settings = Integrator::preset(preset);
        let name = match preset {
            Preset::Engineering => "engineering",
            Preset::Reference => "reference",
        };
        let plain = Self::new(settings.method, settings.rtol, settings.atol_angle_rad, settings.atol_rate_rad_s);
        Self { preset: Some(name), ..plain }
    }

    fn integrate<O: Observer<2, QUADRATURES, FingerMode>>(
        &self,
        problem: &Problem,
        observer: &mut O,
    ) -> End<2, QUADRATURES> {
        match self.method {
            Method::Rodas5p => self.with::<Rodas5p<2, QUADRATURES>, O>(problem, observer),
            Method::RadauIIa5 => self.with::<RadauOrRodas<2, QUADRATURES>, O>(problem, observer),
        }
    }

    fn with<K, O>(&self, problem: &Problem, observer: &mut O) -> End<2, QUADRATURES>
    where
        K: Stepper<2, QUADRATURES>,
        O: Observer<2, QUADRATURES, FingerMode>,
    {
        let options = Options { tolerances: self.tolerances, max_steps: MAX_STEPS };
        let Problem { model, start, .. } = problem;
        integrate::<2, QUADRATURES, GUARDS, Model, K, O>(model, &options, 0.0, *start, problem.duration_s(), observer)
    }
}

impl Contestant for Ours {
    fn method(&self) -> &str {
        match self.method {
            Method::Rodas5p => "phalanx Rodas5P",
            Method::RadauIIa5 => "phalanx Radau IIA 5",
        }
    }

    fn preset(&self) -> Option<&str> {
        self.preset
    }

    fn rtol(&self) -> f64 {
        self.tolerances.rtol_v
    }

    fn is_ours(&self) -> bool {
        true
    }

    fn run(&self, problem: &Problem) -> Result<Cost, String> {
        let end = self.integrate(problem, &mut ());
        end.result.map(|()| cost(&end.counters)).map_err(|failure| failure.to_string())
    }

    fn follow(&self, problem: &Problem) -> Track {
        let mut eye = Eye { grid: Vec::with_capacity(81), touch_s: [None; 2] };
        let end = self.integrate(problem, &mut eye);
        let ended = match end.result {
            Ok(()) => Ended::Complete,
            Err(failure) => match failure.reason {
                Reason::Obstacle(_) => Ended::Singular(failure.time_s),
                reason => Ended::Failed(reason.to_string()),
            },
        };
        Track {
            grid: eye.grid,
            touch_s: eye.touch_s,
            impulse: Some([end.state.z[0], end.state.z[1]]),
            deepest_m: None,
            ended,
            cost: cost(&end.counters),
        }
    }
}

fn cost(counters: &Counters) -> Cost {
    Cost { rhs: counters.rhs, jacobians: counters.jacobians, steps: counters.steps, rejected: counters.rejected }
}

/// Records the trajectory on the grid, and the first touches.
struct Eye {
    grid: Vec<[f64; 2]>,
    touch_s: [Option<f64>; 2],
}

impl Observer<2, QUADRATURES, FingerMode> for Eye {
    fn step(&mut self, step: &Step<2, QUADRATURES>, _: &FingerMode, tools: &mut dyn StepTools<2, QUADRATURES>) -> bool {
        loop {
            let t = self.grid.len() as f64 * GRID_S;
            if t > step.t1 + 1e-15 {
                return true;
            }
            self.grid.push(tools.interpolate((t - step.t0) / step.h).q);
        }
    }

    fn event(&mut self, t: f64, _: &State<2, QUADRATURES>, site: usize, mode: &FingerMode) {
        if site < 2 && mode[site] == SiteState::Active {
            self.touch_s[site].get_or_insert(t);
        }
    }
}
