//! Where labels go so that none lies over another.

/// A place in the picture, in pixels, y downwards.
pub type Point = [f64; 2];

/// What a label is to be placed for.
#[derive(Clone, Debug, PartialEq)]
pub struct Wish {
    /// What it names.
    pub anchor: Point,
    /// Where it would best be from there; of any length but 0.
    pub way: Point,
    pub width: f64,
    pub height: f64,
}

/// A placed label: its middle and its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    pub centre: Point,
    pub width: f64,
    pub height: f64,
}

/// Distances from the anchor that are tried, beyond the label's own half.
const DISTANCES: [f64; 8] = [5.0, 9.0, 14.0, 21.0, 30.0, 42.0, 58.0, 78.0];
const DIRECTIONS: usize = 32;
/// Room between two labels.
const ROOM: f64 = 3.0;

impl Spot {
    fn grown(&self, room: f64) -> [f64; 4] {
        let [x, y] = self.centre;
        let (w, h) = (0.5 * self.width + room, 0.5 * self.height + room);
        [x - w, y - h, x + w, y + h]
    }

    /// Whether two labels lie over each other.
    pub fn overlaps(&self, other: &Spot, room: f64) -> bool {
        let (a, b) = (self.grown(room), other.grown(0.0));
        a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
    }

    /// Whether it is within a picture of a size.
    pub fn within(&self, [width, height]: [f64; 2]) -> bool {
        let [x0, y0, x1, y1] = self.grown(0.0);
        x0 >= 0.0 && y0 >= 0.0 && x1 <= width && y1 <= height
    }

    /// How much of a line is under it, in pixels.
    fn covers(&self, [from, to]: [Point; 2]) -> f64 {
        let [x0, y0, x1, y1] = self.grown(1.0);
        let along = [to[0] - from[0], to[1] - from[1]];
        // Liang and Barsky.
        let (mut low, mut high) = (0.0f64, 1.0f64);
        for (p, q) in
            [(-along[0], from[0] - x0), (along[0], x1 - from[0]), (-along[1], from[1] - y0), (along[1], y1 - from[1])]
        {
            if p == 0.0 && q < 0.0 {
                return 0.0;
            }
            if p < 0.0 {
                low = low.max(q / p);
            } else if p > 0.0 {
                high = high.min(q / p);
            }
        }
        (high - low).max(0.0) * along[0].hypot(along[1])
    }
}

/// Places labels one after the other: near what they name, where they were wished, off the lines of the picture, and never
/// over each other or outside of a picture of that size as long as there is any room.
pub fn placed(wishes: &[Wish], lines: &[[Point; 2]], size: [f64; 2]) -> Vec<Spot> {
    let mut spots: Vec<Spot> = Vec::with_capacity(wishes.len());
    for wish in wishes {
        let others = wishes.iter().map(|other| other.anchor);
        let cost = |spot: &Spot| {
            let over = spots.iter().filter(|other| spot.overlaps(other, ROOM)).count();
            let out = if spot.within(size) { 0.0 } else { 1e6 };
            let crossed: f64 = lines.iter().map(|line| spot.covers(*line)).sum();
            // What another label names stays in sight.
            let hidden =
                others.clone().filter(|anchor| spot.covers([*anchor, [anchor[0] + 0.1, anchor[1]]]) > 0.0).count();
            out + 1e5 * over as f64 + 4.0 * crossed + 40.0 * hidden as f64
        };
        let start = wish.way[1].atan2(wish.way[0]);
        let mut best: Option<(f64, Spot)> = None;
        for distance in DISTANCES {
            for k in 0..DIRECTIONS {
                // From the wished direction to both sides.
                let turn = (k.div_ceil(2)) as f64 * if k % 2 == 0 { 1.0 } else { -1.0 };
                let turned = 14.0 * ((turn.abs() / DIRECTIONS as f64) * 4.0);
                // Lines and labels only add to that, and looking at all of them is most of the work.
                if best.as_ref().is_some_and(|(least, _)| distance + turned >= *least) {
                    continue;
                }
                let angle = start + turn * std::f64::consts::TAU / DIRECTIONS as f64;
                let (sin, cos) = angle.sin_cos();
                // The label touches a circle about the anchor from outside.
                let reach = distance + (0.5 * wish.width * cos.abs()).max(0.5 * wish.height * sin.abs());
                let centre = [wish.anchor[0] + reach * cos, wish.anchor[1] + reach * sin];
                let spot = Spot { centre, width: wish.width, height: wish.height };
                let cost = cost(&spot) + distance + turned;
                if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                    best = Some((cost, spot));
                }
            }
        }
        spots.extend(best.map(|(_, spot)| spot));
    }
    spots
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wish(anchor: Point) -> Wish {
        Wish { anchor, way: [0.0, -1.0], width: 30.0, height: 16.0 }
    }

    #[test]
    fn a_label_goes_where_it_is_wished() {
        let spots = placed(&[wish([100.0, 100.0])], &[], [200.0, 200.0]);
        assert!((spots[0].centre[0] - 100.0).abs() < 1e-9 && spots[0].centre[1] < 92.0, "{spots:?}");
    }

    #[test]
    fn labels_of_one_place_lie_beside_each_other() {
        let spots = placed(&vec![wish([100.0, 100.0]); 9], &[], [200.0, 200.0]);
        for (index, one) in spots.iter().enumerate() {
            assert!(one.within([200.0, 200.0]), "{one:?}");
            assert!(spots[index + 1..].iter().all(|other| !one.overlaps(other, 0.0)), "{spots:?}");
        }
    }

    #[test]
    fn a_label_keeps_off_lines_and_inside() {
        let line = [[0.0, 85.0], [200.0, 85.0]];
        let spots = placed(&[wish([100.0, 100.0]), wish([100.0, 4.0])], &[line], [200.0, 200.0]);
        assert!(spots[0].covers(line) == 0.0 && spots[0].centre[1] > 85.0, "{spots:?}");
        assert!(spots[1].within([200.0, 200.0]), "{spots:?}");
        // What covers a line does so by the length that is under it.
        let across = Spot { centre: [50.0, 85.0], width: 30.0, height: 16.0 };
        assert!((across.covers(line) - 32.0).abs() < 1e-9, "{}", across.covers(line));
    }
}
