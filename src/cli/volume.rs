//! `phalanx thesis volume`: computes which designs hold the object, over three design variables for each base and friction
//! coefficient.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use clap::builder::TypedValueParser;

use super::output::{OutputArgs, print_diagnostic, print_result, reserve, save};
use super::parsers::{choice, limits, number, positive, quantity, rule};
use super::progress::Interrupt;
use super::set::{SetArgs, source_files};
use super::{Failure, Status};
use crate::format::ToReport;
use crate::scene::{self, Template};
use crate::sizing::Rule;
use crate::table::{self, Column, Kind, Table, Value};
use crate::thesis::volume::{
    Axes, COLUMNS, FLAGS, Quantity, Timing, Volume, VolumeCounts, VolumeReport, VolumeRequest, by_friction, slices,
    volumes,
};
use crate::units::{self, Dimension};
use phalanx_parallel::default_threads;

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
    after_help = "Examples:\n  phalanx thesis volume\n  phalanx thesis volume --out volumes\n  phalanx thesis volume --base \"15.5 mm\" \
                  --mu-static 0.8 --resolution 40 --colour-by pfp,form-closed --out volumes --data parquet\n  phalanx thesis volume \
                  scenes/experiment-95.toml --phi22 \"80 deg, 130 deg\" --json > volume.json\n\n--out writes table.txt, \
                  table.json, all points as points.csv (or .parquet), and slices as pictures (slices-*.svg). Exit status: 0 done; 2 bad input; 3 interrupted, or files could not be written."
)]
pub(crate) struct VolumeArgs {
    /// Scene file (TOML) of a finger with a [design]; it defines everything that is not varied
    scene: Option<PathBuf>,

    #[command(flatten)]
    set: SetArgs,

    /// Distances from the ground joints to the object's centre, comma-separated, with units; can be repeated [default:
    /// "12 mm, 15.5 mm, 19 mm, 22.5 mm", or the base of the scene]
    #[arg(long, value_name = "LENGTHS", value_delimiter = ',', value_parser = positive(Dimension::Length, "lengths such as \"12 mm, 15.5 mm\""))]
    base: Vec<f64>,

    /// Coefficients of static friction, comma-separated; can be repeated [default: 0,0.4,0.8, or the coefficient of the
    /// scene]
    #[arg(long, value_name = "NUMBERS", value_delimiter = ',', value_parser = number(|mu| (0.0..=f64::MAX).contains(mu), FRICTION))]
    mu_static: Vec<f64>,

    /// Number of points along each axis, including both ends: one number, or three for l21, phi22 and arm ratio
    #[arg(long, value_name = "POINTS", value_parser = parse_resolution, default_value = "20")]
    resolution: [usize; 3],

    /// Limits of l21 as fractions of the range that its base allows [default: 0,1]
    #[arg(long, value_name = "FROM,TO", value_parser = limits(FRACTIONS, number(|x| (0.0..=1.0).contains(x), FRACTIONS)))]
    l21: Option<[f64; 2]>,

    /// Limits of phi22 with units [default: "90 deg, 120 deg"]
    #[arg(long, value_name = "FROM,TO", value_parser = limits(ANGLES, parse_phi22))]
    phi22: Option<[f64; 2]>,

    /// Limits of the arm ratio l22/l11 [default: 1/3 and 2/3]
    #[arg(long, value_name = "FROM,TO", value_parser = limits(RATIOS, number(|x| (f64::MIN_POSITIVE..=f64::MAX).contains(x), RATIOS)))]
    arm_ratio: Option<[f64; 2]>,

    /// Rule for sizing motor and spring [default: the rule of the scene, else rigid]
    #[arg(long, value_parser = rule())]
    sizing: Option<Rule>,

    /// Quantities that the plots show within the stable region, comma-separated
    #[arg(
        long,
        visible_alias = "color-by",
        value_name = "QUANTITY",
        value_parser = quantity_parser(),
        value_delimiter = ',',
        default_value = "pfp",
        requires = "out"
    )]
    colour_by: Vec<Quantity>,

    /// Format of the file with all points
    #[arg(long, value_parser = points_parser(), default_value = "csv", requires = "out")]
    data: &'static str,

    #[command(flatten)]
    output: OutputArgs,
}

/// Accepted values in messages.
const FRICTION: &str = "coefficients of 0 or more, such as 0,0.4,0.8";
const FRACTIONS: &str = "two numbers between 0 and 1, such as 0,1";
const ANGLES: &str = "two angles such as \"90 deg, 120 deg\"";
const RATIOS: &str = "two numbers above 0, such as 0.333,0.667";

/// Files in the output directory.
const FILES: [&str; 5] = ["table.txt", "table.json", "points.csv", "points.parquet", "slices-*.svg"];

pub(super) fn run(args: &VolumeArgs) -> Result<Status, Failure> {
    let request = build_request(args)?;
    let inputs = args.scene.as_deref().map(source_files).unwrap_or_default();
    let directory = reserve(&[("the scene", &inputs)], &[], (args.output.out.as_deref(), &FILES))?;
    let interrupt = Interrupt::listen()?;
    let threads = default_threads();
    let start = Instant::now();
    let task = ["the study", "parts", args.output.unwritten()];
    let volumes = interrupt.compute(task, |monitor| volumes(&request, threads, monitor))?;
    let wall_s = start.elapsed().as_secs_f64();
    let mut report = VolumeReport::new(&request, &volumes);
    check_designs_exist(&report)?;
    report.directory = args.output.out.as_ref().map(|out| out.display().to_string());
    directory.write_with(|out| write(out, &request, &volumes, args, &mut report, &interrupt))?;
    report.timing = Some(Timing { wall_s, threads });
    print_result(&report, args.output.json)
}

/// Returns an error if no design exists at any base. Prints a warning for each single base without designs.
fn check_designs_exist(report: &VolumeReport) -> Result<(), Failure> {
    let empty = report.volumes.iter().filter(|volume| volume.counts.fingers == 0);
    let describe = |volume: &VolumeCounts| {
        let reason = volume.missing_fingers.first().map_or("", |missing| missing.reason.as_str());
        format!("no design exists at a base of {}: {reason}", units::format(volume.base_m, Dimension::Length))
    };
    let mut messages: Vec<String> = empty.map(describe).collect();
    let is_empty = messages.len() == report.volumes.len();
    // The existence of a design does not depend on friction, so the messages repeat for each coefficient.
    messages.dedup();
    if is_empty {
        let messages = messages.join("\n");
        return Err(Failure::bad_input(format!(
            "{messages}; give another --base, or other limits with --l21, --phi22 or --arm-ratio"
        )));
    }
    messages.iter().for_each(|message| print_diagnostic(&format!("warning: {message}; its shares are 0")));
    Ok(())
}

fn build_request(args: &VolumeArgs) -> Result<VolumeRequest, Failure> {
    let defaults = VolumeRequest::thesis();
    let template = match &args.scene {
        Some(path) => scene::parse_layers_as(&scene::load_layers(path)?, &args.set.set, scene::parse_template)?,
        None if args.set.set.is_empty() => defaults.template,
        None => {
            return Err(Failure::bad_input(
                "--set needs a scene, but none is given; name one, as in phalanx thesis volume scenes/experiment-95.toml --set …",
            ));
        }
    };
    let mut axes = Axes::thesis(args.resolution);
    for (axis, limits) in
        [(&mut axes.l21_fraction, args.l21), (&mut axes.phi22_rad, args.phi22), (&mut axes.arm_ratio, args.arm_ratio)]
    {
        [axis.from, axis.to] = limits.unwrap_or([axis.from, axis.to]);
    }
    let given = |values: &[f64]| Some(values.to_vec()).filter(|values| !values.is_empty());
    let (bases_m, mu_static) = match &args.scene {
        Some(_) => (vec![template.design.base_m], None),
        None => (defaults.bases_m, Some(defaults.mu_static)),
    };
    Ok(VolumeRequest {
        bases_m: given(&args.base).unwrap_or(bases_m),
        mu_static: match given(&args.mu_static).or(mu_static) {
            Some(mu_static) => mu_static,
            None => vec![single_friction(&template)?],
        },
        rule: args.sizing.or(template.rule).unwrap_or(defaults.rule),
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

/// Writes all files and lists them in the report; the tables are written last.
fn write(
    out: &Path,
    request: &VolumeRequest,
    volumes: &[Volume],
    args: &VolumeArgs,
    report: &mut VolumeReport,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    report.files = ["table.txt", "table.json", args.data].map(String::from).to_vec();
    for &quantity in &args.colour_by {
        let [key, ..] = quantity.names();
        let mut save_slices = |region: &str, rows: &[Vec<&Volume>]| -> Result<(), Failure> {
            interrupt.check()?;
            let file = format!("slices-{region}-{key}.svg");
            save(&out.join(&file), &slices(rows, quantity))?;
            report.files.push(file);
            Ok(())
        };
        for of_base in volumes.chunks(request.mu_static.len()) {
            let base_mm = (of_base[0].base_m * 1e9).round() / 1e6;
            save_slices(&format!("{base_mm}mm"), &of_base.iter().map(|volume| vec![volume]).collect::<Vec<_>>())?;
        }
        if request.bases_m.len() > 1 {
            save_slices("intersection", &by_friction(volumes))?;
        }
    }
    interrupt.check()?;
    table::write(&out.join(args.data), &points_table(volumes)).map_err(Failure::incomplete)?;
    interrupt.check()?;
    save(&out.join("table.json"), &report.json())?;
    save(&out.join("table.txt"), &report.report().to_string())
}

/// Returns the table of all points of all volumes, in order. Columns of a state are missing where no finger exists;
/// `reason` is missing where one exists.
fn points_table(volumes: &[Volume]) -> Table {
    let axes = ["base_m", "mu_static", "l21_fraction", "phi22_rad", "arm_ratio"];
    let numbers = axes.into_iter().chain(COLUMNS.map(|(name, _)| name)).map(|name| Column::new(name, Kind::Number));
    let flags = FLAGS.map(|(name, _)| Column::new(name, Kind::Flag));
    let columns: Vec<Column> = numbers.chain(flags).chain([Column::new("reason", Kind::Text)]).collect();
    let mut rows = Vec::with_capacity(volumes.iter().map(|volume| volume.points.len()).sum());
    for volume in volumes {
        for (index, point) in volume.points.iter().enumerate() {
            let axes = [volume.base_m, volume.mu_static].into_iter().chain(volume.axes.at(index));
            let mut row: Vec<Value> = axes.map(Value::Number).collect();
            if let Ok(state) = point {
                row.extend(COLUMNS.map(|(_, value)| Value::Number(value(state))));
                row.extend(FLAGS.map(|(_, test)| Value::Flag(test(state))));
            }
            row.resize(columns.len() - 1, Value::Missing);
            row.push(point.as_ref().map_or_else(|reason| Value::Text(reason.to_string()), |_| Value::Missing));
            rows.push(row);
        }
    }
    Table::new(columns, rows)
}

/// Returns the parser of quantities by their keys.
fn quantity_parser() -> impl TypedValueParser<Value = Quantity> {
    let help = |quantity| match quantity {
        Quantity::Pfp => "Palm force positiveness, N; if negative, the fingers would pull the object off the palm",
        Quantity::F21 => "Normal force of the proximal phalanx, N",
        Quantity::F22 => "Normal force of the distal phalanx, N",
        Quantity::Spring => "Torque of the spring, N·mm",
        Quantity::Motor => "Torque of the motor, N·mm",
        Quantity::Mass => "Mass of a finger, g",
        Quantity::FormClosed => "Whether the object is immobilised even without friction",
    };
    choice(Quantity::ALL.map(|quantity| (quantity.names()[0], help(quantity), quantity)))
}

/// Returns the parser of the format of all points, which gives the name of their file.
fn points_parser() -> impl TypedValueParser<Value = &'static str> {
    choice([
        ("csv", "Comma-separated values: text that any program reads", "points.csv"),
        ("parquet", "Binary columns: smaller and faster to read with data tools", "points.parquet"),
    ])
}

fn parse_phi22(text: &str) -> Result<f64, String> {
    quantity(Dimension::Angle)(text).and_then(|angle_rad| match angle_rad > 0.0 && angle_rad < std::f64::consts::PI {
        true => Ok(angle_rad),
        false => Err(format!("phi22 must be between 0 and 180 deg, both excluded; expected {ANGLES}")),
    })
}

/// Parses one number of points for all axes, or three.
fn parse_resolution(text: &str) -> Result<[usize; 3], String> {
    let expected = "expected one number of points for all axes, such as 20, or three numbers for l21, phi22 and the arm ratio, \
                    such as 20,31,20; each must be 1 or more";
    let points = |item: &str| match item.trim().parse::<usize>() {
        Ok(points) if points > 0 => Ok(points),
        _ => Err(format!("`{}` is not a valid number of points; {expected}", item.trim())),
    };
    match text.split(',').map(points).collect::<Result<Vec<_>, _>>()?[..] {
        [all] => Ok([all; 3]),
        [l21, phi22, arm] => Ok([l21, phi22, arm]),
        ref counts => Err(format!("{} numbers of points were given; {expected}", counts.len())),
    }
}
