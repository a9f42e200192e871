// Designs side by side: states of the study that were kept, each with one drive, in a table of one column a design.
import { listed, make } from "../dom.js";
import { changesOf, MOST_DESIGNS, same } from "../store.js";
import { Superseded } from "../transport.js";
import { replace, useStyles } from "./shared.js";

const REST = 120;  // [ms] the cursor moves over maps meanwhile
const MINUTES = 30;

const isOf = (design, { drive, tables }) => design.drive === drive && same(design.tables, tables);

export function create(container, host) {
  const { call, store, restore, say } = host;
  useStyles();
  const answers = new WeakMap();  // by tables and drive: {question, header}
  let model = null;
  let [drive, place] = [null, {}];
  let timer = 0;
  let round = 0;
  const name = make("input", { type: "text", id: "design-name", maxLength: 60, autocomplete: "off" });
  const keeper = make("button", { type: "button", className: "main", on: { click: keep } }, "Keep this design");
  const minutes = make("input", { type: "number", id: "design-minutes", min: 0.1, max: 1e5, step: "any", value: MINUTES, required: true, on: { change: () => { if (minutes.reportValidity()) soon(0); } } });
  const table = make("div", { className: "wide", tabIndex: 0, role: "region", aria: { label: "Designs side by side" } });
  const note = make("p", { className: "small" });
  container.replaceChildren(make("p", { className: "design-tools" }, make("label", { htmlFor: name.id }, "Name"), name, keeper, make("label", { htmlFor: minutes.id }, "windings warm from cold for"), minutes, "min"), table, note);

  const present = () => ({ name: "now", drive, tables: store.document.tables });
  const columns = () => (store.designs.some((one) => isOf(one, present())) ? store.designs : [...store.designs, present()]);
  const kept = ({ tables, drive: of }) => answers.get(tables)?.get(of);

  /** What was changed against the study as opened, in words. */
  function changesIn({ tables, drive: own }) {
    const others = tables.drives?.[own]?.like === undefined;  // are no part of this one
    return changesOf(store.opened.tables, tables).filter(({ at }) => !(others && at[0] === "drives" && at[1] !== own)).map(({ at, value }) => {
      const field = model.study.fields.find((one) => same(one.at, at));
      const shown = value?.value ?? value;
      return `${field ? field.label : at.at(-1)} ${shown === undefined ? "as by default" : typeof shown === "object" ? "changed" : shown}`;
    });
  }

  function keep() {
    const found = present();
    store.designs = [...store.designs, { ...found, name: name.value.trim() || name.placeholder }];
    name.value = "";
    say("Kept: it stays beside what follows.");
    soon(0);
  }

  function soon(wait = REST) {
    clearTimeout(timer);
    draw();
    timer = setTimeout(ask, wait);
  }

  /** Ask for each design in turn: the program computes one at a time. */
  async function ask() {
    const mine = (round += 1);
    const more = { time: 60 * Number(minutes.value), ...place };
    for (const one of columns()) {
      const question = JSON.stringify(more);
      if (kept(one)?.question === question) continue;
      let header;
      try {
        ({ header } = await call("design", { name: store.document.name, tables: one.tables, drive: one.drive, ...more }));
      } catch (problem) {
        if (problem instanceof Superseded) return;
        header = { faults: [problem] };
      }
      if (mine !== round) return;
      if (!answers.has(one.tables)) answers.set(one.tables, new Map());
      answers.get(one.tables).set(one.drive, { question, header });
    }
    draw(false);
  }

  /** The cells of a row that are the best: of designs that meet what is required, unless what some leave out decides. */
  function bestOf(cells, able) {
    const rivals = cells.filter((cell, k) => cell?.better && cell.value !== null && (able[k] || !able.includes(true)));
    if (rivals.length < 2) return [];
    const best = (rivals[0].better === "less" ? Math.min : Math.max)(...rivals.map((cell) => cell.value));
    const found = rivals.filter((cell) => cell.value === best);
    return found.length < rivals.length && found.every((one) => one.lacks === "" || rivals.every((other) => other.lacks === one.lacks)) ? found : [];
  }

  function draw(busy = true) {
    if (model === null) return;
    const designs = columns();
    const full = store.designs.length === MOST_DESIGNS;
    keeper.disabled = full || designs === store.designs;
    name.placeholder = changesIn(present()).slice(0, 2).join(", ") || "as opened";
    const found = designs.map((one) => kept(one)?.header ?? null);
    const able = found.map((one) => one?.able === true);
    const keys = new Map(found.flatMap((one) => one?.rows ?? []).map((row) => [row.key, row]));
    const heads = designs.map((one, k) => head(one, found[k], isOf(one, present())));
    const lines = [...keys].map(([key, { label, of }]) => {
      const cells = found.map((one) => one?.rows?.find((row) => row.key === key));
      const best = bestOf(cells, able);
      return make("tr", {}, make("th", { scope: "row" }, label, make("small", {}, of)), ...cells.map((cell) => make("td", { className: `${best.includes(cell) ? "best" : ""}${cell?.beyond ? " no" : ""}`, title: cell?.lacks ? `leaves out: ${cell.lacks}` : null },
        cell === undefined ? "–" : cell.text.replace("more than", ">"), best.includes(cell) ? make("small", {}, "best") : null)));
    });
    const changes = make("tr", {}, make("th", { scope: "row" }, "Changes"), ...designs.map((one) => make("td", {}, make("small", {}, listed(changesIn(one)) || "none"))));
    table.setAttribute("aria-busy", String(busy));
    replace(table, make("table", { className: "designs" }, make("thead", {}, make("tr", {}, make("th", { scope: "col" }, "Design"), ...heads)), make("tbody", {}, changes, ...lines)));
    note.textContent = full ? `${MOST_DESIGNS} designs are kept, as many as can be: remove one to keep another.` : "Keep designs to see them side by side. The address holds them; the file does not. Best: of those that meet all that is required.";
  }

  function head(one, found, here) {
    const own = store.designs.includes(one);
    const state = found === null ? "computing …" : found.faults ? found.faults.map((fault) => fault.message).join(" ") : `${found.able ? "✓" : "✗"} ${found.title}`;
    return make("th", { scope: "col", aria: { current: String(here) } },
      own ? make("button", { type: "button", data: { key: `restore ${one.name}` }, title: "Go back to this design", on: { click: () => restore(one) } }, one.name) : make("span", {}, one.name),
      own ? make("button", { type: "button", className: "plain", title: `Remove ${one.name}`, aria: { label: `Remove ${one.name}` }, on: { click: () => { store.designs = store.designs.filter((other) => other !== one); soon(0); } } }, "×") : null,
      make("small", { className: found?.able === false ? "no" : "" }, state));
  }

  return {
    update(next) {
      const { drive: chosen, speed, force } = host.document;
      model = next;
      [drive, place] = [chosen, Number.isFinite(speed) ? { speed, force } : {}];
      soon();
    },
    reset() { round += 1; clearTimeout(timer); model = null; table.replaceChildren(); },
  };
}
