// Elements of the page. Text is always text, never HTML: names of folders may hold anything.

function fillElement(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? "" : value);
  }
  for (const child of children.flat())
    if (child !== null && child !== undefined) node.append(child);
  return node;
}

function element(tag, attributes, ...children) {
  return fillElement(document.createElement(tag), attributes, children);
}

function shape(tag, attributes, ...children) {
  return fillElement(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

/** The value of a colour variable of the style sheet in the present theme. */
function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
}

/** A square of a series' colour beside its name. */
function swatch(name) {
  return shape("svg", { class: "swatch", viewBox: "0 0 10 10", "aria-hidden": "true" },
    shape("rect", { width: 10, height: 10, rx: 2, fill: `var(--${name})` }));
}

/** Calls `action` when the width of an element changes. */
function onResize(node, action) {
  let width = node.clientWidth;
  new ResizeObserver(() => {
    if (node.clientWidth === width || node.clientWidth === 0) return;
    width = node.clientWidth;
    action();
  }).observe(node);
}
