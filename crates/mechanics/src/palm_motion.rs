//! Motion of the palm in the world.

use std::f64::consts::TAU;

use crate::drive::first_after;
use crate::numeric::elementary::{hypot, powi, sin_cos};
use crate::numeric::plane::rotate;

/// Pose (X, Y, Φ) of the palm over time: the sum of its initial pose, moves, vibrations and path. The palm is initially
/// at rest. X and Y are along the axes of the world; Φ is the rotation about the origin of the palm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PalmMotion {
    /// Pose before all motions, m and rad: the start pose of the body.
    pub initial_pose: [f64; 3],
    pub moves: Vec<Move>,
    pub vibrations: Vec<Vibration>,
    pub path: Option<Path>,
    /// Names of the moves and of the vibrations in the scene file; either list may be shorter than that of the motions.
    pub names: [Vec<String>; 2],
}

/// A coordinate of the palm's pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    X,
    Y,
    Angle,
}

/// A move from rest to rest along a polynomial of order 7, with zero rate, acceleration and jerk at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    pub axis: Axis,
    /// Change of the coordinate, m or rad.
    pub distance: f64,
    pub start_s: f64,
    pub length_s: f64,
}

/// amplitude × ramp × sin(2π f (t − start) + phase).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vibration {
    pub axis: Axis,
    /// Amplitude of the coordinate, m or rad.
    pub amplitude: f64,
    pub frequency_hz: f64,
    pub phase_rad: f64,
    pub start_s: f64,
    /// Duration of the ramp in periods.
    pub ramp_periods: f64,
    pub ramp: Ramp,
}

/// Ramp of the amplitude of a vibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ramp {
    /// 10 s³ − 15 s⁴ + 6 s⁵, with continuous acceleration.
    Quintic,
    /// 3 s² − 2 s³.
    Cubic,
}

/// A cubic spline through poses, at rest at both ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Time and (X, Y, Φ), in s, m and rad.
    points: Vec<(f64, [f64; 3])>,
    /// Second derivatives at the points.
    second_derivatives: Vec<[f64; 3]>,
}

/// Pose (X, Y, Φ) and its first three derivatives, in m, rad and s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    pub position: [f64; 3],
    pub rate: [f64; 3],
    pub acceleration: [f64; 3],
    pub jerk: [f64; 3],
}

impl Pose {
    #[inline]
    fn add(&mut self, axis: Axis, derivatives: [f64; 4]) {
        let all = [&mut self.position, &mut self.rate, &mut self.acceleration, &mut self.jerk];
        for (part, derivative) in all.into_iter().zip(derivatives) {
            part[axis as usize] += derivative;
        }
    }
}

impl PalmMotion {
    /// Pose at time t.
    #[inline]
    pub fn pose(&self, t: f64) -> Pose {
        let mut pose = Pose { position: self.initial_pose, ..Pose::default() };
        for item in &self.moves {
            pose.add(item.axis, item.derivatives(t));
        }
        for item in &self.vibrations {
            pose.add(item.axis, item.derivatives(t));
        }
        for (path, axis) in self.path.iter().flat_map(|path| [Axis::X, Axis::Y, Axis::Angle].map(|axis| (path, axis))) {
            pose.add(axis, path.derivatives(t, axis));
        }
        pose
    }

    /// Transforms a vector from the axes of the world to those of the initial pose of the palm.
    pub fn in_initial_axes(&self, vector: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = sin_cos(self.initial_pose[2]);
        rotate(vector, [cos, -sin])
    }

    /// Pose of the world in the frame of the palm at time t: position −e^(−iΦ) p and angle −Φ, where the complex number
    /// p is the position of the palm.
    pub fn world_pose(&self, t: f64) -> Pose {
        let Pose { position, rate, acceleration, jerk } = self.pose(t);
        let ([.., angle], [.., omega], [.., alpha], [.., alpha_rate]) = (position, rate, acceleration, jerk);
        let (sin, cos) = sin_cos(angle);
        let of = |[x, y, _]: [f64; 3]| [x, y];
        let [p, p1, p2, p3] = [position, rate, acceleration, jerk].map(of);
        // A sum of multiples of the derivatives of p, each also rotated by 90°.
        let sum = |terms: &[([f64; 2], [f64; 2])]| {
            terms.iter().fold([0.0; 2], |[x, y], ([u, v], [straight, across])| {
                [x + straight * u - across * v, y + straight * v + across * u]
            })
        };
        let in_palm = |[x, y]: [f64; 2], turn: f64| [-(cos * x + sin * y), sin * x - cos * y, turn];
        let squared = omega * omega;
        let first = sum(&[(p1, [1.0, 0.0]), (p, [0.0, -omega])]);
        let second = sum(&[(p2, [1.0, 0.0]), (p1, [0.0, -2.0 * omega]), (p, [-squared, -alpha])]);
        let third = sum(&[
            (p3, [1.0, 0.0]),
            (p2, [0.0, -3.0 * omega]),
            (p1, [-3.0 * squared, -3.0 * alpha]),
            (p, [-3.0 * omega * alpha, omega * squared - alpha_rate]),
        ]);
        Pose {
            position: in_palm(p, -angle),
            rate: in_palm(first, -omega),
            acceleration: in_palm(second, -alpha),
            jerk: in_palm(third, -alpha_rate),
        }
    }

    /// Upper bounds of the rates and accelerations of [`PalmMotion::world_pose`] between two times.
    pub fn largest_world_rates(&self, [from, to]: [f64; 2]) -> [[f64; 3]; 2] {
        let [[vx, vy, omega], [ax, ay, alpha]] = self.largest_rates([from, to]);
        let [x, y, _] = self.pose(from).position;
        let (speed, acceleration) = (hypot(vx, vy), hypot(ax, ay));
        let distance = hypot(x, y) + speed * (to - from);
        let turning = alpha * distance + omega * (2.0 * speed + omega * distance);
        [[speed + omega * distance, 0.0, omega], [acceleration + turning, 0.0, alpha]]
    }

    /// Times at which some derivative jumps.
    #[inline]
    fn corners(&self) -> impl Iterator<Item = f64> {
        let moves = self.moves.iter().flat_map(|item| [item.start_s, item.start_s + item.length_s]);
        let vibrations = self.vibrations.iter().flat_map(|item| [item.start_s, item.start_s + item.ramp_s()]);
        let path = self.path.iter().flat_map(|path| path.points.iter().map(|point| point.0));
        moves.chain(vibrations).chain(path)
    }

    /// Upper bounds of the rates and accelerations of (X, Y, Φ) between two times.
    pub fn largest_rates(&self, [from, to]: [f64; 2]) -> [[f64; 3]; 2] {
        let mut largest = [[0.0; 3]; 2];
        let mut add = |axis: Axis, rates: [f64; 2]| (0..2).for_each(|k| largest[k][axis as usize] += rates[k]);
        for item in self.moves.iter().filter(|item| from < item.start_s + item.length_s && item.start_s < to) {
            add(item.axis, item.largest_rates());
        }
        for item in self.vibrations.iter().filter(|item| item.start_s < to) {
            add(item.axis, item.largest_rates(from));
        }
        for (path, axis) in self.path.iter().flat_map(|path| [Axis::X, Axis::Y, Axis::Angle].map(|axis| (path, axis))) {
            add(axis, path.largest_rates([from, to], axis));
        }
        largest
    }

    /// Returns the next time after `t` at which any derivative jumps; infinite if there is none.
    #[inline]
    pub fn next_discontinuity(&self, t: f64) -> f64 {
        first_after(t, self.corners())
    }

    /// Time at which the palm begins to move, s.
    pub fn start_s(&self) -> f64 {
        self.corners().fold(f64::INFINITY, f64::min)
    }

    /// Largest absolute acceleration of a point of the palm up to a time, m/s².
    pub fn peak_acceleration_m_s2(&self, [x, y]: [f64; 2], until_s: f64) -> f64 {
        let acceleration = |time_s: f64| {
            let pose = self.pose(time_s);
            let ([ax, ay, alpha], omega) = (pose.acceleration, pose.rate[2]);
            let (sin, cos) = sin_cos(pose.position[2]);
            let (rx, ry) = (cos * x - sin * y, sin * x + cos * y);
            hypot(ax - alpha * ry - omega * omega * rx, ay + alpha * rx - omega * omega * ry)
        };
        let mut corners = vec![0.0];
        while let Some(next) = corners.last().map(|last| self.next_discontinuity(*last)).filter(|next| *next < until_s)
        {
            corners.push(next);
        }
        corners.push(until_s);
        // Near its maximum the acceleration is a parabola: with this number of points the relative error is 4e-8; with
        // a tenth of them it is a hundred times larger.
        const POINTS: f64 = 10_000.0;
        let max_points = (100.0 * POINTS / corners.len() as f64).max(10.0);
        let max_frequency_hz = self.vibrations.iter().map(|item| item.frequency_hz).fold(0.0, f64::max);
        let times = corners.windows(2).flat_map(|pair| {
            let (from, to) = (pair[0], pair[1]);
            // A hundred points per period, within the limit.
            let points = (100.0 * max_frequency_hz * (to - from)).clamp(POINTS.min(max_points), max_points);
            (0..=points as usize).map(move |index| from + (to - from) * index as f64 / points)
        });
        times.map(acceleration).fold(0.0, f64::max)
    }

    /// End of all moves and of the path, s; vibrations continue.
    pub fn moves_end_s(&self) -> f64 {
        let moves = self.moves.iter().map(|item| item.start_s + item.length_s);
        moves.chain(self.path.iter().filter_map(|path| path.points.last()).map(|point| point.0)).fold(0.0, f64::max)
    }
}

impl Move {
    /// Peak acceleration of a move over unit length in unit time: the maximum of 420 u² (1 − u)² (1 − 2u), at 1 − 2u =
    /// 1/√5.
    pub fn unit_peak_acceleration() -> f64 {
        3.36 * 5f64.sqrt()
    }

    /// Largest rate, 140/64 of the mean one, and largest acceleration.
    fn largest_rates(&self) -> [f64; 2] {
        let mean = (self.distance / self.length_s).abs();
        [2.1875 * mean, Self::unit_peak_acceleration() * mean / self.length_s]
    }

    #[inline]
    fn derivatives(&self, t: f64) -> [f64; 4] {
        let since = t - self.start_s;
        if since <= 0.0 {
            return [0.0; 4];
        }
        if since >= self.length_s {
            return [self.distance, 0.0, 0.0, 0.0];
        }
        let u = since / self.length_s;
        let (w, rate) = (1.0 - u, self.distance / self.length_s);
        let second = rate / self.length_s;
        let (u_square, product) = (u * u, u * w);
        let product_square = product * product;
        [
            self.distance * (u_square * u_square) * (35.0 + u * (-84.0 + u * (70.0 - 20.0 * u))),
            rate * 140.0 * (product * product_square),
            second * 420.0 * product_square * (w - u),
            second / self.length_s * 840.0 * u * w * (1.0 - 5.0 * u * w),
        ]
    }
}

impl Vibration {
    #[inline]
    fn ramp_s(&self) -> f64 {
        self.ramp_periods / self.frequency_hz
    }

    /// Upper bounds of rate and acceleration from time `from` on.
    fn largest_rates(&self, from: f64) -> [f64; 2] {
        let (omega, amplitude) = (TAU * self.frequency_hz, self.amplitude.abs());
        let is_ramp_over = from >= self.start_s + self.ramp_s();
        let [r1, r2] = if is_ramp_over { [0.0; 2] } else { self.ramp.largest_derivatives(self.ramp_s()) };
        [amplitude * (r1 + omega), amplitude * (r2 + 2.0 * r1 * omega + omega * omega)]
    }

    #[inline]
    fn derivatives(&self, t: f64) -> [f64; 4] {
        let since = t - self.start_s;
        if since <= 0.0 {
            return [0.0; 4];
        }
        let omega = TAU * self.frequency_hz;
        let (sin, cos) = sin_cos(omega * since + self.phase_rad);
        let oscillation = [sin, omega * cos, -omega * omega * sin, -powi(omega, 3) * cos];
        let [r0, r1, r2, r3] = self.ramp.derivatives(since, self.ramp_s());
        // Derivatives of the product by Leibniz' rule.
        [
            r0 * oscillation[0],
            r1 * oscillation[0] + r0 * oscillation[1],
            r2 * oscillation[0] + 2.0 * r1 * oscillation[1] + r0 * oscillation[2],
            r3 * oscillation[0] + 3.0 * r2 * oscillation[1] + 3.0 * r1 * oscillation[2] + r0 * oscillation[3],
        ]
        .map(|part| self.amplitude * part)
    }
}

impl Ramp {
    /// Largest first and second derivatives of a ramp of this length: 15/8 and 10/√3, or 3/2 and 6, over its powers.
    fn largest_derivatives(self, length: f64) -> [f64; 2] {
        let [first, second] = match self {
            Ramp::Quintic => [1.875, 10.0 / 3f64.sqrt()],
            Ramp::Cubic => [1.5, 6.0],
        };
        [first / length, second / (length * length)]
    }

    #[inline]
    fn derivatives(self, t: f64, length: f64) -> [f64; 4] {
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
    /// Creates the spline through points with increasing times; `None` for fewer than two points.
    pub fn new(points: Vec<(f64, [f64; 3])>) -> Option<Self> {
        if points.len() < 2 {
            return None;
        }
        let axes: [Vec<f64>; 3] = std::array::from_fn(|axis| {
            let times: Vec<f64> = points.iter().map(|point| point.0).collect();
            let values: Vec<f64> = points.iter().map(|point| point.1[axis]).collect();
            second_derivatives(&times, &values)
        });
        let second_derivatives = (0..points.len()).map(|i| std::array::from_fn(|axis| axes[axis][i])).collect();
        Some(Self { points, second_derivatives })
    }

    pub fn points(&self) -> &[(f64, [f64; 3])] {
        &self.points
    }

    /// Upper bounds of rate and acceleration between two times.
    fn largest_rates(&self, [from, to]: [f64; 2], axis: Axis) -> [f64; 2] {
        let axis = axis as usize;
        let overlapping =
            (1..self.points.len()).filter(|after| self.points[after - 1].0 < to && from < self.points[*after].0);
        overlapping.fold([0.0; 2], |[rate, acceleration]: [f64; 2], after| {
            let ((t0, y0), (t1, y1)) = (self.points[after - 1], self.points[after]);
            let [m0, m1] = [after - 1, after].map(|point| self.second_derivatives[point][axis].abs());
            let h = t1 - t0;
            let largest = ((y1[axis] - y0[axis]) / h).abs() + h / 3.0 * (m0 + m1);
            [rate.max(largest), acceleration.max(m0).max(m1)]
        })
    }

    #[inline]
    fn derivatives(&self, t: f64, axis: Axis) -> [f64; 4] {
        let axis = axis as usize;
        let after = self.points.partition_point(|point| point.0 <= t);
        if after == 0 || after == self.points.len() {
            let end = if after == 0 { &self.points[0] } else { &self.points[after - 1] };
            return [end.1[axis], 0.0, 0.0, 0.0];
        }
        let ((t0, y0), (t1, y1)) = (self.points[after - 1], self.points[after]);
        let (m0, m1, h) = (self.second_derivatives[after - 1][axis], self.second_derivatives[after][axis], t1 - t0);
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

/// Second derivatives of the cubic spline with zero slope at both ends (Thomas algorithm).
fn second_derivatives(t: &[f64], y: &[f64]) -> Vec<f64> {
    let last = t.len() - 1;
    let chord = |i: usize| (y[i + 1] - y[i]) / (t[i + 1] - t[i]);
    let (mut upper, mut second_derivatives) = (vec![0.0; t.len()], vec![0.0; t.len()]);
    for i in 0..=last {
        let before = if i > 0 { t[i] - t[i - 1] } else { 0.0 };
        let after = if i < last { t[i + 1] - t[i] } else { 0.0 };
        let (into, out) = (if i > 0 { chord(i - 1) } else { 0.0 }, if i < last { chord(i) } else { 0.0 });
        let (was_upper, was) = if i > 0 { (upper[i - 1], second_derivatives[i - 1]) } else { (0.0, 0.0) };
        let pivot = 2.0 * (before + after) - before * was_upper;
        upper[i] = after / pivot;
        second_derivatives[i] = (6.0 * (out - into) - before * was) / pivot;
    }
    for i in (0..last).rev() {
        second_derivatives[i] -= upper[i] * second_derivatives[i + 1];
    }
    second_derivatives
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
    fn derivatives_match_finite_differences() {
        let (motion, h) = (PalmMotion { initial_pose: [0.3, -0.1, 0.7], ..motion() }, 1e-5);
        assert_eq!(motion.pose(0.0).position, motion.initial_pose);
        for t in [0.02, 0.07, 0.13, 0.28, 0.33, 0.47, 0.61, 0.69, 0.97] {
            let [before, middle, after] = [t - h, t, t + h].map(|t| motion.pose(t));
            for axis in 0..3 {
                let slope =
                    |quantity: fn(&Pose) -> [f64; 3]| (quantity(&after)[axis] - quantity(&before)[axis]) / (2.0 * h);
                for (found, quantity) in [
                    (middle.rate, (|pose| pose.position) as fn(&Pose) -> [f64; 3]),
                    (middle.acceleration, |pose| pose.rate),
                    (middle.jerk, |pose| pose.acceleration),
                ] {
                    let expected = slope(quantity);
                    assert!(
                        (found[axis] - expected).abs() < 1e-6 * (10.0 + expected.abs()),
                        "{t} {axis}: {found:?} {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn largest_rates_bound_all_rates_tightly() {
        let motion = motion();
        for [from, to] in [[0.0, 0.04], [0.02, 0.3], [0.11, 0.13], [0.25, 0.9], [0.6, 0.61], [0.99, 1.4]] {
            let bounds = motion.largest_rates([from, to]);
            let mut found = [[0.0f64; 3]; 2];
            for step in 0..=1000 {
                let pose = motion.pose(from + (to - from) * f64::from(step) / 1000.0);
                for (found, values) in found.iter_mut().zip([pose.rate, pose.acceleration]) {
                    found.iter_mut().zip(values).for_each(|(found, value)| *found = found.max(value.abs()));
                }
            }
            for (bound, found) in bounds.iter().flatten().zip(found.iter().flatten()) {
                assert!(*found <= bound * (1.0 + 1e-12), "{from} {to}: {found} {bound}");
            }
        }
        // The bounds of the middle of a move and of a vibration are reached.
        let single = PalmMotion { moves: vec![motion.moves[0]], ..PalmMotion::default() };
        let [rate, acceleration] = single.largest_rates([0.0, 1.0]).map(|bound| bound[0]);
        assert!((rate - single.pose(0.35).rate[0]).abs() < 1e-12, "{rate}");
        assert!((acceleration - single.peak_acceleration_m_s2([0.0; 2], 1.0)).abs() < 1e-6, "{acceleration}");
    }

    #[test]
    fn moves_start_and_end_at_rest_and_paths_interpolate_points() {
        let motion = motion();
        let with_moves = |moves: Vec<Move>| PalmMotion { moves, ..PalmMotion::default() };
        let moved = with_moves(motion.moves.clone());
        assert_eq!(moved.pose(0.05), Pose::default());
        assert_eq!(moved.pose(0.71).position, [0.3, 0.0, -1.2]);
        assert!((moved.pose(0.35).position[0] - 0.15).abs() < 1e-15, "half of the distance at half of the time");
        let path = PalmMotion { path: motion.path.clone(), ..PalmMotion::default() };
        for (t, position) in motion.path.iter().flat_map(Path::points) {
            let found = path.pose(*t);
            assert!((0..3).all(|axis| (found.position[axis] - position[axis]).abs() < 1e-15), "{t}: {found:?}");
        }
        assert!(path.pose(1e-9).rate.iter().chain(&path.pose(1.0 - 1e-9).rate).all(|rate| rate.abs() < 1e-6));
        let corners: Vec<f64> =
            std::iter::successors(Some(0.0), |t| Some(motion.next_discontinuity(*t))).take(4).collect();
        assert_eq!(corners, [0.0, 0.05, 0.1, 0.2]);
        assert_eq!(motion.moves_end_s(), 1.0);
    }
}
