//! Palm, ground and table in the palm's frame.

use super::body::{Body, BodyRole, Pose, Shape};
use crate::numeric::elementary::sin_cos;
use crate::scene::{PalmMotion, System};

/// Returns the existing planes, in the order of their poses.
pub(super) fn plane_bodies(system: &System) -> Vec<Body> {
    let plane = |name: &str, fixed: bool, level_m: f64| Body {
        name: name.to_string(),
        role: BodyRole::Palm,
        fixed,
        shapes: vec![Shape::HalfPlane { level_m }],
    };
    let below = if system.fingers.is_empty() { "plane" } else { "palm" };
    let palm = system.palm.map(|palm| plane(below, true, palm.level_m));
    // The pose contains the level.
    let table = system.table.map(|_| plane("table", system.palm_motion.is_none(), 0.0));
    palm.into_iter().chain(table).collect()
}

/// Poses and velocities of the planes.
pub(super) fn plane_poses(system: &System, time_s: f64) -> impl Iterator<Item = (Pose, Pose)> {
    let palm = system.palm.map(|_| (Pose::default(), Pose::default()));
    palm.into_iter().chain(system.table.map(|surface| table(surface.level_m, system.palm_motion.as_ref(), time_s)))
}

/// Pose and velocity of a table, solid above its level, which is at rest in the world while the palm moves. The origin
/// is the table point above the palm's origin; sliding along the surface is not visible and is ignored.
fn table(level_m: f64, palm: Option<&PalmMotion>, time_s: f64) -> (Pose, Pose) {
    let palm = palm.map_or_else(Default::default, |motion| motion.pose(time_s));
    let ([_, y, angle], [_, rise, turning]) = (palm.position, palm.rate);
    let ((sin, cos), height) = (sin_cos(angle), level_m - y);
    let pose = Pose { position_m: [height * sin, height * cos], angle_rad: std::f64::consts::PI - angle };
    let velocity = [turning * height * cos - rise * sin, -turning * height * sin - rise * cos];
    (pose, Pose { position_m: velocity, angle_rad: -turning })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Axis, Move};

    /// The palm rises and turns; the table sinks and turns back, and its velocities match differences of its poses.
    #[test]
    fn a_table_at_rest_moves_against_the_palm() {
        let single_move = |axis, distance| Move { axis, distance, start_s: 0.1, length_s: 0.2 };
        let moves = vec![single_move(Axis::X, 0.2), single_move(Axis::Y, -0.03), single_move(Axis::Angle, 0.4)];
        let motion = PalmMotion { moves, ..PalmMotion::default() };
        let at = |time_s: f64| table(0.04, Some(&motion), time_s);
        assert_eq!(at(0.05), table(0.04, None, 0.05));
        let palm = motion.pose(0.17).position;
        let (pose, rates) = at(0.17);
        let in_world = |[x, y]: [f64; 2]| {
            let (sin, cos) = palm[2].sin_cos();
            [palm[0] + cos * x - sin * y, palm[1] + sin * x + cos * y]
        };
        for along_m in [-0.1, 0.0, 0.3] {
            let [_, y] = in_world(pose.apply([along_m, 0.0]));
            assert!((y - 0.04).abs() < 1e-15, "{y}");
        }
        let [_, beyond] = in_world(pose.apply([0.0, -0.01]));
        assert!((beyond - 0.05).abs() < 1e-15, "the table is solid above its level: {beyond}");
        let (ahead, behind) = (at(0.17 + 1e-6).0, at(0.17 - 1e-6).0);
        for (rate, [ahead, behind]) in [
            (rates.position_m[0], [ahead.position_m[0], behind.position_m[0]]),
            (rates.position_m[1], [ahead.position_m[1], behind.position_m[1]]),
            (rates.angle_rad, [ahead.angle_rad, behind.angle_rad]),
        ] {
            assert!((rate - (ahead - behind) / 2e-6).abs() < 1e-7, "{rate}");
        }
    }
}
