//! `phalanx volume`: which designs hold the object, over three design variables at a base and a friction.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

use super::interrupt::Interrupt;
use super::output::{answer, complain};
use super::progress::Count;
use super::set::{SetArgs, files};
use super::targets::reserve;
use super::volume_args::{
    DataArg, Limits, List, Resolution, angle_limits, bases, fraction_limits, frictions, ratio_limits, resolution,
    threads,
};
use super::volume_files::{FILES, write};
use super::words::RuleArg;
use super::{Failure, Status};
use crate::report::volume::{Effort, ShareReport, VolumeReport};
use crate::scene::Template;
use crate::sizing::Rule;
use crate::study::volume::{Axes, Quantity, VolumeError, VolumeRequest, all_cores, volumes_with};
use crate::units::{self, Dimension};

/// Map which designs hold the object: grasp-state volumes over l21, phi22 and the arm ratio.
///
/// Each point of a volume is a design: sized (motor and spring, thesis, section 3.3.2), closed on the object, in equilibrium there. It
/// is stable where neither phalanx would have to pull (force positiveness). Within the stable region the palm force, form
/// closure, forces, torques and mass can be looked at. One volume for each base and each coefficient of static friction, and
/// the intersection over the bases. A design that does not exist is counted, with the reason.
///
/// A scene gives everything that is not varied: l11, half width, object, material, masses, offset, gravity. Base and friction
/// are then the scene's unless they are given. Without a scene all is as in the thesis.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx volume\n  phalanx volume --out volumes\n  phalanx volume --base \"15.5 mm\" \
                  --mu-static 0.8 --resolution 40 --colour-by pfp,form-closed --out volumes --data parquet\n  phalanx volume \
                  scenes/experiment-95.toml --phi22 \"80 deg, 130 deg\" --json > volume.json\n\nWith --out: tables, all points \
                  as a data file, slices as pictures (SVG), and page.html, which shows the volumes in three dimensions in \
                  any browser. Exit status: 0 done; 2 bad input; 3 interrupted, or files could not be written."
)]
pub struct VolumeArgs {
    /// Scene of a finger with a [design] (TOML), from which all that is not varied is taken
    scene: Option<PathBuf>,

    #[command(flatten)]
    set: SetArgs,

    /// Distances from the ground joints to the object's centre, with their units; may be given again [default: "12 mm, 15.5
    /// mm, 19 mm, 22.5 mm", or that of the scene]
    #[arg(long, value_name = "LENGTHS", value_parser = bases)]
    base: Vec<List>,

    /// Coefficients of static friction [default: 0,0.4,0.8, or that of the scene]
    #[arg(long, value_name = "NUMBERS", value_parser = frictions)]
    mu_static: Vec<List>,

    /// Points along each axis, both ends included: one number, or three for l21, phi22 and arm ratio
    #[arg(long, value_name = "POINTS", value_parser = resolution, default_value = "20")]
    resolution: Resolution,

    /// Limits of l21 within the range its base allows [default: 0,1]
    #[arg(long, value_name = "FROM,TO", value_parser = fraction_limits)]
    l21: Option<Limits>,

    /// Limits of phi22 with their units [default: "90 deg, 120 deg"]
    #[arg(long, value_name = "FROM,TO", value_parser = angle_limits)]
    phi22: Option<Limits>,

    /// Limits of the arm ratio l22/l11 [default: 1/3 and 2/3]
    #[arg(long, value_name = "FROM,TO", value_parser = ratio_limits)]
    arm_ratio: Option<Limits>,

    /// How motor and spring are sized [default: rigid, or as the scene says]
    #[arg(long, value_enum)]
    sizing: Option<RuleArg>,

    /// What the pictures show within the stable region; several between commas. The page shows all of them
    #[arg(
        long,
        visible_alias = "color-by",
        value_name = "QUANTITY",
        value_enum,
        value_delimiter = ',',
        default_value = "pfp",
        requires = "out"
    )]
    colour_by: Vec<Quantity>,

    /// Write table.txt, table.json, points.csv (or .parquet), slices-*.svg and page.html there; the directory is made if need be,
    /// and an older file is replaced only when the new one is whole
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Form of the file with all points
    #[arg(long, value_enum, default_value_t = DataArg::Csv, requires = "out")]
    data: DataArg,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,

    /// Threads to compute on [default: all cores]; the result is the same
    #[arg(long, value_name = "NUMBER", value_parser = threads)]
    threads: Option<usize>,
}

/// Runs the command.
pub fn run(args: &VolumeArgs) -> Result<Status, Failure> {
    let request = request(args)?;
    let reads = args.scene.as_deref().map(files).unwrap_or_default();
    let folder = reserve(&[("the scene", &reads)], &[], ("--out", args.out.as_deref(), &FILES))?;
    let interrupt = Interrupt::listen()?;
    let threads = args.threads.unwrap_or_else(all_cores);
    let mut count = Count::new();
    let start = Instant::now();
    let mut tell = |done, total| count.show(done, total, "designs");
    let found = volumes_with(&request, threads, &mut tell, &|| interrupt.signal().is_none());
    count.clear();
    let volumes = found.map_err(|error| match (error, interrupt.signal()) {
        (VolumeError::Stopped { done, total }, Some(signal)) => {
            let files = if args.out.is_some() { "; no file was written, and older ones are as they were" } else { "" };
            Failure::incomplete(format!("interrupted by {signal} after {done} of {total} designs{files}"))
        }
        (error @ VolumeError::Stopped { .. }, None) => Failure::incomplete(error),
        (error, _) => Failure::bad_input(error),
    })?;
    let wall_s = start.elapsed().as_secs_f64();
    let mut report = VolumeReport::new(&request, &volumes);
    refuse_nothing(&report)?;
    if let (Some(out), Some(folder)) = (&args.out, folder) {
        report.directory = Some(out.display().to_string());
        folder.fill(|out| write(out, &request, &volumes, &args.colour_by, args.data, &mut report, &interrupt))?;
    }
    report.effort = Some(Effort { wall_s, threads });
    answer(&report, args.json)?;
    Ok(Status::Done)
}

/// Where not one design exists there is nothing to tabulate; where none does at one base of several, that is said.
fn refuse_nothing(report: &VolumeReport) -> Result<(), Failure> {
    let empty: Vec<_> = report.volumes.iter().filter(|volume| volume.of.fingers == 0).collect();
    let why = |volume: &ShareReport| {
        let reason = volume.no_finger.first().map_or("", |told| told.reason.as_str());
        format!("no design exists at a base of {}: {reason}", units::format(volume.base_m, Dimension::Length))
    };
    let mut told: Vec<String> = empty.iter().map(|volume| why(volume)).collect();
    // Fingers exist or not whatever the friction.
    told.dedup();
    if empty.len() == report.volumes.len() {
        let told = told.join("\n");
        return Err(Failure::bad_input(format!(
            "{told}; give another --base, or other limits of --l21, --phi22, --arm-ratio"
        )));
    }
    told.iter().for_each(|told| complain(&format!("warning: {told}; its shares are 0")));
    Ok(())
}

/// What is asked for.
fn request(args: &VolumeArgs) -> Result<VolumeRequest, Failure> {
    let usual = VolumeRequest::thesis();
    let template = match &args.scene {
        Some(path) => args.set.load_template(path)?,
        None if args.set.is_empty() => usual.template,
        None => {
            return Err(Failure::bad_input(
                "--set sets fields of a scene, and none is given: name one, as in phalanx volume scenes/experiment-95.toml --set …",
            ));
        }
    };
    let given = |lists: &[List]| lists.iter().flat_map(|List(values)| values.clone()).collect::<Vec<_>>();
    let (bases_m, mu_static) = (given(&args.base), given(&args.mu_static));
    let mut axes = Axes::thesis(args.resolution.0);
    for (axis, limits) in
        [(&mut axes.l21_fraction, args.l21), (&mut axes.phi22_rad, args.phi22), (&mut axes.arm_ratio, args.arm_ratio)]
    {
        if let Some(Limits(from, to)) = limits {
            (axis.from, axis.to) = (from, to);
        }
    }
    Ok(VolumeRequest {
        bases_m: match (bases_m.is_empty(), &args.scene) {
            (false, _) => bases_m,
            (true, Some(_)) => vec![template.design.base_m],
            (true, None) => usual.bases_m,
        },
        mu_static: match (mu_static.is_empty(), &args.scene) {
            (false, _) => mu_static,
            (true, Some(_)) => vec![one_friction(&template)?],
            (true, None) => usual.mu_static,
        },
        rule: args.sizing.map(Rule::from).or(template.rule).unwrap_or(usual.rule),
        template,
        axes,
    })
}

/// The friction of the scene, which must be the same at both contacts: equilibrium knows one coefficient.
fn one_friction(template: &Template) -> Result<f64, Failure> {
    match template.mu_static {
        [proximal, distal] if proximal == distal => Ok(proximal),
        [proximal, distal] => Err(Failure::bad_input(format!(
            "the scene has mu_static = {proximal} at the proximal contact and {distal} at the distal one, but a volume has one \
             coefficient; say which with --mu-static"
        ))),
    }
}
