// One plot over time. With uPlot, or as plain SVG where the program was built without it.
// A specification has: title, unit, digits, series [{ label, colour, values }], stacked, most (of the y axis), and
// canLog, for figures that may differ by powers of ten.

const PLOT_HEIGHT = 180;
const DWARFS = 10; // times the least median
const LOG_SPAN = 1e-4; // a logarithmic axis shows at most this share of its top
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

/** A linear axis would show one of the series and a line at zero. */
function isDwarfed(series) {
  const medians = series.map((s) => median(s.values.filter((v) => v > 0))).filter((m) => m !== null);
  return medians.length > 1 && Math.max(...medians) > DWARFS * Math.min(...medians);
}

/** The lower end of a logarithmic axis: values below are drawn at its edge. */
function logFloor(columns, top) {
  const least = columns.flat().reduce((low, v) => (v > 0 && v < low ? v : low), top);
  return 10 ** Math.floor(Math.log10(Math.max(least, top * LOG_SPAN)));
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
    this.log = Boolean(spec.canLog) && isDwarfed(spec.series);
    this.scale = spec.canLog ? element("button", { type: "button", "aria-pressed": String(this.log), onclick: () => this.switchScale() }, "log scale") : null;
    const save = element("button", { type: "button", "aria-label": `Save the plot ${spec.title} as SVG`, onclick: () => savePlot(this) }, "save SVG");
    this.node = element("figure", { class: "plot" },
      element("figcaption", {}, spec.title, spec.unit ? element("span", { class: "unit" }, " " + spec.unit) : null,
        element("span", { class: "tools" }, this.scale, save)),
      this.box, legend);
    this.columns = spec.stacked ? stackedUp(spec.series) : spec.series.map((s) => s.values);
    this.top = topOf(spec, this.columns);
    this.low = spec.canLog ? logFloor(this.columns, this.top) : 0;
    this.hover = null;
  }

  /** Once it is in the page and has a width. */
  draw() {
    this.box.replaceChildren();
    this.drawing = hasPlots ? new UPlotDrawing(this) : new SvgDrawing(this);
    this.showFrame();
  }
  switchScale() {
    this.log = !this.log;
    this.scale.setAttribute("aria-pressed", String(this.log));
    this.drawing.remove();
    this.draw();
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
      scales: { x: { time: false }, y: plot.log ? { distr: 3, range: () => [plot.low, plot.top] } : { range: () => [0, plot.top] } },
      axes: [{ ...axis, size: 26, values: (u, ticks) => ticks.map((t) => tickText(t, ticks) + " s") },
             { ...axis, size: 46, ...this.upwards() }],
      series: [{}, ...order.map((i) => this.lineOf(spec, i))],
      hooks: {
        setCursor: [(u) => this.follow(u)],
        setScale: [(u, key) => key === "x" && this.zoomed(u)],
        draw: [(u) => this.drawMarks(u)],
      },
    }, [store.group.axis.seconds, ...order.map((i) => this.shown(columns[i]))], plot.box);
    this.u.over.append(this.line);
    this.listenToPointer();
    this.showRange();
  }

  upwards() {
    if (!this.plot.log) return { values: (u, ticks) => ticks.map((t) => tickText(t, ticks)) };
    const ticks = logTicks(this.plot.low, this.plot.top);
    return { splits: () => ticks, filter: (u, splits) => splits, values: (u, splits) => splits.map(logText) };
  }
  /** A logarithm has no zero. */
  shown(column) {
    return this.plot.log ? column.map((v) => (v === null ? null : Math.max(v, this.plot.low))) : column;
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
