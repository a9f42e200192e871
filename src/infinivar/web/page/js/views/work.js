// Long computations: the full comparison and the search of the catalogue, with progress, and a button that ends them.
import { digits, make } from "../dom.js";

const STEP = 400;
const KINDS = {
  compare: { title: "Compare all drives", text: "Every drive over the requirement, its tolerances and motions, as infinivar compare does." },
  size: { title: "Search the catalogue", text: "The best motors and gearheads for what this study requires, as infinivar size does." },
};

const watts = (value) => (Number.isFinite(value) ? `${digits(value, 3)} W` : "");

export function create(container, host) {
  let job = null;
  let ended = false;
  const buttons = Object.entries(KINDS).map(([kind, { title, text }]) => make("div", { className: "work" }, make("button", { type: "button", on: { click: () => begin(kind) } }, title), make("span", {}, text)));
  const bar = make("progress", { max: 1, value: 0, aria: { label: "Progress" } });
  const words = make("span", { role: "status" });
  const stop = make("button", { type: "button", on: { click: cancel } }, "Cancel");
  const running = make("div", { className: "view-head", hidden: true }, bar, words, stop);
  const result = make("div", { className: "work-result" });
  container.append(...buttons, running, result);

  function tell(text, bad = false) {
    running.hidden = true;
    for (const one of buttons) one.firstChild.disabled = false;
    if (text) result.replaceChildren(make("p", { className: bad ? "no" : "why", role: bad ? "alert" : "status" }, text));
  }

  async function begin(kind) {
    for (const one of buttons) one.firstChild.disabled = true;
    result.replaceChildren();
    running.hidden = false;
    bar.removeAttribute("value");
    words.textContent = "starting …";
    const { name, tables } = host.document;
    try {
      const { id } = await host.plain("job", { job: kind, name, tables });
      job = id;
      await follow(id);
    } catch (problem) {
      tell(problem.message, true);
    }
    job = null;
  }

  async function follow(id) {
    while (!ended && job === id) {
      const state = await host.plain("progress", { id });
      if (job !== id) return;
      if (state.error) { tell(state.error, true); return; }
      if (state.done) {
        show(state.result);
        return;
      }
      if (state.share > 0) bar.value = state.share;
      words.textContent = `${Math.round(100 * state.share)} % ${state.words ?? ""}`;
      await new Promise((done) => { setTimeout(done, STEP); });
    }
  }

  async function cancel() {
    const id = job;
    job = null;
    if (id === null) return;
    await host.plain("cancel", { id });
    tell("Cancelled.");
  }

  function show(header) {
    tell("");
    if (header.faults?.length) { tell(header.faults.map((fault) => fault.message).join(" "), true); return; }
    const rows = header.job === "size"
      ? header.designs.map((design, k) => [String(k + 1), design.title, design.verdict])
      : Object.entries(header.result.drives ?? header.result.machines ?? {}).map(([name, own]) => [own.title ?? name, own.verdict ?? "", watts(own.mean_loss_in_region ?? own.mean_power)]);
    const heads = header.job === "size" ? ["Rank", "Design", "Verdict"] : ["Drive", "Verdict", header.result.drives ? "Mean loss" : "Mean power"];
    const save = make("button", { type: "button", on: { click: () => host.download(`${header.job}.json`, JSON.stringify(header.result, null, 1), "application/json") } }, "Save all numbers (JSON)");
    result.replaceChildren(make("p", { className: "verdict" }, make("strong", {}, header.verdict)), ...(header.notes ?? []).map((note) => make("p", { className: "why" }, note)),
      make("div", { className: "wide" }, make("table", {}, make("thead", {}, make("tr", {}, ...heads.map((text) => make("th", { scope: "col" }, text)))), make("tbody", {}, ...rows.map((cells) => make("tr", {}, ...cells.map((text) => make("td", {}, text))))))), save);
  }

  return { update() {}, destroy() { ended = true; container.replaceChildren(); } };
}
