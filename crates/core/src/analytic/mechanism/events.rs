//! Event functions of a mechanism: ends of the branches of contact laws and of the ranges of actuators, and the
//! singularities of its dyads.

use super::actuator::{Ranges, command, margin, margin_tolerance, range, range_after};
use super::assur::Assur;
use super::cable::Cable;
use super::contacts::Surfaces;
use super::dyad::PivotLine;
use super::model::{MechanismMode, MechanismModel, Scratch};
use super::motion::Motions;
use super::nearest::{Feature, Frame, POSES, PointOnFace};
use crate::analytic::ContactState;
use crate::analytic::contact::{ContactMode, ContactVariables, Mode, Row, StateRef, first_impact_step, row_dot};
use crate::fivebar::kinematics::SINGULAR_SINE;
use crate::integrator::{
    CoordinateBounds, Dynamic, EventFunction, EventSet, GapBounds, Hybrid, QuasiStaticState, Rates, RootSearch, System,
    Tolerances,
};
use crate::mechanism::structure::Placement;
use crate::mechanism::tendon::Bend;
use crate::mechanism::{Actuator, Limit};

/// Margin below which points count as met in the description of an obstacle, m: the end is not located exactly.
const MET_ROUNDING_M: f64 = 1e-8;

/// What an event function belongs to, by its index.
enum EventOf {
    Contact(usize),
    Actuator(usize),
    /// A path element of a cable, by its index among those that are monitored.
    Path(usize),
    Features,
}

impl EventOf {
    /// The subject of an event function of these contacts and ranges of actuators and `count` functions in all.
    fn index(event: usize, [contacts, ranges]: [usize; 2], count: usize) -> Self {
        match event {
            _ if event + 1 == count => Self::Features,
            _ if event < 3 * contacts => Self::Contact(event % contacts),
            _ if event < 3 * contacts + ranges => Self::Actuator(event - 3 * contacts),
            _ => Self::Path(event - 3 * contacts - ranges),
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

/// Mode of the friction of a cable on an element that it is off: without events.
const OFF: ContactMode = ContactMode { state: ContactState::Active, ..ContactMode::FREE };

/// Derivatives of the gap or the slip of a contact.
enum ContactRow<'a> {
    /// A row over the relative pose of two bodies, and the index of an internal state of friction that is added to the slip.
    Pair {
        bodies: [Option<usize>; 2],
        row: [f64; POSES],
        state: Option<usize>,
    },
    /// The coordinate of a limit times its side.
    Limit(&'a Limit),
    /// A multiple of the coordinate of a joint, and the index of an internal state of friction.
    Joint {
        joint: usize,
        factor: f64,
        state: Option<usize>,
    },
    /// The length of a cable.
    Cable(&'a Cable),
    /// The speed of a cable over a path element, and the index of an internal state of friction.
    Slip {
        cable: &'a Cable,
        element: usize,
        state: Option<usize>,
    },
    Zero,
}

/// A row in a state.
pub(super) struct RowAt<'a> {
    model: &'a MechanismModel,
    motions: &'a Motions<f64>,
    row: ContactRow<'a>,
}

impl Row for RowAt<'_> {
    fn write(&self, row: &mut [f64]) {
        let Self { model, motions, row: of } = self;
        row.fill(0.0);
        let state = match of {
            ContactRow::Pair { bodies, row: over_poses, state } => {
                model.add_pair_loads(motions, *bodies, over_poses, row);
                *state
            }
            ContactRow::Limit(limit) => {
                model.add_limit_load(motions, limit, -limit.side, row);
                None
            }
            ContactRow::Joint { joint, factor, state } => {
                model.add_joint_load(motions, *joint, *factor, row);
                *state
            }
            ContactRow::Cable(cable) => {
                model.add_length_row(motions, cable, row);
                row.iter_mut().for_each(|part| *part = -*part);
                None
            }
            ContactRow::Slip { cable, element, state } => {
                model.add_slip_row(motions, cable, *element, row);
                *state
            }
            ContactRow::Zero => None,
        };
        state.into_iter().for_each(|state| row[state] = 1.0);
    }
}

/// A row that is evaluated.
impl Row for Vec<f64> {
    fn write(&self, row: &mut [f64]) {
        row.copy_from_slice(self);
    }
}

impl MechanismModel {
    /// Number of event functions: those of normal laws, friction laws and dampers of all contacts, then of the ranges of
    /// actuators, of the path elements of cables, and one for the features of all faces.
    fn event_function_count(&self) -> usize {
        3 * self.contacts.len() + self.range_count + self.monitored.len() + 1
    }

    /// Index of the first event function of a path element.
    pub(super) fn first_path_event(&self) -> usize {
        3 * self.contacts.len() + self.range_count
    }

    /// What an event function belongs to.
    fn subject_of(&self, event: usize) -> EventOf {
        let before = [self.contacts.len(), self.range_count];
        EventOf::index(event, before, self.event_function_count())
    }

    /// State of a contact, with its laws.
    #[inline(always)]
    pub(super) fn contact_variables<'a>(
        &'a self,
        motions: &'a Motions<f64>,
        v: &[f64],
        index: usize,
        feature: Option<Feature>,
    ) -> ContactVariables<'a, RowAt<'a>> {
        let contact = &self.contacts[index];
        let state = contact.state;
        let ([delta, rate, slip], normal_row, tangent_row) = match &contact.surfaces {
            Surfaces::Point(pair) => {
                let (kinematics, rates) = self.point_kinematics(motions, pair, feature);
                let row = |row: [f64; POSES], state| ContactRow::Pair { bodies: pair.bodies, row, state };
                (
                    [
                        -kinematics.gap,
                        -row_dot(&kinematics.normal_row, &rates),
                        row_dot(&kinematics.tangent_row, &rates),
                    ],
                    row(kinematics.normal_row, None),
                    row(kinematics.tangent_row, state),
                )
            }
            Surfaces::Limit(limit) => {
                let ([coordinate, rate], side) = (self.limited(motions, limit), limit.side);
                ([side * (coordinate - limit.value), side * rate, 0.0], ContactRow::Limit(limit), ContactRow::Zero)
            }
            Surfaces::Friction(joint) => (
                [1.0, 0.0, motions.joints[*joint].rate],
                ContactRow::Zero,
                ContactRow::Joint { joint: *joint, factor: 1.0, state },
            ),
            Surfaces::Cable(cable, element) => {
                let (cable, element) = (&self.cables[*cable], *element);
                let slip = self.slip_on(motions, cable, element);
                ([1.0, 0.0, slip], ContactRow::Zero, ContactRow::Slip { cable, element, state })
            }
            Surfaces::Tendon(index) => {
                let cable = &self.cables[*index];
                let elongation = self.elongation(motions, cable);
                ([elongation.value, elongation.rate, 0.0], ContactRow::Cable(cable), ContactRow::Zero)
            }
        };
        let row = |row: ContactRow<'a>| RowAt { model: self, motions, row };
        ContactVariables {
            law: &contact.normal,
            friction: contact.friction.as_ref(),
            delta,
            rate,
            slip,
            friction_state: state.map_or(0.0, |state| v[state]),
            normal_row: row(normal_row),
            tangent_row: row(tangent_row),
        }
    }

    /// Evaluates a function of the motions on which a contact depends.
    #[inline(always)]
    pub(super) fn with_contact<R>(
        &self,
        state: StateRef<'_, Dynamic>,
        index: usize,
        f: impl FnOnce(&Motions<f64>) -> R,
    ) -> R {
        let of_joint = |joint: usize| self.mechanism.joints[joint].bodies;
        match &self.contacts[index].surfaces {
            Surfaces::Point(pair) => self.with_bodies(state, pair.bodies, f),
            Surfaces::Limit(limit) => {
                let terms = self.mechanism.limited_terms(limit);
                self.with_bodies(state, terms.flat_map(|(joint, _)| of_joint(joint)), f)
            }
            Surfaces::Friction(joint) => self.with_bodies(state, of_joint(*joint), f),
            Surfaces::Tendon(index) | Surfaces::Cable(index, _) => {
                let elements = self.cables[*index].tendon.path.iter().map(|element| element.body);
                let spools = self.cables[*index].tendon.spools().flat_map(|(joint, _)| of_joint(*joint));
                self.with_bodies(state, elements.chain(spools), f)
            }
        }
    }

    /// State of a contact on its nearest feature, with evaluated rows.
    fn variables_at(&self, (q, v): StateRef<'_, Dynamic>, index: usize) -> ContactVariables<'_, Vec<f64>> {
        self.with_columns((q, v), |motions| {
            let ContactVariables { delta, rate, slip, friction_state, normal_row, tangent_row, .. } =
                self.contact_variables(motions, v, index, None);
            let evaluated = |row: RowAt<'_>| {
                let mut evaluated = vec![0.0; v.len()];
                row.write(&mut evaluated);
                evaluated
            };
            let contact = &self.contacts[index];
            ContactVariables {
                law: &contact.normal,
                friction: contact.friction.as_ref(),
                delta,
                rate,
                slip,
                friction_state,
                normal_row: evaluated(normal_row),
                tangent_row: evaluated(tangent_row),
            }
        })
    }

    /// A contact on a feature of a face, with the frames of its bodies.
    #[inline(always)]
    fn contact_on_feature<'a>(
        &'a self,
        motions: &Motions<f64>,
        mode: &MechanismMode,
        index: usize,
    ) -> Option<(&'a PointOnFace, [Frame<f64>; 2], Feature)> {
        let Surfaces::Point(pair) = &self.contacts[index].surfaces else { return None };
        Some((pair, Self::frames(motions, pair.bodies), mode.features[index]?))
    }

    /// Event function of the features: of the contact that is nearest to the end of its region.
    fn feature_event(&self, motions: &Motions<f64>, mode: &MechanismMode) -> EventFunction {
        let on_features = (0..self.contacts.len()).filter_map(|index| self.contact_on_feature(motions, mode, index));
        let margins = on_features.map(|(pair, frames, on)| pair.margin(&frames, on));
        // A step that leaves a region and returns to it has a small error only: forces are continuous at its end.
        EventFunction { value: margins.fold(f64::INFINITY, f64::min) + FEATURE_MARGIN_M, ..EventFunction::INACTIVE }
    }

    /// The feature on which a contact starts in a mode; `None` without a force.
    fn starting_feature(
        &self,
        state: StateRef<'_, Dynamic>,
        contacts: &Mode<Vec<ContactMode>>,
        index: usize,
    ) -> Option<Feature> {
        match &self.contacts[index].surfaces {
            Surfaces::Point(pair) if contacts[index].has_force() => {
                Some(self.with_motions(state, |motions| pair.nearest(&Self::frames(motions, pair.bodies)).0))
            }
            _ => None,
        }
    }

    /// Command of an actuator.
    fn command_in(
        &self,
        motions: &Motions<f64>,
        state: StateRef<'_, Dynamic>,
        mode: &MechanismMode,
        index: usize,
    ) -> f64 {
        let (actuator, t) = (&self.mechanism.actuators[index], self.time_in(state));
        if !actuator.powertrain.is_direct() {
            return self.drive_command(index, (t, state.1), motions, mode).unwrap_or_default();
        }
        let (motion, [first_s, last_s]) = (motions.combination(&actuator.on), mode.times_s);
        command(actuator, t.clamp(first_s, last_s), motion.coordinate, motion.rate).value
    }

    /// Ranges of all actuators in a state.
    pub(super) fn ranges(&self, t: f64, (q, v): StateRef<'_, Dynamic>) -> Ranges {
        self.with_motions((q, v), |motions| {
            let of_actuator = |actuator: &Actuator| {
                let motion = motions.combination(&actuator.on);
                range(actuator, t, motion.coordinate, motion.rate)
            };
            let mut ranges: Vec<u8> = self.mechanism.actuators.iter().map(of_actuator).collect();
            ranges.resize(self.range_count, 0);
            self.set_drive_ranges((t, v), motions, |_| true, &mut ranges);
            Ranges(ranges)
        })
    }

    /// Event function of a range of an actuator.
    fn actuator_event(
        &self,
        motions: &Motions<f64>,
        state: StateRef<'_, Dynamic>,
        mode: &MechanismMode,
        index: usize,
    ) -> EventFunction {
        let Some(actuator) = self.mechanism.actuators.get(index) else {
            return self.drive_event(index, (self.time_in(state), state.1), motions, mode);
        };
        let value = margin(actuator, mode.ranges.0[index], || self.command_in(motions, state, mode, index));
        EventFunction { value, root_search: RootSearch::Smooth, ..EventFunction::INACTIVE }
    }

    /// The lines between pivots of dyads whose turns are counted, with the offset of the pivots and its rate.
    fn pivot_lines<'a>(
        &'a self,
        motions: &'a Motions<f64>,
    ) -> impl Iterator<Item = (&'a PivotLine, ([f64; 2], [f64; 2]))> + 'a {
        self.groups.iter().flat_map(move |group| group.pivot_lines(&self.mechanism, motions))
    }

    /// The Assur groups beyond dyads, in this mode.
    fn assurs(&self, mode: &MechanismMode) -> impl Iterator<Item = Assur<'_>> + '_ {
        let groups = if mode.near.is_empty() { &[] } else { &self.groups[..] };
        groups.iter().flat_map(move |group| group.assurs(&self.mechanism))
    }

    /// The mode of a state, with the turns that are counted in evaluations.
    fn mode_with_counts(
        &self,
        t: f64,
        (q, v): StateRef<'_, Dynamic>,
        (counts, near): (Vec<i32>, Vec<f64>),
        mut bends: Vec<Bend>,
    ) -> MechanismMode {
        if !bends.is_empty() {
            self.with_motions((q, v), |motions| self.settle_paths(motions, &mut bends));
            self.pass_paths_as(&bends);
        }
        let (ranges, times_s, count) = (self.ranges(t, (q, v)), self.times_around(t), self.contacts.len());
        let free = Mode::free(count);
        let mut mode = MechanismMode {
            contacts: free.clone(),
            features: vec![None; count],
            ranges,
            counts,
            near,
            bends,
            monitors_paths: true,
            is_blocked: false,
            times_s,
        };
        let variables = |index| Some(self.variables_at((q, v), index));
        let mut contacts = free.at_state(&self.event_tolerances, variables, |contacts| {
            mode.contacts.clone_from(contacts);
            let mut rates = Rates::zero(self.sizes());
            self.rates(t, q, v, &mode, &mut rates);
            rates.a
        });
        for (index, feature) in mode.features.iter_mut().enumerate() {
            *feature = self.starting_feature((q, v), &contacts, index);
        }
        for &[cable, element] in &self.monitored {
            let contact = self.cables[cable].frictions.get(element).copied().flatten();
            if let Some(contact) = contact.filter(|_| !self.cables[cable].bends(&mode.bends)[element].is_on()) {
                contacts.contacts[contact] = OFF;
            }
        }
        MechanismMode { contacts, ..mode }
    }

    /// Distance of the mechanism from its nearest singular configuration, and its rate.
    fn clearance_and_rate(&self, motions: &Motions<f64>, mode: &MechanismMode) -> (f64, f64) {
        if mode.is_blocked {
            return (-1.0, 0.0);
        }
        let mut smallest = (f64::INFINITY, 0.0);
        for (_, transmission) in self.groups.iter().flat_map(|group| group.transmissions(&self.mechanism, motions)) {
            let clearance = transmission.sine.abs() - SINGULAR_SINE;
            // NaN counts as the smallest clearance.
            if smallest.0 > clearance || clearance.is_nan() {
                let rate = transmission.sine.signum() * transmission.cosine * transmission.angle_rate;
                smallest = (clearance, rate);
            }
        }
        let of_distances = self.distance_margins(motions).map(|(_, margin)| margin);
        for [margin, rate] in self.wrap_margins(motions).chain(of_distances) {
            if smallest.0 > margin || margin.is_nan() {
                smallest = (margin, rate);
            }
        }
        smallest
    }
}

impl Hybrid for MechanismModel {
    fn event_count(&self) -> usize {
        self.event_function_count()
    }

    fn next_discontinuity(&self, t: f64) -> f64 {
        self.next_time_discontinuity(t)
    }

    /// The force of a contact between bodies with prescribed motion changes no coordinate, so that the error of a step does
    /// not contain it. Turns of dyads are counted from step to step.
    fn max_step(&self, _t: f64, q: &Vec<f64>, v: &Vec<f64>, mode: &MechanismMode) -> f64 {
        self.count_turns_as(mode);
        let mut max_dt = self.with_motions((q, v), |motions| {
            let of_lines = self
                .pivot_lines(motions)
                .fold(f64::INFINITY, |max_dt, (_, (offset, rate))| max_dt.min(PivotLine::max_step(offset, rate)));
            self.assurs(mode).fold(of_lines, |max_dt, assur| max_dt.min(assur.max_step(motions)))
        });
        let Some(time) = self.time_index else { return max_dt };
        for (index, contact) in self.contacts.iter().enumerate() {
            let Surfaces::Point(pair) = &contact.surfaces else { continue };
            if mode[index] != ContactState::Active || !pair.bodies.iter().all(|body| self.mechanism.is_base(*body)) {
                continue;
            }
            let delta_rate_slip_after = |dt: f64| {
                let mut q = q.clone();
                q[time] += dt;
                self.with_contact((&q, v), index, |motions| {
                    let contact = self.contact_variables(motions, v, index, mode.features[index]);
                    [contact.delta, contact.rate, contact.slip]
                })
            };
            let [delta, rate, slip] = delta_rate_slip_after(0.0);
            let depth = delta.max(contact.normal.depth_scale_m());
            let mut dt = MAX_DRIVEN_STEP_S.min(DRIVEN_FRACTION * depth / rate.abs());
            let max_change = contact.friction.map_or(f64::INFINITY, |law| DRIVEN_FRACTION * law.v_static_m_s);
            while (delta_rate_slip_after(dt)[2] - slip).abs() > max_change {
                dt *= 0.5;
            }
            max_dt = max_dt.min(dt);
        }
        max_dt
    }

    fn is_mode_valid(&self, dt: f64, q: &Vec<f64>, v: &Vec<f64>, mode: &MechanismMode) -> bool {
        self.count_turns_as(mode);
        self.with_motions((q, v), |motions| {
            self.pivot_lines(motions).all(|(line, motion)| line.is_valid(dt, &mode.counts, motion))
                && self.assurs(mode).all(|assur| assur.is_valid(dt, motions))
        })
    }

    fn count_turns(&self, q: &Vec<f64>, v: &Vec<f64>, mode: &mut MechanismMode) {
        if mode.counts.is_empty() {
            return;
        }
        self.count_turns_as(mode);
        self.with_motions((q, v), |motions| {
            for (line, (offset, _)) in self.pivot_lines(motions) {
                if let Some(count) = line.recounted(&mode.counts, offset) {
                    mode.counts[line.count] = count;
                }
            }
            for joint in self.assurs(mode).flat_map(Assur::joints).collect::<Vec<_>>() {
                mode.near[joint] = motions.joints[joint].coordinate;
            }
        });
    }

    fn eval_events(&self, q: &Vec<f64>, v: &Vec<f64>, mode: &MechanismMode, events: &mut EventSet<Dynamic>) {
        self.count_turns_as(mode);
        // Error weights have rows.
        let has_weights = mode.contacts.contacts.iter().any(|contact| contact.state.has_force());
        let evaluate = |motions: &Motions<f64>| {
            let variables = |index: usize| Some(self.contact_variables(motions, v, index, mode.features[index]));
            mode.contacts.eval_events(&self.event_tolerances, variables, events);
            let first = 3 * self.contacts.len();
            for index in 0..self.range_count {
                events.functions[first + index] = self.actuator_event(motions, (q, v), mode, index);
            }
            for index in 0..self.monitored.len() {
                events.functions[self.first_path_event() + index] = self.path_event(motions, mode, index);
            }
            events.functions[self.event_function_count() - 1] = self.feature_event(motions, mode);
            (events.clearance, events.clearance_rate) = self.clearance_and_rate(motions, mode);
        };
        match has_weights {
            true => self.with_columns((q, v), evaluate),
            false => self.with_motions_of_equations((q, v), evaluate),
        }
    }

    fn clearance(&self, q: &Vec<f64>, v: &Vec<f64>, mode: &MechanismMode) -> f64 {
        self.count_turns_as(mode);
        self.with_motions((q, v), |motions| self.clearance_and_rate(motions, mode).0)
    }

    fn eval_event(&self, q: &Vec<f64>, v: &Vec<f64>, mode: &MechanismMode, event: usize) -> EventFunction {
        self.count_turns_as(mode);
        match self.subject_of(event) {
            EventOf::Features => self.with_motions((q, v), |motions| self.feature_event(motions, mode)),
            EventOf::Actuator(index) => {
                self.with_motions((q, v), |motions| self.actuator_event(motions, (q, v), mode, index))
            }
            EventOf::Path(index) => self.with_motions((q, v), |motions| self.path_event(motions, mode, index)),
            EventOf::Contact(index) => self.with_contact((q, v), index, |motions| {
                let contact = self.contact_variables(motions, v, index, mode.features[index]);
                mode.contacts.event_function(event, &self.event_tolerances, Some(&contact))
            }),
        }
    }

    fn event_values(&self, q: &Vec<f64>, v: &Vec<f64>, mode: &MechanismMode, requested: &[bool], values: &mut [f64]) {
        self.count_turns_as(mode);
        let count = self.contacts.len();
        for index in 0..count {
            let events = [index, index + count, index + 2 * count];
            if events.iter().any(|event| requested[*event]) {
                self.with_contact((q, v), index, |motions| {
                    let contact = self.contact_variables(motions, v, index, mode.features[index]);
                    let function = |event| mode.contacts.event_function(event, &self.event_tolerances, Some(&contact));
                    let requested = events.into_iter().filter(|event| requested[*event]);
                    requested.for_each(|event| values[event] = function(event).value);
                });
            }
        }
        for event in (3 * count..requested.len()).filter(|event| requested[*event]) {
            values[event] = self.eval_event(q, v, mode, event).value;
        }
    }

    fn gap_bounds(
        &self,
        motion: &CoordinateBounds<Dynamic>,
        (q, v): StateRef<'_, Dynamic>,
        clearance: f64,
        found: &mut GapBounds,
    ) {
        self.with_bounds((q, v), |motions, bounds| self.bound_gaps(motion, (q, motions, clearance), bounds, found));
    }

    fn event_tolerance(&self, event: usize, mode: &MechanismMode) -> f64 {
        match self.subject_of(event) {
            EventOf::Features => FEATURE_TOLERANCE_M,
            EventOf::Actuator(index) => match self.mechanism.actuators.get(index) {
                Some(actuator) => margin_tolerance(actuator),
                None => self.drive_event_tolerance(index, mode),
            },
            EventOf::Path(index) => self.path_tolerance(mode, index),
            EventOf::Contact(index) => self.contacts.get(index).map_or(0.0, |contact| {
                let (normal, friction) = (&contact.normal, contact.friction.as_ref());
                mode.contacts.event_tolerance(event, normal, friction, &self.event_tolerances)
            }),
        }
    }

    fn pass_event(&self, event: usize, q: &Vec<f64>, v: &Vec<f64>, mode: &mut MechanismMode) {
        self.count_turns_as(mode);
        match self.subject_of(event) {
            EventOf::Features => self.with_motions((q, v), |motions| {
                for index in 0..self.contacts.len() {
                    let Some((pair, frames, feature)) = self.contact_on_feature(motions, mode, index) else { continue };
                    if pair.margin(&frames, feature) < 0.0 {
                        mode.features[index] = Some(pair.feature_beyond(&frames, feature));
                    }
                }
            }),
            EventOf::Actuator(index) => {
                let range = self.with_motions((q, v), |motions| match self.mechanism.actuators.get(index) {
                    Some(actuator) => {
                        range_after(actuator, mode.ranges.0[index], self.command_in(motions, (q, v), mode, index))
                    }
                    None => self.drive_range_after(index, (self.time_in((q, v)), v), motions, mode),
                });
                mode.ranges.0[index] = range;
            }
            EventOf::Path(index) => {
                let contact = self.with_motions((q, v), |motions| self.pass_path_event(motions, mode, index));
                self.pass_paths_as(&mode.bends);
                let Some(contact) = contact else { return };
                let [cable, element] = self.monitored[index];
                mode.contacts.contacts[contact] = match self.cables[cable].bends(&mode.bends)[element].is_on() {
                    true => self.with_motions((q, v), |motions| {
                        let variables = self.contact_variables(motions, v, contact, None);
                        ContactMode { friction_range: variables.friction_range(1.0), ..OFF }
                    }),
                    false => OFF,
                };
            }
            EventOf::Contact(index) => {
                let state = mode[index];
                self.with_motions((q, v), |motions| {
                    let contact = self.contact_variables(motions, v, index, mode.features[index]);
                    mode.contacts.pass_event(event, Some(&contact));
                });
                if mode[index] != state {
                    mode.features[index] = self.starting_feature((q, v), &mode.contacts, index);
                }
            }
        }
    }

    fn is_reported(&self, event: usize) -> bool {
        event < self.reported_contacts()
    }

    fn pass_step(&self, functions: &[EventFunction], mode: &mut MechanismMode) -> bool {
        mode.contacts.free_separated(functions)
    }

    fn clamp_law(&self, event: usize, mode: &mut MechanismMode) {
        match self.subject_of(event) {
            EventOf::Features => mode.features.fill(None),
            EventOf::Actuator(index) => mode.ranges.0[index] = super::actuator::UNMONITORED,
            EventOf::Path(_) => mode.monitors_paths = false,
            EventOf::Contact(_) => mode.contacts.clamp_law(event),
        }
    }

    fn mode_at(&self, t: f64, q: &Vec<f64>, v: &Vec<f64>) -> MechanismMode {
        let counts = vec![0; self.groups.last().map_or(0, |group| group.counts().end)];
        let near = self.near_at_start().to_vec();
        self.count_turns_in(&counts, &near);
        let bends = self.with_motions((q, v), |motions| motions.bends.clone());
        self.mode_with_counts(t, (q, v), (counts, near), bends)
    }

    fn mode_after(&self, t: f64, q: &Vec<f64>, v: &Vec<f64>, last: &MechanismMode) -> MechanismMode {
        self.count_turns_as(last);
        self.mode_with_counts(t, (q, v), (last.counts.clone(), last.near.clone()), last.bends.clone())
    }

    /// Chooses anew the ranges of the actuators whose commands are discontinuous; the laws of contacts depend on positions
    /// and rates, which are continuous.
    fn pass_discontinuity(&self, t: f64, q: &Vec<f64>, v: &Vec<f64>, mode: &mut MechanismMode) {
        self.count_turns_as(mode);
        let last_s = mode.times_s[1];
        mode.times_s = self.times_around(t);
        self.with_motions((q, v), |motions| {
            for (range_of, actuator) in mode.ranges.0.iter_mut().zip(&self.mechanism.actuators) {
                if actuator.command.profile().next_discontinuity(last_s) <= t {
                    let motion = motions.combination(&actuator.on);
                    *range_of = range(actuator, t, motion.coordinate, motion.rate);
                }
            }
            let is_discontinuous = |actuator: &Actuator| actuator.command.profile().next_discontinuity(last_s) <= t;
            self.set_drive_ranges((t, v), motions, is_discontinuous, &mut mode.ranges.0);
        });
    }

    fn restart_step(&self, event: usize, q: &Vec<f64>, v: &Vec<f64>, mode: &MechanismMode) -> Option<f64> {
        let count = self.contacts.len();
        if event >= 3 * count || mode[event % count] != ContactState::Active {
            return None;
        }
        let index = event % count;
        let Scratch { row, response, .. } = &mut *self.scratch.borrow_mut();
        let law = &self.contacts[index].normal;
        let rate = self.with_columns((q, v), |motions| {
            let contact = self.contact_variables(motions, v, index, mode.features[index]);
            contact.normal_row.write(row);
            contact.rate
        });
        response.copy_from_slice(row);
        self.with_factors((q, v), |_, factors| self.solve(factors, response));
        let mobility = row_dot(row, response);
        (mobility > 0.0).then(|| first_impact_step(law, rate.abs(), 1.0 / mobility))
    }

    fn project_quasi_static(
        &self,
        t: f64,
        (q, v): (&Vec<f64>, &Vec<f64>),
        mode: &MechanismMode,
        tolerances: &Tolerances,
    ) -> Option<QuasiStaticState<Dynamic>> {
        self.count_turns_as(mode);
        self.settled(t, (q, v), mode, tolerances)
    }

    fn describe_obstacle(&self, q: &Vec<f64>) -> String {
        let at_rest = vec![0.0; q.len()];
        self.with_motions((q, &at_rest), |motions| {
            let dyads = self.groups.iter().flat_map(|group| {
                group.transmissions(&self.mechanism, motions).map(move |dyad| (&group.group.placements[dyad.0], dyad.1))
            });
            let sine = |sine: f64| if sine.is_nan() { -1.0 } else { sine.abs() };
            if let Some(of_cable) = self.describe_cable(motions) {
                return of_cable;
            }
            let met =
                self.distance_margins(motions).find(|(_, [margin, _])| margin.is_nan() || *margin < MET_ROUNDING_M);
            if let Some((actuator, _)) = met {
                return self.mechanism.describe_met_points(actuator);
            }
            match dyads.min_by(|a, b| sine(a.1.sine).total_cmp(&sine(b.1.sine))) {
                Some((Placement::Dyad { outer, inner }, _)) => {
                    self.describe_singularity(motions, &[outer[0].joint, *inner, outer[1].joint])
                }
                Some((Placement::Assur { tree, known, closing }, _)) => {
                    let assur = Assur { mechanism: &self.mechanism, tree, known, closing };
                    self.describe_singularity(motions, &assur.joints().collect::<Vec<_>>())
                }
                _ => "the nearest points of two outlines are not defined".to_string(),
            }
        })
    }
}
