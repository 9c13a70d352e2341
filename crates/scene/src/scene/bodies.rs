//! A scene of kind "bodies": discs and a half plane instead of a finger, to see the contact laws by themselves.

use super::{BodiesBounds, Engine, Integrator, LogRates};
use crate::law::ContactLaw;

/// A resolved scene of discs, in SI: everything a model needs. At least one disc moves, and names differ.
#[derive(Clone, Debug, PartialEq)]
pub struct BodiesScene {
    pub name: String,
    /// What the scene is for, in the user's words; empty if nothing was said.
    pub description: String,
    /// The exact text of the file, kept for the log's attachment.
    pub source: String,
    /// In the order of their names.
    pub discs: Vec<NamedDisc>,
    pub half_plane: Option<HalfPlane>,
    /// Law of every pair of surfaces.
    pub contact: ContactLaw,
    pub gravity_m_s2: [f64; 2],
    pub duration_s: f64,
    pub integrator: Integrator,
    pub engine: Engine,
    pub bounds: BodiesBounds,
    pub log: LogRates,
}

/// A disc and how it moves.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedDisc {
    pub name: String,
    pub radius_m: f64,
    /// Where its centre starts.
    pub centre_m: [f64; 2],
    pub motion: DiscMotion,
}

/// What moves a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DiscMotion {
    Fixed,
    /// Moves as told, whatever it meets: x(t) = centre + velocity t + ½ acceleration t², angle = spin t.
    Driven {
        velocity_m_s: [f64; 2],
        acceleration_m_s2: [f64; 2],
        spin_rad_s: f64,
    },
    /// Moves under gravity and contact. `inertia_kg_m2` is `None` for a disc that does not turn.
    Free {
        mass_kg: f64,
        inertia_kg_m2: Option<f64>,
        velocity_m_s: [f64; 2],
        spin_rad_s: f64,
    },
}

/// Everything below y = level; it does not move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfPlane {
    pub level_m: f64,
}

/// Two surfaces that may meet; the first is a disc that moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair {
    /// Index of a disc.
    pub disc: usize,
    pub partner: Partner,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partner {
    /// Another disc, by its index.
    Disc(usize),
    HalfPlane,
}

impl DiscMotion {
    pub fn moves(&self) -> bool {
        !matches!(self, DiscMotion::Fixed)
    }
}

impl BodiesScene {
    /// Whether friction holds.
    pub fn holds(&self) -> bool {
        self.contact.bristle().is_some()
    }

    /// Every pair of surfaces of which at least one moves, in the order both models count their contacts: by the index of
    /// the first disc, then of the second, the half plane last.
    pub fn pairs(&self) -> Vec<Pair> {
        let mut pairs = Vec::new();
        for (i, first) in self.discs.iter().enumerate() {
            for (j, second) in self.discs.iter().enumerate().skip(i + 1) {
                match (first.motion.moves(), second.motion.moves()) {
                    (true, _) => pairs.push(Pair { disc: i, partner: Partner::Disc(j) }),
                    (false, true) => pairs.push(Pair { disc: j, partner: Partner::Disc(i) }),
                    (false, false) => {}
                }
            }
            if self.half_plane.is_some() && first.motion.moves() {
                pairs.push(Pair { disc: i, partner: Partner::HalfPlane });
            }
        }
        pairs
    }

    /// Name of a pair in reports, keys and topics: `hammer-anvil`, `hammer-plane`.
    pub fn pair_name(&self, pair: Pair) -> String {
        let partner = match pair.partner {
            Partner::Disc(index) => &self.discs[index].name,
            Partner::HalfPlane => "plane",
        };
        format!("{}-{partner}", self.discs[pair.disc].name)
    }
}

/// A scene of any kind.
#[derive(Clone, Debug, PartialEq)]
pub enum AnyScene {
    Finger(Box<super::Scene>),
    Bodies(Box<BodiesScene>),
    Gripper(Box<super::GripperScene>),
}
