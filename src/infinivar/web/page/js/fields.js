// The left pane: the values of a study by owner and part, as text in their units, with sliders, provenance and faults.
import { byId, digits, make } from "./dom.js";
import { letterOf, same, valueAt } from "./store.js";

const STEPS = 1000;
const FEW = 8;  // values that stand before all others
const PAUSE = 4000;  // between two presses of a key that count as one gesture [ms]
const KINDS = {
  stated: "printed in a paper",
  catalogue: "from a catalogue",
  derived: "follows from other values",
  fitted: "fitted to measurements",
  assumed: "assumed",
};
const FIRST_PARTS = ["", "Transmission", "Gearhead", "Motor", "Wheel", "Geometry", "Roller"];

const keyOf = (field) => field.at.join("\u0000");
const pathOf = (field) => field.at.join(".");

/** Where a value lies on its slider, 0 to STEPS, and the value at a place. */
export function placeOn({ low, high, log }, value) {
  const part = log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.round(STEPS * Math.min(Math.max(part, 0), 1));
}

export function valueOn({ low, high, log }, place) {
  const part = place / STEPS;
  return log ? low * (high / low) ** part : low + part * (high - low);
}

/** An SI value as text in the unit of the file. */
export function asWritten(field, value) {
  const bare = field.unit === "1" ? "" : field.unit;
  const { unit, factor, offset } = field.shown?.unit || bare === "" ? field.shown ?? { unit: bare, factor: 1, offset: 0 } : { unit: bare, factor: 1, offset: 0 };
  return `${digits((value - offset) / factor, 4)} ${unit}`.trim();
}

const MOST_LINES = 8;
const LINE = 34;  // characters

const listed = (field) => field.type === "row" || field.type === "list";

/** A row as text, "0 m, 0.1 m", and a list of tables, one a line, "x = 0 m, y = 0.2 m"; and what such a text stands for. */
export const listText = (list) => list.map((one) => (one !== null && typeof one === "object" ? Object.entries(one).map(([key, value]) => `${key} = ${value}`).join(", ") : String(one))).join(list.some((one) => typeof one === "object") ? "\n" : ", ");
const pieces = (text, sign) => text.split(sign).map((one) => one.trim()).filter(Boolean);
const plain = (text) => (Number.isFinite(Number(text)) ? Number(text) : text);
export function listOf(text) {
  if (!text.includes("=")) return pieces(text, /[,;\n]/).map(plain);
  return pieces(text, /[;\n]/).map((one) => Object.fromEntries(pieces(one, ",").map((two) => two.split("=").map((part) => part.trim())).map(([key, value = ""]) => [key, plain(value)])));
}

/** What a text in a box stands for in the tables: a list, a number where a study has a bare number, else the text. */
export function entered(field, text) {
  const trimmed = text.trim();
  if (listed(field)) return listOf(trimmed);
  const bare = field.type === "whole" || (field.type === "quantity" && (field.unit === "1" || field.unit === ""));
  return bare && trimmed !== "" && Number.isFinite(Number(trimmed)) ? Number(trimmed) : trimmed;
}

function originOf(field) {
  const named = KINDS[field.kind] ?? field.kind;
  return `${field.kind[0].toUpperCase()}${field.kind.slice(1)}${named === field.kind ? "" : `: ${named}`}${field.where ? ` – ${field.where}` : ""}`;
}

/** The values of a study; `rank(drive)` gives the paths of those of a drive that matter most, the first one most. */
export function createFields({ store, rank, onOwner, onShow, onPart }) {
  const holder = byId("fields");
  const open = new Map();
  const ranked = new Map();  // paths of the values that matter most, by owner; [] while they are not known
  const home = new Map();  // values as opened, by key
  let rows = new Map();
  let model = null;
  let owner = null;
  let shown = new Set();
  let faults = [];
  let edited = null;
  let signature = "";
  let counter = 0;

  let finishing = 0;
  function finishSoon() {
    clearTimeout(finishing);
    finishing = setTimeout(() => store.finish(), PAUSE);
  }

  const matches = (field, words) => words.every((word) => `${field.group} ${field.label} ${field.path} ${field.meaning}`.toLowerCase().includes(word));

  function listOwners() {
    const known = new Set(model.fields.map((field) => field.owner));
    const drives = model.drives.map((drive) => ({ ...drive, drive: true }));
    const names = new Set(drives.map((drive) => drive.name));
    const others = [...known].filter((name) => !names.has(name)).map((name) => ({ name, title: wordsOf(name) }));
    return [...drives, ...others];
  }

  const wordsOf = (name) => {
    const [group, ...rest] = name.split(".");
    if (!rest.length) return name === "requirement" ? "Requirement" : name[0].toUpperCase() + name.slice(1);
    const titles = { duty: model.motions, tasks: [...model.tasks, ...(model.sessions ?? [])], paths: model.paths ?? [], scenarios: model.scenarios ?? [] }[group] ?? [];
    const kind = { duty: "Motion", tasks: "Task", paths: "Path", scenarios: "Scenario" }[group] ?? group;
    return `${kind}: ${titles.find((one) => one.name === rest.join("."))?.title ?? rest.join(".")}`;
  };

  /** Drives and the requirement as buttons; motions, tasks and scenarios, where there are several, in one list. */
  function drawOwners() {
    const focused = document.activeElement?.dataset?.owner;
    const listed = listOwners();
    const others = listed.filter((one) => !one.drive && one.name !== "requirement");
    const direct = others.length > 1 ? listed.filter((one) => !others.includes(one)) : listed;
    byId("owners").replaceChildren(...direct.map(ownerLine), ...(others.length > 1 ? [ownerList(others)] : []));
    if (focused !== undefined) byId("owners").querySelector(`[data-owner="${CSS.escape(focused)}"]`)?.focus();
  }

  function ownerLine(one) {
    const bad = faults.some((fault) => owns(one, fault.at));
    const button = make("button", { type: "button", title: one.drive ? `${one.title} (${one.name}, ${one.type})` : one.title, data: { owner: one.name }, aria: { pressed: String(one.name === owner) }, on: { click: () => onOwner(one.name) } }, one.title);
    if (bad) button.append(make("span", { className: "flag" }, " !"), make("span", { className: "hidden" }, "has faults"));
    const letter = one.drive ? letterOf(store.document, one.name) : "";
    const edited = one.drive && !same(store.document.tables.drives?.[one.name], store.opened.tables.drives?.[one.name]);
    const mark = make("span", { className: "letter", title: edited ? "changed since the study was opened" : "" }, edited ? `${letter}′` : letter);
    const line = make("div", { className: "owner-line" }, mark, button);
    if (one.drive && model.plane !== null && !one.machine) {
      const box = make("input", { type: "checkbox", checked: shown.has(one.name), aria: { label: `Show the map of ${one.title}` }, data: { owner: `${one.name} map` }, on: { change: () => onShow(one.name, box.checked) } });
      line.append(make("label", {}, box, "map"));
    }
    return line;
  }

  function ownerList(others) {
    const here = others.some((one) => one.name === owner);
    const words = [...new Set(others.map((one) => one.title.split(":")[0].toLowerCase()))].map((one) => `${one}s`);
    const list = make("select", { className: here ? "here" : "", data: { owner: "others" }, aria: { label: `Edit ${words.join(", ")}` } },
      make("option", { value: "" }, `Edit ${words.join(", ")} …`), ...others.map((one) => make("option", { value: one.name, selected: one.name === owner }, one.title + (faults.some((fault) => owns(one, fault.at)) ? " (has faults)" : ""))));
    list.addEventListener("change", () => { if (list.value) onOwner(list.value); });
    return list;
  }

  function owns(one, at) {
    const start = one.drive ? `drives.${one.name}` : one.name;
    return at === start || at.startsWith(`${start}.`);
  }

  function visible() {
    const words = byId("find").value.toLowerCase().split(/\s+/).filter(Boolean);
    const own = model.fields.filter((field) => field.owner === owner);
    return words.length ? own.filter((field) => matches(field, words)) : own;
  }

  /** Rank the values of the owner, once: an order that followed each change would move what is being changed. */
  async function drawRanked() {
    const mine = owner;
    if (!ranked.has(mine)) {
      drawOwners();
      ranked.set(mine, []);
      if (model.drives.some((drive) => drive.name === mine)) ranked.set(mine, await rank(mine).catch(() => []));
    }
    if (mine === owner) draw();
  }

  function draw(force = false) {
    drawOwners();
    const fields = visible();
    const top = byId("find").value.trim() ? [] : (ranked.get(owner) ?? []).map((path) => fields.find((field) => field.path === path && field.slider)).filter(Boolean).slice(0, FEW);
    const found = `${top.map(keyOf)}` + fields.map((field) => `${keyOf(field)}${field.type}${field.slider === null}${field.choices}`).join("\n") + owner + byId("find").value;
    if (!force && found === signature) { for (const field of fields) rows.get(keyOf(field))?.update(field); tellFaults(); return; }
    signature = found;
    rows = new Map();
    const searching = byId("find").value.trim() !== "";
    const groups = new Map();
    for (const field of fields.filter((one) => !top.includes(one))) {
      const name = field.type === "part" ? [field.group, field.label].filter(Boolean).join(" › ") : field.group;
      groups.set(name, [...(groups.get(name) ?? []), field]);
    }
    const ordered = [...groups].sort((one, other) => orderOf(one) - orderOf(other));
    const first = top.length ? [] : ordered.filter(([, own]) => own.some((field) => field.slider)).slice(0, 2).map(([name]) => name);
    const parts = ordered.map(([name, own]) => part(name, own, searching, first.includes(name)));
    holder.replaceChildren(...(top.length ? [few(top), folded("all", "All values", fields.length - top.length, false, "all", parts)] : parts));
    if (!fields.length) holder.replaceChildren(make("p", { className: "about" }, searching ? "Nothing of that name here. Other drives and the requirement have their own values." : "No values to edit."));
    else holder.prepend(legend());
    tellFaults();
  }

  const orderOf = ([name]) => {
    const place = FIRST_PARTS.indexOf(name);
    return place < 0 ? FIRST_PARTS.length : place;
  };

  const legend = () => make("ul", { className: "key", aria: { label: "Where values come from" } },
    ...Object.keys(KINDS).map((kind) => make("li", {}, make("span", { className: `dot ${kind}`, aria: { hidden: "true" } }), kind)));

  function part(name, own, searching, first) {
    const key = `${owner}\u0000${name}`;
    const title = name || "General";
    const picked = own.find((field) => field.type === "part");
    const inner = own.filter((field) => field.type !== "part");
    return folded(name, title, inner.length, searching || (open.get(key) ?? first), searching ? null : key, [...(picked ? [picker(picked)] : []), ...inner.map(row)]);
  }

  function folded(name, title, size, shows, key, content) {
    const details = make("details", { className: "part", open: open.get(key) ?? shows, data: { part: name } },
      make("summary", {}, make("span", {}, title), make("span", { className: "count" }, `${size} value${size === 1 ? "" : "s"}`)), make("div", { className: "inside" }, ...content));
    details.addEventListener("toggle", () => { if (key !== null) open.set(key, details.open); });
    return details;
  }

  const few = (top) => make("section", { className: "few", aria: { label: "Values that matter most" } },
    make("p", { className: "about", title: "By how much 1 % changes the mean loss or the tightest margin over all that is required. Sliders reach from a fifth to five times the value, or as far as is permitted; the mark is the value of the study as opened." }, "Most effect first; marks: as opened"),
    ...top.map((field) => { const box = row(field); box.prepend(make("small", {}, field.group)); return box; }));

  function picker(field) {
    const now = make("span", { className: "now" });
    const message = make("p", { className: "message", hidden: true });
    const button = make("button", { type: "button", aria: { haspopup: "dialog", label: `Choose another part: ${field.label}` }, on: { click: () => onPart(field) } }, "Change part …");
    const box = make("div", { className: "field" }, make("div", { className: "pick" }, now, dot(field), button), message);
    const update = (next) => { now.textContent = next.written; };
    update(field);
    rows.set(keyOf(field), { box, message, input: button, update });
    return box;
  }

  function dot(field) {
    const mark = make("button", { type: "button", tabIndex: 0 });
    updateDot(mark, field);
    return mark;
  }

  function updateDot(mark, field) {
    mark.className = `dot ${field.kind}`;
    mark.dataset.tip = originOf(field);
    mark.setAttribute("aria-label", `${field.label}: ${originOf(field)}`);
  }

  function row(field) {
    counter += 1;
    const id = `field-${counter}`;
    let own = field;
    let ends = field.slider;  // kept while the value lies between them, so that the handle stays where it was put
    const mark = dot(field);
    const label = make("label", { htmlFor: id, title: [field.meaning, field.bounds && `must be ${field.bounds}`].filter(Boolean).join("; ") }, field.label);
    const message = make("p", { className: "message", id: `${id}-message`, hidden: true });
    const was = make("p", { className: "was", hidden: true });
    const line = make("div", { className: "line" }, label, mark);
    const box = make("div", { className: "field", data: { at: pathOf(field) } }, line);
    const put = (value, gesture = null) => { edited = own; store.set(own.at, value, gesture); };
    let input;
    let slider = null;
    let typed = false;

    if (field.type === "choice") {
      const options = field.choices.includes(field.value) ? field.choices : [field.written, ...field.choices];
      input = make("select", { id }, ...options.map((one) => make("option", { value: String(one) }, String(one).replaceAll("_", " "))));
      input.addEventListener("change", () => put(field.choices.find((one) => String(one) === input.value) ?? input.value));
    } else if (field.type === "flag") {
      input = make("input", { type: "checkbox", id });
      input.addEventListener("change", () => put(input.checked));
    } else {
      const look = { id, className: field.type === "quantity" || field.type === "whole" ? "" : "long", autocomplete: "off", spellcheck: false };
      input = listed(field) ? make("textarea", { ...look, title: "Values with commas between them; rows such as x = 0 m, y = 0.2 m one a line (Shift+Enter) or with semicolons between them" }) : make("input", { type: "text", ...look });
      input.addEventListener("change", () => put(entered(own, input.value)));
      input.addEventListener("keydown", (event) => {
        if (event.key === "Escape") { input.value = textNow(); input.select(); }
        if (event.key === "Enter" && listed(own) && !event.shiftKey) {
          event.preventDefault();
          put(entered(own, input.value));
          input.value = input.dataset.shown = textNow();
        }
        if ((event.key === "ArrowUp" || event.key === "ArrowDown") && slider) { event.preventDefault(); slider.focus(); nudge(event.key === "ArrowUp" ? 5 : -5); }
      });
    }
    if (field.slider) {
      slider = make("input", { type: "range", min: 0, max: STEPS, step: 1, aria: { label: `${field.label}, slider` } });
      slider.addEventListener("input", (event) => slide(event));
      slider.addEventListener("pointerdown", () => { typed = false; });
      slider.addEventListener("keydown", () => { typed = true; });
      slider.addEventListener("change", () => (typed ? finishSoon() : store.finish()));
      box.append(make("div", { className: "slide" }, make("span", { className: "track" }, slider), input));
    } else (listed(field) ? box : line).append(input);
    box.append(message, was);

    /** What the tables say where they say it, else what the program found. */
    function textNow() {
      const stated = valueAt(store.document.tables, own.at);
      if (typeof stated === "string" || typeof stated === "number") return String(stated);
      if (Array.isArray(stated)) return listText(stated);
      return own.type === "quantity" && !own.shown?.unit ? asWritten(own, own.value) : own.written;
    }

    function slide() {
      const value = valueOn(ends, Number(slider.value));
      const text = own.type === "whole" ? String(Math.round(value)) : asWritten(own, value);
      input.value = text;
      slider.setAttribute("aria-valuetext", text);
      put(entered(own, text), id);
    }

    function nudge(steps) {
      slider.value = String(Number(slider.value) + steps);
      slide();
      finishSoon();
    }

    function update(next) {
      own = next;
      updateDot(mark, next);
      if (next.type === "choice") input.value = String(next.value);
      else if (next.type === "flag") input.checked = Boolean(next.value);
      else if (document.activeElement !== input || input.dataset.shown === input.value) input.value = textNow();
      input.dataset.shown = input.value;
      if (listed(next)) input.rows = Math.min(MOST_LINES, input.value.split("\n").reduce((sum, line) => sum + Math.ceil((line.length || 1) / LINE), 0));
      if (slider && next.slider) {
        const beyond = next.value < Math.min(ends.low, ends.high) * (1 - 1e-3) || next.value > Math.max(ends.low, ends.high) * (1 + 1e-3);
        if (beyond) ends = next.slider;
        if (document.activeElement !== slider || placeOn(ends, valueOn(ends, Number(slider.value))) !== placeOn(ends, next.value)) slider.value = String(placeOn(ends, next.value));
      }
      if (slider) slider.setAttribute("aria-valuetext", textNow());
      const now = valueAt(store.document.tables, next.at);
      const first = valueAt(store.opened.tables, next.at);
      const differs = JSON.stringify(now) !== JSON.stringify(first);
      box.classList.toggle("changed", differs);
      if (!differs) home.set(keyOf(next), next.value);
      if (slider) {
        box.style.setProperty("--at", home.has(keyOf(next)) ? placeOn(ends, home.get(keyOf(next))) / STEPS : -1);
        slider.title = `${asWritten(next, ends.low)} to ${asWritten(next, ends.high)}`;
      }
      was.hidden = !differs;
      if (differs) {
        const back = make("button", { type: "button", className: "plain", aria: { label: `Reset ${next.label}` }, on: { click: () => { edited = own; input.dataset.shown = input.value; store.set(own.at, first); input.focus(); } } }, "reset");
        was.replaceChildren("changed", back);
      }
    }
    rows.set(keyOf(field), { box, message, input, update, field });
    update(field);
    return box;
  }

  /** Show each fault at its field; those of no visible field at the top. */
  function tellFaults() {
    const rest = [];
    const messages = new Map();
    for (const fault of faults) {
      const found = [...rows.entries()].find(([key]) => key.replaceAll("\u0000", ".") === fault.at)?.[0]
        ?? [...rows.entries()].find(([key]) => fault.at.startsWith(`${key.replaceAll("\u0000", ".")}.`))?.[0]
        ?? (edited !== null && rows.has(keyOf(edited)) && (fault.at === "" || pathOf(edited).startsWith(fault.at)) ? keyOf(edited) : undefined);
      if (found === undefined) rest.push(fault.message);
      else messages.set(found, [...(messages.get(found) ?? []), fault.message]);
    }
    for (const [key, { box, message, input }] of rows) {
      const words = messages.get(key);
      box.classList.toggle("bad", words !== undefined);
      message.hidden = words === undefined;
      message.textContent = words?.join(" ") ?? "";
      if (words === undefined) { input.removeAttribute("aria-invalid"); input.removeAttribute("aria-describedby"); continue; }
      const place = message.id || (message.id = `message-${(counter += 1)}`);
      input.setAttribute("aria-invalid", "true");
      input.setAttribute("aria-describedby", place);
      const details = box.closest("details");
      if (details && !details.open) details.open = true;
      if (box.contains(document.activeElement)) message.scrollIntoView({ block: "nearest" });
    }
    byId("study-faults").replaceChildren(...rest.map((text) => make("p", {}, text)));
  }

  byId("find").addEventListener("input", () => { if (model) draw(); });

  return {
    /** Show a study as the program describes it. */
    async setModel(next) { model = next; faults = []; await drawRanked(); },
    setOwner(next) { if (next === owner) return; owner = next; if (model) drawRanked(); },
    setShown(next) { shown = new Set(next); if (model) drawOwners(); },
    setFaults(next) { faults = next; if (model) { for (const { update, field } of rows.values()) if (field) refresh(update, field); drawOwners(); } tellFaults(); },
    /** Forget which parts are open: another study. */
    reset() { open.clear(); ranked.clear(); home.clear(); signature = ""; edited = null; byId("find").value = ""; },
    get owner() { return owner; },
  };

  function refresh(update, field) { update(model.fields.find((one) => keyOf(one) === keyOf(field)) ?? field); }
}
