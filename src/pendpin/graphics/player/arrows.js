// The forces of the joints on what hangs on them, as arrows.
"use strict";

// Adds an arrow for each body, `values` holding its force as a fraction of the largest (bodies, frames, 3), at its
// origin `positions` (bodies, frames, 3); returns the arrows, hidden, and what moves them on to time t.
function addArrows(viewer, extent, times, positions, values) {
  const frames = times.length;
  const count = values.length / (3 * frames);
  const longest = extent * Math.min(0.3, Math.max(0.06, 0.9 / count)); // arrows of a chain stand one above the other
  const thick = Math.max(0.03 * longest, 0.003 * extent);
  const head = 5 * thick;
  const look = { color: 0x6b46c1, depthTest: false, transparent: true };
  const part = (geometry) => {
    const mesh = new THREE.InstancedMesh(geometry.translate(0, 0.5, 0), new THREE.MeshLambertMaterial(look), count);
    return Object.assign(mesh, { frustumCulled: false, renderOrder: 1 });
  };
  const shafts = part(new THREE.CylinderGeometry(thick, thick, 1, 12));
  const heads = part(new THREE.ConeGeometry(2.2 * thick, 1, 16));
  const group = new THREE.Group().add(shafts, heads);
  group.visible = false;
  add(viewer, ["reactions"], group);

  const up = new THREE.Vector3(0, 1, 0);
  const at = (array, body, frame, part) => {
    const i = 3 * (body * frames + frame);
    const from = new THREE.Vector3().fromArray(array, i);
    return frame + 1 < frames ? from.lerp(new THREE.Vector3().fromArray(array, i + 3), part) : from;
  };
  function show(t) {
    const frame = lastBefore(times, t);
    const part = frame + 1 < frames ? (t - times[frame]) / (times[frame + 1] - times[frame]) : 0;
    for (let body = 0; body < count; body++) {
      const force = at(values, body, frame, part);
      const length = longest * force.length();
      const turn = new THREE.Quaternion().setFromUnitVectors(up, force.normalize());
      const point = at(positions, body, frame, part);
      const tip = Math.min(head, length);
      const place = (mesh, from, size) => {
        const origin = up.clone().applyQuaternion(turn).multiplyScalar(from).add(point);
        mesh.setMatrixAt(body, new THREE.Matrix4().compose(origin, turn, size));
        mesh.instanceMatrix.needsUpdate = true;
      };
      place(shafts, 0, new THREE.Vector3(1, length - tip, 1));
      place(heads, length - tip, new THREE.Vector3(tip / head, tip, tip / head));
    }
  }
  return { group, show, longest };
}
