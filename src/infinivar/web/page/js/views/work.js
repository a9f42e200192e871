// Long computations: the full comparison, the search of the catalogue and sessions, with progress, and a button that ends them.
import { digits, make } from "../dom.js";

const STEP = 400;
const KINDS = {
  compare: { title: "Compare all drives", text: "Every drive over the requirement, its tolerances and motions, as infinivar compare does." },
  size: { title: "Search the catalogue", text: "The best motors and gearheads for what this study requires, as infinivar size does." },
};

const watts = (value) => (Number.isFinite(value) ? `${digits(value, 3)} W` : "");

/** Heads and rows of a result. */
function tableOf(header) {
  if (header.job === "size") return [["Rank", "Design", "Verdict"], header.designs.map((design, k) => [String(k + 1), design.title, design.verdict])];
  if (header.job === "session") return [["Measure", "Value"], [...header.measures, ...header.events].map((line) => [line.split(": ")[0], line.split(": ").slice(1).join(": ")])];
  const own = Object.entries(header.result.drives ?? header.result.machines ?? {});
  return [["Drive", "Verdict", header.result.drives ? "Mean loss" : "Mean power"], own.map(([name, one]) => [one.title ?? name, one.verdict ?? "", watts(one.mean_loss_in_region ?? one.mean_power)])];
}

function tableElement(heads, rows) {
  return make("div", { className: "wide" }, make("table", {}, make("thead", {}, make("tr", {}, ...heads.map((text) => make("th", { scope: "col" }, text)))), make("tbody", {}, ...rows.map((cells) => make("tr", {}, ...cells.map((text) => make("td", {}, text)))))));
}

/** Choices that no source settles, each with the winner it gives. */
function hangingOf({ hangs }) {
  if (!hangs) return [];
  return [make("h3", {}, "What this verdict hangs on"), make("p", { className: "why" }, `${hangs.figure}; in brackets: infeasible`), tableElement(hangs.heads, hangs.rows)];
}

/** The figures that the command draws. */
const figuresOf = ({ figures }) => (figures ?? []).map(({ title, image }) => make("figure", { className: "drawing" }, make("figcaption", {}, title), make("img", { src: image, alt: title })));

/** A folded form for the options of a computation, and what it states. */
function formOf(rows) {
  const inputs = rows.map((row) => {
    const { name, type, choices, least, most, usual } = row;
    const id = `option-${name}`;
    const input = type === "choice" ? make("select", { id }, ...choices.map((one) => make("option", { value: one, selected: one === usual }, one)))
      : type === "flag" ? make("input", { id, type: "checkbox" })
      : make("input", { id, type: type === "text" ? "text" : "number", min: least, max: most, step: type === "number" ? "any" : undefined, placeholder: usual, maxLength: type === "text" ? 200 : undefined });
    return { ...row, id, input };
  });
  const lines = inputs.map(({ id, label, help, input }) => make("p", {}, make("label", { htmlFor: id }, label), input, make("span", {}, help)));
  const stated = ({ type, usual, input }) => (type === "flag" ? input.checked || undefined : input.value.trim() === "" || (type === "choice" && input.value === usual) ? undefined : type === "whole" || type === "number" ? Number(input.value) : input.value.trim());
  return {
    element: make("details", { className: "options" }, make("summary", {}, "Options"), ...lines),
    valid: () => inputs.every(({ input }) => input.reportValidity()),
    values: () => Object.fromEntries(inputs.map((row) => [row.name, stated(row)]).filter(([, value]) => value !== undefined)),
  };
}

export function create(container, host) {
  let forms = {};
  const described = host.call("options").then(({ header }) => { forms = Object.fromEntries(Object.entries(header.jobs).map(([job, rows]) => [job, formOf(rows)])); }, console.error);
  let job = null;
  let ended = false;
  let buttons = [];
  let offered = "";
  const choices = make("div");
  const bar = make("progress", { max: 1, value: 0, aria: { label: "Progress" } });
  const words = make("span", { role: "status" });
  const stop = make("button", { type: "button", on: { click: cancel } }, "Cancel");
  const running = make("div", { className: "view-head", hidden: true }, bar, words, stop);
  const old = make("p", { className: "no", hidden: true, role: "status" }, "The study has changed since: compute again for its present state.");
  const result = make("div", { className: "work-result" });
  let shown = null;
  container.append(choices, running, old, result);

  /** What can be computed: of a study with sessions, each of them. */
  function offer({ sessions, tasks }) {
    const found = sessions.length && !tasks.length
      ? sessions.map(({ name, title }) => [{ job: "session", task: name }, `Run “${title}”`, "A user at the handle, simulated over time, as infinivar session does."])
      : Object.entries(KINDS).map(([job, { title, text }]) => [{ job }, title, text]);
    if (offered === JSON.stringify(found)) return;
    offered = JSON.stringify(found);
    buttons = found.map(([request, title, text]) => make("div", { className: "work" }, make("button", { type: "button", disabled: job !== null, on: { click: () => begin(request) } }, title), make("span", {}, text)));
    choices.replaceChildren(...buttons);
    described.then(() => { found.forEach(([{ job: kind }], k) => { if (kind in forms && buttons[k].isConnected) buttons[k].append(forms[kind].element); }); });
    if (job === null) result.replaceChildren();
  }

  function tell(text, bad = false) {
    running.hidden = true;
    for (const one of buttons) one.firstChild.disabled = false;
    if (text) result.replaceChildren(make("p", { className: bad ? "no" : "why", role: bad ? "alert" : "status" }, text));
  }

  async function begin(request) {
    const form = forms[request.job];
    if (form && !form.valid()) return;
    for (const one of buttons) one.firstChild.disabled = true;
    result.replaceChildren();
    running.hidden = false;
    bar.removeAttribute("value");
    words.textContent = "starting …";
    const { name, tables, drive } = host.document;
    old.hidden = true;
    const mine = (job = { id: null, tables });
    try {
      mine.id = (await host.plain("job", { ...request, name, tables, drive, options: form?.values() })).id;
      if (job === mine) await follow(mine);
      else await host.plain("cancel", { id: mine.id });
    } catch (problem) {
      if (job === mine) tell(problem.message, true);
    }
    if (job === mine) job = null;
  }

  async function follow(mine) {
    while (!ended && job === mine) {
      const state = await host.plain("progress", { id: mine.id });
      if (job !== mine) return;
      if (state.error) { tell(state.error, true); return; }
      if (state.done) {
        show(state.result);
        shown = mine.tables;
        old.hidden = shown === host.document.tables;
        return;
      }
      if (state.share > 0) bar.value = state.share;
      words.textContent = state.share > 0 ? `${Math.round(100 * state.share)} % – ${state.words}` : "starting …";
      await new Promise((done) => { setTimeout(done, STEP); });
    }
  }

  async function cancel() {
    const mine = job;
    job = null;
    if (mine?.id) await host.plain("cancel", { id: mine.id }).catch(() => {});
    tell("Cancelled.");
  }

  function show(header) {
    tell("");
    if (header.faults?.length) { tell(header.faults.map((fault) => fault.message).join(" "), true); return; }
    const [heads, rows] = tableOf(header);
    const save = make("button", { type: "button", on: { click: () => host.download(`${header.job}.json`, JSON.stringify(header.result, null, 1), "application/json") } }, "Save all numbers (JSON)");
    result.replaceChildren(make("p", { className: "verdict" }, make("strong", {}, header.verdict)), ...(header.notes ?? []).map((note) => make("p", { className: "why" }, note)),
      tableElement(heads, rows), ...hangingOf(header), ...figuresOf(header), save);
  }

  /** Forget what was computed: another study. */
  function reset() {
    const mine = job;
    job = shown = null;
    if (mine?.id) host.plain("cancel", { id: mine.id }).catch(() => {});
    tell("");
    result.replaceChildren();
  }

  return { reset, update(model) { offer(model.study); old.hidden = shown === null || !result.firstChild || shown === host.document.tables; }, destroy() { ended = true; container.replaceChildren(); } };
}
