//! The integrators of phalanx as benchmark solvers.

use phalanx::analytic::{ContactState, FingerMode, Model, QUADRATURES};
use phalanx::integrator::{
    Counters, End, Fixed, Method as Stepper, Observer, Options, Reason, Rodas5p, State, Step, StepTools,
    SwitchedMethod, Tolerances, integrate,
};
use phalanx::scene::{Integrator, Method, Preset};

use super::BenchSolver;
use super::problem::Problem;
use super::trajectory::{Cost, EndState, GRID_S, Trajectory};

/// Layout of a finger.
pub type FingerLayout = Fixed<2, QUADRATURES>;

/// Step limit: thirty times the number of steps at the tightest tolerance of the benchmarks.
const MAX_STEPS: u64 = 1_000_000;

/// A method of phalanx with its tolerances.
#[derive(Clone, Debug)]
pub struct PhalanxSolver {
    pub method: Method,
    pub tolerances: Tolerances,
    pub preset: Option<&'static str>,
}

impl PhalanxSolver {
    pub fn new(method: Method, rtol: f64, atol_angle: f64, atol_rate: f64) -> Self {
        Self { method, tolerances: Tolerances { atol_q: atol_angle, atol_v: atol_rate, rtol_v: rtol }, preset: None }
    }

    /// Returns a method at one point of the sweep over tolerances.
    pub fn with_rtol(method: Method, rtol: f64) -> Self {
        let (angle, rate) = super::absolute_tolerances(rtol);
        Self::new(method, rtol, angle, rate)
    }

    /// Returns the settings of a preset.
    pub fn from_preset(preset: Preset) -> Self {
        let settings = Integrator::preset(preset);
        let name = match preset {
            Preset::Draft => "draft",
            Preset::Engineering => "engineering",
            Preset::Reference => "reference",
        };
        let solver = Self::new(settings.method, settings.rtol, settings.atol_angle_rad, settings.atol_rate_rad_s);
        Self { preset: Some(name), ..solver }
    }

    fn integrate<O: Observer<FingerLayout, FingerMode>>(
        &self,
        problem: &Problem,
        observer: &mut O,
    ) -> End<FingerLayout> {
        match self.method {
            Method::Rodas5p => self.integrate_with::<Rodas5p<FingerLayout>, O>(problem, observer),
            Method::RadauIIa5 => self.integrate_with::<SwitchedMethod<FingerLayout>, O>(problem, observer),
        }
    }

    fn integrate_with<K, O>(&self, problem: &Problem, observer: &mut O) -> End<FingerLayout>
    where
        K: Stepper<FingerLayout>,
        O: Observer<FingerLayout, FingerMode>,
    {
        let options = Options { tolerances: self.tolerances, max_steps: MAX_STEPS };
        let Problem { model, start, .. } = problem;
        integrate::<Model, K, O>(model, &options, 0.0, start.clone(), problem.duration_s(), observer)
    }
}

impl BenchSolver for PhalanxSolver {
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

    fn is_phalanx(&self) -> bool {
        true
    }

    fn run(&self, problem: &Problem) -> Result<Cost, String> {
        let end = self.integrate(problem, &mut ());
        end.result.map(|()| cost(&end.counters)).map_err(|failure| failure.to_string())
    }

    fn record(&self, problem: &Problem) -> Trajectory {
        let mut recorder = TrajectoryRecorder { grid: Vec::with_capacity(81), first_contact_s: [None; 2] };
        let end = self.integrate(problem, &mut recorder);
        let end_state = match end.result {
            Ok(()) => EndState::Complete,
            Err(failure) => match failure.reason {
                Reason::Obstacle(_) => EndState::Singular(failure.time_s),
                reason => EndState::Failed(reason.to_string()),
            },
        };
        Trajectory {
            grid: recorder.grid,
            first_contact_s: recorder.first_contact_s,
            impulse: Some([end.state.z[0], end.state.z[1]]),
            max_penetration_m: None,
            end_state,
            cost: cost(&end.counters),
        }
    }
}

fn cost(counters: &Counters) -> Cost {
    Cost { rhs: counters.rhs, jacobians: counters.jacobians, steps: counters.steps, rejected: counters.rejected }
}

/// Records the trajectory on the grid, and the first contacts.
struct TrajectoryRecorder {
    grid: Vec<[f64; 2]>,
    first_contact_s: [Option<f64>; 2],
}

impl Observer<FingerLayout, FingerMode> for TrajectoryRecorder {
    fn step(&mut self, step: &Step<FingerLayout>, _: &FingerMode, tools: &mut dyn StepTools<FingerLayout>) -> bool {
        loop {
            let t = self.grid.len() as f64 * GRID_S;
            if t > step.t1 + 1e-15 {
                return true;
            }
            self.grid.push(tools.interpolate((t - step.t0) / step.h).q);
        }
    }

    fn event(&mut self, t: f64, _: &State<FingerLayout>, contact: usize, mode: &FingerMode) {
        if contact < 2 && mode[contact] == ContactState::Active {
            self.first_contact_s[contact].get_or_insert(t);
        }
    }
}
