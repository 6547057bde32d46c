// The drawing surface, the light and the camera. A picture is drawn when something has changed.

import {
  AmbientLight, Box3, Color, DirectionalLight, HemisphereLight, PerspectiveCamera, Scene, Spherical, Sphere, Vector3,
  WebGLRenderer, Quaternion,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

const FLIGHT_MS = 250;
/** Of the picture that stays free. */
const MARGIN = 0.08;
/** From where to look: along x is forward, y left, z up. */
export const VIEWS = {
  slanted: [1, -1.2, 0.8],
  front: [1, 0, 0],
  left: [0, 1, 0],
  above: [-0.001, 0, 1],
};

export class Stage {
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: 'high-performance' });
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(35, 1, 0.1, 100);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(...VIEWS.slanted);
    this.headlight = new DirectionalLight(0xffffff, 1.6);
    this.camera.add(this.headlight);
    this.scene.add(this.camera, new HemisphereLight(0xffffff, 0x8088a0, 1.1), new AmbientLight(0xffffff, 0.25));
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener('change', () => this.draw());
    this.world = new Sphere(new Vector3(), 1);
    this.listeners = [];
    this.flight = null;
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
  }

  setBackground(colour) {
    this.scene.background = new Color(colour);
    this.draw();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(1, height);
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  /** Before the next frame of the screen, once. */
  draw() {
    if (this.isAsked) return;
    this.isAsked = true;
    requestAnimationFrame((now) => {
      this.isAsked = false;
      this.fly(now);
      // They say what there is, which the depth has to hold.
      this.listeners.forEach((listener) => listener(this));
      this.fitDepth();
      this.renderer.render(this.scene, this.camera);
      this.canvas.dataset.frame = String(Number(this.canvas.dataset.frame ?? 0) + 1);
    });
  }

  onDraw(listener) {
    this.listeners.push(listener);
  }

  get distance() {
    return this.camera.position.distanceTo(this.controls.target);
  }

  /** So that all there is is within the depth that is drawn, with as much of it as can be had. */
  fitDepth() {
    const away = this.camera.position.distanceTo(this.world.center);
    this.camera.near = Math.max(away - 1.2 * this.world.radius, this.distance * 0.01, 1e-6);
    this.camera.far = away + 1.5 * this.world.radius + this.camera.near;
    this.camera.updateProjectionMatrix();
  }

  /** Looks at points, from a direction if one is given, otherwise from where it is. */
  look(points, from = null) {
    const direction = from
      ? new Vector3(...from).normalize()
      : this.camera.position.clone().sub(this.controls.target).normalize();
    const target = new Box3().setFromPoints(points).getCenter(new Vector3());
    const away = this.distanceFor(points, target, direction);
    const still = matchMedia('(prefers-reduced-motion: reduce)').matches || !this.hasLooked;
    this.hasLooked = true;
    this.flight = {
      end: { target, position: target.clone().addScaledVector(direction, away) },
      target: this.controls.target.clone(),
      position: this.camera.position.clone(),
      begin: still ? -Infinity : performance.now(),
    };
    this.draw();
  }

  /** From which all of the points are seen. */
  distanceFor(points, target, direction) {
    const right = new Vector3().crossVectors(this.camera.up, direction).normalize();
    const up = new Vector3().crossVectors(direction, right);
    const slope = Math.tan((this.camera.fov * Math.PI) / 360) * (1 - MARGIN);
    return Math.max(...points.map((point) => {
      const from = point.clone().sub(target);
      const across = Math.max(Math.abs(from.dot(up)), Math.abs(from.dot(right)) / this.camera.aspect);
      return from.dot(direction) + across / slope;
    }));
  }

  fly(now) {
    if (!this.flight) return;
    const { begin, end, target, position } = this.flight;
    const part = Math.min(1, Math.max(0, (now - begin) / FLIGHT_MS));
    const eased = part * part * (3 - 2 * part);
    this.controls.target.lerpVectors(target, end.target, eased);
    this.camera.position.lerpVectors(position, end.position, eased);
    if (part === 1) this.flight = null;
    this.controls.update();
    if (this.flight) this.draw();
  }

  /** By angles in radians. */
  orbit(around, up) {
    const upright = new Quaternion().setFromUnitVectors(this.camera.up, new Vector3(0, 1, 0));
    const offset = this.camera.position.clone().sub(this.controls.target).applyQuaternion(upright);
    const at = new Spherical().setFromVector3(offset);
    at.theta += around;
    at.phi += up;
    offset.setFromSpherical(at.makeSafe()).applyQuaternion(upright.invert());
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.draw();
  }

  zoom(factor) {
    this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    this.controls.update();
    this.draw();
  }

  /** Of a pixel at a distance from the camera, in metres. */
  pixel(distance = this.distance) {
    return (2 * distance * Math.tan((this.camera.fov * Math.PI) / 360)) / this.canvas.clientHeight;
  }
}
