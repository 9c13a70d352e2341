// Outlines of shapes on the screen, fine enough at any zoom.

// A point of a body in the world.
function placed([x, y], px, py, angle) {
  const [s, c] = [Math.sin(angle), Math.cos(angle)];
  return [px + c * x - s * y, py + s * x + c * y];
}

// Corners of the box of a shape in its own frame.
function corners(shape) {
  const around = ([x, y], r) => [[x - r, y], [x + r, y], [x, y - r], [x, y + r]];
  switch (shape.kind) {
    case "polygon": return shape.corners_m;
    case "capsule": return [...around(shape.from_m, shape.radius_m), ...around(shape.to_m, shape.radius_m)];
    case "disc": return around([0, 0], shape.radius_m);
    default: return [];
  }
}

// Points of an arc on the screen, from one angle to another. Of a circle much larger than the view only the part in
// view has points, for a whole circle in few chords would lie beside itself.
function arc(points, centre, radius, from, to, view) {
  const middle = Math.atan2(centre[1] - view.height / 2, view.width / 2 - centre[0]);
  const far = radius > 4 * (view.width + view.height);
  const half = far ? 3 * (view.width + view.height) / radius : Math.PI;
  const count = far ? 96 : Math.max(12, Math.min(160, Math.ceil(radius * Math.abs(to - from) / 3)));
  const at = (angle) => points.push([centre[0] + radius * Math.cos(angle), centre[1] - radius * Math.sin(angle)]);
  if (!far) {
    for (let k = 0; k <= count; k++) at(from + (to - from) * k / count);
    return;
  }
  // The coarse ends outside the view, and the visible piece between them, if this arc has it.
  at(from);
  const turn = Math.round((0.5 * (from + to) - middle) / (2 * Math.PI)) * 2 * Math.PI;
  const [low, high] = [Math.max(from, middle + turn - half), Math.min(to, middle + turn + half)];
  for (let k = 0; k <= 8; k++) if (from + (low - from) * k / 8 < low) at(from + (low - from) * k / 8);
  if (low < high) for (let k = 0; k <= count; k++) at(low + (high - low) * k / count);
  for (let k = 1; k <= 8; k++) if (high < to) at(high + (to - high) * k / 8);
  at(to);
}

// Outline of a shape on the screen, as corners of a closed polygon.
function outline(shape, x, y, angle, view) {
  const world = (point) => view.to(placed(point, x, y, angle));
  const points = [];
  switch (shape.kind) {
    case "polygon":
      return shape.corners_m.map(world);
    case "disc":
      arc(points, view.to([x, y]), shape.radius_m * view.scale, angle, angle + 2 * Math.PI, view);
      return points;
    case "capsule": {
      const [[ax, ay], [bx, by]] = [shape.from_m, shape.to_m];
      const along = Math.atan2(by - ay, bx - ax) + angle;
      const radius = shape.radius_m * view.scale;
      arc(points, world(shape.to_m), radius, along - Math.PI / 2, along + Math.PI / 2, view);
      arc(points, world(shape.from_m), radius, along + Math.PI / 2, along + 1.5 * Math.PI, view);
      return points;
    }
    case "half_plane": {
      // Solid below its level, however the body is turned; it reaches beyond the view on all sides.
      const [cx, cy] = view.to(placed([0, shape.level_m], x, y, angle));
      const reach = Math.abs(cx) + Math.abs(cy) + 2 * (view.width + view.height);
      const [along, below] = [[reach * Math.cos(angle), -reach * Math.sin(angle)], [reach * Math.sin(angle), reach * Math.cos(angle)]];
      return [[-1, 0], [1, 0], [1, 1], [-1, 1]].map(([a, b]) => [0, 1].map((i) => [cx, cy][i] + a * along[i] + b * below[i]));
    }
    default:
      return points;
  }
}

// Makes the part of an outline that is in view the path of a canvas; edges along the edge of the view lie outside it.
function trace(ctx, points, view) {
  ctx.beginPath();
  clipped(points, view.box).forEach(([x, y], index) => (index === 0 ? ctx.moveTo(x, y) : ctx.lineTo(x, y)));
  ctx.closePath();
}
