//! A mass on a line between walls, with the contact laws of the library: the smallest system with every kind of event.

use phalanx_integrator::{
    End, EventFunction, EventSet, Fixed, Hybrid, Linearised, Observer, Options, Radau5, Rates, Rodas5p, RootSearch,
    State, Step, StepTools, System, Tolerances, WeightedQuantity, integrate,
};
use phalanx_mechanics::law::{NormalLaw, damping, spring_force, unclamped_normal_force};

/// Law with the numbers of the object's contact (thesis Table 3.2).
pub const OBJECT: NormalLaw = NormalLaw::step(1e8, 2.2, 1e6, 1e-5);

/// Geometry of an obstacle.
#[derive(Clone, Copy, Debug)]
pub enum Obstacle {
    /// A half line: the mass is free where side · (x − position) > 0.
    Plate { position: f64, side: f64 },
    /// A thin obstacle: the mass is free where |x − position| > half.
    Window { position: f64, half: f64 },
}

#[derive(Clone, Copy, Debug)]
pub struct Wall {
    pub obstacle: Obstacle,
    pub law: NormalLaw,
    /// Tolerance of event location, m.
    pub location_tolerance_m: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Branch {
    Free,
    Active,
    Released,
    Clamped,
}

use Branch::{Active, Clamped, Free, Released};

/// A mass in a field: q̈ and its derivatives in (t, x, v) away from the walls.
pub struct PointMass<F, const S: usize> {
    pub mass: f64,
    pub field: F,
    pub discontinuities: Vec<f64>,
    pub walls: [Wall; S],
}

impl<F: Fn(f64, f64, f64) -> [f64; 4], const S: usize> PointMass<F, S> {
    /// A mass of 20 g.
    pub fn new(field: F, walls: [Wall; S]) -> Self {
        Self { mass: 0.02, field, discontinuities: Vec::new(), walls }
    }
}

/// Motion without a force.
pub fn free_flight(_: f64, _: f64, _: f64) -> [f64; 4] {
    [0.0; 4]
}

/// Motion under gravity along −x.
pub fn free_fall(_: f64, _: f64, _: f64) -> [f64; 4] {
    [-9.81, 0.0, 0.0, 0.0]
}

/// A half line that is free where side · (x − position) > 0.
pub fn plate(position: f64, side: f64, law: NormalLaw, location_tolerance_m: f64) -> Wall {
    Wall { obstacle: Obstacle::Plate { position, side }, law, location_tolerance_m }
}

/// Force tolerance for locating lift-off and reloading, N.
const FORCE_TOLERANCE: f64 = 1e-9;

/// Rate below which a contact creeps instead of rebounding, m/s.
const SLOWEST_REBOUND: f64 = 1e-2;

impl<F, const S: usize> PointMass<F, S> {
    /// Gap and its derivative with respect to x.
    pub fn gap(&self, wall_index: usize, x: f64) -> (f64, f64) {
        match self.walls[wall_index].obstacle {
            Obstacle::Plate { position, side } => (side * (x - position), side),
            Obstacle::Window { position, half } => {
                ((x - position).abs() - half, if x >= position { 1.0 } else { -1.0 })
            }
        }
    }

    /// Force and power of the walls, with derivatives with respect to x and v.
    fn contact(&self, x: f64, v: f64, mode: &[Branch; S]) -> [[f64; 3]; 2] {
        let mut force_and_power = [[0.0; 3]; 2];
        for (wall_index, branch) in mode.iter().enumerate() {
            if !matches!(branch, Active | Clamped) {
                continue;
            }
            let (gap, n) = self.gap(wall_index, x);
            let f = unclamped_normal_force(&self.walls[wall_index].law, -gap, -n * v);
            if *branch == Clamped && f.force < 0.0 {
                continue;
            }
            let [f0, fx, fv] = [n * f.force, -f.d_delta, -f.d_rate];
            let terms = [f0, fx, fv, f0 * v, fx * v, fv * v + f0];
            force_and_power.iter_mut().flatten().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        force_and_power
    }
}

/// One coordinate, and two quadratures: impulse and work of the walls.
pub type OneMass = Fixed<1, 2>;

impl<F: Fn(f64, f64, f64) -> [f64; 4], const S: usize> System for PointMass<F, S> {
    type Layout = OneMass;
    type Mode = [Branch; S];

    fn layout(&self) -> OneMass {
        Fixed
    }

    fn rates(&self, t: f64, q: &[f64; 1], v: &[f64; 1], mode: &[Branch; S], rates: &mut Rates<OneMass>) {
        let [force, power] = self.contact(q[0], v[0], mode);
        rates.a = [(self.field)(t, q[0], v[0])[0] + force[0] / self.mass];
        rates.g = [force[0], power[0]];
    }

    fn linearise(&self, t: f64, q: &[f64; 1], v: &[f64; 1], mode: &[Branch; S], linearised: &mut Linearised<OneMass>) {
        let [force, power] = self.contact(q[0], v[0], mode);
        let [_, a_t, a_x, a_v] = (self.field)(t, q[0], v[0]);
        self.rates(t, q, v, mode, &mut linearised.rates);
        linearised.a_q.0 = [[a_x + force[1] / self.mass]];
        linearised.a_v.0 = [[a_v + force[2] / self.mass]];
        linearised.a_t = [a_t];
        linearised.g_q.0 = [[force[1]], [power[1]]];
        linearised.g_v.0 = [[force[2]], [power[2]]];
        linearised.g_t = [0.0; 2];
    }
}

impl<F: Fn(f64, f64, f64) -> [f64; 4], const S: usize> Hybrid for PointMass<F, S> {
    fn event_count(&self) -> usize {
        S
    }

    fn next_discontinuity(&self, t: f64) -> f64 {
        self.discontinuities.iter().copied().find(|c| *c > t).unwrap_or(f64::INFINITY)
    }

    fn eval_events(&self, q: &[f64; 1], v: &[f64; 1], mode: &[Branch; S], events: &mut EventSet<OneMass>) {
        events.clear();
        events.clearance = 1.0;
        for wall_index in 0..S {
            events.functions[wall_index] = self.eval_event(q, v, mode, wall_index);
            let (gap, n) = self.gap(wall_index, q[0]);
            let (delta, rate, law) = (-gap, -n * v[0], &self.walls[wall_index].law);
            if mode[wall_index] == Active && delta > 0.0 {
                let is_spring_dominated = spring_force(law, delta) > damping(law, delta).0 * rate.abs();
                let is_rebounding = is_spring_dominated && rate.abs() > SLOWEST_REBOUND;
                let weight = WeightedQuantity::Depth { depth: delta, is_rebounding, is_spring_dominated };
                *events.add_weight(wall_index, weight) = [n];
            }
        }
    }

    fn clearance(&self, _: &[f64; 1], _: &[f64; 1], _: &[Branch; S]) -> f64 {
        1.0
    }

    fn eval_event(&self, q: &[f64; 1], v: &[f64; 1], mode: &[Branch; S], wall_index: usize) -> EventFunction {
        let (gap, n) = self.gap(wall_index, q[0]);
        let (delta, rate, law) = (-gap, -n * v[0], &self.walls[wall_index].law);
        let force = unclamped_normal_force(law, delta, rate).force;
        let separated_depth = if delta > 0.0 { delta } else { delta.min(-1e-290) };
        let inactive = EventFunction::INACTIVE;
        let active = EventFunction { is_separated: false, ..inactive };
        match mode[wall_index] {
            Clamped => inactive,
            Free => EventFunction { value: gap, rate: -rate, root_search: RootSearch::Gap, ..inactive },
            Active if delta <= 0.0 && rate >= 0.0 => active,
            Active if law.damping_max() == 0.0 => {
                EventFunction { value: separated_depth, rate, root_search: RootSearch::Gap, ..active }
            }
            Active => {
                let value = if delta > 0.0 { force } else { separated_depth };
                EventFunction { value, root_search: RootSearch::EndOnly, ..active }
            }
            Released => {
                let (value, root_search) = (3.0 * FORCE_TOLERANCE - force, RootSearch::Interior);
                EventFunction { value, root_search, is_separated: delta < 0.0, ..inactive }
            }
        }
    }

    fn event_tolerance(&self, wall_index: usize, mode: &[Branch; S]) -> f64 {
        match mode[wall_index] {
            Active if self.walls[wall_index].law.damping_max() > 0.0 => FORCE_TOLERANCE,
            Released | Clamped => FORCE_TOLERANCE,
            Free | Active => self.walls[wall_index].location_tolerance_m,
        }
    }

    fn pass_event(&self, wall_index: usize, _: &[f64; 1], _: &[f64; 1], mode: &mut [Branch; S]) {
        mode[wall_index] = match mode[wall_index] {
            Free | Released => Active,
            Active => Released,
            Clamped => Clamped,
        };
    }

    fn pass_step(&self, functions: &[EventFunction], mode: &mut [Branch; S]) -> bool {
        let last = *mode;
        for (branch, function) in mode.iter_mut().zip(functions) {
            if *branch == Released && function.is_separated {
                *branch = Free;
            }
        }
        *mode != last
    }

    fn clamp_law(&self, wall_index: usize, mode: &mut [Branch; S]) {
        mode[wall_index] = Clamped;
    }

    fn mode_at(&self, _: f64, q: &[f64; 1], v: &[f64; 1]) -> [Branch; S] {
        std::array::from_fn(|wall_index| {
            let (gap, n) = self.gap(wall_index, q[0]);
            let force = unclamped_normal_force(&self.walls[wall_index].law, -gap, -n * v[0]).force;
            match (gap < 0.0 || (gap == 0.0 && n * v[0] < 0.0), force >= 0.0) {
                (true, true) => Active,
                (true, false) => Released,
                _ => Free,
            }
        })
    }

    fn restart_step(&self, wall_index: usize, _: &[f64; 1], v: &[f64; 1], mode: &[Branch; S]) -> Option<f64> {
        (mode[wall_index] == Active).then_some(1e-9 / (1.0 + v[0].abs()))
    }

    fn describe_obstacle(&self, _: &[f64; 1]) -> String {
        "none".to_string()
    }
}

/// Stores the ends of all steps and all events.
#[derive(Default)]
pub struct Log {
    pub steps: Vec<(f64, f64, f64)>,
    pub events: Vec<(f64, usize, Branch)>,
}

impl<const S: usize> Observer<OneMass, [Branch; S]> for Log {
    fn step(&mut self, step: &Step<OneMass>, _: &[Branch; S], _: &mut dyn StepTools<OneMass>) -> bool {
        self.steps.push((step.t1, step.end.q[0], step.end.v[0]));
        true
    }

    fn event(&mut self, t: f64, _: &State<OneMass>, wall_index: usize, mode: &[Branch; S]) {
        self.events.push((t, wall_index, mode[wall_index]));
    }
}

impl Log {
    /// The branches that the contacts entered, in order.
    pub fn branches(&self) -> Vec<Branch> {
        self.events.iter().map(|event| event.2).collect()
    }

    /// Times of all contacts (including reloads) at a wall.
    pub fn contact_times(&self, wall_index: usize) -> Vec<f64> {
        self.events.iter().filter(|e| e.1 == wall_index && e.2 == Active).map(|e| e.0).collect()
    }
}

/// The tightest tolerances that numbers of size 0.01 m and 1 m/s allow.
pub fn tight() -> Options {
    Options { tolerances: Tolerances { atol_q: 1e-14, atol_v: 1e-12, rtol_v: 1e-12 }, max_steps: 1_000_000 }
}

/// The state of a mass at x with rate v.
pub fn mass_at(x: f64, v: f64) -> State<OneMass> {
    State { q: [x], v: [v], z: [0.0; 2] }
}

/// Integrates a mass from a start (time and state) to `end_s` with both methods; returns the name, the end and the log
/// of each.
#[track_caller]
pub fn run<F: Fn(f64, f64, f64) -> [f64; 4], const S: usize>(
    system: &PointMass<F, S>,
    options: Options,
    (start_s, start): (f64, State<OneMass>),
    end_s: f64,
) -> [(&'static str, End<OneMass>, Log); 2] {
    let [mut rodas, mut radau] = [Log::default(), Log::default()];
    let ends = [
        ("Rodas5P", integrate::<_, Rodas5p<OneMass>, _>(system, &options, start_s, start.clone(), end_s, &mut rodas)),
        ("Radau IIA", integrate::<_, Radau5<OneMass>, _>(system, &options, start_s, start, end_s, &mut radau)),
    ];
    for (name, end) in &ends {
        assert!(end.result.is_ok(), "{name}: {:?}", end.result);
    }
    let [(a, rodas_end), (b, radau_end)] = ends;
    [(a, rodas_end, rodas), (b, radau_end, radau)]
}

/// Integrates a mass that starts at time 0 at `x` with rate `v`, as [`run`].
#[track_caller]
pub fn run_from<F: Fn(f64, f64, f64) -> [f64; 4], const S: usize>(
    system: &PointMass<F, S>,
    options: Options,
    [x, v]: [f64; 2],
    end_s: f64,
) -> [(&'static str, End<OneMass>, Log); 2] {
    run(system, options, (0.0, mass_at(x, v)), end_s)
}
