// Frames and angles of one joint: its axes, those of the body, arcs of theta and phi; and the joint seen closely.
"use strict";

const ARC = 28; // pieces of an arc
const TONES = { world: 0x2d3748, joint: 0x805ad5, body: [0xd64545, 0x3f9142, 0x2b6cb0], arc: 0xb7410e, steel: 0x5a6678 };

// A thin line of straight pieces that can be moved: draw(points).
function polyline(color, pieces, thick) {
  const look = new THREE.MeshBasicMaterial({ color, depthTest: false, transparent: true });
  const geometry = new THREE.CylinderGeometry(1, 1, 1, 8).translate(0, 0.5, 0);
  const mesh = Object.assign(new THREE.InstancedMesh(geometry, look, pieces), { frustumCulled: false, renderOrder: 3 });
  const up = new THREE.Vector3(0, 1, 0);
  function draw(points, width = thick) {
    for (let i = 0; i < pieces; i++) {
      const along = points[i + 1].clone().sub(points[i]);
      const length = along.length();
      const turn = new THREE.Quaternion().setFromUnitVectors(up, length ? along.divideScalar(length) : up);
      mesh.setMatrixAt(i, new THREE.Matrix4().compose(points[i], turn, new THREE.Vector3(width, length, width)));
    }
    mesh.instanceMatrix.needsUpdate = true;
  }
  return { mesh, draw };
}

// A universal joint's fork: two cheeks at the ends of a pin along x, joined by a bridge at height z = 1.7, size 1.
function fork(color) {
  const look = new THREE.MeshPhongMaterial({ color, shininess: 40 });
  const part = (geometry) => new THREE.Mesh(geometry, look);
  const pin = part(new THREE.CylinderGeometry(0.22, 0.22, 2.3, 20).rotateZ(Math.PI / 2));
  const cheeks = [-1, 1].map((side) => part(new THREE.BoxGeometry(0.22, 0.62, 1.9).translate(side * 1.05, 0, 0.75)));
  const bridge = part(new THREE.BoxGeometry(2.32, 0.62, 0.24).translate(0, 0, 1.7));
  return new THREE.Group().add(pin, ...cheeks, bridge);
}

// Letters that follow points: show(list of [text, point, colour]) at the places where a camera sees them, save in a `hole`.
function letters(parent) {
  const spans = [];
  function show(list, camera, { left, bottom, width, height }, stage, hole = { width: 0 }) {
    list.forEach(([text, point, color], i) => {
      spans[i] ??= make("span", parent);
      const { x, y, z } = new THREE.Vector3(point.x, point.z, -point.y).project(camera);
      const [right, up] = [left + ((x + 1) / 2) * width, bottom + ((y + 1) / 2) * height];
      const covered = Math.abs(right - hole.left - hole.width / 2) < hole.width / 2 && Math.abs(up - hole.bottom - hole.height / 2) < hole.height / 2;
      const seen = Math.abs(x) < 1 && Math.abs(y) < 1 && Math.abs(z) < 1 && !covered;
      Object.assign(spans[i].style, {
        display: seen ? "" : "none",
        left: `${right}px`,
        top: `${stage.clientHeight - up}px`,
        color: `#${color.toString(16).padStart(6, "0")}`,
      });
      if (spans[i].dataset.text !== text) {
        spans[i].dataset.text = text;
        spans[i].innerHTML = text;
      }
    });
    spans.slice(list.length).forEach((span) => (span.style.display = "none"));
  }
  return show;
}

// Adds all of it, hidden. `joints` as the page holds them, `objects` the bodies. Returns show(wanted), follow() after
// the bodies have moved, choose(joint), and render(), to be called after the scene has been drawn.
function addFrames(viewer, extent, joints, objects, support, stage) {
  const group = new THREE.Group();
  const model = new THREE.Group(); // of the joint
  const forks = [fork(0x8a94a3), fork(0xd9a05b)];
  model.add(...forks);
  group.add(model);
  group.visible = false;
  add(viewer, ["frames"], group);
  const thick = 0.0032 * extent;
  const lines = {
    arcs: [polyline(TONES.arc, ARC, thick), polyline(TONES.arc, ARC, thick)],
    plumb: polyline(0x8a94a3, 1, 0.5 * thick),
    turned: polyline(0x8a94a3, 1, 0.5 * thick),
    axes: [...TONES.body, ...TONES.body.map(() => TONES.joint)].map((color) => polyline(color, 1, 0.8 * thick)),
  };
  [...lines.arcs, lines.plumb, lines.turned, ...lines.axes].forEach((line) => group.add(line.mesh));
  const showLetters = letters(element("letters"));
  const showClose = letters(element("letters-close"));
  const close = new THREE.PerspectiveCamera(24, 1, 0.01, 100);
  let chosen = 0;
  let now = null; // what was drawn last

  // A ball at the joint would hide what is inside it.
  const balls = joints.map(({ body }) =>
    objects[body].children.filter((part) => part.geometry?.type === "SphereGeometry" && part.position.length() < 1e-9),
  );

  function turn(matrix, object) {
    return columns(matrix).map((axis) => (object ? axis.applyQuaternion(object.quaternion) : axis));
  }

  function follow() {
    if (!group.visible) return;
    const { body, above, axes, base, length, radius, universal } = joints[chosen];
    const object = objects[body];
    const p = object.position.clone();
    const b = turn(axes, object);
    const up = turn(base, above === null ? null : objects[above]);
    const size = Math.min(Math.max(0.022 * extent, 1.7 * radius), 0.2 * length);
    const at = (direction, distance, from = p) => direction.clone().multiplyScalar(distance).add(from);
    const reach = Math.min(0.2 * extent, 0.5 * length);
    const far = Math.min(0.5 * extent, 0.9 * length);
    const middle = universal ? at(b[2], length) : p;
    b.forEach((axis, k) => lines.axes[k].draw([middle, at(axis, 0.7 * reach, middle)]));
    now = { p, size, b, universal, words: [], inside: [] };
    const names = universal ? ["b<sub>1</sub>", "b<sub>2</sub>", "b<sub>3</sub>"] : ["x", "y", "z"];
    b.forEach((axis, k) => now.words.push([names[k], at(axis, 0.8 * reach, middle), TONES.body[k]]));
    const world = ["x<sub>W</sub>", "y<sub>W</sub>", "z<sub>W</sub>"];
    [0, 1, 2].forEach((k) => {
      const along = new THREE.Vector3().setComponent(k, 1.12 * AXES * extent);
      if (k < 2 || upward.visible) now.words.push([world[k], along, TONES.world]);
    });
    [...lines.arcs, lines.plumb, lines.turned, ...lines.axes.slice(3)].forEach(({ mesh }) => (mesh.visible = universal));
    model.visible = universal;
    if (!universal) return sayAngles("");
    const a = [up[0], b[1], up[0].clone().cross(b[1])];
    a.forEach((axis, k) => {
      lines.axes[3 + k].draw([p, at(axis, 2.6 * size)], 0.045 * size);
      now.inside.push([`a<sub>${k + 1}</sub>`, at(axis, 3.0 * size), TONES.joint]);
    });
    now.inside.push(["b<sub>3</sub>", at(b[2], 3.4 * size), TONES.body[2]]);
    const theta = Math.atan2(a[2].dot(up[1]), a[2].dot(up[2]));
    const phi = Math.atan2(b[2].dot(a[0]), b[2].dot(a[2]));
    lines.plumb.draw([p, at(up[2], far)]);
    lines.turned.draw([p, at(a[2], far)]);
    [[theta, up[2], up[1], 0.62], [phi, a[2], a[0], 0.82]].forEach(([angle, from, to, radius], i) => {
      const on = (u) => from.clone().multiplyScalar(Math.cos(u * angle)).addScaledVector(to, Math.sin(u * angle));
      lines.arcs[i].draw(Array.from({ length: ARC + 1 }, (_, k) => at(on(k / ARC), radius * far)));
      now.words.push([i ? "φ" : "θ", at(on(0.5), (radius + 0.07) * far), TONES.arc]);
    });
    const place = (object, x, z) => {
      object.quaternion.setFromRotationMatrix(new THREE.Matrix4().makeBasis(x, z.clone().cross(x), z));
      object.position.copy(p);
      object.scale.setScalar(size);
    };
    place(forks[0], a[0], up[2].clone().negate());
    place(forks[1], a[1], b[2]);
    sayAngles(`θ\u00a0${theta.toFixed(3)}\u00a0rad, φ\u00a0${phi.toFixed(3)}\u00a0rad`);
  }

  function sayAngles(text) {
    element("angles").textContent = text;
  }

  function inset() {
    const box = element("closeup").getBoundingClientRect();
    const pane = stage.getBoundingClientRect();
    return { left: box.left - pane.left, bottom: pane.bottom - box.bottom, width: box.width, height: box.height };
  }

  function render() {
    if (!group.visible || !now) return;
    const { renderer, scene, camera } = viewer;
    const pane = stage;
    const box = inset();
    showLetters(now.words, camera, { left: 0, bottom: 0, width: pane.clientWidth, height: pane.clientHeight }, stage, box);
    const back = camera.position.clone().sub(viewer.controls.target).normalize();
    const target = new THREE.Vector3(now.p.x, now.p.z, -now.p.y);
    close.aspect = box.width / box.height;
    const distance = (now.universal ? 4.2 * now.size : 0.2 * extent) / Math.tan((close.fov * Math.PI) / 360);
    Object.assign(close, { near: distance / 50, far: 50 * distance });
    close.position.copy(target).addScaledVector(back, distance);
    close.up.copy(camera.up);
    close.lookAt(target);
    close.updateProjectionMatrix();
    close.updateMatrixWorld();
    const shown = support?.visible;
    if (support) support.visible = false; // it would cover what the joint does, as would the axes of W
    upward.parent.visible = false;
    const acting = arrows?.group.visible;
    if (acting && arrows.longest > 15 * now.size) arrows.group.visible = false; // larger than all that is to be seen
    renderer.setScissorTest(true);
    renderer.setScissor(box.left, box.bottom, box.width, box.height);
    renderer.setViewport(box.left, box.bottom, box.width, box.height);
    renderer.render(scene, close);
    renderer.setScissorTest(false);
    renderer.setViewport(0, 0, pane.clientWidth, pane.clientHeight);
    if (support) support.visible = shown;
    upward.parent.visible = true;
    if (arrows) arrows.group.visible = acting;
    showClose(now.inside, close, box, stage);
  }

  function show(wanted) {
    group.visible = wanted;
    balls.flat().forEach((ball) => (ball.visible = true));
    if (wanted && joints[chosen].universal) balls[chosen].forEach((ball) => (ball.visible = false));
    ["closeup", "letters", "letters-close"].forEach((id) => (element(id).hidden = !wanted));
    follow();
  }

  function choose(joint) {
    chosen = joint;
    show(group.visible);
  }

  return { group, show, follow, choose, render };
}
