//! Actuators of a mechanism.

use schemars::JsonSchema;
use serde::Deserialize;

use super::joint::combination;
use super::mirror::Entries;
use super::names::{Known, check_units, find};
use super::powertrain::{FeedbackSettings, GearSettings, MotorSettings, Units, powertrain};
use crate::drive::Brake;
use crate::law::Bristle;
use crate::mechanism::{Actuator, Command, Mechanism, Pose, Tendon, TendonActuator};
use crate::scene::quantity::{
    Coordinate, CoordinateRate, Effort, Force, Frequency, Gain, Inertia, JointStiffness, Length, NotNegative, Plain,
    Positive, Quantity, RateGain, Time, Torque, UpTo1, Word,
};
use crate::scene::section_input::{SectionInput, Subsection};
use crate::scene::sections::check_point_count;
use crate::scene::{Interpolation, Problem, Profile};

/// A brake, which adds to the torque (force) of the actuator.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct BrakeSettings {
    /// Largest torque (force); beyond it the brake slips.
    #[schemars(extend("x-required" = "add the largest torque: limit = \"2 N*m\", or a force of a prismatic joint"))]
    pub limit: Option<Positive<Effort>>,
    /// Time at which the brake begins to engage.
    #[schemars(extend("default" = "0 s"))]
    pub at: NotNegative<Time>,
    /// Duration of engagement and of release.
    #[schemars(extend("default" = "1 ms"))]
    pub rise: Positive<Time>,
    /// Time at which the brake begins to release. Default: never.
    pub release: Option<Positive<Time>>,
    /// Whether it resists negative rates only.
    #[schemars(extend("default" = false))]
    pub one_way: bool,
    /// Rate at which the brake reaches its limit. Default: 0.01 rad/s, of a prismatic joint 1 mm/s.
    pub rate: Option<Positive<CoordinateRate>>,
    /// Stiffness of a bristle, with which the brake holds without creep. Default: none; a load below `limit` then lets the joint creep.
    pub stiffness: Option<Positive<JointStiffness>>,
    /// Relaxation time of the bristle.
    #[schemars(extend("default" = "1 ms"))]
    pub relaxation: Positive<Time>,
}

/// An actuator of a joint: a torque (force) over time, or a controller that follows a target. The torque is limited, and
/// falls with the speed. A brake can hold the joint.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct ActuatorSettings {
    /// The driven joint. Required unless `joints` or `tendon` is given.
    #[schemars(extend("minLength" = 1, "x-alternative" = "joints|tendon", "x-required" = "add the driven joint: joint = \"driver\""))]
    pub joint: Option<String>,
    /// Joints of an actuator that turns by the sum of their coordinates times `factors`, in place of `joint`: the input of a
    /// differential turns by the mean of its outputs.
    pub joints: Option<Vec<String>>,
    /// A factor for each of `joints`.
    pub factors: Option<Vec<Quantity<Plain>>>,
    /// Value of the combination of `joints` that counts as 0. Default: 0.
    pub offset: Option<Quantity<Coordinate>>,
    /// The pulled tendon, in place of `joint`.
    #[schemars(extend("minLength" = 1))]
    pub tendon: Option<String>,
    /// Constant tension of a tendon.
    pub tension: Option<NotNegative<Force>>,
    /// Tensions of a tendon at `times`.
    pub tensions: Option<Vec<NotNegative<Force>>>,
    /// Constant torque of a revolute joint; with `gear` or `lead`, of the motor shaft.
    pub torque: Option<Quantity<Torque>>,
    /// Constant force of a prismatic joint.
    pub force: Option<Quantity<Force>>,
    /// Times of `torques`, `forces`, `tensions`, `targets` or the `voltages` of the motor, increasing. Values are constant before the first and after the last.
    pub times: Option<Vec<Quantity<Time>>>,
    /// Interpolation between `times`: "linear", or "step": each value holds until the next time.
    #[schemars(extend("default" = "linear"))]
    pub interpolation: Word<Interpolation>,
    /// Duration of a smooth rise of `torque` or `force` from 0. Default: none.
    pub rise: Option<Positive<Time>>,
    /// Duration of a half sine with the peak `torque` or `force`, which is 0 afterwards. Default: none.
    pub pulse: Option<Positive<Time>>,
    /// Torques at `times`.
    pub torques: Option<Vec<Quantity<Torque>>>,
    /// Forces at `times`.
    pub forces: Option<Vec<Quantity<Force>>>,
    /// Coordinate that the controller follows; with `feedback`, the distance.
    pub target: Option<Quantity<Coordinate>>,
    /// Coordinates, or distances, at `times` that the controller follows.
    pub targets: Option<Vec<Quantity<Coordinate>>>,
    /// Largest rate of the set point. It begins at the start value of the coordinate or distance and follows `target` or `targets`.
    /// Default: none; the set point is the target.
    pub target_rate: Option<Positive<CoordinateRate>>,
    /// Gain on the error of the coordinate, which gives a torque (force) of the motor shaft, or a voltage of a `motor`. Default:
    /// 0, to follow only the rate of the target.
    pub kp: Option<NotNegative<Gain>>,
    /// Gain on the error of the rate. Default: 0.
    pub kd: Option<NotNegative<RateGain>>,
    /// Rate at which the controller is computed; its torque (force) is constant in between. Default: it is continuous.
    pub rate: Option<Positive<Frequency>>,
    /// Largest torque (force) at rest: bound of the command, before the command changes with the speed. Without
    /// `no_load_speed`, no torque exceeds it. Default: none.
    pub limit: Option<Positive<Effort>>,
    /// Rate ω₀ at which the torque (force) has fallen to 0: at the rate v in its direction, it is the command times 1 −
    /// v/ω₀. It exceeds `limit` if the joint moves against it (v below 0), and brakes beyond ω₀. Default: none; the
    /// torque does not depend on the rate.
    pub no_load_speed: Option<Positive<CoordinateRate>>,
    #[schemars(with = "BrakeSettings")]
    pub brake: Subsection,
    /// Gear ratio: rate of the motor per rate of the joint; on a prismatic joint in rad/m. `torque`, `limit` and
    /// `no_load_speed` are then those of the motor shaft. Default: 1.
    pub gear: Option<Quantity<Plain>>,
    /// Travel of a prismatic joint per turn of the motor, in place of `gear` = 2π/lead.
    pub lead: Option<Positive<Length>>,
    /// Moment of inertia of the rotor of the motor, which adds gear² times its value to the inertia of the joint.
    pub rotor: Option<NotNegative<Inertia>>,
    /// Efficiency η of the gear: a gear that drives gives η times its torque, and one that is driven back resists with
    /// 2 − η times. At rest it loses nothing, so that a stalled joint creeps to the full torque; below 0.8, prefer
    /// `loss_stiffness`. Default: 1.
    pub efficiency: Option<Quantity<Plain, UpTo1>>,
    /// Rate of the joint from which on the gear has its full loss. Default: 0.01 rad/s, of a prismatic joint 1 mm/s.
    pub loss_rate: Option<Positive<CoordinateRate>>,
    /// Stiffness of a bristle, with which the gear holds a stalled joint without creep, in place of `loss_rate`. Its
    /// relaxation time is 1 ms. Default: none.
    pub loss_stiffness: Option<Positive<JointStiffness>>,
    #[schemars(with = "MotorSettings")]
    pub motor: Subsection,
    #[schemars(with = "FeedbackSettings")]
    pub feedback: Subsection,
}

pub(super) fn actuator(name: &str, section: &SectionInput<'_>, known: &Known<'_>) -> Option<Actuator> {
    let settings: ActuatorSettings = section.read();
    let ActuatorSettings { joint, joints, factors, .. } = &settings;
    let (mut on, linear, of) = combination(section, known, joint.as_ref(), joints.as_ref(), factors.as_ref(), 1)?;
    on.offset = settings.offset.map_or(0.0, |offset| *offset);
    let brake = brake(&section.subsection("brake"), linear, of)?;
    let units = Units::new(section, linear, of);
    let units_fit = units.check(section);
    let gear = GearSettings {
        gear: settings.gear.map(|gear| *gear),
        lead: settings.lead.map(|lead| *lead),
        rotor: settings.rotor.map(|rotor| *rotor),
        efficiency: settings.efficiency.map(|efficiency| *efficiency),
        loss_rate: settings.loss_rate.map(|rate| *rate),
        loss_stiffness: settings.loss_stiffness.map(|stiffness| *stiffness),
    };
    let powertrain = powertrain(name, section, &gear, &units)?;
    let motor = section.subsection("motor");
    let MotorSettings { voltage, voltages, .. } = motor.quietly(SectionInput::read);
    let commands = ["torque", "force", "torques", "forces", "target", "targets"];
    let mut given: Vec<&str> = commands.into_iter().filter(|key| section.has(key)).collect();
    if units.has_motor && given.is_empty() {
        given.push(if voltages.is_some() { "voltages" } else { "voltage" });
    }
    let [key] = given[..] else {
        let effort = if linear { "force = \"5 N\"" } else { "torque = \"0.25 N*m\"" };
        let help = format!("write {effort}, or a target with the gains of a controller: target, kp, kd");
        if given.is_empty() {
            let message = format!("actuator `{name}` has neither a torque or force nor a target");
            return section.refuse("", message, "no command", help);
        }
        let message = format!("actuator `{name}` has several commands: {}", given.join(", "));
        return section.refuse(given[1], message, "one command only", format!("keep one of them; {help}"));
    };
    let over_time = settings.interpolation.0;
    let effort = |value: f64| {
        Some(match (settings.rise, settings.pulse) {
            (None, None) => Profile::Constant { value },
            (Some(rise), None) => Profile::Ramp { value, rise_s: *rise },
            (None, Some(pulse)) => Profile::HalfSine { value, length_s: *pulse },
            (Some(_), Some(_)) => {
                let message = format!("actuator `{name}` has both a rise and a pulse");
                return section.refuse("pulse", message, "not with `rise`", "keep one of them");
            }
        })
    };
    if let Some(key) = ["force", "forces"].into_iter().find(|key| linear && !units.shaft_is_linear && section.has(key))
    {
        let message = format!("`{}` is a force, but the motor of `{name}` has a torque", section.path(key));
        let help = "write the torque of the motor shaft: torque = \"5 N*mm\"";
        return section.refuse(key, message, "a torque", help);
    }
    let profile = match key {
        "voltage" => Some(Profile::Constant { value: *voltage? }),
        "voltages" => {
            motor.report_unused(["voltage"], "with `voltages`");
            voltage_table(section, &motor, settings.times.clone(), over_time, voltages?)
        }
        "torque" => effort(*settings.torque?),
        "force" => effort(*settings.force?),
        "target" => Some(Profile::Constant { value: *settings.target? }),
        "torques" => values_over_time(section, key, settings.times, over_time, settings.torques?),
        "forces" => values_over_time(section, key, settings.times, over_time, settings.forces?),
        _ => values_over_time(section, key, settings.times, over_time, settings.targets?),
    };
    if !key.ends_with('s') {
        section.report_unused(["times", "interpolation"], &format!("with `{key}`"));
    }
    if !["torque", "force"].contains(&key) {
        section.report_unused(["rise", "pulse"], &format!("with `{key}`"));
    }
    let command = if key.starts_with("target") {
        let [kp, kd] = [settings.kp.map(|kp| *kp), settings.kd.map(|kd| *kd)];
        if kp.is_none() && kd.is_none() {
            let help = if linear {
                "kp = \"2e4 N/m\", kd = \"60 N*s/m\""
            } else {
                "kp = \"5 N*m/rad\", kd = \"0.05 N*m*s/rad\""
            };
            return section.refuse_missing("kp", &format!("add the gains of the controller: {help}"));
        }
        let rate_hz = settings.rate.map(|rate| *rate);
        let target_rate = settings.target_rate.map(|rate| *rate);
        Command::Servo { kp: kp.unwrap_or(0.0), kd: kd.unwrap_or(0.0), target: profile?, target_rate, rate_hz }
    } else {
        section.report_unused(["kp", "kd", "target_rate", "rate"], &format!("with `{key}`: there is no target"));
        if section.subsection("feedback").is_present() {
            let message = format!("`{}` has no effect with `{key}`: there is no target", section.path("feedback"));
            let help = "write target, kp and kd in place of it, or remove the feedback";
            return section.refuse("feedback", message, "no controller", help);
        }
        Command::Effort(profile?)
    };
    let limit = match (units.has_motor, &command) {
        (true, Command::Effort(_)) => None,
        (true, Command::Servo { .. }) => {
            motor.report_unused(["voltages"], "with a target: the controller gives the voltage");
            let voltage = *voltage?;
            if voltage <= 0.0 {
                let message = format!(
                    "`{}` is the largest voltage of the controller, and must be above 0",
                    motor.path("voltage")
                );
                return motor.refuse(
                    "voltage",
                    message,
                    "above 0",
                    "write the voltage of the supply: voltage = \"12 V\"",
                );
            }
            Some(voltage)
        }
        (false, _) => settings.limit.map(|limit| *limit),
    };
    units_fit.then(|| Actuator {
        name: name.to_owned(),
        on,
        command,
        limit,
        no_load_speed: settings.no_load_speed.map(|speed| *speed),
        brake,
        powertrain,
    })
}

/// The voltages of a motor over the times of its actuator.
fn voltage_table<D, R>(
    section: &SectionInput<'_>,
    motor: &SectionInput<'_>,
    times: Option<Vec<Quantity<Time>>>,
    interpolation: Interpolation,
    voltages: Vec<Quantity<D, R>>,
) -> Option<Profile> {
    let Some(times) = times else {
        let help = "add the times of `voltages` to the actuator: times = [\"0 ms\", \"20 ms\"]";
        return section.refuse_missing("times", help);
    };
    if times.len() != voltages.len() {
        let message = format!("`{}` has {} values for {} times", motor.path("voltages"), voltages.len(), times.len());
        return motor.refuse("voltages", message, "one value per time", "write as many values as times, at least one");
    }
    values_over_time(section, "times", Some(times), interpolation, voltages)
}

/// Resolves a brake; the outer `None` if it is invalid.
fn brake(section: &SectionInput<'_>, linear: bool, of: &str) -> Option<Option<Brake>> {
    if !section.is_present() {
        return Some(None);
    }
    let BrakeSettings { limit, at, rise, release, one_way, rate, stiffness, relaxation } = section.read();
    let units_fit = check_units(section, linear, of);
    let engaged_s = *at + *rise;
    if let Some(release) = release.filter(|release| **release < engaged_s) {
        let message =
            format!("`{}` is {} s, before the brake is engaged at {engaged_s} s", section.path("release"), *release);
        return section.refuse("release", message, "too early", "release it later, or engage it earlier or faster");
    }
    if stiffness.is_none() {
        section.report_unused(["relaxation"], "without `stiffness`");
    }
    let bristle = |stiffness: Positive<JointStiffness>| Bristle {
        damping_n_s_per_m: *stiffness * *relaxation,
        relaxation_s: *relaxation,
    };
    let brake = Brake {
        torque_n_m: *limit?,
        start_s: *at,
        rise_s: *rise,
        release_s: release.map(|release| *release),
        one_way,
        v_static_rad_s: rate.map_or(if linear { 1e-3 } else { 0.01 }, |rate| *rate),
        bristle: stiffness.map(bristle),
    };
    units_fit.then_some(Some(brake))
}

/// Limits the rates of set points, which begin at the coordinates or distances of these poses.
pub(super) fn limit_target_rates(mechanism: &mut Mechanism, poses: &[Pose]) {
    let starts: Vec<f64> = mechanism.actuators.iter().map(|actuator| mechanism.measured(actuator, poses)).collect();
    for (actuator, start) in mechanism.actuators.iter_mut().zip(starts) {
        if let Command::Servo { target, target_rate: Some(rate), .. } = &mut actuator.command {
            *target = target.rate_limited((0.0, start), *rate);
        }
    }
}

/// Resolves the actuators of tendons; their images pull the images of the tendons.
pub(super) fn pulls(actuators: &Entries<'_>, tendons: &Entries<'_>, all: &mut [Option<Tendon>]) {
    let (images, names, tendon_images) = (actuators.partners(), actuators.names(), tendons.partners());
    for (index, name, section) in actuators.written().filter(|(.., section)| section.has("tendon")) {
        let Some((tendon, tension)) = pull(section, &tendons.names()) else { continue };
        let image = (images[index] != index).then(|| (tendon_images[tendon], names[images[index]]));
        for (tendon, name) in [(tendon, name)].into_iter().chain(image) {
            let Some(tendon) = all[tendon].as_mut() else { continue };
            if let Some(other) = &tendon.actuator {
                let message = format!("the tendon `{}` has two actuators, {} and {name}", tendon.name, other.name);
                section.report("tendon", message, "pulled twice", "remove one of them, and add up the tensions");
            }
            tendon.actuator = Some(TendonActuator { name: name.to_owned(), tension: tension.clone() });
        }
    }
}

/// Resolves the actuator of a tendon: the tendon, and its tension.
fn pull(section: &SectionInput<'_>, names: &[&str]) -> Option<(usize, Profile)> {
    let ActuatorSettings { tendon, tension, tensions, times, interpolation, .. } = section.read();
    let of_tendons = ["tendon", "tension", "tensions", "times", "interpolation"];
    let of_joints = section.keys().chain(["brake", "motor", "feedback"]).filter(|key| !of_tendons.contains(key));
    section.report_unused(of_joints, "with `tendon`");
    let tension = match (tension, tensions) {
        (Some(value), _) => {
            section.report_unused(["times", "tensions", "interpolation"], "with `tension`");
            Some(Profile::Constant { value: *value })
        }
        (None, Some(values)) => values_over_time(section, "tensions", times, interpolation.0, values),
        (None, None) => section.refuse_missing("tension", "add the tension: tension = \"30 N\", or times and tensions"),
    };
    Some((find(section, "tendon", &tendon?, "tendon", names)?, tension?))
}

/// A table of values over increasing times.
fn values_over_time<D, R>(
    section: &SectionInput<'_>,
    key: &str,
    times: Option<Vec<Quantity<Time>>>,
    interpolation: Interpolation,
    values: Vec<Quantity<D, R>>,
) -> Option<Profile> {
    let Some(times) = times else {
        let help = format!("add the times of `{key}`: times = [\"0 ms\", \"20 ms\"]");
        return section.refuse_missing("times", &help);
    };
    check_point_count(section, times.len())?;
    if times.len() != values.len() || times.is_empty() {
        let message = format!("`{}` has {} values for {} times", section.path(key), values.len(), times.len());
        return section.refuse(key, message, "one value per time", "write as many values as times, at least one");
    }
    if let Some(k) = (1..times.len()).find(|k| *times[*k] <= *times[*k - 1]) {
        let message = format!("time {} of `{}` is not after the one before it", k + 1, section.path("times"));
        let span = section.item_span("times", k);
        let help = "sort the times; two values need two times";
        section.checker.push(Problem::new(span, message, "not increasing", help));
        return None;
    }
    let points = times.iter().zip(&values).map(|(time, value)| (**time, **value)).collect();
    Some(Profile::Table { points, interpolation })
}
