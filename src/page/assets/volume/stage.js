// Draws the volume with its box and axis labels, and finds the cell under the pointer.

// Brightness of faces normal to x, y and z; close to 1, so that colours match the scale.
const FACE_BRIGHTNESS = [0.93, 0.97, 1];

class Stage {
  constructor(canvas, data) {
    this.canvas = canvas;
    this.data = data;
    this.cube = new Cube(data.size);
    this.faces = [];
  }

  // `app` determines the coloured region, the dark cells and the outlined cells.
  draw(app) {
    const { ctx, width, height } = clearCanvas(this.canvas);
    const projection = this.cube.projection(width, height);
    const { volume, scale } = app;
    const region = REGIONS[app.region];
    const [from, to] = [WORLD_AXES.map((axis) => app.slices[axis][0]), WORLD_AXES.map((axis) => app.slices[axis][1])];
    const cellFill = (cell) => {
      const n = this.data.index(dataCell(cell));
      if (!volume.hasFinger[n]) return null;
      if (region(volume.flags[n])) return n;
      return app.rest ? -1 : null;
    };
    this.faces = this.cube.faces(projection, from, to, cellFill);
    this.drawBox(ctx, projection, false);
    const [dark, darkEdge, cellEdge] = [parseHex(colour("unstable")), colour("soft"), colour("cell-edge")];
    ctx.lineWidth = 0.7;
    for (const face of this.faces) {
      const cellColour = face.fill >= 0 ? scale.colour(volume.values[face.fill]) : dark;
      const brightness = FACE_BRIGHTNESS[face.axis];
      ctx.fillStyle = `rgb(${cellColour.map((channel) => Math.round(channel * brightness)).join(",")})`;
      tracePolygon(ctx, face.corners);
      ctx.fill();
      ctx.strokeStyle = face.fill >= 0 ? cellEdge : darkEdge;
      ctx.stroke();
    }
    this.drawBox(ctx, projection, true);
    this.drawAxisLabels(ctx, projection);
    for (const [cell, colourName, lineWidth] of [[app.at, "ink", 3], [app.hover, "accent", 3]]) if (cell) this.outlineCell(ctx, projection, cell, colourName, lineWidth);
  }

  // The data cell of the frontmost face at a point of the canvas, or null.
  cellAt(point) {
    for (let n = this.faces.length - 1; n >= 0; n--) if (isInsidePolygon(point, this.faces[n].corners)) return dataCell(this.faces[n].cell);
    return null;
  }

  // The centre of a cell on the canvas.
  cellCentre(cell) {
    const { clientWidth, clientHeight } = this.canvas;
    const position = worldCell(cell).map((index, axis) => (2 * index + 1) / this.cube.cells[axis] - 1);
    return this.cube.projection(clientWidth, clientHeight).toScreen(...position);
  }

  outlineCell(ctx, projection, cell, colourName, lineWidth) {
    const { cube } = this;
    const edge = (axis, index) => (2 * index) / cube.cells[axis] - 1;
    for (const [stroke, width] of [[colour("panel"), lineWidth + 2], [colour(colourName), lineWidth]]) {
      ctx.strokeStyle = stroke;
      ctx.lineWidth = width;
      for (const axis of [0, 1, 2]) {
        tracePolygon(ctx, cube.faceCorners(projection.toScreen, edge, worldCell(cell), axis, projection.eye[axis] >= 0 ? 1 : -1));
        ctx.stroke();
      }
    }
  }

  // Draws the back edges of the box before the cells, or its front edges after them.
  drawBox(ctx, projection, front) {
    ctx.strokeStyle = colour(front ? "soft" : "line");
    ctx.lineWidth = 1;
    for (const axis of [0, 1, 2]) {
      const [a, b] = [0, 1, 2].filter((other) => other !== axis);
      for (const sa of [-1, 1]) for (const sb of [-1, 1]) {
        const isFront = sa * projection.eye[a] > 1e-9 || sb * projection.eye[b] > 1e-9;
        if (isFront !== front) continue;
        const textExtents = [-1, 1].map((end) => {
          const position = [0, 0, 0];
          [position[axis], position[a], position[b]] = [end, sa, sb];
          return projection.toScreen(...position);
        });
        ctx.beginPath();
        ctx.moveTo(...textExtents[0]);
        ctx.lineTo(...textExtents[1]);
        ctx.stroke();
      }
    }
  }

  // Draws names and values of the axes outside the box.
  drawAxisLabels(ctx, projection) {
    const { eye, toScreen } = projection;
    this.nameExtents = [];
    const centre = toScreen(0, 0, 0);
    const sideZ = eye[2] >= -1e-9 ? -1 : 1;
    const isTopView = Math.abs(eye[2]) > 1 - 1e-9;
    const side = (axis) => (eye[axis] >= 0 ? 1 : -1);
    for (const axis of [0, 1, 2]) {
      if (Math.abs(eye[axis]) > 1 - 1e-9) continue;
      // The edge of the box next to the labels.
      const position = [0, 0, 0];
      if (axis === 2) {
        const leftmost = [[-1, -1], [-1, 1], [1, -1], [1, 1]].map(([x, y]) => [toScreen(x, y, 0)[0], x, y]).sort((p, q) => p[0] - q[0])[0];
        [position[0], position[1]] = [leftmost[1], leftmost[2]];
      } else {
        const other = 1 - axis;
        position[2] = sideZ;
        // Seen from above, the nearer edges are the outer ones; from vertically above, the left and the lower edge.
        position[other] = isTopView ? -1 : side(other);
      }
      const data = this.data.axes[WORLD_AXES[axis]];
      const edgePoint = (coordinate) => {
        const point = [...position];
        point[axis] = coordinate;
        return toScreen(...point);
      };
      const [sx, sy] = edgePoint(0);
      let [ox, oy] = [sx - centre[0], sy - centre[1]];
      const [p, q] = [edgePoint(-1), edgePoint(1)];
      // The direction away from the box, normal to the edge.
      const along = [q[0] - p[0], q[1] - p[1]];
      const edgeLength = Math.hypot(...along);
      if (edgeLength < 24) continue;
      let normal = [-along[1] / edgeLength, along[0] / edgeLength];
      if (normal[0] * ox + normal[1] * oy < 0) normal = normal.map((coordinate) => -coordinate);
      const align = normal[0] > 0.4 ? "left" : normal[0] < -0.4 ? "right" : "center";
      const cells = this.cube.cells[axis];
      const lastCentre = cells > 1 ? 1 - 1 / cells : 0;
      const ticks = cells > 1 ? [[-lastCentre, data.values[0]], [0, 0.5 * (data.values[0] + data.values.at(-1))], [lastCentre, data.values.at(-1)]] : [[0, data.values[0]]];
      for (const [coordinate, value] of ticks) {
        const [x, y] = edgePoint(coordinate);
        drawLabel(ctx, formatAxisValue(data, value), x + 9 * normal[0], y + 12 * normal[1], "soft", align);
      }
      const distance = align === "center" ? 32 : 62;
      const nameWidth = ctx.measureText(data.name).width;
      const textExtents = { left: [0, nameWidth], right: [nameWidth, 0], center: [nameWidth / 2, nameWidth / 2] }[align];
      // On a narrow screen, the name is shifted into the canvas.
      const canvasWidth = this.canvas.clientWidth;
      const x = Math.min(Math.max(sx + distance * normal[0], textExtents[0] + 4), canvasWidth - textExtents[1] - 4);
      const y = sy + (align === "center" ? 30 : 34) * normal[1] + (align === "center" ? 0 : 14);
      drawLabel(ctx, data.name, x, y, "ink", align);
      this.nameExtents.push([x - textExtents[0], x + textExtents[1]]);
    }
  }
}

const dataCell = ([x, y, z]) => [x, z, y];
const worldCell = ([l21, phi22, arm]) => [l21, arm, phi22];

function tracePolygon(ctx, corners) {
  ctx.beginPath();
  corners.forEach(([x, y], index) => (index ? ctx.lineTo(x, y) : ctx.moveTo(x, y)));
  ctx.closePath();
}

// Formats a value of an axis.
function formatAxisValue(axis, value) {
  const displayed = axis.unit === "rad" ? value * DEGREE : value;
  const text = Number(displayed.toFixed(axis.unit === "rad" ? 2 : 3)).toString();
  return withMinusSign(text) + (axis.unit === "rad" ? "°" : "");
}
