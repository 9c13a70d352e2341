//! A sizing along its test trajectory (thesis Figs. 3.1–3.3).

use super::axis::Axis;
use super::canvas::{Marker, THIN_LINE, TITLE_HEIGHT, picture};
use super::series::{Panel, Series, Stack};
use super::theme::{BLUE, Colour, GREEN, ORANGE, PURPLE, SOFT};
use crate::sizing::{Profile, ProfilePoint};

/// Height of a single panel, without axis labels.
const SINGLE_PANEL_HEIGHT: f64 = 350.0;
/// Height of each of several panels, without axis labels.
const PANEL_HEIGHT: f64 = 177.0;

type Curve<'a> = (&'a str, Colour, Vec<(f64, f64)>);

/// Fig. 3.1: angle, rate and acceleration of the motor link, and the angles of the phalanges.
pub fn sizing_trajectory(scene: &str, profile: &Profile) -> String {
    let coordinates = |value: fn(&ProfilePoint) -> f64| time_series(profile, |point| Some(value(point)));
    let angles: [Curve; 3] = [
        ("q11", BLUE, coordinates(|point| point.q11_rad.to_degrees())),
        ("q21", ORANGE, coordinates(|point| point.q21_rad.to_degrees())),
        ("q22 + φ22", GREEN, {
            let straight = profile.closing.start.q22_rad;
            time_series(profile, |point| Some((point.q22_rad - straight).to_degrees()))
        }),
    ];
    let rate: [Curve; 1] = [("rate of q11", BLUE, coordinates(|point| point.qd11_rad_s))];
    let acceleration: [Curve; 1] = [("acceleration of q11", BLUE, coordinates(|point| point.qdd11_rad_s2 * 1e-3))];
    let panels =
        [("angle, deg", &angles[..]), ("rate, rad/s", &rate[..]), ("acceleration, 1000 rad/s²", &acceleration[..])];
    draw_panels(&format!("{scene}: test trajectory"), PANEL_HEIGHT, profile, &panels)
}

/// Fig. 3.2: the spring torque required in the rigid phase over time, by placement.
pub fn sizing_springs(scene: &str, profile: &Profile) -> String {
    let coordinates =
        |placement: usize| time_series(profile, |point| point.springs_n_m.map(|springs| springs[placement] * 1e3));
    let curves: [Curve; 4] = [
        ("q21 − q11", BLUE, coordinates(0)),
        ("q12", ORANGE, coordinates(1)),
        ("q22", GREEN, coordinates(2)),
        ("q11+q12−(q21+q22)", PURPLE, coordinates(3)),
    ];
    let title = format!("{scene}: minimum spring torque along the swing, by placement");
    draw_panels(&title, SINGLE_PANEL_HEIGHT, profile, &[("k_s(t), N·mm", &curves)])
}

/// Fig. 3.3: the motor torque along the trajectory for either type of spring.
pub fn sizing_spring_types(scene: &str, profile: &Profile) -> String {
    let coordinates = |value: fn(&ProfilePoint) -> f64| time_series(profile, |point| Some(value(point) * 1e3));
    let curves: [Curve; 3] = [
        ("torsional spring", ORANGE, coordinates(|point| point.torsional_n_m)),
        ("constant spring", BLUE, coordinates(|point| point.constant_n_m)),
        ("net, distal held", GREEN, time_series(profile, |point| point.net_n_m.map(|n_m| n_m * 1e3))),
    ];
    let title = format!("{scene}: motor torque along the trajectory, by spring");
    draw_panels(&title, SINGLE_PANEL_HEIGHT, profile, &[("motor torque, N·mm", &curves)])
}

/// Draws stacked panels with the legend of the first.
fn draw_panels(title: &str, panel_height: f64, profile: &Profile, panels: &[(&str, &[Curve<'_>])]) -> String {
    let x = Axis::linear("time, ms", [0.0, profile.closing.trajectory.length_s * 1e3]);
    let panel = |(index, (label, curves)): (usize, &(&str, &[Curve]))| {
        let mut series = vec![Series::vertical(SOFT, profile.closing.contact_s() * 1e3)];
        for (name, colour, points) in *curves {
            let curve = Series::new(Marker::Line { width: 2.0 }, *colour, points.iter().copied());
            series.push(if index == 0 { curve.named(*name) } else { curve });
        }
        series.extend((index == 0).then(|| Series::key(THIN_LINE, SOFT, "proximal contact")));
        let values = curves.iter().flat_map(|curve| curve.2.iter().map(|point| point.1));
        Panel { heading: None, y: Axis::linear(label, values), series }
    };
    let panels: Vec<Panel> = panels.iter().enumerate().map(panel).collect();
    let stack = Stack { top: 0.0, heading: 0.0, panel: panel_height, has_legends: true };
    picture(title, TITLE_HEIGHT + stack.height(panels.len()), |svg| stack.draw(svg, &x, &panels))
}

/// Points (time in ms, value) where a value exists.
fn time_series(profile: &Profile, value: impl Fn(&ProfilePoint) -> Option<f64>) -> Vec<(f64, f64)> {
    profile.points.iter().filter_map(|point| Some((point.time_s * 1e3, value(point)?))).collect()
}
