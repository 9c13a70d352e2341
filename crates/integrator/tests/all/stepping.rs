//! Integration with fixed steps, for tests of the methods alone.

use phalanx_integrator::{Dense, Method, State, StepStart, System, Tolerances};

/// Tight enough for Radau's Newton iteration to go down to rounding.
pub const TIGHT: Tolerances = Tolerances { atol_q: 1e-15, atol_v: 1e-15, rtol_v: 1e-15 };

/// Takes `count` steps of size `h` and passes the dense output of every step to `visit`.
pub fn march<K: Method<N, Z>, Y: System<N, Z>, const N: usize, const Z: usize>(
    system: &Y,
    mode: &Y::Mode,
    from: (f64, State<N, Z>),
    h: f64,
    count: usize,
    mut visit: impl FnMut(&Dense<N, Z>),
) -> State<N, Z> {
    let (t0, mut state) = from;
    let mut method = K::new();
    for i in 0..count {
        let t = t0 + i as f64 * h;
        let linearised = system.linearise(t, &state.q, &state.v, mode);
        let start_point = StepStart {
            system,
            mode,
            linearised: &linearised,
            tolerances: &TIGHT,
            t,
            latest_time: f64::INFINITY,
            state: &state,
        };
        let attempt = method.attempt(&start_point, h);
        assert!(!attempt.error.is_nan(), "a step of {h} failed at {t}");
        method.accept_step();
        visit(&method.dense());
        state = attempt.end;
    }
    state
}

/// Slopes of log error over log step size between successive halvings.
pub fn slopes(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect()
}
