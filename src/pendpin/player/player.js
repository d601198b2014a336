// Shows the drawing embedded in this page with meshcat's viewer, and plays it with meshcat's animator.
// Points come in the world frame W (z up); three.js and the camera have y up: (x, y, z) becomes (x, z, -y).
"use strict";
(() => {
  const THREE = MeshCat.THREE;
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
  function unpack({ scale, data }) {
    return Float32Array.from(new Int16Array(bytes(data).buffer), (v) => v * scale);
  }

  const positions = unpack(drawing.positions); // bodies, frames, 3
  const quaternions = unpack(drawing.quaternions); // bodies, frames, 4
  const times = floats(drawing.times);
  const trail = floats(drawing.trail.points); // points, 3
  const trailTimes = floats(drawing.trail.times);

  function lastBefore(sorted, t) {
    let low = 0;
    let high = sorted.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (sorted[middle] <= t) low = middle + 1;
      else high = middle;
    }
    return Math.max(0, low - 1);
  }

  // ---- the scene -----------------------------------------------------------------------------------------------------

  function openViewer() {
    try {
      return new MeshCat.Viewer(element("stage"));
    } catch (error) {
      say("This page draws with WebGL, which this browser does not offer.");
      throw error;
    }
  }

  function add(viewer, path, object) {
    viewer.set_object(["pendpin"].concat(path), object);
  }

  function addLights(viewer, focus) {
    add(viewer, ["lights", "sky"], new THREE.HemisphereLight(0xffffff, 0xd8d2cc, 0.7));
    const front = new THREE.DirectionalLight(0xffffff, 0.28);
    front.position.set(1, -0.4, 0);
    add(viewer, ["lights", "front"], front);
    const sun = new THREE.DirectionalLight(0xffffff, 0.3);
    sun.position.set(focus.x + 0.8 * extent, focus.y - 1.1 * extent, focus.z + 2.5 * extent);
    sun.target.position.copy(focus);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    sun.shadow.radius = 4;
    const view = sun.shadow.camera;
    view.left = view.bottom = -1.6 * extent;
    view.right = view.top = 1.6 * extent;
    view.near = 0.1 * extent;
    view.far = 8 * extent;
    const pair = new THREE.Group(); // a light shines towards its target only if the target is in the scene
    pair.add(sun, sun.target);
    add(viewer, ["lights", "sun"], pair);
  }

  function roundLength(length) {
    const decade = 10 ** Math.floor(Math.log10(length));
    return decade * [5, 2, 1].find((step) => step * decade <= length * 1.0001);
  }

  // Grid lines that fade away from the middle.
  function grid(cell, cells) {
    const points = [];
    const colors = [];
    const put = (x, y) => {
      points.push(x * cell, y * cell, 0);
      colors.push(0.36, 0.42, 0.5, 0.42 * Math.max(0, 1 - Math.hypot(x, y) / cells) ** 1.5);
    };
    for (let i = -cells; i <= cells; i++) {
      for (let j = -cells; j < cells; j++) {
        put(i, j), put(i, j + 1);
        put(j, i), put(j + 1, i);
      }
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
    geometry.setAttribute("color", new THREE.Float32BufferAttribute(colors, 4));
    const material = new THREE.LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false });
    return new THREE.LineSegments(geometry, material);
  }

  function addFloor(viewer, box) {
    const cell = roundLength(extent / 4);
    const centre = box.getCenter(new THREE.Vector3());
    const height = box.min.z - 0.08 * extent;
    const lines = grid(cell, Math.ceil((2 * extent) / cell));
    lines.position.set(cell * Math.round(centre.x / cell), cell * Math.round(centre.y / cell), height);
    add(viewer, ["floor", "grid"], lines);
    const plane = new THREE.PlaneGeometry(8 * extent, 8 * extent);
    const shadow = new THREE.Mesh(plane, new THREE.ShadowMaterial({ opacity: 0.13 }));
    shadow.position.set(centre.x, centre.y, height - 0.001 * extent);
    shadow.receiveShadow = true;
    add(viewer, ["floor", "shadow"], shadow);
  }

  function addAxes(viewer) {
    const axes = new THREE.Group();
    const length = 0.16 * extent;
    const along = [new THREE.Vector3(1, 0, 0), new THREE.Vector3(0, 1, 0), new THREE.Vector3(0, 0, 1)];
    [0xd64545, 0x3f9142, 0x2b6cb0].forEach((color, i) => {
      const arrow = new THREE.ArrowHelper(along[i], new THREE.Vector3(), length, color, 0.2 * length, 0.1 * length);
      axes.add(arrow);
    });
    add(viewer, ["axes"], axes);
  }

  // The tip's path as two tubes: all of it faintly, and its last part up to the present strongly.
  function addTrail(viewer) {
    const count = trailTimes.length;
    if (count < 2) return () => {};
    const sides = 6;
    const whole = tube(count, sides, 0.0016 * extent);
    const recent = tube(count, sides, 0.0034 * extent);
    const faint = new THREE.MeshBasicMaterial({ color: 0x2b6cb0, transparent: true, opacity: 0.22, depthWrite: false });
    add(viewer, ["trail", "whole"], new THREE.Mesh(whole, faint));
    add(viewer, ["trail", "recent"], new THREE.Mesh(recent, new THREE.MeshBasicMaterial({ color: 0x2b6cb0 })));
    const length = Math.min(3, duration); // s
    return (t) => {
      const first = lastBefore(trailTimes, t - length);
      recent.setDrawRange(first * sides * 6, (lastBefore(trailTimes, t) - first) * sides * 6);
    };
  }

  function tube(count, sides, radius) {
    const path = new THREE.Curve();
    path.getPoint = (u) => {
      const at = Math.min(count - 2, Math.floor(u * (count - 1)));
      const from = new THREE.Vector3().fromArray(trail, 3 * at);
      return from.lerp(new THREE.Vector3().fromArray(trail, 3 * at + 3), u * (count - 1) - at);
    };
    path.getPointAt = path.getPoint; // one ring for each sample, wherever the tip hurries or lingers
    path.getTangentAt = path.getTangent;
    return new THREE.TubeGeometry(path, count - 1, radius, sides, false);
  }

  function decodeMeshes(command) {
    for (const geometry of command.object?.geometries ?? []) {
      if (geometry.base64 !== undefined) geometry.data = bytes(geometry.base64);
    }
    return command;
  }

  function bounds() {
    const box = new THREE.Box3();
    const point = new THREE.Vector3();
    for (const values of [positions, trail, drawing.fixed]) {
      for (let i = 0; i < values.length; i += 3) box.expandByPoint(point.fromArray(values, i));
    }
    return box;
  }

  // ---- the camera ----------------------------------------------------------------------------------------------------

  // Put the camera as near as lets every point of the motion be seen, looking from the front right, a little from above.
  function fit(viewer, box) {
    const camera = viewer.camera;
    const up = (x, y, z) => new THREE.Vector3(x, z, -y);
    const centre = box.getCenter(new THREE.Vector3());
    const target = up(centre.x, centre.y, centre.z);
    const back = up(1, -0.72, 0.27).normalize();
    const right = new THREE.Vector3(0, 1, 0).cross(back).normalize();
    const above = back.clone().cross(right);
    camera.fov = 32;
    const tall = Math.tan((camera.fov * Math.PI) / 360) * 0.82; // room for the bar and the title
    const wide = tall * Math.max(0.2, window.innerWidth / window.innerHeight);
    const pad = 0.06 * extent;
    let distance = extent;
    for (const values of [positions, trail, drawing.fixed]) {
      for (let i = 0; i < values.length; i += 3) {
        const p = up(values[i], values[i + 1], values[i + 2]).sub(target);
        const across = Math.max((Math.abs(p.dot(right)) + pad) / wide, (Math.abs(p.dot(above)) + pad) / tall);
        distance = Math.max(distance, p.dot(back) + across);
      }
    }
    camera.near = distance / 200;
    camera.far = distance + 20 * extent;
    camera.position.copy(target).addScaledVector(back, distance);
    viewer.controls.target.copy(target);
    viewer.controls.update();
    viewer.set_dirty();
  }

  // ---- the motion ----------------------------------------------------------------------------------------------------

  function tracks() {
    const frames = times.length;
    const one = (body, name, type, values, width) => ({
      name: `body_${body}.${name}`,
      type,
      times,
      values: values.subarray(body * frames * width, (body + 1) * frames * width),
    });
    const bodies = [...Array(drawing.bodies).keys()];
    return bodies.flatMap((body) => [
      one(body, "position", "vector3", positions, 3),
      one(body, "quaternion", "quaternion", quaternions, 4),
    ]);
  }

  function loadMotion(viewer) {
    const clip = { name: "motion", fps: 1, tracks: tracks() };
    const options = { play: true, repetitions: Infinity };
    viewer.set_animation([{ path: ["pendpin", "bodies"], clip }], options);
    viewer.animator.pause();
  }

  function controls(viewer, showTrail) {
    const animator = viewer.animator;
    const slider = element("time");
    let shown = -1;
    slider.max = duration;

    function show() {
      const t = animator.actions[0].time;
      element("play").classList.toggle("playing", animator.playing);
      if (t === shown) return;
      shown = t;
      slider.value = t;
      element("clock").textContent = `${(start + t).toFixed(2)} / ${(start + duration).toFixed(2)} s`;
      showTrail(t);
      viewer.set_dirty();
    }

    function seek(t) {
      animator.seek(Math.max(0, Math.min(duration, t)));
      animator.display_progress(animator.actions[0].time);
      show();
    }

    function toggle() {
      if (animator.playing) animator.pause();
      else animator.play();
    }

    function seekToAddress() {
      const t = parseFloat(new URLSearchParams(location.hash.slice(1)).get("t"));
      if (Number.isNaN(t)) return false;
      animator.pause();
      seek(t - start);
      return true;
    }

    element("play").addEventListener("click", toggle);
    slider.addEventListener("input", () => {
      animator.pause();
      seek(parseFloat(slider.value));
    });
    element("speed").addEventListener("change", (event) => {
      animator.mixer.timeScale = parseFloat(event.target.value);
    });
    window.addEventListener("hashchange", seekToAddress);
    window.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (event.key === " " && event.target.id !== "play") toggle();
      else if (step && event.target === document.body) seek(animator.actions[0].time + (step * duration) / 100);
      else return;
      event.preventDefault();
    });
    if (!seekToAddress()) animator.play();
    const tick = () => {
      show();
      requestAnimationFrame(tick);
    };
    tick();
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

  function main() {
    const viewer = openViewer();
    drawing.commands.map(decodeMeshes).forEach((command) => viewer.handle_command(command));
    const box = bounds();
    addLights(viewer, box.getCenter(new THREE.Vector3()));
    addFloor(viewer, box);
    addAxes(viewer);
    loadMotion(viewer);
    controls(viewer, addTrail(viewer));
    let moved = false;
    fit(viewer, box);
    viewer.controls.addEventListener("start", () => (moved = true));
    window.addEventListener("resize", () => moved || fit(viewer, box));
    if (drawing.live) watch();
  }

  main();
})();
