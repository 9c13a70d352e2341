//! Event functions of the contacts: where the branches of their laws change.

use std::cell::OnceCell;

use super::components::{ContactModel, ContactPair};
use super::evaluation::ContactMotion;
use super::model::Multibody;
use super::{CONTACTS, EVENT_FUNCTIONS, FINGERS, GraspLayout, GraspMode, first_impact_step};
use crate::analytic::ContactState;
use crate::analytic::closed_form::{FingerBounds, FingerKinematics};
use crate::analytic::contact::{ContactKinematics, ContactVariables, EventTolerances, Mode, StateRef, row_dot};
use crate::analytic::motion_bound::{MotionBound, RateBound};
use crate::fivebar::dynamics::absolute_rates;
use crate::fivebar::kinematics::{SINGULAR_SINE, nearest_singularity};
use crate::gripper::FingerContact;
use crate::integrator::{CoordinateBounds, EventFunction, EventSet, GapBounds, Hybrid, Rates, System};
use crate::numeric::elementary::hypot;
use crate::numeric::map_array;
use crate::numeric::plane::{cross, dot};

impl<const N: usize> Multibody<N> {
    /// State of a contact, with its laws; `None` where the scene has no such contact.
    #[inline(always)]
    fn contact_variables(
        &self,
        (q, v): StateRef<'_, GraspLayout<N>>,
        finger_kinematics: impl Fn(usize) -> FingerKinematics,
        index: usize,
    ) -> Option<ContactVariables<'_, [f64; N]>> {
        if !Self::GRASP {
            return self.contact_variables_noinline((q, v), &finger_kinematics, index);
        }
        let contact = self.contacts.get(index)?.as_ref()?;
        Some(self.contact_variables_from(v, contact, self.contact_kinematics(q, finger_kinematics, contact)))
    }

    /// Like [`Multibody::contact_variables`], with rows of zeros, which only error weights need.
    #[inline(always)]
    fn contact_variables_without_rows(
        &self,
        (q, v): StateRef<'_, GraspLayout<N>>,
        finger_kinematics: impl Fn(usize) -> FingerKinematics,
        index: usize,
    ) -> Option<ContactVariables<'_, [f64; N]>> {
        let contact = self.contacts.get(index)?.as_ref()?;
        let ContactMotion { gap, gap_rate, slip, .. } = match Self::GRASP {
            true => self.contact_motion((q, v), finger_kinematics, contact),
            false => self.contact_motion_noinline((q, v), &finger_kinematics, contact),
        };
        Some(ContactVariables {
            law: &contact.normal,
            friction: contact.friction.as_ref(),
            delta: -gap,
            rate: -gap_rate,
            slip,
            bristle_state: self.bristle_state(contact, v).unwrap_or(0.0),
            normal_row: [0.0; N],
            tangent_row: [0.0; N],
        })
    }

    /// Like [`Multibody::contact_variables`], but compiled only once.
    #[inline(never)]
    fn contact_variables_noinline(
        &self,
        (q, v): StateRef<'_, GraspLayout<N>>,
        finger_kinematics: &dyn Fn(usize) -> FingerKinematics,
        index: usize,
    ) -> Option<ContactVariables<'_, [f64; N]>> {
        let contact = self.contacts.get(index)?.as_ref()?;
        Some(self.contact_variables_from(v, contact, self.contact_kinematics_noinline(q, finger_kinematics, contact)))
    }

    #[inline(always)]
    fn contact_variables_from<'a>(
        &self,
        v: &[f64; N],
        contact: &'a ContactModel,
        kinematics: ContactKinematics<f64, N>,
    ) -> ContactVariables<'a, [f64; N]> {
        let (rate, slip) = (-row_dot(&kinematics.normal_row, v), row_dot(&kinematics.tangent_row, v));
        let (mut row, mut tangent) = (kinematics.normal_row, kinematics.tangent_row);
        // Time is no degree of freedom.
        self.time_index.into_iter().for_each(|time| (row[time], tangent[time]) = (0.0, 0.0));
        contact.bristle_index.into_iter().for_each(|bristle| tangent[bristle] = 1.0);
        let bristle_state = self.bristle_state(contact, v).unwrap_or(0.0);
        ContactVariables {
            law: &contact.normal,
            friction: contact.friction.as_ref(),
            delta: -kinematics.gap,
            rate,
            slip,
            bristle_state,
            normal_row: row,
            tangent_row: tangent,
        }
    }

    /// Like [`Multibody::contact_variables`], for callers that need it rarely.
    fn variables_at(&self, q: &[f64; N], v: &[f64; N], index: usize) -> Option<ContactVariables<'_, [f64; N]>> {
        self.contact_variables_noinline((q, v), &|finger| self.finger_kinematics(finger, q), index)
    }

    /// Bounds of the motion of the palm in the world over a part of a step that ends or begins in this state.
    fn palm_bound(&self, motion: &CoordinateBounds<GraspLayout<N>>, q: &[f64; N]) -> MotionBound {
        let Some((palm, time)) = self.palm_motion.as_ref().zip(self.time_index) else { return MotionBound::default() };
        let (step_s, span_s) = (motion.rate[time], motion.rate[time] * motion.width);
        let [rate, acceleration] = palm.largest_rates([q[time] - span_s, q[time] + span_s]);
        let bound = |[x, y, angle]: [f64; 3], scale: f64| [hypot(x, y) * scale, angle * scale];
        let [speed, spin] = bound(rate, step_s);
        let [acceleration, spin_acceleration] = bound(acceleration, step_s * step_s);
        MotionBound { speed, acceleration, spin, spin_acceleration }
    }

    /// Distance of the fingers' linkages from their nearest singular configuration, and its rate.
    #[inline(always)]
    fn clearance_and_rate(&self, all_finger_kinematics: &[FingerKinematics; FINGERS], v: &[f64; N]) -> (f64, f64) {
        let mut smallest = (f64::INFINITY, 0.0);
        for (finger, (pose, rates)) in all_finger_kinematics.iter().enumerate() {
            let (sine, cosine) = (cross(pose.e3, pose.e4), dot(pose.e3, pose.e4));
            let [_, _, rate3, rate4] = absolute_rates(rates, Self::finger_coordinates(finger, v));
            let clearance = (sine.abs() - SINGULAR_SINE, sine.signum() * cosine * (rate4 - rate3));
            // NaN counts as the smallest clearance.
            if smallest.0 > clearance.0 || clearance.0.is_nan() {
                smallest = clearance;
            }
        }
        smallest
    }
}

impl<const N: usize> Hybrid for Multibody<N> {
    #[inline(always)]
    fn event_count(&self) -> usize {
        EVENT_FUNCTIONS
    }

    fn next_discontinuity(&self, t: f64) -> f64 {
        self.next_time_discontinuity(t)
    }

    #[inline(always)]
    fn eval_events(&self, q: &[f64; N], v: &[f64; N], mode: &GraspMode, events: &mut EventSet<GraspLayout<N>>) {
        let all_finger_kinematics = self.all_finger_kinematics(q);
        let variables = |index: usize| {
            let finger_kinematics = |finger: usize| all_finger_kinematics[finger];
            match mode[index].has_force() {
                true => self.contact_variables((q, v), finger_kinematics, index),
                false => self.contact_variables_without_rows((q, v), finger_kinematics, index),
            }
        };
        mode.eval_events(&EventTolerances::GRASP, variables, events);
        (events.clearance, events.clearance_rate) = self.clearance_and_rate(&all_finger_kinematics, v);
    }

    fn clearance(&self, q: &[f64; N], v: &[f64; N], _mode: &GraspMode) -> f64 {
        self.clearance_and_rate(&self.all_finger_kinematics(q), v).0
    }

    #[inline(always)]
    fn eval_event(&self, q: &[f64; N], v: &[f64; N], mode: &GraspMode, event: usize) -> EventFunction {
        let finger_kinematics = |finger: usize| self.finger_kinematics(finger, q);
        let contact = self.contact_variables_without_rows((q, v), finger_kinematics, event % CONTACTS);
        mode.event_function(event, &EventTolerances::GRASP, contact.as_ref())
    }

    #[inline(always)]
    fn event_values(&self, q: &[f64; N], v: &[f64; N], mode: &GraspMode, requested: &[bool], values: &mut [f64]) {
        let all_finger_kinematics = [const { OnceCell::new() }; FINGERS];
        let finger_kinematics =
            |finger: usize| *all_finger_kinematics[finger].get_or_init(|| self.finger_kinematics(finger, q));
        for event in (0..EVENT_FUNCTIONS).filter(|event| requested[*event]) {
            let contact = self.contact_variables_without_rows((q, v), finger_kinematics, event % CONTACTS);
            values[event] = mode.event_function(event, &EventTolerances::GRASP, contact.as_ref()).value;
        }
    }

    fn gap_bounds(
        &self,
        motion: &CoordinateBounds<GraspLayout<N>>,
        (q, _): StateRef<'_, GraspLayout<N>>,
        clearance: f64,
        found: &mut GapBounds,
    ) {
        let coordinate = |index: usize| RateBound::of_coordinate(motion, index);
        let centre = self.moving_object().map_or_else(RateBound::default, |(first, _)| {
            let [x, y] = [coordinate(first), coordinate(first + 1)];
            RateBound { rate: hypot(x.rate, y.rate), acceleration: hypot(x.acceleration, y.acceleration) }
        });
        let largest = |[x, y]: [f64; 2]| hypot(x, y) + centre.rate * motion.width;
        found.clearance_reach = f64::INFINITY;
        let fingers: [FingerBounds; FINGERS] = std::array::from_fn(|finger| {
            let coordinates = [2 * finger, 2 * finger + 1].map(coordinate);
            let bounds = self.fingers[finger].model.bounds(clearance + SINGULAR_SINE, coordinates, motion.width);
            if bounds.clearance_reach.is_nan() || bounds.clearance_reach < found.clearance_reach {
                found.clearance_reach = bounds.clearance_reach;
            }
            bounds
        });
        for (gap, contact) in found.gaps.iter_mut().zip(&self.contacts) {
            let Some(contact) = contact else { continue };
            let bound = |finger: usize, phalanx: FingerContact, distance: f64| {
                self.fingers[finger].model.phalanx_bound(&fingers[finger], phalanx, (centre, distance))
            };
            *gap = match contact.pair {
                ContactPair::Phalanx { finger, phalanx } => {
                    let object = self.object_in_finger_frame(self.fingers[finger].side, q);
                    bound(finger, phalanx, largest(object.centre_m))
                }
                ContactPair::Stop { finger } => bound(finger, FingerContact::Limit, 0.0),
                ContactPair::Plane(_) => centre.gap(),
                ContactPair::MovingPlane(_) => {
                    let [x, y, _] = self.object_pose(q);
                    self.palm_bound(motion, q).seen(centre, largest([x, y])).gap()
                }
            };
        }
    }

    fn event_tolerance(&self, event: usize, mode: &GraspMode) -> f64 {
        let contact = self.contacts[event % CONTACTS].as_ref();
        contact.map_or(0.0, |contact| {
            mode.event_tolerance(event, &contact.normal, contact.friction.as_ref(), &EventTolerances::GRASP)
        })
    }

    fn pass_event(&self, event: usize, q: &[f64; N], v: &[f64; N], mode: &mut GraspMode) {
        mode.pass_event(event, self.variables_at(q, v, event % CONTACTS).as_ref());
    }

    fn is_reported(&self, event: usize) -> bool {
        event < CONTACTS
    }

    fn pass_step(&self, functions: &[EventFunction], mode: &mut GraspMode) -> bool {
        mode.free_separated(functions)
    }

    fn clamp_law(&self, event: usize, mode: &mut GraspMode) {
        mode.clamp_law(event);
    }

    fn mode_at(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> GraspMode {
        let accelerations = |mode: &GraspMode| {
            let mut rates = Rates::zero(self.layout());
            self.rates(t, q, v, mode, &mut rates);
            rates.a
        };
        Mode::FREE.at_state(&EventTolerances::GRASP, |index| self.variables_at(q, v, index), accelerations)
    }

    fn restart_step(&self, event: usize, q: &[f64; N], v: &[f64; N], mode: &GraspMode) -> Option<f64> {
        if mode[event % CONTACTS] != ContactState::Active {
            return None;
        }
        let ContactVariables { law, rate, normal_row, .. } = self.variables_at(q, v, event % CONTACTS)?;
        let mobility = row_dot(&normal_row, &self.inverse(q).solve(&normal_row));
        // The mobility is 0 for a fixed object on a plane.
        (mobility > 0.0).then(|| first_impact_step(law, rate.abs(), 1.0 / mobility))
    }

    fn describe_obstacle(&self, q: &[f64; N]) -> String {
        let [right, left] = map_array(self.all_finger_kinematics(q), |(pose, _)| cross(pose.e3, pose.e4).abs());
        let finger = usize::from(right > left || left.is_nan());
        let component = &self.fingers[finger];
        let singularity = nearest_singularity(&component.model.dynamics.lengths, Self::finger_coordinates(finger, q));
        format!("singular configuration of the {} finger: {singularity}", component.side.name())
    }
}
