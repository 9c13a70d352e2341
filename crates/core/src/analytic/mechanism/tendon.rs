//! Tendons: length, its derivatives by the coordinates, tension and loads.
//!
//! By the principle of virtual work the arcs around pulleys do not contribute to the derivative of the length: it is
//! that of the straight segments between the centres of the path elements. Elements from which the cable has lifted off
//! do not belong to the path.

use super::cable::{Cable, Tension};
use super::contacts::{Contact, Surfaces};
use super::dynamics::{Chunk, Sums};
use super::model::{MechanismMode, MechanismModel, Scratch};
use super::motion::{LANES, Lanes, Motions, pair};
use super::nearest::{Frame, POSES};
use super::strands::{ElementReading, Strand, StrandDerivatives, Strands};
use crate::analytic::contact::{StateRef, WithDerivatives, row_dot};
use crate::integrator::{Dynamic, EventFunction, Linearised, RootSearch};
use crate::mechanism::PathElement;
use crate::mechanism::tendon::{
    BAND, Bend, CableFault, MAX_WRAP_RAD, Segment, find_fault, gap, neighbours, path_length, segment, settle_path,
    strands, turn, wrap,
};
use crate::numeric::elementary::exp;
use crate::numeric::plane::{Vector, add, cross, dot, perp, scale, sub};
use crate::numeric::{Dual, Real};

/// Tolerance of locating a lift-off or a return, as a part of its band.
const BAND_TOLERANCE: f64 = 0.3;
/// Depth below which a gap has not closed but jumped, in radii of the pulley: a closing gap is located within its band.
const JUMP: f64 = 1e3 * BAND;

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

/// Derivative of the angle of a segment, as [`segment_row`].
fn turn_row(elements: [&PathElement; 2], frames: &[Frame<f64>; 2]) -> [f64; POSES] {
    let centers = pair(|k| frames[k].position(elements[k].point_m));
    let Segment { length, direction } = segment(elements, sub(centers[1], centers[0]));
    let across = scale(perp(direction), length.recip());
    let turn = |k: usize| cross(sub(centers[k], frames[k].origin), across);
    [-across[0], -across[1], -turn(0), turn(1)]
}

/// Pairs of path elements with a segment, and their bodies.
fn segments<'a>(
    cable: &'a Cable,
    motions: &'a Motions<f64>,
) -> impl Iterator<Item = ([&'a PathElement; 2], [Option<usize>; 2])> {
    let path = &cable.tendon.path;
    strands(cable.bends(&motions.bends)).map(|ends| {
        let ends = ends.map(|element| &path[element]);
        (ends, ends.map(|element| element.body))
    })
}

/// Position of the centre of a path element.
fn center(motions: &Motions<f64>) -> impl Fn(&PathElement) -> Vector<f64> + Copy {
    |element| motions.body(element.body).position(element.point_m)
}

impl MechanismModel {
    /// Elongation of a tendon.
    pub(super) fn elongation(&self, motions: &Motions<f64>, cable: &Cable) -> Elongation {
        let tendon = &cable.tendon;
        let length = path_length(&tendon.path, cable.bends(&motions.bends), center(motions));
        let (mut value, mut rate) = (length - tendon.rest_m, 0.0);
        for (elements, bodies) in segments(cable, motions) {
            let by_pose = segment_row(elements, &Self::frames(motions, bodies));
            rate += row_dot(&by_pose, &Self::pair_rates(motions, bodies));
        }
        for &(joint, factor) in tendon.spools() {
            value += factor * motions.joints[joint].coordinate;
            rate += factor * motions.joints[joint].rate;
        }
        Elongation { value, rate }
    }

    /// Adds the derivative of the length of a tendon by the coordinates.
    pub(super) fn add_length_row(&self, motions: &Motions<f64>, cable: &Cable, row: &mut [f64]) {
        for (elements, bodies) in segments(cable, motions) {
            let by_pose = segment_row(elements, &Self::frames(motions, bodies));
            self.add_pair_loads(motions, bodies, &by_pose, row);
        }
        for &(joint, factor) in cable.tendon.spools() {
            self.add_joint_load(motions, joint, factor, row);
        }
    }

    /// Adds the second derivatives of the length of a segment with respect to the coordinates to the derivatives of loads in
    /// `second`.
    fn add_segment_derivatives(
        &self,
        (plain, motions): (&Motions<f64>, &[Motions<Lanes>]),
        (elements, bodies): ([&PathElement; 2], [Option<usize>; 2]),
        second: &mut Sums<'_>,
    ) {
        let frames = Self::variable_frames(&Self::frames(plain, bodies), bodies);
        let row = segment_row(elements, &frames).map(|part| WithDerivatives {
            value: part.value,
            by_q: part.grad,
            ..WithDerivatives::default()
        });
        self.add_pair_derivatives((plain, motions), bodies, &row, &[], None, second);
    }

    /// The same for the length on a spool.
    fn add_spool_derivatives(
        &self,
        (plain, motions): (&Motions<f64>, &[Motions<Lanes>]),
        (joint, factor): (usize, f64),
        second: &mut Sums<'_>,
    ) {
        let span = self.span_of_joint(joint);
        let support = &plain.joint_supports[joint].coordinates[..];
        for (at, chunk) in Chunk::of_group(span.first, span.size) {
            let row = |i| motions[at].joint_entry(joint, i);
            second.add_block(chunk, (support, row), Dual::constant(factor), [0.0; LANES]);
        }
    }

    /// Adds the second derivatives of the length of a tendon, as [`MechanismModel::add_segment_derivatives`].
    fn add_second_derivatives(
        &self,
        (plain, motions): (&Motions<f64>, &[Motions<Lanes>]),
        cable: &Cable,
        second: &mut Sums<'_>,
    ) {
        for segment in segments(cable, plain) {
            self.add_segment_derivatives((plain, motions), segment, second);
        }
        for spool in cable.tendon.spools() {
            self.add_spool_derivatives((plain, motions), *spool, second);
        }
    }

    /// Derivatives of a distance, which is the length of a cable, by the coordinates, and of its rate by them.
    pub(super) fn distance_derivatives(
        &self,
        (plain, motions): (&Motions<f64>, &[Motions<Lanes>]),
        cable: &Cable,
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
        let elongation = self.elongation(motions, cable);
        let state = cable.contact.map(|contact| mode[contact]);
        let tension = cable.tension(t, state, elongation.value, elongation.rate);
        (elongation, tension)
    }

    /// Adds the loads of all tendons.
    pub(super) fn add_tendon_loads(
        &self,
        t: f64,
        v: &[f64],
        mode: &MechanismMode,
        motions: &Motions<f64>,
        (load, g): (&mut [f64], &mut [f64]),
    ) {
        if self.cables.is_empty() {
            return;
        }
        let Scratch { row, strands, .. } = &mut *self.scratch.borrow_mut();
        for cable in &self.cables {
            let (elongation, tension) = self.tension(t, mode, motions, cable);
            g[self.drive_work()] -= tension.pull * elongation.rate;
            g[self.contact_work()] -= tension.elastic * elongation.rate;
            if !cable.frictions.is_empty() {
                self.find_strands(v, mode, motions, (cable, tension.total()), &mut strands.all);
                self.add_strand_loads(v, mode, motions, (cable, &strands.all), (&mut *load, &mut *g));
                continue;
            }
            row.fill(0.0);
            self.add_length_row(motions, cable, row);
            load.iter_mut().zip(&*row).for_each(|(load, part)| *load -= tension.total() * part);
        }
    }

    /// Finds the strands of a cable, from the first to the last, with their tensions; `first` is that of the first one.
    fn find_strands(
        &self,
        v: &[f64],
        mode: &MechanismMode,
        motions: &Motions<f64>,
        (cable, first): (&Cable, f64),
        found: &mut Vec<Strand>,
    ) {
        let tendon = &cable.tendon;
        found.clear();
        for ends in strands(cable.bends(&motions.bends)) {
            let elements = ends.map(|element| &tendon.path[element]);
            let (bodies, centers) = (elements.map(|element| element.body), elements.map(center(motions)));
            let row = segment_row(elements, &Self::frames(motions, bodies));
            let rate = row_dot(&row, &Self::pair_rates(motions, bodies));
            let direction = segment(elements, sub(centers[1], centers[0])).direction;
            found.push(Strand { ends, bodies, row, direction, rate, tension: first, turn: 0.0, slip: 0.0 });
        }
        let rate_of = |spools: &[(usize, f64)]| -> f64 {
            spools.iter().map(|(joint, factor)| factor * motions.joints[*joint].rate).sum()
        };
        found.first_mut().into_iter().for_each(|strand| strand.rate += rate_of(&tendon.joints));
        found.last_mut().into_iter().for_each(|strand| strand.rate += rate_of(&tendon.far_joints));
        let mut behind = found.last().map_or(0.0, |strand| strand.rate);
        for k in (1..found.len()).rev() {
            let next = found[k].direction;
            let strand = &mut found[k - 1];
            let element = &tendon.path[strand.ends[1]];
            strand.turn = turn(element, cable.bends(&motions.bends)[strand.ends[1]], [strand.direction, next]);
            strand.slip = element.signed_radius_m() * motions.body(element.body).rate[2] - behind;
            behind += strand.rate;
        }
        for k in 1..found.len() {
            let Strand { ends: [_, element], turn, slip, tension, .. } = found[k - 1];
            found[k].tension = match self.friction_coefficient(v, mode, (cable, element), slip) {
                Some([mu, _]) => tension * exp(-mu * turn),
                None => tension,
            };
        }
    }

    /// Friction coefficient at a path element, and its contribution to the rate of the internal state of its law; `None`
    /// without friction.
    fn friction_coefficient<T: Real + FromState>(
        &self,
        v: &[f64],
        mode: &MechanismMode,
        (cable, element): (&Cable, usize),
        slip: T,
    ) -> Option<[T; 2]> {
        let contact = (*cable.frictions.get(element)?)?;
        let state = self.contacts[contact].state.map(|state| T::from_state(v[state]));
        let range = mode.contacts.friction_range(contact);
        let [force, state_rate] = self.contacts[contact].joint_friction(slip, state, range);
        Some([-force, state_rate])
    }

    /// Adds the loads of the strands of a cable with friction.
    fn add_strand_loads(
        &self,
        v: &[f64],
        mode: &MechanismMode,
        motions: &Motions<f64>,
        (cable, all): (&Cable, &[Strand]),
        (load, g): (&mut [f64], &mut [f64]),
    ) {
        let tendon = &cable.tendon;
        for (strand, next) in all.iter().zip(all.iter().skip(1).map(Some).chain([None])) {
            let Strand { ends: [_, element], bodies, row, tension, slip, .. } = strand;
            self.add_pair_loads(motions, *bodies, &row.map(|part| -tension * part), load);
            let Some(next) = next else { continue };
            let (element_of, change) = (&tendon.path[*element], next.tension - tension);
            let moment = [0.0, 0.0, element_of.signed_radius_m() * change, 0.0];
            self.add_pair_loads(motions, [element_of.body, None], &moment, load);
            for work in [self.contact_work(), self.cable_work()] {
                g[work] += change * slip;
            }
            let friction = self.friction_coefficient(v, mode, (cable, *element), *slip);
            let contact = cable.frictions[*element].map(|contact| &self.contacts[contact]);
            if let (Some([_, state_rate]), Some(Contact { state: Some(state), .. })) = (friction, contact) {
                load[*state] += state_rate;
            }
        }
        let ends = [(all.first(), &tendon.joints), (all.last(), &tendon.far_joints)];
        for (strand, spools) in ends {
            let tension = strand.map_or(0.0, |strand| strand.tension);
            spools.iter().for_each(|(joint, factor)| self.add_joint_load(motions, *joint, -factor * tension, load));
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
        let Scratch { row, second, strands, .. } = &mut *self.scratch.borrow_mut();
        let (n, contact_work, drive_work) = (row.len(), self.contact_work(), self.drive_work());
        for cable in &self.cables {
            let (elongation, tension) = self.tension(t, mode, plain, cable);
            let rate = elongation.rate;
            if !cable.frictions.is_empty() {
                self.find_strands(v, mode, plain, (cable, tension.total()), &mut strands.all);
                let of_cable = (cable, elongation, tension);
                self.add_strand_derivatives(v, mode, (plain, motions), of_cable, (second, strands), sums);
                continue;
            }
            row.fill(0.0);
            self.add_length_row(plain, cable, row);
            second.clear();
            self.add_second_derivatives((plain, motions), cable, &mut Sums::of(second).1);
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

    /// Adds the derivatives of the loads of a cable with friction, whose strands are found.
    fn add_strand_derivatives(
        &self,
        v: &[f64],
        mode: &MechanismMode,
        (plain, motions): (&Motions<f64>, &[Motions<Lanes>]),
        (cable, elongation, of_first): (&Cable, Elongation, Tension),
        (second, memory): (&mut Linearised<Dynamic>, &mut Strands),
        sums: &mut Sums<'_>,
    ) {
        let (n, path) = (v.len(), &cable.tendon.path);
        let (contact_work, drive_work) = (self.contact_work(), self.drive_work());
        let Strands { all, derivatives, tension, next, slip, angle } = memory;
        derivatives.resize_with(derivatives.len().max(all.len()), StrandDerivatives::default);
        tension.reset(n);
        tension.by_t = of_first.pull_rate;
        // The tensions times the second derivatives of the lengths, and the first derivatives of all strands.
        for (k, (strand, of)) in all.iter().zip(&mut *derivatives).enumerate() {
            let elements = strand.ends.map(|element| &path[element]);
            let StrandDerivatives { row, rate, angle } = of;
            for list in [&mut *row, &mut *angle, &mut *rate] {
                list.clear();
                list.resize(n, 0.0);
            }
            self.add_pair_loads(plain, strand.bodies, &strand.row, row);
            self.add_pair_loads(plain, strand.bodies, &turn_row(elements, &Self::frames(plain, strand.bodies)), angle);
            second.clear();
            let (_, mut of_second) = Sums::of(second);
            self.add_segment_derivatives((plain, motions), (elements, strand.bodies), &mut of_second);
            let near = if k == 0 { &cable.tendon.joints[..] } else { &[] };
            let far = if k + 1 == all.len() { &cable.tendon.far_joints[..] } else { &[] };
            for spool in near.iter().chain(far) {
                self.add_joint_load(plain, spool.0, spool.1, row);
                self.add_spool_derivatives((plain, motions), *spool, &mut of_second);
            }
            for (i, rate) in rate.iter_mut().enumerate() {
                *rate = row_dot(&second.a_q[i], v);
                let by_q = sums.load_q[i].iter_mut().zip(&second.a_q[i]);
                by_q.for_each(|(sum, part)| *sum -= strand.tension * part);
            }
            tension.add_tension(&of_first, row, rate);
            for j in 0..n {
                sums.g_q[drive_work][j] -= of_first.pull * rate[j];
                sums.g_v[drive_work][j] -= of_first.pull * row[j];
                sums.g_q[contact_work][j] -= of_first.elastic * rate[j];
                sums.g_v[contact_work][j] -= of_first.elastic * row[j];
            }
        }
        for j in 0..n {
            let elastic_by = |by_total: f64| by_total * elongation.rate;
            sums.g_q[contact_work][j] -= elastic_by(tension.by_q[j]);
            sums.g_v[contact_work][j] -= elastic_by(tension.by_v[j]);
        }
        sums.g_t[drive_work] -= of_first.pull_rate * elongation.rate;
        for (k, strand) in all.iter().enumerate() {
            let row = &derivatives[k].row;
            for i in (0..n).filter(|i| row[*i] != 0.0) {
                for j in 0..n {
                    sums.load_q[i][j] -= row[i] * tension.by_q[j];
                    sums.load_v[i][j] -= row[i] * tension.by_v[j];
                }
                sums.load_t[i] -= row[i] * tension.by_t;
            }
            let (Some(after), [_, index]) = (all.get(k + 1), strand.ends) else { continue };
            let element = &path[index];
            slip.reset(n);
            for StrandDerivatives { row, rate, .. } in &derivatives[k + 1..all.len()] {
                for j in 0..n {
                    slip.by_q[j] -= rate[j];
                    slip.by_v[j] -= row[j];
                }
            }
            let (radius, bodies) = (element.signed_radius_m(), [element.body, None]);
            angle.clear();
            angle.resize(n, 0.0);
            if radius != 0.0 {
                self.add_pair_loads(plain, bodies, &[0.0, 0.0, 1.0, 0.0], angle);
                // The rate of the angle, and the moment on it.
                let spin = WithDerivatives { by_v: [0.0, 0.0, 1.0, 0.0], ..WithDerivatives::default() };
                let mut moment = [WithDerivatives::default(); POSES];
                moment[2].value = radius * (after.tension - strand.tension);
                second.clear();
                let (_, mut of_second) = Sums::of(second);
                self.add_pair_derivatives((plain, motions), bodies, &moment, &[(0, spin)], None, &mut of_second);
                for j in 0..n {
                    slip.by_q[j] += radius * second.g_q[0][j];
                    slip.by_v[j] += radius * second.g_v[0][j];
                    let by_q = sums.load_q[j].iter_mut().zip(&second.a_q[j]);
                    by_q.for_each(|(sum, part)| *sum += part);
                }
            }
            next.by_q.clone_from(&tension.by_q);
            next.by_v.clone_from(&tension.by_v);
            next.by_t = tension.by_t;
            let variable = Dual::<2>::variable(strand.slip, 0);
            if let Some([mu, state_rate]) = self.friction_coefficient(v, mode, (cable, index), variable) {
                let ratio = exp(-mu.value * strand.turn);
                let bend = cable.bends(&plain.bends)[index].sign();
                let [before, behind] = [&derivatives[k].angle, &derivatives[k + 1].angle];
                let [by_slip, by_turn] = [-after.tension * strand.turn * mu.grad[0], -after.tension * mu.value];
                for j in 0..n {
                    let turn = bend * (behind[j] - before[j]);
                    next.by_q[j] = ratio * next.by_q[j] + by_slip * slip.by_q[j] + by_turn * turn;
                    next.by_v[j] = ratio * next.by_v[j] + by_slip * slip.by_v[j];
                }
                next.by_t *= ratio;
                let state = cable.frictions[index].and_then(|contact| self.contacts[contact].state);
                if let Some(state) = state {
                    next.by_v[state] -= after.tension * strand.turn * mu.grad[1];
                    for j in 0..n {
                        sums.load_q[state][j] += state_rate.grad[0] * slip.by_q[j];
                        sums.load_v[state][j] += state_rate.grad[0] * slip.by_v[j];
                    }
                    sums.load_v[state][state] += state_rate.grad[1];
                }
            }
            let change = after.tension - strand.tension;
            for j in 0..n {
                let [by_q, by_v] = [next.by_q[j] - tension.by_q[j], next.by_v[j] - tension.by_v[j]];
                for work in [contact_work, self.cable_work()] {
                    sums.g_q[work][j] += by_q * strand.slip + change * slip.by_q[j];
                    sums.g_v[work][j] += by_v * strand.slip + change * slip.by_v[j];
                }
                for i in (0..n).filter(|i| angle[*i] != 0.0) {
                    sums.load_q[i][j] += radius * angle[i] * by_q;
                    sums.load_v[i][j] += radius * angle[i] * by_v;
                }
                sums.load_t[j] += radius * angle[j] * (next.by_t - tension.by_t);
            }
            for work in [contact_work, self.cable_work()] {
                sums.g_t[work] += (next.by_t - tension.by_t) * strand.slip;
            }
            std::mem::swap(tension, next);
        }
    }

    /// Speed of a cable over a path element towards its first strand.
    pub(super) fn slip_on(&self, motions: &Motions<f64>, cable: &Cable, element: usize) -> f64 {
        let of = &cable.tendon.path[element];
        let rate_of = |ends: [usize; 2]| {
            let elements = ends.map(|element| &cable.tendon.path[element]);
            let bodies = elements.map(|element| element.body);
            row_dot(&segment_row(elements, &Self::frames(motions, bodies)), &Self::pair_rates(motions, bodies))
        };
        let behind = strands(cable.bends(&motions.bends)).filter(|[from, _]| *from >= element).map(rate_of);
        let spools = cable.tendon.far_joints.iter().map(|(joint, factor)| factor * motions.joints[*joint].rate);
        of.signed_radius_m() * motions.body(of.body).rate[2] - behind.chain(spools).sum::<f64>()
    }

    /// Adds the derivative of [`MechanismModel::slip_on`] by the rates.
    pub(super) fn add_slip_row(&self, motions: &Motions<f64>, cable: &Cable, element: usize, row: &mut [f64]) {
        let of = &cable.tendon.path[element];
        for ends in strands(cable.bends(&motions.bends)).filter(|[from, _]| *from >= element) {
            let elements = ends.map(|element| &cable.tendon.path[element]);
            let bodies = elements.map(|element| element.body);
            let by_pose = segment_row(elements, &Self::frames(motions, bodies));
            self.add_pair_loads(motions, bodies, &by_pose.map(|part| -part), row);
        }
        for &(joint, factor) in &cable.tendon.far_joints {
            self.add_joint_load(motions, joint, -factor, row);
        }
        self.add_pair_loads(motions, [of.body, None], &[0.0, 0.0, of.signed_radius_m(), 0.0], row);
    }

    /// Index of the quadrature for the work of the friction of cables, if there is any.
    pub(super) fn cable_work(&self) -> usize {
        self.contacts.len() + 2
    }

    /// Index of the quadrature for the work of the friction of cables; `None` without such friction.
    pub fn cable_quadrature(&self) -> Option<usize> {
        self.cables.iter().any(|cable| !cable.frictions.is_empty()).then(|| self.cable_work())
    }

    /// Margin of each pulley to where the cable wraps it too far, with its rate. It is not a number if the cable cannot pass
    /// its elements.
    pub(super) fn wrap_margins<'a>(&'a self, motions: &'a Motions<f64>) -> impl Iterator<Item = [f64; 2]> + 'a {
        self.cables.iter().flat_map(move |cable| {
            let (path, mut before) = (&cable.tendon.path, None);
            strands(cable.bends(&motions.bends)).filter_map(move |ends| {
                let elements = ends.map(|element| &path[element]);
                let centers = elements.map(center(motions));
                let next = segment(elements, sub(centers[1], centers[0]));
                let last: Option<(usize, Segment<f64>)> = before.replace((ends[0], next));
                if next.length.is_nan() {
                    return Some([f64::NAN, 0.0]);
                }
                let ((last, before), pulley) = (last?, elements[0]);
                if !pulley.is_pulley() {
                    return None;
                }
                let wrap = wrap(pulley, [before.direction, next.direction]);
                if wrap.is_nan() {
                    return Some([f64::NAN, 0.0]);
                }
                (wrap > 0.5 * MAX_WRAP_RAD).then(|| {
                    let turning = turning(path, motions, ends) - turning(path, motions, [last, ends[0]]);
                    [MAX_WRAP_RAD - wrap, -(pulley.side * turning)]
                })
            })
        })
    }

    /// Event function of a path element: of the lift-off from a pulley or of the return to it, or of the turn of the cable at
    /// an eyelet with friction.
    pub(super) fn path_event(&self, motions: &Motions<f64>, mode: &MechanismMode, index: usize) -> EventFunction {
        let inactive = EventFunction::INACTIVE;
        let [cable, element] = self.monitored[index];
        let (cable, tendon) = (&self.cables[cable], &self.cables[cable].tendon);
        let (path, of, bend) = (&tendon.path, &tendon.path[element], cable.bends(&mode.bends)[element]);
        let Some([before, after]) = neighbours(cable.bends(&mode.bends), element).filter(|_| mode.monitors_paths)
        else {
            return inactive;
        };
        let center = center(motions);
        let segment_of =
            |[from, to]: [usize; 2]| segment([&path[from], &path[to]], sub(center(&path[to]), center(&path[from])));
        let (value, rate) = match bend {
            Bend::Off => (
                gap(path, [before, element, after], center) + BAND * of.radius_m,
                gap_rate(path, motions, [before, element, after]),
            ),
            Bend::Left | Bend::Right => {
                let pairs = [[before, element], [element, after]];
                let [first, second] = pairs.map(|pair| segment_of(pair).direction);
                let rates = pairs.map(|pair| turning(path, motions, pair));
                (turn(of, bend, [first, second]) + BAND, bend.sign() * (rates[1] - rates[0]))
            }
        };
        EventFunction { value, rate, root_search: RootSearch::Bounded, ..inactive }
    }

    /// Tolerance of [`MechanismModel::path_event`].
    pub(super) fn path_tolerance(&self, mode: &MechanismMode, index: usize) -> f64 {
        let [cable, element] = self.monitored[index];
        let cable = &self.cables[cable];
        match cable.bends(&mode.bends)[element] {
            Bend::Off => BAND_TOLERANCE * BAND * cable.tendon.path[element].radius_m,
            Bend::Left | Bend::Right => BAND_TOLERANCE * BAND,
        }
    }

    /// Whether the gap of a pulley that is off the path has jumped: the cable has come round its back.
    fn has_jumped(&self, motions: &Motions<f64>, bends: &[Bend], [cable, element]: [usize; 2]) -> bool {
        let cable = &self.cables[cable];
        let (path, bends) = (&cable.tendon.path, cable.bends(bends));
        let places = neighbours(bends, element).filter(|_| !bends[element].is_on());
        places.is_some_and(|[before, after]| {
            gap(path, [before, element, after], center(motions)) < -JUMP * path[element].radius_m
        })
    }

    /// Changes the path after an event of a path element. Returns the index of the contact of its friction.
    pub(super) fn pass_path_event(
        &self,
        motions: &Motions<f64>,
        mode: &mut MechanismMode,
        index: usize,
    ) -> Option<usize> {
        let place = self.monitored[index];
        if self.has_jumped(motions, &mode.bends, place) {
            mode.is_blocked = true;
            return None;
        }
        let [cable, element] = place;
        let (cable, of) = (&self.cables[cable], &self.cables[cable].tendon.path[element]);
        let bend = &mut mode.bends[cable.first + element];
        *bend = match *bend {
            Bend::Off => {
                if of.side > 0.0 {
                    Bend::Left
                } else {
                    Bend::Right
                }
            }
            Bend::Left | Bend::Right if of.is_pulley() => Bend::Off,
            Bend::Left => Bend::Right,
            Bend::Right => Bend::Left,
        };
        cable.frictions.get(element).copied().flatten()
    }

    /// Finds the paths of all cables in a state, from these.
    pub(super) fn settle_paths(&self, motions: &Motions<f64>, bends: &mut [Bend]) {
        for cable in &self.cables {
            let path = &cable.tendon.path;
            settle_path(path, &mut bends[cable.first..][..path.len()], center(motions));
        }
    }

    /// Explains why a cable cannot go on, if one cannot.
    pub(super) fn describe_cable(&self, motions: &Motions<f64>) -> Option<String> {
        let jumped = |place: &&[usize; 2]| self.has_jumped(motions, &motions.bends, **place);
        let blocked = self.monitored.iter().find(jumped).copied();
        self.cables.iter().enumerate().find_map(|(index, cable)| {
            let behind = blocked.filter(|[of, _]| *of == index).map(|[_, element]| CableFault::Behind(element));
            let find = || find_fault(&cable.tendon.path, cable.bends(&motions.bends), center(motions));
            Some(self.mechanism.describe_cable(&cable.tendon, behind.or_else(find)?))
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

    /// Reads the path elements that samples report, see [`Mechanism::reported_elements`].
    ///
    /// [`Mechanism::reported_elements`]: crate::mechanism::Mechanism::reported_elements
    pub fn read_elements(
        &self,
        t: f64,
        (q, v): StateRef<'_, Dynamic>,
        mode: &MechanismMode,
        mut read: impl FnMut(usize, ElementReading),
    ) {
        let mut reported = self.mechanism.reported_elements().enumerate().peekable();
        if reported.peek().is_none() {
            return;
        }
        self.with_motions((q, v), |motions| {
            let all = &mut self.scratch.borrow_mut().strands.all;
            let (mut of, mut first) = (None, 0.0);
            for (index, [cable_index, element]) in reported {
                let cable = &self.cables[cable_index];
                let (path, rubs) = (&cable.tendon.path, !cable.frictions.is_empty());
                if of.replace(cable_index) != Some(cable_index) {
                    first = self.tension(t, mode, motions, cable).1.total();
                    if rubs {
                        self.find_strands(v, mode, motions, (cable, first), all);
                    }
                }
                let bends = cable.bends(&motions.bends);
                let is_on = bends[element].is_on();
                let Some([before, after]) = neighbours(bends, element) else { continue };
                let mut reading = ElementReading { is_on, tension: first, ..ElementReading::default() };
                if rubs {
                    let behind = all.iter().find(|strand| strand.ends[1] > element);
                    reading.tension = behind.map_or(first, |strand| strand.tension);
                }
                match all.iter().find(|strand| rubs && strand.ends[1] == element) {
                    Some(strand) => (reading.turn, reading.slip) = (strand.turn, strand.slip),
                    None if is_on => {
                        let directions = [[before, element], [element, after]].map(|ends| {
                            let ends = ends.map(|element| &path[element]);
                            let [from, to] = ends.map(center(motions));
                            segment(ends, sub(to, from)).direction
                        });
                        reading.turn = turn(&path[element], bends[element], directions);
                    }
                    None => reading.gap = gap(path, [before, element, after], center(motions)),
                }
                read(index, reading);
            }
        });
    }

    /// Adds the tensions of all strands of a cable, from the first to the last; a belt between spools has one.
    pub(super) fn strand_tensions(
        &self,
        t: f64,
        v: &[f64],
        mode: &MechanismMode,
        motions: &Motions<f64>,
        (cable, tensions): (&Cable, &mut Vec<f64>),
    ) {
        let first = self.tension(t, mode, motions, cable).1.total();
        let all = &mut self.scratch.borrow_mut().strands.all;
        self.find_strands(v, mode, motions, (cable, first), all);
        tensions.extend(all.iter().map(|strand| strand.tension));
        tensions.extend(all.is_empty().then_some(first));
    }

    /// Number of these tensions.
    pub(super) fn strand_count(&self, motions: &Motions<f64>, cable: &Cable) -> usize {
        strands(cable.bends(&motions.bends)).count().max(1)
    }

    /// Forces of a tendon with these tensions of its strands: a body, a point, a force and a moment for each end of a segment.
    pub(super) fn tendon_forces<'a>(
        &'a self,
        motions: &'a Motions<f64>,
        (cable, tensions): (&'a Cable, &'a [f64]),
    ) -> impl Iterator<Item = (Option<usize>, [f64; 2], [f64; 2], f64)> + 'a {
        segments(cable, motions).zip(tensions).enumerate().flat_map(move |(k, ((elements, bodies), tension))| {
            let centers = elements.map(center(motions));
            let u = segment(elements, sub(centers[1], centers[0])).direction;
            // The element at the end of a strand takes the moment of both tensions.
            let change = tensions.get(k + 1).map_or(0.0, |next| next - tension);
            [
                (bodies[0], centers[0], u.map(|part| tension * part), 0.0),
                (bodies[1], centers[1], u.map(|part| -tension * part), elements[1].signed_radius_m() * change),
            ]
        })
    }

    /// Contacts that are reported: all except tendons and friction of joints.
    pub(super) fn reported_contacts(&self) -> usize {
        let is_reported = |contact: &&Contact| matches!(contact.surfaces, Surfaces::Point(_) | Surfaces::Limit(_));
        self.contacts.iter().filter(is_reported).count()
    }
}

/// A number with derivatives by the slip and the internal state of friction, or without derivatives.
trait FromState {
    fn from_state(state: f64) -> Self;
}

impl FromState for f64 {
    fn from_state(state: f64) -> Self {
        state
    }
}

impl FromState for Dual<2> {
    fn from_state(state: f64) -> Self {
        Dual::variable(state, 1)
    }
}

/// Rate of the centre of a path element.
fn center_rate(motions: &Motions<f64>, element: &PathElement) -> Vector<f64> {
    motions.body(element.body).point(element.point_m).rate
}

/// Rate at which a segment turns: that of its ends across it.
fn turning(path: &[PathElement], motions: &Motions<f64>, ends: [usize; 2]) -> f64 {
    let elements = ends.map(|element| &path[element]);
    let [from, to] = elements.map(center(motions));
    let [from_rate, to_rate] = elements.map(|element| center_rate(motions, element));
    let part = segment(elements, sub(to, from));
    cross(part.direction, sub(to_rate, from_rate)) / part.length
}

/// Rate of the gap of a pulley that is off the path.
fn gap_rate(path: &[PathElement], motions: &Motions<f64>, [before, element, after]: [usize; 3]) -> f64 {
    let [first, pulley, last] = [before, element, after].map(|element| &path[element]);
    let [from, at, to] = [first, pulley, last].map(center(motions));
    let [from_rate, at_rate, to_rate] = [first, pulley, last].map(|element| center_rate(motions, element));
    let Segment { direction, length } = segment([first, last], sub(to, from));
    let (left, spin) = (perp(direction), turning(path, motions, [before, after]));
    // The point where the segment begins or ends moves along it as the segment turns.
    let distance_rate = |of: &PathElement, center: Vector<f64>, rate: Vector<f64>| {
        let radius = of.signed_radius_m();
        let offset = sub(at, sub(center, scale(left, radius)));
        let end_rate = add(rate, scale(direction, radius * spin));
        dot(offset, sub(at_rate, end_rate)) / dot(offset, offset).sqrt()
    };
    let along = dot(direction, sub(at, from));
    match along {
        _ if along < 0.0 => distance_rate(first, from, from_rate),
        _ if along > length => distance_rate(last, to, to_rate),
        _ => pulley.side * (dot(left, sub(at_rate, from_rate)) - spin * along),
    }
}
