//! No contact is missed: first touches of jaws, bars, balls and boxes that move along known paths, against closed forms and
//! against paths sampled so densely that no touch is shorter than a sample.
//!
//! The reference uses distances written anew, and no event search of the integrator.

use phalanx::scene::parse_any;
use phalanx::trace::{self, Model, Simulation};
use std::f64::consts::TAU;

use crate::support::random::Random;

/// A scene with the time of its first touch; `None` if there is none.
struct Case {
    scene: String,
    expected_s: Option<f64>,
    /// Rate of the gap at the touch, m/s.
    rate_m_s: f64,
}

/// Contacts are located to this gap, m: 1e-7 of the scale of the depth (`EVENT_TOLERANCES`), with a margin for the dense
/// output.
const GAP_TOLERANCE_M: f64 = 2e-11;
/// Gaps of this size and below are neither a touch nor none, m.
const GRAZING_M: f64 = 1e-9;
/// Largest delay of a touch, s.
const MAX_DELAY_S: f64 = 1e-8;
/// The same for the engine, whose poses have errors of its step tolerance.
const ENGINE_GAP_TOLERANCE_M: f64 = 1e-5;
const MAX_ENGINE_DELAY_S: f64 = 1e-5;
/// Samples of a path in the reference.
const SAMPLES: usize = 4000;

/// Distance of a point from a segment from the origin along x.
fn distance_to_segment([x, y]: [f64; 2], length: f64) -> f64 {
    (x - x.clamp(0.0, length)).hypot(y)
}

/// Distance of a point from a box about the origin, negative inside.
fn distance_to_box([x, y]: [f64; 2], [half_x, half_y]: [f64; 2]) -> f64 {
    let (dx, dy) = (x.abs() - half_x, y.abs() - half_y);
    dx.max(0.0).hypot(dy.max(0.0)) + dx.max(dy).min(0.0)
}

fn rotated([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

/// First zero of a gap over 0…end; `None` without one, and no result at all if the smallest gap is too close to zero to
/// decide. Between samples the minimum is refined, so that short touches are found.
fn first_zero(gap: &dyn Fn(f64) -> f64, end: f64) -> Option<Option<f64>> {
    let at = |i: usize| end * i as f64 / SAMPLES as f64;
    let values: Vec<f64> = (0..=SAMPLES).map(|i| gap(at(i))).collect();
    if values[0] < GRAZING_M {
        return None;
    }
    let bisect = |mut low: f64, mut high: f64| {
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if gap(middle) > 0.0 { low = middle } else { high = middle }
        }
        high
    };
    for i in 1..=SAMPLES {
        if values[i] <= 0.0 {
            return Some(Some(bisect(at(i - 1), at(i))));
        }
        if i < SAMPLES && values[i] <= values[i - 1] && values[i] <= values[i + 1] {
            let (mut low, mut high) = (at(i - 1), at(i + 1));
            for _ in 0..200 {
                let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
                if gap(a) < gap(b) { high = b } else { low = a }
            }
            let lowest = 0.5 * (low + high);
            if gap(lowest).abs() < GRAZING_M {
                return None;
            }
            if gap(lowest) < 0.0 {
                return Some(Some(bisect(at(i - 1), lowest)));
            }
        }
    }
    (values[SAMPLES] > GRAZING_M).then_some(None)
}

const LAW: &str =
    "[laws.l]\nstiffness = 1e6\ndamping = \"3 s/m\"\n[log]\nnumeric_rate = \"100 Hz\"\npicture_rate = \"0 Hz\"\n";

/// Builds a case from a scene and its gap over time; `None` if the touch cannot be decided.
fn case(scene: String, gap: &dyn Fn(f64) -> f64, end_s: f64) -> Option<Case> {
    let expected_s = first_zero(gap, end_s)?;
    let rate_m_s = expected_s.map_or(0.0, |t| ((gap(t) - gap(t - 1e-7)) / 1e-7).abs());
    Some(Case {
        scene: format!("kind = \"mechanism\"\nduration = \"{end_s:e} s\"\n{scene}{LAW}"),
        expected_s,
        rate_m_s,
    })
}

/// A bar that turns about a pivot at a constant rate or under a constant torque, and a disc at any place within its reach:
/// hit by its flank or its tip, or grazed.
fn turning_bar(random: &mut Random, is_driven: bool) -> Option<Case> {
    let length = random.log_within(0.01, 0.3);
    let (bar, radius) = (length * random.log_within(0.01, 0.3), length * random.log_within(0.01, 0.5));
    let reach = length + bar + radius;
    let distance = match random.chance(0.3) {
        true => reach - random.log_within(1e-7, 1e-2) * length,
        false => random.within(bar + radius, reach),
    };
    let (inertia, start) = (random.log_within(1e-6, 1e-3), random.within(-3.0, 3.0));
    let place = rotated([distance, 0.0], random.within(-3.0, 3.0));
    let turns = random.log_within(0.05, 6.0);
    let (end, angle, drive): (f64, Box<dyn Fn(f64) -> f64>, String) = if is_driven {
        let torque = random.log_within(1e-3, 10.0) * if random.chance(0.5) { 1.0 } else { -1.0 };
        let end = (2.0 * turns * TAU * inertia / torque.abs()).sqrt();
        let angle = move |t: f64| start + 0.5 * torque / inertia * t * t;
        (end, Box::new(angle), format!("[actuators.m]\njoint = \"j\"\ntorque = \"{torque:e} N*m\"\n"))
    } else {
        let rate = random.log_within(0.1, 1000.0) * if random.chance(0.5) { 1.0 } else { -1.0 };
        (turns * TAU / rate.abs(), Box::new(move |t: f64| start + rate * t), String::new())
    };
    let rate = if is_driven { 0.0 } else { (angle(end) - start) / end };
    let gap = |t: f64| distance_to_segment(rotated(place, -angle(t)), length) - bar - radius;
    let [x, y] = place;
    let scene = format!(
        "[bodies.bar]\nmass = \"50 g\"\ninertia = \"{inertia:e} kg*m^2\"\n[bodies.bar.outlines.o]\ntype = \"capsule\"\n\
         from = [\"0 m\", \"0 m\"]\nto = [\"{length:e} m\", \"0 m\"]\nradius = \"{bar:e} m\"\n[ground.outlines.peg]\n\
         type = \"disc\"\ncenter = [\"{x:e} m\", \"{y:e} m\"]\nradius = \"{radius:e} m\"\n[joints.j]\n\
         bodies = [\"ground\", \"bar\"]\npoints = [[\"0 m\", \"0 m\"], [\"0 m\", \"0 m\"]]\nstart = \"{start:e} rad\"\n\
         start_rate = \"{rate:e} rad/s\"\n{drive}[[contacts]]\nbetween = [\"bar.o\", \"ground.peg\"]\nlaw = \"l\"\n"
    );
    case(scene, &gap, end)
}

/// A free body with a pose over time: thrown, turning, under gravity.
struct Thrown {
    at: [f64; 2],
    angle: f64,
    velocity: [f64; 2],
    spin: f64,
}

impl Thrown {
    /// A body that flies from one place towards another one, past it by `miss`, and turns.
    fn towards([x, y]: [f64; 2], distance: f64, (time, miss, spin): (f64, f64, f64), random: &mut Random) -> Self {
        let direction = random.within(0.0, TAU);
        let [dx, dy] = rotated([distance, miss], direction);
        let velocity = rotated([-1.5 * distance / time, 0.0], direction);
        Self { at: [x + dx, y + dy], angle: random.within(-3.0, 3.0), velocity, spin }
    }

    /// Place and angle at a time, in free flight under gravity along −y.
    fn pose(&self, t: f64, gravity: f64) -> ([f64; 2], f64) {
        let [[x, y], [u, v]] = [self.at, self.velocity];
        ([x + u * t, y + v * t - 0.5 * gravity * t * t], self.angle + self.spin * t)
    }

    fn body(&self, name: &str, outline: &str) -> String {
        let Self { at: [x, y], angle, velocity: [u, v], spin } = self;
        format!(
            "[bodies.{name}]\nmass = \"50 g\"\ninertia = \"1e-5 kg*m^2\"\nstart = {{ at = [\"{x:e} m\", \"{y:e} m\"], angle = \
             \"{angle:e} rad\", velocity = [\"{u:e} m/s\", \"{v:e} m/s\"], spin = \"{spin:e} rad/s\" }}\n\
             [bodies.{name}.outlines.o]\n{outline}"
        )
    }
}

fn disc(radius: f64) -> String {
    format!("type = \"disc\"\nradius = \"{radius:e} m\"\n")
}

fn rounded_box([half_x, half_y]: [f64; 2], rounding: f64) -> String {
    let [x, y] = [half_x, half_y].map(|half| 2.0 * (half + rounding));
    format!("type = \"box\"\nsize = [\"{x:e} m\", \"{y:e} m\"]\nrounding = \"{rounding:e} m\"\n")
}

/// A ball against a ball or a box, or a box against a ball, each thrown; the second one may be fixed.
fn thrown(random: &mut Random, is_box: bool) -> Option<Case> {
    let size = random.log_within(1e-3, 0.1);
    let (half, rounding) = ([size, size * random.log_within(0.05, 1.0)], size * random.log_within(0.02, 0.3));
    let radius = size * random.log_within(0.02, 2.0);
    let reach = half[0].hypot(half[1]) + rounding + radius;
    let (time, gravity) = (random.log_within(1e-4, 1.0), if random.chance(0.5) { 9.81 } else { 0.0 });
    let miss = match random.chance(0.3) {
        true => reach * (1.0 - random.log_within(1e-8, 1e-2)),
        false => reach * random.within(-1.0, 1.0),
    };
    let spin = if random.chance(0.7) { random.log_within(0.1, 30.0) / time } else { 0.0 };
    let ball = Thrown::towards([0.0, 0.0], reach * random.log_within(1.2, 100.0), (time, miss, spin), random);
    let other = Thrown { at: [0.0; 2], angle: random.within(-3.0, 3.0), velocity: [0.0; 2], spin: 0.5 * spin };
    let is_fixed = random.chance(0.4);
    let other_gravity = if is_fixed { 0.0 } else { gravity };
    let other = if is_fixed { Thrown { spin: 0.0, ..other } } else { other };
    let gap = |t: f64| {
        let ((at, _), (center, angle)) = (ball.pose(t, gravity), other.pose(t, other_gravity));
        let offset = rotated([at[0] - center[0], at[1] - center[1]], -angle);
        match is_box {
            true => distance_to_box(offset, half) - rounding - radius,
            false => offset[0].hypot(offset[1]) - rounding - radius,
        }
    };
    let outline = if is_box { rounded_box(half, rounding) } else { disc(rounding) };
    let other_body = match is_fixed {
        true => format!("[ground.outlines.o]\n{outline}angle = \"{:e} rad\"\n", other.angle),
        false => other.body("other", &outline),
    };
    let other_body = if is_fixed && !is_box { format!("[ground.outlines.o]\n{outline}") } else { other_body };
    let other_name = if is_fixed { "ground" } else { "other" };
    let scene = format!(
        "gravity = [\"0 m/s^2\", \"{:e} m/s^2\"]\n{}{other_body}[[contacts]]\nbetween = [\"ball.o\", \"{other_name}.o\"]\n\
         law = \"l\"\n",
        -gravity,
        ball.body("ball", &disc(radius))
    );
    case(scene, &gap, time)
}

/// A slider-crank or a four-bar under a torque whose coupler, a capsule, meets a peg. The reference is the motion of the same
/// linkage without the contact, sampled: it shares the kinematics of the model, but not its search.
fn linkage(random: &mut Random) -> Option<Case> {
    let crank = random.log_within(0.01, 0.05);
    let (coupler, pad, radius) = (crank * random.within(2.2, 4.0), crank * 0.1, crank * random.log_within(0.02, 0.5));
    let start = random.within(-3.0, 3.0);
    let (rate, torque) = (random.log_within(1.0, 300.0), random.within(-0.02, 0.02));
    let end_s = random.within(0.3, 2.0) * TAU / rate;
    let [tip_x, tip_y] = rotated([crank, 0.0], start);
    let is_slider = random.chance(0.5);
    let (last, last_at) = if is_slider {
        let x = tip_x + (coupler * coupler - tip_y * tip_y).sqrt();
        ("type = \"prismatic\"\n".to_string(), [x, 0.0])
    } else {
        // A rocker from a ground pivot; both circles meet above the line of their centres.
        let (pivot, rocker) = (crank * 3.0, crank * 2.8);
        let (dx, dy) = (pivot - tip_x, -tip_y);
        let distance = dx.hypot(dy);
        let along = (coupler * coupler - rocker * rocker + distance * distance) / (2.0 * distance);
        let across = (coupler * coupler - along * along).sqrt();
        let at = [tip_x + (along * dx - across * dy) / distance, tip_y + (along * dy + across * dx) / distance];
        (String::new(), at)
    };
    let angle = (last_at[1] - tip_y).atan2(last_at[0] - tip_x);
    if !angle.is_finite() {
        return None;
    }
    let peg = [random.within(-1.0, 4.0) * crank, random.within(-1.5, 3.0) * crank];
    let last_body = if is_slider {
        format!("guess = {{ at = [\"{:e} m\", \"0 m\"] }}\n", last_at[0])
    } else {
        let pivot = crank * 3.0;
        let turn = last_at[1].atan2(last_at[0] - pivot);
        format!("guess = {{ at = [\"{pivot:e} m\", \"0 m\"], angle = \"{turn:e} rad\" }}\n")
    };
    let last_points = if is_slider {
        ["[[\"0 m\", \"0 m\"], [\"0 m\", \"0 m\"]]".to_string(), "\"0 m\", \"0 m\"".to_string()]
    } else {
        let (pivot, rocker) = (crank * 3.0, crank * 2.8);
        [format!("[[\"{pivot:e} m\", \"0 m\"], [\"0 m\", \"0 m\"]]"), format!("\"{rocker:e} m\", \"0 m\"")]
    };
    let scene = format!(
        "[bodies.crank]\nmass = \"50 g\"\ninertia = \"1e-4 kg*m^2\"\n[bodies.coupler]\nmass = \"20 g\"\n\
         inertia = \"1e-5 kg*m^2\"\nguess = {{ at = [\"{tip_x:e} m\", \"{tip_y:e} m\"], angle = \"{angle:e} rad\" }}\n\
         [bodies.coupler.outlines.o]\ntype = \"capsule\"\nfrom = [\"0 m\", \"0 m\"]\nto = [\"{coupler:e} m\", \"0 m\"]\n\
         radius = \"{pad:e} m\"\n[bodies.last]\nmass = \"20 g\"\ninertia = \"1e-5 kg*m^2\"\n{last_body}\
         [ground.outlines.peg]\ntype = \"disc\"\ncenter = [\"{:e} m\", \"{:e} m\"]\nradius = \"{radius:e} m\"\n\
         [joints.crank]\nbodies = [\"ground\", \"crank\"]\npoints = [[\"0 m\", \"0 m\"], [\"0 m\", \"0 m\"]]\n\
         start = \"{start:e} rad\"\nstart_rate = \"{rate:e} rad/s\"\n[joints.pin]\nbodies = [\"crank\", \"coupler\"]\n\
         points = [[\"{crank:e} m\", \"0 m\"], [\"0 m\", \"0 m\"]]\n[joints.wrist]\nbodies = [\"coupler\", \"last\"]\n\
         points = [[\"{coupler:e} m\", \"0 m\"], [{}]]\n[joints.last]\n{last}bodies = [\"ground\", \"last\"]\n\
         points = {}\n[actuators.m]\njoint = \"crank\"\ntorque = \"{torque:e} N*m\"\n",
        peg[0], peg[1], last_points[1], last_points[0]
    );
    // The motion of both runs is that of the reference preset: it differs by less than the time of a touch shows.
    let text = |contact: &str| {
        format!(
            "kind = \"mechanism\"\nduration = \"{end_s:e} s\"\n{scene}{contact}{LAW}[integrator]\npreset = \"reference\"\n"
        )
    };
    let free = parse_any(&text(""), "free.toml").unwrap_or_else(|error| panic!("{error}"));
    let gap = |simulation: &Simulation| {
        let get = |channel: &str| simulation.get(channel).unwrap_or_else(|error| panic!("{error}"));
        let at = ["coupler_x_m", "coupler_y_m"].map(get);
        let offset = rotated([peg[0] - at[0], peg[1] - at[1]], -get("coupler_angle_rad"));
        distance_to_segment(offset, coupler) - pad - radius
    };
    let mut samples = Vec::with_capacity(SAMPLES + 1);
    let mut simulation = Simulation::new(&free, Model::Analytic).ok()?;
    for i in 0..=SAMPLES {
        let time = end_s * i as f64 / SAMPLES as f64;
        if i > 0 {
            simulation.advance(time - simulation.time_s()).ok()?;
        }
        samples.push(gap(&simulation));
    }
    // Cubic interpolation of the samples finds the touch; the motion itself locates it.
    let interpolated = |t: f64| {
        let x = t / end_s * SAMPLES as f64;
        let first = (x.floor() as usize).clamp(1, SAMPLES - 2) - 1;
        let u = x - first as f64;
        (0..4)
            .map(|k| {
                let others = (0..4).filter(|other| *other != k);
                samples[first + k] * others.map(|other| (u - other as f64) / (k as f64 - other as f64)).product::<f64>()
            })
            .sum()
    };
    let mut expected_s = first_zero(&interpolated, end_s)?;
    let mut rate_m_s = 0.0;
    if let Some(near_s) = &mut expected_s {
        let sample_s = end_s / SAMPLES as f64;
        let from_s = (*near_s - sample_s).max(0.0);
        let mut before = Simulation::new(&free, Model::Analytic).ok()?;
        before.advance(from_s).ok()?;
        let exact = |t: f64| {
            let mut simulation = before.clone();
            simulation.advance(t - simulation.time_s()).expect("a motion without contact");
            gap(&simulation)
        };
        let (mut low, mut high) = (from_s, (*near_s + sample_s).min(end_s));
        if exact(low) <= 0.0 || exact(high) >= 0.0 {
            return None;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if exact(middle) > 0.0 { low = middle } else { high = middle }
        }
        *near_s = high;
        rate_m_s = ((exact(high) - exact(high - 1e-7)) / 1e-7).abs();
    }
    let contact = "[[contacts]]\nbetween = [\"coupler.o\", \"ground.peg\"]\nlaw = \"l\"\n";
    Some(Case { scene: text(contact), expected_s, rate_m_s })
}

/// A four-bar whose crank turns at a constant rate, because it is heavy, and a half plane of the ground that the tip of its
/// rocker overlaps at its dead centre: the shortest touch of a turn. The bounds of the rocker over a whole step are unknown.
#[test]
fn tips_of_rockers_touch_planes_at_their_dead_centres() {
    let lengths = [0.03_f64, 0.06, 0.05, 0.07];
    let [crank, coupler, rocker, ground] = lengths;
    // The smallest angle of the rocker, with its tip furthest to the right: crank and coupler are in line.
    let reach = crank + coupler;
    let smallest =
        std::f64::consts::PI - ((ground * ground + rocker * rocker - reach * reach) / (2.0 * ground * rocker)).acos();
    let (sin, cos) = smallest.sin_cos();
    let tip = [ground + rocker * cos, rocker * sin];
    for (overlap, is_swapped) in
        [2e-6, 2e-5, 1e-4, 5e-4].into_iter().flat_map(|overlap| [(overlap, false), (overlap, true)])
    {
        for start in [0.7_f64, 0.9, 1.2] {
            let (x, y) = (crank * start.cos(), crank * start.sin());
            let (dx, dy) = (ground - x, -y);
            let distance = dx.hypot(dy);
            let along = (coupler * coupler - rocker * rocker + distance * distance) / (2.0 * distance);
            let across = (coupler * coupler - along * along).sqrt();
            let pin = [x + (along * dx - across * dy) / distance, y + (along * dy + across * dx) / distance];
            let (turn, angle) = ((pin[1] - y).atan2(pin[0] - x), pin[1].atan2(pin[0] - ground));
            let radius = 1e-3;
            let (face, pair) = match is_swapped {
                false => (
                    format!(
                        "type = \"half_plane\"\npoint = [\"{:e} m\", \"0 m\"]\nnormal = [-1, 0]\n",
                        tip[0] + radius - overlap
                    ),
                    "[\"rocker.tip\", \"ground.wall\"]",
                ),
                // A disc in the path of the tip, in place of the plane.
                true => (
                    format!(
                        "type = \"disc\"\ncenter = [\"{:e} m\", \"{:e} m\"]\nradius = \"0.02 m\"\n",
                        tip[0] + (0.02 + radius - overlap) * sin,
                        tip[1] - (0.02 + radius - overlap) * cos
                    ),
                    "[\"ground.wall\", \"rocker.tip\"]",
                ),
            };
            let scene = format!(
                "kind = \"mechanism\"\nduration = \"0.13 s\"\n[bodies.crank]\nmass = \"10 g\"\ninertia = \"1 kg*m^2\"\n\
                 [bodies.coupler]\nmass = \"10 g\"\ninertia = \"1e-5 kg*m^2\"\nguess = {{ at = [\"{x:e} m\", \"{y:e} m\"], \
                 angle = \"{turn:e} rad\" }}\n[bodies.rocker]\nmass = \"10 g\"\ninertia = \"1e-5 kg*m^2\"\nguess = {{ at = \
                 [\"{ground:e} m\", \"0 m\"], angle = \"{angle:e} rad\" }}\n[bodies.rocker.outlines.tip]\ntype = \"disc\"\n\
                 center = [\"{rocker:e} m\", \"0 m\"]\nradius = \"{radius:e} m\"\n[ground.outlines.wall]\n{face}[joints.crank]\n\
                 bodies = [\"ground\", \"crank\"]\npoints = [[\"0 m\", \"0 m\"], [\"0 m\", \"0 m\"]]\nstart = \"{start:e} rad\"\n\
                 start_rate = \"100 rad/s\"\n[joints.a]\nbodies = [\"crank\", \"coupler\"]\npoints = [[\"{crank:e} m\", \"0 m\"], \
                 [\"0 m\", \"0 m\"]]\n[joints.b]\nbodies = [\"coupler\", \"rocker\"]\npoints = [[\"{coupler:e} m\", \"0 m\"], \
                 [\"{rocker:e} m\", \"0 m\"]]\n[joints.c]\nbodies = [\"ground\", \"rocker\"]\npoints = [[\"{ground:e} m\", \"0 m\"], \
                 [\"0 m\", \"0 m\"]]\n[[contacts]]\nbetween = {pair}\nlaw = \"l\"\n{LAW}"
            );
            let scene = parse_any(&scene, "rocker.toml").unwrap_or_else(|error| panic!("{error}"));
            let outcome = trace::run(Model::Analytic, &scene, &mut ()).unwrap_or_else(|error| panic!("{error}"));
            let touches = outcome.contacts[0].touchdowns;
            // Two turns of 63 ms.
            assert!((2..=3).contains(&touches), "{overlap} {is_swapped} {start}: {touches} touch-downs");
        }
    }
}

/// Compares the first touch of a run with the expected one; `None` if they agree.
fn disagreement(model: Model, case: &Case) -> Option<String> {
    let scene = parse_any(&case.scene, "case.toml").unwrap_or_else(|error| panic!("{error}\n{}", case.scene));
    let found_s = match trace::run(model, &scene, &mut ()) {
        Ok(outcome) => outcome.contacts.iter().filter_map(|contact| contact.first_s).min_by(f64::total_cmp),
        Err(error) => return Some(format!("ends: {error}")),
    };
    match (case.expected_s, found_s) {
        (None, None) => None,
        (Some(expected), Some(found)) => {
            let tolerance = match model {
                Model::Analytic => MAX_DELAY_S.max(GAP_TOLERANCE_M / case.rate_m_s),
                Model::Engine => MAX_ENGINE_DELAY_S.max(ENGINE_GAP_TOLERANCE_M / case.rate_m_s),
            };
            ((found - expected).abs() > tolerance)
                .then(|| format!("found at {found:e} s, {:e} s late; rate {:e} m/s", found - expected, case.rate_m_s))
        }
        (expected, found) => Some(format!("expected {expected:?}, found {found:?}")),
    }
}

/// Builds a random case of a family; `None` if it is degenerate or cannot be decided.
type Build = fn(&mut Random) -> Option<Case>;

/// Compares `count` random cases of each family.
fn compare(model: Model, seed: u64, count: usize) {
    let families: [(&str, Build); 5] = [
        ("jaw", |random| turning_bar(random, true)),
        ("bar", |random| turning_bar(random, false)),
        ("ball", |random| thrown(random, false)),
        ("box", |random| thrown(random, true)),
        ("linkage", linkage),
    ];
    let (mut failures, mut touches) = (Vec::new(), 0);
    for (family, build) in &families {
        let mut random = Random::for_seed(seed);
        let cases = std::iter::from_fn(|| Some(build(&mut random))).flatten().take(count);
        for (index, case) in cases.enumerate() {
            touches += usize::from(case.expected_s.is_some());
            if let Some(text) = disagreement(model, &case) {
                failures.push(format!("{family} {index}: {text}\n{}", case.scene));
            }
        }
    }
    let most = failures.iter().take(5).cloned().collect::<Vec<_>>().join("\n");
    assert!(failures.is_empty(), "{} of {}: {most}", failures.len(), families.len() * count);
    assert!(touches > count, "{touches} of {} cases touch", families.len() * count);
}

#[test]
fn random_motions_touch_when_their_closed_forms_do() {
    compare(Model::Analytic, 1, 25);
}

#[test]
#[ignore = "takes minutes: 2,500 motions with fresh seeds"]
fn many_random_motions_touch_when_their_closed_forms_do() {
    compare(Model::Analytic, 57_000, 500);
}

#[test]
#[ignore = "takes minutes: 2,500 motions with fresh seeds"]
fn the_engine_passes_nothing_either() {
    compare(Model::Engine, 58_000, 500);
}

/// The jaw of a user, which passed through its object with the verdict "accurate": its touch in closed form.
#[test]
fn a_jaw_that_turns_far_in_one_step_touches_its_object() {
    let scene = "kind = \"mechanism\"\nduration = \"80 ms\"\n[bodies.jaw]\nmass = \"50 g\"\ninertia = \"2e-5 kg*m^2\"\n\
                 com = [\"25 mm\", \"0 mm\"]\n[bodies.jaw.outlines.pad]\ntype = \"capsule\"\nfrom = [\"0 mm\", \"0 mm\"]\n\
                 to = [\"60 mm\", \"0 mm\"]\nradius = \"5 mm\"\n[ground.outlines.object]\ntype = \"disc\"\n\
                 center = [\"0 mm\", \"45 mm\"]\nradius = \"10 mm\"\n[joints.pivot]\nbodies = [\"ground\", \"jaw\"]\n\
                 points = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\nstart = \"0 rad\"\n[actuators.motor]\n\
                 joint = \"pivot\"\ntorque = \"0.1 N*m\"\n[laws.rubber]\nstiffness = 1e6\ndamping = \"3 s/m\"\n\
                 [[contacts]]\nbetween = [\"jaw.pad\", \"ground.object\"]\nlaw = \"rubber\"\n";
    let scene = parse_any(scene, "jaw.toml").expect("a scene");
    let outcome = trace::run(Model::Analytic, &scene, &mut ()).expect("a run");
    // 45 mm sin(90° − θ) = 15 mm, and θ = τ t²/(2 J) with J = 2e-5 + 0.05·0.025² kg m².
    let angle = (15.0_f64 / 45.0).acos();
    let expected_s = (2.0 * angle * (2e-5 + 0.05 * 0.025 * 0.025) / 0.1_f64).sqrt();
    let found_s = outcome.contacts.iter().filter_map(|contact| contact.first_s).next().expect("a touch");
    assert!((found_s - expected_s).abs() < 1e-9, "{found_s} {expected_s}");
    assert!((expected_s - 35.520_887e-3).abs() < 1e-9, "{expected_s}");
}

/// Two jaws on one line that move at a ratio of their speeds, pushed by 1 N; the second one is ahead by `gap_m`. Their direction
/// is not along an axis, so that a constant gap has rounding errors.
fn coupled_jaws(ratio: f64, gap_m: f64, degrees: f64) -> String {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let jaw = |name: &str, along: f64| {
        let [x, y] = [cos * along, sin * along].map(|coordinate| format!("{coordinate:?} m"));
        format!(
            "[bodies.{name}]\nmass = \"50 g\"\ninertia = \"2e-5 kg*m^2\"\nguess = {{ at = [\"{x}\", \"{y}\"] }}\n[bodies.{name}.outlines.pad]\n\
             type = \"box\"\nsize = [\"20 mm\", \"20 mm\"]\nangle = \"{degrees} deg\"\nrounding = \"1 mm\"\n[joints.{name}]\ntype = \"prismatic\"\n\
             bodies = [\"ground\", \"{name}\"]\npoints = [[\"{x}\", \"{y}\"], [\"0 m\", \"0 m\"]]\naxis = \"{degrees} deg\"\nstart = \"0 m\"\n"
        )
    };
    format!(
        "kind = \"mechanism\"\nduration = \"20 ms\"\n{}{}[couplings.ratio]\njoints = [\"first\", \"second\"]\nfactors = [{ratio:?}, -1]\n\
         [actuators.push]\njoint = \"first\"\nforce = \"1 N\"\n[laws.hard]\nstiffness = 1e6\nexponent = 1.5\n[[contacts]]\n\
         between = [\"first.pad\", \"second.pad\"]\nlaw = \"hard\"\n",
        jaw("first", 0.0),
        jaw("second", 0.02 + gap_m),
    )
}

/// No bound of rates tells that jaws stay apart which a coupling moves together. Steps are long nevertheless, and jaws that hardly
/// approach each other touch in time.
#[test]
fn gaps_that_a_constraint_holds_do_not_shorten_steps() {
    for degrees in [0.0, 30.0, 77.3] {
        for gap_m in [1e-15, 1e-12, 1e-9, 1e-6] {
            let scene = parse_any(&coupled_jaws(1.0, gap_m, degrees), "jaws.toml").expect("a scene");
            let outcome = trace::run(Model::Analytic, &scene, &mut ()).expect("a run");
            assert!(outcome.work.steps < 60, "{degrees}, {gap_m}: {} steps", outcome.work.steps);
            if gap_m > 1e-13 {
                assert!(outcome.contacts.iter().all(|contact| contact.first_s.is_none()), "{degrees}, {gap_m}");
            }
        }
        for (slower, gap_m) in [(1e-2, 1e-9), (1e-3, 1e-9), (1e-3, 1e-6), (1e-4, 1e-8), (1e-5, 1e-9)] {
            let ratio = 1.0 - slower;
            let scene = parse_any(&coupled_jaws(ratio, gap_m, degrees), "jaws.toml").expect("a scene");
            let outcome = trace::run(Model::Analytic, &scene, &mut ()).expect("a run");
            let found_s =
                outcome.contacts.iter().filter_map(|contact| contact.first_s).reduce(f64::min).expect("a touch");
            let mass = 0.05 * (1.0 + ratio * ratio);
            let expected_s = (2.0 * mass * gap_m / slower).sqrt();
            let rate_m_s = slower * expected_s / mass;
            let allowed_s = MAX_DELAY_S + GAP_TOLERANCE_M / rate_m_s;
            assert!((found_s - expected_s).abs() < allowed_s, "{degrees}, {slower}, {gap_m}: {found_s} {expected_s}");
        }
    }
}

/// A limit of a sum that a coupling fixes.
#[test]
fn a_limit_of_a_constant_sum_does_not_shorten_steps() {
    let limit = |lower: &str| {
        coupled_jaws(1.0, 1e-3, 0.0)
            + &format!(
                "[limits.sum]\njoints = [\"first\", \"second\"]\nfactors = [1, -1]\nlower = \"{lower}\"\nstop = \"hard\"\n"
            )
    };
    for lower in ["0 m", "-1e-15 m", "-1e-9 m"] {
        let scene = parse_any(&limit(lower), "jaws.toml").expect("a scene");
        let outcome = trace::run(Model::Analytic, &scene, &mut ()).expect("a run");
        assert!(outcome.work.steps < 60, "{lower}: {} steps", outcome.work.steps);
    }
}
