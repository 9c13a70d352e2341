//! Sizing and statics of the designs (thesis §3.3.2, §4.2.1), the influence of torques and grid points, and the closing of
//! design 95 with the printed torques and of its CAD model (§4.3, §4.4, Fig. 4.8).
//!
//! A grid with points on the faces of the space overweights the faces; points at cell centres do not. Percentages with
//! other torques on the same points show the influence of sizing.

use std::f64::consts::FRAC_PI_2;

use super::{Run, Simulations, step_error};
use crate::criteria::{Criteria, Tracker, scene_static_grasp};
use crate::gripper::{Placement, Spring, total_mass};
use crate::plot::canvas::Marker;
use crate::plot::chart::{Axis as PlotAxis, Series, series_chart};
use crate::plot::theme::{BLUE, Colour, GREEN, ORANGE};
use crate::scene::{self, Scene, SpringKind, Template};
use crate::sizing::{Profile, ProfilePoint, Rule, Sizing, Task, profile};
use crate::statics::{NecessaryCount, drive_loads, equilibrium, form_closure, palm_force};
use crate::trace::{self, Event, FingerContact, FingerState, Outcome, RequiredData, Sample, Sink, SinkError};
use crate::volume::{Axes, Axis, BASES_M, ClosedFinger, close_finger, close_linkage, design_at};
use phalanx_parallel::{ComputeError, Monitor};

/// Motor torque that the thesis prints for design 95 (§4.3); it has no other source.
const PRINTED_MOTOR_N_M: f64 = 0.480;
/// Spring torque that the thesis prints for design 95 (§4.3); it has no other source.
const PRINTED_SPRING_N_M: f64 = 0.1326;

/// The finger of Figs. 3.2 and 3.3.
const EXAMPLE: &str =
    "sizing = \"rigid\"\n[design]\nbase = \"12 mm\"\nl21 = \"18.9 mm\"\nphi22 = \"100 deg\"\narm_ratio = 0.5\n";
/// Deflection of a torsional spring for the straight finger: a right angle. The thesis does not specify it.
const PRELOAD_RAD: f64 = FRAC_PI_2;
/// Number of samples of the example's profile.
const SAMPLES: usize = 400;
/// Number of samples of a profile that is evaluated but not plotted.
const FEW_SAMPLES: usize = 60;

/// Number of cells along each axis of a [`Grid`].
pub(crate) const CELLS_PER_AXIS: usize = 10;

/// Results of the sizing.
#[derive(Clone, Debug, PartialEq)]
pub struct SizingFound {
    /// Sizing of design 95 with the rule for the rigid phase.
    pub rigid: Sizing,
    /// Sizing of design 95 with the rule for the whole closing.
    pub whole: Sizing,
    /// The finger of Figs. 3.2 and 3.3.
    pub example: Profile,
    /// Number of designs for which the last two of the four placements need the two weakest springs.
    pub last_placements_weakest: usize,
    /// Number of designs in which the constant spring never needs more torque than the torsional spring.
    pub constant_spring_weaker: usize,
}

impl SizingFound {
    /// Ratios of the printed torques of design 95 to the computed ones: motor, spring.
    fn printed_ratios(&self) -> [f64; 2] {
        [PRINTED_MOTOR_N_M / self.rigid.motor_n_m, PRINTED_SPRING_N_M / self.rigid.spring_n_m]
    }
}

/// Sizes design 95, the example, and all designs.
pub fn sizing<'a>(designs: impl Iterator<Item = &'a Scene>, chosen: &Scene) -> Result<SizingFound, ComputeError> {
    let example = scene::parse(EXAMPLE, "example.toml").map_err(step_error("the example"))?;
    let chosen = sizing_profile(chosen, FEW_SAMPLES)?;
    let mut found = SizingFound {
        rigid: chosen.rigid,
        whole: chosen.whole,
        example: sizing_profile(&example, SAMPLES)?,
        last_placements_weakest: 0,
        constant_spring_weaker: 0,
    };
    for design in designs {
        let profile = sizing_profile(design, FEW_SAMPLES)?;
        let [s1, s2, s3, s4] = profile.placements_n_m;
        found.last_placements_weakest += usize::from(s3.max(s4) < s1.min(s2));
        // Up to the contact both springs are equal except for rounding.
        let is_weaker =
            |point: &ProfilePoint| point.constant_n_m <= point.torsional_n_m + 1e-12 * point.torsional_n_m.abs();
        found.constant_spring_weaker += usize::from(profile.points.iter().all(is_weaker));
    }
    Ok(found)
}

fn sizing_profile(scene: &Scene, samples: usize) -> Result<Profile, ComputeError> {
    profile(&scene.finger().linkage, &task(scene)?, PRELOAD_RAD, samples).map_err(step_error("the sizing"))
}

/// Returns the closing motion for which the finger of a scene is sized.
fn task(scene: &Scene) -> Result<Task, ComputeError> {
    let object = scene.object().ok_or("there is no object").map_err(step_error("the sizing"))?;
    Ok(Task::thesis(object.placed()))
}

/// Numbers of statically stable designs with another sizing, without friction and with friction.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct OtherSizing {
    pub torques: &'static str,
    pub statically_stable_mu_0: usize,
    pub statically_stable_mu_0_8: usize,
}

/// Returns the necessary condition (1.19) for form closure of the grasp of a scene.
pub fn necessary_count(scene: &Scene) -> Result<NecessaryCount, ComputeError> {
    let rest = scene_static_grasp(scene).map_err(step_error("form closure"))?;
    Ok(form_closure(&scene.finger().linkage, &rest.end).map_err(step_error("form closure"))?.necessary)
}

/// Returns the number of form-closed designs of the design space printed in §4.2, in which l21 takes quarters of its
/// range (errata 15).
pub(crate) fn form_closed_in_quarters() -> Result<usize, ComputeError> {
    let axes = Axes { l21_fraction: Axis::new(0.0, 0.75, 4), ..Axes::thesis([4, 4, 3]) };
    let mut form_closed = 0;
    for base_m in BASES_M {
        for finger in closed_fingers(base_m, axes, "the designs in quarters") {
            form_closed += usize::from(finger?.sized.form_closed);
        }
    }
    Ok(form_closed)
}

/// Sizes and closes the fingers of a base at all points of the axes.
fn closed_fingers(
    base_m: f64,
    axes: Axes,
    step: &'static str,
) -> impl Iterator<Item = Result<ClosedFinger, ComputeError>> {
    let template = Template::thesis();
    (0..axes.len()).map(move |index| {
        let design = design_at(&template, base_m, axes.at(index));
        close_finger(&template, &design, Rule::Rigid).map_err(step_error(step))
    })
}

/// Evaluates static stability with the sizing of the study, with the other rule, and with motor and spring torques
/// scaled by the printed ratios of design 95.
pub(crate) fn other_sizings(simulations: &Simulations, found: &SizingFound) -> Result<Vec<OtherSizing>, ComputeError> {
    let [motor, spring] = found.printed_ratios();
    let mut sizings = vec![OtherSizing {
        torques: "this study: RMS over the rigid phase",
        statically_stable_mu_0: simulations.count(0, Run::is_statically_stable),
        statically_stable_mu_0_8: simulations.count(1, Run::is_statically_stable),
    }];
    for (torques, rule, factors) in [
        ("RMS over all 10 ms", Rule::Whole, [1.0, 1.0]),
        ("spring of every design stronger by the printed ratio of design 95", Rule::Rigid, [1.0, spring]),
        ("spring stronger and motor weaker by the printed ratios of design 95", Rule::Rigid, [motor, spring]),
    ] {
        let mut stable = [0; 2];
        for run in &simulations.runs {
            let closed = close_linkage(run.scene.finger().linkage, &task(&run.scene)?, rule);
            let closed = closed.map_err(step_error("another sizing"))?;
            stable[run.condition] += usize::from(is_stable(&closed, factors, [0.0, 0.8][run.condition])?);
        }
        sizings.push(OtherSizing { torques, statically_stable_mu_0: stable[0], statically_stable_mu_0_8: stable[1] });
    }
    Ok(sizings)
}

/// Percentages for one base, over the centres of `CELLS_PER_AXIS`³ cells. Pairs are without friction and with μ_s =
/// 0.8.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    pub base_m: f64,
    /// Percentages of stable designs with the sizing of the volumes.
    pub stable_percent: [f64; 2],
    /// Percentage of designs that are stable without friction and form-closed.
    pub closed_percent: f64,
    /// Percentages of stable designs if the spring torque is scaled by the printed ratio for design 95.
    pub stronger_spring_percent: [f64; 2],
    /// Percentages of stable designs if the spring torque and the motor torque are scaled by the printed ratios for
    /// design 95.
    pub both_torques_percent: [f64; 2],
}

/// Computes the percentages for each base of the thesis.
///
/// # Errors
/// Returns an error if a finger or its statics cannot be computed, or the monitor stops the computation.
pub fn grids(sizing: &SizingFound, monitor: &Monitor) -> Result<Vec<Grid>, ComputeError> {
    let [motor_ratio, spring_ratio] = sizing.printed_ratios();
    let centres = |axis: &Axis| {
        let half = 0.5 * (axis.to - axis.from) / axis.points as f64;
        Axis::new(axis.from + half, axis.to - half, axis.points)
    };
    let [l21_fraction, phi22_rad, arm_ratio] = Axes::thesis([CELLS_PER_AXIS; 3]).all().map(centres);
    let axes = Axes { l21_fraction, phi22_rad, arm_ratio };
    let grid = |base_m: f64| -> Result<Grid, ComputeError> {
        let (mut counts, mut closed_and_stable) = ([[0usize; 2]; 3], 0usize);
        for closed in closed_fingers(base_m, axes, "the volumes by other torques") {
            monitor.check()?;
            let closed = closed?;
            let factors = [[1.0, 1.0], [1.0, spring_ratio], [motor_ratio, spring_ratio]];
            for (count, factors) in counts.iter_mut().zip(factors) {
                for (mu, mu_static) in [0.0, 0.8].into_iter().enumerate() {
                    count[mu] += usize::from(is_stable(&closed, factors, mu_static)?);
                }
            }
            closed_and_stable += usize::from(closed.sized.form_closed && is_stable(&closed, [1.0, 1.0], 0.0)?);
        }
        let percent = |count: usize| 100.0 * count as f64 / axes.len() as f64;
        let [stable_percent, stronger_spring_percent, both_torques_percent] = counts.map(|count| count.map(percent));
        let closed_percent = percent(closed_and_stable);
        Ok(Grid { base_m, stable_percent, closed_percent, stronger_spring_percent, both_torques_percent })
    };
    BASES_M.into_iter().map(grid).collect()
}

/// Returns whether the grasp is force-positive with motor and spring torque multiplied by factors.
fn is_stable(closed: &ClosedFinger, [motor, spring]: [f64; 2], mu_static: f64) -> Result<bool, ComputeError> {
    let sizing = closed.sized.sizing;
    let kind = SpringKind::Constant { torque_n_m: sizing.spring_n_m * spring };
    let spring = Spring { kind, placement: Placement::Phalanges };
    let loads = drive_loads(&closed.finger, &closed.end, sizing.motor_n_m * motor, Some(&spring));
    let loads = loads.map_err(step_error("static stability"))?;
    let forces = equilibrium(&closed.finger, &closed.end, loads, mu_static).map_err(step_error("static stability"))?;
    Ok(forces.is_force_positive())
}

/// A closing motion of the finger, with the data for a plot and a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Closing {
    pub name: &'static str,
    pub mass_kg: f64,
    pub criteria: Criteria,
    pub outcome: Outcome,
    /// PFP computed from the final forces, N.
    pub pfp_n: f64,
    /// Times and states of the finger.
    pub points: Vec<(f64, FingerState)>,
}

/// Simulates the finger of a scene.
pub fn closing(name: &'static str, scene: &Scene) -> Result<Closing, ComputeError> {
    let rest = scene_static_grasp(scene).map_err(step_error(name))?;
    let mut recorder = ClosingRecorder { tracker: Tracker::new(rest.final_angles()), points: Vec::new() };
    let outcome = trace::run_analytic(scene, &mut recorder).map_err(step_error(name))?;
    let [f21_n, f22_n] =
        [FingerContact::Proximal, FingerContact::Distal].map(|contact| outcome.last.finger_contact(contact).normal_n);
    let criteria = recorder.tracker.criteria(rest.static_forces_n());
    Ok(Closing {
        name,
        mass_kg: total_mass(&scene.finger().linkage.bodies),
        criteria: criteria.ok_or("the run has no duration").map_err(step_error(name))?,
        pfp_n: palm_force(&rest.end, f21_n, f22_n, rest.mu_static[0]),
        outcome,
        points: recorder.points,
    })
}

/// Records the angles in addition to the criteria.
struct ClosingRecorder {
    tracker: Tracker,
    points: Vec<(f64, FingerState)>,
}

impl Sink for ClosingRecorder {
    fn required_data(&self) -> RequiredData {
        RequiredData::EVALUATION
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.points.push((sample.time_s, sample.finger(0)));
        self.tracker.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.tracker.event(event)
    }
}

type Angle = (&'static str, Colour, fn(&FingerState) -> f64);

/// Draws the joint angles: the first closing motion with solid lines, others with faint lines.
pub(crate) fn plot_closings(title: &str, closings: &[&Closing]) -> String {
    let angles: [Angle; 3] = [
        ("q11", BLUE, |finger| finger.q11_rad.to_degrees()),
        ("q21", ORANGE, |finger| finger.q21_rad.to_degrees()),
        ("q22", GREEN, |finger| finger.q22_rad.to_degrees()),
    ];
    let points = || closings.iter().flat_map(|closing| &closing.points);
    let end = points().map(|point| point.0 * 1e3).fold(0.0, f64::max);
    let x = PlotAxis::from_range("time, ms", 0.0, end.max(1e-9));
    let values = points().flat_map(|point| angles.iter().map(move |(.., angle)| angle(&point.1)));
    let y = PlotAxis::linear("angle, deg", values);
    let curves = closings.iter().enumerate().flat_map(|(index, closing)| {
        let marker = if index == 0 { Marker::Line { width: 2.0 } } else { Marker::FaintLine { width: 3.0 } };
        angles.map(|(name, colour, angle)| {
            let curve = closing.points.iter().map(|point| (point.0, angle(&point.1)));
            Series::over_time(marker, colour, curve).named(format!("{name}, {}", closing.name))
        })
    });
    series_chart(title, 460.0, &x, &y, &curves.collect::<Vec<_>>())
}
