//! Derivatives of the numbers of a sample, and their rates.

use super::neighbours::{Neighbour, Neighbours, along, extrapolate};
use super::tangent::{Column, Direction, Instant, Tangent};
use crate::integrator::{Hybrid, State, Step, StepTools};
use crate::trace::{Kernel, RequiredData, Sample};

/// Backward difference of order 4 for the rate at the end of a step, and its spacing as a fraction of the step.
const BACKWARD_WEIGHTS: [f64; 5] = [25.0 / 12.0, -4.0, 3.0, -4.0 / 3.0, 0.25];
const BACKWARD_STEP: f64 = 0.1;

impl<'a, M: Kernel + Hybrid> Tangent<'a, M> {
    pub fn sample(&self, (t, state, mode): Instant<'_, M>) -> Sample {
        let mut sample = Sample::new(t, self.counts);
        let mut history = self.history.clone();
        self.kernel.read((state, mode), &self.start_energy, RequiredData::ALL, &mut history, &mut sample);
        sample
    }

    /// Derivatives of the numbers of a sample whose time has the derivative `dt`.
    pub fn read_along(
        &self,
        neighbours: &Neighbours<'a, M>,
        (t, state, mode): Instant<'_, M>,
        moving: (&State<M::Layout>, f64),
        dt: f64,
    ) -> Result<Vec<f64>, String> {
        let lin = Self::linearise(&self.kernel, (t, state, mode));
        let (_, direction) = self.differentiate(neighbours, (t, state, mode), &lin, moving)?;
        let level = neighbours.level(direction.level, self.counts)?;
        let mut history = self.history.clone();
        let mut sample = Sample::new(t, self.counts);
        self.kernel.read((state, mode), &self.start_energy, RequiredData::ALL, &mut history, &mut sample);
        let read = |Neighbour { kernel, start_energy, .. }: &Neighbour<M>, h: f64| {
            let Direction { tangent, dt, .. } = &direction;
            let (state, mut sample) = (along(state, h, tangent), Sample::new(t + h * dt, self.counts));
            kernel.read((&state, mode), start_energy, RequiredData::ALL, &mut history.clone(), &mut sample);
            sample
        };
        let quotient = |[below, above]: [Sample; 2], h: f64| -> Vec<f64> {
            above.values().iter().zip(below.values()).map(|(above, below)| (above - below) / (2.0 * h)).collect()
        };
        let of_run: [Vec<f64>; 2] = [0, 1].map(|k| {
            let (pair, h) = (&level.pairs[k], level.h[k]);
            quotient([read(&pair[0], -h), read(&pair[1], h)], h)
        });
        let derivatives = of_run[0].iter().zip(&of_run[1]).map(|(full, half)| extrapolate([*full, *half]));
        let moved = dt - direction.dt;
        if moved == 0.0 {
            return Ok(derivatives.collect());
        }
        // The tangent moves in time by `direction.dt`; the rest is along the run itself.
        let rates = self.rates_before(t)?.0.iter();
        Ok(derivatives.zip(rates).map(|(derivative, rate)| derivative + moved * rate).collect())
    }

    /// Derivatives of the sample at the end of the last step.
    pub fn sample_derivatives(&self) -> Vec<Result<Vec<f64>, String>> {
        let at_end = (self.time_s, &self.state, &self.mode);
        let of_column = |((neighbours, column), shift): ((&Neighbours<'a, M>, &Column<M::Layout>), &f64)| {
            self.read_along(neighbours, at_end, (column.as_ref().map_err(Clone::clone)?, *shift), 0.0)
        };
        self.neighbours.iter().zip(&self.columns).zip(&self.shifts).map(of_column).collect()
    }

    /// Rates of the numbers of the sample and of the event functions of contacts, just before an event.
    pub fn rates_before(&self, t: f64) -> Result<&(Vec<f64>, Vec<f64>), String> {
        let found = self.rates.as_ref().filter(|_| t == self.time_s);
        found.ok_or_else(|| format!("an event at {t} s is not at the end of a step"))
    }

    /// Finds the rates at a fraction of a step. The rate of the force of a stiff damper is inaccurate if it is computed
    /// from the accelerations of a state, which are small differences of large forces.
    pub fn find_rates(
        &mut self,
        (step, mode): (&Step<M::Layout>, &M::Mode),
        to: f64,
        tools: &mut dyn StepTools<M::Layout>,
    ) {
        let (mut sums, mut event_sums) = (vec![0.0; self.counts.values()], vec![0.0; self.contacts]);
        for (index, weight) in BACKWARD_WEIGHTS.into_iter().enumerate() {
            let theta = to * (1.0 - BACKWARD_STEP * index as f64);
            let state = if theta < 1.0 { tools.resolve(theta).clone() } else { step.end.clone() };
            let sample = self.sample((step.t0 + theta * step.h, &state, mode));
            sums.iter_mut().zip(sample.values()).for_each(|(sum, value)| *sum += weight * value);
            let functions = self.events((&state, mode)).functions;
            event_sums.iter_mut().zip(functions).for_each(|(sum, function)| *sum += weight * function.value);
        }
        let scale = 1.0 / (BACKWARD_STEP * to * step.h);
        sums.iter_mut().chain(&mut event_sums).for_each(|sum| *sum *= scale);
        self.rates = Some((sums, event_sums));
    }
}
