// The page: which request is sent when, and what each part shows of the answers.
import { byId, download, make, say, tooltips } from "./dom.js";
import { createFields } from "./fields.js";
import { COUNT, firstMaps, firstShown, firstStudy, keep, resumed, started, transport } from "./first.js";
import { createKeys } from "./keys.js";
import { createMaps, mapOf } from "./maps.js";
import { createPanes } from "./panes.js";
import { changesOf, createStore, fromFragment, letterOf, same, toFragment, valueAt, withValue, withValues } from "./store.js";
import { createTheme, remember, remembered } from "./theme.js";
import { Superseded, Unanswered } from "./transport.js";

const EXPORTS = [
  { what: "report", title: "Report", text: "The comparison with its figures and data, as an archive (zip)" },
  { what: "figure", title: "Figure", text: "The maps of all drives side by side, or the powers of machines, as a drawing (SVG)" },
  { what: "csv", title: "Data", text: "The map of the chosen drive, one line a point, with powers, losses and limits (CSV)" },
];
const STUDY_DELAY = 90;
const SPOKEN_DELAY = 700;
const JUDGE_DELAY = 150;
const GLANCE_DELAY = 400;
const ADDRESS_DELAY = 300;
const LONGEST_BLANK = 400;
const AGAIN = 2000;
const LARGEST_FILE = 400_000;

/** What the page begins with until that is known: as most studies, maps of two drives. */
const UNKNOWN = { requirement: {}, drives: { "…": {}, "… ": {} } };

const store = createStore();
const theme = createTheme();
const view = { drive: null, shown: [], point: null, looked: null, task: null, count: COUNT, mode: "side" };
let model = null;
let version = "";
let shippedNames = new Set();
let maps = new Map();
let studyTimer = 0;
let spokenTimer = 0;
let judgeTimer = 0;
let glanceTimer = 0;
let addressTimer = 0;
let firstPainted = false;
let broken = false;
let welcomed = false;
let waiting = null;  // what was being typed when the page was left, until the last valid state is shown
let disk = null;  // the state of the study's files that the page knows
let own = null;  // name of the study with which the program was started
let mapped = null;  // the request behind the maps shown: what is typed may be no study
let tasked = null;  // the last answer about tasks
let glanced = null;  // the last answer at a glance
let firstSeen;
// The fields are many: they come after the first maps, or soon where there are none.
const seen = new Promise((resolve) => { firstSeen = resolve; setTimeout(resolve, LONGEST_BLANK); });
let round = 0;

tooltips();
const rank = async (drive) => (await transport.call("foremost", { ...payload(), drive })).header.paths ?? [];
const fields = createFields({ store, rank, onOwner: chooseOwner, onShow: showMap, onPart: choosePart });
const plots = createMaps({ theme, onLook: look, onChoose: choose, onDrive: chooseDrive });
const panes = createPanes({ theme, host: { call: transport.call, plain: transport.plain, choose: (point) => choose(point, view.drive), chooseTask, download, say, apply, store, restore } });

// What is not needed for the first maps is loaded after them.
const dialogs = () => import("./dialogs.js");
let touring = null;
const tour = () => (touring ??= import("./tour.js").then((module) => module.createTour()));

const payload = () => ({ name: store.document.name, tables: store.document.tables });

// --- asking -----------------------------------------------------------------------------------------------------------------

/** Request the maps of the drives shown, and paint them; the time from `stamp` to the painted maps is reported. */
async function askMaps(stamp = performance.now()) {
  if (model !== null && model.plane === null) { await askTasks(); return; }
  if (!view.shown.length) { plots.setDrives([]); plots.blank("Tick a drive on the left to see its map."); return; }
  const known = {};
  for (const name of view.shown) if (maps.has(name)) known[name] = maps.get(name).tag;
  status("computing …", true);
  const mine = (round += 1);
  const asking = payload();
  let reply;
  try {
    reply = await taken("maps") ?? await transport.call("maps", { ...asking, count: view.count, drives: view.shown, known });
  } catch (problem) { failed(problem); return; }
  const { header, arrays } = reply;
  answered();
  if (header.faults?.length) { if (asking.tables === store.document.tables) faulty(header.faults); return; }
  if (model === null && header.reason) return;
  if (model === null) lay(header.plane, header.requirement, (name) => header.drives[name]?.title ?? name);
  const next = new Map();
  for (const [name, own] of Object.entries(header.drives)) next.set(name, own.same && maps.has(name) ? maps.get(name) : mapOf(name, header, arrays));
  maps = next;
  mapped = asking;
  plots.setMaps(maps, () => {
    const channel = new MessageChannel();  // runs after the frame is handed over
    channel.port1.onmessage = () => painted(performance.now() - stamp, mine !== round);
    channel.port2.postMessage(null);
  });
  await askBefore();
  speakSoon();
}

const early = { maps: firstMaps, study: firstStudy };

/** The answer to a request sent while the page loaded, if it is still current; each is taken once. */
async function taken(what) {
  const asking = early[what];
  early[what] = null;
  if (asking === null) return null;
  const [before, shown] = [store.document.tables, view.shown.join()];
  const known = await asking;
  const same = known.tables === before && store.document.tables === before;
  return same && (what === "study" || (known.shown.join() === shown && view.count === COUNT)) ? known.reply : null;
}

function painted(took, more) {
  const place = byId("status");
  status(`${Math.max(1, Math.round(took))} ms`, more);
  place.title = "From the change to the painted maps";
  place.dataset.took = took.toFixed(1);
  place.dataset.paints = String(Number(place.dataset.paints ?? 0) + 1);
  judgeSoon();
  if (firstPainted) return;
  firstPainted = true;
  firstSeen();
  place.dataset.first = performance.now().toFixed(1);
  document.head.append(make("link", { rel: "stylesheet", href: "page/vendor/uPlot/uPlot.css" }));
}

function judgeSoon() {
  clearTimeout(judgeTimer);
  judgeTimer = setTimeout(askJudge, JUDGE_DELAY);
}

/** Ask how the drives shown stand against the requirement, once maps rest: it is sampled far more finely than a map. */
async function askJudge() {
  if (!model?.requirement || !view.shown.length) return;
  const judged = maps;
  let header;
  try { ({ header } = await transport.call("judge", { ...mapped, drives: view.shown })); } catch (problem) { failed(problem); return; }
  if (judged !== maps || header.faults?.length) return;
  for (const [name, found] of Object.entries(header.drives)) if (maps.has(name) && !found.fault) maps.get(name).header.requirement = found;
  plots.setMaps(maps);
}

function glanceSoon() {
  clearTimeout(glanceTimer);
  byId("glance").setAttribute("aria-busy", "true");
  if (byId("glance").hidden && (model.plane !== null || model.tasks.length || model.paths.length)) leaveRoom(model.drives.length);
  glanceTimer = setTimeout(askGlance, GLANCE_DELAY);
}

/** Room for the answer at a glance of so many drives, so that what follows it stays where it is. */
function leaveRoom(count) {
  const holder = byId("glance");
  holder.hidden = false;
  holder.style.minHeight = `${70 + 25 * count}px`;
  holder.replaceChildren(make("h2", { id: "glance-title" }, "Comparing …"));
}

/** Until maps come, grey ones of their size. */
function expectMaps({ tables }) {
  const drives = tables.drives ?? {};
  const flat = Boolean(tables.requirement || tables.duty);
  document.querySelector(".right").classList.toggle("beside", flat);
  if (flat) leaveRoom(Object.keys(drives).length);
  plots.expect(flat ? view.shown.map((name) => ({ name, title: drives[name]?.title ?? name, letter: letterOf({ tables }, name) })) : []);
}

/** Ask who wins, once the study rests: all drives are compared. */
async function askGlance() {
  const { tables } = store.document;
  let header;
  try { ({ header } = await transport.call("glance", payload())); } catch (problem) { failed(problem); return; }
  if (tables !== store.document.tables || header.faults?.length) return;
  glanced = header;
  byId("glance").setAttribute("aria-busy", "false");
  showGlance();
}

async function showGlance() {
  const { drawGlance } = await import("./glance.js");
  if (glanced !== null) drawGlance({ header: glanced, drive: view.drive, letter: (name) => letterOf(store.document, name), onDrive: chooseOwner, apply, mend: (drive) => transport.call("mend", { ...payload(), drive }) });
}

/** Set the values of a change as one step, which one undo takes back. */
function apply(changes) {
  store.put(withValues(store.document.tables, changes));
  say("Applied. Undo takes it back.");
}

/** Go back to a design that was kept, as one step. */
function restore({ name, drive, tables }) {
  store.put(tables);
  chooseOwner(drive);
  say(`${name} is back. Undo leaves it.`);
}

function status(text, busy, bad = false) {
  byId("status").textContent = text;
  byId("status").classList.toggle("bad", bad);
  byId("maps").setAttribute("aria-busy", String(busy));
}

/** Ask for the maps of the pinned state that are not known yet. */
async function askBefore() {
  const { before } = store;
  if (before === null) return;
  const lacking = view.shown.filter((name) => name in (before.document.tables.drives ?? {}) && before.maps.get(name)?.count !== view.count);
  if (lacking.length && !transport.waits("maps")) {
    try {
      const { header, arrays } = await transport.call("maps", { ...before.document, count: view.count, drives: lacking, known: {} });
      for (const name of Object.keys(header.drives ?? {})) before.maps.set(name, mapOf(name, header, arrays));
    } catch (problem) { failed(problem); return; }
  }
  if (store.before === before) plots.setBefore(before.maps);
}

async function askTasks() {
  if (!model.tasks.length) return;
  const { tables } = store.document;
  let reply = tasked?.tables === tables ? tasked.reply : null;
  if (reply === null) {
    try {
      status("computing …", true);
      reply = await transport.call("tasks", payload());
    } catch (problem) { failed(problem); return; }
  }
  answered();
  status("", false);
  if (reply.header.faults?.length) { faulty(reply.header.faults); return; }
  tasked = { tables, reply };
  const { drawTasks } = await import("./tasks.js");
  drawTasks({ header: reply.header, task: view.task, drive: view.drive, onTask: (row, name) => chooseTask(row.group === "paths" ? view.task : row.name, name) });
}

async function askStudy() {
  clearTimeout(studyTimer);
  const asking = store.document;
  let header;
  try {
    ({ header } = await taken("study") ?? await transport.call("study", payload()));
  } catch (problem) { failed(problem); return; }
  answered();
  const began = model === null;
  if (began) await seen;
  byId("study").setAttribute("aria-busy", "false");
  if (header.faults?.length) { if (asking === store.document) faulty(header.faults); return; }
  const flat = model?.plane === null;
  model = header;
  store.settle(asking);
  arrange();
  fields.setModel(model);
  plots.setStale(false);
  glanceSoon();
  if (flat !== (model.plane === null)) await askMaps();
  if (!began) return;
  judgeSoon();
  if (model.plane === null && model.tasks.length) panes.choose("machine");
  if (waiting !== null) {
    const { tables } = waiting;
    waiting = null;
    store.put(tables);
  } else askView();
  welcome();
}

/** Offer the tour on the first visit, once there is something to show. */
function welcome() {
  if (welcomed || remembered("tour") !== null) return;
  welcomed = true;
  remember("tour", "seen");
  notice("New here? A tour of two minutes shows what each part of the page is for.", [["Take the tour", startTour]], false, "tour");
}

const startTour = async () => (await tour()).start(model?.plane !== null);

function faulty(found) {
  if (model === null) { unusable(found); return; }
  fields.setFaults(found);
  plots.setStale(true);
  status("maps of the last valid state", false, true);
}

/** A study that was never valid: say why, and show that of the program. */
async function unusable(found) {
  const { name, tables } = store.document;
  const { study } = (await started).header;
  const other = !same(tables, study.tables);
  if (other) open({ now: study });
  else {
    byId("study-title").textContent = name;
    byId("study").setAttribute("aria-busy", "false");
    status("", false, true);
    plots.blank(`“${name}” cannot be shown.`);
  }
  notice(`“${name}” cannot be shown: ${found.map((fault) => fault.message).join(" ")}${other ? ` The study of the program, “${study.name}”, is shown instead.` : ""}`, [], true, "unusable");
}

function failed(problem) {
  if (problem instanceof Superseded) return;
  if (problem instanceof Unanswered) setTimeout(listen, AGAIN);
  console.error(problem);
  status("", false);
  if (broken) return;
  broken = true;
  notice(`Something went wrong: ${problem.message}`, [["Try again", () => { broken = false; changed(); }]], true, "broken");
}

/** Ask until the program is back, then for what is shown. */
async function listen() {
  if (!broken) return;
  try { await transport.call("disk"); } catch (problem) { setTimeout(listen, AGAIN); return; }
  answered();
  say("The program is back.");
  changed();
}

function answered() {
  if (!broken) return;
  broken = false;
  document.querySelector("[data-notice='broken']")?.remove();
}

/** Ask the view that is open. */
function askView() {
  if (model === null || (model.plane === null && !model.tasks.length && !model.sessions.length)) return;
  const point = view.looked ?? view.point;
  const place = model.plane === null ? { task: view.task } : point;
  panes.update({ payload: { ...payload(), drive: view.drive, drives: view.shown, ...place }, study: model });
}

/** The document is another one: first the maps, then all that follows. */
async function changed(stamp = performance.now(), wait = 0) {
  tellTools();
  byId("study").setAttribute("aria-busy", "true");
  clearTimeout(studyTimer);
  studyTimer = setTimeout(askStudy, wait);
  await askMaps(stamp);
  askView();
}

// --- what is shown ----------------------------------------------------------------------------------------------------------

/** Fit what is shown to the study: names, drives, point, tabs. */
function arrange() {
  const drives = model.drives;
  const names = drives.map((drive) => drive.name);
  document.title = `${model.title || model.name} – infinivar explorer`;
  byId("study-title").textContent = model.title || model.name;
  tellNotes();
  if (!names.includes(view.drive)) view.drive = names[0] ?? null;
  view.shown = view.shown.filter((name) => names.includes(name));
  if (!view.shown.length) view.shown = firstShown(drives.filter((drive) => !drive.machine).map((drive) => drive.name));
  const flat = model.plane !== null;
  byId("maps").classList.toggle("listed", !flat);
  if (!flat) byId("live").textContent = "";
  byId("maps-title").textContent = flat ? "Efficiency" : model.sessions.length && !model.tasks.length ? "Sessions" : "Tasks";
  for (const id of ["scale", "where"]) byId(id).hidden = !flat;
  byId("pin").disabled = !flat;
  document.querySelector(".fine").hidden = !flat;
  fields.setShown(view.shown);
  const moves = model.motions.length || model.paths.length ? ["motion"] : [];
  if (flat) {
    lay(model.plane, model.requirement, (name) => drives.find((drive) => drive.name === name).title);
    panes.offer(["balance", "contact", ...moves, ...(model.shakes ? ["plane"] : []), "machine", "designs", "work"]);
  } else {
    if (!model.tasks.some((task) => task.name === view.task)) view.task = model.tasks[0]?.name ?? null;
    if (!model.tasks.length) tellSessions();
    if (model.tasks.length) panes.offer(["machine", "balance", "contact", ...moves, "designs", "work"]);
    else panes.offer(["work"], { work: "Run sessions" });
  }
  byId("views").hidden = !flat && !model.tasks.length && !model.sessions.length;
  if (fields.owner === null || !(names.includes(fields.owner) || model.fields.some((field) => field.owner === fields.owner))) fields.setOwner(view.drive);
  tellModes();
}

/** Prepare the figures of the drives shown on a plane, and the point on it. */
function lay(plane, requirement, titleOf) {
  plots.setPlane(plane, requirement, view.count);
  view.point = view.point === null || !inside(view.point, plane) ? plots.startOf() : plots.centred(view.point);
  plots.setDrives(view.shown.map((name) => ({ name, title: titleOf(name), letter: letterOf(store.document, name) })));
  plots.setPoint(view.point, view.looked, view.drive);
}

const inside = (point, plane) => ["speed", "force"].every((axis) => point[axis] >= plane[axis][0] && point[axis] <= plane[axis][1]);

/** What the study is about, whether it is a reconstruction, and its warnings: in one line that opens. */
function tellNotes() {
  const lists = [["Reconstruction", model.reconstruction ?? []], ["Warnings", model.warnings]].filter(([, lines]) => lines.length);
  const marks = lists.map(([title, lines]) => make("span", { className: "mark" }, title === "Warnings" ? `${lines.length} warning${lines.length === 1 ? "" : "s"}` : "reconstruction"));
  const opened = byId("study-notes").querySelector("details")?.open ?? false;
  byId("study-notes").replaceChildren(make("details", { className: "note", open: opened }, make("summary", {}, "About this study", ...marks),
    make("p", {}, model.description || "No description."), ...lists.flatMap(([title, lines]) => [make("strong", {}, title), make("ul", {}, ...lines.map((line) => make("li", {}, line)))])));
}

function tellSessions() {
  status("", false);
  if (!model.sessions.length) { plots.blank("This study has nothing to draw: add a [requirement], a motion [duty.NAME] or a task [tasks.NAME]."); return; }
  plots.blank(
    make("p", {}, make("strong", {}, "This study is made of sessions: a user moves the machine and a controller guides it.")),
    make("p", {}, "Run one below, or save the study and run it on the command line, which also draws and reports it:"),
    make("ul", {}, ...model.sessions.map((one) => make("li", {}, make("code", {}, `infinivar session ${store.document.name}.toml --task ${one.name} --out out`), ` – ${one.title}`))));
}

function tellTools() {
  byId("undo").disabled = !store.undoable;
  byId("redo").disabled = !store.redoable;
}

function tellModes() {
  const pinned = store.before !== null;
  document.querySelector(".right").classList.toggle("beside", model?.plane != null && (!pinned || view.mode !== "side"));
  byId("pin").setAttribute("aria-pressed", String(pinned));
  byId("pin").querySelector("span").textContent = pinned ? "Unpin" : "Pin before";
  const holder = byId("modes");
  holder.hidden = !pinned || model?.plane === null;
  const choices = [["side", "Side by side"], ["difference", "Difference"], ["now", "Now only"]];
  holder.replaceChildren(...choices.map(([mode, title]) => make("button", { type: "button", aria: { pressed: String(view.mode === mode) }, on: { click: () => { view.mode = mode; tellModes(); plots.setBefore(store.before.maps, mode); [...holder.children].find((one) => one.getAttribute("aria-pressed") === "true").focus(); } } }, title)));
}

function speakSoon() {
  clearTimeout(spokenTimer);
  spokenTimer = setTimeout(() => { if (model?.plane) byId("live").textContent = plots.sentence(); }, SPOKEN_DELAY);
}

function clear(kind) { if (kind) document.querySelector(`[data-notice="${kind}"]`)?.remove(); }

/** A line below the header, with buttons; one of a kind at a time. */
function notice(text, buttons, bad = false, kind = "", dismissed = () => {}) {
  clear(kind);
  const line = make("div", { className: `notice${bad ? " bad" : ""}`, data: { notice: kind }, role: bad ? "alert" : "status" }, make("p", {}, text));
  for (const [title, action] of [...buttons, ["Dismiss", dismissed]]) line.append(make("button", { type: "button", on: { click: () => { line.remove(); action(); } } }, title));
  byId("notices").append(line);
}

// --- what is done -----------------------------------------------------------------------------------------------------------

function look(point, drive) {
  view.looked = point;
  if (point !== null && view.drive !== drive) follow(drive);
  plots.setPoint(view.point, view.looked, view.drive);
  askView();
}

function choose(point, drive) {
  view.point = point;
  view.looked = null;
  if (view.drive !== drive) follow(drive);
  plots.setPoint(view.point, null, view.drive);
  addressSoon();
  speakSoon();
  askView();
}

/** The drive of the views is another one. */
function follow(drive) {
  if (view.drive === drive) return;
  view.drive = drive;
  addressSoon();
  showGlance();
}

function chooseDrive(drive, edit = false) {
  follow(drive);
  if (edit) fields.setOwner(drive);
  plots.setPoint(view.point, view.looked, view.drive);
  askView();
}

function chooseOwner(owner) {
  fields.setOwner(owner);
  if (!model.drives.some((drive) => drive.name === owner)) return;
  follow(owner);
  if (model.plane === null) { askTasks(); } else plots.setPoint(view.point, view.looked, view.drive);
  askView();
}

function chooseTask(task, drive) {
  view.task = task;
  follow(drive ?? view.drive);
  askTasks();
  askView();
}

function showMap(name, on) {
  const order = model.drives.map((drive) => drive.name);
  view.shown = order.filter((one) => (one === name ? on : view.shown.includes(one)));
  arrange();
  addressSoon();
  askMaps();
}

async function choosePart(field) {
  const known = model.drives.some((drive) => drive.name === field.owner) && (model.plane !== null || model.tasks.length || model.paths.length);
  const attempt = known ? (parts) => transport.call("tried", { ...payload(), drive: field.owner, at: field.at, parts }) : null;
  (await dialogs()).pickPart({ call: transport.call, field, attempt, onPick: (part, name) => { store.put(withPart(field, part, name)); say(`${field.label}: ${part}`); } });
}

/** The tables with another part; the title of its drive names each part that is not the one with which it was opened. */
function withPart(field, part, name) {
  const tables = withValue(store.document.tables, field.at, part);
  const drive = model.drives.find((one) => one.name === field.owner);
  if (drive === undefined) return tables;
  const at = ["drives", drive.name, "title"];
  const first = valueAt(store.opened.tables, at);
  const mark = " – with ";
  const base = first ?? drive.title.split(mark)[0];
  const others = model.fields.filter((one) => one.type === "part" && one.owner === field.owner && !same(valueAt(tables, one.at), valueAt(store.opened.tables, one.at)));
  const named = others.map((one) => `${[one.group, one.label].filter(Boolean).join(" ").toLowerCase()} ${one.path === field.path ? name : one.written}`);
  return withValue(tables, at, named.length ? `${base}${mark}${named.join(", ")}` : first);
}

async function openFile(file) {
  if (file.size > LARGEST_FILE) { notice(`${file.name} was not opened: it has ${file.size} bytes; a study file has ${LARGEST_FILE} at most.`, [], true, "open"); return; }
  try {
    const { header } = await transport.call("open", { name: file.name, text: await file.text() });
    if (header.faults?.length) { notice(`${file.name} was not opened: ${header.faults.map((fault) => fault.message).join(" ")}`, [], true, "open"); return; }
    await leave();
    open({ now: { name: header.name, tables: header.tables, text: header.text } });
  } catch (problem) { failed(problem); }
}

/** Begin with another study: its document, as it was opened, and what was done to it. */
function open(next, state = {}) {
  const document = next.now;
  const [left, edited] = [store.whole, store.edited];
  waiting = next.valid && !same(next.valid.tables, document.tables) ? document : null;
  tasked = glanced = null;
  byId("glance").hidden = true;
  model = null;
  maps = new Map();
  fields.reset();
  panes.reset();
  fields.setOwner(null);
  Object.assign(view, { drive: null, shown: [], point: null, looked: null, task: null }, state);
  if (!view.shown.length) view.shown = firstShown(Object.keys(document.tables.drives ?? {}));
  expectMaps(document);
  tellStudies(document.name);
  byId("study-faults").replaceChildren();
  for (const kind of ["open", "save", "export", "unusable"]) clear(kind);
  store.open(waiting === null ? next : { ...next, now: next.valid });
  if (edited) notice(`“${left.now.name}” was changed.`, [["Back to it", () => open(left)]], false, "left");
}

function tellStudies(name) {
  const list = byId("shipped");
  list.querySelector("[data-own]")?.remove();
  if (!shippedNames.has(name)) list.prepend(make("option", { value: name, data: { own: "" } }, name));
  list.value = name;
}

async function save() {
  try {
    const { header } = await transport.call("toml", { ...payload(), text: store.document.text });
    if (header.faults?.length) { notice(`Not saved: ${header.faults.map((fault) => fault.message).join(" ")}`, [], true, "save"); return; }
    clear("save");
    download(header.file, header.text, "application/toml");
    say(`Saved as ${header.file}`);
  } catch (problem) { failed(problem); }
}

/** The study and what is shown of it, in the address. */
async function tellAddress() {
  const { drive, shown, point } = view;
  const { document, valid } = store;
  const { href } = location;
  const fragment = await toFragment({ ...payload(), drive, shown, point, designs: store.designs.map((one) => ({ name: one.name, drive: one.drive, changes: changesOf(document.tables, one.tables) })), ...(valid === null || same(valid.tables, document.tables) ? {} : { valid: { tables: valid.tables } }) });
  if (document === store.document && href === location.href) history.replaceState({ text: document.text }, "", fragment);
}

/** Before another study is opened: "back" leads to this one. */
async function leave() {
  clearTimeout(addressTimer);
  if (store.edited || location.hash) await tellAddress();
  clearTimeout(addressTimer);
  history.pushState(null, "", location.pathname);
}

function addressSoon() {
  clearTimeout(addressTimer);
  addressTimer = setTimeout(tellAddress, ADDRESS_DELAY);
}

async function link() {
  await tellAddress();
  await (await dialogs()).copyLink(location.href);
}

function pin() {
  if (store.before !== null) { store.pin(null); return; }
  if (model === null || model.plane === null) return;
  store.pin({ maps: new Map(maps) });
  say("Pinned. Change something: the maps show both states.");
}

async function exportAs(kind) {
  say(`${kind.title}: being made …`);
  try {
    const { header, arrays } = await transport.call("export", { ...payload(), what: kind.what, ...(kind.what === "csv" ? { drive: view.drive, count: view.count } : {}) });
    if (header.faults?.length) { notice(`${kind.title}: ${header.faults.map((fault) => fault.message).join(" ")}`, [], true, "export"); return; }
    download(header.file, arrays.content, header.type);
    say(`Saved as ${header.file}`);
  } catch (problem) { failed(problem); }
}

const actions = {
  undo: () => store.undo(),
  redo: () => store.redo(),
  save,
  open: () => byId("file").click(),
  pin,
  link,
  maps: () => plots.focus(),
  views: () => panes.focus(),
  find: () => byId("find").focus(),
  help: async () => (await dialogs()).help({ version, onTour: startTour }),
};

for (const name of ["undo", "redo", "save", "open", "pin", "link", "help"]) byId(name).addEventListener("click", actions[name]);
byId("export").addEventListener("click", async () => (await dialogs()).exportFiles({ kinds: model?.plane === null ? EXPORTS.filter((kind) => kind.what !== "csv") : EXPORTS, onExport: exportAs }));
createKeys(actions);

byId("file").addEventListener("change", () => {
  const [file] = byId("file").files;
  if (file) openFile(file);
  byId("file").value = "";
});
document.addEventListener("dragover", (event) => { if (event.dataTransfer?.types.includes("Files")) event.preventDefault(); });
document.addEventListener("drop", (event) => {
  const [file] = event.dataTransfer?.files ?? [];
  if (file) { event.preventDefault(); openFile(file); }
});

byId("shipped").addEventListener("change", async () => {
  try {
    const { header } = await transport.call("shipped", { which: byId("shipped").value });
    await leave();
    open({ now: { name: header.name, tables: header.tables, text: header.text } });
  } catch (problem) { failed(problem); }
});

byId("count").addEventListener("change", () => {
  view.count = Number(byId("count").value);
  if (model?.plane) arrange();
  askMaps();
  askView();
});

store.subscribe((why) => {
  if (why === "pin") { tellModes(); plots.setBefore(store.before?.maps ?? null, view.mode); return; }
  if (why === "designs") { addressSoon(); return; }
  changed(performance.now(), why === "edit" ? STUDY_DELAY : 0);
  setTimeout(() => keep(store.document, store.opened, store.valid));  // after the request for maps
  if (store.opened.name !== own || store.edited || location.hash) addressSoon();
});

/** Open the study that the address holds; of one that is resumed, it only says what is shown. */
async function openLink(known = null) {
  const content = await fromFragment(location.hash);
  if (content === null) return false;
  const { name, tables, valid, designs, ...state } = content;
  if (known !== null && !same(known.now.tables, tables)) return false;
  open({ ...(known ?? { now: { name, tables, text: history.state?.text }, valid: valid && { name, tables: valid } }), designs }, state);
  return true;
}

/** Another address, as after "back": open its study, that of the program if it holds none. */
async function followAddress() {
  if (location.hash !== "" && !location.hash.startsWith("#study=")) return;  // a place on the page
  clearTimeout(addressTimer);
  try {
    const { name, tables } = await fromFragment(location.hash) ?? (await started).header.study;
    if (store.document.name === name && same(store.document.tables, tables)) return;
    if (!await openLink()) open({ now: (await started).header.study });
  } catch (problem) { notice(problem.message, [], true, "link"); }
}

addEventListener("popstate", followAddress);

/** Tell if the files of the study have changed since the page got them. */
async function askDisk() {
  if (disk === null || broken || store.opened.name !== own) return;
  let header;
  try { ({ header } = await transport.call("disk")); } catch (problem) { failed(problem); return; }
  if (header.stamp === disk) return;
  disk = header.stamp;
  notice("The study file, or a file that it names, has changed on disk.", [["Read it again", readAgain]], false, "disk");
}

async function readAgain() {
  try {
    const { header } = await transport.call("start", { again: true });
    if (header.faults?.length) { notice(`Not read: ${header.faults.map((fault) => fault.message).join(" ")}`, [["Try again", readAgain]], true, "disk"); return; }
    disk = header.stamp;
    open({ now: header.study });
  } catch (problem) { failed(problem); }
}

addEventListener("focus", askDisk);
document.addEventListener("visibilitychange", () => { if (document.visibilityState === "visible") askDisk(); });

async function begin() {
  view.shown = firstShown(Object.keys(UNKNOWN.drives));
  expectMaps(resumed?.now ?? { tables: UNKNOWN });
  const { header } = await started;
  version = header.version;
  disk = header.stamp;
  own = header.study.name;
  shippedNames = new Set(header.shipped.map((one) => one.name));
  byId("shipped").replaceChildren(...header.shipped.map((one) => make("option", { value: one.name, title: one.description }, one.title)));
  if (resumed) { if (!await openLink(resumed).catch(() => false)) open(resumed); } else if (!await openLink().catch((problem) => { notice(problem.message, [], true, "link"); return false; })) open({ now: header.study });
  const held = [store.document.tables, waiting?.tables];
  for (const { id, name, tables, time } of header.recovered.filter((one) => !held.some((known) => same(known, one.tables)))) {
    const decided = () => transport.plain("decided", { id }).catch(failed);
    notice(`The explorer stopped while you edited “${name}” (${time}). The study as last sent is still here.`, [["Restore", () => { open({ now: { name, tables } }); decided(); }]], false, `recovered ${id}`, decided);
  }
}

begin().catch(failed);
