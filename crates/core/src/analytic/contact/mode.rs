//! Active branches of the contact laws, and the event functions that detect their ends, for all kernels.

use std::ops::{Index, IndexMut};

use crate::integrator::{EventFunction, EventSet, Layout, RootSearch, Vector, VectorOf, WeightedQuantity};
use crate::law::{
    Damping, FrictionLaw, FrictionPoint, FrictionRange, NormalLaw, RANGE_OVERLAP, SlipWeight, damping, is_damped,
    spring_force, unclamped_normal_force,
};

/// Branch of the normal law of one contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactState {
    /// Separated surfaces: no force.
    Free,
    /// k δᵉ + c δ̇; an event ends the branch where the force becomes negative.
    Active,
    /// Overlapping surfaces without a force: k δᵉ + c δ̇ is negative, and the force is clamped to zero.
    Released,
    /// max(0, k δᵉ + c δ̇) without events: for single steps where events chatter.
    Clamped,
}

impl ContactState {
    /// Whether the contact can have a force on this branch.
    #[inline(always)]
    pub fn has_force(self) -> bool {
        matches!(self, Self::Active | Self::Clamped)
    }
}

/// Range of the depth of a contact relative to the transition depth of its damper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DamperRange {
    /// δ < δ_max: c grows with the depth.
    Engaging,
    /// δ ≥ δ_max: c = c_max.
    Engaged,
    /// The range is not monitored.
    Any,
}

/// Branch of the normal law of one contact, and the ranges of its friction law and damper.
///
/// The ranges change no force. The exception is friction with stiction: it keeps the branch of its law up to the event
/// that ends the range. The ranges prevent a step from skipping part of a law, such as the whole sticking range between
/// sliding in one direction and sliding in the other. Neither the stages of the step nor its error estimate would
/// detect this.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ContactMode {
    pub state: ContactState,
    pub friction_range: FrictionRange,
    pub damper_range: DamperRange,
}

impl ContactMode {
    pub const FREE: Self =
        Self { state: ContactState::Free, friction_range: FrictionRange::Any, damper_range: DamperRange::Any };
    /// Mode for integrators without event location: the laws without events.
    pub const CLAMPED: Self = Self { state: ContactState::Clamped, ..Self::FREE };
}

/// Modes of all contacts; S is an array or a vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mode<S> {
    pub contacts: S,
}

impl DamperRange {
    #[inline(always)]
    pub(crate) fn at_depth(law: &NormalLaw, delta: f64) -> Self {
        match law.damping {
            Damping::Step { max_n_s_per_m, transition_m } if max_n_s_per_m > 0.0 => match delta < transition_m {
                true => DamperRange::Engaging,
                false => DamperRange::Engaged,
            },
            Damping::Step { .. } | Damping::Constant { .. } | Damping::HuntCrossley { .. } => DamperRange::Any,
        }
    }
}

impl<const C: usize> From<[ContactState; C]> for Mode<[ContactMode; C]> {
    fn from(states: [ContactState; C]) -> Self {
        Self { contacts: states.map(|state| ContactMode { state, ..ContactMode::FREE }) }
    }
}

impl<S: AsRef<[ContactMode]>> Index<usize> for Mode<S> {
    type Output = ContactState;

    #[inline(always)]
    fn index(&self, index: usize) -> &ContactState {
        &self.contacts.as_ref()[index].state
    }
}

impl<S: AsRef<[ContactMode]> + AsMut<[ContactMode]>> IndexMut<usize> for Mode<S> {
    #[inline(always)]
    fn index_mut(&mut self, index: usize) -> &mut ContactState {
        &mut self.contacts.as_mut()[index].state
    }
}

/// Coordinates and rates.
pub(crate) type StateRef<'a, L> = (&'a VectorOf<L>, &'a VectorOf<L>);

/// Derivatives of a quantity of a contact by all coordinates or rates.
pub(crate) trait Row {
    /// Writes all derivatives.
    fn write(&self, row: &mut [f64]);
}

impl<const N: usize> Row for [f64; N] {
    #[inline(always)]
    fn write(&self, row: &mut [f64]) {
        row.copy_from_slice(self);
    }
}

/// State of one contact with its laws: penetration, penetration rate, slip, and the rows that give the rate of the gap
/// and the slip.
#[derive(Clone, Copy, Debug)]
pub struct ContactVariables<'a, R> {
    pub law: &'a NormalLaw,
    pub friction: Option<&'a FrictionLaw>,
    pub delta: f64,
    pub rate: f64,
    pub slip: f64,
    /// Internal state of the friction law; 0 for a law without a state.
    pub friction_state: f64,
    pub normal_row: R,
    pub tangent_row: R,
}

/// Spring and damper force of the normal law, N (limit: N·m); their sum may be negative.
#[derive(Clone, Copy, Debug, Default)]
struct SpringDamperForce {
    spring: f64,
    damper: f64,
}

impl SpringDamperForce {
    #[inline(always)]
    fn total(&self) -> f64 {
        self.spring + self.damper
    }
}

impl<R: Row> ContactVariables<'_, R> {
    #[inline(always)]
    fn force(&self) -> SpringDamperForce {
        if self.delta <= 0.0 {
            return SpringDamperForce { spring: 0.0, damper: 0.0 };
        }
        let damper = damping(self.law, self.delta).0 * self.rate;
        SpringDamperForce { spring: spring_force(self.law, self.delta), damper }
    }

    /// Point of the friction law under a normal force, N.
    #[inline(always)]
    fn friction_point(&self, normal: f64) -> FrictionPoint {
        FrictionPoint { slip: self.slip, state: self.friction_state, normal }
    }

    /// Range of the friction law under a normal force, N; not monitored without a law.
    pub(crate) fn friction_range(&self, normal: f64) -> FrictionRange {
        self.friction.map_or(FrictionRange::Any, |law| law.range(self.friction_point(normal)))
    }
}

/// Rounding error of a depth, m or rad; the depth is a difference of coordinates.
const DEPTH_NOISE: f64 = 2e-15;

/// Tolerances of event location.
#[derive(Clone, Copy, Debug)]
pub struct EventTolerances {
    /// Tolerance of the depth, as a fraction of δ_max.
    pub depth_fraction: f64,
    pub force: f64,
}

impl EventTolerances {
    /// Tolerances for fingers on an object: touch-downs are located to a fraction of δ_max; lift-offs and reloads, to a
    /// force without a visible effect on the motion.
    pub const GRASP: Self = Self { depth_fraction: 1e-5, force: 1e-6 };
    /// Tolerances for free bodies: contacts are located as precisely as positions allow, because their times are
    /// compared with measurements.
    pub const COLLISION: Self = Self { depth_fraction: 1e-8, force: 1e-9 };

    /// Tolerance of a force, not below the effect of rounding errors of the depth.
    fn force_tolerance(&self, law: &NormalLaw) -> f64 {
        self.force.max(spring_force(law, DEPTH_NOISE))
    }

    /// Force at which a released contact becomes active again, so that lift-off and reload do not alternate.
    fn reload_force(&self, law: &NormalLaw) -> f64 {
        3.0 * self.force_tolerance(law)
    }
}

/// Whether a low derivative of the spring force is infinite at zero depth, where no polynomial can follow it.
pub(crate) fn is_kinked(law: &NormalLaw) -> bool {
    law.exponent.fract() != 0.0 && law.exponent < 3.0
}

/// Rate above which a contact rebounds instead of creeping, m/s (limit: rad/s).
const MIN_REBOUND_SPEED: f64 = 1e-2;

/// A contact separates slowly if its damper cancels this part of the spring force. Its force may then end and return
/// within one step; interpolation over a long step would keep a force that the law has ended.
const WEAK_FORCE_RATIO: f64 = 0.5;

/// Tolerance of locating the end of a range, as a fraction of its overlap with the next.
const RANGE_TOLERANCE: f64 = 0.3;

impl<const C: usize> Mode<[ContactMode; C]> {
    pub const FREE: Self = Self { contacts: [ContactMode::FREE; C] };
    /// See [`ContactMode::CLAMPED`].
    pub const CLAMPED: Self = Self { contacts: [ContactMode::CLAMPED; C] };
}

impl Mode<Vec<ContactMode>> {
    /// All contacts free.
    pub(crate) fn free(count: usize) -> Self {
        Self { contacts: vec![ContactMode::FREE; count] }
    }
}

impl<S: AsRef<[ContactMode]> + AsMut<[ContactMode]>> Mode<S> {
    /// Number of contacts.
    fn count(&self) -> usize {
        self.contacts.as_ref().len()
    }

    /// Range of the friction law of a contact.
    #[inline(always)]
    pub fn friction_range(&self, index: usize) -> FrictionRange {
        self.contacts.as_ref()[index].friction_range
    }

    /// Determines the mode of a state; `self` has all contacts free. `contact_variables` gives the contacts; `accelerations`
    /// gives the accelerations in a mode. A contact at zero depth is active if its gap closes, or if it is at rest and would
    /// close without the forces of all contacts at zero depth.
    pub(crate) fn at_state<'a, R: Row, V: Vector<f64>>(
        mut self,
        event_tolerances: &EventTolerances,
        contact_variables: impl Fn(usize) -> Option<ContactVariables<'a, R>>,
        accelerations: impl FnOnce(&Self) -> V,
    ) -> Self {
        let mut at_zero_depth = Vec::new();
        for (index, mode) in self.contacts.as_mut().iter_mut().enumerate() {
            let Some(contact) = contact_variables(index) else { continue };
            let ContactVariables { law, delta, rate, .. } = contact;
            mode.damper_range = DamperRange::at_depth(law, delta);
            mode.friction_range = contact.friction_range(contact.force().total());
            if delta.abs() <= event_tolerances.depth_fraction * law.depth_scale_m() {
                at_zero_depth.push((index, contact.normal_row, rate));
            } else if delta > 0.0 {
                let force = unclamped_normal_force(law, delta, rate).force;
                mode.state = if force >= 0.0 { ContactState::Active } else { ContactState::Released };
            }
        }
        let free_accelerations = accelerations(&self);
        let mut row = free_accelerations.clone();
        for (index, normal_row, rate) in at_zero_depth {
            normal_row.write(row.as_mut());
            let is_at_rest = rate.abs() < 1e-12;
            if rate >= 1e-12 || (is_at_rest && -row_dot(row.as_ref(), free_accelerations.as_ref()) > 0.0) {
                self[index] = ContactState::Active;
            }
        }
        self
    }

    /// Whether the friction of a contact is outside its sticking range; `None` without a force or a monitored range.
    pub(crate) fn is_slipping(&self, index: usize) -> Option<bool> {
        match self.friction_range(index) {
            _ if !self[index].has_force() => None,
            FrictionRange::Any => None,
            range => Some(range != FrictionRange::Sticking),
        }
    }

    /// All event functions of the contacts: those of normal laws, then friction laws, then dampers. Contacts without a branch
    /// or friction range that can end are not evaluated.
    #[inline(always)]
    pub(crate) fn eval_events<'a, R: Row, L: Layout>(
        &self,
        event_tolerances: &EventTolerances,
        contact_variables: impl Fn(usize) -> Option<ContactVariables<'a, R>>,
        events: &mut EventSet<L>,
    ) {
        events.clear();
        let count = self.count();
        for index in 0..count {
            if self[index] == ContactState::Clamped && self.friction_range(index) == FrictionRange::Any {
                continue;
            }
            let Some(contact) = contact_variables(index) else { continue };
            let force = contact.force();
            events.functions[index] = self.normal_event(index, event_tolerances, &contact, &force);
            // The other functions of a contact without a force stay inactive.
            if !self[index].has_force() {
                continue;
            }
            events.functions[index + 2 * count] = self.damper_event(index, &contact);
            if let Some(depth) = self.weighted_depth(index, &contact, &force) {
                contact.normal_row.write(events.add_weight(index, depth).as_mut());
            }
            if let Some(friction) = contact.friction {
                events.functions[index + count] = self.slip_event(index, friction, &contact, &force);
                if let Some(slip) = self.weighted_slip(index, friction, &force) {
                    contact.tangent_row.write(events.add_weight(index + count, slip).as_mut());
                }
            }
        }
    }

    /// One event function of a contact; inactive if the contact does not exist.
    #[inline(always)]
    pub(crate) fn event_function<R: Row>(
        &self,
        event: usize,
        event_tolerances: &EventTolerances,
        contact: Option<&ContactVariables<'_, R>>,
    ) -> EventFunction {
        let Some(contact) = contact else { return EventFunction::INACTIVE };
        let index = event % self.count();
        match (event / self.count(), contact.friction) {
            (0, _) => self.normal_event(index, event_tolerances, contact, &contact.force()),
            (1, Some(friction)) => {
                let force = if friction.has_state() { contact.force() } else { SpringDamperForce::default() };
                self.slip_event(index, friction, contact, &force)
            }
            (1, None) => EventFunction::INACTIVE,
            _ => self.damper_event(index, contact),
        }
    }

    /// Event function of the normal law of a contact.
    #[inline(always)]
    fn normal_event<R: Row>(
        &self,
        index: usize,
        event_tolerances: &EventTolerances,
        contact: &ContactVariables<'_, R>,
        force: &SpringDamperForce,
    ) -> EventFunction {
        let ContactVariables { law, delta, rate, .. } = *contact;
        let inactive = EventFunction::INACTIVE;
        match self[index] {
            ContactState::Clamped => inactive,
            ContactState::Free => {
                EventFunction { value: -delta, rate: -rate, root_search: RootSearch::Bounded, ..inactive }
            }
            // After touch-down, before the first penetration.
            ContactState::Active if delta <= 0.0 && rate >= 0.0 => EventFunction { is_separated: false, ..inactive },
            // Without a damper the force falls continuously to 0 with the depth, so the depth locates the separation.
            ContactState::Active if !is_damped(law) => {
                let (value, root_search) = (if delta > 0.0 { delta } else { delta.min(-1e-290) }, RootSearch::Gap);
                EventFunction { value, rate, root_search, is_separated: false }
            }
            ContactState::Active => {
                // A negative depth ends the branch even if the force never became negative.
                let value = if delta > 0.0 { force.total() } else { delta.min(-1e-290) };
                let root_search =
                    if value < WEAK_FORCE_RATIO * force.spring { RootSearch::FadingForce } else { RootSearch::EndOnly };
                EventFunction { value, root_search, is_separated: false, ..inactive }
            }
            // The force of a released contact may return and end again within one step.
            ContactState::Released => EventFunction {
                value: event_tolerances.reload_force(law) - force.total(),
                root_search: RootSearch::Interior,
                is_separated: delta < 0.0,
                ..inactive
            },
        }
    }

    /// Weighted depth of an active contact.
    #[inline(always)]
    fn weighted_depth<R: Row>(
        &self,
        index: usize,
        contact: &ContactVariables<'_, R>,
        force: &SpringDamperForce,
    ) -> Option<WeightedQuantity> {
        let is_spring_dominated = force.spring > force.damper.abs();
        let is_rebounding = is_spring_dominated && contact.rate.abs() > MIN_REBOUND_SPEED;
        let depth = contact.delta;
        (self[index] == ContactState::Active && depth > 0.0).then_some(WeightedQuantity::Depth {
            depth,
            is_rebounding,
            is_spring_dominated,
        })
    }

    /// Event function of the friction law of a contact.
    #[inline(always)]
    fn slip_event<R: Row>(
        &self,
        index: usize,
        law: &FrictionLaw,
        contact: &ContactVariables<'_, R>,
        force: &SpringDamperForce,
    ) -> EventFunction {
        let range = self.friction_range(index);
        if !self[index].has_force() || range == FrictionRange::Any {
            return EventFunction::INACTIVE;
        }
        let value = law.range_margin(range, contact.friction_point(force.total()));
        let root_search = if law.may_return_to(range) { RootSearch::EndOnly } else { RootSearch::Smooth };
        EventFunction { value, root_search, is_separated: false, ..EventFunction::INACTIVE }
    }

    /// Weighted slip of a contact with a force.
    #[inline(always)]
    fn weighted_slip(&self, index: usize, law: &FrictionLaw, force: &SpringDamperForce) -> Option<WeightedQuantity> {
        let weight = law.slip_weight(self.friction_range(index), force.total());
        weight
            .filter(|_| self[index].has_force())
            .map(|SlipWeight { slip_scale, normal_force }| WeightedQuantity::Slip { slip_scale, normal_force })
    }

    #[inline(always)]
    fn damper_event<R: Row>(&self, index: usize, contact: &ContactVariables<'_, R>) -> EventFunction {
        let ContactVariables { law, delta, rate, .. } = *contact;
        let [margin, margin_rate] = match self.contacts.as_ref()[index].damper_range {
            _ if self[index] != ContactState::Active => return EventFunction::INACTIVE,
            DamperRange::Any => return EventFunction::INACTIVE,
            DamperRange::Engaging => [law.depth_scale_m() - delta, -rate],
            DamperRange::Engaged => [delta - law.depth_scale_m(), rate],
        };
        let (value, root_search) = (margin + RANGE_OVERLAP * law.depth_scale_m(), RootSearch::Gap);
        EventFunction { value, rate: margin_rate, root_search, is_separated: false }
    }

    /// Tolerance of an event function. The functions are those of the normal laws, then of the friction laws, then of
    /// the dampers.
    pub fn event_tolerance(
        &self,
        event: usize,
        law: &NormalLaw,
        friction: Option<&FrictionLaw>,
        event_tolerances: &EventTolerances,
    ) -> f64 {
        let count = self.count();
        if event >= 2 * count {
            return RANGE_TOLERANCE * RANGE_OVERLAP * law.depth_scale_m();
        }
        if event >= count {
            let Some(law) = friction else { return 0.0 };
            let overlap = law.range_overlap(self.friction_range(event - count));
            return RANGE_TOLERANCE * overlap * law.min_slip_scale_m_s();
        }
        match self[event] {
            ContactState::Active if is_damped(law) => event_tolerances.force_tolerance(law),
            ContactState::Released | ContactState::Clamped => event_tolerances.force_tolerance(law),
            ContactState::Free | ContactState::Active => event_tolerances.depth_fraction * law.depth_scale_m(),
        }
    }

    /// Changes the mode by an event of a contact in this state.
    pub(crate) fn pass_event<R: Row>(&mut self, event: usize, contact: Option<&ContactVariables<'_, R>>) {
        let Some(contact) = contact else { return };
        let count = self.count();
        let mode = &mut self.contacts.as_mut()[event % count];
        if event >= 2 * count {
            let is_engaging = mode.damper_range == DamperRange::Engaging;
            mode.damper_range = if is_engaging { DamperRange::Engaged } else { DamperRange::Engaging };
            return;
        }
        let normal = contact.force().total();
        let range = contact.friction_range(normal);
        if event >= count {
            // If the range is the old one, the event was located within its margin.
            let is_old = mode.friction_range == range;
            let neighbour = |law: &FrictionLaw| law.neighbour_range(range, contact.friction_point(normal));
            mode.friction_range = if is_old { contact.friction.map_or(range, neighbour) } else { range };
            return;
        }
        mode.state = match mode.state {
            ContactState::Free | ContactState::Released => ContactState::Active,
            ContactState::Active => ContactState::Released,
            ContactState::Clamped => ContactState::Clamped,
        };
        mode.friction_range = range;
        mode.damper_range = DamperRange::at_depth(contact.law, contact.delta);
    }

    /// Frees released contacts whose surfaces have separated in a step; returns whether there are any.
    pub(crate) fn free_separated(&mut self, functions: &[EventFunction]) -> bool {
        let mut is_changed = false;
        for (mode, function) in self.contacts.as_mut().iter_mut().zip(functions) {
            if mode.state == ContactState::Released && function.is_separated {
                (mode.state, is_changed) = (ContactState::Free, true);
            }
        }
        is_changed
    }

    /// Removes the events of the law to which an event function belongs.
    pub fn clamp_law(&mut self, event: usize) {
        let count = self.count();
        let mode = &mut self.contacts.as_mut()[event % count];
        match event / count {
            0 => mode.state = ContactState::Clamped,
            1 => mode.friction_range = FrictionRange::Any,
            _ => mode.damper_range = DamperRange::Any,
        }
    }
}

/// Laws of one contact, the active branch, and the range of the friction law.
#[derive(Clone, Copy)]
pub(crate) struct ContactLaws<'a> {
    pub normal: &'a NormalLaw,
    pub friction: Option<&'a FrictionLaw>,
    pub state: ContactState,
    pub range: FrictionRange,
}

impl<'a> ContactLaws<'a> {
    /// Returns the laws of a contact if it has a force in this mode; `None` otherwise.
    #[inline(always)]
    pub fn in_mode<S: AsRef<[ContactMode]>>(
        mode: &Mode<S>,
        index: usize,
        (normal, friction): (&'a NormalLaw, Option<&'a FrictionLaw>),
    ) -> Option<Self> {
        let ContactMode { state, friction_range: range, .. } = mode.contacts.as_ref()[index];
        state.has_force().then_some(Self { normal, friction, state, range })
    }
}

/// Product of a row and a column, such as the rate of a gap.
#[inline(always)]
pub(crate) fn row_dot(row: &[f64], column: &[f64]) -> f64 {
    row.iter().zip(column).fold(-0.0, |sum, (entry, other)| sum + entry * other)
}
