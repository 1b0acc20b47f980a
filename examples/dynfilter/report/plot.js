// One plot over time. With uPlot, or as plain SVG where the program was built without it.
// A specification has: title, unit, digits, series [{ label, colour, values }], stacked, most (of the y axis).

const PLOT_HEIGHT = 180;
const hasPlots = typeof uPlot !== "undefined";

/** Sums from the first series on; drawn from the last to the first, each over the one before. */
function stackedUp(series) {
  const sums = [];
  for (const one of series) {
    const below = sums[sums.length - 1];
    sums.push(one.values.map((v, k) => (v || 0) + (below ? below[k] : 0)));
  }
  return sums;
}

/** More than half of the values are missing: points instead of lines. */
function isSparse(values) {
  return known(values).length * 2 < values.length;
}

function topOf(spec, columns) {
  const most = columns.reduce((top, column) => Math.max(top, largest(column)), 0);
  return spec.most || (most > 0 ? most * 1.05 : 1);
}

/** What a plot shows, for those who do not see it. */
function describe(spec) {
  const parts = spec.series.map((s) => {
    const most = largest(s.values);
    if (most === -Infinity) return `${s.label}: no values`;
    return `${s.label}: median ${figure(median(s.values), spec.digits)}, at most ${figure(most, spec.digits)}`;
  });
  return `${spec.title}${spec.unit ? " in " + spec.unit : ""} over time. ${parts.join("; ")}.`;
}

class Plot {
  constructor(spec) {
    this.spec = spec;
    this.values = spec.series.map(() => element("output", { class: "value" }));
    this.box = element("div", { class: "plot-box", role: "img", "aria-label": describe(spec) });
    const legend = element("ul", { class: "legend" }, spec.series.map((s, i) =>
      element("li", {}, swatch(s.colour), element("span", {}, s.label), this.values[i])));
    this.node = element("figure", { class: "plot" },
      element("figcaption", {}, spec.title, spec.unit ? element("span", { class: "unit" }, " " + spec.unit) : null),
      this.box, legend);
    this.columns = spec.stacked ? stackedUp(spec.series) : spec.series.map((s) => s.values);
    this.top = topOf(spec, this.columns);
    this.hover = null;
  }

  /** Once it is in the page and has a width. */
  draw() {
    this.box.replaceChildren();
    this.drawing = hasPlots ? new UPlotDrawing(this) : new SvgDrawing(this);
    this.showFrame();
  }
  /** A plot that is no more in the page must not follow the others. */
  remove() {
    this.drawing.remove();
  }
  resize() {
    this.drawing.resize();
    this.showFrame();
  }
  showRange() {
    this.drawing.showRange();
    this.showFrame();
  }
  showFrame() {
    this.drawing.placeCursor();
    this.showValues();
  }
  showValues() {
    const k = this.hover === null ? store.frame : this.hover;
    this.spec.series.forEach((s, i) => (this.values[i].textContent = figure(s.values[k], this.spec.digits)));
  }
  width() {
    return Math.max(200, this.box.clientWidth);
  }
}

/** With uPlot: values follow the mouse, dragging zooms, a click chooses a frame. */
class UPlotDrawing {
  constructor(plot) {
    this.plot = plot;
    const { spec, columns } = plot;
    const order = spec.series.map((_, i) => (spec.stacked ? spec.series.length - 1 - i : i));
    const axis = { stroke: colour("soft"), grid: { stroke: colour("grid"), width: 1 }, ticks: { show: false }, font: "11px system-ui, sans-serif" };
    this.line = element("div", { class: "frame-line" });
    this.u = new uPlot({
      width: plot.width(),
      height: PLOT_HEIGHT,
      legend: { show: false },
      padding: [10, 8, 0, 0],
      cursor: { y: false, points: { show: false }, drag: { x: true, y: false }, sync: { key: "frames" } },
      scales: { x: { time: false }, y: { range: () => [0, plot.top] } },
      axes: [{ ...axis, size: 26, values: (u, ticks) => ticks.map((t) => tickText(t, ticks) + " s") },
             { ...axis, size: 46, values: (u, ticks) => ticks.map((t) => tickText(t, ticks)) }],
      series: [{}, ...order.map((i) => this.lineOf(spec, i))],
      hooks: {
        setCursor: [(u) => this.follow(u)],
        setScale: [(u, key) => key === "x" && this.zoomed(u)],
        draw: [(u) => this.drawMarks(u)],
      },
    }, [store.group.axis.seconds, ...order.map((i) => columns[i])], plot.box);
    this.u.over.append(this.line);
    this.listenToPointer();
    this.showRange();
  }

  lineOf(spec, i) {
    const s = spec.series[i];
    const sparse = isSparse(s.values);
    return {
      stroke: colour(s.colour),
      width: spec.stacked ? 0 : 1.5,
      fill: spec.stacked ? colour(s.colour) : undefined,
      points: { show: sparse || s.values.length < 3, size: 5, fill: colour(s.colour) },
    };
  }

  listenToPointer() {
    const over = this.u.over;
    let pressed = null;
    over.addEventListener("pointerdown", (event) => (pressed = event.clientX));
    over.addEventListener("click", (event) => {
      if (pressed !== null && Math.abs(event.clientX - pressed) > 4) return; // a zoom
      setFrame(this.u.posToIdx(event.clientX - over.getBoundingClientRect().left));
    });
  }
  follow(u) {
    this.plot.hover = u.cursor.left >= 0 && u.cursor.idx !== null && u.cursor.idx !== undefined ? u.cursor.idx : null;
    this.plot.showValues();
  }
  zoomed(u) {
    const { min, max } = u.scales.x;
    const seconds = store.group.axis.seconds;
    if (min === null) return;
    this.placeCursor(); // now that the scale is the new one
    if (min <= seconds[0] && max >= seconds[seconds.length - 1]) setRange(null);
    else setRange([min, max]);
  }
  showRange() {
    const seconds = store.group.axis.seconds;
    const last = seconds[seconds.length - 1];
    const [min, max] = store.range || [seconds[0], last > seconds[0] ? last : seconds[0] + 1];
    this.u.setScale("x", { min, max });
  }
  remove() {
    this.u.destroy();
  }
  resize() {
    this.u.setSize({ width: this.plot.width(), height: PLOT_HEIGHT });
  }
  placeCursor() {
    if (!this.u) return; // its first scale
    const left = this.u.valToPos(store.group.axis.seconds[store.frame], "x");
    this.line.hidden = left < -1 || left > this.u.over.clientWidth + 1;
    this.line.style.left = left + "px";
    this.line.dataset.frame = store.frame;
  }
  drawMarks(u) {
    const ratio = window.devicePixelRatio || 1;
    const seconds = store.group.axis.seconds;
    for (const mark of markRanges(store.focus)) {
      const from = u.valToPos(seconds[mark.from], "x", true), to = u.valToPos(seconds[mark.to], "x", true);
      const begin = Math.max(from - ratio, u.bbox.left), end = Math.min(to + ratio, u.bbox.left + u.bbox.width);
      if (begin > end) continue;
      u.ctx.fillStyle = colour(MARKS[mark.kind].colour);
      u.ctx.fillRect(begin, u.bbox.top - 6 * ratio, Math.max(2 * ratio, end - begin), 5 * ratio);
    }
  }
}

/** The same without uPlot: no hovering and no zoom by dragging. */
class SvgDrawing {
  constructor(plot) {
    this.plot = plot;
    this.line = shape("line", { class: "frame-line-svg" });
    this.svg = shape("svg", { class: "plain-plot", height: PLOT_HEIGHT, "aria-hidden": "true" });
    this.svg.addEventListener("click", (event) => {
      const x = event.clientX - this.svg.getBoundingClientRect().left;
      const wanted = this.from + (x - this.left) / (this.right - this.left) * (this.to - this.from);
      const seconds = store.group.axis.seconds;
      setFrame(seconds.reduce((best, s, k) => (Math.abs(s - wanted) < Math.abs(seconds[best] - wanted) ? k : best), 0));
    });
    plot.box.append(this.svg);
    this.resize();
  }

  resize() {
    const seconds = store.group.axis.seconds;
    const last = seconds[seconds.length - 1];
    [this.from, this.to] = store.range || [seconds[0], last > seconds[0] ? last : seconds[0] + 1];
    [this.left, this.right, this.bottom, this.upper] = [46, this.plot.width() - 8, PLOT_HEIGHT - 22, 10];
    this.svg.setAttribute("width", this.plot.width());
    this.svg.replaceChildren(...this.axes(), ...this.curves(), ...this.marks(), this.line);
  }
  showRange() {
    this.resize();
  }
  remove() {}
  x(s) {
    return this.left + (s - this.from) / (this.to - this.from) * (this.right - this.left);
  }
  y(value) {
    return this.bottom - Math.min(1, value / this.plot.top) * (this.bottom - this.upper);
  }

  axes() {
    const across = roundTicks(this.from, this.to, 8), up = roundTicks(0, this.plot.top, 4);
    const text = (x, y, anchor, content) => shape("text", { x, y, "text-anchor": anchor, class: "tick" }, content);
    return [
      ...across.map((t) => shape("line", { class: "grid", x1: this.x(t), x2: this.x(t), y1: this.upper, y2: this.bottom })),
      ...up.map((t) => shape("line", { class: "grid", x1: this.left, x2: this.right, y1: this.y(t), y2: this.y(t) })),
      ...across.map((t) => text(this.x(t), PLOT_HEIGHT - 6, "middle", tickText(t, across) + " s")),
      ...up.map((t) => text(this.left - 6, this.y(t) + 4, "end", tickText(t, up))),
    ];
  }

  curves() {
    const { spec, columns } = this.plot;
    const seconds = store.group.axis.seconds;
    const inside = seconds.map((s) => s >= this.from && s <= this.to);
    const order = spec.series.map((_, i) => (spec.stacked ? spec.series.length - 1 - i : i));
    const drawn = [];
    for (const i of order) {
      const paint = `var(--${spec.series[i].colour})`;
      const points = [];
      let path = "", open = false;
      columns[i].forEach((value, k) => {
        if (value === null || value === undefined || !inside[k]) return (open = false);
        const at = `${this.x(seconds[k]).toFixed(1)} ${this.y(value).toFixed(1)}`;
        path += (open ? "L" : "M") + at;
        points.push([this.x(seconds[k]), this.y(value)]);
        open = true;
      });
      if (spec.stacked && points.length > 0) {
        const [first, last] = [points[0][0], points[points.length - 1][0]];
        path += `L${last} ${this.bottom}L${first} ${this.bottom}Z`;
      }
      if (isSparse(columns[i]) || columns[i].length < 3)
        drawn.push(...points.map(([cx, cy]) => shape("circle", { cx, cy, r: 2.5, fill: paint })));
      else
        drawn.push(shape("path", spec.stacked ? { d: path, fill: paint } : { d: path, fill: "none", stroke: paint, "stroke-width": 1.5 }));
    }
    return drawn;
  }

  marks() {
    const seconds = store.group.axis.seconds;
    return markRanges(store.focus)
      .map((m) => [m, Math.max(this.left, this.x(seconds[m.from]) - 1), Math.min(this.right, this.x(seconds[m.to]) + 1)])
      .filter(([, from, to]) => from <= to)
      .map(([m, from, to]) => shape("rect", { x: from, y: 2, width: to - from, height: 5, fill: `var(--${MARKS[m.kind].colour})` }));
  }

  placeCursor() {
    const x = this.x(store.group.axis.seconds[store.frame]);
    const inside = x >= this.left - 1 && x <= this.right + 1;
    this.line.setAttribute("visibility", inside ? "visible" : "hidden");
    for (const [name, value] of Object.entries({ x1: x, x2: x, y1: this.upper, y2: this.bottom }))
      this.line.setAttribute(name, value);
    this.line.dataset.frame = store.frame;
  }
}
