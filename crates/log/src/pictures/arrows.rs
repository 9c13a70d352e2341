//! Contact points and forces as foxglove primitives, one entity a contact.

use foxglove::messages::{ArrowPrimitive, Color, Pose, SceneEntity, SceneUpdate, SpherePrimitive, Timestamp, Vector3};

use super::frame::{WORLD, about_z};
use phalanx_core::drawing::Drawing;
use phalanx_core::numeric::elementary::atan2;
use phalanx_core::trace::ContactSample;

/// Over everything else, and thickness of arrows and points, as parts of the longest arrow.
const HEIGHT: f64 = 0.05;
const SHAFT: f64 = 0.02;
const HEAD: f64 = 0.05;
const HEAD_LENGTH: f64 = 0.08;
const POINT: f64 = 0.05;

const NORMAL: Color = Color { r: 0.85, g: 0.1, b: 0.1, a: 1.0 };
const TANGENTIAL: Color = Color { r: 0.5, g: 0.2, b: 0.8, a: 1.0 };
const TOUCH: Color = Color { r: 0.1, g: 0.1, b: 0.1, a: 1.0 };

/// The arrows as they were drawn last.
pub struct Arrows {
    drawing: Drawing,
    /// Lengths of normal and tangential arrow of each contact.
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

    /// Whether an arrow was drawn last.
    pub fn any(&self) -> bool {
        self.lengths_m.iter().any(|lengths| lengths[0] > 0.0)
    }

    /// Largest change of an arrow since it was drawn, as a part of the longest one.
    pub fn change<'a>(&self, contacts: impl Iterator<Item = &'a ContactSample>) -> f64 {
        let change = |(contact, shown): (&ContactSample, &[f64; 2])| {
            let [normal, tangential] = self.lengths(contact);
            (normal - shown[0]).abs().max((tangential - shown[1]).abs())
        };
        contacts.zip(&self.lengths_m).map(change).fold(0.0, f64::max) / self.drawing.longest_arrow_m
    }

    fn lengths(&self, contact: &ContactSample) -> [f64; 2] {
        [contact.normal_n, contact.tangential_n].map(|force| self.drawing.arrow_m(force))
    }

    /// The arrows of forces on the phalanges (on the disc of a pair): from the contact point along the normal and along the
    /// surface. A contact without force has none, which takes away what it had.
    pub fn draw<'a>(&mut self, contacts: impl Iterator<Item = &'a ContactSample>, stamp: Timestamp) -> &SceneUpdate {
        let longest_m = self.drawing.longest_arrow_m;
        for (index, contact) in contacts.enumerate() {
            let [normal, tangential] = self.lengths(contact);
            self.lengths_m[index] = [normal, tangential];
            let entity = &mut self.update.entities[index];
            entity.timestamp = Some(stamp);
            entity.arrows.clear();
            entity.spheres.clear();
            if contact.normal_n <= 0.0 {
                continue;
            }
            let at = contact.point_m;
            entity.arrows.push(arrow(at, contact.normal, normal, longest_m, NORMAL));
            if contact.tangential_n != 0.0 {
                entity.arrows.push(arrow(at, contact.tangent(), tangential, longest_m, TANGENTIAL));
            }
            let size = POINT * longest_m;
            entity.spheres.push(SpherePrimitive {
                pose: Some(pose(at, 0.0, longest_m)),
                size: Some(Vector3 { x: size, y: size, z: size }),
                color: Some(TOUCH),
            });
        }
        &self.update
    }
}

fn arrow(at: [f64; 2], [x, y]: [f64; 2], length_m: f64, longest_m: f64, colour: Color) -> ArrowPrimitive {
    let sign = length_m.signum();
    let head = (HEAD_LENGTH * longest_m).min(length_m.abs());
    ArrowPrimitive {
        pose: Some(pose(at, atan2(sign * y, sign * x), longest_m)),
        shaft_length: length_m.abs() - head,
        shaft_diameter: SHAFT * longest_m,
        head_length: head,
        head_diameter: HEAD * longest_m,
        color: Some(colour),
    }
}

fn pose([x, y]: [f64; 2], angle_rad: f64, longest_m: f64) -> Pose {
    Pose { position: Some(Vector3 { x, y, z: HEIGHT * longest_m }), orientation: Some(about_z(angle_rad)) }
}
