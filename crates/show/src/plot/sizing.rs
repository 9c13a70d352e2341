//! A sizing along its test trajectory (thesis Figs. 3.1–3.3).

use super::canvas::{Marker, THIN_LINE};
use super::chart::{Axis, Panel, Series, panel_chart};
use super::theme::{BLUE, Colour, GREEN, ORANGE, PURPLE, SOFT};
use crate::sizing::{Profile, ProfilePoint};

/// Draws three pictures of a sizing. Fig. 3.1: angle, rate and acceleration of the motor link, and the angles of the
/// phalanges. Fig. 3.2: the spring torque required in the rigid phase, for each placement. Fig. 3.3: the motor torque
/// for either type of spring.
pub fn sizing(scene: &str, profile: &Profile) -> [String; 3] {
    let curve = |colour: Colour, value: &dyn Fn(&ProfilePoint) -> Option<f64>| {
        let points = profile.points.iter().filter_map(|point| Some((point.time_s * 1e3, value(point)?)));
        Series::new(Marker::Line { width: 2.0 }, colour, points)
    };
    let straight = profile.closing.start.q22_rad;
    let angles = vec![
        curve(BLUE, &|point| Some(point.q11_rad.to_degrees())).named("q11"),
        curve(ORANGE, &|point| Some(point.q21_rad.to_degrees())).named("q21"),
        curve(GREEN, &|point| Some((point.q22_rad - straight).to_degrees())).named("q22 + φ22"),
    ];
    let spring = |(placement, (name, colour)): (usize, (&str, Colour))| {
        curve(colour, &|point| point.springs_n_m.map(|springs| springs[placement] * 1e3)).named(name)
    };
    let placements = [("q21 − q11", BLUE), ("q12", ORANGE), ("q22", GREEN), ("q11+q12−(q21+q22)", PURPLE)];
    let torques = vec![
        curve(ORANGE, &|point| Some(point.torsional_n_m * 1e3)).named("torsional spring"),
        curve(BLUE, &|point| Some(point.constant_n_m * 1e3)).named("constant spring"),
        curve(GREEN, &|point| point.net_n_m.map(|n_m| n_m * 1e3)).named("net, distal held"),
    ];
    let x = Axis::linear("time, ms", [0.0, profile.closing.trajectory.length_s * 1e3]);
    let panel = |(label, curves): (&str, Vec<Series>)| {
        let y = Axis::linear(label, curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.1)));
        let is_named = curves.iter().any(|curve| curve.name.is_some());
        let mut series = vec![Series::vertical(SOFT, profile.closing.contact_s() * 1e3)];
        series.extend(curves);
        series.extend(is_named.then(|| Series::key(THIN_LINE, SOFT, "proximal contact")));
        Panel { heading: None, y, series }
    };
    let draw = |title: &str, height: f64, panels: Vec<(&str, Vec<Series>)>| {
        let panels: Vec<Panel> = panels.into_iter().map(panel).collect();
        panel_chart(&format!("{scene}: {title}"), &x, [0.0, height], &[], &panels)
    };
    let trajectory = vec![
        ("angle, deg", angles),
        ("rate, rad/s", vec![curve(BLUE, &|point| Some(point.qd11_rad_s))]),
        ("acceleration, 1000 rad/s²", vec![curve(BLUE, &|point| Some(point.qdd11_rad_s2 * 1e-3))]),
    ];
    let springs = vec![("k_s(t), N·mm", placements.into_iter().enumerate().map(spring).collect())];
    [
        draw("test trajectory", 177.0, trajectory),
        draw("minimum spring torque along the swing, by placement", 350.0, springs),
        draw("motor torque along the trajectory, by spring", 350.0, vec![("motor torque, N·mm", torques)]),
    ]
}
