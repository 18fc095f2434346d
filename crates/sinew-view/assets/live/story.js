// Five short steps that show what friction in the sheaths does. Each is a state of the page with a link, `#story=2`.
import { button, byId, element } from "./layout.js";

/** @import {Session} from "./session.js" */
/** @import {Commands} from "./commands.js" */
/** @import {View} from "../view/view.js" */

/**
 * @typedef {{session: Session, commands: Commands, view: View|null}} Page
 * @typedef {{title: string, text: string, show: (page: Page) => Promise<void>}} Step
 */

/** The muscle whose sheath bends most. @param {Session} session */
function bent(session) {
  const bends = (session.scene?.muscles ?? []).map((muscle) => muscle.sheath?.bend_rad ?? 0);
  return bends.indexOf(Math.max(...bends));
}

/** Runs the machine at a speed. @param {Page} page @param {number} factor @param {string|null} variant */
async function run({ session, commands }, factor, variant) {
  if (commands.speed) commands.speed.select.value = String(factor);
  if (session.accepts("speed")) await session.command("speed", { factor, paused: false });
  if (session.accepts("compare") && variant !== session.compared && (variant === null || session.scene?.variants.includes(variant))) await commands.compare(variant);
  if (session.accepts("mode")) await started(session);
}

/** The request that leads one mode further towards a run. @type {Record<string, string>} */
const TOWARDS = { off: "get_ready", ready: "pretension", pretension: "hold", hold: "run" };
/** Looks at the mode until it runs: every so many ms, so often. */
const LOOK = 300;
const LOOKS = 40;

/** Leads a machine that is at rest from mode to mode until it runs; one that was stopped is left to the reader. @param {Session} session */
async function started(session) {
  let asked = "";
  for (let k = 0; k < LOOKS && !/^run/.test(session.mode); k += 1) {
    const request = TOWARDS[session.mode];
    if (!request) { await session.command("mode", { request: "run" }); return; }
    if (request !== asked && (await session.connection.send({ command: "mode", request })).ok) asked = request;
    await new Promise((resolve) => setTimeout(resolve, LOOK));
  }
}

/** Selects the cable whose sheath bends most, and looks at it. @param {Page} page */
function focus({ session, view }) {
  session.select({ kind: "muscle", index: bent(session) });
  view?.look(session.selection);
}

/** @type {Step[]} */
const STEPS = [
  { title: "Motors pull cables through sheaths",
    text: "The motors stand beside the machine. Each pulls a cable through a curved sheath, and the cables move the joints. The end point follows the thin line.",
    show: async (page) => { await run(page, 1, null); page.session.select(null); page.view?.look(null); } },
  { title: "Tension is lost on the way",
    text: "The cable presses on its sheath and rubs. The colour shows the tension along the cable: it changes between the motor, the near end, and the joint, the far end.",
    show: async (page) => { await run(page, 1, null); focus(page); } },
  { title: "At a reversal the cable sticks",
    text: "When the motor reverses, the cable first sticks. A slip front runs through the sheath; until it arrives, the far tension does not change. Marks show where the cable slides. Slow motion: a tenth of real time.",
    show: async (page) => { await run(page, 0.1, null); focus(page); } },
  { title: "Near tension does not tell far tension",
    text: "Far over near tension draws a loop with the width of the friction. The estimate of the far tension follows the loop, and the controller acts on it.",
    show: async (page) => { await run(page, 0.25, null); focus(page); } },
  { title: "With and without compensation",
    text: "The second machine runs the same path without a compensation of friction. Compare the two trails and the end-point errors, then take hold of the end point yourself.",
    show: async (page) => { await run(page, 1, "none"); page.session.select(null); page.view?.look(null); } },
];
const SEEN = "sinew-story";

export class Story {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    this.box = byId("story");
    this.at = -1;
    addEventListener("hashchange", () => this.fromLink());
  }

  /** The step of the page's address, or the first on a first visit. */
  start() {
    const { session } = this.page;
    // Only a machine that the page commands starts by itself.
    if (!session.scene?.simulated || !session.accepts("path")) return;
    if (this.fromLink()) return;
    let seen = true;
    try { seen = localStorage.getItem(SEEN) !== null; } catch { /* A private window: no first visit is known. */ }
    if (!seen) this.go(0, false);
  }

  fromLink() {
    const step = Number(new URLSearchParams(location.hash.slice(1)).get("story"));
    if (!(step >= 1 && step <= STEPS.length)) return false;
    if (step - 1 !== this.at) this.go(step - 1, false);
    return true;
  }

  /** @param {number} step @param {boolean} [link] whether the address follows */
  async go(step, link = true) {
    this.at = step;
    try { localStorage.setItem(SEEN, "seen"); } catch { /* It is shown again next time. */ }
    if (link) {
      const words = new URLSearchParams(location.hash.slice(1));
      words.set("story", String(step + 1));
      history.replaceState(null, "", `#${words}`);
    }
    this.draw();
    await STEPS[step].show(this.page);
  }

  close() {
    this.at = -1;
    const words = new URLSearchParams(location.hash.slice(1));
    words.delete("story");
    history.replaceState(null, "", words.size ? `#${words}` : location.pathname);
    this.draw();
    this.page.view?.stage.canvas.focus();
  }

  draw() {
    const step = STEPS[this.at];
    this.box.hidden = !step;
    if (!step) return;
    const dots = element("ol", { class: "dots", "aria-label": "Steps" }, STEPS.map((other, k) => element("li", {}, [button(String(k + 1), () => this.go(k), { "aria-current": k === this.at ? "step" : false, "aria-label": `Step ${k + 1}: ${other.title}` })])));
    const last = this.at === STEPS.length - 1;
    this.box.setAttribute("role", "region");
    this.box.setAttribute("aria-label", "A short introduction");
    this.box.replaceChildren(element("div", { class: "story-text" }, [element("h2", { text: step.title }), element("p", { text: step.text })]),
      element("div", { class: "story-foot" }, [dots, button("Close", () => this.close(), { class: "quiet" }), button(last ? "Done" : "Next", () => (last ? this.close() : this.go(this.at + 1)), { class: "primary" })]));
  }
}
