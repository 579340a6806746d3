// Explorer: three sliders for a texture, and the chance and friction that are expected of it.

import { cancel, ended, explore, get, isEnded, newestJob, on } from "./api.js";
import { firstError } from "./jobs.js";
import { alert, button, debounce, h, heading, newId, percent, short } from "./ui.js";

const SIZES = [["width_um", "Width"], ["spacing_um", "Spacing"], ["depth_um", "Depth"]];

function knob(label, onInput) {
  const id = newId();
  const input = h("input", { id, type: "range", oninput: onInput, disabled: true });
  const output = h("output", { for: id });
  const el = h("div", { class: "knob" }, h("label", { for: id }, label), output, input);
  const show = () => {
    output.textContent = `${short(input.value, 4)} µm`;
    input.setAttribute("aria-valuetext", output.textContent);
  };
  input.addEventListener("input", show);
  const setBounds = ([from, to], value) => {
    Object.assign(input, { min: from, max: to, step: to - from > 50 ? 1 : 0.1, disabled: from === to });
    input.value = value ?? input.value;
    show();
  };
  return { el, setBounds, read: () => Number(input.value) };
}

/// Draws the explorer of the design `path`; `onPrediction` gets each answer, or null.
export function drawExplorer(root, path, signal, onPrediction) {
  const chance = h("p", { class: "chance" });
  const note = h("div", { role: "status" });
  const readings = h("dl", { class: "readings" });
  const best = button("Go to the most likely", () => { moveTo(last.best_um); ask(); }, { disabled: true });
  const knobs = SIZES.map(([, label]) => knob(label, () => ask()));
  root.append(heading("Explorer"), chance, note, ...knobs.map((one) => one.el), best, readings);
  let last = null;
  let wanted = false;
  let isBusy = false;
  let isExploring = false;
  let isOutdated = false;

  const moveTo = (sizes) => knobs.forEach((one, i) => one.setBounds(last.bounds_um[i], sizes?.[i]));
  const predict = () => get("/api/predict", { path, ...Object.fromEntries(SIZES.map(([key], i) =>
    [key, knobs[i].read()])) });

  const showAnswer = (answer) => {
    const isFirst = last === null;
    last = answer;
    best.disabled = !answer.best_um;
    moveTo(isFirst ? answer.best_um : null);
    if (isFirst && answer.best_um) wanted = true;
    chance.textContent = !answer.expected ? "No answer for this texture"
      : answer.chance === null ? ""
        : `${percent(answer.chance)} chance to be on target${answer.condition ? ", all conditions at once" : ""}`;
    const [count = null, depth_um = 0] = answer.exposures ?? [], name = answer.exposures_name;
    const rows = [["Largest local pressure", answer.peak_pressure_mpa, "MPa"],
      ["Clearance left under a cavity", answer.clearance_um, "µm"],
      ["Share of the face that is cavity", 100 * answer.areal_density, "%"],
      [`${name[0].toUpperCase()}${name.slice(1)} (depth)`, count, `(${short(depth_um)} µm)`],
      ["Laser time", answer.laser_s, "s"]];
    readings.replaceChildren(...rows.map(([name, value, unit]) => h("div", {}, h("dt", {}, name),
      h("dd", {}, value === null ? "not known" : `${short(value)} ${unit}`))));
    onPrediction(answer);
  };

  /// What is shown belongs to an earlier text of the design.
  const forget = () => {
    chance.textContent = "";
    onPrediction(null);
  };

  /// One request at a time; the newest position of the sliders is asked for last.
  const ask = async () => {
    wanted = true;
    if (isBusy) return;
    isBusy = true;
    try {
      while (wanted && !signal.aborted) {
        wanted = false;
        showAnswer(await predict());
        note.replaceChildren();
      }
    } catch (error) {
      if (error.status === 409) compute();
      else note.replaceChildren(alert(error));
    } finally {
      isBusy = false;
    }
  };

  const compute = async () => {
    if (isExploring || signal.aborted) return;
    isExploring = true;
    forget();
    note.replaceChildren(h("p", { class: "quiet" }, "Computing the table of textures. This takes some seconds."));
    // A computation that this page left goes on; if its answer is outdated, the next question says so.
    const running = newestJob("explore", path);
    const found = running && !isEnded(running) && !running.is_cancelled ? ended(running.id) : explore(path);
    const job = await found.catch((error) => ({ state: "failed", err: error.message }));
    isExploring = false;
    if (isOutdated) { isOutdated = false; return compute(); }
    if (signal.aborted || job.state === "cancelled") return note.replaceChildren();
    if (job.state === "done") return ask();
    note.replaceChildren(alert(firstError(job)));
  };

  const settle = debounce((doc) => {
    if (signal.aborted) return;
    if (doc.check.errors.length > 0) return forget();
    if (!isExploring) return ask();
    isOutdated = true;
    const running = newestJob("explore", path);
    if (running) cancel(running.id);
  }, 800);
  on("doc", (doc) => doc.path === path && settle(doc), signal);
  return { start: ask };
}
