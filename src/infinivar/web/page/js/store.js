// The document - name and tables of a study file -, its past and future, and the state that is pinned as "before".
// Documents are never changed in place: undo and redo go through a list of them.

const MOST_STEPS = 200;
const LONGEST_LINK = 2 ** 20;
const DEEPEST = 64;

/** Most designs that are kept beside the study. */
export const MOST_DESIGNS = 8;

const isTable = (value) => value !== null && typeof value === "object" && !Array.isArray(value);

/** The value at a list of keys, or undefined. */
export const valueAt = (tables, keys) => keys.reduce((inside, key) => (inside === null || typeof inside !== "object" ? undefined : inside[key]), tables);

/** Tables with another value at a list of keys; undefined removes the key. */
export function withValue(tables, keys, value) {
  const [key, ...rest] = keys;
  const copy = Array.isArray(tables) ? [...tables] : { ...(typeof tables === "object" ? tables : {}) };
  const content = rest.length ? withValue(copy[key] ?? {}, rest, value) : value;
  if (content === undefined) delete copy[key];
  else copy[key] = content;
  return copy;
}

/** Tables with several values changed, each {at, value}; undefined removes. */
export const withValues = (tables, changes) => changes.reduce((found, { at, value }) => withValue(found, at, value), tables);

/** The changes that turn tables into others. */
export function changesOf(from, to, at = []) {
  if (!isTable(from) || !isTable(to)) return same(from, to) ? [] : [{ at, value: to }];
  return [...new Set([...Object.keys(from), ...Object.keys(to)])].flatMap((key) => changesOf(from[key], to[key], [...at, key]));
}

/** The letter by which a drive is named where there is little room, in the order of the study; "" beyond Z. */
export function letterOf({ tables }, drive) {
  const place = Object.keys(tables.drives ?? {}).indexOf(drive);
  return place < 0 || place > 25 ? "" : String.fromCharCode(65 + place);
}

/** Whether two tables say the same. */
export const same = (one, other) => JSON.stringify(one) === JSON.stringify(other);

export function createStore() {
  let now = { name: "", tables: {} };
  let opened = now;
  let valid = null;
  let before = null;
  let past = [];
  let future = [];
  let designs = [];
  let gesture = null;
  const listeners = new Set();
  const tell = (why) => { for (const listener of listeners) listener(why); };

  return {
    get document() { return now; },
    get opened() { return opened; },
    /** The last document that the program could show; null if there was none. */
    get valid() { return valid; },
    settle(document) { valid = document; },
    get before() { return before; },
    /** States of the study that are kept to be compared, {name, drive, tables} each. */
    get designs() { return designs; },
    set designs(next) { designs = next; tell("designs"); },
    get undoable() { return past.length > 0; },
    get redoable() { return future.length > 0; },
    subscribe(listener) { listeners.add(listener); return () => listeners.delete(listener); },

    get edited() { return !same(now.tables, opened.tables); },
    /** The document with its past and future, to be opened again. */
    get whole() { return { now, opened, valid, past, future, designs }; },

    /** Begin with another study, as it is and as it was opened, by default with nothing to undo. */
    open(next) {
      ({ now, opened = now, valid = null, past = [], future = [], designs = [] } = next);
      gesture = before = null;
      tell("open");
    },

    /** Change a value. The changes of one gesture, such as dragging a slider, are undone as one. */
    set(keys, value, mark = null) { this.put(withValue(now.tables, keys, value), mark); },

    /** Change to other tables, as one step. */
    put(tables, mark = null) {
      if (same(tables, now.tables)) return;
      if (mark === null || mark !== gesture) past = [...past, now].slice(1 - MOST_STEPS);
      gesture = mark;
      future = [];
      now = { ...now, tables };
      tell("edit");
    },

    /** The next change is a step of its own. */
    finish() { gesture = null; },

    undo() {
      if (!past.length) return;
      future = [now, ...future];
      now = past.at(-1);
      past = past.slice(0, -1);
      gesture = null;
      tell("undo");
    },

    redo() {
      if (!future.length) return;
      past = [...past, now];
      now = future[0];
      future = future.slice(1);
      gesture = null;
      tell("redo");
    },

    /** Pin this state, with what is known of it, or release it (null). */
    pin(known) {
      before = known === null ? null : { document: now, ...known };
      tell("pin");
    },
  };
}

async function through(bytes, stream, most = Infinity) {
  const reader = new Blob([bytes]).stream().pipeThrough(stream).getReader();
  const parts = [];
  let size = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    size += value.length;
    if (size > most) { await reader.cancel(); throw new Error("the link holds more than a study"); }
    parts.push(value);
  }
  return new Uint8Array(await new Blob(parts).arrayBuffer());
}

/** The fragment of a link that holds a document. */
export async function toFragment(content) {
  const packed = await through(new TextEncoder().encode(JSON.stringify(content)), new CompressionStream("deflate-raw"));
  let text = "";
  for (const byte of packed) text += String.fromCharCode(byte);
  return `#study=${btoa(text).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "")}`;
}

const flatter = (value, depth) => value === null || typeof value !== "object" || (depth > 0 && Object.values(value).every((one) => flatter(one, depth - 1)));

/** The document that a fragment holds and what is shown of it, or null if it holds none. Throws if it is damaged. */
export async function fromFragment(fragment) {
  if (!fragment.startsWith("#study=")) return null;
  try {
    const text = atob(fragment.slice(7).replaceAll("-", "+").replaceAll("_", "/"));
    const bytes = Uint8Array.from(text, (one) => one.charCodeAt(0));
    const content = JSON.parse(new TextDecoder().decode(await through(bytes, new DecompressionStream("deflate-raw"), LONGEST_LINK)));
    const { name, tables, drive, shown, point, valid, designs } = content;
    if (typeof name !== "string" || !isTable(tables) || !flatter(content, DEEPEST)) throw new Error("no study");
    const drives = isTable(tables.drives) ? Object.keys(tables.drives) : [];
    return {
      name, tables, valid: isTable(valid?.tables) ? valid.tables : null, drive: drives.includes(drive) ? drive : null,
      shown: Array.isArray(shown) ? drives.filter((one) => shown.includes(one)) : [],
      designs: (Array.isArray(designs) ? designs : []).slice(0, MOST_DESIGNS).filter((one) => typeof one?.name === "string" && typeof one.drive === "string" && Array.isArray(one.changes) && one.changes.every((change) => Array.isArray(change?.at) && change.at.length))
        .map((one) => ({ name: one.name, drive: one.drive, tables: withValues(tables, one.changes) })),
      point: Number.isFinite(point?.speed) && Number.isFinite(point?.force) ? { speed: point.speed, force: point.force } : null,
    };
  } catch {
    throw new Error("The study in this link is damaged: was the link copied whole?");
  }
}
