//! Postures of a gripper in words: `run`, `geometric`, or angles such as `q11=2 deg, q21=65 deg`.

use crate::grasp::gripper::{Given, PostureOf};
use crate::units::{self, Dimension};

/// What is said of a posture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Posture {
    /// Of a run.
    Run,
    /// All phalanges on the object where the scene has it.
    Geometric,
    /// (q11, q21) of right and left, and the object's centre where it is given.
    Given { angles_rad: [[f64; 2]; 2], object_m: [Option<f64>; 2] },
}

/// Nearer than this to the object's surface a phalanx touches it, if nothing else is said.
const WITHIN_M: f64 = 5e-5;

impl Posture {
    /// What is asked with it: `at_s` is a time of a run, `within_m` how far what touches may be from the object.
    ///
    /// # Errors
    /// What does not go together.
    pub fn asked(self, at_s: Option<f64>, within_m: Option<f64>) -> Result<PostureOf, String> {
        if at_s.is_some() && self != Posture::Run {
            return Err("--at is a time of a run, and --posture asks for none: take one of them out".to_string());
        }
        match self {
            Posture::Given { angles_rad, object_m } => {
                Ok(PostureOf::Given(Given { angles_rad, object_m, within_m: within_m.unwrap_or(WITHIN_M) }))
            }
            Posture::Run => Ok(PostureOf::Run { at_s, within_m }),
            Posture::Geometric if within_m.is_some() => {
                Err("with --posture geometric all phalanges touch the object: take out --within".to_string())
            }
            Posture::Geometric => Ok(PostureOf::Geometric),
        }
    }
}

const EXAMPLE: &str = "expected \"run\", \"geometric\" or angles such as \"q11=2 deg, q21=65 deg\"";

/// Reads a posture.
///
/// # Errors
/// What it lacks, or is not known.
pub fn posture(text: &str) -> Result<Posture, String> {
    match text.trim() {
        "run" => return Ok(Posture::Run),
        "geometric" => return Ok(Posture::Geometric),
        _ => {}
    }
    let mut angles: [[Option<f64>; 2]; 2] = [[None; 2]; 2];
    let mut object_m = [None; 2];
    let parts = text.split(',').map(str::trim).filter(|part| !part.is_empty());
    for part in parts {
        let (key, value) = part.split_once('=').ok_or_else(|| format!("`{part}` has no `=`; {EXAMPLE}"))?;
        let (key, value) = (key.trim(), value.trim());
        let (coordinate, side) = match key.split_once('_') {
            Some((coordinate, side)) => (coordinate, Some(side)),
            None => (key, None),
        };
        let sides: &[usize] = match side {
            None => &[0, 1],
            Some("r") => &[0],
            Some("l") => &[1],
            Some(_) => return Err(unknown(key)),
        };
        let said = |error: units::QuantityError| format!("`{part}`: {error}");
        match (coordinate, side) {
            ("q11" | "q21", _) => {
                let angle = units::parse(value, Dimension::Angle).map_err(said)?;
                sides.iter().for_each(|&side| angles[side][usize::from(coordinate == "q21")] = Some(angle));
            }
            ("x" | "y", None) => {
                let length = units::parse(value, Dimension::Length).map_err(said)?;
                object_m[usize::from(coordinate == "y")] = Some(length);
            }
            _ => return Err(unknown(key)),
        }
    }
    let mut angles_rad = [[0.0; 2]; 2];
    for (side, end) in ["_r", "_l"].into_iter().enumerate() {
        for (index, name) in ["q11", "q21"].into_iter().enumerate() {
            let missing = || format!("there is no {name}{end}, nor {name} for both fingers; {EXAMPLE}");
            angles_rad[side][index] = angles[side][index].ok_or_else(missing)?;
        }
    }
    Ok(Posture::Given { angles_rad, object_m })
}

fn unknown(key: &str) -> String {
    format!("`{key}` is none of q11, q21, q11_r, q21_r, q11_l, q21_l, x, y; {EXAMPLE}")
}

/// How many directions there are, by the angle from one to the next.
///
/// # Errors
/// Not a whole number of them make a turn.
pub fn directions(text: &str) -> Result<usize, String> {
    let angle_rad = units::parse(text, Dimension::Angle).map_err(|error| error.to_string())?;
    let count = std::f64::consts::TAU / angle_rad;
    match count.round() {
        whole if (whole - count).abs() < 1e-6 * whole && (4.0..=720.0).contains(&whole) => Ok(whole as usize),
        _ => {
            Err("a whole number of them, from 4 to 720, makes a turn; expected an angle such as \"15 deg\"".to_string())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn postures_are_read() {
        assert_eq!((posture("run"), posture(" geometric ")), (Ok(Posture::Run), Ok(Posture::Geometric)));
        let both = posture("q11 = 0.1 rad, q21=0.2 rad,x=1 mm").expect("angles");
        assert_eq!(both, Posture::Given { angles_rad: [[0.1, 0.2]; 2], object_m: [Some(1e-3), None] });
        let one = posture("q11=0.1 rad,q21=0.2 rad,q11_l=0.3 rad").expect("angles");
        assert_eq!(one, Posture::Given { angles_rad: [[0.1, 0.2], [0.3, 0.2]], object_m: [None; 2] });
        for (text, message) in [
            ("q11=0.1 rad", "no q21_r"),
            ("q11_r=1 deg,q21=1 deg", "no q11_l"),
            ("q12=1 deg", "none of q11"),
            ("q11_x=1 deg", "none of q11"),
            ("x_r=1 mm", "none of q11"),
            ("closed", "has no `=`"),
            ("q11=1", "no unit"),
            ("", "no q11_r"),
        ] {
            let error = posture(text).expect_err(message);
            assert!(error.contains(message), "{text}: {error}");
        }
    }

    #[test]
    fn directions_make_a_turn() {
        assert_eq!((directions("15 deg"), directions("0.5 deg")), (Ok(24), Ok(720)));
        for text in ["7 deg", "0 deg", "-15 deg", "200 deg", "0.1 deg"] {
            assert!(directions(text).expect_err(text).contains("makes a turn"), "{text}");
        }
    }
}
