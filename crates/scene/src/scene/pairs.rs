//! Discs that may meet one another, or the ground.

use super::System;

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

impl System {
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
