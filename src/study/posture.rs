//! Text form of a gripper's posture: `run`, `geometric`, or angles such as `q11=2 deg, q21=65 deg`.

use crate::grasp::gripper::{ExplicitPosture, PostureRequest};
use crate::units::{self, Dimension};

/// Posture of a gripper as specified in a text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PostureSpec {
    /// Posture in a run of the scene.
    Run,
    /// All phalanges in contact with the object at its position in the scene.
    Geometric,
    /// (q11, q21) of the right and left finger, and the coordinates of the object's centre that are specified.
    Angles { angles_rad: [[f64; 2]; 2], object_m: [Option<f64>; 2] },
}

/// Default distance from the object's surface within which a phalanx is in contact, m.
const DEFAULT_WITHIN_M: f64 = 5e-5;

impl PostureSpec {
    /// Posture for a grasp analysis at time `at_s` of a run. A surface no farther than `within_m` from the object is in
    /// contact.
    ///
    /// # Errors
    /// Returns an error if the arguments do not apply to this posture.
    pub fn to_grasp_posture(self, at_s: Option<f64>, within_m: Option<f64>) -> Result<PostureRequest, String> {
        if at_s.is_some() && self != PostureSpec::Run {
            return Err("--at is a time of a run, but --posture does not use a run: remove one of them".to_string());
        }
        match self {
            PostureSpec::Angles { angles_rad, object_m } => Ok(PostureRequest::Explicit(ExplicitPosture {
                angles_rad,
                object_m,
                within_m: within_m.unwrap_or(DEFAULT_WITHIN_M),
            })),
            PostureSpec::Run => Ok(PostureRequest::Run { at_s, within_m }),
            PostureSpec::Geometric if within_m.is_some() => {
                Err("with --posture geometric all phalanges are in contact with the object: remove --within"
                    .to_string())
            }
            PostureSpec::Geometric => Ok(PostureRequest::Geometric),
        }
    }
}

const EXAMPLE: &str = "expected \"run\", \"geometric\" or angles such as \"q11=2 deg, q21=65 deg\"";

/// Parses a posture.
///
/// # Errors
/// Returns an error if a key is unknown, an angle is missing or a value is invalid.
pub fn parse_posture(text: &str) -> Result<PostureSpec, String> {
    match text.trim() {
        "run" => return Ok(PostureSpec::Run),
        "geometric" => return Ok(PostureSpec::Geometric),
        _ => {}
    }
    let mut angles: [[Option<f64>; 2]; 2] = [[None; 2]; 2];
    let mut object_m = [None; 2];
    let entries = text.split(',').map(str::trim).filter(|entry| !entry.is_empty());
    for entry in entries {
        let (key, value) = entry.split_once('=').ok_or_else(|| format!("`{entry}` has no `=`; {EXAMPLE}"))?;
        let (key, value) = (key.trim(), value.trim());
        let (coordinate, side) = match key.split_once('_') {
            Some((coordinate, side)) => (coordinate, Some(side)),
            None => (key, None),
        };
        let sides: &[usize] = match side {
            None => &[0, 1],
            Some("r") => &[0],
            Some("l") => &[1],
            Some(_) => return Err(unknown_key(key)),
        };
        let invalid = |error: units::QuantityError| format!("`{entry}`: {error}");
        match (coordinate, side) {
            ("q11" | "q21", _) => {
                let angle = units::parse(value, Dimension::Angle).map_err(invalid)?;
                sides.iter().for_each(|&side| angles[side][usize::from(coordinate == "q21")] = Some(angle));
            }
            ("x" | "y", None) => {
                let length = units::parse(value, Dimension::Length).map_err(invalid)?;
                object_m[usize::from(coordinate == "y")] = Some(length);
            }
            _ => return Err(unknown_key(key)),
        }
    }
    let mut angles_rad = [[0.0; 2]; 2];
    for (side, suffix) in ["_r", "_l"].into_iter().enumerate() {
        for (index, name) in ["q11", "q21"].into_iter().enumerate() {
            let missing = || format!("{name}{suffix} is missing, and there is no {name} for both fingers; {EXAMPLE}");
            angles_rad[side][index] = angles[side][index].ok_or_else(missing)?;
        }
    }
    Ok(PostureSpec::Angles { angles_rad, object_m })
}

fn unknown_key(key: &str) -> String {
    format!("`{key}` is not one of q11, q21, q11_r, q21_r, q11_l, q21_l, x, y; {EXAMPLE}")
}

/// Parses the angle between adjacent directions and returns the number of directions in a full turn.
///
/// # Errors
/// Returns an error if the angle does not divide a full turn into 4 to 720 directions.
pub fn parse_direction_count(text: &str) -> Result<usize, String> {
    let angle_rad = units::parse(text, Dimension::Angle).map_err(|error| error.to_string())?;
    let count = std::f64::consts::TAU / angle_rad;
    match count.round() {
        whole if (whole - count).abs() < 1e-6 * whole && (4.0..=720.0).contains(&whole) => Ok(whole as usize),
        _ => Err("the angle must divide a full turn into 4 to 720 directions; expected an angle such as \"15 deg\""
            .to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_postures() {
        assert_eq!(
            (parse_posture("run"), parse_posture(" geometric ")),
            (Ok(PostureSpec::Run), Ok(PostureSpec::Geometric))
        );
        let both = parse_posture("q11 = 0.1 rad, q21=0.2 rad,x=1 mm").expect("angles");
        assert_eq!(both, PostureSpec::Angles { angles_rad: [[0.1, 0.2]; 2], object_m: [Some(1e-3), None] });
        let distinct = parse_posture("q11=0.1 rad,q21=0.2 rad,q11_l=0.3 rad").expect("angles");
        assert_eq!(distinct, PostureSpec::Angles { angles_rad: [[0.1, 0.2], [0.3, 0.2]], object_m: [None; 2] });
        for (text, message) in [
            ("q11=0.1 rad", "q21_r is missing"),
            ("q11_r=1 deg,q21=1 deg", "q11_l is missing"),
            ("q12=1 deg", "not one of q11"),
            ("q11_x=1 deg", "not one of q11"),
            ("x_r=1 mm", "not one of q11"),
            ("closed", "has no `=`"),
            ("q11=1", "no unit"),
            ("", "q11_r is missing"),
        ] {
            let error = parse_posture(text).expect_err(message);
            assert!(error.contains(message), "{text}: {error}");
        }
    }

    #[test]
    fn directions_divide_a_full_turn() {
        assert_eq!((parse_direction_count("15 deg"), parse_direction_count("0.5 deg")), (Ok(24), Ok(720)));
        for text in ["7 deg", "0 deg", "-15 deg", "200 deg", "0.1 deg"] {
            assert!(parse_direction_count(text).expect_err(text).contains("divide a full turn"), "{text}");
        }
    }
}
