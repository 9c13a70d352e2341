//! Whether contacts grip the object: the distance of the origin from the convex hull of their wrenches.

use crate::statics::{GRIP_TOLERANCE, Wrench, WrenchHull};

/// Bisections of the time at which contacts begin or cease to grip: to 1e-12 of a step.
const BISECTIONS: usize = 40;

/// Edges of the friction cone of a contact.
pub(super) type Edges = [Wrench; 2];

/// Decides one instant after the other, with what is known of the instant before.
#[derive(Clone, Debug, Default)]
pub(super) struct GripSearch {
    hull: WrenchHull,
    /// A direction in which all wrenches of the last instant without a grip have a positive part.
    separation: Wrench,
    /// Vertices of the hull between which the origin was when the contacts last gripped.
    support: Vec<usize>,
    before: Option<Instant>,
    /// Active points with their edges, and the distance of the origin from the hull, when it was last computed; negative
    /// inside the hull.
    computed: Option<(Vec<(usize, Edges)>, f64)>,
    /// Memory for active points.
    memory: Vec<(usize, Edges)>,
}

#[derive(Clone, Debug)]
struct Instant {
    time_s: f64,
    /// Active points with their edges.
    contacts: Vec<(usize, Edges)>,
    is_gripped: bool,
}

impl GripSearch {
    /// Returns whether the active points grip the object at a time. If this has changed since the last instant although
    /// the active points are the same, also returns the time of the change. It is searched under the assumption that
    /// the edges change linearly.
    pub fn evaluate(&mut self, time_s: f64, active: impl Iterator<Item = (usize, Edges)>) -> (bool, Option<f64>) {
        let mut contacts = std::mem::take(&mut self.memory);
        contacts.clear();
        contacts.extend(active);
        let is_gripped = self.still_grips(&contacts) || self.is_gripped(&contacts);
        let before = self.before.take();
        let is_same = |before: &&Instant| {
            let of_points = before.contacts.iter().zip(&contacts);
            before.is_gripped != is_gripped
                && before.contacts.len() == contacts.len()
                && of_points.into_iter().all(|((point, _), (other, _))| point == other)
        };
        let changed_s = before.as_ref().filter(is_same).map(|before| {
            let (mut from, mut to) = (0.0, 1.0);
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (from + to);
                let between = |k: usize| {
                    let (point, [a, b]) = (contacts[k].0, [before.contacts[k].1, contacts[k].1]);
                    (point, [0, 1].map(|edge: usize| a[edge] + (b[edge] - a[edge]) * middle))
                };
                let contacts: Vec<(usize, Edges)> = (0..contacts.len()).map(between).collect();
                if self.is_gripped(&contacts) == is_gripped { to = middle } else { from = middle }
            }
            before.time_s + to * (time_s - before.time_s)
        });
        self.memory = before.map_or_else(Vec::new, |before| before.contacts);
        self.before = Some(Instant { time_s, contacts, is_gripped });
        (is_gripped, changed_s)
    }

    /// Whether the same points gripped the object when the distance was last computed, and have moved so little that they
    /// still do: the distance, also that inside the hull, changes by at most the largest displacement of an edge.
    fn still_grips(&self, contacts: &[(usize, Edges)]) -> bool {
        let Some((computed, distance)) = &self.computed else { return false };
        let is_near = |((point, edges), (other, before)): (&(usize, Edges), &(usize, Edges))| {
            let moved = (0..2).map(|edge| (edges[edge] - before[edge]).norm()).fold(0.0, f64::max);
            point == other && distance + moved < GRIP_TOLERANCE
        };
        computed.len() == contacts.len() && contacts.iter().zip(computed).all(is_near)
    }

    fn is_gripped(&mut self, contacts: &[(usize, Edges)]) -> bool {
        self.hull.clear();
        contacts.iter().for_each(|(_, edges)| self.hull.add(*edges));
        // A normal force alone is not balanced.
        if contacts.len() < 2 || self.hull.is_separated(&self.separation) {
            return false;
        }
        // Most often the origin is between the same vertices as before.
        let is_between = |nearest: Wrench| nearest.norm() < GRIP_TOLERANCE;
        if !self.support.is_empty() && self.hull.nearest_of(&self.support).is_some_and(is_between) {
            self.keep(contacts, -self.hull.depth_in(&self.support));
            return true;
        }
        let Some((nearest, support)) = self.hull.nearest() else { return false };
        let distance = nearest.norm();
        let is_gripped = distance < GRIP_TOLERANCE;
        match is_gripped {
            true => self.support = support,
            false => self.separation = nearest,
        }
        self.keep(contacts, if is_gripped { distance - self.hull.depth_in(&self.support) } else { distance });
        is_gripped
    }

    /// Keeps a distance with the contacts for which it was computed.
    fn keep(&mut self, contacts: &[(usize, Edges)], distance: f64) {
        let (computed, of_computed) = self.computed.get_or_insert_default();
        computed.clear();
        computed.extend_from_slice(contacts);
        *of_computed = distance;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::elementary::sin_cos;
    use crate::statics::FrictionContact;

    /// Edges of two opposite contacts of a disc of radius 1. The second contact is turned.
    fn contacts(turn_rad: f64) -> [(usize, Edges); 2] {
        [0.0, std::f64::consts::PI + turn_rad].map(|angle_rad| {
            let (sin, cos) = sin_cos(angle_rad);
            let contact = FrictionContact { point_m: [cos, sin], push: [-cos, -sin], mu: 0.5 };
            (usize::from(angle_rad > 0.0), WrenchHull::edges_of(&contact, [0.0; 2], 1.0))
        })
    }

    /// The line between the contacts leaves both friction cones at twice the friction angle.
    #[test]
    fn what_is_known_of_the_instant_before_changes_no_decision() {
        let (mut search, limit_rad) = (GripSearch::default(), 2.0 * 0.5f64.atan());
        let turns = (0..400).map(|k: i32| 1.5 * limit_rad * f64::from(200 - (k - 200).abs()) / 200.0);
        for (instant, turn_rad) in turns.enumerate() {
            let (is_gripped, _) = search.evaluate(instant as f64, contacts(turn_rad).into_iter());
            let (alone, _) = GripSearch::default().evaluate(0.0, contacts(turn_rad).into_iter());
            assert_eq!((is_gripped, alone), (turn_rad < limit_rad, turn_rad < limit_rad), "{turn_rad}");
        }
    }
}
