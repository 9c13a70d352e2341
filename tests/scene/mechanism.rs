//! Scenes of mechanisms: their samples.

use phalanx::trace::schema::JointState;
use phalanx::trace::{ContactSample, Sample, Schema, interpolate};

use crate::support::mechanism_cases::mechanism_case;

/// Names of the channels of a case.
fn columns(name: &str) -> Vec<String> {
    let schema = Schema::from_scene(&mechanism_case(name).scene());
    schema.channels().into_iter().map(|channel| channel.name).collect()
}

#[test]
fn channels_follow_from_joints_actuators_bodies_and_contacts() {
    let slider = columns("b_swinging_slider");
    let expected = "time_s arm_rad arm_rate_rad_s arm_force_x_n arm_force_y_n \
        slide_position_m slide_rate_m_s slide_force_x_n slide_force_y_n slide_moment_n_m push_force_n \
        arm_x_m arm_y_m arm_angle_rad arm_vx_m_s arm_vy_m_s arm_spin_rad_s";
    assert_eq!(slider[..17].join(" "), expected);
    assert_eq!(slider[17], "block_x_m");

    let finger = columns("c_f85_link_pad");
    for name in
        ["r_coupler_rate_rad_s", "motor_torque_n_m", "ground.disc/r_link.face_normal_n", "r_coupler_upper_gap_rad"]
    {
        assert!(finger.iter().any(|column| column == name), "{name} is not among {finger:?}");
    }
}

#[test]
fn samples_hold_the_states_of_a_mechanism() {
    let schema = Schema::from_scene(&mechanism_case("c_f85_two_disc").scene());
    let counts = schema.counts();
    assert_eq!((counts.joints, counts.actuators, counts.bodies, counts.contacts, counts.limits), (10, 2, 9, 6, 2));
    let sample_at = |time_s: f64| {
        let mut sample = Sample::new(time_s, counts);
        for index in 0..counts.joints {
            let rate = 0.125 * (1 + index) as f64;
            let force_n = [rate * time_s, 2.0];
            let joint = JointState { angle_rad: rate * time_s, rate_rad_s: rate, force_n, moment_n_m: -time_s };
            sample.set_joint(index, &joint);
        }
        sample.set_actuator(1, 0.25);
        sample.set_contact(5, &ContactSample { gap_m: 0.3, normal_n: time_s, ..ContactSample::default() });
        sample
    };
    let middle = interpolate(&sample_at(0.0), &sample_at(1.0), 0.5);
    let joint = middle.joint_state(9);
    assert_eq!((joint.angle_rad, joint.rate_rad_s, joint.force_n, joint.moment_n_m), (0.625, 1.25, [0.625, 2.0], -0.5));
    assert_eq!((middle.actuator(0), middle.actuator(1), middle.contact(5).normal_n), (0.0, 0.25, 0.5));
    assert!(middle.is_stop(4) && middle.is_stop(5) && !middle.is_stop(3));
    assert_eq!(middle.surfaces().count(), 4);
    let channel = |subject: &str, key: &str| {
        let channels =
            schema.subjects().into_iter().filter(|found| found.name == subject).flat_map(|found| {
                found.channels().map(|(quantity, channel)| (quantity.key, channel)).collect::<Vec<_>>()
            });
        channels.into_iter().find(|(found, _)| *found == key).expect("a channel").1
    };
    assert_eq!(channel("l_coupler_lower", "torque_n_m").value(&middle), 0.5);
    assert_eq!(channel("l_motor", "torque_n_m").value(&middle), 0.25);
    // The contacts of another order keep the joints, and know their limits.
    let selected = middle.select(&[8], &[0, 5]);
    assert_eq!((selected.joint_state(9), selected.contact(1)), (middle.joint_state(9), middle.contact(5)));
    assert!(selected.is_stop(1) && !selected.is_stop(0));
}
