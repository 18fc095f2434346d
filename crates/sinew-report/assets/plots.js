"use strict";
// Plots: values under the cursor, zoom, and saving as SVG. The pictures stand in the page as paths, which this script reads;
// without it they are complete.
const sinew = (() => {
  const number = (v, digits) => (v === null || v === undefined || !Number.isFinite(v) ? "–" : Number(v.toPrecision(digits)).toString().replace("-", "−"));
  const unitOf = (label) => (/\(([^()]+)\)\s*$/.exec(label) || ["", ""])[1];
  const escaped = (text) => text.replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);
  // Round values within a range, at least two.
  const ticks = (low, high, count) => {
    for (let requested = count; ; requested *= 2) {
      const raw = (high - low) / requested, power = 10 ** Math.floor(Math.log10(raw));
      const step = power * [1, 2, 5, 10].find((m) => m * power >= 0.7 * raw);
      const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9)), found = [];
      for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step && found.length < 40; k++) found.push([k * step, (k * step).toFixed(Math.min(decimals, 12)).replace(/^-(0\.?0*)$/, "$1").replace("-", "−")]);
      if (found.length > 1 || requested > 64) return found;
    }
  };
  // Polylines of a path of whole units: M, then l with relative steps, h and v.
  const parse = (data) => {
    const lines = [];
    let x = 0, y = 0, line = null, command = "", numbers = [];
    const push = () => line.push([x, y]);
    for (const [token] of data.matchAll(/[A-Za-z]|-?\d+(?:\.\d+)?/g)) {
      if (/[A-Za-z]/.test(token)) {
        command = token; numbers = [];
        if (token === "z" && line) line.push(line[0]);
        continue;
      }
      numbers.push(Number(token));
      if (command === "h") { x += numbers.pop(); push(); } else if (command === "v") { y += numbers.pop(); push(); }
      else if (numbers.length === 2) {
        [x, y] = command === "M" ? numbers : [x + numbers[0], y + numbers[1]];
        if (command === "M") lines.push(line = []);
        if (command === "M" || numbers[0] || numbers[1]) push();
        numbers = [];
      }
    }
    return lines;
  };

  // Colours of a class as they are on white paper, whatever the theme.
  const onPaper = (read) => {
    const root = document.documentElement, theme = root.dataset.theme;
    root.dataset.theme = "light";
    try { return read(); } finally { if (theme) root.dataset.theme = theme; else delete root.dataset.theme; }
  };
  const pixel = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const plain = (colour) => {
    pixel.canvas.width = pixel.canvas.height = 1;
    pixel.fillStyle = colour;
    pixel.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = pixel.getImageData(0, 0, 1, 1).data;
    return [`#${[r, g, b].map((v) => v.toString(16).padStart(2, "0")).join("")}`, a / 255];
  };
  const styleOf = (path) => {
    const css = getComputedStyle(path), fill = css.fill !== "none", [stroke, strokeAlpha] = plain(css.stroke === "none" ? "transparent" : css.stroke), [area, areaAlpha] = plain(fill ? css.fill : "transparent");
    return `fill="${fill ? area : "none"}" fill-opacity="${areaAlpha.toFixed(3)}" stroke="${css.stroke === "none" ? "none" : stroke}" stroke-opacity="${(strokeAlpha * css.strokeOpacity).toFixed(3)}" stroke-width="${parseFloat(css.strokeWidth)}" stroke-linecap="${css.strokeLinecap}" stroke-linejoin="round"${css.strokeDasharray === "none" ? "" : ` stroke-dasharray="${css.strokeDasharray.replaceAll("px", "")}"`}`;
  };
  // Panels one above the other as a standalone picture: { x, y: {label, ticks: [at, text]}, box, height, shapes: [{data, style}], legend: [{style, name}] }.
  const picture = (title, panels) => {
    const width = 760, left = 76, inner = width - left - 20;
    let top = 30, body = "";
    panels.forEach((p) => {
      body += `<text x="8" y="${top - 10}">${escaped(p.y.label)}</text>`;
      body += `<svg x="${left}" y="${top}" width="${inner}" height="${p.height}" viewBox="${p.box.join(" ")}" preserveAspectRatio="none">${p.shapes.map((s) => `<path d="${s.data}" vector-effect="non-scaling-stroke" ${s.style}/>`).join("")}</svg>`;
      body += `<path d="M${left} ${top}v${p.height}h${inner}" fill="none" stroke="#59626d"/>`;
      body += p.y.ticks.map(([at, text]) => `<text x="${left - 7}" y="${(top + at * p.height + 4).toFixed(1)}" text-anchor="end">${escaped(text)}</text>`).join("");
      top += p.height + 18;
      body += p.x.ticks.map(([at, text]) => `<text x="${(left + at * inner).toFixed(1)}" y="${top}" text-anchor="middle">${escaped(text)}</text>`).join("");
      if (p.x.label) { top += 19; body += `<text x="${left + inner}" y="${top}" text-anchor="end">${escaped(p.x.label)}</text>`; }
      let x = left;
      if (p.legend.length) top += 22;
      for (const entry of p.legend) {
        const wide = 44 + 7.2 * entry.name.length;
        if (x + wide > width && x > left) { x = left; top += 19; }
        body += `<path d="M${x} ${top - 4}h28" ${entry.style}/><text x="${x + 35}" y="${top}">${escaped(entry.name)}</text>`;
        x += wide;
      }
      top += 36;
    });
    return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${width} ${top - 12}" width="${width}" height="${top - 12}" font-family="Helvetica, Arial, sans-serif" font-size="13"><title>${escaped(title)}</title><rect width="100%" height="100%" fill="#fff"/>${body}</svg>\n`;
  };
  const download = (title, text, kind) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type: kind === "csv" ? "text/csv" : "image/svg+xml" }));
    link.download = `${title.replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-|-$/g, "").slice(0, 80).toLowerCase() || "figure"}.${kind}`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };
  // Rows of texts and numbers; what is missing stays empty.
  const table = (title, rows) => download(title, rows.map((row) => `${row.map((v) => (typeof v === "string" ? `"${v.replaceAll('"', '""')}"` : v ?? "")).join(",")}\n`).join(""), "csv");
  const save = (title, panels) => download(title, picture(title, panels), "svg");
  const button = (text, label, action) => {
    const b = document.createElement("button");
    b.type = "button"; b.textContent = text; b.title = label;
    b.setAttribute("aria-label", label);
    b.addEventListener("click", action);
    return b;
  };

  const all = [];
  const enhance = (plot) => {
    const area = plot.querySelector(".area"), svg = area.querySelector("svg"), grid = svg.querySelector("path.grid");
    const [x0, x1, y0, y1] = plot.dataset.ends.split(" ").map(Number), [, , W, H] = svg.getAttribute("viewBox").split(" ").map(Number);
    const named = plot.classList.contains("named"), overTime = plot.classList.contains("trace");
    const names = [...plot.querySelectorAll(".x-ticks span")].map((s) => s.textContent);
    const title = plot.getAttribute("aria-label"), yLabel = plot.querySelector(".y-label").textContent, xLabel = plot.querySelector(".x-label").textContent;
    const [xUnit, yUnit] = [unitOf(xLabel || (plot.dataset.link ? "(s)" : "")), unitOf(yLabel)];
    let series = null, view = [0, 0, W, H], at = null, start = null;
    plot.addEventListener("redrawn", () => { series = null; });
    const lines = () => (series ??= [...svg.querySelectorAll("path[data-name]:not(.reversal, .repeat, .fault, .skipped)")].map((p) => ({ name: p.dataset.name, points: parse(p.getAttribute("d")).flat() })));
    const valueX = (u) => x0 + u / W * (x1 - x0), valueY = (u) => y1 - u / H * (y1 - y0);
    const axisTicks = () => {
      const [vx, vy, vw, vh] = view, wide = Math.max(2, Math.round(area.clientWidth / 110)), high = Math.max(2, Math.round(area.clientHeight / 55));
      const x = named ? [] : ticks(valueX(vx), valueX(vx + vw), wide).map(([v, t]) => [(v - x0) / (x1 - x0) * W, t]);
      return { x, y: ticks(valueY(vy + vh), valueY(vy), high).map(([v, t]) => [(y1 - v) / (y1 - y0) * H, t]) };
    };
    const spans = (holder, list, side) => holder.replaceChildren(...(side === "top" ? [plot.querySelector(".y-ticks i")] : []), ...list.map(([fraction, text]) => {
      const s = document.createElement("span");
      s.style[side] = `${100 * fraction}%`; s.textContent = text;
      return s;
    }));
    const draw = () => {
      const [vx, vy, vw, vh] = view, whole = vw === W && vh === H, found = axisTicks();
      svg.setAttribute("viewBox", view.join(" "));
      const xs = named ? names.map((t, k) => [k / (x1 - x0) * W - x0 / (x1 - x0) * W, t]) : found.x;
      spans(plot.querySelector(".x-ticks"), xs.map(([u, t]) => [(u - vx) / vw, t]).filter(([s]) => s >= -1e-6 && s <= 1 + 1e-6), "left");
      spans(plot.querySelector(".y-ticks"), found.y.map(([u, t]) => [(u - vy) / vh, t]), "top");
      if (!named || !whole) grid.setAttribute("d", found.y.map(([u]) => `M${vx} ${u}h${vw}`).join("") + found.x.map(([u]) => `M${u} ${vy}v${vh}`).join(""));
      reset.hidden = whole;
      plot.classList.toggle("zoomed", !whole);
    };
    // Linked plots share the horizontal range; only the one that is zoomed changes its vertical one.
    const zoom = (left, top, width, height) => {
      width = Math.min(width, W); height = Math.min(height, H);
      if (!(width > W / 2000 && height > H / 2000)) return;
      view = [Math.max(0, Math.min(left, W - width)), Math.max(0, Math.min(top, H - height)), width, height];
      draw();
      for (const other of all) if (other !== self && plot.dataset.link && other.link === plot.dataset.link) other.follow(valueX(view[0]), valueX(view[0] + width));
    };
    const self = {
      link: plot.dataset.link,
      follow: (low, high) => {
        const left = (low - x0) / (x1 - x0) * W, right = (high - x0) / (x1 - x0) * W;
        view = [Math.max(0, left), view[1], Math.min(W, right) - Math.max(0, left), view[3]];
        if (view[2] > 0) draw();
      },
    };
    const unit = (x, y) => [view[0] + x / area.clientWidth * view[2], view[1] + y / area.clientHeight * view[3]];
    const pixels = (u) => [(u[0] - view[0]) / view[2] * area.clientWidth, (u[1] - view[1]) / view[3] * area.clientHeight];
    const nearest = (points, [px, py], flat) => {
      let best = null, least = Infinity;
      for (const p of points) {
        const [x, y] = pixels(p), d = Math.abs(x - px) + (flat ? 0.1 : 1) * Math.abs(y - py);
        if (d < least) { least = d; best = p; }
      }
      // Between two points of a line over time its value is interpolated.
      return best && [best, least];
    };
    const onLine = (points, u) => {
      for (let i = 1; i < points.length; i++) {
        const [a, b] = [points[i - 1], points[i]];
        if (a[0] <= u && u <= b[0]) return b[0] > a[0] ? a[1] + (u - a[0]) / (b[0] - a[0]) * (b[1] - a[1]) : b[1];
      }
      return null;
    };
    const mark = document.createElement("b"), values = document.createElement("output"), box = document.createElement("i");
    mark.className = "cursor"; values.className = "values"; box.className = "zoom-box";
    mark.hidden = values.hidden = box.hidden = true;
    area.append(mark, box, values);
    const show = (x, y) => {
      at = [x, y];
      const u = unit(x, y), parts = [];
      let place = x;
      if (overTime && !named) {
        parts.push(["", `${number(valueX(u[0]), 4)} ${xUnit}`]);
        for (const s of lines()) {
          const found = onLine(s.points, u[0]);
          if (found !== null && !parts.some(([n]) => n === s.name)) parts.push([s.name, `${number(valueY(found), 4)} ${yUnit}`]);
        }
      } else {
        let best = null;
        for (const s of lines()) {
          const found = nearest(s.points, [x, y], named);
          if (found && (!best || found[1] < best[1])) best = [...found, s.name];
        }
        if (!best) return;
        [place] = pixels(best[0]);
        const where = named ? names[Math.round(valueX(best[0][0]))] ?? "" : `${number(valueX(best[0][0]), 4)} ${xUnit}`;
        if (named) {
          const column = best[0][0];
          parts.push(["", where]);
          for (const s of lines()) {
            const ys = s.points.filter((p) => Math.abs(p[0] - column) < 1).map((p) => valueY(p[1])).filter((v) => v !== 0);
            if (ys.length) parts.push([s.name, `${ys.length > 1 && Math.min(...ys) !== Math.max(...ys) ? `${number(Math.min(...ys), 3)} … ` : ""}${number(Math.max(...ys), 3)} ${yUnit}`]);
          }
        } else parts.push([best[2], `${where}, ${number(valueY(best[0][1]), 4)} ${yUnit}`]);
      }
      mark.style.left = `${place}px`;
      values.replaceChildren(...parts.map(([name, value]) => {
        const span = document.createElement("span");
        span.textContent = name ? `${name} ${value}` : value;
        return span;
      }));
      values.style.left = place > area.clientWidth / 2 ? "0" : "auto";
      values.style.right = place > area.clientWidth / 2 ? "auto" : "0";
      mark.hidden = values.hidden = false;
    };
    const hide = () => { mark.hidden = values.hidden = box.hidden = true; at = null; };
    const local = (e) => { const r = area.getBoundingClientRect(); return [e.clientX - r.left, e.clientY - r.top]; };
    area.addEventListener("pointermove", (e) => {
      const [x, y] = local(e);
      if (!start) return void show(x, y);
      const [a, b] = start, flat = overTime && Math.abs(y - b) < 0.15 * area.clientHeight;
      box.hidden = Math.abs(x - a) < 4;
      Object.assign(box.style, { left: `${Math.min(a, x)}px`, width: `${Math.abs(x - a)}px`, top: flat ? "0" : `${Math.min(b, y)}px`, height: flat ? "100%" : `${Math.abs(y - b)}px` });
    });
    area.addEventListener("pointerdown", (e) => { if (e.button === 0) { start = local(e); area.setPointerCapture(e.pointerId); } });
    area.addEventListener("pointerup", (e) => {
      if (!start) return;
      const [[a, b], [x, y]] = [start, local(e)], flat = overTime && Math.abs(y - b) < 0.15 * area.clientHeight;
      start = null; box.hidden = true;
      if (Math.abs(x - a) < 8) return void show(x, y);
      const [l, t] = unit(Math.min(a, x), flat ? 0 : Math.min(b, y)), [r, d] = unit(Math.max(a, x), flat ? area.clientHeight : Math.max(b, y));
      zoom(l, t, r - l, d - t);
    });
    area.addEventListener("pointercancel", () => { start = null; hide(); });
    area.addEventListener("pointerleave", () => { if (!start) hide(); });
    const all_ = () => zoom(0, 0, W, H);
    area.addEventListener("dblclick", all_);
    area.tabIndex = 0;
    area.setAttribute("role", "application");
    area.setAttribute("aria-label", `${title}. Arrow keys move the cursor, plus and minus zoom, zero shows all.`);
    area.addEventListener("keydown", (e) => {
      if (e.ctrlKey || e.metaKey || e.altKey) return;
      const [x, y] = at ?? [area.clientWidth / 2, area.clientHeight / 2], step = (e.shiftKey ? 0.1 : 0.01) * area.clientWidth;
      const grow = (f) => { const u = unit(x, y), w = view[2] * f, h = overTime ? view[3] : view[3] * f; zoom(u[0] - w / 2, overTime ? view[1] : u[1] - h / 2, w, h); show(area.clientWidth / 2, y); };
      const act = { ArrowLeft: () => show(Math.max(0, x - step), y), ArrowRight: () => show(Math.min(area.clientWidth, x + step), y), ArrowUp: () => show(x, Math.max(0, y - step)), ArrowDown: () => show(x, Math.min(area.clientHeight, y + step)), "+": () => grow(0.5), "=": () => grow(0.5), "-": () => grow(2), 0: all_, Escape: hide }[e.key];
      if (!act) return;
      e.preventDefault();
      act();
    });
    area.addEventListener("blur", hide);
    const legend = () => {
      const own = [...plot.querySelectorAll(".legend > span")], shared = own.length ? own : [...(plot.closest(".pictures")?.nextElementSibling?.matches(".legend") ? plot.closest(".pictures").nextElementSibling.children : [])];
      return shared.map((s) => ({ name: s.textContent.trim(), style: styleOf(s.querySelector("path")) }));
    };
    const tools = document.createElement("span"), reset = button("↺", `Show all of: ${title}`, all_);
    tools.className = "tools";
    reset.hidden = true;
    tools.append(reset, button("SVG", `Save as SVG: ${title}`, () => onPaper(() => {
      const [vx, vy, vw, vh] = view, found = axisTicks();
      const shapes = [...svg.querySelectorAll("path")].map((p) => ({ data: p.getAttribute("d"), style: styleOf(p) }));
      const xs = named ? names.map((t, k) => [(k - x0) / (x1 - x0) * W, t]) : found.x;
      save(title, [{ box: view, height: 340, shapes, legend: legend(), x: { label: xLabel || (plot.dataset.link ? "time (s)" : ""), ticks: xs.map(([u, t]) => [(u - vx) / vw, t]) }, y: { label: yLabel, ticks: found.y.map(([u, t]) => [(u - vy) / vh, t]) } }]);
    })), button("CSV", `Save the drawn points as CSV: ${title}`, () => {
      const exact = (v) => Number(v.toPrecision(6)), along = (u) => (named ? names[Math.round(valueX(u))] ?? "" : exact(valueX(u)));
      table(title, [["line", xLabel || (plot.dataset.link ? "time (s)" : ""), yLabel], ...lines().flatMap((s) => s.points.map(([u, v]) => [s.name, along(u), exact(valueY(v))]))]);
    }));
    plot.querySelector(".y-label").after(tools);
    all.push(self);
  };
  document.querySelectorAll(".plot").forEach(enhance);
  return { button, number, onPaper, plain, save, table, ticks };
})();
