// The head of the page, notes, and what each stage did.

class Head {
  constructor(data) {
    this.title = element("h1", {});
    this.line = element("p", { class: "about" });
    this.version = `dynfilter ${data.version}`;
    this.theme = element("button", { type: "button", class: "theme", onclick: () => this.switchTheme() }, "dark or light");
    this.node = element("header", {}, element("div", {}, this.title, this.line), this.theme);
    this.kind = data.kind;
    this.runs = data.runs;
  }
  rebuild() {
    const s = store.focus.summary, axis = store.group.axis;
    const seconds = axis.seconds[axis.length - 1];
    this.title.replaceChildren(...(this.kind === "compare"
      ? [`${counted(this.runs.length, "run")} on `, element("em", {}, s.sequence)]
      : [element("em", {}, s.pipeline), " on ", element("em", {}, s.sequence)]));
    const parts = [this.version, `${counted(s.frames, "frame")} in ${figure(seconds, 1)} s`];
    if (this.kind === "compare") parts.unshift(`figures of ${runLabel(store.focus)}`);
    if (s.detector && s.detector.mode !== "sync") parts.push(`detector ${s.detector.mode}`);
    if (s.map) parts.push(`map of ${s.map.points.toLocaleString("en")} points`);
    this.line.textContent = parts.join(" · ");
  }
  switchTheme() {
    setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
  }
}

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  tell("theme");
}

/** The reader's theme, and light on paper. */
function followThemes() {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const own = () => setTheme(dark.matches ? "dark" : "light");
  let before;
  own();
  dark.addEventListener("change", own);
  window.addEventListener("beforeprint", () => {
    before = document.documentElement.dataset.theme;
    setTheme("light");
  });
  window.addEventListener("afterprint", () => setTheme(before));
}

class Notes {
  constructor() {
    this.node = element("section", { class: "notes" });
  }
  rebuild() {
    const notes = store.focus.summary.notes || [];
    this.node.hidden = notes.length === 0;
    this.node.replaceChildren(element("h2", {}, "Notes"), element("ul", {}, notes.map((note) => element("li", {}, note))));
  }
}

class StageTable {
  constructor() {
    this.node = element("section", {});
  }
  rebuild() {
    const stages = store.focus.summary.stages || [];
    this.node.hidden = stages.length === 0;
    const heads = ["stage", "frames", "judged", "dynamic", "unknown", "suspects", "skipped", "failed", "median ms", "notes, frames"];
    const rows = stages.map((s) => {
      const notes = [...s.notes].sort((a, b) => b.frames - a.frames).map((n) => element("div", {}, `${n.note} (${n.frames})`));
      const name = s.depth === 0 ? `${s.name} (${s.call_point})` : "\u2003".repeat(s.depth) + s.name;
      return element("tr", {}, element("th", { scope: "row", class: "text" }, name),
        [s.frames, figure(s.judged, 0), figure(s.dynamic, 0), figure(s.unknown, 0), figure(s.prior, 0), s.skipped, s.failed, figure(s.ms, 2)].map((v) => element("td", {}, String(v))),
        element("td", { class: "text wide" }, notes));
    });
    this.node.replaceChildren(element("h2", {}, `Stages of ${runLabel(store.focus)}`), element("p", { class: "hint" }, "Counts are means and times medians, over the frames in which a stage was reached."),
      element("div", { class: "table-box", tabindex: 0, role: "region", "aria-label": "Stages" },
        element("table", {}, element("thead", {}, element("tr", {}, heads.map((h, i) => element("th", { scope: "col", class: i === 0 || i === 9 ? "text" : null }, h)))), element("tbody", {}, rows))));
  }
}
