// What is drawn over the vehicles: contact curves, arrows and marks. Lines have a width in pixels.

import { ConeGeometry, Group, Mesh, MeshBasicMaterial, SphereGeometry, Vector3 } from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';

const HEAD_PIXELS = 16;
const MARK_PIXELS = 5;

/** Segments, each from a point to another; on top of everything. */
export class Lines {
  constructor(colour, width) {
    this.material = new LineMaterial({ color: colour, linewidth: width, depthTest: false });
    this.object = new Group();
  }

  set(points) {
    this.object.children.forEach((child) => child.geometry.dispose());
    this.object.clear();
    if (points.length === 0) return;
    const lines = new LineSegments2(new LineSegmentsGeometry().setPositions(points), this.material);
    lines.frustumCulled = false;
    lines.renderOrder = 2;
    this.object.add(lines);
  }
}

/** The segments of curves: of a closed one, from its last point to its first as well. */
export function curveSegments(curves) {
  const segments = [];
  for (const { isClosed, points } of curves) {
    const count = points.length / 3;
    for (let at = 0; at < count - (isClosed ? 0 : 1); at++) {
      const next = (at + 1) % count;
      segments.push(...points.subarray(3 * at, 3 * at + 3), ...points.subarray(3 * next, 3 * next + 3));
    }
  }
  return segments;
}

/** True to scale, but for its head and the marks at its ends, whose size on the screen is the same from
 *  everywhere. */
export class Arrow {
  constructor(colour, hasTwoEnds) {
    this.lines = new Lines(colour, 3);
    const material = new MeshBasicMaterial({ color: colour, depthTest: false });
    const shapes = hasTwoEnds
      ? [new SphereGeometry(1, 12, 8), new SphereGeometry(1, 12, 8)]
      : [new SphereGeometry(1, 12, 8), new ConeGeometry(0.35, 1, 16).translate(0, -0.5, 0)];
    this.ends = shapes.map((shape) => new Mesh(shape, material));
    this.pixels = [MARK_PIXELS, hasTwoEnds ? MARK_PIXELS : HEAD_PIXELS];
    this.object = new Group().add(this.lines.object, ...this.ends);
    this.ends.forEach((end) => { end.renderOrder = 3; });
    this.object.visible = false;
  }

  set(points) {
    this.points = points;
    if (!points) return;
    const [from, to] = points;
    this.lines.set([...from.toArray(), ...to.toArray()]);
    this.ends.forEach((end, at) => end.position.copy(points[at]));
    const direction = to.clone().sub(from);
    if (direction.lengthSq() > 0) {
      this.ends[1].quaternion.setFromUnitVectors(new Vector3(0, 1, 0), direction.normalize());
    }
  }

  show(is) {
    this.object.visible = is && this.points !== null;
  }

  fit(stage) {
    this.ends.forEach((end, at) => {
      const away = end.position.distanceTo(stage.camera.position);
      end.scale.setScalar(this.pixels[at] * stage.pixel(away));
    });
  }
}
