//! Logs are streamed: the memory of a 10 s run, 500 times the usual duration, stays bounded. Steps do not allocate.

#![cfg(target_os = "linux")]

mod support;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::Path;

use phalanx::analytic::mechanism::MechanismModel;
use phalanx::integrator::{Options, SwitchedMethod, Tolerances, integrate_by};
use phalanx::mechanism::assemble;
use phalanx::trace::{self, Event, Model, Sample, Sink, SinkError};
use phalanx::{log, scene};

/// System allocator that counts the allocations of the current thread.
struct CountingAllocator;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
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

/// Counts the allocations between samples after the second one; requires all data, also the forces in joints. Events may
/// allocate.
#[derive(Default)]
struct AllocationsOfSamples {
    samples: usize,
    at_last: Option<usize>,
    between: usize,
}

impl Sink for AllocationsOfSamples {
    fn sample(&mut self, _: &Sample) -> Result<(), SinkError> {
        self.samples += 1;
        let now = ALLOCATIONS.get();
        if self.samples > 2 {
            self.between += self.at_last.map_or(0, |last| now - last);
        }
        self.at_last = Some(now);
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        self.at_last = None;
        Ok(())
    }
}

#[test]
fn samples_of_mechanisms_do_not_allocate() {
    for name in ["four-bar", "f85-finger", "tendon-finger", "slider-crank", "jaws"] {
        let scene = scene::load_any(format!("scenes/mechanisms/{name}.toml")).unwrap_or_else(|error| panic!("{error}"));
        let mut sink = AllocationsOfSamples::default();
        trace::run(Model::Analytic, &scene, &mut sink).unwrap_or_else(|error| panic!("{error}"));
        assert!(sink.samples > 100 && ALLOCATIONS.get() > 0, "{name}: {} samples", sink.samples);
        // Lists of extrema grow at the first contact.
        assert!(sink.between < 8, "{name}: {} allocations between {} samples", sink.between, sink.samples);
    }
}

/// Numbers of allocations, steps and events of an integration of a shipped mechanism without observer.
fn cost_of_integration(name: &str, part: f64) -> [usize; 3] {
    let scene = scene::load_any(format!("scenes/mechanisms/{name}.toml")).unwrap_or_else(|error| panic!("{error}"));
    let mechanism = scene.mechanism().expect("a mechanism");
    let start = assemble(&mechanism).expect("an assembled mechanism");
    let model = MechanismModel::new(&mechanism, (&start.poses, &start.rates)).expect("dyads");
    let tolerances = Tolerances { atol_q: 3e-11, atol_v: 3e-7, rtol_v: 3e-7 };
    let options = Options { tolerances, max_steps: 1_000_000 };
    let (method, state) = (SwitchedMethod::rodas(model.sizes()), model.start());
    let before = ALLOCATIONS.get();
    let end = integrate_by(method, &model, &options, 0.0, state, part * scene.duration_s, &mut ());
    let allocations = ALLOCATIONS.get() - before;
    end.result.unwrap_or_else(|failure| panic!("{name}: {failure}"));
    [allocations, end.counters.steps as usize, end.counters.events as usize]
}

/// A run and its first half need as many allocations, except those of events: the row of a new contact, and the first step
/// after a touch-down.
#[test]
fn steps_of_mechanisms_do_not_allocate() {
    for name in ["four-bar", "f85-finger", "tendon-finger", "slider-crank", "jaws"] {
        let [half, whole] = [0.5, 1.0].map(|part| cost_of_integration(name, part));
        let [allocations, steps, events] = [0, 1, 2].map(|index| whole[index] - half[index]);
        assert!(steps > 20, "{name}: {steps} steps");
        assert!(
            allocations < 8 + 3 * events,
            "{name}: {allocations} allocations in {steps} steps with {events} events"
        );
    }
}

/// Peak resident set of this process in bytes (proc(5), VmHWM).
fn peak_memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux has /proc/self/status");
    let line = status.lines().find(|l| l.starts_with("VmHWM:")).expect("VmHWM is always listed");
    line.split_whitespace().nth(1).and_then(|kib| kib.parse::<u64>().ok()).expect("a number of KiB") * 1024
}

#[test]
fn ten_second_run_stays_below_50_mb() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/experiment-95.toml");
    let mut scene = scene::load(&path).expect("the shipped scene loads");
    scene.duration_s = 10.0;
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("hold.mcap");
    let info = log::RunInfo { scene: &scene, scene_file: "experiment-95.toml", model: "analytic" };
    let mut writer = log::create(&file, &info).expect("the log opens");
    let outcome = support::checked_run::run(Model::Analytic, &scene, &mut writer).expect("the hold completes");
    writer.commit().expect("the log closes");
    assert_eq!(outcome.last.time_s, 10.0);
    assert!(std::fs::metadata(&file).expect("the log exists").len() > 5_000_000, "100,000 samples were logged");
    assert!(peak_memory() < 50_000_000, "{} bytes", peak_memory());
}
