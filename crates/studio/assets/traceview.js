// One export of a tribometer: its curves, and what was understood of its columns, which can be corrected.

import { edit, get } from "./api.js";
import { timePlot } from "./plot.js";
import { alert, h, heading, table } from "./ui.js";

const ROLES = ["time", "torque", "friction_force", "friction_coefficient", "normal_force", "speed", "revolutions",
  "humidity",
  "repeat", "step", "position"];
const FRICTION = { force_n: ["friction force", "N"], torque_n_m: ["torque", "N m"],
  coefficient: ["friction coefficient", ""] };

export const readTrace = (path, calibration) => get("/api/trace", calibration ? { path, calibration } : { path });

/// Edits that make `role` the meaning of a column; null stands for a column that is not used.
function roleEdits(column, role, columns = {}) {
  const at = (key) => ["traces", "columns", key];
  const old = column.role;
  const release = old && { at: at(old), value: columns[old] === column.title ? null : "none" };
  return [release, role && { at: at(role), value: column.title }].filter(Boolean);
}

/// Draws the export at `path` into `root`. `range` and `onRange` are the averaging window and what follows its change.
export async function drawTrace(root, path, calibration, { range, onRange, signal }) {
  const trace = await readTrace(path, calibration.path);
  if (signal.aborted) return;
  const change = (column, role) => edit(calibration.path, roleEdits(column, role, calibration.values?.traces?.columns))
    .then((doc) => drawTrace(root, path, doc, { range, onRange, signal }))
    .catch((error) => root.prepend(alert(error)));
  const choice = (column) => {
    const options = ROLES.map((role) => h("option", { value: role }, role.replaceAll("_", " ")));
    const select = h("select", { "aria-label": `Role of ${column.title}`,
      onchange: () => change(column, select.value || null) },
      h("option", { value: "" }, "not used"), options);
    select.value = column.role ?? "";
    return select;
  };
  const series = trace.repeats.flatMap((repeat) => {
    const name = trace.repeats.length > 1 ? ` ${repeat.label}` : "";
    const [label, unit] = FRICTION[repeat.friction_is];
    const force = repeat.force_n && { label: `normal force${name}`, unit: "Normal force in N", x: repeat.time_s,
      y: repeat.force_n };
    const title = `${label[0].toUpperCase()}${label.slice(1)}${unit && ` in ${unit}`}`;
    return [{ label: label + name, unit: title, x: repeat.time_s, y: repeat.friction }, force].filter(Boolean);
  });
  const hasSteps = trace.error && trace.columns.some((column) => column.role === "step");
  const way = hasSteps ? "Several steps: add the file, then enter its step under Settings, Conditions."
    : "Choose the roles of the columns below.";
  const head = trace.error ? alert(trace.error, trace.columns.length > 0 && h("p", {}, way))
    : h("p", { class: "quiet" }, `${trace.samples} ${trace.samples === 1 ? "sample" : "samples"}`, trace.notes.map((note) => `; ${note}`));
  root.replaceChildren(...[heading(path, 3), head,
    series.length > 0 && timePlot(series, { title: `Friction and force of ${path} over time`, range, onRange, signal }),
    trace.columns.length > 0 && table("Columns as they were understood", ["Column", "Unit", "Role"],
      trace.columns.map((column) => [column.title, column.unit ?? "", choice(column)])),
  ].filter(Boolean));
}
