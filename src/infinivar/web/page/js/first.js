// The first questions of the page, asked while the rest of it still loads.
import { remembered } from "./theme.js";
import { createTransport } from "./transport.js";

const wanted = remembered("theme");
const dark = wanted === "dark" || (wanted !== "light" && matchMedia("(prefers-color-scheme: dark)").matches);
document.documentElement.dataset.theme = dark ? "dark" : "light";

export const transport = createTransport();

/** Cells along each axis of the maps at first. */
export const COUNT = 200;

/** Two drives to begin with: the first, and the last, which a study lists to compare it with; one in a narrow window. */
export const firstShown = (names) => (names.length > 1 ? (innerWidth <= 560 ? [names[0]] : [names[0], names.at(-1)]) : names);

/** What the page begins with. */
export const started = transport.call("start");

/** What was edited in this window before it was loaded again: {now, opened}, or null. */
export const resumed = performance.getEntriesByType("navigation")[0]?.type === "reload" ? kept() : null;

function kept() {
  try {
    const found = JSON.parse(sessionStorage.getItem("infinivar.study"));
    return found?.now?.tables && found.opened?.tables ? found : null;
  } catch { return null; }
}

/** Keep what is edited, in case this window is loaded again. */
export function keep(now, opened) {
  try { sessionStorage.setItem("infinivar.study", JSON.stringify({ now, opened })); } catch { /* storage may be full or forbidden */ }
}

/** A question about the study that the page begins with; null if its address holds another one. */
function early(ask) {
  if (location.hash || resumed) return null;
  const asked = started.then(async ({ header }) => {
    const { name, tables } = header.study;
    return { tables, ...(await ask({ name, tables }, firstShown(Object.keys(tables.drives ?? {})))) };
  });
  asked.catch(() => {});  // told by who waits for it
  return asked;
}

/** The maps and the description of that study: {tables, shown, reply}. */
export const firstMaps = early(async (study, shown) => ({ shown, reply: await transport.call("maps", { ...study, count: COUNT, drives: shown, known: {} }) }));
export const firstStudy = early(async (study) => ({ reply: await transport.call("study", study) }));
