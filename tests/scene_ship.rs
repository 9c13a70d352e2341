//! The shipped scenes load, resolve as documented, and survive being shown and read again.

use phalanx::scene;

#[test]
fn anchor_has_the_lengths_masses_and_start_of_design_95() {
    let anchor = scene::load("scenes/experiment-95.toml").unwrap_or_else(|e| panic!("{e}"));
    let l = anchor.finger.lengths;
    let expected = [15e-3, 22.3628e-3, 24.4324e-3, 7.5e-3, 12.8566e-3];
    for (got, want) in [l.l11_m, l.l12_m, l.l21_m, l.l22_m, l.t22_m].into_iter().zip(expected) {
        assert!((got - want).abs() < 5e-8, "{got} {want}");
    }
    let b = anchor.finger.bodies;
    for (body, grams) in [(b.l11, 4.28), (b.l21, 6.30), (b.l12, 5.86), (b.l22, 8.21)] {
        assert!((body.mass_kg * 1e3 - grams).abs() < 5e-3, "{body:?}");
    }
    assert!((anchor.initial.q11_rad.to_degrees() + 49.999).abs() < 1e-3);
    assert!((anchor.initial.q21_rad.to_degrees() - 40.001).abs() < 1e-3);
}
