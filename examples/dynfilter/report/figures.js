// The figures of the runs: large ones on top, and a table that sorts by any column.

/** Path in summary.json, name, digits, unit, and whether less is better. */
const FIGURES = [
  { key: "tracked_frames", name: "tracked", digits: 0 },
  { key: "ate_rmse_m", name: "ATE", digits: 4, unit: "m", less: true },
  { key: "rpe_trans_rmse_m", name: "RPE", digits: 4, unit: "m", less: true },
  { key: "rpe_rot_rmse_deg", name: "RPE, rotation", digits: 3, unit: "deg", less: true },
  { key: "recall", name: "recall", digits: 3 },
  { key: "precision", name: "precision", digits: 3 },
  { key: "static_kept", name: "static kept", digits: 3 },
  { key: "rejected_mean", name: "rejected", digits: 0, unit: "a frame" },
  { key: "ms.total", name: "time", digits: 1, unit: "ms", less: true },
  { key: "ms.filters", name: "filters", digits: 2, unit: "ms", less: true },
  { key: "map.points", name: "map points", digits: 0 },
  { key: "map.truth.ghosts", name: "ghosts", digits: 4, less: true },
  { key: "map.truth.coverage", name: "map coverage", digits: 3 },
];
const HEAD_FIGURES = ["tracked_frames", "ate_rmse_m", "rpe_trans_rmse_m", "recall", "static_kept", "rejected_mean", "ms.total"];

function valueOf(summary, key) {
  const value = key.split(".").reduce((json, part) => (json === null || json === undefined ? null : json[part]), summary);
  return value === undefined ? null : value;
}

function shownFigure(summary, spec, withUnit) {
  const text = figure(valueOf(summary, spec.key), spec.digits);
  if (spec.key === "tracked_frames") return summary.verdicts_only ? NONE : `${text} of ${summary.frames}`;
  return withUnit && spec.unit && text !== NONE ? `${text} ${spec.unit}` : text;
}

function raw(summary, key) {
  const value = valueOf(summary, key);
  return value === null ? "null" : String(value);
}

/** Summaries of `none` and `oracle` for the same frames. */
function references(run, beside) {
  const same = (other) => other !== run && other.variant === run.variant;
  const own = run.group.runs.filter(same).map((other) => other.summary);
  return ["none", "oracle"]
    .map((name) => [...own, ...beside].find((summary) => summary.pipeline === name && run.summary.pipeline !== name))
    .filter((summary) => summary);
}

class HeadFigures {
  constructor(data) {
    this.beside = data.beside || [];
    this.node = element("section", { class: "cards", "aria-label": "Figures" });
  }
  rebuild() {
    const run = store.focus;
    const others = references(run, this.beside);
    const exists = (f) => !(f.key === "tracked_frames" && run.summary.verdicts_only) && [run.summary, ...others].some((summary) => valueOf(summary, f.key) !== null);
    const cards = FIGURES.filter((f) => HEAD_FIGURES.includes(f.key) && exists(f)).map((f) => {
      const lines = others.map((summary) => element("div", { class: "reference" }, element("span", {}, summary.pipeline),
        element("span", { "data-pipeline": summary.pipeline, "data-key": f.key, "data-value": raw(summary, f.key) }, shownFigure(summary, f, false))));
      return element("div", { class: "card" }, element("div", { class: "name" }, f.name, f.unit ? element("span", { class: "unit" }, " " + f.unit) : null),
        element("div", { class: "figure", "data-pipeline": run.summary.pipeline, "data-key": f.key, "data-value": raw(run.summary, f.key) }, shownFigure(run.summary, f, false)), lines);
    });
    this.node.replaceChildren(...cards);
  }
}

/** Rows { cells: [{ text, value }], node } under heads that sort them. */
class SortedTable {
  constructor(heads, rows, label) {
    this.rows = rows;
    this.body = element("tbody", {}, rows.map((row) => row.node));
    this.heads = heads.map((head, c) => element("th", { scope: "col", class: head.text ? "text" : null },
      element("button", { type: "button", title: "Sort by " + head.name, onclick: () => this.sort(c) }, head.name, head.unit ? element("span", { class: "unit" }, " " + head.unit) : null)));
    this.node = element("div", { class: "table-box", tabindex: 0, role: "region", "aria-label": label },
      element("table", {}, element("thead", {}, element("tr", {}, this.heads)), this.body));
  }
  sort(c) {
    const down = this.heads[c].getAttribute("aria-sort") === "ascending";
    for (const head of this.heads) head.removeAttribute("aria-sort");
    this.heads[c].setAttribute("aria-sort", down ? "descending" : "ascending");
    const order = (a, b) => {
      const [x, y] = [a.values[c], b.values[c]];
      if (x === null || y === null) return (x === null) - (y === null); // missing ones last, either way
      const sign = typeof x === "string" ? x.localeCompare(y) : x - y;
      return down ? -sign : sign;
    };
    this.body.replaceChildren(...[...this.rows].sort(order).map((row) => row.node));
  }
}

/** All runs of a comparison: a switch for the lines of each, and a button that chooses it. */
class RunTable {
  constructor(runs, groups) {
    const several = groups.length > 1;
    this.figures = FIGURES.filter((f) => runs.some((run) => valueOf(run.summary, f.key) !== null));
    const heads = [{ name: "pipeline", text: true }, ...(several ? [{ name: "sequence", text: true }] : []), ...this.figures];
    this.rows = runs.map((run) => this.rowOf(run, several));
    this.table = new SortedTable(heads, this.rows, "All runs");
    this.node = element("section", {}, element("h2", {}, "Runs"),
      element("p", { class: "hint use" }, "The box switches a run's lines on and off. The name chooses the run of the figures above, the pictures and the stacked plots. A head sorts."),
      this.table.node);
  }
  rowOf(run, several) {
    const label = runLabel(run), s = run.summary;
    const box = element("input", { type: "checkbox", "aria-label": `lines of ${label}`, onchange: () => (box.checked || run !== store.focus ? setShown(run, box.checked) : (box.checked = true)) });
    const choose = element("button", { type: "button", class: "choose", onclick: () => setFocus(run) }, swatch(run.colour), label);
    const node = element("tr", {}, element("th", { scope: "row", class: "text" }, box, choose),
      several ? element("td", { class: "text" }, s.sequence) : null,
      this.figures.map((f) => element("td", { "data-key": f.key, "data-value": raw(s, f.key) }, shownFigure(s, f, false))));
    const values = [label, ...(several ? [s.sequence] : []), ...this.figures.map((f) => valueOf(s, f.key))];
    return { run, box, choose, node, values };
  }
  rebuild() {
    for (const { run, box, choose, node } of this.rows) {
      const here = run.group === store.group;
      box.checked = here && store.shown.has(run);
      box.disabled = !here;
      node.classList.toggle("focus", run === store.focus);
      choose.setAttribute("aria-pressed", run === store.focus);
    }
  }
}

function medianTable(medians, runs) {
  if (!medians || medians.length === runs.length) return null;
  const columns = [
    { name: "scene", key: "scene", text: true }, { name: "pipeline", key: "pipeline", text: true }, { name: "runs", key: "runs", digits: 0 },
    { name: "tracked", key: "tracked_frames", digits: 0 }, { name: "ATE", unit: "m", key: "ate_rmse_m", digits: 4 },
    { name: "worst", unit: "m", key: "ate_rmse_max_m", digits: 4 }, { name: "mean", unit: "m", key: "ate_rmse_mean_m", digits: 4 },
    { name: "std", unit: "m", key: "ate_rmse_std_m", digits: 4 }, { name: "over oracle", key: "ate_over_oracle", digits: 2 },
    { name: "recall", key: "recall", digits: 3 }, { name: "static kept", key: "static_kept", digits: 3 },
    { name: "time", unit: "ms", key: "ms_total", digits: 1 }, { name: `p against ${medians[0].reference}`, key: "p_value", digits: 3 },
  ].filter((c) => c.text || medians.some((m) => m[c.key] !== null && m[c.key] !== undefined));
  const short = (scene) => scene.split("/").pop();
  const rows = medians.map((m) => ({
    values: columns.map((c) => m[c.key]),
    node: element("tr", {}, columns.map((c) => element("td", { class: c.text ? "text" : null }, c.text ? short(m[c.key]) : figure(m[c.key], c.digits)))),
  }));
  return element("section", {}, element("h2", {}, "Medians over the runs of a scene"), new SortedTable(columns, rows, "Medians").node,
    element("p", { class: "hint" }, "std divides by n - 1. p: Wilcoxon signed-rank test of the ATE, paired by seed and variant. Below 0.05 a difference of seeds is more than noise; variants share frames, so their p is too small."));
}
