//! The contact space and the contact solver of the engine, against dense algebra and closed forms.

use crate::support::runs::anchor;
use nalgebra::{DMatrix, DVector};
use phalanx::engine::{self, Contact, Linkage, Motion, Plan, Row, Twist};
use phalanx::law::{ContactLaw, FrictionLaw, NormalLaw};
use phalanx::scene::{Scene, Stepping};
use phalanx::trace::Site;

fn motion<'a>(scene: &Scene, plan: &'a Plan) -> Motion<'a> {
    let settings = &scene.engine;
    let world = engine::build(plan, settings.construction, settings.response, settings.iterations);
    Motion::new(plan, world).expect("a world")
}

/// M⁻¹ over all bodies, and the opening rates J of the finger's five pins, from plain geometry.
fn masses_and_joints(plan: &Plan, linkage: &Linkage) -> (DMatrix<f64>, DMatrix<f64>) {
    let count = plan.bodies.len();
    let diagonal: Vec<f64> =
        linkage.inertias.iter().flat_map(|i| [i.inverse_mass, i.inverse_mass, i.inverse_inertia]).collect();
    let inverse_mass = DMatrix::from_diagonal(&DVector::from_vec(diagonal));
    let mut joints = DMatrix::zeros(2 * plan.pins.len(), 3 * count);
    for (p, pin) in plan.pins.iter().enumerate() {
        let mut add = |body: usize, anchor: [f64; 2], sign: f64| {
            let com = plan.bodies[body].body.com_m;
            let [c, s] = linkage.places[body].direction;
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

fn column(row: &Row, bodies: usize) -> DVector<f64> {
    let mut impulse: Vec<Twist> = vec![[0.0; 3]; bodies];
    row.add_to(&mut impulse, 1.0);
    DVector::from_vec(impulse.into_iter().flatten().collect())
}

/// W = C (M⁻¹ − M⁻¹ Jᵀ (J M⁻¹ Jᵀ)⁻¹ J M⁻¹) Cᵀ, by dense algebra of another library.
#[test]
fn contact_space_inverse_inertia_is_that_of_the_jointed_bodies() {
    let scene = anchor();
    let plan = engine::plan(&scene.system).unwrap();
    let mut motion = motion(&scene, &plan);
    // So long a step takes in every site: limit, and both contacts with friction.
    for _ in 0..3 {
        motion.advance(2e-3).unwrap();
    }
    assert_eq!(motion.space.len(), 5);
    let mut scratch = motion.linkage.places.clone();
    scratch.clear();
    // The space is that of the step's start: build it anew where the bodies are now.
    let Motion { world, linkage, touches, velocities, accelerations, space, .. } = &mut motion;
    space.assemble(world, &plan, linkage, (touches, &[]), velocities, accelerations, 2e-3);
    let (inverse_mass, joints) = masses_and_joints(&plan, linkage);
    let bodies = plan.bodies.len();
    let rows: Vec<DVector<f64>> = space.rows.iter().map(|row| column(row, bodies)).collect();
    let rows = DMatrix::from_columns(&rows);
    let reacting = (&joints * &inverse_mass * joints.transpose()).try_inverse().expect("independent joints");
    let held = &inverse_mass - &inverse_mass * joints.transpose() * reacting * &joints * &inverse_mass;
    let expected = rows.transpose() * held * &rows;
    let size = space.len();
    let largest = expected.amax();
    for i in 0..size {
        for j in 0..size {
            let found = space.w[i * size + j];
            assert!((found - expected[(i, j)]).abs() <= 1e-9 * largest, "W[{i}][{j}] = {found}, {}", expected[(i, j)]);
        }
    }
    assert!((0..size).all(|i| space.w[i * size + i] > 0.0));
}

/// One row, one mass: a contact space without any body behind it.
fn single(law: ContactLaw, mass: f64, gap: f64, rate: f64, slip: f64) -> engine::Space {
    let scene = anchor();
    let plan = engine::plan(&scene.system).unwrap();
    let motion = motion(&scene, &plan);
    let mut touch =
        *motion.touches.iter().find(|touch| plan.place(touch.index) == Some(Site::Proximal as usize)).unwrap();
    (touch.gap, touch.law, touch.friction) = (gap, law.normal, law.friction);
    let rows = 1 + usize::from(law.friction.is_some());
    let mut space = engine::Space::default();
    space.sites.push(engine::Site { touch, normal: 0, tangent: law.friction.map(|_| 1), memory: 0.0 });
    space.rows = vec![touch.normal_row; rows];
    space.w = vec![0.0; rows * rows];
    (0..rows).for_each(|i| space.w[i * rows + i] = 1.0 / mass);
    space.free = vec![0.0; rows];
    space.rate = [rate, slip][..rows].to_vec();
    space
}

const STIFF: NormalLaw =
    NormalLaw { stiffness_n_per_m_e: 1e8, exponent: 2.2, damping_max_n_s_per_m: 1e6, transition_m: 1e-5 };

/// k = 0, no push: v(δ) = v₀ − (c_max/m)(δ³/δ_max² − δ⁴/(2 δ_max³)) (5-integrators, 7).
#[test]
fn a_damper_alone_stops_a_mass_where_the_closed_form_says() {
    let normal = NormalLaw { stiffness_n_per_m_e: 0.0, ..STIFF };
    for (mass, speed) in [(0.005, 2.0), (0.02, 0.5), (0.005, 8.0)] {
        let space = single(ContactLaw { normal, friction: None }, mass, 1e-6, -speed, 0.0);
        let mut contact = Contact::default();
        contact.solve(&space, 1e-5).unwrap();
        let depth = -contact.gap[0];
        let taken = 1e6 / mass * (depth.powi(3) / 1e-10 - depth.powi(4) / 2e-15);
        // It creeps to a stop: nothing is left of the speed.
        assert!((taken / speed - 1.0).abs() < 2e-3, "{mass} kg at {speed} m/s: depth {depth:e}, taken {taken}");
        let impulse = contact.early[0] + contact.late[0];
        assert!((impulse / (mass * speed) - 1.0).abs() < 2e-3);
        assert_eq!(contact.changes[0].kind, engine::ChangeKind::Meets);
        assert!((contact.changes[0].after_s - 1e-6 / speed).abs() < 1e-15);
    }
}

/// Without a damper a mass comes back as fast as it came, after the closed-form depth (m v²/2 = k δᵉ⁺¹/(e + 1)).
#[test]
fn a_spring_alone_gives_everything_back() {
    let normal = NormalLaw { damping_max_n_s_per_m: 0.0, ..STIFF };
    let (mass, speed) = (0.005, 2.0);
    let space = single(ContactLaw { normal, friction: None }, mass, 1e-5, -speed, 0.0);
    let mut contact = Contact::default();
    contact.solve(&space, 2e-3).unwrap();
    assert!((contact.rate[0] / speed - 1.0).abs() < 5e-3, "comes back at {}", contact.rate[0]);
    assert!(contact.rate[0] <= speed * (1.0 + 1e-3), "no energy from nowhere: {}", contact.rate[0]);
    let deepest = (0.5 * mass * speed * speed * 3.2 / 1e8f64).powf(1.0 / 3.2);
    assert!((contact.deepest[0].gap / -deepest - 1.0).abs() < 5e-3, "{:e} {deepest:e}", contact.deepest[0].gap);
}

/// Sliding through an impact with μ constant: the tangential impulse is μ times the normal one.
#[test]
fn friction_takes_its_share_of_an_impact() {
    let friction =
        Some(FrictionLaw { mu_static: 0.3, mu_dynamic: 0.3, v_static_m_s: 0.1, v_dynamic_m_s: 0.2, bristle: None });
    let space = single(ContactLaw { normal: STIFF, friction }, 0.005, 1e-7, -2.0, 5.0);
    let mut contact = Contact::default();
    contact.solve(&space, 1e-5).unwrap();
    let normal = contact.early[0] + contact.late[0];
    let tangential = contact.early[1] + contact.late[1];
    assert!((normal / 0.01 - 1.0).abs() < 2e-3, "{normal}");
    assert!((tangential / normal + 0.3).abs() < 1e-9, "{tangential} {normal}");
    assert!((contact.rate[1] - (5.0 + tangential / 0.005)).abs() < 1e-9);
    // Early and late parts move the mass as the contact's own equations do.
    let moved = space.touch_gap() + 1e-5 * (-2.0 + contact.early[0] / 0.005);
    assert!((moved - contact.gap[0]).abs() < 1e-14, "{moved:e} {:e}", contact.gap[0]);
}

trait FirstGap {
    fn touch_gap(&self) -> f64;
}

impl FirstGap for engine::Space {
    fn touch_gap(&self) -> f64 {
        self.sites[0].touch.gap
    }
}

/// What recedes does not meet, and what rests does if it is about to: read as the analytic model reads its start.
#[test]
fn surfaces_meet_where_they_close_or_are_about_to() {
    let law = ContactLaw { normal: STIFF, friction: None };
    for (rate, free, closes) in [
        (-1e-6, 9.81, true),
        (1e-6, -9.81, false),
        (0.0, -9.81, true),
        (-0.0, 9.81, false),
        (1e-15, -9.81, true),
        (0.0, 0.0, false),
    ] {
        let mut space = single(law, 1.0, 0.0, rate, 0.0);
        space.free[0] = free;
        assert_eq!(space.closes(&space.sites[0]), closes, "{rate} m/s, {free} m/s²");
    }
}

/// Whatever stiffness, damping, speed and step: a certified solution, and a contact that never pulls.
#[test]
fn every_law_is_solved_at_every_step() {
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
        let space =
            single(ContactLaw { normal, friction }, 0.005, gap, random.within(-10.0, 5.0), random.within(-5.0, 5.0));
        let mut contact = Contact::default();
        let dt = 10f64.powf(random.within(-8.0, -4.0));
        contact.solve(&space, dt).unwrap_or_else(|error| panic!("case {case}: {error}"));
        assert!(contact.force[0] >= 0.0 && contact.early[0] >= 0.0 && contact.late[0] >= 0.0, "case {case} pulls");
        assert!(contact.gap[0].is_finite() && contact.rate.iter().all(|rate| rate.is_finite()));
        // Dissipation: kinetic energy plus what the spring held at first bounds what is left.
        let energy = |gap: f64, rate: f64| 0.0025 * rate * rate + phalanx::law::elastic_energy(&normal, -gap);
        let (before, after) = (energy(gap, space.rate[0]), energy(contact.gap[0], contact.rate[0]));
        assert!(after <= before * (1.0 + 2e-2) + 1e-15, "case {case}: {before:e} J becomes {after:e} J");
    }
}

/// The stated criteria of the stepper, watched over a whole closing.
#[test]
fn steps_follow_their_criteria() {
    let scene = anchor();
    let Stepping::Adaptive { tolerance_m, max_step_s } = scene.engine.stepping else { panic!("adaptive by default") };
    let plan = engine::plan(&scene.system).unwrap();
    let mut motion = motion(&scene, &plan);
    let (mut last, mut landed, mut shortest) = (f64::INFINITY, 0, f64::INFINITY);
    while motion.clock.now() < scene.duration_s {
        let dt = engine::next(&motion, scene.engine.stepping, scene.duration_s);
        assert!(dt <= max_step_s && dt <= 2.0 * last, "{dt:e} after {last:e}");
        let stray = 0.5 * dt * dt * motion.opening;
        assert!(stray <= tolerance_m * (1.0 + 1e-12), "a joint strays by {stray:e} m");
        for touch in &motion.touches {
            let rate = touch.normal_row.rate(&motion.velocities);
            if touch.gap <= 0.0 && rate < 0.0 {
                assert!(-rate * dt <= 0.05 * touch.law.transition_m * (1.0 + 1e-12), "an impact is crossed too fast");
            }
        }
        motion.advance(dt).unwrap();
        for change in &motion.contact.changes {
            let place = plan.place(motion.space.sites[change.site].touch.index).expect("a place");
            let site = Site::ALL[place];
            if change.kind == engine::ChangeKind::Meets && site != Site::Limit {
                landed += 1;
                // The touch is met in a short step, after an approach of ever shorter ones.
                assert!(dt < 1e-6, "{site:?} is met in a step of {dt:e} s");
            }
        }
        (last, shortest) = (dt, shortest.min(dt));
    }
    assert_eq!(landed, 2);
    assert!(shortest < 2e-7 && last > 1e-5, "small around impacts ({shortest:e} s), large elsewhere ({last:e} s)");
}
