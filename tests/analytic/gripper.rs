//! The analytic model of a gripper against an independent program, against its own finger, and against what must hold.

use phalanx::analytic::multibody::{Multibody, guards, quadratures};
use phalanx::analytic::{self, SiteState};
use phalanx::gripper::Site;
use phalanx::integrator::{
    End, Linearised, Method, Observer, Options, RadauOrRodas, Rates, Rodas5p, State, Step, StepTools,
    System as Equations, Tolerances, integrate,
};
use phalanx::scene::{Disc, DiscMotion, Integrator, Place, Preset, Scene, System};
use phalanx::shape::{Placed, reach};

use crate::support::grippers::{Anchor, anchor, anchors};

/// The model of a gripper: of two fingers and an object.
pub type GripperModel<const N: usize> = Multibody<N, PLACES>;
pub type GripperMode = analytic::Mode<PLACES>;

pub const PLACES: usize = Place::ALL.len();
pub const QUADRATURES: usize = quadratures(PLACES);
const GUARDS: usize = guards(PLACES);

pub fn start<const N: usize>(system: &System) -> State<N, QUADRATURES> {
    GripperModel::<N>::new(system).start(system)
}

/// States at given times, and every event: time, place, whether it presses from then on.
pub struct Watcher<const N: usize> {
    times: Vec<f64>,
    pub states: Vec<State<N, QUADRATURES>>,
    pub events: Vec<(f64, usize, bool)>,
}

impl<const N: usize> Observer<N, QUADRATURES, GripperMode> for Watcher<N> {
    fn step(
        &mut self,
        step: &Step<N, QUADRATURES>,
        _: &GripperMode,
        tools: &mut dyn StepTools<N, QUADRATURES>,
    ) -> bool {
        while let Some(time) = self.times.get(self.states.len()).filter(|time| **time <= step.t1 + 1e-15) {
            let inside = *time < step.t1;
            self.states.push(if inside { tools.resolve((time - step.t0) / step.h) } else { *step.end });
        }
        true
    }

    fn event(&mut self, t: f64, _: &State<N, QUADRATURES>, place: usize, mode: &GripperMode) {
        self.events.push((t, place, mode[place].presses()));
    }
}

fn run_by<const N: usize, K: Method<N, QUADRATURES>>(
    scene: &Scene,
    settings: &Integrator,
    times: Vec<f64>,
) -> (Watcher<N>, End<N, QUADRATURES>) {
    let mut watcher = Watcher { times, states: Vec::new(), events: Vec::new() };
    let Integrator { atol_angle_rad, atol_rate_rad_s, rtol, max_steps, .. } = *settings;
    let tolerances = Tolerances { atol_q: atol_angle_rad, atol_v: atol_rate_rad_s, rtol_v: rtol };
    let options = Options { tolerances, max_steps };
    let model = GripperModel::<N>::new(&scene.system);
    let start = start::<N>(&scene.system);
    let end =
        integrate::<N, QUADRATURES, GUARDS, _, K, _>(&model, &options, 0.0, start, scene.duration_s, &mut watcher);
    assert!(end.result.is_ok(), "{:?}", end.result);
    (watcher, end)
}

pub fn reference<const N: usize>(scene: &Scene, times: Vec<f64>) -> (Watcher<N>, End<N, QUADRATURES>) {
    run_by::<N, RadauOrRodas<N, QUADRATURES>>(scene, &Integrator::preset(Preset::Reference), times)
}

pub fn everyday<const N: usize>(scene: &Scene, times: Vec<f64>) -> (Watcher<N>, End<N, QUADRATURES>) {
    run_by::<N, Rodas5p<N, QUADRATURES>>(scene, &Integrator::preset(Preset::Engineering), times)
}

/// Largest difference of coordinates from the states of an anchor; positions in object radii.
pub fn off<const N: usize>(anchor: &Anchor, found: &[State<N, QUADRATURES>]) -> f64 {
    assert_eq!(found.len(), anchor.states.len(), "{}", anchor.name);
    let radius = reach(&anchor.scene.system.grasped().shape);
    let scale = |coordinate: usize| if coordinate == 4 || coordinate == 5 { 1.0 / radius } else { 1.0 };
    let of = |(found, wanted): (&State<N, QUADRATURES>, &[f64; 7])| {
        (0..N.min(7)).map(|i| scale(i) * (found.q[i] - wanted[i]).abs()).fold(0.0, f64::max)
    };
    found.iter().zip(anchor.states.iter().map(|state| &state.q)).map(of).fold(0.0, f64::max)
}

/// Impulses of phalanges, palm and table are those of an anchor.
#[track_caller]
pub fn assert_impulses<const N: usize>(anchor: &Anchor, end: &End<N, QUADRATURES>) {
    for (place, wanted) in [0, 1, 3, 4, 6, 7].into_iter().zip(anchor.impulse) {
        let impulse = end.state.z[place];
        assert!((impulse - wanted).abs() < 1e-6 * wanted.max(1e-3), "{}: {place} {impulse} {wanted}", anchor.name);
    }
}

pub fn times(anchor: &Anchor) -> Vec<f64> {
    anchor.states.iter().map(|state| state.time_s).collect()
}

#[test]
fn the_reference_agrees_with_an_independent_program() {
    for anchor in anchors() {
        let (found, end) = reference::<7>(&anchor.scene, times(&anchor));
        let off = off(&anchor, &found.states);
        assert!(off < 2e-9, "{}: {off:.1e}", anchor.name);
        for (place, wanted) in [0, 1, 3, 4].into_iter().zip(anchor.first_touch_s) {
            let first = found.events.iter().find(|(_, at, presses)| *at == place && *presses).expect("a touch").0;
            assert!((first - wanted).abs() < 1e-10, "{}: place {place} at {first}, not {wanted}", anchor.name);
        }
        assert_impulses(&anchor, &end);
    }
}

#[test]
fn the_everyday_preset_is_near_it() {
    for (letter, bound) in [("a", 2e-7), ("b", 2e-7), ("c", 2e-5), ("f", 3e-6), ("i", 2e-7)] {
        let anchor = anchor(letter);
        let (found, _) = everyday::<7>(&anchor.scene, times(&anchor));
        let off = off(&anchor, &found.states);
        assert!(off < bound, "{}: {off:.1e}", anchor.name);
    }
}

/// Both fingers do the same to the last digit of what the object's place has.
#[test]
fn a_symmetric_gripper_stays_symmetric() {
    for letter in ["a", "b", "i"] {
        let (found, end) = everyday::<7>(&anchor(letter).scene, Vec::new());
        let q = end.state.q;
        let apart = (q[0] - q[2]).abs().max((q[1] - q[3]).abs()).max(q[6].abs());
        assert!(apart < 1e-10 && q[4].abs() < 1e-12, "{letter}: {apart:.1e} rad apart, {:.1e} m aside", q[4]);
        assert!(found.events.iter().any(|(_, place, _)| *place == 1), "{letter}: the tips touch");
    }
}

fn fixed(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.system.grasped_mut().motion = DiscMotion::Fixed;
    scene
}

/// With the object held, each finger is a finger's scene; the left one sees its mirror image.
#[test]
fn a_fixed_object_gives_each_finger_its_own_scene() {
    let anchor = anchor("c");
    let (_, end) = reference::<4>(&fixed(&anchor.scene), Vec::new());
    for (side, sign) in [(0, 1.0), (1, -1.0)] {
        let finger = &anchor.scene.system.fingers[side];
        let mut scene = crate::support::runs::anchor();
        (scene.finger_mut().linkage, scene.finger_mut().spring, scene.finger_mut().limit) =
            (finger.linkage, finger.spring, finger.limit);
        (scene.finger_mut().contact, scene.finger_mut().initial, scene.finger_mut().motor.actuation) =
            (finger.contact, finger.initial, finger.motor.actuation.clone());
        scene.duration_s = anchor.scene.duration_s;
        scene.system.gravity_m_s2 = anchor.scene.system.gravity_m_s2;
        let [x, y] = anchor.scene.system.grasped().centre_m;
        scene.system.discs = vec![Disc::object(Placed::disc(
            reach(&anchor.scene.system.grasped().shape),
            [sign * x - 0.5 * anchor.scene.system.palm_width_m, y],
        ))];
        scene.integrator = Integrator::preset(Preset::Reference);
        let alone = phalanx::trace::run_analytic(&scene, &mut ()).expect("a run").last;
        let off = (end.state.q[2 * side] - alone.finger().q11_rad)
            .abs()
            .max((end.state.q[2 * side + 1] - alone.finger().q21_rad).abs());
        assert!(off < 1e-10, "finger {side}: {off:.1e} rad");
    }
}

#[test]
fn a_very_heavy_object_is_a_fixed_one() {
    let anchor = anchor("c");
    let mut scene = anchor.scene.clone();
    scene.system.gravity_m_s2 = [0.0; 2];
    let held = reference::<4>(&fixed(&scene), Vec::new()).1.state.q;
    let mut last = f64::INFINITY;
    for factor in [1e3, 1e6] {
        let DiscMotion::Free { mass_kg, inertia_kg_m2, .. } = &mut scene.system.grasped_mut().motion else {
            panic!("a free object")
        };
        (*mass_kg, *inertia_kg_m2) = (0.0537840662 * factor, Some(1.0756813e-5 * factor));
        let heavy = reference::<7>(&scene, Vec::new()).1.state.q;
        let off = (0..4).map(|i| (heavy[i] - held[i]).abs()).fold(0.0, f64::max);
        assert!(off < 0.02 * last, "{factor:e} times: {off:.1e} rad off");
        last = off;
    }
    assert!(last < 1e-4, "{last:.1e}");
}

/// Energy is lost in dampers and friction only.
#[test]
fn energy_balances() {
    for anchor in anchors() {
        let model = GripperModel::<7>::new(&anchor.scene.system);
        let before = start::<7>(&anchor.scene.system);
        let (_, end) = reference::<7>(&anchor.scene, Vec::new());
        let stored = |state: &State<7, QUADRATURES>| {
            let energies = model.energies(&state.q, &state.v);
            energies.kinetic + energies.gravity + energies.spring
        };
        let (contact, motors) = (end.state.z[PLACES], end.state.z[PLACES + 1]);
        let balance = stored(&end.state) - stored(&before) - contact - motors;
        assert!(balance.abs() < 1e-9, "{}: {balance:.1e} J", anchor.name);
        assert!(contact < 0.0 && motors > 0.1, "{}: {contact} J in contacts, {motors} J of motors", anchor.name);
    }
}

/// Force and moment about its centre that contacts exert on the object in a state: what is read of them, with the sign turned; and the sum
/// of the sizes of all forces.
fn on_object(model: &GripperModel<7>, state: &State<7, QUADRATURES>, mode: &GripperMode) -> ([f64; 3], f64) {
    let (mut sum, mut sizes) = ([0.0; 3], 0.0);
    for index in (0..PLACES).filter(|place| !Place::ALL[*place].is_stop()) {
        let Some(reading) = model.reading(&state.q, &state.v, index, mode[index]) else { continue };
        let ([nx, ny], [px, py]) = (reading.geometry.normal, reading.geometry.point);
        let force = [-reading.normal * nx + reading.tangential * ny, -reading.normal * ny - reading.tangential * nx];
        let lever = [px - state.q[4], py - state.q[5]];
        sum[0] += force[0];
        sum[1] += force[1];
        sum[2] += lever[0] * force[1] - lever[1] * force[0];
        sizes += force[0].hypot(force[1]);
    }
    (sum, sizes)
}

/// Sums what contacts give the object, by Simpson's rule over every step; and how far its accelerations are from those forces at most.
struct Books<'a> {
    model: &'a GripperModel<7>,
    given: [f64; 3],
    /// Sizes of all that was given, N·s.
    size: f64,
    /// Of mass times acceleration from the forces, relative to the largest force.
    off: f64,
    largest: f64,
    inertia: [f64; 3],
    weight: [f64; 3],
}

impl Observer<7, QUADRATURES, GripperMode> for Books<'_> {
    fn step(
        &mut self,
        step: &Step<7, QUADRATURES>,
        mode: &GripperMode,
        tools: &mut dyn StepTools<7, QUADRATURES>,
    ) -> bool {
        let parts = [(0.0, 1.0 / 6.0), (0.5, 4.0 / 6.0), (1.0, 1.0 / 6.0)];
        for (part, weight) in parts {
            let state = match part {
                0.0 => *step.start,
                1.0 => *step.end,
                part => tools.resolve(part),
            };
            let (force, sizes) = on_object(self.model, &state, mode);
            let rates: Rates<7, QUADRATURES> = self.model.rates(step.t0 + part * step.h, &state.q, &state.v, mode);
            self.size += weight * step.h * sizes;
            self.largest = self.largest.max(sizes);
            for (i, force) in force.into_iter().enumerate() {
                self.given[i] += weight * step.h * force;
                let inertial = self.inertia[i] * rates.a[4 + i] - self.weight[i];
                let lever = if i == 2 { 0.02 } else { 1.0 };
                self.off = self.off.max((inertial - force).abs() / lever);
            }
        }
        true
    }

    fn event(&mut self, _: f64, _: &State<7, QUADRATURES>, _: usize, _: &GripperMode) {}
}

/// What contacts and gravity give the object is what its momentum and its angular momentum become.
#[test]
fn momentum_balances() {
    for anchor in anchors() {
        let model = GripperModel::<7>::new(&anchor.scene.system);
        let DiscMotion::Free { mass_kg, inertia_kg_m2: Some(inertia_kg_m2), .. } = anchor.scene.system.grasped().motion
        else {
            panic!("free")
        };
        let [gx, gy] = anchor.scene.system.gravity_m_s2;
        let (inertia, weight) = ([mass_kg, mass_kg, inertia_kg_m2], [mass_kg * gx, mass_kg * gy, 0.0]);
        let mut books = Books { model: &model, given: [0.0; 3], size: 0.0, off: 0.0, largest: 0.0, inertia, weight };
        let Integrator { atol_angle_rad, atol_rate_rad_s, rtol, max_steps, .. } = Integrator::preset(Preset::Reference);
        let tolerances = Tolerances { atol_q: atol_angle_rad, atol_v: atol_rate_rad_s, rtol_v: rtol };
        let options = Options { tolerances, max_steps };
        let (before, duration_s) = (start::<7>(&anchor.scene.system), anchor.scene.duration_s);
        let end = integrate::<7, QUADRATURES, GUARDS, _, RadauOrRodas<7, QUADRATURES>, _>(
            &model, &options, 0.0, before, duration_s, &mut books,
        );
        // At every instant, to rounding.
        assert!(books.off < 1e-12 * books.largest, "{}: {:.1e} of {:.1e} N", anchor.name, books.off, books.largest);
        // Over the run, as closely as Simpson's rule goes through impacts.
        for i in 0..3 {
            let gained = inertia[i] * (end.state.v[4 + i] - before.v[4 + i]) - weight[i] * duration_s;
            let off = (gained - books.given[i]).abs();
            let size = books.size * if i == 2 { 0.02 } else { 1.0 };
            assert!(off < 1e-5 * size, "{}: {i}: {gained:e}, given {:e}, of {size:e}", anchor.name, books.given[i]);
        }
    }
}

/// The Jacobian is put together from blocks: every entry against central differences, with everything in contact at once.
#[test]
fn the_jacobian_is_that_of_the_accelerations() {
    for letter in ["c", "f", "i"] {
        let mut scene = anchor(letter).scene;
        scene.system.fingers[0].spring.as_mut().expect("a spring").kind =
            phalanx::gripper::SpringKind::Torsional { stiffness_n_m_per_rad: 0.08, preload_rad: 1.0 };
        scene.system.table.iter_mut().for_each(|table| table.level_m = 0.0399);
        scene
            .system
            .differential
            .iter_mut()
            .for_each(|differential| differential.motor.no_load_speed_rad_s = Some(300.0));
        let model = GripperModel::<7>::new(&scene.system);
        let mut mode = GripperMode::FREE;
        mode.sites = [SiteState::Active; PLACES];
        // Both fingers close on the object without its centre in the middle; the surfaces press where gaps are negative.
        let q = [0.08, 1.22, 0.11, 1.31, 1e-3, 0.01998, 0.02];
        let v = [12.0, -7.0, 9.0, 5.0, 0.3, -0.2, 4.0];
        let exact: Linearised<7, QUADRATURES> = model.linearise(1e-3, &q, &v, &mode);
        let outputs = |q: &[f64; 7], v: &[f64; 7]| {
            let rates: Rates<7, QUADRATURES> = model.rates(1e-3, q, v, &mode);
            let mut all = [0.0; 7 + QUADRATURES];
            all[..7].copy_from_slice(&rates.a);
            all[7..].copy_from_slice(&rates.g);
            all
        };
        let pressing = (0..PLACES).filter(|place| model.reading(&q, &v, *place, SiteState::Active).is_some());
        assert!(pressing.count() >= 7);
        for j in 0..7 {
            for (rows, by_rate) in [((&exact.a_q, &exact.g_q), false), ((&exact.a_v, &exact.g_v), true)] {
                let at = |h: f64| {
                    let (mut q, mut v) = (q, v);
                    if by_rate {
                        v[j] += h
                    } else {
                        q[j] += h
                    }
                    outputs(&q, &v)
                };
                // Derivatives of order 4 by central differences.
                let h = if by_rate { 1e-3 } else { if j == 4 || j == 5 { 2e-7 } else { 5e-6 } };
                let (near, far): ([_; 2], [_; 2]) = ([at(h), at(-h)], [at(2.0 * h), at(-2.0 * h)]);
                for i in 0..7 + QUADRATURES {
                    let by_difference = (8.0 * (near[0][i] - near[1][i]) - (far[0][i] - far[1][i])) / (12.0 * h);
                    let entry = if i < 7 { rows.0[i][j] } else { rows.1[i - 7][j] };
                    let row = if i < 7 { &rows.0[i] } else { &rows.1[i - 7] };
                    let scale = row.iter().fold(0.0f64, |most, entry| most.max(entry.abs()));
                    assert!(
                        (entry - by_difference).abs() <= 1e-6 * scale,
                        "{letter}: output {i} by {} {j}: {entry:e}, by differences {by_difference:e}",
                        if by_rate { "rate" } else { "coordinate" }
                    );
                }
            }
        }
    }
}

/// A left phalanx is read in the palm's frame: mirrored, and pressing the object the other way.
#[test]
fn contacts_are_read_in_the_palms_frame() {
    let anchor = anchor("a");
    let model = GripperModel::<7>::new(&anchor.scene.system);
    let (_, end) = reference::<7>(&anchor.scene, Vec::new());
    let read = |side, site| {
        let place = Place::Finger(side, site).index();
        model.reading(&end.state.q, &end.state.v, place, analytic::SiteState::Active).expect("a contact")
    };
    for site in [Site::Proximal, Site::Distal] {
        let [right, left] = phalanx::scene::Side::BOTH.map(|side| read(side, site));
        assert!(right.normal > 1.0, "{site:?} presses");
        assert!((right.geometry.point[0] + left.geometry.point[0]).abs() < 1e-9, "{site:?}: points");
        assert!((right.geometry.normal[0] + left.geometry.normal[0]).abs() < 1e-7, "{site:?}: normals");
        let towards = |reading: &analytic::SiteReading| {
            let [x, y] = reading.geometry.point;
            let [cx, cy] = [end.state.q[4], end.state.q[5]];
            reading.geometry.normal[0] * (x - cx) + reading.geometry.normal[1] * (y - cy)
        };
        for reading in [&right, &left] {
            assert!(
                (towards(reading) - 0.02).abs() < 1e-5,
                "{site:?}: the normal points from the object to the phalanx"
            );
        }
    }
}
