// The answer at a glance, above the maps: a sentence, what it hangs on, and one row a drive or machine.
import { byId, make } from "./dom.js";
import { mendBox } from "./mend.js";

/** By answer and drive, its box of changes that mend: the list stays while another drive is looked at. */
const boxes = new WeakMap();

function boxOf(header, name, made) {
  if (!boxes.has(header)) boxes.set(header, new Map());
  const known = boxes.get(header);
  if (!known.has(name)) known.set(name, made());
  return known.get(name);
}

/** Draw the answer `glance`; `onDrive(name)` is called with the row that is chosen, `mend(name)` asks what would mend a drive. */
export function drawGlance({ header, drive, letter, onDrive, mend, apply }) {
  const holder = byId("glance");
  holder.hidden = !header.rows.length;
  if (holder.hidden) return;
  holder.style.minHeight = "";
  const focused = document.activeElement?.dataset?.row;
  const weighed = header.rows.some((row) => row.weighs);
  const heads = [header.what, header.figure, "above best", "tightest limit", "margin", ...(weighed ? ["mass"] : [])];
  const row = (one) => make("tr", { className: one.best ? "best" : "", aria: { current: String(one.name === drive) } },
    make("th", { scope: "row" }, make("div", {}, make("span", { className: one.able ? "yes" : "no", title: one.able ? "meets all that is required" : "does not meet all that is required" }, one.able ? "✓" : "✗"),
      make("span", { className: "letter" }, letter(one.name)), make("button", { type: "button", title: one.title, data: { row: one.name }, on: { click: () => onDrive(one.name) } }, one.title))),
    make("td", { className: "number" }, one.shown), make("td", { className: "number more" }, one.best ? "best" : one.more),
    make("td", {}, one.limit), make("td", { className: `number${one.margin < 1 ? " no" : ""}` }, one.margin_shown), weighed ? make("td", { className: "number" }, one.weighs.replace("more than", ">")) : null);
  holder.replaceChildren(
    make("h2", { id: "glance-title", title: header.verdict }, header.headline),
    make("p", { className: header.decided ? "why" : "why open", title: "Without sampled builds and simulated motions, which “Compare all drives” adds" }, header.turned_by),
    make("div", { className: "wide" }, make("table", {}, make("thead", {}, make("tr", {}, ...heads.map((text, k) => make("th", { scope: "col", className: [1, 2, 4, 5].includes(k) ? "number" : "" }, text)))), make("tbody", {}, ...header.rows.map(row)))));
  const chosen = header.rows.find((one) => one.name === drive);
  if (chosen && !chosen.able) holder.append(make("p", { className: "why" }, `${chosen.title} does not meet all that is required. `), boxOf(header, chosen.name, () => mendBox({ ask: () => mend(chosen.name), apply })));
  if (focused) holder.querySelector(`[data-row="${CSS.escape(focused)}"]`)?.focus();
}
