//! Constant data of a mechanism: groups, contacts, the layout of its coordinates, and its start.

use std::cell::{RefCell, RefMut};

use super::actuator::{Ranges, range};
use super::body_bounds::MechanismBounds;
use super::cable::Cable;
use super::conditioning::conditioned_groups;
use super::contacts::{Contact, FrictionStates, contacts};
use super::drive_model::{DriveModel, DriveRows, charge_count, drives};
use super::factor::Factor;
use super::free::{FreeBody, center_frame, free_body, is_round};
use super::group::{PlacedGroup, start_of};
use super::motion::{LANES, Lanes, Motions, Part, Support};
use super::nearest::Feature;
use super::palm_frame::{exchange_ground, palm_of_frame, place_in_frame};
use super::strands::Strands;
use crate::analytic::ContactState;
use crate::analytic::contact::{ContactMode, EventTolerances, Mode, StateRef};
use crate::integrator::{Dynamic, Layout, Linearised, State};
use crate::law::FrictionKind;
use crate::mechanism::structure::{Group, StructureError, find_groups};
use crate::mechanism::tendon::{Bend, center_in, settled_path};
use crate::mechanism::{Actuator, Body, Mechanism, Pose, SpringKind, Tendon, coordinate_in};
use crate::numeric::plane::scale_by;
use crate::scene::{PalmMotion, Profile};
use std::borrow::Cow;
use std::ops::Index;

/// Touch-downs are located to a part of δ_max, lift-off and reload to a force without visible effect on the motion.
const EVENT_TOLERANCES: EventTolerances = EventTolerances { depth_fraction: 1e-7, force: 1e-8 };

/// Branches of the contact laws, features of the faces, ranges of the actuators, and the interval of time in which the
/// mode is valid.
#[derive(Debug, PartialEq)]
pub struct MechanismMode {
    pub contacts: Mode<Vec<ContactMode>>,
    /// Feature of the face that each contact with a force is on; otherwise the nearest one.
    pub(super) features: Vec<Option<Feature>>,
    pub(super) ranges: Ranges,
    /// Turns of the lines between pivots of dyads since the start, in counts.
    pub(super) counts: Vec<i32>,
    /// Coordinates of all joints at the last accepted state, near which Newton's method places bodies; empty if it places none.
    pub(super) near: Vec<f64>,
    /// How cables pass their path elements, cable by cable.
    pub(super) bends: Vec<Bend>,
    /// Whether event functions monitor the paths of cables.
    pub(super) monitors_paths: bool,
    /// Whether a cable has come round the back of a pulley, where the model ends.
    pub(super) is_blocked: bool,
    /// First and last time between two discontinuities of commands and prescribed motions. A step sees the commands between
    /// them only, whatever the rounding error of the time as a coordinate.
    pub(super) times_s: [f64; 2],
}

impl Clone for MechanismMode {
    fn clone(&self) -> Self {
        Self {
            contacts: self.contacts.clone(),
            features: self.features.clone(),
            ranges: self.ranges.clone(),
            counts: self.counts.clone(),
            near: self.near.clone(),
            bends: self.bends.clone(),
            monitors_paths: self.monitors_paths,
            is_blocked: self.is_blocked,
            times_s: self.times_s,
        }
    }

    /// Without allocation.
    fn clone_from(&mut self, other: &Self) {
        self.contacts.contacts.clone_from(&other.contacts.contacts);
        self.features.clone_from(&other.features);
        self.ranges.0.clone_from(&other.ranges.0);
        self.counts.clone_from(&other.counts);
        self.near.clone_from(&other.near);
        self.bends.clone_from(&other.bends);
        (self.monitors_paths, self.is_blocked) = (other.monitors_paths, other.is_blocked);
        self.times_s = other.times_s;
    }
}

impl Index<usize> for MechanismMode {
    type Output = ContactState;

    fn index(&self, index: usize) -> &ContactState {
        &self.contacts[index]
    }
}

/// Coordinates on which the pose of a body depends. Those of a free body are its pose.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Span {
    pub first: usize,
    pub size: usize,
    pub is_free: bool,
}

/// Motions at the last state, with and without derivatives, kept to avoid allocation and repetition.
#[derive(Clone, Debug)]
struct Workspace {
    /// Coordinates and rates of that state, if there is one.
    q: Vec<f64>,
    v: Vec<f64>,
    has_state: bool,
    /// Poses and rates of those groups that are evaluated, with derivatives by the coordinates and bias accelerations of all if
    /// `has_columns`.
    motions: Motions<f64>,
    is_evaluated: Vec<bool>,
    has_columns: bool,
    /// Whether the motions contain all angles, see [`MechanismModel::with_angles`].
    has_angles: bool,
    /// Factors of the mass matrices of all groups, in this state if `has_factors`.
    factors: Vec<Factor>,
    has_factors: bool,
    /// Motions with derivatives by the coordinates of each group, [`LANES`] of them at a time.
    with_derivatives: Vec<Motions<Lanes>>,
    bounds: MechanismBounds,
}

/// Memory of evaluations within a state.
#[derive(Clone, Debug)]
pub(super) struct Scratch {
    /// Derivative of the length of a cable, or of a gap, with respect to the coordinates.
    pub row: Vec<f64>,
    /// Accelerations per unit of a normal force.
    pub response: Vec<f64>,
    /// Second derivatives of the length of a cable or of a measured distance, stored in place of the derivatives of
    /// loads. Without them it has no entries.
    pub second: Linearised<Dynamic>,
    /// Derivatives of the variables of a drive. Without drives they have no entries.
    pub drive: DriveRows,
    /// Straight parts of a cable with friction, and their derivatives.
    pub strands: Strands,
}

/// The analytic model of a mechanism.
///
/// Its coordinates are the independent coordinates of all groups. They are followed by the first-order states: the
/// internal states of friction and brakes, and time if an event of an actuator depends on it and no group has it as a
/// coordinate. First-order states are stored among the rates; nothing depends on the coordinates at their indices.
#[derive(Clone, Debug)]
pub struct MechanismModel {
    pub(super) mechanism: Mechanism,
    /// Groups of bodies with joints or prescribed motions.
    pub(super) groups: Vec<PlacedGroup>,
    pub(super) free_bodies: Vec<FreeBody>,
    /// Coordinates of each body.
    pub(super) spans: Vec<Span>,
    /// Group of each body; `None` of a free body.
    pub(super) group_of: Vec<Option<usize>>,
    /// Origin of the reported frame of each body, in its frame here.
    pub(super) reported_origins: Vec<[f64; 2]>,
    /// Dyad of each joint whose coordinate is evaluated on demand: its group and placement.
    dyad_of: Vec<Option<(usize, usize)>>,
    /// All contacts in the order of [`Mechanism::point_contacts`], of [`Mechanism::limits`], of the tendons, of friction in
    /// joints, then of friction of cables.
    pub(super) contacts: Vec<Contact>,
    pub(super) cables: Vec<Cable>,
    /// Actuators with a powertrain.
    pub(super) drives: Vec<DriveModel>,
    /// Number of ranges: one for the command of each actuator, then those of the drives.
    pub(super) range_count: usize,
    /// For each limit of a sum, the coordinates of its group on which it may depend.
    pub(super) sum_supports: Vec<Vec<usize>>,
    /// Path elements with event functions, by cable and element: pulleys, and eyelets with friction.
    pub(super) monitored: Vec<[usize; 2]>,
    pub(super) friction_states: Vec<(usize, FrictionKind)>,
    /// Index of the bristle state of the brake of each actuator.
    pub(super) brake_bristles: Vec<Option<usize>>,
    /// Index of time among the coordinates, if bodies have prescribed motion.
    pub(super) time_index: Option<usize>,
    /// Index of time among the first-order states, if an event of an actuator depends on it and it is no coordinate.
    clock_index: Option<usize>,
    /// Number of coordinates of all groups; first-order states follow.
    second_order: usize,
    /// The group of the bodies with prescribed motion, whose first coordinate is time.
    pub(super) prescribed: Option<usize>,
    /// The moving palm, relative to which states are reported, if the equations are written in the frame of the world.
    pub(super) palm: Option<usize>,
    /// The body that stands for the world, and the motion of the palm, if the equations are written in the frame of the palm.
    pub(super) world: Option<(usize, PalmMotion)>,
    /// Gravity in the world; that of the mechanism is in the axes of its frame at the start.
    pub(super) world_gravity_m_s2: [f64; 2],
    /// Whether forces affect x, y and θ of each body.
    pub(super) moves_by_forces: Vec<[bool; 3]>,
    used_coordinates: usize,
    pub(super) event_tolerances: EventTolerances,
    /// Numbers of coordinates, with a place for time, and of quadratures.
    layout: Dynamic,
    /// Motions at the last state of the equations, and at the last state that was sampled within a step.
    workspaces: [RefCell<Workspace>; 2],
    pub(super) scratch: RefCell<Scratch>,
    start: Vec<(f64, f64)>,
    near_at_start: Vec<f64>,
}

impl Workspace {
    /// Whether the stored motions were evaluated at the state (`q`, `v`).
    #[inline(always)]
    fn is_at(&self, (q, v): StateRef<'_, Dynamic>) -> bool {
        self.has_state && has_bits_of(&self.q, q) && has_bits_of(&self.v, v)
    }

    /// Memory for the states of these groups.
    fn new(mechanism: &Mechanism, groups: &[PlacedGroup], layout: Dynamic) -> Self {
        let mut motions = Motions::new(mechanism);
        motions.counts = vec![0; groups.last().map_or(0, |placed| placed.counts().end)];
        groups.iter().for_each(|group| group.add_supports(mechanism, &mut motions));
        // The ground does not move with any coordinate.
        let (largest, ground) = (groups.iter().map(PlacedGroup::size).max().unwrap_or(0), mechanism.bodies.len());
        motions.body_supports[ground] = Support { first: motions.columns.len(), coordinates: Vec::new() };
        motions.columns.resize(motions.columns.len() + largest, [0.0; 3]);
        let mut with_derivatives = Motions::new(mechanism);
        with_derivatives.reserve(&motions);
        Self {
            q: layout.vector(0.0),
            v: layout.vector(0.0),
            has_state: false,
            motions,
            is_evaluated: vec![false; groups.len()],
            has_columns: false,
            has_angles: false,
            factors: groups.iter().map(|group| Factor::new(group.size(), group.has_prescribed())).collect(),
            has_factors: false,
            with_derivatives: vec![with_derivatives; largest.div_ceil(LANES)],
            bounds: MechanismBounds::new(mechanism),
        }
    }
}

/// The mechanism in the frame in which its equations are written: that of its moving palm, if it has one.
fn in_frame(mechanism: &Mechanism) -> Cow<'_, Mechanism> {
    match palm_of_frame(mechanism) {
        None => Cow::Borrowed(mechanism),
        Some(palm) => {
            let mut mechanism = mechanism.clone();
            exchange_ground(&mut mechanism, palm);
            Cow::Owned(mechanism)
        }
    }
}

/// Coordinates of all joints in poses of the bodies; none if Newton's method places no bodies.
fn near_at(mechanism: &Mechanism, groups: &[PlacedGroup], poses: &[Pose]) -> Vec<f64> {
    match groups.iter().any(|placed| placed.group.has_assur()) {
        true => mechanism.joints.iter().map(|joint| coordinate_in(joint, poses)).collect(),
        false => Vec::new(),
    }
}

/// Whether any cable has friction.
fn has_cable_friction(mechanism: &Mechanism) -> bool {
    mechanism.tendons.iter().any(Tendon::has_friction)
}

/// How a cable passes its path at rest in these poses.
fn settled_path_in(tendon: &Tendon, poses: &[Pose]) -> Vec<Bend> {
    settled_path(&tendon.path, |element| center_in(element, poses))
}

/// Pulleys, and eyelets with friction: where a cable lifts off and returns, and where its turn has a kink.
fn monitored(cables: &[Cable]) -> Vec<[usize; 2]> {
    let of_cable = |(index, cable): (usize, &Cable)| {
        let elements = cable.tendon.path.iter().enumerate();
        let all = elements.filter(|(_, element)| element.is_pulley() || element.friction.is_some());
        all.map(|(element, _)| [index, element]).collect::<Vec<_>>()
    };
    cables.iter().enumerate().flat_map(of_cable).collect()
}

/// Lengths of vectors are multiples of this number, so that loops over them need no remainder.
const VECTOR_UNIT: usize = 4;

/// Whether two lists have the same bits. Different states nearly always differ in the first coordinate; the others are
/// compared together, which the compiler can vectorise.
fn has_bits_of(a: &[f64], b: &[f64]) -> bool {
    let difference = |(a, b): (&f64, &f64)| a.to_bits() ^ b.to_bits();
    a.iter().zip(b).take(1).all(|of| difference(of) == 0)
        && a.iter().zip(b).fold(0, |all, of| all | difference(of)) == 0
}

/// Whether an event of an actuator depends on time.
fn depends_on_time(mechanism: &Mechanism) -> bool {
    mechanism.actuators.iter().any(|actuator| {
        let is_constant = actuator.command.profile().next_discontinuity(f64::NEG_INFINITY).is_infinite();
        let has_ranges = actuator.limit.is_some() || actuator.no_load_speed.is_some();
        !is_constant && (has_ranges || DriveModel::depends_on_time(actuator))
    })
}

/// Sets the poses of all bodies at the start, which those that do not move or rotate keep, and removes inertia without effect.
fn fix_bodies(mechanism: &mut Mechanism, poses: &[Pose]) {
    for (body, pose) in mechanism.bodies.iter_mut().zip(poses) {
        if body.motion.is_none() {
            body.pose = *pose;
        }
        let [moves, _, rotates] = body.moves_by_forces();
        body.mass_kg *= f64::from(moves);
        body.inertia_kg_m2 = if rotates { body.inertia_kg_m2 } else { 0.0 };
    }
}

/// The coordinates of all groups, in the order of the groups.
struct Coordinates {
    groups: Vec<PlacedGroup>,
    free_bodies: Vec<FreeBody>,
    spans: Vec<Span>,
    dyad_of: Vec<Option<(usize, usize)>>,
    /// Their values and rates at the start.
    start: Vec<(f64, f64)>,
}

impl Coordinates {
    /// Places the groups in these poses, whose bodies have the origins `reported_origins` in samples.
    fn of_groups(
        mechanism: &Mechanism,
        found: Vec<Group>,
        (poses, rates): (&[Pose], &[Pose]),
        (is_in_palm_frame, reported_origins): (bool, &[[f64; 2]]),
    ) -> Self {
        let spans = vec![Span::default(); mechanism.bodies.len()];
        let dyad_of = vec![None; mechanism.joints.len()];
        let mut all = Self { groups: Vec::new(), free_bodies: Vec::new(), spans, dyad_of, start: Vec::new() };
        for group in found {
            let (first, size, free) = (all.start.len(), group.coordinates.len(), free_body(&group));
            group.bodies.iter().for_each(|body| all.spans[*body] = Span { first, size, is_free: free.is_some() });
            all.start.extend(start_of(&group, mechanism, (poses, rates)));
            if let Some((body, axes)) = free {
                let of = &mechanism.bodies[body];
                let (mobility, weight) = (1.0 / of.mass_kg, scale_by(mechanism.gravity_m_s2, of.mass_kg));
                let mobility = [mobility, mobility, 1.0 / of.inertia_kg_m2];
                let is_round = reported_origins[body] == [0.0; 2] && is_round(mechanism, body);
                let angle_rad = poses[body][2];
                all.free_bodies.push(FreeBody { body, first, axes, is_round, angle_rad, mobility, weight });
                continue;
            }
            let counts = all.groups.last().map_or(0, |placed| placed.counts().end);
            let mut placed = PlacedGroup::new(mechanism, group, (first, counts), poses);
            placed.is_in_palm_frame = is_in_palm_frame;
            for (placement, joint) in placed.joints_on_demand(mechanism) {
                all.dyad_of[joint] = Some((all.groups.len(), placement));
            }
            all.groups.push(placed);
        }
        all
    }
}

impl MechanismModel {
    /// Builds the model from the assembled poses and rates of all bodies.
    ///
    /// # Errors
    /// Returns an error for a mechanism that cannot be written in independent coordinates.
    pub fn new(mechanism: &Mechanism, (poses, rates): (&[Pose], &[Pose])) -> Result<Self, StructureError> {
        let world = palm_of_frame(mechanism).zip(mechanism.palm().map(|(_, motion)| motion.clone()));
        let world_gravity_m_s2 = mechanism.gravity_m_s2;
        let (mut mechanism, mut poses, mut rates) = (in_frame(mechanism).into_owned(), poses.to_vec(), rates.to_vec());
        if let Some((palm, motion)) = &world {
            place_in_frame(&mut mechanism, (*palm, motion), (&mut poses, &mut rates));
        }
        let found = find_groups(&mechanism)?;
        let mut reported_origins = vec![[0.0; 2]; mechanism.bodies.len()];
        for (body, origin) in reported_origins.iter_mut().enumerate() {
            if mechanism.bodies[body].motion.is_none() {
                *origin = scale_by(mechanism.bodies[body].com_m, -1.0);
                center_frame(&mut mechanism, body, (&mut poses, &mut rates));
            }
        }
        let (poses, rates) = (&poses[..], &rates[..]);
        let moves_by_forces = mechanism.bodies.iter().map(Body::moves_by_forces).collect();
        fix_bodies(&mut mechanism, poses);
        let found = conditioned_groups(&mechanism, found, poses);
        let Coordinates { groups, free_bodies, spans, dyad_of, start } =
            Coordinates::of_groups(&mechanism, found, (poses, rates), (world.is_some(), &reported_origins));
        // A charge is a coordinate of second order, whose rate is a current.
        let charges = charge_count(&mechanism);
        let second_order = start.len() + charges;
        let prescribed = groups.iter().position(PlacedGroup::has_prescribed);
        let group_of = |body| groups.iter().position(|placed| placed.group.bodies.contains(&body));
        let group_of: Vec<Option<usize>> = (0..mechanism.bodies.len()).map(group_of).collect();
        let mut states = FrictionStates::after(second_order);
        let mut cables = Cable::all(&mechanism.tendons);
        let contacts = contacts(&mechanism, &mut cables, &mut states);
        let brakes = mechanism.actuators.iter().map(|actuator| actuator.brake.and_then(|brake| brake.bristle));
        let brake_bristles = brakes.map(|bristle| states.add(bristle.map(FrictionKind::Bristle))).collect();
        let first_work = contacts.len() + 2 + usize::from(has_cable_friction(&mechanism));
        let drives = drives(&mechanism, &groups, start.len(), first_work, &mut states);
        let losses = drives.iter().filter(|drive| drive.has_loss()).count();
        let range_count = mechanism.actuators.len() + drives.iter().map(DriveModel::range_count).sum::<usize>();
        let sum_supports = mechanism.sum_limits.iter().map(|limit| {
            let (joint, _) = limit.on.terms[0];
            let body = mechanism.joints[joint].bodies[1].or(mechanism.joints[joint].bodies[0]);
            (0..body.map_or(0, |body| spans[body].size)).collect()
        });
        let sum_supports = sum_supports.collect();
        let next = states.next();
        let time_index = prescribed.map(|group: usize| groups[group].first);
        let clock_index = (time_index.is_none() && depends_on_time(&mechanism)).then_some(next);
        let palm = mechanism.palm().map(|(body, _)| body).filter(|_| world.is_none());
        let coordinate_count = next + usize::from(clock_index.is_some());
        // A new input of an actuator can depend on time.
        let may_have_clock = time_index.is_none() && !mechanism.actuators.is_empty();
        let layout = Dynamic {
            coordinates: (next + usize::from(may_have_clock)).next_multiple_of(VECTOR_UNIT),
            quadratures: (first_work + losses).next_multiple_of(VECTOR_UNIT),
        };
        let near_at_start = near_at(&mechanism, &groups, poses);
        let bends: Vec<Bend> = mechanism.tendons.iter().flat_map(|tendon| settled_path_in(tendon, poses)).collect();
        let workspaces = [(); 2].map(|()| {
            let mut workspace = Workspace::new(&mechanism, &groups, layout);
            workspace.motions.near.clone_from(&near_at_start);
            workspace.motions.bends.clone_from(&bends);
            RefCell::new(workspace)
        });
        let has_cables = !cables.is_empty() || drives.iter().any(DriveModel::has_distance);
        let of_cables = if has_cables { layout } else { Dynamic { coordinates: 0, quadratures: 0 } };
        let scratch = Scratch {
            row: layout.vector(0.0),
            response: layout.vector(0.0),
            second: Linearised::zero(of_cables),
            drive: DriveRows::new(if drives.is_empty() { 0 } else { layout.coordinates }),
            strands: Strands::default(),
        };
        let event_tolerances = if mechanism.joints.is_empty() { EventTolerances::COLLISION } else { EVENT_TOLERANCES };
        Ok(Self {
            mechanism,
            groups,
            free_bodies,
            spans,
            group_of,
            reported_origins,
            dyad_of,
            monitored: monitored(&cables),
            contacts,
            cables,
            drives,
            range_count,
            sum_supports,
            friction_states: states.into_states(),
            brake_bristles,
            time_index,
            clock_index,
            second_order,
            prescribed,
            palm,
            world,
            world_gravity_m_s2,
            moves_by_forces,
            used_coordinates: coordinate_count,
            event_tolerances,
            layout,
            workspaces,
            scratch: RefCell::new(scratch),
            start,
            near_at_start,
        })
    }

    /// Numbers of coordinates and quadratures.
    pub fn sizes(&self) -> Dynamic {
        self.layout
    }

    /// Returns coordinates and rates at the start.
    pub fn start(&self) -> State<Dynamic> {
        let mut state = State::zero(self.layout);
        for (index, (q, v)) in self.start.iter().enumerate() {
            (state.q[index], state.v[index]) = (*q, *v);
        }
        self.time_index.into_iter().for_each(|time| state.v[time] = 1.0);
        state
    }

    pub fn contact_count(&self) -> usize {
        self.contacts.len()
    }

    /// Replaces a group by one with other coordinates, in poses in which its turns are counted anew.
    pub(super) fn replace_group(&mut self, index: usize, group: Group, poses: &[Pose]) {
        let old = &self.groups[index];
        old.joints.iter().for_each(|joint| self.dyad_of[*joint] = None);
        let mut placed = PlacedGroup::new(&self.mechanism, group, (old.first, old.counts().start), poses);
        placed.is_in_palm_frame = self.world.is_some();
        for (placement, joint) in placed.joints_on_demand(&self.mechanism) {
            self.dyad_of[joint] = Some((index, placement));
        }
        self.groups[index] = placed;
        self.near_at_start = near_at(&self.mechanism, &self.groups, poses);
        for workspace in &mut self.workspaces {
            let motions = &mut workspace.get_mut().motions;
            let (counts, bends) = (std::mem::take(&mut motions.counts), std::mem::take(&mut motions.bends));
            *workspace.get_mut() = Workspace::new(&self.mechanism, &self.groups, self.layout);
            let motions = &mut workspace.get_mut().motions;
            (motions.counts, motions.near, motions.bends) = (counts, self.near_at_start.clone(), bends);
        }
    }

    /// Coordinates of all joints near which Newton's method places bodies at the start; empty if it places none.
    pub(super) fn near_at_start(&self) -> &[f64] {
        &self.near_at_start
    }

    /// From time `t` on, replaces the effort of an actuator or the target of a servo as a function of time. The ranges
    /// in the mode are updated, and time becomes a first-order state if an event now depends on it.
    ///
    /// # Panics
    /// Panics if there is no place for time among the states.
    pub fn set_input(
        &mut self,
        index: usize,
        input: Profile,
        t: f64,
        (q, v): (&mut Vec<f64>, &mut Vec<f64>),
        mode: &mut MechanismMode,
    ) {
        self.count_turns_as(mode);
        *self.mechanism.actuators[index].command.profile_mut() = input;
        if self.time_index.or(self.clock_index).is_none() && depends_on_time(&self.mechanism) {
            self.clock_index = Some(self.used_coordinates);
            self.used_coordinates += 1;
        }
        if let Some(time) = self.time_index {
            (q[time], v[time]) = (t, 1.0);
        }
        if let Some(clock) = self.clock_index {
            v[clock] = t;
        }
        mode.ranges = self.ranges(t, (q, v));
        mode.times_s = self.times_around(t);
    }

    /// Time `t` and the last time before the next discontinuity.
    pub(super) fn times_around(&self, t: f64) -> [f64; 2] {
        [t, self.next_time_discontinuity(t).next_down()]
    }

    /// Range of an actuator at time `t`. The command after a discontinuity, which a sample at its time contains, does not
    /// belong to the range of the mode.
    #[inline(always)]
    pub(super) fn range_at(&self, t: f64, mode: &MechanismMode, index: usize, coordinate: f64, rate: f64) -> u8 {
        match t > mode.times_s[1] {
            true => range(&self.mechanism.actuators[index], t, coordinate, rate),
            false => mode.ranges.0[index],
        }
    }

    /// Time of the state (`q`, `v`); 0 if nothing depends on time.
    #[inline(always)]
    pub(super) fn time_in(&self, (q, v): StateRef<'_, Dynamic>) -> f64 {
        match (self.time_index, self.clock_index) {
            (Some(time), _) => q[time],
            (None, Some(clock)) => v[clock],
            (None, None) => 0.0,
        }
    }

    /// Index of time among the first-order states.
    pub(super) fn clock(&self) -> Option<usize> {
        self.clock_index
    }

    /// Number of coordinates of all groups.
    pub(super) fn second_order(&self) -> usize {
        self.second_order
    }

    /// Number of coordinates and first-order states in use.
    #[inline(always)]
    pub(super) fn coordinates_in_use(&self) -> usize {
        self.used_coordinates
    }

    /// Whether a contact can stick, because its friction has an internal state.
    pub fn has_stiction(&self, contact: usize) -> bool {
        self.contacts[contact].state.is_some()
    }

    /// Coordinates on which a joint depends.
    pub(super) fn span_of_joint(&self, joint: usize) -> Span {
        let bodies = self.mechanism.joints[joint].bodies;
        let body = bodies[1].or(bodies[0]).expect("a joint has a body");
        self.spans[body]
    }

    /// Coordinate of a joint.
    pub(super) fn joint_coordinate(&self, motions: &Motions<f64>, joint: usize) -> f64 {
        match self.dyad_of[joint] {
            None => motions.joints[joint].coordinate,
            Some((group, dyad)) => self.groups[group].joint_coordinate(&self.mechanism, motions, dyad, joint),
        }
    }

    /// Uses the counts of turns and the paths of cables of a mode in all evaluations until the next call. Functions that
    /// receive a mode call this themselves; it must be called before other readings of a state.
    #[inline(always)]
    pub fn count_turns_as(&self, mode: &MechanismMode) {
        self.count_turns_in(&mode.counts, &mode.near);
        if !self.cables.is_empty() {
            self.pass_paths_as(&mode.bends);
        }
    }

    /// Uses these paths of cables in all evaluations until the next call.
    #[inline(always)]
    pub(super) fn pass_paths_as(&self, bends: &[Bend]) {
        for workspace in &self.workspaces {
            let motions = &mut workspace.borrow_mut().motions;
            if motions.bends[..] != *bends {
                motions.bends.copy_from_slice(bends);
            }
        }
    }

    #[inline(always)]
    pub(super) fn count_turns_in(&self, counts: &[i32], near: &[f64]) {
        for workspace in &self.workspaces {
            let workspace = &mut *workspace.borrow_mut();
            let motions = &mut workspace.motions;
            if motions.counts[..] != *counts {
                motions.counts.copy_from_slice(counts);
                workspace.has_state = false;
            }
            if !near.is_empty() && motions.near[..] != *near {
                motions.near.clear();
                motions.near.extend_from_slice(near);
                workspace.has_state = false;
            }
        }
    }

    /// The workspace that is at a state, or the one for samples.
    #[inline(always)]
    fn workspace_at(&self, state: StateRef<'_, Dynamic>) -> RefMut<'_, Workspace> {
        let [of_equations, of_samples] = &self.workspaces;
        let workspace = of_equations.borrow_mut();
        if workspace.is_at(state) { workspace } else { of_samples.borrow_mut() }
    }

    /// Evaluates a function of the poses and rates of all bodies and joints in a state.
    #[inline(always)]
    pub(super) fn with_motions<R>(&self, state: StateRef<'_, Dynamic>, f: impl FnOnce(&Motions<f64>) -> R) -> R {
        let mut workspace = self.workspace_at(state);
        self.update(state, &mut workspace);
        f(&workspace.motions)
    }

    /// Like [`MechanismModel::with_motions`], for a state whose equations follow.
    #[inline(always)]
    pub(super) fn with_motions_of_equations<R>(
        &self,
        state: StateRef<'_, Dynamic>,
        f: impl FnOnce(&Motions<f64>) -> R,
    ) -> R {
        let mut workspace = self.workspaces[0].borrow_mut();
        self.update(state, &mut workspace);
        f(&workspace.motions)
    }

    /// Like [`MechanismModel::with_motions`], with the angles of all bodies and the coordinates of all joints: evaluations
    /// of forces omit those of dyads that no force depends on.
    pub(super) fn with_angles<R>(&self, state: StateRef<'_, Dynamic>, f: impl FnOnce(&Motions<f64>) -> R) -> R {
        let mut workspace = self.workspace_at(state);
        self.update(state, &mut workspace);
        if !std::mem::replace(&mut workspace.has_angles, true) {
            self.groups.iter().for_each(|group| group.evaluate_angles(&self.mechanism, &mut workspace.motions));
        }
        f(&workspace.motions)
    }

    /// Like [`MechanismModel::with_motions`], with memory for bounds.
    pub(super) fn with_bounds<R>(
        &self,
        state: StateRef<'_, Dynamic>,
        f: impl FnOnce(&Motions<f64>, &mut MechanismBounds) -> R,
    ) -> R {
        let mut workspace = self.workspace_at(state);
        let workspace = &mut *workspace;
        self.update(state, workspace);
        f(&workspace.motions, &mut workspace.bounds)
    }

    /// Like [`MechanismModel::with_motions`], with derivatives by the coordinates and bias accelerations.
    #[inline(always)]
    pub(super) fn with_columns<R>(&self, state: StateRef<'_, Dynamic>, f: impl FnOnce(&Motions<f64>) -> R) -> R {
        let mut workspace = self.workspaces[0].borrow_mut();
        self.update_columns(state, &mut workspace);
        f(&workspace.motions)
    }

    /// Like [`MechanismModel::with_columns`], with the factors of the mass matrices of all groups.
    #[inline(always)]
    pub(super) fn with_factors<R>(
        &self,
        state: StateRef<'_, Dynamic>,
        f: impl FnOnce(&Motions<f64>, &[Factor]) -> R,
    ) -> R {
        let mut workspace = self.workspaces[0].borrow_mut();
        let workspace = &mut *workspace;
        self.update_columns(state, workspace);
        if !std::mem::replace(&mut workspace.has_factors, true) {
            for (group, factor) in self.groups.iter().zip(&mut workspace.factors) {
                self.evaluate_inertia(group, &workspace.motions, factor.inertia());
                factor.factor();
            }
        }
        f(&workspace.motions, &workspace.factors)
    }

    /// Like [`MechanismModel::with_motions`], with the motions of these bodies and of their joints only.
    #[inline(always)]
    pub(super) fn with_bodies<R>(
        &self,
        state: StateRef<'_, Dynamic>,
        bodies: impl IntoIterator<Item = Option<usize>>,
        f: impl FnOnce(&Motions<f64>) -> R,
    ) -> R {
        let mut workspace = self.workspace_at(state);
        self.enter(state, &mut workspace);
        for group in bodies.into_iter().flatten().filter_map(|body| self.group_of[body]) {
            self.evaluate_group(group, &mut workspace);
        }
        f(&workspace.motions)
    }

    /// Evaluates poses and rates of a state, unless they are there.
    fn update(&self, state: StateRef<'_, Dynamic>, workspace: &mut Workspace) {
        self.enter(state, workspace);
        (0..self.groups.len()).for_each(|group| self.evaluate_group(group, workspace));
    }

    /// Evaluates poses and rates of a group, unless they are there.
    #[inline(always)]
    fn evaluate_group(&self, index: usize, workspace: &mut Workspace) {
        let Workspace { q, v, motions, is_evaluated, .. } = workspace;
        if !std::mem::replace(&mut is_evaluated[index], true) {
            let group = &self.groups[index];
            group.evaluate(&self.mechanism, group.state((q, v)), motions, Part::Rates);
        }
    }

    /// Enters a state, in which only free bodies are evaluated, unless it is the last one.
    fn enter(&self, (q, v): StateRef<'_, Dynamic>, workspace: &mut Workspace) {
        if workspace.is_at((q, v)) {
            return;
        }
        for free in &self.free_bodies {
            free.place((&q[free.first..], &v[free.first..]), &mut workspace.motions);
        }
        (workspace.has_angles, workspace.has_columns, workspace.has_factors) = (false, false, false);
        workspace.has_state = true;
        workspace.is_evaluated.fill(false);
        workspace.q.copy_from_slice(q);
        workspace.v.copy_from_slice(v);
    }

    /// Evaluates the motions of a state with derivatives by the coordinates, unless they are there.
    fn update_columns(&self, state: StateRef<'_, Dynamic>, workspace: &mut Workspace) {
        self.enter(state, workspace);
        if std::mem::replace(&mut workspace.has_columns, true) {
            return;
        }
        let Workspace { q, v, motions, is_evaluated, .. } = workspace;
        for (group, is_evaluated) in self.groups.iter().zip(is_evaluated) {
            let part = if std::mem::replace(is_evaluated, true) { Part::Derivatives } else { Part::All };
            group.evaluate(&self.mechanism, group.state((q, v)), motions, part);
        }
    }

    /// Evaluates a function of the motions of all bodies and joints, without and with second derivatives by the coordinates
    /// of their group.
    pub(super) fn with_derivatives<R>(
        &self,
        state: StateRef<'_, Dynamic>,
        f: impl FnOnce(&Motions<f64>, &[Motions<Lanes>]) -> R,
    ) -> R {
        let mut workspace = self.workspaces[0].borrow_mut();
        let workspace = &mut *workspace;
        self.update_columns(state, workspace);
        for group in &self.groups {
            let state = group.state((state.0, state.1));
            for (chunk, motions) in workspace.with_derivatives.iter_mut().enumerate().take(group.chunks()) {
                group.differentiate(&self.mechanism, state, chunk, &workspace.motions, motions);
            }
        }
        f(&workspace.motions, &workspace.with_derivatives)
    }

    /// Linear springs: bodies, points, and the index of the spring.
    pub(super) fn linear_springs(&self) -> impl Iterator<Item = (usize, [Option<usize>; 2], [[f64; 2]; 2])> + '_ {
        self.mechanism.springs.iter().enumerate().filter_map(|(index, spring)| match &spring.kind {
            SpringKind::Linear { bodies, points_m } => Some((index, *bodies, *points_m)),
            SpringKind::Torsional { .. } => None,
        })
    }

    /// Next time at which a command of an actuator or a prescribed motion is discontinuous.
    pub(super) fn next_time_discontinuity(&self, t: f64) -> f64 {
        let next = |actuator: &Actuator| {
            let brake = actuator.brake.map_or(f64::INFINITY, |brake| brake.next_discontinuity(t));
            actuator.command.profile().next_discontinuity(t).min(brake)
        };
        let pulls = self.cables.iter().filter_map(|cable| cable.tendon.actuator.as_ref());
        let pulls = pulls.map(|actuator| actuator.tension.next_discontinuity(t));
        let motions = self.mechanism.bodies.iter().filter_map(|body| body.motion.as_ref());
        let motions = motions.map(|motion| motion.next_discontinuity(t));
        self.mechanism.actuators.iter().map(next).chain(pulls).chain(motions).fold(f64::INFINITY, f64::min)
    }
}
