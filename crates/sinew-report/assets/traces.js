"use strict";
// Time series of the records: zoom, values under the cursor, and the loop of one record.
(() => {
  const byId = (id) => document.getElementById(id);
  const holder = byId("data");
  if (!holder || typeof uPlot === "undefined") return;
  const data = JSON.parse(holder.textContent);
  const live = byId("live"), readout = byId("readout"), select = byId("record");
  byId("viewer").classList.add("live");

  const bytes = (text) => {
    const raw = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    return new DataView(raw.buffer);
  };
  const words = (text, [low, high]) => {
    const view = bytes(text);
    return Array.from({ length: view.byteLength / 2 }, (_, i) => {
      const w = view.getInt16(2 * i, true);
      return w === -32768 ? null : low + (w + 32767) / 65534 * (high - low);
    });
  };
  const combine = (a, b, f) => a.map((v, i) => (v === null || b[i] === null ? null : f(v, b[i])));
  const unpack = (r) => {
    if (r.unpacked) return r.unpacked;
    const view = bytes(r.time);
    const time = Array.from({ length: view.byteLength / 4 }, (_, i) => r.start_s + view.getFloat32(4 * i, true));
    const far = words(r.measured, data.far_range), predicted = words(r.predicted, data.far_range);
    const half = words(r.half, data.half_range), inputs = r.inputs.map((text, k) => (text ? words(text, data.input_ranges[k]) : time.map(() => null)));
    const gate = data.gated ? words(r.gate, [0, 1]) : null;
    const skipped = [];
    let at = 0;
    r.scored.split(" ").map(Number).forEach((n, k) => {
      if (k % 2 && n > 1) skipped.push([time[at], time[Math.min(at + n, time.length - 1)]]);
      at += n;
    });
    r.unpacked = {
      time, far, predicted, half, inputs, near: inputs[0], gate, skipped,
      low: combine(predicted, half, (p, h) => p - h), high: combine(predicted, half, (p, h) => p + h),
      error: combine(predicted, far, (p, m) => p - m),
    };
    return r.unpacked;
  };

  // Canvas cannot resolve light-dark(): a probe element does.
  const probe = document.createElement("span");
  probe.hidden = true;
  live.after(probe);
  const colour = (name) => {
    probe.style.color = `var(--${name})`;
    return getComputedStyle(probe).color;
  };
  const faint = (name, fraction) => {
    probe.style.color = `color-mix(in srgb, var(--${name}) ${fraction}%, transparent)`;
    return getComputedStyle(probe).color;
  };

  const { number } = figures;
  const withUnit = (v, unit) => (unit === "°" ? `${v}°` : unit ? `${v}\u202f${unit}` : v);
  const showReadout = (o) => {
    readout.replaceChildren(...o.flatMap(([k, v]) => {
      const span = document.createElement("span"), b = document.createElement("b");
      b.textContent = v;
      span.append(`${k} `, b);
      return [span, " "];
    }));
  };

  let panes = [], current = Number(select.value), whole = [0, 1], moving = false;
  const axis = (more) => ({
    stroke: () => colour("soft"), font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif",
    grid: { stroke: () => colour("grid"), width: 1 }, ticks: { show: false }, ...more,
  });
  const shade = (u) => {
    const r = unpack(data.records[current]);
    u.ctx.save();
    u.ctx.fillStyle = faint("rule", 22);
    for (const [a, b] of r.skipped) {
      const left = Math.max(u.valToPos(a, "x", true), u.bbox.left);
      const right = Math.min(u.valToPos(b, "x", true), u.bbox.left + u.bbox.width);
      if (right > left) u.ctx.fillRect(left, u.bbox.top, right - left, u.bbox.height);
    }
    u.ctx.restore();
  };
  const followers = (u) => {
    if (moving) return;
    moving = true;
    const { min, max } = u.scales.x;
    panes.forEach((p) => { if (p !== u) p.setScale("x", { min, max }); });
    moving = false;
  };
  const describe = (u) => {
    const i = u.cursor.idx, record = data.records[current];
    if (i === null || i === undefined) {
      showReadout([["RMSE", `${record.percent} of range`], ["in band", record.coverage], ["samples", record.samples.toLocaleString("en").replaceAll(",", "\u202f")]]);
      return;
    }
    const r = unpack(record), unit = data.far_unit;
    const row = [["t", `${number(r.time[i], 6)}\u202fs`], ["measured", withUnit(number(r.far[i], 4), unit)],
      ["predicted", withUnit(`${number(r.predicted[i], 4)} ± ${number(r.half[i], 2)}`, unit)], ["error", withUnit(number(r.error[i], 2), unit)],
      ...data.inputs.map((name, k) => [name, number(r.inputs[k][i], 4)])];
    if (r.gate) row.push(["gate", number(r.gate[i], 2)]);
    showReadout(row);
  };
  // The whole record: its range without outliers; zoomed in: the samples in view.
  const fit = (range, fixed) => (u, low, high) => {
    const { min, max } = u.scales.x;
    const near = !fixed && min !== null && max - min < 0.98 * (whole[1] - whole[0]) && low !== null;
    if (near) {
      low = Math.max(low, range[0]);
      high = Math.min(high, range[1]);
      if (high > low) return uPlot.rangeNum(low, high, 0.06, false);
    }
    return range[1] > range[0] ? range : [range[0] - 1, range[0] + 1];
  };
  const pane = (label, height, series, columns, range, bands, last, fixed = false) => {
    const title = document.createElement("div");
    title.className = "pane-label";
    title.textContent = label;
    live.append(title);
    const u = new uPlot({
      width: live.clientWidth, height: last ? height + 34 : height, padding: [6, 12, last ? 0 : 6, 0], legend: { show: false },
      cursor: { sync: { key: "sinew" }, y: false, points: { size: 6 }, drag: { x: true, y: false } },
      scales: { x: { time: false }, y: { range: fit(range, fixed) } },
      axes: [axis({ size: last ? 26 : 4, values: last ? undefined : () => [], label: last ? "time (s)" : undefined, labelSize: 16, labelGap: 0 }), axis({ size: 56, splits: (u, _, low, high) => figures.ticks(low, high, Math.max(2, Math.round(u.bbox.height / devicePixelRatio / 45))).map(([v]) => v), values: (u, splits) => splits.map((v) => number(v, 6)) })],
      series: [{}, ...series], bands,
      hooks: { setScale: [(u, key) => key === "x" && followers(u)], drawClear: [shade], setCursor: [(u) => u === panes[0] && describe(u)] },
    }, columns, live);
    panes.push(u);
    return u;
  };
  const line = (name, width) => ({ stroke: () => colour(name), width, points: { show: false } });
  const build = () => {
    // The height is fixed while the panes are replaced, so that the page does not scroll.
    live.style.minHeight = `${live.offsetHeight}px`;
    panes.forEach((p) => p.destroy());
    panes = [];
    live.replaceChildren();
    const record = data.records[current], r = unpack(record), phone = live.clientWidth < 600;
    const finite = r.time.filter(Number.isFinite);
    whole = [Math.min(...finite), Math.max(...finite)];
    const edge = { stroke: "transparent", width: 0, points: { show: false } };
    pane(data.far, phone ? 240 : 330, [edge, edge, { ...line("measured", 3), stroke: () => faint("measured", 50) }, line("accent", 1.5)], [r.time, r.high, r.low, r.far, r.predicted],
      record.view, [{ series: [1, 2], fill: () => faint("accent", 20) }], false);
    pane(data.far_unit ? `error, predicted − measured (${data.far_unit})` : "error, predicted − measured", 120, [line("accent", 1.4)], [r.time, r.error], record.view_error, [], false);
    const gate = r.gate !== null;
    data.inputs.forEach((name, k) => pane(name, 110, [line("near", 1.5)], [r.time, r.inputs[k]], record.view_inputs[k], [], !gate && k === data.inputs.length - 1));
    if (gate) pane("gate: weight of the learned correction", 70, [line("warm", 1.4)], [r.time, r.gate], [0, 1.05], [], true, true);
    live.style.minHeight = "";
    describe(panes[0]);
  };
  // The loop of one record, drawn into the picture of all.
  const loop = document.querySelector("#loop-figure .loop");
  const paths = loop ? ["measured", "predicted"].map((c) => loop.querySelector(`path.${c}`)) : [];
  const loopSize = loop ? loop.querySelector("svg").getAttribute("viewBox").split(" ").slice(2).map(Number) : [];
  const drawn = paths.map((p) => p?.getAttribute("d") ?? "");
  let single = false;
  const drawLoop = () => {
    if (!loop || paths.includes(null)) return;
    const r = unpack(data.records[current]), [x0, x1, y0, y1] = loop.dataset.ends.split(" ").map(Number), [width, height] = loopSize;
    const path = (ys) => {
      let d = "", up = true;
      ys.forEach((y, i) => {
        const x = r.near[i];
        if (x === null || y === null) { up = true; return; }
        d += `${up ? "M" : "L"}${Math.round((x - x0) / (x1 - x0) * width)} ${Math.round((y1 - y) / (y1 - y0) * height)}`;
        up = false;
      });
      return d;
    };
    [r.far, r.predicted].forEach((ys, k) => paths[k].setAttribute("d", single ? path(ys) : drawn[k]));
    loop.dispatchEvent(new Event("redrawn"));
    loop.classList.toggle("one", single);
    const name = byId("loop-name");
    if (name) name.textContent = single ? data.records[current].label : "";
    document.querySelectorAll("[data-loop]").forEach((b) => b.setAttribute("aria-pressed", String((b.dataset.loop === "one") === single)));
  };
  document.querySelectorAll("[data-loop]").forEach((b) => b.addEventListener("click", () => { single = b.dataset.loop === "one"; drawLoop(); }));
  const zoom = (min, max) => {
    const width = Math.min(max - min, whole[1] - whole[0]);
    min = Math.max(whole[0], Math.min(min, whole[1] - width));
    if (width > 0) panes[0].setScale("x", { min, max: min + width });
  };
  const step = (kind) => {
    const { min, max } = panes[0].scales.x, w = max - min, c = (min + max) / 2;
    if (kind === "in") zoom(c - w / 4, c + w / 4);
    if (kind === "out") zoom(c - w, c + w);
    if (kind === "left") zoom(min - w / 4, max - w / 4);
    if (kind === "right") zoom(min + w / 4, max + w / 4);
    if (kind === "all") zoom(...whole);
  };
  const pick = (index) => {
    current = index;
    select.value = String(index);
    document.querySelectorAll("[data-pick]").forEach((b) => b.setAttribute("aria-pressed", String(Number(b.dataset.pick) === index)));
    build();
    drawLoop();
  };
  addEventListener("theme", () => panes.forEach((p) => p.redraw()));

  select.addEventListener("change", () => pick(Number(select.value)));
  document.querySelectorAll("[data-pick]").forEach((b) => b.addEventListener("click", () => {
    pick(Number(b.dataset.pick));
    if (b.classList.contains("thumb")) byId("traces").scrollIntoView();
  }));
  // The panes as they are zoomed, one above the other.
  const style = (name, width, dash = []) => {
    probe.style.color = `var(--${name})`;
    const [colour] = figures.plain(getComputedStyle(probe).color);
    return { line: { stroke: colour, strokeOpacity: 1, width, dash }, area: { fill: colour, fillOpacity: 0.2 }, swatch: { stroke: colour, strokeOpacity: 0.2, width: 10 } };
  };
  const panels = () => {
    const r = unpack(data.records[current]), far = style("measured", 2.4), own = style("accent", 1.4), input = style("near", 1.3, [7, 4]), warm = style("warm", 1.3), grid = style("grid", 1).line;
    return panes.map((u, k) => {
      const { min: x0, max: x1 } = u.scales.x, { min: y0, max: y1 } = u.scales.y, W = 4000, H = 2000;
      const at = (i, ys) => `${((r.time[i] - x0) / (x1 - x0) * W).toFixed(1)} ${((y1 - ys[i]) / (y1 - y0) * H).toFixed(1)}`;
      const seen = r.time.map((t, i) => i).filter((i) => r.time[i] >= x0 && r.time[i] <= x1);
      const path = (ys) => seen.map((i, n) => (ys[i] === null ? "" : `${n && ys[seen[n - 1]] !== null ? "L" : "M"}${at(i, ys)}`)).join("");
      const banded = seen.filter((i) => r.high[i] !== null && r.low[i] !== null);
      const shapes = k === 0 ? [{ data: banded.length ? `M${banded.map((i) => at(i, r.high)).join("L")}L${banded.reverse().map((i) => at(i, r.low)).join("L")}z` : "", style: own.area }, { data: path(r.far), style: far.line }, { data: path(r.predicted), style: own.line }]
        : k === 1 ? [{ data: path(r.error), style: own.line }]
        : k - 2 < data.inputs.length ? [{ data: path(r.inputs[k - 2]), style: input.line }] : [{ data: path(r.gate), style: warm.line }];
      const label = live.querySelectorAll(".pane-label")[k].textContent, last = k === panes.length - 1;
      const legend = [{ name: "measured", style: far.line }, { name: "predicted", style: own.line }, { name: "95 % band", style: own.swatch }];
      return { box: [0, 0, W, H], height: k === 0 ? 300 : 110, grid, shapes, legend: k === 0 ? legend : [], x: { label: last ? "time (s)" : "", low: x0, high: x1 }, y: { label, low: y0, high: y1 } };
    });
  };
  for (const kind of ["svg", "pdf"]) byId(`save-${kind}`).addEventListener("click", () => figures.onPaper(() => figures.save(`${data.far} ${data.records[current].label}`, panels(), kind)));
  byId("save-csv").addEventListener("click", () => {
    const { label } = data.records[current], r = unpack(data.records[current]), columns = [r.time, r.far, r.predicted, r.low, r.high, r.error, ...r.inputs];
    const labels = [...live.querySelectorAll(".pane-label")].map((e) => e.textContent);
    figures.table(`${data.far} ${label}`, [["time (s)", labels[0], "predicted", "95 % band, low", "95 % band, high", ...labels.slice(1, 2 + r.inputs.length)], ...r.time.map((_, i) => columns.map((c) => c[i]))]);
  });
  document.querySelectorAll("[data-zoom]").forEach((b) => b.addEventListener("click", () => step(b.dataset.zoom)));
  live.addEventListener("dblclick", () => step("all"));
  live.addEventListener("keydown", (e) => {
    const kind = { ArrowLeft: "left", ArrowRight: "right", "+": "in", "=": "in", "-": "out", 0: "all" }[e.key];
    if (!kind || e.ctrlKey || e.metaKey || e.altKey) return;
    e.preventDefault();
    step(kind);
  });

  // Touch: one finger moves a zoomed picture, two zoom it.
  const fingers = new Map();
  const timeAt = (x) => panes[0].posToVal(x - panes[0].over.getBoundingClientRect().left, "x");
  live.addEventListener("pointerdown", (e) => { if (e.pointerType === "touch") fingers.set(e.pointerId, { x: e.clientX, t: timeAt(e.clientX) }); });
  live.addEventListener("pointermove", (e) => {
    const finger = fingers.get(e.pointerId);
    if (!finger) return;
    finger.x = e.clientX;
    const { left, width } = panes[0].over.getBoundingClientRect();
    const [a, b] = [...fingers.values()];
    const { min, max } = panes[0].scales.x;
    if (b && Math.abs(b.x - a.x) > 12) {
      const perPixel = (b.t - a.t) / (b.x - a.x);
      if (perPixel > 0) zoom(a.t - (a.x - left) * perPixel, a.t + (left + width - a.x) * perPixel);
    } else if (!b && max - min < (whole[1] - whole[0]) * 0.999) {
      const perPixel = (max - min) / width, start = a.t - (a.x - left) * perPixel;
      zoom(start, start + (max - min));
    }
  });
  ["pointerup", "pointercancel"].forEach((n) => live.addEventListener(n, (e) => fingers.delete(e.pointerId)));

  let width = 0;
  new ResizeObserver(() => {
    if (live.clientWidth === width || !live.clientWidth) return;
    width = live.clientWidth;
    panes.forEach((p) => p.setSize({ width, height: p.height }));
  }).observe(live);
  width = live.clientWidth;
  pick(current);
})();
