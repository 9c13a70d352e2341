//! Grasp-state volumes as tables (thesis Tables 3.3–3.5) and JSON.

use serde::Serialize;

use crate::format::report::{Report, Table, ToReport};
use crate::study::volume::{
    Axes, Intersection, Point, Volume, VolumeCounts, VolumeRequest, count_volume, intersections, percent,
};

/// Maximum number of reported reasons for missing fingers per volume.
const MAX_REASONS: usize = 3;

/// Report of grasp-state volumes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeReport {
    /// Name of the scene that the designs vary.
    pub scene: String,
    /// How motor and spring were sized.
    pub sizing: &'static str,
    /// Axes of every volume.
    pub axes: Axes,
    /// Volumes in the requested order, grouped by base.
    pub volumes: Vec<VolumeShareReport>,
    /// Points that satisfy a criterion at every base, for each friction.
    pub intersections: Vec<IntersectionReport>,
    /// Number of sized designs.
    pub designs: usize,
    /// Time and threads. Omitted from files, so that the same request gives the same bytes.
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

/// Fractions of all points of a volume, or of the intersection over all bases, in percent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FractionReport {
    pub points: usize,
    /// Points with an existing finger.
    pub fingers: usize,
    pub stable_percent: f64,
    /// Fraction of points with a stable grasp and PFP ≥ 0.
    pub palm_positive_percent: f64,
    /// Fraction of points with a stable and form-closed grasp.
    pub form_closed_percent: f64,
    /// Fraction of points with a form-closed grasp, stable or not.
    #[serde(rename = "form_closed_anyway_percent")]
    pub form_closed_total_percent: f64,
}

/// Fractions of one volume.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeShareReport {
    pub base_m: f64,
    pub mu_static: f64,
    #[serde(flatten)]
    pub fractions: FractionReport,
    /// The largest palm force of the stable region; null if no point is stable.
    pub largest_palm_force: Option<LargestPalmForce>,
    /// The most frequent reasons for missing fingers.
    #[serde(rename = "no_finger")]
    pub missing_finger_reasons: Vec<ReasonReport>,
}

/// Fractions of the points that satisfy a criterion at every base.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IntersectionReport {
    pub mu_static: f64,
    #[serde(flatten)]
    pub fractions: FractionReport,
}

/// The largest palm force and its design.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LargestPalmForce {
    pub static_pfp_n: f64,
    pub l21_fraction: f64,
    pub phi22_rad: f64,
    pub arm_ratio: f64,
}

/// A reason for missing fingers, with the message of the first such point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReasonReport {
    pub points: usize,
    pub reason: String,
}

impl VolumeReport {
    /// Creates the report of the volumes of a request.
    pub fn new(request: &VolumeRequest, volumes: &[Volume]) -> Self {
        Self {
            scene: request.template.name.clone(),
            sizing: request.rule.name(),
            axes: request.axes,
            volumes: volumes.iter().map(|volume| volume_report(volume, &count_volume(volume))).collect(),
            intersections: intersections(volumes).iter().map(intersection_report).collect(),
            designs: request.bases_m.len() * request.axes.len(),
            timing: None,
            directory: None,
            files: Vec::new(),
        }
    }
}

fn volume_report(volume: &Volume, counts: &VolumeCounts) -> VolumeShareReport {
    let best = counts.best.map(|best| {
        let Point { l21_fraction, phi22_rad, arm_ratio, .. } = volume.points[best.point];
        LargestPalmForce { static_pfp_n: best.pfp_n, l21_fraction, phi22_rad, arm_ratio }
    });
    let VolumeCounts {
        base_m, mu_static, points, fingers, stable, palm_positive, form_closed, form_closed_total, ..
    } = *counts;
    let fractions = to_percent([points, fingers, stable, palm_positive, form_closed, form_closed_total]);
    VolumeShareReport {
        base_m,
        mu_static,
        fractions,
        largest_palm_force: best,
        missing_finger_reasons: missing_finger_reasons(volume),
    }
}

fn intersection_report(counts: &Intersection) -> IntersectionReport {
    let Intersection { mu_static, points, fingers, stable, palm_positive, form_closed, form_closed_total } = *counts;
    let fractions = to_percent([points, fingers, stable, palm_positive, form_closed, form_closed_total]);
    IntersectionReport { mu_static, fractions }
}

fn to_percent([points, fingers, counts @ ..]: [usize; 6]) -> FractionReport {
    let [stable_percent, palm_positive_percent, form_closed_percent, form_closed_total_percent] =
        counts.map(|count| percent(count, points));
    FractionReport {
        points,
        fingers,
        stable_percent,
        palm_positive_percent,
        form_closed_percent,
        form_closed_total_percent,
    }
}

/// Returns the most frequent reasons for missing fingers. Messages that differ in numbers only count as the same
/// reason.
fn missing_finger_reasons(volume: &Volume) -> Vec<ReasonReport> {
    let mut by_kind: Vec<(String, ReasonReport)> = Vec::new();
    for error in volume.points.iter().filter_map(|point| point.state.as_ref().err()) {
        let reason = error.to_string();
        let kind: String = reason.chars().filter(|c| !(c.is_ascii_digit() || matches!(c, '.' | '-'))).collect();
        match by_kind.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, report)) => report.points += 1,
            None => by_kind.push((kind, ReasonReport { points: 1, reason })),
        }
    }
    let mut reasons: Vec<ReasonReport> = by_kind.into_iter().map(|(_, report)| report).collect();
    reasons.sort_by_key(|report| std::cmp::Reverse(report.points));
    reasons.truncate(MAX_REASONS);
    reasons
}

impl ToReport for VolumeReport {
    fn report(&self) -> Report {
        let Axes { l21_fraction, phi22_rad, arm_ratio } = &self.axes;
        let [phi_from, phi_to] = [phi22_rad.from, phi22_rad.to].map(|angle| short(angle.to_degrees()));
        let mut text = Report::from(format!(
            "{}: grasp-state volumes of {} x {} x {} points, motor and spring sized by the rule \"{}\"\nl21 {} to {} of its range, \
             phi22 {phi_from} to {phi_to} deg, arm ratio r_l {} to {}; shares in % of all points of a volume\n",
            self.scene,
            l21_fraction.points,
            phi22_rad.points,
            arm_ratio.points,
            self.sizing,
            short(l21_fraction.from),
            short(l21_fraction.to),
            short(arm_ratio.from),
            short(arm_ratio.to)
        ));
        text.push_str("\nstable: F21 >= 0 and F22 >= 0, %\n");
        text.push(grid(self, &[""], |fractions, _| vec![two_decimals(fractions.stable_percent)]));
        text.push_str(
            "\nstable with PFP >= 0 (the object is pressed against the palm), %; largest PFP of the stable region, N\n",
        );
        let largest =
            |best: Option<&LargestPalmForce>| best.map_or("-".to_string(), |best| two_decimals(best.static_pfp_n));
        text.push(grid(self, &["%", "max"], |fractions, best| {
            vec![two_decimals(fractions.palm_positive_percent), largest(best)]
        }));
        text.push_str("\nstable and form-closed, %; form-closed, stable or not, %\n");
        text.push(grid(self, &["stable", "any"], |fractions, _| {
            vec![two_decimals(fractions.form_closed_percent), two_decimals(fractions.form_closed_total_percent)]
        }));
        text.push(largest_palm_forces(self));
        text.push_str(&missing_fingers(self));
        if let Some(Timing { wall_s, threads }) = self.timing {
            let unit = if threads == 1 { "thread" } else { "threads" };
            text.push_str(&format!(
                "\n{} designs sized and closed in {wall_s:.2} s on {threads} {unit}\n",
                self.designs
            ));
        }
        if let Some(directory) = &self.directory {
            text.push_str(&format!("\nfiles in {directory}: {}\n", self.files.join(", ")));
        }
        text
    }
}

/// Returns a table with a row for each base, columns for each friction, and the intersection below if there are several
/// bases.
fn grid(
    report: &VolumeReport,
    subheaders: &[&str],
    cells: impl Fn(&FractionReport, Option<&LargestPalmForce>) -> Vec<String>,
) -> Report {
    let mut header = vec!["base".to_string()];
    for intersection in &report.intersections {
        for (index, subheader) in subheaders.iter().enumerate() {
            let mu = if index == 0 { format!("mu_s {}", short(intersection.mu_static)) } else { String::new() };
            header.push(format!("{mu} {subheader}").trim().to_string());
        }
    }
    let mut rows = vec![header];
    let frictions = report.intersections.len().max(1);
    for shares in report.volumes.chunks(frictions) {
        let base = format!("{} mm", short(shares[0].base_m * 1e3));
        rows.push(
            [base]
                .into_iter()
                .chain(shares.iter().flat_map(|share| cells(&share.fractions, share.largest_palm_force.as_ref())))
                .collect(),
        );
    }
    if report.volumes.len() > frictions {
        let name = "intersection".to_string();
        rows.push(
            [name]
                .into_iter()
                .chain(report.intersections.iter().flat_map(|intersection| cells(&intersection.fractions, None)))
                .collect(),
        );
    }
    Table::new(&rows).columns_per_group(subheaders.len()).into()
}

/// Returns a table of the largest palm force of each volume and its design.
fn largest_palm_forces(report: &VolumeReport) -> Report {
    let mut rows = vec![["base", "mu_s", "PFP, N", "l21 of its range", "phi22, deg", "r_l"].map(String::from).to_vec()];
    for share in &report.volumes {
        if let Some(best) = &share.largest_palm_force {
            rows.push(vec![
                format!("{} mm", short(share.base_m * 1e3)),
                short(share.mu_static),
                two_decimals(best.static_pfp_n),
                short(best.l21_fraction),
                short(best.phi22_rad.to_degrees()),
                short(best.arm_ratio),
            ]);
        }
    }
    if rows.len() == 1 {
        Report::default()
    } else {
        Report::from("\nwhere PFP is largest\n").with(Table::new(&rows).key_columns(2))
    }
}

/// Reports how many designs do not exist, and why; the same for every friction.
fn missing_fingers(report: &VolumeReport) -> String {
    let mut text = String::new();
    let frictions = report.intersections.len().max(1);
    for share in
        report.volumes.iter().step_by(frictions).filter(|share| share.fractions.fingers < share.fractions.points)
    {
        let (missing, base) = (share.fractions.points - share.fractions.fingers, short(share.base_m * 1e3));
        text.push_str(&format!("\nbase {base} mm: {missing} of {} points have no finger\n", share.fractions.points));
        for ReasonReport { points, reason } in &share.missing_finger_reasons {
            text.push_str(&format!("  {points} points, such as: {reason}\n"));
        }
    }
    text
}

fn two_decimals(value: f64) -> String {
    format!("{value:.2}")
}

/// Formats a number with up to four decimals, without trailing zeros.
fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}
