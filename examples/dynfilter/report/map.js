// The dense map, drawn point by point into a picture, and turned with the mouse or the keyboard.

const TURN_PER_PIXEL = 0.008, TURN_PER_KEY = 0.15;
const START_TURN = 0.35, START_TILT = 0.55; // radians
const FIT_SHARE = 0.02, FIT_ROOM = 1.08; // points beyond these quantiles may be outside of the first view
const CEILING_ABOVE_M = 0.5; // points so far above the cameras
const MAP_LENS = 1.1; // focal length over half the picture's height

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}
function scaled(v, s) {
  return v.map((x) => x * s);
}
function plus(a, b) {
  return a.map((x, i) => x + b[i]);
}
function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
function unit(v) {
  return scaled(v, 1 / Math.hypot(...v));
}

function middleOf(map, steps) {
  return [0, 1, 2].map((a) => map.low_m[a] + map.step_m * median(steps.filter((_, i) => i % 3 === a)));
}

/** Points relative to `from`, by default their middle. */
function mapPoints(map, from) {
  const steps = new Uint16Array(bytesOf(map.xyz).buffer);
  const points = new Float32Array(steps.length);
  const middle = from || middleOf(map, steps);
  for (let i = 0; i < steps.length; ++i) points[i] = map.low_m[i % 3] + map.step_m * steps[i] - middle[i % 3];
  return { points, colours: bytesOf(map.rgb), middle };
}

/** From the FIT_SHARE quantile to that from the other end. */
function innerRange(values) {
  const sorted = Float64Array.from(values).sort();
  const skipped = Math.floor(FIT_SHARE * sorted.length);
  return [sorted[skipped], sorted[sorted.length - 1 - skipped]];
}

class MapView {
  constructor() {
    this.canvas = element("canvas", { tabindex: 0, role: "application", class: "map", "aria-label": "Map" });
    this.box = element("input", { type: "checkbox", "aria-label": "ceiling", onchange: () => {
      this.hidesCeiling = !this.box.checked;
      this.later();
    } });
    this.switch = element("label", { class: "switch" }, this.box, " ceiling");
    this.caption = element("figcaption", {}, "Map of what does not move", this.switch);
    this.text = element("p", { class: "hint" });
    this.node = element("figure", { class: "map-figure" }, this.caption, this.canvas, this.text);
    this.listenToPointer();
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    listen("frame", () => this.later());
    onResize(this.node, () => this.later());
  }

  load() {
    const map = store.focus.map;
    this.node.hidden = !map;
    if (!map) return;
    if (this.source !== map) {
      // Maps of one sequence are seen from one place, so that they can be compared.
      const same = this.group === store.group;
      this.source = map;
      this.group = store.group;
      Object.assign(this, mapPoints(map, same ? this.middle : null));
      if (!same) this.startView(map);
    }
    this.canvas.setAttribute("aria-label", `Map of ${map.points} points. Arrow keys turn it, plus and minus zoom.`);
    this.text.textContent = `${map.shown.toLocaleString("en")} of ${map.points.toLocaleString("en")} points. ` +
      "Drag or arrow keys: turn. Wheel, pinch, + and −: zoom. The line is the camera's path.";
    this.later();
  }

  startView(map) {
    this.up = unit(map.up);
    this.tilt = START_TILT;
    this.faceFrom(store.focus);
    this.radius = this.shownRadius();
    this.fitView();
  }
  /** Moves the middle of what is seen into the middle of the picture, as near as it fits. */
  fitView() {
    this.target = [0, 0, 0];
    this.distance = this.radius;
    const { right, down, away } = this.camera();
    const seen = { right: [], down: [], away: [] };
    for (let i = 0; i < this.points.length; i += 3) {
      if (this.hidesCeiling && this.height(i) > this.ceiling) continue;
      const p = this.points.subarray(i, i + 3);
      seen.right.push(dot(right, p));
      seen.down.push(dot(down, p));
      seen.away.push(dot(away, p));
    }
    const [left, end] = innerRange(seen.right), [top, bottom] = innerRange(seen.down), [near] = innerRange(seen.away);
    this.target = plus(scaled(right, (left + end) / 2), scaled(down, (top + bottom) / 2));
    const [width, height] = this.size();
    const fits = MAP_LENS * Math.max((bottom - top) / 2, (end - left) / 2 * height / width);
    this.distance = FIT_ROOM * fits - near / 2;
  }
  size() {
    return [Math.max(200, this.canvas.clientWidth), Math.max(200, this.canvas.clientHeight)];
  }

  /** Looks as the run's cameras did, from their places into the middle of the map. Without the ceiling. */
  faceFrom(run) {
    const place = run.position_m.map((axis, a) => median(axis) - this.middle[a]);
    const aside = Math.abs(this.up[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0];
    const level = plus(scaled(place, -1), scaled(this.up, dot(place, this.up)));
    this.north = Math.hypot(...level) > 1e-3 ? unit(level) : unit(cross(aside, this.up));
    this.east = cross(this.north, this.up);
    this.turn = START_TURN;
    this.ceiling = dot(place, this.up) + CEILING_ABOVE_M;
    const above = this.above();
    this.hidesCeiling = above > 0 && above < this.points.length / 6; // else it is no room
    this.switch.hidden = !this.hidesCeiling;
    this.box.checked = !this.hidesCeiling;
  }
  /** How far 90 % of the shown points are from the middle. */
  shownRadius() {
    const distances = [];
    for (let i = 0; i < this.points.length; i += 3)
      if (!this.hidesCeiling || this.height(i) <= this.ceiling) distances.push(Math.hypot(this.points[i], this.points[i + 1], this.points[i + 2]));
    distances.sort((a, b) => a - b);
    return Math.max(0.1, distances[Math.floor(0.9 * (distances.length - 1))]);
  }
  /** How many points are above the cameras by much. */
  above() {
    let n = 0;
    for (let i = 0; i < this.points.length; i += 3) n += this.height(i) > this.ceiling ? 1 : 0;
    return n;
  }
  height(i) {
    return this.points[i] * this.up[0] + this.points[i + 1] * this.up[1] + this.points[i + 2] * this.up[2];
  }

  key(event) {
    const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    if (turns[event.key]) this.rotate(...turns[event.key].map((n) => n * TURN_PER_KEY));
    else if (event.key === "+" || event.key === "=") this.move(1 / ZOOM_STEP);
    else if (event.key === "-") this.move(ZOOM_STEP);
    else return;
    event.preventDefault();
  }
  rotate(turn, tilt) {
    this.turn += turn;
    this.tilt = Math.max(-1.5, Math.min(1.5, this.tilt + tilt));
    this.later();
  }
  move(factor) {
    this.distance = Math.max(0.05 * this.radius, Math.min(20 * this.radius, this.distance * factor));
    this.later();
  }
  listenToPointer() {
    const pointers = new Map();
    this.canvas.addEventListener("pointerdown", (event) => {
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      const last = pointers.get(event.pointerId);
      if (!last) return;
      const here = [event.clientX, event.clientY];
      if (pointers.size === 2) {
        const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
        const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
        if (apart(here) > 0) this.move(apart(last) / apart(here));
      } else this.rotate(-(here[0] - last[0]) * TURN_PER_PIXEL, (here[1] - last[1]) * TURN_PER_PIXEL);
      pointers.set(event.pointerId, here);
    });
    for (const end of ["pointerup", "pointercancel"])
      this.canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
    this.canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.move(event.deltaY < 0 ? 1 / ZOOM_STEP : ZOOM_STEP);
    }, { passive: false });
  }

  /** At most once per picture of the screen. */
  later() {
    if (this.waiting || !this.source || this.node.hidden) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.draw();
    });
  }

  /** Directions of the picture in the world: right, down, away from the viewer; and the viewer's place. */
  camera() {
    const level = plus(scaled(this.north, Math.cos(this.turn)), scaled(this.east, Math.sin(this.turn)));
    const away = unit(plus(scaled(level, Math.cos(this.tilt)), scaled(this.up, -Math.sin(this.tilt))));
    const right = unit(cross(away, this.up));
    return { right, down: cross(away, right), away, from: plus(this.target, scaled(away, -this.distance)) };
  }

  draw() {
    const [width, height] = this.size();
    this.canvas.width = width;
    this.canvas.height = height;
    const context = this.canvas.getContext("2d");
    const image = context.createImageData(width, height); // transparent: the paper is the canvas's background
    const camera = this.camera(), focal = MAP_LENS * height / 2;
    this.drawPoints(image, camera, focal);
    context.putImageData(image, 0, 0);
    for (const run of shownRuns()) if (run.map === this.source || run === store.focus) this.drawPath(context, run, camera, focal);
  }

  drawPoints(image, camera, focal) {
    const { width, height } = image;
    const pixels = new Uint32Array(image.data.buffer);
    const depth = new Float32Array(width * height).fill(Infinity);
    const { points, colours } = this;
    const { right, down, away, from } = camera;
    for (let i = 0; i < points.length; i += 3) {
      if (this.hidesCeiling && this.height(i) > this.ceiling) continue;
      const x = points[i] - from[0], y = points[i + 1] - from[1], z = points[i + 2] - from[2];
      const far = x * away[0] + y * away[1] + z * away[2];
      if (far < 0.02) continue;
      const u = width / 2 + focal * (x * right[0] + y * right[1] + z * right[2]) / far;
      const v = height / 2 + focal * (x * down[0] + y * down[1] + z * down[2]) / far;
      if (!(u >= 1 && v >= 1 && u < width - 1 && v < height - 1)) continue;
      const size = Math.max(2, Math.min(7, Math.round(0.022 * focal / far)));
      const paint = 0xff000000 | colours[i + 2] << 16 | colours[i + 1] << 8 | colours[i];
      const u0 = Math.max(0, Math.round(u - size / 2)), v0 = Math.max(0, Math.round(v - size / 2));
      for (let row = v0; row < Math.min(height, v0 + size); ++row)
        for (let at = row * width + u0; at < row * width + Math.min(width, u0 + size); ++at)
          if (far < depth[at]) {
            depth[at] = far;
            pixels[at] = paint;
          }
    }
  }

  drawPath(context, run, camera, focal) {
    const project = (row) => {
      if (row === undefined || run.position_m[0][row] === null) return null;
      const p = [0, 1, 2].map((a) => run.position_m[a][row] - this.middle[a] - camera.from[a]);
      const far = dot(p, camera.away);
      return far < 0.02 ? null
        : [context.canvas.width / 2 + focal * dot(p, camera.right) / far, context.canvas.height / 2 + focal * dot(p, camera.down) / far];
    };
    context.strokeStyle = colour(run.colour);
    context.lineWidth = 2;
    context.beginPath();
    let open = false;
    for (const k of run.group.axis.index.keys()) {
      const at = project(rowAt(run, k));
      if (at) open ? context.lineTo(...at) : context.moveTo(...at);
      open = at !== null;
    }
    context.stroke();
    const here = project(rowAt(run, store.frame));
    if (!here) return;
    context.fillStyle = colour(run.colour);
    context.beginPath();
    context.arc(...here, 5, 0, 2 * Math.PI);
    context.fill();
    context.strokeStyle = "#fff";
    context.stroke();
  }
}
