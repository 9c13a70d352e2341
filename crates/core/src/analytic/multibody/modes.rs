//! Where the branches of the contacts change.

use std::cell::OnceCell;

use super::contacts::Posture;
use super::model::Multibody;
use super::parts::{Joined, Meet};
use super::touch::Touch;
use super::{FINGERS, first_step, guards, mode};
use crate::analytic::SiteState;
use crate::analytic::mode::{Contact, Press, along};
use crate::fivebar::dynamics::absolute_rates;
use crate::fivebar::kinematics::{SINGULAR_SINE, nearest_singularity};
use crate::integrator::{Guard, Hybrid, System, Watch};
use crate::law::{FrictionLaw, NormalLaw};
use crate::numeric::from_each;
use crate::numeric::plane::{cross, dot};

/// Part of the law's scales that a contact between driven or fixed surfaces may cross in a step: nothing it does is felt by
/// any coordinate, so that no error estimate would shorten its steps.
const DRIVEN_FRACTION: f64 = 0.05;

/// What a guard asks of a contact, with its laws.
type Asked<'a, const N: usize> = (Contact<N>, &'a NormalLaw, Option<&'a FrictionLaw>);

impl<const N: usize, const C: usize> Multibody<N, C> {
    /// What a guard asks of a contact; `None` where the scene has no such contact.
    #[inline(always)]
    fn asked(
        &self,
        state: (&[f64; N], &[f64; N]),
        posture: impl Fn(usize) -> Posture,
        index: usize,
    ) -> Option<Asked<'_, N>> {
        match Self::GRASP {
            true => self.told(state.1, index, |contact| self.touch(state.0, posture, contact)),
            false => self.asked_apart(state, &posture, index),
        }
    }

    /// The same, compiled once.
    #[inline(never)]
    fn asked_apart(
        &self,
        state: (&[f64; N], &[f64; N]),
        posture: &dyn Fn(usize) -> Posture,
        index: usize,
    ) -> Option<Asked<'_, N>> {
        self.told(state.1, index, |contact| self.touch_apart(state.0, posture, contact))
    }

    #[inline(always)]
    fn told(&self, v: &[f64; N], index: usize, touch: impl FnOnce(&Joined) -> Touch<f64, N>) -> Option<Asked<'_, N>> {
        let contact = self.contacts.get(index)?.as_ref()?;
        let touch = touch(contact);
        let (rate, slip) = (-along(&touch.normal_row, v), along(&touch.tangent_row, v));
        let (mut row, mut tangent) = (touch.normal_row, touch.tangent_row);
        // Nothing moves time.
        self.time.into_iter().for_each(|time| (row[time], tangent[time]) = (0.0, 0.0));
        contact.memory.into_iter().for_each(|memory| tangent[memory] = 1.0);
        let memory = self.remembered(contact, v).unwrap_or(0.0);
        let at = Contact { delta: -touch.gap, rate, slip, memory, row, tangent };
        Some((at, &contact.normal, contact.friction.as_ref()))
    }

    /// One guard without its strain, and without the finger that it is not about.
    #[inline(always)]
    fn guard(
        &self,
        state: (&[f64; N], &[f64; N]),
        posture: impl Fn(usize) -> Posture,
        mode: &mode::Mode<C>,
        guard: usize,
    ) -> Guard<N> {
        let asked = self.asked(state, posture, guard % C);
        asked.map_or(Guard::QUIET, |(at, law, friction)| mode.guard(guard, (law, friction), &self.landing, &at))
    }

    /// How easily a contact's surfaces part: row · M⁻¹ rowᵀ.
    fn mobility(&self, q: &[f64; N], row: &[f64; N]) -> f64 {
        along(row, &self.inverse(q).solve(row))
    }

    /// Whether neither side of a contact feels it.
    fn is_driven(&self, contact: &Joined) -> bool {
        let heavy = |disc: usize| self.discs[disc].inverse_mass == 0.0;
        match contact.meet {
            Meet::Phalanx { .. } | Meet::Stop { .. } => false,
            Meet::Discs { disc, other } => heavy(disc) && heavy(other),
            Meet::Plane { disc, .. } | Meet::PassingPlane { disc, .. } => heavy(disc),
        }
    }

    /// How far the loops of each finger are from folding, and how fast they come near it.
    #[inline(always)]
    fn clearance(&self, postures: &[Posture; FINGERS], v: &[f64; N]) -> (f64, f64) {
        let mut least = (f64::INFINITY, 0.0);
        for (finger, (pose, rates)) in postures.iter().enumerate().take(self.count()) {
            let (sine, cosine) = (cross(pose.e3, pose.e4), dot(pose.e3, pose.e4));
            let [_, _, rate3, rate4] = absolute_rates(rates, Self::own(finger, v));
            let fold = (sine.abs() - SINGULAR_SINE, sine.signum() * cosine * (rate4 - rate3));
            // A clearance that is not a number is the smaller one.
            if least.0 > fold.0 || fold.0.is_nan() {
                least = fold;
            }
        }
        least
    }
}

impl<const N: usize, const C: usize, const Z: usize, const G: usize> Hybrid<N, Z, G> for Multibody<N, C> {
    fn next_corner(&self, t: f64) -> f64 {
        self.next_corner_in_time(t)
    }

    fn longest_step(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &mode::Mode<C>) -> f64 {
        let mut longest = f64::INFINITY;
        if self.discs.iter().all(|disc| disc.driven.is_none()) {
            return longest;
        }
        for index in &self.between {
            let is_felt = |contact: &Option<Joined>| !contact.is_some_and(|contact| self.is_driven(&contact));
            if mode[*index] != SiteState::Active || is_felt(&self.contacts[*index]) {
                continue;
            }
            let posture = |finger| self.posture(finger, q);
            let Some((at, law, friction)) = self.asked_apart((q, v), &posture, *index) else { continue };
            longest = longest.min(DRIVEN_FRACTION * at.delta.max(law.transition_m) / at.rate.abs());
            if let Some(friction) = friction {
                let a = <Self as System<N, Z>>::rates(self, t, q, v, mode).a;
                longest = longest.min(DRIVEN_FRACTION * friction.v_static_m_s / along(&at.tangent, &a).abs());
            }
        }
        longest
    }

    #[inline(always)]
    fn watch(&self, q: &[f64; N], v: &[f64; N], mode: &mode::Mode<C>) -> Watch<N, G> {
        const { assert!(G == guards(C)) };
        let postures = self.postures(q);
        let mut guards = [Guard::QUIET; G];
        for index in 0..self.contacts.len() {
            if mode.is_left_alone(index) {
                continue;
            }
            let asked = self.asked((q, v), |finger| postures[finger], index);
            let Some((at, law, friction)) = asked else { continue };
            let press = Press::of(law, &at);
            guards[index] = mode.normal_guard(index, law, &self.landing, &at, &press);
            guards[index + 2 * C] = mode.damper_guard(index, law, &at);
            if let Some(friction) = friction {
                guards[index + C] = mode.slip_guard(index, friction, &at, &press);
            }
        }
        let (clearance, clearance_rate) = self.clearance(&postures, v);
        Watch { guards, clearance, clearance_rate }
    }

    #[inline(always)]
    fn glance(&self, q: &[f64; N], v: &[f64; N], mode: &mode::Mode<C>, guard: usize) -> Guard<N> {
        self.guard((q, v), |finger| self.posture(finger, q), mode, guard)
    }

    #[inline(always)]
    fn values(&self, q: &[f64; N], v: &[f64; N], mode: &mode::Mode<C>, wanted: &[bool; G]) -> [f64; G] {
        let postures = [const { OnceCell::new() }; FINGERS];
        let posture = |finger: usize| *postures[finger].get_or_init(|| self.posture(finger, q));
        let mut values = [f64::NAN; G];
        for guard in (0..G).filter(|guard| wanted[*guard]) {
            values[guard] = self.guard((q, v), posture, mode, guard).value;
        }
        values
    }

    fn landing_tolerance(&self, guard: usize, mode: &mode::Mode<C>) -> f64 {
        let contact = self.contacts.get(guard % C).and_then(|contact| contact.as_ref());
        let of = |at: &Joined| mode.landing_tolerance(guard, &at.normal, at.friction.as_ref(), &self.landing);
        contact.map_or(0.0, of)
    }

    fn switch(&self, guard: usize, q: &[f64; N], v: &[f64; N], mode: &mode::Mode<C>) -> mode::Mode<C> {
        let asked = self.asked_apart((q, v), &|finger| self.posture(finger, q), guard % C);
        asked.map_or(*mode, |(at, law, friction)| mode.switched(guard, law, friction, &at))
    }

    fn is_told(&self, guard: usize) -> bool {
        guard < C
    }

    fn relax(&self, guards: &[Guard<N>; G], mode: &mode::Mode<C>) -> Option<mode::Mode<C>> {
        mode.relaxed(guards)
    }

    fn with_natural(&self, guard: usize, mode: &mode::Mode<C>) -> mode::Mode<C> {
        mode.with_natural(guard)
    }

    fn read_mode(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> mode::Mode<C> {
        let at = |index: usize| self.asked_apart((q, v), &|finger| self.posture(finger, q), index);
        mode::Mode::read(&self.landing, at, |mode| <Self as System<N, Z>>::rates(self, t, q, v, mode).a)
    }

    fn restart_step(&self, guard: usize, q: &[f64; N], v: &[f64; N], mode: &mode::Mode<C>) -> Option<f64> {
        let index = guard % C;
        if mode[index] != SiteState::Active {
            return None;
        }
        let (at, law, _) = self.asked_apart((q, v), &|finger| self.posture(finger, q), index)?;
        let mobility = self.mobility(q, &at.row);
        // A fixed disc on a plane: nothing moves.
        (mobility > 0.0).then(|| first_step(law, at.rate.abs(), 1.0 / mobility))
    }

    fn obstacle(&self, q: &[f64; N]) -> String {
        let [right, left] = from_each(self.postures(q), |(pose, _)| cross(pose.e3, pose.e4).abs());
        let finger = match self.fingers.len() {
            0 => return "two discs have the same centre".to_string(),
            FINGERS if right > left || left.is_nan() => 1,
            _ => 0,
        };
        let part = &self.fingers[finger];
        let found = nearest_singularity(&part.model.dynamics.lengths, Self::own(finger, q));
        match self.fingers.len() {
            1 => format!("singular configuration: {found}"),
            _ => format!("singular configuration of the {} finger: {found}", part.side.word()),
        }
    }
}
