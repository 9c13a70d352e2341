//! The rapier world of a plan, with the settings that make rapier accurate (see the [module](super)).

use rapier2d_f64::na::Unit;
use rapier2d_f64::prelude::*;

use super::joint::joint_in_rapier;
use super::plan::{Capsule, Plan, PlannedContact, PlannedJoint, PlannedSurface, Shape, SurfaceId};
use crate::numeric::elementary::hypot;
use crate::scene::Response;
use crate::shape::max_radius;

/// A rapier world with the handles of the components of a plan.
pub struct World {
    pub physics: PhysicsWorld,
    pub bodies: Vec<RigidBodyHandle>,
    /// For each contact of the plan, the colliders of its body and of the other surface.
    pub contacts: Vec<[ColliderHandle; 2]>,
    /// For each joint of the plan, its constraint.
    pub joints: Vec<ImpulseJointHandle>,
    pub response: Response,
}

impl Clone for World {
    fn clone(&self) -> Self {
        let Self { physics, bodies, contacts, joints, response } = self;
        let physics = PhysicsWorld {
            gravity: physics.gravity,
            integration_parameters: physics.integration_parameters,
            islands: physics.islands.clone(),
            broad_phase: physics.broad_phase.clone(),
            narrow_phase: physics.narrow_phase.clone(),
            bodies: physics.bodies.clone(),
            colliders: physics.colliders.clone(),
            impulse_joints: physics.impulse_joints.clone(),
            soft_bodies: physics.soft_bodies.clone(),
            ccd_solver: physics.ccd_solver.clone(),
            // The pipelines are working memory of a step.
            ..PhysicsWorld::new()
        };
        let (bodies, contacts, joints) = (bodies.clone(), contacts.clone(), joints.clone());
        Self { physics, bodies, contacts, joints, response: *response }
    }
}

/// Disables solver contacts and response for the pairs that carry this hook; the contact laws replace them, and
/// rapier's broad phase still finds the pairs. `None` rather than empty solver flags, so that rapier skips the unused
/// contact geometry.
pub(crate) struct LawContactHook;

impl PhysicsHooks for LawContactHook {
    fn filter_contact_pair(&self, _: &PairFilterContext) -> Option<SolverFlags> {
        None
    }
}

/// Constraints correct their error in one step.
const RIGID: SpringCoefficients<f64> = SpringCoefficients { natural_frequency: 1e14, damping_ratio: 1.0 };

/// Distance up to which rapier tracks a pair, in radii of the largest surface: far enough that no step exceeds it.
const PREDICTION_RADII: f64 = 0.5;

/// Distance up to which rapier tracks a pair if all surfaces are sharp or flat, m.
const SHARP_PREDICTION_M: f64 = 1e-3;

/// Builds the world. With [`Response::Laws`], every contact pair has the hook.
pub fn build_world(plan: &Plan, response: Response, iterations: u32) -> World {
    let mut physics = PhysicsWorld::new();
    // Gravity is applied as a force on each body, so that it can be halved when the step size changes.
    physics.gravity = Vector::ZERO;
    physics.integration_parameters = parameters(plan, response, iterations);

    let ground = physics.insert_body(RigidBodyBuilder::fixed());
    let bodies: Vec<RigidBodyHandle> = plan
        .bodies
        .iter()
        .enumerate()
        .map(|(i, planned)| {
            let body = &planned.body;
            let com = Vector::new(body.com_m[0], body.com_m[1]);
            let pose = Pose::new(Vector::new(planned.origin_m[0], planned.origin_m[1]), planned.angle_rad);
            let driven = plan.drives.iter().any(|drive| drive.body == i);
            let (builder, mass_kg, inertia_kg_m2) = match driven {
                // The centre of mass of a body without mass would be that of its colliders, about which rapier turns it.
                true => (RigidBodyBuilder::kinematic_velocity_based(), 1.0, 1.0),
                false => (RigidBodyBuilder::dynamic(), body.mass_kg, body.inertia_kg_m2),
            };
            physics.insert_body(
                builder
                    .pose(pose)
                    .additional_mass_properties(MassProperties::new(com, mass_kg, inertia_kg_m2))
                    // Sleeping bodies ignore forces; fast links exceed rapier's default limit of 45° per step.
                    .can_sleep(false)
                    .allow_fast_rotation(true),
            )
        })
        .collect();

    let insert_joint = |planned: &PlannedJoint| {
        let [first, second] = planned.bodies.map(|body| body.map_or(ground, |body| bodies[body]));
        physics.insert_impulse_joint(first, second, joint(plan, planned))
    };
    let joints = plan.joints.iter().map(insert_joint).collect();

    let mut world = World { physics, bodies, contacts: Vec::new(), joints, response };
    add_colliders(&mut world, plan, response);
    // A step of zero length updates world mass properties and contact pairs.
    world.physics.integration_parameters.dt = 0.0;
    world.physics.step_with_events(&LawContactHook, &());
    set_rates(&mut world, plan);
    world
}

fn parameters(plan: &Plan, response: Response, iterations: u32) -> IntegrationParameters {
    let surfaces = plan.fixed_surfaces.iter().chain(plan.bodies.iter().flat_map(|body| &body.surfaces));
    let radius = |surface: &PlannedSurface| match &surface.shape {
        Shape::Capsule(Capsule { radius_m, .. }) => *radius_m,
        Shape::Disc(shape) => max_radius(shape),
        Shape::HalfPlane => 0.0,
        Shape::Polygon { vertices_m, radius_m } => reach(vertices_m) + radius_m,
        Shape::Ellipse { semi_axes_m: [a, b] } => a.max(*b),
    };
    let largest_radius_m = surfaces.map(radius).filter(|radius_m| *radius_m > 0.0).reduce(f64::max);
    let prediction_distance_m = largest_radius_m.map_or(SHARP_PREDICTION_M, |radius_m| PREDICTION_RADII * radius_m);
    IntegrationParameters {
        num_solver_iterations: 1,
        num_internal_pgs_iterations: iterations as usize,
        // A stabilisation pass moves bodies without their velocities, which would reduce the order of the scheme.
        num_internal_stabilization_iterations: match response {
            Response::Laws => 0,
            Response::Rapier { .. } => 1,
        },
        warmstart_joints: true,
        // rapier's contact is soft by default (60 Hz): the motor would push surfaces into each other while closing.
        contact_softness: RIGID,
        static_contact_softness: RIGID,
        normalized_max_linear_velocity: Real::MAX,
        normalized_max_corrective_velocity: Real::MAX,
        normalized_prediction_distance: prediction_distance_m,
        normalized_allowed_linear_error: 0.0,
        max_ccd_substeps: 0,
        contact_recycling: false,
        ..IntegrationParameters::default()
    }
}

fn joint(plan: &Plan, planned: &PlannedJoint) -> GenericJoint {
    let joint = joint_in_rapier(planned);
    // Bodies of a joint pass through one another, unless the plan has a contact between them.
    let touch = |contact: &PlannedContact| {
        let bodies = [Some(contact.body), contact.against.body];
        bodies == planned.bodies || bodies == [planned.bodies[1], planned.bodies[0]]
    };
    joint.contacts_enabled(plan.contacts.iter().any(touch)).softness(RIGID).build()
}

fn add_colliders(world: &mut World, plan: &Plan, response: Response) {
    let count = plan.bodies.len();
    let finish = |builder: ColliderBuilder, surface: usize| {
        let builder = builder
            .density(0.0)
            .collision_groups(groups(plan, surface))
            // By default driven bodies collide only with dynamic ones.
            .active_collision_types(ActiveCollisionTypes::all());
        match response {
            Response::Laws => builder.active_hooks(ActiveHooks::FILTER_CONTACT_PAIRS),
            Response::Rapier { friction, restitution } => builder.friction(friction).restitution(restitution),
        }
    };
    let placed = |surface: &PlannedSurface| collider(&surface.shape).position(surface_pose_in_frame(surface));
    let fixed: Vec<_> = plan
        .fixed_surfaces
        .iter()
        .enumerate()
        .map(|(index, surface)| world.physics.insert_collider(finish(placed(surface), count + index), None))
        .collect();
    let moving: Vec<Vec<_>> = plan
        .bodies
        .iter()
        .zip(&world.bodies)
        .enumerate()
        .map(|(index, (planned, body))| {
            let colliders = planned.surfaces.iter().map(|surface| finish(placed(surface), index));
            colliders.map(|collider| world.physics.insert_collider(collider, Some(*body))).collect()
        })
        .collect();
    world.contacts.extend(plan.contacts.iter().map(|contact| {
        let SurfaceId { body, index } = contact.against;
        [moving[contact.body][contact.surface], body.map_or(&fixed, |body| &moving[body])[index]]
    }));
}

/// Returns the pose of a surface in the frame of its body, or in the world.
pub(crate) fn surface_pose_in_frame(surface: &PlannedSurface) -> Pose {
    let ([x, y], [re, im]) = (surface.origin_m, surface.direction);
    Pose::from_parts(Vector::new(x, y), Rotation { re, im })
}

/// Collision groups: surfaces (of bodies, then fixed ones) collide only if the plan has a contact; links of a finger
/// pass through one another. rapier has 32 groups; further surfaces share them, which creates unneeded pairs.
fn groups(plan: &Plan, surface: usize) -> InteractionGroups {
    let group = |surface: usize| Group::from_bits_truncate(1 << (surface % 32));
    let mut partners = Group::NONE;
    for contact in &plan.contacts {
        let other = contact.against.body.unwrap_or(plan.bodies.len() + contact.against.index);
        if contact.body == surface {
            partners |= group(other);
        } else if other == surface {
            partners |= group(contact.body);
        }
    }
    InteractionGroups::new(group(surface), partners, InteractionTestMode::And)
}

/// Distance of the furthest vertex from the origin.
fn reach(vertices_m: &[[f64; 2]]) -> f64 {
    vertices_m.iter().map(|[x, y]| hypot(*x, *y)).fold(0.0, f64::max)
}

/// Returns the rapier collider of a surface: of polygons and ellipses, whose closest points are computed here, a disc
/// that contains them.
pub(crate) fn collider(shape: &Shape) -> ColliderBuilder {
    match shape {
        Shape::Capsule(capsule) => {
            let [x, y] = capsule.end_m;
            ColliderBuilder::capsule_from_endpoints(Vector::ZERO, Vector::new(x, y), capsule.radius_m)
        }
        Shape::Disc(shape) => ColliderBuilder::ball(max_radius(shape)),
        Shape::Polygon { vertices_m, radius_m } => ColliderBuilder::ball(reach(vertices_m) + radius_m),
        Shape::Ellipse { semi_axes_m: [a, b] } => ColliderBuilder::ball(a.max(*b)),
        Shape::HalfPlane => ColliderBuilder::halfspace(Unit::new_unchecked(Vector::Y)),
    }
}

/// Sets the initial rates of all bodies.
fn set_rates(world: &mut World, plan: &Plan) {
    if plan.bodies.iter().all(|body| body.rate_rad_s == 0.0 && body.velocity_m_s == [0.0; 2]) {
        return;
    }
    for (i, planned) in plan.bodies.iter().enumerate() {
        let body = &mut world.physics.bodies[world.bodies[i]];
        let arm = body.center_of_mass() - body.translation();
        let [vx, vy] = planned.velocity_m_s;
        body.set_linvel(Vector::new(vx, vy) + arm.perp() * planned.rate_rad_s, true);
        body.set_angvel(planned.rate_rad_s, true);
    }
}
