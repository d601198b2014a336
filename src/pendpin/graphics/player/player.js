// Shows the drawing that this page holds in meshcat's viewer, and plays it.
"use strict";

const element = (id) => document.getElementById(id);
const drawing = JSON.parse(element("drawing").textContent);
const { start, duration, extent } = drawing;
const far = Math.abs(start) > 1e5 * duration; // as seconds since 1970: times are shown after the start
const origin = far ? 0 : start;

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

// Do what a command says; a mesh that cannot be read is left out, and a note says so.
function handle(viewer, command) {
  const meshes = command.object?.geometries.filter(({ type }) => type === "_meshfile_geometry") ?? [];
  for (const mesh of meshes) if (mesh.base64 !== undefined) mesh.data = bytes(mesh.base64);
  try {
    viewer.handle_command(command);
  } catch (error) {
    for (const mesh of meshes) {
      const object = { ...command.object, geometries: [mesh], object: { type: "Group", uuid: "alone" } };
      try {
        viewer.handle_command({ type: "set_object", path: "/alone", object });
      } catch {
        drawing.notes.push(`the mesh ${mesh.name} cannot be read: it is left out`);
        Object.assign(mesh, { type: "BoxGeometry", width: 0, height: 0, depth: 0 });
      }
    }
    viewer.handle_command({ type: "delete", path: "/alone" });
    viewer.handle_command(command);
  }
}

const times = floats(drawing.times); // s after the start, one for each frame
const positions = integers(drawing.positions); // bodies, frames, 3
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

// The motion of one run for meshcat's animator.
function clipOf(motion) {
  const times = floats(motion.times);
  const parts = { position: [integers(motion.positions), "vector3"], quaternion: [integers(motion.quaternions), "quaternion"] };
  const tracks = [...Array(motion.bodies).keys()].flatMap((body) =>
    Object.entries(parts).map(([name, [values, type]]) => {
      const size = values.length / motion.bodies;
      return { name: `body_${body}.${name}`, type, times, values: values.subarray(body * size, (body + 1) * size) };
    }),
  );
  return { name: "motion", fps: 1, tracks }; // fps 1: times are seconds
}

// Give the motions to meshcat's animator, which moves the bodies to any time but does not keep time here.
function loadMotion(viewer) {
  const paths = [["pendpin", "bodies"], ...drawing.ghosts.map((_, i) => ["pendpin", `ghost_${i}`])];
  const clips = paths.map((path, i) => ({ path, clip: clipOf(i ? drawing.ghosts[i - 1] : drawing) }));
  viewer.set_animation(clips, { play: true, repetitions: Infinity });
  viewer.animator.pause();
  viewer.animator.seek(0);
}

// Another run, drawn so that the first one is seen through it.
function addGhost(viewer, { solids }, i) {
  handle(viewer, { type: "set_object", path: `/pendpin/ghost_${i}`, object: solids });
  viewer.scene_tree.find(["pendpin", `ghost_${i}`]).object.traverse((part) => {
    if (!part.material) return;
    Object.assign(part.material, { transparent: true, opacity: 0.45, depthWrite: false });
    part.castShadow = false;
  });
}

const viewer = openViewer(element("stage"));
drawing.commands.forEach((command) => handle(viewer, command));
drawing.ghosts.forEach((ghost, i) => addGhost(viewer, ghost, i));
loadMotion(viewer);
const solids = viewer.scene_tree.find(["pendpin", "bodies"]).object;
const support = solids.getObjectByName(`body_${drawing.support}`); // for a robot there is none: its base is part of it
const bodies = solids.getObjectByName("solids").children.filter((body) => body !== support);
const ghostTrails = drawing.ghosts.map(({ trail }) => integers(trail.points));
const reached = drawing.leaves ? [] : [positions, trail.points, ...ghostTrails]; // what leaves is not followed
const clouds = [[0, 0, ARROW * extent], corners(viewer, bodies), ...reached]; // with the z axis
const box = around(clouds);
addLights(viewer, extent, box.getCenter(new THREE.Vector3()));
addFloor(viewer, extent, box);
const upward = addAxes(viewer, AXES * extent);
const showTrail = addTrail(viewer, extent, trail.times, trail.points);
ghostTrails.forEach((points, i) => addPath(viewer, points, GHOST_COLORS[i], i));
const objects = [...Array(drawing.bodies).keys()].map((body) => solids.getObjectByName(`body_${body}`));
const joints = drawing.joints.filter(({ body }) => body !== null);
const arrows = drawing.forces && addReactions();
const frames = joints.length ? addFrames(viewer, extent, joints, objects, support, element("stage")) : null;
const runs = [drawing, ...drawing.ghosts].map(({ label, curves }) => ({ label, quantities: quantitiesOf(curves) }));
const plots = addPlots(element("plots"), runs, drawing.plots, firstPlots(), origin, far ? "after the start (s)" : "time (s)", duration, seek);

function addReactions() {
  const rods = joints.some(({ universal }) => universal);
  const held = rods ? joints : objects.map((_, body) => ({ body, axes: [[1, 0, 0], [0, 1, 0], [0, 0, 1]] })).filter(({ body }) => body !== drawing.support);
  const vectors = (held) => held && integers(held);
  const axes = held.map(({ axes }) => columns(axes));
  const places = held.map(({ body }) => body);
  return addArrows(viewer, extent, times, objects, places, axes, vectors(drawing.forces), vectors(drawing.moments));
}

// The plots that are seen first: of runs to be compared their distance and one position.
function firstPlots() {
  const titles = drawing.plots.map(({ title }) => title);
  const names = [...runs[0].quantities.keys()];
  const drift = names.includes("energy_drift") ? "energy_drift" : titles[0];
  if (runs.length > 1) return ["distance of the tips", drawing.plots[1]?.curves[0]?.name, drift];
  return titles.slice(0, 3);
}

// --- time -------------------------------------------------------------------------------------------------------------

const digits = Math.max(2, 2 - Math.floor(Math.log10(duration)));
const clock = (time) => (digits < 8 && origin + duration < 1e7 ? time.toFixed(digits) : time.toExponential(3));
let t = 0; // s after the start
let playing = false;
let looping = true;
let speed = 1;

function show() {
  viewer.animator.seek(t);
  showTrail(t, 3 * speed);
  if (arrows?.group.visible) arrows.show(t);
  frames?.follow();
  plots.show(t);
  element("time").value = t;
  element("clock").textContent = `${far ? "+" : ""}${clock(origin + t)} / ${clock(origin + duration)} s`;
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
  fitCamera(viewer, clouds, VIEWS[name], 0.02 * extent);
  frames?.follow();
}

function showReactions(wanted) {
  arrows.group.visible = wanted;
  element("reactions").ariaPressed = wanted;
  element("scale").hidden = !wanted;
  show();
}

// What the arrows are: the sum, its components along the axes of the body, the moment with two heads.
function nameArrows() {
  const scale = element("scale");
  const css = (color) => `#${color.toString(16).padStart(6, "0")}`;
  const names = joints.some(({ universal }) => universal) ? ["R1", "R2", "R3"] : ["along x", "along y", "along z"];
  const word = (text, color) => (make("span", scale, { textContent: text }).style.color = css(color));
  word(`Joint forces; the longest arrow is ${short(drawing.forces.largest)} N`, ARROWS.sum);
  names.forEach((name, i) => word(name, ARROWS.components[i]));
  if (drawing.moments) word(`moment (two heads), longest ${short(drawing.moments.largest)} N m`, ARROWS.moment);
}

function showFrames(wanted) {
  frames.show(wanted);
  element("frames").ariaPressed = wanted;
  show();
}

// --- the user ---------------------------------------------------------------------------------------------------------

// An address that ends in #t=1.5&view=above&speed=5&reactions=on&frames=on asks for these; with a time the motion stands still.
function obeyAddress() {
  const asked = new URLSearchParams(location.hash.slice(1));
  const time = parseFloat(asked.get("t"));
  if (asked.get("view") in VIEWS) look(asked.get("view"));
  if (arrows && asked.has("reactions")) showReactions(asked.get("reactions") === "on");
  if (frames && asked.has("frames")) showFrames(asked.get("frames") === "on");
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
  f: () => frames && showFrames(!frames.group.visible),
  "+": () => plots.zoom(0.5),
  "-": () => plots.zoom(2),
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
  element("frames").addEventListener("click", () => showFrames(!frames.group.visible));
  element("joint").addEventListener("change", () => (frames.choose(+element("joint").value), show()));
  element("closer").addEventListener("click", () => plots.zoom(0.5));
  element("wider").addEventListener("click", () => plots.zoom(2));
  element("down").addEventListener("click", () => element("report").scrollIntoView({ behavior: "smooth" }));
  views.forEach((button) => button.addEventListener("click", () => look(button.value)));
  viewer.controls.addEventListener("start", () => look(null));
  window.addEventListener("hashchange", obeyAddress);
  window.addEventListener("keydown", onKey);
  new ResizeObserver(() => {
    viewer.set_3d_pane_size();
    if (view) look(view);
    plots.redraw();
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
if (arrows) nameArrows();
element("frames").hidden = !frames;
joints.forEach(({ name }, i) => element("joint").add(new Option(name, i)));
element("closer").hidden = element("wider").hidden = !runs[0].quantities.size;
element("down").hidden = !element("report").children.length;
const paint = viewer.render.bind(viewer);
viewer.render = () => (paint(), frames?.render());
if (runs.length > 1) {
  element("ghosts").hidden = false;
  runs.forEach(({ label }, i) => markRun(make("span", element("ghosts"), { textContent: label }), i));
}
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
