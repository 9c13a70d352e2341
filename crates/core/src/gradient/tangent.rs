//! The tangent equation: derivatives of a run of the analytic model with respect to parameters of its scene.
//!
//! The derivative S = ∂y/∂p of a state at a fixed time satisfies Ṡ = J S + ∂f/∂p. It is integrated along the steps of the
//! run by Radau IIA of order 5, with the exact Jacobians J of the kernel; steps are halved until the error of S is small.
//! At an event g = 0 its time changes by dt/dp = −(∂g/∂y S + ∂g/∂p)/ġ, and S jumps by (f⁻ − f⁺) dt/dp.
//!
//! Instead of S, the integration uses the derivative S + τ f at a time that moves by τ, with τ = dt/dp of the last event. It
//! is continuous at the event, satisfies the same equation (with τ ∂f/∂t), and contacts have nearly the same depth after a
//! touch-down that moves. τ is 0 in steps to the times at which derivatives are read.
//!
//! ∂f/∂p is the difference quotient of f along the tangent, between (y + h S, p + h) and (y − h S, p − h), minus J S. At
//! fixed y a stiff contact would be lost or deepened by the change of p alone; along the tangent its depth hardly
//! changes, so that h can be large and rounding is small.

use super::neighbours::{
    LEVELS, Level, Neighbours, QUOTIENT_TOLERANCE, TangentParameter, along, best_level, extrapolate,
};
use crate::integrator::{EventSet, Hybrid, Layout, Linearised, Rates, State, System, VectorOf};
use crate::numeric::elementary::powi;
use crate::trace::{ContactSample, Counts, Energy, Kernel, RequiredData, Sample, Schema, Start};

/// Largest relative change of the depth of an active contact in a difference quotient.
const MAX_DEPTH_CHANGE: f64 = 0.1;

/// A sample with the derivatives of its numbers by each parameter.
pub(super) type SampleDerivatives = (Sample, Vec<Result<Vec<f64>, String>>);

/// Derivatives of the time and of the numbers of the sample of an event by each parameter.
pub(super) type EventDerivatives = Vec<Result<(f64, Vec<f64>), String>>;

/// A tangent of the family of runs, along which difference quotients are taken.
pub(super) struct Direction<L: Layout> {
    /// Derivatives of the state at a time whose derivative is `dt`.
    pub tangent: State<L>,
    pub dt: f64,
    /// Level of the step of the difference quotients.
    pub level: usize,
}

/// Derivatives of a state; the reason why there are none.
pub(super) type Column<L> = Result<State<L>, String>;

/// Total derivatives of accelerations and quadrature rates, and the tangent of their difference quotients.
type Differentiated<L> = (Rates<L>, Direction<L>);

/// A state with its time and mode.
pub(super) type Instant<'a, M> = (f64, &'a State<<M as System>::Layout>, &'a <M as System>::Mode);

/// State of the tangent-linear integration between two steps.
pub(super) struct Tangent<'a, M: Kernel> {
    pub kernel: M,
    pub schema: &'a Schema,
    pub counts: Counts,
    /// Number of contacts of the model. They begin with the contacts of a sample; the others have no names.
    pub contacts: usize,
    pub start_energy: Energy,
    pub history: M::History,
    pub neighbours: Vec<Neighbours<'a, M>>,
    /// For each parameter, the derivatives of the state at a time whose derivative is given by `shifts`.
    pub columns: Vec<Column<M::Layout>>,
    pub shifts: Vec<f64>,
    /// For each parameter, the largest magnitudes so far of the derivatives of each coordinate and rate.
    pub scales: Vec<[VectorOf<M::Layout>; 2]>,
    pub mode: M::Mode,
    /// Time at the end of the last step, s.
    pub time_s: f64,
    /// State at the end of the last step.
    pub state: State<M::Layout>,
    /// Size of the last step, s.
    pub step_s: f64,
    /// Rates at the present time, if they may be needed; see [`Tangent::rates_before`].
    pub rates: Option<(Vec<f64>, Vec<f64>)>,
    /// Largest depth of each contact since its touch-down.
    pub deepest: Vec<f64>,
    /// Bounds of the interval of time in which the same piece of the functions of time applies to all neighbours.
    pub bounds_s: [f64; 2],
    /// Times of the last and of the next discontinuity of the right-hand side.
    pub discontinuities_s: [f64; 2],
    /// Rates just before a discontinuity at the present time.
    pub before_discontinuity: Option<Rates<M::Layout>>,
    /// Largest acceleration of a coordinate so far.
    pub acceleration_scale: f64,
    pub times: &'a [f64],
    pub at_times: Vec<SampleDerivatives>,
    pub events: Vec<(Sample, EventDerivatives)>,
}

impl<'a, M: Kernel + Hybrid> Tangent<'a, M> {
    pub fn new(start: &Start<M>, schema: &'a Schema, parameters: &'a [TangentParameter<'a>], times: &'a [f64]) -> Self {
        let (kernel, state, counts) = (start.kernel.clone(), start.state.clone(), schema.counts());
        let contacts = kernel.contact_count();
        let mode = kernel.mode_at(0.0, &state.q, &state.v);
        let (mut sample, mut history) = (Sample::new(0.0, counts), M::History::default());
        kernel.read((&state, &mode), &Energy::default(), RequiredData::EVALUATION, &mut history, &mut sample);
        let neighbours: Vec<Neighbours<'a, M>> = parameters
            .iter()
            .map(|parameter| Neighbours::new(*parameter, start.kernel.clone(), mode.clone()))
            .collect();
        let column = |neighbours: &Neighbours<'a, M>| -> Column<M::Layout> {
            let Level { pairs, h } = neighbours.level(0, counts)?;
            let quotient = |of: &dyn Fn(&State<M::Layout>) -> f64| {
                extrapolate([0, 1].map(|k| (of(&pairs[k][1].start) - of(&pairs[k][0].start)) / (2.0 * h[k])))
            };
            let mut column = State::zero(kernel.layout());
            for i in 0..kernel.layout().coordinates() {
                (column.q[i], column.v[i]) = (quotient(&|state| state.q[i]), quotient(&|state| state.v[i]));
            }
            Ok(column)
        };
        let columns = neighbours.iter().map(column).collect();
        let mut tangent = Self {
            start_energy: sample.energy(),
            scales: vec![[kernel.layout().vector(0.0), kernel.layout().vector(0.0)]; neighbours.len()],
            shifts: vec![0.0; neighbours.len()],
            kernel,
            schema,
            counts,
            contacts,
            history,
            neighbours,
            columns,
            mode,
            time_s: 0.0,
            state,
            step_s: 0.0,
            rates: None,
            deepest: vec![0.0; contacts],
            bounds_s: [f64::NEG_INFINITY, f64::INFINITY],
            discontinuities_s: [f64::NEG_INFINITY; 2],
            before_discontinuity: None,
            acceleration_scale: 0.0,
            times,
            at_times: Vec::new(),
            events: Vec::new(),
        };
        tangent.find_discontinuity(0.0);
        tangent
    }

    pub fn contact_name(&self, contact: usize) -> &str {
        let contacts = &self.schema.contacts;
        let of_sample = self.kernel.sample_contact(contact, contacts.len());
        of_sample.map_or("of a tendon", |contact| &contacts[contact].name)
    }

    /// Gives up all derivatives for a reason.
    pub fn refuse(&mut self, reason: &str) {
        for column in self.columns.iter_mut().filter(|column| column.is_ok()) {
            *column = Err(reason.to_string());
        }
    }

    /// Finds the next discontinuity of the right-hand side after time `t`, and its derivatives.
    pub fn find_discontinuity(&mut self, t: f64) {
        let after = t.max(self.bounds_s[0]);
        let next = self.kernel.next_discontinuity(t);
        self.discontinuities_s = [self.discontinuities_s[1], next];
        let mut before = next;
        for neighbours in &mut self.neighbours {
            let level = neighbours.level(0, self.counts);
            let moved = level.map_or(0.0, |Level { pairs, h }| {
                let times = pairs[0].each_ref().map(|neighbour| neighbour.kernel.next_discontinuity(after));
                before = before.min(times[0]).min(times[1]);
                (times[1] - times[0]) / (2.0 * h[0])
            });
            let moved = if moved.is_finite() { moved } else { 0.0 };
            neighbours.discontinuities = [neighbours.discontinuities[1], moved];
        }
        self.bounds_s[1] = before.next_down();
    }

    #[inline(never)]
    pub fn rates(kernel: &M, (t, state, mode): Instant<'_, M>) -> Rates<M::Layout> {
        let mut rates = Rates::zero(kernel.layout());
        kernel.rates(t, &state.q, &state.v, mode, &mut rates);
        rates
    }

    #[inline(never)]
    pub fn linearise(kernel: &M, (t, state, mode): Instant<'_, M>) -> Linearised<M::Layout> {
        let mut linearised = Linearised::zero(kernel.layout());
        kernel.linearise(t, &state.q, &state.v, mode, &mut linearised);
        linearised
    }

    /// Change of a time that stays in the same piece of the functions of time.
    fn room_s(&self, t: f64) -> f64 {
        (t - self.bounds_s[0]).min(self.bounds_s[1] - t)
    }

    /// All event functions of a state.
    pub fn events(&self, (state, mode): (&State<M::Layout>, &M::Mode)) -> EventSet<M::Layout> {
        let mut events = EventSet::new(self.kernel.layout(), self.kernel.event_count());
        self.kernel.eval_events(&state.q, &state.v, mode, &mut events);
        events
    }

    pub fn contact(&self, (_, state, mode): Instant<'_, M>, contact: usize) -> ContactSample {
        self.kernel.contact(state, contact, mode)
    }

    /// Returns the total derivatives of accelerations and quadrature rates; the derivatives of the state are those at a
    /// moving time. Also returns the tangent along which difference quotients are taken there.
    pub fn differentiate(
        &self,
        neighbours: &Neighbours<'a, M>,
        (t, state, mode): Instant<'_, M>,
        lin: &Linearised<M::Layout>,
        moving: (&State<M::Layout>, f64),
    ) -> Result<Differentiated<M::Layout>, String> {
        let (mut direction, change) = self.direction((t, state, mode), &lin.rates, neighbours, moving)?;
        let layout = self.kernel.layout();
        let (mut found, mut errors): ([_; LEVELS], _) =
            (std::array::from_fn(|_| Rates::zero(layout)), [f64::INFINITY; LEVELS]);
        for index in 0..LEVELS {
            let level = neighbours.level(index, self.counts)?;
            let is_too_large = change * level.h[0] > MAX_DEPTH_CHANGE && index + 1 < LEVELS;
            if is_too_large || level.h[0] * (direction.dt - moving.1).abs() > self.room_s(t) {
                continue;
            }
            let [full, half] = [0, 1].map(|k| {
                let rates = |side: usize, h: f64| {
                    let Direction { tangent, dt, .. } = &direction;
                    Self::rates(&level.pairs[k][side].kernel, (t + h * dt, &along(state, h, tangent), mode))
                };
                let (h, [below, above]) = (level.h[k], [rates(0, -level.h[k]), rates(1, level.h[k])]);
                combined(&above, &below, |above, below| (above - below) / (2.0 * h))
            });
            let largest = |of: &dyn Fn(usize) -> f64| {
                (0..layout.coordinates()).fold(0.0, |largest: f64, i| largest.max(of(i).abs()))
            };
            errors[index] = largest(&|i| half.a[i] - full.a[i]) / largest(&|i| half.a[i]).max(f64::MIN_POSITIVE);
            found[index] = combined(&full, &half, |full, half| extrapolate([full, half]));
            if errors[index] <= QUOTIENT_TOLERANCE {
                break;
            }
        }
        direction.level = best_level(&errors);
        let mut found = std::mem::replace(&mut found[direction.level], Rates::zero(layout));
        let dt = direction.dt - moving.1;
        if dt != 0.0 {
            let (v, a) = (state.v.as_ref(), lin.rates.a.as_ref());
            for i in 0..layout.coordinates() {
                let rate = product(&lin.a_q[i], v) + product(&lin.a_v[i], a) + lin.a_t[i];
                found.a[i] -= dt * rate;
            }
            for i in 0..layout.quadratures() {
                let rate = product(&lin.g_q[i], v) + product(&lin.g_v[i], a) + lin.g_t[i];
                found.g[i] -= dt * rate;
            }
        }
        Ok((found, direction))
    }

    /// Returns a tangent along which the depths of active contacts change little, and their largest relative change per
    /// change of the parameter: the given derivatives, or those at the time at which a contact has the same depth.
    fn direction(
        &self,
        (t, state, mode): Instant<'_, M>,
        rates: &Rates<M::Layout>,
        neighbours: &Neighbours<'a, M>,
        (column, shift): (&State<M::Layout>, f64),
    ) -> Result<(Direction<M::Layout>, f64), String> {
        let level = neighbours.level(0, self.counts)?;
        let contacts = (0..self.contacts).filter(|contact| mode[*contact].has_force()).map(|contact| {
            let reading = self.contact((t, state, mode), contact);
            let gap = |kernel: &M, _: f64, state: &State<M::Layout>| [kernel.contact(state, contact, mode).gap_m];
            let [_, [change]] = level.quotients((t, state), (column, shift), gap);
            [-reading.gap_m, -reading.gap_rate_m_s, -change]
        });
        let contacts: Vec<[f64; 3]> = contacts.collect();
        let change_of = |[depth, rate, change]: &[f64; 3], dt: f64| ((change + rate * dt) / depth).abs();
        let largest = |dt: f64| contacts.iter().map(|contact| change_of(contact, dt)).fold(0.0, f64::max);
        let worst = contacts.iter().max_by(|a, b| change_of(a, 0.0).total_cmp(&change_of(b, 0.0)));
        let aligned = worst.map_or(0.0, |[_, rate, change]| -change / rate);
        let is_better = largest(aligned) < 0.5 * largest(0.0);
        let smallest_h = level.h[0] * powi(0.1, LEVELS as i32 - 1);
        let is_inside = smallest_h * aligned.abs() <= self.room_s(t);
        let dt = if is_better && is_inside && largest(0.0) * level.h[0] > MAX_DEPTH_CHANGE { aligned } else { 0.0 };
        Ok((Direction { tangent: along(column, dt, &flow(state, rates)), dt: shift + dt, level: 0 }, largest(dt)))
    }
}

/// Time derivative of a state at these rates.
pub(super) fn flow<L: Layout>(state: &State<L>, rates: &Rates<L>) -> State<L> {
    State { q: state.v.clone(), v: rates.a.clone(), z: rates.g.clone() }
}

/// A function of each number of two rates.
fn combined<L: Layout>(first: &Rates<L>, second: &Rates<L>, of: impl Fn(f64, f64) -> f64) -> Rates<L> {
    let mut combined = first.clone();
    let combine = |numbers: &mut [f64], others: &[f64]| {
        numbers.iter_mut().zip(others).for_each(|(number, other)| *number = of(*number, *other));
    };
    combine(combined.a.as_mut(), second.a.as_ref());
    combine(combined.g.as_mut(), second.g.as_ref());
    combined
}

pub(super) fn product(row: &[f64], column: &[f64]) -> f64 {
    row.iter().zip(column).map(|(a, b)| a * b).sum()
}
