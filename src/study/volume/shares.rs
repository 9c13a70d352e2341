//! How much of a volume holds the object, and how (thesis Tables 3.3–3.5).
//!
//! A share is the number of points over all points of the volume, those without a finger among them. Palm force
//! positiveness and form closure count within the stable region, as the tables of the thesis have them.

use super::{Point, Volume};

/// Counts of one volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares {
    pub base_m: f64,
    pub mu_static: f64,
    pub points: usize,
    /// Points where there is a finger.
    pub fingers: usize,
    /// F21 ≥ 0 and F22 ≥ 0.
    pub stable: usize,
    /// Stable with PFP ≥ 0.
    pub palm_positive: usize,
    /// Stable and form-closed.
    pub form_closed: usize,
    /// Form-closed, stable or not.
    pub form_closed_anyway: usize,
    /// Largest PFP of the stable region; `None` where nothing is stable.
    pub best: Option<Best>,
}

/// Where a palm force is largest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Best {
    pub pfp_n: f64,
    /// Place in the list of points.
    pub point: usize,
}

/// Counts of the points that hold at every base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intersection {
    pub mu_static: f64,
    pub points: usize,
    pub fingers: usize,
    pub stable: usize,
    pub palm_positive: usize,
    pub form_closed: usize,
    pub form_closed_anyway: usize,
}

/// A part of all points, in percent.
pub fn percent(part: usize, points: usize) -> f64 {
    100.0 * part as f64 / points.max(1) as f64
}

/// What a point counts as.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Tally {
    finger: bool,
    stable: bool,
    palm_positive: bool,
    form_closed: bool,
    form_closed_anyway: bool,
}

fn tally(point: &Point) -> Tally {
    point.state.as_ref().map_or(Tally::default(), |state| Tally {
        finger: true,
        stable: state.is_stable(),
        palm_positive: state.is_palm_positive(),
        form_closed: state.is_form_closed(),
        form_closed_anyway: state.sized.form_closed,
    })
}

/// Counts a volume.
pub fn shares(volume: &Volume) -> Shares {
    let count = |of: fn(&Tally) -> bool| volume.points.iter().filter(|point| of(&tally(point))).count();
    let stable = volume.points.iter().enumerate().filter_map(|(index, point)| {
        let state = point.state.as_ref().ok().filter(|state| state.is_stable())?;
        Some(Best { pfp_n: state.forces.pfp_n, point: index })
    });
    Shares {
        base_m: volume.base_m,
        mu_static: volume.mu_static,
        points: volume.points.len(),
        fingers: count(|tally| tally.finger),
        stable: count(|tally| tally.stable),
        palm_positive: count(|tally| tally.palm_positive),
        form_closed: count(|tally| tally.form_closed),
        form_closed_anyway: count(|tally| tally.form_closed_anyway),
        // The first of equals, so that the answer does not depend on anything else.
        best: stable.reduce(|best, next| if next.pfp_n > best.pfp_n { next } else { best }),
    }
}

/// Counts what holds in all of these volumes, point by point; they are of one friction and have the same axes.
pub fn intersection(volumes: &[&Volume]) -> Option<Intersection> {
    let first = volumes.first()?;
    let all = |of: fn(&Tally) -> bool| {
        let held =
            |index: &usize| volumes.iter().all(|volume| volume.points.get(*index).is_some_and(|p| of(&tally(p))));
        (0..first.points.len()).filter(held).count()
    };
    Some(Intersection {
        mu_static: first.mu_static,
        points: first.points.len(),
        fingers: all(|tally| tally.finger),
        stable: all(|tally| tally.stable),
        palm_positive: all(|tally| tally.palm_positive),
        form_closed: all(|tally| tally.form_closed),
        form_closed_anyway: all(|tally| tally.form_closed_anyway),
    })
}

/// The intersection over the bases for each coefficient of friction, in the order in which these come.
pub fn intersections(volumes: &[Volume]) -> Vec<Intersection> {
    let mut frictions: Vec<f64> = Vec::new();
    for volume in volumes {
        if !frictions.contains(&volume.mu_static) {
            frictions.push(volume.mu_static);
        }
    }
    let of = |mu: &f64| intersection(&volumes.iter().filter(|volume| volume.mu_static == *mu).collect::<Vec<_>>());
    frictions.iter().filter_map(of).collect()
}
