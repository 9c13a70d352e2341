//! Models beside a parameter, and difference quotients between them.

use std::any::Any;
use std::cell::OnceCell;

use crate::integrator::{Hybrid, Layout, State, System};
use crate::numeric::array_from;
use crate::numeric::elementary::powi;
use crate::scene::Scene;
use crate::trace::{Counts, Energy, Kernel, KernelUser, RequiredData, Sample, Start, with_kernel};

/// A parameter of a scene.
#[derive(Clone, Copy)]
pub(super) struct TangentParameter<'a> {
    /// Returns the scene for a value of the parameter.
    pub scene_at: &'a dyn Fn(f64) -> Result<Scene, String>,
    pub value: f64,
    /// Largest change of the parameter in difference quotients.
    pub step: f64,
}

/// Number of steps of difference quotients; each is a tenth of the one before.
pub(super) const LEVELS: usize = 6;
/// Relative difference of two difference quotients at which their extrapolation is accurate.
pub(super) const QUOTIENT_TOLERANCE: f64 = 1e-6;
/// Ratio of the errors of two levels up to which the larger step is taken, which has the smaller rounding errors.
const LEVEL_MARGIN: f64 = 10.0;

/// The kernel at one value of a parameter, and its start.
pub(super) struct Neighbour<M: System> {
    pub kernel: M,
    pub start: State<M::Layout>,
    pub start_energy: Energy,
}

/// Kernels at p ± h and p ± h/2, with the exact half differences of p.
pub(super) struct Level<M: System> {
    pub pairs: [[Neighbour<M>; 2]; 2],
    pub h: [f64; 2],
}

/// A parameter with its neighbours at decreasing steps, built when they are first used.
pub(super) struct Neighbours<'a, M: Kernel> {
    pub parameter: TangentParameter<'a>,
    /// Kernel at the start. The neighbours must have the same coordinates and mode.
    pub kernel: M,
    pub start_mode: M::Mode,
    pub levels: [OnceCell<Result<Level<M>, String>>; LEVELS],
    /// Derivatives of the times of the last and of the next discontinuity of the right-hand side.
    pub discontinuities: [f64; 2],
    /// Exchanges of coordinates so far, which neighbours built later repeat.
    exchanges: Vec<Exchange<M>>,
}

/// An exchange of coordinates: the kernel in the new ones, and state, mode and tangent in those before.
pub(super) struct Exchange<M: System> {
    pub kernel: M,
    pub state: State<M::Layout>,
    pub mode: M::Mode,
    pub tangent: State<M::Layout>,
}

impl<M: Kernel + Hybrid> Exchange<M> {
    /// Kernel and state of a neighbour, at a distance h of the parameter, in the new coordinates.
    fn of_neighbour(&self, kernel: &M, h: f64) -> Option<(M, State<M::Layout>)> {
        let state = along(&self.state, h, &self.tangent);
        let (kernel, state, _) = kernel.in_coordinates_of(&self.kernel, &state, &self.mode)?;
        Some((kernel, state))
    }
}

/// Takes the kernel of a scene in whatever type it has.
struct Erase;

impl KernelUser for Erase {
    type Output = Box<dyn Any>;

    fn use_kernel<M: Kernel + Hybrid>(self, start: Start<M>) -> Box<dyn Any> {
        Box::new((start.kernel, start.state))
    }
}

impl<'a, M: Kernel> Neighbours<'a, M> {
    pub fn new(parameter: TangentParameter<'a>, kernel: M, start_mode: M::Mode) -> Self {
        let levels = [const { OnceCell::new() }; LEVELS];
        Self { parameter, kernel, start_mode, levels, discontinuities: [0.0; 2], exchanges: Vec::new() }
    }

    /// Returns the neighbours of a level, whose index gives the step of the difference quotients.
    ///
    /// # Errors
    /// Returns the reason why there are none.
    pub fn level(&self, index: usize, counts: Counts) -> Result<&Level<M>, String>
    where
        M: Hybrid,
    {
        let built = self.levels[index].get_or_init(|| {
            let TangentParameter { scene_at, value, step } = self.parameter;
            let step = step * powi(0.1, index as i32);
            let neighbour = |value: f64| -> Result<Neighbour<M>, String> {
                let other = || format!("the structure of the model changes at a value of {value}");
                let erased = with_kernel(&scene_at(value)?, Erase).map_err(|error| error.to_string())?;
                let built = erased.downcast::<(M, State<M::Layout>)>().map_err(|_| other())?;
                let (kernel, start) = *built;
                let [own, others] = [self.kernel.layout(), kernel.layout()];
                let has_sizes = (own.coordinates(), own.quadratures()) == (others.coordinates(), others.quadratures());
                if !has_sizes || !kernel.has_coordinates_of(&self.kernel) {
                    return Err(other());
                }
                let start_mode = kernel.mode_at(0.0, &start.q, &start.v);
                if (0..counts.contacts)
                    .map(|contact| kernel.contact_index(contact))
                    .any(|index| start_mode[index] != self.start_mode[index])
                {
                    return Err(format!("a contact opens or closes at the start for a value of {value}"));
                }
                let mut sample = Sample::new(0.0, counts);
                let (none, mut history) = (Energy::default(), M::History::default());
                kernel.read((&start, &start_mode), &none, RequiredData::EVALUATION, &mut history, &mut sample);
                let start_energy = sample.energy();
                let exchanged = self.exchanges.iter().try_fold(kernel, |kernel, exchange| {
                    exchange.of_neighbour(&kernel, value - self.parameter.value).map(|(kernel, _)| kernel)
                });
                Ok(Neighbour { kernel: exchanged.ok_or_else(other)?, start, start_energy })
            };
            let pair = |h: f64| -> Result<_, String> {
                let [below, above] = [value - h, value + h];
                Ok(([neighbour(below)?, neighbour(above)?], 0.5 * (above - below)))
            };
            let ((full, h), (half, half_h)) = (pair(step)?, pair(0.5 * step)?);
            Ok(Level { pairs: [full, half], h: [h, half_h] })
        });
        built.as_ref().map_err(Clone::clone)
    }

    /// Continues in other coordinates; returns the tangent in these. Its derivative with respect to the parameter is a
    /// difference quotient along the tangent in the previous coordinates.
    ///
    /// # Errors
    /// Returns the reason why there is none.
    pub fn exchange(&mut self, exchange: Exchange<M>, counts: Counts) -> Result<State<M::Layout>, String>
    where
        M: Hybrid,
    {
        let (mut found, mut errors) = (vec![exchange.tangent.clone(); LEVELS], [f64::INFINITY; LEVELS]);
        for index in 0..LEVELS {
            let Level { pairs, h } = self.level(index, counts)?;
            let quotient = |k: usize| -> Option<State<M::Layout>> {
                let [(_, below), (_, above)] = [
                    exchange.of_neighbour(&pairs[k][0].kernel, -h[k])?,
                    exchange.of_neighbour(&pairs[k][1].kernel, h[k])?,
                ];
                let mut quotient = State::zero(exchange.kernel.layout());
                let scale = 1.0 / (2.0 * h[k]);
                quotient.add_scaled(scale, &above);
                quotient.add_scaled(-scale, &below);
                Some(quotient)
            };
            let none = || "the coordinates of the model cannot be exchanged beside the parameter".to_string();
            let [full, half] = [quotient(0).ok_or_else(none)?, quotient(1).ok_or_else(none)?];
            let tangent = &mut found[index];
            let (mut largest, mut error): (f64, f64) = (f64::MIN_POSITIVE, 0.0);
            for (of, full, half) in [(&mut tangent.q, &full.q, &half.q), (&mut tangent.v, &full.v, &half.v)] {
                for i in 0..exchange.kernel.layout().coordinates() {
                    of[i] = extrapolate([full[i], half[i]]);
                    (largest, error) = (largest.max(half[i].abs()), error.max((half[i] - full[i]).abs()));
                }
            }
            errors[index] = error / largest;
            if errors[index] <= QUOTIENT_TOLERANCE {
                break;
            }
        }
        let tangent = found.swap_remove(best_level(&errors));
        self.exchanges.push(exchange);
        self.levels = [const { OnceCell::new() }; LEVELS];
        Ok(tangent)
    }
}

impl<M: Kernel> Level<M> {
    /// Difference quotients at the full and at the half step of a level.
    pub fn quotients<const R: usize>(
        &self,
        (t, state): (f64, &State<M::Layout>),
        (direction, dt): (&State<M::Layout>, f64),
        f: impl Fn(&M, f64, &State<M::Layout>) -> [f64; R],
    ) -> [[f64; R]; 2] {
        [0, 1].map(|k| {
            let ([below, above], h) = (&self.pairs[k], self.h[k]);
            let below = f(&below.kernel, t - h * dt, &along(state, -h, direction));
            let above = f(&above.kernel, t + h * dt, &along(state, h, direction));
            array_from(|i| (above[i] - below[i]) / (2.0 * h))
        })
    }
}

/// y + h d.
pub(super) fn along<L: Layout>(y: &State<L>, h: f64, d: &State<L>) -> State<L> {
    let mut moved = y.clone();
    moved.add_scaled(h, d);
    moved
}

/// The first level whose quotients are about as accurate as any, from the relative differences of both quotients of each
/// level. Two quotients that are rounding errors may agree by chance, but their errors grow tenfold from level to level.
pub(super) fn best_level(errors: &[f64; LEVELS]) -> usize {
    let estimates: [f64; LEVELS] = array_from(|level| {
        let next = errors.get(level + 1).filter(|error| error.is_finite());
        errors[level].max(0.1 * next.copied().unwrap_or(0.0))
    });
    let smallest = estimates.iter().copied().fold(f64::INFINITY, f64::min);
    estimates.iter().position(|estimate| *estimate <= LEVEL_MARGIN * smallest).unwrap_or(0)
}

/// Extrapolates two difference quotients; the second one has half the step.
pub(super) fn extrapolate([full, half]: [f64; 2]) -> f64 {
    half + (half - full) / 3.0
}
