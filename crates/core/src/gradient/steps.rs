//! Integration of the tangent equation along a step of the run.

use super::neighbours::Neighbours;
use super::tangent::{Column, Tangent, product};
use crate::integrator::{
    ErrorWeight, Hybrid, Layout, Linearised, Rates, State, Step, StepTools, WeightedQuantity, radau5_tableau,
};
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

/// Time, state and linearisation at an abscissa of a step.
type Node<L> = (f64, State<L>, Linearised<L>);

impl<'a, M: Kernel + Hybrid> Tangent<'a, M> {
    /// Advances all derivatives over a part of a step, which is halved until the error is small.
    pub fn advance(
        &mut self,
        [from, to]: [f64; 2],
        (step, mode): (&Step<M::Layout>, &M::Mode),
        tools: &mut dyn StepTools<M::Layout>,
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
        columns: &[Column<M::Layout>],
        [from, to]: [f64; 2],
        (step, mode): (&Step<M::Layout>, &M::Mode),
        tools: &mut dyn StepTools<M::Layout>,
    ) -> (Vec<Column<M::Layout>>, State<M::Layout>) {
        let (n, h) = (self.kernel.coordinate_count(), (to - from) * step.h);
        let layout = self.kernel.layout();
        let (c, a) = radau5_tableau();
        let mut node = |c: f64| {
            let theta = from + c * (to - from);
            let state = if theta < 1.0 { tools.resolve(theta).clone() } else { step.end.clone() };
            let t = (step.t0 + theta * step.h).max(self.bounds_s[0]).min(self.bounds_s[1]);
            let linearised = Self::linearise(&self.kernel, (t, &state, mode));
            (t, state, linearised)
        };
        let nodes: Vec<Node<M::Layout>> = c.into_iter().map(&mut node).collect();
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
            |((neighbours, column), shift): ((&Neighbours<'a, M>, &Column<M::Layout>), &f64)| -> Column<M::Layout> {
                let start = column.as_ref().map_err(Clone::clone)?;
                let mut stages = [start.clone(), start.clone(), start.clone()];
                let mut end = start.clone();
                for (stage, c) in stages.iter_mut().zip(c) {
                    (0..layout.coordinates()).for_each(|i| stage.q[i] += c * h * start.v[i]);
                }
                // Newton's method on a linear system: the second iteration takes difference quotients along the solution.
                for _ in 0..ITERATIONS {
                    let mut loads: [Rates<M::Layout>; 3] = std::array::from_fn(|_| Rates::zero(layout));
                    for ((load, (t, state, lin)), stage) in loads.iter_mut().zip(&nodes).zip(&stages) {
                        (*load, _) = self.differentiate(neighbours, (*t, state, mode), lin, (stage, *shift))?;
                    }
                    let residual = |i: usize, row: usize| {
                        start.v[row] - stages[i].v[row] + h * (0..3).map(|j| a[i][j] * loads[j].a[row]).sum::<f64>()
                    };
                    let mut solution: Vec<f64> = (0..size).map(|index| residual(index / n, index % n)).collect();
                    solve_lu(&matrix, &order, &mut solution);
                    let corrections: [State<M::Layout>; 3] = [0, 1, 2].map(|j| {
                        let mut correction = State::zero(layout);
                        for i in 0..n {
                            correction.q[i] = h * (0..3).map(|k| a[j][k] * solution[k * n + i]).sum::<f64>();
                            correction.v[i] = solution[j * n + i];
                        }
                        correction
                    });
                    for (stage, correction) in stages.iter_mut().zip(&corrections) {
                        stage.add_scaled(1.0, correction);
                    }
                    end.copy_from(&stages[2]);
                    for m in 0..layout.quadratures() {
                        let rate = |j: usize| {
                            let (lin, State { q, v, .. }) = (&nodes[j].2, &corrections[j]);
                            loads[j].g[m] + product(&lin.g_q[m], q.as_ref()) + product(&lin.g_v[m], v.as_ref())
                        };
                        end.z[m] = start.z[m] + h * (0..3).map(|j| a[2][j] * rate(j)).sum::<f64>();
                    }
                }
                match end.is_finite() {
                    true => Ok(end),
                    false => Err(format!("the derivatives are not finite at {} s", step.t0)),
                }
            };
        (self.neighbours.iter().zip(columns).zip(&self.shifts).map(advance).collect(), nodes[2].1.clone())
    }

    /// Largest relative difference of two approximations of all derivatives at the same state.
    #[inline(never)]
    fn difference(
        &mut self,
        whole: &[Column<M::Layout>],
        halves: &[Column<M::Layout>],
        (end, mode): (&State<M::Layout>, &M::Mode),
    ) -> f64 {
        let events = self.events((end, mode));
        let mut error = 0.0_f64;
        for (index, (whole, halves)) in whole.iter().zip(halves).enumerate() {
            let (Ok(whole), Ok(halves)) = (whole, halves) else { continue };
            let mut change = whole.clone();
            change.add_scaled(-1.0, halves);
            let State { q, v, .. } = &change;
            let size = q.as_ref().len();
            for (scale, difference, halves) in
                self.scales[index].iter_mut().zip([q, v]).zip([&halves.q, &halves.v]).map(|((a, b), c)| (a, b, c))
            {
                (0..size).for_each(|i| scale[i] = scale[i].max(halves[i].abs()));
                let largest = scale.as_ref().iter().fold(0.0_f64, |a, b| a.max(*b));
                let relative = |i: usize| difference[i].abs() / scale[i].max(1e-3 * largest);
                error = (0..size).map(relative).filter(|x| x.is_finite()).fold(error, f64::max);
            }
            let parameter = &self.neighbours[index].parameter;
            let value = parameter.value.abs().max(parameter.step);
            for ErrorWeight { quantity, row, .. } in events.weights() {
                let relative = match quantity {
                    WeightedQuantity::Depth { depth, .. } => product(row.as_ref(), q.as_ref()) * value / depth,
                    WeightedQuantity::Slip { slip_scale, .. } => product(row.as_ref(), v.as_ref()) * value / slip_scale,
                };
                error = error.max(CONTACT_WEIGHT * relative.abs());
            }
        }
        error
    }
}
