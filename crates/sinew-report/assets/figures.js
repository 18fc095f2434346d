"use strict";
// Charts as files: laid out once for the width and font that the reader chose, written as SVG or PDF, and as CSV.
const figures = (() => {
  // Lengths are in units of which 13 are a line of text; saved text has 9 points.
  const TEXT = 13, UNIT_PT = 9 / TEXT, MM_PT = 72 / 25.4;
  const FONTS = { sans: { css: "Helvetica, Arial, sans-serif", pdf: "Helvetica" }, serif: { css: "'Times New Roman', Times, serif", pdf: "Times-Roman" } };
  const pen = document.createElement("canvas").getContext("2d", { willReadFrequently: true });

  const settings = { width: 160, font: "sans" };
  try {
    const kept = JSON.parse(localStorage.getItem("sinew-figures") || "{}");
    if (kept.width >= 40 && kept.width <= 400) settings.width = kept.width;
    if (FONTS[kept.font]) settings.font = kept.font;
  } catch { /* private window */ }
  const form = document.getElementById("figures"), width = form.querySelector("input"), font = form.querySelector("select");
  width.value = settings.width; font.value = settings.font;
  form.addEventListener("change", () => {
    if (width.checkValidity()) settings.width = width.valueAsNumber;
    settings.font = font.value;
    try { localStorage.setItem("sinew-figures", JSON.stringify(settings)); } catch { /* kept for this page */ }
  });

  // A colour of a style sheet as "#rrggbb" and its opacity.
  const plain = (colour) => {
    pen.canvas.width = pen.canvas.height = 1;
    pen.fillStyle = colour;
    pen.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = pen.getImageData(0, 0, 1, 1).data;
    return [`#${[r, g, b].map((v) => v.toString(16).padStart(2, "0")).join("")}`, a / 255];
  };
  // Whatever the theme, colours are those of white paper while `read` runs.
  const onPaper = (read) => {
    const root = document.documentElement, theme = root.dataset.theme;
    root.dataset.theme = "light";
    try { return read(); } finally { if (theme) root.dataset.theme = theme; else delete root.dataset.theme; }
  };
  // As pages write numbers.
  const number = (v, digits) => (v === null || v === undefined || !Number.isFinite(v) ? "–" : Number(v.toPrecision(digits)).toString().replace("-", "−"));
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
  // Polylines of a path: M and L to points, l with relative steps, h and v, z.
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
        const moved = x !== numbers[0] || y !== numbers[1];
        [x, y] = command === "l" ? [x + numbers[0], y + numbers[1]] : numbers;
        if (command === "M") lines.push(line = []);
        if (command === "l" ? numbers[0] || numbers[1] : command === "M" || moved) push();
        numbers = [];
      }
    }
    return lines;
  };

  const short = (v) => Number(v.toFixed(2));
  const measured = (words) => {
    pen.font = `${TEXT}px ${FONTS[settings.font].css}`;
    return pen.measureText(words).width;
  };
  // Panels one above the other: { x, y: {label, low, high, named: [at, text] or none}, box, height, grid: style,
  // shapes: [{data, style}], legend: [{name, style}] } with styles { fill, fillOpacity, stroke, strokeOpacity, width, cap,
  // dash }. What is drawn: boxes of shapes, lines and texts.
  const layout = (panels) => {
    const wide = settings.width * MM_PT / UNIT_PT, left = 76, inner = wide - left - 20, parts = [];
    const line = (data, style) => parts.push({ data, style }), text = (x, y, words, anchor = "start") => parts.push({ x, y, words, anchor });
    let top = 30;
    for (const p of panels) {
      const high = p.height * Math.max(0.6, Math.min(1, wide / 760));
      const places = (axis, room) => axis.named ?? ticks(axis.low, axis.high, Math.max(2, Math.round(room))).map(([v, t]) => [(v - axis.low) / (axis.high - axis.low), t]);
      text(8, top - 10, p.y.label);
      const [bx, by, bw, bh] = p.box, across = places(p.x, inner / 90), up = places(p.y, high / 60);
      const grid = [...across.filter(() => !p.x.named).map(([at]) => `M${short(bx + at * bw)} ${short(by)}v${short(bh)}`), ...up.map(([at]) => `M${short(bx)} ${short(by + (1 - at) * bh)}h${short(bw)}`)].join("");
      parts.push({ box: p.box, at: [left, top, inner, high], shapes: [{ data: grid, style: p.grid }, ...p.shapes] });
      line(`M${left} ${top}v${high}h${inner}`, { stroke: "#59626d", strokeOpacity: 1, width: 1 });
      for (const [at, label] of up) text(left - 7, top + (1 - at) * high + 4, label, "end");
      top += high + 18;
      for (const [at, label] of across) text(left + at * inner, top, label, "middle");
      if (p.x.label) text(left + inner, top += 19, p.x.label, "end");
      let x = left;
      if (p.legend.length) top += 22;
      for (const entry of p.legend) {
        const room = 51 + measured(entry.name);
        if (x + room > wide && x > left) { x = left; top += 19; }
        line(`M${x} ${top - 4}h28`, entry.style);
        text(x + 35, top, entry.name);
        x += room;
      }
      top += 36;
    }
    return { wide, high: top - 12, parts };
  };

  const escaped = (text) => text.replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);
  const svg = (title, { wide, high, parts }) => {
    const path = (data, s, rest = "") => `<path d="${data}" ${rest}fill="${s.fill ?? "none"}"${s.fill ? ` fill-opacity="${short(s.fillOpacity)}"` : ""} stroke="${s.stroke ?? "none"}"${s.stroke ? ` stroke-opacity="${short(s.strokeOpacity)}" stroke-width="${s.width}" stroke-linecap="${s.cap ?? "butt"}" stroke-linejoin="round"` : ""}${s.dash?.length ? ` stroke-dasharray="${s.dash.join(" ")}"` : ""}/>`;
    const body = parts.map((p) => (p.words !== undefined ? `<text x="${short(p.x)}" y="${short(p.y)}"${p.anchor === "start" ? "" : ` text-anchor="${p.anchor}"`}>${escaped(p.words)}</text>`
      : p.box ? `<svg x="${p.at[0]}" y="${short(p.at[1])}" width="${short(p.at[2])}" height="${short(p.at[3])}" viewBox="${p.box.join(" ")}" preserveAspectRatio="none">${p.shapes.map((s) => path(s.data, s.style, 'vector-effect="non-scaling-stroke" ')).join("")}</svg>`
        : path(p.data, p.style)));
    const [w, h] = [settings.width, settings.width * high / wide];
    return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${short(wide)} ${short(high)}" width="${w}mm" height="${short(h)}mm" font-family="${FONTS[settings.font].css}" font-size="${TEXT}"><title>${escaped(title)}</title><rect width="100%" height="100%" fill="#fff"/>${body.join("")}</svg>\n`;
  };

  // Codes of the two fonts' alphabets: Windows' beyond ASCII, and Symbol's.
  const windows = new TextDecoder("windows-1252");
  const LATIN = new Map(Array.from({ length: 128 }, (_, k) => [windows.decode(Uint8Array.of(k + 128)), k + 128]));
  const SYMBOL = new Map([..."αβχδεφγηικλμνοπθρστυωξψζΔΦΓΛΠΘΣΩΞΨ−"].map((c, k) => [c, "abcdefghiklmnopqrstuwxyzDFGLPQSWXY-".charCodeAt(k)]));
  for (const [c, code] of [["≤", 163], ["∞", 165], ["→", 174], ["≥", 179], ["≈", 187], ["√", 214]]) SYMBOL.set(c, code);
  // Runs of codes, each with its font.
  const runs = (words) => {
    const found = [];
    const add = (name, code) => { if (found.at(-1)?.name === name) found.at(-1).codes.push(code); else found.push({ name, codes: [code] }); };
    for (const c of words) {
      if (SYMBOL.has(c)) add("S", SYMBOL.get(c));
      else if (LATIN.has(c)) add("F", LATIN.get(c));
      // Subscripts and the like become what they are made of; what is in neither font a question mark.
      else for (const part of c.normalize("NFKD")) add("F", part.charCodeAt(0) < 128 ? part.charCodeAt(0) : 63);
    }
    return found;
  };
  const pdf = (title, { wide, high, parts }) => {
    const opacities = ["/ca 1 /CA 1"];
    const tone = (colour, operator) => `${[1, 3, 5].map((k) => short(parseInt(colour.slice(k, k + 2), 16) / 255)).join(" ")} ${operator}\n`;
    const shape = (lines, s) => {
      const [fill, stroke] = [s.fill && s.fillOpacity > 0, s.stroke && s.strokeOpacity > 0 && s.width > 0];
      if (!fill && !stroke) return "";
      const pair = `/ca ${short(s.fillOpacity ?? 1)} /CA ${short(s.strokeOpacity ?? 1)}`;
      if (!opacities.includes(pair)) opacities.push(pair);
      // A point by itself is a dot of the line's end.
      const path = lines.map(([first, ...rest]) => `${short(first[0])} ${short(first[1])} m\n${(rest.length ? rest : [first]).map(([x, y]) => `${short(x)} ${short(y)} l\n`).join("")}`).join("");
      return `/O${opacities.indexOf(pair)} gs\n${fill ? tone(s.fill, "rg") : ""}${stroke ? `${tone(s.stroke, "RG")}${s.width} w ${{ round: 1, square: 2 }[s.cap] ?? 0} J [${(s.dash ?? []).join(" ")}] 0 d\n` : ""}${path}${fill && stroke ? "B" : fill ? "f" : "S"}\n`;
    };
    const text = (p) => {
      const room = p.anchor === "start" ? 0 : measured(p.words) * (p.anchor === "end" ? 1 : 0.5);
      const pieces = runs(p.words).map((run) => `/${run.name} ${TEXT} Tf <${run.codes.map((code) => code.toString(16).padStart(2, "0")).join("")}> Tj`);
      return `BT 1 0 0 -1 ${short(p.x - room)} ${short(p.y)} Tm ${pieces.join(" ")} ET\n`;
    };
    const box = ({ box: [bx, by, bw, bh], at: [x, y, w, h], shapes }) => `q ${x} ${short(y)} ${short(w)} ${short(h)} re W n\n${shapes.map((s) => shape(parse(s.data).map((line) => line.map(([u, v]) => [x + (u - bx) / bw * w, y + (v - by) / bh * h])), s.style)).join("")}Q\n`;
    const drawn = parts.map((p) => (p.words !== undefined ? `/O0 gs 0 0 0 rg\n${text(p)}` : p.box ? box(p) : shape(parse(p.data), p.style)));
    const [w, h] = [short(wide * UNIT_PT), short(high * UNIT_PT)], content = `${UNIT_PT} 0 0 ${-UNIT_PT} 0 ${h} cm 1 j\n${drawn.join("")}`;
    const unicode = [...`\ufeff${title}`].flatMap((c) => [...Array(c.length).keys()].map((k) => c.charCodeAt(k).toString(16).padStart(4, "0"))).join("");
    const objects = [
      "<< /Type /Catalog /Pages 2 0 R >>",
      "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      `<< /Type /Page /Parent 2 0 R /MediaBox [0 0 ${w} ${h}] /Contents 4 0 R /Resources << /Font << /F 5 0 R /S 6 0 R >> /ExtGState << ${opacities.map((pair, k) => `/O${k} << ${pair} >>`).join(" ")} >> >> >>`,
      `<< /Length ${content.length} >>\nstream\n${content}\nendstream`,
      `<< /Type /Font /Subtype /Type1 /BaseFont /${FONTS[settings.font].pdf} /Encoding /WinAnsiEncoding >>`,
      "<< /Type /Font /Subtype /Type1 /BaseFont /Symbol >>",
      `<< /Title <${unicode}> /Producer (Sinew) >>`,
    ];
    let file = "%PDF-1.4\n";
    const places = objects.map((object, k) => {
      const place = file.length;
      file += `${k + 1} 0 obj\n${object}\nendobj\n`;
      return place;
    });
    const table = file.length;
    return `${file}xref\n0 ${objects.length + 1}\n0000000000 65535 f \n${places.map((place) => `${String(place).padStart(10, "0")} 00000 n \n`).join("")}trailer\n<< /Size ${objects.length + 1} /Root 1 0 R /Info 7 0 R >>\nstartxref\n${table}\n%%EOF\n`;
  };

  const KINDS = { csv: "text/csv", svg: "image/svg+xml", pdf: "application/pdf" };
  const download = (title, text, kind) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type: KINDS[kind] }));
    link.download = `${title.replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-|-$/g, "").slice(0, 80).toLowerCase() || "figure"}.${kind}`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };
  // Rows of texts and numbers; what is missing stays empty.
  const table = (title, rows) => download(title, rows.map((row) => `${row.map((v) => (typeof v === "string" ? `"${v.replaceAll('"', '""')}"` : v ?? "")).join(",")}\n`).join(""), "csv");
  const save = (title, panels, kind) => download(title, { svg, pdf }[kind](title, layout(panels)), kind);
  return { number, onPaper, parse, plain, save, table, ticks };
})();
