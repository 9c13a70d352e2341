//! Small dense linear programmes: the largest c·x with A x = b and lo ≤ x ≤ hi.
//!
//! A primal simplex method with bounded variables and two phases. The programmes of statics have some dozens of rows, so
//! that the inverse of the basis is computed anew in each iteration and errors do not accumulate. Rows and columns are
//! divided by powers of two, which rounds nothing. The caller verifies the result.

use nalgebra::{DMatrix, DVector};

/// A linear programme; bounds may be infinite.
#[derive(Clone, Debug)]
pub(super) struct LinearProgram {
    pub matrix: DMatrix<f64>,
    pub right: DVector<f64>,
    pub bounds: Vec<[f64; 2]>,
    pub objective: Vec<f64>,
}

/// Result of a programme.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Outcome {
    /// A vertex of largest c·x, and multipliers y: c − Aᵀy is at most 0 at a lower bound, at least 0 at an upper one.
    Optimal { x: Vec<f64>, y: Vec<f64> },
    /// From x, c·x grows without limit along the ray, which keeps A x.
    Unbounded { x: Vec<f64>, ray: Vec<f64> },
    /// Multipliers with y·A x > y·b for all x within their bounds.
    Infeasible { y: Vec<f64> },
}

/// How the next vertex is selected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// Equilibrated rows and columns, the steepest edge (Dantzig); Bland's rule where the method stalls.
    Steepest,
    /// The rows and columns as they are, and Bland's rule, which cannot cycle.
    First,
}

/// Entries below this part of the largest one of their column are rounding errors of geometry.
const ROUNDING: f64 = 1e-14;
/// Sum of the unbalanced remainders of all rows, relative to the largest right-hand side, that counts as zero. Postures
/// of runs are at rest up to about this part.
const FEASIBLE: f64 = 1e-8;
/// Reduced costs below this part of their terms are zero.
const ZERO_COST: f64 = 1e-11;
/// The same relative to the largest multiplier: terms may consist of rounding errors only.
const ROUNDED_COST: f64 = 1e-14;
/// Multipliers that differ by less than this part of the largest one are the same, and a variable this part of the largest one
/// from a bound is at it.
const SAME_MULTIPLIER: f64 = 1e-9;
/// Bounds may be exceeded by this part of a value while a larger pivot is selected (Harris 1973).
const SLACK: f64 = 1e-12;

/// Position of a variable outside the basis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Basic,
    Lower,
    Upper,
    /// Zero, without bounds.
    Free,
}

/// Result of one phase.
enum End {
    Optimal { y: DVector<f64> },
    Ray { entering: usize, sign: f64, direction: DVector<f64> },
}

/// The programme with one artificial variable for each row, after the other variables.
struct Tableau {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
    bounds: Vec<[f64; 2]>,
    x: DVector<f64>,
    place: Vec<Place>,
    basis: Vec<usize>,
    /// Components of a direction below this part of the largest are zero.
    pivot: f64,
}

impl LinearProgram {
    /// Like [`LinearProgram::solve`], but if the optimal multipliers are not unique, returns those of least norm
    /// instead of those of a vertex. A symmetric hand then has a symmetric result.
    pub fn solve_with_smallest_multipliers(&self, rule: Rule) -> Option<Outcome> {
        let found = self.solve(rule)?;
        let Outcome::Optimal { x, y } = &found else { return Some(found) };
        let smallest = self.smallest_multipliers(x);
        let largest = y.iter().fold(0.0f64, |largest, y| largest.max(y.abs()));
        match smallest {
            Some(smallest) if y.iter().zip(&smallest).any(|(a, b)| (a - b).abs() > SAME_MULTIPLIER * largest) => {
                Some(Outcome::Optimal { x: x.clone(), y: smallest })
            }
            _ => Some(found),
        }
    }

    /// The multipliers of least norm for which the reduced costs of all variables between their bounds vanish; `None` unless
    /// the signs of the others show that they are optimal.
    fn smallest_multipliers(&self, x: &[f64]) -> Option<Vec<f64>> {
        let size = x.iter().fold(0.0f64, |size, x| size.max(x.abs()));
        let distance = |j: usize| {
            let [lo, hi] = self.bounds[j];
            [x[j] - lo, hi - x[j]].map(|distance| distance > SAME_MULTIPLIER * size)
        };
        let between: Vec<usize> = (0..x.len()).filter(|j| distance(*j) == [true; 2]).collect();
        if between.is_empty() || self.matrix.nrows() == 0 {
            return None;
        }
        let columns = self.matrix.select_columns(&between).transpose();
        let costs = DVector::from_fn(between.len(), |k, _| self.objective[between[k]]);
        let y = columns.svd(true, true).solve(&costs, SAME_MULTIPLIER).ok()?;
        let is_optimal = |j: usize| {
            let column = self.matrix.column(j);
            let reduced = self.objective[j] - column.dot(&y);
            let zero = SAME_MULTIPLIER * (self.objective[j].abs() + column.amax() * y.amax());
            let [from_lower, from_upper] = distance(j);
            (!from_upper || reduced <= zero) && (!from_lower || reduced >= -zero)
        };
        (0..x.len()).all(is_optimal).then(|| y.as_slice().to_vec())
    }

    /// Solves the programme; `None` if the method does not end.
    pub fn solve(&self, rule: Rule) -> Option<Outcome> {
        let (m, n) = self.matrix.shape();
        let (matrix, rows, columns) = self.equilibrated(rule);
        let scaled_bounds = self.bounds.iter().zip(&columns).map(|(bounds, scale)| bounds.map(|bound| bound / scale));
        let right = DVector::from_fn(m, |i, _| self.right[i] * rows[i]);
        let pivot = if rule == Rule::Steepest { 1e-12 } else { 1e-14 };
        let mut tableau = Tableau::new(&matrix, right, scaled_bounds.collect(), pivot);
        let unscaled = |x: &DVector<f64>| (0..n).map(|j| x[j] * columns[j]).collect::<Vec<f64>>();
        let multipliers = |y: &DVector<f64>| (0..m).map(|i| y[i] * rows[i]).collect::<Vec<f64>>();

        let artificial = DVector::from_fn(n + m, |j, _| if j < n { 0.0 } else { -1.0 });
        let End::Optimal { y } = tableau.maximise(&artificial, rule)? else { return None };
        let remainder: f64 = tableau.x.rows(n, m).sum();
        let largest = tableau.right.amax().max(tableau.start_size(n));
        if remainder > FEASIBLE * largest {
            return Some(Outcome::Infeasible { y: multipliers(&y) });
        }
        // What remains of the artificial variables is rounding, and stays.
        for j in n..n + m {
            tableau.bounds[j] = [tableau.x[j]; 2];
            if tableau.place[j] != Place::Basic {
                tableau.place[j] = Place::Lower;
            }
        }
        let objective = DVector::from_fn(n + m, |j, _| if j < n { self.objective[j] * columns[j] } else { 0.0 });
        Some(match tableau.maximise(&objective, rule)? {
            End::Optimal { y } => Outcome::Optimal { x: unscaled(&tableau.x), y: multipliers(&y) },
            End::Ray { entering, sign, direction } => {
                let mut ray = DVector::zeros(n + m);
                ray[entering] = sign;
                let zero = tableau.pivot * direction.amax().max(1.0);
                for (&j, &change) in tableau.basis.iter().zip(direction.iter()) {
                    ray[j] = if change.abs() > zero || tableau.is_free(j) { change } else { 0.0 };
                }
                Outcome::Unbounded { x: unscaled(&tableau.x), ray: unscaled(&ray) }
            }
        })
    }

    /// Returns the matrix without rounding errors, with rows and columns multiplied by powers of two, and the factors.
    fn equilibrated(&self, rule: Rule) -> (DMatrix<f64>, Vec<f64>, Vec<f64>) {
        let (m, n) = self.matrix.shape();
        let mut matrix = self.matrix.clone();
        for mut column in matrix.column_iter_mut() {
            let least = ROUNDING * column.amax();
            column.iter_mut().filter(|entry| entry.abs() <= least).for_each(|entry| *entry = 0.0);
        }
        let (mut rows, mut columns) = (vec![1.0; m], vec![1.0; n]);
        for _ in 0..if rule == Rule::Steepest { 3 } else { 0 } {
            for (mut row, scale) in matrix.row_iter_mut().zip(&mut rows) {
                let factor = balancing(row.iter());
                row *= factor;
                *scale *= factor;
            }
            for (mut column, scale) in matrix.column_iter_mut().zip(&mut columns) {
                let factor = balancing(column.iter());
                column *= factor;
                *scale *= factor;
            }
        }
        (matrix, rows, columns)
    }
}

/// Power of two that brings the geometric mean of the largest and the smallest entry to about 1.
fn balancing<'a>(entries: impl Iterator<Item = &'a f64>) -> f64 {
    let sizes = entries.map(|entry| entry.abs()).filter(|size| *size > 0.0);
    let (least, largest) = sizes.fold((f64::INFINITY, 0.0f64), |(a, b), size| (a.min(size), b.max(size)));
    if largest == 0.0 {
        return 1.0;
    }
    let exponent = |size: f64| ((size.to_bits() >> 52) & 0x7ff) as i32 - 1023;
    let mean = (exponent(least) + exponent(largest)).div_euclid(2);
    f64::from_bits(((1023 - mean.clamp(-1000, 1000)) as u64) << 52)
}

impl Tableau {
    fn new(matrix: &DMatrix<f64>, right: DVector<f64>, mut bounds: Vec<[f64; 2]>, pivot: f64) -> Self {
        let (m, n) = matrix.shape();
        let start = |[lo, hi]: [f64; 2]| match (lo.is_finite(), hi.is_finite()) {
            (true, true) if hi.abs() < lo.abs() => (hi, Place::Upper),
            (true, _) => (lo, Place::Lower),
            (false, true) => (hi, Place::Upper),
            (false, false) => (0.0, Place::Free),
        };
        let (values, mut place): (Vec<f64>, Vec<Place>) = bounds.iter().map(|bounds| start(*bounds)).unzip();
        let rest = &right - matrix * DVector::from_column_slice(&values);
        let x = DVector::from_fn(n + m, |j, _| if j < n { values[j] } else { rest[j - n].abs() });
        let sign = |i: usize| if rest[i] < 0.0 { -1.0 } else { 1.0 };
        let artificial = |i: usize, j: usize| if i + n == j { sign(i) } else { 0.0 };
        let matrix = DMatrix::from_fn(m, n + m, |i, j| if j < n { matrix[(i, j)] } else { artificial(i, j) });
        bounds.extend((0..m).map(|_| [0.0, f64::INFINITY]));
        place.extend((0..m).map(|_| Place::Basic));
        Tableau { matrix, right, bounds, x, place, basis: (n..n + m).collect(), pivot }
    }

    fn is_free(&self, j: usize) -> bool {
        self.bounds[j].iter().all(|bound| bound.is_infinite())
    }

    /// Largest load of the variables that start at a bound other than zero.
    fn start_size(&self, n: usize) -> f64 {
        let at_bound = (0..n).filter(|j| self.place[*j] != Place::Basic);
        at_bound.map(|j| self.x[j].abs() * self.matrix.column(j).amax()).fold(0.0, f64::max)
    }

    /// Inverse of the basis, with the basic variables and a refinement of these.
    fn factorise(&mut self) -> Option<DMatrix<f64>> {
        let inverse = self.matrix.select_columns(&self.basis).try_inverse()?;
        self.basis.iter().for_each(|j| self.x[*j] = 0.0);
        for _ in 0..2 {
            let correction = &inverse * (&self.right - self.balance());
            self.basis.iter().zip(correction.iter()).for_each(|(j, by)| self.x[*j] += by);
        }
        inverse.iter().all(|entry| entry.is_finite()).then_some(inverse)
    }

    /// A x: the columns of variables that are not 0, in their order.
    fn balance(&self) -> DVector<f64> {
        let mut sum = DVector::zeros(self.right.len());
        for (column, x) in self.matrix.column_iter().zip(&self.x).filter(|(_, x)| **x != 0.0) {
            sum.axpy(*x, &column, 1.0);
        }
        sum
    }

    /// Moves from vertex to vertex while the objective grows; `None` if this does not end.
    fn maximise(&mut self, objective: &DVector<f64>, rule: Rule) -> Option<End> {
        let (m, count) = self.matrix.shape();
        let mut stalled = 0;
        // The usual number of steps is two or three times that of the rows.
        for _ in 0..200 + 50 * count {
            let inverse = self.factorise()?;
            let by_basis = DVector::from_fn(m, |i, _| objective[self.basis[i]]);
            let mut y = inverse.tr_mul(&by_basis);
            let missing = DVector::from_fn(m, |i, _| by_basis[i] - self.matrix.column(self.basis[i]).dot(&y));
            y += inverse.tr_mul(&missing);
            let takes_first = rule == Rule::First || stalled > count;
            let Some((entering, sign)) = self.entering(objective, &y, takes_first) else {
                return Some(End::Optimal { y });
            };
            let direction = -sign * (&inverse * self.matrix.column(entering));
            let Some((step, leaving)) = self.leaving(entering, &direction, takes_first) else {
                return Some(End::Ray { entering, sign, direction });
            };
            stalled = if step > 0.0 { 0 } else { stalled + 1 };
            let [lo, hi] = self.bounds[entering];
            match leaving {
                None => {
                    let to_upper = sign > 0.0;
                    (self.x[entering], self.place[entering]) =
                        if to_upper { (hi, Place::Upper) } else { (lo, Place::Lower) };
                }
                Some(position) => {
                    let variable = self.basis[position];
                    let [lo, hi] = self.bounds[variable];
                    (self.x[variable], self.place[variable]) =
                        if direction[position] < 0.0 { (lo, Place::Lower) } else { (hi, Place::Upper) };
                    self.basis[position] = entering;
                    self.place[entering] = Place::Basic;
                }
            }
        }
        None
    }

    /// Returns the variable that enters the basis and the sign of its change; `None` at the optimum.
    fn entering(&self, objective: &DVector<f64>, y: &DVector<f64>, takes_first: bool) -> Option<(usize, f64)> {
        let (mut best, largest): (Option<(usize, f64)>, f64) = (None, y.amax());
        for (j, column) in self.matrix.column_iter().enumerate() {
            let [lo, hi] = self.bounds[j];
            if self.place[j] == Place::Basic || lo == hi {
                continue;
            }
            let cost = objective[j] - column.dot(y);
            let improves = match self.place[j] {
                Place::Lower => cost > 0.0,
                Place::Upper => cost < 0.0,
                Place::Free | Place::Basic => true,
            };
            // Most columns do not, and their rounding errors are not needed.
            if !improves {
                continue;
            }
            let terms = column.iter().zip(y.iter()).map(|(entry, y)| (entry * y).abs()).sum::<f64>();
            let zero = (ZERO_COST * (terms + objective[j].abs())).max(ROUNDED_COST * largest * column.amax());
            if cost.abs() <= zero {
                continue;
            }
            if best.is_none_or(|(_, steepest)| cost.abs() > steepest.abs()) {
                best = Some((j, cost));
            }
            if takes_first {
                break;
            }
        }
        best.map(|(j, cost)| (j, cost.signum()))
    }

    /// Returns the length of the step and the position in the basis of the variable that reaches its bound first, or
    /// none if the entering variable itself reaches its other bound; `None` without any limit.
    fn leaving(&self, entering: usize, direction: &DVector<f64>, takes_first: bool) -> Option<(f64, Option<usize>)> {
        let zero = self.pivot * direction.amax().max(1.0);
        // Step to the bound, with the bound moved by the slack.
        let step = |position: usize, slack: f64| {
            let (j, change) = (self.basis[position], direction[position]);
            let bound = if change < 0.0 { self.bounds[j][0] } else { self.bounds[j][1] };
            let room = (bound - self.x[j]) * change.signum();
            (change.abs() > zero && bound.is_finite())
                .then(|| (room.max(0.0) + slack * (1.0 + bound.abs())) / change.abs())
        };
        let positions = 0..self.basis.len();
        let nearest = positions.clone().filter_map(|position| step(position, SLACK)).fold(f64::INFINITY, f64::min);
        let within = positions.filter(|position| step(*position, 0.0).is_some_and(|step| step <= nearest));
        let leaving = match takes_first {
            true => within.min_by_key(|position| self.basis[*position]),
            false => within.max_by(|a, b| direction[*a].abs().total_cmp(&direction[*b].abs())),
        };
        let [lo, hi] = self.bounds[entering];
        let range = hi - lo;
        match leaving.and_then(|position| Some((step(position, 0.0)?, position))) {
            Some((step, position)) if step < range => Some((step, Some(position))),
            _ if range.is_finite() => Some((range, None)),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn program(rows: &[&[f64]], right: &[f64], bounds: &[[f64; 2]], objective: &[f64]) -> LinearProgram {
        LinearProgram {
            matrix: DMatrix::from_fn(rows.len(), bounds.len(), |i, j| rows[i][j]),
            right: DVector::from_column_slice(right),
            bounds: bounds.to_vec(),
            objective: objective.to_vec(),
        }
    }

    const POSITIVE: [f64; 2] = [0.0, f64::INFINITY];

    #[test]
    fn both_rules_find_the_optimum_the_ray_and_the_contradiction() {
        for rule in [Rule::Steepest, Rule::First] {
            // x + y + s = 4, x + 3 y + t = 6, the largest 3 x + 5 y: at (3, 1).
            let rows: [&[f64]; 2] = [&[1.0, 1.0, 1.0, 0.0], &[1.0, 3.0, 0.0, 1.0]];
            let optimum = program(&rows, &[4.0, 6.0], &[POSITIVE; 4], &[3.0, 5.0, 0.0, 0.0]);
            let Some(Outcome::Optimal { x, y }) = optimum.solve(rule) else { panic!("{rule:?}") };
            assert_eq!((x, y), (vec![3.0, 1.0, 0.0, 0.0], vec![2.0, 1.0]));
            // x − y = 1: both grow.
            let ray = program(&[&[1.0, -1.0]], &[1.0], &[POSITIVE; 2], &[1.0, 0.0]);
            let Some(Outcome::Unbounded { x, ray }) = ray.solve(rule) else { panic!("{rule:?}") };
            assert_eq!((x[0] - x[1], ray[0] - ray[1]), (1.0, 0.0));
            assert!(ray[0] > 0.0);
            // x + y = −1.
            let none = program(&[&[1.0, 1.0]], &[-1.0], &[POSITIVE; 2], &[1.0, 0.0]);
            let Some(Outcome::Infeasible { y }) = none.solve(rule) else { panic!("{rule:?}") };
            assert!(y[0] > 0.0, "{y:?}");
        }
    }

    /// Beale's example, at which the rule of Dantzig cycles.
    #[test]
    fn a_cycle_ends() {
        let rows: [&[f64]; 3] = [
            &[0.25, -60.0, -0.04, 9.0, 1.0, 0.0, 0.0],
            &[0.5, -90.0, -0.02, 3.0, 0.0, 1.0, 0.0],
            &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        ];
        let beale = program(&rows, &[0.0, 0.0, 1.0], &[POSITIVE; 7], &[0.75, -150.0, 0.02, -6.0, 0.0, 0.0, 0.0]);
        for rule in [Rule::Steepest, Rule::First] {
            let Some(Outcome::Optimal { x, .. }) = beale.solve(rule) else { panic!("{rule:?}") };
            assert!((0.75 * x[0] - 150.0 * x[1] + 0.02 * x[2] - 6.0 * x[3] - 0.05).abs() < 1e-12, "{x:?}");
        }
    }
}
