//! Events and discontinuities: how their times move, and how the derivatives of the state jump at them.

use super::neighbours::{Neighbours, along, extrapolate};
use super::tangent::{EventDerivatives, Instant, Tangent, flow};
use crate::analytic::ContactState;
use crate::integrator::{Hybrid, Rates, State, Step};
use crate::trace::Kernel;

/// Depth at which a contact is released, as a fraction of its largest one, below which it is released by separation.
const MIN_RELEASE_DEPTH: f64 = 1e-4;
/// Relative change of a parameter over which the time of an event must be linear in it; otherwise the event grazes.
const LINEAR_RANGE: f64 = 1e-6;
/// Jump of the accelerations that counts as a discontinuity, relative to the largest acceleration so far.
const MIN_JUMP: f64 = 1e-6;
/// The same without an event of a contact: ranges of friction with stiction overlap by 1e-7 of its limit, by which the force
/// jumps at their ends.
const MIN_SILENT_JUMP: f64 = 1e-5;

impl<'a, M: Kernel + Hybrid> Tangent<'a, M> {
    /// Changes to the mode of a step at its start, unless an event has already reported the change.
    pub fn enter(&mut self, step: &Step<M::Layout>, mode: &M::Mode) {
        let contacts = 0..self.contacts;
        if (&self.state.q, &self.state.v) != (&step.start.q, &step.start.v) {
            self.refuse(&format!("a contact that oscillates is set to its equilibrium at {} s", step.t0));
        }
        if let Some(contact) = contacts.clone().find(|contact| mode[*contact] == ContactState::Clamped) {
            let message = "chatters, and its force has a kink that is not located";
            self.refuse(&format!("the contact {} {message}, at {} s", self.contact_name(contact), step.t0));
        }
        self.pass_discontinuity(mode);
        if *mode == self.mode {
            return;
        }
        let rates = Self::rates(&self.kernel, (step.t0, step.start, &self.mode));
        let next = Self::rates(&self.kernel, (step.t0, step.start, mode));
        let opened: Vec<usize> =
            contacts.filter(|contact| is_touch_down(self.mode[*contact], mode[*contact])).collect();
        for contact in &opened {
            self.pass_event((step.t0, step.start), *contact, mode);
        }
        if opened.is_empty() && self.is_jump(rates.a.as_ref(), next.a.as_ref(), MIN_SILENT_JUMP) {
            self.refuse(&format!("the accelerations jump at {} s without an event of a contact", step.t0));
        }
        self.mode.clone_from(mode);
    }

    /// Passes an event of the normal law of a contact. Returns the derivatives of its time and its sample, and applies
    /// the jump to the derivatives of the state.
    pub fn pass_event(
        &mut self,
        (t, state): (f64, &State<M::Layout>),
        contact: usize,
        mode: &M::Mode,
    ) -> EventDerivatives {
        let before = (t, state, &self.mode.clone());
        let is_touch_down = is_touch_down(self.mode[contact], mode[contact]);
        let rates = Self::rates(&self.kernel, before);
        let jumps = is_touch_down && self.jumps_at_touch_down((t, state), contact, mode);
        let mut results = Vec::new();
        for index in 0..self.neighbours.len() {
            let neighbours = &self.neighbours[index];
            let shift = self.shifts[index];
            let moved = self.columns[index].clone().and_then(|column| {
                let dt = self.time_derivative(neighbours, before, (&rates, &column, shift), contact)?;
                Ok((dt, self.read_along(neighbours, before, (&column, shift), dt)))
            });
            match moved {
                Ok((dt, sample)) => {
                    self.shift(index, (state, &rates), dt);
                    results.push(sample.map(|sample| (dt, sample)));
                }
                Err(reason) => {
                    self.columns[index] = Err(reason.clone());
                    results.push(Err(reason));
                }
            }
        }
        if jumps {
            self.rates = None;
        }
        results
    }

    /// Passes a discontinuity of the right-hand side in time, at the present time; `mode` is the mode after it.
    pub fn pass_discontinuity(&mut self, mode: &M::Mode) {
        let Some(before) = self.before_discontinuity.take() else { return };
        let (t, state) = (self.time_s, self.state.clone());
        let after = Self::rates(&self.kernel, (t, &state, mode));
        self.pass_jump(&before, &after);
        let moved = |neighbours: &Neighbours<'a, M>| neighbours.parameter.step * neighbours.discontinuities[1].abs();
        let latest = t + self.neighbours.iter().map(moved).fold(0.0, f64::max);
        self.mode.clone_from(mode);
        self.bounds_s[0] = latest.next_up();
        self.find_discontinuity(t);
    }

    /// Derivative of the time of a step with respect to the parameter. Near a discontinuity in time, the step moves
    /// with it; otherwise, difference quotients would cross the discontinuity.
    pub fn shift_of_step(&self, index: usize, step: &Step<M::Layout>) -> f64 {
        let (neighbours, shift) = (&self.neighbours[index], self.shifts[index]);
        let ([last, next], [last_s, next_s]) = (neighbours.discontinuities, self.discontinuities_s);
        let reach = |discontinuity: f64| neighbours.parameter.step * (shift - discontinuity).abs();
        if step.t1 + reach(next) >= next_s {
            next
        } else if step.t0 - reach(last) < last_s {
            last
        } else {
            shift
        }
    }

    /// Changes the derivative of the time at which a column of derivatives is taken.
    pub fn shift(&mut self, index: usize, (state, rates): (&State<M::Layout>, &Rates<M::Layout>), shift: f64) {
        if shift == self.shifts[index] {
            return;
        }
        if let Ok(column) = &mut self.columns[index] {
            column.add_scaled(shift - self.shifts[index], &flow(state, rates));
        }
        self.shifts[index] = shift;
    }

    /// Passes a jump of the rates that moves with the next discontinuity in time.
    fn pass_jump(&mut self, before: &Rates<M::Layout>, after: &Rates<M::Layout>) {
        for (index, column) in self.columns.iter_mut().enumerate() {
            let dt = self.neighbours[index].discontinuities[1] - self.shifts[index];
            let Ok(column) = column else { continue };
            (0..column.v.as_ref().len()).for_each(|i| column.v[i] += (before.a[i] - after.a[i]) * dt);
            (0..column.z.as_ref().len()).for_each(|i| column.z[i] += (before.g[i] - after.g[i]) * dt);
        }
    }

    /// Whether the accelerations jump at a touch-down. The force just beyond it is extrapolated from two small depths.
    fn jumps_at_touch_down(&self, (t, state): (f64, &State<M::Layout>), contact: usize, mode: &M::Mode) -> bool {
        let reading = self.contact((t, state, mode), contact);
        let duration_s = (2.0 * reading.gap_m.abs()).max(1e-12) / reading.gap_rate_m_s.abs();
        let beyond = |factor: f64| {
            let mut state = state.clone();
            for i in 0..state.q.as_ref().len() {
                state.q[i] += (factor * duration_s) * state.v[i];
            }
            let [with, without] = [mode, &self.mode].map(|mode| Self::rates(&self.kernel, (t, &state, mode)));
            (with, without)
        };
        let ([near, without], [far, far_without]) = (<[_; 2]>::from(beyond(1.0)), <[_; 2]>::from(beyond(2.0)));
        let jump = |i: usize| 2.0 * (near.a[i] - without.a[i]) - (far.a[i] - far_without.a[i]);
        let with: Vec<f64> = (0..without.a.as_ref().len()).map(|i| without.a[i] + jump(i)).collect();
        self.is_jump(without.a.as_ref(), &with, MIN_JUMP)
    }

    fn is_jump(&self, before: &[f64], after: &[f64], least: f64) -> bool {
        let largest = before.iter().chain(after).fold(self.acceleration_scale, |largest, a| largest.max(a.abs()));
        before.iter().zip(after).any(|(before, after)| (before - after).abs() > least * largest)
    }

    /// dt/dp of an event of the normal law of a contact.
    fn time_derivative(
        &self,
        neighbours: &Neighbours<'a, M>,
        (t, state, mode): Instant<'_, M>,
        (rates, column, shift): (&Rates<M::Layout>, &State<M::Layout>, f64),
        contact: usize,
    ) -> Result<f64, String> {
        let level = neighbours.level(0, self.counts)?;
        let gap = |kernel: &M, _: f64, state: &State<M::Layout>| [kernel.contact(state, contact, mode).gap_m];
        let reading = self.contact((t, state, mode), contact);
        let [[full], [half]] = level.quotients((t, state), (column, shift), gap);
        let gap_derivative = extrapolate([full, half]);
        let flow = flow(state, rates);
        // The force of a contact without a damper ends at zero depth, located at a small force.
        let from_gap = shift - gap_derivative / reading.gap_rate_m_s;
        if mode[contact] == ContactState::Free || -reading.gap_m < MIN_RELEASE_DEPTH * self.deepest[contact] {
            let rate = reading.gap_rate_m_s;
            let h = 0.01 * self.step_s;
            let rate_at = |h: f64| self.contact((t, &along(state, h, &flow), mode), contact).gap_rate_m_s;
            let curvature = (rate_at(h) - rate_at(-h)) / (2.0 * h);
            let turning = 0.5 * rate * rate / curvature.abs().max(f64::MIN_POSITIVE);
            let parameter = &neighbours.parameter;
            let change = LINEAR_RANGE * parameter.value.abs().max(parameter.step);
            if turning < ((from_gap * rate) * change).abs() || rate == 0.0 {
                return Err(format!(
                    "the contact {} grazes at {t} s: its gap changes at {rate:.1e} m/s (limit: rad/s), and the time of the \
                     event is not linear in the parameter",
                    self.contact_name(contact)
                ));
            }
            return Ok(from_gap);
        }
        let lin = Self::linearise(&self.kernel, (t, state, mode));
        let (_, direction) = self.differentiate(neighbours, (t, state, mode), &lin, (column, shift))?;
        let force =
            |kernel: &M, _: f64, state: &State<M::Layout>| [kernel.eval_event(&state.q, &state.v, mode, contact).value];
        let level = neighbours.level(direction.level, self.counts)?;
        let [[full], [half]] = level.quotients((t, state), (&direction.tangent, direction.dt), force);
        // Along the direction, time moves by its own part.
        let derivative = direction.dt - extrapolate([full, half]) / self.rates_before(t)?.1[contact];
        match derivative.is_finite() {
            true => Ok(derivative),
            false => {
                Err(format!("the force of the contact {} does not cross zero at {t} s", self.contact_name(contact)))
            }
        }
    }
}

/// Whether a contact without a force begins to have one.
fn is_touch_down(before: ContactState, after: ContactState) -> bool {
    before == ContactState::Free && after.has_force()
}
