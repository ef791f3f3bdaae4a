// The page round the kernel: the rig, one sample, the picture, the traces, pointer and keys.
// `rig` holds the simulator's own packed arguments; run, hold and the rest are its kernel.

// ---- the rig -----------------------------------------------------------------------------------
const floats = rows => Float64Array.from(rows);
const table = (rows, columns) => Array.from({ length: rows }, () => new Float64Array(columns));
const IDEAL = { kp: rig.kp_at, gap: 0, friction: 0, filters: false, converters: false, delay: 0, offset: 0, reference: 0, push: 0.2 };
const BENCH = { kp: rig.kp_at, gap: 1, friction: 1, filters: true, converters: true, delay: rig.delay, offset: 1, reference: 0, push: 0.2 };

function heldStill(start, options, inner) {
  // The rig at rest at the relative angles `start`; the program has not begun. `inner`: step in s.
  const x = new Float64Array(3 * N + 2 * M + 1);
  let absolute = 0;
  for (let i = 0; i < N; i++) x[i] = absolute += start[i];
  for (let j = 0; j < M; j++) x[2 * N + j] = start[j + 1];
  for (let i = 0; i < N; i++) x[2 * N + 2 * M + i] = start[i];
  const one = {
    k: 0, fell: -1, inner, law: null, plant: null, ports: null, clock: null,
    state: { x, anchor: Float64Array.from([...start, ...start.slice(1, M + 1)]),
             volts: new Float64Array(M), before: new Float64Array(M), sent: new Float64Array(M) },
    memory: Object.fromEntries(Object.entries(rig.memory).map(([name, zeros]) => [name, floats(zeros)])),
    work: table(12, 3 * N + 2 * M + 1),
    rows: { X: table(1, 2 * N), Y: table(1, N + 1), U: table(1, M), XH: table(1, 2 * N) },
    y_ref: table(1, rig.law.tracked.length),
  };
  adjust(one, options);
  return one;
}

function adjust(one, options) {
  // The same rig under other options, in the middle of a run too.
  const gears = rig.plant.gear.map(row => row.slice());
  const was = one.plant;
  for (let j = 0; j < M; j++) {
    gears[j][HALF_GAP] *= options.gap;
    gears[j][DRY] *= options.friction;
    if (was && was.gear[j][HALF_GAP] === 0 && gears[j][HALF_GAP] > 0) {  // the rotor was the joint's
      one.state.x[2 * N + j] = one.state.x[j + 1] - one.state.x[j];
      one.state.x[2 * N + M + j] = one.state.x[N + j + 1] - one.state.x[N + j];
    }
  }
  const filter = rates => rates.map(rate => options.filters ? rate : 0);
  if (was && options.filters && was.w_out[0] === 0) {
    record(0, one.state.x, one.rows.X);
    for (let i = 0; i <= N; i++) one.state.x[2 * N + 2 * M + i] = one.rows.X[0][i];
  }
  one.plant = { ...rig.plant, gear: gears, c: options.gap > 0 ? rig.plant.c : rig.stiff,
    dry: rig.plant.dry.map(torque => torque * options.friction),
    w_in: filter(rig.plant.w_in), w_out: filter(rig.plant.w_out) };
  const steps = duration => Math.ceil(duration / one.inner - 1e-9), late = steps(options.delay);
  one.clock = { dt: rig.dt, delay: options.delay, late, steps: late + steps(rig.dt - options.delay), first: 0 };
  const quantum = values => values.map(value => options.converters ? value : 0);
  one.ports = { ...rig.ports, error: [rig.offset.map(value => value * options.offset)],
    ad: quantum(rig.ports.ad), da: quantum(rig.ports.da) };
  one.law = rig.gains.length ? { ...rig.law, F: rig.gains[options.kp].F } : rig.law;
  one.y_ref[0].fill(options.reference);
}

function begin(one) {
  // The program reads its sensors once and starts from there: v = T x, at rest.
  const y = one.rows.Y[0];
  read(one.state.x, one.ports.error[0], one.ports.ad, one.plant.w_out, y);
  rig.T.forEach((row, i) => { one.memory.v[i] = row.slice(0, N).reduce((sum, t, j) => sum + t * y[j], 0); });
  one.memory.w.fill(0);
  one.k = 0;
}

function sample(one, torques) {
  // One sampling interval: the program's steps, then the plant under `torques` on the links.
  run(one.state, one.memory, one.law, one.y_ref, one.clock, one.plant, [torques], one.ports, one.work, one.rows);
  const fell = hold(one.state, one.k * rig.dt, one.clock, one.plant, torques, one.work);
  one.k += 1;
  if (fell >= 0) one.fell = fell;
}

function simulate(start, seconds, options, inner) {
  // The rows that pl.simulate returns: relative angles and rates, and voltages.
  const one = heldStill(start, options, inner), rows = [], none = new Float64Array(N);
  begin(one);
  for (let k = 0; k <= Math.round(seconds / rig.dt) && one.fell < 0; k++) {
    sample(one, none);
    rows.push([...one.rows.X[0], ...one.rows.U[0]]);
  }
  return { rows, fell: one.fell };
}

// ---- picture -----------------------------------------------------------------------------------
const $ = id => document.getElementById(id);
const svg = (parent, kind, attributes) => {
  const node = document.createElementNS("http://www.w3.org/2000/svg", kind);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  return parent.appendChild(node);
};
const total = rig.lengths.reduce((a, b) => a + b, 0), SCALE = 250 / total, GROUND = 285;
const picture = $("rig");
const shade = color => color === "#000000" ? "var(--ink)" : `color-mix(in srgb, ${color} var(--share), white)`;
const shades = rig.colors.map(shade), voltShades = rig.volt_colors.map(shade);  // paler on a dark page
const voltNames = rig.u_max.map((_, j) => `u${String.fromCharCode(0x2081 + j)}`);
const night = matchMedia("(prefers-color-scheme: dark)");
function dress() {
  // As the notebook round the frame where there is one that says, else as the reader's system.
  let lab;
  try { lab = parent.document.body.dataset.jpThemeLight; } catch { /* a frame of another site */ }
  document.documentElement.classList.toggle("dark", lab ? lab === "false" : night.matches);
}
night.addEventListener("change", dress);
dress();
picture.setAttribute("viewBox", "-190 0 380 320");
svg(picture, "line", { x1: -180, x2: 180, y1: GROUND + 8, y2: GROUND + 8, stroke: "var(--soft)", "stroke-width": 2 });
const links = rig.lengths.map((_, i) => svg(picture, "line",
  { stroke: shades[i], "stroke-width": 12 - 2 * i, "stroke-linecap": "round" }));
const hinges = rig.lengths.map((_, i) => svg(picture, "circle",
  { r: i > 0 && i <= M ? 9 : 6, fill: i > 0 && i <= M ? "var(--ink)" : "var(--paper)", stroke: "var(--ink)", "stroke-width": 2 }));
const bars = rig.u_max.map((_, j) => ({
  frame: svg(picture, "rect", { width: 80, height: 8, fill: "var(--wash)", stroke: "var(--soft)" }),
  level: svg(picture, "rect", { height: 8, fill: voltShades[j] }),
  label: svg(picture, "text", { "font-size": 11 }) }));
const pull = svg(picture, "line", { stroke: "var(--focus)", "stroke-width": 3, "stroke-dasharray": "5 4", visibility: "hidden" });
const place = new Float64Array(2 * N + 2);

function draw(one) {
  const x = one.state.x, u = one.state.before;
  place[0] = 0; place[1] = GROUND;
  for (let i = 0; i < N; i++) {
    place[2 * i + 2] = place[2 * i] + SCALE * rig.lengths[i] * Math.sin(x[i]);
    place[2 * i + 3] = place[2 * i + 1] - SCALE * rig.lengths[i] * Math.cos(x[i]);
    links[i].setAttribute("x1", place[2 * i]); links[i].setAttribute("y1", place[2 * i + 1]);
    links[i].setAttribute("x2", place[2 * i + 2]); links[i].setAttribute("y2", place[2 * i + 3]);
    links[i].setAttribute("stroke-opacity", i === chosen ? 1 : 0.75);
    hinges[i].setAttribute("cx", place[2 * i]); hinges[i].setAttribute("cy", place[2 * i + 1]);
  }
  let below = Infinity;  // bars stay in the picture and clear of each other, fallen too
  bars.forEach((bar, j) => {
    const left = Math.max(-180, Math.min(place[2 * j + 2] + 22, 30)), top = Math.min(place[2 * j + 3] - 4, below - 16);
    below = top;
    const part = 40 * Math.max(-1, Math.min(1, u[j] / rig.u_max[j]));
    bar.frame.setAttribute("x", left); bar.frame.setAttribute("y", top);
    bar.level.setAttribute("x", left + 40 + Math.min(part, 0)); bar.level.setAttribute("y", top);
    bar.level.setAttribute("width", Math.abs(part));
    bar.label.setAttribute("x", left + 84); bar.label.setAttribute("y", top + 8);
    bar.label.textContent = `${voltNames[j]} ${u[j].toFixed(1)} V`;
  });
}

// ---- traces ------------------------------------------------------------------------------------
const SPAN = 10, COUNT = Math.round(SPAN / rig.dt), EVERY = 4;  // s, samples, samples a point
const DASHES = ["none", "7 4", "2 3"], MARGIN = 12;  // of the shaded limits
const history = table(COUNT, N + M);
let written = 0;

function chart(box, names, colors, limited) {
  const node = box.firstElementChild, text = kind => Object.assign(box.appendChild(document.createElement("span")), { className: kind });
  node.setAttribute("viewBox", "0 0 400 160");
  node.setAttribute("preserveAspectRatio", "none");
  if (limited) for (const y of [0, 160 - MARGIN])
    svg(node, "rect", { x: 0, width: 400, y, height: MARGIN, fill: "var(--line)", opacity: 0.7 });
  svg(node, "line", { x1: 0, x2: 400, y1: 80, y2: 80, stroke: "var(--line)" });
  const paths = names.map((_, i) => svg(node, "path", { fill: "none", stroke: colors[i], "stroke-width": 1.8,
    "stroke-dasharray": DASHES[i % 3], "vector-effect": "non-scaling-stroke" }));
  const top = text("top"), bottom = text("bottom"), key = text("key");
  names.forEach((name, i) => Object.assign(key.appendChild(document.createElement("i")), { textContent: name })
    .style.borderBottom = `3px ${["solid", "dashed", "dotted"][i % 3]} ${colors[i]}`);
  return { paths, top, bottom };
}

const charts = [
  chart($("angles"), rig.names, shades, false),
  chart($("volts"), voltNames, voltShades, true),
];

function trace() {
  const first = Math.max(0, written - COUNT);
  charts.forEach((one, c) => {
    const offset = c ? N : 0, count = c ? M : N;
    let limit = c ? 80 / (80 - MARGIN) : 0.05;
    if (!c) for (let k = first; k < written; k += EVERY) for (let i = 0; i < N; i++)
      while (Math.abs(history[k % COUNT][i]) > limit && limit < 1.6) limit *= 2;
    one.paths.forEach((path, i) => {
      let d = "";
      for (let k = first; k < written; k += EVERY) {
        const value = history[k % COUNT][offset + i] / (c ? rig.u_max[i] : 1);
        d += `${d ? "L" : "M"}${(400 * (k - first) / COUNT).toFixed(1)} ${(80 - 80 * value / limit).toFixed(1)}`;
      }
      path.setAttribute("d", d);
    });
    one.top.textContent = c ? "limit" : `${limit} rad`;
    one.bottom.textContent = c ? "-limit" : `-${limit} rad, last ${SPAN} s`;
  });
}

// ---- what the reader does ----------------------------------------------------------------------
const PUSH = Math.round(0.1 / rig.dt);  // samples that one push lasts
const quiet = matchMedia("(prefers-reduced-motion: reduce)");
let options = { ...BENCH }, one = null, mode = "held", paused = quiet.matches, seen = true;
let speed = 1, chosen = N - 1, grip = null, push = { way: 0, left: 0 }, due = 0, last = 0, frames = 0, told = 0;
const torques = new Float64Array(N);

function force(fx, fy, link, along) {
  // Torques on the links of a force at a point `along` m up `link`.
  for (let i = 0; i < link; i++) torques[i] += rig.lengths[i] * (fx * Math.cos(one.state.x[i]) - fy * Math.sin(one.state.x[i]));
  torques[link] += along * (fx * Math.cos(one.state.x[link]) - fy * Math.sin(one.state.x[link]));
}

function loads() {
  torques.fill(0);
  if (push.left > 0) { torques[chosen] += push.way * options.push; push.left -= 1; }
  pull.setAttribute("visibility", grip ? "visible" : "hidden");
  if (!grip) return;
  const i = grip.link, share = grip.along / rig.lengths[i];
  const px = place[2 * i] + share * (place[2 * i + 2] - place[2 * i]), py = place[2 * i + 1] + share * (place[2 * i + 3] - place[2 * i + 1]);
  const stiffness = 4 / SCALE;  // N for each pixel: 4 N/m
  force(stiffness * (grip.x - px), -stiffness * (grip.y - py), i, grip.along);
  for (const [name, value] of [["x1", px], ["y1", py], ["x2", grip.x], ["y2", grip.y]]) pull.setAttribute(name, value);
}

function advanceOne() {
  loads();
  sample(one, torques);
  const row = history[written % COUNT];
  for (let i = 0; i < N; i++) row[i] = one.rows.X[0][i];
  for (let j = 0; j < M; j++) row[N + j] = one.rows.U[0][j];
  written += 1;
  if (one.fell >= 0) change("fell");
}

function change(next) {
  if (next === "held") { one = heldStill(rig.start, options, rig.inner); written = 0; }
  if (next === "runs" && mode !== "runs") { if (mode === "fell") one = heldStill(rig.start, options, rig.inner); begin(one); written = 0; }
  mode = next;
  $("hold").setAttribute("aria-pressed", mode === "held");
  badge(); draw(one); trace(); describe();
}

function badge() {
  const [word, look] = mode === "fell" ? [`falls at ${(one.k * rig.dt).toFixed(1)} s`, "bad"]
    : mode === "held" ? ["held by hand", "still"] : paused ? ["paused", "still"] : ["balances", "good"];
  if ($("badge").textContent !== word) $("badge").textContent = word;
  $("badge").className = look;
}

function describe() {
  const lean = Array.from(one.state.x.subarray(0, N), angle => angle * 180 / Math.PI);
  const side = angle => Math.abs(angle) < 0.05 ? "upright" : `${Math.abs(angle).toFixed(1)} degrees to the ${angle > 0 ? "right" : "left"}`;
  const now = rig.u_max.map((limit, j) => `u${j + 1} ${one.state.before[j].toFixed(1)} V of ${limit} V`);
  $("words").textContent = lean.map((angle, i) => `Link ${i + 1} ${side(angle)}`).join(", ") + "; " + now.join(", ")
    + (mode === "held" ? ". Held by hand: let go, and the program takes over." : mode === "fell" ? ". A link has passed the horizontal: hold it by hand to begin again." : ".");
  $("clock").textContent = mode === "runs" ? `${(one.k * rig.dt).toFixed(1)} s` : "";
}

function frame(now) {
  requestAnimationFrame(frame);
  const passed = Math.min(now - last, 100) / 1000;
  last = now;
  frames += 1;
  if (mode !== "runs" || paused || !seen) return;
  due += passed * speed / rig.dt;
  for (; due >= 1 && mode === "runs"; due -= 1) advanceOne();
  if (quiet.matches && now - told < 500) return;
  draw(one);
  if (frames % 4 === 0 || quiet.matches) trace();
  if (now - told > 500) { told = now; describe(); }
}

function pause(value) {
  paused = value;
  $("pause").setAttribute("aria-pressed", paused);
  badge();
}

const actions = {
  start: () => { change("held"); change("runs"); pause(false); },
  hold: () => change("held"),
  go: () => { if (mode === "held") { change("runs"); pause(false); } },
  pause: () => pause(!paused),
  one: () => { if (mode === "held") change("runs"); pause(true); if (mode === "runs") { advanceOne(); draw(one); trace(); describe(); } },
};
for (const [id, act] of Object.entries(actions)) $(id).addEventListener("click", act);
$("speed").addEventListener("change", event => { speed = Number(event.target.value); });
rig.lengths.forEach((_, i) => $("link").add(new Option(`link ${i + 1}`, i, i === chosen, i === chosen)));
$("link").addEventListener("change", event => { chosen = Number(event.target.value); draw(one); });
const shove = way => { push = { way, left: PUSH }; };
for (const [id, way] of [["left", -1], ["right", 1]]) $(id).addEventListener("click", () => shove(way));

picture.addEventListener("keydown", event => {
  const digit = Number(event.key);
  if (digit >= 1 && digit <= N) { chosen = digit - 1; $("link").value = chosen; draw(one); }
  else if (event.key === "ArrowLeft" || event.key === "ArrowRight") shove(event.key === "ArrowLeft" ? -1 : 1);
  else if (event.key === " ") actions.pause();
  else if (event.key === ".") actions.one();
  else if ("hgs".includes(event.key.toLowerCase())) actions[{ h: "hold", g: "go", s: "start" }[event.key.toLowerCase()]]();
  else return;
  event.preventDefault();
});

function pointer(event) {
  const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(picture.getScreenCTM().inverse());
  return [at.x, at.y];
}
picture.addEventListener("pointerdown", event => {
  picture.focus({ preventScroll: true });
  const [x, y] = pointer(event);
  let best = null;
  for (let i = 0; i < N; i++) {
    const ax = place[2 * i], ay = place[2 * i + 1], bx = place[2 * i + 2] - ax, by = place[2 * i + 3] - ay;
    const share = Math.max(0, Math.min(1, ((x - ax) * bx + (y - ay) * by) / (bx * bx + by * by)));
    const distance = Math.hypot(x - ax - share * bx, y - ay - share * by);
    if (!best || distance < best.distance) best = { distance, link: i, along: share * rig.lengths[i] };
  }
  if (best.distance > 45) return;
  grip = { link: best.link, along: best.along, x, y };
  chosen = best.link; $("link").value = chosen;
  picture.setPointerCapture(event.pointerId);
});
picture.addEventListener("pointermove", event => { if (grip) [grip.x, grip.y] = pointer(event); });
for (const end of ["pointerup", "pointercancel"]) picture.addEventListener(end, () => { grip = null; loads(); });

function knob(name, label, steps, shown) {
  // A native range over the positions of `steps`, or a box to tick where there is none.
  const row = $("knobs").appendChild(document.createElement("label"));
  row.append(label);
  const input = row.appendChild(document.createElement("input")), out = row.appendChild(document.createElement("output"));
  const nearest = value => steps.reduce((best, step, i) => Math.abs(step - value) < Math.abs(steps[best] - value) ? i : best, 0);
  Object.assign(input, steps ? { type: "range", min: 0, max: steps.length - 1, step: 1, value: nearest(options[name]) }
    : { type: "checkbox", checked: options[name] }, { id: `knob-${name}` });
  const value = () => steps ? steps[input.value] : input.checked;
  const tell = () => { out.textContent = shown(value()); if (steps) input.setAttribute("aria-valuetext", out.textContent); };
  input.addEventListener("input", () => { options = { ...options, [name]: value() }; tell(); adjust(one, options); });
  tell();
}
const ladder = (last, count) => Array.from({ length: count + 1 }, (_, i) => last * i / count);
if (rig.gains.length) knob("kp", "gain k_p", rig.gains.map((_, i) => i), i => `${rig.gains[i].kp} V/rad`);
knob("gap", "gear gap", ladder(2, 20), f => f ? `${(1000 * 2 * f * rig.plant.gear[0][HALF_GAP]).toFixed(0)} mrad` : "none");
knob("friction", "dry friction", ladder(2, 20), f => f ? `${(f * rig.plant.gear[0][DRY]).toFixed(2)} N m` : "none");
knob("filters", "filters", null, on => on ? "on" : "off");
knob("converters", "converters", null, on => on ? "12 bits" : "exact");
knob("delay", "delay", [...ladder(rig.dt, 20), rig.delay].sort((a, b) => a - b), s => `${(1000 * s).toFixed(2)} ms`);
knob("offset", "offsets", ladder(4, 16), f => f ? `${f} x bench` : "none");
knob("push", "push", ladder(1, 50), torque => `${torque.toFixed(2)} N m`);
knob("reference", "reference", ladder(0.4, 40).map(r => r - 0.2), r => `${r.toFixed(2)} rad`);

new IntersectionObserver(entries => { seen = entries[entries.length - 1].isIntersecting; }).observe(picture);
change("held");
if (!quiet.matches) change("runs");
pause(paused);
requestAnimationFrame(frame);
