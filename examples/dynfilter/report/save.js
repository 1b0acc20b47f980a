// Plots as SVG files that need no style sheet.

const SAVED_WIDTH = 800;
const SAVED_STYLES = ["fill", "stroke", "stroke-width", "stroke-dasharray", "stroke-linecap", "font-size", "font-weight", "font-family", "text-anchor", "visibility"];
const TITLE_HEIGHT = 28, LEGEND_HEIGHT = 20, LETTER_WIDTH = 6.6;

/** A copy of a shape in the page, with the styles that the page gives it. */
function styledCopy(node) {
  const copy = node.cloneNode(false);
  if (node.nodeType !== Node.ELEMENT_NODE) return copy;
  const style = getComputedStyle(node);
  for (const name of SAVED_STYLES) copy.setAttribute(name, style.getPropertyValue(name));
  for (const name of ["class", "tabindex", "role", "aria-label", "aria-hidden"]) copy.removeAttribute(name);
  for (const child of node.childNodes)
    if (!child.classList || !child.classList.contains("frame-line-svg")) copy.append(styledCopy(child));
  return copy;
}

/** Names of the series below each other and beside each other, as they fit. */
function savedLegend(series, top, width) {
  const parts = [];
  let x = 8, y = top + 14;
  for (const one of series) {
    const wide = 16 + LETTER_WIDTH * one.label.length + 14;
    if (x > 8 && x + wide > width) [x, y] = [8, y + LEGEND_HEIGHT];
    parts.push(shape("rect", { x, y: y - 9, width: 10, height: 10, rx: 2, fill: colour(one.colour) }),
      shape("text", { x: x + 15, y, fill: colour("ink"), "font-size": 12 }, one.label));
    x += wide;
  }
  return { parts, bottom: y + 8 };
}

function standalone(svg, title, series) {
  const { width, height } = svg.getBoundingClientRect();
  const inner = styledCopy(svg);
  fillElement(inner, { x: 0, y: TITLE_HEIGHT, width, height }, []);
  const legend = savedLegend(series, TITLE_HEIGHT + height, width);
  const all = shape("svg", { xmlns: "http://www.w3.org/2000/svg", width, height: legend.bottom, viewBox: `0 0 ${width} ${legend.bottom}`, "font-family": "sans-serif" },
    shape("rect", { width, height: legend.bottom, fill: colour("paper") }),
    shape("text", { x: 8, y: 18, fill: colour("ink"), "font-size": 14, "font-weight": 600 }, title), inner, legend.parts);
  return new XMLSerializer().serializeToString(all);
}

function saveFile(name, text) {
  const url = URL.createObjectURL(new Blob([text], { type: "image/svg+xml" }));
  element("a", { download: name, href: url }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

function fileName(title) {
  return title.toLowerCase().replace(/[^a-z0-9]+/g, "_").replace(/^_|_$/g, "") + ".svg";
}

function saveShape(svg, title, series) {
  saveFile(fileName(title), standalone(svg, title, series || []));
}

/** Also with uPlot, which draws pixels: drawn once more, outside of the window. */
function savePlot(plot) {
  const { spec, columns, top, low, log } = plot;
  const box = element("div", { class: "off-screen" });
  document.body.append(box);
  const drawing = new SvgDrawing({ spec, columns, top, low, log, box, width: () => SAVED_WIDTH });
  saveShape(drawing.svg, spec.title + (spec.unit ? `, ${spec.unit}` : "") + (log ? ", log scale" : ""), spec.series);
  box.remove();
}
