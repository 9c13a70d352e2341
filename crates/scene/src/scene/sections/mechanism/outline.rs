//! Outlines of a mechanism, and which of two outlines has the points of a contact.

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::limits::MAX_CORNERS;
use crate::mechanism::{Outline, OutlineShape, rounded_core};
use crate::numeric::elementary::{hypot, sin_cos};
use crate::numeric::plane::{add, cross, rotate, sub};
use crate::scene::quantity::{Angle, Length, NotNegative, Plain, Positive, Quantity, keyword_enum};
use crate::scene::section_input::SectionInput;
use crate::units::{Dimension, format};

keyword_enum! {
    pub enum OutlineKind {
        Disc = "disc",
        Capsule = "capsule",
        Box = "box",
        Polygon = "polygon",
        Ellipse = "ellipse",
        HalfPlane = "half_plane",
    }
}

/// An outline: a disc, a capsule (a segment with a radius), a convex polygon with rounded corners, an ellipse, or a
/// half plane.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct OutlineSettings {
    /// "disc", "capsule", "box", "polygon" (convex), "ellipse" (can only touch with its points) or "half_plane" (can
    /// only be touched). Required.
    #[schemars(extend("x-required" = "add the type of the outline: type = \"disc\", \"capsule\", \"box\", \"polygon\", \
        \"ellipse\" or \"half_plane\""))]
    pub r#type: Option<OutlineKind>,
    /// Centre of a disc, a box or an ellipse.
    #[schemars(extend("x-with" = "type = disc|box|ellipse", "default" = ["0 mm", "0 mm"]))]
    pub center: Option<[Quantity<Length>; 2]>,
    /// Width and height of a box, along its own axes.
    #[schemars(extend("x-with" = "type = box", "x-required" = "add width and height: size = [\"40 mm\", \"30 mm\"]"))]
    pub size: Option<[Positive<Length>; 2]>,
    /// Semi-axes of an ellipse.
    #[schemars(extend("x-with" = "type = ellipse",
        "x-required" = "add both semi-axes: semi_axes = [\"20 mm\", \"15 mm\"]"))]
    pub semi_axes: Option<[Positive<Length>; 2]>,
    /// Angle of the first axis of a box or an ellipse.
    #[schemars(extend("x-with" = "type = box|ellipse", "default" = "0 deg"))]
    pub angle: Option<Quantity<Angle>>,
    /// Corners of a polygon, counter-clockwise.
    #[schemars(extend("x-with" = "type = polygon",
        "x-required" = "add the corners: vertices = [[\"0 mm\", \"0 mm\"], [\"30 mm\", \"0 mm\"], [\"0 mm\", \"20 mm\"]]"))]
    pub vertices: Option<Vec<[Quantity<Length>; 2]>>,
    /// Radius of the rounded corners of a box or a polygon, inside the given shape. Two outlines without any radius
    /// cannot touch.
    #[schemars(extend("x-with" = "type = box|polygon", "default" = "0 mm"))]
    pub rounding: Option<NotNegative<Length>>,
    /// First end of the capsule's segment.
    #[schemars(extend("x-with" = "type = capsule", "x-required" = "add the first end: from = [\"0 mm\", \"0 mm\"]"))]
    pub from: Option<[Quantity<Length>; 2]>,
    /// Second end of the capsule's segment.
    #[schemars(extend("x-with" = "type = capsule", "x-required" = "add the second end: to = [\"0 mm\", \"30 mm\"]"))]
    pub to: Option<[Quantity<Length>; 2]>,
    /// Disc: its radius (required). Capsule: half its width (required). Polygon: distance by which the outline lies
    /// outside `vertices`; replaces `rounding`.
    #[schemars(extend("x-with" = "type = disc|capsule|polygon"))]
    pub radius: Option<Positive<Length>>,
    /// A point of the half plane's edge.
    #[schemars(extend("x-with" = "type = half_plane", "default" = ["0 mm", "0 mm"]))]
    pub point: Option<[Quantity<Length>; 2]>,
    /// Direction out of the half plane, a vector of any length.
    #[schemars(extend("x-with" = "type = half_plane", "x-required" = "add the direction out of the solid: normal = [0, 1]"))]
    pub normal: Option<[Quantity<Plain>; 2]>,
}

/// The SI values of a pair.
pub(super) fn si<const N: usize, D, R>(values: [Quantity<D, R>; N]) -> [f64; N] {
    values.map(|value| *value)
}

/// Resolves an outline.
pub(crate) fn outline(section: &SectionInput<'_>) -> Option<OutlineShape> {
    let settings: OutlineSettings = section.read();
    let kind = settings.r#type?;
    if matches!(kind, OutlineKind::Disc | OutlineKind::Capsule) && !section.has("radius") {
        section.report_missing("radius", "add the radius: radius = \"5 mm\"");
    }
    let radius = settings.radius.map(|radius| *radius);
    Some(match kind {
        OutlineKind::Disc => OutlineShape::Disc { center_m: si(settings.center?), radius_m: radius? },
        OutlineKind::Capsule => {
            let (from_m, to_m) = (si(settings.from?), si(settings.to?));
            if from_m == to_m {
                let message = format!("both ends of `{}` are the same point", section.path(""));
                return section.refuse("to", message, "the same as `from`", "move one end, or use a disc");
            }
            OutlineShape::Capsule { from_m, to_m, radius_m: radius? }
        }
        OutlineKind::Box => {
            let ([width, height], center_m) = (si(settings.size?), si(settings.center?));
            let (sin, cos) = sin_cos(*settings.angle?);
            let corner = |[x, y]: [f64; 2]| add(center_m, rotate([0.5 * x * width, 0.5 * y * height], [cos, sin]));
            let outer_m = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(corner);
            rounded(section, &outer_m, *settings.rounding?)?
        }
        OutlineKind::Polygon => {
            let vertices_m: Vec<[f64; 2]> = settings.vertices?.into_iter().map(si).collect();
            check_convex(section, &vertices_m)?;
            match radius {
                Some(radius_m) => {
                    section.report_unused(["rounding"], "with `radius`");
                    OutlineShape::Polygon { vertices_m, radius_m }
                }
                None => rounded(section, &vertices_m, *settings.rounding?)?,
            }
        }
        OutlineKind::Ellipse => OutlineShape::Ellipse {
            center_m: si(settings.center?),
            semi_axes_m: si(settings.semi_axes?),
            angle_rad: *settings.angle?,
        },
        OutlineKind::HalfPlane => {
            let normal = si(settings.normal?);
            let length = hypot(normal[0], normal[1]);
            if !length.is_normal() {
                let message = format!("`{}` has no direction", section.path("normal"));
                let help = "write the direction out of the solid: [0, 1]";
                return section.refuse("normal", message, "of length 0", help);
            }
            OutlineShape::HalfPlane { point_m: si(settings.point?), normal: normal.map(|part| part / length) }
        }
    })
}

/// The polygon whose outer shape has these corners.
fn rounded(section: &SectionInput<'_>, outer_m: &[[f64; 2]], rounding_m: f64) -> Option<OutlineShape> {
    match rounded_core(outer_m, rounding_m) {
        Ok(vertices_m) => Some(OutlineShape::Polygon { vertices_m, radius_m: rounding_m }),
        Err(largest_m) => {
            let largest = format(largest_m, Dimension::Length);
            let message = format!("`{}` must be below {largest}: a side vanishes", section.path("rounding"));
            let help = "make it smaller, or use a capsule, which is a box whose short sides are round";
            section.refuse("rounding", message, "too large", help)
        }
    }
}

/// Checks that a polygon is convex and counter-clockwise.
fn check_convex(section: &SectionInput<'_>, vertices_m: &[[f64; 2]]) -> Option<()> {
    let (path, count) = (section.path("vertices"), vertices_m.len());
    if !(3..=MAX_CORNERS).contains(&count) {
        let message = format!("`{path}` has {count} corners, but must have 3 to {MAX_CORNERS}");
        let help = "for two points use a capsule, for a curve a disc or an ellipse";
        return section.refuse("vertices", message, &format!("{count} corners"), help);
    }
    // Every corner lies on the inner side of every side that it does not belong to.
    let concave_corner = |sign: f64| {
        (0..count).find(|k| {
            let (from, to) = (vertices_m[*k], vertices_m[(k + 1) % count]);
            let is_outside = |other: usize| sign * cross(sub(to, from), sub(vertices_m[other], from)) <= 0.0;
            (0..count).any(|other| other != *k && other != (k + 1) % count && is_outside(other))
        })
    };
    match (concave_corner(1.0), concave_corner(-1.0)) {
        (None, _) => Some(()),
        (Some(_), None) => {
            let message = format!("the corners of `{path}` are clockwise");
            section.refuse("vertices", message, "clockwise", "write them in the reverse order, counter-clockwise")
        }
        (Some(k), Some(_)) => {
            let next = (k + 1) % count;
            let message =
                format!("`{path}` is not convex: corners lie on both sides of the line from {k} to {next}, or on it");
            let help =
                "remove corners that lie on a side, or divide the shape into several convex outlines of the body";
            section.refuse("vertices", message, "not convex", help)
        }
    }
}

/// Settings of an outline by its name. Polygons are shown by their core, from which they are read without rounding errors.
pub(super) fn outline_settings(outline: &Outline) -> (String, Value) {
    let settings = match &outline.shape {
        OutlineShape::Disc { center_m, radius_m } => {
            json!({ "type": OutlineKind::Disc, "center": center_m, "radius": radius_m })
        }
        OutlineShape::Capsule { from_m, to_m, radius_m } => {
            json!({ "type": OutlineKind::Capsule, "from": from_m, "to": to_m, "radius": radius_m })
        }
        OutlineShape::Polygon { vertices_m, radius_m } => {
            // Without a radius the core is the outer shape.
            let radius_m = Some(radius_m).filter(|radius_m| **radius_m > 0.0);
            json!({ "type": OutlineKind::Polygon, "vertices": vertices_m, "radius": radius_m })
        }
        OutlineShape::HalfPlane { point_m, normal } => {
            json!({ "type": OutlineKind::HalfPlane, "point": point_m, "normal": normal })
        }
        OutlineShape::Ellipse { center_m, semi_axes_m, angle_rad } => json!({
            "type": OutlineKind::Ellipse,
            "center": center_m,
            "semi_axes": semi_axes_m,
            "angle": angle_rad,
        }),
    };
    (outline.name.clone(), settings)
}
