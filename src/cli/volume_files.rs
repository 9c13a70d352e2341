//! The files of `phalanx volume --out`.

use std::path::Path;

use super::Failure;
use super::interrupt::Interrupt;
use super::saved::save;
use super::volume_args::DataArg;
use crate::page::{Note, VolumePage, volume_page};
use crate::plot;
use crate::report::volume::VolumeReport;
use crate::report::volume_points::volume_points;
use crate::study::volume::{Quantity, Volume, VolumeRequest};
use crate::table;
use crate::wording::Reported;

/// The volumes in three dimensions.
const PAGE: &str = "page.html";

/// Files of volumes.
pub const FILES: [&str; 6] = ["table.txt", "table.json", "points.csv", "points.parquet", PAGE, "slices-*.svg"];

/// Writes everything, and says in the report what was written; the table that says so comes last.
pub fn write(
    out: &Path,
    request: &VolumeRequest,
    volumes: &[Volume],
    quantities: &[Quantity],
    data: DataArg,
    report: &mut VolumeReport,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let mut files = Vec::new();
    let mut keep = |file: String, drawn: String| {
        interrupt.check()?;
        let path = out.join(&file);
        files.push(file);
        save(&path, &drawn)
    };
    for &quantity in quantities {
        for frictions in volumes.chunks(request.mu_static.len()) {
            let of_base: Vec<&Volume> = frictions.iter().collect();
            let base = format!("{}", (frictions[0].base_m * 1e9).round() / 1e6);
            keep(format!("slices-{base}mm-{}.svg", quantity.key()), plot::volume_slices(&of_base, quantity))?;
        }
        if request.bases_m.len() > 1 {
            let of_friction = |mu: &f64| volumes.iter().filter(|volume| volume.mu_static == *mu).collect::<Vec<_>>();
            let frictions: Vec<_> = request.mu_static.iter().map(of_friction).collect();
            let drawn = plot::intersection_slices(&frictions, quantity);
            keep(format!("slices-intersection-{}.svg", quantity.key()), drawn)?;
        }
    }
    let points = match data {
        DataArg::Csv => "points.csv",
        DataArg::Parquet => "points.parquet",
    };
    interrupt.check()?;
    let table = volume_points(volumes);
    interrupt.check()?;
    table::write(&out.join(points), &table).map_err(Failure::incomplete)?;
    interrupt.check()?;
    files.insert(0, points.to_string());
    let path = out.join(PAGE);
    // A page is given to others: it does not say where it was made.
    let nowhere = VolumeReport { directory: None, ..report.clone() };
    let page = VolumePage {
        title: format!("Grasp-state volumes: {}", request.template.name),
        description: description(report),
        volumes,
        notes: vec![Note { title: "Shares".to_string(), text: nowhere.report() }],
        pictures: Vec::new(),
    };
    save(&path, &volume_page(&page))?;
    files.insert(0, PAGE.to_string());
    report.files = ["table.txt", "table.json"].map(String::from).into_iter().chain(files).collect();
    save(&out.join("table.json"), &report.json())?;
    save(&out.join("table.txt"), &report.report().to_string())
}

/// What the volumes are, in one sentence.
fn description(report: &VolumeReport) -> String {
    format!(
        "Which designs hold the object, over three design variables: every cell is a design, sized by the rule “{}”, closed on \
         the object and in equilibrium.",
        report.sizing
    )
}
