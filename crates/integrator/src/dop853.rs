//! DOP853: explicit, order 8, with error estimates of orders 5 and 3 and dense output of order 7, for phases that are not
//! stiff. Coefficients: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., II.5 and
//! II.6.

use super::layout::{Layout, VectorOf, add_weighted, copy};
use super::linear::dot;
use super::method::{Attempt, Method, Refinement, StepStart};
use super::state::DENSE_TERMS;
use super::{Dense, Linearised, Rates, State, System};
use crate::numeric::array_from;

/// Number of stages: those of the method, the end of the step, and three of dense output.
const STAGES: usize = 16;
/// Index of the stage at the end of the step.
const END: usize = 12;
/// Fraction of the step at which the defect of dense output is measured.
const DEFECT_AT: f64 = 0.5;
/// Largest accepted defect, relative to the tolerances. The error estimate of a system with one degree of freedom has zeros, and
/// without this bound the step after one may be too long by far: of a four-bar's 212 steps, 90 % have a defect below 1, and
/// the one that ruins the run has 4e4.
const MAX_DEFECT: f64 = 4.0;
/// Largest |h λ| that does not count as stiff. The method becomes unstable at 6.1 (Hairer's code); steps of implicit methods are
/// longer before.
const MAX_STIFFNESS: f64 = 4.0;

/// DOP853 with the stages of its last attempt, for dense output; it has no other history.
#[derive(Clone)]
pub struct Dop853<L: Layout> {
    h: f64,
    /// Derivatives of coordinates, rates and quadratures at the stages.
    k: [State<L>; STAGES],
    rates: Rates<L>,
    /// State of a stage.
    stage: State<L>,
    /// Dense output, and memory for its derivative.
    dense: Dense<L>,
    slope: State<L>,
    /// Largest |h λ| of the last attempt, estimated from its last two stages.
    stiffness: f64,
}

impl<L: Layout> Dop853<L> {
    /// Whether the last attempt was stiff.
    pub fn is_stiff(&self) -> bool {
        // A value that is not a number counts as stiff.
        self.stiffness.is_nan() || self.stiffness >= MAX_STIFFNESS
    }

    /// Writes the state of stage `i`, whose derivatives at earlier stages are known.
    #[inline(always)]
    fn write_stage(&mut self, i: usize, from: &State<L>, of_q: usize) {
        let Self { h, k, stage: State { q, v, .. }, .. } = self;
        let weights: [f64; STAGES] = std::array::from_fn(|j| A[i].get(j).map_or(0.0, |weight| *h * weight));
        copy(q, &from.q);
        copy(v, &from.v);
        add_weighted(&mut q.as_mut()[..of_q], &weights[..A[i].len()], &k[..], |k| k.q.as_ref());
        add_weighted(v.as_mut(), &weights[..A[i].len()], &k[..], |k| k.v.as_ref());
    }

    /// Evaluates the right-hand side of stage `i` in its state.
    #[inline(always)]
    fn evaluate_stage<Y: System<Layout = L>>(&mut self, i: usize, origin: &StepStart<Y>, of_q: usize) {
        let Self { h, k, rates, stage: State { q, v, .. }, .. } = self;
        let time = (origin.t + NODES[i] * *h).min(origin.latest_time);
        origin.system.rates(time, q, v, origin.mode, rates);
        k[i].q.as_mut()[..of_q].copy_from_slice(&v.as_ref()[..of_q]);
        copy(&mut k[i].v, &rates.a);
        copy(&mut k[i].z, &rates.g);
    }

    /// |h λ| from the change of the derivatives between two states at the end of the step.
    fn measure_stiffness(&self, before_end: &State<L>) -> f64 {
        let [end, before] = [&self.k[END], &self.k[END - 1]];
        let squared = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        let of_derivatives = squared(end.q.as_ref(), before.q.as_ref()) + squared(end.v.as_ref(), before.v.as_ref());
        let of_states = squared(self.stage.q.as_ref(), before_end.q.as_ref())
            + squared(self.stage.v.as_ref(), before_end.v.as_ref());
        if of_states > 0.0 { self.h * (of_derivatives / of_states).sqrt() } else { 0.0 }
    }
}

impl<L: Layout> Method<L> for Dop853<L> {
    fn new(layout: L) -> Self {
        let zero = || State::zero(layout);
        Self {
            h: 0.0,
            k: std::array::from_fn(|_| zero()),
            rates: Rates::zero(layout),
            stage: zero(),
            dense: Dense::new(layout),
            slope: zero(),
            stiffness: 0.0,
        }
    }

    fn error_order(&self) -> f64 {
        8.0
    }

    fn restart(&mut self) {}

    fn accept_step(&mut self) {}

    fn follow(&mut self, _: &Self) {}

    fn attempt<Y: System<Layout = L>>(&mut self, origin: &StepStart<Y>, h: f64, attempt: &mut Attempt<L>) {
        let StepStart { system, linearised, tolerances, t, state: from, .. } = *origin;
        self.h = h;
        // Coordinates of first-order states stay at 0.
        let (of_q, count) = (system.second_order_count(), system.coordinate_count());
        self.k[0].q.as_mut()[..of_q].copy_from_slice(&from.v.as_ref()[..of_q]);
        copy(&mut self.k[0].v, &linearised.rates.a);
        copy(&mut self.k[0].z, &linearised.rates.g);
        for i in 1..END {
            self.write_stage(i, from, of_q);
            self.evaluate_stage(i, origin, of_q);
        }
        // The derivative of dense output is memory for the state of the last stage but one.
        self.slope.copy_from(&self.stage);
        self.write_stage(END, from, of_q);
        let Attempt { end, error_q, error_v, .. } = &mut *attempt;
        let mut norms = [0.0; 2];
        for (norm, weights) in norms.iter_mut().zip(&E).rev() {
            let weights = weights.map(|weight| h * weight);
            error_q.as_mut().fill(0.0);
            error_v.as_mut().fill(0.0);
            add_weighted(&mut error_q.as_mut()[..of_q], &weights[..], &self.k[..], |k| k.q.as_ref());
            add_weighted(error_v.as_mut(), &weights[..], &self.k[..], |k| k.v.as_ref());
            *norm = tolerances.norm((error_q, error_v), (from, &self.stage), count);
        }
        // The estimate of order 5 times its ratio to both behaves like one of order 8.
        let [fifth, third] = norms;
        let ratio = if fifth > 0.0 { fifth / (fifth * fifth + 0.01 * third * third).sqrt() } else { 0.0 };
        error_q.as_mut().iter_mut().chain(error_v.as_mut()).for_each(|error| *error *= ratio);
        copy(&mut end.q, &self.stage.q);
        copy(&mut end.v, &self.stage.v);
        copy(&mut end.z, &from.z);
        let weights: [f64; END] = std::array::from_fn(|j| h * A[END][j]);
        add_weighted(end.z.as_mut(), &weights[..], &self.k[..], |k| k.z.as_ref());
        attempt.rhs = END as u64 - 1;
        attempt.error = if attempt.end.is_finite() { ratio * fifth } else { f64::NAN };
        if !attempt.is_acceptable() {
            return;
        }
        self.evaluate_stage(END, origin, of_q);
        self.stiffness = self.measure_stiffness(&self.slope);
        for i in END + 1..STAGES {
            self.write_stage(i, from, of_q);
            self.evaluate_stage(i, origin, of_q);
        }
        self.write_dense(t, [from, &attempt.end]);
        let defect = self.defect(origin, attempt, of_q, count);
        attempt.error = attempt.error.max(defect / MAX_DEFECT);
        attempt.rhs = STAGES as u64;
    }

    /// The dense output itself: equations that are not stiff have accurate forces there.
    fn refine<Y: System<Layout = L>>(
        &self,
        _origin: &StepStart<Y>,
        dense: &Dense<L>,
        theta: f64,
        refinement: &mut Refinement<L>,
    ) -> bool {
        dense.write(theta, &mut refinement.state);
        true
    }

    fn dense(&self, _: Option<&Linearised<L>>, dense: &mut Dense<L>) {
        dense.copy_from(&self.dense);
    }

    fn dense_positions(&self, d: &mut [VectorOf<L>; DENSE_TERMS]) -> usize {
        d.iter_mut().zip(&self.dense.d).for_each(|(to, from)| copy(to, &from.q));
        DENSE_TERMS
    }
}

impl<L: Layout> Dop853<L> {
    /// Writes the dense output of the last attempt. Hairer's form of it has alternate factors Θ and 1 − Θ.
    fn write_dense(&mut self, t0: f64, [start, end]: [&State<L>; 2]) {
        let Self { h, k, dense, .. } = self;
        (dense.t0, dense.h, dense.terms) = (t0, *h, DENSE_TERMS);
        dense.start.copy_from(start);
        dense.end.copy_from(end);
        let write = |[start, end]: [&[f64]; 2], k: [&[f64]; STAGES], mut d: [&mut [f64]; DENSE_TERMS]| {
            for n in 0..start.len() {
                let k: [f64; STAGES] = array_from(|i| k[i][n]);
                let change = end[n] - start[n];
                let f1 = *h * k[0] - change;
                let f2 = 2.0 * change - *h * (k[0] + k[END]);
                let [f3, f4, f5, f6] = [0, 1, 2, 3].map(|i| *h * dot(&D[i], &k));
                let terms = [f1, f2 + f3, f4 + f5 - f3, f6 - f4 - 2.0 * f5, f5 - 2.0 * f6, f6];
                d.iter_mut().zip(terms).for_each(|(d, term)| d[n] = term);
            }
        };
        let d = &mut dense.d;
        write([start.q.as_ref(), end.q.as_ref()], array_from(|i| k[i].q.as_ref()), d.each_mut().map(|d| d.q.as_mut()));
        write([start.v.as_ref(), end.v.as_ref()], array_from(|i| k[i].v.as_ref()), d.each_mut().map(|d| d.v.as_mut()));
        write([start.z.as_ref(), end.z.as_ref()], array_from(|i| k[i].z.as_ref()), d.each_mut().map(|d| d.z.as_mut()));
    }

    /// Norm of the defect of the dense output inside the step, times the step: the difference of its derivative and the
    /// right-hand side.
    fn defect<Y: System<Layout = L>>(
        &mut self,
        origin: &StepStart<Y>,
        attempt: &mut Attempt<L>,
        of_q: usize,
        count: usize,
    ) -> f64 {
        let Self { h, dense, rates, stage, slope, .. } = self;
        dense.motion(DEFECT_AT, &mut stage.q, &mut stage.v);
        dense.derivative(DEFECT_AT, slope);
        let time = (origin.t + DEFECT_AT * *h).min(origin.latest_time);
        origin.system.rates(time, &stage.q, &stage.v, origin.mode, rates);
        for n in 0..count {
            slope.q[n] = if n < of_q { *h * (slope.q[n] - stage.v[n]) } else { 0.0 };
            slope.v[n] = *h * (slope.v[n] - rates.a[n]);
        }
        origin.tolerances.norm((&slope.q, &slope.v), (origin.state, &attempt.end), count)
    }
}

/// Nodes cᵢ.
#[rustfmt::skip]
const NODES: [f64; STAGES] = [
    0.0, 0.05260015195876773, 0.0789002279381516, 0.1183503419072274, 0.2816496580927726, 0.3333333333333333, 0.25, 0.3076923076923077, 0.6512820512820513, 0.6, 0.8571428571428571, 1.0, 1.0, 0.1, 0.2, 0.7777777777777778,
];

/// Weights aᵢⱼ of the stages before; row 12 has those of the result.
#[rustfmt::skip]
const A: [&[f64]; STAGES] = [
    &[],
    &[0.05260015195876773],
    &[0.0197250569845379, 0.0591751709536137],
    &[0.02958758547680685, 0.0, 0.08876275643042054],
    &[0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792],
    &[0.037037037037037035, 0.0, 0.0, 0.17082860872947386, 0.12546768756682242],
    &[0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596, -0.017578125],
    &[0.03709200011850479, 0.0, 0.0, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402, 0.008273789163814023],
    &[0.6241109587160757, 0.0, 0.0, -3.3608926294469414, -0.868219346841726, 27.59209969944671, 20.154067550477894, -43.48988418106996],
    &[0.47766253643826434, 0.0, 0.0, -2.4881146199716677, -0.590290826836843, 21.230051448181193, 15.279233632882423, -33.28821096898486, -0.020331201708508627],
    &[-0.9371424300859873, 0.0, 0.0, 5.186372428844064, 1.0914373489967295, -8.149787010746927, -18.52006565999696, 22.739487099350505, 2.4936055526796523, -3.0467644718982196],
    &[2.273310147516538, 0.0, 0.0, -10.53449546673725, -2.0008720582248625, -17.9589318631188, 27.94888452941996, -2.8589982771350235, -8.87285693353063, 12.360567175794303, 0.6433927460157636],
    &[0.054293734116568765, 0.0, 0.0, 0.0, 0.0, 4.450312892752409, 1.8915178993145003, -5.801203960010585, 0.3111643669578199, -0.1521609496625161, 0.20136540080403034, 0.04471061572777259],
    &[0.056167502283047954, 0.0, 0.0, 0.0, 0.0, 0.0, 0.25350021021662483, -0.2462390374708025, -0.12419142326381637, 0.15329179827876568, 0.00820105229563469, 0.007567897660545699, -0.008298],
    &[0.03183464816350214, 0.0, 0.0, 0.0, 0.0, 0.028300909672366776, 0.053541988307438566, -0.05492374857139099, 0.0, 0.0, -0.00010834732869724932, 0.0003825710908356584, -0.00034046500868740456, 0.1413124436746325],
    &[-0.42889630158379194, 0.0, 0.0, 0.0, 0.0, -4.697621415361164, 7.683421196062599, 4.06898981839711, 0.3567271874552811, 0.0, 0.0, 0.0, -0.0013990241651590145, 2.9475147891527724, -9.15095847217987],
];

/// Weights of the error estimates of orders 5 and 3.
#[rustfmt::skip]
const E: [[f64; 12]; 2] = [
    [0.01312004499419488, 0.0, 0.0, 0.0, 0.0, -1.2251564463762044, -0.4957589496572502, 1.6643771824549864, -0.35032884874997366, 0.3341791187130175, 0.08192320648511571, -0.022355307863886294],
    [-0.18980075407240762, 0.0, 0.0, 0.0, 0.0, 4.450312892752409, 1.8915178993145003, -5.801203960010585, -0.4226823213237919, -0.1521609496625161, 0.20136540080403034, 0.02265179219836082],
];

/// Weights of the last four terms of dense output, in the form of Hairer's code.
#[rustfmt::skip]
const D: [[f64; STAGES]; 4] = [
    [-8.428938276109013, 0.0, 0.0, 0.0, 0.0, 0.5667149535193777, -3.0689499459498917, 2.38466765651207, 2.117034582445028, -0.871391583777973, 2.2404374302607883, 0.6315787787694688, -0.08899033645133331, 18.148505520854727, -9.194632392478356, -4.436036387594894],
    [10.427508642579134, 0.0, 0.0, 0.0, 0.0, 242.28349177525817, 165.20045171727028, -374.5467547226902, -22.113666853125306, 7.733432668472264, -30.674084731089398, -9.332130526430229, 15.697238121770845, -31.139403219565178, -9.35292435884448, 35.81684148639408],
    [19.985053242002433, 0.0, 0.0, 0.0, 0.0, -387.0373087493518, -189.17813819516758, 527.8081592054236, -11.57390253995963, 6.8812326946963, -1.0006050966910838, 0.7777137798053443, -2.778205752353508, -60.19669523126412, 84.32040550667716, 11.99229113618279],
    [-25.69393346270375, 0.0, 0.0, 0.0, 0.0, -154.18974869023643, -231.5293791760455, 357.6391179106141, 93.40532418362432, -37.45832313645163, 104.0996495089623, 29.8402934266605, -43.53345659001114, 96.32455395918828, -39.17726167561544, -149.72683625798564],
];
