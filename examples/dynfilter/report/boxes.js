// Errors in figures: statistics of each run, and boxes per pipeline.

const BOX_ROW = 30, BOX_AXIS = 26, BOX_LETTER = 7;
const BOXED = ["ate_rmse_m", "rpe_trans_rmse_m", "recall", "static_kept", "ms.total"];

/** The table that evo prints, of the error after alignment. */
class ErrorTable {
  constructor() {
    this.node = element("section", {});
  }
  rebuild() {
    const columns = [{ name: "run", text: true }, { name: "poses", key: "n", digits: 0 },
      ...["rmse", "mean", "median", "std", "min", "max"].map((key) => ({ name: key, key, digits: 4, unit: "m" }))];
    const rows = store.group.runs.map((run) => [run, errorStatistics(run.frames.error_m)]).filter(([, s]) => s !== null).map(([run, s]) => ({
      values: [runLabel(run), ...columns.slice(1).map((c) => s[c.key])],
      node: element("tr", { class: run === store.focus ? "focus" : null }, element("th", { scope: "row", class: "text" }, swatch(run.colour), runLabel(run)),
        columns.slice(1).map((c) => element("td", { "data-statistic": c.key, "data-value": String(s[c.key]) }, figure(s[c.key], c.digits)))),
    }));
    this.node.hidden = rows.length === 0;
    this.node.replaceChildren(element("h2", {}, "Position error: statistics"),
      element("p", { class: "hint" }, "Of the frames with a pose and a true one, after the alignment of the ATE, which is the rmse. std divides by n, as in evo."),
      new SortedTable(columns, rows, "Statistics of the position error").node);
  }
}

/** Pipelines as rows: a box from the lower to the upper quartile, a line from the least to the largest value. */
class BoxPlot {
  constructor(title, unit, digits, rows) {
    Object.assign(this, { title, unit, digits, rows });
    const all = rows.flatMap((row) => row.values);
    this.canLog = all.every((v) => v > 0);
    this.log = this.canLog && isDwarfed(rows);
    this.svg = shape("svg", { class: "box-plot", height: rows.length * BOX_ROW + BOX_AXIS, role: "img", "aria-label": this.description() });
    this.scale = this.canLog ? element("button", { type: "button", "aria-pressed": String(this.log), onclick: () => this.switchScale() }, "log scale") : null;
    const save = element("button", { type: "button", "aria-label": `Save the boxes of ${title} as SVG`, onclick: () => saveShape(this.svg, [title, unit].filter(Boolean).join(", ")) }, "save SVG");
    this.node = element("figure", { class: "boxes" }, element("figcaption", {}, title, unit ? element("span", { class: "unit" }, " " + unit) : null,
      element("span", { class: "tools" }, this.scale, save)), this.svg);
  }
  description() {
    const parts = this.rows.map((row) => `${row.name}: median ${figure(median(row.values), this.digits)}, from ${figure(Math.min(...row.values), this.digits)} to ${figure(largest(row.values), this.digits)}`);
    return `${this.title}${this.unit ? " in " + this.unit : ""} per pipeline. ${parts.join("; ")}.`;
  }
  switchScale() {
    this.log = !this.log;
    this.scale.setAttribute("aria-pressed", String(this.log));
    this.draw();
  }
  draw() {
    const width = Math.max(220, this.node.clientWidth), all = this.rows.flatMap((row) => row.values);
    const letters = Math.max(...this.rows.map((row) => row.name.length));
    const [left, right] = [Math.min(width * 0.4, letters * BOX_LETTER + 12), width - 14];
    const top = largest(all) * 1.02 || 1, low = this.log ? Math.min(...all) * 0.9 : 0;
    const share = (v) => (this.log ? Math.log(v / low) / Math.log(top / low) : v / top);
    const x = (v) => left + share(v) * (right - left);
    const bottom = this.rows.length * BOX_ROW;
    const ticks = this.log ? logTicks(low, top) : roundTicks(0, top, Math.max(2, Math.floor((right - left) / 60)));
    this.svg.setAttribute("width", width);
    this.svg.replaceChildren(
      ...ticks.map((t) => shape("line", { class: "grid", x1: x(t), x2: x(t), y1: 0, y2: bottom })),
      ...ticks.map((t) => shape("text", { class: "tick", x: x(t), y: bottom + 15, "text-anchor": "middle" }, this.log ? logText(t) : tickText(t, ticks))),
      ...this.rows.flatMap((row, i) => this.row(row, (i + 0.5) * BOX_ROW, left, x)));
  }
  row({ name, colour: paint, values, dots }, y, left, x) {
    const line = (x1, x2, y1, y2, width) => shape("line", { class: "whisker", x1, x2, y1, y2, "stroke-width": width });
    const [least, lower, middle, upper, most] = [0, 0.25, 0.5, 0.75, 1].map((share) => x(quantile(values, share)));
    const cut = Math.floor((left - 10) / BOX_LETTER);
    return [shape("text", { class: "box-name", x: left - 8, y: y + 4, "text-anchor": "end" }, name.length > cut ? name.slice(0, cut - 1) + "…" : name),
      line(least, most, y, y, 1), line(least, least, y - 5, y + 5, 1), line(most, most, y - 5, y + 5, 1),
      shape("rect", { class: "box", x: lower, y: y - 9, width: Math.max(1, upper - lower), height: 18, fill: `var(--${paint})` }),
      line(middle, middle, y - 9, y + 9, 2.5),
      ...(dots ? values.map((v) => shape("circle", { class: "box-dot", cx: x(v), cy: y, r: 2.5 })) : [])];
  }
}

/** Boxes of the runs of each pipeline on the shown scene; of single runs, those of their frames. */
class BoxPlots {
  constructor(runs) {
    this.runs = runs;
    this.grid = element("div", { class: "box-grid" });
    this.hint = element("p", { class: "hint" });
    this.title = element("h2", {});
    this.node = element("section", {}, this.title, this.hint, this.grid);
    onResize(this.grid, () => this.plots.forEach((plot) => plot.draw()));
  }
  pipelines() {
    const found = new Map();
    for (const run of this.runs.filter((one) => one.group.scene === store.group.scene)) {
      const name = run.summary.pipeline;
      if (!found.has(name)) found.set(name, []);
      found.get(name).push(run);
    }
    return [...found];
  }
  ofRuns(pipelines, spec) {
    const rows = pipelines.map(([name, runs]) => ({ name, colour: runs[0].pipelineColour, values: known(runs.map((run) => valueOf(run.summary, spec.key))), dots: true }));
    return rows.some((row) => row.values.length > 1) ? new BoxPlot(spec.name, spec.unit, spec.digits, rows.filter((row) => row.values.length > 0)) : null;
  }
  ofFrames(pipelines) {
    const rows = pipelines.map(([name, runs]) => ({ name, colour: runs[0].pipelineColour, values: known(runs[0].frames.error_m) })).filter((row) => row.values.length > 1);
    return rows.length > 1 ? [new BoxPlot("Position error", "m", 4, rows)] : [];
  }
  rebuild() {
    const pipelines = this.pipelines(), most = Math.max(...pipelines.map(([, runs]) => runs.length));
    pipelines.forEach(([, runs], i) => runs.forEach((run) => (run.pipelineColour = "run-" + (i % RUN_COLOURS))));
    const specs = BOXED.map((key) => FIGURES.find((f) => f.key === key));
    this.plots = most > 1 ? specs.map((spec) => this.ofRuns(pipelines, spec)).filter(Boolean) : this.ofFrames(pipelines);
    this.node.hidden = this.plots.length === 0;
    this.title.textContent = most > 1 ? `${most} runs per pipeline on ${store.group.scene.split("/").pop()}` : "Error per pipeline";
    this.hint.textContent = `Box: from the lower to the upper quartile of the ${most > 1 ? "runs" : "frames"}, with the median. Line: from the least to the largest.${most > 1 ? " A dot is a run." : ""}`;
    this.grid.replaceChildren(...this.plots.map((plot) => plot.node));
    this.plots.forEach((plot) => plot.draw());
  }
}
