// One vehicle: its triangles, those that touch, and the boxes of its tree.

import {
  BufferAttribute, BufferGeometry, DoubleSide, Group, LineBasicMaterial, LineSegments, Matrix4, Mesh,
  MeshBasicMaterial, MeshLambertMaterial, Points, PointsMaterial, Raycaster, Vector3,
} from 'three';
import * as colours from './colours.js';
import { partPlaced } from './motion.js';

export const LOOKS = ['solid', 'ghost', 'hidden'];

export class Body {
  constructor(model, side) {
    this.model = model;
    this.side = side;
    this.object = new Group();
    this.object.matrixAutoUpdate = false;
    this.positions = new BufferAttribute(model.positions, 3);
    this.deformed = model.deformed && new BufferAttribute(model.deformed, 3);
    this.materials = new Map();
    this.contactMaterials = contactMaterials(colours.CONTACTS[side]);
    this.parts = (model.parts.length > 0 ? model.parts : [null]).map((part) => this.makePart(part));
    this.partOf = partNumbers(model);
    this.boxes = new LineSegments(
      new BufferGeometry(),
      new LineBasicMaterial({ color: colours.BOXES[side] }),
    );
    this.boxes.frustumCulled = false;
    this.object.add(this.boxes);
    this.paintWhole();
    this.setLook('solid');
  }

  makePart(part) {
    const object = new Group();
    object.matrixAutoUpdate = false;
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', this.positions);
    const mesh = new Mesh(geometry);
    const contacts = new Mesh(new BufferGeometry(), this.contactMaterials.face);
    const dots = new Points(contacts.geometry.clone(), this.contactMaterials.dot);
    contacts.renderOrder = dots.renderOrder = 1;
    [mesh, contacts, dots].forEach((drawn) => { drawn.frustumCulled = false; });
    object.add(mesh, contacts, dots);
    this.object.add(object);
    return { part, object, mesh, contacts, dots };
  }

  /** Opaque, so that each pixel is drawn once. A ghost is drawn on every fourth pixel. */
  material(colour) {
    if (!this.materials.has(colour)) {
      const material = new MeshLambertMaterial({ color: colour, flatShading: true, side: DoubleSide });
      material.onBeforeCompile = (shader) => {
        shader.fragmentShader = shader.fragmentShader.replace(
          'void main() {',
          `void main() {
            #ifdef GHOST
            if (mod(floor(gl_FragCoord.x) + 2.0 * floor(gl_FragCoord.y), 4.0) > 0.5) discard;
            #endif`,
        );
      };
      this.materials.set(colour, material);
      this.applyLook();
    }
    return this.materials.get(colour);
  }

  /** In one colour, with one draw call a part. */
  paintWhole() {
    const colour = colours.BODIES[this.side];
    this.paint((ranks) => [{ colour, ranks }]);
  }

  /** By the class of the distributed root that a triangle is below: `classOf(root)` is a colour. */
  paintRoots(classOf) {
    const { rootStarts } = this.model;
    const colourOf = new Array(rootStarts.length - 1).fill(0).map((_, root) => classOf(root));
    this.paint((ranks) => {
      const classes = new Map();
      let root = 0;
      for (const rank of ranks) {
        while (rank >= rootStarts[root + 1]) root += 1;
        const colour = colourOf[root];
        if (!classes.has(colour)) classes.set(colour, []);
        classes.get(colour).push(rank);
      }
      return [...classes].map(([colour, ofClass]) => ({ colour, ranks: ofClass }));
    });
  }

  paint(classes) {
    const { index } = this.model;
    const all = Uint32Array.from({ length: index.length / 3 }, (_, rank) => rank);
    for (const { part, mesh } of this.parts) {
      const found = classes(part ? part.ranks : all);
      mesh.material = found.map(({ colour }) => this.material(colour));
      const ordered = new Uint32Array(3 * found.reduce((sum, { ranks }) => sum + ranks.length, 0));
      let at = 0;
      mesh.geometry.clearGroups();
      found.forEach(({ ranks }, number) => {
        mesh.geometry.addGroup(at, 3 * ranks.length, number);
        for (const rank of ranks) {
          ordered.set(index.subarray(3 * rank, 3 * rank + 3), at);
          at += 3;
        }
      });
      mesh.geometry.setIndex(new BufferAttribute(ordered, 1));
    }
  }

  setLook(look) {
    this.look = look;
    this.applyLook();
  }

  applyLook() {
    for (const material of this.materials.values()) {
      material.visible = this.look !== 'hidden';
      material.defines = this.look === 'ghost' ? { GHOST: '' } : {};
      material.needsUpdate = true;
    }
  }

  /** As it is before or after the crash that deforms it. */
  setDeformed(is) {
    const positions = is && this.deformed ? this.deformed : this.positions;
    for (const { mesh } of this.parts) mesh.geometry.setAttribute('position', positions);
  }

  get current() {
    return this.parts[0].mesh.geometry.getAttribute('position');
  }

  place(matrix, seconds) {
    this.object.matrix.copy(matrix);
    for (const { part, object } of this.parts) {
      if (part) object.matrix.copy(partPlaced(part, this.model.center, seconds));
    }
    this.object.updateMatrixWorld(true);
  }

  /** Triangles that touch, drawn over the others, and a dot on each, to be seen from far away. */
  showContacts(ranks) {
    this.parts.forEach(({ contacts, dots }, number) => {
      const own = this.partOf ? ranks.filter((rank) => this.partOf[rank] === number) : ranks;
      const corners = new Float32Array(9 * own.length);
      const middles = new Float32Array(3 * own.length);
      own.forEach((rank, at) => {
        const triangle = this.corners(rank);
        corners.set(triangle.flatMap((corner) => corner.toArray()), 9 * at);
        const middle = triangle[0].add(triangle[1]).add(triangle[2]).divideScalar(3);
        middles.set(middle.toArray(), 3 * at);
      });
      replace(contacts.geometry, corners);
      replace(dots.geometry, middles);
    });
  }

  setContactsVisible(visible, onTop) {
    for (const { contacts, dots } of this.parts) contacts.visible = dots.visible = visible;
    Object.values(this.contactMaterials).forEach((material) => { material.depthTest = !onTop; });
  }

  /** In the body. */
  corners(rank) {
    return [0, 1, 2].map((corner) =>
      new Vector3().fromBufferAttribute(this.current, this.model.index[3 * rank + corner]));
  }

  /** In the world. */
  placedCorners(rank) {
    const part = this.parts[this.partOf ? this.partOf[rank] : 0];
    return this.corners(rank).map((corner) => corner.applyMatrix4(part.object.matrixWorld));
  }

  /** Of a depth of the tree, or none. */
  showBoxes(depth) {
    const { boxStarts, boxNumbers } = this.model;
    this.boxes.visible = depth !== null;
    if (depth === null) return;
    const at = Math.min(depth, boxStarts.length - 2);
    replace(this.boxes.geometry, edges(boxNumbers.subarray(15 * boxStarts[at], 15 * boxStarts[at + 1])));
  }

  /** The rank of the triangle that a ray meets first, and how far away. */
  pick(ray) {
    if (this.look === 'hidden') return null;
    let nearest = null;
    for (const { mesh } of this.parts) {
      const inverse = new Matrix4().copy(mesh.matrixWorld).invert();
      const local = ray.clone().applyMatrix4(inverse);
      const index = mesh.geometry.index.array;
      const [a, b, c, hit] = [new Vector3(), new Vector3(), new Vector3(), new Vector3()];
      for (let at = 0; at < index.length; at += 3) {
        a.fromBufferAttribute(this.current, index[at]);
        b.fromBufferAttribute(this.current, index[at + 1]);
        c.fromBufferAttribute(this.current, index[at + 2]);
        if (!local.intersectTriangle(a, b, c, false, hit)) continue;
        const distance = hit.distanceTo(local.origin);
        if (nearest === null || distance < nearest.distance) {
          nearest = { distance, corners: [index[at], index[at + 1], index[at + 2]] };
        }
      }
    }
    return nearest && { distance: nearest.distance, rank: this.rankOf(nearest.corners) };
  }

  rankOf([a, b, c]) {
    const { index } = this.model;
    for (let at = 0; at < index.length; at += 3) {
      if (index[at] === a && index[at + 1] === b && index[at + 2] === c) return at / 3;
    }
    return 0;
  }
}

export function ray(camera, x, y) {
  const caster = new Raycaster();
  caster.setFromCamera({ x, y }, camera);
  return caster.ray;
}

function contactMaterials(colour) {
  return {
    face: new MeshBasicMaterial({
      color: colour, side: DoubleSide, polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -2,
    }),
    dot: new PointsMaterial({ color: colour, size: 4, sizeAttenuation: false }),
  };
}

function partNumbers({ parts, ids }) {
  if (parts.length === 0) return null;
  const numbers = new Uint16Array(ids.length);
  parts.forEach(({ ranks }, number) => ranks.forEach((rank) => { numbers[rank] = number; }));
  return numbers;
}

function replace(geometry, positions) {
  geometry.dispose();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
}

/** Of boxes, each a middle, three half lengths and three axes. */
function edges(numbers) {
  const lines = new Float32Array((numbers.length / 15) * 72);
  let at = 0;
  for (let box = 0; box < numbers.length; box += 15) {
    const corner = (bits, k) => [0, 1, 2].reduce(
      (sum, axis) =>
        sum + (bits & (1 << axis) ? 1 : -1) * numbers[box + 3 + axis] * numbers[box + 6 + 3 * axis + k],
      numbers[box + k],
    );
    for (let from = 0; from < 8; from++) {
      for (const axis of [1, 2, 4]) {
        if (from & axis) continue;
        for (const end of [from, from | axis]) {
          for (let k = 0; k < 3; k++) lines[at++] = corner(end, k);
        }
      }
    }
  }
  return lines;
}
