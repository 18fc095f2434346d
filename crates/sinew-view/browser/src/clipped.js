// Text that an ancestor hides, or that lies beyond the screen where nothing scrolls sideways.
const found = new Set(), screen = document.documentElement.clientWidth;
const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
for (let text; (text = texts.nextNode()); ) {
  const owner = text.parentElement;
  if (!text.data.trim() || !owner.checkVisibility({ opacityProperty: true, visibilityProperty: true })) continue;
  // Ends of long names are left out with an ellipsis; they stand in a title or elsewhere in full.
  if (owner.closest("script, style, noscript, option, .skip") || getComputedStyle(owner).textOverflow === "ellipsis") continue;
  const range = document.createRange();
  range.selectNodeContents(text);
  for (const r of range.getClientRects()) {
    for (let e = owner; e !== document.documentElement; e = e.parentElement) {
      const style = getComputedStyle(e), b = e.getBoundingClientRect(), hides = (overflow) => /hidden|clip/.test(overflow);
      const beside = Math.max(r.right - b.right, b.left - r.left), beyond = Math.max(r.bottom - b.bottom, b.top - r.top);
      if ((hides(style.overflowX) && beside > 1.5) || (hides(style.overflowY) && beyond > 3)) found.add(`${owner.tagName}: ${text.data.trim().slice(0, 50)}`);
      if (/auto|scroll/.test(style.overflowX) || style.position === "fixed") break;
      if (e === document.body && (r.right > screen + 1.5 || r.left < -1.5)) found.add(`beyond the screen: ${text.data.trim().slice(0, 50)}`);
    }
  }
}
return [...found];
