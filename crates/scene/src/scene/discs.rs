//! A scene of discs, to study contact laws alone, and its mechanism.

use super::builder::{add_disc, add_outline, body};
use crate::law::ContactLaw;
use crate::mechanism::{Body, ContactPair, ForcePoint, Mechanism, OutlineId, OutlineShape, PrescribedMotion};

/// Name of the half plane in pairs.
pub(super) const PLANE: &str = "plane";

/// Discs above a half plane with one contact law.
#[derive(Clone, Debug, PartialEq)]
pub struct Discs {
    /// Discs in the order of their names.
    pub discs: Vec<Disc>,
    /// Height of the surface of a solid half plane below the discs, at rest; `None` without a half plane.
    pub half_plane_m: Option<f64>,
    pub law: ContactLaw,
    pub gravity_m_s2: [f64; 2],
}

#[derive(Clone, Debug, PartialEq)]
pub struct Disc {
    pub name: String,
    pub radius_m: f64,
    /// Initial position of the centre.
    pub centre_m: [f64; 2],
    pub motion: DiscMotion,
}

/// Motion of a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DiscMotion {
    Fixed,
    /// Prescribed motion, not affected by contacts: x(t) = centre + velocity t + ½ acceleration t², angle = spin t.
    Driven {
        velocity_m_s: [f64; 2],
        acceleration_m_s2: [f64; 2],
        spin_rad_s: f64,
    },
    /// Moves under gravity and contact forces. `inertia_kg_m2` is `None` for a disc that does not rotate.
    Free {
        mass_kg: f64,
        inertia_kg_m2: Option<f64>,
        velocity_m_s: [f64; 2],
        spin_rad_s: f64,
    },
}

impl DiscMotion {
    pub fn moves(&self) -> bool {
        !matches!(self, DiscMotion::Fixed)
    }
}

impl Disc {
    /// The body of a moving disc.
    fn body(&self) -> Option<Body> {
        let [x, y] = self.centre_m;
        let at_rates = |[vx, vy]: [f64; 2], spin| body(self.name.clone(), [0.0; 2], [x, y, 0.0], [vx, vy, spin]);
        match self.motion {
            DiscMotion::Fixed => None,
            DiscMotion::Driven { velocity_m_s, acceleration_m_s2, spin_rad_s } => Some(Body {
                motion: Some(PrescribedMotion::ConstantAcceleration { acceleration_m_s2 }),
                ..at_rates(velocity_m_s, spin_rad_s)
            }),
            DiscMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s } => {
                let inertia_kg_m2 = inertia_kg_m2.unwrap_or(f64::INFINITY);
                Some(Body { mass_kg, inertia_kg_m2, ..at_rates(velocity_m_s, spin_rad_s) })
            }
        }
    }
}

impl Discs {
    /// Returns the mechanism: moving discs are bodies; fixed ones and the half plane are outlines of the ground.
    pub fn mechanism(&self) -> Mechanism {
        let mut mechanism = Mechanism { gravity_m_s2: self.gravity_m_s2, ..Mechanism::default() };
        let outline = |disc: &Disc| add_disc(&mut mechanism, &disc.name, disc.radius_m, disc.centre_m, disc.body());
        let outlines: Vec<OutlineId> = self.discs.iter().map(outline).collect();
        let half_plane = self.half_plane_m.map(|level_m| {
            let shape = OutlineShape::HalfPlane { point_m: [0.0, level_m], normal: [0.0, 1.0] };
            add_outline(&mut mechanism, None, PLANE, shape)
        });
        // Pairs by the index of the first disc, then of the second, with the half plane last. The first surface moves.
        let mut add = |disc: usize, face: OutlineId, other: &str| {
            mechanism.contacts.push(ContactPair {
                name: Some(format!("{}-{other}", self.discs[disc].name)),
                points: outlines[disc],
                face,
                law: self.law,
                rolling: None,
                // Each disc has the contact point on its own surface, as in the thesis.
                force_point: ForcePoint::Each,
                is_reported_on_face: false,
            });
        };
        for (i, first) in self.discs.iter().enumerate() {
            for (j, second) in self.discs.iter().enumerate().skip(i + 1) {
                match (first.motion.moves(), second.motion.moves()) {
                    (true, _) => add(i, outlines[j], &second.name),
                    (false, true) => add(j, outlines[i], &first.name),
                    (false, false) => {}
                }
            }
            if let Some(plane) = half_plane
                && first.motion.moves()
            {
                add(i, plane, PLANE);
            }
        }
        mechanism
    }
}
