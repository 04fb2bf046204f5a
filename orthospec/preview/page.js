"use strict";
// The scene's data: commands for the viewer, bars and their ends at each place of the tool, places in words.
const scene = JSON.parse(document.getElementById("scene").textContent);
const VIEW = 40; // Of the eye, upright, in degrees.
const ROOM = 0.92; // So much of the room is filled.
const viewer = new MeshCat.Viewer(document.getElementById("meshcat-pane"));
const bytes = (text) => Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
const tell = (command) => viewer.handle_command(command);
const set = (path, property, value) => tell({type: "set_property", path: path, property: property, value: value});

for (const command of scene.commands) viewer.handle_command_bytearray(bytes(command));
for (const path of ["/Grid", "/Axes"]) set(path, "visible", false);

// The viewer would take the window's whole height, now and whenever that changes; here it has its own room.
const pane = document.getElementById("meshcat-pane");
const sized = viewer.set_3d_pane_size.bind(viewer);
viewer.set_3d_pane_size = () => {
  sized(pane.offsetWidth, pane.offsetHeight);
  if (!turned) fit();
};

// The nearest view from one side that holds the whole outline, until somebody turns it. With a point (u, v, w) to the
// right, upwards and towards the eye, and the eye at (a, b, c): |u - a| <= t (c - w), and likewise for v and b.
let turned = false;
viewer.controls.addEventListener("start", () => { turned = true; });
const dot = (p, q) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
const unit = (p) => p.map((x) => x / Math.hypot(...p));
function fit() {
  const back = unit([1.3, 0.95, 1.55]);
  const right = unit([back[2], 0, -back[0]]);
  const up = [back[1] * right[2], back[2] * right[0] - back[0] * right[2], -back[1] * right[0]];
  const slope = Math.tan((VIEW * Math.PI) / 360) * ROOM;
  const slopes = [(slope * pane.offsetWidth) / pane.offsetHeight, slope];
  // The viewer's second axis goes up, the scene's third one.
  const points = scene.outline.map(([x, y, z]) => [x, z, -y]);
  const ends = [right, up].map((way, k) =>
    [1, -1].map((sign) => Math.max(...points.map((p) => sign * dot(p, way) + slopes[k] * dot(p, back)))));
  const eye = [...ends.map(([most, least]) => (most - least) / 2),
    Math.max(...ends.map(([most, least], k) => (most + least) / (2 * slopes[k])))];
  const place = [0, 1, 2].map((k) => right[k] * eye[0] + up[k] * eye[1]);
  viewer.camera.fov = VIEW;
  viewer.controls.target.set(...place);
  viewer.camera.position.set(...place.map((x, k) => x + eye[2] * back[k]));
  viewer.set_dirty();
}
viewer.set_3d_pane_size();
set("/Lights/AmbientLight/<object>", "intensity", 0.75);

// A bar is a cylinder along y, of length 1: turned to its direction, and as long as it has to be.
function stretched(a, b) {
  const way = [0, 1, 2].map((k) => b[k] - a[k]);
  const length = Math.hypot(...way) || 1e-9;
  const along = way.map((x) => x / length);
  const least = along.map(Math.abs).indexOf(Math.min(...along.map(Math.abs)));
  const other = [0, 1, 2].map((k) => (k === least ? 1 : 0));
  const cross = (u, v) => [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  let across = cross(along, other);
  const norm = Math.hypot(...across);
  across = across.map((x) => x / norm);
  const third = cross(across, along);
  const middle = [0, 1, 2].map((k) => (a[k] + b[k]) / 2);
  return [...across, 0, ...way, 0, ...third, 0, ...middle, 1];
}

const moved = (path, place) =>
  tell({type: "set_transform", path: path, matrix: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, ...place, 1]});

const slider = document.getElementById("place");
const said = document.getElementById("pose");
const button = document.getElementById("play");

function show(frame) {
  let bar = 0;
  for (const machine of scene.frames) {
    for (const ends of machine[frame]) {
      tell({type: "set_transform", path: scene.bars[bar++], matrix: stretched(ends.slice(0, 3), ends.slice(3))});
    }
  }
  for (const tool of scene.tools) moved(tool.path, tool.places[frame]);
  for (const [path, machine, bar, end] of scene.joints) {
    moved(path, scene.frames[machine][frame][bar].slice(3 * end, 3 * end + 3));
  }
  if (said) said.value = scene.poses[frame];
  viewer.set_dirty();
}

if (slider) {
  slider.addEventListener("input", () => show(Number(slider.value)));
  show(0);
  let playing = null;
  button.addEventListener("click", () => {
    if (playing !== null) {
      clearInterval(playing);
      playing = null;
    } else {
      playing = setInterval(() => {
        slider.value = (Number(slider.value) + 1) % scene.poses.length;
        show(Number(slider.value));
      }, 60);
    }
    button.textContent = playing === null ? "Move" : "Stop";
  });
}

for (const box of document.querySelectorAll("input[data-path]")) {
  const apply = () => set("/scene/" + box.dataset.path, "visible", box.checked);
  box.addEventListener("change", () => { apply(); viewer.set_dirty(); });
  apply();
}

const chosen = document.getElementById("measure");
if (chosen) {
  const apply = () => {
    for (const option of chosen.options) {
      if (option.value) set("/scene/" + option.value, "visible", option.selected);
      const legend = document.getElementById("legend-" + option.value);
      if (legend) legend.hidden = !option.selected;
    }
    // Nothing tints the colours of values.
    set("/scene/cuboid/faces", "visible", !chosen.value);
    viewer.set_dirty();
  };
  chosen.addEventListener("change", apply);
  apply();
}

const theme = document.getElementById("theme");
const dark = window.matchMedia("(prefers-color-scheme: dark)");
function dress() {
  document.documentElement.dataset.theme = theme.value;
  const night = theme.value ? theme.value === "dark" : dark.matches;
  const colours = night ? [[0.13, 0.14, 0.16], [0.07, 0.075, 0.085]] : [[0.97, 0.975, 0.985], [0.84, 0.86, 0.89]];
  set("/Background", "top_color", colours[0]);
  set("/Background", "bottom_color", colours[1]);
  viewer.set_dirty();
}
dark.addEventListener("change", dress);
theme.addEventListener("change", dress);
dress();
document.body.dataset.ready = "yes";
