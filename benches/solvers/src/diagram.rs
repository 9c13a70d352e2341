//! Work and precision of one case: times and errors of all solvers at several tolerances.

use std::hint::black_box;
use std::time::Instant;

use phalanx::integrator::{
    Hybrid, Layout, Method as _, Observer, Options, SwitchedMethod, State, Step, StepTools, Tolerances, integrate_by,
};
use phalanx::scene::{Integrator, Method, Preset};
use serde::Serialize;

use crate::case::{Case, CaseEquations};
use crate::equations::GeneralSolver;
use crate::support::absolute_tolerances;
use crate::support::precision::{median, reference_settings, sorted, worst};
use crate::support::rtols;
use crate::support::trajectory::{Cost, largest};
use crate::vector_field::MAX_STEPS;

/// Number of members of the ensemble.
pub const MEMBERS: usize = 5;

/// Spacing of the compared states, s.
const SPACING_S: f64 = 1e-4;

/// Error from which a run is not timed: it has nothing to do with the solution.
const MEANINGLESS: f64 = 1.0;

/// A method with its tolerances.
#[derive(Clone, Copy, Debug)]
enum Solver {
    Phalanx(Method, Tolerances, Option<&'static str>),
    #[cfg(feature = "cvode")]
    Cvode(f64),
    #[cfg(feature = "diffsol")]
    Diffsol(f64),
}

/// Errors of one run: largest difference of an angle, and of the object's position over its radius.
#[derive(Clone, Copy, Debug, Serialize)]
struct RunErrors {
    angle_rad: f64,
    position: Option<f64>,
}

/// Median and largest error over the ensemble.
#[derive(Clone, Copy, Debug, Serialize)]
struct Spread {
    median: f64,
    worst: f64,
}

/// Result of one solver; errors and time are null if a run failed.
#[derive(Clone, Debug, Serialize)]
struct Row {
    method: &'static str,
    preset: Option<&'static str>,
    rtol: f64,
    angle_rad: Option<Spread>,
    position: Option<Spread>,
    failed: usize,
    failure: Option<String>,
    cost: Option<Cost>,
    time_s: Option<f64>,
    repetitions: usize,
}

/// Results of all solvers for one case.
#[derive(Clone, Debug, Serialize)]
pub struct Diagram {
    case: String,
    duration_s: f64,
    members: usize,
    object_radius_m: Option<f64>,
    /// Largest difference of the two references.
    floor_angle_rad: f64,
    floor_position: Option<f64>,
    rows: Vec<Row>,
}

/// The compared coordinates at multiples of [`SPACING_S`].
type Grid = Vec<Vec<f64>>;

impl Solver {
    fn all(everyday: Integrator) -> Vec<Self> {
        let presets = [(everyday, "engineering"), (Integrator::preset(Preset::Reference), "reference")];
        let presets = presets.map(|(settings, name)| {
            let tolerances =
                Tolerances { atol_q: settings.atol_angle_rad, atol_v: settings.atol_rate_rad_s, rtol_v: settings.rtol };
            Self::Phalanx(settings.method, tolerances, Some(name))
        });
        let phalanx = |method| {
            rtols().map(move |rtol| {
                let (atol_q, atol_v) = absolute_tolerances(rtol);
                Self::Phalanx(method, Tolerances { atol_q, atol_v, rtol_v: rtol }, None)
            })
        };
        let mut all: Vec<Self> =
            presets.into_iter().chain(phalanx(Method::Rodas5p)).chain(phalanx(Method::RadauIIa5)).collect();
        #[cfg(feature = "cvode")]
        all.extend(rtols().map(Self::Cvode));
        #[cfg(feature = "diffsol")]
        all.extend(rtols().map(Self::Diffsol));
        all
    }

    fn name(&self) -> (&'static str, Option<&'static str>, f64) {
        match self {
            Self::Phalanx(Method::Rodas5p, tolerances, preset) => ("phalanx Rodas5P", *preset, tolerances.rtol_v),
            Self::Phalanx(Method::RadauIIa5, tolerances, preset) => ("phalanx Radau IIA 5", *preset, tolerances.rtol_v),
            #[cfg(feature = "cvode")]
            Self::Cvode(rtol) => (<crate::cvode::Cvode as GeneralSolver>::METHOD, None, *rtol),
            #[cfg(feature = "diffsol")]
            Self::Diffsol(rtol) => (<crate::bdf::Bdf as GeneralSolver>::METHOD, None, *rtol),
        }
    }

    /// Integrates a case; `grid` receives the states.
    fn run<M: Hybrid>(&self, case: &Case<M>, grid: Option<&mut Grid>) -> Result<Cost, String> {
        match self {
            Self::Phalanx(method, tolerances, _) => run_phalanx(case, *method, *tolerances, grid),
            #[cfg(feature = "cvode")]
            Self::Cvode(rtol) => run_published(case, &crate::cvode::Cvode { rtol: *rtol }, grid),
            #[cfg(feature = "diffsol")]
            Self::Diffsol(rtol) => run_published(case, &crate::bdf::Bdf { rtol: *rtol }, grid),
        }
    }
}

fn run_phalanx<M: Hybrid>(
    case: &Case<M>,
    method: Method,
    tolerances: Tolerances,
    grid: Option<&mut Grid>,
) -> Result<Cost, String> {
    let layout = case.kernel.layout();
    let method = match method {
        Method::Rodas5p => SwitchedMethod::rodas(layout),
        Method::RadauIIa5 => SwitchedMethod::new(layout),
    };
    let options = Options { tolerances, max_steps: MAX_STEPS as u64 };
    let Case { kernel, start, duration_s, coordinate_count, .. } = case;
    let start = start.clone();
    let end = match grid {
        None => integrate_by(method, kernel, &options, 0.0, start, *duration_s, &mut ()),
        Some(grid) => {
            let mut recorder = Recorder { grid, count: *coordinate_count };
            integrate_by(method, kernel, &options, 0.0, start, *duration_s, &mut recorder)
        }
    };
    let counters = end.counters;
    end.result.map_err(|failure| failure.to_string())?;
    let phalanx::integrator::Counters { steps, rejected, rhs, jacobians, .. } = counters;
    Ok(Cost { rhs, jacobians, steps, rejected })
}

fn run_published<G: GeneralSolver, M: Hybrid>(
    case: &Case<M>,
    solver: &G,
    grid: Option<&mut Grid>,
) -> Result<Cost, String> {
    let equations = CaseEquations::new(case);
    let problem = equations.problem();
    let steps = match grid {
        None => solver.solve(&problem, None),
        Some(grid) => {
            grid.push(problem.start[..case.coordinate_count].to_vec());
            solver.solve(
                &problem,
                Some(&mut |_, t1, y, interpolate| {
                    while grid.len() as f64 * SPACING_S <= t1 + 1e-15 {
                        let t = grid.len() as f64 * SPACING_S;
                        let Some(y) = (if t < t1 { interpolate(t) } else { Some(y.to_vec()) }) else { break };
                        grid.push(y[..case.coordinate_count].to_vec());
                    }
                }),
            )
        }
    }?;
    let (rhs, jacobians) = (equations.rhs.get(), equations.jacobians.get());
    Ok(Cost { rhs, jacobians, steps: steps.accepted as u64, rejected: steps.rejected as u64 })
}

/// Records the states of phalanx on the grid.
struct Recorder<'a> {
    grid: &'a mut Grid,
    count: usize,
}

impl<L: Layout, Mode> Observer<L, Mode> for Recorder<'_> {
    fn step(&mut self, step: &Step<L>, _: &Mode, tools: &mut dyn StepTools<L>) -> bool {
        loop {
            let t = self.grid.len() as f64 * SPACING_S;
            if t > step.t1 + 1e-15 {
                return true;
            }
            let State { q, .. } = tools.interpolate((t - step.t0) / step.h).clone();
            self.grid.push(q.as_ref()[..self.count].to_vec());
        }
    }

    fn event(&mut self, _: f64, _: &State<L>, _: usize, _: &Mode) {}
}

/// Differences of two runs; infinite if one of them is shorter.
fn distance(a: &Grid, b: &Grid, object_radius_m: Option<f64>) -> RunErrors {
    let infinite = |is_equal_length| if is_equal_length { 0.0 } else { f64::INFINITY };
    let difference = |indices: &[usize]| {
        let rows = a.iter().zip(b).flat_map(|(x, y)| indices.iter().map(move |i| (x[*i] - y[*i]).abs()));
        largest(rows.chain([infinite(a.len() == b.len())]))
    };
    match object_radius_m {
        None => RunErrors { angle_rad: difference(&[0, 1]), position: None },
        Some(radius_m) => {
            RunErrors { angle_rad: difference(&[0, 1, 2, 3, 6]), position: Some(difference(&[4, 5]) / radius_m) }
        }
    }
}

fn spread(errors: &[f64]) -> Spread {
    let errors = sorted(errors.iter().copied());
    Spread { median: median(&errors), worst: worst(&errors) }
}

/// Measures all solvers. `rounds` is the number of timed runs of each; all solvers run once per round.
pub fn measure<M: Hybrid>(name: &str, members: &[Case<M>], rounds: usize) -> Diagram {
    let record = |solver: &Solver, case: &Case<M>| {
        let mut grid = Grid::new();
        solver.run(case, Some(&mut grid)).map(|cost| (grid, cost))
    };
    let references: Vec<[Grid; 2]> = members
        .iter()
        .map(|case| {
            reference_settings().map(|settings| {
                let solver = Solver::Phalanx(settings.method, settings.tolerances, None);
                record(&solver, case).unwrap_or_else(|error| panic!("{name}: the reference failed: {error}")).0
            })
        })
        .collect();
    let radius_m = members[0].object_radius_m;
    let floors: Vec<RunErrors> = references.iter().map(|[a, b]| distance(a, b, radius_m)).collect();
    let solvers = Solver::all(members[0].everyday);
    let mut rows: Vec<Row> = solvers
        .iter()
        .map(|solver| {
            let runs: Vec<_> = members.iter().map(|case| record(solver, case)).collect();
            let failures: Vec<&String> = runs.iter().filter_map(|run| run.as_ref().err()).collect();
            // The larger of the distances from both references.
            let errors: Vec<RunErrors> = runs
                .iter()
                .zip(&references)
                .filter_map(|(run, references)| run.as_ref().ok().map(|(grid, _)| (grid, references)))
                .map(|(grid, references)| {
                    let [a, b] = [0, 1].map(|i| distance(grid, &references[i], radius_m));
                    let position = a.position.zip(b.position).map(|(a, b)| a.max(b));
                    RunErrors { angle_rad: a.angle_rad.max(b.angle_rad), position }
                })
                .collect();
            let all_complete = failures.is_empty();
            let angles: Vec<f64> = errors.iter().map(|errors| errors.angle_rad).collect();
            let positions: Vec<f64> = errors.iter().filter_map(|errors| errors.position).collect();
            let (method, preset, rtol) = solver.name();
            eprintln!("{name}: {method} at {rtol:.0e}");
            Row {
                method,
                preset,
                rtol,
                angle_rad: all_complete.then(|| spread(&angles)),
                position: (all_complete && !positions.is_empty()).then(|| spread(&positions)),
                failed: failures.len(),
                failure: failures.first().map(|failure| failure.to_string()),
                cost: runs[0].as_ref().ok().map(|(_, cost)| *cost),
                time_s: None,
                repetitions: 0,
            }
        })
        .collect();
    let mut times = vec![Vec::new(); solvers.len()];
    for round in 0..=rounds {
        for ((solver, row), times) in solvers.iter().zip(&rows).zip(&mut times) {
            if row.angle_rad.is_none_or(|angle| angle.median > MEANINGLESS) {
                continue;
            }
            let case = &members[round % members.len()];
            let start = Instant::now();
            black_box(solver.run(black_box(case), None)).ok();
            let elapsed = start.elapsed().as_secs_f64();
            // The first round warms up.
            if round > 0 {
                times.push(elapsed);
            }
        }
    }
    for (row, times) in rows.iter_mut().zip(times) {
        row.repetitions = times.len();
        row.time_s = (!times.is_empty()).then(|| median(&sorted(times.into_iter())));
    }
    Diagram {
        case: name.to_string(),
        duration_s: members[0].duration_s,
        members: members.len(),
        object_radius_m: radius_m,
        floor_angle_rad: largest(floors.iter().map(|errors| errors.angle_rad)),
        floor_position: radius_m.map(|_| largest(floors.iter().filter_map(|errors| errors.position))),
        rows,
    }
}
