// A plot over time as plain SVG: without uPlot, and in files.

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
  remove() {
    this.svg.remove();
  }
  x(s) {
    return this.left + (s - this.from) / (this.to - this.from) * (this.right - this.left);
  }
  y(value) {
    const { low, top, log } = this.plot;
    const share = log ? Math.log(Math.max(value, low) / low) / Math.log(top / low) : value / top;
    return this.bottom - Math.min(1, share) * (this.bottom - this.upper);
  }

  axes() {
    const { low, top, log } = this.plot;
    const across = roundTicks(this.from, this.to, 8), up = log ? logTicks(low, top) : roundTicks(0, top, 4);
    const text = (x, y, anchor, content) => shape("text", { x, y, "text-anchor": anchor, class: "tick" }, content);
    return [
      ...across.map((t) => shape("line", { class: "grid", x1: this.x(t), x2: this.x(t), y1: this.upper, y2: this.bottom })),
      ...up.map((t) => shape("line", { class: "grid", x1: this.left, x2: this.right, y1: this.y(t), y2: this.y(t) })),
      ...across.map((t) => text(this.x(t), PLOT_HEIGHT - 6, "middle", tickText(t, across) + " s")),
      ...up.map((t) => text(this.left - 6, this.y(t) + 4, "end", log ? logText(t) : tickText(t, up))),
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
