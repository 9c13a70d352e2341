//! Building, sizing, closing and solving a design allocates memory only for the form-closure certificate.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

use phalanx::scene::Template;
use phalanx::sizing::Rule;
use phalanx::statics::form_closure;
use phalanx::study::volume::{Axes, close_finger, design_at, solve_grasp};

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

#[test]
fn only_the_form_closure_certificate_allocates() {
    let (template, axes) = (Template::thesis(), Axes::thesis([5; 3]));
    for rule in [Rule::Rigid, Rule::Whole] {
        for base_m in [0.012, 0.0155, 0.019, 0.0225] {
            for index in 0..axes.len() {
                let design = design_at(&template, base_m, axes.at(index));
                let before = ALLOCATIONS.get();
                let closed = black_box(close_finger(&template, &design, rule));
                let closed = closed.as_ref().expect("every design of the thesis has a finger");
                for mu_static in [0.0, 0.4, 0.8] {
                    black_box(solve_grasp(closed, mu_static)).expect("an equilibrium");
                }
                let total = ALLOCATIONS.get() - before;
                let before = ALLOCATIONS.get();
                drop(black_box(form_closure(&closed.finger, &closed.end)));
                assert_eq!(total, ALLOCATIONS.get() - before, "base {base_m}, point {index}");
            }
        }
    }
    let before = ALLOCATIONS.get();
    drop(black_box(vec![1u8]));
    assert!(ALLOCATIONS.get() > before, "allocations are counted");
}
