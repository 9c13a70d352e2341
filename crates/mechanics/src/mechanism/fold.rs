//! Folds: postures in which the constraints of a mechanism lose rank, so that it can continue on two branches.

use super::assembly::{Condition, all_gradients};
use super::{Mechanism, Pose};

/// Smallest pivot of the scaled constraints, as a part of the largest one, below which they count as dependent.
const DEPENDENT: f64 = 1e-2;
/// Part of the largest weight in the dependence above which a joint belongs to it.
const WEIGHT: f64 = 0.05;

/// Returns the joints whose constraints depend on each other in assembled poses. In such poses the mechanism has more
/// directions of motion than degrees of freedom. `None` if all constraints are independent.
pub fn folded_joints(mechanism: &Mechanism, poses: &[Pose]) -> Option<Vec<usize>> {
    let gradients = all_gradients(mechanism, poses);
    let (count, columns) = (gradients.len(), 3 * poses.len());
    // Each row of the elimination is a combination of the constraints, whose weights follow the gradient.
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(count);
    for (index, (_, gradient)) in gradients.iter().enumerate() {
        let weights = (0..count).map(|other| f64::from(u8::from(other == index)));
        rows.push(gradient.iter().copied().chain(weights).collect());
    }
    let mut pivots = Vec::with_capacity(count);
    for step in 0..count {
        let size = |row: &[f64]| row[..columns].iter().map(|part| part.abs()).fold(0.0, f64::max);
        let pivot_row = (step..count).max_by(|a, b| size(&rows[*a]).total_cmp(&size(&rows[*b])))?;
        rows.swap(step, pivot_row);
        let pivot_column = (0..columns).max_by(|a, b| rows[step][*a].abs().total_cmp(&rows[step][*b].abs()))?;
        let pivot = rows[step][pivot_column];
        pivots.push(pivot.abs());
        if pivot == 0.0 {
            break;
        }
        let (done, left) = rows.split_at_mut(step + 1);
        for row in left {
            let factor = row[pivot_column] / pivot;
            row.iter_mut().zip(&done[step]).for_each(|(part, of_pivot)| *part -= factor * of_pivot);
        }
    }
    let (first, last) = (pivots.first()?, pivots.last()?);
    if *last >= DEPENDENT * first {
        return None;
    }
    let weights = &rows[pivots.len() - 1][columns..];
    let largest = weights.iter().map(|weight| weight.abs()).fold(0.0, f64::max);
    let mut joints: Vec<usize> = Vec::new();
    for ((condition, _), weight) in gradients.iter().zip(weights) {
        match condition {
            Condition::Joint(joint) if weight.abs() > WEIGHT * largest && joints.last() != Some(joint) => {
                joints.push(*joint);
            }
            _ => {}
        }
    }
    Some(joints)
}

impl Mechanism {
    /// Describes a singular posture, in nearly all cases a fold of the mechanism, in which the analytic model has no
    /// regular choice of coordinates. `joints` are the singular joints: those of a dyad, with the inner one in the
    /// middle, or the six or more joints of a larger Assur group.
    pub fn describe_singularity(&self, poses: &[Pose], joints: &[usize]) -> String {
        let name = |joint: &usize| &self.joints[*joint].name[..];
        let list = |joints: &[usize]| match joints {
            [others @ .., last] if !others.is_empty() => {
                format!("{} and {}", others.iter().map(name).collect::<Vec<_>>().join(", "), name(last))
            }
            joints => joints.iter().map(name).collect(),
        };
        let remedies = "Give one of these joints a stop (`lower` or `upper`) before this posture, start with a motion that does \
             not reach it, or simulate with `--model engine`, which may go on in one of them";
        match (folded_joints(self, poses), joints) {
            (Some(folded), [_, inner, _]) => format!(
                "singular configuration: the joints {} are in line, and the mechanism can go on in two ways: {} bends to either \
                 side. {remedies}",
                list(&folded),
                name(inner)
            ),
            (Some(folded), _) => format!(
                "singular configuration: the joints {} fold, and the mechanism can go on in two ways. {remedies}",
                list(&folded)
            ),
            (None, _) => format!(
                "singular configuration: the joints {} fail as coordinates, and so do all others that the analytic model can \
                 choose: simulate with `--model engine`, or give one of these joints a stop (`lower` or `upper`) before this \
                 posture",
                list(joints)
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::{Body, Joint, JointKind};

    /// A parallelogram with sides of 1 m and 2 m, whose crank is at an angle.
    fn parallelogram(angle: f64) -> (Mechanism, Vec<Pose>) {
        let (sin, cos) = crate::numeric::elementary::sin_cos(angle);
        let body = |name: &str| Body::new(name, 1.0, 1.0);
        let joint = |bodies, points_m| Joint::new("", JointKind::Revolute, bodies, points_m);
        let mechanism = Mechanism {
            bodies: ["crank", "coupler", "rocker"].map(body).to_vec(),
            joints: vec![
                joint([None, Some(0)], [[0.0; 2]; 2]),
                joint([Some(0), Some(1)], [[1.0, 0.0], [0.0; 2]]),
                joint([Some(1), Some(2)], [[2.0, 0.0], [1.0, 0.0]]),
                joint([None, Some(2)], [[2.0, 0.0], [0.0; 2]]),
            ],
            ..Mechanism::default()
        };
        (mechanism, vec![[0.0, 0.0, angle], [cos, sin, 0.0], [2.0, 0.0, angle]])
    }

    #[test]
    fn a_parallelogram_folds_where_all_joints_are_in_line() {
        let folded = |angle| {
            let (mechanism, poses) = parallelogram(angle);
            folded_joints(&mechanism, &poses)
        };
        for angle in [0.0, 1e-3, std::f64::consts::PI] {
            assert_eq!(folded(angle), Some(vec![0, 1, 2, 3]), "{angle}");
        }
        for angle in [0.3, 1.0, -2.0] {
            assert_eq!(folded(angle), None, "{angle}");
        }
    }
}
