// What the parts of the page share: the scene, the newest state, what is selected, and the commands' way to the server.
import { Connection } from "./connection.js";
import { History } from "./history.js";
import { FLAG } from "./protocol.js";

/** @import {SceneMessage, State} from "./protocol.js" */
/** @import {Selection} from "../view/types.js" */

/** The longest step between two states of a recording that is no jump, s at normal speed. */
const STEP = 1;
/** Time after the last jump at which the signals before it are fetched, ms: a scrubber that is dragged jumps many times. */
const SETTLED = 150;

/** Events: `scene`, `state`, `select`, `connection`, `event`, `notice`; of a recording `seek`, `recall`. */
export class Session extends EventTarget {
  constructor() {
    super();
    /** @type {SceneMessage|null} */
    this.scene = null;
    /** @type {State|null} */
    this.state = null;
    /** @type {Selection} */
    this.selection = null;
    /** @type {History} */
    this.history = new History([]);
    /** @type {"connecting"|"open"|"lost"} */
    this.link = "connecting";
    /** Whether no graphics processor draws: charts are then better drawn by the processor, too. */
    this.software = false;
    /** Variant on the second machine. @type {string|null} */
    this.compared = null;
    /** Number of the last wish for a history. */
    this.recalled = 0;
    this.settling = 0;
    this.connection = new Connection(this);
  }

  /** @param {string} name @param {unknown} [detail] */
  tell(name, detail) {
    this.dispatchEvent(new CustomEvent(name, { detail }));
  }

  /** @param {string} name @param {(detail: any) => void} call */
  on(name, call) {
    this.addEventListener(name, (e) => call(/** @type {CustomEvent} */ (e).detail));
  }

  /** @param {SceneMessage} scene */
  takeScene(scene) {
    const same = this.scene && JSON.stringify([this.scene.machine, this.scene.muscles, this.scene.shapes]) === JSON.stringify([scene.machine, scene.muscles, scene.shapes]);
    // A connection that was lost and came back goes on with what was kept; a history of its own would also take memory.
    const kept = this.scene && JSON.stringify(this.scene.layout) === JSON.stringify(scene.layout);
    this.scene = scene;
    if (!kept) this.history = new History(scene.layout);
    if (!same) this.selection = scene.muscles.length ? { kind: "muscle", index: 0 } : null;
    this.tell("scene", { same });
    this.tell("select");
    if (scene.recording) this.recall();
  }

  /** Fetches what a recording holds before now; only the newest wish counts. */
  async recall() {
    const wish = ++this.recalled, { history } = this;
    const rows = await this.connection.fetchHistory().catch(() => []);
    if (wish !== this.recalled || history !== this.history) return;
    history.prepend(rows);
    this.tell("recall");
  }

  /** Goes to a time of a recording. @param {number} time s */
  async seek(time) {
    if (await this.command("seek", { time_s: time })) this.jump();
  }

  /** The time of a recording jumped: what was kept does not join what comes. */
  jump() {
    this.recalled += 1;
    this.history.clear();
    this.tell("seek");
    clearTimeout(this.settling);
    this.settling = window.setTimeout(() => this.recall(), SETTLED);
  }

  /** @param {State} state */
  takeState(state) {
    // Any page can move the time of a recording, and an older state may come behind the answer to a command.
    const { history } = this, step = (state.time_s?.[0] ?? NaN) - history.last;
    if (this.scene?.recording && (step < 0 || step > STEP * Math.max(1, state.speed?.[0] ?? 1))) this.jump();
    this.state = state;
    history.push(state);
    this.tell("state");
  }

  /** @param {"connecting"|"open"|"lost"} link */
  takeLink(link) {
    if (link === this.link) return;
    this.link = link;
    this.tell("connection");
  }

  /** @param {Selection} selection */
  select(selection) {
    if (selection?.kind === this.selection?.kind && selection?.index === this.selection?.index) return;
    this.selection = selection;
    this.tell("select");
  }

  /** The selected muscle, or the one that is shown while none is. */
  get muscle() {
    return this.selection?.kind === "muscle" ? this.selection.index : 0;
  }

  /** Name of what is selected. */
  get selectedName() {
    const { scene, selection } = this;
    if (!scene || !selection) return "";
    return { body: scene.bodies, joint: scene.joints, muscle: scene.muscles }[selection.kind][selection.index]?.name ?? "";
  }

  /** Name of the mode of the supervisor. */
  get mode() {
    return this.scene && this.state?.mode ? this.scene.supervisor.modes[this.state.mode[0]] ?? "" : "";
  }

  /** Name of the fault that is held, if any. */
  get fault() {
    const code = this.state?.fault?.[0] ?? 0;
    if (!code) return "";
    const fault = this.scene?.supervisor.faults[code], named = fault?.of === "joint" ? this.scene?.joints : this.scene?.muscles;
    if (!fault) return `fault ${code}`;
    const name = fault.of ? named?.[this.state?.fault_index?.[0] ?? 0]?.name : undefined;
    return `${fault.kind}: ${fault.part}${name ? ` of ${name}` : ""}`;
  }

  /** @param {keyof typeof FLAG} name */
  flag(name) {
    return Boolean((this.state?.flags?.[0] ?? 0) & FLAG[name]);
  }

  /** Whether the source accepts a command. @param {string} command */
  accepts(command) {
    return this.scene?.commands.includes(command) ?? false;
  }

  /**
   * Sends a command; what the server refuses is told to the reader.
   * @param {string} command @param {Record<string, unknown>} [fields] @param {string} [said] told when it was accepted
   * @returns {Promise<boolean>}
   */
  async command(command, fields = {}, said = "") {
    const answer = await this.connection.send({ command, ...fields });
    if (!answer.ok) this.tell("notice", { text: answer.error || "The server refused the command.", bad: true });
    else if (said) this.tell("notice", { text: said });
    return answer.ok;
  }

  /** Time of the newest state, s. */
  get time() {
    return this.state?.time_s?.[0] ?? 0;
  }
}
