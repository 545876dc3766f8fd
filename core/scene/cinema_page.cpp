// SPDX-License-Identifier: Apache-2.0
#include "core/scene/cinema_page.h"

#include <nlohmann/json.hpp>

namespace gxy {
namespace {

// The page before and behind the table. It loads nothing but pictures: the policy in its head forbids all else.
constexpr const char* kPageBegin = R"html(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src 'self' file: data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Cinema database</title>
<style>
:root { color-scheme: light dark; --ground: #f4f5f7; --panel: #ffffff; --ink: #1b1f26; --soft: #5a6472; --line: #cdd3db; --mark: #1463c4; }
@media (prefers-color-scheme: dark) { :root { --ground: #14171c; --panel: #1e2229; --ink: #e8ebf0; --soft: #a3adba; --line: #3a414c; --mark: #6cb0ff; } }
* { box-sizing: border-box; }
html, body { height: 100%; margin: 0; }
body { display: grid; grid-template-columns: minmax(15rem, 22rem) 1fr; background: var(--ground); color: var(--ink); font: 15px/1.4 system-ui, sans-serif; }
#controls { overflow: auto; padding: 1rem 1.1rem; background: var(--panel); border-right: 1px solid var(--line); }
h1 { margin: 0; font-size: 1.15rem; overflow-wrap: anywhere; }
#size { margin: .1rem 0 1rem; color: var(--soft); }
.axis { display: grid; grid-template-columns: 1fr auto auto; gap: .2rem .6rem; align-items: baseline; margin-bottom: .9rem; }
.axis label { font-weight: 600; overflow-wrap: anywhere; }
.axis output { font-variant-numeric: tabular-nums; overflow-wrap: anywhere; }
.axis input { grid-row: 2; grid-column: 1 / -1; width: 100%; margin: 0; accent-color: var(--mark); }
.axis button { grid-row: 1; grid-column: 3; }
button, select { font: inherit; color: inherit; background: var(--ground); border: 1px solid var(--line); border-radius: .3rem; padding: 0 .5rem; }
button { min-width: 2.2rem; }
#file { margin-bottom: 1rem; }
:focus-visible { outline: 2px solid var(--mark); outline-offset: 2px; }
#said { min-height: 1.4em; color: var(--soft); }
kbd { border: 1px solid var(--line); border-radius: .2rem; padding: 0 .25rem; font-size: .85em; }
#help { color: var(--soft); font-size: .9rem; }
#stage { display: grid; place-items: center; min-width: 0; min-height: 0; padding: 1rem; cursor: grab; touch-action: none; user-select: none; }
#stage img { max-width: 100%; max-height: calc(100vh - 2rem); display: block; }
#stage p { padding: 2rem; overflow-wrap: anywhere; }
@media (max-width: 640px) { body { grid-template-columns: 1fr; grid-template-rows: auto 1fr; } #controls { border-right: 0; border-bottom: 1px solid var(--line); } }
</style>
</head>
<body>
<main id="controls">
<h1 id="title"></h1>
<p id="size"></p>
<noscript><p>This page needs JavaScript. The table is data.csv, beside it.</p></noscript>
<div id="file" hidden><label>Show <select></select></label></div>
<div id="axes"></div>
<p id="said" role="status" aria-live="polite"></p>
<p id="help"><kbd>Tab</kbd> goes from control to control, <kbd>&larr;</kbd> <kbd>&rarr;</kbd> change the value of a slider, <kbd>Home</kbd> and <kbd>End</kbd> go to its ends. On the picture, arrow keys and dragging change <span id="turns"></span>. Reload for steps that came since.</p>
</main>
<div id="stage" tabindex="0" role="group" aria-label="Picture"></div>
<script type="application/json" id="table">)html";

constexpr const char* kPageEnd = R"html(</script>
<script>
"use strict";
const table = JSON.parse(document.getElementById("table").textContent);
const columns = table.columns, rows = table.rows, parameters = table.parameters;
const byId = id => document.getElementById(id);
const isNumber = text => text.trim() !== "" && !Number.isNaN(Number(text));

// The different values of each parameter: numbers ascend, texts stand in the order of the table.
const axes = [];
for (let c = 0; c < parameters; c++) {
  const values = [...new Set(rows.map(row => row[c]))];
  if (values.every(isNumber)) values.sort((a, b) => Number(a) - Number(b));
  axes.push({ name: columns[c], values, places: new Map(values.map((v, i) => [v, i])), at: 0 });
}
const keyOf = places => places.join(",");
const places = rows.map(row => axes.map((axis, c) => axis.places.get(row[c])));
const rowAt = new Map(places.map((p, r) => [keyOf(p), r]));
let file = parameters, shown = -1, player = null;

// The row at these places; if there is none, of those that agree in the parameter just changed the nearest one.
function nearestRow(wanted, changed) {
  const exact = rowAt.get(keyOf(wanted));
  if (exact !== undefined) return exact;
  let best = -1, least = Infinity;
  places.forEach((p, r) => {
    if (changed >= 0 && p[changed] !== wanted[changed]) return;
    let distance = 0;
    p.forEach((at, c) => { distance += Math.abs(at - wanted[c]) / Math.max(axes[c].values.length - 1, 1); });
    if (distance < least) { least = distance; best = r; }
  });
  return best;
}

function nameOf(row) {
  return axes.map((axis, c) => axis.name + " " + rows[row][c]).join(", ");
}

function urlOf(row) {
  return rows[row][file].split("/").map(encodeURIComponent).join("/");
}

function show(row, exact) {
  if (row < 0) return;
  shown = row;
  axes.forEach((axis, c) => {
    axis.at = places[row][c];
    axis.slider.value = axis.at;
    axis.output.textContent = axis.values[axis.at];
    axis.slider.setAttribute("aria-valuetext", axis.values[axis.at]);
  });
  const stage = byId("stage"), url = urlOf(row);
  if (/\.(png|jpe?g|gif|webp|svg)$/i.test(rows[row][file])) {
    let image = stage.querySelector("img");
    if (!image) {
      image = document.createElement("img");
      image.draggable = false;
      image.onerror = () => { byId("said").textContent = "The file " + rows[shown][file] + " is missing."; };
      stage.replaceChildren(image);
    }
    image.alt = nameOf(row);
    image.src = url;
  } else {
    const text = document.createElement("p"), link = document.createElement("a");
    link.href = url;
    link.textContent = rows[row][file];
    text.append("Browsers do not show this kind of file: ", link);
    stage.replaceChildren(text);
  }
  byId("said").textContent = exact ? "" : "There is no picture of these values; this is the nearest one.";
  const query = axes.map((axis, c) => encodeURIComponent(axis.name) + "=" + encodeURIComponent(rows[row][c]));
  try { history.replaceState(null, "", "#" + query.join("&")); } catch (e) { /* some browsers refuse this to files */ }
  for (let c = 0; c < axes.length; c++)  // what is asked for next
    for (const step of [-1, 1]) {
      const wanted = places[row].slice();
      wanted[c] += step;
      const next = rowAt.get(keyOf(wanted));
      if (next !== undefined && /\.png$/i.test(rows[next][file])) new Image().src = urlOf(next);
    }
}

function choose(c, at) {
  const wanted = axes.map(axis => axis.at);
  wanted[c] = Math.min(Math.max(at, 0), axes[c].values.length - 1);
  const row = nearestRow(wanted, c);
  show(row, row >= 0 && keyOf(places[row]) === keyOf(wanted));
}

function stop() {
  if (!player) return;
  clearInterval(player.timer);
  player.button.textContent = "\u25b6";
  player.button.setAttribute("aria-pressed", "false");
  player = null;
}

function play(c, button) {
  const again = player && player.button === button;
  stop();
  if (again) return;
  button.textContent = "\u23f8";
  button.setAttribute("aria-pressed", "true");
  player = { button, timer: setInterval(() => choose(c, (axes[c].at + 1) % axes[c].values.length), 250) };
}

function makeControls() {
  byId("title").textContent = document.title = table.title;
  byId("size").textContent = rows.length + (rows.length === 1 ? " picture, " : " pictures, ") + axes.length +
    (axes.length === 1 ? " parameter" : " parameters");
  axes.forEach((axis, c) => {
    const group = document.createElement("div");
    group.className = "axis";
    const label = document.createElement("label"), output = document.createElement("output");
    const button = document.createElement("button"), slider = document.createElement("input");
    slider.type = "range";
    slider.id = "axis" + c;
    slider.min = 0;
    slider.max = axis.values.length - 1;
    slider.step = 1;
    slider.disabled = axis.values.length < 2;
    label.htmlFor = output.htmlFor = slider.id;
    label.textContent = axis.name;
    button.type = "button";
    button.textContent = "\u25b6";
    button.hidden = axis.values.length < 2;
    button.setAttribute("aria-label", "Play " + axis.name);
    button.setAttribute("aria-pressed", "false");
    button.onclick = () => play(c, button);
    slider.oninput = () => { stop(); choose(c, Number(slider.value)); };
    group.append(label, output, slider, button);
    byId("axes").append(group);
    axis.slider = slider;
    axis.output = output;
  });
  if (columns.length - parameters > 1) {
    const select = byId("file").querySelector("select");
    for (let c = parameters; c < columns.length; c++) select.append(new Option(columns[c], c));
    select.onchange = () => { file = Number(select.value); show(shown, true); };
    byId("file").hidden = false;
  }
}

// The parameters that the picture itself changes: across and up.
const across = Math.max(axes.findIndex(axis => axis.name === "phi"), 0);
let up = axes.findIndex(axis => axis.name === "theta");
if (up < 0) up = axes.length > 1 ? (across === 0 ? 1 : 0) : -1;

byId("turns").textContent = axes.length === 0 ? "nothing" : axes[across].name + (up < 0 ? "" : " and " + axes[up].name);

function turn(c, steps, around) {
  if (c < 0 || c >= axes.length || steps === 0) return;
  stop();
  const count = axes[c].values.length, at = axes[c].at + steps;
  choose(c, around && axes[c].name === "phi" ? ((at % count) + count) % count : at);
}

function makeStage() {
  const stage = byId("stage");
  stage.onkeydown = event => {
    const step = { ArrowLeft: [across, -1], ArrowRight: [across, 1], ArrowUp: [up, 1], ArrowDown: [up, -1] }[event.key];
    if (!step) return;
    event.preventDefault();
    turn(step[0], step[1], true);
  };
  let from = null;
  stage.onpointerdown = event => { from = [event.clientX, event.clientY]; stage.setPointerCapture(event.pointerId); };
  stage.onpointerup = stage.onpointercancel = () => { from = null; };
  stage.onpointermove = event => {
    if (!from) return;
    const reach = 40;  // pixels for one value
    const x = Math.trunc((event.clientX - from[0]) / reach), y = Math.trunc((event.clientY - from[1]) / reach);
    if (x !== 0) { from[0] += x * reach; turn(across, -x, true); }
    if (y !== 0) { from[1] += y * reach; turn(up, y, true); }
  };
}

makeControls();
makeStage();
const wanted = axes.map(() => 0);
for (const part of location.hash.slice(1).split("&")) {
  const [name, value] = part.split("=").map(decodeURIComponent);
  const c = axes.findIndex(axis => axis.name === name);
  if (c >= 0 && axes[c].places.has(value)) wanted[c] = axes[c].places.get(value);
}
if (location.hash.length < 2)  // begin with the first row
  places[0].forEach((at, c) => { wanted[c] = at; });
show(nearestRow(wanted, -1), true);
</script>
</body>
</html>
)html";

}  // namespace

std::string cinemaPage(const CinemaTable& table, const std::string& title) {
  const nlohmann::json data{{"title", title},
                            {"columns", table.columns()},
                            {"parameters", table.parameters()},
                            {"rows", table.rows()}};
  std::string text = kPageBegin;
  for (const char c : data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace))
    text += c == '<' ? std::string("\\u003c") : std::string(1, c);  // no end of the script in a value
  return text + kPageEnd;
}

}  // namespace gxy
