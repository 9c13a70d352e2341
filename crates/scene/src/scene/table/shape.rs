//! Keys for the shape of a body, in `[object]` and `[discs.NAME]`.

use super::settings;
use crate::scene::check::POSITIVE;
use crate::scene::defaults;
use crate::scene::keywords::SceneKind;
use crate::scene::value_kinds::Length;
use crate::shape::Shape;

/// A shape without size, for a size that is required or unused.
pub const UNSET_SHAPE: Shape = Shape::Disc { radius_m: f64::NAN };

settings! {
    /// The shape of a body.
    Shape = defaults::OBJECT, s, where {
        fn defaults_for(kind: SceneKind) -> Self {
            match kind {
                SceneKind::Bodies => UNSET_SHAPE,
                SceneKind::Finger | SceneKind::Gripper => Self::defaults(),
            }
        }
    };
    "radius": Length = match s {
        Shape::Disc { radius_m } => Some(radius_m),
    }, allowed(POSITIVE), required("add its size: radius = \"10 mm\"");
}
