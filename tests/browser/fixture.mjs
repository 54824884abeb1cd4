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
export function drive({ count = 301, swing = 1.2, contact = false, origin = null } = {}) {
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
  const believed = (values, size) => values.map((value, tick) => value + size * Math.sin(tick / 17));
  return {
    truth: { x, y, heading },
    raw: {
      dt_s: 0.1,
      map_id: "hall",
      footprint: [[0.45, 0.25], [-0.35, 0.25], [-0.35, -0.25], [0.45, -0.25]],
      start: { x: x[0], y: y[0], heading: heading[0] },
      goals: [{ tick: 0, x: x[last] + 0.1, y: y[last] }],
      goal_tolerance_m: 0.25,
      unknown: [{ disc: { x: 6.2, y: 5.1, r: 0.5 } }, { polygon: [[10, 1], [11, 1.2], [10.9, 2.2], [9.9, 2]] }],
      robot: { x: deltas(x), y: deltas(y), heading: deltas(heading), v: deltas(speed), w: deltas(turn) },
      belief: { x: deltas(believed(x, 0.12)), y: deltas(believed(y, 0.09)), heading: deltas(believed(heading, 0.05)) },
      movers: [
        { shape: { disc: { x: 0, y: 0, r: 0.3 } }, x: deltas(ticks.map((tick) => 16 - 0.05 * tick)), y: deltas(ticks.map(() => 3.3)), heading: deltas(ticks.map(() => 3.14)) },
        { shape: { polygon: [[0.6, 0.3], [-0.6, 0.3], [-0.6, -0.3], [0.6, -0.3]] }, from_tick: 40,
          x: deltas(ticks.slice(40).map(() => 14)), y: deltas(ticks.slice(40).map((tick) => 1 + 0.02 * tick)), heading: deltas(ticks.slice(40).map(() => 1.57)) },
      ],
      sensed: ticks.filter((tick) => tick % 10 === 0).map((tick) => [tick, [[16000 - 50 * tick, 3300], [6200, 5100]]]),
      lidar: { from_rad: -1.2, step_rad: 2.4 / 60, scans: ticks.filter((tick) => tick % 5 === 0).map((tick) => [tick, Array.from({ length: 61 }, (_, ray) => (ray % 9 ? 1500 + 900 * Math.sin(ray / 8 + tick / 40) | 0 : 0))]) },
      paths: [
        { tick: 0, points: flatDeltas([[x[0], y[0]], [6, 2.6], [9, 5], [x[last], y[last]]]) },
        { tick: 150, points: flatDeltas([[x[150], y[150]], [8, 4.6], [x[last], y[last]]]) },
      ],
      sub_goal: ticks.filter((tick) => tick % 40 === 0).map((tick) => [tick, ...milli([x[Math.min(last, tick + 40)], y[Math.min(last, tick + 40)]])]),
      states: { names: ["track", "avoid", "wait", "recover"], changes: [[0, 0], [70, 1], [120, 2], [150, 0], [200, 3], [206, 0]] },
      notes: { cap_mps: { values: ticks.map((tick) => (tick < 20 ? null : 60 + Math.round(40 * Math.cos(tick / 25)))), scale: 0.01 }, region: { values: ticks.map((tick) => (tick / 60) | 0), scale: 1 } },
      speed_max_mps: 1,
      contact: contact ? { tick: last, x: x[last] + 0.3, y: y[last], with: "dynamic" } : null,
      end: { tick: last, outcome: contact ? "collision" : "success" },
      ...(origin && { map: { ...hall(), origin }, map_id: undefined }),
    },
  };
}

function flatDeltas(list) {
  const [x, y] = [0, 1].map((axis) => deltas(list.map((point) => point[axis])));
  return x.flatMap((value, i) => [value, y[i]]);
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
