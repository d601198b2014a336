// Shows the drawing that this page holds in meshcat's viewer, and plays it.
"use strict";

const element = (id) => document.getElementById(id);
const drawing = JSON.parse(element("drawing").textContent);
const { start, duration, extent } = drawing;

function say(text) {
  element("note").textContent = text;
  element("note").hidden = false;
}

// --- what the page holds ----------------------------------------------------------------------------------------------

function bytes(text) {
  return Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
}

function floats(text) {
  return new Float32Array(bytes(text).buffer);
}

// Whole numbers of 16 bits, and what one of them is worth.
function integers({ scale, data }) {
  return Float32Array.from(new Int16Array(bytes(data).buffer), (v) => v * scale);
}

function decodeMeshes(command) {
  for (const geometry of command.object?.geometries ?? []) {
    if (geometry.base64 !== undefined) geometry.data = bytes(geometry.base64);
  }
  return command;
}

const times = floats(drawing.times); // s after the start, one for each frame
const positions = integers(drawing.positions); // bodies, frames, 3
const quaternions = integers(drawing.quaternions); // bodies, frames, 4
const trail = { times: floats(drawing.trail.times), points: integers(drawing.trail.points) };

// --- the scene --------------------------------------------------------------------------------------------------------

function openViewer(stage) {
  let viewer;
  try {
    viewer = new MeshCat.Viewer(stage);
  } catch (error) {
    say("This page draws with WebGL, which this browser does not offer.");
    throw error;
  }
  viewer.gui.domElement.remove(); // meshcat's own panel: the controls of this page stand in its place
  const fill = viewer.set_3d_pane_size.bind(viewer);
  viewer.set_3d_pane_size = () => fill(stage.clientWidth, stage.clientHeight);
  viewer.set_3d_pane_size();
  return viewer;
}

function tracks(body) {
  const part = (values) => {
    const size = values.length / drawing.bodies;
    return values.subarray(body * size, (body + 1) * size);
  };
  return [
    { name: `body_${body}.position`, type: "vector3", times, values: part(positions) },
    { name: `body_${body}.quaternion`, type: "quaternion", times, values: part(quaternions) },
  ];
}

// Give the motion to meshcat's animator, which moves the bodies to any time but does not keep time here.
function loadMotion(viewer) {
  const bodies = [...Array(drawing.bodies).keys()];
  const clip = { name: "motion", fps: 1, tracks: bodies.flatMap(tracks) }; // fps 1: times are seconds
  viewer.set_animation([{ path: ["pendpin", "bodies"], clip }], { play: true, repetitions: Infinity });
  viewer.animator.pause();
  viewer.animator.seek(0);
}

const viewer = openViewer(element("stage"));
drawing.commands.map(decodeMeshes).forEach((command) => viewer.handle_command(command));
loadMotion(viewer);
const solids = viewer.scene_tree.find(["pendpin", "bodies"]).object;
const support = solids.getObjectByName(`body_${drawing.support}`); // for a robot there is none: its base is part of it
const bodies = solids.getObjectByName("solids").children.filter((body) => body !== support);
const clouds = [[0, 0, 0.16 * extent], corners(viewer, bodies), positions, trail.points]; // with the z axis
const box = around(clouds);
addLights(viewer, extent, box.getCenter(new THREE.Vector3()));
addFloor(viewer, extent, box);
const upward = addAxes(viewer, 0.16 * extent);
const showTrail = addTrail(viewer, extent, trail.times, trail.points);
const arrows = drawing.forces && addArrows(viewer, extent, times, positions, integers(drawing.forces));
const plotTimes = floats(drawing.plots.times);
const showPlots = drawing.plots.plots.map((plot) =>
  addPlot(element("plots"), { ...plot, values: plot.values.map(floats) }, plotTimes, start, duration, seek),
);

// --- time -------------------------------------------------------------------------------------------------------------

const digits = Math.max(2, 2 - Math.floor(Math.log10(duration)));
const clock = (time) => (digits < 8 && start + duration < 1e7 ? time.toFixed(digits) : time.toExponential(3));
let t = 0; // s after the start
let playing = false;
let looping = true;
let speed = 1;

function show() {
  viewer.animator.seek(t);
  showTrail(t, 3 * speed);
  if (arrows?.group.visible) arrows.show(t);
  showPlots.forEach((showAt) => showAt(t));
  element("time").value = t;
  element("clock").textContent = `${clock(start + t)} / ${clock(start + duration)} s`;
  element("time").ariaValueText = element("clock").textContent;
  viewer.set_dirty();
}

function play(wanted) {
  if (wanted && t >= duration) t = 0;
  playing = wanted;
  element("play").classList.toggle("playing", playing);
}

function seek(time) {
  play(false);
  t = Math.max(0, Math.min(duration, time));
  show();
}

function step(count) {
  const frame = lastBefore(times, t);
  const between = count < 0 && t > times[frame] ? 1 : 0; // back to the frame that has just passed
  seek(times[Math.max(0, Math.min(times.length - 1, frame + count + between))]);
}

function pass(seconds) {
  t += seconds;
  if (t >= duration && !looping) seek(duration);
  else t %= duration;
  show();
}

function loop(wanted) {
  looping = wanted;
  element("loop").ariaPressed = looping;
}

// Real time, unless the motion would then take less than 1 s or more than 60 s.
function offerSpeeds() {
  const speeds = [0.01, 0.1, 0.25, 0.5, 1, 2, 5, 10, 50, 200];
  while (duration / speeds[0] < 1) speeds.unshift(speeds[0] / 10);
  while (duration / speeds.at(-1) > 60) speeds.push(speeds.at(-1) * 10);
  speeds.forEach((value) => element("speed").add(new Option(`${short(value)}\u00d7`, value)));
  if (duration > 60) setSpeed(speeds.find((value) => duration / value <= 60));
  else setSpeed(duration < 1 ? speeds.findLast((value) => duration / value >= 1) : 1);
}

function setSpeed(value) {
  speed = value;
  element("speed").value = value;
}

// --- views and arrows -------------------------------------------------------------------------------------------------

const views = [...document.querySelectorAll("#views button[value]")];
let view = "corner";

function look(name) {
  view = name;
  views.forEach((button) => (button.ariaPressed = button.value === name));
  if (!name) return; // the user has turned the scene
  upward.visible = name !== "above"; // there it would cover what hangs below, as would the support
  if (support) support.visible = upward.visible;
  fitCamera(viewer, clouds, VIEWS[name], 0.02 * extent + (arrows?.group.visible ? arrows.longest : 0));
}

function showReactions(wanted) {
  arrows.group.visible = wanted;
  element("reactions").ariaPressed = wanted;
  element("scale").hidden = !wanted;
  look(view); // with room for them, or without
  show();
}

// --- the user ---------------------------------------------------------------------------------------------------------

// An address that ends in #t=1.5&view=above&speed=5&reactions=on asks for these; with a time the motion stands still.
function obeyAddress() {
  const asked = new URLSearchParams(location.hash.slice(1));
  const time = parseFloat(asked.get("t"));
  if (asked.get("view") in VIEWS) look(asked.get("view"));
  if (arrows && asked.has("reactions")) showReactions(asked.get("reactions") === "on");
  if ([...element("speed").options].some((option) => option.value === asked.get("speed"))) setSpeed(+asked.get("speed"));
  if (Number.isFinite(time)) seek(time - start);
  return Number.isFinite(time);
}

const KEYS = {
  " ": () => play(!playing),
  ArrowLeft: () => step(-1),
  ArrowRight: () => step(1),
  Home: () => seek(0),
  End: () => seek(duration),
  l: () => loop(!looping),
  r: () => arrows && showReactions(!arrows.group.visible),
  1: () => look("corner"),
  2: () => look("front"),
  3: () => look("side"),
  4: () => look("above"),
};

function onKey(event) {
  const own = event.target.matches("select") || (event.key === " " && event.target.matches("button"));
  const action = KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!action || own || event.ctrlKey || event.altKey || event.metaKey) return;
  action();
  event.preventDefault();
}

function listen() {
  element("time").addEventListener("input", () => seek(parseFloat(element("time").value)));
  element("play").addEventListener("click", () => play(!playing));
  element("back").addEventListener("click", () => step(-1));
  element("on").addEventListener("click", () => step(1));
  element("loop").addEventListener("click", () => loop(!looping));
  element("speed").addEventListener("change", (event) => setSpeed(parseFloat(event.target.value)));
  element("reactions").addEventListener("click", () => showReactions(!arrows.group.visible));
  views.forEach((button) => button.addEventListener("click", () => look(button.value)));
  viewer.controls.addEventListener("start", () => look(null));
  window.addEventListener("hashchange", obeyAddress);
  window.addEventListener("keydown", onKey);
  new ResizeObserver(() => {
    viewer.set_3d_pane_size();
    if (view) look(view);
  }).observe(element("stage"));
}

// A live page says when the program that served it has ended.
async function lookForServer() {
  for (;;) {
    await new Promise((done) => setTimeout(done, 1500));
    try {
      await fetch("alive", { cache: "no-store" });
    } catch {
      say("pendpin has ended; this page plays on.");
      return;
    }
  }
}

if (drawing.notes.length) say(drawing.notes.join("\n"));
element("time").max = duration;
element("reactions").hidden = !arrows;
if (arrows) element("scale").textContent = `Joint forces; the longest arrow is ${short(drawing.forces.largest)} N`;
offerSpeeds();
VIEWS.corner.from = acrossSwing(trail.points, VIEWS.corner.from);
look("corner");
listen();
if (!obeyAddress()) play(!matchMedia("(prefers-reduced-motion: reduce)").matches);
show();
requestAnimationFrame(function tick(now, before = now) {
  if (playing) pass(((now - before) / 1000) * speed);
  requestAnimationFrame((next) => tick(next, now));
});
if (drawing.live) lookForServer();
