//! Integration of the tangent equation along a step of the run.

use super::neighbours::{Neighbours, along};
use super::tangent::{Column, Tangent, product};
use crate::integrator::{ErrorWeight, Hybrid, Linearised, Rates, State, Step, StepTools, radau5_tableau};
use crate::numeric::array_from;
use crate::numeric::dense::{factor_lu, solve_lu};
use crate::trace::Kernel;

/// Allowed difference of one step and two half steps, relative to the largest derivative so far. The error of the half
/// steps is a part of 1/31 of it.
const TANGENT_TOLERANCE: f64 = 1e-8;
/// Iterations of a step.
const ITERATIONS: usize = 2;
/// Weight of the relative error of the depth or slip of a contact. The depth is a small difference of coordinates.
const CONTACT_WEIGHT: f64 = 0.1;
/// Largest number of times that a step is halved.
const MAX_HALVINGS: u32 = 12;
/// A step is halved at least this often before its error can count as rounding.
const MIN_HALVINGS: u32 = 3;
/// Ratio of the errors of a half and of the whole above which the error is rounding; at a kink it is 1/2.
const MIN_DECREASE: f64 = 0.8;

impl<'a, M: Kernel<N, Z> + Hybrid<N, Z>, const N: usize, const Z: usize> Tangent<'a, M, N, Z> {
    /// Advances all derivatives over a part of a step, in halves until their error is small.
    pub fn advance(
        &mut self,
        [from, to]: [f64; 2],
        (step, mode): (&Step<N, Z>, &M::Mode),
        tools: &mut dyn StepTools<N, Z>,
        (halvings, error_before): (u32, f64),
    ) {
        if self.columns.iter().all(Result::is_err) {
            return;
        }
        let middle = 0.5 * (from + to);
        let (whole, end) = self.collocate(&self.columns, [from, to], (step, mode), tools);
        let (half, _) = self.collocate(&self.columns, [from, middle], (step, mode), tools);
        let (halves, _) = self.collocate(&half, [middle, to], (step, mode), tools);
        let error = self.difference(&whole, &halves, (&end, mode));
        // Rounding errors do not decrease with the step.
        let is_noise = halvings >= MIN_HALVINGS && error > MIN_DECREASE * error_before;
        if error <= TANGENT_TOLERANCE || halvings == MAX_HALVINGS || is_noise {
            self.columns = halves;
        } else {
            self.advance([from, middle], (step, mode), tools, (halvings + 1, error));
            self.advance([middle, to], (step, mode), tools, (halvings + 1, error));
        }
    }

    /// Derivatives at `to` (a fraction of the step) from those at `from`, by one step of Radau IIA. Not inlined, so that the
    /// recursion of its caller has small frames.
    #[inline(never)]
    fn collocate(
        &self,
        columns: &[Column<N, Z>],
        [from, to]: [f64; 2],
        (step, mode): (&Step<N, Z>, &M::Mode),
        tools: &mut dyn StepTools<N, Z>,
    ) -> (Vec<Column<N, Z>>, State<N, Z>) {
        let (n, h) = (self.kernel.coordinate_count(), (to - from) * step.h);
        let (c, a) = radau5_tableau();
        let mut node = |c: f64| {
            let theta = from + c * (to - from);
            let state = if theta < 1.0 { tools.resolve(theta) } else { *step.end };
            let t = (step.t0 + theta * step.h).max(self.bounds_s[0]).min(self.bounds_s[1]);
            (t, state, Self::linearise(&self.kernel, (t, &state, mode)))
        };
        let nodes: Vec<(f64, State<N, Z>, Linearised<N, Z>)> = c.into_iter().map(&mut node).collect();
        // V_i = V₀ + h Σ a_ij (A_v V_j + A_q Q_j + ∂a/∂p), Q_j = Q₀ + h Σ a_jk V_k.
        let size = 3 * n;
        let mut matrix = vec![0.0; size * size];
        for (i, j) in (0..9).map(|index| (index / 3, index % 3)) {
            for (row, column) in (0..n * n).map(|index| (index / n, index % n)) {
                let unit = if i == j && row == column { 1.0 } else { 0.0 };
                let stiffness: f64 = (0..3).map(|l| a[i][l] * a[l][j] * nodes[l].2.a_q[row][column]).sum();
                let entry = unit - h * a[i][j] * nodes[j].2.a_v[row][column] - h * h * stiffness;
                matrix[(i * n + row) * size + j * n + column] = entry;
            }
        }
        let order = factor_lu(&mut matrix, size);
        let advance =
            |((neighbours, column), shift): ((&Neighbours<'a, M, N, Z>, &Column<N, Z>), &f64)| -> Column<N, Z> {
                let start = column.as_ref().map_err(Clone::clone)?;
                let mut stages = [*start; 3];
                let mut end = *start;
                for (stage, c) in stages.iter_mut().zip(c) {
                    (0..N).for_each(|i| stage.q[i] += c * h * start.v[i]);
                }
                // Newton's method on a linear system: the second iteration takes difference quotients along the solution.
                for _ in 0..ITERATIONS {
                    let mut loads = [Rates { a: [0.0; N], g: [0.0; Z] }; 3];
                    for ((load, (t, state, lin)), stage) in loads.iter_mut().zip(&nodes).zip(&stages) {
                        (*load, _) = self.differentiate(neighbours, (*t, state, mode), lin, (stage, *shift))?;
                    }
                    let residual = |i: usize, row: usize| {
                        start.v[row] - stages[i].v[row] + h * (0..3).map(|j| a[i][j] * loads[j].a[row]).sum::<f64>()
                    };
                    let mut solution: Vec<f64> = (0..size).map(|index| residual(index / n, index % n)).collect();
                    solve_lu(&matrix, &order, &mut solution);
                    let corrections: [State<N, Z>; 3] = [0, 1, 2].map(|j| State {
                        q: array_from(|i| match i < n {
                            true => h * (0..3).map(|k| a[j][k] * solution[k * n + i]).sum::<f64>(),
                            false => 0.0,
                        }),
                        v: array_from(|i| if i < n { solution[j * n + i] } else { 0.0 }),
                        z: [0.0; Z],
                    });
                    for (stage, correction) in stages.iter_mut().zip(&corrections) {
                        *stage = along(stage, 1.0, correction);
                    }
                    end = stages[2];
                    for m in 0..Z {
                        let rate = |j: usize| {
                            let (lin, State { q, v, .. }) = (&nodes[j].2, &corrections[j]);
                            loads[j].g[m] + product(&lin.g_q[m], q) + product(&lin.g_v[m], v)
                        };
                        end.z[m] = start.z[m] + h * (0..3).map(|j| a[2][j] * rate(j)).sum::<f64>();
                    }
                }
                match end.is_finite() {
                    true => Ok(end),
                    false => Err(format!("the derivatives are not finite at {} s", step.t0)),
                }
            };
        (self.neighbours.iter().zip(columns).zip(&self.shifts).map(advance).collect(), nodes[2].1)
    }

    /// Largest relative difference of two approximations of all derivatives at the same state.
    #[inline(never)]
    fn difference(
        &mut self,
        whole: &[Column<N, Z>],
        halves: &[Column<N, Z>],
        (end, mode): (&State<N, Z>, &M::Mode),
    ) -> f64 {
        let events = self.events((end, mode));
        let mut error = 0.0_f64;
        for (index, (whole, halves)) in whole.iter().zip(halves).enumerate() {
            let (Ok(whole), Ok(halves)) = (whole, halves) else { continue };
            let [q, v]: [[f64; N]; 2] =
                [array_from(|i| whole.q[i] - halves.q[i]), array_from(|i| whole.v[i] - halves.v[i])];
            for (scale, difference, halves) in
                self.scales[index].iter_mut().zip([&q, &v]).zip([&halves.q, &halves.v]).map(|((a, b), c)| (a, b, c))
            {
                (0..N).for_each(|i| scale[i] = scale[i].max(halves[i].abs()));
                let largest = scale.iter().fold(0.0_f64, |a, b| a.max(*b));
                let relative = |i: usize| difference[i].abs() / scale[i].max(1e-3 * largest);
                error = (0..N).map(relative).filter(|x| x.is_finite()).fold(error, f64::max);
            }
            let parameter = &self.neighbours[index].parameter;
            let value = parameter.value.abs().max(parameter.step);
            for (_, weight) in &events.weights {
                let relative = match weight {
                    ErrorWeight::Depth { row, depth, .. } => product(row, &q) * value / depth,
                    ErrorWeight::Slip { row, slip_scale, .. } => product(row, &v) * value / slip_scale,
                };
                error = error.max(CONTACT_WEIGHT * relative.abs());
            }
        }
        error
    }
}
