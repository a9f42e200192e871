// A tour of two minutes: what each part of the page is for, one after another.
import { make } from "./dom.js";

const STUDY = { at: "#study-title", title: "A study", text: "A study holds drive-trains or machines, and what is required of them. Choose another one at the top, or open your own file." };
const ANSWER = { at: "#glance:not([hidden])", title: "The answer", text: "Which one wins with what is stated, by how much, and which open choices would turn that. One row each: the figure that decides, the tightest limit with its margin, and the mass. Choose a row to look into it." };
const CHANGE = { at: "#fields .field:has(input[type=range])", title: "Change a value" };
const KEEP = { at: "#save", title: "Keep it", text: "Save the study as a file for the command line, or copy a link that holds it whole. Press F1 for help and for this tour." };

const OF_DRIVES = [
  STUDY,
  ANSWER,
  { at: "#strip", title: "Maps", text: "Each map shows the efficiency of a drive at every force and speed of the load. Tinted regions are beyond a limit, named on the map. The dashed line is what is required. Move over a map to read it, click to stay at a point." },
  { ...CHANGE, text: "Move a slider or type a value in any unit, such as 550 N, and all maps follow. Try it now. The dot tells where the value comes from." },
  { at: "#owners", title: "Drives", text: "Choose what to edit here, and tick the drives whose maps you want to see side by side." },
  { at: "#pin", title: "Before and after", text: "Pin the present state, change something, and see both states side by side or as a difference. Undo takes back any step." },
  { at: "#tabs", title: "Look deeper", text: "At the point you chose: where the power goes, how the wheel creeps in its contact, what a motion costs, and the machine itself." },
  KEEP,
];

/** Machines have tasks and sessions in place of maps. */
const OF_MACHINES = [
  STUDY,
  ANSWER,
  { at: "#strip", title: "What the machine does", text: "Each task with its power and its tightest limit, one column a machine; choose a cell to see the machine in that task. A study of sessions lists them here: a user moves the machine and a controller guides it." },
  { ...CHANGE, text: "Move a slider or type a value in any unit, such as 550 N, and what is shown follows. Try it now. The dot tells where the value comes from." },
  { at: "#owners", title: "What to edit", text: "Choose here what to edit: a machine, a task, or a session. Undo takes back any step." },
  { at: "#tabs", title: "Look deeper", text: "The machine drawn to scale, where its power goes, how its wheels creep in their contacts, and long computations such as sessions." },
  KEEP,
];

export function createTour() {
  const title = make("h2", { id: "tour-title" });
  const text = make("p", { id: "tour-text" });
  const count = make("span");
  const back = make("button", { type: "button" }, "Back");
  const next = make("button", { type: "button", className: "main" }, "Next");
  const end = make("button", { type: "button", className: "plain" }, "End tour");
  const box = make("div", { className: "tour", role: "dialog", hidden: true, tabIndex: -1, aria: { labelledby: "tour-title", describedby: "tour-text" } },
    title, text, make("div", { className: "actions" }, count, end, back, next));
  document.body.append(box);
  let steps = OF_DRIVES;
  let step = -1;
  let lit = null;
  let came = null;

  function show(index) {
    lit?.classList.remove("lit");
    step = index;
    const target = document.querySelector(steps[step].at) ?? document.querySelector("#study-title");
    title.textContent = steps[step].title;
    text.textContent = steps[step].text;
    count.textContent = `${step + 1} of ${steps.length}`;
    back.disabled = step === 0;
    next.textContent = step === steps.length - 1 ? "Done" : "Next";
    box.hidden = false;
    lit = target;
    lit?.classList.add("lit");
    lit?.scrollIntoView({ block: "nearest" });
    place();
    box.focus();
  }

  function place() {
    if (step < 0 || !lit) return;
    const target = lit.getBoundingClientRect();
    const own = box.getBoundingClientRect();
    const room = 14;
    const spots = [
      [target.right + room, target.top],
      [target.left, target.bottom + room],
      [target.left, target.top - own.height - room],
      [target.left - own.width - room, target.top],
    ];
    const fits = ([left, top]) => left >= 8 && top >= 8 && left + own.width <= innerWidth - 8 && top + own.height <= innerHeight - 8;
    const [left, top] = spots.find(fits) ?? [Math.min(Math.max(8, target.left), innerWidth - own.width - 8), innerHeight - own.height - 12];
    box.style.left = `${left}px`;
    box.style.top = `${top}px`;
  }

  function finish() {
    lit?.classList.remove("lit");
    lit = null;
    step = -1;
    box.hidden = true;
    (came?.isConnected ? came : document.querySelector("#help")).focus();
  }

  back.addEventListener("click", () => show(Math.max(0, step - 1)));
  next.addEventListener("click", () => (step === steps.length - 1 ? finish() : show(step + 1)));
  end.addEventListener("click", finish);
  box.addEventListener("keydown", (event) => {
    if (event.key === "Escape") finish();
    if (event.target !== box) return;
    if (event.key === "ArrowRight" || event.key === "Enter") next.click();
    if (event.key === "ArrowLeft") back.click();
  });
  addEventListener("resize", place);
  addEventListener("scroll", place, true);

  return {
    /** Start with the steps for maps of drives, or for machines. */
    start(flat) { came = document.activeElement; steps = flat ? OF_DRIVES : OF_MACHINES; show(0); },
  };
}
