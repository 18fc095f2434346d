// Puts the page together: one session, the view, the traces, the commands.
import { View } from "../view/view.js";
import { Commands } from "./commands.js";
import { Grasp } from "./grasp.js";
import { keyboard } from "./keyboard.js";
import { byId, tell, themes, words } from "./layout.js";
import { Loop } from "./loop.js";
import { Replay } from "./replay.js";
import { Session } from "./session.js";
import { Story } from "./story.js";
import { Toolbar } from "./toolbar.js";
import { Traces } from "./traces.js";

/** Sources by their name in the scene. @type {Record<string, string>} */
const SOURCES = { twin: "simulated", segment: "simulated", ethercat: "hardware", recording: "recording", kinematic: "without forces" };

/** What tests read. @type {Record<string, any>} */
const seen = { ready: false, firstFrameMs: NaN, fps: 0, scene: null, state: null, connection: "connecting", mode: "", selected: "", errors: [], stopAnswerMs: NaN };
/** @type {any} */ (globalThis).sinew = seen;
addEventListener("error", (e) => seen.errors.push(String(e.message)));
addEventListener("unhandledrejection", (e) => seen.errors.push(String(e.reason)));

const session = new Session(), traces = new Traces(session), loop = new Loop(session), commands = new Commands(session), replay = new Replay(session), toolbar = new Toolbar(session);
seen.session = session;
const canvas = /** @type {HTMLCanvasElement} */ (byId("view"));
/** @type {{session: Session, commands: Commands, view: View|null}} */
const page = { session, commands, view: null };
const story = new Story(page);
/** @type {Grasp|null} */
let grasp = null;
byId("signals").append(loop.box, traces.box);

/** Says something in the status line, or above the view where it is a refusal. @param {{text: string, bad?: boolean}} notice */
function say({ text, bad }) {
  const line = byId("status");
  line.textContent = text;
  line.classList.toggle("bad", Boolean(bad));
  line.classList.add("said");
  clearTimeout(said);
  said = setTimeout(() => line.classList.remove("said"), bad ? 6000 : 2500);
}
let said = 0;

function showScene(/** @type {{same: boolean}} */ { same }) {
  const scene = /** @type {NonNullable<typeof session.scene>} */ (session.scene);
  document.title = `${scene.machine} – Sinew`;
  byId("title").textContent = scene.machine;
  const source = byId("source");
  source.hidden = false;
  source.textContent = scene.recording ? `recording${scene.simulated ? ", simulated" : ""}` : scene.source === "kinematic" ? SOURCES.kinematic : scene.simulated ? "simulated" : SOURCES[scene.source] ?? scene.source;
  source.classList.toggle("warn", scene.simulated);
  session.compared = scene.compare ?? null;
  seen.scene = scene;
  if (scene.notice && !page.view) say({ text: scene.notice, bad: true });
  if (!page.view) {
    try {
      page.view = new View(canvas, scene, { select: (found) => session.select(found), reduced: matchMedia("(prefers-reduced-motion: reduce)").matches });
    } catch (error) {
      const notice = byId("notice");
      notice.hidden = false;
      notice.textContent = `The machine cannot be drawn: ${error instanceof Error ? error.message : error} Signals and commands work.`;
    }
    if (page.view) {
      toolbar.view = seen.view = page.view;
      session.software = page.view.stage.software;
      grasp = new Grasp(session, page.view);
      page.view.stage.first.push(() => { seen.firstFrameMs = performance.now(); seen.ready = true; });
    }
  } else if (!same) {
    // Another machine: the page begins anew.
    location.reload();
    return;
  } else page.view.path(scene.path ?? null);
  const limits = scene.muscles.map((muscle) => muscle.tension_limits_n?.[1] ?? 0).filter(Number.isFinite);
  limit = Math.max(0, ...limits) || Infinity;
  showRange(Math.min(limit, LOWEST_RANGE));
  toolbar.build();
  commands.build();
  traces.offer();
}

/** End of the colours of tension at first, N. */
const LOWEST_RANGE = 20;
/** End of the colours, and the largest tension that the machine allows, N. */
let highest = 0, limit = Infinity;

/** Colours up to a tension. @param {number} end N */
function showRange(end) {
  highest = end;
  page.view?.range(highest);
  toolbar.legend(highest);
}

/** The colours reach as far as the tensions have come: those of a light machine would all look the same below its limit. */
function widenRange() {
  const most = Math.max(0, ...Array.from(session.state?.tension_in_n ?? []).filter(Number.isFinite));
  if (most <= highest || highest >= limit) return;
  const power = 10 ** Math.floor(Math.log10(most)), round = [1, 2, 5, 10].map((m) => m * power).find((end) => end >= most) ?? most;
  showRange(Math.min(limit, round));
}

function showState() {
  const { state } = session;
  if (!state) return;
  widenRange();
  seen.state = state;
  seen.mode = session.mode;
  // A machine that is paused sends the same state again: it need not be drawn again.
  const same = session.flag("paused") && page.view?.now?.time_s?.[0] === session.time;
  if (!same) page.view?.take(state, session.time);
}

function showSelection() {
  seen.selected = session.selectedName;
  page.view?.select(session.selection);
  traces.build();
}

function showConnection() {
  const chip = byId("connection");
  seen.connection = session.link;
  chip.textContent = { connecting: "connecting", open: "connected", lost: "connection lost" }[session.link];
  chip.classList.toggle("bad-chip", session.link === "lost");
  document.body.classList.toggle("disconnected", session.link === "lost");
  byId("main").toggleAttribute("data-lost", session.link === "lost");
  if (session.link !== "open" || greeted) return;
  greeted = true;
  story.start();
}

let greeted = false;

/** Words and numbers that change slowly. */
function slow() {
  const mode = byId("mode"), fault = byId("fault"), stage = page.view?.stage;
  mode.hidden = !session.mode;
  tell(mode, words(session.mode));
  fault.hidden = !session.fault;
  tell(fault, words(session.fault));
  const speed = session.state?.speed?.[0] ?? 1, notes = [];
  if (session.flag("paused")) notes.push("paused");
  else if (speed !== 1 && Number.isFinite(speed)) notes.push(`${Number(speed.toPrecision(2))} × real time`);
  if (session.flag("behind")) notes.push("behind real time");
  if (session.flag("stale")) notes.push("source is silent");
  tell(byId("clock"), [`${session.time.toFixed(1)} s`, ...notes].join(" · "));
  seen.fps = stage?.fps ?? 0;
  seen.fraction = stage?.fraction ?? 1;
  toolbar.read();
}

/** Charts fraction what the view leaves of the processor. */
function charts() {
  requestAnimationFrame(charts);
  const now = performance.now(), every = page.view?.stage.software ? 240 : 60;
  if (now - drawn < every || !session.state) return;
  drawn = now;
  // Without a graphics processor one chart a turn, so that the machine moves smoothly.
  turn = (turn + 1) % (page.view?.stage.software ? traces.shown.length + 1 : 2);
  if (turn) traces.draw(false, page.view?.stage.software ? turn - 1 : -1);
  else if (!traces.paused) loop.draw();
}
let drawn = 0, turn = 0;

session.on("scene", showScene);
session.on("state", showState);
session.on("select", showSelection);
session.on("seek", () => { page.view?.trail.clear(); page.view?.second.clear(); });
session.on("recall", () => { page.view?.retrace(session.history); traces.draw(true); });
session.on("connection", showConnection);
session.on("notice", say);
session.on("event", (/** @type {any} */ event) => say({ text: event.text ?? "", bad: event.kind === "fault" }));
themes(byId("theme"), () => { page.view?.recolour(); loop.recolour(); traces.recolour(); });
keyboard({ session, grasp: () => grasp, replay, traces, view: () => page.view, ghost: () => toolbar.toggleGhost() });
setInterval(slow, 200);
requestAnimationFrame(charts);
showConnection();
session.connection.start();
