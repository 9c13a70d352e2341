//! Event functions of the finger's contacts: where the branches of their laws change.

use super::finger::FingerKinematics;
use super::model::{EVENT_FUNCTIONS, FingerLayout, FingerMode, FingerMotion, finger_coordinates, pad};
use crate::analytic::contact::{
    ContactState, ContactVariables, DIFFERENCE_STEP_S, EventTolerances, Settling, StateRef, first_impact_step,
    max_chatter_rate, may_chatter, settling,
};
use crate::analytic::motion_bound::RateBound;
use crate::fivebar::dynamics::{absolute_rates, solve_mass};
use crate::fivebar::kinematics::{SINGULAR_SINE, nearest_singularity};
use crate::gripper::FingerContact;
use crate::integrator::{
    CoordinateBounds, EventFunction, EventSet, GapBounds, Hybrid, QuasiStaticState, Rates, System, Tolerances,
};
use crate::numeric::array_from;
use crate::numeric::plane::{cross, dot};

/// Returns the contact that an event function belongs to. Normal laws come first, then friction laws, then dampers.
fn contact_of_event(event: usize) -> FingerContact {
    FingerContact::ALL[event % FingerContact::ALL.len()]
}

impl<const N: usize, const W: usize> FingerMotion<N, W> {
    /// State of a contact with its laws; `None` where the scene has no such contact.
    #[inline(always)]
    fn contact_variables(
        &self,
        (pose, rates): &FingerKinematics,
        v: &[f64; N],
        contact: FingerContact,
    ) -> Option<ContactVariables<'_, [f64; N]>> {
        let geometry = self.geometry(pose, rates, contact)?;
        let (rate, slip) =
            (-dot(geometry.normal_row, finger_coordinates(v)), dot(geometry.tangent_row, finger_coordinates(v)));
        let mut variables = ContactVariables {
            law: self.finger.normal_law(contact)?,
            friction: self.finger.friction_law(contact),
            delta: -geometry.gap,
            rate,
            slip,
            friction_state: 0.0,
            normal_row: pad(geometry.normal_row),
            tangent_row: pad(geometry.tangent_row),
        };
        if let Some(state) = Self::state_index(contact) {
            (variables.friction_state, variables.tangent_row[state]) = (v[state], 1.0);
        }
        Some(variables)
    }
}

impl<const N: usize, const W: usize> FingerMotion<N, W> {
    /// Returns the state with one contact at rest at its equilibrium depth, where the spring balances the load; `None`
    /// if the contact does not chatter about that depth.
    fn contact_at_equilibrium(
        &self,
        t: f64,
        (q, v): StateRef<'_, FingerLayout<N>>,
        mode: &FingerMode,
        contact: FingerContact,
        max_rate: f64,
    ) -> Option<QuasiStaticState<FingerLayout<N>>> {
        let terms = self.finger.terms(finger_coordinates(q));
        let variables = self.contact_variables(&(terms.pose, terms.rates), v, contact)?;
        let (law, motion) = (variables.law, [variables.delta, variables.rate]);
        if !may_chatter(law, motion, max_rate) {
            return None;
        }
        let mut mode_without_contact = *mode;
        mode_without_contact[contact as usize] = ContactState::Free;
        let mut free = Rates::zero(self.layout());
        self.rates(t, q, v, &mode_without_contact, &mut free);
        let free = free.a;
        // The row changes along the free motion; its contribution to the gap's acceleration is a central difference.
        let gap_rate_after = |h: f64| -> Option<f64> {
            let q = [q[0] + h * v[0], q[1] + h * v[1]];
            let (pose, rates) = self.finger.kinematics(q);
            Some(dot(self.geometry(&pose, &rates, contact)?.normal_row, finger_coordinates(v)))
        };
        let row_change =
            (gap_rate_after(DIFFERENCE_STEP_S)? - gap_rate_after(-DIFFERENCE_STEP_S)?) / (2.0 * DIFFERENCE_STEP_S);
        let row = finger_coordinates(&variables.normal_row);
        let response = solve_mass(&terms.mass, row);
        let mobility = dot(row, response);
        let free_acceleration = dot(row, finger_coordinates(&free)) + row_change;
        let Settling { of_depth, of_rate, decay_rate } = settling(law, motion, free_acceleration, mobility)?;
        let response: [f64; N] = pad(response);
        Some(QuasiStaticState {
            q: array_from(|i| q[i] + of_depth * response[i]),
            v: array_from(|i| v[i] + of_rate * response[i]),
            decay_rate,
        })
    }
}

impl<const N: usize, const W: usize> Hybrid for FingerMotion<N, W> {
    #[inline(always)]
    fn event_count(&self) -> usize {
        EVENT_FUNCTIONS
    }

    fn next_discontinuity(&self, t: f64) -> f64 {
        self.actuation.next_discontinuity(t)
    }

    #[inline(always)]
    fn eval_events(&self, q: &[f64; N], v: &[f64; N], mode: &FingerMode, events: &mut EventSet<FingerLayout<N>>) {
        let kinematics = self.finger.kinematics(finger_coordinates(q));
        let (pose, rates) = &kinematics;
        let (sine, cosine) = (cross(pose.e3, pose.e4), dot(pose.e3, pose.e4));
        let [_, _, rate3, rate4] = absolute_rates(rates, finger_coordinates(v));
        let variables = |index: usize| self.contact_variables(&kinematics, v, FingerContact::ALL[index]);
        mode.eval_events(&EventTolerances::GRASP, variables, events);
        events.clearance = sine.abs() - SINGULAR_SINE;
        events.clearance_rate = sine.signum() * cosine * (rate4 - rate3);
    }

    fn clearance(&self, q: &[f64; N], _v: &[f64; N], _mode: &FingerMode) -> f64 {
        let (pose, _) = self.finger.kinematics(finger_coordinates(q));
        cross(pose.e3, pose.e4).abs() - SINGULAR_SINE
    }

    #[inline(always)]
    fn eval_event(&self, q: &[f64; N], v: &[f64; N], mode: &FingerMode, event: usize) -> EventFunction {
        let kinematics = self.finger.kinematics(finger_coordinates(q));
        let contact = self.contact_variables(&kinematics, v, contact_of_event(event));
        mode.event_function(event, &EventTolerances::GRASP, contact.as_ref())
    }

    #[inline(always)]
    fn event_values(&self, q: &[f64; N], v: &[f64; N], mode: &FingerMode, requested: &[bool], values: &mut [f64]) {
        const CONTACTS: usize = FingerContact::ALL.len();
        let kinematics = self.finger.kinematics(finger_coordinates(q));
        for contact in FingerContact::ALL {
            let indices = [contact as usize, contact as usize + CONTACTS, contact as usize + 2 * CONTACTS];
            if indices.iter().all(|event| !requested[*event]) {
                continue;
            }
            let variables = self.contact_variables(&kinematics, v, contact);
            for event in indices.into_iter().filter(|event| requested[*event]) {
                values[event] = mode.event_function(event, &EventTolerances::GRASP, variables.as_ref()).value;
            }
        }
    }

    #[inline(always)]
    fn gap_bounds(
        &self,
        motion: &CoordinateBounds<FingerLayout<N>>,
        _state: StateRef<'_, FingerLayout<N>>,
        clearance: f64,
        found: &mut GapBounds,
    ) {
        let coordinates = [0, 1].map(|index| RateBound::of_coordinate(motion, index));
        let bounds = self.finger.bounds(clearance + SINGULAR_SINE, coordinates, motion.width);
        found.clearance_reach = bounds.clearance_reach;
        // The object is fixed.
        let centre = self.object.map_or([0.0; 2], |object| object.centre_m);
        let centre = (RateBound::default(), dot(centre, centre).sqrt());
        for contact in FingerContact::ALL {
            found.gaps[contact as usize] = self.finger.phalanx_bound(&bounds, contact, centre);
        }
    }

    fn event_tolerance(&self, event: usize, mode: &FingerMode) -> f64 {
        let contact = contact_of_event(event);
        let friction = self.finger.friction_law(contact);
        self.finger
            .normal_law(contact)
            .map_or(0.0, |law| mode.event_tolerance(event, law, friction, &EventTolerances::GRASP))
    }

    fn pass_event(&self, event: usize, q: &[f64; N], v: &[f64; N], mode: &mut FingerMode) {
        let kinematics = self.finger.kinematics(finger_coordinates(q));
        mode.pass_event(event, self.contact_variables(&kinematics, v, contact_of_event(event)).as_ref());
    }

    fn is_reported(&self, event: usize) -> bool {
        event < FingerContact::ALL.len()
    }

    fn pass_step(&self, events: &[EventFunction], mode: &mut FingerMode) -> bool {
        mode.free_separated(events)
    }

    fn clamp_law(&self, event: usize, mode: &mut FingerMode) {
        mode.clamp_law(event);
    }

    fn mode_at(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> FingerMode {
        let kinematics = self.finger.kinematics(finger_coordinates(q));
        let variables = |index: usize| self.contact_variables(&kinematics, v, FingerContact::ALL[index]);
        FingerMode::FREE.at_state(&EventTolerances::GRASP, variables, |mode| {
            let mut rates = Rates::zero(self.layout());
            self.rates(t, q, v, mode, &mut rates);
            rates.a
        })
    }

    fn restart_step(&self, event: usize, q: &[f64; N], v: &[f64; N], mode: &FingerMode) -> Option<f64> {
        let contact = contact_of_event(event);
        if mode[contact as usize] != ContactState::Active {
            return None;
        }
        let terms = self.finger.terms(finger_coordinates(q));
        let (geometry, law) = (self.geometry(&terms.pose, &terms.rates, contact)?, self.finger.normal_law(contact)?);
        let row = geometry.normal_row;
        let speed = dot(row, finger_coordinates(v)).abs();
        let mobility = dot(row, solve_mass(&terms.mass, row));
        Some(first_impact_step(law, speed, 1.0 / mobility))
    }

    fn project_quasi_static(
        &self,
        t: f64,
        (q, v): StateRef<'_, FingerLayout<N>>,
        mode: &FingerMode,
        tolerances: &Tolerances,
    ) -> Option<QuasiStaticState<FingerLayout<N>>> {
        let mut projected = QuasiStaticState { q: *q, v: *v, decay_rate: f64::INFINITY };
        let max_rate = max_chatter_rate(tolerances);
        for contact in FingerContact::ALL {
            if let Some(state) = self.contact_at_equilibrium(t, (&projected.q, &projected.v), mode, contact, max_rate) {
                projected = QuasiStaticState { decay_rate: projected.decay_rate.min(state.decay_rate), ..state };
            }
        }
        projected.decay_rate.is_finite().then_some(projected)
    }

    fn describe_obstacle(&self, q: &[f64; N]) -> String {
        format!("singular configuration: {}", nearest_singularity(&self.finger.dynamics.lengths, finger_coordinates(q)))
    }
}
