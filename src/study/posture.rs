//! Text form of a gripper's posture: `run`, `geometric`, or angles such as `q11=2 deg, q21=65 deg`.

use std::collections::BTreeMap;

use crate::grasp::gripper::{ExplicitPosture, PostureRequest};
use crate::units::{self, Dimension};

/// Posture of the gripper at the end of a run.
pub const END_OF_RUN: PostureRequest = PostureRequest::Run { at_s: None, within_m: None };

/// Default distance from the object's surface within which a phalanx is in contact, m.
const DEFAULT_WITHIN_M: f64 = 5e-5;

/// Returns the posture of this request at time `at_s` of a run. A surface is in contact if it is at most `within_m`
/// from the object. Returns an error if an argument does not apply to this kind of posture.
pub fn with_options(
    posture: PostureRequest,
    at_s: Option<f64>,
    within_m: Option<f64>,
) -> Result<PostureRequest, String> {
    match posture {
        PostureRequest::Run { .. } => Ok(PostureRequest::Run { at_s, within_m }),
        _ if at_s.is_some() => {
            Err("--at is a time of a run, but --posture does not use a run: remove one of them".to_string())
        }
        PostureRequest::Geometric if within_m.is_some() => {
            Err("with --posture geometric all phalanges are in contact with the object: remove --within".to_string())
        }
        PostureRequest::Geometric => Ok(PostureRequest::Geometric),
        PostureRequest::Explicit(posture) => {
            let within_m = within_m.unwrap_or(posture.within_m);
            Ok(PostureRequest::Explicit(ExplicitPosture { within_m, ..posture }))
        }
    }
}

const EXAMPLE: &str = "expected \"run\", \"geometric\" or angles such as \"q11=2 deg, q21=65 deg\"";

pub fn parse_posture(text: &str) -> Result<PostureRequest, String> {
    match text.trim() {
        "run" => return Ok(END_OF_RUN),
        "geometric" => return Ok(PostureRequest::Geometric),
        _ => {}
    }
    let mut values: BTreeMap<String, f64> = BTreeMap::new();
    for entry in text.split(',').map(str::trim).filter(|entry| !entry.is_empty()) {
        let (key, value) = entry.split_once('=').ok_or_else(|| format!("`{entry}` has no `=`; {EXAMPLE}"))?;
        let key = key.trim();
        let (keys, dimension) = match key {
            "q11" | "q21" => (vec![format!("{key}_r"), format!("{key}_l")], Dimension::Angle),
            "q11_r" | "q21_r" | "q11_l" | "q21_l" => (vec![key.to_string()], Dimension::Angle),
            "x" | "y" => (vec![key.to_string()], Dimension::Length),
            _ => {
                return Err(format!("`{key}` is not one of q11, q21, q11_r, q21_r, q11_l, q21_l, x, y; {EXAMPLE}"));
            }
        };
        let value = units::parse(value.trim(), dimension).map_err(|error| format!("`{entry}`: {error}"))?;
        values.extend(keys.into_iter().map(|key| (key, value)));
    }
    let mut angles_rad = [[0.0; 2]; 2];
    for (side, suffix) in ["_r", "_l"].into_iter().enumerate() {
        for (index, name) in ["q11", "q21"].into_iter().enumerate() {
            let missing = || format!("{name}{suffix} is missing, and there is no {name} for both fingers; {EXAMPLE}");
            angles_rad[side][index] = *values.get(&format!("{name}{suffix}")).ok_or_else(missing)?;
        }
    }
    let object_m = ["x", "y"].map(|key| values.get(key).copied());
    Ok(PostureRequest::Explicit(ExplicitPosture { angles_rad, object_m, within_m: DEFAULT_WITHIN_M }))
}

/// Parses the angle between adjacent directions and returns the number of directions. The angle must divide a full turn
/// into 4 to 720 parts.
pub fn parse_direction_count(text: &str) -> Result<usize, String> {
    let angle_rad = units::parse(text, Dimension::Angle).map_err(|error| error.to_string())?;
    let count = std::f64::consts::TAU / angle_rad;
    match count.round() {
        whole if (whole - count).abs() < 1e-6 * whole && (4.0..=720.0).contains(&whole) => Ok(whole as usize),
        _ => Err("the angle must divide a full turn into 4 to 720 directions; expected an angle such as \"15 deg\""
            .to_string()),
    }
}
