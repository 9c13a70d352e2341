//! The sizing along its test trajectory (thesis Figs. 3.1–3.3).

use super::axis::Axis;
use super::canvas::{Area, Entry, FOOT, HEAD, LEGEND, Mark, THIN, WIDTH, frame, legend, line, picture, upright};
use super::theme::{BLUE, Colour, GREEN, ORANGE, PURPLE, SOFT};
use crate::sizing::{Profile, ProfilePoint};

/// Heights of the only panel of a picture, and of one of several, without its foot.
const ONE: f64 = 350.0;
const OF_SEVERAL: f64 = 177.0;
const THICK: Mark = Mark::Line { width: 2.0 };

type Curve<'a> = (&'a str, Colour, Vec<(f64, f64)>);

/// Fig. 3.1: angle, rate and acceleration of the motor link, and the angles of the phalanges.
pub fn sizing_trajectory(scene: &str, profile: &Profile) -> String {
    let of = |value: fn(&ProfilePoint) -> f64| over_time(profile, |point| Some(value(point)));
    let angles: [Curve; 3] = [
        ("q11", BLUE, of(|point| point.q11_rad.to_degrees())),
        ("q21", ORANGE, of(|point| point.q21_rad.to_degrees())),
        ("q22 + φ22", GREEN, {
            let straight = profile.closing.start.q22_rad;
            over_time(profile, |point| Some((point.q22_rad - straight).to_degrees()))
        }),
    ];
    let rate: [Curve; 1] = [("rate of q11", BLUE, of(|point| point.qd11_rad_s))];
    let acceleration: [Curve; 1] = [("acceleration of q11", BLUE, of(|point| point.qdd11_rad_s2 * 1e-3))];
    let panels =
        [("angle, deg", &angles[..]), ("rate, rad/s", &rate[..]), ("acceleration, 1000 rad/s²", &acceleration[..])];
    drawn(&format!("{scene}: test trajectory"), OF_SEVERAL, profile, &panels)
}

/// Fig. 3.2: the spring that the rigid phase needs at each moment, by its place.
pub fn sizing_springs(scene: &str, profile: &Profile) -> String {
    let of = |place: usize| over_time(profile, |point| point.springs_n_m.map(|springs| springs[place] * 1e3));
    let curves: [Curve; 4] = [
        ("q21 − q11", BLUE, of(0)),
        ("q12", ORANGE, of(1)),
        ("q22", GREEN, of(2)),
        ("q11+q12−(q21+q22)", PURPLE, of(3)),
    ];
    let title = format!("{scene}: least spring torque along the swing, by place");
    drawn(&title, ONE, profile, &[("k_s(t), N·mm", &curves)])
}

/// Fig. 3.3: the motor's torque along the trajectory, against either spring.
pub fn sizing_spring_types(scene: &str, profile: &Profile) -> String {
    let of = |value: fn(&ProfilePoint) -> f64| over_time(profile, |point| Some(value(point) * 1e3));
    let curves: [Curve; 3] = [
        ("torsional spring", ORANGE, of(|point| point.torsional_n_m)),
        ("constant spring", BLUE, of(|point| point.constant_n_m)),
        ("net, distal held", GREEN, over_time(profile, |point| point.net_n_m.map(|n_m| n_m * 1e3))),
    ];
    let title = format!("{scene}: motor torque along the trajectory, by spring");
    drawn(&title, ONE, profile, &[("motor torque, N·mm", &curves)])
}

/// Panels one above the other, with the legend of the first.
fn drawn(title: &str, tall: f64, profile: &Profile, panels: &[(&str, &[Curve<'_>])]) -> String {
    let x = Axis::linear("time, ms", [0.0, profile.closing.trajectory.length_s * 1e3]);
    picture(title, HEAD + tall * panels.len() as f64 + FOOT, |svg| {
        for (index, (label, curves)) in panels.iter().enumerate() {
            let foot = index + 1 == panels.len();
            let height = if foot { tall + FOOT } else { tall };
            let area = Area { left: 0.0, top: tall * index as f64, width: WIDTH - LEGEND, height };
            let y = Axis::linear(label, curves.iter().flat_map(|curve| curve.2.iter().map(|point| point.1)));
            let on = frame(svg, area, &x, &y, foot);
            upright(svg, &on, profile.closing.contact_s() * 1e3, SOFT);
            for (_, colour, points) in *curves {
                line(svg, &on, points.iter().copied(), THICK, *colour);
            }
        }
        let lines = panels[0].1.iter().map(|(name, colour, _)| Entry::new(THICK, *colour, name));
        let entries: Vec<Entry> = lines.chain([Entry::new(THIN, SOFT, "proximal contact")]).collect();
        legend(svg, [WIDTH - LEGEND, 0.0], LEGEND, &entries);
    })
}

/// (time in ms, value) wherever there is a value.
fn over_time(profile: &Profile, value: impl Fn(&ProfilePoint) -> Option<f64>) -> Vec<(f64, f64)> {
    profile.points.iter().filter_map(|point| Some((point.time_s * 1e3, value(point)?))).collect()
}
