"use strict";
(() => {
  const root = document.documentElement;
  const byId = (id) => document.getElementById(id);

  // Theme: the system's until the reader chooses one.
  const themes = ["auto", "light", "dark"];
  const store = {
    get: () => { try { return localStorage.getItem("sinew-theme") || "auto"; } catch { return "auto"; } },
    set: (v) => { try { localStorage.setItem("sinew-theme", v); } catch { /* private window: keep it for this page */ } },
  };
  let theme = themes.includes(store.get()) ? store.get() : "auto";
  const button = byId("theme");
  const show = () => {
    if (theme === "auto") root.removeAttribute("data-theme");
    else root.dataset.theme = theme;
    button.textContent = { auto: "◐ Auto", light: "○ Light", dark: "● Dark" }[theme];
    button.setAttribute("aria-label", `Theme: ${theme}. Change`);
    dispatchEvent(new Event("theme"));
  };
  button.addEventListener("click", () => {
    theme = themes[(themes.indexOf(theme) + 1) % themes.length];
    store.set(theme);
    show();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => dispatchEvent(new Event("theme")));
  document.querySelectorAll(".needs-script").forEach((e) => { e.hidden = false; });
  show();

  // Terms of the glossary are explained where they first stand in a section.
  const terms = new Map([...document.querySelectorAll("#glossary dt")].map((term) => [term.textContent, term.nextElementSibling.textContent]));
  const any = new RegExp(`(?<![\\p{L}-])(?:${[...terms.keys()].join("|")})(?=s?(?![\\p{L}-]))`, "iu");
  const plain = (node) => !node.parentElement.closest("a, abbr, button, code, figcaption, h1, h2, h3, option, output, script, style, summary, svg, .legend, .plot, .scene, .tag");
  document.querySelectorAll("main > section").forEach((section) => {
    const walker = document.createTreeWalker(section, NodeFilter.SHOW_TEXT), told = new Set(), texts = [];
    while (walker.nextNode()) if (plain(walker.currentNode)) texts.push(walker.currentNode);
    for (let text of texts) for (let from = 0; ;) {
      const found = any.exec(text.data.slice(from)), term = found?.[0].toLowerCase();
      if (!found) break;
      from += found.index + term.length;
      if (told.has(term)) continue;
      told.add(term);
      const word = text.splitText(from - term.length), abbr = document.createElement("abbr");
      text = word.splitText(term.length);
      abbr.title = terms.get(term);
      abbr.tabIndex = 0;
      word.replaceWith(abbr);
      abbr.append(word);
      from = 0;
    }
  });

  // Long names of code may break after an underscore, not within a word.
  document.querySelectorAll("main, .contents").forEach((part) => {
    const walker = document.createTreeWalker(part, NodeFilter.SHOW_TEXT), named = [];
    while (walker.nextNode()) {
      const text = walker.currentNode;
      if (/[\p{L}\d]_[\p{L}\d]/u.test(text.data) && !text.parentElement.closest("option, pre, script, style, svg")) named.push(text);
    }
    for (const text of named) {
      const parts = text.data.split(/(?<=[\p{L}\d]_)(?=[\p{L}\d])/u).flatMap((piece) => [document.createElement("wbr"), piece]);
      text.replaceWith(...parts.slice(1));
    }
  });

  // Contents: mark the section being read.
  const links = new Map([...document.querySelectorAll(".contents a")].map((a) => [a.hash.slice(1), a]));
  const seen = new IntersectionObserver((entries) => {
    for (const e of entries) if (e.isIntersecting) {
      links.forEach((a) => a.removeAttribute("aria-current"));
      links.get(e.target.id || "main")?.setAttribute("aria-current", "true");
    }
  }, { rootMargin: "-15% 0px -75% 0px" });
  document.querySelectorAll("main > section").forEach((s) => seen.observe(s));

  // Tables that are wider than the page scroll under their first column; the keyboard reaches them.
  const wide = document.querySelectorAll(".table, .scrolled");
  const fit = () => wide.forEach((t) => { if (t.scrollWidth > t.clientWidth + 1) t.tabIndex = 0; else t.removeAttribute("tabindex"); });
  addEventListener("resize", fit);
  document.querySelectorAll("details").forEach((d) => d.addEventListener("toggle", fit));
  fit();
})();
