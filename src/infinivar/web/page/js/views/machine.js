// The machine drawn from its geometry: what turns and slides does so with its true ratio of speeds, slowed down by a stated factor.
import { digits, make, say } from "../dom.js";
import { remember, remembered } from "../theme.js";
import { heading, onWidth, replace, svg, terms, useStyles } from "./shared.js";

const CALM = matchMedia("(prefers-reduced-motion: reduce)");
const TEXT = 12;

export function create(container) {
  useStyles();
  const head = make("div");
  const scenes = make("div", { className: "scenes" });
  const beside = make("div", { className: "beside" });
  const button = make("button", { type: "button", data: { key: "play" }, on: { click: () => run(!playing, true) } });
  const pace = make("span", { className: "pace" });
  const bar = make("p", { className: "view-head play" }, button, pace);
  container.replaceChildren(head, bar, make("div", { className: "machine" }, scenes, beside));
  let model = null;
  let moving = [];
  let playing = !CALM.matches && remembered("motion") !== "still";
  // How far each thing has turned or slid: it goes on from there when its speed changes.
  const phases = new Map();
  let before = null;
  let request = 0;
  const seen = new IntersectionObserver((entries) => { visible = entries.at(-1).isIntersecting; next(); });
  let visible = true;
  seen.observe(scenes);
  const end = onWidth(scenes, () => draw());

  function draw() {
    if (model === null || scenes.clientWidth === 0) return;
    const { header } = model;
    moving = [];
    const wide = scenes.clientWidth;
    const columns = header.scenes.length < 3 || wide < 560 ? 1 : 2;
    const side = Math.floor((wide - 14 * (columns - 1)) / columns);
    const first = columns === 2;
    replace(scenes, ...header.scenes.map((scene, place) => drawn(scene, header, place === 0 && first ? wide : side, moving, place === 0)));
    step(0);
  }

  /** Move on by some seconds of the page. */
  function step(seconds) {
    const { slow } = model.header;
    for (const { key, rate, apply } of moving) {
      const phase = (phases.get(key) ?? 0) + (rate * seconds) / slow;
      phases.set(key, phase);
      apply(phase);
    }
  }

  function frame(now) {
    request = 0;
    const passed = before === null ? 0 : Math.min(0.1, (now - before) / 1000);
    before = now;
    if (model !== null) step(passed);
    next();
  }

  function next() {
    if (playing && visible && moving.length && request === 0) request = requestAnimationFrame(frame);
    if (!playing || !visible) before = null;
  }

  function run(on, chosen = false) {
    playing = on;
    button.textContent = on ? "❚❚ Pause" : "▶ Play";
    if (chosen) { remember("motion", on ? "moves" : "still"); say(on ? "The machine moves." : "The machine stands still."); }
    next();
  }
  const calm = () => { if (CALM.matches) run(false); };
  CALM.addEventListener("change", calm);
  run(playing);

  return {
    update(next_) {
      model = next_;
      const { header } = model;
      const nothing = header.reason !== null;
      scenes.hidden = beside.hidden = nothing;
      replace(head, heading(header), nothing ? make("p", { className: "blank" }, header.reason) : null);
      moving = [];
      if (!nothing) {
        draw();
        replace(beside, terms(header.state), ...header.notes.map((text) => make("p", { className: "small" }, `${text[0].toUpperCase()}${text.slice(1)}.`)));
      }
      bar.hidden = nothing || !moving.length;
      pace.textContent = header.slow > 1 ? `${digits(header.slow, 2)} times slower than the machine; speeds to scale with each other` : "at the speed of the machine";
      next();
    },
    destroy() {
      cancelAnimationFrame(request);
      seen.disconnect();
      end();
      CALM.removeEventListener("change", calm);
    },
  };
}

/** One scene as a figure; what moves adds its key, rate and how it is placed to `moving`. */
function drawn(scene, header, width, moving, main) {
  let [left, bottom, right, top] = scene.frame;
  const most = main ? 400 : 300;
  const room = main ? 0 : 0.03 * (right - left);
  [left, right] = [left - room, right + room];
  // Text is as large on every drawing: it may need more room than the shapes, and the more the smaller they are.
  let pad = { left: 0, right: 0 };
  const fitted = () => Math.min((width - 4) / (right - left + pad.left + pad.right), most / (top - bottom));
  for (let turn = 0; turn < 8; turn += 1) pad = textRoom(scene, fitted(), left, right);
  const shown = { scale: fitted() };
  [left, right] = [left - pad.left, right + pad.right];
  const high = 18 / shown.scale;
  [bottom, top] = [bottom - high, top + high];
  const size = [Math.round((right - left) * shown.scale), Math.round((top - bottom) * shown.scale)];
  const place = ([x, y]) => [(x - left) * shown.scale, (top - y) * shown.scale];
  const groups = {};
  const root = svg("svg", { viewBox: `0 0 ${size[0]} ${size[1]}`, width: size[0], height: size[1], class: "drawn", role: "img", "aria-label": `${scene.title}. ${main ? header.description : scene.note}` });
  const layers = [];
  for (const item of scene.items) {
    const element = shape(item, place, shown.scale, scene.title, moving);
    if (!item.slide) { layers.push(element); continue; }
    // Items of a slide keep their place in the order of painting: each run of them is a group of its own.
    let last = layers.at(-1);
    if (last?.dataset?.slide !== item.slide) {
      last = svg("g", { "data-slide": item.slide });
      layers.push(last);
      (groups[item.slide] ??= []).push(last);
    }
    last.append(element);
  }
  root.append(...layers);
  for (const [name, own] of Object.entries(groups)) moving.push({ key: `slide ${name}`, rate: header.slides[name].rate, apply: (way) => slid(own, header.slides[name], way, shown.scale) });
  return make("figure", { className: main ? "scene main" : "scene" }, make("figcaption", {}, scene.title, scene.note ? make("small", {}, scene.note) : null), root, keysOf(scene));
}

/** What the arrows stand for. */
function keysOf({ keys }) {
  if (!keys.length) return null;
  return make("ul", { className: "legend" }, ...keys.map(({ look, text }) => make("li", {}, look ? svg("svg", { width: 26, height: 10, "aria-hidden": "true", class: "drawn" }, arrow({ start: [0, 0], end: [25, 0] }, ([x]) => [x, 5], `m ${look}`)) : null, text)));
}

/** Room for texts beside the shapes, in millimetres. */
function textRoom(scene, scale, left, right) {
  const room = { left: 0, right: 0 };
  for (const item of scene.items) {
    const words = item.text ?? "";
    if (!words) continue;
    const [x] = item.at;
    const wide = (0.64 * TEXT * words.length) / scale;
    const [before, after] = { start: [0, wide], middle: [wide / 2, wide / 2], end: [wide, 0] }[item.anchor];
    room.left = Math.max(room.left, left - (x - before));
    room.right = Math.max(room.right, x + after - right);
  }
  return room;
}

function slid(groups, { direction, span, wraps }, passed, scale) {
  let way = passed;
  if (span > 0) way = wraps ? ((way % span) + span) % span : ((((way + span / 2) % span) + span) % span) - span / 2;
  for (const group of groups) group.setAttribute("transform", `translate(${(direction[0] * way * scale).toFixed(2)} ${(-direction[1] * way * scale).toFixed(2)})`);
}

function shape(item, place, scale, scene, moving) {
  const look = `m ${item.look}`;
  switch (item.kind) {
    case "poly": {
      const points = item.points.map((one) => place(one).map((value) => value.toFixed(1)).join(",")).join(" ");
      return svg(item.closed ? "polygon" : "polyline", { class: look, points });
    }
    case "circle": {
      const [cx, cy] = place(item.centre);
      return svg("circle", { class: look, cx, cy, r: Math.max(1.5, item.radius * scale) });
    }
    case "text": {
      const [x, y] = place(item.at);
      return svg("text", { class: look, x, y: y + 4, "text-anchor": item.anchor }, item.text);
    }
    case "arrow": return arrow(item, place, look);
    default: return marks(item, place, scene, look, moving);
  }
}

function arrow(item, place, look) {
  const [x1, y1] = place(item.start);
  const [x2, y2] = place(item.end);
  const long = Math.hypot(x2 - x1, y2 - y1);
  if (long < 2) return svg("g");
  const [ux, uy] = [(x2 - x1) / long, (y2 - y1) / long];
  const head = Math.min(10, 0.5 * long);
  const [bx, by] = [x2 - head * ux, y2 - head * uy];
  const wing = 0.42 * head;
  return svg("g", { class: look }, svg("line", { x1, y1, x2: bx, y2: by }), svg("polygon", { points: `${x2},${y2} ${bx - wing * uy},${by + wing * ux} ${bx + wing * uy},${by - wing * ux}` }));
}

/** Lines on a turning body; those on its far side are not seen. */
function marks(item, place, scene, look, moving) {
  const { ends, cosine, sine, rate, count, face } = item;
  const lines = Array.from({ length: count }, () => svg("line", { class: look }));
  const set = (turned) => lines.forEach((one, k) => {
    const angle = turned + (2 * Math.PI * k) / count;
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const hidden = face !== null && face[0] * c + face[1] * s <= 1e-9;
    one.setAttribute("visibility", hidden ? "hidden" : "visible");
    if (hidden) return;
    for (const end of [0, 1]) {
      const [x, y] = place([ends[end][0] + cosine[end][0] * c + sine[end][0] * s, ends[end][1] + cosine[end][1] * c + sine[end][1] * s]);
      one.setAttribute(`x${end + 1}`, x.toFixed(2));
      one.setAttribute(`y${end + 1}`, y.toFixed(2));
    }
  });
  set(0);
  if (rate !== 0) moving.push({ key: `${scene} ${moving.length}`, rate, apply: set });
  return svg("g", {}, ...lines);
}
