// What stands around the bodies: light, floor, axes and the tip's trail; and the camera that sees it all.
// Points are in the world frame W (z up); three.js and its camera have y up: (x, y, z) becomes (x, z, -y).
"use strict";
const THREE = MeshCat.THREE;

const AXES = 0.16; // of the extent: the axes of W
const ARROW = 0.22; // of the extent: the longest arrow, for which every view leaves room

function add(viewer, path, object) {
  viewer.set_object(["pendpin", ...path], object);
}

function addLights(viewer, extent, focus) {
  add(viewer, ["lights", "sky"], new THREE.HemisphereLight(0xffffff, 0xd8d2cc, 0.7));
  const front = new THREE.DirectionalLight(0xffffff, 0.28);
  front.position.set(1, -0.4, 0);
  add(viewer, ["lights", "front"], front);
  const sun = new THREE.DirectionalLight(0xffffff, 0.3);
  sun.position.copy(focus).add(new THREE.Vector3(0.8, -1.1, 2.5).multiplyScalar(extent));
  sun.target.position.copy(focus);
  sun.castShadow = true;
  sun.shadow.mapSize.set(2048, 2048);
  sun.shadow.radius = 4;
  const reach = 1.6 * extent;
  Object.assign(sun.shadow.camera, { left: -reach, right: reach, bottom: -reach, top: reach });
  Object.assign(sun.shadow.camera, { near: 0.1 * extent, far: 8 * extent });
  const pair = new THREE.Group(); // a light shines towards its target only if the target is in the scene
  pair.add(sun, sun.target);
  add(viewer, ["lights", "sun"], pair);
}

// 1, 2 or 5 times a power of ten.
function roundLength(length) {
  const decade = 10 ** Math.floor(Math.log10(length));
  return decade * [5, 2, 1].find((step) => step * decade <= length * 1.0001);
}

// Square cells in a plane, their lines fading away from the middle.
function grid(cell, cells) {
  const points = [];
  const colors = [];
  const put = (x, y) => {
    points.push(x * cell, y * cell, 0);
    colors.push(0.36, 0.42, 0.5, 0.42 * Math.max(0, 1 - Math.hypot(x, y) / cells) ** 1.5);
  };
  for (let i = -cells; i <= cells; i++) {
    for (let j = -cells; j < cells; j++) {
      put(i, j);
      put(i, j + 1);
      put(j, i);
      put(j + 1, i);
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
  geometry.setAttribute("color", new THREE.Float32BufferAttribute(colors, 4));
  const material = new THREE.LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false });
  return new THREE.LineSegments(geometry, material);
}

// A grid below the lowest point, with the shadows that fall on it.
function addFloor(viewer, extent, box) {
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

// The axes of W: x red, y green, z blue; returns that of z.
function addAxes(viewer, length) {
  const axes = new THREE.Group();
  axes.scale.setScalar(length); // three.js draws no arrow shorter than 0.1 mm
  [0xd64545, 0x3f9142, 0x2b6cb0].forEach((color, i) => {
    const along = new THREE.Vector3().setComponent(i, 1);
    axes.add(new THREE.ArrowHelper(along, new THREE.Vector3(), 1, color, 0.2, 0.1));
  });
  add(viewer, ["axes"], axes);
  return axes.children[2];
}

// A tube through points (flat: x, y, z, x, ...), with one ring of `sides` corners at each.
function tube(points, sides, radius) {
  const last = points.length / 3 - 1;
  const path = new THREE.Curve();
  path.getPoint = (u) => {
    const at = Math.min(last - 1, Math.floor(u * last));
    const from = new THREE.Vector3().fromArray(points, 3 * at);
    return from.lerp(new THREE.Vector3().fromArray(points, 3 * at + 3), u * last - at);
  };
  path.getPointAt = path.getPoint; // rings where the samples are, not at equal distances
  path.getTangentAt = path.getTangent;
  return new THREE.TubeGeometry(path, last, radius, sides, false);
}

// The tip's path, all of it faintly, and its last seconds strongly; returns what moves these on to time t.
function addTrail(viewer, extent, times, points) {
  const sides = 6;
  const size = around([points]).getSize(new THREE.Vector3()).length();
  const recent = tube(points, sides, 0.0034 * Math.min(extent, Math.max(size, 0.1 * extent)));
  const whole = new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(points, 3));
  const faint = new THREE.LineBasicMaterial({ color: 0x2b6cb0, transparent: true, opacity: 0.3, depthWrite: false });
  add(viewer, ["trail", "whole"], new THREE.Line(whole, faint));
  add(viewer, ["trail", "recent"], new THREE.Mesh(recent, new THREE.MeshBasicMaterial({ color: 0x2b6cb0 })));
  return (t, seconds) => {
    const first = lastBefore(times, t - seconds);
    recent.setDrawRange(6 * sides * first, 6 * sides * (lastBefore(times, t) - first));
  };
}

const GHOST_COLORS = [0x009e73, 0xcc79a7, 0x56b4e9]; // of further runs
const RUN_COLORS = ["#d9622b", "#009E73", "#b05a8a", "#3a8fc0"]; // of the first and further runs: names and curves

// The path of a further run's tip.
function addPath(viewer, points, color, i) {
  const whole = new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(points, 3));
  const faint = new THREE.LineBasicMaterial({ color, transparent: true, opacity: 0.35, depthWrite: false });
  add(viewer, ["trail", `ghost_${i}`], new THREE.Line(whole, faint));
}

// Index of the last of rising times that is not after t, or 0.
function lastBefore(times, t) {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle + 1;
    else high = middle;
  }
  return Math.max(0, low - 1);
}

// Corners of the box around objects as they stand now, flat: x, y, z, x, ...
function corners(viewer, objects) {
  viewer.scene.updateMatrixWorld(true);
  const box = new THREE.Box3();
  objects.forEach((object) => box.expandByObject(object));
  const ends = [box.min, box.max];
  if (box.isEmpty()) return [];
  return [0, 1, 2, 3, 4, 5, 6, 7].flatMap((k) => [ends[k & 1].x, -ends[(k >> 1) & 1].z, ends[k >> 2].y]);
}

// The box around clouds of points.
function around(clouds) {
  const box = new THREE.Box3();
  const point = new THREE.Vector3();
  for (const cloud of clouds) {
    for (let i = 0; i < cloud.length; i += 3) box.expandByPoint(point.fromArray(cloud, i));
  }
  return box;
}

// Where each view looks from, and its angle: with 2 degrees and from far away, sizes do not depend on the distance.
const VIEWS = {
  corner: { from: [1, -0.72, 0.27], angle: 32 },
  front: { from: [1, 0, 0], angle: 2 },
  side: { from: [0, -1, 0], angle: 2 },
  above: { from: [0, -1e-4, 1], angle: 2 },
};

// From where a swing goes across the picture: `from`, turned about z so that its angle to the swing is that to the y axis.
// Of the two such places on the near side the nearer to `from`, which stays where the path has no main direction.
function acrossSwing(points, from) {
  const { x, y } = around([points]).getCenter(new THREE.Vector3());
  let xx = 0, xy = 0, yy = 0;
  for (let i = 0; i < points.length; i += 3) {
    const [dx, dy] = [points[i] - x, points[i + 1] - y];
    xx += dx * dx, xy += dx * dy, yy += dy * dy;
  }
  if (!(Math.hypot(xx - yy, 2 * xy) > 0.5 * (xx + yy))) return from;
  const swing = Math.atan2(2 * xy, xx - yy) / 2;
  const own = Math.atan2(from[1], from[0]);
  const off = (angle) => Math.abs(Math.atan2(Math.sin(angle - own), Math.cos(angle - own)));
  const angles = [-1, 1].flatMap((side) => [swing + side * (Math.PI / 2) - own, swing + side * (Math.PI / 2) + own]);
  const best = angles.reduce((a, b) => (off(b) < off(a) ? b : a));
  const reach = Math.hypot(from[0], from[1]);
  return [reach * Math.cos(best), reach * Math.sin(best), from[2]];
}

// Put the camera of a view as near as lets every point be seen, and as much as `pad` in m around it.
function fitCamera(viewer, clouds, view, pad) {
  const camera = viewer.camera;
  const turned = (x, y, z) => new THREE.Vector3(x, z, -y);
  const target = turned(...around(clouds).getCenter(new THREE.Vector3()).toArray());
  const back = turned(...view.from).normalize();
  const right = new THREE.Vector3(0, 1, 0).cross(back).normalize();
  const above = back.clone().cross(right);
  camera.fov = view.angle;
  const tall = Math.tan((camera.fov * Math.PI) / 360) * 0.84; // room for the title and the views
  const wide = tall * Math.max(0.2, camera.aspect);
  let distance = 0;
  for (const cloud of clouds) {
    for (let i = 0; i < cloud.length; i += 3) {
      const p = turned(cloud[i], cloud[i + 1], cloud[i + 2]).sub(target);
      const across = Math.max((Math.abs(p.dot(right)) + pad) / wide, (Math.abs(p.dot(above)) + pad) / tall);
      distance = Math.max(distance, p.dot(back) + across);
    }
  }
  Object.assign(camera, { near: distance / 200, far: 20 * distance });
  camera.position.copy(target).addScaledVector(back, distance);
  viewer.controls.target.copy(target);
  viewer.controls.update();
  viewer.set_dirty();
}
