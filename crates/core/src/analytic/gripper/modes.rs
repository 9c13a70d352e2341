//! Where the branches of the contacts change.

use std::cell::OnceCell;

use super::contacts::Posture;
use super::coordinates::memory_of;
use super::model::GripperModel;
use super::{GUARDS, GripperMode, PLACES, QUADRATURES, TIME, first_step};
use crate::analytic::SiteState;
use crate::analytic::mode::{Contact, Landing, Press, along};
use crate::fivebar::dynamics::absolute_rates;
use crate::fivebar::kinematics::{SINGULAR_SINE, nearest_singularity};
use crate::integrator::{Guard, Hybrid, System, Watch};
use crate::numeric::plane::{cross, dot};
use crate::scene::{Place, Side};

/// As a finger's: far below anything that is felt.
const LANDING: Landing = Landing { depth_share: 1e-5, force: 1e-6 };

impl<const N: usize> GripperModel<N> {
    /// What a guard asks of a place; `None` where the scene has no such contact.
    #[inline(always)]
    fn contact(
        &self,
        (q, v): (&[f64; N], &[f64; N]),
        posture: impl FnOnce(Side) -> Posture,
        place: Place,
    ) -> Option<Contact<N>> {
        let touch = self.touch(q, posture, place)?;
        let (rate, slip) = (-along(&touch.normal_row, v), along(&touch.tangent_row, v));
        let (mut row, mut tangent) = (touch.normal_row, touch.tangent_row);
        // Nothing moves time.
        [&mut row, &mut tangent].into_iter().flat_map(|row| row.iter_mut().skip(TIME)).for_each(|part| *part = 0.0);
        let memory = memory_of(place).filter(|memory| *memory < N);
        memory.into_iter().for_each(|memory| tangent[memory] = 1.0);
        Some(Contact { delta: -touch.gap, rate, slip, memory: memory.map_or(0.0, |memory| v[memory]), row, tangent })
    }

    #[inline(always)]
    fn guards(&self, state: (&[f64; N], &[f64; N]), postures: &[Posture; 2], mode: &GripperMode) -> [Guard<N>; GUARDS] {
        let mut guards = [Guard::QUIET; GUARDS];
        for (index, place) in Place::ALL.into_iter().enumerate() {
            if mode.is_left_alone(index) {
                continue;
            }
            let at = self.contact(state, |side| postures[side as usize], place);
            let Some((at, law)) = at.zip(self.normal_law(place)) else { continue };
            let press = Press::of(law, &at);
            guards[index] = mode.normal_guard(index, law, &LANDING, &at, &press);
            guards[index + 2 * PLACES] = mode.damper_guard(index, law, &at);
            if let Some(friction) = self.friction_law(place) {
                guards[index + PLACES] = mode.slip_guard(index, friction, &at, &press);
            }
        }
        guards
    }

    /// One guard without its strain, and without the finger that it is not about.
    #[inline(always)]
    fn guard(
        &self,
        state: (&[f64; N], &[f64; N]),
        posture: impl FnOnce(Side) -> Posture,
        mode: &GripperMode,
        guard: usize,
    ) -> Guard<N> {
        let place = Place::ALL[guard % PLACES];
        let at = self.contact(state, posture, place).zip(self.normal_law(place));
        at.map_or(Guard::QUIET, |(at, law)| mode.guard(guard, (law, self.friction_law(place)), &LANDING, &at))
    }

    /// How easily a contact's surfaces part: row · M⁻¹ rowᵀ.
    fn mobility(&self, q: &[f64; N], row: &[f64; N]) -> f64 {
        along(row, &self.inverse(q).solve(row))
    }
}

impl<const N: usize> Hybrid<N, QUADRATURES, GUARDS> for GripperModel<N> {
    fn next_corner(&self, t: f64) -> f64 {
        self.next_corner_in_time(t)
    }

    #[inline(always)]
    fn watch(&self, q: &[f64; N], v: &[f64; N], mode: &GripperMode) -> Watch<N, GUARDS> {
        let postures = self.postures(q);
        let guards = self.guards((q, v), &postures, mode);
        let folds = Side::BOTH.map(|side| {
            let (pose, rates) = &postures[side as usize];
            let (sine, cosine) = (cross(pose.e3, pose.e4), dot(pose.e3, pose.e4));
            let [_, _, rate3, rate4] = absolute_rates(rates, Self::own(side, v));
            (sine.abs() - SINGULAR_SINE, sine.signum() * cosine * (rate4 - rate3))
        });
        // Written so that a clearance that is not a number is the smaller one.
        let (clearance, clearance_rate) =
            if folds[0].0 > folds[1].0 || folds[1].0.is_nan() { folds[1] } else { folds[0] };
        Watch { guards, clearance, clearance_rate }
    }

    #[inline(always)]
    fn glance(&self, q: &[f64; N], v: &[f64; N], mode: &GripperMode, guard: usize) -> Guard<N> {
        self.guard((q, v), |side| self.posture(side, q), mode, guard)
    }

    #[inline(always)]
    fn values(&self, q: &[f64; N], v: &[f64; N], mode: &GripperMode, wanted: &[bool; GUARDS]) -> [f64; GUARDS] {
        let postures = [OnceCell::new(), OnceCell::new()];
        let posture = |side: Side| *postures[side as usize].get_or_init(|| self.posture(side, q));
        std::array::from_fn(
            |guard| if wanted[guard] { self.guard((q, v), posture, mode, guard).value } else { f64::NAN },
        )
    }

    fn landing_tolerance(&self, guard: usize, mode: &GripperMode) -> f64 {
        let place = Place::ALL[guard % PLACES];
        let friction = self.friction_law(place);
        self.normal_law(place).map_or(0.0, |law| mode.landing_tolerance(guard, law, friction, &LANDING))
    }

    fn switch(&self, guard: usize, q: &[f64; N], v: &[f64; N], mode: &GripperMode) -> GripperMode {
        let place = Place::ALL[guard % PLACES];
        let at = self.contact((q, v), |side| self.posture(side, q), place).zip(self.normal_law(place));
        at.map_or(*mode, |(at, law)| mode.switched(guard, law, self.friction_law(place), &at))
    }

    fn is_told(&self, guard: usize) -> bool {
        guard < PLACES
    }

    fn relax(&self, guards: &[Guard<N>; GUARDS], mode: &GripperMode) -> Option<GripperMode> {
        mode.relaxed(guards)
    }

    fn with_natural(&self, guard: usize, mode: &GripperMode) -> GripperMode {
        mode.with_natural(guard)
    }

    fn read_mode(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> GripperMode {
        let postures = self.postures(q);
        let at = |index: usize| {
            let place = Place::ALL[index];
            let (at, law) = self.contact((q, v), |side| postures[side as usize], place).zip(self.normal_law(place))?;
            Some((at, law, self.friction_law(place)))
        };
        GripperMode::read(&LANDING, at, |mode| self.rates(t, q, v, mode).a)
    }

    fn restart_step(&self, guard: usize, q: &[f64; N], v: &[f64; N], mode: &GripperMode) -> Option<f64> {
        let place = guard % PLACES;
        if mode[place] != SiteState::Active {
            return None;
        }
        let place = Place::ALL[place];
        let (at, law) = self.contact((q, v), |side| self.posture(side, q), place).zip(self.normal_law(place))?;
        let mobility = self.mobility(q, &at.row);
        // A fixed object on a plane: nothing moves.
        (mobility > 0.0).then(|| first_step(law, at.rate.abs(), 1.0 / mobility))
    }

    fn obstacle(&self, q: &[f64; N]) -> String {
        let near = Side::BOTH.map(|side| {
            let (pose, _) = self.posture(side, q);
            cross(pose.e3, pose.e4).abs()
        });
        let side = if near[0] > near[1] || near[1].is_nan() { Side::Left } else { Side::Right };
        let lengths = &self.fingers[side as usize].dynamics.lengths;
        let found = nearest_singularity(lengths, Self::own(side, q));
        format!("singular configuration of the {} finger: {found}", side.word())
    }
}
