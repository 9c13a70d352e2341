//! Data of actuators with a powertrain: the places of their states among those of the model, and their ranges.

use super::cable::Cable;
use super::contacts::FrictionStates;
use super::group::PlacedGroup;
use crate::law::FrictionKind;
use crate::mechanism::{Actuator, DistanceFeedback, Mechanism, PathElement, PointId, Tendon};

/// A quantity whose range is monitored. The range of the command of each actuator precedes these.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// The current, between its limits.
    Current,
    /// The torque of the motor, which changes the sign of the loss.
    Torque,
    /// The rate of a gear without a bristle, within and beyond that of its law.
    Speed,
    /// The loss of a gear with a bristle, between its bounds.
    Loss,
}

/// An actuator with a powertrain.
#[derive(Clone, Debug)]
pub(super) struct DriveModel {
    /// Index of the actuator.
    pub actuator: usize,
    /// Index of its group, and its place among the actuators of the group.
    pub place: (usize, usize),
    /// The cable between the points whose distance is measured.
    pub distance: Option<Cable>,
    /// Index of the charge of the motor among the coordinates.
    pub charge: Option<usize>,
    /// Index of the state of the bristle.
    pub bristle: Option<usize>,
    /// Index of the work of the gear among the quadratures.
    pub loss_work: Option<usize>,
    /// Monitored quantities, and the index of the first one among all ranges.
    pub kinds: Vec<Kind>,
    pub first_range: usize,
}

/// Memory for the derivatives of a drive by all coordinates: of the coordinate, its rate, the distance and its rate.
#[derive(Clone, Debug, Default)]
pub(super) struct DriveRows {
    pub row: Vec<f64>,
    pub rate_q: Vec<f64>,
    pub measured_row: Vec<f64>,
    pub measured_rate_q: Vec<f64>,
}

impl DriveRows {
    pub fn new(count: usize) -> Self {
        let zero = || vec![0.0; count];
        Self { row: zero(), rate_q: zero(), measured_row: zero(), measured_rate_q: zero() }
    }
}

impl DriveModel {
    /// Returns the cable between the points of a feedback.
    fn cable(mechanism: &Mechanism, feedback: &DistanceFeedback) -> Cable {
        let element = |id: PointId| PathElement {
            body: id.body,
            point_m: mechanism.point(id).at_m,
            radius_m: 0.0,
            side: 1.0,
            friction: None,
        };
        Cable::new(&Tendon {
            name: String::new(),
            path: feedback.points.map(element).into(),
            joints: Vec::new(),
            far_joints: Vec::new(),
            is_reversed: false,
            stiffness_n_per_m: 0.0,
            damping_n_s_per_m: 0.0,
            rest_m: 0.0,
            actuator: None,
        })
    }

    pub fn has_loss(&self) -> bool {
        self.loss_work.is_some()
    }

    pub fn has_distance(&self) -> bool {
        self.distance.is_some()
    }

    /// Number of ranges beyond that of the command.
    pub fn range_count(&self) -> usize {
        self.kinds.len()
    }

    /// Whether an event of the drive depends on time.
    pub fn depends_on_time(actuator: &Actuator) -> bool {
        let powertrain = &actuator.powertrain;
        powertrain.loss.is_some() || powertrain.motor.is_some_and(|motor| motor.current_limit.is_some())
    }
}

/// The drives of a mechanism. Adds the states of their bristles; `first_charge` is the index of the first charge.
pub(super) fn drives(
    mechanism: &Mechanism,
    groups: &[PlacedGroup],
    first_charge: usize,
    first_work: usize,
    states: &mut FrictionStates,
) -> Vec<DriveModel> {
    let (mut charge, mut work, mut range) = (first_charge, first_work, mechanism.actuators.len());
    let take = |next: &mut usize, is_needed: bool| is_needed.then(|| std::mem::replace(next, *next + 1));
    let place_of = |actuator: usize| {
        groups.iter().enumerate().find_map(|(group, placed)| {
            Some((group, placed.actuators.iter().position(|(index, _)| *index == actuator)?))
        })
    };
    let mut all = Vec::new();
    for (index, actuator) in mechanism.actuators.iter().enumerate() {
        let powertrain = &actuator.powertrain;
        let Some(place) = place_of(index).filter(|_| !powertrain.is_direct()) else { continue };
        let bristle = powertrain.loss.and_then(|loss| loss.bristle);
        let mut kinds = Vec::new();
        if powertrain.motor.is_some_and(|motor| motor.current_limit.is_some()) {
            kinds.push(Kind::Current);
        }
        if powertrain.loss.is_some() {
            kinds.extend([Kind::Torque, if bristle.is_some() { Kind::Loss } else { Kind::Speed }]);
        }
        all.push(DriveModel {
            actuator: index,
            place,
            distance: powertrain.feedback.map(|feedback| DriveModel::cable(mechanism, &feedback)),
            charge: take(&mut charge, powertrain.has_charge()),
            bristle: states.add(bristle.map(FrictionKind::Bristle)),
            loss_work: take(&mut work, powertrain.loss.is_some()),
            first_range: range,
            kinds: kinds.clone(),
        });
        range += kinds.len();
    }
    all
}

/// Number of charges of a mechanism.
pub(super) fn charge_count(mechanism: &Mechanism) -> usize {
    mechanism.actuators.iter().filter(|actuator| actuator.powertrain.has_charge()).count()
}
