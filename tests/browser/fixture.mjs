// Makes a page with drives that nobody drove, by what `src/report/page/episode.rs` says of the JSON: the player is tested on every
// part that a recording can have, and on recordings that lack all they may lack. `node fixture.mjs FOLDER` writes FOLDER/fixture.html.

import { deflateRawSync } from "node:zlib";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

const page = new URL("../../src/report/page/", import.meta.url);

const pack = (value) => deflateRawSync(Buffer.from(JSON.stringify(value))).toString("base64");
const milli = (values) => values.map((value) => Math.round(value * 1000));
const deltas = (values) => milli(values).map((value, i, all) => (i ? value - all[i - 1] : value));

/** Shelves in a hall, and a corner that nobody mapped. */
function hall() {
  const [cols, rows] = [80, 48];
  const state = (col, row) => {
    if (col > 72 && row > 40) return 2;
    if (col === 0 || row === 0 || col === cols - 1 || row === rows - 1) return 1;
    return row % 10 > 4 && row % 10 < 8 && col % 20 > 5 ? 1 : 0;
  };
  const runs = [];
  for (let row = 0; row < rows; row++) {
    for (let col = 0; col < cols; col++) {
      if (runs.at(-2) === state(col, row)) runs[runs.length - 1] += 1;
      else runs.push(state(col, row), 1);
    }
  }
  return { cols, rows, resolution_m: 0.25, cells: runs };
}

/** A drive of `count` ticks along a wave; the second stack drives a flatter one. */
function drive({ count = 301, swing = 1.2, contact = false } = {}) {
  const ticks = Array.from({ length: count }, (_, tick) => tick);
  const speed = ticks.map((tick) => Math.min(1, 0.05 * tick) * (tick > 120 && tick < 150 ? 0.1 : 1));
  const [x, y, heading] = [[1], [2.5], [swing * 0.6 + 0.2]];
  for (const tick of ticks.slice(1)) {
    heading.push(swing * Math.cos(tick / 30) * 0.6 + 0.2);
    x.push(x[tick - 1] + 0.06 * speed[tick] * Math.cos(heading[tick]));
    y.push(y[tick - 1] + 0.06 * speed[tick] * Math.sin(heading[tick]));
  }
  const last = count - 1;
  const turn = heading.map((value, tick) => (tick ? (value - heading[tick - 1]) / 0.1 : 0));
  // A row's belief is of where the row before ended.
  const believed = (values, size) => values.map((_, tick) => values[Math.max(0, tick - 1)] + size * Math.sin(tick / 17));
  const every = (period, value) => ticks.filter((tick) => tick % period === 0).map(value);
  const ranges = every(5, (tick) => Array.from({ length: 61 }, (_, ray) => (ray % 9 ? Math.round(150 + 90 * Math.sin(ray / 8 + tick / 40)) : 0)));
  return {
    truth: { x, y, heading },
    raw: {
      dt_s: 0.1,
      map_id: "hall",
      footprint: [[0.45, 0.25], [-0.35, 0.25], [-0.35, -0.25], [0.45, -0.25]],
      start: { x: 1000, y: 2500, heading: milli(heading)[0] },
      goals: [{ row: 0, x: 15000, y: 9000 }, { row: 100, x: milli(x)[last] + 100, y: milli(y)[last] }],
      goal_tolerance_m: 0.25,
      unknown: [{ disc: { x: 6200, y: 5100, r: 500 } }, { polygon: [[10000, 1000], [11000, 1200], [10900, 2200], [9900, 2000]], from_row: 50 }],
      robot: { x: deltas(x), y: deltas(y), heading: deltas(heading), v: deltas(speed), w: deltas(turn) },
      clearance: deltas(ticks.map((tick) => (tick < 9 ? 1000 : 0.6 + 0.5 * Math.sin(tick / 21)))),
      belief: { x: deltas(believed(x, 0.12)), y: deltas(believed(y, 0.09)), heading: deltas(believed(heading, 0.05)) },
      movers: [
        { shape: { disc: { r: 300 } }, heading: 3142, x: deltas(ticks.map((tick) => 16 - 0.05 * tick)), y: deltas(ticks.map(() => 3.3)) },
        { shape: { polygon: [[300, 600], [-300, 600], [-300, -600], [300, -600]] }, heading: 1571, present: [[40, 400]],
          x: deltas(ticks.map(() => 14)), y: deltas(ticks.map((tick) => 1 + 0.02 * tick)) },
      ],
      seen: [[0, []], [130, [0]], [220, [0, 1]]],
      sensed: every(10, (tick) => [tick, [[16060 - 50 * tick, 3250], [13950, 1000 + 20 * tick]]]),
      grown: [[60, [5 * 4 * 80 + 23, 1, 1, 78, 1, 1], []], [200, [], [5 * 4 * 80 + 23]]],
      lidar: { first: -1200, step: 40, count: 61, every: 5, unit_mm: 10, ranges: ranges.flatMap((scan, k) => scan.map((range, ray) => range - (ranges[k - 1]?.[ray] ?? 0))) },
      paths: [path(0, [[x[0], y[0]], [6, 2.6], [9, 5], [x[last], y[last]]]), path(150, [[x[150], y[150]], [8, 4.6], [x[last], y[last]]])].filter(({ row }) => row < count),
      sub_goal: every(40, (tick) => [tick, ...milli([x[Math.min(last, tick + 40)], y[Math.min(last, tick + 40)]])]),
      states: { names: ["track", "avoid", "wait", "recover"], changes: [[0, 0], [70, 1], [120, 2], [150, 0], [200, 3], [206, 0]] },
      notes: {
        cap_mps: { values: deltas(ticks.map((tick) => 0.6 + 0.4 * Math.cos(tick / 25))), scale: 1000 },
        region: { values: deltas(ticks.map((tick) => (tick / 60) | 0)), scale: 1000 },
      },
      v_max: 1000,
      contact: contact ? { row: last, x: milli(x)[last] + 300, y: milli(y)[last], with: "dynamic" } : null,
      end: { row: last, time_s: contact ? 0.1 * last - 0.04 : 0.1 * last, outcome: contact ? "collision" : "success" },
    },
  };
}

function path(row, nodes) {
  const [x, y] = [0, 1].map((axis) => deltas(nodes.map((node) => node[axis])));
  return { row, x, y, nodes: nodes.map(milli) };
}

/** Episodes of the page, with the truth that they were made from. */
export function episodes() {
  const made = (id, world, stack, outcome, { truth, raw }, sentence, stats = {}) => ({
    truth,
    entry: {
      id, world, stack, outcome, cause: "", sentence, point: 0, episode: 0,
      command: `simrun run scenarios/hall.yaml --episode 0 --stack ${stack} --trace`,
      stats: { time_s: (raw.robot.x.length - 1) * raw.dt_s, length_m: 17.31, clearance_min_m: 0.182, ...stats },
      data: pack(raw),
    },
  });
  const least = { robot: { x: [0, 100, 100], y: [0, 0, 50], heading: [0, 0, 464] } };
  return [
    made("p0-e0-a_star+dwa", "p0-e0", "a_star+dwa", "success", drive(), "Arrived after 30.0 s, 0.18 m from the nearest obstacle at the tightest place."),
    made("p0-e0-theta_star+dwa", "p0-e0", "theta_star+dwa", "collision", drive({ count: 221, swing: 0.7, contact: true }), "Hit mover 0 at 21.96 s while it was moving.", { time_s: 21.96 }),
    made("p0-e1-a_star+dwa", "p0-e1", "a_star+dwa", "timeout", drive({ count: 601, swing: 0.9 }), "Time ran out after 60.0 s.", { length_m: null }),
    { truth: { x: [0, 0.1, 0.2], y: [0, 0, 0.05], heading: [0, 0, 0.464] }, entry: { id: "bare", data: pack(least) } },
  ];
}

export function fixture() {
  const text = (name) => readFileSync(new URL(name, page), "utf8");
  const entries = episodes().map(({ entry }) => entry);
  const inline = (value) => JSON.stringify(value).replaceAll("<", "\\u003c");
  return `<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Replay player on made-up drives</title>
<style>
body { margin: 0 auto; padding: 16px; max-width: 1600px; font-family: system-ui, sans-serif; color-scheme: light dark; background: light-dark(#fff, #14171b); color: light-dark(#1b1f24, #e8ebef) }
@media print { body { background: #fff; color: #000 } }
${text("replay.css")}
</style>
<h1>Replay player on made-up drives</h1>
<p>${entries.map(({ id }) => `<a class="episode" href="#${id}">${id}</a>`).join(" ")}</p>
<section id="replay" aria-label="Replay"></section>
<script type="application/json" id="maps">${inline({ hall: pack(hall()) })}</script>
<script type="application/json" id="episodes">${inline(entries)}</script>
<script>${text("replay.js")}
SimrunReplay.mount(document);</script>
</html>
`;
}

if (process.argv[1] === new URL(import.meta.url).pathname) {
  const folder = process.argv[2] ?? ".";
  writeFileSync(join(folder, "fixture.html"), fixture());
}
