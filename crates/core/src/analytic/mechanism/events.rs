//! Event functions of a mechanism: ends of the branches of contact laws and of the ranges of actuators, and the
//! singularities of its dyads.

use super::actuator::{Ranges, margin, margin_tolerance, range, range_after};
use super::dyad::PivotLine;
use super::model::{MechanismMode, MechanismModel, Surfaces};
use super::motion::Motions;
use super::nearest::{Feature, Frame, PointOnFace};
use crate::analytic::ContactState;
use crate::analytic::contact::{ContactVariables, Mode, StateRef, first_impact_step, row_dot};
use crate::fivebar::kinematics::SINGULAR_SINE;
use crate::integrator::{CoordinateBounds, EventFunction, EventSet, GapBounds, Hybrid, RootSearch, System};
use crate::mechanism::structure::Placement;

/// Margin below which a cable counts as lifted in the description of an obstacle, rad: the end is not located exactly.
const WRAP_ROUNDING: f64 = 1e-6;

/// What an event function belongs to, by its index.
enum EventOf {
    Contact(usize),
    Actuator(usize),
    Features,
}

impl EventOf {
    /// The subject of an event function of `C` contacts and `count` functions in all.
    fn index<const C: usize>(event: usize, count: usize) -> Self {
        match event {
            _ if event + 1 == count => Self::Features,
            _ if event < 3 * C => Self::Contact(event % C),
            _ => Self::Actuator(event - 3 * C),
        }
    }
}

/// Largest change of depth and slip of a contact between driven bodies in one step, as a fraction of the length and speed
/// scales of its law.
const DRIVEN_FRACTION: f64 = 0.05;
/// Longest step during such a contact, s.
const MAX_DRIVEN_STEP_S: f64 = 1.0;
/// The region of a feature ends this far beyond its nominal end, m, so that neighbouring regions do not alternate.
const FEATURE_MARGIN_M: f64 = 1e-12;
/// Tolerance of locating that end, m.
const FEATURE_TOLERANCE_M: f64 = 3e-13;

impl<const N: usize, const K: usize, const C: usize> MechanismModel<N, K, C> {
    /// Number of event functions: those of normal laws, friction laws and dampers of all contacts, then of actuators, then one
    /// for the features of all faces.
    fn event_function_count(&self) -> usize {
        3 * C + self.mechanism.actuators.len() + 1
    }

    /// What an event function belongs to.
    fn subject_of(&self, event: usize) -> EventOf {
        EventOf::index::<C>(event, self.event_function_count())
    }

    /// State of a contact, with its laws; `None` beyond the last contact. The rows are 0 unless `with_rows`.
    fn contact_variables(
        &self,
        motions: &Motions<f64, K>,
        v: &[f64; N],
        index: usize,
        feature: Option<Feature>,
        with_rows: bool,
    ) -> Option<ContactVariables<'_, N>> {
        let contact = self.contacts.get(index)?;
        let mut rows = [[0.0; N]; 2];
        let [delta, rate, slip] = match &contact.surfaces {
            Surfaces::Point(pair) => {
                let (kinematics, rates) = self.point_kinematics(motions, pair, feature);
                let of_poses = [kinematics.normal_row, kinematics.tangent_row];
                if with_rows {
                    (0..2).for_each(|k| self.add_pair_loads(motions, pair.bodies, &of_poses[k], &mut rows[k]));
                }
                [-kinematics.gap, -row_dot(&of_poses[0], &rates), row_dot(&of_poses[1], &rates)]
            }
            Surfaces::Limit(limit) => {
                let (span, motion) = (self.span_of_joint(limit.joint), &motions.joints[limit.joint]);
                (0..span.size).for_each(|i| rows[0][span.first + i] = -limit.side * motion.row[i]);
                let coordinate = self.joint_coordinate(motions, limit.joint);
                [limit.side * (coordinate - limit.value), limit.side * motion.rate, 0.0]
            }
            Surfaces::Friction(joint) => {
                let (span, motion) = (self.span_of_joint(*joint), &motions.joints[*joint]);
                (0..span.size).for_each(|i| rows[1][span.first + i] = motion.row[i]);
                [1.0, 0.0, motion.rate]
            }
            Surfaces::Tendon(index) => {
                let elongation = self.elongation(motions, &self.cables[*index].tendon, v);
                rows[0] = elongation.row.map(|part| -part);
                [elongation.value, elongation.rate, 0.0]
            }
        };
        let [normal_row, mut tangent_row] = rows;
        let bristle_state = contact.bristle.map_or(0.0, |bristle| {
            tangent_row[bristle] = 1.0;
            v[bristle]
        });
        Some(ContactVariables {
            law: &contact.normal,
            friction: contact.friction.as_ref(),
            delta,
            rate,
            slip,
            bristle_state,
            normal_row,
            tangent_row,
        })
    }

    fn variables_at(
        &self,
        (q, v): StateRef<'_, N>,
        index: usize,
        feature: Option<Feature>,
    ) -> Option<ContactVariables<'_, N>> {
        self.with_motions((q, v), |motions| self.contact_variables(motions, v, index, feature, true))
    }

    /// Contacts on a feature of a face, with the frames of their bodies.
    fn contacts_on_features<'a>(
        &'a self,
        motions: &'a Motions<f64, K>,
        mode: &'a MechanismMode<C>,
    ) -> impl Iterator<Item = (usize, &'a PointOnFace, [Frame<f64>; 2], Feature)> {
        self.contacts.iter().enumerate().filter_map(|(index, contact)| match &contact.surfaces {
            Surfaces::Point(pair) => {
                mode.features[index].map(|feature| (index, pair, Self::frames(motions, pair.bodies), feature))
            }
            Surfaces::Limit(_) | Surfaces::Tendon(_) | Surfaces::Friction(_) => None,
        })
    }

    /// Event function of the features: of the contact that is nearest to the end of its region.
    fn feature_event(&self, motions: &Motions<f64, K>, mode: &MechanismMode<C>) -> EventFunction {
        let margins = self.contacts_on_features(motions, mode).map(|(_, pair, frames, on)| pair.margin(&frames, on));
        // A step that leaves a region and returns to it has a small error only: forces are continuous at its end.
        EventFunction { value: margins.fold(f64::INFINITY, f64::min) + FEATURE_MARGIN_M, ..EventFunction::INACTIVE }
    }

    /// The feature on which a contact starts in a mode; `None` without a force.
    fn starting_feature(&self, state: StateRef<'_, N>, contacts: &Mode<C>, index: usize) -> Option<Feature> {
        match &self.contacts[index].surfaces {
            Surfaces::Point(pair) if contacts[index].has_force() => {
                Some(self.with_motions(state, |motions| pair.nearest(&Self::frames(motions, pair.bodies)).0))
            }
            _ => None,
        }
    }

    /// Time, coordinate and rate at an actuator.
    fn actuator_state(
        &self,
        motions: &Motions<f64, K>,
        q: &[f64; N],
        mode: &MechanismMode<C>,
        index: usize,
    ) -> (f64, f64, f64) {
        let (motion, [first_s, last_s]) = (motions.combination(&self.mechanism.actuators[index].on), mode.times_s);
        (self.time_index.map_or(0.0, |time| q[time].clamp(first_s, last_s)), motion.coordinate, motion.rate)
    }

    /// Ranges of all actuators in a state.
    pub(super) fn ranges(&self, t: f64, (q, v): StateRef<'_, N>) -> Ranges {
        let mut ranges = Ranges::UNMONITORED;
        self.with_motions((q, v), |motions| {
            for (index, actuator) in self.mechanism.actuators.iter().enumerate() {
                let motion = motions.combination(&actuator.on);
                ranges.0[index] = range(actuator, t, motion.coordinate, motion.rate);
            }
        });
        ranges
    }

    /// Event function of the range of an actuator.
    fn actuator_event(
        &self,
        motions: &Motions<f64, K>,
        q: &[f64; N],
        mode: &MechanismMode<C>,
        index: usize,
    ) -> EventFunction {
        let Some(actuator) = self.mechanism.actuators.get(index) else { return EventFunction::INACTIVE };
        let (t, coordinate, rate) = self.actuator_state(motions, q, mode, index);
        let value = margin(actuator, mode.ranges.0[index], t, coordinate, rate);
        EventFunction { value, root_search: RootSearch::Smooth, ..EventFunction::INACTIVE }
    }

    /// The lines between pivots of dyads whose turns are counted, with the offset of the pivots and its rate.
    fn pivot_lines<'a>(
        &'a self,
        motions: &'a Motions<f64, K>,
    ) -> impl Iterator<Item = (&'a PivotLine, ([f64; 2], [f64; 2]))> + 'a {
        self.groups.iter().flat_map(move |group| group.pivot_lines(&self.mechanism, motions))
    }

    /// The mode of a state, with the turns that are counted in evaluations.
    fn mode_with_counts<const Z: usize>(&self, t: f64, (q, v): StateRef<'_, N>, counts: [i32; C]) -> MechanismMode<C> {
        let (ranges, times_s) = (self.ranges(t, (q, v)), self.times_around(t));
        let accelerations = |mode: &Mode<C>| {
            let mode = MechanismMode { contacts: *mode, features: [None; C], ranges, counts, times_s };
            <Self as System<N, Z>>::rates(self, t, q, v, &mode).a
        };
        let variables = |index| self.variables_at((q, v), index, None);
        let contacts = Mode::at_state(&self.event_tolerances, variables, accelerations);
        let mut features = [None; C];
        for (index, feature) in features.iter_mut().enumerate().take(self.contacts.len()) {
            *feature = self.starting_feature((q, v), &contacts, index);
        }
        MechanismMode { contacts, features, ranges, counts, times_s }
    }

    /// Distance of the mechanism from its nearest singular configuration, and its rate.
    fn clearance_and_rate(&self, motions: &Motions<f64, K>) -> (f64, f64) {
        let mut smallest = (f64::INFINITY, 0.0);
        for (_, transmission) in self.groups.iter().flat_map(|group| group.transmissions(&self.mechanism, motions)) {
            let clearance = transmission.sine.abs() - SINGULAR_SINE;
            // NaN counts as the smallest clearance.
            if smallest.0 > clearance || clearance.is_nan() {
                let rate = transmission.sine.signum() * transmission.cosine * transmission.angle_rate;
                smallest = (clearance, rate);
            }
        }
        for (_, _, [margin, rate]) in self.wrap_margins(motions) {
            if smallest.0 > margin || margin.is_nan() {
                smallest = (margin, rate);
            }
        }
        smallest
    }
}

impl<const N: usize, const K: usize, const C: usize, const Z: usize> Hybrid<N, Z> for MechanismModel<N, K, C> {
    fn event_count(&self) -> usize {
        self.event_function_count()
    }

    fn next_discontinuity(&self, t: f64) -> f64 {
        self.next_time_discontinuity(t)
    }

    /// The force of a contact between bodies with prescribed motion changes no coordinate, so that the error of a step does
    /// not contain it. Turns of dyads are counted from step to step.
    fn max_step(&self, _t: f64, q: &[f64; N], v: &[f64; N], mode: &MechanismMode<C>) -> f64 {
        self.count_turns_as(mode);
        let mut max_dt = self.with_motions((q, v), |motions| {
            self.pivot_lines(motions)
                .fold(f64::INFINITY, |max_dt, (_, (offset, rate))| max_dt.min(PivotLine::max_step(offset, rate)))
        });
        let Some(time) = self.time_index else { return max_dt };
        for (index, contact) in self.contacts.iter().enumerate() {
            let Surfaces::Point(pair) = &contact.surfaces else { continue };
            if mode[index] != ContactState::Active || !pair.bodies.iter().all(|body| self.mechanism.is_base(*body)) {
                continue;
            }
            let after = |dt: f64| {
                let mut q = *q;
                q[time] += dt;
                self.variables_at((&q, v), index, mode.features[index])
            };
            let Some(contact) = after(0.0) else { continue };
            let depth = contact.delta.max(contact.law.depth_scale_m());
            let mut dt = MAX_DRIVEN_STEP_S.min(DRIVEN_FRACTION * depth / contact.rate.abs());
            let max_change = contact.friction.map_or(f64::INFINITY, |law| DRIVEN_FRACTION * law.v_static_m_s);
            while after(dt).is_some_and(|later| (later.slip - contact.slip).abs() > max_change) {
                dt *= 0.5;
            }
            max_dt = max_dt.min(dt);
        }
        max_dt
    }

    fn is_mode_valid(&self, dt: f64, q: &[f64; N], v: &[f64; N], mode: &MechanismMode<C>) -> bool {
        self.count_turns_as(mode);
        self.with_motions((q, v), |motions| {
            self.pivot_lines(motions).all(|(line, motion)| line.is_valid(dt, &mode.counts, motion))
        })
    }

    fn continued_mode(&self, q: &[f64; N], v: &[f64; N], mode: &MechanismMode<C>) -> Option<MechanismMode<C>> {
        self.count_turns_as(mode);
        let mut next = None;
        self.with_motions((q, v), |motions| {
            for (line, (offset, _)) in self.pivot_lines(motions) {
                if let Some(count) = line.recounted(&mode.counts, offset) {
                    next.get_or_insert(*mode).counts[line.count] = count;
                }
            }
        });
        next
    }

    fn eval_events(&self, q: &[f64; N], v: &[f64; N], mode: &MechanismMode<C>, events: &mut EventSet<N>) {
        self.count_turns_as(mode);
        self.with_motions((q, v), |motions| {
            let variables =
                |index: usize| self.contact_variables(motions, v, index, mode.features[index], mode[index].has_force());
            mode.contacts.eval_events(self.contacts.len(), &self.event_tolerances, variables, events);
            for index in 0..self.mechanism.actuators.len() {
                events.functions[3 * C + index] = self.actuator_event(motions, q, mode, index);
            }
            events.functions[self.event_function_count() - 1] = self.feature_event(motions, mode);
            (events.clearance, events.clearance_rate) = self.clearance_and_rate(motions);
        });
    }

    fn clearance(&self, q: &[f64; N], v: &[f64; N], mode: &MechanismMode<C>) -> f64 {
        self.count_turns_as(mode);
        self.with_motions((q, v), |motions| self.clearance_and_rate(motions).0)
    }

    fn eval_event(&self, q: &[f64; N], v: &[f64; N], mode: &MechanismMode<C>, event: usize) -> EventFunction {
        self.count_turns_as(mode);
        self.with_motions((q, v), |motions| match self.subject_of(event) {
            EventOf::Features => self.feature_event(motions, mode),
            EventOf::Actuator(index) => self.actuator_event(motions, q, mode, index),
            EventOf::Contact(index) => {
                let contact = self.contact_variables(motions, v, index, mode.features[index], false);
                mode.contacts.event_function(event, &self.event_tolerances, contact)
            }
        })
    }

    fn event_values(
        &self,
        q: &[f64; N],
        v: &[f64; N],
        mode: &MechanismMode<C>,
        requested: &[bool],
        values: &mut [f64],
    ) {
        self.count_turns_as(mode);
        self.with_motions((q, v), |motions| {
            for index in 0..self.contacts.len() {
                let events = [index, index + C, index + 2 * C];
                if events.iter().any(|event| requested[*event]) {
                    let contact = self.contact_variables(motions, v, index, mode.features[index], false);
                    let value = |event| mode.contacts.event_function(event, &self.event_tolerances, contact).value;
                    events.into_iter().for_each(|event| values[event] = value(event));
                }
            }
            for index in 0..self.mechanism.actuators.len() {
                values[3 * C + index] = self.actuator_event(motions, q, mode, index).value;
            }
            values[self.event_function_count() - 1] = self.feature_event(motions, mode).value;
        });
    }

    fn gap_bounds(&self, motion: &CoordinateBounds<N>, (q, v): StateRef<'_, N>, clearance: f64, found: &mut GapBounds) {
        self.with_bounds((q, v), |motions, bounds| self.bound_gaps(motion, (q, motions, clearance), bounds, found));
    }

    fn event_tolerance(&self, event: usize, mode: &MechanismMode<C>) -> f64 {
        match self.subject_of(event) {
            EventOf::Features => FEATURE_TOLERANCE_M,
            EventOf::Actuator(index) => self.mechanism.actuators.get(index).map_or(0.0, margin_tolerance),
            EventOf::Contact(index) => self.contacts.get(index).map_or(0.0, |contact| {
                let (normal, friction) = (&contact.normal, contact.friction.as_ref());
                mode.contacts.event_tolerance(event, normal, friction, &self.event_tolerances)
            }),
        }
    }

    fn mode_after_event(&self, event: usize, q: &[f64; N], v: &[f64; N], mode: &MechanismMode<C>) -> MechanismMode<C> {
        self.count_turns_as(mode);
        let mut next = *mode;
        match self.subject_of(event) {
            EventOf::Features => self.with_motions((q, v), |motions| {
                for (index, pair, frames, feature) in self.contacts_on_features(motions, mode) {
                    if pair.margin(&frames, feature) < 0.0 {
                        next.features[index] = Some(pair.feature_beyond(&frames, feature));
                    }
                }
            }),
            EventOf::Actuator(index) => {
                let (t, coordinate, rate) =
                    self.with_motions((q, v), |motions| self.actuator_state(motions, q, mode, index));
                let range = &mut next.ranges.0[index];
                *range = range_after(&self.mechanism.actuators[index], *range, t, coordinate, rate);
            }
            EventOf::Contact(index) => {
                let variables = self.variables_at((q, v), index, mode.features[index]);
                next.contacts = mode.contacts.after_event(event, variables);
                if next.contacts[index] != mode.contacts[index] {
                    next.features[index] = self.starting_feature((q, v), &next.contacts, index);
                }
            }
        }
        next
    }

    fn is_reported(&self, event: usize) -> bool {
        event < self.reported_contacts()
    }

    fn mode_after_step(&self, functions: &[EventFunction], mode: &MechanismMode<C>) -> Option<MechanismMode<C>> {
        mode.contacts.with_separated_contacts(functions).map(|contacts| MechanismMode { contacts, ..*mode })
    }

    fn with_clamped_law(&self, event: usize, mode: &MechanismMode<C>) -> MechanismMode<C> {
        let mut next = *mode;
        match self.subject_of(event) {
            EventOf::Features => next.features = [None; C],
            EventOf::Actuator(index) => next.ranges.0[index] = super::actuator::UNMONITORED,
            EventOf::Contact(_) => next.contacts = mode.contacts.with_clamped_law(event),
        }
        next
    }

    fn mode_at(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> MechanismMode<C> {
        self.count_turns_in(&[0; C]);
        self.mode_with_counts::<Z>(t, (q, v), [0; C])
    }

    fn mode_after(&self, t: f64, q: &[f64; N], v: &[f64; N], last: &MechanismMode<C>) -> MechanismMode<C> {
        self.count_turns_as(last);
        self.mode_with_counts::<Z>(t, (q, v), last.counts)
    }

    /// Chooses anew the ranges of the actuators whose commands are discontinuous; the laws of contacts depend on positions
    /// and rates, which are continuous.
    fn mode_after_discontinuity(
        &self,
        t: f64,
        q: &[f64; N],
        v: &[f64; N],
        mode: &MechanismMode<C>,
    ) -> MechanismMode<C> {
        self.count_turns_as(mode);
        let mut next = MechanismMode { times_s: self.times_around(t), ..*mode };
        let ranges = self.ranges(t, (q, v));
        for (index, actuator) in self.mechanism.actuators.iter().enumerate() {
            if actuator.command.profile().next_discontinuity(mode.times_s[1]) <= t {
                next.ranges.0[index] = ranges.0[index];
            }
        }
        next
    }

    fn restart_step(&self, event: usize, q: &[f64; N], v: &[f64; N], mode: &MechanismMode<C>) -> Option<f64> {
        if event >= 3 * C || mode[event % C] != ContactState::Active {
            return None;
        }
        let ContactVariables { law, rate, normal_row, .. } =
            self.variables_at((q, v), event % C, mode.features[event % C])?;
        let mut response = normal_row;
        self.with_factors((q, v), |_, factors| self.solve(factors, &mut response));
        let mobility = row_dot(&normal_row, &response);
        (mobility > 0.0).then(|| first_impact_step(law, rate.abs(), 1.0 / mobility))
    }

    fn describe_obstacle(&self, q: &[f64; N]) -> String {
        let at_rest = [0.0; N];
        self.with_motions((q, &at_rest), |motions| {
            let dyads = self.groups.iter().flat_map(|group| {
                group.transmissions(&self.mechanism, motions).map(move |dyad| (&group.group.placements[dyad.0], dyad.1))
            });
            let sine = |sine: f64| if sine.is_nan() { -1.0 } else { sine.abs() };
            let beyond =
                self.wrap_margins(motions).find(|(_, _, [margin, _])| margin.is_nan() || *margin < WRAP_ROUNDING);
            if let Some((tendon, element, _)) = beyond {
                return self.mechanism.describe_lifted(&self.cables[tendon].tendon, element);
            }
            match dyads.min_by(|a, b| sine(a.1.sine).total_cmp(&sine(b.1.sine))) {
                Some((Placement::Dyad { outer, inner }, _)) => {
                    self.describe_singularity(motions, [outer[0].joint, *inner, outer[1].joint])
                }
                _ => "the nearest points of two outlines are not defined".to_string(),
            }
        })
    }
}
