// Shows the drawing that this page holds in meshcat's viewer, and plays it with meshcat's animator.
"use strict";
(() => {
  const element = (id) => document.getElementById(id);
  const drawing = JSON.parse(element("drawing").textContent);
  const { start, duration, extent } = drawing;

  function say(text) {
    element("note").textContent = text;
    element("note").hidden = false;
  }

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

  const times = floats(drawing.times); // s after the start, one for each frame
  const positions = integers(drawing.positions); // bodies, frames, 3
  const quaternions = integers(drawing.quaternions); // bodies, frames, 4
  const trail = { times: floats(drawing.trail.times), points: floats(drawing.trail.points) };

  function openViewer() {
    try {
      return new MeshCat.Viewer(element("stage"));
    } catch (error) {
      say("This page draws with WebGL, which this browser does not offer.");
      throw error;
    }
  }

  function decodeMeshes(command) {
    for (const geometry of command.object?.geometries ?? []) {
      if (geometry.base64 !== undefined) geometry.data = bytes(geometry.base64);
    }
    return command;
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

  function loadMotion(viewer) {
    const bodies = [...Array(drawing.bodies).keys()];
    const clip = { name: "motion", fps: 1, tracks: bodies.flatMap(tracks) }; // fps 1: times are seconds
    viewer.set_animation([{ path: ["pendpin", "bodies"], clip }], { play: true, repetitions: Infinity });
    viewer.animator.pause();
    viewer.animator.seek(0);
  }

  // The bar at the bottom: it moves meshcat's animator, and shows where that is.
  function controls(viewer, showTrail) {
    const animator = viewer.animator;
    const slider = element("time");
    const now = () => animator.actions[0].time;
    let shown = -1;

    function show() {
      const t = now();
      element("play").classList.toggle("playing", animator.playing);
      if (t === shown) return;
      shown = t;
      slider.value = t;
      element("clock").textContent = `${(start + t).toFixed(2)} / ${(start + duration).toFixed(2)} s`;
      showTrail(t);
      viewer.set_dirty();
    }

    function seek(t) {
      animator.pause();
      animator.seek(Math.max(0, Math.min(duration, t)));
      animator.display_progress(now());
    }

    function toggle() {
      if (animator.playing) animator.pause();
      else animator.play();
    }

    // An address that ends in #t=1.5 asks for that instant, standing still.
    function seekToAddress() {
      const t = parseFloat(new URLSearchParams(location.hash.slice(1)).get("t"));
      if (Number.isFinite(t)) seek(t - start);
      return Number.isFinite(t);
    }

    function onKey(event) {
      const step = { ArrowLeft: -0.01, ArrowRight: 0.01 }[event.key];
      if (event.key === " " && event.target === document.body) toggle();
      else if (step && event.target === document.body) seek(now() + step * duration);
      else return;
      event.preventDefault();
    }

    function tick() {
      show();
      requestAnimationFrame(tick);
    }

    const display = animator.display_progress.bind(animator);
    animator.display_progress = (t) => {
      display(t);
      show(); // here, before the frame is drawn, so that the trail ends at the tip
    };
    slider.max = duration;
    slider.addEventListener("input", () => seek(parseFloat(slider.value)));
    element("play").addEventListener("click", toggle);
    element("speed").addEventListener("change", (event) => (animator.mixer.timeScale = parseFloat(event.target.value)));
    window.addEventListener("hashchange", seekToAddress);
    window.addEventListener("keydown", onKey);
    if (!seekToAddress()) animator.play();
    tick();
  }

  function frame(viewer, clouds) {
    let moved = false;
    fitCamera(viewer, extent, clouds);
    viewer.controls.addEventListener("start", () => (moved = true));
    window.addEventListener("resize", () => moved || fitCamera(viewer, extent, clouds));
  }

  // A live page says when the program that served it has ended.
  async function watch() {
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

  const viewer = openViewer();
  drawing.commands.map(decodeMeshes).forEach((command) => viewer.handle_command(command));
  loadMotion(viewer);
  const solids = corners(viewer, viewer.scene_tree.find(["pendpin", "bodies"]).object);
  const clouds = [[0, 0, 0], solids, positions, trail.points];
  const box = around(clouds);
  addLights(viewer, extent, box.getCenter(new THREE.Vector3()));
  addFloor(viewer, extent, box);
  addAxes(viewer, extent);
  controls(viewer, addTrail(viewer, extent, trail.times, trail.points));
  frame(viewer, clouds);
  if (drawing.live) watch();
})();
