// The camera's path from above and from the side.

const ERROR_COLOURS = 6; // --error-0 ... in the style sheet
const ZOOM_STEP = 1.25;

/** The axis that points up, and two horizontal ones: [right, towards the top of the view from above]. */
function axesOf(up) {
  const size = up.map(Math.abs);
  const vertical = size.indexOf(Math.max(...size));
  const sign = up[vertical] < 0 ? -1 : 1;
  // Seen from above, a right-handed frame has its second horizontal axis to the left of the first one.
  const right = (vertical + 1) % 3, ahead = (vertical + 2) % 3;
  return { up: { axis: vertical, sign }, right: { axis: right, sign: 1 }, ahead: { axis: ahead, sign } };
}

function axisName(direction) {
  return (direction.sign < 0 ? "−" : "") + "xyz"[direction.axis];
}

/** Points [across, along] of three lists of coordinates, null where there is none. */
function projected(position, across, along) {
  return position[across.axis].map((v, k) =>
    v === null ? null : [v * across.sign, position[along.axis][k] * along.sign]);
}

/** Errors up to this have a colour of their own; above, all have the last one. */
function errorLimit(run) {
  const errors = known(run.frames.error_m).sort((a, b) => a - b);
  return errors.length ? Math.max(1e-6, errors[Math.floor(0.98 * (errors.length - 1))]) : 0;
}

class PathView {
  constructor(title, pick) {
    this.pick = pick;
    this.svg = shape("svg", { class: "path-view", tabindex: 0, role: "application" });
    this.buttons = element("span", { class: "tools" },
      element("button", { type: "button", "aria-label": `${title}: zoom in`, onclick: () => this.zoom(ZOOM_STEP) }, "+"),
      element("button", { type: "button", "aria-label": `${title}: zoom out`, onclick: () => this.zoom(1 / ZOOM_STEP) }, "−"),
      element("button", { type: "button", "aria-label": `${title}: show all`, onclick: () => this.showAll() }, "all"),
      element("button", { type: "button", "aria-label": `Save ${title} as SVG`, onclick: () => saveShape(this.svg, `${title}, m`, this.legend()) }, "save SVG"));
    this.caption = element("figcaption", {}, title, " ", element("span", { class: "unit" }, "m"), this.buttons);
    this.title = title;
    this.node = element("figure", { class: "path" }, this.caption, this.svg);
    this.listenToPointer();
    this.svg.addEventListener("keydown", (event) => this.key(event));
  }

  load() {
    const axes = axesOf(store.focus.up);
    this.across = axes[this.pick[0]];
    this.along = axes[this.pick[1]];
    this.paths = shownRuns().map((run) => ({ run, points: projected(run.position_m, this.across, this.along) }));
    const truth = store.group.runs.find((run) => run.truth_s.length > 0);
    this.truth = truth ? projected(truth.truth_m, this.across, this.along) : [];
    this.truthSeconds = truth ? truth.truth_s.map((s) => s - store.group.axis.first) : [];
    this.limit = errorLimit(store.focus);
    this.svg.setAttribute("aria-label", `${this.title}: the camera's path` +
      (truth ? " and the true one" : "") + ", in metres. Arrow keys move, plus and minus zoom, 0 shows all.");
    this.view = null;
    this.draw();
  }

  legend() {
    const truth = this.truth.length > 0 ? [{ label: "ground truth", colour: "truth" }] : [];
    return [...truth, ...this.paths.map(({ run }) => ({ label: runLabel(run), colour: run.colour }))];
  }
  size() {
    return [Math.max(200, this.svg.clientWidth), Math.max(160, this.svg.clientHeight)];
  }
  showAll() {
    const all = [this.truth, ...this.paths.map((p) => p.points)].flat().filter((p) => p !== null);
    const [width, height] = this.size();
    const range = (a) => {
      const values = all.map((p) => p[a]);
      return values.length ? [Math.min(...values), Math.max(...values)] : [-0.5, 0.5];
    };
    const [x, y] = [range(0), range(1)];
    const scale = Math.min((width - 70) / Math.max(x[1] - x[0], 0.01), (height - 50) / Math.max(y[1] - y[0], 0.01));
    this.view = { x: (x[0] + x[1]) / 2, y: (y[0] + y[1]) / 2, scale };
    this.draw();
  }
  zoom(factor, at) {
    const [width, height] = this.size();
    const [px, py] = at || [width / 2, height / 2];
    const [x, y] = this.world(px, py);
    this.view.scale *= factor;
    this.view.x = x - (px - width / 2) / this.view.scale;
    this.view.y = y + (py - height / 2) / this.view.scale;
    this.draw();
  }
  pan(dx, dy) {
    this.view.x -= dx / this.view.scale;
    this.view.y += dy / this.view.scale;
    this.draw();
  }
  key(event) {
    const moves = { ArrowLeft: [30, 0], ArrowRight: [-30, 0], ArrowUp: [0, 30], ArrowDown: [0, -30] };
    if (moves[event.key]) this.pan(...moves[event.key]);
    else if (event.key === "+" || event.key === "=") this.zoom(ZOOM_STEP);
    else if (event.key === "-") this.zoom(1 / ZOOM_STEP);
    else if (event.key === "0") this.showAll();
    else return;
    event.preventDefault();
  }
  listenToPointer() {
    const pointers = new Map();
    const at = (event) => [event.offsetX, event.offsetY];
    this.svg.addEventListener("pointerdown", (event) => {
      pointers.set(event.pointerId, at(event));
      this.svg.setPointerCapture(event.pointerId);
    });
    this.svg.addEventListener("pointermove", (event) => {
      const last = pointers.get(event.pointerId);
      if (!last) return;
      const here = at(event);
      if (pointers.size === 2) {
        const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
        const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
        if (apart(last) > 0) this.zoom(apart(here) / apart(last), [(here[0] + other[0]) / 2, (here[1] + other[1]) / 2]);
      } else this.pan(here[0] - last[0], here[1] - last[1]);
      pointers.set(event.pointerId, here);
    });
    for (const end of ["pointerup", "pointercancel"])
      this.svg.addEventListener(end, (event) => pointers.delete(event.pointerId));
    this.svg.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(event.deltaY < 0 ? ZOOM_STEP : 1 / ZOOM_STEP, at(event));
    }, { passive: false });
  }

  screen(point) {
    const [width, height] = this.size();
    return [width / 2 + (point[0] - this.view.x) * this.view.scale, height / 2 - (point[1] - this.view.y) * this.view.scale];
  }
  world(px, py) {
    const [width, height] = this.size();
    return [this.view.x + (px - width / 2) / this.view.scale, this.view.y - (py - height / 2) / this.view.scale];
  }

  draw() {
    if (!this.view) return this.showAll();
    this.cursor = shape("g", {});
    this.svg.replaceChildren(...this.grid(), this.curve(this.truth, { class: "truth-path" }),
      ...this.paths.filter((p) => p.run !== store.focus).map((p) => this.runCurve(p)),
      ...this.paths.filter((p) => p.run === store.focus).flatMap((p) => this.errorCurves(p)), this.cursor);
    this.placeCursor();
  }
  grid() {
    const [width, height] = this.size();
    const [left, top] = this.world(0, 0), [right, bottom] = this.world(width, height);
    const across = roundTicks(left, right, Math.max(2, Math.round(width / 60)));
    const step = across.length > 1 ? across[1] - across[0] : right - left;
    const along = [];
    for (let k = Math.ceil(bottom / step); k * step <= top; ++k) along.push(k * step);
    const parts = [];
    for (const t of across) {
      const [x] = this.screen([t, 0]);
      parts.push(shape("line", { class: "grid", x1: x, x2: x, y1: 0, y2: height }));
      if (x > 40 && x < width - 30) parts.push(shape("text", { class: "tick", x, y: height - 5, "text-anchor": "middle" }, tickText(t * this.across.sign, across)));
    }
    for (const t of along) {
      const [, y] = this.screen([0, t]);
      parts.push(shape("line", { class: "grid", x1: 0, x2: width, y1: y, y2: y }));
      if (y > 30 && y < height - 20) parts.push(shape("text", { class: "tick", x: 4, y: y - 3 }, tickText(t * this.along.sign, across)));
    }
    parts.push(shape("text", { class: "axis", x: width - 6, y: height - 5, "text-anchor": "end" }, axisName(this.across) + " →"));
    parts.push(shape("text", { class: "axis", x: 4, y: 12 }, axisName(this.along) + " ↑"));
    return parts;
  }
  curve(points, attributes) {
    let d = "", open = false;
    for (const point of points) {
      if (point === null) {
        open = false;
        continue;
      }
      d += (open ? "L" : "M") + this.screen(point).map((v) => v.toFixed(1)).join(" ");
      open = true;
    }
    return shape("path", { d, fill: "none", ...attributes });
  }
  runCurve({ run, points }) {
    return this.curve(points, { stroke: `var(--${run.colour})`, "stroke-width": 1.5 });
  }
  /** Steps of the path, by the error at their end: a path per colour. */
  errorCurves({ run, points }) {
    const errors = run.frames.error_m;
    if (this.limit === 0) return [this.runCurve({ run, points })];
    const parts = new Array(ERROR_COLOURS).fill("");
    for (let k = 1; k < points.length; ++k) {
      if (points[k] === null || points[k - 1] === null || errors[k] === null) continue;
      const level = Math.min(ERROR_COLOURS - 1, Math.floor(errors[k] / this.limit * ERROR_COLOURS));
      const [from, to] = [this.screen(points[k - 1]), this.screen(points[k])];
      parts[level] += `M${from.map((v) => v.toFixed(1)).join(" ")}L${to.map((v) => v.toFixed(1)).join(" ")}`;
    }
    return parts.map((d, level) => shape("path", { d, class: "error-path", stroke: `var(--error-${level})` }));
  }

  placeCursor() {
    if (!this.view) return;
    const dots = [];
    if (this.truth.length > 0) {
      const now = store.group.axis.seconds[store.frame];
      const k = this.truthSeconds.reduce((best, s, i) => (Math.abs(s - now) < Math.abs(this.truthSeconds[best] - now) ? i : best), 0);
      dots.push([this.truth[k], "truth-dot", null]);
    }
    for (const { run, points } of this.paths) dots.push([points[rowAt(run, store.frame)], "dot", run.colour]);
    this.cursor.dataset.frame = store.frame;
    this.cursor.replaceChildren(...dots.filter(([point]) => point).map(([point, kind, paint]) => {
      const [cx, cy] = this.screen(point);
      return shape("circle", { cx, cy, r: 5, class: kind, fill: paint ? `var(--${paint})` : "none" });
    }));
  }
}

/** Colours of the errors, and what the lines are. */
function pathKey() {
  const limit = errorLimit(store.focus);
  const has = store.group.runs.some((run) => run.truth_s.length > 0);
  const items = [];
  if (has) items.push(element("span", { class: "key-truth" }, "ground truth"));
  if (limit > 0) {
    const bar = shape("svg", { class: "error-bar", viewBox: `0 0 ${ERROR_COLOURS} 1`, preserveAspectRatio: "none", "aria-hidden": "true" },
      Array.from({ length: ERROR_COLOURS }, (_, i) => shape("rect", { x: i, width: 1.02, height: 1, fill: `var(--error-${i})` })));
    items.push(element("span", { class: "key-error" }, `error of ${runLabel(store.focus)}: 0 `, bar, ` ${figure(limit, 4)} m and more`));
  }
  for (const run of shownRuns())
    if (run !== store.focus || limit === 0) items.push(element("span", {}, swatch(run.colour), runLabel(run)));
  if (!has) items.push(element("span", {}, "no ground truth: relative to the first camera"));
  return items;
}

class Trajectory {
  constructor() {
    this.views = [new PathView("Trajectory from above", ["right", "ahead"]), new PathView("Trajectory from the side", ["right", "up"])];
    this.key = element("p", { class: "path-key" });
    this.node = element("div", {}, element("div", { class: "paths" }, this.views.map((view) => view.node)), this.key);
    listen("frame", () => this.views.forEach((view) => view.placeCursor()));
    onResize(this.node, () => this.views.forEach((view) => view.draw()));
  }
  rebuild() {
    this.node.hidden = shownRuns().every((run) => run.summary.verdicts_only);
    this.key.replaceChildren(...pathKey());
    this.views.forEach((view) => view.load());
  }
}
