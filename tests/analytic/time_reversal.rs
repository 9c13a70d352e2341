//! Time reversal: a conservative swing, run forward and then with its rates flipped, returns to where it came from.
//!
//! Without joint limit and object, nothing dissipates: constant spring, constant torque and gravity are all potentials.

use crate::support::runs::{anchor, reference};
use phalanx::analytic::{GUARDS, Model, QUADRATURES};
use phalanx::integrator::{End, Method, Options, Radau5, Rodas5p, State, Tolerances, integrate};
use phalanx::scene::{Placement, Scene, Spring, SpringKind};

type Point = State<2, QUADRATURES>;

fn swing<K: Method<2, QUADRATURES>>(model: &Model, start: Point, span: f64) -> End<2, QUADRATURES> {
    let settings = reference();
    let options = Options {
        tolerances: Tolerances {
            atol_q: settings.atol_angle_rad,
            atol_v: settings.atol_rate_rad_s,
            rtol_v: settings.rtol,
        },
        max_steps: settings.max_steps,
    };
    integrate::<2, QUADRATURES, GUARDS, _, K, _>(model, &options, 0.0, start, span, &mut ())
}

fn conservative() -> Vec<(Scene, Point, f64)> {
    let mut scene = anchor();
    scene.finger_mut().limit = None;
    scene.system.discs.clear();
    let at = |q, v| State { q, v, z: [0.0; QUADRATURES] };
    let mut cases = vec![
        (scene.clone(), at([-0.3, 1.1], [0.0, 0.0]), 3e-3),
        (scene.clone(), at([-0.6, 0.9], [150.0, 100.0]), 2e-3),
    ];
    for placement in [Placement::GroundLinks, Placement::DrivenCoupler, Placement::CouplerDistal] {
        let kind = SpringKind::Torsional { stiffness_n_m_per_rad: 0.1, preload_rad: 1.0 };
        scene.finger_mut().spring = Some(Spring { kind, placement });
        cases.push((scene.clone(), at([-0.3, 1.1], [20.0, 10.0]), 3e-3));
    }
    cases
}

fn worst_return<K: Method<2, QUADRATURES>>(name: &str) -> f64 {
    let mut worst = 0.0f64;
    for (scene, start, span) in conservative() {
        let model = Model::new(&scene.system);
        let there = swing::<K>(&model, start, span);
        assert!(there.result.is_ok(), "{name}: {:?}", there.result);
        let moved = (there.state.q[0] - start.q[0]).abs().max((there.state.q[1] - start.q[1]).abs());
        assert!(moved > 0.1, "{name}: hardly moved, {moved}");
        let flipped = State { v: there.state.v.map(|v| -v), ..there.state };
        let back = swing::<K>(&model, flipped, span);
        assert!(back.result.is_ok(), "{name}: {:?}", back.result);
        let angle = (0..2).map(|i| (back.state.q[i] - start.q[i]).abs()).fold(0.0, f64::max);
        let rate = (0..2).map(|i| (back.state.v[i] + start.v[i]).abs()).fold(0.0, f64::max);
        println!("{name}: moved {moved:.2} rad, back to {angle:.1e} rad, {rate:.1e} rad/s");
        // Rates are a thousand times the angles over milliseconds.
        worst = worst.max(angle).max(1e-3 * rate);
    }
    worst
}

#[test]
fn radau_iia_returns() {
    assert!(worst_return::<Radau5<2, QUADRATURES>>("Radau IIA") < 1e-10);
}

#[test]
fn rodas5p_returns() {
    assert!(worst_return::<Rodas5p<2, QUADRATURES>>("Rodas5P") < 1e-10);
}
