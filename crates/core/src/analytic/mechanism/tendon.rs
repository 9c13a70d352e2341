//! Tendons: length, its derivatives by the coordinates, tension and loads.
//!
//! By the principle of virtual work the arcs around pulleys do not contribute to the derivative of the length: it is
//! that of the straight segments between the centres of the path elements.

use super::cable::{Cable, Tension};
use super::contacts::{Contact, Surfaces};
use super::dynamics::{Chunk, Sums};
use super::model::{MechanismMode, MechanismModel, Scratch};
use super::motion::{LANES, Lanes, Motions, pair};
use super::nearest::{Frame, POSES};
use crate::analytic::contact::{StateRef, WithDerivatives, row_dot};
use crate::integrator::{Dynamic, Linearised};
use crate::mechanism::tendon::{MAX_WRAP_RAD, path_length, segment, wraps};
use crate::mechanism::{PathElement, Tendon};
use crate::numeric::plane::{cross, sub};
use crate::numeric::{Dual, Real};

/// Elongation beyond `rest_m`, and its rate.
pub(super) struct Elongation {
    pub value: f64,
    pub rate: f64,
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

impl MechanismModel {
    /// Elongation of a tendon.
    pub(super) fn elongation(&self, motions: &Motions<f64>, tendon: &Tendon) -> Elongation {
        let center = |element: &PathElement| motions.body(element.body).position(element.point_m);
        let (mut value, mut rate) = (path_length(&tendon.path, center) - tendon.rest_m, 0.0);
        for (elements, bodies) in segments(tendon) {
            let by_pose = segment_row(elements, &Self::frames(motions, bodies));
            rate += row_dot(&by_pose, &Self::pair_rates(motions, bodies));
        }
        for &(joint, factor) in &tendon.joints {
            value += factor * motions.joints[joint].coordinate;
            rate += factor * motions.joints[joint].rate;
        }
        Elongation { value, rate }
    }

    /// Adds the derivative of the length of a tendon by the coordinates.
    pub(super) fn add_length_row(&self, motions: &Motions<f64>, tendon: &Tendon, row: &mut [f64]) {
        for (elements, bodies) in segments(tendon) {
            let by_pose = segment_row(elements, &Self::frames(motions, bodies));
            self.add_pair_loads(motions, bodies, &by_pose, row);
        }
        for &(joint, factor) in &tendon.joints {
            self.add_joint_load(motions, joint, factor, row);
        }
    }

    /// Adds the second derivatives of the length of a tendon with respect to the coordinates to the derivatives of
    /// loads in `second`.
    fn add_second_derivatives(
        &self,
        (plain, motions): (&Motions<f64>, &[Motions<Lanes>]),
        tendon: &Tendon,
        second: &mut Sums<'_>,
    ) {
        for (elements, bodies) in segments(tendon) {
            let frames = Self::variable_frames(&Self::frames(plain, bodies), bodies);
            let row = segment_row(elements, &frames).map(|part| WithDerivatives {
                value: part.value,
                by_q: part.grad,
                ..WithDerivatives::default()
            });
            self.add_pair_derivatives((plain, motions), bodies, &row, &[], None, second);
        }
        for &(joint, factor) in &tendon.joints {
            let span = self.span_of_joint(joint);
            let support = &plain.joint_supports[joint].coordinates[..];
            for (at, chunk) in Chunk::of_group(span.first, span.size) {
                let row = |i| motions[at].joint_entry(joint, i);
                second.add_block(chunk, (support, row), Dual::constant(factor), [0.0; LANES]);
            }
        }
    }

    /// Derivatives of a distance, which is the length of a cable, by the coordinates, and of its rate by them.
    pub(super) fn distance_derivatives(
        &self,
        (plain, motions): (&Motions<f64>, &[Motions<Lanes>]),
        cable: &Tendon,
        v: &[f64],
        second: &mut Linearised<Dynamic>,
        (row, rate_q): (&mut [f64], &mut [f64]),
    ) {
        row.fill(0.0);
        self.add_length_row(plain, cable, row);
        second.clear();
        self.add_second_derivatives((plain, motions), cable, &mut Sums::of(second).1);
        rate_q.iter_mut().enumerate().for_each(|(j, entry)| *entry = row_dot(&second.a_q[j], v));
    }

    /// Elongation and tension of a tendon.
    pub(super) fn tension(
        &self,
        t: f64,
        mode: &MechanismMode,
        motions: &Motions<f64>,
        cable: &Cable,
    ) -> (Elongation, Tension) {
        let elongation = self.elongation(motions, &cable.tendon);
        let state = cable.contact.map(|contact| mode[contact]);
        let tension = cable.tension(t, state, elongation.value, elongation.rate);
        (elongation, tension)
    }

    /// Adds the loads of all tendons.
    pub(super) fn add_tendon_loads(
        &self,
        t: f64,
        mode: &MechanismMode,
        motions: &Motions<f64>,
        (load, g): (&mut [f64], &mut [f64]),
    ) {
        if self.cables.is_empty() {
            return;
        }
        let Scratch { row, .. } = &mut *self.scratch.borrow_mut();
        for cable in &self.cables {
            let (elongation, tension) = self.tension(t, mode, motions, cable);
            row.fill(0.0);
            self.add_length_row(motions, &cable.tendon, row);
            load.iter_mut().zip(&*row).for_each(|(load, part)| *load -= tension.total() * part);
            g[self.drive_work()] -= tension.pull * elongation.rate;
            g[self.contact_work()] -= tension.elastic * elongation.rate;
        }
    }

    /// Adds the derivatives of [`MechanismModel::add_tendon_loads`].
    pub(super) fn add_tendon_derivatives(
        &self,
        t: f64,
        v: &[f64],
        mode: &MechanismMode,
        (plain, motions): (&Motions<f64>, &[Motions<Lanes>]),
        sums: &mut Sums<'_>,
    ) {
        if self.cables.is_empty() {
            return;
        }
        let Scratch { row, second, .. } = &mut *self.scratch.borrow_mut();
        let (n, contact_work, drive_work) = (row.len(), self.contact_work(), self.drive_work());
        for cable in &self.cables {
            let (Elongation { rate, .. }, tension) = self.tension(t, mode, plain, cable);
            row.fill(0.0);
            self.add_length_row(plain, &cable.tendon, row);
            second.clear();
            self.add_second_derivatives((plain, motions), &cable.tendon, &mut Sums::of(second).1);
            let second = &second.a_q;
            for j in 0..n {
                let rate_q = row_dot(&second[j], v);
                let by_q = tension.by_elongation * row[j] + tension.by_rate * rate_q;
                let by_v = tension.by_rate * row[j];
                for i in 0..n {
                    sums.load_q[i][j] -= row[i] * by_q + tension.total() * second[i][j];
                    sums.load_v[i][j] -= row[i] * by_v;
                }
                sums.load_t[j] -= row[j] * tension.pull_rate;
                sums.g_q[drive_work][j] -= tension.pull * rate_q;
                sums.g_v[drive_work][j] -= tension.pull * row[j];
                sums.g_q[contact_work][j] -= by_q * rate + tension.elastic * rate_q;
                sums.g_v[contact_work][j] -= by_v * rate + tension.elastic * row[j];
            }
            sums.g_t[drive_work] -= tension.pull_rate * rate;
        }
    }

    /// Margin of each pulley to where the cable lifts off or wraps it too far, with tendon, path element and the rate of
    /// the margin. It is not a number if the cable cannot pass its elements.
    pub(super) fn wrap_margins<'a>(
        &'a self,
        motions: &'a Motions<f64>,
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

    /// Returns the length of a tendon, its rate, and its tension.
    pub fn tendon(&self, t: f64, (q, v): StateRef<'_, Dynamic>, mode: &MechanismMode, index: usize) -> [f64; 3] {
        let cable = &self.cables[index];
        self.with_motions((q, v), |motions| {
            let (elongation, tension) = self.tension(t, mode, motions, cable);
            [elongation.value + cable.tendon.rest_m, elongation.rate, tension.total()]
        })
    }

    /// Forces of all tendons: a body, a point and a force for each end of a segment.
    pub(super) fn tendon_forces<'a>(
        &'a self,
        motions: &'a Motions<f64>,
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
