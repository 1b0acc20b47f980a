// Pictures of two runs beside each other, at the same frame.

class SideBySide {
  constructor() {
    this.sides = ["Left", "Right"].map((name) => {
      const choice = element("select", { "aria-label": `${name} picture`, onchange: () => this.show() });
      const image = element("img", { width: 960, height: 780, alt: "", title: "click to zoom", tabindex: 0, role: "button",
        onclick: () => zoomPicture(image), onkeydown: (event) => event.key === "Enter" && zoomPicture(image) });
      const caption = element("figcaption", {});
      return { choice, image, caption, node: element("figure", { class: "picture" }, choice, image, caption) };
    });
    this.title = element("h2", {}, "Two pipelines at the same frame");
    this.pair = element("div", { class: "beside" }, this.sides.map((side) => side.node));
    this.node = element("section", {});
    listen("frame", () => this.show());
  }
  rebuild() {
    this.runs = store.group.runs.filter((run) => run.pictures.length > 0);
    this.node.hidden = this.runs.length < 2;
    this.node.replaceChildren(...(this.node.hidden ? [] : [this.title, this.pair]));
    if (this.node.hidden) return;
    const other = this.runs.find((run) => run !== store.focus && run.variant === store.focus.variant) || this.runs.find((run) => run !== store.focus);
    this.choose([other, store.focus]);
    this.show();
  }
  /** What the reader has chosen stays, while it is there. */
  choose(usual) {
    this.sides.forEach(({ choice }, i) => {
      const kept = choice.dataset.group === store.group.sequence ? this.runs[choice.selectedIndex] : null;
      const chosen = i === 0 && kept ? kept : usual[i];
      choice.replaceChildren(...this.runs.map((run) => element("option", { selected: run === chosen }, runLabel(run))));
      choice.dataset.group = store.group.sequence;
    });
  }
  /** Of the frames with a picture of both runs, the nearest; without one, the nearest of each. */
  places(runs) {
    const [left, right] = runs.map((run) => new Map(run.pictures.map((picture) => [run.onAxis[picture.frame], picture])));
    const both = [...left.keys()].filter((at) => right.has(at));
    if (both.length === 0) return runs.map((run) => pictureAt(run, store.frame));
    const at = both.reduce((best, k) => (Math.abs(k - store.frame) < Math.abs(best - store.frame) ? k : best));
    return [left, right].map((pictures) => ({ at, picture: pictures.get(at) }));
  }
  show() {
    if (this.node.hidden || !this.runs) return;
    const runs = this.sides.map(({ choice }) => this.runs[choice.selectedIndex]);
    this.places(runs).forEach(({ at, picture }, i) => {
      const { image, caption } = this.sides[i], run = runs[i];
      const text = `frame ${store.group.axis.index[at]}: ${verdictText(run, picture.frame)}`;
      if (image.dataset.frame !== String(at) || image.dataset.run !== runLabel(run)) image.src = "data:image/jpeg;base64," + picture.jpeg;
      Object.assign(image.dataset, { frame: at, run: runLabel(run) });
      image.alt = `${runLabel(run)}, ${text}.`;
      caption.textContent = text;
    });
  }
}
