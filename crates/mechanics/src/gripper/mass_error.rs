//! Errors of mass properties.

/// Error for link lengths without valid mass properties.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MassError {
    #[error("{name} is {value}, but must be a finite number above 0: give another value")]
    NotPositive { name: &'static str, value: f64 },
    #[error(
        "the distal body is not a triangle: l22 = {:.4} mm and t22 = {:.4} mm at phi22 = {:.4} deg are collinear, but phi22 \
         must differ from 0 and 180 deg, or the scene must give mass, centre and inertia of the body",
        .l22_m * 1e3, .t22_m * 1e3, .phi22_rad.to_degrees()
    )]
    DegenerateTriangle { phi22_rad: f64, l22_m: f64, t22_m: f64 },
    #[error(
        "body {name} has mass {mass_kg} kg and inertia {inertia_kg_m2} kg m², but both must be finite and \
         above 0: check lengths, density and depth"
    )]
    OutOfRange { name: &'static str, mass_kg: f64, inertia_kg_m2: f64 },
}
