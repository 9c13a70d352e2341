//! What says of which shape a body is, wherever one is described: `[object]` and `[discs.NAME]`.

use super::lines;
use crate::scene::check::POSITIVE;
use crate::scene::defaults;
use crate::scene::kinds::Length;
use crate::scene::words::SceneKind;
use crate::shape::Shape;

/// One whose size must be given, or means nothing.
pub const UNSAID: Shape = Shape::Disc { radius_m: f64::NAN };

lines! {
    /// The shape of a body.
    Shape = defaults::OBJECT, s, where {
        fn usual_in(kind: SceneKind) -> Self {
            match kind {
                SceneKind::Bodies => UNSAID,
                SceneKind::Finger | SceneKind::Gripper => Self::usual(),
            }
        }
    };
    "radius": Length = match s {
        Shape::Disc { radius_m } => Some(radius_m),
    }, allowed(POSITIVE), needed("add its size: radius = \"10 mm\"");
}
