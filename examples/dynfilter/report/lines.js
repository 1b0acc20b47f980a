// Which plots over time there are.

const MOST_REASONS = 6;

function overRuns(title, unit, digits, key, more) {
  const series = shownRuns()
    .filter((run) => known(run.frames[key]).length > 0)
    .map((run) => ({ label: runLabel(run), colour: run.colour, values: spread(run, run.frames[key]) }));
  return { title, unit, digits, series, ...more };
}

/** Kept and rejected features of the chosen run, as frames.csv counts them; rare reasons are pooled. */
function featureStack(run) {
  const total = (reason) => reason.features.reduce((sum, n) => sum + n, 0);
  const sorted = [...run.reasons].sort((a, b) => total(b) - total(a));
  const series = [
    { label: "static", colour: "kept", values: spread(run, run.frames.static) },
    { label: "unknown, kept", colour: "unknown", values: spread(run, run.frames.unknown) },
    { label: "restored by the floor", colour: "restored", values: spread(run, run.frames.restored) },
  ];
  sorted.slice(0, MOST_REASONS).forEach((reason, i) =>
    series.push({ label: "rejected: " + (reason.name || "no stage named"), colour: "reason-" + i, values: spread(run, reason.features) }));
  const rest = sorted.slice(MOST_REASONS);
  if (rest.length > 0) {
    const pooled = run.frames.index.map((_, row) => rest.reduce((sum, reason) => sum + reason.features[row], 0));
    series.push({ label: `rejected: ${rest.length} other reasons`, colour: "reason-" + MOST_REASONS, values: spread(run, pooled) });
  }
  const used = series.filter((s, i) => i < 2 || largest(s.values) > 0);
  return { title: "Features by verdict", unit: ofFocus(run), digits: 0, stacked: true, series: used };
}

function ofFocus(run) {
  return store.group.runs.length > 1 ? "of " + runLabel(run) : "";
}

function stepTimes(run) {
  const steps = ["extraction", "correspondence", "filters", "tracking"];
  return {
    title: "Time per step", unit: ["ms", ofFocus(run)].filter(Boolean).join(" "), digits: 2, stacked: true,
    series: steps.map((step, i) => ({ label: step, colour: "step-" + i, values: spread(run, run.frames[step + "_ms"]) })),
  };
}

/** A combinator's time is that of its members, which follow it. */
function hasMembers(stage, next) {
  return next !== undefined && next.call_point === stage.call_point && next.depth > stage.depth;
}

function alwaysSkipped(run, stage) {
  const same = (s) => s.call_point === stage.call_point && s.path === stage.path && s.name === stage.name;
  const total = (run.summary.stages || []).find(same);
  return total !== undefined && total.skipped >= total.frames;
}

function stageTimes(run) {
  const several = new Set(run.stages.map((stage) => stage.call_point)).size > 1;
  const series = run.stages
    .filter((stage, i) => !hasMembers(stage, run.stages[i + 1]) && known(stage.ms).length > 0 && !alwaysSkipped(run, stage))
    .map((stage, i) => ({
      label: several ? `${stage.name} (${stage.call_point})` : stage.name,
      colour: "run-" + (i % RUN_COLOURS), values: spread(run, stage.ms),
    }));
  return { title: "Time per stage of the pipeline", unit: ["ms", ofFocus(run)].filter(Boolean).join(" "), digits: 2, series };
}

function classification(run) {
  const names = { recall: "recall", precision: "precision", static_kept: "static kept" };
  const series = Object.keys(names)
    .filter((key) => known(run.frames[key]).length > 0)
    .map((key, i) => ({ label: names[key], colour: "run-" + i, values: spread(run, run.frames[key]) }));
  return { title: "Recall, precision and static features kept", unit: ofFocus(run), digits: 3, most: 1.02, series };
}

/** Specifications of all plots that have anything to show. */
function plotList() {
  const run = store.focus;
  const several = store.group.runs.length > 1;
  const specs = [overRuns("Position error", "m, as in the ATE", 4, "error_m", { canLog: true }), featureStack(run)];
  specs.push(overRuns("Mean weight of the kept features", "1: sharp corners that stand still", 3, "weight", { most: 1.02 }));
  if (several) specs.push(overRuns("Features rejected", "", 0, "rejected"));
  if (several) specs.push(overRuns("Recall", "", 3, "recall", { most: 1.02 }), overRuns("Precision", "", 3, "precision", { most: 1.02 }));
  else specs.push(classification(run));
  if (several) specs.push(overRuns("Time per frame", "ms", 1, "total_ms"));
  specs.push(stepTimes(run), stageTimes(run));
  return specs.filter((spec) => spec.series.length > 0);
}

class Plots {
  constructor() {
    this.node = element("div", { class: "plots" });
    this.plots = [];
    listen("frame", () => this.plots.forEach((plot) => plot.showFrame()));
    listen("range", () => this.plots.forEach((plot) => plot.showRange()));
    onResize(this.node, () => this.plots.forEach((plot) => plot.resize()));
  }
  rebuild() {
    this.plots.forEach((plot) => plot.remove());
    this.plots = plotList().map((spec) => new Plot(spec));
    this.node.replaceChildren(...this.plots.map((plot) => plot.node));
    this.plots.forEach((plot) => plot.draw());
  }
}
