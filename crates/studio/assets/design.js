// Design: the search for a texture, its report, other textures worth cutting, and the files for the laser.

import { has, hashOf, load, loadFolder, on, state } from "./api.js";
import { drawSummary } from "./form.js";
import { jobButton, make, outdated, watchResult } from "./jobs.js";
import { addTrial, calibrationOf, isMeasured, materialLine, trialOf } from "./trial.js";
import { alert, button, dimensions, fileUrl, h, heading, link, percent, reportFrame, short, stem, table,
  zipLink } from "./ui.js";

const DOWNLOADS = ["pattern.dxf", "pattern.svg", "process.toml", "scene.toml"];
const MISSED = ["cannot_be_met", "measure_again", "do_not_texture"];

/// Button that adds a texture to the trials of a calibration, or the name of the trial that it is; of a measured one
/// another sample can be cut. `calibration` is a document or null.
function cutButton(design, calibration) {
  if (!calibration) return null;
  const added = (name) => link(hashOf("trials", { calibration: calibration.path }), `Added as ${name}`);
  const known = trialOf(calibration, design);
  if (known && !isMeasured(known)) return added(known.name);
  const cut = button(known ? "I will cut this again" : "I will cut this", async () => {
    cut.disabled = true;
    try { cut.replaceWith(added(await addTrial(calibration.path, design))); }
    catch (error) { cut.disabled = false; cut.after(alert(error)); }
  });
  return known ? [added(known.name), " ", cut] : cut;
}

export function decision(result) {
  const sample = result.design ? result : result.samples?.[0];
  return h("div", { class: `decision ${MISSED.includes(result.advice) ? "missed" : ""}` },
    h("p", { class: "headline" }, result.words[0].toUpperCase() + result.words.slice(1)),
    sample?.design && h("p", {}, dimensions(sample.design),
      sample.chance === null ? "" : `; chance that a cut sample is on target: ${percent(sample.chance)}`));
}

/// Button that writes the laser's files for the texture with the number `sample` in the result in `out`, and downloads
/// them.
function laserButton(out, sample) {
  const folder = `${out}-sample-${sample}`;
  const write = button("Laser files", async () => {
    write.disabled = true;
    try {
      await make(["export", `${out}/result.json`, "--sample", String(sample), "-o", folder]);
      zipLink(folder).click();
    } catch (error) { write.after(alert(error)); }
    write.disabled = false;
  });
  return write;
}

/// Medians at the pressures of the target; where there are several conditions, each with its name.
function medians(expected) {
  const nameOf = (at) => `${short(at.speed_mm_s)} mm/s, ${short(at.humidity_pct)} %${
    at.sliding_angle_deg === undefined || at.sliding_angle_deg === null ? "" : `, ${short(at.sliding_angle_deg)}°`}`;
  const conditions = [...Map.groupBy(expected, nameOf)];
  return conditions.map(([name, loads]) => loads.map((load) => load.median.toFixed(2)).join(", ")
    + (conditions.length > 1 ? ` (${name})` : "")).join("; ");
}

/// Table of textures with their chances; `filesOf(i)` is what leads to the laser's files of a texture.
export function textures(caption, samples, calibration, filesOf) {
  const rows = samples.map((sample, i) => [dimensions(sample.design), percent(sample.chance),
    medians(sample.expected), [cutButton(sample.design, calibration) ?? "", " ", filesOf(i)]]);
  return table(caption, ["Texture", "Chance", "Expected at the pressures of the target", ""], rows);
}

export async function show(root, signal) {
  root.append(h("h1", { class: "hidden" }, "Design"));
  if (!state.design) {
    root.append(h("p", {}, "There is no design in the folder yet. ", link(hashOf("target"), "Set a target first"),
      "."));
    return;
  }
  const out = `out/${stem(state.design)}`;
  const problems = h("div", {});
  const view = h("div", {});
  const search = jobButton("Find the texture", () => ["optimize", state.design], loadFolder, signal);
  const title = heading("");
  const material = h("div", {});
  const old = outdated(state.design, `${out}/result.json`, "Find the texture again.", signal);
  root.append(title, material, problems, search, old, view);
  const doc = await load(state.design);
  const path = await calibrationOf(doc);
  let calibration = path && await load(path);
  if (signal.aborted) return;
  title.textContent = doc.values?.name ?? state.design;
  material.append(materialLine(doc, path));
  drawSummary(problems, doc, signal);
  on("doc", (now) => { if (now.path === path) calibration = now; }, signal);

  const draw = (record) => {
    const files = DOWNLOADS.filter((name) => has(`${out}/${name}`));
    view.replaceChildren(...[
      decision(record),
      record.design && h("p", {}, cutButton(record.design, calibration)),
      h("p", { class: "line" }, "Download: ", files.map((name) => link(fileUrl(`${out}/${name}`, true), name)),
        zipLink(out, "all files as zip")),
      record.others?.length > 0 && textures("Also worth cutting", record.others, calibration,
        (i) => laserButton(out, i + 2)),
      has(`${out}/report.html`) && reportFrame(`${out}/report.html`, `Report of ${record.name}`),
    ].filter(Boolean));
  };
  search.attach("optimize", state.design);
  await watchResult(out, draw, signal);
}
