//! Actuators with a powertrain: motor torque, loss of the gear and current, in ranges that end at their kinks; the states
//! of the current and of the bristle of a gear; and controllers of the distance of two points.
//!
//! The current of a motor with an inductance is the rate of a coordinate, its charge, so that the states of bristles may
//! depend on it.

use super::actuator::{RANGE_MARGIN, RANGE_TOLERANCE, UNMONITORED, command_scale, ends, range_of_value};
use super::cable::Cable;
use super::drive_model::{DriveModel, DriveRows, Kind};
use super::dynamics::{Chunk, Sums};
use super::group::{PlacedGroup, Row};
use super::model::{MechanismMode, MechanismModel};
use super::motion::{LANES, Lanes, Motions};
use crate::analytic::contact::StateRef;
use crate::drive::Profile;
use crate::integrator::{Dynamic, EventFunction, RootSearch};
use crate::law::{Bristle, friction_coefficient};
use crate::mechanism::{Actuator, Command, GearLoss, MIN_DISTANCE_M, Motor, Powertrain};
use crate::numeric::{Dual, Real};

/// Overlap of the ranges of the loss of a gear, as a fraction of its bound. Without it the ranges alternate where the loss
/// stays at its bound.
const LOSS_MARGIN: f64 = 1e-7;
/// Overlap of the ranges of the rate of a lossy gear, as a fraction of the rate of its law.
const SPEED_MARGIN: f64 = 1e-6;

/// Variables of a powertrain: time, measured value and its rate, rate of the coordinate, current and state of the bristle.
const VARIABLES: usize = 6;
const TIME: usize = 0;
const MEASURED: usize = 1;
const MEASURED_RATE: usize = 2;
const RATE: usize = 3;
const CURRENT: usize = 4;
const BRISTLE: usize = 5;

type Variables<T> = [T; VARIABLES];

/// Torque of the motor, loss of the gear as a torque against the coordinate, current, voltage, and rate of the current.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Forces<T> {
    pub torque: T,
    pub loss: T,
    pub current: T,
    pub voltage: T,
    current_rate: T,
}

/// What samples contain of an actuator with a powertrain.
#[derive(Clone, Copy, Debug, Default)]
pub struct DriveReading {
    /// Torque of the motor, N·m.
    pub torque_n_m: f64,
    /// Current, A, and voltage, V; 0 without a motor.
    pub current_a: f64,
    pub voltage_v: f64,
    /// Distance of the points, m, and its rate; 0 without them.
    pub distance_m: f64,
    pub distance_rate_m_s: f64,
    /// Work that the gear has lost, J, by its index among the quadratures.
    pub loss_work: Option<usize>,
}

/// Command of an actuator: torque or voltage, before its limit.
fn command<T: Real>(actuator: &Actuator, at: &Variables<T>) -> T {
    let profile = |profile: &Profile| {
        let (value, rate) = profile.at(at[TIME].value());
        (at[TIME].chain(value, rate), T::constant(rate))
    };
    match &actuator.command {
        Command::Effort(effort) => profile(effort).0,
        Command::Servo { kp, kd, target, .. } => {
            let sign = actuator.powertrain.feedback.map_or(1.0, |feedback| feedback.sign);
            let (target, target_rate) = profile(target);
            (target - at[MEASURED]) * (sign * kp) + (target_rate - at[MEASURED_RATE]) * (sign * kd)
        }
    }
}

/// A value between bounds: a number on the range between them, or the bound of the range below or beyond.
fn within<T: Real>(value: T, bound: T, range: u8) -> T {
    let range = match range {
        UNMONITORED if value.value() > bound.value() => 2,
        UNMONITORED if value.value() < -bound.value() => 0,
        UNMONITORED => 1,
        range => range,
    };
    match range {
        0 => -bound,
        1 => value,
        _ => bound,
    }
}

/// Range of a value between ± a bound: 0 below, 1 between, 2 beyond.
fn range_between(value: f64, bound: f64) -> u8 {
    u8::from(value >= -bound) + u8::from(value > bound)
}

/// Margin of a value to the ends of its range between ± a bound.
fn margin_between(value: f64, bound: f64, range: u8) -> f64 {
    match range {
        0 => -bound - value,
        1 => (bound - value).min(value + bound),
        _ => value - bound,
    }
}

/// The neighbouring range at the end that a value has reached.
fn next_between(value: f64, range: u8) -> u8 {
    match range {
        1 if value > 0.0 => 2,
        1 => 0,
        _ => 1,
    }
}

/// A drive with all ranges; they do not count beyond a discontinuity of its command.
struct InRange<'a> {
    actuator: &'a Actuator,
    drive: &'a DriveModel,
    ranges: Option<&'a [u8]>,
}

impl InRange<'_> {
    /// Range of the command.
    fn command_range(&self) -> u8 {
        self.ranges.map_or(UNMONITORED, |ranges| ranges[self.drive.actuator])
    }

    /// Range of a monitored quantity.
    fn range(&self, kind: Kind) -> u8 {
        let place = self.drive.kinds.iter().position(|other| *other == kind);
        self.ranges.zip(place).map_or(UNMONITORED, |(ranges, place)| ranges[self.drive.first_range + place])
    }

    fn motor(&self) -> Option<&Motor> {
        self.actuator.powertrain.motor.as_ref()
    }

    /// The command within the limit of the actuator.
    fn limited_command<T: Real>(&self, at: &Variables<T>) -> T {
        let command = command(self.actuator, at);
        let Some(limit) = self.actuator.limit else { return command };
        let range = self.command_range();
        let [lower, upper] = match range == UNMONITORED {
            true => [command.value(); 2],
            false => ends(self.actuator, range),
        };
        match () {
            () if lower >= limit => T::constant(limit),
            () if upper <= -limit => T::constant(-limit),
            () => command,
        }
    }

    /// Voltage less the back electromotive force.
    fn net_voltage<T: Real>(&self, motor: &Motor, voltage: T, at: &Variables<T>) -> T {
        voltage - at[RATE] * (motor.back_emf * self.actuator.powertrain.gear)
    }

    /// Voltage, current and rate of the current.
    fn electric<T: Real>(&self, motor: &Motor, at: &Variables<T>) -> [T; 3] {
        let voltage = self.limited_command(at);
        let net = self.net_voltage(motor, voltage, at);
        let (limit, range) = (motor.current_limit, self.range(Kind::Current));
        let Some(inductance) = motor.inductance else {
            let free = net * motor.resistance.recip();
            let current = limit.map_or(free, |limit| within(free, T::constant(limit), range));
            return [voltage, current, T::zero()];
        };
        let rate = (net - at[CURRENT] * motor.resistance) * inductance.recip();
        let Some(limit) = limit else { return [voltage, at[CURRENT], rate] };
        let held = T::constant(limit);
        match range {
            0 => [voltage, -held, T::zero()],
            2 => [voltage, held, T::zero()],
            UNMONITORED if at[CURRENT].value().abs() >= limit && rate.value() * at[CURRENT].value() > 0.0 => {
                [voltage, at[CURRENT], T::zero()]
            }
            _ => [voltage, at[CURRENT], rate],
        }
    }

    /// Torque of the motor.
    fn torque<T: Real>(&self, at: &Variables<T>) -> Forces<T> {
        if let Some(motor) = self.motor() {
            let [voltage, current, current_rate] = self.electric(motor, at);
            return Forces {
                torque: current * motor.torque_constant,
                current,
                voltage,
                current_rate,
                ..Forces::default()
            };
        }
        let command = self.limited_command(at);
        let Some(speed) = self.actuator.no_load_speed else { return Forces { torque: command, ..Forces::default() } };
        let range = self.command_range();
        let is_negative =
            if range == UNMONITORED { command.value() < 0.0 } else { ends(self.actuator, range)[1] <= 0.0 };
        let slope = self.actuator.powertrain.gear / speed;
        let decrease = at[RATE] * if is_negative { -slope } else { slope };
        Forces { torque: command - command * decrease, ..Forces::default() }
    }

    /// Bound of the loss: (1 − η) |n u|.
    fn loss_bound<T: Real>(&self, loss: &GearLoss, torque: T) -> T {
        let is_negative = match self.range(Kind::Torque) {
            UNMONITORED => torque.value() < 0.0,
            range => range == 0,
        };
        let factor = (1.0 - loss.efficiency) * self.actuator.powertrain.gear.abs();
        torque * if is_negative { -factor } else { factor }
    }

    /// All forces.
    fn forces<T: Real>(&self, at: &Variables<T>) -> Forces<T> {
        let forces = self.torque(at);
        let Some(loss) = &self.actuator.powertrain.loss else { return forces };
        let bound = self.loss_bound(loss, forces.torque);
        let loss = match &loss.bristle {
            None => {
                let (part, slope) = friction_coefficient(&loss.law(), at[RATE].value());
                bound * at[RATE].chain(part, slope)
            }
            Some(bristle) => within(bristle_effort(bristle, at), bound, self.range(Kind::Loss)),
        };
        Forces { loss, ..forces }
    }

    /// Magnitude against which the ends of the ranges of the torque are located.
    fn torque_scale(&self) -> f64 {
        let command = command_scale(self.actuator);
        let torque = self.motor().map_or(command, |motor| {
            let stall = command / motor.resistance;
            motor.torque_constant * motor.current_limit.map_or(stall, |limit| limit.min(stall))
        });
        torque.max(f64::MIN_POSITIVE)
    }

    /// Margin of a monitored quantity to the end of its range, without the overlap.
    fn margin(&self, kind: Kind, at: &Variables<f64>) -> f64 {
        let range = self.range(kind);
        if range == UNMONITORED {
            return f64::INFINITY;
        }
        match self.value_and_bound(kind, at) {
            Some((value, bound)) => margin_between(value, bound, range),
            // The current of an inductance stays at its limit as long as its rate would increase it.
            None => {
                let Some(motor) = self.motor() else { return f64::INFINITY };
                let limit = motor.current_limit.unwrap_or(f64::INFINITY);
                let held = if range == 0 { -limit } else { limit };
                let outward =
                    held.signum() * (self.net_voltage(motor, self.limited_command(at), at) / motor.resistance);
                outward - limit
            }
        }
    }

    /// A monitored quantity and the bound that ends its range; `None` for the current of an inductance at its limit.
    fn value_and_bound(&self, kind: Kind, at: &Variables<f64>) -> Option<(f64, f64)> {
        Some(match (kind, self.motor()) {
            (Kind::Current, Some(motor)) => {
                let limit = motor.current_limit.unwrap_or(f64::INFINITY);
                let value = match motor.inductance {
                    Some(_) if self.range(kind) != 1 => return None,
                    Some(_) => at[CURRENT],
                    None => self.net_voltage(motor, self.limited_command(at), at) / motor.resistance,
                };
                (value, limit)
            }
            (Kind::Current, None) => (0.0, f64::INFINITY),
            // Ranges 0 and 2 only.
            (Kind::Torque, _) => (self.torque(at).torque, 0.0),
            (Kind::Speed | Kind::Loss, _) => {
                let loss = self.actuator.powertrain.loss.as_ref()?;
                match &loss.bristle {
                    None => (at[RATE], loss.rate),
                    Some(bristle) => {
                        (bristle_effort(bristle, at), self.loss_bound(loss, self.torque(at).torque).max(0.0))
                    }
                }
            }
        })
    }

    /// Overlap of the ranges of a monitored quantity.
    fn overlap(&self, kind: Kind) -> f64 {
        let loss = self.actuator.powertrain.loss.as_ref();
        match kind {
            Kind::Current => {
                RANGE_MARGIN * self.motor().and_then(|motor| motor.current_limit).unwrap_or(f64::MIN_POSITIVE)
            }
            Kind::Torque => RANGE_MARGIN * self.torque_scale(),
            Kind::Speed => SPEED_MARGIN * loss.map_or(1.0, |loss| loss.rate),
            Kind::Loss => {
                let part = loss.map_or(0.0, |loss| 1.0 - loss.efficiency);
                (LOSS_MARGIN * part * self.torque_scale() * self.actuator.powertrain.gear.abs()).max(f64::MIN_POSITIVE)
            }
        }
    }

    /// Range of a monitored quantity in a state.
    fn range_of(&self, kind: Kind, at: &Variables<f64>) -> u8 {
        if kind == Kind::Torque {
            return if self.torque(at).torque < 0.0 { 0 } else { 2 };
        }
        match (kind, self.motor()) {
            (Kind::Current, Some(Motor { current_limit: Some(limit), inductance: Some(_), resistance, .. })) => {
                let motor = self.motor().expect("a motor");
                let net = self.net_voltage(motor, self.limited_command(at), at);
                match () {
                    () if at[CURRENT] >= *limit && net > resistance * limit => 2,
                    () if at[CURRENT] <= -limit && net < -resistance * limit => 0,
                    () => 1,
                }
            }
            _ => self.value_and_bound(kind, at).map_or(1, |(value, bound)| range_between(value, bound)),
        }
    }

    /// Range after the end of a range was located.
    fn range_after(&self, kind: Kind, at: &Variables<f64>) -> u8 {
        let old = self.range(kind);
        match (kind, self.value_and_bound(kind, at)) {
            (Kind::Torque, _) => 2 - old,
            (_, Some((value, _))) => next_between(value, old),
            (_, None) => 1,
        }
    }
}

/// Effort of a bristle before its bound.
fn bristle_effort<T: Real>(bristle: &Bristle, at: &Variables<T>) -> T {
    (at[BRISTLE] + at[RATE]) * bristle.damping_n_s_per_m
}

impl MechanismModel {
    fn in_ranges<'a>(&'a self, drive: &'a DriveModel, ranges: Option<&'a [u8]>) -> InRange<'a> {
        InRange { actuator: &self.mechanism.actuators[drive.actuator], drive, ranges }
    }

    /// A drive in a mode at time `t`. The command after a discontinuity, which a sample at its time contains, does not
    /// belong to the ranges of the mode.
    fn in_range<'a>(&'a self, drive: &'a DriveModel, t: f64, mode: &'a MechanismMode) -> InRange<'a> {
        self.in_ranges(drive, (t <= mode.times_s[1]).then_some(&mode.ranges.0[..]))
    }

    /// Variables of a drive in a state.
    fn drive_variables(&self, drive: &DriveModel, t: f64, v: &[f64], motions: &Motions<f64>) -> Variables<f64> {
        let motion = motions.combination(&self.mechanism.actuators[drive.actuator].on);
        let [measured, measured_rate] = match &drive.distance {
            Some(cable) => {
                let elongation = self.elongation(motions, cable);
                [elongation.value, elongation.rate]
            }
            None => [motion.coordinate, motion.rate],
        };
        let state = |index: Option<usize>| index.map_or(0.0, |index| v[index]);
        [t, measured, measured_rate, motion.rate, state(drive.charge), state(drive.bristle)]
    }

    /// The drive of an actuator, if it has a powertrain.
    pub(super) fn drive_of(&self, actuator: usize) -> Option<&DriveModel> {
        self.drives.iter().find(|drive| drive.actuator == actuator)
    }

    /// Sets the ranges of the drives that `is_chosen`. The range of a quantity follows from those before it.
    pub(super) fn set_drive_ranges(
        &self,
        (t, v): (f64, &[f64]),
        motions: &Motions<f64>,
        is_chosen: impl Fn(&Actuator) -> bool,
        ranges: &mut [u8],
    ) {
        for drive in &self.drives {
            let actuator = &self.mechanism.actuators[drive.actuator];
            if !is_chosen(actuator) {
                continue;
            }
            let at = self.drive_variables(drive, t, v, motions);
            ranges[drive.actuator] = range_of_value(actuator, command(actuator, &at));
            for (place, kind) in drive.kinds.iter().enumerate() {
                let range = self.in_ranges(drive, Some(ranges)).range_of(*kind, &at);
                ranges[drive.first_range + place] = range;
            }
        }
    }

    /// The drive and the quantity of a range beyond those of the commands.
    fn monitored(&self, range: usize) -> Option<(&DriveModel, Kind)> {
        let of = |drive: &&DriveModel| (drive.first_range..drive.first_range + drive.kinds.len()).contains(&range);
        let drive = self.drives.iter().find(of)?;
        Some((drive, drive.kinds[range - drive.first_range]))
    }

    /// Time in a mode, whatever the rounding error of the time as a coordinate.
    fn time_within(t: f64, mode: &MechanismMode) -> f64 {
        t.clamp(mode.times_s[0], mode.times_s[1])
    }

    /// Value of the command of a drive, if the actuator has one.
    pub(super) fn drive_command(
        &self,
        actuator: usize,
        (t, v): (f64, &[f64]),
        motions: &Motions<f64>,
        mode: &MechanismMode,
    ) -> Option<f64> {
        let drive = self.drive_of(actuator)?;
        let at = self.drive_variables(drive, Self::time_within(t, mode), v, motions);
        Some(command(&self.mechanism.actuators[actuator], &at))
    }

    /// Event function of a range beyond those of the commands.
    pub(super) fn drive_event(
        &self,
        range: usize,
        (t, v): (f64, &[f64]),
        motions: &Motions<f64>,
        mode: &MechanismMode,
    ) -> EventFunction {
        let Some((drive, kind)) = self.monitored(range) else { return EventFunction::INACTIVE };
        let at = self.drive_variables(drive, Self::time_within(t, mode), v, motions);
        let of = self.in_ranges(drive, Some(&mode.ranges.0));
        let value = of.margin(kind, &at) + of.overlap(kind);
        EventFunction { value, root_search: RootSearch::Smooth, ..EventFunction::INACTIVE }
    }

    /// Tolerance of [`MechanismModel::drive_event`].
    pub(super) fn drive_event_tolerance(&self, range: usize, mode: &MechanismMode) -> f64 {
        let Some((drive, kind)) = self.monitored(range) else { return 0.0 };
        RANGE_TOLERANCE * self.in_ranges(drive, Some(&mode.ranges.0)).overlap(kind)
    }

    /// Range after the end of a range beyond those of the commands was located.
    pub(super) fn drive_range_after(
        &self,
        range: usize,
        (t, v): (f64, &[f64]),
        motions: &Motions<f64>,
        mode: &MechanismMode,
    ) -> u8 {
        let Some((drive, kind)) = self.monitored(range) else { return UNMONITORED };
        let at = self.drive_variables(drive, Self::time_within(t, mode), v, motions);
        self.in_ranges(drive, Some(&mode.ranges.0)).range_after(kind, &at)
    }

    /// Forces of a drive in a mode.
    fn drive_forces<T: Real>(&self, drive: &DriveModel, mode: &MechanismMode, at: &Variables<T>) -> Forces<T> {
        self.in_range(drive, at[TIME].value(), mode).forces(at)
    }

    /// Adds the loads of all drives, and their powers.
    pub(super) fn add_drive_loads(
        &self,
        t: f64,
        v: &[f64],
        mode: &MechanismMode,
        motions: &Motions<f64>,
        (load, g): (&mut [f64], &mut [f64]),
    ) {
        for drive in &self.drives {
            let at = self.drive_variables(drive, t, v, motions);
            let forces = self.drive_forces(drive, mode, &at);
            let (actuator, (group, row)) = (&self.mechanism.actuators[drive.actuator], self.drive_row(drive));
            let gear = actuator.powertrain.gear;
            let of_group = &mut load[group.first..][..group.size()];
            row.add_load(motions, &actuator.on, gear * forces.torque - forces.loss, of_group);
            g[self.drive_work()] += gear * forces.torque * at[RATE];
            g[self.contact_work()] -= forces.loss * at[RATE];
            drive.loss_work.into_iter().for_each(|work| g[work] += forces.loss * at[RATE]);
            drive.charge.into_iter().for_each(|charge| load[charge] += forces.current_rate);
            if let Some((state, gain)) = self.bristle_of(drive) {
                load[state] += gain * forces.loss;
            }
        }
    }

    /// The group of a drive and the row of its coordinate.
    fn drive_row(&self, drive: &DriveModel) -> (&PlacedGroup, &Row) {
        let (group, place) = drive.place;
        let group = &self.groups[group];
        (group, &group.actuators[place].1)
    }

    /// The state of the bristle of a drive, and its rate per unit of the loss.
    fn bristle_of(&self, drive: &DriveModel) -> Option<(usize, f64)> {
        let bristle = self.mechanism.actuators[drive.actuator].powertrain.loss?.bristle?;
        Some((drive.bristle?, bristle.stretch_gain()))
    }

    /// Adds the derivatives of [`MechanismModel::add_drive_loads`].
    pub(super) fn add_drive_derivatives(
        &self,
        t: f64,
        v: &[f64],
        mode: &MechanismMode,
        (plain, motions): (&Motions<f64>, &[Motions<Lanes>]),
        sums: &mut Sums<'_>,
    ) {
        if self.drives.is_empty() {
            return;
        }
        let scratch = &mut *self.scratch.borrow_mut();
        let (rows, second) = (&mut scratch.drive, &mut scratch.second);
        for drive in &self.drives {
            let at = self.drive_variables(drive, t, v, plain);
            let variable = |k: usize| Dual::<VARIABLES>::variable(at[k], k);
            let forces = self.drive_forces(drive, mode, &std::array::from_fn(variable));
            let (actuator, (group, row)) = (&self.mechanism.actuators[drive.actuator], self.drive_row(drive));
            let (on, gear) = (&actuator.on, actuator.powertrain.gear);
            let (ideal, loss) = (forces.torque * gear, forces.loss);
            let effort = ideal - loss;
            rows.row.fill(0.0);
            rows.rate_q.fill(0.0);
            for (index, chunk) in Chunk::of_group(group.first, group.size()) {
                let (lanes, first) = (&motions[index], group.first + chunk.start);
                let rate = lanes.combination(on).rate;
                for lane in 0..chunk.count {
                    rows.rate_q[first + lane] = rate.grad[lane];
                }
                let entry = |i: usize| lanes.row_entry(on, i);
                sums.add_block(chunk, (&row.support, entry), Dual::constant(effort.value), [0.0; LANES]);
            }
            row.support.iter().for_each(|i| rows.row[group.first + i] = plain.row_entry(on, *i));
            match &drive.distance {
                Some(cable) => {
                    self.distance_derivatives(
                        (plain, motions),
                        cable,
                        v,
                        second,
                        (&mut rows.measured_row, &mut rows.measured_rate_q),
                    );
                }
                None => {
                    rows.measured_row.copy_from_slice(&rows.row);
                    rows.measured_rate_q.copy_from_slice(&rows.rate_q);
                }
            }
            let DriveRows { row: by_row, rate_q, measured_row, measured_rate_q } = &*rows;
            let rate_variable = variable(RATE);
            // Adds the derivatives of a number, times a factor, to rows over all coordinates and their rates.
            let add = |number: &Dual<VARIABLES>, factor: f64, by_q: &mut [f64], by_v: &mut [f64]| {
                let by = number.grad.map(|part| factor * part);
                for j in 0..by_row.len() {
                    by_q[j] +=
                        by[MEASURED] * measured_row[j] + by[MEASURED_RATE] * measured_rate_q[j] + by[RATE] * rate_q[j];
                    by_v[j] += by[MEASURED_RATE] * measured_row[j] + by[RATE] * by_row[j];
                }
                drive.charge.into_iter().for_each(|charge| by_v[charge] += by[CURRENT]);
                drive.bristle.into_iter().for_each(|state| by_v[state] += by[BRISTLE]);
            };
            for &i in &row.support {
                let (i, entry) = (group.first + i, by_row[group.first + i]);
                add(&effort, entry, &mut sums.load_q[i], &mut sums.load_v[i]);
                sums.load_t[i] += entry * effort.grad[TIME];
            }
            let mut add_power = |work: usize, power: Dual<VARIABLES>| {
                add(&power, 1.0, &mut sums.g_q[work], &mut sums.g_v[work]);
                sums.g_t[work] += power.grad[TIME];
            };
            add_power(self.drive_work(), ideal * rate_variable);
            add_power(self.contact_work(), -(loss * rate_variable));
            drive.loss_work.into_iter().for_each(|work| add_power(work, loss * rate_variable));
            let mut add_state = |state: usize, state_rate: Dual<VARIABLES>| {
                add(&state_rate, 1.0, &mut sums.load_q[state], &mut sums.load_v[state]);
                sums.load_t[state] += state_rate.grad[TIME];
            };
            drive.charge.into_iter().for_each(|charge| add_state(charge, forces.current_rate));
            if let Some((state, gain)) = self.bristle_of(drive) {
                add_state(state, loss * gain);
            }
        }
    }

    /// Effort of a drive on its coordinate.
    pub(super) fn drive_effort(
        &self,
        drive: &DriveModel,
        t: f64,
        (mode, v): (&MechanismMode, &[f64]),
        motions: &Motions<f64>,
    ) -> f64 {
        let at = self.drive_variables(drive, t, v, motions);
        let forces = self.drive_forces(drive, mode, &at);
        self.mechanism.actuators[drive.actuator].powertrain.gear * forces.torque - forces.loss
    }

    /// Reads all actuators with a powertrain, in the order of the actuators.
    pub fn read_drives(
        &self,
        t: f64,
        (q, v): StateRef<'_, Dynamic>,
        mode: &MechanismMode,
        read: impl FnOnce(&mut dyn Iterator<Item = (&'_ Powertrain, DriveReading)>),
    ) {
        if self.drives.is_empty() {
            return;
        }
        self.with_motions((q, v), |motions| {
            let of_drive = |drive: &DriveModel| {
                let at = self.drive_variables(drive, t, v, motions);
                let Forces { torque, current, voltage, .. } = self.drive_forces(drive, mode, &at);
                let [distance_m, distance_rate_m_s] = match drive.distance {
                    Some(_) => [at[MEASURED], at[MEASURED_RATE]],
                    None => [0.0; 2],
                };
                let (torque_n_m, current_a, voltage_v) = (torque, current, voltage);
                let loss_work = drive.loss_work;
                let reading =
                    DriveReading { torque_n_m, current_a, voltage_v, distance_m, distance_rate_m_s, loss_work };
                (&self.mechanism.actuators[drive.actuator].powertrain, reading)
            };
            read(&mut self.drives.iter().map(of_drive));
        });
    }

    /// Margins of all measured distances to the smallest one, with the index of the actuator and the rate.
    pub(super) fn distance_margins<'a>(
        &'a self,
        motions: &'a Motions<f64>,
    ) -> impl Iterator<Item = (usize, [f64; 2])> + 'a {
        self.drives.iter().filter_map(move |drive| {
            let elongation = self.elongation(motions, drive.distance.as_ref()?);
            Some((drive.actuator, [elongation.value - MIN_DISTANCE_M, elongation.rate]))
        })
    }

    /// The cables between points whose distance is measured.
    pub(super) fn measured_distances(&self) -> impl Iterator<Item = &Cable> {
        self.drives.iter().filter_map(|drive| drive.distance.as_ref())
    }
}
