//! How the palm moves in the world, and brakes that hold a drive meanwhile.

use std::f64::consts::TAU;

use crate::law::{Bristle, smoothstep};
use crate::numeric::elementary::{hypot, powi, sin_cos};

/// Pose (X, Y, Φ) of the palm over time: the sum of all that moves it, at rest at the origin before.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PalmMotion {
    pub moves: Vec<Move>,
    pub vibrations: Vec<Vibration>,
    pub path: Option<Path>,
    /// Names of moves and of vibrations, as far as a scene has given them.
    pub names: [Vec<String>; 2],
}

/// A coordinate of the palm's pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    X,
    Y,
    Angle,
}

/// From rest to rest, on the polynomial whose rate, acceleration and jerk vanish at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    pub axis: Axis,
    /// m or rad.
    pub distance: f64,
    pub start_s: f64,
    pub length_s: f64,
}

/// amplitude × ramp × sin(2π f (t − start) + phase).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vibration {
    pub axis: Axis,
    /// m or rad.
    pub amplitude: f64,
    pub frequency_hz: f64,
    pub phase_rad: f64,
    pub start_s: f64,
    /// Periods in which it grows.
    pub ramp_periods: f64,
    pub ramp: Ramp,
}

/// How a vibration grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ramp {
    /// 10 s³ − 15 s⁴ + 6 s⁵: accelerations do not jump.
    Quintic,
    /// 3 s² − 2 s³.
    Cubic,
}

/// A cubic spline through poses, at rest at both ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Time and (X, Y, Φ), m and rad.
    points: Vec<(f64, [f64; 3])>,
    /// Second derivatives there.
    bends: Vec<[f64; 3]>,
}

/// (X, Y, Φ) and three derivatives, m and rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    pub place: [f64; 3],
    pub rate: [f64; 3],
    pub acceleration: [f64; 3],
    pub jerk: [f64; 3],
}

/// What holds a drive, like an electromagnet: torque −T s(t) β(q̇).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brake {
    /// Most that it holds, N·m.
    pub torque_n_m: f64,
    pub start_s: f64,
    /// Time in which it grips, and in which it lets go.
    pub rise_s: f64,
    pub release_s: Option<f64>,
    /// Holds against opening only.
    pub one_way: bool,
    /// Half width of its sticking range.
    pub v_static_rad_s: f64,
    /// What holds below its torque instead, in rad; `None` creeps.
    pub bristle: Option<Bristle>,
}

impl Pose {
    #[inline]
    fn add(&mut self, axis: Axis, derivatives: [f64; 4]) {
        let all = [&mut self.place, &mut self.rate, &mut self.acceleration, &mut self.jerk];
        for (part, derivative) in all.into_iter().zip(derivatives) {
            part[axis as usize] += derivative;
        }
    }
}

impl PalmMotion {
    /// Pose at time t.
    #[inline]
    pub fn pose(&self, t: f64) -> Pose {
        let mut pose = Pose::default();
        for one in &self.moves {
            pose.add(one.axis, one.at(t));
        }
        for one in &self.vibrations {
            pose.add(one.axis, one.at(t));
        }
        for (path, axis) in self.path.iter().flat_map(|path| [Axis::X, Axis::Y, Axis::Angle].map(|axis| (path, axis))) {
            pose.add(axis, path.at(t, axis));
        }
        pose
    }

    /// The next time after `t` at which some derivative jumps; infinite if there is none.
    #[inline]
    pub fn next_corner(&self, t: f64) -> f64 {
        let moves = self.moves.iter().flat_map(|one| [one.start_s, one.start_s + one.length_s]);
        let vibrations = self.vibrations.iter().flat_map(|one| [one.start_s, one.start_s + one.ramp_s()]);
        let path = self.path.iter().flat_map(|path| path.points.iter().map(|point| point.0));
        first_after(t, moves.chain(vibrations).chain(path))
    }

    /// When it begins to move, s.
    pub fn starts_s(&self) -> f64 {
        let (moves, vibrations) =
            (self.moves.iter().map(|one| one.start_s), self.vibrations.iter().map(|one| one.start_s));
        let path = self.path.iter().filter_map(|path| path.points.first()).map(|point| point.0);
        moves.chain(vibrations).chain(path).fold(f64::INFINITY, f64::min)
    }

    /// The largest acceleration of a point of the palm in the world up to a time, m/s².
    pub fn peak_m_s2(&self, [x, y]: [f64; 2], until_s: f64) -> f64 {
        let at = |time_s: f64| {
            let pose = self.pose(time_s);
            let ([ax, ay, alpha], omega) = (pose.acceleration, pose.rate[2]);
            let (sin, cos) = sin_cos(pose.place[2]);
            let (rx, ry) = (cos * x - sin * y, sin * x + cos * y);
            hypot(ax - alpha * ry - omega * omega * rx, ay + alpha * rx - omega * omega * ry)
        };
        let mut corners = vec![0.0];
        while let Some(next) = corners.last().map(|last| self.next_corner(*last)).filter(|next| *next < until_s) {
            corners.push(next);
        }
        corners.push(until_s);
        // Near its top it is a parabola: with so many places it is right to 4e-8 of itself, a hundred times worse with a tenth of them.
        const PLACES: f64 = 10_000.0;
        let most = (100.0 * PLACES / corners.len() as f64).max(10.0);
        let fastest_hz = self.vibrations.iter().map(|one| one.frequency_hz).fold(0.0, f64::max);
        let pieces = corners.windows(2).flat_map(|pair| {
            let (from, to) = (pair[0], pair[1]);
            // A hundred in a period, as far as all of them are not too many.
            let places = (100.0 * fastest_hz * (to - from)).clamp(PLACES.min(most), most);
            (0..=places as usize).map(move |index| from + (to - from) * index as f64 / places)
        });
        pieces.map(at).fold(0.0, f64::max)
    }

    /// When all moves are over, s; vibrations go on.
    pub fn arrives_s(&self) -> f64 {
        let moves = self.moves.iter().map(|one| one.start_s + one.length_s);
        moves.chain(self.path.iter().filter_map(|path| path.points.last()).map(|point| point.0)).fold(0.0, f64::max)
    }
}

impl Move {
    /// The peak acceleration of a move over a unit of length in a unit of time: of 420 u² (1 − u)² (1 − 2u), where 1 − 2u = 1/√5.
    pub fn unit_peak() -> f64 {
        3.36 * 5f64.sqrt()
    }

    #[inline]
    fn at(&self, t: f64) -> [f64; 4] {
        let u = (t - self.start_s) / self.length_s;
        if u <= 0.0 {
            return [0.0; 4];
        }
        if u >= 1.0 {
            return [self.distance, 0.0, 0.0, 0.0];
        }
        let (w, rate) = (1.0 - u, self.distance / self.length_s);
        let second = rate / self.length_s;
        [
            self.distance * powi(u, 4) * (35.0 + u * (-84.0 + u * (70.0 - 20.0 * u))),
            rate * 140.0 * powi(u * w, 3),
            second * 420.0 * powi(u * w, 2) * (w - u),
            second / self.length_s * 840.0 * u * w * (1.0 - 5.0 * u * w),
        ]
    }
}

impl Vibration {
    #[inline]
    fn ramp_s(&self) -> f64 {
        self.ramp_periods / self.frequency_hz
    }

    #[inline]
    fn at(&self, t: f64) -> [f64; 4] {
        let since = t - self.start_s;
        if since <= 0.0 {
            return [0.0; 4];
        }
        let omega = TAU * self.frequency_hz;
        let (sin, cos) = sin_cos(omega * since + self.phase_rad);
        let wave = [sin, omega * cos, -omega * omega * sin, -powi(omega, 3) * cos];
        let [r0, r1, r2, r3] = self.ramp.at(since, self.ramp_s());
        // Leibniz.
        [
            r0 * wave[0],
            r1 * wave[0] + r0 * wave[1],
            r2 * wave[0] + 2.0 * r1 * wave[1] + r0 * wave[2],
            r3 * wave[0] + 3.0 * r2 * wave[1] + 3.0 * r1 * wave[2] + r0 * wave[3],
        ]
        .map(|part| self.amplitude * part)
    }
}

impl Ramp {
    #[inline]
    fn at(self, t: f64, length: f64) -> [f64; 4] {
        if t >= length {
            return [1.0, 0.0, 0.0, 0.0];
        }
        let s = t / length;
        let by_s = match self {
            Ramp::Quintic => [
                s * s * s * (10.0 + s * (6.0 * s - 15.0)),
                30.0 * s * s * (1.0 - s) * (1.0 - s),
                60.0 * s * (1.0 - s) * (1.0 - 2.0 * s),
                60.0 * (1.0 + 6.0 * s * (s - 1.0)),
            ],
            Ramp::Cubic => [s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s), 6.0 - 12.0 * s, -12.0],
        };
        [by_s[0], by_s[1] / length, by_s[2] / powi(length, 2), by_s[3] / powi(length, 3)]
    }
}

impl Path {
    /// The spline through points of increasing times; `None` of fewer than two.
    pub fn new(points: Vec<(f64, [f64; 3])>) -> Option<Self> {
        if points.len() < 2 {
            return None;
        }
        let axes: [Vec<f64>; 3] = std::array::from_fn(|axis| {
            let times: Vec<f64> = points.iter().map(|point| point.0).collect();
            let values: Vec<f64> = points.iter().map(|point| point.1[axis]).collect();
            bends(&times, &values)
        });
        let bends = (0..points.len()).map(|i| std::array::from_fn(|axis| axes[axis][i])).collect();
        Some(Self { points, bends })
    }

    pub fn points(&self) -> &[(f64, [f64; 3])] {
        &self.points
    }

    #[inline]
    fn at(&self, t: f64, axis: Axis) -> [f64; 4] {
        let axis = axis as usize;
        let after = self.points.partition_point(|point| point.0 <= t);
        if after == 0 || after == self.points.len() {
            let end = if after == 0 { &self.points[0] } else { &self.points[after - 1] };
            return [end.1[axis], 0.0, 0.0, 0.0];
        }
        let ((t0, y0), (t1, y1)) = (self.points[after - 1], self.points[after]);
        let (m0, m1, h) = (self.bends[after - 1][axis], self.bends[after][axis], t1 - t0);
        let (a, b) = ((t1 - t) / h, (t - t0) / h);
        let chord = (y1[axis] - y0[axis]) / h;
        [
            a * y0[axis] + b * y1[axis] + h * h / 6.0 * ((a * a - 1.0) * a * m0 + (b * b - 1.0) * b * m1),
            chord + h / 6.0 * ((1.0 - 3.0 * a * a) * m0 + (3.0 * b * b - 1.0) * m1),
            a * m0 + b * m1,
            (m1 - m0) / h,
        ]
    }
}

/// Second derivatives of the cubic spline that is level at both ends (Thomas' algorithm).
fn bends(t: &[f64], y: &[f64]) -> Vec<f64> {
    let last = t.len() - 1;
    let chord = |i: usize| (y[i + 1] - y[i]) / (t[i + 1] - t[i]);
    let (mut upper, mut bends) = (vec![0.0; t.len()], vec![0.0; t.len()]);
    for i in 0..=last {
        let before = if i > 0 { t[i] - t[i - 1] } else { 0.0 };
        let after = if i < last { t[i + 1] - t[i] } else { 0.0 };
        let (into, out) = (if i > 0 { chord(i - 1) } else { 0.0 }, if i < last { chord(i) } else { 0.0 });
        let (was_upper, was) = if i > 0 { (upper[i - 1], bends[i - 1]) } else { (0.0, 0.0) };
        let pivot = 2.0 * (before + after) - before * was_upper;
        upper[i] = after / pivot;
        bends[i] = (6.0 * (out - into) - before * was) / pivot;
    }
    for i in (0..last).rev() {
        bends[i] -= upper[i] * bends[i + 1];
    }
    bends
}

impl Brake {
    /// How far it grips, 0…1, and the rate of that.
    #[inline]
    pub fn grip(&self, t: f64) -> (f64, f64) {
        let step = |from: f64| {
            let (value, slope) = smoothstep((t - from) / self.rise_s);
            (value, slope / self.rise_s)
        };
        let (on, on_rate) = step(self.start_s);
        let (off, off_rate) = self.release_s.map_or((0.0, 0.0), step);
        (on * (1.0 - off), on_rate * (1.0 - off) - on * off_rate)
    }

    /// The next time after `t` at which its grip bends.
    #[inline]
    pub fn next_corner(&self, t: f64) -> f64 {
        let from = [Some(self.start_s), self.release_s].into_iter().flatten();
        first_after(t, from.flat_map(|from| [from, from + self.rise_s]))
    }

    /// Torque of its bristle, N·m, where the shaft's rate and the bristle's memory add up to `held`, and its derivatives by that and by
    /// time.
    #[inline]
    pub fn held(&self, t: f64, held: f64, bristle: &Bristle) -> [f64; 3] {
        let (grip, grip_rate) = self.grip(t);
        let (most, growing) = (self.torque_n_m * grip, self.torque_n_m * grip_rate);
        let pull = bristle.damping_n_s_per_m * held;
        if pull < -most {
            [most, 0.0, growing]
        } else if self.one_way && pull > 0.0 {
            [0.0; 3]
        } else if pull > most {
            [-most, 0.0, -growing]
        } else {
            [-pull, -bristle.damping_n_s_per_m, 0.0]
        }
    }

    /// Torque at a rate of its shaft, N·m, and its derivatives by rate and time.
    #[inline]
    pub fn torque(&self, t: f64, rate: f64) -> [f64; 3] {
        let (grip, grip_rate) = self.grip(t);
        if grip == 0.0 && grip_rate == 0.0 || self.one_way && rate >= 0.0 {
            return [0.0; 3];
        }
        let (beta, slope) = if rate.abs() >= self.v_static_rad_s {
            (rate.signum(), 0.0)
        } else {
            let (sigma, slope) = smoothstep((rate + self.v_static_rad_s) / (2.0 * self.v_static_rad_s));
            (2.0 * sigma - 1.0, slope / self.v_static_rad_s)
        };
        [-grip * beta, -grip * slope, -grip_rate * beta].map(|part| self.torque_n_m * part)
    }
}

#[inline]
fn first_after(t: f64, times: impl Iterator<Item = f64>) -> f64 {
    times.filter(|time| *time > t).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion() -> PalmMotion {
        let path = Path::new(vec![
            (0.0, [0.0; 3]),
            (0.3, [0.1, -0.02, 0.3]),
            (0.5, [0.05, 0.0, -0.1]),
            (1.0, [0.2, 0.1, 0.0]),
        ]);
        let vibration = |axis, ramp| Vibration {
            axis,
            amplitude: 2e-3,
            frequency_hz: 7.0,
            phase_rad: 0.4,
            start_s: 0.1,
            ramp_periods: 3.0,
            ramp,
        };
        PalmMotion {
            moves: vec![
                Move { axis: Axis::X, distance: 0.3, start_s: 0.05, length_s: 0.6 },
                Move { axis: Axis::Angle, distance: -1.2, start_s: 0.2, length_s: 0.5 },
            ],
            vibrations: vec![vibration(Axis::Y, Ramp::Quintic), vibration(Axis::Angle, Ramp::Cubic)],
            path,
            ..PalmMotion::default()
        }
    }

    #[test]
    fn every_derivative_is_that_of_the_one_before() {
        let (motion, h) = (motion(), 1e-5);
        for t in [0.02, 0.07, 0.13, 0.28, 0.33, 0.47, 0.61, 0.69, 0.97] {
            let [before, at, after] = [t - h, t, t + h].map(|t| motion.pose(t));
            for axis in 0..3 {
                let slope = |of: fn(&Pose) -> [f64; 3]| (of(&after)[axis] - of(&before)[axis]) / (2.0 * h);
                for (found, of) in [
                    (at.rate, (|pose| pose.place) as fn(&Pose) -> [f64; 3]),
                    (at.acceleration, |pose| pose.rate),
                    (at.jerk, |pose| pose.acceleration),
                ] {
                    let expected = slope(of);
                    assert!(
                        (found[axis] - expected).abs() < 1e-6 * (10.0 + expected.abs()),
                        "{t} {axis}: {found:?} {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn moves_begin_and_end_at_rest_and_paths_go_through_their_points() {
        let motion = motion();
        let only = |moves: Vec<Move>| PalmMotion { moves, ..PalmMotion::default() };
        let moved = only(motion.moves.clone());
        assert_eq!(moved.pose(0.05), Pose::default());
        assert_eq!(moved.pose(0.71).place, [0.3, 0.0, -1.2]);
        assert!((moved.pose(0.35).place[0] - 0.15).abs() < 1e-15, "half way at half time");
        let path = PalmMotion { path: motion.path.clone(), ..PalmMotion::default() };
        for (t, place) in motion.path.iter().flat_map(Path::points) {
            let found = path.pose(*t);
            assert!((0..3).all(|axis| (found.place[axis] - place[axis]).abs() < 1e-15), "{t}: {found:?}");
        }
        assert!(path.pose(1e-9).rate.iter().chain(&path.pose(1.0 - 1e-9).rate).all(|rate| rate.abs() < 1e-6));
        let corners: Vec<f64> = std::iter::successors(Some(0.0), |t| Some(motion.next_corner(*t))).take(4).collect();
        assert_eq!(corners, [0.0, 0.05, 0.1, 0.2]);
        assert_eq!(motion.arrives_s(), 1.0);
    }

    #[test]
    fn brakes_hold_what_they_are_said_to() {
        let brake = Brake {
            torque_n_m: 2.0,
            start_s: 0.01,
            rise_s: 1e-3,
            release_s: Some(0.05),
            one_way: false,
            v_static_rad_s: 0.01,
            bristle: None,
        };
        assert_eq!(brake.torque(9e-3, 5.0), [0.0; 3]);
        assert_eq!(brake.torque(0.02, 5.0)[0], -2.0);
        assert_eq!(brake.torque(0.02, -5.0)[0], 2.0);
        assert!((brake.torque(0.0105, 5.0)[0] + 1.0).abs() < 1e-12);
        assert!((brake.torque(0.02, 0.0)[1] + 300.0).abs() < 1e-9, "1.5 T/v_s");
        assert_eq!(brake.torque(0.06, 5.0)[0], 0.0);
        let ratchet = Brake { one_way: true, ..brake };
        assert_eq!((ratchet.torque(0.02, 5.0)[0], ratchet.torque(0.02, -5.0)[0]), (0.0, 2.0));
        let (t, rate, h) = (0.0107, 0.004, 1e-7);
        let [_, by_rate, by_time] = brake.torque(t, rate);
        let slope = |a: [f64; 3], b: [f64; 3]| (a[0] - b[0]) / (2.0 * h);
        assert!((by_rate - slope(brake.torque(t, rate + h), brake.torque(t, rate - h))).abs() < 1e-3);
        assert!((by_time - slope(brake.torque(t + h, rate), brake.torque(t - h, rate))).abs() < 1e-3);
    }
}
