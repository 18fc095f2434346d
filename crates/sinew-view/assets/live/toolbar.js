// Above the view: named views, what is selected, the reference; below it the legend of the tensions.
import { VIEWS } from "../view/camera.js";
import { TENSION_GRADIENT } from "../view/palette.js";
import { button, byId, element, figure, tell, words } from "./layout.js";

/** @import {Session} from "./session.js" */
/** @import {View} from "../view/view.js" */

/** Names of the kinds, plural. */
const KINDS = /** @type {const} */ ({ muscle: "Muscles", joint: "Joints", body: "Bodies" });

export class Toolbar {
  /** @param {Session} session */
  constructor(session) {
    this.session = session;
    /** @type {View|null} */
    this.view = null;
    this.box = /** @type {HTMLElement} */ (document.querySelector(".view-tools"));
    this.select = element("select", { "aria-label": "Selected", onchange: () => {
      const [kind, index] = this.select.value.split(":");
      session.select(kind ? { kind: /** @type {keyof typeof KINDS} */ (kind), index: Number(index) } : null);
    } });
    this.ghost = button("Reference", () => this.toggleGhost(), { "aria-pressed": "true", title: "Pose of the reference, transparent" });
    this.figures = element("span", { class: "muted figures-line" });
    const views = element("span", { class: "group", role: "group", "aria-label": "Views" }, Object.keys(VIEWS).map((name) => button(name[0].toUpperCase() + name.slice(1), () => this.view?.orbit.view(name))));
    this.box.append(views, this.ghost, this.select, this.figures);
    session.on("select", () => this.follow());
  }

  toggleGhost() {
    if (!this.view) return;
    this.view.ghost = !this.view.ghost;
    this.ghost.setAttribute("aria-pressed", String(this.view.ghost));
    if (this.view.now) this.view.take(this.view.now, this.session.time);
  }

  /** Lists what can be selected. */
  build() {
    const { scene } = this.session;
    if (!scene) return;
    this.select.replaceChildren(element("option", { value: "", text: "nothing selected" }), ...Object.entries(KINDS).map(([kind, label]) => {
      const list = { muscle: scene.muscles, joint: scene.joints, body: scene.bodies }[/** @type {keyof typeof KINDS} */ (kind)];
      return element("optgroup", { label }, list.map((item, k) => (kind === "body" && k === 0 ? null : element("option", { value: `${kind}:${k}`, text: words(item.name) }))).filter((e) => e !== null));
    }));
    this.follow();
  }

  follow() {
    const { selection } = this.session;
    this.select.value = selection ? `${selection.kind}:${selection.index}` : "";
  }

  /** Legend of the map of tensions. @param {number} highest N */
  legend(highest) {
    const bar = element("span", { class: "ramp" });
    bar.style.background = TENSION_GRADIENT;
    byId("legend").hidden = !this.session.history.rings.has("tension_in_n");
    byId("legend").replaceChildren(element("span", { text: "Cable tension 0" }), bar, element("span", { text: `${figure(highest)} N` }), element("span", { class: "slides", text: this.session.scene?.tension_along === "interpolated" ? "between the ends interpolated" : "marks: sliding" }));
  }

  /** Numbers of what is selected. */
  read() {
    const { session } = this, { state, scene, selection } = session;
    if (!state || !scene) return;
    const at = (/** @type {string} */ field, /** @type {number} */ k) => state[field]?.[k] ?? NaN;
    let text = "";
    if (selection?.kind === "muscle" && Number.isFinite(at("tension_in_n", selection.index))) text = `near ${figure(at("tension_in_n", selection.index))} N${Number.isFinite(at("tension_out_estimated_n", selection.index)) ? `, far ${figure(at("tension_out_estimated_n", selection.index))} N` : ""}`;
    else if (selection?.kind === "joint") {
      const angle = scene.joints[selection.index]?.unit !== "m", value = ["joint_true", "joint_estimated", "joint_reference"].map((field) => at(field, selection.index)).find(Number.isFinite) ?? NaN;
      text = angle ? `${figure((value * 180) / Math.PI)} deg` : `${figure(1000 * value)} mm`;
    }
    tell(this.figures, text);
  }
}
