//! Counts of the points of a volume by grasp state (thesis Tables 3.3–3.5).
//!
//! Fractions refer to all points of the volume, including points without a finger. Palm force positiveness and form
//! closure are counted in the stable region, as in the tables of the thesis.

use super::{Point, Volume};

/// Numbers of points of one volume by grasp state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeCounts {
    pub base_m: f64,
    pub mu_static: f64,
    pub points: usize,
    /// Number of points with a finger.
    pub fingers: usize,
    /// Number of stable points: F21 ≥ 0 and F22 ≥ 0.
    pub stable: usize,
    /// Number of stable points with PFP ≥ 0.
    pub palm_positive: usize,
    /// Number of stable, form-closed points.
    pub form_closed: usize,
    /// Number of form-closed points, stable or not.
    pub form_closed_total: usize,
    /// Largest PFP of the stable region; `None` if no point is stable.
    pub best: Option<Best>,
}

/// Point with the largest palm force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Best {
    pub pfp_n: f64,
    /// Index in the list of points.
    pub point: usize,
}

/// Counts of the points in a state at every base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intersection {
    pub mu_static: f64,
    pub points: usize,
    pub fingers: usize,
    pub stable: usize,
    pub palm_positive: usize,
    pub form_closed: usize,
    pub form_closed_total: usize,
}

/// Returns a count as a percentage of all points.
pub fn percent(count: usize, points: usize) -> f64 {
    100.0 * count as f64 / points.max(1) as f64
}

/// Counts to which a point contributes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct PointFlags {
    finger: bool,
    stable: bool,
    palm_positive: bool,
    form_closed: bool,
    form_closed_total: bool,
}

fn point_flags(point: &Point) -> PointFlags {
    point.state.as_ref().map_or(PointFlags::default(), |state| PointFlags {
        finger: true,
        stable: state.is_stable(),
        palm_positive: state.is_palm_positive(),
        form_closed: state.is_form_closed(),
        form_closed_total: state.sized.form_closed,
    })
}

/// Counts the points of a volume.
pub fn count_volume(volume: &Volume) -> VolumeCounts {
    let count = |test: fn(&PointFlags) -> bool| volume.points.iter().filter(|point| test(&point_flags(point))).count();
    let stable = volume.points.iter().enumerate().filter_map(|(index, point)| {
        let state = point.state.as_ref().ok().filter(|state| state.is_stable())?;
        Some(Best { pfp_n: state.forces.pfp_n, point: index })
    });
    VolumeCounts {
        base_m: volume.base_m,
        mu_static: volume.mu_static,
        points: volume.points.len(),
        fingers: count(|flags| flags.finger),
        stable: count(|flags| flags.stable),
        palm_positive: count(|flags| flags.palm_positive),
        form_closed: count(|flags| flags.form_closed),
        form_closed_total: count(|flags| flags.form_closed_total),
        // The first of equal points, so that the result is unique.
        best: stable.reduce(|best, next| if next.pfp_n > best.pfp_n { next } else { best }),
    }
}

/// Counts the points that are in a state in all volumes. The volumes have the same friction coefficient and axes.
pub fn intersection(volumes: &[&Volume]) -> Option<Intersection> {
    let first = volumes.first()?;
    let all = |test: fn(&PointFlags) -> bool| {
        let in_all_volumes = |index: &usize| {
            volumes.iter().all(|volume| volume.points.get(*index).is_some_and(|point| test(&point_flags(point))))
        };
        (0..first.points.len()).filter(in_all_volumes).count()
    };
    Some(Intersection {
        mu_static: first.mu_static,
        points: first.points.len(),
        fingers: all(|flags| flags.finger),
        stable: all(|flags| flags.stable),
        palm_positive: all(|flags| flags.palm_positive),
        form_closed: all(|flags| flags.form_closed),
        form_closed_total: all(|flags| flags.form_closed_total),
    })
}

/// Returns the intersection over the bases for each friction coefficient, in their order.
pub fn intersections(volumes: &[Volume]) -> Vec<Intersection> {
    let mut coefficients: Vec<f64> = Vec::new();
    for volume in volumes {
        if !coefficients.contains(&volume.mu_static) {
            coefficients.push(volume.mu_static);
        }
    }
    let intersection_at =
        |mu: &f64| intersection(&volumes.iter().filter(|volume| volume.mu_static == *mu).collect::<Vec<_>>());
    coefficients.iter().filter_map(intersection_at).collect()
}
