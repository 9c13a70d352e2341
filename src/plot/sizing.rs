//! The sizing along its test trajectory (thesis Figs. 3.1–3.3).

use plotters::style::RGBColor;

use super::axis::Axis;
use super::canvas::{
    BLUE, DrawError, Entry, GREEN, GREY, LEGEND, Mark, ORANGE, PURPLE, WIDTH, frame, legend, line, picture, titled,
};
use crate::sizing::{Profile, ProfilePoint};

const HEIGHT: u32 = 440;
const TALL: u32 = 620;
const THICK: Mark = Mark::Line { width: 2 };

type Curve<'a> = (&'a str, RGBColor, Vec<(f64, f64)>);

/// Fig. 3.1: angle, rate and acceleration of the motor link, and the angles of the phalanges.
pub fn sizing_trajectory(scene: &str, profile: &Profile) -> Result<String, DrawError> {
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
    picture(TALL, |area| {
        let rest = titled(area, &format!("{scene}: test trajectory"))?;
        let (left, right) = rest.split_horizontally(WIDTH - LEGEND - 10);
        let rows = left.split_evenly((3, 1));
        for (index, (row, (label, curves))) in rows
            .iter()
            .zip([
                ("angle, deg", &angles[..]),
                ("rate, rad/s", &rate[..]),
                ("acceleration, 1000 rad/s²", &acceleration[..]),
            ])
            .enumerate()
        {
            panel(row, profile, label, curves, index == 2)?;
        }
        legend(&right, &entries(&angles))
    })
}

/// Fig. 3.2: the spring that the rigid phase needs at each moment, by its place.
pub fn sizing_springs(scene: &str, profile: &Profile) -> Result<String, DrawError> {
    let of = |place: usize| over_time(profile, |point| point.springs_n_m.map(|springs| springs[place] * 1e3));
    let curves: [Curve; 4] = [
        ("q21 − q11", BLUE, of(0)),
        ("q12", ORANGE, of(1)),
        ("q22", GREEN, of(2)),
        ("q11+q12−(q21+q22)", PURPLE, of(3)),
    ];
    one(&format!("{scene}: least spring torque along the swing, by place"), "k_s(t), N·mm", profile, &curves)
}

/// Fig. 3.3: the motor's torque along the trajectory, against either spring.
pub fn sizing_spring_types(scene: &str, profile: &Profile) -> Result<String, DrawError> {
    let of = |value: fn(&ProfilePoint) -> f64| over_time(profile, |point| Some(value(point) * 1e3));
    let curves: [Curve; 3] = [
        ("torsional spring", ORANGE, of(|point| point.torsional_n_m)),
        ("constant spring", BLUE, of(|point| point.constant_n_m)),
        ("net, distal held", GREEN, over_time(profile, |point| point.net_n_m.map(|n_m| n_m * 1e3))),
    ];
    one(&format!("{scene}: motor torque along the trajectory, by spring"), "motor torque, N·mm", profile, &curves)
}

fn one(title: &str, label: &str, profile: &Profile, curves: &[Curve<'_>]) -> Result<String, DrawError> {
    picture(HEIGHT, |area| {
        let rest = titled(area, title)?;
        let (left, right) = rest.split_horizontally(WIDTH - LEGEND - 10);
        panel(&left, profile, label, curves, true)?;
        legend(&right, &entries(curves))
    })
}

fn panel(
    area: &super::canvas::Area<'_>,
    profile: &Profile,
    label: &str,
    curves: &[Curve<'_>],
    foot: bool,
) -> Result<(), DrawError> {
    let x = Axis::linear("time, ms", [0.0, profile.closing.trajectory.length_s * 1e3]);
    let y = Axis::linear(label, curves.iter().flat_map(|curve| curve.2.iter().map(|point| point.1)));
    let mut chart = frame(area, &x, &y, foot)?;
    let contact_ms = profile.closing.contact_s() * 1e3;
    line(&mut chart, vec![(contact_ms, y.from), (contact_ms, y.to)], Mark::Line { width: 1 }, GREY)?;
    for (_, colour, points) in curves {
        line(&mut chart, points.clone(), THICK, *colour)?;
    }
    Ok(())
}

fn entries(curves: &[Curve<'_>]) -> Vec<Entry> {
    let lines = curves.iter().map(|(name, colour, _)| Entry::new(THICK, *colour, name));
    lines.chain([Entry::new(Mark::Line { width: 1 }, GREY, "proximal contact")]).collect()
}

/// (time in ms, value) wherever there is a value.
fn over_time(profile: &Profile, value: impl Fn(&ProfilePoint) -> Option<f64>) -> Vec<(f64, f64)> {
    profile.points.iter().filter_map(|point| Some((point.time_s * 1e3, value(point)?))).collect()
}
