//! Placement of labels without overlaps.

/// Coordinates in the picture, in pixels, y downwards.
pub type Point = [f64; 2];

/// A label to be placed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LabelRequest {
    /// Point that the label refers to.
    pub anchor: Point,
    /// Preferred direction from the anchor; of any length but 0.
    pub direction: Point,
    pub width: f64,
    pub height: f64,
}

/// A placed label: its centre and its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LabelBox {
    pub centre: Point,
    pub width: f64,
    pub height: f64,
}

/// Candidate distances between the anchor and the edge of the label, in pixels.
const DISTANCES: [f64; 8] = [5.0, 9.0, 14.0, 21.0, 30.0, 42.0, 58.0, 78.0];
/// Number of candidate directions from the anchor to the label.
const DIRECTIONS: usize = 32;
/// Minimum gap between two labels, in pixels.
const LABEL_GAP: f64 = 3.0;

impl LabelBox {
    fn bounds(&self, margin: f64) -> [f64; 4] {
        let [x, y] = self.centre;
        let (w, h) = (0.5 * self.width + margin, 0.5 * self.height + margin);
        [x - w, y - h, x + w, y + h]
    }

    /// Whether two labels overlap, given a margin.
    pub fn overlaps(&self, other: &LabelBox, margin: f64) -> bool {
        let (a, b) = (self.bounds(margin), other.bounds(0.0));
        a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
    }

    /// Whether the label is within a picture of a size.
    pub fn is_within(&self, [width, height]: [f64; 2]) -> bool {
        let [x0, y0, x1, y1] = self.bounds(0.0);
        x0 >= 0.0 && y0 >= 0.0 && x1 <= width && y1 <= height
    }

    /// Length of a line that the label covers, in pixels.
    fn covered_length(&self, [from, to]: [Point; 2]) -> f64 {
        let [x0, y0, x1, y1] = self.bounds(1.0);
        let along = [to[0] - from[0], to[1] - from[1]];
        // Line clipping by Liang and Barsky.
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

/// Places labels one after the other: near their anchors, in the preferred direction, off the lines of the picture.
/// Labels do not overlap and stay within a picture of that size, unless no candidate satisfies this.
pub(crate) fn place_labels(requests: &[LabelRequest], lines: &[[Point; 2]], size: [f64; 2]) -> Vec<LabelBox> {
    let mut boxes: Vec<LabelBox> = Vec::with_capacity(requests.len());
    for request in requests {
        let others = requests.iter().map(|other| other.anchor);
        let cost = |label_box: &LabelBox| {
            let overlap_count = boxes.iter().filter(|other| label_box.overlaps(other, LABEL_GAP)).count();
            let out = if label_box.is_within(size) { 0.0 } else { 1e6 };
            let covered_length_sum: f64 = lines.iter().map(|line| label_box.covered_length(*line)).sum();
            // Anchors of other labels must stay visible.
            let hidden_anchors = others
                .clone()
                .filter(|anchor| label_box.covered_length([*anchor, [anchor[0] + 0.1, anchor[1]]]) > 0.0)
                .count();
            out + 1e5 * overlap_count as f64 + 4.0 * covered_length_sum + 40.0 * hidden_anchors as f64
        };
        let start = request.direction[1].atan2(request.direction[0]);
        let mut best: Option<(f64, LabelBox)> = None;
        for distance in DISTANCES {
            for k in 0..DIRECTIONS {
                // Alternate to both sides of the preferred direction.
                let turn = (k.div_ceil(2)) as f64 * if k % 2 == 0 { 1.0 } else { -1.0 };
                let turn_cost = 14.0 * ((turn.abs() / DIRECTIONS as f64) * 4.0);
                // The remaining terms of the cost are positive and expensive to evaluate.
                if best.as_ref().is_some_and(|(lowest_cost, _)| distance + turn_cost >= *lowest_cost) {
                    continue;
                }
                let angle = start + turn * std::f64::consts::TAU / DIRECTIONS as f64;
                let (sin, cos) = angle.sin_cos();
                // The label is tangent to a circle about the anchor, from outside.
                let reach = distance + (0.5 * request.width * cos.abs()).max(0.5 * request.height * sin.abs());
                let centre = [request.anchor[0] + reach * cos, request.anchor[1] + reach * sin];
                let label_box = LabelBox { centre, width: request.width, height: request.height };
                let cost = cost(&label_box) + distance + turn_cost;
                if best.as_ref().is_none_or(|(lowest_cost, _)| cost < *lowest_cost) {
                    best = Some((cost, label_box));
                }
            }
        }
        boxes.extend(best.map(|(_, label_box)| label_box));
    }
    boxes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(anchor: Point) -> LabelRequest {
        LabelRequest { anchor, direction: [0.0, -1.0], width: 30.0, height: 16.0 }
    }

    #[test]
    fn places_a_label_in_the_preferred_direction() {
        let boxes = place_labels(&[request([100.0, 100.0])], &[], [200.0, 200.0]);
        assert!((boxes[0].centre[0] - 100.0).abs() < 1e-9 && boxes[0].centre[1] < 92.0, "{boxes:?}");
    }

    #[test]
    fn labels_avoid_lines_and_stay_within_the_picture() {
        let line = [[0.0, 85.0], [200.0, 85.0]];
        let boxes = place_labels(&[request([100.0, 100.0]), request([100.0, 4.0])], &[line], [200.0, 200.0]);
        assert!(boxes[0].covered_length(line) == 0.0 && boxes[0].centre[1] > 85.0, "{boxes:?}");
        assert!(boxes[1].is_within([200.0, 200.0]), "{boxes:?}");
        // The covered length of a line across a label is its width plus the margins.
        let across = LabelBox { centre: [50.0, 85.0], width: 30.0, height: 16.0 };
        assert!((across.covered_length(line) - 32.0).abs() < 1e-9, "{}", across.covered_length(line));
    }
}
