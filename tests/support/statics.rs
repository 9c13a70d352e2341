//! Grasps of discs by single fingers: of given designs and of random ones.

pub use super::runs::Random;
use phalanx::gripper::{
    Assembly, Design, FinalPosture, Finger, Lengths, Placement, ProximalLength, Spring, SpringKind, bodies, close_loop,
    disc, final_posture, joint_positions, lengths,
};
use phalanx::numeric::plane::{add, rotate, sub};
use phalanx::shape::{PlacedShape, max_radius};
use phalanx::statics::{Certificate, FormClosure, GraspConfiguration, Unilateral};
use serde_json::Value;

/// A finger in its final posture on a disc.
#[derive(Clone, Debug)]
pub struct Grasp {
    pub finger: Finger,
    pub disc: PlacedShape,
    pub end: FinalPosture,
}

/// Returns the grasp of a design; `None` if the design has none.
pub fn grasp(design: &Design) -> Option<Grasp> {
    let lengths = lengths(design).ok()?;
    let finger = Finger { lengths, bodies: bodies(&lengths, 1070.0, 0.04).ok()?, assembly: Assembly::Reference };
    let disc = disc(design);
    let end = final_posture(&lengths, Assembly::Reference, disc).ok()?;
    Some(Grasp { finger, disc, end })
}

/// Returns the grasp with phalanges of zero width and a disc that is larger by their half width.
pub fn without_width(grasp: &Grasp) -> Grasp {
    let w = grasp.finger.lengths.half_width_m;
    let finger = Finger { lengths: Lengths { half_width_m: 0.0, ..grasp.finger.lengths }, ..grasp.finger };
    let disc = PlacedShape::disc(max_radius(&grasp.disc.shape) + w, grasp.disc.centre_m);
    let end = final_posture(&finger.lengths, finger.assembly, disc).expect("tangent to the same virtual circle");
    Grasp { finger, disc, end }
}

pub fn constant_spring(torque_n_m: f64) -> Spring {
    Spring { kind: SpringKind::Constant { torque_n_m }, placement: Placement::Phalanges }
}

impl Random {
    /// Returns the next random design within the ranges of the thesis (§3.4) that has a grasp.
    pub fn grasp(&mut self) -> Grasp {
        loop {
            let base_m = self.within(0.012, 0.0225);
            let l21 = ProximalLength::Fraction(self.within(0.0, 1.0));
            let phi22_rad = self.within(90.0, 120.0).to_radians();
            let design = Design::thesis(base_m, l21, phi22_rad, self.within(1.0 / 3.0, 2.0 / 3.0));
            if let Some(grasp) = grasp(&design) {
                return grasp;
            }
        }
    }
}

impl Random {
    /// Returns fingers of different designs around an object away from the centre, with angles perturbed by up to
    /// `angle_rad`. The loops may not close.
    pub fn configuration<'a>(
        &mut self,
        [right, left]: [&'a Grasp; 2],
        angle_rad: f64,
        offset_m: [f64; 2],
    ) -> GraspConfiguration<'a> {
        let mut around = |mean: f64, range: f64| mean + self.within(-range, range);
        GraspConfiguration {
            fingers: [&right.finger, &left.finger],
            angles_rad: [right, left]
                .map(|grasp| [grasp.end.posture.q11_rad, grasp.end.posture.q21_rad].map(|q| around(q, angle_rad))),
            palm_width_m: -right.disc.centre_m[0] - left.disc.centre_m[0],
            object: right.disc.at([around(0.0, offset_m[0]), around(right.disc.centre_m[1], offset_m[1])]),
        }
    }
}

/// Frame of a link: its first joint, and the direction of its x axis.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub origin_m: [f64; 2],
    pub angle_rad: f64,
}

impl Frame {
    /// Returns the position of a point that is fixed to the link.
    pub fn point(&self, local_m: [f64; 2]) -> [f64; 2] {
        add(self.origin_m, rotate(local_m, [self.angle_rad.cos(), self.angle_rad.sin()]))
    }

    /// Returns a point in the frame of the link.
    pub fn local(&self, point_m: [f64; 2]) -> [f64; 2] {
        rotate(sub(point_m, self.origin_m), [self.angle_rad.cos(), -self.angle_rad.sin()])
    }
}

/// Returns the frames of l11, l12, l21 and l22 for driven angles (q11, q21).
pub fn frames(finger: &Finger, [q11, q21]: [f64; 2]) -> [Frame; 4] {
    let posture = close_loop(&finger.lengths, finger.assembly, q11, q21).expect("near a posture");
    let joints = joint_positions(&finger.lengths, &posture);
    let (q12, q22) = (posture.q12_rad, posture.q22_rad);
    [([0.0; 2], q11), (joints.a12_m, q11 + q12), ([0.0; 2], q21), (joints.a22_m, q21 + q22)]
        .map(|(origin_m, angle_rad)| Frame { origin_m, angle_rad })
}

/// Returns the derivatives by q11 and q21 of quantities of the frames, by central differences.
pub fn rates<const N: usize>(
    finger: &Finger,
    q: [f64; 2],
    quantities: impl Fn([Frame; 4]) -> [f64; N],
) -> [[f64; N]; 2] {
    const H: f64 = 1e-6;
    [[H, 0.0], [0.0, H]].map(|step| {
        let (above, below) = (quantities(frames(finger, add(q, step))), quantities(frames(finger, sub(q, step))));
        std::array::from_fn(|i| (above[i] - below[i]) / (2.0 * H))
    })
}

/// Returns the final posture of a finger and its mirror image, with the object on the palm between them.
pub fn symmetric_configuration(Grasp { finger, disc, end }: &Grasp) -> GraspConfiguration<'_> {
    GraspConfiguration {
        fingers: [finger; 2],
        angles_rad: [[end.posture.q11_rad, end.posture.q21_rad]; 2],
        palm_width_m: -2.0 * disc.centre_m[0],
        object: disc.at([0.0, disc.centre_m[1]]),
    }
}

/// Returns the configuration mirrored about the centre of the palm.
pub fn mirrored_configuration<'a>(configuration: &GraspConfiguration<'a>) -> GraspConfiguration<'a> {
    let ([right, left], [right_angles, left_angles]) = (configuration.fingers, configuration.angles_rad);
    let [x, y] = configuration.object.centre_m;
    GraspConfiguration {
        fingers: [left, right],
        angles_rad: [left_angles, right_angles],
        object: configuration.object.at([-x, y]),
        ..*configuration
    }
}

/// Verifies the certificate of a form-closure decision by sums over the rows and columns of U.
#[track_caller]
pub fn check_certificate(u: &Unilateral, closure: &FormClosure) {
    match &closure.certificate {
        Certificate::Multipliers { values, residual } => {
            assert!(closure.closed && closure.rank == u.unknowns.len());
            assert!(values.iter().all(|&lambda| lambda > 0.0), "{values:?}");
            for (j, unknown) in u.unknowns.iter().enumerate() {
                let terms: Vec<f64> = values.iter().enumerate().map(|(i, l)| l * u.row(i)[j]).collect();
                let size = terms.iter().map(|t| t.abs()).fold(0.0, f64::max);
                assert!(terms.iter().sum::<f64>().abs() < 1e-9 * size, "{unknown:?}: {terms:?}");
            }
            assert!(*residual < 1e-12, "{residual:e}");
        }
        Certificate::Motion { values, rates, residual } => {
            assert!(!closure.closed);
            assert!(values.iter().any(|v| v.abs() > 1e-9), "{values:?}");
            let largest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
            let speed = largest(&mut values.iter().zip(&u.scale).map(|(w, scale)| w * scale));
            for (i, row) in u.rows.iter().enumerate() {
                let terms: Vec<f64> = values.iter().zip(u.row(i)).map(|(w, u)| w * u).collect();
                let size = speed * largest(&mut u.row(i).iter().zip(&u.scale).map(|(u, scale)| u / scale));
                let sum = terms.iter().sum::<f64>();
                assert!(sum >= -1e-9 * size, "{row:?}: {terms:?}");
                assert!((sum - rates[i]).abs() <= 1e-12 * size);
            }
            assert!(*residual < 1e-12, "{residual:e}");
        }
    }
}

/// Returns a number of a JSON document.
#[track_caller]
pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

/// Asserts that the keys of all numbers in a document of `phalanx statics` end with a unit, except for dimensionless
/// numbers.
pub fn assert_units(document: &Value) {
    const DIMENSIONLESS: &str = "mu_static normal direction transmission transmission_inverse contacts motors hand object rank \
                                 unknowns margin residual forces gap q1_l1 q1_linf weakest";
    const UNITS: [&str; 9] = ["_s", "_m", "_n", "_n_m", "_rad", "_m_s", "_rad_s", "_m_s2", "_kg"];
    fn check(key: &str, value: &Value) {
        match value {
            Value::Number(_) => assert!(
                DIMENSIONLESS.split(' ').any(|known| known == key) || UNITS.iter().any(|unit| key.ends_with(unit)),
                "the number under \"{key}\" has no unit"
            ),
            Value::Array(values) => values.iter().for_each(|value| check(key, value)),
            Value::Object(fields) => fields.iter().for_each(|(key, value)| check(key, value)),
            _ => {}
        }
    }
    check("", document);
}
