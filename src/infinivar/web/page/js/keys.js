// Keys for what the buttons do. All have a modifier or are function keys, so that typing never triggers them.

export const KEYS = [
  ["Ctrl+Z", "undo"],
  ["Ctrl+Shift+Z", "redo"],
  ["Ctrl+S", "save as a study file"],
  ["Ctrl+O", "open a study file"],
  ["Alt+B", "pin this state as “before”, or release it"],
  ["Alt+L", "copy a link that holds the study"],
  ["Alt+M", "go to the maps"],
  ["Alt+V", "go to the views"],
  ["Alt+F", "find a value"],
  ["F1", "this help"],
  ["arrows", "on a map: move the point; with Shift faster; Home resets it"],
  ["arrows", "on a slider: change the value; on tabs: change the view"],
];

const MAC = /mac/i.test(navigator.platform);

/** Whether Alt makes letters here: in a text box of a Mac. */
const writes = (event) => MAC && event.target instanceof HTMLInputElement && event.target.type !== "range";

const OF_STUDY = new Set(["undo", "redo", "save", "open", "pin", "link"]);

/** Take over what is typed in a field, as leaving it does. */
function confirm(field) {
  if (!(field instanceof HTMLInputElement)) return;
  field.blur();
  field.focus();
}

/** Call the action of each key: {undo, redo, save, open, pin, link, maps, views, find, help}. */
export function createKeys(actions) {
  document.addEventListener("keydown", (event) => {
    const command = event.ctrlKey || event.metaKey;
    const key = event.key.toLowerCase();
    let action = null;
    if (command && !event.altKey) {
      if (key === "z") action = event.shiftKey ? "redo" : "undo";
      else if (key === "y") action = "redo";
      else if (key === "s") action = "save";
      else if (key === "o") action = "open";
    } else if (event.altKey && !command && !event.shiftKey && !writes(event)) action = { KeyB: "pin", KeyL: "link", KeyM: "maps", KeyV: "views", KeyF: "find" }[event.code] ?? null;
    else if (event.key === "F1") action = "help";
    if (action === null || document.querySelector("dialog[open]")) return;
    event.preventDefault();
    if (OF_STUDY.has(action)) confirm(document.activeElement);
    actions[action]();
  });
}
