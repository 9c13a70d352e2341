//! Pairs of discs, and of a disc and the ground, that may come into contact.

use super::System;

/// Two surfaces that may come into contact; the first is a moving disc.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair {
    /// Index of a disc.
    pub disc: usize,
    pub partner: Partner,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partner {
    /// Another disc, by index.
    Disc(usize),
    HalfPlane,
}

impl System {
    /// All pairs of surfaces with at least one that moves, in the order of both models: by the index of the first disc,
    /// then of the second, with the half plane last.
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
            if self.palm.is_some() && first.motion.moves() {
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
