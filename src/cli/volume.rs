//! `phalanx volume`: computes which designs hold the object, over three design variables for each base and friction
//! coefficient.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

use super::choice_args::RuleArg;
use super::interrupt::{self, Interrupt};
use super::output::{print_diagnostic, print_result};
use super::progress::RunCounter;
use super::set::{SetArgs, source_files};
use super::targets::reserve;
use super::volume_args::{
    AxisLimits, DataArg, Resolution, ValueList, parse_angle_limits, parse_bases, parse_fraction_limits,
    parse_frictions, parse_ratio_limits, parse_resolution, parse_threads,
};
use super::volume_files::{FILES, write};
use super::{Failure, Status};
use crate::report::volume::{Timing, VolumeReport, VolumeShareReport};
use crate::scene::Template;
use crate::sizing::Rule;
use crate::study::volume::{Axes, Quantity, VolumeError, VolumeRequest, all_cores, volumes_with};
use crate::units::{self, Dimension};

/// Compute which designs hold the object: grasp-state volumes over l21, phi22 and the arm ratio.
///
/// Each point of a volume is a design whose motor and spring are sized (thesis, section 3.3.2) and whose finger is
/// closed on the object in equilibrium. A design is stable if neither phalanx would have to pull the object (force
/// positiveness). Within the stable region, the plots show palm force, form closure, forces, torques or mass. There
/// is one volume for each base and each coefficient of static friction, and the intersection over the bases. Designs
/// that do not exist are counted by reason.
///
/// The scene defines everything that is not varied: l11, half width, object, material, masses, offset, gravity, and by
/// default also base and friction. Without a scene all values are those of the thesis.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx volume\n  phalanx volume --out volumes\n  phalanx volume --base \"15.5 mm\" \
                  --mu-static 0.8 --resolution 40 --colour-by pfp,form-closed --out volumes --data parquet\n  phalanx volume \
                  scenes/experiment-95.toml --phi22 \"80 deg, 130 deg\" --json > volume.json\n\n--out writes tables, all points \
                  as a data file, slices as pictures (SVG), and page.html, which shows the volumes in three dimensions in \
                  any browser. Exit status: 0 done; 2 bad input; 3 interrupted, or files could not be written."
)]
pub struct VolumeArgs {
    /// Scene file (TOML) of a finger with a [design]; it defines everything that is not varied
    scene: Option<PathBuf>,

    #[command(flatten)]
    set: SetArgs,

    /// Distances from the ground joints to the object's centre, comma-separated, with units; can be repeated [default:
    /// "12 mm, 15.5 mm, 19 mm, 22.5 mm", or the base of the scene]
    #[arg(long, value_name = "LENGTHS", value_parser = parse_bases)]
    base: Vec<ValueList>,

    /// Coefficients of static friction, comma-separated; can be repeated [default: 0,0.4,0.8, or the coefficient of the
    /// scene]
    #[arg(long, value_name = "NUMBERS", value_parser = parse_frictions)]
    mu_static: Vec<ValueList>,

    /// Number of points along each axis, including both ends: one number, or three for l21, phi22 and arm ratio
    #[arg(long, value_name = "POINTS", value_parser = parse_resolution, default_value = "20")]
    resolution: Resolution,

    /// Limits of l21 as fractions of the range that its base allows [default: 0,1]
    #[arg(long, value_name = "FROM,TO", value_parser = parse_fraction_limits)]
    l21: Option<AxisLimits>,

    /// Limits of phi22 with units [default: "90 deg, 120 deg"]
    #[arg(long, value_name = "FROM,TO", value_parser = parse_angle_limits)]
    phi22: Option<AxisLimits>,

    /// Limits of the arm ratio l22/l11 [default: 1/3 and 2/3]
    #[arg(long, value_name = "FROM,TO", value_parser = parse_ratio_limits)]
    arm_ratio: Option<AxisLimits>,

    /// Rule for sizing motor and spring [default: the rule of the scene, else rigid]
    #[arg(long, value_enum)]
    sizing: Option<RuleArg>,

    /// Quantities that the plots show within the stable region, comma-separated; the page shows all quantities
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

    /// Write table.txt, table.json, points.csv (or .parquet), slices-*.svg and page.html to this directory, which is
    /// created if needed; an existing file is replaced only when the new one is complete
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Format of the file with all points
    #[arg(long, value_enum, default_value_t = DataArg::Csv, requires = "out")]
    data: DataArg,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,

    /// Number of threads [default: all cores]; the result does not depend on it
    #[arg(long, value_name = "NUMBER", value_parser = parse_threads)]
    threads: Option<usize>,
}

/// Runs `phalanx volume`.
pub fn run(args: &VolumeArgs) -> Result<Status, Failure> {
    let request = build_request(args)?;
    let inputs = args.scene.as_deref().map(source_files).unwrap_or_default();
    let directory = reserve(&[("the scene", &inputs)], &[], ("--out", args.out.as_deref(), &FILES))?;
    let interrupt = Interrupt::listen()?;
    let threads = args.threads.unwrap_or_else(all_cores);
    let mut counter = RunCounter::new();
    let start = Instant::now();
    let mut report_progress = |done, total| counter.update(done, total, "designs");
    let result = volumes_with(&request, threads, &mut report_progress, &|| interrupt.signal().is_none());
    counter.clear();
    let volumes = result.map_err(|error| match (error, interrupt.signal()) {
        (VolumeError::Stopped { done, total }, Some(signal)) => {
            let files = if args.out.is_some() { interrupt::NO_FILE_WRITTEN } else { "" };
            Failure::incomplete(format!("interrupted by {signal} after {done} of {total} designs{files}"))
        }
        (error @ VolumeError::Stopped { .. }, None) => Failure::incomplete(error),
        (error, _) => Failure::bad_input(error),
    })?;
    let wall_s = start.elapsed().as_secs_f64();
    let mut report = VolumeReport::new(&request, &volumes);
    check_designs_exist(&report)?;
    if let (Some(out), Some(directory)) = (&args.out, directory) {
        report.directory = Some(out.display().to_string());
        directory
            .write_with(|out| write(out, &request, &volumes, &args.colour_by, args.data, &mut report, &interrupt))?;
    }
    report.timing = Some(Timing { wall_s, threads });
    print_result(&report, args.json)?;
    Ok(Status::Done)
}

/// Returns an error if no design exists at any base. Prints a warning for each single base without designs.
fn check_designs_exist(report: &VolumeReport) -> Result<(), Failure> {
    let empty: Vec<_> = report.volumes.iter().filter(|volume| volume.fractions.fingers == 0).collect();
    let describe = |volume: &VolumeShareReport| {
        let reason = volume.missing_finger_reasons.first().map_or("", |entry| entry.reason.as_str());
        format!("no design exists at a base of {}: {reason}", units::format(volume.base_m, Dimension::Length))
    };
    let mut messages: Vec<String> = empty.iter().map(|volume| describe(volume)).collect();
    // The existence of a design does not depend on friction, so the messages repeat for each coefficient.
    messages.dedup();
    if empty.len() == report.volumes.len() {
        let messages = messages.join("\n");
        return Err(Failure::bad_input(format!(
            "{messages}; give another --base, or other limits with --l21, --phi22 or --arm-ratio"
        )));
    }
    messages.iter().for_each(|message| print_diagnostic(&format!("warning: {message}; its shares are 0")));
    Ok(())
}

/// Builds the request from the arguments.
fn build_request(args: &VolumeArgs) -> Result<VolumeRequest, Failure> {
    let defaults = VolumeRequest::thesis();
    let template = match &args.scene {
        Some(path) => args.set.load_template(path)?,
        None if args.set.is_empty() => defaults.template,
        None => {
            return Err(Failure::bad_input(
                "--set needs a scene, but none is given; name one, as in phalanx volume scenes/experiment-95.toml --set …",
            ));
        }
    };
    let flatten = |lists: &[ValueList]| lists.iter().flat_map(|ValueList(values)| values.clone()).collect::<Vec<_>>();
    let (bases_m, mu_static) = (flatten(&args.base), flatten(&args.mu_static));
    let mut axes = Axes::thesis(args.resolution.0);
    for (axis, limits) in
        [(&mut axes.l21_fraction, args.l21), (&mut axes.phi22_rad, args.phi22), (&mut axes.arm_ratio, args.arm_ratio)]
    {
        if let Some(AxisLimits(from, to)) = limits {
            (axis.from, axis.to) = (from, to);
        }
    }
    Ok(VolumeRequest {
        bases_m: match (bases_m.is_empty(), &args.scene) {
            (false, _) => bases_m,
            (true, Some(_)) => vec![template.design.base_m],
            (true, None) => defaults.bases_m,
        },
        mu_static: match (mu_static.is_empty(), &args.scene) {
            (false, _) => mu_static,
            (true, Some(_)) => vec![single_friction(&template)?],
            (true, None) => defaults.mu_static,
        },
        rule: args.sizing.map(Rule::from).or(template.rule).unwrap_or(defaults.rule),
        template,
        axes,
    })
}

/// Returns the friction coefficient of the scene, which must be equal at both contacts because a volume has a single
/// coefficient.
fn single_friction(template: &Template) -> Result<f64, Failure> {
    match template.mu_static {
        [proximal, distal] if proximal == distal => Ok(proximal),
        [proximal, distal] => Err(Failure::bad_input(format!(
            "the scene has mu_static = {proximal} at the proximal contact and {distal} at the distal one, but a volume has one \
             coefficient; choose it with --mu-static"
        ))),
    }
}
