// The volume in three dimensions: a box of cells in orthographic projection, painted from back to front.
//
// World axes: x is l21, y (depth) is r_l, z (up) is φ22; the box extends from −1 to 1 along each axis.

// Index of the data axis (l21, φ22, r_l) of each world axis.
const WORLD_AXES = [0, 2, 1];

const VIEWS = {
  corner: { turn: -0.62, tilt: 0.48 },
  front: { turn: 0, tilt: 0 },
  top: { turn: 0, tilt: Math.PI / 2 },
  side: { turn: -Math.PI / 2, tilt: 0 },
};

class Cube {
  constructor(size) {
    // Number of cells along x, y, z.
    this.cells = WORLD_AXES.map((axis) => size[axis]);
    this.view("corner");
  }

  view(name) {
    ({ turn: this.turn, tilt: this.tilt } = VIEWS[name]);
    this.zoom = 1;
  }

  turnBy(turn, tilt) {
    this.turn = Math.atan2(Math.sin(this.turn + turn), Math.cos(this.turn + turn));
    this.tilt = Math.min(Math.max(this.tilt + tilt, -Math.PI / 2), Math.PI / 2);
  }

  zoomBy(factor) {
    this.zoom = Math.min(Math.max(this.zoom * factor, 0.4), 12);
  }

  // The projection to a canvas of a given size, and the direction to the viewer.
  projection(width, height) {
    const [st, ct] = [Math.sin(this.turn), Math.cos(this.turn)];
    const [si, ci] = [Math.sin(this.tilt), Math.cos(this.tilt)];
    const available = Math.max(60, Math.min(width - 120, height - 110));
    const scale = (this.zoom * available) / 3.1;
    const [cx, cy] = [width / 2 + 6, height / 2 + 2];
    const toScreen = (x, y, z) => {
      const across = x * ct - y * st;
      const depth = x * st + y * ct;
      return [cx + scale * across, cy - scale * (z * ci + depth * si)];
    };
    return { toScreen, eye: [-st * ci, -ct * ci, si], scale };
  }

  // Visible faces of the cells from back to front; `cellFill` returns the fill of a world cell, or null if it is empty.
  faces(projection, from, toScreen, cellFill) {
    const { cells } = this;
    const { toScreen: project, eye } = projection;
    const edge = (axis, index) => (2 * index) / cells[axis] - 1;
    const order = [0, 1, 2].map((axis) => {
      const indices = [];
      for (let i = from[axis]; i <= toScreen[axis]; i++) indices.push(i);
      return eye[axis] >= 0 ? indices : indices.reverse();
    });
    const facing = eye.map((component) => (component >= 0 ? 1 : -1));
    const visibleAxes = [0, 1, 2].filter((axis) => Math.abs(eye[axis]) > 1e-9);
    const faces = [];
    for (const z of order[2]) for (const y of order[1]) for (const x of order[0]) {
      const cell = [x, y, z];
      const fill = cellFill(cell);
      if (fill === null) continue;
      for (const axis of visibleAxes) {
        const neighbour = [...cell];
        neighbour[axis] += facing[axis];
        const isInRange = neighbour[axis] >= from[axis] && neighbour[axis] <= toScreen[axis];
        if (isInRange && cellFill(neighbour) !== null) continue;
        faces.push({ cell, axis, fill, corners: this.faceCorners(project, edge, cell, axis, facing[axis]) });
      }
    }
    return faces;
  }

  faceCorners(toScreen, edge, cell, axis, side) {
    const [a, b] = [0, 1, 2].filter((other) => other !== axis);
    return [[0, 0], [1, 0], [1, 1], [0, 1]].map(([da, db]) => {
      const position = [0, 0, 0];
      position[axis] = edge(axis, cell[axis] + (side > 0 ? 1 : 0));
      position[a] = edge(a, cell[a] + da);
      position[b] = edge(b, cell[b] + db);
      return toScreen(...position);
    });
  }
}

function isInsidePolygon([x, y], corners) {
  let isInside = false;
  for (let i = 0, j = corners.length - 1; i < corners.length; j = i++) {
    const [[xi, yi], [xj, yj]] = [corners[i], corners[j]];
    if (yi > y !== yj > y && x < ((xj - xi) * (y - yi)) / (yj - yi) + xi) isInside = !isInside;
  }
  return isInside;
}
