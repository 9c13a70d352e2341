//! The grasped object.

use super::super::check::Checker;
use super::super::table::input::SectionInput;
use super::super::table::object::{GraspedMotion, ObjectSettings};
use super::super::table::{SettingsSection, read};
use super::super::value_kinds::{Length, Pair};
use super::super::{Disc, defaults};
use crate::shape::{self, PlacedShape, Shape};
use crate::units::{Dimension, format};

/// Resolves the shape of the object.
pub fn shape(checker: &mut Checker<'_>, input: &SectionInput<'_>) -> Shape {
    read(checker, "object", &input.subsection("object"), Shape::defaults())
}

/// Moves a shape perpendicular to the palm such that it rests on the palm.
pub fn rest_on_palm(placed: PlacedShape) -> PlacedShape {
    let [x, _] = placed.centre_m;
    let [_, below] = placed.at([x, 0.0]).lowest_point_m();
    placed.at([x, -below])
}

/// Resolves the object, with the defaults that depend on its shape.
pub fn object_settings(checker: &mut Checker<'_>, input: &SectionInput<'_>) -> ObjectSettings {
    let shape = shape(checker, input);
    let mut object = ObjectSettings {
        shape,
        ..read(checker, "object", &input.subsection("object"), ObjectSettings::defaults_for(input.kind))
    };
    if object.centre_m[1].is_nan() {
        object.centre_m = rest_on_palm(object.placed()).centre_m;
    }
    if let GraspedMotion::Free { mass_kg, inertia_kg_m2, .. } = &mut object.motion {
        if mass_kg.is_nan() {
            *mass_kg = shape::mass(&shape, defaults::DENSITY_KG_M3, defaults::DEPTH_M);
        }
        if inertia_kg_m2.is_nan() {
            *inertia_kg_m2 = shape::inertia(&shape, *mass_kg);
        }
    }
    object
}

/// Resolves the object of a single finger: an empty list without object, `None` if it is invalid.
pub fn single_object(
    checker: &mut Checker<'_>,
    input: &SectionInput<'_>,
    object_settings: ObjectSettings,
    base_m: Option<f64>,
) -> Option<Vec<Disc>> {
    let ObjectSettings { present, shape, centre_m, .. } = object_settings;
    let object = input.subsection("object");
    if !present {
        if !input.subsection("design").is_present() {
            checker.report_unused_at("object.radius", object.span("radius"), "with present = false and no [design]");
        }
        return Some(Vec::new());
    }
    // An invalid centre has been reported.
    object.is_valid::<Pair<Length>>("centre").then_some(())?;
    let ([x, y], lengths) = (centre_m, input.subsection("lengths"));
    if x.is_finite() {
        checker.report_unused_at("lengths.base", lengths.span("base"), "with object.centre");
        return Some(vec![Disc::fixed_object(shape.at(centre_m))]);
    }
    if base_m.is_none() && lengths.is_present() && !lengths.has("base") {
        let [base, height] = [example_base_m(input, &shape), y].map(|metres| format(metres, Dimension::Length));
        let help = format!(
            "add the distance along the palm to the object's centre, such as [lengths] base = \"{base}\", or [object] centre = \
             [\"-{base}\", \"{height}\"], or [object] present = false"
        );
        checker.report_missing_at("lengths.base", lengths.span, &help);
    }
    Some(vec![Disc::fixed_object(shape.at([-base_m?, y]))])
}

/// Example of a base for messages, with three digits. As in the example of the thesis, it exceeds the smallest base of
/// a design (D > R, see `gripper::proximal_range`).
pub fn example_base_m(input: &SectionInput<'_>, shape: &Shape) -> f64 {
    let half_width_m = input.value::<Length>("half_width").unwrap_or(defaults::HALF_WIDTH_M);
    let reach_m = shape::max_radius(shape);
    let base_m = (half_width_m * (2.0 * reach_m + half_width_m)).sqrt() + 0.25 * reach_m;
    format!("{base_m:.2e}").parse().unwrap_or(base_m)
}
