// Small helpers for elements, numbers, the theme and files.

/**
 * An element with its properties and children.
 * @template {keyof HTMLElementTagNameMap} T
 * @param {T} tag @param {Record<string, any>} [properties] `class`, `text`, `on…` and attributes @param {(Node|string)[]} [children]
 * @returns {HTMLElementTagNameMap[T]}
 */
export function element(tag, properties = {}, children = []) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === null || value === false) continue;
    if (name === "class") made.className = value;
    else if (name === "text") made.textContent = value;
    else if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else made.setAttribute(name, value === true ? "" : String(value));
  }
  made.append(...children);
  return made;
}

/** Sets a text that has changed; another would be laid out and painted again. @param {Element} place @param {string} text */
export function tell(place, text) {
  if (place.textContent !== text) place.textContent = text;
}

/** The same of an attribute. @param {Element} place @param {string} name @param {string} value */
export function mark(place, name, value) {
  if (place.getAttribute(name) !== value) place.setAttribute(name, value);
}

/** An element of the page by its id. @param {string} id @returns {HTMLElement} */
export function byId(id) {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no element ${id}`);
  return found;
}

/** @param {string} text @param {() => void} act @param {Record<string, any>} [properties] */
export function button(text, act, properties = {}) {
  return element("button", { type: "button", onclick: act, ...properties, text });
}

/** A labelled choice. @param {string} label @param {[string, string][]} options value and name @param {(value: string) => void} act @param {string} [value] */
export function choice(label, options, act, value) {
  const select = element("select", { onchange: () => act(select.value) }, options.map(([id, name]) => element("option", { value: id, text: name, selected: id === value })));
  return { box: element("label", { class: "field" }, [element("span", { text: label }), select]), select };
}

/** A labelled number. @param {string} label @param {string} unit @param {{value: number, min: number, max: number, step: number}} range */
export function number(label, unit, range) {
  const input = element("input", { type: "number", ...range });
  return { box: element("label", { class: "field" }, [element("span", { text: `${label}, ${unit}` }), input]), input, get value() { return Number(input.value); } };
}

/** A name of code in the words of a reader. @param {string} name */
export function words(name) {
  return name.replaceAll("_", " ");
}

/** A number with some digits that count; a dash for what is not known. @param {number} x @param {number} [digits] */
export function figure(x, digits = 3) {
  if (!Number.isFinite(x)) return "–";
  const text = Math.abs(x) >= 10 ** digits ? x.toFixed(0) : Number(x.toPrecision(digits)).toString();
  return text.replace("-", "\u2212");
}

/** Saves a file. @param {string} name @param {Blob} content */
export function save(name, content) {
  const link = element("a", { href: URL.createObjectURL(content), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

const THEMES = ["auto", "light", "dark"];
const NAMES = { auto: "◐ Auto", light: "○ Light", dark: "● Dark" };

/** Theme: the system's until the reader chooses one. @param {HTMLElement} control @param {() => void} changed */
export function themes(control, changed) {
  const kept = () => { try { return localStorage.getItem("sinew-theme"); } catch { return null; } };
  let theme = THEMES.includes(kept() ?? "") ? /** @type {string} */ (kept()) : "auto";
  const show = () => {
    if (theme === "auto") document.documentElement.removeAttribute("data-theme");
    else document.documentElement.dataset.theme = theme;
    control.textContent = NAMES[/** @type {keyof typeof NAMES} */ (theme)];
    control.setAttribute("aria-label", `Theme: ${theme}. Change`);
    changed();
  };
  control.addEventListener("click", () => {
    theme = THEMES[(THEMES.indexOf(theme) + 1) % THEMES.length];
    try { localStorage.setItem("sinew-theme", theme); } catch { /* A private window keeps it for this page. */ }
    show();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
  show();
}
