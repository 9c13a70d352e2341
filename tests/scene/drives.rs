//! Keys of gears, motors, feedback and limits of sums.

use phalanx::drive::Profile;
use phalanx::mechanism::{Command, DistanceFeedback, GearLoss, Motor, PointId};
use phalanx::scene::{self, Scene};

use super::{assert_round_trip, parse};
use crate::support::mechanism_cases::drive_cases;

/// Two jaws that are images of one another, and an arm with a geared motor.
const JAWS: &str = r#"
kind = "mechanism"
duration = "20 ms"
gravity = ["0 m/s^2", "0 m/s^2"]
[mirror]
from = "right"
to = "left"
[parameters]
ratio = 15
lead = "4 mm"
[bodies.right_jaw]
mass = "80 g"
inertia = "20 kg*mm^2"
guess = { at = ["40 mm", "0 mm"] }
points.tip.at = ["-5 mm", "1 mm"]
[bodies.arm]
mass = "80 g"
inertia = "20 kg*mm^2"
[ground.points.pivot]
at = ["0 mm", "3 mm"]
[joints.right_slide]
type = "prismatic"
bodies = ["ground", "right_jaw"]
points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
start = "40 mm"
[joints.arm]
bodies = ["ground", "arm"]
points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
start = "0 deg"
[laws.stop]
type = "hunt_crossley"
stiffness = 1e6
exponent = 1.5
damping = "0.1 s/m"
[actuators.right_grip]
joint = "right_slide"
lead = "= lead"
rotor = "1 g*cm^2"
efficiency = 0.7
loss_rate = "2 mm/s"
target = "30 mm"
target_rate = "50 mm/s"
kp = "20 V/mm"
kd = "1 V*s/m"
motor = { torque_constant = "9 mN*m/A", resistance = "3 Ω", voltage = "12 V", current_limit = "500 mA", inductance = "0.3 mH" }
feedback = { distance = ["ground.pivot", "right_jaw.tip"] }
[actuators.arm]
joint = "arm"
gear = "= 2 * ratio"
efficiency = 0.6
loss_stiffness = "200 N*m/rad"
torque = "5 N*mm"
limit = "20 N*mm"
no_load_speed = "6000 rpm"
[limits.right_play]
joints = ["right_slide", "left_slide"]
factors = [1, -0.5]
upper = "60 mm"
stop = "stop"
"#;

#[test]
fn keys_of_drives_are_read_with_their_images() {
    let scene = parse(JAWS);
    let of = scene.mechanism.as_ref().expect("a mechanism");
    let names: Vec<&str> = of.actuators.iter().map(|actuator| actuator.name.as_str()).collect();
    assert_eq!(names, ["arm", "left_grip", "right_grip"]);
    let [arm, left, right] = &of.actuators[..] else { panic!("three actuators") };
    let powertrain = &arm.powertrain;
    let loss = powertrain.loss.expect("a loss");
    assert_eq!((powertrain.gear, loss.efficiency, powertrain.motor), (30.0, 0.6, None));
    assert!((loss.bristle.expect("a bristle").damping_n_s_per_m - 0.2).abs() < 1e-15);
    assert!((arm.no_load_speed.expect("a speed") - 200.0 * std::f64::consts::PI).abs() < 1e-9);
    assert!((arm.effort_limit().expect("a limit") - 0.6).abs() < 1e-15);
    let powertrain = &right.powertrain;
    assert!((powertrain.gear * 4e-3 - std::f64::consts::TAU).abs() < 1e-12);
    assert_eq!(powertrain.loss, Some(GearLoss { efficiency: 0.7, rate: 2e-3, bristle: None }));
    assert_eq!(
        powertrain.motor,
        Some(Motor {
            torque_constant: 9e-3,
            resistance: 3.0,
            current_limit: Some(0.5),
            back_emf: 9e-3,
            inductance: Some(3e-4),
        })
    );
    assert!((powertrain.reflected_inertia() - powertrain.gear.powi(2) * 1e-7).abs() < 1e-9);
    let Command::Servo { kp, kd, target: Profile::Table { points, .. }, .. } = &right.command else {
        panic!("a controller with a rate of its target")
    };
    assert_eq!((*kp, *kd, right.limit), (20e3, 1.0, Some(12.0)));
    // The set point starts at the distance, not at the coordinate.
    assert!((points[0].1 - 35e-3f64.hypot(2e-3)).abs() < 1e-12, "{points:?}");
    let points = |body: usize| [PointId { body: None, point: 0 }, PointId { body: Some(body), point: 0 }];
    let body = |name: &str| of.bodies.iter().position(|body| body.name == name).expect("a body");
    for (actuator, name) in [(left, "left_jaw"), (right, "right_jaw")] {
        let expected = DistanceFeedback { points: points(body(name)), sign: 1.0 };
        assert_eq!(actuator.powertrain.feedback, Some(expected), "{name}");
    }
    assert_eq!(of.bodies[body("left_jaw")].points[0].at_m, [5e-3, 1e-3]);
    let [left, right] = &of.sum_limits[..] else { panic!("limits and their image") };
    assert_eq!((left.name.as_str(), right.upper, right.lower), ("left_play", Some(0.06), None));
    let joint = |name: &str| of.joints.iter().position(|joint| joint.name == name).expect("a joint");
    assert_eq!(left.on.terms, [(joint("left_slide"), 1.0), (joint("right_slide"), -0.5)]);
}

#[test]
fn drives_round_trip_through_show() {
    for case in drive_cases() {
        let shown = scene::show(&case.scene());
        assert_round_trip(&parse(&shown));
    }
    let scene = parse(JAWS);
    assert_round_trip(&Scene { source: String::new(), ..scene });
}

#[test]
fn fields_of_drives_can_be_set() {
    let with = |from: &str, to: &str| {
        let scene = parse(&JAWS.replace(from, to));
        scene.mechanism.expect("a mechanism").actuators
    };
    assert_eq!(with("ratio = 15", "ratio = 20")[0].powertrain.gear, 40.0);
    let expression = with("resistance = \"3 Ω\"", "resistance = \"= 12 V / 6 A\"");
    assert_eq!(expression[2].powertrain.motor.expect("a motor").resistance, 2.0);
}
