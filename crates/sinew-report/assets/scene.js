"use strict";
// Three-dimensional views: shapes of bodies, cables, wrapping surfaces and paths of points in a parallel projection. The
// data stand as JSON in the figure. Drag or arrow keys rotate, plus and minus zoom, two fingers pinch; the wheel scrolls the
// page, with Ctrl it zooms.
(() => {
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const unit = (a) => { const n = Math.hypot(...a) || 1; return a.map((v) => v / n); };
  // A point of a body in its pose: position and quaternion.
  const placed = (pose, p) => {
    const [px, py, pz, w, x, y, z] = pose, t = cross([x, y, z], p).map((v) => 2 * v), u = cross([x, y, z], t);
    return [px + p[0] + w * t[0] + u[0], py + p[1] + w * t[1] + u[1], pz + p[2] + w * t[2] + u[2]];
  };
  const hull = (points) => {
    const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]), half = (list) => {
      const chain = [];
      for (const p of list) {
        while (chain.length > 1) {
          const [a, b] = chain.slice(-2);
          if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0) break;
          chain.pop();
        }
        chain.push(p);
      }
      return chain.slice(0, -1);
    };
    return sorted.length < 3 ? sorted : [...half(sorted), ...half(sorted.reverse())];
  };

  const enhance = (figure) => {
    const data = JSON.parse(figure.querySelector("script").textContent), canvas = figure.querySelector("canvas"), probe = figure.querySelector(".probe");
    const { fixed, paths = [] } = data, poses = data.poses ?? [], sweeps = data.sweeps ?? [];
    const base = poses[0]?.scene;
    const select = figure.querySelector("select"), slide = figure.querySelector("label.slide"), slider = slide?.querySelector("input");
    const colour = (name) => { probe.style.color = name.startsWith("--") ? `var(${name})` : name; return getComputedStyle(probe).color; };
    const classColour = { measured: "--soft", predicted: "--accent", near: "--near", lowered: "--warm" };
    const chosen = () => Number(select?.value ?? 0);
    const scene = () => {
      const sweep = sweeps[chosen() - poses.length];
      if (slide) slide.hidden = !sweep;
      if (!sweep) return poses[chosen()]?.scene;
      slide.querySelector("output").textContent = `${sinew.number(sweep.at[slider.value], 4)} ${sweep.unit}`;
      return sweep.frames[slider.value];
    };
    const cablesOf = (s) => s.cables.map((cable, i) => cable ?? base.cables[i]);
    const points = (s) => {
      const list = cablesOf(s).flat(2);
      // The world's own shapes may be a floor: they do not set the scale.
      for (const shape of fixed.shapes) if (shape.body > 0) for (const p of shape.points) list.push(placed(s.bodies[shape.body], p));
      return list;
    };
    let middle = [0, 0, 0], size = 0.05, radius = 0;
    const frame = () => {
      const sweep = sweeps[chosen() - poses.length], shown = sweep ? [sweep.frames[0], sweep.frames[sweep.frames.length >> 1], sweep.frames[sweep.frames.length - 1]] : poses.length ? [poses[chosen()].scene] : [];
      const all = [...shown.flatMap(points), ...paths.flatMap((p) => p.points)];
      if (!all.length) all.push([0, 0, 0]);
      middle = [0, 1, 2].map((i) => (all.reduce((a, p) => Math.min(a, p[i]), 1 / 0) + all.reduce((a, p) => Math.max(a, p[i]), -1 / 0)) / 2);
      size = all.reduce((a, p) => Math.max(a, Math.hypot(...p.map((v, i) => v - middle[i]))), 1e-3);
      radius = (fixed?.shapes ?? []).reduce((a, s) => Math.max(a, s.radius), 0);
    };
    // Axes of the view: up is against gravity.
    const up = fixed?.up ?? [0, 0, 1], ahead = unit(Math.abs(dot(up, [1, 0, 0])) < 0.9 ? cross(cross(up, [1, 0, 0]), up) : cross(cross(up, [0, 1, 0]), up)), left = cross(up, ahead);
    let yaw = -0.65, pitch = 0.3, zoom = 1;
    // Draws with a pen: polygons and lines in pixels, so that canvas and saved picture are the same.
    const draw = (pen, w, h) => {
      const scale = 0.47 * Math.min(w, h) / (size + radius) * zoom, now = scene();
      const at = (p) => {
        const d = p.map((v, i) => v - middle[i]), x = dot(d, ahead), y = dot(d, left), z = dot(d, up);
        const along = x * Math.cos(yaw) + y * Math.sin(yaw), away = y * Math.cos(yaw) - x * Math.sin(yaw);
        return [w / 2 + scale * along, h / 2 - scale * (z * Math.cos(pitch) - away * Math.sin(pitch)), away * Math.cos(pitch) + z * Math.sin(pitch)];
      };
      if (now) {
        const bodies = fixed.shapes.map((shape) => {
          const list = shape.points.map((p) => at(placed(now.bodies[shape.body], p)));
          return { outline: hull(list), depth: list.reduce((a, p) => a + p[2], 0) / list.length, width: Math.max(2 * shape.radius * scale, 1.5), world: shape.body === 0 };
        }).sort((a, b) => b.depth - a.depth);
        for (const b of bodies) pen.area(b.outline, colour("--shape"), b.width, b.world ? 0.25 : 0.75, colour("--card"));
        for (const s of fixed.surfaces) {
          const centre = placed(now.bodies[s.body], s.centre);
          if (!s.axis) {
            const [x, y] = at(centre);
            pen.line([...Array(25).keys()].map((k) => [x + s.radius * scale * Math.cos(k * Math.PI / 12), y + s.radius * scale * Math.sin(k * Math.PI / 12)]), colour("--rule"), 1);
            continue;
          }
          const tip = placed(now.bodies[s.body], s.centre.map((v, i) => v + s.axis[i])), axis = unit(tip.map((v, i) => v - centre[i]));
          const u = unit(cross(axis, Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0])), v = cross(axis, u);
          const ring = (o) => [...Array(25).keys()].map((k) => at(centre.map((x, i) => x + s.radius * (Math.cos(k * Math.PI / 12) * u[i] + Math.sin(k * Math.PI / 12) * v[i] + o * axis[i]))));
          for (const o of [-0.5, 0.5]) pen.line(ring(o), colour("--rule"), 1);
        }
        cablesOf(now).forEach((cable, i) => cable.forEach((line) => pen.line(line.map(at), colour(`--m${i % 8}`), 1.8, [[], [7, 4], [2, 4], [10, 3, 2, 3]][(i + (i >> 3)) % 4])));
        for (const j of fixed.joints) { const p = at(placed(now.bodies[j.body], j.at)); pen.line([p, p], colour("--ink"), 7); pen.line([p, p], colour("--card"), 4); }
      }
      for (const p of paths) pen.line(p.points.map(at), colour(classColour[p.class] ?? "--accent"), p.class === "measured" ? 3 : 1.6, p.class === "near" ? [6, 4] : []);
      // A bar of a round length, and the directions of the axes.
      const raw = 0.25 * w / scale, power = 10 ** Math.floor(Math.log10(raw)), length = power * [5, 2, 1].find((m) => m * power <= raw);
      pen.line([[14, h - 20], [14, h - 14], [14 + length * scale, h - 14], [14 + length * scale, h - 20]], colour("--soft"), 1);
      pen.text(14, h - 26, `${sinew.number(length >= 1 ? length : 1e3 * length, 3)} ${length >= 1 ? "m" : "mm"}`, colour("--soft"));
      const origin = at(middle);
      [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]].forEach(([name, axis]) => {
        const tip = at(middle.map((v, i) => v + axis[i] * 24 / scale)), [dx, dy] = [tip[0] - origin[0], tip[1] - origin[1]], x = w - 44, y = h - 38;
        pen.line([[x, y], [x + dx, y + dy]], colour("--soft"), 1.5);
        pen.text(x + 1.35 * dx - 3, y + 1.35 * dy + 4, name, colour("--soft"));
      });
    };
    const onCanvas = () => {
      const density = devicePixelRatio || 1, w = canvas.clientWidth, h = canvas.clientHeight;
      if (!w || !h) return;
      canvas.width = w * density; canvas.height = h * density;
      const c = canvas.getContext("2d");
      c.scale(density, density);
      c.lineCap = c.lineJoin = "round"; c.font = "12px system-ui, sans-serif";
      const trace = (list) => { c.beginPath(); list.forEach((p, k) => (k ? c.lineTo(p[0], p[1]) : c.moveTo(p[0], p[1]))); if (list.length === 1 || (list.length === 2 && list[0] === list[1])) c.lineTo(list[0][0] + 0.01, list[0][1]); };
      draw({
        // A hull widened by its radius: filled and stroked; a thinner line of the paper's colour keeps bodies apart.
        area: (list, fill, width, alpha, paper) => {
          c.setLineDash([]); c.globalAlpha = alpha;
          trace(list); c.closePath();
          c.strokeStyle = paper; c.lineWidth = width + 2.5; c.stroke();
          c.fillStyle = c.strokeStyle = fill; c.lineWidth = width; c.stroke(); c.fill();
          c.globalAlpha = 1;
        },
        line: (list, stroke, width, dash = []) => { c.strokeStyle = stroke; c.lineWidth = width; c.setLineDash(dash); trace(list); c.stroke(); },
        text: (x, y, text, fill) => { c.fillStyle = fill; c.fillText(text, x, y); },
      }, w, h);
    };
    const save = () => sinew.onPaper(() => {
      const w = 760, h = 560, parts = [], d = (list) => list.map((p, k) => `${k ? "L" : "M"}${p[0].toFixed(1)} ${p[1].toFixed(1)}`).join("") + (list.length < 2 || list[0] === list[1] ? "h0" : "");
      const { plain } = sinew;
      draw({
        area: (list, fill, width, alpha, paper) => parts.push(`<g opacity="${alpha}" stroke-linejoin="round" stroke-linecap="round"><path d="${d(list)}z" fill="none" stroke="${plain(paper)[0]}" stroke-width="${(width + 2.5).toFixed(1)}"/><path d="${d(list)}z" fill="${plain(fill)[0]}" stroke="${plain(fill)[0]}" stroke-width="${width.toFixed(1)}"/></g>`),
        line: (list, stroke, width, dash = []) => list.length && parts.push(`<path d="${d(list)}" fill="none" stroke="${plain(stroke)[0]}" stroke-width="${width}" stroke-linecap="round" stroke-linejoin="round"${dash.length ? ` stroke-dasharray="${dash}"` : ""}/>`),
        text: (x, y, text, fill) => parts.push(`<text x="${x.toFixed(1)}" y="${y.toFixed(1)}" fill="${plain(fill)[0]}">${text}</text>`),
      }, w, h);
      sinew.download(canvas.getAttribute("aria-label").split(".")[0], `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${w} ${h}" width="${w}" height="${h}" font-family="Helvetica, Arial, sans-serif" font-size="12"><rect width="100%" height="100%" fill="#fff"/>${parts.join("")}</svg>\n`);
    });
    const turn = (a, b) => { yaw += a; pitch = Math.max(-1.55, Math.min(1.55, pitch + b)); onCanvas(); };
    const grow = (f) => { zoom = Math.max(0.2, Math.min(40, zoom * f)); onCanvas(); };
    const reset = () => { [yaw, pitch, zoom] = [-0.65, 0.3, 1]; frame(); onCanvas(); };
    if (select) select.addEventListener("change", () => {
      const sweep = sweeps[chosen() - poses.length];
      if (sweep) { slider.max = sweep.at.length - 1; slider.value = slider.max >> 1; }
      frame(); onCanvas();
    });
    slider?.addEventListener("input", onCanvas);
    const tools = figure.querySelector(".tools");
    tools.append(sinew.button("◂", "Turn left", () => turn(-0.2, 0)), sinew.button("▸", "Turn right", () => turn(0.2, 0)), sinew.button("▴", "Turn up", () => turn(0, 0.15)), sinew.button("▾", "Turn down", () => turn(0, -0.15)),
      sinew.button("+", "Zoom in", () => grow(1.3)), sinew.button("−", "Zoom out", () => grow(1 / 1.3)), sinew.button("↺", "First view", reset), sinew.button("SVG", "Save the view as SVG", save));
    canvas.addEventListener("keydown", (e) => {
      if (e.ctrlKey || e.metaKey || e.altKey) return;
      const act = { ArrowLeft: () => turn(-0.1, 0), ArrowRight: () => turn(0.1, 0), ArrowUp: () => turn(0, 0.1), ArrowDown: () => turn(0, -0.1), "+": () => grow(1.2), "=": () => grow(1.2), "-": () => grow(1 / 1.2), 0: reset }[e.key];
      if (!act) return;
      e.preventDefault();
      act();
    });
    const held = new Map();
    canvas.addEventListener("pointerdown", (e) => { canvas.setPointerCapture(e.pointerId); held.set(e.pointerId, [e.clientX, e.clientY]); });
    ["pointerup", "pointercancel"].forEach((n) => canvas.addEventListener(n, (e) => held.delete(e.pointerId)));
    canvas.addEventListener("pointermove", (e) => {
      const was = held.get(e.pointerId);
      if (!was) return;
      const other = [...held].find(([id]) => id !== e.pointerId), here = [e.clientX, e.clientY];
      held.set(e.pointerId, here);
      if (other) grow(Math.hypot(here[0] - other[1][0], here[1] - other[1][1]) / (Math.hypot(was[0] - other[1][0], was[1] - other[1][1]) || 1));
      else turn((here[0] - was[0]) / 150, (here[1] - was[1]) / 150);
    });
    canvas.addEventListener("wheel", (e) => { if (e.ctrlKey) { e.preventDefault(); grow(Math.exp(-e.deltaY / 300)); } }, { passive: false });
    addEventListener("theme", onCanvas);
    addEventListener("beforeprint", onCanvas);
    new ResizeObserver(onCanvas).observe(canvas);
    frame(); onCanvas();
  };
  document.querySelectorAll("figure.scene").forEach(enhance);
})();
