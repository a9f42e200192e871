// What the views share: SVG elements, the style sheet of the views, tables, plain charts and numbers.
import { digits, make } from "../dom.js";

const SPACE = "http://www.w3.org/2000/svg";
let count = 0;

/** An SVG element with attributes, and children: elements or text. */
export function svg(tag, attributes = {}, ...children) {
  const element = document.createElementNS(SPACE, tag);
  for (const [name, value] of Object.entries(attributes)) if (value !== null && value !== undefined) element.setAttribute(name, value);
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

/** A picture with a title and a description for those who do not see it. */
export function picture(width, height, title, description, ...children) {
  count += 1;
  const ids = [`view-title-${count}`, `view-text-${count}`];
  return svg("svg", { viewBox: `0 0 ${width} ${height}`, width, height, role: "img", "aria-labelledby": ids.join(" "), class: "drawn" },
    svg("title", { id: ids[0] }, title), svg("desc", { id: ids[1] }, description), ...children);
}

/** Load the style sheet of the views, once. */
export function useStyles() {
  const address = new URL("../../views.css", import.meta.url).href;
  if (![...document.querySelectorAll("link[rel=stylesheet]")].some((one) => one.href === address)) document.head.append(make("link", { rel: "stylesheet", href: address }));
}

/** A number with its unit, "–" where there is none. */
export const withUnit = (value, unit, figures = 3) => (Number.isFinite(value) ? `${digits(value, figures)} ${unit}` : "–");

/** Rows of label and text as a list of terms. */
export function terms(rows) {
  return make("dl", { className: "terms" }, ...rows.flatMap(({ label, text }) => [make("dt", {}, label), make("dd", {}, text)]));
}

/** A table that opens on demand: what a picture shows, in numbers. */
export function numbers(title, heads, rows) {
  const head = make("tr", {}, ...heads.map((text) => make("th", { scope: "col" }, text)));
  const body = rows.map((cells) => make("tr", {}, ...cells.map((text, place) => (place ? make("td", {}, text) : make("th", { scope: "row" }, text)))));
  return make("details", { className: "numbers" }, make("summary", {}, title), make("div", { className: "wide", tabIndex: 0, role: "region", aria: { label: title } }, make("table", {}, make("thead", {}, head), make("tbody", {}, ...body))));
}

/** Keep what is open in an element open while its content is replaced, and the focus where it was. */
export function replace(container, ...children) {
  const open = [...container.querySelectorAll("details")].map((one) => one.open);
  const focused = container.contains(document.activeElement) ? document.activeElement.dataset.key : undefined;
  container.replaceChildren(...children.filter((child) => child !== null && child !== undefined));
  [...container.querySelectorAll("details")].forEach((one, place) => { one.open = open[place] ?? one.open; });
  if (focused !== undefined) container.querySelector(`[data-key="${CSS.escape(focused)}"]`)?.focus({ preventScroll: true });
}

/** Round places for about so many ticks from low to high. */
export function ticks(low, high, wanted = 5) {
  const raw = (high - low) / wanted;
  if (!(raw > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= raw * 0.999);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1) found.push(k * step);
  return found;
}

/** Axes of a chart with a frame: {x, y} map values to places; `parts` are its elements. */
export function axes({ width, height, x, y, left = 52, bottom = 40, top = 12, right = 14, logarithmic = false }) {
  const inner = { left, top, width: width - left - right, height: height - top - bottom };
  const along = logarithmic ? (value) => Math.log(value / x.low) / Math.log(x.high / x.low) : (value) => (value - x.low) / (x.high - x.low);
  const place = { x: (value) => inner.left + inner.width * along(value), y: (value) => inner.top + inner.height * (1 - (value - y.low) / (y.high - y.low)) };
  const parts = [];
  const xTicks = x.ticks ?? ticks(x.low, x.high, Math.max(2, Math.round(inner.width / 75)));
  for (const value of xTicks) {
    parts.push(svg("line", { class: "grid", x1: place.x(value), x2: place.x(value), y1: inner.top, y2: inner.top + inner.height }));
    parts.push(svg("text", { class: "tick", x: place.x(value), y: inner.top + inner.height + 15, "text-anchor": "middle" }, digits(value, 4)));
  }
  for (const value of ticks(y.low, y.high, Math.max(2, Math.round(inner.height / 45)))) {
    parts.push(svg("line", { class: "grid", x1: inner.left, x2: inner.left + inner.width, y1: place.y(value), y2: place.y(value) }));
    parts.push(svg("text", { class: "tick", x: inner.left - 6, y: place.y(value) + 4, "text-anchor": "end" }, digits(value, 4)));
  }
  parts.push(svg("text", { class: "label", x: inner.left + inner.width / 2, y: height - 5, "text-anchor": "middle" }, x.label));
  const turned = `translate(12 ${inner.top + inner.height / 2}) rotate(-90)`;
  parts.push(svg("text", { class: "label", transform: turned, "text-anchor": "middle" }, y.label));
  return { ...place, inner, parts };
}

/** Points of a line as the attribute `points`. */
export const line = (xs, ys, place) => Array.from(xs, (x, k) => `${place.x(x).toFixed(1)},${place.y(ys[k]).toFixed(1)}`).join(" ");

/** Call `draw(width)` now and whenever the width of an element changes; returns what ends it. */
export function onWidth(element, draw) {
  let last = 0;
  const watcher = new ResizeObserver(() => {
    const width = Math.floor(element.clientWidth);
    // Also when it is seen again: what changed meanwhile was not drawn.
    if (width > 0 && width !== last) draw(width);
    last = width;
  });
  watcher.observe(element);
  return () => watcher.disconnect();
}

/** The title of what is shown, and its verdict: good, bad, or neither (null). */
export function heading(header, verdict = null, good = null) {
  return make("p", { className: "view-head" }, make("strong", {}, header.title), header.place ? make("span", {}, header.task ? `${header.task}: ${header.place}` : header.place) : null,
    verdict === null ? null : make("span", { className: good === null ? "verdict" : good ? "verdict yes" : "verdict no" }, verdict));
}
