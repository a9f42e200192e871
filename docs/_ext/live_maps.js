// The page of maps without a server: sliders, the law as WebAssembly, and the explorer's painter.
const place = byId("live-maps");
const CELLS = 140;
const MARGIN = { left: 50, right: 10, top: 6, bottom: 38 };
const colours = { text: "#1b1f24", muted: "#57606a", line: "#8c959f", surface: "#ffffff", required: "#D55E00" };
const values = Object.fromEntries(FACTS.sliders.map((slider) => [slider.path, slider.start]));
const { plane } = FACTS;
let law = null;

const bytes = Uint8Array.from(atob(WASM), (one) => one.charCodeAt(0));

/** Numbers of the law's memory. */
const view = (Kind, name, length) => new Kind(law.memory.buffer, law[name].value, length);

function give(drive, speed = 0, force = 0) {
  view(Float64Array, "given", 16).set([speed, force, ...FACTS.drives[drive].inputs.map((path) => values[path])]);
}

/** Results at one point: efficiency, loss [W], code of the limit, power from the supply and to the load [W]. */
function at(drive, speed, force) {
  give(drive, speed, force);
  law.point(drive);
  return [...view(Float64Array, "found", 5)];
}

/** Where the share of cells within limits around each passes a half, the painter draws the limit: the law gives limits, no margins. */
function marginOf(limit) {
  const inside = (i, j) => limit[Math.min(Math.max(i, 0), CELLS - 1) * CELLS + Math.min(Math.max(j, 0), CELLS - 1)] === 0;
  const near = [-1, 0, 1].flatMap((down) => [-1, 0, 1].map((right) => [down, right]));
  return Float32Array.from(limit, (_, at) => (2 / 9) * near.filter(([down, right]) => inside(Math.floor(at / CELLS) + down, (at % CELLS) + right)).length);
}

/** A map in the form that the painter expects. */
function mapOf(drive) {
  give(drive);
  view(Float64Array, "plane", 4).set([...plane.speed, ...plane.force]);
  law.map(drive, CELLS);
  const size = CELLS * CELLS;
  const codes = view(Uint8Array, "limit", size);
  const present = [0, ...new Set(codes.filter((code) => code !== 0))];
  const loss = view(Float32Array, "loss", size).slice();
  const names = present.map((code) => FACTS.limits[code]);
  const limit = codes.map((code) => present.indexOf(code));
  const largest = loss.reduce((most, one) => (one > most ? one : most), 0);
  return {
    count: CELLS, efficiency: view(Float32Array, "efficiency", size).slice(), loss: largest > 0 ? loss : undefined, limit, margin: marginOf(limit),
    header: { limit_names: names.map(([name]) => name), limits: names.map(([, words]) => words), labels: [], largest_loss: largest / 1.5 },
    share: limit.reduce((count, code) => count + (code === 0), 0) / size,
  };
}

function figure(drive) {
  const canvas = make("canvas", { role: "img" });
  const note = make("p", { className: "live-note" });
  const title = FACTS.drives[drive].title;
  const paint = (map, lossReach) => {
    const width = Math.max(240, Math.min(460, canvas.parentElement.clientWidth));
    const height = Math.round(0.85 * width);
    const scale = devicePixelRatio || 1;
    Object.assign(canvas, { width: width * scale, height: height * scale });
    Object.assign(canvas.style, { width: `${width}px`, height: `${height}px` });
    const context = canvas.getContext("2d");
    context.scale(scale, scale);
    const box = { left: MARGIN.left, top: MARGIN.top, width: width - MARGIN.left - MARGIN.right, height: height - MARGIN.top - MARGIN.bottom };
    paintCells(context, box, map, { dark: false, surface: colours.surface, lossReach });
    paintEdges(context, box, map, colours.line, colours.muted);
    paintContours(context, box, map);
    if (FACTS.requirement) paintRequired(context, box, plane, FACTS.requirement, colours.required);
    paintAxes(context, box, plane, colours);
    const limits = map.header.limit_names.map((name, index) => (index === 0 ? null : make("span", {}, swatch(name), map.header.limits[index])));
    note.replaceChildren(`Within limits: ${Math.round(100 * map.share)} % of the map. Beyond: `, ...limits.filter(Boolean));
    canvas.setAttribute("aria-label", `${title}: ${note.textContent}`);
  };
  return { paint, element: make("figure", {}, make("figcaption", {}, title), canvas, note) };
}

function swatch(name) {
  const one = make("i");
  one.style.background = tint(name, false);
  return one;
}

function slider({ path, title, unit, low, high, start }) {
  const shown = make("b", {}, said(start, unit));
  const input = make("input", { type: "range", min: low, max: high, step: "any", value: start, name: path, on: { input: () => {
    values[path] = Number(input.value);
    shown.textContent = said(values[path], unit);
    draw();
  } } });
  return make("label", {}, make("span", {}, title, shown), input);
}

const said = (value, unit) => `${digits(value, 3)}${unit === "1" ? "" : ` ${unit}`}`;

const figures = FACTS.drives.map((_, drive) => figure(drive));
let waiting = 0;

function draw() {
  cancelAnimationFrame(waiting);
  waiting = requestAnimationFrame(() => {
    const begun = performance.now();
    const maps = figures.map((_, drive) => mapOf(drive));
    const reach = lossReachOf(maps);
    maps.forEach((map, drive) => figures[drive].paint(map, reach));
    place.dataset.milliseconds = String(performance.now() - begun);
    place.dataset.painted = String(Number(place.dataset.painted ?? 0) + 1);
  });
}

if (place) {
  WebAssembly.instantiate(bytes, {}).then(({ instance }) => {
    law = instance.exports;
    place.replaceChildren(
      make("div", { className: "live-sliders" }, ...FACTS.sliders.map(slider)),
      make("div", { className: "live-figures" }, ...figures.map((one) => one.element)),
    );
    draw();
    new ResizeObserver(draw).observe(place);
    place.at = at;
    place.values = values;
  });
}
