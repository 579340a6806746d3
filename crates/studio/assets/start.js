// Beginning a material or a design: forms that ask for a name and write the template.

import { edit, get, hashOf, load, loadFolder, materialName, measuredTable, save, state } from "./api.js";
import { make } from "./jobs.js";
import { alert, h, nameForm, parent, relative, stem } from "./ui.js";

/// Examples in the template of a calibration, beside the rows of its table. What was measured is for the user to enter.
const EXAMPLES = [["source"], ["material", "youngs_modulus_gpa"], ["material", "youngs_modulus_std_gpa"],
  ["material", "density_g_cm3"], ["surface", "persson_rms_slope"], ["specimen", "radius_mm"]];

function begin(root, label, action, value, onName) {
  const failed = h("div", {});
  const start = (name) => onName(name).catch((error) => failed.replaceChildren(alert(error)));
  root.append(nameForm(label, action, value, start), failed);
}

async function choose(paths, page) {
  await loadFolder();
  location.hash = hashOf(page, paths);
}

/// Form that writes the folder of a new material and chooses it.
export function startMaterial(root) {
  begin(root, "Name of a new material", "Start a material", "my-material", async (name) => {
    const path = `${name}/calibration.toml`;
    await make(["new", "calibration", name]);
    await edit(path, [{ at: ["name"], value: materialName(path) }, ...EXAMPLES.map((at) => ({ at, value: null }))]);
    const table = await load(`${name}/flat.csv`);
    await save(table.path, table.text.replace(/^\d.*\n/gm, ""), table.digest);
    await choose({ calibration: path }, "material");
  });
}

/// First speed and humidity that the calibration measured, for a new design.
async function firstCondition(calibration) {
  const { conditions } = await get("/api/traces", { path: calibration }).catch(() => ({ conditions: [] }));
  if (conditions[0]) return { speed_mm_s: conditions[0].speed_mm_s, humidity_pct: conditions[0].humidity_pct };
  const measured = await measuredTable(await load(calibration));
  const cell = (key) => Number(measured.rows[0][measured.titles.indexOf(key)]);
  return { speed_mm_s: cell("speed_mm_s"), humidity_pct: cell("humidity_pct") };
}

/// Form that writes a new design for the chosen calibration and chooses it.
export function startDesign(root) {
  begin(root, "Name of a new design", "Start a design", "my-design", async (name) => {
    const path = name.endsWith(".toml") ? name : `${name}.toml`;
    await make(["new", "design", path]);
    const edits = [{ at: ["name"], value: stem(path) }];
    if (state.calibration) {
      const condition = await firstCondition(state.calibration).catch(() => null);
      edits.push({ at: ["material"], value: relative(parent(path), state.calibration) });
      if (condition) edits.push({ at: ["condition"], value: condition });
    }
    await edit(path, edits);
    await choose({ design: path }, "target");
  });
}
