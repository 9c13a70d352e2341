//! The scenes of the work–precision diagrams, with the kernels that phalanx uses for them.

use std::cell::{Cell, RefCell};

use phalanx::analytic::mechanism::MechanismModel;
use phalanx::analytic::{FingerMode, Model};
use phalanx::integrator::{Hybrid, Linearised, State, System};
use phalanx::mechanism::assemble;
use phalanx::scene::{Integrator, Profile, Scene, parse_any};
use phalanx::shape::max_radius;

use crate::equations::{Equations, InitialValueProblem};
use crate::support::problem::TORQUE_STEP;

/// Coordinates of a gripper with a free object. The time of a moving palm follows, then bristle states.
const GRIPPER: usize = 7;

/// A scene whose torques are multiplied by a factor near 1.
pub struct Case<M: Hybrid> {
    pub kernel: M,
    pub start: State<M::Layout>,
    /// The laws without events.
    pub clamped: M::Mode,
    pub duration_s: f64,
    /// Settings of an everyday run.
    pub everyday: Integrator,
    /// Number of coordinates on which the equations depend. They are the first ones.
    pub coordinate_count: usize,
    /// Indices of the rates: those of the coordinates, then the bristle states.
    rates: Vec<usize>,
    /// Index of time among the coordinates.
    time: Option<usize>,
    /// Radius of the object, whose position follows the four angles of the fingers.
    pub object_radius_m: Option<f64>,
}

/// Reads a scene and multiplies its torques by 1 + i · 1e-9.
fn scene(text: &str, member: usize) -> Scene {
    let mut scene = parse_any(text, "scene").unwrap_or_else(|error| panic!("the scene cannot be loaded: {error}"));
    for finger in &mut scene.hand.fingers {
        let factor = 1.0 + member as f64 * TORQUE_STEP;
        match &mut finger.motor.actuation {
            Profile::Constant { value } => *value *= factor,
            Profile::Table { points, .. } => points.iter_mut().for_each(|(_, value)| *value *= factor),
            other => panic!("no factor for {other:?}"),
        }
    }
    scene
}

pub fn finger(member: usize) -> Case<Model> {
    let scene = scene(include_str!("../../../scenes/experiment-95.toml"), member);
    Case {
        kernel: Model::new(&scene.hand),
        start: Model::start(&scene.hand),
        clamped: FingerMode::CLAMPED,
        duration_s: scene.duration_s,
        everyday: scene.integrator,
        coordinate_count: 2,
        rates: vec![0, 1],
        time: None,
        object_radius_m: None,
    }
}

fn gripper_of(scene: &Scene) -> Case<MechanismModel> {
    let mechanism = scene.mechanism().unwrap_or_else(|error| panic!("{error}"));
    let placed = assemble(&mechanism).unwrap_or_else(|error| panic!("{error}"));
    let kernel = MechanismModel::new(&mechanism, (&placed.poses, &placed.rates)).unwrap_or_else(|error| panic!("{error}"));
    let start = kernel.start();
    let mut clamped = kernel.mode_at(0.0, &start.q, &start.v);
    (0..kernel.event_count()).for_each(|event| kernel.clamp_law(event, &mut clamped));
    let object = scene.object().unwrap_or_else(|| panic!("the scene has no object"));
    Case {
        start,
        clamped,
        duration_s: scene.duration_s,
        everyday: scene.integrator,
        coordinate_count: GRIPPER,
        rates: (0..GRIPPER).chain(kernel.second_order_count()..kernel.coordinate_count()).collect(),
        time: scene.hand.palm_motion.is_some().then_some(GRIPPER),
        object_radius_m: Some(max_radius(&object.shape)),
        kernel,
    }
}

pub fn gripper(member: usize) -> Case<MechanismModel> {
    gripper_of(&scene(include_str!("../../../scenes/gripper/design-95.toml"), member))
}

pub fn cycle(member: usize) -> Case<MechanismModel> {
    gripper_of(&scene(include_str!("../../../scenes/gripper/cycle.toml"), member))
}

impl<M: Hybrid> CaseEquations<'_, M> {
    /// The initial value problem of the published solvers.
    pub fn problem(&self) -> InitialValueProblem<'_, Self> {
        let Case { kernel, start, duration_s, coordinate_count, rates, .. } = self.case;
        let rates = rates.iter().map(|index| start.v[*index]);
        let start = start.q.as_ref()[..*coordinate_count].iter().copied().chain(rates).collect();
        let mut stops = vec![kernel.next_discontinuity(0.0)];
        while stops[stops.len() - 1] < *duration_s {
            stops.push(kernel.next_discontinuity(stops[stops.len() - 1]));
        }
        let last = stops.len() - 1;
        stops[last] = *duration_s;
        InitialValueProblem { equations: self, start, stops }
    }
}

/// The equations of a case with clamped laws; counts evaluations.
pub struct CaseEquations<'a, M: Hybrid> {
    case: &'a Case<M>,
    memory: RefCell<(State<M::Layout>, Linearised<M::Layout>)>,
    latest_time: Cell<f64>,
    pub rhs: Cell<u64>,
    pub jacobians: Cell<u64>,
}

impl<'a, M: Hybrid> CaseEquations<'a, M> {
    pub fn new(case: &'a Case<M>) -> Self {
        let layout = case.kernel.layout();
        let memory = RefCell::new((State::zero(layout), Linearised::zero(layout)));
        Self { case, memory, latest_time: Cell::new(f64::INFINITY), rhs: Cell::new(0), jacobians: Cell::new(0) }
    }

    /// Writes coordinates and rates of the kernel, and returns the time.
    fn set_state(&self, t: f64, y: &[f64], State { q, v, .. }: &mut State<M::Layout>) -> f64 {
        let Case { coordinate_count, rates, time, .. } = self.case;
        let t = t.min(self.latest_time.get());
        q.as_mut()[..*coordinate_count].copy_from_slice(&y[..*coordinate_count]);
        for (index, rate) in rates.iter().zip(&y[*coordinate_count..]) {
            v[*index] = *rate;
        }
        time.iter().for_each(|time| (q[*time], v[*time]) = (t, 1.0));
        t
    }
}

impl<M: Hybrid> Equations for CaseEquations<'_, M> {
    fn coordinate_count(&self) -> usize {
        self.case.coordinate_count
    }

    fn rates(&self, t: f64, y: &[f64], out: &mut [f64]) {
        self.rhs.set(self.rhs.get() + 1);
        let (state, Linearised { rates: found, .. }) = &mut *self.memory.borrow_mut();
        let t = self.set_state(t, y, state);
        let State { q, v, .. } = state;
        self.case.kernel.rates(t, q, v, &self.case.clamped, found);
        let (coordinates, rates) = out.split_at_mut(self.case.coordinate_count);
        coordinates.copy_from_slice(&v.as_ref()[..coordinates.len()]);
        for (rate, index) in rates.iter_mut().zip(&self.case.rates) {
            *rate = found.a[*index];
        }
    }

    fn jacobian(&self, t: f64, y: &[f64], columns: &mut [f64]) {
        self.jacobians.set(self.jacobians.get() + 1);
        let (state, derivatives) = &mut *self.memory.borrow_mut();
        let t = self.set_state(t, y, state);
        self.case.kernel.linearise(t, &state.q, &state.v, &self.case.clamped, derivatives);
        let (size, count, rates) = (y.len(), self.case.coordinate_count, &self.case.rates);
        columns.fill(0.0);
        for (row, i) in rates.iter().enumerate() {
            for k in 0..count {
                columns[k * size + count + row] = derivatives.a_q[*i][k];
            }
            for (column, k) in rates.iter().enumerate() {
                columns[(count + column) * size + count + row] = derivatives.a_v[*i][*k];
            }
        }
        for k in 0..count {
            columns[(count + k) * size + k] = 1.0;
        }
    }

    fn set_latest_time(&self, t: f64) {
        self.latest_time.set(t);
    }
}
