// The forces and moments of the joints on what hangs on them, as arrows.
"use strict";

const ARROWS = { sum: 0x6b46c1, components: [0xd64545, 0x3f9142, 0x2b6cb0], moment: 0xb7791f };

// Arrows of one colour, `count` of them, with one head or two; place(i, from, along, length) puts one of them.
function arrowSet(color, count, thick, heads, opacity) {
  const look = { color, depthTest: false, transparent: true, opacity };
  const part = (geometry, order) => {
    const mesh = new THREE.InstancedMesh(geometry.translate(0, 0.5, 0), new THREE.MeshLambertMaterial(look), count);
    return Object.assign(mesh, { frustumCulled: false, renderOrder: order });
  };
  const head = 5 * thick;
  const shaft = part(new THREE.CylinderGeometry(thick, thick, 1, 12), 1);
  const cones = Array.from({ length: heads }, () => part(new THREE.ConeGeometry(2.2 * thick, 1, 16), 2));
  const up = new THREE.Vector3(0, 1, 0);
  function place(i, from, along, length) {
    const turn = new THREE.Quaternion().setFromUnitVectors(up, along);
    const tip = Math.min(head, length / heads);
    const put = (mesh, start, size) => {
      const origin = along.clone().multiplyScalar(start).add(from);
      mesh.setMatrixAt(i, new THREE.Matrix4().compose(origin, turn, size));
      mesh.instanceMatrix.needsUpdate = true;
    };
    put(shaft, 0, new THREE.Vector3(1, Math.max(0, length - tip), 1));
    cones.forEach((cone, k) => put(cone, length - (1 + 0.7 * k) * tip, new THREE.Vector3(tip / head, tip, tip / head)));
  }
  return { meshes: [shaft, ...cones], place };
}

// Adds the arrows of the bodies `places`, hidden: the force as a whole, its components along `axes` (3 by 3, columns, for
// each body), and the moment. forces and moments hold fractions of the largest (bodies, frames, 3); the objects of the
// bodies say where they are. Returns the group and what moves the arrows to time t.
function addArrows(viewer, extent, times, objects, places, axes, forces, moments) {
  const count = places.length;
  const longest = extent * Math.min(ARROW, Math.max(0.06, 0.9 / count)); // arrows of a chain stand one above the other
  const thick = Math.max(0.025 * longest, 0.0025 * extent);
  const sets = {
    sum: arrowSet(ARROWS.sum, count, thick, 1, 0.75),
    components: ARROWS.components.map((color) => arrowSet(color, count, 0.8 * thick, 1, 1)),
    moment: moments && arrowSet(ARROWS.moment, count, thick, 2, 1),
  };
  const group = new THREE.Group();
  [sets.sum, ...sets.components, sets.moment].forEach((set) => set && group.add(...set.meshes));
  group.visible = false;
  add(viewer, ["reactions"], group);

  const at = (array, body, frame, part) => {
    const i = 3 * (body * times.length + frame);
    const from = new THREE.Vector3().fromArray(array, i);
    return frame + 1 < times.length ? from.lerp(new THREE.Vector3().fromArray(array, i + 3), part) : from;
  };
  const put = (set, k, point, vector) => {
    const size = vector.length();
    const along = size ? vector.clone().divideScalar(size) : new THREE.Vector3(0, 0, 1);
    set.place(k, point, along, longest * size);
  };
  function show(t) {
    const frame = lastBefore(times, t);
    const part = frame + 1 < times.length ? (t - times[frame]) / (times[frame + 1] - times[frame]) : 0;
    places.forEach((body, k) => {
      const { position, quaternion } = objects[body];
      const force = at(forces, body, frame, part);
      put(sets.sum, k, position, force);
      axes[k].forEach((axis, i) => {
        const along = axis.clone().applyQuaternion(quaternion);
        put(sets.components[i], k, position, along.multiplyScalar(force.dot(along)));
      });
      if (sets.moment) put(sets.moment, k, position, at(moments, body, frame, part));
    });
  }
  return { group, show, longest };
}

// The columns of a 3 by 3 matrix.
function columns(matrix) {
  return [0, 1, 2].map((j) => new THREE.Vector3(...matrix.map((row) => row[j])));
}
