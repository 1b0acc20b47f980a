// What the reader looks at. Parts of the page listen to changes of it.

const store = {
  group: null, // runs of one sequence
  focus: null, // the run that pictures, stacks and marks are of
  shown: new Set(), // runs with lines
  frame: 0, // position on the group's axis
  range: null, // [from, to] in seconds; null: all
};

const listeners = {};

function listen(event, action) {
  (listeners[event] = listeners[event] || []).push(action);
}

function tell(event) {
  for (const action of listeners[event] || []) action();
}

function setFrame(k) {
  const last = store.group.axis.length - 1;
  const frame = Math.max(0, Math.min(last, Math.round(k)));
  if (frame === store.frame) return;
  store.frame = frame;
  tell("frame");
}

function setRange(range) {
  const same = range === store.range || (range && store.range && range[0] === store.range[0] && range[1] === store.range[1]);
  if (same) return;
  store.range = range;
  tell("range");
}

function setShown(run, on) {
  if (on) store.shown.add(run);
  else store.shown.delete(run);
  tell("runs");
}

function setFocus(run) {
  if (run.group !== store.group) {
    store.group = run.group;
    store.shown = new Set(wholeRuns(run.group.runs));
    store.frame = 0;
    store.range = null;
  }
  store.focus = run;
  store.shown.add(run);
  tell("runs");
  tell("frame");
}

/** The shown runs, in the order of the page. */
function shownRuns() {
  return store.group.runs.filter((run) => store.shown.has(run));
}

/** Zooms all plots about the current frame; more than the whole: the whole. */
function zoomTime(factor) {
  const axis = store.group.axis;
  const [first, last] = [axis.seconds[0], axis.seconds[axis.length - 1]];
  const [from, to] = store.range || [first, last];
  const width = (to - from) * factor;
  if (!(width < last - first)) return setRange(null);
  const middle = axis.seconds[store.frame];
  const begin = Math.min(Math.max(first, middle - width / 2), last - width);
  setRange([begin, begin + width]);
}
