// Dialogs: choosing a part from the catalogue, exporting, help, and a link that could not be copied.
import { make, say } from "./dom.js";
import { KEYS } from "./keys.js";
import { Superseded } from "./transport.js";

/** A modal dialog that goes when it is closed. */
function dialog(title, ...content) {
  const heading = make("h2", { id: "dialog-title" }, title);
  const box = make("dialog", { aria: { labelledby: "dialog-title" } }, heading, ...content);
  const came = document.activeElement;
  box.addEventListener("close", () => { box.remove(); if (came?.isConnected) came.focus(); });
  box.addEventListener("click", (event) => { if (event.target === box) box.close(); });
  document.body.append(box);
  box.showModal();
  return box;
}

const closing = (box, words = "Close") => make("div", { className: "actions" }, make("button", { type: "button", on: { click: () => box().close() } }, words));

const TRIED = 4;  // parts at once

/** Orders of what a drive would need with the parts listed; those with which it is within limits come first. */
const OWN = new Map([["power", { title: "least power", of: ({ power }) => power ?? Infinity }], ["margin", { title: "largest margin", of: ({ margin }) => -(margin ?? 0) }]]);

/** Choose a part of a kind; `onPick` gets its name in the catalogue. `attempt(parts)` answers what the drive would need with each; null if
 *  there is no drive to try them in. */
export function pickPart({ call, field, onPick, attempt }) {
  const search = make("input", { type: "search", id: "part-search", placeholder: "name, maker, or mass < 100 g …", autocomplete: "off", spellcheck: false });
  const list = make("div", { className: "found", role: "group", aria: { label: "Parts found" } });
  const count = make("p", { className: "about", role: "status" });
  const order = make("select", { id: "part-order", on: { change: () => ask() } }, make("option", { value: "" }, "as listed"), ...(attempt ? [...OWN].map(([value, { title }]) => make("option", { value }, title)) : []));
  const known = new Map();  // by part, what the drive would need with it
  let box = null;
  let round = 0;

  /** Say what the drive would need with the parts listed, a few at a time. */
  async function preview() {
    const mine = (round += 1);
    const places = [...box.querySelectorAll("[data-part]")];
    const told = () => { for (const place of places) { const row = known.get(place.dataset.part); place.textContent = row?.words ?? ""; place.classList.toggle("no", row?.able === false); } };
    told();
    const parts = [...new Set(places.map((place) => place.dataset.part))].filter((part) => !known.has(part));
    try {
      for (let k = 0; k < parts.length && mine === round && box.isConnected; k += TRIED) {
        const { header } = await attempt(parts.slice(k, k + TRIED));
        for (const row of header.rows) known.set(row.part, row);
        told();
      }
    } catch (problem) { if (!(problem instanceof Superseded)) console.error(problem); }
    if (mine !== round || !OWN.has(order.value)) return;
    const rank = (button) => { const row = known.get(button.querySelector("[data-part]").dataset.part); return [row?.able ? 0 : 1, OWN.get(order.value).of(row ?? {})]; };
    list.append(...[...list.querySelectorAll("button")].map((button) => [rank(button), button]).sort(([one], [other]) => one[0] - other[0] || one[1] - other[1]).map(([, button]) => button));
  }

  async function ask() {
    let header;
    try {
      ({ header } = await call("parts", { kind: field.part_kind, query: search.value, limit: 40, sort: OWN.has(order.value) ? "" : order.value }));
    } catch (problem) {
      if (!(problem instanceof Superseded)) list.replaceChildren(make("p", {}, problem.message));
      return;
    }
    if (header.faults?.length) {
      count.textContent = "";
      list.replaceChildren(...header.faults.map((fault) => make("p", { className: "no" }, fault.message)));
      return;
    }
    const { rows, columns, count: total } = header;
    count.textContent = rows.length ? `${total} part${total === 1 ? "" : "s"}${total > rows.length ? `, ${rows.length} shown: type to narrow` : ""}` : "";
    list.replaceChildren(...rows.map((row) => {
      const facts = columns.filter(({ name }) => row.texts[name] !== "–").map(({ name, label, unit }) => `${label} ${row.texts[name]} ${unit}`.trim());
      return make("button", { type: "button", on: { click: () => { box.close(); onPick(row.part, row.name); } } },
        make("b", {}, row.name), ` ${row.manufacturer}`, make("small", {}, [row.part, ...facts].join(" · ")), attempt && make("small", { data: { part: row.part } }));
    }));
    if (order.options.length <= 1 + OWN.size) order.append(...columns.flatMap(({ name, label }) => [make("option", { value: name }, `least ${label}`), make("option", { value: `-${name}` }, `largest ${label}`)]));
    if (attempt) preview();
    if (!rows.length) list.append(make("p", {}, `No part matches “${search.value}”. Try a shorter word.`));
  }

  search.addEventListener("input", ask);
  search.addEventListener("keydown", (event) => {
    if (event.key === "ArrowDown") { event.preventDefault(); list.querySelector("button")?.focus(); }
    if (event.key === "Enter") list.querySelector("button")?.click();
  });
  list.addEventListener("keydown", (event) => {
    const next = { ArrowDown: "nextElementSibling", ArrowUp: "previousElementSibling" }[event.key];
    if (!next) return;
    event.preventDefault();
    (document.activeElement[next] ?? search).focus();
  });
  box = dialog(`Choose: ${[field.group, field.label].filter(Boolean).join(" › ").toLowerCase()}`,
    make("p", { className: "about" }, `Now: ${field.written}. Values that you set yourself stay as they are. `, attempt && make("b", { data: { part: "" } })),
    make("label", { htmlFor: "part-search" }, "Search the catalogue "), search, make("label", { htmlFor: "part-order" }, " Sort "), order, count, list, closing(() => box, "Cancel"));
  search.focus();
  ask();
}

/** Choose what to export. */
export function exportFiles({ kinds, onExport }) {
  const box = dialog("Export",
    make("div", { className: "choices" }, ...kinds.map((kind) => make("button", { type: "button", on: { click: () => { box.close(); onExport(kind); } } }, kind.title, make("small", {}, kind.text)))),
    closing(() => box, "Cancel"));
}

/** Keys, and the tour again. */
export function help({ version, onTour }) {
  const box = dialog("Help",
    make("p", { className: "about" }, `infinivar ${version}. Every number on this page is computed by the program on this machine; nothing is sent elsewhere.`),
    make("h3", {}, "Keys"),
    make("dl", {}, ...KEYS.flatMap(([key, words]) => [make("dt", {}, make("kbd", {}, key)), make("dd", {}, words)])),
    make("div", { className: "actions" },
      make("button", { type: "button", on: { click: () => { box.close(); onTour(); } } }, "Start the tour"),
      make("button", { type: "button", className: "main", on: { click: () => box.close() } }, "Close")));
}

/** Put a link on the clipboard; where that is not allowed, show it to be copied by hand. */
export async function copyLink(address) {
  try {
    await navigator.clipboard.writeText(address);
    say(`Link copied: it holds the whole study in ${Math.ceil(address.length / 100) / 10} kB. The address bar has it, too.`);
  } catch {
    const text = make("input", { type: "text", id: "link-text", readOnly: true, value: address });
    text.style.width = "100%";
    const box = dialog("Link to this study", make("label", { htmlFor: "link-text" }, "Copy this address: it holds the whole study."), text, closing(() => box));
    text.select();
  }
}
