//! Grasp-state volumes as tables (thesis Tables 3.3–3.5) and JSON.

use serde::Serialize;

use crate::study::volume::{Axes, Intersection, Point, Shares, Volume, VolumeRequest, intersections, percent, shares};
use crate::wording::report::{Report, Reported, Table};

/// Reasons for missing fingers that are told of one volume; there may be as many as points.
const MOST_REASONS: usize = 3;

/// What is reported of volumes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeReport {
    /// Name of the scene that the designs vary.
    pub scene: String,
    /// How motor and spring were sized.
    pub sizing: &'static str,
    /// Of every volume.
    pub axes: Axes,
    /// Bases slowest, as they were asked for.
    pub volumes: Vec<ShareReport>,
    /// What holds at every base, for each friction.
    pub intersections: Vec<IntersectionReport>,
    /// Designs that were sized.
    pub designs: usize,
    /// In how much time and on how many threads; left out of files, so that the same request gives the same bytes.
    #[serde(flatten)]
    pub effort: Option<Effort>,
    /// Where files were written, and which.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub directory: Option<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
}

/// What it took.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Effort {
    pub wall_s: f64,
    pub threads: usize,
}

/// Shares of all points of a volume, or of those that hold at every base.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PercentReport {
    pub points: usize,
    /// Points where there is a finger.
    pub fingers: usize,
    pub stable_percent: f64,
    /// Stable with PFP ≥ 0.
    pub palm_positive_percent: f64,
    /// Stable and form-closed.
    pub form_closed_percent: f64,
    /// Form-closed, stable or not.
    pub form_closed_anyway_percent: f64,
}

/// One volume.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShareReport {
    pub base_m: f64,
    pub mu_static: f64,
    #[serde(flatten)]
    pub of: PercentReport,
    /// The largest palm force of the stable region; null where nothing is stable.
    pub largest_palm_force: Option<BestReport>,
    /// Why there are no fingers: the most frequent reasons.
    pub no_finger: Vec<ReasonReport>,
}

/// What holds at every base.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IntersectionReport {
    pub mu_static: f64,
    #[serde(flatten)]
    pub of: PercentReport,
}

/// Where a palm force is largest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BestReport {
    pub static_pfp_n: f64,
    pub l21_fraction: f64,
    pub phi22_rad: f64,
    pub arm_ratio: f64,
}

/// A reason for missing fingers, in the words of the first of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReasonReport {
    pub points: usize,
    pub reason: String,
}

impl VolumeReport {
    /// Counts the volumes of a request.
    pub fn new(request: &VolumeRequest, volumes: &[Volume]) -> Self {
        Self {
            scene: request.template.name.clone(),
            sizing: request.rule.name(),
            axes: request.axes,
            volumes: volumes.iter().map(|volume| share(volume, &shares(volume))).collect(),
            intersections: intersections(volumes).iter().map(common).collect(),
            designs: request.bases_m.len() * request.axes.len(),
            effort: None,
            directory: None,
            files: Vec::new(),
        }
    }
}

fn share(volume: &Volume, counted: &Shares) -> ShareReport {
    let best = counted.best.map(|best| {
        let Point { l21_fraction, phi22_rad, arm_ratio, .. } = volume.points[best.point];
        BestReport { static_pfp_n: best.pfp_n, l21_fraction, phi22_rad, arm_ratio }
    });
    let Shares { base_m, mu_static, points, fingers, stable, palm_positive, form_closed, form_closed_anyway, .. } =
        *counted;
    let of = percents([points, fingers, stable, palm_positive, form_closed, form_closed_anyway]);
    ShareReport { base_m, mu_static, of, largest_palm_force: best, no_finger: reasons(volume) }
}

fn common(counted: &Intersection) -> IntersectionReport {
    let Intersection { mu_static, points, fingers, stable, palm_positive, form_closed, form_closed_anyway } = *counted;
    let of = percents([points, fingers, stable, palm_positive, form_closed, form_closed_anyway]);
    IntersectionReport { mu_static, of }
}

fn percents([points, fingers, parts @ ..]: [usize; 6]) -> PercentReport {
    let [stable_percent, palm_positive_percent, form_closed_percent, form_closed_anyway_percent] =
        parts.map(|part| percent(part, points));
    PercentReport {
        points,
        fingers,
        stable_percent,
        palm_positive_percent,
        form_closed_percent,
        form_closed_anyway_percent,
    }
}

/// The most frequent reasons; two are one where they are of one kind, whatever the figures in them.
fn reasons(volume: &Volume) -> Vec<ReasonReport> {
    let mut found: Vec<(String, ReasonReport)> = Vec::new();
    for error in volume.points.iter().filter_map(|point| point.state.as_ref().err()) {
        let reason = error.to_string();
        let kind: String = reason.chars().filter(|c| !(c.is_ascii_digit() || matches!(c, '.' | '-'))).collect();
        match found.iter_mut().find(|(of, _)| *of == kind) {
            Some((_, told)) => told.points += 1,
            None => found.push((kind, ReasonReport { points: 1, reason })),
        }
    }
    let mut reasons: Vec<ReasonReport> = found.into_iter().map(|(_, told)| told).collect();
    reasons.sort_by_key(|told| std::cmp::Reverse(told.points));
    reasons.truncate(MOST_REASONS);
    reasons
}

/// Tables for people.
impl Reported for VolumeReport {
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
        text.push(grid(self, &[""], |of, _| vec![two(of.stable_percent)]));
        text.push_str(
            "\nstable with PFP >= 0 (the object is pressed on the palm), %; largest PFP of the stable region, N\n",
        );
        let largest = |best: Option<&BestReport>| best.map_or("-".to_string(), |best| two(best.static_pfp_n));
        text.push(grid(self, &["%", "max"], |of, best| vec![two(of.palm_positive_percent), largest(best)]));
        text.push_str("\nstable and form-closed, %; form-closed, stable or not, %\n");
        text.push(grid(self, &["stable", "any"], |of, _| {
            vec![two(of.form_closed_percent), two(of.form_closed_anyway_percent)]
        }));
        text.push(best(self));
        text.push_str(&missing(self));
        if let Some(Effort { wall_s, threads }) = self.effort {
            let of = if threads == 1 { "thread" } else { "threads" };
            text.push_str(&format!("\n{} designs sized and closed in {wall_s:.2} s on {threads} {of}\n", self.designs));
        }
        if let Some(directory) = &self.directory {
            text.push_str(&format!("\nfiles in {directory}: {}\n", self.files.join(", ")));
        }
        text
    }
}

/// A row for each base, columns for each friction, and the intersection below where there are several bases.
fn grid(
    report: &VolumeReport,
    heads: &[&str],
    cells: impl Fn(&PercentReport, Option<&BestReport>) -> Vec<String>,
) -> Report {
    let mut head = vec!["base".to_string()];
    for of in &report.intersections {
        for (index, sub) in heads.iter().enumerate() {
            let mu = if index == 0 { format!("mu_s {}", short(of.mu_static)) } else { String::new() };
            head.push(format!("{mu} {sub}").trim().to_string());
        }
    }
    let mut rows = vec![head];
    let frictions = report.intersections.len().max(1);
    for shares in report.volumes.chunks(frictions) {
        let base = format!("{} mm", short(shares[0].base_m * 1e3));
        rows.push(
            [base]
                .into_iter()
                .chain(shares.iter().flat_map(|share| cells(&share.of, share.largest_palm_force.as_ref())))
                .collect(),
        );
    }
    if report.volumes.len() > frictions {
        let name = "intersection".to_string();
        rows.push([name].into_iter().chain(report.intersections.iter().flat_map(|all| cells(&all.of, None))).collect());
    }
    Table::new(&rows).together(heads.len()).into()
}

/// Where the largest palm forces are.
fn best(report: &VolumeReport) -> Report {
    let mut rows = vec![["base", "mu_s", "PFP, N", "l21 of its range", "phi22, deg", "r_l"].map(String::from).to_vec()];
    for share in &report.volumes {
        if let Some(best) = &share.largest_palm_force {
            rows.push(vec![
                format!("{} mm", short(share.base_m * 1e3)),
                short(share.mu_static),
                two(best.static_pfp_n),
                short(best.l21_fraction),
                short(best.phi22_rad.to_degrees()),
                short(best.arm_ratio),
            ]);
        }
    }
    if rows.len() == 1 {
        Report::default()
    } else {
        Report::from("\nwhere PFP is largest\n").and(Table::new(&rows).keys(2))
    }
}

/// Which designs do not exist, and why; the same for every friction.
fn missing(report: &VolumeReport) -> String {
    let mut text = String::new();
    let frictions = report.intersections.len().max(1);
    for share in report.volumes.iter().step_by(frictions).filter(|share| share.of.fingers < share.of.points) {
        let (gone, base) = (share.of.points - share.of.fingers, short(share.base_m * 1e3));
        text.push_str(&format!("\nbase {base} mm: {gone} of {} points have no finger\n", share.of.points));
        for ReasonReport { points, reason } in &share.no_finger {
            text.push_str(&format!("  {points} points, such as: {reason}\n"));
        }
    }
    text
}

fn two(value: f64) -> String {
    format!("{value:.2}")
}

/// A number of up to four digits without needless zeros.
fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}
