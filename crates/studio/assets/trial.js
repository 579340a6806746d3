// Trials in a calibration: adding a texture as a trial that is to be cut.

import { edit, has, hashOf, load, materialName, say } from "./api.js";
import { h, link, parent, resolve } from "./ui.js";

/// Path of the calibration that has the trials of the design `doc`: its material, or what its material was made from.
/// Null without one.
export async function calibrationOf(doc) {
  const { material } = doc.values ?? {};
  if (typeof material !== "string") return null;
  let path = resolve(parent(doc.path), material);
  if (has(path)?.kind === "material") {
    const made = (await load(path)).values?.made_from;
    path = made ? resolve(parent(path), made.calibration) : path;
  }
  return has(path)?.kind === "calibration" ? path : null;
}

/// Line with the material of the design `doc` and the calibration that has its trials.
export function materialLine(doc, calibration) {
  const { material } = doc.values ?? {};
  return h("p", {}, `Material: ${typeof material === "string" ? material : "numbers in the design file"}. Trials: `,
    calibration ? link(hashOf("trials", { calibration }), materialName(calibration)) : "none, without a calibration");
}

const sizesOf = ({ areal_density: _areal, section_density: _section, ...pattern }) => Object.entries(pattern);

export const isMeasured = (trial) => Boolean(trial.measurements || trial.traces?.length);

/// Last trial of the calibration `doc` with the texture of a result.
export function trialOf(doc, design) {
  return doc.values?.trial?.findLast(({ pattern = {} }) =>
    sizesOf(design).every(([key, value]) => JSON.stringify(pattern[key] ?? null) === JSON.stringify(value)));
}

/// Adds a `[[trial]]` with the texture of a result to the calibration at `path`, unless one waits to be measured;
/// resolves to its name.
export async function addTrial(path, design) {
  const doc = await load(path);
  const known = trialOf(doc, design);
  if (known && !isMeasured(known)) return known.name;
  const trials = doc.values?.trial ?? [];
  const names = new Set(trials.map((trial) => trial.name));
  let number = trials.length + 1;
  while (names.has(`cut-${number}`)) number++;
  const given = Object.fromEntries(sizesOf(design).filter(([, value]) => value !== null));
  await edit(path, [{ at: ["trial", trials.length], value: { name: `cut-${number}`, pattern: given } }]);
  say(`cut-${number} was added to the trials of ${path}.`);
  return `cut-${number}`;
}
