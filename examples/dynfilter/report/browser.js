// The frame at the cursor: its pictures, its figures, and the frames that deserve a look.

const PLAY_STEP_MS = 100;

/** The picture of a run that is nearest to a frame of the axis; null without any. */
function pictureAt(run, k) {
  let best = null;
  for (const picture of run.pictures) {
    const at = run.onAxis[picture.frame];
    const nearer = best === null || Math.abs(at - k) < Math.abs(best.at - k);
    if (nearer) best = { at, picture };
  }
  return best;
}

function verdictText(run, row) {
  const f = run.frames;
  return `${f.static[row]} static, ${f.unknown[row]} unknown, ${f.restored[row]} restored, ${f.rejected[row]} rejected`;
}

/** One picture fills the window; a second click or Escape ends that. */
function zoomPicture(image) {
  image.classList.toggle("zoomed");
}
document.addEventListener("keydown", (event) => {
  if (event.key === "Escape") document.querySelectorAll("img.zoomed").forEach(zoomPicture);
});

class FramePictures {
  constructor() {
    this.node = element("div", { class: "pictures" });
    listen("frame", () => this.show());
  }
  rebuild() {
    const runs = [store.focus, ...shownRuns().filter((run) => run !== store.focus)].filter((run) => run.pictures.length > 0);
    this.cards = runs.map((run) => {
      const image = element("img", { width: 960, height: 780, alt: "", title: "click to zoom", tabindex: 0, role: "button",
        onclick: () => zoomPicture(image), onkeydown: (event) => event.key === "Enter" && zoomPicture(image) });
      const caption = element("figcaption", {});
      return { run, image, caption, node: element("figure", { class: run === store.focus ? "picture large" : "picture" }, image, caption) };
    });
    this.node.replaceChildren(...this.cards.map((card) => card.node));
    if (runs.length === 0) this.node.append(element("p", { class: "hint" }, "There are no pictures."));
    this.show();
  }
  show() {
    for (const { run, image, caption } of this.cards || []) {
      const { at, picture } = pictureAt(run, store.frame);
      if (image.dataset.frame !== String(at) || image.dataset.run !== runLabel(run)) {
        image.src = "data:image/jpeg;base64," + picture.jpeg;
        image.dataset.frame = at;
        image.dataset.run = runLabel(run);
        image.alt = `Frame ${store.group.axis.index[at]} with the verdicts of ${runLabel(run)}: ${verdictText(run, picture.frame)}.`;
      }
      const several = store.group.runs.length > 1 ? runLabel(run) + ": " : "";
      caption.textContent = several + (at === store.frame ? `frame ${store.group.axis.index[at]}`
        : `nearest picture, frame ${store.group.axis.index[at]}`);
    }
  }
}

/** What is known about the chosen run at the cursor. */
class FrameFacts {
  constructor() {
    this.node = element("dl", { class: "facts" });
    listen("frame", () => this.show());
  }
  show() {
    const run = store.focus, f = run.frames, row = rowAt(run, store.frame);
    if (row === undefined) return this.node.replaceChildren(element("dt", {}, "not played"), element("dd", {}, runLabel(run)));
    const position = run.position_m.map((axis) => axis[row]);
    const state = f.state[row].replace("_", " ") + (f.keyframe[row] ? ", keyframe" : "") + (f.relocalised[row] ? ", relocalised" : "");
    const facts = [
      ["state", state],
      ["features", `${f.features[row]}: ${verdictText(run, row)}`],
      ["tracked points", f.tracked_points[row]],
      ["position", position[0] === null ? NONE : position.map((p) => figure(p, 3)).join(", ") + " m"],
      ["error", figure(f.error_m[row], 4, "m")],
      ["time", figure(f.total_ms[row], 1, "ms")],
    ];
    if (f.recall[row] !== null || f.precision[row] !== null)
      facts.push(["recall, precision", `${figure(f.recall[row], 3)}, ${figure(f.precision[row], 3)}`]);
    if (f.age_frames[row] !== null) facts.push(["age of boxes, masks", counted(f.age_frames[row], "frame")]);
    if (f.note[row]) facts.push(["notes", f.note[row]]);
    this.node.replaceChildren(...facts.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, String(value))]));
  }
}

class MarkList {
  constructor() {
    this.node = element("div", { class: "marks" });
    listen("frame", () => this.show());
  }
  rebuild() {
    this.ranges = markRanges(store.focus);
    const axis = store.group.axis;
    const kinds = Object.keys(MARKS).filter((kind) => this.ranges.some((m) => m.kind === kind));
    const groups = kinds.map((kind) => {
      const own = this.ranges.filter((m) => m.kind === kind);
      const frames = own.reduce((sum, m) => sum + m.to - m.from + 1, 0);
      const buttons = own.map((m) => {
        const range = m.from === m.to ? `${axis.index[m.from]}` : `${axis.index[m.from]}–${axis.index[m.to]}`;
        return (m.button = element("button", { type: "button", title: m.text, "aria-label": `frame ${range}: ${m.text}`, onclick: () => setFrame(m.from) }, range));
      });
      return element("details", { open: own.length <= 12 },
        element("summary", {}, swatch(MARKS[kind].colour), `${MARKS[kind].name}: ${counted(frames, "frame")}`),
        element("p", { class: "chips" }, buttons));
    });
    const none = element("p", { class: "hint" }, "None: the floor did not act, nothing was late, tracking was never lost.");
    this.node.replaceChildren(element("h2", {}, "Marked frames"), ...(groups.length ? groups : [none]));
    this.show();
  }
  show() {
    for (const mark of this.ranges || [])
      mark.button.classList.toggle("current", store.frame >= mark.from && store.frame <= mark.to);
  }
}

/** The bar with the slider, which stays in view. */
class FrameBar {
  constructor() {
    const button = (text, label, action) => element("button", { type: "button", "aria-label": label, title: label, onclick: action }, text);
    this.slider = element("input", { type: "range", id: "frame-slider", min: 0, step: 1, value: 0, "aria-label": "Frame", oninput: () => setFrame(Number(this.slider.value)) });
    this.text = element("output", { class: "frame-text", for: "frame-slider" });
    this.playButton = button("▶", "Play", () => this.play());
    this.markButtons = [button("◀ mark", "Previous marked frame", () => this.toMark(-1)), button("mark ▶", "Next marked frame", () => this.toMark(1))];
    const zoom = element("span", { class: "zoom" },
      button("+", "Zoom the plots in at this frame", () => zoomTime(1 / 2)),
      button("−", "Zoom the plots out", () => zoomTime(2)),
      button("all", "Show all of the time", () => setRange(null)));
    this.node = element("div", { class: "frame-bar", role: "group", "aria-label": "Frame of all plots" },
      this.playButton, this.slider, this.text, element("span", { class: "mark-buttons" }, this.markButtons), zoom,
      element("span", { class: "keys hint" }, "Keys: ← → frame, with Shift 10, Home, End, space plays"));
    listen("frame", () => this.show());
  }
  rebuild() {
    const last = store.group.axis.length - 1;
    this.slider.max = last;
    this.slider.disabled = last < 1;
    this.playButton.disabled = last < 1;
    const marked = markRanges(store.focus).length > 0;
    for (const one of this.markButtons) one.disabled = !marked;
    this.show();
  }
  show() {
    this.slider.value = store.frame;
    this.slider.setAttribute("aria-valuetext", frameText(store.frame));
    this.text.textContent = frameText(store.frame);
  }
  toMark(direction) {
    const starts = [...new Set(markRanges(store.focus).map((m) => m.from))].sort((a, b) => a - b);
    const next = direction > 0 ? starts.find((k) => k > store.frame) : starts.reverse().find((k) => k < store.frame);
    if (next !== undefined) setFrame(next);
  }
  play() {
    const playing = this.timer !== undefined;
    clearInterval(this.timer);
    this.timer = undefined;
    this.playButton.textContent = playing ? "▶" : "❚❚";
    this.playButton.setAttribute("aria-label", playing ? "Play" : "Pause");
    if (playing) return;
    if (store.frame === store.group.axis.length - 1) setFrame(0);
    this.timer = setInterval(() => {
      if (store.frame === store.group.axis.length - 1) this.play();
      else setFrame(store.frame + 1);
    }, PLAY_STEP_MS);
  }
}
