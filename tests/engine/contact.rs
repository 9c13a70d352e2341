//! Contact space and contact solver of the engine, against dense algebra and closed forms.

use crate::support::laws::{THESIS_FRICTION, THESIS_NORMAL};
use crate::support::runs::{Random, assert_relative, experiment_95};
use nalgebra::{DMatrix, DVector};
use phalanx::engine::{self, ContactSolver, Linkage, Motion, Plan, Row, Twist};
use phalanx::law::{ContactLaw, FrictionKind, FrictionLaw, NormalLaw};
use phalanx::scene::{Scene, Stepping};
use phalanx::trace::FingerContact;

fn motion(scene: &Scene, plan: &Plan) -> Motion {
    let settings = &scene.engine;
    let world = engine::build_world(plan, settings.response, settings.iterations);
    Motion::new(plan.clone(), world).expect("a world")
}

/// Returns M⁻¹ of all bodies, and the constraint Jacobian J of the five pins of the finger.
fn masses_and_joints(plan: &Plan, linkage: &Linkage) -> (DMatrix<f64>, DMatrix<f64>) {
    let count = plan.bodies.len();
    let diagonal: Vec<f64> =
        linkage.inertias.iter().flat_map(|i| [i.inverse_mass, i.inverse_mass, i.inverse_inertia]).collect();
    let inverse_mass = DMatrix::from_diagonal(&DVector::from_vec(diagonal));
    let mut joints = DMatrix::zeros(2 * plan.joints.len(), 3 * count);
    for (p, joint) in plan.joints.iter().enumerate() {
        let mut add = |body: usize, anchor: [f64; 2], sign: f64| {
            let com = plan.bodies[body].body.com_m;
            let [c, s] = linkage.poses[body].direction;
            let local = [anchor[0] - com[0], anchor[1] - com[1]];
            let arm = [c * local[0] - s * local[1], s * local[0] + c * local[1]];
            joints[(2 * p, 3 * body)] = sign;
            joints[(2 * p + 1, 3 * body + 1)] = sign;
            joints[(2 * p, 3 * body + 2)] = -sign * arm[1];
            joints[(2 * p + 1, 3 * body + 2)] = sign * arm[0];
        };
        for (k, sign) in [-1.0, 1.0].into_iter().enumerate() {
            if let Some(body) = joint.bodies[k] {
                add(body, joint.anchors_m[k], sign);
            }
        }
    }
    (inverse_mass, joints)
}

fn row_as_vector(row: &Row, bodies: usize) -> DVector<f64> {
    let mut impulse: Vec<Twist> = vec![[0.0; 3]; bodies];
    row.add_to(&mut impulse, 1.0);
    DVector::from_vec(impulse.into_iter().flatten().collect())
}

/// W = C (M⁻¹ − M⁻¹ Jᵀ (J M⁻¹ Jᵀ)⁻¹ J M⁻¹) Cᵀ, computed by the dense algebra of another library.
#[test]
fn contact_space_inverse_inertia_matches_dense_algebra() {
    let scene = experiment_95();
    let plan = engine::build_plan(&scene).unwrap();
    let mut motion = motion(&scene, &plan);
    // A step of this length activates all contacts: the limit, and both phalanges with friction.
    for _ in 0..3 {
        motion.advance(2e-3, &|| true).unwrap();
    }
    assert_eq!(motion.space.len(), 5);
    // The contact space describes the start of the step; assemble it again at the current poses.
    let Motion { world, linkage, candidates, velocities, accelerations, space, .. } = &mut motion;
    space.assemble(world, &plan, linkage, (candidates, &[], &[]), velocities, accelerations, 2e-3, &|| true);
    let (inverse_mass, joints) = masses_and_joints(&plan, linkage);
    let bodies = plan.bodies.len();
    let rows: Vec<DVector<f64>> = space.rows.iter().map(|row| row_as_vector(row, bodies)).collect();
    let rows = DMatrix::from_columns(&rows);
    let joint_response = (&joints * &inverse_mass * joints.transpose()).try_inverse().expect("independent joints");
    let constrained_inverse_mass =
        &inverse_mass - &inverse_mass * joints.transpose() * joint_response * &joints * &inverse_mass;
    let expected = rows.transpose() * constrained_inverse_mass * &rows;
    let actual = DMatrix::from_row_slice(space.len(), space.len(), &space.w);
    assert!((&actual - &expected).amax() <= 1e-9 * expected.amax(), "{actual} {expected}");
    assert!(actual.diagonal().min() > 0.0);
}

/// A contact space with one contact and a constant mass instead of bodies.
fn single_contact_space(law: ContactLaw, mass: f64, gap: f64, rate: f64, slip: f64) -> engine::ContactSpace {
    let scene = experiment_95();
    let plan = engine::build_plan(&scene).unwrap();
    let motion = motion(&scene, &plan);
    let mut candidate = motion
        .candidates
        .iter()
        .find(|candidate| plan.contact_channel(candidate.index) == Some(FingerContact::Proximal as usize))
        .unwrap()
        .clone();
    (candidate.gap, candidate.law, candidate.friction) = (gap, law.normal, law.friction);
    let rows = 1 + usize::from(law.friction.is_some());
    let mut space = engine::ContactSpace::default();
    space.rows = vec![candidate.normal_row.clone(); rows];
    space.active_contacts.push(engine::ActiveContact {
        candidate,
        normal: 0,
        tangent: law.friction.map(|_| 1),
        rolling: None,
        friction_state: 0.0,
        current: 0.0,
        cable: None,
    });
    space.coupled = rows;
    space.w = vec![0.0; rows * rows];
    (0..rows).for_each(|i| space.w[i * rows + i] = 1.0 / mass);
    space.free = vec![0.0; rows];
    space.rate = [rate, slip][..rows].to_vec();
    space
}

/// Solves the contact over one step.
fn solve(space: &engine::ContactSpace, dt: f64) -> ContactSolver {
    let mut contact = ContactSolver::default();
    contact.solve(space, dt, &|| true).unwrap_or_else(|error| panic!("{error}"));
    contact
}

/// For k = 0 and no other force, v(δ) = v₀ − (c_max/m)(δ³/δ_max² − δ⁴/(2 δ_max³)) (5-integrators, 7).
#[test]
fn a_damper_stops_a_mass_at_the_closed_form_depth() {
    let normal = NormalLaw { stiffness_n_per_m_e: 0.0, ..THESIS_NORMAL };
    for (mass, speed) in [(0.005, 2.0), (0.02, 0.5), (0.005, 8.0)] {
        let space = single_contact_space(ContactLaw { normal, friction: None }, mass, 1e-6, -speed, 0.0);
        let contact = solve(&space, 1e-5);
        let depth = -contact.gap[0];
        // The damper absorbs the whole speed.
        let absorbed_speed = 1e6 / mass * (depth.powi(3) / 1e-10 - depth.powi(4) / 2e-15);
        assert_relative(absorbed_speed, speed, 2e-3, format!("{mass} kg at {speed} m/s: speed"));
        assert_relative(contact.early_impulse[0] + contact.late_impulse[0], mass * speed, 2e-3, "impulse");
        assert_eq!(contact.changes[0].kind, engine::ChangeKind::Closes);
        assert!((contact.changes[0].after_s - 1e-6 / speed).abs() < 1e-15);
    }
}

/// Without a damper a mass rebounds at its approach speed, from the closed-form depth (m v²/2 = k δᵉ⁺¹/(e + 1)).
#[test]
fn a_spring_returns_all_energy() {
    let normal = THESIS_NORMAL.with_damping_max(0.0);
    let (mass, speed) = (0.005, 2.0);
    let space = single_contact_space(ContactLaw { normal, friction: None }, mass, 1e-5, -speed, 0.0);
    let contact = solve(&space, 2e-3);
    assert_relative(contact.rate[0], speed, 5e-3, "rebound");
    assert!(contact.rate[0] <= speed * (1.0 + 1e-3), "gains energy: {} m/s", contact.rate[0]);
    let deepest = (0.5 * mass * speed * speed * 3.2 / 1e8f64).powf(1.0 / 3.2);
    assert_relative(contact.deepest[0].gap, -deepest, 5e-3, "largest depth");
}

/// In an impact with constant sliding friction the tangential impulse is μ times the normal impulse.
#[test]
fn tangential_impulse_is_mu_times_the_normal_impulse() {
    let friction = Some(FrictionLaw { mu_static: 0.3, mu_dynamic: 0.3, ..THESIS_FRICTION });
    let space = single_contact_space(ContactLaw { normal: THESIS_NORMAL, friction }, 0.005, 1e-7, -2.0, 5.0);
    let contact = solve(&space, 1e-5);
    let normal = contact.early_impulse[0] + contact.late_impulse[0];
    let tangential = contact.early_impulse[1] + contact.late_impulse[1];
    assert_relative(normal, 0.01, 2e-3, "normal impulse");
    assert!((tangential / normal + 0.3).abs() < 1e-9, "{tangential} {normal}");
    assert!((contact.rate[1] - (5.0 + tangential / 0.005)).abs() < 1e-9);
    // The early impulse gives the displacement of the solution of the contact equations.
    let expected_gap = 1e-7 + 1e-5 * (-2.0 + contact.early_impulse[0] / 0.005);
    assert!((expected_gap - contact.gap[0]).abs() < 1e-14, "{expected_gap:e} {:e}", contact.gap[0]);
}

/// At zero gap a contact closes if the gap decreases, or if its rate is zero and about to become negative, as in the
/// analytic model.
#[test]
fn contact_closes_if_the_gap_closes_or_is_about_to_close() {
    let law = ContactLaw { normal: THESIS_NORMAL, friction: None };
    for (rate, free, closes) in [
        (-1e-6, 9.81, true),
        (1e-6, -9.81, false),
        (0.0, -9.81, true),
        (-0.0, 9.81, false),
        (1e-15, -9.81, true),
        (0.0, 0.0, false),
    ] {
        let mut space = single_contact_space(law, 1.0, 0.0, rate, 0.0);
        space.free[0] = free;
        assert_eq!(space.is_closing(&space.active_contacts[0]), closes, "{rate} m/s, {free} m/s²");
    }
}

/// For random stiffness, damping, speed and step size there is a certified solution without tensile forces.
#[test]
fn random_laws_are_solved_at_random_step_sizes() {
    let mut random = Random(7);
    for case in 0..2000 {
        let normal = NormalLaw::step(
            10f64.powf(random.within(6.0, 12.0)),
            random.within(1.0, 3.0),
            10f64.powf(random.within(0.0, 8.0)),
            10f64.powf(random.within(-7.0, -3.0)),
        );
        let friction = (case % 2 == 0).then(|| FrictionLaw {
            mu_static: random.within(0.0, 2.0),
            mu_dynamic: 0.0,
            v_static_m_s: 10f64.powf(random.within(-4.0, -1.0)),
            v_dynamic_m_s: 0.2,
            kind: FrictionKind::Regularised,
        });
        let gap = random.within(-1e-4, 1e-4);
        let (rate, slip) = (random.within(-10.0, 5.0), random.within(-5.0, 5.0));
        let space = single_contact_space(ContactLaw { normal, friction }, 0.005, gap, rate, slip);
        let contact = solve(&space, 10f64.powf(random.within(-8.0, -4.0)));
        let normal_forces = [contact.force[0], contact.early_impulse[0], contact.late_impulse[0]];
        assert!(normal_forces.iter().all(|force| *force >= 0.0), "case {case}: tensile force");
        assert!(contact.gap[0].is_finite() && contact.rate.iter().all(|rate| rate.is_finite()));
        // The contact must not create energy: kinetic and elastic energy do not increase.
        let energy = |gap: f64, rate: f64| 0.0025 * rate * rate + phalanx::law::elastic_energy(&normal, -gap);
        let (before, after) = (energy(gap, rate), energy(contact.gap[0], contact.rate[0]));
        assert!(after <= before * (1.0 + 2e-2) + 1e-15, "case {case}: {before:e} J becomes {after:e} J");
    }
}

/// The documented step-size criteria hold over a whole closing.
#[test]
fn adaptive_steps_satisfy_their_criteria() {
    let scene = experiment_95();
    let Stepping::Adaptive { tolerance_m, max_step_s } = scene.engine.stepping else {
        panic!("the default is not adaptive")
    };
    let plan = engine::build_plan(&scene).unwrap();
    let mut motion = motion(&scene, &plan);
    let (mut last, mut contacts_closed, mut shortest) = (f64::INFINITY, 0, f64::INFINITY);
    while motion.clock.now() < scene.duration_s {
        let dt = engine::next_step(&motion, scene.engine.stepping, scene.duration_s);
        assert!(dt <= max_step_s && dt <= 2.0 * last, "{dt:e} after {last:e}");
        let joint_opening = 0.5 * dt * dt * motion.opening_acceleration;
        assert!(joint_opening <= tolerance_m * (1.0 + 1e-12), "a joint opens by {joint_opening:e} m");
        for candidate in &motion.candidates {
            let rate = candidate.normal_row.rate(&motion.velocities);
            let is_slow = -rate * dt <= 0.05 * candidate.law.depth_scale_m() * (1.0 + 1e-12);
            assert!(candidate.gap > 0.0 || is_slow, "an impact is crossed too fast");
        }
        motion.advance(dt, &|| true).unwrap();
        for change in &motion.contact.changes {
            let channel = plan
                .contact_channel(motion.space.active_contacts[change.contact].candidate.index)
                .expect("a contact channel");
            let finger_contact = FingerContact::ALL[channel];
            if change.kind == engine::ChangeKind::Closes && finger_contact != FingerContact::Limit {
                contacts_closed += 1;
                // Steps become shorter as the surfaces approach.
                assert!(dt < 1e-6, "{finger_contact:?} closes in a step of {dt:e} s");
            }
        }
        (last, shortest) = (dt, shortest.min(dt));
    }
    assert_eq!(contacts_closed, 2);
    // Steps are short at impacts and long elsewhere.
    assert!(shortest < 2e-7 && last > 1e-5, "{shortest:e} {last:e}");
}
