//! Discs and the half plane.

use super::parts::{Body, Drawing, Part, Pose, Shape, extent};
use crate::numeric::elementary::{hypot, pow};
use crate::scene::{BodiesScene, DiscMotion, Pair, Partner};
use crate::trace::BodyState;

/// What a scene of discs looks like. Discs keep the order of the scene, whether they move or not.
pub fn discs(scene: &BodiesScene) -> Drawing {
    let mut bodies = Vec::with_capacity(scene.discs.len() + 1);
    if let Some(plane) = scene.half_plane {
        let shapes = vec![Shape::HalfPlane { level_m: plane.level_m }];
        bodies.push(Body { name: "plane".to_string(), part: Part::Palm, fixed: true, shapes });
    }
    for disc in &scene.discs {
        bodies.push(Body {
            name: disc.name.clone(),
            part: Part::Disc,
            fixed: !disc.motion.moves(),
            shapes: vec![Shape::Disc { radius_m: disc.radius_m }],
        });
    }
    let pairs = scene.pairs();
    let smallest_m = scene.discs.iter().map(|disc| disc.radius_m).fold(f64::INFINITY, f64::min);
    let usual_n = pairs.iter().map(|pair| impact_n(scene, *pair)).fold(0.0, f64::max);
    let start: Vec<Pose> = scene.discs.iter().map(|disc| Pose { position_m: disc.centre_m, angle_rad: 0.0 }).collect();
    let moving = bodies.iter().skip(usize::from(scene.half_plane.is_some()));
    let places: Vec<(&Body, Pose)> = moving.zip(start).collect();
    Drawing {
        contacts: pairs.into_iter().map(|pair| scene.pair_name(pair)).collect(),
        arrow_m_per_n: 0.5 * smallest_m / if usual_n > 0.0 && usual_n.is_finite() { usual_n } else { 1.0 },
        longest_arrow_m: 2.0 * smallest_m,
        extent_m: extent(&places),
        bodies,
    }
}

/// Where the bodies of [`discs`] are, in their order.
pub fn disc_poses(scene: &BodiesScene, bodies: &[BodyState]) -> Vec<Pose> {
    let plane = scene.half_plane.map(|_| Pose::default());
    let discs = bodies
        .iter()
        .map(|BodyState { centre_m, angle_rad, .. }| Pose { position_m: *centre_m, angle_rad: *angle_rad });
    plane.into_iter().chain(discs).collect()
}

/// How fast these change: velocities and spins in place of positions and angles.
pub fn disc_motions(scene: &BodiesScene, bodies: &[BodyState]) -> Vec<Pose> {
    let plane = scene.half_plane.map(|_| Pose::default());
    let discs = bodies
        .iter()
        .map(|BodyState { velocity_m_s, spin_rad_s, .. }| Pose { position_m: *velocity_m_s, angle_rad: *spin_rad_s });
    plane.into_iter().chain(discs).collect()
}

/// Largest force of an impact without damping at the speeds of the start, k δᵉ with ½ m v² = k δ^(e+1)/(e+1); where that
/// is nothing, the weight.
fn impact_n(scene: &BodiesScene, pair: Pair) -> f64 {
    let of = |index: usize| match scene.discs[index].motion {
        DiscMotion::Fixed => ([0.0; 2], f64::INFINITY),
        DiscMotion::Driven { velocity_m_s, .. } => (velocity_m_s, f64::INFINITY),
        DiscMotion::Free { velocity_m_s, mass_kg, .. } => (velocity_m_s, mass_kg),
    };
    let (v1, m1) = of(pair.disc);
    let (v2, m2) = match pair.partner {
        Partner::Disc(index) => of(index),
        Partner::HalfPlane => ([0.0; 2], f64::INFINITY),
    };
    let mass = (m1.recip() + m2.recip()).recip();
    if !mass.is_finite() {
        return 0.0;
    }
    let speed = hypot(v1[0] - v2[0], v1[1] - v2[1]);
    let (k, e) = (scene.contact.normal.stiffness_n_per_m_e, scene.contact.normal.exponent);
    let energy = 0.5 * mass * speed * speed;
    let weight = mass * hypot(scene.gravity_m_s2[0], scene.gravity_m_s2[1]);
    if k > 0.0 { (k * pow((e + 1.0) * energy / k, e / (e + 1.0))).max(weight) } else { weight }
}
