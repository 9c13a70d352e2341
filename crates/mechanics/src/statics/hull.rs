//! Distance of the origin from the wrenches that contacts exert with a normal force of 1.
//!
//! The wrenches of a contact are those between the edges n ± μ t of its friction cone, a force and a moment about the
//! centre of mass divided by the radius of the object. Contacts can press on an object at rest, in any ratio, if the origin
//! is in the convex hull of all edges. The distance of the origin from the hull varies steadily with the contacts, unlike
//! the answer of an exact balance, which a misalignment of 1e-10 rad changes.
//!
//! The nearest point is found by Wolfe's method (P. Wolfe, Finding the nearest point in a polytope, Mathematical
//! Programming 11, 1976): it keeps a simplex of vertices whose affine hull has its nearest point inside it, adds the
//! vertex that lies deepest beyond this point, and removes vertices until the nearest point is inside again.

use super::FrictionContact;
use super::force_closure::{Wrench, edges};

/// Contacts grip an object if the distance of the origin from the hull is below this value: a misalignment of opposite
/// contacts by 1e-6 rad.
pub const GRIP_TOLERANCE: f64 = 1e-6;

/// A vertex lies beyond the nearest point if it reduces the square of the distance by more than this part of the largest
/// square of a vertex: rounding errors of scalar products are a few 1e-16 of it.
const PROGRESS: f64 = 1e-15;

/// Weights of vertices below this are rounding errors of the solution of equations of this size.
const MIN_WEIGHT: f64 = 1e-14;

/// Wolfe's method ends after fewer steps than there are simplices; a handful of contacts need 10.
const MAX_STEPS: usize = 1000;

/// Convex hull of the edges of friction cones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WrenchHull {
    vertices: Vec<Wrench>,
}

impl WrenchHull {
    pub fn clear(&mut self) {
        self.vertices.clear();
    }

    /// Adds the two edges of the friction cone of a contact.
    pub fn add(&mut self, edges: [Wrench; 2]) {
        self.vertices.extend(edges);
    }

    /// Returns the edges of the friction cone of a contact with an object. Moments are about its centre of mass,
    /// divided by its radius.
    pub fn edges_of(contact: &FrictionContact, centre_m: [f64; 2], radius_m: f64) -> [Wrench; 2] {
        edges(contact, centre_m, radius_m)
    }

    /// Whether all vertices lie beyond [`GRIP_TOLERANCE`] in a direction, which then separates the hull from the
    /// origin.
    pub fn is_separated(&self, direction: &Wrench) -> bool {
        let length = direction.norm();
        self.vertices.iter().all(|vertex| direction.dot(vertex) > GRIP_TOLERANCE * length)
    }

    /// Returns the point nearest to the origin in the affine hull of the `support` vertices. `None` if these vertices
    /// are dependent, or if the point does not lie between them and thus not in the convex hull.
    pub fn nearest_of(&self, support: &[usize]) -> Option<Wrench> {
        let vertex = |index: &usize| Some((*self.vertices.get(*index)?, 0.0));
        let simplex = support.iter().map(vertex).collect::<Option<Vec<_>>>()?;
        let weights = affine_weights(&simplex).filter(|weights| weights.iter().all(|weight| *weight > 0.0))?;
        Some(simplex.iter().zip(weights).map(|((vertex, _), weight)| vertex * weight).sum())
    }

    /// Returns a lower bound of the depth of the origin in the hull, from vertices whose hull contains it: for four
    /// vertices, the distance from the nearest face of their tetrahedron; for fewer, 0.
    pub fn depth_in(&self, support: &[usize]) -> f64 {
        let &[a, b, c, d] = support else { return 0.0 };
        let distance = |face: [usize; 3]| {
            let [p, q, r] = face.map(|index| self.vertices[index]);
            let normal = (q - p).cross(&(r - p));
            normal.dot(&p).abs() / normal.norm()
        };
        let distances = [[a, b, c], [a, b, d], [a, c, d], [b, c, d]].map(distance);
        // Not a number for a face without an area.
        let is_known = distances.iter().all(|distance| distance.is_finite());
        if is_known { distances.into_iter().fold(f64::INFINITY, f64::min) } else { 0.0 }
    }

    /// Returns the point of the hull that is nearest to the origin, and the indices of the vertices between which it
    /// lies; `None` without contacts.
    pub fn nearest(&self) -> Option<(Wrench, Vec<usize>)> {
        let square = |vertex: &Wrench| vertex.dot(vertex);
        let first = self.vertices.iter().min_by(|a, b| square(a).total_cmp(&square(b)))?;
        let largest = self.vertices.iter().map(square).fold(0.0, f64::max);
        let mut simplex = vec![(*first, 1.0)];
        let mut nearest = *first;
        for _ in 0..MAX_STEPS {
            let along = |vertex: &&Wrench| nearest.dot(vertex);
            let Some(next) = self.vertices.iter().min_by(|a, b| along(a).total_cmp(&along(b))) else { break };
            if square(&nearest) - along(&next) <= PROGRESS * largest || simplex.iter().any(|(kept, _)| kept == next) {
                break;
            }
            simplex.push((*next, 0.0));
            reduce(&mut simplex);
            nearest = simplex.iter().map(|(vertex, weight)| vertex * *weight).sum();
        }
        let index = |(kept, _): &(Wrench, f64)| self.vertices.iter().position(|vertex| vertex == kept);
        Some((nearest, simplex.iter().filter_map(index).collect()))
    }
}

/// Returns the distance of the origin from the convex hull of the wrenches of contacts with a normal force of 1;
/// infinite without contacts. Contacts grip an object if the distance is below [`GRIP_TOLERANCE`].
pub fn hull_distance(contacts: &[FrictionContact], centre_m: [f64; 2], radius_m: f64) -> f64 {
    let mut hull = WrenchHull::default();
    contacts.iter().for_each(|contact| hull.add(edges(contact, centre_m, radius_m)));
    hull.nearest().map_or(f64::INFINITY, |(nearest, _)| nearest.norm())
}

/// Moves the weights to the nearest point of the simplex, and removes the vertices that it does not need.
fn reduce(simplex: &mut Vec<(Wrench, f64)>) {
    while let Some(weights) = affine_weights(simplex) {
        if weights.iter().all(|weight| *weight > MIN_WEIGHT) {
            simplex.iter_mut().zip(weights).for_each(|((_, weight), found)| *weight = found);
            return;
        }
        // As far as the weights stay positive.
        let limits = simplex.iter().zip(&weights).filter(|(_, to)| **to <= MIN_WEIGHT);
        let fraction = limits.map(|((_, from), to)| from / (from - to).max(f64::MIN_POSITIVE)).fold(1.0, f64::min);
        let removed = simplex.iter().zip(&weights).map(|((_, from), to)| from + fraction * (to - from));
        let removed: Vec<f64> = removed.collect();
        simplex.iter_mut().zip(&removed).for_each(|((_, weight), found)| *weight = *found);
        let least = removed.iter().copied().fold(f64::INFINITY, f64::min);
        simplex.retain(|(_, weight)| *weight > MIN_WEIGHT.max(least));
        let sum: f64 = simplex.iter().map(|(_, weight)| weight).sum();
        simplex.iter_mut().for_each(|(_, weight)| *weight /= sum);
    }
}

/// Weights of the vertices, of sum 1, of the point of their affine hull that is nearest to the origin; `None` of a single
/// vertex, and if the vertices are not independent.
fn affine_weights(simplex: &[(Wrench, f64)]) -> Option<Vec<f64>> {
    let ((origin, _), others) = simplex.split_first()?;
    if others.is_empty() {
        return None;
    }
    let sides = nalgebra::DMatrix::from_fn(3, others.len(), |row, column| (others[column].0 - origin)[row]);
    let qr = sides.qr();
    let target = -nalgebra::DVector::from_column_slice(origin.as_slice());
    let mut weights = qr.q().tr_mul(&target);
    if !qr.r().solve_upper_triangular_mut(&mut weights) {
        return None;
    }
    let rest = 1.0 - weights.sum();
    Some(std::iter::once(rest).chain(weights.iter().copied()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_depth_in_a_tetrahedron_is_that_from_its_nearest_face() {
        let mut hull = WrenchHull::default();
        let [a, b] = [Wrench::new(1.0, 1.0, 1.0), Wrench::new(1.0, -1.0, -1.0)];
        let [c, d] = [Wrench::new(-1.0, 1.0, -1.0), Wrench::new(-1.0, -1.0, 1.0)];
        hull.add([a, b]);
        hull.add([c, d]);
        assert!((hull.depth_in(&[0, 1, 2, 3]) - 1.0 / 3f64.sqrt()).abs() < 1e-15);
        assert_eq!((hull.depth_in(&[0, 1, 2]), hull.depth_in(&[0, 1, 2, 2])), (0.0, 0.0));
    }
}
