//! Contact space and contact solver of the engine, against dense algebra and closed forms.

use crate::support::runs::experiment_95;
use nalgebra::{DMatrix, DVector};
use phalanx::engine::{self, ContactSolver, Linkage, Motion, Plan, Row, Twist};
use phalanx::law::{ContactLaw, FrictionLaw, NormalLaw};
use phalanx::scene::{Scene, Stepping};
use phalanx::trace::FingerContact;

fn motion<'a>(scene: &Scene, plan: &'a Plan) -> Motion<'a> {
    let settings = &scene.engine;
    let world = engine::build_world(plan, settings.construction, settings.response, settings.iterations);
    Motion::new(plan, world).expect("a world")
}

/// Returns M⁻¹ of all bodies, and the constraint Jacobian J of the five pins of the finger.
fn masses_and_joints(plan: &Plan, linkage: &Linkage) -> (DMatrix<f64>, DMatrix<f64>) {
    let count = plan.bodies.len();
    let diagonal: Vec<f64> =
        linkage.inertias.iter().flat_map(|i| [i.inverse_mass, i.inverse_mass, i.inverse_inertia]).collect();
    let inverse_mass = DMatrix::from_diagonal(&DVector::from_vec(diagonal));
    let mut joints = DMatrix::zeros(2 * plan.pins.len(), 3 * count);
    for (p, pin) in plan.pins.iter().enumerate() {
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
        add(pin.second, pin.anchor_second_m, 1.0);
        if let Some(first) = pin.first {
            add(first, pin.anchor_first_m, -1.0);
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
    let plan = engine::build_plan(&scene.system).unwrap();
    let mut motion = motion(&scene, &plan);
    // A step of this length activates all contacts: the limit, and both phalanges with friction.
    for _ in 0..3 {
        motion.advance(2e-3, &|| true).unwrap();
    }
    assert_eq!(motion.space.len(), 5);
    let mut linkage_poses = motion.linkage.poses.clone();
    linkage_poses.clear();
    // The contact space describes the start of the step; assemble it again at the current poses.
    let Motion { world, linkage, candidates, velocities, accelerations, space, .. } = &mut motion;
    space.assemble(world, &plan, linkage, (candidates, &[]), velocities, accelerations, 2e-3);
    let (inverse_mass, joints) = masses_and_joints(&plan, linkage);
    let bodies = plan.bodies.len();
    let rows: Vec<DVector<f64>> = space.rows.iter().map(|row| row_as_vector(row, bodies)).collect();
    let rows = DMatrix::from_columns(&rows);
    let joint_response = (&joints * &inverse_mass * joints.transpose()).try_inverse().expect("independent joints");
    let constrained_inverse_mass =
        &inverse_mass - &inverse_mass * joints.transpose() * joint_response * &joints * &inverse_mass;
    let expected = rows.transpose() * constrained_inverse_mass * &rows;
    let size = space.len();
    let largest = expected.amax();
    for i in 0..size {
        for j in 0..size {
            let actual = space.w[i * size + j];
            assert!(
                (actual - expected[(i, j)]).abs() <= 1e-9 * largest,
                "W[{i}][{j}] = {actual}, {}",
                expected[(i, j)]
            );
        }
    }
    assert!((0..size).all(|i| space.w[i * size + i] > 0.0));
}

/// A contact space with one contact and a constant mass instead of bodies.
fn single_contact_space(law: ContactLaw, mass: f64, gap: f64, rate: f64, slip: f64) -> engine::ContactSpace {
    let scene = experiment_95();
    let plan = engine::build_plan(&scene.system).unwrap();
    let motion = motion(&scene, &plan);
    let mut candidate = *motion
        .candidates
        .iter()
        .find(|candidate| plan.contact_channel(candidate.index) == Some(FingerContact::Proximal as usize))
        .unwrap();
    (candidate.gap, candidate.law, candidate.friction) = (gap, law.normal, law.friction);
    let rows = 1 + usize::from(law.friction.is_some());
    let mut space = engine::ContactSpace::default();
    space.active_contacts.push(engine::ActiveContact {
        candidate,
        normal: 0,
        tangent: law.friction.map(|_| 1),
        bristle_state: 0.0,
    });
    space.rows = vec![candidate.normal_row; rows];
    space.w = vec![0.0; rows * rows];
    (0..rows).for_each(|i| space.w[i * rows + i] = 1.0 / mass);
    space.free = vec![0.0; rows];
    space.rate = [rate, slip][..rows].to_vec();
    space
}

const STIFF: NormalLaw =
    NormalLaw { stiffness_n_per_m_e: 1e8, exponent: 2.2, damping_max_n_s_per_m: 1e6, transition_m: 1e-5 };

/// For k = 0 and no other force, v(δ) = v₀ − (c_max/m)(δ³/δ_max² − δ⁴/(2 δ_max³)) (5-integrators, 7).
#[test]
fn a_damper_stops_a_mass_at_the_closed_form_depth() {
    let normal = NormalLaw { stiffness_n_per_m_e: 0.0, ..STIFF };
    for (mass, speed) in [(0.005, 2.0), (0.02, 0.5), (0.005, 8.0)] {
        let space = single_contact_space(ContactLaw { normal, friction: None }, mass, 1e-6, -speed, 0.0);
        let mut contact = ContactSolver::default();
        contact.solve(&space, 1e-5, &|| true).unwrap();
        let depth = -contact.gap[0];
        let absorbed_speed = 1e6 / mass * (depth.powi(3) / 1e-10 - depth.powi(4) / 2e-15);
        // The damper absorbs the whole speed.
        assert!(
            (absorbed_speed / speed - 1.0).abs() < 2e-3,
            "{mass} kg at {speed} m/s: depth {depth:e}, taken {absorbed_speed}"
        );
        let impulse = contact.early_impulse[0] + contact.late_impulse[0];
        assert!((impulse / (mass * speed) - 1.0).abs() < 2e-3);
        assert_eq!(contact.changes[0].kind, engine::ChangeKind::Closes);
        assert!((contact.changes[0].after_s - 1e-6 / speed).abs() < 1e-15);
    }
}

/// Without a damper a mass rebounds at its approach speed, from the closed-form depth (m v²/2 = k δᵉ⁺¹/(e + 1)).
#[test]
fn a_spring_returns_all_energy() {
    let normal = NormalLaw { damping_max_n_s_per_m: 0.0, ..STIFF };
    let (mass, speed) = (0.005, 2.0);
    let space = single_contact_space(ContactLaw { normal, friction: None }, mass, 1e-5, -speed, 0.0);
    let mut contact = ContactSolver::default();
    contact.solve(&space, 2e-3, &|| true).unwrap();
    assert!((contact.rate[0] / speed - 1.0).abs() < 5e-3, "rebounds at {} m/s", contact.rate[0]);
    assert!(contact.rate[0] <= speed * (1.0 + 1e-3), "gains energy: {} m/s", contact.rate[0]);
    let deepest = (0.5 * mass * speed * speed * 3.2 / 1e8f64).powf(1.0 / 3.2);
    assert!((contact.deepest[0].gap / -deepest - 1.0).abs() < 5e-3, "{:e} {deepest:e}", contact.deepest[0].gap);
}

/// In an impact with constant sliding friction the tangential impulse is μ times the normal impulse.
#[test]
fn tangential_impulse_is_mu_times_the_normal_impulse() {
    let friction =
        Some(FrictionLaw { mu_static: 0.3, mu_dynamic: 0.3, v_static_m_s: 0.1, v_dynamic_m_s: 0.2, bristle: None });
    let space = single_contact_space(ContactLaw { normal: STIFF, friction }, 0.005, 1e-7, -2.0, 5.0);
    let mut contact = ContactSolver::default();
    contact.solve(&space, 1e-5, &|| true).unwrap();
    let normal = contact.early_impulse[0] + contact.late_impulse[0];
    let tangential = contact.early_impulse[1] + contact.late_impulse[1];
    assert!((normal / 0.01 - 1.0).abs() < 2e-3, "{normal}");
    assert!((tangential / normal + 0.3).abs() < 1e-9, "{tangential} {normal}");
    assert!((contact.rate[1] - (5.0 + tangential / 0.005)).abs() < 1e-9);
    // The early impulse gives the displacement of the solution of the contact equations.
    let expected_gap = space.initial_gap() + 1e-5 * (-2.0 + contact.early_impulse[0] / 0.005);
    assert!((expected_gap - contact.gap[0]).abs() < 1e-14, "{expected_gap:e} {:e}", contact.gap[0]);
}

trait InitialGap {
    fn initial_gap(&self) -> f64;
}

impl InitialGap for engine::ContactSpace {
    fn initial_gap(&self) -> f64 {
        self.active_contacts[0].candidate.gap
    }
}

/// At zero gap a contact closes if the gap decreases, or if its rate is zero and about to become negative, as in the
/// analytic model.
#[test]
fn contact_closes_if_the_gap_closes_or_is_about_to_close() {
    let law = ContactLaw { normal: STIFF, friction: None };
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
    let mut random = crate::support::runs::Random(7);
    for case in 0..2000 {
        let normal = NormalLaw {
            stiffness_n_per_m_e: 10f64.powf(random.within(6.0, 12.0)),
            exponent: random.within(1.0, 3.0),
            damping_max_n_s_per_m: 10f64.powf(random.within(0.0, 8.0)),
            transition_m: 10f64.powf(random.within(-7.0, -3.0)),
        };
        let friction = (case % 2 == 0).then(|| FrictionLaw {
            mu_static: random.within(0.0, 2.0),
            mu_dynamic: 0.0,
            v_static_m_s: 10f64.powf(random.within(-4.0, -1.0)),
            v_dynamic_m_s: 0.2,
            bristle: None,
        });
        let gap = random.within(-1e-4, 1e-4);
        let space = single_contact_space(
            ContactLaw { normal, friction },
            0.005,
            gap,
            random.within(-10.0, 5.0),
            random.within(-5.0, 5.0),
        );
        let mut contact = ContactSolver::default();
        let dt = 10f64.powf(random.within(-8.0, -4.0));
        contact.solve(&space, dt, &|| true).unwrap_or_else(|error| panic!("case {case}: {error}"));
        assert!(
            contact.force[0] >= 0.0 && contact.early_impulse[0] >= 0.0 && contact.late_impulse[0] >= 0.0,
            "case {case}: tensile force"
        );
        assert!(contact.gap[0].is_finite() && contact.rate.iter().all(|rate| rate.is_finite()));
        // The contact must not create energy: kinetic and elastic energy do not increase.
        let energy = |gap: f64, rate: f64| 0.0025 * rate * rate + phalanx::law::elastic_energy(&normal, -gap);
        let (before, after) = (energy(gap, space.rate[0]), energy(contact.gap[0], contact.rate[0]));
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
    let plan = engine::build_plan(&scene.system).unwrap();
    let mut motion = motion(&scene, &plan);
    let (mut last, mut contacts_closed, mut shortest) = (f64::INFINITY, 0, f64::INFINITY);
    while motion.clock.now() < scene.duration_s {
        let dt = engine::next_step(&motion, scene.engine.stepping, scene.duration_s);
        assert!(dt <= max_step_s && dt <= 2.0 * last, "{dt:e} after {last:e}");
        let joint_opening = 0.5 * dt * dt * motion.opening_acceleration;
        assert!(joint_opening <= tolerance_m * (1.0 + 1e-12), "a joint opens by {joint_opening:e} m");
        for candidate in &motion.candidates {
            let rate = candidate.normal_row.rate(&motion.velocities);
            if candidate.gap <= 0.0 && rate < 0.0 {
                assert!(
                    -rate * dt <= 0.05 * candidate.law.transition_m * (1.0 + 1e-12),
                    "an impact is crossed too fast"
                );
            }
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
    assert!(
        shortest < 2e-7 && last > 1e-5,
        "steps are not short at impacts ({shortest:e} s) or not long elsewhere ({last:e} s)"
    );
}
