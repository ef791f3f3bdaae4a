// A panel in the page: see face.py. Python writes face, state and picture, the browser writes hand.

function make(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes))
    if (value !== undefined && value !== false) node.setAttribute(name, value === true ? "" : value);
  node.append(...children);
  return node;
}
function render({ model, el }) {
  // Shown twice, a panel still needs names of its own for each of its controls.
  const face = model.get("face"), id = face.still + Math.random().toString(36).slice(2), fields = {};
  const moves = () => model.get("hand").count || 0;  // the same however often the panel is shown
  function say(hand) {
    model.set("hand", { ...hand, count: moves() + 1, ratio: window.devicePixelRatio || 1 });
    model.save_changes();
    root.classList.add("asked");
  }
  const root = make("div", { class: "pendlab-face" });
  // The front ends take arrow keys, letters and the space bar for themselves; Notebook 7 does on the
  // way down, so that only the window comes first. With Control or Command held down their shortcuts
  // stay theirs: a student saves with a slider in hand.
  function early(event) {
    if (!root.contains(event.target) || event.ctrlKey || event.metaKey) return;
    event.stopPropagation();
    event.target.jump?.(event);
  }
  window.addEventListener("keydown", early, true);
  function row(control) {
    const name = control.name, note = make("small", { id: id + name + "why" });
    const label = make("label", { for: id + name }, control.label);
    if (control.kind === "switch") {
      const box = make("input", { type: "checkbox", id: id + name });
      box.onchange = () => say({ name, position: Number(box.checked) });
      fields[name] = { show: ([position]) => (box.checked = position), parts: [box], note };
      return make("div", { class: "knob switch" }, box, label, note);
    }
    if (control.kind === "choice") {
      const options = control.options.map((text, k) => make("option", { value: k }, text));
      const box = make("select", { id: id + name }, ...options);
      box.onchange = () => say({ name, position: Number(box.value) });
      fields[name] = { show: ([position]) => (box.value = position), parts: [box], note };
      return make("div", { class: "knob" }, label, box, note);
    }
    const range = make("input", { type: "range", id: id + name, min: 0, max: control.last, step: 1 });
    const text = make("input", { type: "text", inputmode: "decimal", class: "number",
                                 "aria-label": control.label + ", as a number" });
    const at = (k) => `calc(8px + ${k / control.last} * (100% - 16px))`;
    const ticks = control.ticks.map(([k, word]) =>
      make("span", { class: "tick", style: `left: ${at(k)}` }, word));
    const start = make("span", { class: "start", style: `left: ${at(control.start)}`,
                                 title: "where it starts" }, "\u25b2");
    const moved = () => say({ name, position: Number(range.value) });
    range[face.continuous ? "oninput" : "onchange"] = moved;
    const jumps = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10,
                    Home: -1e6, End: 1e6 };
    range.jump = (event) => {
      if (!(event.key in jumps)) return;
      event.preventDefault();
      range.value = Number(range.value) + jumps[event.key];
      moved();
    };
    text.onchange = () => say({ name, text: text.value });
    fields[name] = {
      show: ([position, written, spoken], mine) => {
        // While a hand is ahead of the kernel, the slider stays in the hand.
        if (!mine || document.activeElement !== range) range.value = position;
        if (!mine || document.activeElement !== text) text.value = written;
        range.setAttribute("aria-valuetext", spoken);
      },
      parts: [range, text],
      note,
    };
    return make("div", { class: "knob" }, label, text,
      make("span", { class: "track" }, range, make("span", { class: "ticks", "aria-hidden": "true" },
        ...ticks, start)), note);
  }
  const buttons = face.buttons.map((name) => {
    const button = make("button", { type: "button" }, name);
    button.onclick = () => say({ button: name });
    return button;
  });
  const progress = make("progress", { hidden: true, "aria-label": "progress" });
  const image = make("img", { width: face.width }), beside = make("div", { class: "beside" });
  const badge = make("span", { class: "verdict" }), words = make("div", { role: "status" });
  const table = make("div");
  const [first, ...folds] = face.groups.map(({ heading, controls }) => {
    // One width for the labels, so that the sliders stand below each other.
    const longest = Math.max(...controls.map((control) => control.label.length));
    const style = `--label: ${1 + 0.85 * Math.min(longest, 26)}ch`;
    const grid = make("div", { class: "grid", style }, ...controls.map(row));
    return heading ? make("details", {}, make("summary", {}, heading), grid) : grid;
  });
  const legend = face.legend.map((line) => make("li", {}, line));
  root.append(
    make("style", {}, `.jp-OutputArea-child:has(.${face.still}), .${face.still} { display: none }`),
    make("div", { class: "head" }, make("b", {}, face.title), badge),
    first, make("div", { class: "folds" }, ...folds),
    make("div", { class: "buttons" }, ...buttons, progress),
    make("div", { class: "views" }, image, beside), words, table,
    make("details", {}, make("summary", {}, "What is what"), make("ul", {}, ...legend)),
  );
  el.append(root);

  function show() {
    const state = model.get("state"), hand = state.count !== undefined && state.count < moves();
    for (const [name, value] of Object.entries(state.values)) fields[name].show(value, hand);
    for (const [name, field] of Object.entries(fields)) {
      const why = state.idle[name] || "";
      field.note.textContent = why;
      for (const part of field.parts) {
        part.disabled = Boolean(why);
        part.setAttribute("aria-describedby", field.note.id);
      }
    }
    badge.textContent = state.verdict ? state.verdict[0] : "";
    badge.className = "verdict " + (state.verdict ? (state.verdict[1] ? "good" : "bad") : "none");
    words.className = state.sound ? "words" : "words wrong";
    words.replaceChildren(...state.words.map((line) => make("p", {}, line)));
    const rows = state.table.map((cells, k) => make("tr", {},
      ...cells.map((cell, j) => k && j ? make("td", {}, cell) : make("th", { scope: k ? "row" : "col" }, cell))));
    table.replaceChildren(...(rows.length ? [make("table", {}, ...rows)] : []));
    image.alt = state.alt;
    root.classList.toggle("busy", Boolean(state.busy));
    root.classList.toggle("asked", hand);
    progress.hidden = !state.progress;
    if (state.progress) [progress.value, progress.max] = state.progress;
  }
  function accompany() {
    const before = beside.querySelector("details");
    beside.innerHTML = model.get("beside");
    const now = beside.querySelector("details");
    if (before && now) {  // a moving picture that was hidden or halted stays so
      now.open = before.open;
      Object.assign(now.dataset, before.dataset);
    }
    for (const still of beside.querySelectorAll("script")) {  // one that came as text does not run
      const script = make("script", {}, still.textContent);
      still.replaceWith(script);
    }
  }
  let address;
  function paint() {
    const next = URL.createObjectURL(new Blob([model.get("picture")], { type: "image/png" }));
    image.src = next;
    if (address) URL.revokeObjectURL(address);
    address = next;
  }
  model.on("change:state", show);
  model.on("change:picture", paint);
  model.on("change:beside", accompany);
  show();
  paint();
  accompany();
  if ((window.devicePixelRatio || 1) > 1) say({});
  return () => {
    model.off("change:state", show);
    model.off("change:picture", paint);
    model.off("change:beside", accompany);
    URL.revokeObjectURL(address);
    window.removeEventListener("keydown", early, true);
  };
}
export default { render };
