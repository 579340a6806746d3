// Trials in the calibration: adding a texture as a trial that is to be cut.

import { edit, load, say, state } from "./api.js";

/// Adds a `[[trial]]` with the texture of a result to the chosen calibration; resolves to its name.
export async function addTrial(design) {
  const doc = await load(state.calibration);
  const trials = doc.values?.trial ?? [];
  const names = new Set(trials.map((trial) => trial.name));
  let number = trials.length + 1;
  while (names.has(`cut-${number}`)) number++;
  const { areal_density: _areal, section_density: _section, ...pattern } = design;
  const given = Object.fromEntries(Object.entries(pattern).filter(([, value]) => value !== null));
  await edit(state.calibration, [{ at: ["trial", trials.length], value: { name: `cut-${number}`, pattern: given } }]);
  say(`cut-${number} was added to the trials of ${state.calibration}.`);
  return `cut-${number}`;
}
