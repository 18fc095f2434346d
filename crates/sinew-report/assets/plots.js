"use strict";
// Plots: values under the cursor, zoom, and saving. The pictures stand in the page as paths, which this script reads;
// without it they are complete.
(() => {
  const unitOf = (label) => (/\(([^()]+)\)\s*$/.exec(label) || ["", ""])[1];
  const styleOf = (path) => {
    const css = getComputedStyle(path), filled = css.fill !== "none", stroked = css.stroke !== "none";
    const [fill, fillOpacity] = figures.plain(filled ? css.fill : "transparent"), [stroke, alpha] = figures.plain(stroked ? css.stroke : "transparent");
    const dash = css.strokeDasharray === "none" ? [] : css.strokeDasharray.split(/[\s,]+/).map(parseFloat);
    return { fill: filled ? fill : null, fillOpacity, stroke: stroked ? stroke : null, strokeOpacity: alpha * css.strokeOpacity, width: parseFloat(css.strokeWidth), cap: css.strokeLinecap, dash };
  };
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
    const lines = () => (series ??= [...svg.querySelectorAll("path[data-name]:not(.reversal, .repeat, .fault, .skipped)")].map((p) => ({ name: p.dataset.name, points: figures.parse(p.getAttribute("d")).flat() })));
    const valueX = (u) => x0 + u / W * (x1 - x0), valueY = (u) => y1 - u / H * (y1 - y0);
    const axisTicks = () => {
      const [vx, vy, vw, vh] = view, wide = Math.max(2, Math.round(area.clientWidth / 110)), high = Math.max(2, Math.round(area.clientHeight / 55));
      const x = named ? [] : figures.ticks(valueX(vx), valueX(vx + vw), wide).map(([v, t]) => [(v - x0) / (x1 - x0) * W, t]);
      return { x, y: figures.ticks(valueY(vy + vh), valueY(vy), high).map(([v, t]) => [(y1 - v) / (y1 - y0) * H, t]) };
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
        parts.push(["", `${figures.number(valueX(u[0]), 4)} ${xUnit}`]);
        for (const s of lines()) {
          const found = onLine(s.points, u[0]);
          if (found !== null && !parts.some(([n]) => n === s.name)) parts.push([s.name, `${figures.number(valueY(found), 4)} ${yUnit}`]);
        }
      } else {
        let best = null;
        for (const s of lines()) {
          const found = nearest(s.points, [x, y], named);
          if (found && (!best || found[1] < best[1])) best = [...found, s.name];
        }
        if (!best) return;
        [place] = pixels(best[0]);
        const where = named ? names[Math.round(valueX(best[0][0]))] ?? "" : `${figures.number(valueX(best[0][0]), 4)} ${xUnit}`;
        if (named) {
          const column = best[0][0];
          parts.push(["", where]);
          for (const s of lines()) {
            const ys = s.points.filter((p) => Math.abs(p[0] - column) < 1).map((p) => valueY(p[1])).filter((v) => v !== 0);
            if (ys.length) parts.push([s.name, `${ys.length > 1 && Math.min(...ys) !== Math.max(...ys) ? `${figures.number(Math.min(...ys), 3)} … ` : ""}${figures.number(Math.max(...ys), 3)} ${yUnit}`]);
          }
        } else parts.push([best[2], `${where}, ${figures.number(valueY(best[0][1]), 4)} ${yUnit}`]);
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
    const drawn = () => {
      const [vx, vy, vw, vh] = view, shapes = [...svg.querySelectorAll("path:not(.grid)")].map((p) => ({ data: p.getAttribute("d"), style: styleOf(p) }));
      const x = { label: xLabel || (plot.dataset.link ? "time (s)" : ""), low: valueX(vx), high: valueX(vx + vw), named: named ? names.map((t, k) => [((k - x0) / (x1 - x0) * W - vx) / vw, t]) : null };
      return [{ box: view, height: 340, grid: styleOf(grid), shapes, legend: legend(), x, y: { label: yLabel, low: valueY(vy + vh), high: valueY(vy) } }];
    };
    const saved = ["svg", "pdf"].map((kind) => button(kind.toUpperCase(), `Save as ${kind.toUpperCase()}: ${title}`, () => figures.onPaper(() => figures.save(title, drawn(), kind))));
    tools.append(reset, ...saved, button("CSV", `Save the drawn points as CSV: ${title}`, () => {
      const exact = (v) => Number(v.toPrecision(6)), along = (u) => (named ? names[Math.round(valueX(u))] ?? "" : exact(valueX(u)));
      figures.table(title, [["line", xLabel || (plot.dataset.link ? "time (s)" : ""), yLabel], ...lines().flatMap((s) => s.points.map(([u, v]) => [s.name, along(u), exact(valueY(v))]))]);
    }));
    plot.querySelector(".y-label").after(tools);
    all.push(self);
  };
  document.querySelectorAll(".plot").forEach(enhance);
})();
