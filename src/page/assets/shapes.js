// Outlines of shapes on the screen, with sufficient resolution at any zoom.

// Transforms a point from body to world coordinates.
function toWorld([x, y], px, py, angle) {
  const [s, c] = [Math.sin(angle), Math.cos(angle)];
  return [px + c * x - s * y, py + s * x + c * y];
}

// Extreme points of a shape in its own frame, for bounding boxes.
function boundingPoints(shape) {
  const circleExtent = ([x, y], r) => [[x - r, y], [x + r, y], [x, y - r], [x, y + r]];
  switch (shape.kind) {
    case "polygon": return shape.corners_m;
    case "capsule": return [...circleExtent(shape.from_m, shape.radius_m), ...circleExtent(shape.to_m, shape.radius_m)];
    case "disc": return circleExtent([0, 0], shape.radius_m);
    default: return [];
  }
}

// Appends the points of an arc on the screen. For a circle much larger than the view, the points are concentrated in
// the view, because few chords around the whole circle would deviate visibly.
function appendArc(points, centre, radius, from, to, view) {
  const middle = Math.atan2(centre[1] - view.height / 2, view.width / 2 - centre[0]);
  const isHuge = radius > 4 * (view.width + view.height);
  const halfAngle = isHuge ? 3 * (view.width + view.height) / radius : Math.PI;
  const count = isHuge ? 96 : Math.max(12, Math.min(160, Math.ceil(radius * Math.abs(to - from) / 3)));
  const addPoint = (angle) => points.push([centre[0] + radius * Math.cos(angle), centre[1] - radius * Math.sin(angle)]);
  if (!isHuge) {
    for (let k = 0; k <= count; k++) addPoint(from + (to - from) * k / count);
    return;
  }
  // Coarse ends outside the view, with the visible section between them if the arc contains it.
  addPoint(from);
  const offset = Math.round((0.5 * (from + to) - middle) / (2 * Math.PI)) * 2 * Math.PI;
  const [low, high] = [Math.max(from, middle + offset - halfAngle), Math.min(to, middle + offset + halfAngle)];
  for (let k = 0; k <= 8; k++) if (from + (low - from) * k / 8 < low) addPoint(from + (low - from) * k / 8);
  if (low < high) for (let k = 0; k <= count; k++) addPoint(low + (high - low) * k / count);
  for (let k = 1; k <= 8; k++) if (high < to) addPoint(high + (to - high) * k / 8);
  addPoint(to);
}

// Outline of a shape on the screen as a closed polygon.
function shapeOutline(shape, x, y, angle, view) {
  const screenPoint = (point) => view.toScreen(toWorld(point, x, y, angle));
  const screenAngle = angle + view.angle;
  const points = [];
  switch (shape.kind) {
    case "polygon":
      return shape.corners_m.map(screenPoint);
    case "disc":
      appendArc(points, view.toScreen([x, y]), shape.radius_m * view.scale, screenAngle, screenAngle + 2 * Math.PI, view);
      return points;
    case "capsule": {
      const [[ax, ay], [bx, by]] = [shape.from_m, shape.to_m];
      const axisAngle = Math.atan2(by - ay, bx - ax) + screenAngle;
      const radius = shape.radius_m * view.scale;
      appendArc(points, screenPoint(shape.to_m), radius, axisAngle - Math.PI / 2, axisAngle + Math.PI / 2, view);
      appendArc(points, screenPoint(shape.from_m), radius, axisAngle + Math.PI / 2, axisAngle + 1.5 * Math.PI, view);
      return points;
    }
    case "half_plane": {
      // Solid below its level in the frame of the body; extends beyond the view on all sides.
      const [cx, cy] = view.toScreen(toWorld([0, shape.level_m], x, y, angle));
      const reach = Math.abs(cx) + Math.abs(cy) + 2 * (view.width + view.height);
      const [cosine, sine] = [reach * Math.cos(screenAngle), reach * Math.sin(screenAngle)];
      const [along, below] = [[cosine, -sine], [sine, cosine]];
      return [[-1, 0], [1, 0], [1, 1], [-1, 1]].map(([a, b]) => [0, 1].map((i) => [cx, cy][i] + a * along[i] + b * below[i]));
    }
    default:
      return points;
  }
}

// Traces the visible part of an outline as the path of a canvas; the box is larger than the view and hides clipped
// edges.
function tracePath(ctx, points, view) {
  ctx.beginPath();
  clipPolygon(points, view.box).forEach(([x, y], index) => (index === 0 ? ctx.moveTo(x, y) : ctx.lineTo(x, y)));
  ctx.closePath();
}
