//! A design is built, sized, closed and held without an allocation, but for the certificate of its form closure.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

use phalanx::scene::Template;
use phalanx::sizing::Rule;
use phalanx::statics::form_closure;
use phalanx::study::volume::{Axes, close, design, hold};

/// The system's allocator, counting what this thread asks of it.
struct Counting;

thread_local! {
    static ASKED: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: everything is handed on to the system's allocator as it is; counting touches a thread-local without a destructor.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ASKED.set(ASKED.get() + 1);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn nothing_allocates_but_the_certificate() {
    let (template, axes) = (Template::thesis(), Axes::thesis([5; 3]));
    for rule in [Rule::Rigid, Rule::Whole] {
        for base_m in [0.012, 0.0155, 0.019, 0.0225] {
            for index in 0..axes.len() {
                let design = design(&template, base_m, axes.at(index));
                let before = ASKED.get();
                let closed = black_box(close(&template, &design, rule));
                let closed = closed.as_ref().expect("every design of the thesis has a finger");
                for mu_static in [0.0, 0.4, 0.8] {
                    black_box(hold(closed, mu_static)).expect("and holds");
                }
                let in_all = ASKED.get() - before;
                let before = ASKED.get();
                drop(black_box(form_closure(&closed.finger, &closed.end)));
                assert_eq!(in_all, ASKED.get() - before, "base {base_m}, point {index}");
            }
        }
    }
    let before = ASKED.get();
    drop(black_box(vec![1u8]));
    assert!(ASKED.get() > before, "the count counts");
}
