// The only module that knows how requests reach the program. Another transport with the same `call`, for example one that runs
// the answers in a worker, serves the page as well.

/** A newer question of the same kind took the place of this one. */
export class Superseded extends Error {}

/** The program does not answer: it has ended, or cannot be reached. */
export class Unanswered extends Error {}

const TYPES = { float32: Float32Array, float64: Float64Array, uint8: Uint8Array };

/** Header and arrays of a packed answer; arrays are views on its bytes. */
export function unpack(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const start = 4 + length;
  const arrays = {};
  for (const { name, dtype, shape, offset } of header.arrays ?? []) {
    const count = shape.reduce((product, one) => product * one, 1);
    arrays[name] = new TYPES[dtype](buffer, start + offset, count);
    arrays[name].shape = shape;
  }
  return { header, arrays };
}

function randomId() {
  const bytes = crypto.getRandomValues(new Uint8Array(12));
  return Array.from(bytes, (one) => one.toString(16).padStart(2, "0")).join("");
}

/** Asks the server that sent the page. One question of a kind is under way, and only the newest next one is kept. */
export function createTransport(base = "api/") {
  const client = randomId();
  const lanes = new Map();
  let [sequence, left] = [0, false];
  for (const event of ["beforeunload", "pagehide"]) addEventListener(event, () => { left = true; setTimeout(() => { left = false; }, 5000); });

  async function reply(name, payload) {
    sequence += 1;
    const headers = { "Content-Type": "application/json", "X-Client": client, "X-Sequence": String(sequence) };
    let got;
    try {
      got = await fetch(base + name, { method: "POST", headers, body: JSON.stringify(payload) });
    } catch {
      if (left) throw new Superseded(name);  // by another page
      throw new Unanswered("the program does not answer: is `infinivar serve` still running?");
    }
    if (got.status === 409) throw new Superseded(name);
    if (!got.ok) {
      const reply = await got.json().catch(() => ({}));
      throw new Error(reply.error ?? `the program refused the request (${got.status})`);
    }
    return got;
  }

  const send = async (name, payload) => unpack(await (await reply(name, payload)).arrayBuffer());

  /** What is answered in plain JSON: begin, follow and cancel a long computation. */
  const plain = async (name, payload = {}) => (await reply(name, payload)).json();

  function next(lane) {
    const { name, payload, resolve, reject } = lane.waiting;
    lane.waiting = null;
    lane.busy = true;
    send(name, payload).then(resolve, reject).finally(() => {
      lane.busy = false;
      if (lane.waiting) next(lane);
    });
  }

  /** The answer of a name: {header, arrays}. `lane` separates questions that do not replace each other. */
  function call(name, payload = {}, lane = name) {
    return new Promise((resolve, reject) => {
      const own = lanes.get(lane) ?? { busy: false, waiting: null };
      lanes.set(lane, own);
      own.waiting?.reject(new Superseded(name));
      own.waiting = { name, payload, resolve, reject };
      if (!own.busy) next(own);
    });
  }

  return { call, plain, waits: (lane) => Boolean(lanes.get(lane)?.waiting) };
}
