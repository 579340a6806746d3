// Design: the search for a texture, its report, other textures worth cutting, and the files for the laser.

import { has, hashOf, load, loadFolder, state } from "./api.js";
import { drawSummary } from "./form.js";
import { jobButton, outdated, watchResult } from "./jobs.js";
import { addTrial } from "./trial.js";
import { alert, button, dimensions, fileUrl, h, heading, link, percent, reportFrame, stem, table } from "./ui.js";

const DOWNLOADS = ["pattern.dxf", "pattern.svg", "process.toml", "scene.toml"];
const MISSED = ["cannot_be_met", "do_not_texture"];

/// Button that adds a texture to the trials.
export function cutButton(design) {
  const cut = button("I will cut this", async () => {
    cut.disabled = true;
    try { cut.replaceWith(link(hashOf("trials"), `Added as ${await addTrial(design)}`)); }
    catch (error) { cut.disabled = false; cut.after(alert(error)); }
  });
  return state.calibration ? cut : null;
}

export function decision(result) {
  const sample = result.design ? result : result.samples?.[0];
  return h("div", { class: `decision ${MISSED.includes(result.advice) ? "missed" : ""}` },
    h("p", { class: "headline" }, result.words[0].toUpperCase() + result.words.slice(1)),
    sample?.design && h("p", {}, dimensions(sample.design),
      sample.chance === null ? "" : `; chance that a cut sample is on target: ${percent(sample.chance)}`));
}

/// Table of textures with their chances.
export function textures(caption, samples) {
  const rows = samples.map((sample) => [dimensions(sample.design), percent(sample.chance),
    sample.expected.map((load) => load.median.toFixed(2)).join(", "), cutButton(sample.design) ?? ""]);
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
  const old = outdated(state.design, `${out}/result.json`, "Find the texture again.", signal);
  root.append(title, problems, search, old, view);
  const doc = await load(state.design);
  if (signal.aborted) return;
  title.textContent = doc.values?.name ?? state.design;
  drawSummary(problems, doc, signal);

  const draw = (record) => {
    const files = DOWNLOADS.filter((name) => has(`${out}/${name}`));
    view.replaceChildren(...[
      decision(record),
      record.design && h("p", {}, cutButton(record.design)),
      h("p", { class: "line" }, "Download: ", files.map((name) => link(fileUrl(`${out}/${name}`, true), name)),
        link(`/api/zip?${new URLSearchParams({ path: out })}`, "all files as zip", { download: `${stem(out)}.zip` })),
      record.others?.length > 0 && textures("Also worth cutting", record.others),
      has(`${out}/report.html`) && reportFrame(`${out}/report.html`, `Report of ${record.name}`),
    ].filter(Boolean));
  };
  search.attach("optimize", state.design);
  await watchResult(out, draw, signal);
}
