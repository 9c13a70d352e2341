//! Offsets of an object that the hand of a mechanism captures: closed forms, direct runs, and rejected plans.

use phalanx::criteria::ObjectTracker;
use phalanx::parallel::Monitor;
use phalanx::scene::{self, Axis, Scene};
use phalanx::study::offsets::{OffsetPlacement, OffsetPlan, Offsets, offsets};
use phalanx::trace::{self, Model};

use crate::support::designs::assert_near;

/// Two synchronised jaws, 42 mm apart, that close slowly on a box of 30 mm without gravity, on a palm that is turned. `start` is the
/// pose of the box in the frame of the palm, m and rad.
fn jaws(turn_deg: f64, [x, y, angle]: [f64; 3]) -> Scene {
    let (sin, cos) = turn_deg.to_radians().sin_cos();
    let at = |u: f64, v: f64| format!("[\"{} m\", \"{} m\"]", cos * u - sin * v, sin * u + cos * v);
    let (left, right, object) = (at(-0.025, 0.0), at(0.025, 0.0), at(x, y));
    let object_rad = angle + turn_deg.to_radians();
    let text = format!(
        r#"
        kind = "mechanism"
        duration = "150 ms"
        [bodies.palm]
        mass = "300 g"
        inertia = "100000 g*mm^2"
        guess = {{ at = ["0 mm", "0 mm"], angle = "{turn_deg} deg" }}
        [bodies.left]
        mass = "20 g"
        inertia = "3000 g*mm^2"
        guess = {{ at = {left}, angle = "{turn_deg} deg" }}
        outlines.pad = {{ type = "box", size = ["8 mm", "20 mm"], rounding = "1 mm" }}
        [bodies.right]
        mass = "20 g"
        inertia = "3000 g*mm^2"
        guess = {{ at = {right}, angle = "{turn_deg} deg" }}
        outlines.pad = {{ type = "box", size = ["8 mm", "20 mm"], rounding = "1 mm" }}
        [bodies.object]
        mass = "100 g"
        inertia = "15000 g*mm^2"
        start = {{ at = {object}, angle = "{object_rad} rad" }}
        outlines.skin = {{ type = "box", size = ["30 mm", "30 mm"], rounding = "1 mm" }}
        [joints.left]
        type = "prismatic"
        bodies = ["palm", "left"]
        points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
        start = "-25 mm"
        [joints.right]
        type = "prismatic"
        bodies = ["palm", "right"]
        points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
        [couplings.synchronised]
        joints = ["left", "right"]
        factors = [1, 1]
        [actuators.grip]
        joint = "left"
        target = "-10 mm"
        target_rate = "0.1 m/s"
        kp = "1e4 N/m"
        kd = "100 N*s/m"
        limit = "40 N"
        [laws.pad]
        stiffness = 1e7
        damping = "3 s/m"
        friction = {{ mu_static = 0.5, law = "bristle", bristle_damping = "1000 N*s/m" }}
        [[contacts]]
        between = ["*.pad", "object"]
        law = "pad"
        [moves.none]
        body = "palm"
        x = "1 um"
        start = "10 s"
        time = "1 s"
        "#
    );
    scene::parse_any(&text, "jaws.toml").unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn run_offsets(scene: &Scene, axes: &[(Axis, f64)], count: usize, tolerance: f64) -> Offsets {
    let plan = OffsetPlan { model: Model::Analytic, axes: axes.to_vec(), count, tolerance };
    offsets(plan, scene, &Monitor::silent(&|| true)).unwrap_or_else(|error| panic!("{error}"))
}

/// Across the jaws, the range is the opening less the box: ±(42 − 30)/2 mm. Along them, the flat sides overlap up to 23 mm; beyond,
/// rounded corners of 1 mm meet at an angle φ with sin φ = (y − 23 mm)/2 mm, and hold up to tan φ = μ.
#[test]
fn parallel_jaws_capture_what_fits_and_overlaps() {
    for turn_deg in [0.0, 40.0] {
        let scene = jaws(turn_deg, [0.0; 3]);
        let across = run_offsets(&scene, &[(Axis::X, 8e-3)], 5, 1e-5);
        assert_eq!((across.base.as_str(), across.object.as_str()), ("palm", "object"));
        let edges = across.captured_range.expect("a range");
        for (edge, sign) in edges.into_iter().zip([-1.0, 1.0]) {
            let lost = edge.lost.expect("an edge");
            assert!((edge.captured * sign..=lost * sign).contains(&6.01e-3), "{turn_deg}: {edge:?}");
        }
        // Beyond, the box would start inside a jaw.
        let inside = across.placements[4].reason.as_deref().expect("a reason");
        assert!(inside.contains("2.000 mm inside `right.pad`"), "{inside}");
        let along = run_offsets(&scene, &[(Axis::Y, 30e-3)], 5, 2e-5);
        let expected_m = 23e-3 + 2e-3 * 0.5f64.atan().sin();
        println!("along: {:?}", along.captured_range);
        for (edge, sign) in along.captured_range.expect("a range").into_iter().zip([-1.0, 1.0]) {
            assert_near(edge.captured * sign, expected_m, 0.15e-3);
        }
    }
}

/// Every place of a map has the fate and the end of a run of the scene with its object there.
#[test]
fn a_map_agrees_with_direct_runs() {
    let map = run_offsets(&jaws(40.0, [0.0; 3]), &[(Axis::X, 4e-3), (Axis::Angle, 0.6)], 3, 1e-5);
    assert!(map.captured_range.is_none());
    let offsets: Vec<[f64; 3]> = map.placements.iter().map(|placement| placement.offset).collect();
    assert_eq!(offsets.len(), 9);
    assert_eq!((offsets[0], offsets[5]), ([-4e-3, 0.0, -0.6], [0.0, 0.0, 0.6]));
    let mut captured = 0;
    for OffsetPlacement { offset, fate, tts_s, slip, reason, .. } in &map.placements {
        if let Some(reason) = reason {
            assert!(reason.contains("inside"), "{reason}");
            continue;
        }
        let scene = jaws(40.0, *offset);
        let mut tracker = ObjectTracker::for_scene(&scene).expect("a grasp");
        trace::run(Model::Analytic, &scene, &mut tracker).unwrap_or_else(|error| panic!("{error}"));
        let direct = tracker.criteria().expect("criteria");
        assert_eq!(*fate, Some(direct.fate.name()), "{offset:?}");
        for (found, expected) in
            [(*tts_s, direct.tts_s), (slip.map(|of| of.displacement_m), direct.slip.map(|of| of.displacement_m))]
        {
            let differs = found.zip(expected).map_or(found != expected, |(a, b)| (a - b).abs() > 1e-4 * b.abs() + 1e-7);
            assert!(!differs, "{offset:?}: {found:?} {expected:?}");
        }
        captured += usize::from(*fate == Some("held"));
    }
    println!("{captured} of 9 captured");
    assert!(captured >= 3, "{captured}");
}

#[test]
fn plans_of_offsets_are_checked() {
    let plan = |axes: &[Axis], count: usize| {
        let axes = axes.iter().map(|axis| (*axis, 1e-3)).collect();
        OffsetPlan { model: Model::Analytic, axes, count, tolerance: 1e-5 }.check()
    };
    assert!(plan(&[Axis::X], 1001).is_ok() && plan(&[Axis::Y, Axis::Angle], 99).is_ok());
    for axes in [&[][..], &[Axis::X, Axis::X], &[Axis::X, Axis::Y, Axis::Angle]] {
        assert!(plan(axes, 3).is_err_and(|message| message.contains("one or two of x, y and angle")), "{axes:?}");
    }
    assert!(plan(&[Axis::X, Axis::Y], 101).is_err_and(|message| message.contains("10201 runs")));
}
