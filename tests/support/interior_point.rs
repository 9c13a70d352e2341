//! A linear programme by an interior-point method, independent of the solver of statics.
//!
//! Free unknowns are eliminated, redundant equations removed, and the rest is solved by the homogeneous self-dual method of
//! Xu, Hung and Ye (1996) with the predictor and corrector of Mehrotra. It does not visit vertices.

/// Answer to: how large can the unknown of the first column become, if the others alone have a solution?
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Largest {
    Infeasible,
    Unbounded,
    Value(f64),
}

/// A programme: Σ columns x + Σ free y = right, with each x from 0 to its upper bound, which may be infinite.
#[derive(Clone, Debug, Default)]
pub struct Programme {
    pub free: Vec<Vec<f64>>,
    pub columns: Vec<(Vec<f64>, f64)>,
    pub right: Vec<f64>,
}

/// Relative residuals at which a programme is solved.
const TOLERANCE: f64 = 1e-9;

/// Pivots below this part of the largest coefficient are rounding.
const ZERO_PIVOT: f64 = 1e-9;

impl Programme {
    /// Returns the largest value of the first column's unknown; `None` if the method does not converge.
    pub fn largest(&self) -> Option<Largest> {
        let others = Self { columns: self.columns[1..].to_vec(), ..self.clone() };
        let Some((rows, right)) = others.reduced() else { return Some(Largest::Infeasible) };
        let count = |rows: &[Vec<f64>]| rows.first().map_or(0, Vec::len);
        if interior_point(&rows, &right, &vec![0.0; count(&rows)])? == Largest::Infeasible {
            return Some(Largest::Infeasible);
        }
        let (rows, right) = self.reduced()?;
        let objective: Vec<f64> = (0..count(&rows)).map(|j| if j == 0 { -1.0 } else { 0.0 }).collect();
        Some(match interior_point(&rows, &right, &objective)? {
            Largest::Value(value) => Largest::Value(-value),
            other => other,
        })
    }

    /// Equations in nonnegative unknowns without free ones, in echelon form; `None` if they contradict each other.
    fn reduced(&self) -> Option<(Vec<Vec<f64>>, Vec<f64>)> {
        let (free, count) = (self.free.len(), self.columns.len());
        let bounded: Vec<usize> = (0..count).filter(|j| self.columns[*j].1.is_finite()).collect();
        let width = free + count + bounded.len();
        let mut rows: Vec<Vec<f64>> = (0..self.right.len())
            .map(|i| {
                let columns = self.free.iter().map(|column| column[i]).chain(self.columns.iter().map(|(c, _)| c[i]));
                columns.chain(bounded.iter().map(|_| 0.0)).chain([self.right[i]]).collect()
            })
            .collect();
        for (k, j) in bounded.iter().enumerate() {
            let mut row = vec![0.0; width + 1];
            (row[free + j], row[free + count + k], row[width]) = (1.0, 1.0, self.columns[*j].1);
            rows.push(row);
        }
        let mut kept = Vec::new();
        for (range, keeps) in [(0..free, false), (free..width, true)] {
            loop {
                let largest =
                    rows.iter().enumerate().flat_map(|(i, row)| range.clone().map(move |j| (i, j, row[j].abs())));
                let Some((i, j, size)) = largest.max_by(|a, b| a.2.total_cmp(&b.2)) else { break };
                if size <= ZERO_PIVOT {
                    break;
                }
                let pivot = rows.swap_remove(i);
                for row in rows.iter_mut().chain(&mut kept) {
                    let factor = row[j] / pivot[j];
                    if factor != 0.0 {
                        row.iter_mut().zip(&pivot).for_each(|(entry, by)| *entry -= factor * by);
                        row[j] = 0.0;
                    }
                }
                if keeps {
                    kept.push(pivot.iter().map(|entry| entry / pivot[j]).collect());
                }
            }
        }
        if rows.iter().any(|row| row[width].abs() > 1e-7) {
            return None;
        }
        let right = kept.iter().map(|row: &Vec<f64>| row[width]).collect();
        Some((kept.iter().map(|row| row[free..width].to_vec()).collect(), right))
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// A combination Σ rows y.
fn combined(rows: &[Vec<f64>], y: &[f64], count: usize) -> Vec<f64> {
    let mut sum = vec![0.0; count];
    for (row, y) in rows.iter().zip(y) {
        sum.iter_mut().zip(row).for_each(|(sum, entry)| *sum += entry * y);
    }
    sum
}

/// Lower factor of a positive definite matrix; a pivot that is no larger than rounding is replaced by a large one.
fn cholesky(mut matrix: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let largest = (0..matrix.len()).map(|i| matrix[i][i]).fold(0.0, f64::max);
    for i in 0..matrix.len() {
        for j in 0..=i {
            let sum = matrix[i][j] - (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum::<f64>();
            matrix[i][j] = match i == j {
                true if sum > 1e-30 * largest => sum.sqrt(),
                true => 1e64,
                false => sum / matrix[j][j],
            };
        }
    }
    matrix
}

fn solve(lower: &[Vec<f64>], right: &[f64]) -> Vec<f64> {
    let mut x = right.to_vec();
    for i in 0..x.len() {
        x[i] = (x[i] - dot(&lower[i][..i], &x[..i])) / lower[i][i];
    }
    for i in (0..x.len()).rev() {
        let below: f64 = (i + 1..x.len()).map(|k| lower[k][i] * x[k]).sum();
        x[i] = (x[i] - below) / lower[i][i];
    }
    x
}

/// The least c·x with A x = b and x ≥ 0.
fn interior_point(a: &[Vec<f64>], b: &[f64], c: &[f64]) -> Option<Largest> {
    let (m, n) = (a.len(), c.len());
    let (mut x, mut y, mut z, mut tau, mut kappa) = (vec![1.0; n], vec![0.0; m], vec![1.0; n], 1.0, 1.0);
    let times = |x: &[f64]| a.iter().map(|row| dot(row, x)).collect::<Vec<f64>>();
    let minus = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>();
    let residuals = |x: &[f64], y: &[f64], z: &[f64], tau: f64, kappa: f64| {
        let scaled = |values: &[f64]| values.iter().map(|value| value * tau).collect::<Vec<f64>>();
        let (primal, dual) = (minus(&scaled(b), &times(x)), minus(&minus(&scaled(c), &combined(a, y, n)), z));
        (primal, dual, dot(c, x) - dot(b, y) + kappa)
    };
    let (primal, dual, gap) = residuals(&x, &y, &z, tau, kappa);
    let start = [norm(&primal), norm(&dual), gap.abs()].map(|size| size.max(1.0));
    for _ in 0..200 {
        let (primal, dual, gap) = residuals(&x, &y, &z, tau, kappa);
        let mu = (dot(&x, &z) + tau * kappa) / (n + 1) as f64;
        let sizes = [norm(&primal), norm(&dual), gap.abs()];
        let is_balanced = sizes[0] <= TOLERANCE * tau * start[0] && sizes[1] <= TOLERANCE * tau * start[1];
        if is_balanced && (dot(c, &x) - dot(b, &y)).abs() <= TOLERANCE * (tau + dot(c, &x).abs()) {
            return Some(Largest::Value(dot(c, &x) / tau));
        }
        let is_solved = sizes.iter().zip(start).all(|(size, start)| *size <= TOLERANCE * start);
        if (is_solved && tau <= TOLERANCE * kappa.max(1.0)) || (mu <= TOLERANCE && tau <= TOLERANCE * kappa.min(1.0)) {
            return Some(if dot(b, &y) > -dot(c, &x) { Largest::Infeasible } else { Largest::Unbounded });
        }
        let ratio: Vec<f64> = x.iter().zip(&z).map(|(x, z)| x / z).collect();
        let normal = (0..m)
            .map(|i| {
                let weighted: Vec<f64> = a[i].iter().zip(&ratio).map(|(entry, ratio)| entry * ratio).collect();
                (0..m).map(|j| if j <= i { dot(&weighted, &a[j]) } else { 0.0 }).collect()
            })
            .collect();
        let lower = cholesky(normal);
        let symmetric = |first: &[f64], second: &[f64]| {
            let weighted: Vec<f64> = first.iter().zip(&ratio).map(|(first, ratio)| first * ratio).collect();
            let right: Vec<f64> = times(&weighted).iter().zip(second).map(|(a, b)| a + b).collect();
            let v = solve(&lower, &right);
            let u = combined(a, &v, n).iter().zip(first).zip(&ratio).map(|((av, r), ratio)| ratio * (av - r)).collect();
            (u, v)
        };
        let (p, q): (Vec<f64>, Vec<f64>) = symmetric(c, b);
        let direction = |gamma: f64, products: &[f64], product: f64| {
            let eta = 1.0 - gamma;
            let complement: Vec<f64> = (0..n).map(|j| gamma * mu - x[j] * z[j] - products[j]).collect();
            let of_tau = gamma * mu - tau * kappa - product;
            let first: Vec<f64> = (0..n).map(|j| eta * dual[j] - complement[j] / x[j]).collect();
            let second: Vec<f64> = primal.iter().map(|rest| eta * rest).collect();
            let (u, v): (Vec<f64>, Vec<f64>) = symmetric(&first, &second);
            let d_tau = (eta * gap + of_tau / tau + dot(c, &u) - dot(b, &v)) / (kappa / tau - dot(c, &p) + dot(b, &q));
            let d_x: Vec<f64> = u.iter().zip(&p).map(|(u, p)| u + p * d_tau).collect();
            let d_y: Vec<f64> = v.iter().zip(&q).map(|(v, q)| v + q * d_tau).collect();
            let d_z: Vec<f64> = (0..n).map(|j| (complement[j] - z[j] * d_x[j]) / x[j]).collect();
            (d_x, d_y, d_z, d_tau, (of_tau - kappa * d_tau) / tau)
        };
        let step = |(d_x, _, d_z, d_tau, d_kappa): &(Vec<f64>, Vec<f64>, Vec<f64>, f64, f64)| {
            let pairs = x.iter().zip(d_x).chain(z.iter().zip(d_z)).chain([(&tau, d_tau), (&kappa, d_kappa)]);
            pairs.filter(|(_, change)| **change < 0.0).map(|(value, change)| -value / change).fold(1.0, f64::min)
        };
        let affine = direction(0.0, &vec![0.0; n], 0.0);
        let gamma = (1.0 - step(&affine)).powi(2) * (1.0 - step(&affine)).min(0.1);
        let products: Vec<f64> = affine.0.iter().zip(&affine.2).map(|(a, b)| a * b).collect();
        let corrected = direction(gamma, &products, affine.3 * affine.4);
        let length = 0.9995 * step(&corrected);
        let (d_x, d_y, d_z, d_tau, d_kappa) = corrected;
        let add =
            |values: &mut [f64], by: &[f64]| values.iter_mut().zip(by).for_each(|(value, by)| *value += length * by);
        add(&mut x, &d_x);
        add(&mut y, &d_y);
        add(&mut z, &d_z);
        (tau, kappa) = (tau + length * d_tau, kappa + length * d_kappa);
        if !(tau > 0.0 && x.iter().chain(&z).all(|value| value.is_finite())) {
            return None;
        }
    }
    None
}
