// A body in WebGL2: turned by pointer, touch or keys, moved by an emulator's parameters or through cases, coloured by a quantity.
"use strict";
(() => {
  // Numbers: what the program stores as base64, and a regression as sinew-emulate defines it.
  const array = (Type, text) => new Type(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer);
  const clamp = (x, low = 0, high = 1) => Math.min(high, Math.max(low, x));
  /** The share of a parameter's range at which a value of θ lies, on its scale, and the value at a share. */
  const shareOf = ({ range: [a, b], logarithmic }, value) => (logarithmic ? Math.log(value / a) / Math.log(b / a) : (value - a) / (b - a));
  const valueAt = ({ range: [a, b], logarithmic }, share) => (logarithmic ? a * (b / a) ** share : a + (b - a) * share);
  /** The share at a value that is typed in the parameter's own unit: at the end of the range where it is outside; NaN where it is no number. */
  const shareTyped = (p, typed) => clamp(shareOf(p, clamp(typed * p.size, ...p.range)));
  /** A row of numbers: integers of a few bytes each, the lowest byte first, raised by the largest one. */
  const unpack = ({ step, integers }, size) => {
    const bytes = array(Uint8Array, integers), each = bytes.length / size, half = Math.min(256 ** each / 2, 2 ** 52) - 1;
    const values = new Float64Array(size).fill(-half);
    bytes.forEach((byte, i) => (values[Math.floor(i / each)] += byte * 256 ** (i % each)));
    return values.map((x) => x * step);
  };
  /** A function of the shares of θ that gives mean + Σ modes · (φ W); for all values, or for the three of some nodes. */
  const regression = (source) => {
    const { lengths, exponents } = source;
    const [mean, points, inputs] = [array(Float64Array, source.mean), array(Float64Array, source.points), exponents[0].length || 1];
    const [size, count, rows] = [mean.length, source.modes.length, points.length / inputs], kernels = (rows * lengths.length) / inputs;
    const functions = kernels + exponents.length, [weights, phi] = [source.weights.map((row) => unpack(row, functions)), new Float64Array(functions)];
    // Four modes in one sweep over the values, for which there are zeros at the end.
    const [modes, coefficients, values] = [new Float64Array((count + 3) * size), new Float64Array(count + 3), new Float64Array(size)];
    source.modes.forEach((row, k) => modes.set(unpack(row, size), k * size));
    const add = (from, to) => {
      for (let i = from; i < to; i++) values[i] = mean[i];
      for (let k = 0, at = 0; k < count; k += 4, at += 4 * size) {
        const [a, b, c, d] = [coefficients[k], coefficients[k + 1], coefficients[k + 2], coefficients[k + 3]];
        for (let i = from, j = at + from; i < to; i++, j++)
          values[i] += a * modes[j] + b * modes[j + size] + c * modes[j + 2 * size] + d * modes[j + 3 * size];
      }
    };
    return (shares, nodes) => {
      const x = shares.map((share) => Math.sqrt(12) * (share - 0.5));
      for (let b = 0; b < functions; b++) {
        const [at, set] = [(b % rows) * inputs, Math.floor(b / rows) * inputs];
        const square = b < kernels && x.reduce((sum, of, d) => sum + ((of - points[at + d]) / lengths[set + d]) ** 2, 0);
        phi[b] = b < kernels ? Math.exp(-0.5 * square) : exponents[b - kernels].reduce((v, e, d) => v * x[d] ** e, 1);
      }
      weights.forEach((row, k) => (coefficients[k] = row.reduce((sum, weight, b) => sum + phi[b] * weight, 0)));
      nodes ? nodes.forEach((node) => add(3 * node, 3 * node + 3)) : add(0, size);
      return values;
    };
  };
  /** Volume of a cavity: flux of a field through its surfaces and the lids over their rims. */
  const volumeOf = (parts, at) => {
    let volume = 0;
    const place = (node) => [at[3 * node], at[3 * node + 1], at[3 * node + 2]];
    const onto = (planes, x) => planes.reduce((on, { node, normal, dual }) => plus(on, dual, -dot(normal, plus(x, place(node), -1))), x);
    for (const { triangles, weights, lids, planes, field } of parts) {
      const origin = onto(planes, place(triangles[0]));
      const add = (weight, a, b, c) => (volume += weight * dot(field.map((row) => dot(row, plus(plus(plus(a, b), c), origin, -3))), cross(plus(b, a, -1), plus(c, a, -1))) / 6);
      for (let t = 0; t < triangles.length; t += 3) add(weights[(t / 3) % weights.length], place(triangles[t]), place(triangles[t + 1]), place(triangles[t + 2]));
      for (const { edges, chords, weights, planes } of lids) {
        const ends = edges.map((edge) => edge.map(place)), lengths = ends.map(([a, b]) => Math.hypot(...plus(b, a, -1)));
        const whole = lengths.reduce((sum, length) => sum + length, 0) || 1;
        const apex = onto(planes, ends.reduce((sum, [a, b], e) => plus(sum, plus(a, b), (0.5 * lengths[e]) / whole), [0, 0, 0]));
        chords.forEach(([a, b], c) => add(weights[c], place(a), place(b), apex));
      }
    }
    return volume;
  };
  const plus = (a, b, times = 1) => a.map((x, i) => x + times * b[i]);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const unit = (a) => a.map((x) => x / (Math.hypot(...a) || 1));
  // Words and elements.
  const digits = (x, count = 3) => {
    if (x === 0 || !isFinite(x)) return x === 0 ? "0" : "–";
    const size = Math.floor(Math.log10(Math.abs(x)));
    return size < -3 || size > 5 ? x.toExponential(count - 1) : String(+x.toFixed(clamp(count - 1 - size, 0, 6)));
  };
  const unitOf = (name) => (name === "1" ? "" : ` ${name}`), head = (name, of) => (of === "1" ? name : `${name} [${of}]`);
  const plain = (text) => text.replace(/[&<>"]/g, (sign) => `&#${sign.charCodeAt(0)};`);
  const make = (tag, properties = {}, ...children) => {
    const element = Object.assign(document.createElement(tag), properties);
    for (const [name, value] of [["role", properties.role], ["aria-label", properties.label]]) if (value) element.setAttribute(name, value);
    element.append(...children);
    return element;
  };
  // Colours: viridis, plasma and magma of matplotlib at nine points.
  const MAPS = {
    displacement: "440154472d7b3b528b2c728e21918c28ae805ec962addc30fde725",
    model: "0d08874c02a17e03a8a92395cc4778e56b5df89540fdc527f0f921",
    error: "1d114740126751127c822681b63679e65164fb8861fec287fcfdbf",
  };
  const colours = (source) => (MAPS[source] ?? MAPS.displacement).match(/.{6}/g);
  const rgb = (hex) => [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16));
  const SOLID = [`#version 300 es
    in vec3 position, normal; in float value; uniform mat4 view; out vec3 place, facing, corner; out float shade;
    void main() {
      place = position; facing = normal; shade = value; corner = vec3(equal(ivec3(gl_VertexID % 3), ivec3(0, 1, 2)));
      gl_Position = view * vec4(position, 1.0);
    }`, `#version 300 es
    precision highp float;
    in vec3 place, facing, corner; in float shade; out vec4 colour;
    uniform vec3 eye, right, up, inside; uniform vec4 cut; uniform float edges; uniform sampler2D colours;
    void main() {
      if (dot(cut.xyz, place) > cut.w) discard;
      // A face seen from behind is the inside of the wall, where it is cut.
      if (!gl_FrontFacing) { colour = vec4(inside, 1.0); return; }
      vec3 n = normalize(facing), towards = normalize(eye - place), key = normalize(towards + 0.55 * up - 0.5 * right);
      float light = 0.50 + 0.42 * max(dot(n, key), 0.0) + 0.14 * dot(n, up);
      vec3 base = shade >= -0.5 ? texture(colours, vec2(clamp(shade, 0.002, 0.998), 0.5)).rgb : vec3(0.55);
      vec3 lit = pow(base, vec3(2.2)) * light * 1.12 + 0.10 * pow(max(dot(n, normalize(key + towards)), 0.0), 48.0), near = smoothstep(vec3(0.0), 1.1 * fwidth(corner), corner);
      lit *= mix(0.55, 1.0, smoothstep(0.0, 0.45, abs(dot(n, towards)))) * mix(1.0, min(near.x, min(near.y, near.z)), 0.45 * edges);
      colour = vec4(pow(lit, vec3(1.0 / 2.2)), 1.0);
    }`];
  const LINES = [`#version 300 es
    in vec3 from, to, facing; uniform mat4 view; uniform vec2 size; uniform float width; uniform vec3 eye; out vec3 place;
    void main() {
      vec4 a = view * vec4(from, 1.0), b = view * vec4(to, 1.0);
      vec2 along = normalize((b.xy / b.w - a.xy / a.w) * size + vec2(1e-6, 0.0));
      place = gl_VertexID > 1 ? to : from; gl_Position = gl_VertexID > 1 ? b : a;
      gl_Position.xy += (float(gl_VertexID % 2) - 0.5) * width * vec2(-along.y, along.x) / size * 2.0 * gl_Position.w;
      gl_Position.z -= 2.5e-3 * gl_Position.w;
      // A fibre on a face that is seen from behind; an outline faces nowhere.
      if (dot(facing, eye - from) < 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    }`, `#version 300 es
    precision highp float;
    in vec3 place; uniform vec4 cut, tint; out vec4 colour;
    void main() { if (dot(cut.xyz, place) > cut.w) discard; colour = tint; }`];
  /** Draws a surface and lines on a canvas; nothing where the browser has no WebGL2. */
  const painter = (canvas) => {
    const gl = canvas.getContext("webgl2", { antialias: true, premultipliedAlpha: false });
    if (!gl) return null;
    const program = (sources) => {
      const made = gl.createProgram();
      sources.forEach((source, index) => {
        const shader = gl.createShader(index ? gl.FRAGMENT_SHADER : gl.VERTEX_SHADER);
        gl.shaderSource(shader, source); gl.compileShader(shader); gl.attachShader(made, shader);
      });
      gl.linkProgram(made); if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
      const set = (values) => {
        gl.useProgram(made);
        for (const [name, value] of Object.entries(values)) {
          const place = gl.getUniformLocation(made, name);
          if (value.length === 16) gl.uniformMatrix4fv(place, false, value);
          else gl[`uniform${value.length ?? 1}f${value.length ? "v" : ""}`](place, value);
        }
      };
      return { made, set };
    };
    const buffers = ({ made }, names, divisor) => {
      const vertices = gl.createVertexArray();
      gl.bindVertexArray(vertices);
      const own = Object.fromEntries(names.map(([name, size]) => {
        const [buffer, place] = [gl.createBuffer(), gl.getAttribLocation(made, name)]; gl.bindBuffer(gl.ARRAY_BUFFER, buffer); gl.enableVertexAttribArray(place);
        gl.vertexAttribPointer(place, size, gl.FLOAT, false, 0, 0); gl.vertexAttribDivisor(place, divisor);
        return [name, buffer];
      }));
      const fill = (arrays) => Object.entries(arrays).forEach(([name, data]) => {
        gl.bindBuffer(gl.ARRAY_BUFFER, own[name]); gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
      });
      return { vertices, fill };
    };
    const [solid, lines, ends] = [program(SOLID), program(LINES), [["from", 3], ["to", 3]]];
    const surface = buffers(solid, [["position", 3], ["normal", 3], ["value", 1]], 0);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    for (const name of ["MIN_FILTER", "MAG_FILTER"]) gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${name}`], gl.LINEAR);
    for (const name of ["WRAP_S", "WRAP_T"]) gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${name}`], gl.CLAMP_TO_EDGE);
    [gl.DEPTH_TEST, gl.BLEND].forEach((name) => gl.enable(name));
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    return {
      surface, fibres: buffers(lines, [...ends, ["facing", 3]], 1), outline: buffers(lines, ends, 1),
      palette(hex) {
        const bytes = Uint8Array.from(hex.flatMap((text) => [...rgb(text), 255]));
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, hex.length, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
      },
      /** The surface with its uniforms, then lines: their buffers, how many, and their uniforms. */
      draw(uniforms, corners, drawn) {
        gl.viewport(0, 0, canvas.width, canvas.height);
        gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
        solid.set(uniforms);
        gl.bindVertexArray(surface.vertices); gl.drawArrays(gl.TRIANGLES, 0, corners);
        for (const [name, count, own] of drawn) {
          lines.set({ view: uniforms.view, eye: uniforms.eye, size: [canvas.width, canvas.height], ...own });
          gl.bindVertexArray(this[name].vertices); gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
        }
      },
    };
  };
  /** Edges of one triangle only, and those where faces meet at an angle; and for every corner the triangles that share its normal. */
  const topologyOf = (triangles, normals) => {
    const [edges, fans] = [new Map(), new Map()];
    const note = (map, key, face) => map.set(key, [...(map.get(key) ?? []), face]);
    triangles.forEach((node, c) => {
      const face = Math.floor(c / 3);
      const next = triangles[3 * face + ((c + 1) % 3)];
      note(edges, `${Math.min(node, next)},${Math.max(node, next)}`, face); note(fans, node, face);
    });
    const smooth = (a, b) => dot(normals(a), normals(b)) > 0.8;
    const sharp = [...edges].filter(([, [a, b]]) => b === undefined || !smooth(a, b)).map(([key]) => key.split(",").map(Number));
    return { sharp, corners: Array.from(triangles, (node, c) => fans.get(node).filter((face) => smooth(face, Math.floor(c / 3)))) };
  };
  /** A chart of curves over two axes with a point, in the colours of the page. */
  const chart = (names, [left, right], [bottom, top], curves, at) => {
    const [width, height, x0, y0] = [360, 210, 46, 172], axes = names.map((name) => plain(name.length > 28 ? `${name.slice(0, 26)}…` : name));
    const x = (v) => x0 + ((v - left) / (right - left || 1)) * (width - x0 - 12);
    const y = (v) => y0 - ((v - bottom) / (top - bottom || 1)) * (y0 - 14);
    const ticks = (low, high) => {
      const raw = (high - low) / 4 || 1;
      const step = [1, 2, 2.5, 5, 10].map((m) => m * 10 ** Math.floor(Math.log10(raw))).find((s) => s >= raw * 0.999);
      const first = Math.ceil(low / step - 1e-9);
      return Array.from({ length: Math.max(0, Math.floor(high / step + 1e-9) - first + 1) }, (_, i) => (first + i) * step);
    };
    const path = (points) => points.map(([a, b], i) => `${i ? "L" : "M"}${x(a).toFixed(1)} ${y(b).toFixed(1)}`).join("");
    const text = (place, anchor, words) => `<text ${place} text-anchor="${anchor}">${words}</text>`;
    const [across, down] = [0.5 * (x0 + width - 12), 0.5 * (y0 + 14)];
    return `<svg viewBox="0 0 ${width} ${height}" role="img" aria-label="${axes[1]} against ${axes[0]}" font-size="11">
      ${ticks(left, right).map((v) => `<path class="grid" d="M${x(v)} 14V${y0}"/>` + text(`x="${x(v)}" y="${y0 + 16}"`, "middle", digits(v, 4))).join("")}
      ${ticks(bottom, top).map((v) => `<path class="grid" d="M${x0} ${y(v)}H${width - 12}"/>` + text(`x="${x0 - 6}" y="${y(v) + 4}"`, "end", digits(v, 4))).join("")}
      ${curves.map(([name, points]) => `<path class="${name}" d="${path(points)}"/>`).join("")}<circle cx="${x(at[0])}" cy="${y(at[1])}" r="5"/>
      ${text(`x="${across}" y="${height - 4}"`, "middle", axes[0])}${text(`transform="rotate(-90 11 ${down})" x="11" y="${down + 4}"`, "middle", axes[1])}</svg>`;
  };
  globalThis.sinewViewer = { array, chart, regression, shareOf, shareTyped, valueAt, volumeOf, views: [] };
  if (typeof document === "undefined") return;
  const START = { yaw: -1.05, pitch: 0.32, zoom: 1, shift: [0, 0] };
  /** Tangent of half of the field of view, points of a curve, and milliseconds of a beat over 2π. */
  const [FIELD, CURVE, BEAT] = [Math.tan(0.245), 17, 640];
  /** Turns an element with data into a view of them. */
  const start = (root) => {
    const data = JSON.parse(root.querySelector("script").textContent);
    const { emulator, quantities, cases, strokes } = data;
    const [points, triangles] = [array(Float32Array, data.points), array(Uint32Array, data.triangles)];
    const [nodes, faces, parameters] = [points.length / 3, triangles.length / 3, emulator?.parameters ?? []];
    const [position, values, lengths] = [Float64Array.from(points), new Float64Array(nodes), new Float64Array(nodes)];
    const pressure = Math.max(0, parameters.findIndex((p) => p.pressure));
    // Elements.
    const canvas = make("canvas", { tabIndex: 0, role: "img" });
    const [legend, readings, charts, rows, tools] = ["legend", "readings", "charts", "rows", "tools"].map((className) => make("div", { className }));
    const [menu, panel] = [make("div", { className: "menu", role: "group", label: "Colour by" }), make("div", { className: "panel" })];
    if (data.title) panel.append(make("header", {}, make("h1", { textContent: data.title }), make("p", { textContent: data.about })));
    panel.append(menu, readings, rows, charts, ...data.notes.map((note) => make("p", { className: "warning", textContent: `⚠ ${note}` })));
    const facts = data.facts.flatMap((pair) => pair.map((textContent, index) => make(index ? "dd" : "dt", { textContent })));
    if (facts.length) panel.append(make("details", {}, make("summary", { textContent: "How these numbers were made" }), make("dl", {}, ...facts)));
    panel.append(make("p", { className: "keys", textContent: "Drag to turn, wheel or pinch to zoom, shift or two fingers to move. Keys on the " +
      `body: arrows turn, + and − zoom, 0 begins again, ${emulator ? "space plays, F fibres, C colours, " : ""}E edges, R rest.` }));
    root.append(make("div", { className: "stage" }, canvas, tools, legend), panel);
    let paint = painter(canvas); if (!paint) return void (legend.textContent = "This browser has no WebGL2, which the body is drawn with.");
    // State.
    const state = { shares: parameters.map(() => 0.5), active: pressure, quantity: 0, chosen: 0, playing: 0, cut: 0, normal: [1, 0, 0],
      fibres: !!strokes, edges: false, rest: true, camera: structuredClone(START), stale: true, mean: 0, largest: 0, error: null };
    const [model, errors] = [emulator && regression(emulator.displacement), emulator?.error && regression(emulator.error)];
    const models = quantities.map((quantity) => quantity.model && regression(quantity.model));
    const cavities = (emulator?.cavities ?? []).map((cavity) => {
      const parts = cavity.parts.map((part) => ({ ...part, triangles: array(Uint32Array, part.triangles) }));
      return { ...cavity, parts, nodes: [...new Set(parts.flatMap((part) => [...part.triangles]))], about: emulator.cavities.length > 1 ? `volume of ${cavity.name}` : "volume" };
    });
    const shown = cases.map((one) => ({ ...one, displacement: array(Float32Array, one.displacement), values: array(Float32Array, one.values) }));
    // All that the body fills at rest and where it moves most.
    const middle = emulator ? model(state.shares) : shown[0].displacement;
    const peak = (u) => Math.sqrt(u.reduce((most, x, i) => (i % 3 ? most : Math.max(most, x ** 2 + u[i + 1] ** 2 + u[i + 2] ** 2)), 0));
    const most = emulator ? quantities[0].scale[1] / (peak(middle) || 1) : 1;
    const bounds = [0, 1, 2].map((axis) => points.reduce(([low, high], x, i) => (i % 3 === axis
      ? [Math.min(low, x, x + most * middle[i]), Math.max(high, x, x + most * middle[i])] : [low, high]), [Infinity, -Infinity]));
    const [centre, radius] = [bounds.map(([low, high]) => 0.5 * (low + high)), 0.54 * Math.hypot(...bounds.map(([low, high]) => high - low))];
    // Geometry: normals of faces by their areas, corners with their own normals, fibres and outline.
    const areas = new Float64Array(3 * faces);
    const normals = () => {
      const side = (a, b) => [0, 1, 2].map((i) => position[3 * b + i] - position[3 * a + i]);
      const area = (a, b, c) => cross(side(a, b), side(a, c));
      for (let f = 0; f < 3 * faces; f += 3) areas.set(area(triangles[f], triangles[f + 1], triangles[f + 2]), f);
    };
    normals(); const topology = topologyOf(triangles, (face) => unit(Array.from(areas.subarray(3 * face, 3 * face + 3))));
    const corner = { position: new Float32Array(9 * faces), normal: new Float32Array(9 * faces), value: new Float32Array(3 * faces) };
    const [from, to] = [0, 1].map((end) => Float32Array.from(topology.sharp.flatMap((edge) => Array.from(points.subarray(3 * edge[end], 3 * edge[end] + 3)))));
    paint.outline.fill({ from, to });
    const fibres = strokes && { triangles: array(Uint32Array, strokes.triangles), along: array(Float32Array, strokes.along) };
    const fill = () => {
      normals();
      const { logarithmic, scale: [a, b] } = quantities[state.quantity];
      const [low, high] = logarithmic ? [Math.log(a), Math.log(b)] : [a, b];
      triangles.forEach((node, c) => {
        const value = logarithmic ? Math.log(Math.max(values[node], Number.MIN_VALUE)) : values[node];
        corner.value[c] = Number.isNaN(value) ? -1 : clamp((value - low) / (high - low || 1));
        let [x, y, z] = [0, 0, 0];
        for (const face of topology.corners[c]) [x, y, z] = [x + areas[3 * face], y + areas[3 * face + 1], z + areas[3 * face + 2]];
        corner.normal.set(unit([x, y, z]), 3 * c);
        corner.position.set(position.subarray(3 * node, 3 * node + 3), 3 * c);
      });
      paint.surface.fill(corner);
      if (!fibres) return;
      const ends = Object.fromEntries(["from", "to", "facing"].map((name) => [name, new Float32Array(3 * fibres.triangles.length)]));
      fibres.triangles.forEach((face, s) => {
        ends.facing.set(areas.subarray(3 * face, 3 * face + 3), 3 * s);
        for (let i = 0; i < 3; i++) {
          const [p, q, r] = [0, 1, 2].map((k) => position[3 * triangles[3 * face + k] + i]);
          const half = fibres.along[2 * s] * (q - p) + fibres.along[2 * s + 1] * (r - p);
          [ends.from[3 * s + i], ends.to[3 * s + i]] = [(p + q + r) / 3 - half, (p + q + r) / 3 + half];
        }
      });
      paint.fibres.fill(ends);
    };
    // What is shown for θ, or for a case.
    const evaluate = () => {
      const u = emulator ? state.solved?.displacement ?? model(state.shares) : shown[state.chosen].displacement;
      position.forEach((_, i) => (position[i] = points[i] + u[i]));
      for (let n = 0; n < nodes; n++) lengths[n] = Math.hypot(u[3 * n], u[3 * n + 1], u[3 * n + 2]);
      [state.mean, state.largest] = [lengths.reduce((sum, x) => sum + x, 0) / nodes, peak(u)];
      if (errors) state.error = Array.from(errors(state.shares), Math.exp);
      const { source } = quantities[state.quantity];
      values.set(source === "displacement" ? lengths : source === "case" ? shown[state.chosen].values : models[state.quantity](state.shares));
      if (source === "error") values.forEach((v, n) => (values[n] = Math.exp(v) * state.error[0]));
    };
    const place = new Float64Array(points.length);
    const volume = (cavity, shares) => {
      const u = shares && model(shares, cavity.nodes);
      if (u) for (const node of cavity.nodes) for (let i = 3 * node; i < 3 * node + 3; i++) place[i] = points[i] + u[i];
      return emulator.volume_scale * volumeOf(cavity.parts, shares ? place : position);
    };
    // Curves over one parameter: for the others as they are, computed when they change, and in the middle of their ranges.
    const kept = new Map();
    const curves = (name, index, of) => [["middle", parameters.map(() => 0.5)], ["own", state.shares]].map(([kind, shares]) => {
      const [slot, key] = [`${name} ${kind}`, shares.with(index, 0).join()];
      const at = (share) => [of(shares.with(index, share)), valueAt(parameters[index], share) / parameters[index].size];
      if (kept.get(slot)?.key !== key) kept.set(slot, { key, points: Array.from({ length: CURVE }, (_, i) => at(i / (CURVE - 1))) });
      return [kind, kept.get(slot).points];
    });
    const [own, range] = [(index) => valueAt(parameters[index], state.shares[index]) / parameters[index].size, ({ range, size }) => range.map((v) => v / size)];
    const drawCharts = () => {
      const pictures = cavities.filter((cavity) => cavity.pressure !== null).map((cavity) => {
        const p = parameters[cavity.pressure];
        const found = curves(cavity.name, cavity.pressure, (shares) => volume(cavity, shares));
        return chart([head(cavity.about, emulator.volume), head(p.name, p.unit)], cavity.range, range(p), found, [volume(cavity), own(cavity.pressure)]);
      });
      if (!pictures.length) {
        const [index, p] = [state.active, parameters[state.active]];
        const found = curves(index, index, (shares) => peak(model(shares))).map(([kind, list]) => [kind, list.map(([u, v]) => [v, u])]);
        pictures.push(chart([head(p.name, p.unit), head("largest displacement", data.length)], range(p), [0, quantities[0].scale[1]], found, [own(index), state.largest]));
      }
      charts.innerHTML = `${pictures.join("")}<p>dashed: all other parameters in the middle of their ranges</p>`;
    };
    const tell = () => {
      const { name, unit: of, scale: [low, high], logarithmic, source } = quantities[state.quantity];
      const bar = make("div", { className: "bar", style: `background:linear-gradient(90deg,${colours(source).map((hex) => `#${hex}`)})` });
      const ends = [low, logarithmic ? Math.sqrt(low * high) : 0.5 * (low + high), high].map((v) => make("span", { textContent: digits(v) }));
      legend.replaceChildren(make("b", { textContent: head(name, of) }), bar, make("div", { className: "ends" }, ...ends));
      if (!emulator) return;
      const reading = (text, value, of) => make("div", {}, make("span", { textContent: text }), make("b", { textContent: digits(value) + unitOf(of) }));
      readings.replaceChildren(reading("mean motion of the surface", state.mean, data.length), reading("largest motion", state.largest, data.length),
        ...cavities.map((cavity) => reading(cavity.about, volume(cavity), emulator.volume)));
      const [share, mean, most] = [(100 * state.error?.[0]) / state.mean, ...(state.error ?? [])].map((e) => digits(e, 2)), length = unitOf(data.length);
      const error = most ? `estimated error ${mean}${length} in the mean (${share} %), ${most}${length} at most` : `95 % error ${mean}${length}, root mean square over the nodes (${share} %)`;
      const told = [state.error ? error : "no estimated error", emulator.mesh, state.solved?.words].filter(Boolean);
      readings.append(...told.map((textContent) => make("p", { className: "error", textContent })));
      drawCharts();
    };
    // Camera and drawing.
    const camera = () => {
      const { yaw, pitch, zoom, shift } = state.camera;
      const back = [Math.cos(pitch) * Math.cos(yaw), Math.cos(pitch) * Math.sin(yaw), Math.sin(pitch)];
      const [right, aspect] = [[-Math.sin(yaw), Math.cos(yaw), 0], canvas.width / canvas.height];
      const up = cross(back, right);
      const distance = (radius / Math.sin(Math.atan(FIELD * Math.min(1, aspect)))) * zoom;
      const eye = centre.map((x, i) => x - shift[0] * right[i] - shift[1] * up[i] + distance * back[i]);
      const [near, far] = [Math.max(distance - 3 * radius, 0.02 * radius), distance + 3 * radius];
      const world = [...right.flatMap((x, i) => [x, up[i], back[i], 0]), -dot(right, eye), -dot(up, eye), -dot(back, eye), 1];
      const lens = [1 / (FIELD * aspect), 0, 0, 0, 0, 1 / FIELD, 0, 0, 0, 0, (near + far) / (near - far), -1, 0, 0, (2 * near * far) / (near - far), 0];
      const view = world.map((_, i) => [0, 1, 2, 3].reduce((sum, k) => sum + lens[4 * k + (i % 4)] * world[4 * (i >> 2) + k], 0));
      return { view, eye, right, up, back, distance };
    };
    const tint = (name) => rgb(getComputedStyle(root).getPropertyValue(name).trim().slice(1)).map((x) => x / 255);
    const words = () => (emulator ? parameters.map((p, i) => `${p.name} ${digits(own(i))}${unitOf(p.unit)}`).join(", ") : shown[state.chosen].title);
    const draw = () => {
      if (state.stale) {
        evaluate(); fill(); tell();
        canvas.setAttribute("aria-label", `${data.title || "body"}, ${quantities[state.quantity].name}, ${words()}`);
        state.stale = false;
      }
      const [{ view, eye, right, up }, whole] = [camera(), [0, 0, 0, 1]];
      const cut = state.cut ? [...state.normal, dot(state.normal, centre) + radius * (1 - 2 * state.cut)] : whole;
      const [lines, ratio] = [[], canvas.width / (canvas.clientWidth || 1)];
      if (state.rest) lines.push(["outline", topology.sharp.length, { tint: [...tint("--dim"), 0.75], width: 1.2 * ratio, cut: whole }]);
      if (state.fibres) lines.push(["fibres", fibres.triangles.length, { tint: [...tint("--fibre"), 0.85], width: 1.5 * ratio, cut }]);
      paint.draw({ view, eye, right, up, cut, inside: tint("--inside"), edges: state.edges ? 1 : 0 }, 3 * faces, lines);
    };
    let waiting = 0; const refresh = (stale = false) => {
      state.stale ||= stale;
      waiting ||= requestAnimationFrame((now) => {
        waiting = 0;
        if (state.playing) setShare(state.active, 0.5 - 0.5 * Math.cos((now - state.playing) / BEAT));
        draw();
      });
    };
    // Sliders, or a list of cases.
    const sliders = parameters.map((p, index) => {
      const [about, [low, high]] = [head(p.name, p.unit), range(p)];
      const slider = make("input", { type: "range", min: 0, max: 1, step: 0.005, label: about });
      const number = make("input", { type: "number", min: low, max: high, step: "any", label: `${about} as a number` });
      slider.addEventListener("input", () => { stop(); setShare(index, +slider.value); });
      number.addEventListener("change", () => {
        const typed = number.valueAsNumber, share = shareTyped(p, typed);
        stop(); setShare(index, share >= 0 ? share : state.shares[index]);
        if (typed === clamp(typed, low, high)) number.value = typed; // All digits, which the body is at.
      });
      rows.append(make("label", {}, make("span", { textContent: p.name, title: `${about}, ${digits(low)} to ${digits(high)}` }), slider, number, make("small", { textContent: unitOf(p.unit) })));
      return { slider, number };
    });
    const setShare = (index, share) => {
      [state.shares[index], state.active, state.solved] = [share, index, null];
      const text = digits(own(index), 4); [sliders[index].slider.value, sliders[index].number.value] = [share, text]; sliders[index].slider.setAttribute("aria-valuetext", text + unitOf(parameters[index].unit));
      refresh(true); root.dispatchEvent(new Event("moved"));
    };
    // Buttons; each tells whether it is pressed.
    const buttons = [];
    const button = (text, title, pressed, act) => {
      const made = make("button", { type: "button", textContent: text, title, label: title });
      const say = () => made.setAttribute("aria-pressed", pressed());
      made.addEventListener("click", () => { act(); buttons.forEach((say) => say()); });
      buttons.push(say); say(); return made;
    };
    const choose = (index) => { state.quantity = index; paint.palette(colours(quantities[index].source)); refresh(true); };
    const menus = quantities.map((q, index) => button(q.name, `Colour by ${q.name}`, () => state.quantity === index, () => choose(index)));
    const stop = () => { state.playing = 0; play.textContent = "▶"; play.setAttribute("aria-pressed", false); };
    const play = emulator && button("▶", "Play", () => !!state.playing, () => {
      if (state.playing) return stop();
      if (parameters[pressure].pressure) state.active = pressure;
      state.playing = performance.now() - BEAT * Math.acos(1 - 2 * clamp(state.shares[state.active])) || -1;
      play.textContent = "❚❚"; refresh();
    });
    const pick = (index) => () => { state.chosen = index; refresh(true); };
    if (shown.length > 1) rows.append(...shown.map(({ title }, index) => button(title, title, () => state.chosen === index, pick(index))));
    const toggle = (name, title) => button(name, title, () => state[name], () => { state[name] = !state[name]; refresh(); });
    const [edges, rest] = [toggle("edges", "Edges of the mesh (E)"), toggle("rest", "Outline of the body at rest (R)")];
    const fibre = strokes && toggle("fibres", "Fibres (F)");
    const again = button("⟲", "Begin again (0)", () => false, () => { state.camera = structuredClone(START); refresh(); });
    const dark = root.closest(".viewer-page") && button("◐", "Light or dark", () => false, () => {
      const { dataset } = document.documentElement;
      dataset.theme = (dataset.theme ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light")) === "dark" ? "light" : "dark"; refresh();
    });
    const knife = make("input", { type: "range", min: 0, max: 1, step: 0.01, value: 0, label: "Cut open", title: "Cut open" });
    knife.addEventListener("input", () => {
      state.normal = state.cut ? state.normal : unit([...camera().back.slice(0, 2), 0]); state.cut = +knife.value; refresh();
    });
    menu.append(...(menus.length > 1 ? menus : []));
    tools.append(...[play, fibre, edges, rest, make("label", { className: "cut", textContent: "cut" }, knife), again, dark].filter(Boolean));
    // Pointer, touch, wheel and keys.
    const pointers = new Map();
    const turn = (right, up) => Object.assign(state.camera, { yaw: state.camera.yaw - right, pitch: clamp(state.camera.pitch + up, -1.57, 1.57) });
    const zoom = (factor) => (state.camera.zoom = clamp(state.camera.zoom * factor, 0.08, 4));
    const shift = (...by) => {
      const scale = (2 * FIELD * camera().distance) / canvas.clientHeight;
      state.camera.shift = state.camera.shift.map((x, i) => x + (i ? -by[i] : by[i]) * scale);
    };
    /** The value at the foremost node near the pointer. */
    const point = (event) => {
      const [{ view }, box] = [camera(), canvas.getBoundingClientRect()];
      let [best, found] = [Infinity, -1];
      for (let n = 0; n < nodes; n++) {
        const [px, py, w] = [0, 1, 3].map((r) => dot([view[r], view[4 + r], view[8 + r]], position.subarray(3 * n, 3 * n + 3)) + view[12 + r]);
        const apart = Math.hypot((0.5 + (0.5 * px) / w) * box.width - event.offsetX, (0.5 - (0.5 * py) / w) * box.height - event.offsetY);
        if (apart < 14 && apart + (60 * w) / radius < best) [best, found] = [apart + (60 * w) / radius, n];
      }
      const { name, unit: of } = quantities[state.quantity];
      legend.firstChild.textContent = head(name, of) + (found < 0 ? "" : `, here ${digits(values[found])}`);
    };
    const on = (name, act, options) => canvas.addEventListener(name, act, options);
    on("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId); pointers.set(event.pointerId, [event.clientX, event.clientY]);
    });
    ["pointerup", "pointercancel"].forEach((name) => on(name, (event) => pointers.delete(event.pointerId)));
    on("pointermove", (event) => {
      const [now, last] = [[event.clientX, event.clientY], pointers.get(event.pointerId)];
      if (!last) return point(event);
      const [dx, dy] = [now[0] - last[0], now[1] - last[1]];
      const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
      const apart = (at) => Math.hypot(at[0] - other[0], at[1] - other[1]) || 1;
      if (other) zoom(apart(last) / apart(now));
      if (other || event.shiftKey || event.buttons === 2) shift(other ? dx / 2 : dx, other ? dy / 2 : dy);
      else turn(0.008 * dx, 0.008 * dy);
      pointers.set(event.pointerId, now); refresh();
    });
    ["contextmenu", "webglcontextlost"].forEach((name) => on(name, (event) => event.preventDefault()));
    on("webglcontextrestored", () => { paint = painter(canvas); paint.outline.fill({ from, to }); choose(state.quantity); });
    // On a page with other things the wheel scrolls until the body is clicked.
    on("wheel", (event) => { if (!dark && document.activeElement !== canvas) return; event.preventDefault(); zoom(Math.exp(0.0012 * event.deltaY)); refresh(); }, { passive: false });
    const keys = { ArrowLeft: () => turn(0.12, 0), ArrowRight: () => turn(-0.12, 0), ArrowUp: () => turn(0, -0.12), ArrowDown: () => turn(0, 0.12),
      "+": () => zoom(0.88), "-": () => zoom(1.14), 0: () => again.click(), " ": () => play?.click(), f: () => fibre?.click(), e: () => edges.click(),
      r: () => rest.click(), c: () => menus[(state.quantity + 1) % menus.length].click() };
    on("keydown", (event) => {
      const act = keys[event.key] ?? keys[event.key.toLowerCase()];
      if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault(); act(); refresh();
    });
    parameters.forEach((_, index) => setShare(index, 0.5));
    state.active = pressure; choose(0);
    new ResizeObserver(() => {
      const ratio = Math.min(devicePixelRatio || 1, 2);
      [canvas.width, canvas.height] = [canvas.clientWidth, canvas.clientHeight].map((size) => Math.max(1, Math.round(size * ratio)));
      draw();
    }).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => refresh());
    sinewViewer.views.push({ data, state, root, canvas, model, draw, evaluate, refresh, setShare, digits });
  };
  document.querySelectorAll(".viewer").forEach(start);
})();
