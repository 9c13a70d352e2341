//! Grasp-state volumes: comparison with single designs and with the thesis, for several threads, resolutions and bases;
//! allocations of the computation.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell as Counter;
use std::hint::black_box;
use std::sync::Mutex;

use phalanx_core::gripper::{
    Assembly, Design, Finger, Placement, ProximalLength, Spring, SpringKind, bodies, disc, final_posture, lengths,
    total_mass,
};
use phalanx_core::scene::{self, Template};
use phalanx_core::sizing::{Rule, Task, size};
use phalanx_core::statics::{drive_loads, equilibrium, form_closure};
use phalanx_parallel::{ComputeError, Monitor};
use phalanx_thesis::volume::{
    self, Axes, Axis, BASES_M, Cell, Counts, GraspState, Quantity, SizedFinger, Volume, VolumeRequest, by_friction,
    cells, close_finger, count_volume, design_at, intersections, solve_grasp,
};

/// Returns a request of a few hundred points.
fn small_request(resolution: [usize; 3]) -> VolumeRequest {
    VolumeRequest { axes: Axes::thesis(resolution), ..VolumeRequest::thesis() }
}

fn volumes(request: &VolumeRequest, threads: usize) -> Result<Vec<Volume>, ComputeError> {
    volume::volumes(request, threads, &Monitor::silent(&|| true))
}

/// Every point is recomputed with the functions for a single design.
#[test]
fn points_equal_single_designs() {
    for rule in [Rule::Rigid, Rule::Whole] {
        let computed = volumes(&VolumeRequest { rule, ..small_request([4, 3, 5]) }, 2).unwrap();
        let parameters: Vec<(f64, f64)> = computed.iter().map(|volume| (volume.base_m, volume.mu_static)).collect();
        assert_eq!(parameters, BASES_M.map(|base_m| [(base_m, 0.0), (base_m, 0.4), (base_m, 0.8)]).concat());
        for volume in &computed {
            let mut expected = Counts { points: 60, fingers: 60, ..Counts::default() };
            for (index, point) in volume.points.iter().enumerate() {
                let [l21, phi22, arm] = [index / 15, index / 5 % 3, index % 5].map(|index| index as f64);
                let [fraction, phi22_rad, arm_ratio] = volume.axes.at(index);
                let deg = std::f64::consts::PI / 180.0;
                assert!((fraction - l21 / 3.0).abs() < 1e-15 && (arm_ratio - (1.0 + arm / 4.0) / 3.0).abs() < 1e-15);
                assert!((phi22_rad - (90.0 + 15.0 * phi22) * deg).abs() < 1e-15);
                let l21 = ProximalLength::Fraction(fraction);
                let design = Design::thesis(volume.base_m, l21, phi22_rad, arm_ratio);
                let lengths = lengths(&design).unwrap();
                let bodies = bodies(&lengths, 1070.0, 0.04).unwrap();
                let finger = Finger { lengths, bodies, assembly: Assembly::Reference };
                let task = Task::thesis(disc(&design));
                let sizing = size(&finger, &task, rule).unwrap();
                let end = final_posture(&lengths, finger.assembly, task.object).unwrap();
                let kind = SpringKind::Constant { torque_n_m: sizing.spring_n_m };
                let spring = Spring { kind, placement: Placement::Phalanges };
                let loads = drive_loads(&finger, &end, sizing.motor_n_m, Some(&spring)).unwrap();
                let forces = equilibrium(&finger, &end, loads, volume.mu_static).unwrap();
                let form_closed = form_closure(&finger, &end).unwrap().closed;
                let sized = SizedFinger { lengths, mass_kg: total_mass(&bodies), sizing, form_closed };
                assert_eq!(point, &Ok(GraspState { sized, forces }));
                let is_stable = forces.f21_n >= 0.0 && forces.f22_n >= 0.0;
                assert_eq!(point.as_ref().unwrap().is_stable(), is_stable);
                expected.stable += usize::from(is_stable);
                expected.form_closed += usize::from(is_stable && form_closed);
                expected.palm_positive += usize::from(is_stable && forces.pfp_n >= 0.0);
                expected.form_closed_total += usize::from(form_closed);
            }
            assert_eq!(count_volume(volume).counts, expected);
        }
    }
}

#[test]
fn points_do_not_depend_on_the_number_of_threads() {
    let request = small_request([7, 6, 9]);
    let expected = volumes(&request, 1).unwrap();
    for threads in [2, 3, 8, 1000] {
        assert_eq!(volumes(&request, threads).unwrap(), expected, "{threads}");
    }
}

#[test]
fn intersection_counts_points_stable_at_every_base() {
    let computed = volumes(&small_request([6, 5, 4]), 2).unwrap();
    for (common, bases) in intersections(&computed).iter().zip(by_friction(&computed)) {
        assert_eq!((bases.len(), bases[0].mu_static), (4, common.mu_static));
        let states = |index: usize| bases.iter().map(move |volume| volume.points[index].as_ref().unwrap());
        let count = |test: fn(&GraspState) -> bool| {
            (0..120).filter(|&index| states(index).all(|state| state.is_stable() && test(state))).count()
        };
        assert_eq!(common.counts.stable, count(|_| true));
        assert_eq!(common.counts.palm_positive, count(|state| state.forces.pfp_n >= 0.0));
        assert_eq!(common.counts.form_closed, count(|state| state.sized.form_closed));
        assert!(bases.iter().all(|volume| count_volume(volume).counts.stable >= common.counts.stable));
        // Cells of the intersection have the smallest palm force and the largest mass.
        let forces = cells(&bases, Quantity::Pfp);
        assert_eq!(forces.iter().filter(|cell| matches!(cell, Cell::Stable(_))).count(), common.counts.stable);
        for (index, cell) in forces.iter().enumerate() {
            let smallest = states(index).map(|state| state.forces.pfp_n).fold(f64::INFINITY, f64::min);
            assert!(cell.value().is_none_or(|value| value == smallest));
        }
        let (masses, single) = (cells(&bases, Quantity::Mass), cells(&bases[..1], Quantity::Mass));
        assert!(masses.iter().zip(&single).all(|(all, single)| all.value() >= single.value() || all.value().is_none()));
        assert_eq!(Counts::new(&bases[..1]), count_volume(bases[0]).counts);
    }
    assert_eq!(Counts::new(&[]), Counts::default());
}

/// Designs that do not exist keep their points, with the reason.
#[test]
fn designs_that_do_not_exist_are_counted() {
    // At 30 mm the contact angle of the tip is below its minimum for every l21.
    let request = VolumeRequest { bases_m: vec![0.0155, 0.030], mu_static: vec![0.0, 0.8], ..small_request([3, 3, 3]) };
    let computed = volumes(&request, 2).unwrap();
    let largest_base = &computed[2];
    for point in &largest_base.points {
        let reason = point.as_ref().unwrap_err().to_string();
        assert!(reason.contains("base is 30.0000 mm") && reason.contains("nearer"), "{reason}");
    }
    let counted = count_volume(largest_base);
    let none = Counts { points: 27, ..Counts::default() };
    assert_eq!((counted.counts, counted.largest_palm_force, counted.missing_fingers[0].points), (none, None, 27));
    assert_eq!(intersections(&computed)[0].counts, none);

    // With a long arm and a wide angle, some tips would have to bend backwards, so part of the volume is empty.
    let mut axes = Axes::thesis([6, 6, 6]);
    (axes.phi22_rad, axes.arm_ratio) = (Axis::new(0.5, 2.6, 6), Axis::new(0.3, 2.5, 6));
    let computed = volumes(&VolumeRequest { axes, bases_m: vec![0.0155], ..VolumeRequest::thesis() }, 2).unwrap();
    let counts = count_volume(&computed[0]).counts;
    assert!(0 < counts.fingers && counts.fingers < counts.points && counts.stable <= counts.fingers, "{counts:?}");
    let empty = cells(&[&computed[0]], Quantity::Pfp).iter().filter(|cell| **cell == Cell::NoFinger).count();
    assert_eq!(empty, counts.points - counts.fingers);
}

#[test]
fn scene_provides_the_values_that_are_not_varied() {
    let text = "half_width = \"2 mm\"\nclosing_time = \"12 ms\"\nsizing = \"whole\"\ngravity = [\"1 m/s^2\", \"-9.81 m/s^2\"]\n\
                [design]\nbase = \"22 mm\"\nl21_fraction = 0.5\nphi22 = \"100 deg\"\narm_ratio = 0.5\nl11 = \"20 mm\"\nheight_ratio \
                = 0.95\n[object]\nradius = \"26 mm\"\n[material]\ndensity = \"2700 kg/m^3\"\n[bodies.l22]\nmass = \"9 g\"\n[initial]\n\
                offset = \"20 deg\"\n[contact.friction]\nmu_static = 0.3\n";
    let template = scene::parse_template(text, "other.toml").unwrap();
    assert_eq!((template.rule, template.mu_static), (Some(Rule::Whole), [0.3, 0.3]));
    let scene = scene::parse(text, "other.toml").unwrap();
    let [l21_fraction, phi22_rad, arm_ratio] = [0.5, 100f64.to_radians(), 0.5].map(|value| Axis::new(value, value, 1));
    let axes = Axes { l21_fraction, phi22_rad, arm_ratio };
    let bases_m = vec![template.design.base_m];
    let request = VolumeRequest { template, bases_m, mu_static: vec![0.3], axes, rule: Rule::Whole };
    let computed = volumes(&request, 1).unwrap();
    let sized = computed[0].points[0].as_ref().unwrap().sized;
    // The only point is the scene itself: equal lengths, masses and sizing.
    let finger = scene.finger();
    assert_eq!(sized.lengths, finger.linkage.lengths);
    assert_eq!((sized.mass_kg, finger.linkage.bodies.l22.mass_kg), (total_mass(&finger.linkage.bodies), 0.009));
    assert_eq!(finger.motor.actuation, scene::Profile::Constant { value: sized.sizing.motor_n_m });
    assert_eq!(finger.spring.unwrap().kind, SpringKind::Constant { torque_n_m: sized.sizing.spring_n_m });
}

#[test]
fn rejects_scenes_that_are_not_templates() {
    let drive = "[motor]\ntorque = \"480 N*mm\"\n[spring]\ntorque = \"120 N*mm\"\n";
    let design = "[design]\nbase = \"15.5 mm\"\nl21_fraction = 1.0\nphi22 = \"120 deg\"\narm_ratio = 0.5\n";
    let object = "[object]\ncentre = [\"-15.5 mm\", \"20 mm\"]\n";
    let lengths = "[lengths]\nl21 = \"24.4 mm\"\nl22 = \"7.5 mm\"\nt22 = \"12.9 mm\"\nphi22 = \"120 deg\"\n";
    for (text, fragment) in [
        ([design, drive, object].concat(), "the base determines the position of the object"),
        ([design, drive, "[initial]\nq21 = \"30 deg\"\n"].concat(), "offset = \"25 deg\""),
        ([lengths, drive, object].concat(), "replace [lengths] by [design]"),
        ([design, drive, "oops = 1\n"].concat(), "oops"),
    ] {
        let error = scene::parse_template(&text, "one.toml").unwrap_err().to_string();
        assert!(error.contains(fragment) && error.contains("one.toml"), "{error}");
    }
    let shipped = include_str!("../../../scenes/experiment-95.toml");
    assert!(scene::parse_template(shipped, "experiment-95.toml").is_ok());
}

#[test]
fn rejects_invalid_requests() {
    let valid = || small_request([2, 2, 2]);
    let reversed = Axes { arm_ratio: Axis::new(0.6, 0.4, 3), ..valid().axes };
    for (request, fragment) in [
        (VolumeRequest { bases_m: vec![], ..valid() }, "no base"),
        (VolumeRequest { mu_static: vec![], ..valid() }, "no friction coefficient"),
        (VolumeRequest { bases_m: vec![f64::NAN], ..valid() }, "above 0"),
        (VolumeRequest { bases_m: vec![0.01, 0.02, 0.01], ..valid() }, "twice"),
        (VolumeRequest { mu_static: vec![-0.1], ..valid() }, "at least 0"),
        (VolumeRequest { axes: Axes::thesis([2, 0, 2]), ..valid() }, "phi22 has no points"),
        (VolumeRequest { axes: Axes::thesis([usize::MAX; 3]), ..valid() }, "lower the resolution"),
        (VolumeRequest { axes: Axes::thesis([200; 3]), ..valid() }, "96000000 points"),
        (VolumeRequest { axes: reversed, ..valid() }, "lower one first"),
    ] {
        let error = volumes(&request, 1).unwrap_err();
        assert!(matches!(&error, ComputeError::Unsuitable(text) if text.contains(fragment)), "{error}");
    }
}

#[test]
fn progress_is_reported_and_study_can_be_interrupted() {
    let request = small_request([20, 4, 4]);
    let reported = Mutex::new(Vec::new());
    let report = |done, total, _: &str| reported.lock().unwrap().push((done, total));
    volume::volumes(&request, 2, &Monitor::new(report, &|| true)).unwrap();
    assert!(reported.lock().unwrap().iter().copied().eq((0..=1280).map(|done| (done, 1280))));
    let stopped = volume::volumes(&request, 2, &Monitor::silent(&|| false)).unwrap_err();
    assert!(matches!(stopped, ComputeError::Stopped { done, total: 1280 } if done < 1280), "{stopped}");
}

/// `tests/design/reproduce.rs` compares all figures of the volumes.
#[test]
fn form_closed_points_are_counted_regardless_of_stability() {
    let request = VolumeRequest { bases_m: vec![0.0155], mu_static: vec![0.0, 0.8], ..VolumeRequest::thesis() };
    let counted: Vec<Counts> = volumes(&request, 2).unwrap().iter().map(|volume| count_volume(volume).counts).collect();
    for counts in &counted {
        assert_eq!((counts.points, counts.fingers), (8000, 8000));
        assert!((counts.percent(counts.form_closed_total) - 23.9).abs() < 0.01, "{counts:?}");
    }
}

/// System allocator that counts the allocations of the current thread.
struct CountingAllocator;

thread_local! {
    static ALLOCATIONS: Counter<usize> = const { Counter::new(0) };
}

// SAFETY: all calls are forwarded to the system allocator; the counter is a thread-local without a destructor.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// Returns the number of allocations of an action.
fn allocations<T>(action: impl FnOnce() -> T) -> (usize, T) {
    let before = ALLOCATIONS.get();
    let result = black_box(action());
    (ALLOCATIONS.get() - before, result)
}

#[test]
fn only_the_form_closure_certificate_allocates() {
    let (template, axes) = (Template::thesis(), Axes::thesis([5; 3]));
    for rule in [Rule::Rigid, Rule::Whole] {
        for base_m in BASES_M {
            for index in 0..axes.len() {
                let design = design_at(&template, base_m, axes.at(index));
                let (total, closed) = allocations(|| {
                    let closed = close_finger(&template, &design, rule).expect("a design of the thesis has a finger");
                    for mu_static in [0.0, 0.4, 0.8] {
                        black_box(solve_grasp(&closed, mu_static)).expect("an equilibrium");
                    }
                    closed
                });
                let (expected, _) = allocations(|| form_closure(&closed.finger, &closed.end));
                assert_eq!(total, expected, "base {base_m}, point {index}");
            }
        }
    }
    assert!(allocations(|| vec![1u8]).0 > 0, "allocations are counted");
}
