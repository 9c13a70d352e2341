//! Files of `phalanx volume --out`.

use std::path::Path;

use super::Failure;
use super::interrupt::Interrupt;
use super::targets::save;
use super::volume_args::DataArg;
use crate::format::ToReport;
use crate::page::{Note, VolumePage, volume_page};
use crate::plot;
use crate::report::volume::VolumeReport;
use crate::report::volume_points::volume_points;
use crate::study::volume::{Quantity, Volume, VolumeRequest};
use crate::table;

/// Page with the volumes in three dimensions.
const PAGE_FILE: &str = "page.html";

/// Files in the output directory.
pub const FILES: [&str; 6] = ["table.txt", "table.json", "points.csv", "points.parquet", PAGE_FILE, "slices-*.svg"];

/// Writes all files and lists them in the report; the tables are written last.
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
    let mut save_slices = |file: String, svg: String| {
        interrupt.check()?;
        let path = out.join(&file);
        files.push(file);
        save(&path, &svg)
    };
    for &quantity in quantities {
        for frictions in volumes.chunks(request.mu_static.len()) {
            let base_volumes: Vec<&Volume> = frictions.iter().collect();
            let base = format!("{}", (frictions[0].base_m * 1e9).round() / 1e6);
            save_slices(
                format!("slices-{base}mm-{}.svg", quantity.key()),
                plot::volume_slices(&base_volumes, quantity),
            )?;
        }
        if request.bases_m.len() > 1 {
            let volumes_with = |mu: &f64| volumes.iter().filter(|volume| volume.mu_static == *mu).collect::<Vec<_>>();
            let frictions: Vec<_> = request.mu_static.iter().map(volumes_with).collect();
            let svg = plot::intersection_slices(&frictions, quantity);
            save_slices(format!("slices-intersection-{}.svg", quantity.key()), svg)?;
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
    let path = out.join(PAGE_FILE);
    // Pages are shared, so the page does not contain local paths.
    let portable_report = VolumeReport { directory: None, ..report.clone() };
    let page = VolumePage {
        title: format!("Grasp-state volumes: {}", request.template.name),
        description: description(report),
        volumes,
        notes: vec![Note { title: "Shares".to_string(), text: portable_report.report() }],
        pictures: Vec::new(),
    };
    save(&path, &volume_page(&page))?;
    files.insert(0, PAGE_FILE.to_string());
    report.files = ["table.txt", "table.json"].map(String::from).into_iter().chain(files).collect();
    save(&out.join("table.json"), &report.json())?;
    save(&out.join("table.txt"), &report.report().to_string())
}

/// Describes the volumes in one sentence.
fn description(report: &VolumeReport) -> String {
    format!(
        "Designs that hold the object, over three design variables. Every cell is a design that is sized by the rule “{}” and closed \
         on the object in equilibrium.",
        report.sizing
    )
}
