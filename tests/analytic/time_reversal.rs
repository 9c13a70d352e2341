//! Time reversal: a conservative swing that continues with reversed rates returns to its initial state.
//!
//! Without joint limit and object there is no dissipation: spring, constant torque and gravity are conservative.

use crate::support::runs::{experiment_95, reference_settings};
use phalanx::analytic::{EVENT_FUNCTIONS, Model, QUADRATURES};
use phalanx::integrator::{End, Method, Options, Radau5, Rodas5p, State, Tolerances, integrate};
use phalanx::scene::{Placement, Scene, Spring, SpringKind};

type SwingState = State<2, QUADRATURES>;

fn integrate_swing<K: Method<2, QUADRATURES>>(model: &Model, start: SwingState, span: f64) -> End<2, QUADRATURES> {
    let settings = reference_settings();
    let options = Options {
        tolerances: Tolerances {
            atol_q: settings.atol_angle_rad,
            atol_v: settings.atol_rate_rad_s,
            rtol_v: settings.rtol,
        },
        max_steps: settings.max_steps,
    };
    integrate::<2, QUADRATURES, EVENT_FUNCTIONS, _, K, _>(model, &options, 0.0, start, span, &mut ())
}

fn conservative_swings() -> Vec<(Scene, SwingState, f64)> {
    let mut scene = experiment_95();
    scene.finger_mut().limit = None;
    scene.system.discs.clear();
    let state = |q, v| State { q, v, z: [0.0; QUADRATURES] };
    let mut cases = vec![
        (scene.clone(), state([-0.3, 1.1], [0.0, 0.0]), 3e-3),
        (scene.clone(), state([-0.6, 0.9], [150.0, 100.0]), 2e-3),
    ];
    for placement in [Placement::GroundLinks, Placement::DrivenCoupler, Placement::CouplerDistal] {
        let kind = SpringKind::Torsional { stiffness_n_m_per_rad: 0.1, preload_rad: 1.0 };
        scene.finger_mut().spring = Some(Spring { kind, placement });
        cases.push((scene.clone(), state([-0.3, 1.1], [20.0, 10.0]), 3e-3));
    }
    cases
}

fn max_return_error<K: Method<2, QUADRATURES>>(name: &str) -> f64 {
    let mut max_error = 0.0f64;
    for (scene, start, span) in conservative_swings() {
        let model = Model::new(&scene.system);
        let forward_end = integrate_swing::<K>(&model, start, span);
        assert!(forward_end.result.is_ok(), "{name}: {:?}", forward_end.result);
        let moved = (forward_end.state.q[0] - start.q[0]).abs().max((forward_end.state.q[1] - start.q[1]).abs());
        assert!(moved > 0.1, "{name}: moved by only {moved} rad");
        let reversed = State { v: forward_end.state.v.map(|v| -v), ..forward_end.state };
        let backward = integrate_swing::<K>(&model, reversed, span);
        assert!(backward.result.is_ok(), "{name}: {:?}", backward.result);
        let angle = (0..2).map(|i| (backward.state.q[i] - start.q[i]).abs()).fold(0.0, f64::max);
        let rate = (0..2).map(|i| (backward.state.v[i] + start.v[i]).abs()).fold(0.0, f64::max);
        println!("{name}: moved {moved:.2} rad, back to {angle:.1e} rad, {rate:.1e} rad/s");
        // Over milliseconds, errors of rates are a thousand times those of angles.
        max_error = max_error.max(angle).max(1e-3 * rate);
    }
    max_error
}

#[test]
fn radau_iia_is_time_reversible() {
    assert!(max_return_error::<Radau5<2, QUADRATURES>>("Radau IIA") < 1e-10);
}

#[test]
fn rodas5p_is_time_reversible() {
    assert!(max_return_error::<Rodas5p<2, QUADRATURES>>("Rodas5P") < 1e-10);
}
