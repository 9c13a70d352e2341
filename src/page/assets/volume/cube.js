// The volume in three dimensions: a box of cells, seen without perspective, painted from the back to the front.
//
// Axes of the world: x is l21, y is r_l into the depth, z is φ22 upwards; the box is −1 … 1 along each.

// Which axis of the data each axis of the world is: l21, r_l, φ22 of (l21, φ22, r_l).
const WORLD = [0, 2, 1];

const VIEWS = {
  corner: { turn: -0.62, tilt: 0.48 },
  front: { turn: 0, tilt: 0 },
  top: { turn: 0, tilt: Math.PI / 2 },
  side: { turn: -Math.PI / 2, tilt: 0 },
};

class Cube {
  constructor(size) {
    // Cells along x, y, z.
    this.cells = WORLD.map((axis) => size[axis]);
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

  // The map to a canvas of a size, and the direction to the eye.
  projection(width, height) {
    const [st, ct] = [Math.sin(this.turn), Math.cos(this.turn)];
    const [si, ci] = [Math.sin(this.tilt), Math.cos(this.tilt)];
    const room = Math.max(60, Math.min(width - 120, height - 110));
    const scale = (this.zoom * room) / 3.1;
    const [cx, cy] = [width / 2 + 6, height / 2 + 2];
    const to = (x, y, z) => {
      const across = x * ct - y * st;
      const deep = x * st + y * ct;
      return [cx + scale * across, cy - scale * (z * ci + deep * si)];
    };
    return { to, eye: [-st * ci, -ct * ci, si], scale };
  }

  // Faces of the cells that are seen, from the back to the front: `shown` says the colour of a cell of the world, or null.
  faces(projection, from, to, shown) {
    const { cells } = this;
    const { to: place, eye } = projection;
    const edge = (axis, index) => (2 * index) / cells[axis] - 1;
    const order = [0, 1, 2].map((axis) => {
      const list = [];
      for (let i = from[axis]; i <= to[axis]; i++) list.push(i);
      return eye[axis] >= 0 ? list : list.reverse();
    });
    const near = eye.map((part) => (part >= 0 ? 1 : -1));
    const seen = [0, 1, 2].filter((axis) => Math.abs(eye[axis]) > 1e-9);
    const faces = [];
    for (const z of order[2]) for (const y of order[1]) for (const x of order[0]) {
      const cell = [x, y, z];
      const fill = shown(cell);
      if (fill === null) continue;
      for (const axis of seen) {
        const beside = [...cell];
        beside[axis] += near[axis];
        const inside = beside[axis] >= from[axis] && beside[axis] <= to[axis];
        if (inside && shown(beside) !== null) continue;
        faces.push({ cell, axis, fill, corners: this.face(place, edge, cell, axis, near[axis]) });
      }
    }
    return faces;
  }

  face(place, edge, cell, axis, side) {
    const [a, b] = [0, 1, 2].filter((other) => other !== axis);
    return [[0, 0], [1, 0], [1, 1], [0, 1]].map(([da, db]) => {
      const at = [0, 0, 0];
      at[axis] = edge(axis, cell[axis] + (side > 0 ? 1 : 0));
      at[a] = edge(a, cell[a] + da);
      at[b] = edge(b, cell[b] + db);
      return place(...at);
    });
  }
}

function inside([x, y], corners) {
  let within = false;
  for (let i = 0, j = corners.length - 1; i < corners.length; j = i++) {
    const [[xi, yi], [xj, yj]] = [corners[i], corners[j]];
    if (yi > y !== yj > y && x < ((xj - xi) * (y - yi)) / (yj - yi) + xi) within = !within;
  }
  return within;
}
