// The panel of commands: modes, path, compensation, time. The stop stands in the bar and is always visible.
import { button, byId, choice, element, mark, number, tell, words } from "./layout.js";

/** @import {Session} from "./session.js" */

/** Requests to the supervisor, and what they are for. @type {[string, string, string][]} */
const REQUESTS = [
  ["get_ready", "Get ready", "References the winches and gets the drives ready"], ["pretension", "Pretension", "Tightens the cables"], ["hold", "Hold", "Holds the pose"],
  ["run", "Run", "Follows the path"], ["reset", "Reset fault", "Acknowledges a fault"], ["turn_off", "Turn off", "Takes the power from the drives"],
];
const FASTER = [["10", "10 ×"], ["4", "4 ×"], ["2", "2 ×"]];
const SPEEDS = [["1", "real time"], ["0.5", "1/2"], ["0.25", "1/4"], ["0.1", "1/10"], ["0.02", "1/50"]];

/** A part of the panel. @param {string} title @param {(Node|string)[]} children */
export function part(title, children) {
  return element("fieldset", { class: "part" }, [element("legend", { text: title }), ...children]);
}

/** The stop, from wherever it was asked for. @param {Session} session */
export async function stop(session) {
  const control = byId("stop");
  control.classList.add("pressed");
  const began = performance.now();
  await session.command("mode", { request: "safe_stop" }, "Stop: the supervisor brings the machine to rest.");
  Object.assign(/** @type {any} */ (globalThis).sinew, { stopAnswerMs: performance.now() - began });
  setTimeout(() => control.classList.remove("pressed"), 400);
}

export class Commands {
  /** @param {Session} session */
  constructor(session) {
    this.session = session;
    this.box = byId("commands");
    /** @type {Map<string, HTMLButtonElement>} */
    this.requests = new Map();
    byId("stop").addEventListener("click", () => stop(session));
    session.on("state", () => this.follow());
  }

  build() {
    const { session } = this, { scene } = session;
    if (!scene) return;
    const parts = [];
    if (session.accepts("mode")) {
      const offered = REQUESTS.filter(([id]) => scene.requests?.includes(id) ?? true);
      this.requests = new Map(offered.map(([id, name, purpose]) => [id, button(name, () => session.command("mode", { request: id }), { title: purpose })]));
      if (offered.length) parts.push(part("Mode", [element("div", { class: "buttons" }, [...this.requests.values()])]));
    }
    if (session.accepts("path") && scene.paths.length) {
      const path = choice("Path", scene.paths.map((name) => [name, words(name)]), (name) => session.command("path", { name }, `Path: ${words(name)}`), scene.path_name);
      parts.push(part("Path of the end point", [path.box]));
    }
    if (session.accepts("compare") && scene.variants.length > 1) {
      const other = choice("Second machine", [["", "no second machine"], ...scene.variants.map((/** @type {string} */ v) => /** @type {[string, string]} */ ([v, v === "none" ? "without compensation" : words(v)]))], (variant) => this.compare(variant || null), session.compared ?? "");
      parts.push(part("Compare compensations", [other.box, element("p", { class: "hint", text: "A second simulated machine runs the same path with another compensation of friction." })]));
    }
    if (session.accepts("speed") || session.accepts("step")) {
      this.pause = button("Pause", () => session.command("speed", { paused: !session.flag("paused") }));
      const speeds = /** @type {[string, string][]} */ (scene.recording ? [...FASTER, ...SPEEDS] : SPEEDS);
      this.speed = choice("Speed", speeds, () => session.command("speed", { factor: this.factor() }), "1");
      const cycles = button("One cycle", () => session.command("step", { cycles: 1 })), many = button("20 cycles", () => session.command("step", { cycles: 20 }));
      parts.push(part("Time", [this.speed.box, element("div", { class: "buttons" }, [this.pause, ...(session.accepts("step") ? [cycles, many] : [])])]));
    }
    if (session.accepts("payload")) {
      const mass = number("Payload", "kg", { value: 0.5, min: 0, max: 5, step: 0.1 });
      parts.push(part("Payload", [element("div", { class: "row" }, [mass.box, button("Attach", () => session.command("payload", { mass_kg: mass.value }, `Payload: ${mass.value} kg`))])]));
    }
    if (session.accepts("push")) parts.push(this.push());
    if (session.accepts("fault")) parts.push(this.faults());
    if (scene.recording) parts.push(element("p", { class: "hint", text: "A recording is watched, not commanded." }));
    else if (!parts.length) parts.push(element("p", { class: "hint", text: session.accepts("mode") ? "A run of its own: the stop is all that this page commands." : "This source is watched, not commanded." }));
    this.box.replaceChildren(...parts);
    const stopButton = /** @type {HTMLButtonElement} */ (byId("stop"));
    stopButton.disabled = !session.accepts("mode");
    stopButton.hidden = Boolean(scene.recording);
    this.follow();
  }

  factor() {
    return Number(this.speed?.select.value ?? 1);
  }

  /** @param {string|null} variant */
  async compare(variant) {
    if (await this.session.command("compare", { variant }, variant ? `Second machine: ${words(variant)}` : "One machine")) {
      this.session.compared = variant;
      this.session.tell("select");
    }
  }

  push() {
    const { session } = this, scene = /** @type {NonNullable<typeof session.scene>} */ (session.scene);
    const moved = /** @type {[string, string][]} */ (scene.bodies.map((body, k) => [String(k), words(body.name)])).slice(1);
    const body = choice("Body", moved, (value) => session.select({ kind: "body", index: Number(value) }), String(scene.end_point?.body ?? moved.length));
    const force = number("Force", "N", { value: 20, min: 1, max: 200, step: 1 });
    const go = (/** @type {string} */ name, /** @type {number[]} */ d) => button(name, () => session.command("push", { body: Number(body.select.value), point: [0, 0, 0], force_n: d.map((v) => v * force.value), duration_s: 0.2 }, `Push of ${force.value} N for 0.2 s`), { "aria-label": `Push along ${name}` });
    return part("Push for 0.2 s", [element("div", { class: "row" }, [body.box, force.box]),
      element("div", { class: "buttons six" }, [go("+x", [1, 0, 0]), go("−x", [-1, 0, 0]), go("+y", [0, 1, 0]), go("−y", [0, -1, 0]), go("+z", [0, 0, 1]), go("−z", [0, 0, -1])])]);
  }

  faults() {
    const { session } = this, { scene } = session;
    const kind = choice("Failure", scene?.fault_kinds ?? [], () => {}), target = element("p", { class: "hint" });
    const name = () => session.scene?.muscles[session.muscle]?.name ?? "";
    const show = () => { target.textContent = `of the muscle ${words(name())}, which is selected in the view`; };
    session.on("select", show);
    show();
    return part("Let a part fail", [kind.box, target, button("Fail now", () => session.command("fault", { fault: kind.select.value.replace("{}", name()) }, `Failure of ${words(name())}: ${kind.select.selectedOptions[0].textContent}`))]);
  }

  /** Shows the mode on the buttons. */
  follow() {
    const { session } = this;
    const mode = session.mode.toLowerCase().replaceAll(" ", "_");
    for (const [id, control] of this.requests) mark(control, "aria-pressed", String(mode === id || (id === "run" || id === "hold" ? mode.startsWith(id) : mode === { turn_off: "off", get_ready: "ready" }[id])));
    if (this.pause) tell(this.pause, session.flag("paused") ? "Continue" : "Pause");
  }
}
