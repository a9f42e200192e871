// The first requests of the page, sent while the rest of it still loads.
import { remembered } from "./theme.js";
import { createTransport } from "./transport.js";

const theme = remembered("theme");
const dark = theme === "dark" || (theme !== "light" && matchMedia("(prefers-color-scheme: dark)").matches);
document.documentElement.dataset.theme = dark ? "dark" : "light";

export const transport = createTransport();

/** Cells along each axis of the maps at first. */
export const COUNT = 200;

/** Drives to begin with, as the program chooses them for its own study. */
export const firstShown = (names) => (names.length > 1 ? (innerWidth <= 560 ? [names[0]] : [names[0], names.at(-1)]) : names);

/** What was edited in this window before it was loaded again: {now, opened, valid}, or null. */
export const resumed = performance.getEntriesByType("navigation")[0]?.type === "reload" ? kept() : null;

/** Whether the page begins with the study of the program. */
const own = !location.hash && !resumed;

/** What the page begins with, and the first maps of that study. */
export const started = transport.call("start", own ? { count: COUNT, most: innerWidth <= 560 ? 1 : 2 } : {});

function kept() {
  try {
    const found = JSON.parse(sessionStorage.getItem("infinivar.study"));
    return found?.now?.tables && found.opened?.tables ? found : null;
  } catch { return null; }
}

/** Keep what is edited, in case this window is loaded again. */
export function keep(now, opened, valid) {
  try { sessionStorage.setItem("infinivar.study", JSON.stringify({ now, opened, valid })); } catch { /* storage may be full or forbidden */ }
}

/** What is known of that study, once it is: {tables, shown, reply}; null if the page begins with another one. */
function early(ask) {
  if (!own) return null;
  const opening = started.then(async ({ header, arrays }) => ({ tables: header.study.tables, ...(await ask(header, arrays)) }));
  opening.catch(() => {});  // reported by the caller
  return opening;
}

export const firstMaps = early(({ maps }, arrays) => (maps === undefined ? { shown: [] } : { shown: Object.keys(maps.drives), reply: { header: maps, arrays } }));
export const firstStudy = early(async ({ study }) => ({ reply: await transport.call("study", { name: study.name, tables: study.tables }) }));
