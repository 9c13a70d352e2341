// Draws the volume with its box and figures, and finds the cell under a pointer.

// Light on faces across x, y and z: little, so that colours are still those of the scale.
const LIGHT = [0.93, 0.97, 1];

class Stage {
  constructor(canvas, data) {
    this.canvas = canvas;
    this.data = data;
    this.cube = new Cube(data.size);
    this.faces = [];
  }

  // `app` says what is in colour, what is dark and which cells are marked.
  draw(app) {
    const { ctx, width, height } = cleared(this.canvas);
    const projection = this.cube.projection(width, height);
    const { volume, scale } = app;
    const region = REGIONS[app.region];
    const [from, to] = [WORLD.map((axis) => app.slices[axis][0]), WORLD.map((axis) => app.slices[axis][1])];
    const shown = (cell) => {
      const n = this.data.index(dataCell(cell));
      if (!volume.finger[n]) return null;
      if (region(volume.flags[n])) return n;
      return app.rest ? -1 : null;
    };
    this.faces = this.cube.faces(projection, from, to, shown);
    this.box(ctx, projection, false);
    const [dark, darkEdge, cellEdge] = [channels(colour("unstable")), colour("soft"), colour("cell-edge")];
    ctx.lineWidth = 0.7;
    for (const face of this.faces) {
      const own = face.fill >= 0 ? scale.colour(volume.values[face.fill]) : dark;
      const light = LIGHT[face.axis];
      ctx.fillStyle = `rgb(${own.map((channel) => Math.round(channel * light)).join(",")})`;
      outlined(ctx, face.corners);
      ctx.fill();
      ctx.strokeStyle = face.fill >= 0 ? cellEdge : darkEdge;
      ctx.stroke();
    }
    this.box(ctx, projection, true);
    this.figures(ctx, projection);
    for (const [cell, name, wide] of [[app.at, "ink", 3], [app.hover, "accent", 3]]) if (cell) this.mark(ctx, projection, cell, name, wide);
  }

  // The data cell whose face is in front at a place, or null.
  pick(place) {
    for (let n = this.faces.length - 1; n >= 0; n--) if (inside(place, this.faces[n].corners)) return dataCell(this.faces[n].cell);
    return null;
  }

  // Where the middle of a cell is on the canvas.
  middle(cell) {
    const { clientWidth, clientHeight } = this.canvas;
    const at = worldCell(cell).map((index, axis) => (2 * index + 1) / this.cube.cells[axis] - 1);
    return this.cube.projection(clientWidth, clientHeight).to(...at);
  }

  mark(ctx, projection, cell, name, wide) {
    const { cube } = this;
    const edge = (axis, index) => (2 * index) / cube.cells[axis] - 1;
    for (const [stroke, width] of [[colour("panel"), wide + 2], [colour(name), wide]]) {
      ctx.strokeStyle = stroke;
      ctx.lineWidth = width;
      for (const axis of [0, 1, 2]) {
        outlined(ctx, cube.face(projection.to, edge, worldCell(cell), axis, projection.eye[axis] >= 0 ? 1 : -1));
        ctx.stroke();
      }
    }
  }

  // Edges of the whole box: those behind before the cells, those in front after them.
  box(ctx, projection, front) {
    ctx.strokeStyle = colour(front ? "soft" : "line");
    ctx.lineWidth = 1;
    for (const axis of [0, 1, 2]) {
      const [a, b] = [0, 1, 2].filter((other) => other !== axis);
      for (const sa of [-1, 1]) for (const sb of [-1, 1]) {
        const isFront = sa * projection.eye[a] > 1e-9 || sb * projection.eye[b] > 1e-9;
        if (isFront !== front) continue;
        const ends = [-1, 1].map((end) => {
          const at = [0, 0, 0];
          [at[axis], at[a], at[b]] = [end, sa, sb];
          return projection.to(...at);
        });
        ctx.beginPath();
        ctx.moveTo(...ends[0]);
        ctx.lineTo(...ends[1]);
        ctx.stroke();
      }
    }
  }

  // Names and values of the axes, outside the box.
  figures(ctx, projection) {
    const { eye, to } = projection;
    this.names = [];
    const middle = to(0, 0, 0);
    const below = eye[2] >= -1e-9 ? -1 : 1;
    const flat = Math.abs(eye[2]) > 1 - 1e-9;
    const side = (axis) => (eye[axis] >= 0 ? 1 : -1);
    for (const axis of [0, 1, 2]) {
      if (Math.abs(eye[axis]) > 1 - 1e-9) continue;
      // The edge of the box that the figures stand at.
      const at = [0, 0, 0];
      if (axis === 2) {
        const left = [[-1, -1], [-1, 1], [1, -1], [1, 1]].map(([x, y]) => [to(x, y, 0)[0], x, y]).sort((p, q) => p[0] - q[0])[0];
        [at[0], at[1]] = [left[1], left[2]];
      } else {
        const other = 1 - axis;
        at[2] = below;
        // Seen from above, the nearer edges are the outer ones; from straight above, the left and the lower one.
        at[other] = flat ? -1 : side(other);
      }
      const data = this.data.axes[WORLD[axis]];
      const place = (part) => {
        const point = [...at];
        point[axis] = part;
        return to(...point);
      };
      const [sx, sy] = place(0);
      let [ox, oy] = [sx - middle[0], sy - middle[1]];
      const [p, q] = [place(-1), place(1)];
      // Away from the box, across the edge.
      const along = [q[0] - p[0], q[1] - p[1]];
      const long = Math.hypot(...along);
      if (long < 24) continue;
      let normal = [-along[1] / long, along[0] / long];
      if (normal[0] * ox + normal[1] * oy < 0) normal = normal.map((part) => -part);
      const align = normal[0] > 0.4 ? "left" : normal[0] < -0.4 ? "right" : "center";
      const cells = this.cube.cells[axis];
      const half = cells > 1 ? 1 - 1 / cells : 0;
      const ticks = cells > 1 ? [[-half, data.values[0]], [0, 0.5 * (data.values[0] + data.values.at(-1))], [half, data.values.at(-1)]] : [[0, data.values[0]]];
      for (const [part, value] of ticks) {
        const [x, y] = place(part);
        label(ctx, axisText(data, value), x + 9 * normal[0], y + 12 * normal[1], "soft", align);
      }
      const away = align === "center" ? 32 : 62;
      const wide = ctx.measureText(data.name).width;
      const ends = { left: [0, wide], right: [wide, 0], center: [wide / 2, wide / 2] }[align];
      // A narrow screen has no room beside the figures: the name stays within it.
      const room = this.canvas.clientWidth;
      const x = Math.min(Math.max(sx + away * normal[0], ends[0] + 4), room - ends[1] - 4);
      const y = sy + (align === "center" ? 30 : 34) * normal[1] + (align === "center" ? 0 : 14);
      label(ctx, data.name, x, y, "ink", align);
      this.names.push([x - ends[0], x + ends[1]]);
    }
  }
}

const dataCell = ([x, y, z]) => [x, z, y];
const worldCell = ([l21, phi22, arm]) => [l21, arm, phi22];

function outlined(ctx, corners) {
  ctx.beginPath();
  corners.forEach(([x, y], index) => (index ? ctx.lineTo(x, y) : ctx.moveTo(x, y)));
  ctx.closePath();
}

// A value of an axis as people read it.
function axisText(axis, value) {
  const shown = axis.unit === "rad" ? value * DEGREE : value;
  const text = Number(shown.toFixed(axis.unit === "rad" ? 2 : 3)).toString();
  return minus(text) + (axis.unit === "rad" ? "°" : "");
}
