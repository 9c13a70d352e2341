//! Design 95 with the printed torques, and its CAD model (thesis §4.3, §4.4, Fig. 4.8).

use super::step_error;
use crate::criteria::{Criteria, Tracker, scene_static_grasp};
use crate::gripper::total_mass;
use crate::monitor::StudyError;
use crate::plot::axis::Axis;
use crate::plot::canvas::Marker;
use crate::plot::series::{Series, series_chart};
use crate::plot::theme::{BLUE, Colour, GREEN, ORANGE};
use crate::scene::Scene;
use crate::statics::palm_force;
use crate::trace::{self, Event, FingerContact, FingerState, Outcome, Sample, Sink, SinkError};

/// A closing motion of the finger, with the data for a plot and a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Closing {
    pub name: &'static str,
    pub mass_kg: f64,
    pub criteria: Criteria,
    pub outcome: Outcome,
    /// PFP from the final forces.
    pub pfp_n: f64,
    /// Times and states of the finger.
    pub points: Vec<(f64, FingerState)>,
}

/// Simulates the finger of a scene.
pub fn closing(name: &'static str, scene: &Scene) -> Result<Closing, StudyError> {
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
    let x = Axis::from_range("time, ms", 0.0, end.max(1e-9));
    let values = points().flat_map(|point| angles.iter().map(move |(.., angle)| angle(&point.1)));
    let y = Axis::linear("angle, deg", values);
    let curves = closings.iter().enumerate().flat_map(|(index, closing)| {
        let marker = if index == 0 { Marker::Line { width: 2.0 } } else { Marker::FaintLine { width: 3.0 } };
        angles.map(|(name, colour, angle)| {
            let curve = closing.points.iter().map(|point| (point.0, angle(&point.1)));
            Series::over_time(marker, colour, curve).named(format!("{name}, {}", closing.name))
        })
    });
    series_chart(title, 460.0, &x, &y, &curves.collect::<Vec<_>>())
}
