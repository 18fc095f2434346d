// A recording: play, scrub, events on the scrubber, and a second recording laid over the first.
import { button, byId, element, figure, tell } from "./layout.js";

/** @import {Session} from "./session.js" */

/** Between two seeks while the scrubber is held, ms. */
const EVERY = 60;

export class Replay {
  /** @param {Session} session */
  constructor(session) {
    this.session = session;
    this.box = byId("replay");
    this.sent = 0;
    this.held = false;
    /** Whether it was played once. */
    this.played = false;
    this.slider = element("input", { type: "range", min: 0, step: 0.001, "aria-label": "Time of the recording, s" });
    this.clock = element("output");
    this.play = button("Pause", () => this.toggle());
    this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
    this.slider.addEventListener("pointerdown", () => { this.held = true; });
    for (const name of ["pointerup", "pointercancel", "change"]) this.slider.addEventListener(name, () => { this.held = false; this.seek(Number(this.slider.value), true); });
    session.on("scene", () => this.build());
    session.on("state", () => this.follow());
  }

  build() {
    const { session } = this, recording = session.scene?.recording;
    this.box.hidden = !recording;
    if (!session.scene || !recording) return;
    this.slider.max = String(recording.duration_s);
    const { events } = session.scene;
    const marks = element("div", { class: "marks", "aria-hidden": "true" }, events.map((event) => {
      const mark = element("i", { class: event.kind, title: `${figure(event.time_s, 4)} s: ${event.text}` });
      mark.style.left = `${(100 * event.time_s) / recording.duration_s}%`;
      return mark;
    }));
    const list = element("select", { "aria-label": "Go to an event", onchange: () => { if (list.value) this.seek(Number(list.value), true); list.value = ""; } },
      [element("option", { value: "", text: events.length ? `${events.length} events` : "no events" }), ...events.map((event) => element("option", { value: event.time_s, text: `${figure(event.time_s, 4)} s  ${event.text}` }))]);
    list.disabled = !events.length;
    const { overlays = [], compare } = session.scene;
    const over = session.accepts("overlay") && overlays.length
      ? [element("select", { "aria-label": "Lay another recording over this one", onchange: (/** @type {Event} */ e) => session.command("overlay", { name: /** @type {HTMLSelectElement} */ (e.target).value || null }) },
        [element("option", { value: "", text: "no overlay" }), ...overlays.map((name) => element("option", { value: name, text: `over it: ${name}`, selected: name === compare }))])] : [];
    this.box.replaceChildren(this.play, element("div", { class: "scrubber" }, [this.slider, marks]), this.clock, list, ...over);
  }

  /** @param {number} time s @param {boolean} [now] */
  seek(time, now = false) {
    const clock = performance.now();
    if (!now && clock - this.sent < EVERY) return;
    this.sent = clock;
    this.session.seek(time);
  }

  toggle() {
    const { session } = this;
    session.command("speed", { paused: !session.flag("paused") });
  }

  /** To the event before or after now. @param {number} direction */
  event(direction) {
    const times = (this.session.scene?.events ?? []).map((event) => event.time_s).sort((a, b) => a - b), now = this.session.time;
    const next = direction > 0 ? times.find((t) => t > now + 1e-3) : times.reverse().find((t) => t < now - 1e-3);
    if (next !== undefined) this.seek(next, true);
  }

  follow() {
    const { session } = this, recording = session.scene?.recording;
    if (!recording) return;
    // It plays once somebody looks.
    if (!this.played && session.time === 0 && session.flag("paused")) this.toggle();
    this.played = true;
    if (!this.held) this.slider.value = String(session.time);
    tell(this.clock, `${session.time.toFixed(2)} / ${recording.duration_s.toFixed(2)} s`);
    tell(this.play, session.flag("paused") ? "Play" : "Pause");
  }
}
