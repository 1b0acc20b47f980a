// Runs of one sequence on one axis of frames.

const RUN_COLOURS = 10;

function runLabel(run) {
  return run.summary.pipeline + (run.variant ? ", " + run.variant : "");
}

/** Of variants, those of the whole sequence: lines of all would hide each other. */
function wholeRuns(runs) {
  const whole = runs.filter((run) => !run.variant || run.variant === "forward from 0");
  return whole.length > 0 ? whole : runs;
}

/** All frames that any of the runs played, by time. */
function axisOf(runs) {
  const secondsOf = new Map();
  for (const run of runs) run.frames.index.forEach((index, k) => secondsOf.set(index, run.frames.time_s[k]));
  const index = [...secondsOf.keys()].sort((a, b) => secondsOf.get(a) - secondsOf.get(b) || a - b);
  const first = index.length ? secondsOf.get(index[0]) : 0;
  return {
    index,
    length: index.length,
    first,
    seconds: index.map((i) => Math.round((secondsOf.get(i) - first) * 1e6) / 1e6),
    at: new Map(index.map((i, k) => [i, k])),
  };
}

function groupRuns(runs) {
  const groups = [];
  for (const run of runs) {
    const { scene, sequence } = run.summary;
    let group = groups.find((g) => g.scene === scene && g.sequence === sequence);
    if (!group) groups.push((group = { scene, sequence, runs: [] }));
    run.group = group;
    run.colour = "run-" + (group.runs.length % RUN_COLOURS);
    group.runs.push(run);
  }
  for (const group of groups) {
    group.axis = axisOf(group.runs);
    for (const run of group.runs) {
      run.onAxis = run.frames.index.map((index) => group.axis.at.get(index));
      run.atAxis = new Map(run.onAxis.map((k, row) => [k, row]));
    }
  }
  return groups;
}

/** A list per played frame as a list on the axis, null where the run did not play. */
function spread(run, values) {
  const onAxis = new Array(run.group.axis.length).fill(null);
  values.forEach((value, row) => (onAxis[run.onAxis[row]] = value));
  return onAxis;
}

/** The played frame of a run at the cursor, or undefined. */
function rowAt(run, k) {
  return run.atAxis.get(k);
}

function frameText(k) {
  const axis = store.group.axis;
  return `frame ${axis.index[k]}, ${axis.seconds[k].toFixed(2)} s`;
}

const MARKS = {
  lost: { name: "tracking lost", colour: "mark-lost" },
  floor: { name: "floor", colour: "mark-floor" },
  late: { name: "late boxes or masks", colour: "mark-late" },
  uncertain: { name: "background uncertain", colour: "mark-uncertain" },
  failed: { name: "stage failed", colour: "mark-failed" },
};

/** Marks of a run, neighbouring frames of one kind as one: { kind, text, from, to } on the axis. */
function markRanges(run) {
  const ranges = [];
  for (const kind of Object.keys(MARKS)) {
    const marks = run.marks.filter((m) => m.kind === kind).map((m) => ({ at: run.onAxis[m.frame], text: m.text }));
    marks.sort((a, b) => a.at - b.at);
    for (const mark of marks) {
      const last = ranges[ranges.length - 1];
      if (last && last.kind === kind && mark.at <= last.to + 1) last.to = mark.at;
      else ranges.push({ kind, text: mark.text, from: mark.at, to: mark.at });
    }
  }
  return ranges;
}
