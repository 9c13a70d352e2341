//! Tendons: length, its derivatives by the coordinates, tension and loads.
//!
//! By the principle of virtual work the arcs around pulleys do not contribute to the derivative of the length: it is
//! that of the straight segments between the centres of the path elements.

use super::cable::{Cable, Tension};
use super::dynamics::Sums;
use super::model::{Contact, MechanismMode, MechanismModel, Surfaces};
use super::motion::{Motions, pair};
use super::nearest::{Frame, POSES};
use crate::analytic::contact::{WithDerivatives, row_dot};
use crate::mechanism::tendon::{MAX_WRAP_RAD, path_length, segment, wraps};
use crate::mechanism::{PathElement, Tendon};
use crate::numeric::plane::{cross, sub};
use crate::numeric::{Dual, Real};

/// Elongation beyond `rest_m`, its rate, and the derivative of the length by the coordinates.
pub(super) struct Elongation<const N: usize> {
    pub value: f64,
    pub rate: f64,
    pub row: [f64; N],
}

/// Derivative of the length of a segment between two path elements by the relative pose of their bodies.
fn segment_row<T: Real>(elements: [&PathElement; 2], frames: &[Frame<T>; 2]) -> [T; POSES] {
    let centers = pair(|k| frames[k].position(elements[k].point_m));
    let u = segment(elements, sub(centers[1], centers[0])).direction;
    let turn = |k: usize| cross(sub(centers[k], frames[k].origin), u);
    [-u[0], -u[1], -turn(0), turn(1)]
}

/// Pairs of path elements with a segment, and their bodies.
fn segments(tendon: &Tendon) -> impl Iterator<Item = ([&PathElement; 2], [Option<usize>; 2])> {
    tendon.path.windows(2).map(|ends| ([&ends[0], &ends[1]], [ends[0].body, ends[1].body]))
}

impl<const N: usize, const K: usize, const C: usize> MechanismModel<N, K, C> {
    pub(super) fn elongation(&self, motions: &Motions<f64, K>, tendon: &Tendon, v: &[f64; N]) -> Elongation<N> {
        let center = |element: &PathElement| motions.body(element.body).position(element.point_m);
        let (mut value, mut row) = (path_length(&tendon.path, center) - tendon.rest_m, [0.0; N]);
        for (elements, bodies) in segments(tendon) {
            let by_pose = segment_row(elements, &Self::frames(motions, bodies));
            self.add_pair_loads(motions, bodies, &by_pose, &mut row);
        }
        for &(joint, factor) in &tendon.joints {
            let (span, motion) = (self.span_of_joint(joint), &motions.joints[joint]);
            value += factor * motion.coordinate;
            (0..span.size).for_each(|i| row[span.first + i] += factor * motion.row[i]);
        }
        Elongation { value, rate: row_dot(&row, v), row }
    }

    /// Second derivatives of the length of a tendon by the coordinates.
    fn second_derivatives(
        &self,
        (plain, motions): (&Motions<f64, K>, &Motions<Dual<K>, K>),
        tendon: &Tendon,
    ) -> [[f64; N]; N] {
        let mut sums = Sums::<N, 0>::ZERO;
        for (elements, bodies) in segments(tendon) {
            let frames = Self::variable_frames(&Self::frames(plain, bodies), bodies);
            let row = segment_row(elements, &frames).map(|part| WithDerivatives {
                value: part.value,
                by_q: part.grad,
                ..WithDerivatives::default()
            });
            self.add_pair_derivatives(motions, bodies, &row, &[], None, &mut sums);
        }
        for &(joint, factor) in &tendon.joints {
            let (span, row) = (self.span_of_joint(joint), &motions.joints[joint].row);
            sums.add_block((span.first, span.size), row, Dual::constant(factor), |_| 0.0);
        }
        sums.load_q
    }

    /// Elongation and tension of a tendon.
    pub(super) fn tension(
        &self,
        t: f64,
        v: &[f64; N],
        mode: &MechanismMode<C>,
        motions: &Motions<f64, K>,
        cable: &Cable,
    ) -> (Elongation<N>, Tension) {
        let elongation = self.elongation(motions, &cable.tendon, v);
        let state = cable.contact.map(|contact| mode[contact]);
        let tension = cable.tension(t, state, elongation.value, elongation.rate);
        (elongation, tension)
    }

    /// Adds the loads of all tendons.
    pub(super) fn add_tendon_loads<const Z: usize>(
        &self,
        t: f64,
        v: &[f64; N],
        mode: &MechanismMode<C>,
        motions: &Motions<f64, K>,
        load: &mut [f64; N],
        g: &mut [f64; Z],
    ) {
        for cable in &self.cables {
            let (elongation, tension) = self.tension(t, v, mode, motions, cable);
            (0..N).for_each(|i| load[i] -= tension.total() * elongation.row[i]);
            g[Self::DRIVE_WORK] -= tension.pull * elongation.rate;
            g[Self::CONTACT_WORK] -= tension.elastic * elongation.rate;
        }
    }

    /// Adds the derivatives of [`MechanismModel::add_tendon_loads`].
    pub(super) fn add_tendon_derivatives<const Z: usize>(
        &self,
        t: f64,
        v: &[f64; N],
        mode: &MechanismMode<C>,
        (plain, motions): (&Motions<f64, K>, &Motions<Dual<K>, K>),
        sums: &mut Sums<N, Z>,
    ) {
        for cable in &self.cables {
            let (Elongation { rate, row, .. }, tension) = self.tension(t, v, mode, plain, cable);
            let second = self.second_derivatives((plain, motions), &cable.tendon);
            for j in 0..N {
                let rate_q = row_dot(&second[j], v);
                let by_q = tension.by_elongation * row[j] + tension.by_rate * rate_q;
                let by_v = tension.by_rate * row[j];
                for i in 0..N {
                    sums.load_q[i][j] -= row[i] * by_q + tension.total() * second[i][j];
                    sums.load_v[i][j] -= row[i] * by_v;
                }
                sums.load_t[j] -= row[j] * tension.pull_rate;
                sums.g_q[Self::DRIVE_WORK][j] -= tension.pull * rate_q;
                sums.g_v[Self::DRIVE_WORK][j] -= tension.pull * row[j];
                sums.g_q[Self::CONTACT_WORK][j] -= by_q * rate + tension.elastic * rate_q;
                sums.g_v[Self::CONTACT_WORK][j] -= by_v * rate + tension.elastic * row[j];
            }
            sums.g_t[Self::DRIVE_WORK] -= tension.pull_rate * rate;
        }
    }

    /// Margin of each pulley to where the cable lifts off or wraps it too far, with tendon, path element and the rate of
    /// the margin. It is not a number if the cable cannot pass its elements.
    pub(super) fn wrap_margins<'a>(
        &'a self,
        motions: &'a Motions<f64, K>,
    ) -> impl Iterator<Item = (usize, usize, [f64; 2])> + 'a {
        self.cables.iter().enumerate().flat_map(move |(index, Cable { tendon, .. })| {
            let center = |element: &PathElement| motions.body(element.body).position(element.point_m);
            let rate = move |element: &PathElement| motions.body(element.body).point(element.point_m).rate;
            // A segment turns at the rate of its ends across it.
            let turning = move |k: usize| {
                let ends = [&tendon.path[k], &tendon.path[k + 1]];
                let part = segment(ends, sub(center(ends[1]), center(ends[0])));
                cross(part.direction, sub(rate(ends[1]), rate(ends[0]))) / part.length
            };
            wraps(&tendon.path, center).map(move |(element, wrap)| {
                let wrap_rate = tendon.path[element].side * (turning(element) - turning(element - 1));
                let is_high = wrap > 0.5 * MAX_WRAP_RAD;
                let margin = if is_high { [MAX_WRAP_RAD - wrap, -wrap_rate] } else { [wrap, wrap_rate] };
                (index, element, margin)
            })
        })
    }

    /// Length of a tendon, its rate and its tension.
    pub fn tendon(&self, t: f64, (q, v): (&[f64; N], &[f64; N]), mode: &MechanismMode<C>, index: usize) -> [f64; 3] {
        let cable = &self.cables[index];
        self.with_motions((q, v), |motions| {
            let (elongation, tension) = self.tension(t, v, mode, motions, cable);
            [elongation.value + cable.tendon.rest_m, elongation.rate, tension.total()]
        })
    }

    /// Forces of all tendons: a body, a point and a force for each end of a segment.
    pub(super) fn tendon_forces<'a>(
        &'a self,
        motions: &'a Motions<f64, K>,
        tensions: &'a [f64],
    ) -> impl Iterator<Item = (Option<usize>, [f64; 2], [f64; 2])> + 'a {
        self.cables.iter().zip(tensions).flat_map(move |(cable, tension)| {
            segments(&cable.tendon).flat_map(move |(elements, bodies)| {
                let centers = pair(|k| motions.body(bodies[k]).position(elements[k].point_m));
                let u = segment(elements, sub(centers[1], centers[0])).direction;
                [
                    (bodies[0], centers[0], u.map(|part| tension * part)),
                    (bodies[1], centers[1], u.map(|part| -tension * part)),
                ]
            })
        })
    }

    /// Contacts that are reported: all except tendons and friction of joints.
    pub(super) fn reported_contacts(&self) -> usize {
        let is_reported = |contact: &&Contact| matches!(contact.surfaces, Surfaces::Point(_) | Surfaces::Limit(_));
        self.contacts.iter().filter(is_reported).count()
    }
}
