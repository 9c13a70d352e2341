//! What may touch in a system: the contacts of its samples, in their order.

use super::{Partner, Place, Side, System};
use crate::gripper::Site;
use crate::law::{FrictionLaw, NormalLaw};

/// Two surfaces that may touch, or the stop of a joint. Discs are told by their indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Touching {
    /// A phalanx and a disc.
    Phalanx(Side, Site, usize),
    Stop(Side),
    /// Two discs, the first of which moves.
    Discs(usize, usize),
    /// A disc on palm or ground.
    Palm(usize),
    Table(usize),
}

impl System {
    /// Everything that may touch. Where there are fingers, first the places of [`System::places`] with the first disc, whether or not
    /// anything is there; then every other disc's with them; then pairs of discs, and without fingers these alone.
    pub fn touching(&self) -> Vec<Touching> {
        let pairs = self.pairs().into_iter().map(|pair| match pair.partner {
            Partner::Disc(other) => Touching::Discs(pair.disc, other),
            Partner::HalfPlane => Touching::Palm(pair.disc),
        });
        let tables = |from: usize| {
            let moving = (from..self.discs.len()).filter(|disc| self.discs[*disc].motion.moves());
            moving.filter(|_| self.table.is_some()).map(Touching::Table)
        };
        if self.fingers.is_empty() {
            return pairs.chain(tables(0)).collect();
        }
        let mut all: Vec<Touching> = self.places().iter().map(|place| place.touching(0)).collect();
        let sites = |(side, disc)| [Site::Proximal, Site::Distal].map(|site| Touching::Phalanx(side, site, disc));
        let others = (1..self.discs.len()).flat_map(|disc| self.sided().map(move |(side, _)| (side, disc)));
        all.extend(others.flat_map(sites));
        // The palm and the table of the first disc are among the places of two fingers.
        let told = |touching: &Touching| self.fingers.len() > 1 && matches!(touching, Touching::Palm(0));
        all.extend(pairs.filter(|touching| !told(touching)));
        all.extend(tables(usize::from(self.fingers.len() > 1)));
        all
    }

    /// Name of a contact in reports, keys and topics: `distal`, `left_distal`, `hammer-anvil`, `hammer-plane`; with fingers, `ball-distal`
    /// of all discs but the first.
    pub fn touching_name(&self, touching: Touching) -> String {
        let (disc, other) = match touching {
            Touching::Phalanx(side, site, disc) => (disc, self.place_name(Place::Finger(side, site))),
            Touching::Stop(side) => return self.place_name(Place::Finger(side, Site::Limit)),
            Touching::Discs(disc, other) => (disc, self.discs[other].name.clone()),
            Touching::Palm(disc) if self.fingers.is_empty() => (disc, "plane".to_string()),
            Touching::Palm(disc) => (disc, Place::Palm.name()),
            Touching::Table(disc) => (disc, Place::Table.name()),
        };
        let is_place = self.places().iter().any(|place| place.touching(0) == touching);
        if is_place { other } else { format!("{}-{other}", self.discs[disc].name) }
    }

    /// The laws of a contact; `None` where nothing is there to touch.
    pub fn laws(&self, touching: Touching) -> Option<(NormalLaw, Option<FrictionLaw>)> {
        let law = match touching {
            Touching::Stop(side) => return self.finger(side).limit.map(|normal| (normal, None)),
            Touching::Phalanx(side, site, disc) => self.discs.get(disc).and_then(|_| self.finger(side).law(site)),
            Touching::Discs(..) => self.between_discs,
            Touching::Palm(disc) => self.discs.get(disc).and(self.palm).and_then(|palm| palm.contact),
            Touching::Table(disc) => self.discs.get(disc).and(self.table).and_then(|table| table.contact),
        };
        law.map(|law| (law.normal, law.friction))
    }

    /// The narrowest range of slip of a friction law, m/s; infinite without friction.
    pub fn narrowest_friction_m_s(&self) -> f64 {
        let laws = self.touching().into_iter().filter_map(|touching| self.laws(touching)?.1);
        laws.map(|friction| friction.finest_m_s()).fold(f64::INFINITY, f64::min)
    }
}

impl Place {
    /// What touches there, of a disc.
    pub fn touching(self, disc: usize) -> Touching {
        match self {
            Place::Finger(side, Site::Limit) => Touching::Stop(side),
            Place::Finger(side, site) => Touching::Phalanx(side, site, disc),
            Place::Palm => Touching::Palm(disc),
            Place::Table => Touching::Table(disc),
        }
    }
}

impl Touching {
    /// Whether it is the stop of a joint, whose gap is an angle.
    pub fn is_stop(self) -> bool {
        matches!(self, Touching::Stop(_))
    }
}
