//! A mass on a line among walls, under the contact laws of the library: the smallest system with every kind of event.

use phalanx_integrator::{
    Guard, Hybrid, Linearised, Look, Observer, Options, Rates, State, Step, StepTools, Strain, System, Tolerances,
    Watch,
};
use phalanx_mechanics::law::{NormalLaw, damping, spring_force, unclamped_normal_force};

/// Law with the numbers of the object's contact (thesis Table 3.2).
pub const OBJECT: NormalLaw =
    NormalLaw { stiffness_n_per_m_e: 1e8, exponent: 2.2, damping_max_n_s_per_m: 1e6, transition_m: 1e-5 };

/// Where a mass meets something.
#[derive(Clone, Copy, Debug)]
pub enum Place {
    /// A half line: free is where side · (x − at) > 0.
    Plate { at: f64, side: f64 },
    /// A thin obstacle: free is where |x − at| > half.
    Window { at: f64, half: f64 },
}

#[derive(Clone, Copy, Debug)]
pub struct Wall {
    pub place: Place,
    pub law: NormalLaw,
    /// How near the landing must be, m.
    pub landing_m: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Branch {
    Free,
    Active,
    Released,
    Natural,
}

use Branch::{Active, Free, Natural, Released};

/// q̈ and its derivatives in (t, x, v) away from the walls.
pub type Field = fn(f64, f64, f64) -> [f64; 4];

pub struct Line<const S: usize> {
    pub mass: f64,
    pub field: Field,
    pub corners: Vec<f64>,
    pub walls: [Wall; S],
}

/// Force below which lift-off and reload are located.
const FORCE_TOLERANCE: f64 = 1e-9;

/// Rates below which a contact creeps rather than rebounds, m/s.
const SLOWEST_REBOUND: f64 = 1e-2;

impl<const S: usize> Line<S> {
    /// Gap, and its derivative in x.
    pub fn gap(&self, site: usize, x: f64) -> (f64, f64) {
        match self.walls[site].place {
            Place::Plate { at, side } => (side * (x - at), side),
            Place::Window { at, half } => ((x - at).abs() - half, if x >= at { 1.0 } else { -1.0 }),
        }
    }

    /// Acceleration by, impulse on and power of the walls, with the derivatives in (x, v).
    fn contact(&self, x: f64, v: f64, mode: &[Branch; S]) -> [[f64; 3]; 2] {
        let (mut force, mut power) = ([0.0; 3], [0.0; 3]);
        for (site, branch) in mode.iter().enumerate() {
            if !matches!(branch, Active | Natural) {
                continue;
            }
            let (gap, n) = self.gap(site, x);
            let f = unclamped_normal_force(&self.walls[site].law, -gap, -n * v);
            if *branch == Natural && f.force < 0.0 {
                continue;
            }
            let [f0, fx, fv] = [n * f.force, -f.d_delta, -f.d_rate];
            for (sum, part) in force.iter_mut().zip([f0, fx, fv]) {
                *sum += part;
            }
            for (sum, part) in power.iter_mut().zip([f0 * v, fx * v, fv * v + f0]) {
                *sum += part;
            }
        }
        [force, power]
    }
}

/// Quadratures: impulse and work of the walls.
impl<const S: usize> System<1, 2> for Line<S> {
    type Mode = [Branch; S];

    fn rates(&self, t: f64, q: &[f64; 1], v: &[f64; 1], mode: &[Branch; S]) -> Rates<1, 2> {
        let [force, power] = self.contact(q[0], v[0], mode);
        Rates { a: [(self.field)(t, q[0], v[0])[0] + force[0] / self.mass], g: [force[0], power[0]] }
    }

    fn linearise(&self, t: f64, q: &[f64; 1], v: &[f64; 1], mode: &[Branch; S]) -> Linearised<1, 2> {
        let [force, power] = self.contact(q[0], v[0], mode);
        let [_, a_t, a_x, a_v] = (self.field)(t, q[0], v[0]);
        Linearised {
            rates: self.rates(t, q, v, mode),
            a_q: [[a_x + force[1] / self.mass]],
            a_v: [[a_v + force[2] / self.mass]],
            a_t: [a_t],
            g_q: [[force[1]], [power[1]]],
            g_v: [[force[2]], [power[2]]],
            g_t: [0.0; 2],
        }
    }
}

impl<const S: usize> Hybrid<1, 2, S> for Line<S> {
    fn next_corner(&self, t: f64) -> f64 {
        self.corners.iter().copied().find(|c| *c > t).unwrap_or(f64::INFINITY)
    }

    fn watch(&self, q: &[f64; 1], v: &[f64; 1], mode: &[Branch; S]) -> Watch<1, S> {
        let guards = std::array::from_fn(|site| {
            let (gap, n) = self.gap(site, q[0]);
            let (delta, rate, law) = (-gap, -n * v[0], &self.walls[site].law);
            let force = unclamped_normal_force(law, delta, rate).force;
            let strain = if delta > 0.0 {
                let springy = spring_force(law, delta) > damping(law, delta).0 * rate.abs();
                let rebounds = springy && rate.abs() > SLOWEST_REBOUND;
                Strain::Depth { row: [n], depth: delta, rebounds, springy }
            } else {
                Strain::None
            };
            let parted = if delta > 0.0 { delta } else { delta.min(-1e-290) };
            let quiet = Guard::QUIET;
            match mode[site] {
                Natural => quiet,
                Free => Guard { value: gap, rate: -rate, look: Look::Gap, ..quiet },
                Active if delta <= 0.0 && rate >= 0.0 => Guard { apart: false, ..quiet },
                Active if law.damping_max_n_s_per_m == 0.0 => {
                    Guard { value: parted, rate, look: Look::Gap, apart: false, strain }
                }
                Active => {
                    let value = if delta > 0.0 { force } else { parted };
                    Guard { value, look: Look::End, apart: false, strain, ..quiet }
                }
                Released => {
                    Guard { value: 3.0 * FORCE_TOLERANCE - force, look: Look::Inside, apart: delta < 0.0, ..quiet }
                }
            }
        });
        Watch { guards, clearance: 1.0, clearance_rate: 0.0 }
    }

    fn landing_tolerance(&self, site: usize, mode: &[Branch; S]) -> f64 {
        match mode[site] {
            Active if self.walls[site].law.damping_max_n_s_per_m > 0.0 => FORCE_TOLERANCE,
            Released | Natural => FORCE_TOLERANCE,
            Free | Active => self.walls[site].landing_m,
        }
    }

    fn switch(&self, site: usize, _: &[f64; 1], _: &[f64; 1], mode: &[Branch; S]) -> [Branch; S] {
        let mut next = *mode;
        next[site] = match mode[site] {
            Free | Released => Active,
            Active => Released,
            Natural => Natural,
        };
        next
    }

    fn relax(&self, guards: &[Guard<1>; S], mode: &[Branch; S]) -> Option<[Branch; S]> {
        let next = std::array::from_fn(|i| if mode[i] == Released && guards[i].apart { Free } else { mode[i] });
        (next != *mode).then_some(next)
    }

    fn with_natural(&self, site: usize, mode: &[Branch; S]) -> [Branch; S] {
        let mut next = *mode;
        next[site] = Natural;
        next
    }

    fn read_mode(&self, _: f64, q: &[f64; 1], v: &[f64; 1]) -> [Branch; S] {
        std::array::from_fn(|site| {
            let (gap, n) = self.gap(site, q[0]);
            let force = unclamped_normal_force(&self.walls[site].law, -gap, -n * v[0]).force;
            match (gap < 0.0 || (gap == 0.0 && n * v[0] < 0.0), force >= 0.0) {
                (true, true) => Active,
                (true, false) => Released,
                _ => Free,
            }
        })
    }

    fn restart_step(&self, site: usize, _: &[f64; 1], v: &[f64; 1], mode: &[Branch; S]) -> Option<f64> {
        (mode[site] == Active).then_some(1e-9 / (1.0 + v[0].abs()))
    }

    fn obstacle(&self, _: &[f64; 1]) -> String {
        "none".to_string()
    }
}

/// Keeps the ends of all steps and all events.
#[derive(Default)]
pub struct Log {
    pub steps: Vec<(f64, f64, f64)>,
    pub events: Vec<(f64, usize, Branch)>,
}

impl<const S: usize> Observer<1, 2, [Branch; S]> for Log {
    fn step(&mut self, step: &Step<1, 2>, _: &[Branch; S], _: &mut dyn StepTools<1, 2>) -> bool {
        self.steps.push((step.t1, step.end.q[0], step.end.v[0]));
        true
    }

    fn event(&mut self, t: f64, _: &State<1, 2>, site: usize, mode: &[Branch; S]) {
        self.events.push((t, site, mode[site]));
    }
}

impl Log {
    /// Times of the touch-downs (and reloads) at a site.
    pub fn touchdowns(&self, site: usize) -> Vec<f64> {
        self.events.iter().filter(|e| e.1 == site && e.2 == Active).map(|e| e.0).collect()
    }
}

/// As tight as numbers of size 0.01 m and 1 m/s allow.
pub fn tight() -> Options {
    Options { tolerances: Tolerances { atol_q: 1e-14, atol_v: 1e-12, rtol_v: 1e-12 }, max_steps: 1_000_000 }
}

/// A mass at x with rate v.
pub fn at(x: f64, v: f64) -> State<1, 2> {
    State { q: [x], v: [v], z: [0.0; 2] }
}

/// The same experiment with both methods: (name, end, log) of each.
macro_rules! with_both {
    ($system:expr, $options:expr, $start:expr, $end:expr) => {
        $crate::wall::with_both!($system, $options, $start, 0.0, $end)
    };
    ($system:expr, $options:expr, $start:expr, $begin:expr, $end:expr) => {{
        use phalanx_integrator::{Radau5, Rodas5p, integrate};
        let mut logs = [$crate::wall::Log::default(), $crate::wall::Log::default()];
        let [a, b] = &mut logs;
        let rodas = integrate::<1, 2, _, _, Rodas5p<1, 2>, _>($system, &$options, $begin, $start, $end, a);
        let radau = integrate::<1, 2, _, _, Radau5<1, 2>, _>($system, &$options, $begin, $start, $end, b);
        let [a, b] = logs;
        [("Rodas5P", rodas, a), ("Radau IIA", radau, b)]
    }};
}
pub(crate) use with_both;
