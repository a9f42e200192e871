// The views below the maps, one tab each. A view is a module with `create(container, host)`; one that is missing or fails says so
// and leaves the rest of the page alone.
import { byId, make } from "./dom.js";
import { Superseded } from "./transport.js";

/** The views of drives: tab, module, the answer that they show, and whether it depends on the point. */
export const VIEWS = [
  { id: "balance", title: "Power balance", answer: "point", point: true },
  { id: "contact", title: "Rolling contact", answer: "contact", point: true },
  { id: "motion", title: "Motion", answer: "motion", point: false },
  { id: "plane", title: "Frequency and power", answer: "plane", point: false },
  { id: "machine", title: "Machine", answer: "drawing", point: true },
  { id: "designs", title: "Designs", answer: null, point: true },
  { id: "work", title: "Compare and size", answer: null, point: false },
];

export function createPanes({ host, theme }) {
  const tabs = byId("tabs");
  const panels = byId("panels");
  const panes = VIEWS.map((view) => {
    const tab = make("button", { type: "button", role: "tab", id: `tab-${view.id}`, aria: { controls: `panel-${view.id}`, selected: "false" }, tabIndex: -1 }, view.title);
    const body = make("div", { className: "view" });
    const why = make("p", { className: "why", role: "status", hidden: true });
    const panel = make("div", { className: "panel", role: "tabpanel", id: `panel-${view.id}`, tabIndex: 0, aria: { labelledby: `tab-${view.id}` }, hidden: true }, why, body);
    const pane = { ...view, tab, panel, body, why, made: null, shown: null, requested: null };
    tab.addEventListener("click", () => choose(pane.id, true));
    return pane;
  });
  tabs.append(...panes.map((pane) => pane.tab));
  panels.append(...panes.map((pane) => pane.panel));
  let chosen = panes[0];
  let context = null;

  tabs.addEventListener("keydown", (event) => {
    const move = { ArrowRight: 1, ArrowLeft: -1, Home: -Infinity, End: Infinity }[event.key];
    if (move === undefined) return;
    event.preventDefault();
    const seen = panes.filter((pane) => !pane.tab.hidden);
    const place = seen.indexOf(chosen) + move;
    const next = seen[Number.isFinite(place) ? (place + seen.length) % seen.length : place < 0 ? 0 : seen.length - 1];
    choose(next.id, true);
    next.tab.focus();
  });

  function tell(pane, text) {
    pane.why.textContent = text.slice(0, 1).toUpperCase() + text.slice(1);
    pane.why.hidden = text === "";
    pane.body.hidden = text !== "";
  }

  async function ready(pane) {
    pane.made ??= import(`./views/${pane.id}.js`).then((module) => module.create(pane.body, hostOf(pane)));
    return pane.made;
  }

  /** What a view may do: ask the program, ask its own answer with more words, and move the point. */
  function hostOf(pane) {
    return { ...host, get document() { return context?.payload; }, ask(more) { pane.more = { ...pane.more, ...more }; return show(pane); } };
  }

  /** What a view asks: those that show no point do not ask anew when it moves. */
  function questionOf(pane) {
    const { speed, force, ...rest } = context.payload;
    return { ...(pane.point ? context.payload : rest), ...pane.more };
  }

  const sameQuestion = (one, other) => one !== null && one.tables === other.tables && JSON.stringify({ ...one, tables: null }) === JSON.stringify({ ...other, tables: null });

  async function show(pane) {
    if (context === null) return;
    const own = { ...context, payload: questionOf(pane) };
    if (sameQuestion(pane.requested, own.payload)) return;
    pane.requested = own.payload;
    let view;
    try {
      view = await ready(pane);
    } catch (problem) {
      pane.made = null;
      pane.requested = null;
      console.error(problem);
      tell(pane, `This view could not be loaded (${problem.message}). The other views and the maps work without it.`);
      return;
    }
    if (pane.shown === null && pane.answer !== null) tell(pane, "computing …");
    try {
      const { header, arrays } = pane.answer === null ? { header: {}, arrays: {} } : await host.call(pane.answer, own.payload);
      if (pane.requested !== own.payload) return;  // of the study before
      if (header.faults?.length) { tell(pane, header.faults.map((fault) => fault.message).join(" ")); return; }
      tell(pane, "");
      pane.shown = { header, arrays, drive: own.payload.drive, theme: { dark: theme.dark }, study: own.study };
      view.update(pane.shown);
    } catch (problem) {
      if (pane.requested !== own.payload) return;
      pane.requested = null;
      if (problem instanceof Superseded) return;
      console.error(problem);
      tell(pane, `This view failed: ${problem.message}`);
    }
  }

  function choose(id, ask = false) {
    chosen = panes.find((pane) => pane.id === id) ?? chosen;
    for (const pane of panes) {
      const own = pane === chosen;
      pane.tab.setAttribute("aria-selected", String(own));
      pane.tab.tabIndex = own ? 0 : -1;
      pane.panel.hidden = !own;
    }
    if (ask) show(chosen);
  }
  choose(panes[0].id);

  theme.subscribe(async () => {
    for (const pane of panes) {
      if (pane.made === null || pane.shown === null) continue;
      try { (await pane.made).update({ ...pane.shown, theme: { dark: theme.dark } }); } catch (problem) { console.error(problem); }
    }
  });

  return {
    /** Show what is known at another place, or of another study: {payload, study}. */
    update(next) { context = next; return show(chosen); },
    /** Offer these views only. */
    offer(ids, titles = {}) {
      for (const pane of panes) {
        pane.tab.hidden = !ids.includes(pane.id);
        pane.tab.textContent = titles[pane.id] ?? pane.title;
      }
      if (chosen.tab.hidden) choose(ids[0]);
    },
    /** Forget what was chosen in the views: another study. */
    reset() {
      context = null;
      for (const pane of panes) {
        pane.more = {};
        pane.shown = pane.requested = null;
        if (pane.answer !== null) tell(pane, "computing …");
        pane.made?.then((view) => view.reset?.(), () => {});
      }
    },
    choose,
    focus() { chosen.tab.focus(); },
    get chosen() { return chosen.id; },
  };
}
