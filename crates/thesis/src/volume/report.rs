//! Grasp-state volumes as tables (thesis Tables 3.3–3.5) and JSON.

use serde::Serialize;

use super::counts::{Counts, Intersection, LargestPalmForce, VolumeCounts, count_volume, intersections};
use super::{Axes, Volume, VolumeRequest};
use crate::format::report::{Report, Table, ToReport};
use crate::text::short;

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
    pub volumes: Vec<VolumeCounts>,
    /// Points that satisfy a criterion at every base, for each friction.
    pub intersections: Vec<Intersection>,
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
            self.scene,
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
