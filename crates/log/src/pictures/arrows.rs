//! Contact points and forces as foxglove primitives, one entity per contact.

use foxglove::messages::{
    ArrowPrimitive, Color, Pose, Quaternion, SceneEntity, SceneUpdate, SpherePrimitive, Timestamp, Vector3,
};

use phalanx_core::drawing::Drawing;
use phalanx_core::numeric::elementary::{atan2, sin_cos};
use phalanx_core::trace::ContactSample;

/// Name of the root frame.
pub(crate) const WORLD: &str = "world";

/// Elevation of arrows and points above all bodies, relative to the longest arrow.
const ARROW_ELEVATION: f64 = 0.05;
/// Diameter of an arrow shaft, relative to the longest arrow.
const SHAFT_DIAMETER: f64 = 0.02;
/// Diameter of an arrow head, relative to the longest arrow.
const HEAD_DIAMETER: f64 = 0.05;
/// Length of an arrow head, relative to the longest arrow.
const HEAD_LENGTH: f64 = 0.08;
/// Diameter of a contact point, relative to the longest arrow.
const POINT_DIAMETER: f64 = 0.05;

/// Colour of normal forces.
const NORMAL: Color = Color { r: 0.85, g: 0.1, b: 0.1, a: 1.0 };
/// Colour of friction forces.
const TANGENTIAL: Color = Color { r: 0.5, g: 0.2, b: 0.8, a: 1.0 };
/// Colour of contact points.
const CONTACT_POINT: Color = Color { r: 0.1, g: 0.1, b: 0.1, a: 1.0 };

/// Force arrows as they were drawn last.
pub struct Arrows {
    drawing: Drawing,
    /// Lengths of the normal and tangential arrow of each contact.
    lengths_m: Vec<[f64; 2]>,
    update: SceneUpdate,
}

impl Arrows {
    pub fn new(drawing: &Drawing) -> Self {
        let entity =
            |name: &String| SceneEntity { frame_id: WORLD.to_string(), id: name.clone(), ..SceneEntity::default() };
        Arrows {
            drawing: drawing.clone(),
            lengths_m: vec![[0.0; 2]; drawing.contacts.len()],
            update: SceneUpdate { deletions: Vec::new(), entities: drawing.contacts.iter().map(entity).collect() },
        }
    }

    /// Whether the last picture has an arrow.
    pub(crate) fn any_visible(&self) -> bool {
        self.lengths_m.iter().any(|lengths| lengths[0] > 0.0)
    }

    /// Largest change of an arrow since it was drawn, relative to the longest arrow.
    pub(crate) fn largest_change(&self, contacts: impl Iterator<Item = ContactSample>) -> f64 {
        let change = |(contact, drawn): (ContactSample, &[f64; 2])| {
            let [normal, tangential] = self.lengths(&contact);
            (normal - drawn[0]).abs().max((tangential - drawn[1]).abs())
        };
        contacts.zip(&self.lengths_m).map(change).fold(0.0, f64::max) / self.drawing.longest_arrow_m
    }

    fn lengths(&self, contact: &ContactSample) -> [f64; 2] {
        [contact.normal_n, contact.tangential_n].map(|force| self.drawing.arrow_m(force))
    }

    /// Draws the forces on the phalanges (for a pair of discs, on the first disc), from the contact point along the
    /// normal and along the tangent. A contact without force gets an empty entity, which removes its earlier arrows.
    pub fn draw(&mut self, contacts: impl Iterator<Item = ContactSample>, stamp: Timestamp) -> &SceneUpdate {
        let longest_m = self.drawing.longest_arrow_m;
        for (index, contact) in contacts.enumerate() {
            let [normal, tangential] = self.lengths(&contact);
            self.lengths_m[index] = [normal, tangential];
            let entity = &mut self.update.entities[index];
            entity.timestamp = Some(stamp);
            entity.arrows.clear();
            entity.spheres.clear();
            if contact.normal_n <= 0.0 {
                continue;
            }
            let point_m = contact.point_m;
            entity.arrows.push(arrow(point_m, contact.normal, normal, longest_m, NORMAL));
            if contact.tangential_n != 0.0 {
                entity.arrows.push(arrow(point_m, contact.tangent(), tangential, longest_m, TANGENTIAL));
            }
            let size = POINT_DIAMETER * longest_m;
            entity.spheres.push(SpherePrimitive {
                pose: Some(pose(point_m, 0.0, longest_m)),
                size: Some(Vector3 { x: size, y: size, z: size }),
                color: Some(CONTACT_POINT),
            });
        }
        &self.update
    }
}

fn arrow(point_m: [f64; 2], [x, y]: [f64; 2], length_m: f64, longest_m: f64, colour: Color) -> ArrowPrimitive {
    let sign = length_m.signum();
    let head = (HEAD_LENGTH * longest_m).min(length_m.abs());
    ArrowPrimitive {
        pose: Some(pose(point_m, atan2(sign * y, sign * x), longest_m)),
        shaft_length: length_m.abs() - head,
        shaft_diameter: SHAFT_DIAMETER * longest_m,
        head_length: head,
        head_diameter: HEAD_DIAMETER * longest_m,
        color: Some(colour),
    }
}

fn pose([x, y]: [f64; 2], angle_rad: f64, longest_m: f64) -> Pose {
    Pose {
        position: Some(Vector3 { x, y, z: ARROW_ELEVATION * longest_m }),
        orientation: Some(rotation_about_z(angle_rad)),
    }
}

/// Returns the quaternion of a rotation in the plane.
pub(crate) fn rotation_about_z(angle_rad: f64) -> Quaternion {
    let (sin, cos) = sin_cos(0.5 * angle_rad);
    Quaternion { x: 0.0, y: 0.0, z: sin, w: cos }
}
