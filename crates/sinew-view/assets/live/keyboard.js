// Keys that act from everywhere, and the dialog that lists them. The space bar stops, whatever has the focus but text fields.
import { button, byId, element } from "./layout.js";
import { stop } from "./commands.js";

/** @import {Session} from "./session.js" */
/** @import {Grasp} from "./grasp.js" */
/** @import {Replay} from "./replay.js" */
/** @import {Traces} from "./traces.js" */
/** @import {View} from "../view/view.js" */

/** @type {[string, string][]} */
const KEYS = [
  ["Space", "stop the machine"], ["r", "run along the path"], ["h", "hold the pose"], ["p", "pause or continue the time"], [".", "one cycle"],
  ["m / Shift m", "next or previous muscle"], ["j / Shift j", "next or previous joint"], ["b / Shift b", "next or previous body"], ["Escape", "select nothing"],
  ["w a s d q e", "move the end point, Enter releases it (view focused)"], ["arrows, + −", "turn and zoom (view focused)"], ["1 2 3 4", "front, side, top, free view (view focused)"],
  ["f", "look at what is selected, or at everything"], ["g", "show or hide the reference"], ["t", "pause the traces"], ["[ ]", "previous or next event of a recording"], ["?", "this list"],
];

/** @param {{session: Session, grasp: () => Grasp|null, replay: Replay, traces: Traces, view: () => View|null, ghost: () => void}} page */
export function keyboard({ session, grasp, replay, traces, view, ghost }) {
  const dialog = /** @type {HTMLDialogElement} */ (byId("keys"));
  dialog.append(element("h2", { id: "keys-title", text: "Keys" }), element("dl", {}, KEYS.flatMap(([key, act]) => [element("dt", {}, key.split(" / ").map((k) => element("kbd", { text: k }))), element("dd", { text: act })])),
    button("Close", () => dialog.close(), { class: "primary" }));
  byId("help").addEventListener("click", () => dialog.showModal());
  const next = (/** @type {"muscle"|"joint"|"body"} */ kind, /** @type {boolean} */ back) => {
    const { scene, selection } = session, list = { muscle: scene?.muscles, joint: scene?.joints, body: scene?.bodies }[kind];
    // The world is no body to select.
    const first = kind === "body" ? 1 : 0, count = (list?.length ?? 0) - first;
    if (count < 1) return;
    const at = selection?.kind === kind ? selection.index - first : back ? 0 : -1;
    session.select({ kind, index: first + ((at + (back ? -1 : 1) + count) % count) });
  };
  const time = () => session.accepts("speed") && session.command("speed", { paused: !session.flag("paused") });
  addEventListener("keydown", (e) => {
    if (e.ctrlKey || e.metaKey || e.altKey) return;
    const target = /** @type {HTMLElement} */ (e.target), types = target.matches("input:not([type=range]), textarea");
    if (e.key === " " && !types) {
      // Not the button or the list that has the focus: the stop comes first.
      e.preventDefault();
      if (!e.repeat && session.accepts("mode")) stop(session);
      else if (!e.repeat && session.scene?.recording) replay.toggle();
      return;
    }
    if (types || target.matches("select") || dialog.open) return;
    if (target === view()?.stage.canvas) {
      if (grasp()?.key(e.key)) { e.preventDefault(); return; }
      if (e.key === "Enter") { grasp()?.end(); return; }
    }
    /** @type {Record<string, () => unknown>} */
    const acts = {
      r: () => session.accepts("mode") && session.command("mode", { request: "run" }), h: () => session.accepts("mode") && session.command("mode", { request: "hold" }),
      p: time, ".": () => session.accepts("step") && session.command("step", { cycles: 1 }),
      m: () => next("muscle", false), M: () => next("muscle", true), j: () => next("joint", false), J: () => next("joint", true), b: () => next("body", false), B: () => next("body", true),
      Escape: () => session.select(null), f: () => view()?.look(session.selection), g: ghost, t: () => traces.pause(), "[": () => replay.event(-1), "]": () => replay.event(1), "?": () => dialog.showModal(),
    };
    if (acts[e.key]) { e.preventDefault(); acts[e.key](); }
  });
  // A button acts on the release of the space bar: not here.
  addEventListener("keyup", (e) => { if (e.key === " " && /** @type {HTMLElement} */ (e.target).matches("button, select, summary, [type=range]")) e.preventDefault(); });
}
