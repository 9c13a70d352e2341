//! Points of volumes by grasp state (thesis Tables 3.3–3.5), also as tables and JSON, and their display state for one
//! quantity.
//!
//! Fractions refer to all points of the volume, including points without a finger. Palm force positiveness and form
//! closure are counted in the stable region, as in the tables of the thesis.

use std::cmp::Reverse;

use serde::Serialize;
use serde::ser::{SerializeStruct, Serializer};

use super::point::{GraspState, Quantity};
use super::{Axes, Volume, VolumeRequest};
use crate::format::report::{Report, Table, ToReport};
use crate::text::short;

/// Maximum number of reported reasons for missing fingers per volume.
const MAX_REASONS: usize = 3;

/// Numbers of points in each state of the grasp. They are serialised as percentages of all points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    pub points: usize,
    /// Number of points with a finger.
    pub fingers: usize,
    /// Number of stable points: F21 ≥ 0 and F22 ≥ 0.
    pub stable: usize,
    /// Number of stable points with PFP ≥ 0.
    pub palm_positive: usize,
    /// Number of points that are stable and form-closed.
    pub form_closed: usize,
    /// Number of form-closed points, whether stable or not.
    pub form_closed_total: usize,
}

impl Counts {
    /// Counts the points that are in a state in all of `volumes`. The volumes must have the same axes.
    pub fn new(volumes: &[&Volume]) -> Self {
        let points = volumes.first().map_or(0, |volume| volume.points.len());
        let mut counts = Counts { points, ..Counts::default() };
        for index in 0..points {
            let Some(states) = states(volumes, index) else { continue };
            let all = |test: fn(&GraspState) -> bool| usize::from(states.iter().all(|state| test(state)));
            counts.fingers += 1;
            counts.stable += all(GraspState::is_stable);
            counts.palm_positive += all(GraspState::is_palm_positive);
            counts.form_closed += all(GraspState::is_form_closed);
            counts.form_closed_total += all(|state| state.sized.form_closed);
        }
        counts
    }

    /// Returns a count as a percentage of all points.
    pub fn percent(&self, count: usize) -> f64 {
        100.0 * count as f64 / self.points.max(1) as f64
    }
}

impl Serialize for Counts {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Counts", 6)?;
        fields.serialize_field("points", &self.points)?;
        fields.serialize_field("fingers", &self.fingers)?;
        fields.serialize_field("stable_percent", &self.percent(self.stable))?;
        fields.serialize_field("palm_positive_percent", &self.percent(self.palm_positive))?;
        fields.serialize_field("form_closed_percent", &self.percent(self.form_closed))?;
        fields.serialize_field("form_closed_anyway_percent", &self.percent(self.form_closed_total))?;
        fields.end()
    }
}

/// Counts of one volume.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeCounts {
    pub base_m: f64,
    pub mu_static: f64,
    #[serde(flatten)]
    pub counts: Counts,
    /// The largest palm force of the stable region; `None` if no point is stable.
    pub largest_palm_force: Option<LargestPalmForce>,
    /// The most frequent reasons for missing fingers.
    #[serde(rename = "no_finger")]
    pub missing_fingers: Vec<MissingFingers>,
}

/// The largest palm force and its design.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LargestPalmForce {
    pub static_pfp_n: f64,
    pub l21_fraction: f64,
    pub phi22_rad: f64,
    pub arm_ratio: f64,
}

/// A reason for missing fingers, with the message of the first point to which it applies.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct MissingFingers {
    pub points: usize,
    pub reason: String,
}

/// Counts of the points that are in a state for every base.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Intersection {
    pub mu_static: f64,
    #[serde(flatten)]
    pub counts: Counts,
}

/// Returns the states of a point in all volumes; `None` if a finger does not exist.
fn states<'a>(volumes: &[&'a Volume], index: usize) -> Option<Vec<&'a GraspState>> {
    volumes.iter().map(|volume| volume.points[index].as_ref().ok()).collect()
}

/// Counts the points of a volume.
pub fn count_volume(volume: &Volume) -> VolumeCounts {
    let stable = volume.points.iter().enumerate().filter_map(|(index, point)| {
        let state = point.as_ref().ok().filter(|state| state.is_stable())?;
        Some((index, state.forces.pfp_n))
    });
    // The first of equal points, so that the result is unique.
    let best = stable.reduce(|best, next| if next.1 > best.1 { next } else { best });
    VolumeCounts {
        base_m: volume.base_m,
        mu_static: volume.mu_static,
        counts: Counts::new(&[volume]),
        largest_palm_force: best.map(|(index, static_pfp_n)| {
            let [l21_fraction, phi22_rad, arm_ratio] = volume.axes.at(index);
            LargestPalmForce { static_pfp_n, l21_fraction, phi22_rad, arm_ratio }
        }),
        missing_fingers: missing_fingers(volume),
    }
}

/// Returns the most frequent reasons for missing fingers. Messages that differ in numbers only count as the same
/// reason.
fn missing_fingers(volume: &Volume) -> Vec<MissingFingers> {
    let mut by_kind: Vec<(String, MissingFingers)> = Vec::new();
    for error in volume.points.iter().filter_map(|point| point.as_ref().err()) {
        let reason = error.to_string();
        let kind = reason.replace(|c: char| c.is_ascii_digit() || matches!(c, '.' | '-'), "");
        match by_kind.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, missing)) => missing.points += 1,
            None => by_kind.push((kind, MissingFingers { points: 1, reason })),
        }
    }
    let mut reasons: Vec<MissingFingers> = by_kind.into_iter().map(|(_, missing)| missing).collect();
    reasons.sort_by_key(|missing| Reverse(missing.points));
    reasons.truncate(MAX_REASONS);
    reasons
}

/// Groups volumes by friction coefficient; each group contains the volumes of all bases. In `volumes`, the base varies
/// slowest.
pub fn by_friction(volumes: &[Volume]) -> Vec<Vec<&Volume>> {
    let frictions = volumes.iter().take_while(|volume| volume.base_m == volumes[0].base_m).count();
    (0..frictions).map(|friction| volumes.iter().skip(friction).step_by(frictions).collect()).collect()
}

/// Returns the intersection over the bases for each friction coefficient, in the order of the coefficients.
pub fn intersections(volumes: &[Volume]) -> Vec<Intersection> {
    let intersection =
        |bases: &Vec<&Volume>| Intersection { mu_static: bases[0].mu_static, counts: Counts::new(bases) };
    by_friction(volumes).iter().map(intersection).collect()
}

/// Display state of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell {
    /// No finger exists, at least at one base.
    NoFinger,
    /// A contact force would have to be tensile.
    Unstable,
    /// The value of the quantity in SI units.
    Stable(f64),
}

impl Cell {
    pub fn value(self) -> Option<f64> {
        if let Cell::Stable(value) = self { Some(value) } else { None }
    }
}

/// Returns the cells of a volume, or of the intersection of volumes that differ only in their base. A cell of an
/// intersection is stable if it is stable in all volumes, and has the worst value.
pub fn cells(volumes: &[&Volume], quantity: Quantity) -> Vec<Cell> {
    let worst = if quantity.is_largest_worst() { f64::max } else { f64::min };
    let cell = |index: usize| {
        let Some(states) = states(volumes, index) else { return Cell::NoFinger };
        match states.iter().map(|state| quantity.value(state)).reduce(worst) {
            Some(value) if states.iter().all(|state| state.is_stable()) => Cell::Stable(value),
            _ => Cell::Unstable,
        }
    };
    (0..volumes.first().map_or(0, |volume| volume.points.len())).map(cell).collect()
}

/// Report of grasp-state volumes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeReport {
    /// Name of the scene that the designs vary.
    pub scene: String,
    /// How motor and spring were sized, in words.
    pub sizing: &'static str,
    /// Axes of every volume.
    pub axes: Axes,
    /// Volumes in the requested order, grouped by base.
    pub volumes: Vec<VolumeCounts>,
    /// For each friction coefficient, the points that satisfy a criterion for every base.
    pub intersections: Vec<Intersection>,
    /// Number of sized designs.
    pub designs: usize,
    /// Computing time and number of threads. They are omitted from files, so that the same request gives the same
    /// bytes.
    #[serde(flatten)]
    pub timing: Option<Timing>,
    /// Directory of the written files.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub directory: Option<String>,
    /// Names of the written files.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
}

/// Wall time and number of threads.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Timing {
    pub wall_s: f64,
    pub threads: usize,
}

impl VolumeReport {
    /// Creates the report of the volumes of a request.
    pub fn new(request: &VolumeRequest, volumes: &[Volume]) -> Self {
        Self {
            scene: request.template.name.clone(),
            sizing: request.rule.name(),
            axes: request.axes,
            volumes: volumes.iter().map(count_volume).collect(),
            intersections: intersections(volumes),
            designs: request.bases_m.len() * request.axes.len(),
            timing: None,
            directory: None,
            files: Vec::new(),
        }
    }

    /// Returns a table with a row for each base, columns for each friction, and the intersection below if there are
    /// several bases.
    fn grid(&self, subheaders: &[&str], cells: impl Fn(&Counts, Option<&LargestPalmForce>) -> Vec<String>) -> Report {
        let header = self.intersections.iter().flat_map(|intersection| {
            let mu = format!("mu_s {}", short(intersection.mu_static, 4));
            subheaders.iter().enumerate().map(move |(index, subheader)| match index {
                0 => format!("{mu} {subheader}").trim().to_string(),
                _ => (*subheader).to_string(),
            })
        });
        let mut rows = vec![std::iter::once("base".to_string()).chain(header).collect::<Vec<_>>()];
        for of_base in self.volumes.chunks(self.intersections.len().max(1)) {
            let values = of_base.iter().flat_map(|of| cells(&of.counts, of.largest_palm_force.as_ref()));
            rows.push(std::iter::once(millimetres(of_base[0].base_m)).chain(values).collect());
        }
        if self.volumes.len() > self.intersections.len() {
            let values = self.intersections.iter().flat_map(|intersection| cells(&intersection.counts, None));
            rows.push(std::iter::once("intersection".to_string()).chain(values).collect());
        }
        Table::new(&rows).columns_per_group(subheaders.len()).into()
    }

    /// Returns a table of the largest palm force of each volume and its design.
    fn largest_palm_forces(&self) -> Report {
        let row = |of: &VolumeCounts| {
            let best = of.largest_palm_force?;
            let design = [best.l21_fraction, best.phi22_rad.to_degrees(), best.arm_ratio].map(|value| short(value, 4));
            let volume = [millimetres(of.base_m), short(of.mu_static, 4), format!("{:.2}", best.static_pfp_n)];
            Some([volume, design].concat())
        };
        let header = ["base", "mu_s", "PFP, N", "l21 of its range", "phi22, deg", "r_l"].map(String::from).to_vec();
        let rows: Vec<Vec<String>> = std::iter::once(header).chain(self.volumes.iter().filter_map(row)).collect();
        match rows.len() {
            1 => Report::default(),
            _ => Report::from("\nwhere PFP is largest\n").with(Table::new(&rows).key_columns(2)),
        }
    }

    /// Reports how many designs do not exist, and why; the same for every friction.
    fn missing_fingers(&self) -> String {
        let mut text = String::new();
        for of in self.volumes.iter().step_by(self.intersections.len().max(1)) {
            let Counts { points, fingers, .. } = of.counts;
            if fingers < points {
                let (base, missing) = (millimetres(of.base_m), points - fingers);
                text.push_str(&format!("\nbase {base}: {missing} of {points} points have no finger\n"));
            }
            for missing in &of.missing_fingers {
                text.push_str(&format!("  {} points, such as: {}\n", missing.points, missing.reason));
            }
        }
        text
    }
}

impl ToReport for VolumeReport {
    fn report(&self) -> Report {
        let Axes { l21_fraction, phi22_rad, arm_ratio } = &self.axes;
        let [phi_from, phi_to] = [phi22_rad.from, phi22_rad.to].map(|angle| short(angle.to_degrees(), 4));
        let [l21, phi22, arm] = self.axes.resolution();
        let mut text = Report::from(format!(
            "{}: grasp-state volumes of {l21} x {phi22} x {arm} points, motor and spring sized by the rule \"{}\"\nl21 {} to {} of \
             its range, phi22 {phi_from} to {phi_to} deg, arm ratio r_l {} to {}; shares in % of all points of a volume\n",
            crate::scene::one_line(&self.scene),
            self.sizing,
            short(l21_fraction.from, 4),
            short(l21_fraction.to, 4),
            short(arm_ratio.from, 4),
            short(arm_ratio.to, 4)
        ));
        let percent = |counts: &Counts, count: usize| format!("{:.2}", counts.percent(count));
        text.push_str("\nstable: F21 >= 0 and F22 >= 0, %\n");
        text.push(self.grid(&[""], |counts, _| vec![percent(counts, counts.stable)]));
        text.push_str(
            "\nstable with PFP >= 0 (the object is pressed against the palm), %; largest PFP of the stable region, N\n",
        );
        text.push(self.grid(&["%", "max"], |counts, best| {
            let largest = best.map_or("-".to_string(), |best| format!("{:.2}", best.static_pfp_n));
            vec![percent(counts, counts.palm_positive), largest]
        }));
        text.push_str("\nstable and form-closed, %; form-closed, stable or not, %\n");
        text.push(self.grid(&["stable", "any"], |counts, _| {
            vec![percent(counts, counts.form_closed), percent(counts, counts.form_closed_total)]
        }));
        text.push(self.largest_palm_forces());
        text.push_str(&self.missing_fingers());
        if let Some(Timing { wall_s, threads }) = self.timing {
            let unit = if threads == 1 { "thread" } else { "threads" };
            let designs = self.designs;
            text.push_str(&format!("\n{designs} designs sized and closed in {wall_s:.2} s on {threads} {unit}\n"));
        }
        if let Some(directory) = &self.directory {
            text.push_str(&format!("\nfiles in {directory}: {}\n", self.files.join(", ")));
        }
        text
    }
}

fn millimetres(length_m: f64) -> String {
    format!("{} mm", short(length_m * 1e3, 4))
}
