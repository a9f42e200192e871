// The maps of the drives side by side: one figure a drive, with the pinned state beside it or as the difference to it.
import { byId, digits, make } from "./dom.js";
import { changed, lossReachOf, paintAxes, paintCells, paintContours, paintEdges, paintNames, paintPoint, paintRequired, paintScale, reachOf, share, tint } from "./paint.js";
import { same } from "./store.js";
import { colour } from "./theme.js";

const MARGIN = { left: 50, right: 10, top: 6, bottom: 38 };
const STEP = { fine: 1 / 100, coarse: 1 / 10 };

/** Read a map from an answer: the parts of drive `name`. */
export function mapOf(name, header, arrays) {
  const own = header.drives[name];
  return {
    header: own,
    tag: own.tag,
    count: header.count,
    plane: { speed: header.plane.speed, force: header.plane.force },
    efficiency: arrays[`${name}/efficiency`],
    limit: arrays[`${name}/limit`],
    margin: arrays[`${name}/margin`],
    loss: arrays[`${name}/loss`],
  };
}

/** Efficiency and limit of the cell at a point, or null outside the plane. */
export function cellAt(map, point) {
  const i = Math.floor(share(map.plane.force, point.force) * map.count);
  const j = Math.floor(share(map.plane.speed, point.speed) * map.count);
  if (!(i >= 0 && j >= 0 && i < map.count && j < map.count)) return null;
  const index = i * map.count + j;
  const code = map.limit[index];
  return { efficiency: map.efficiency[index], loss: map.loss?.[index], limit: code === 0 ? null : map.header.limits[code] };
}

export function createMaps({ theme, onLook, onChoose, onDrive }) {
  const strip = byId("strip");
  let plane = null;
  let cells = 1;  // along each axis
  let requirement = null;
  let figures = new Map();
  let maps = new Map();
  let before = null;
  let mode = "side";
  let chosen = null;
  let looked = null;
  let drive = null;
  let stale = false;
  let painting = 0;
  let laidFor = "";
  let afterPaint = [];

  const sizeOf = () => [strip.clientWidth, innerWidth, innerHeight, window.devicePixelRatio].join();
  const compared = () => before !== null && before.size > 0;

  function createPlot(name) {
    const base = make("canvas", { aria: { hidden: "true" } });
    const over = make("canvas", { tabIndex: 0, role: "application", data: { drive: name } });
    const holder = make("div", { className: "plot" }, base, over);
    const plot = { base, over, holder, box: null };
    const pointAt = (event) => {
      const own = over.getBoundingClientRect();
      const right = (event.clientX - own.left - plot.box.left) / plot.box.width;
      const up = 1 - (event.clientY - own.top - plot.box.top) / plot.box.height;
      const inside = right >= -0.03 && right <= 1.03 && up >= -0.05 && up <= 1.05;
      const held = (value) => Math.min(Math.max(value, 0), 1);
      const at = ([low, high], part) => low + held(part) * (high - low);
      return inside || plot.dragging ? centred({ force: at(plane.force, right), speed: at(plane.speed, up) }) : null;
    };
    over.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || plane === null) return;
      const point = pointAt(event);
      if (point === null) return;
      plot.dragging = true;
      over.setPointerCapture(event.pointerId);
      onChoose(point, name);
    });
    over.addEventListener("pointermove", (event) => {
      if (plane === null) return;
      const point = pointAt(event);
      if (plot.dragging) onChoose(point, name);
      else if (event.pointerType === "mouse") onLook(point, name);
    });
    for (const end of ["pointerup", "pointercancel"]) over.addEventListener(end, () => { plot.dragging = false; });
    over.addEventListener("pointerleave", () => { if (!plot.dragging) onLook(null, name); });
    over.addEventListener("keydown", (event) => {
      const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1], PageUp: [0, 10], PageDown: [0, -10] };
      const move = moves[event.key];
      if (plane === null || chosen === null || event.ctrlKey || event.altKey || event.metaKey) return;
      if (!move && event.key !== "Home") return;
      event.preventDefault();
      if (event.key === "Home") { onChoose(startOf(), name); return; }
      const step = event.shiftKey ? STEP.coarse : STEP.fine;
      const size = Math.max(1, Math.round(step * cells)) / cells;
      const moved = ([low, high], value, count) => value + count * size * (high - low);
      onChoose(centred({ force: moved(plane.force, chosen.force, move[0]), speed: moved(plane.speed, chosen.speed, move[1]) }), name);
    });
    over.addEventListener("focus", () => onDrive(name));
    return plot;
  }

  function createFigure({ name, title, letter }) {
    const now = createPlot(name);
    const then = createPlot(name);
    const heading = make("button", { type: "button", title: `${title}: show this drive in the views and edit it`, on: { click: () => onDrive(name, true) } }, title);
    const cover = make("span", { className: "cover" });
    const pair = [make("div", { className: "one" }, make("span", {}, "before"), then.holder), make("div", { className: "one" }, make("span", {}, "now"), now.holder)];
    const pairs = make("div", { className: "pairs" }, ...pair);
    const readout = make("p", { className: "readout" });
    const legend = make("ul", { className: "legend", aria: { label: `Limits on the map of ${title}` } });
    const figure = make("figure", { className: "map", data: { drive: name } }, make("figcaption", {}, make("span", { className: "letter" }, letter), heading, cover), pairs, readout, legend);
    /** What was painted, and how many cells each limit has there: a map that stays is not painted again. */
    const [painted, counts] = [[], null];
    return { name, title, figure, now, then, pair, cover, readout, legend, painted, counts };
  }

  /** Where to look first: well within the required region, else within the plane. */
  function startOf() {
    const end = (ends, most) => (most === undefined ? 0.26 * ends[1] : Math.min(0.45 * most, ends[1]));
    return centred({ force: end(plane.force, requirement?.force), speed: end(plane.speed, requirement?.speed) });
  }

  /** The centre of the cell that holds a point, so that what a map and a view say there is about the same point. */
  function centred(point) {
    const at = (ends, value) => {
      const cell = Math.min(Math.max(Math.floor(cells * share(ends, value) + 1e-9), 0), cells - 1);
      return ends[0] + ((cell + 0.5) * (ends[1] - ends[0])) / cells;
    };
    return { force: at(plane.force, point.force), speed: at(plane.speed, point.speed) };
  }

  function layOut(plot, width, beside) {
    const stacked = beside && innerWidth <= 560;  // both must leave room for the slider below them
    const above = figures.size > 1 && strip.closest(".beside") !== null && innerWidth >= 1200;  // one above the other
    const low = (stacked ? 0.2 : above ? 0.24 : innerWidth <= 900 ? 0.3 : 0.43) * innerHeight;
    const height = Math.round(Math.min(Math.max((beside ? 1.15 : 0.78) * width, 190), Math.max(stacked || above ? 150 : 200, low), 430));
    const ratio = window.devicePixelRatio || 1;
    plot.holder.style.height = `${height}px`;
    for (const canvas of [plot.base, plot.over]) {
      const size = [Math.round(width * ratio), Math.round(height * ratio)];
      if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
    }
    plot.ratio = ratio;
    plot.box = { left: MARGIN.left, top: MARGIN.top, width: width - MARGIN.left - MARGIN.right, height: height - MARGIN.top - MARGIN.bottom };
  }

  function cleared(canvas, plot) {
    const context = canvas.getContext("2d");
    context.setTransform(plot.ratio, 0, 0, plot.ratio, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    return context;
  }

  function paintMap(plot, map, colours, options = {}) {
    const context = cleared(plot.base, plot);
    const own = { ...plane, ...map.plane };
    const counts = paintCells(context, plot.box, map, { dark: theme.dark, surface: colours.surface, ...options });
    paintEdges(context, plot.box, map, colours.edge, colours.muted);
    if (!options.before) paintContours(context, plot.box, map);
    paintNames(context, plot.box, own, map, theme.dark, colours.outsideText);
    if (requirement !== null) paintRequired(context, plot.box, own, requirement, colours.required);
    paintAxes(context, plot.box, own, { text: colours.text, muted: colours.muted, line: colours.line });
    return counts;
  }

  const comparable = (map, old) => old !== undefined && old.count === map.count && ["speed", "force"].every((axis) => map.plane[axis].every((end, k) => Math.abs(end - old.plane[axis][k]) < 1e-9 * (1 + Math.abs(end))));

  function largestChange() {
    let most = 0;
    for (const name of figures.keys()) {
      const [map, old] = [maps.get(name), before?.get(name)];
      if (map === undefined || !comparable(map, old)) continue;
      for (let k = 0; k < map.limit.length; k += 1) {
        if (map.limit[k] !== 0 || old.limit[k] !== 0) continue;
        const size = Math.abs(map.efficiency[k] - old.efficiency[k]);
        if (size > most) most = size;
      }
    }
    return most;
  }

  /** Paint all; `frame` says that a frame is being made now, else the next one has it. */
  function paint(frame = false) {
    painting = 0;
    strip.classList.toggle("stale", stale);
    if (!figures.size) return;
    laidFor = sizeOf();
    const colours = { text: colour("text"), muted: colour("muted"), line: colour("line"), surface: colour("surface"), required: theme.dark ? "#ff8a3d" : "#D55E00", edge: theme.dark ? "#f2f4f6" : "#15181b", outsideText: colour("outside-text") };
    const difference = compared() && mode === "difference";
    const reach = difference ? reachOf(largestChange()) : 0;
    const lossReach = lossReachOf([...figures.keys()].map((name) => maps.get(name)).filter((map) => map !== undefined));
    for (const figure of figures.values()) {
      const map = maps.get(figure.name);
      const old = compared() ? before.get(figure.name) : undefined;
      const beside = old !== undefined && mode === "side";
      figure.pair[0].hidden = !beside;
      figure.pair[1].firstChild.hidden = !beside;
      if (map?.header.fault) { figure.painted = []; tellFault(figure, map); continue; }
      const width = beside ? (figure.figure.clientWidth - 8) / (innerWidth <= 560 ? 1 : 2) : figure.figure.clientWidth;
      layOut(figure.now, Math.floor(width), beside);
      if (map === undefined) { figure.painted = []; paintWaiting(figure); continue; }
      const subtract = difference && comparable(map, old);
      const painted = [map, old, mode, subtract ? reach : lossReach, theme.dark, plane, requirement, laidFor, width];
      if (painted.some((one, k) => one !== figure.painted[k])) {
        figure.painted = painted;
        figure.counts = paintMap(figure.now, map, colours, subtract ? { before: old, reach } : { lossReach });
        if (beside) { layOut(figure.then, Math.floor(width), beside); paintMap(figure.then, old, colours, { lossReach }); }
      }
      tellLimits(figure, map, figure.counts, subtract);
    }
    if (plane !== null) tellScale(difference, reach, lossReach);
    paintOver();
    if (maps.size) for (const then of afterPaint.splice(0)) if (frame) then(); else requestAnimationFrame(then);
  }

  /** A grey map of the size that it will have. */
  function paintWaiting({ now, readout }) {
    const context = cleared(now.base, now);
    context.fillStyle = colour("soft");
    context.fillRect(now.box.left, now.box.top, now.box.width, now.box.height);
    readout.textContent = "computing …";
  }

  function tellFault(figure, map) {
    figure.readout.textContent = map.header.fault;
    figure.cover.textContent = "";
    figure.legend.replaceChildren();
    if (figure.now.box) cleared(figure.now.base, figure.now);
  }

  function tellLimits(figure, map, counts, subtract) {
    const { requirement: required } = map.header;
    const total = counts.reduce((sum, one) => sum + one, 0);
    const words = required ? (required.covers ? "✓ covers the requirement" : `✗ covers ${digits(100 * required.coverage, 3)} % of the requirement`) : requirement === null ? "" : "judging …";
    const outside = required?.covers && required.fits === false;
    figure.cover.textContent = outside ? "✗ exceeds the envelope" : words;
    figure.cover.title = [required?.verdict, required?.size].filter(Boolean).join("; ");
    figure.cover.className = `cover ${required ? (required.covers && !outside ? "yes" : "no") : ""}`;
    const rows = map.header.limit_names.map((name, code) => ({ name, words: map.header.limits[code], part: counts[code] / total }));
    const items = rows.slice(1).filter((row) => row.part > 0).sort((one, other) => other.part - one.part)
      .map((row) => swatch(tint(row.name, theme.dark), `${row.words} ${Math.max(1, Math.round(100 * row.part))} %`));
    if (subtract) items.unshift(swatch(changed(theme.dark).better, "now within limits", "within"), swatch(changed(theme.dark).worse, "now beyond a limit"));
    figure.legend.replaceChildren(...items);
    const where = `${plane.force_name} to the right, ${plane.speed_name} up`;
    const beyond = items.filter((item) => item.querySelector(".swatch")).map((item) => item.textContent).join(", ");
    for (const [plot, state] of [[figure.now, ""], [figure.then, "before, "]]) {
      plot.over.setAttribute("aria-label", `Efficiency map of ${figure.title}, ${state}${where}. Beyond limits: ${beyond || "nowhere"}. Arrow keys move the point, with Shift faster, Home resets it.`);
    }
  }

  function swatch(background, text, kind = "beyond") {
    const mark = make("span", { className: `swatch ${kind}`, aria: { hidden: "true" } });
    mark.style.backgroundColor = background;
    return make("li", {}, mark, text);
  }

  let scaleShown = "";
  function tellScale(difference, reach, lossReach) {
    const over = lossReach > 0 && [...figures.keys()].some((name) => maps.get(name)?.loss?.some((value) => value > lossReach));
    const legend = `${difference}${reach}/${digits(lossReach, 2)}${over}`;
    if (scaleShown === legend) return;
    scaleShown = legend;
    const scale = (kind, label, low, high) => {
      const canvas = make("canvas", { className: kind === "loss" && over ? "over" : "", role: "img", aria: { label } });
      paintScale(canvas, kind);
      return make("span", { className: "ends" }, low, canvas, high);
    };
    const shown = [difference ? scale("change", "Colours of the change of efficiency", `−${digits(100 * reach)}`, `+${digits(100 * reach)} points`) : scale("efficiency", "Colours of the efficiency", "0", "100 %")];
    if (!difference && lossReach > 0) shown.push(scale("loss", "Colours of the loss where the load drives", "loss where the load drives 0", `${digits(lossReach, 2)} W${over ? " or more" : ""}`));
    if (requirement !== null) shown.push(make("span", { className: "required" }, "╌╌ required"));
    byId("scale").replaceChildren(...shown);
  }

  const shown = () => looked ?? chosen;

  /** Numbers of the point from the maps at hand, without asking. */
  function paintOver() {
    const point = shown();
    for (const figure of figures.values()) {
      const map = maps.get(figure.name);
      figure.figure.classList.toggle("chosen", figure.name === drive);
      if (map === undefined || map.header.fault || point === null) continue;
      for (const plot of [figure.now, figure.then]) {
        if (!plot.box || (plot === figure.then && figure.pair[0].hidden)) continue;
        paintPoint(cleared(plot.over, plot), plot.box, plane, point, looked === null);
      }
      const old = compared() ? before.get(figure.name) : undefined;
      const cell = cellAt(map, point);
      figure.readout.dataset.efficiency = String(cell?.efficiency);
      figure.readout.replaceChildren(...lookedAt(cell, old === undefined ? null : cellAt(old, point)));
    }
    if (plane === null || point === null) return;
    Object.assign(byId("where").dataset, { speed: point.speed, force: point.force });
    byId("where").textContent = `${looked === null ? "At" : "Under the cursor"}: ${placeWords(point)}. Move over a map to look, click to stay there.`;
  }

  function placeWords(point) {
    return `${digits(point.speed, 3)} ${plane.speed_unit}, ${digits(point.force, 3)} ${plane.force_unit}`;
  }

  function words(cell) {
    if (cell === null) return "outside the map";
    if (cell.limit !== null) return `beyond ${cell.limit}`;
    if (Number.isFinite(cell.efficiency)) return `${(100 * cell.efficiency).toFixed(1)} %`;
    if (Number.isFinite(cell.loss)) return `${digits(cell.loss, 3)} W lost, the load drives`;
    return "efficiency undefined";
  }

  function lookedAt(cell, old) {
    const main = make("b", { className: cell?.limit ? "beyond" : "" }, words(cell));
    if (old === null) return cell !== null && cell.limit === null && Number.isFinite(cell.efficiency) ? [main, " efficiency"] : [main];
    const parts = [main, ` · before ${words(old)}`];
    if (cell && old && !cell.limit && !old.limit && Number.isFinite(cell.efficiency - old.efficiency)) {
      const change = 100 * (cell.efficiency - old.efficiency);
      const sign = change >= 0.05 ? "+" : change <= -0.05 ? "−" : "±";
      parts.push(" · ", make("span", { className: sign === "+" ? "up" : sign === "−" ? "down" : "" }, `${sign}${Math.abs(change).toFixed(1)} points`));
    }
    return parts;
  }

  const soon = () => { if (!painting) painting = requestAnimationFrame(() => paint(true)); };
  theme.subscribe(() => { scaleShown = ""; soon(); });
  new ResizeObserver(() => { if (sizeOf() !== laidFor) soon(); }).observe(strip);
  // Where the maps stay at the top of a narrow window, what gets the focus must not end up below them.
  new ResizeObserver(([entry]) => {
    document.documentElement.style.scrollPaddingTop = innerWidth <= 900 ? `${Math.ceil(entry.target.offsetHeight) + 6}px` : "";
  }).observe(byId("maps"));

  return {
    /** Figures of these drives, {name, title} each; those that stay keep their elements and the focus. */
    setDrives(drives) {
      const kept = new Map();
      for (const one of drives) {
        const old = figures.get(one.name);
        kept.set(one.name, old !== undefined && old.title === one.title ? old : createFigure(one));
      }
      const unchanged = kept.size === figures.size && [...kept.keys()].every((name, k) => figures.get(name) === kept.get(name) && [...figures.keys()][k] === name);
      figures = kept;
      if (!unchanged) strip.replaceChildren(...[...kept.values()].map((one) => one.figure));
      soon();
    },
    /** Ends, names and units of the axes, the requirement or null, and how many cells the maps have along each axis. */
    setPlane(next, required, count) {
      if (!same([next, required], [plane, requirement])) [plane, requirement] = [next, required];
      cells = count;
      soon();
    },
    /** Grey maps of these drives until those of another study are known. */
    expect(drives) { [plane, requirement, maps, before, stale] = [null, null, new Map(), null, false]; this.setDrives(drives); },
    /** Paint these maps at once, so that they are in the next frame; `then` is called with it. */
    setMaps(next, then = () => {}) {
      maps = next;
      stale = false;
      afterPaint.push(then);
      cancelAnimationFrame(painting);
      paint();
    },
    setStale(value) { stale = value; soon(); },
    setBefore(next, how = mode) { before = next; mode = how; scaleShown = ""; soon(); },
    setPoint(point, under, name) {
      [chosen, looked, drive] = [point, under, name];
      if (figures.size && !painting && figures.values().next().value.now.box) paintOver(); else soon();
    },
    /** Say something in place of maps. */
    blank(...content) { figures = new Map(); strip.replaceChildren(make("div", { className: "blank" }, ...content)); byId("where").textContent = ""; },
    focus() { figures.values().next().value?.now.over.focus(); },
    startOf,
    centred,
    /** The numbers at the point as one sentence, for a screen reader. */
    sentence() {
      if (plane === null || shown() === null) return "";
      const parts = [...figures.values()].filter((one) => maps.get(one.name)?.limit).map((one) => `${one.title}: ${words(cellAt(maps.get(one.name), shown()))}`);
      return `At ${placeWords(shown())}: ${parts.join("; ")}.`;
    },
  };
}
