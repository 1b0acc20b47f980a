// Builds the page from the data beside it.

function build(data) {
  followThemes();
  const groups = groupRuns(data.runs);
  store.group = groups[0];
  store.shown = new Set(wholeRuns(groups[0].runs));
  store.focus = favourite(wholeRuns(groups[0].runs));

  const head = new Head(data), figures = new HeadFigures(data), notes = new Notes(), stages = new StageTable();
  const plots = new Plots(), trajectory = new Trajectory(), map = new MapView();
  const pictures = new FramePictures(), facts = new FrameFacts(), marks = new MarkList(), bar = new FrameBar();
  const compared = data.kind === "compare";
  const statistics = new ErrorTable(), boxes = new BoxPlots(data.runs), beside = new SideBySide();
  const runTable = compared ? new RunTable(data.runs, groups) : null;
  const plain = hasPlots ? null : element("p", { class: "hint", id: "no-uplot" },
    "The plots are plain: the program was built without uPlot, so they cannot be zoomed by dragging.");

  document.getElementById("report").replaceChildren(...[
    head.node, figures.node, runTable && runTable.node, compared ? medianTable(data.medians, data.runs) : null, boxes.node, plain,
    element("div", { class: "columns" },
      element("section", { class: "left", "aria-label": "Trajectory and plots" }, trajectory.node, plots.node),
      element("section", { class: "side", "aria-label": "Frame" }, pictures.node, facts.node, marks.node)),
    beside.node, map.node, statistics.node, stages.node, notes.node, bar.node].filter(Boolean));

  listenToKeys(bar);
  const parts = [head, figures, runTable, boxes, beside, statistics, trajectory, plots, pictures, marks, bar, stages, notes].filter(Boolean);
  const rebuild = () => {
    for (const part of parts) part.rebuild();
    facts.show();
    map.load();
  };
  listen("runs", rebuild);
  listen("theme", () => {
    plots.rebuild();
    map.later();
  });
  rebuild();
  setFrame(Math.floor(store.group.axis.length / 2));
}

/** The run that a comparison shows first: the most accurate one besides `none` and `oracle`. */
function favourite(runs) {
  const error = (run) => (run.summary.ate_rmse_m === null ? Infinity : run.summary.ate_rmse_m);
  const own = runs.filter((run) => !["none", "oracle"].includes(run.summary.pipeline));
  return (own.length ? own : runs).reduce((best, run) => (error(run) < error(best) ? run : best));
}

build(JSON.parse(document.getElementById("data").textContent));
