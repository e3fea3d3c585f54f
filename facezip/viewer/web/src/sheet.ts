// The UV layout, laid flat: every tile at its place, with its texture and, if wanted, its triangles.

import * as THREE from "three";
import type { Face } from "./head/face";
import type { Head } from "./head/head";
import type { State } from "./state";

/** Pixels of the page above and below, for names and legend. */
const MARGIN = 72;

/** Where a tile is, in pixels from the lower left of the canvas. */
export interface Cell { left: number; bottom: number; width: number; height: number }

export class Sheet {
  /** Of each tile, as drawn last. */
  cells: Cell[] = [];
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.OrthographicCamera();
  private readonly planes: THREE.Mesh[];
  private readonly wires: THREE.Mesh[];

  constructor(private readonly head: Head, wires: THREE.Material) {
    const { document: { tiles }, face } = head;
    this.planes = tiles.map(({ place: [column, row] }) => new THREE.Mesh(squareAt(column, row)));
    this.wires = face ? tiles.map((_, t) => new THREE.Mesh(trianglesOf(face, t), wires)) : [];
    this.scene.add(...this.planes, ...this.wires);
  }

  /** `materials` are one a tile. */
  draw(renderer: THREE.WebGLRenderer, materials: THREE.Material[], { map, exact, wireframe }: State): void {
    const { width, height } = renderer.domElement;
    this.cells = this.cellsIn(width, height, map, exact, renderer.getPixelRatio());
    this.cells.forEach((cell, t) => {
      this.planes[t].material = materials[t];
      for (const mesh of [this.planes[t], this.wires[t]].filter(Boolean)) this.put(mesh, cell, t);
    });
    for (const mesh of this.wires) mesh.visible = wireframe;
    // The camera counts in pixels, so that one texel can be one pixel exactly.
    Object.assign(this.camera, { left: 0, right: width, bottom: 0, top: height, near: -1, far: 1 });
    this.camera.updateProjectionMatrix();
    renderer.render(this.scene, this.camera);
  }

  // Meshes lie in UV over all tiles.
  private put(mesh: THREE.Object3D, { left, bottom, width, height }: Cell, t: number): void {
    const [column, row] = this.head.document.tiles[t].place;
    mesh.scale.set(width, height, 1);
    mesh.position.set(left - column * width, bottom - row * height, 0);
  }

  private cellsIn(width: number, height: number, map: number, exact: boolean, ratio: number): Cell[] {
    const { tiles } = this.head.document;
    const sizes = tiles.map(({ textures }) => textures[map].size.map((side) => Math.max(1, Math.round(side * this.head.scale))));
    const [columns, rows] = [0, 1].map((axis) => tiles.map(({ place }) => place[axis]));
    const [first, below] = [Math.min(...columns), Math.min(...rows)];
    const [across, up] = [Math.max(...columns) - first + 1, Math.max(...rows) - below + 1];
    const [high, wide] = [0, 1].map((axis) => Math.max(...sizes.map((size) => size[axis])));
    const fit = Math.min((0.92 * width) / (wide * across), Math.max(0.5 * height, height - 2 * MARGIN * ratio) / (high * up));
    const scale = exact ? 1 : fit;
    const [left, bottom] = [Math.floor((width - wide * across * scale) / 2), Math.floor((height - high * up * scale) / 2)];
    return tiles.map((_, t) => ({
      left: left + (columns[t] - first) * wide * scale, bottom: bottom + (rows[t] - below) * high * scale,
      width: exact ? sizes[t][1] : wide * scale, height: exact ? sizes[t][0] : high * scale,
    }));
  }
}

function squareAt(column: number, row: number): THREE.BufferGeometry {
  const square = new THREE.PlaneGeometry().translate(column + 0.5, row + 0.5, 0);
  const { position, uv } = square.attributes;
  for (let i = 0; i < uv.count; i++) uv.setXY(i, position.getX(i), 1 - position.getY(i));
  return square;
}

function trianglesOf({ geometry }: Face, t: number): THREE.BufferGeometry {
  const { uv } = geometry.attributes;
  const { start, count } = geometry.groups[t];
  const flat = Float32Array.from({ length: 3 * uv.count }, (_, i) => [uv.getX(Math.floor(i / 3)), 1 - uv.getY(Math.floor(i / 3)), 0.5][i % 3]);
  const layout = new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(flat, 3));
  return layout.setIndex(new THREE.BufferAttribute(geometry.getIndex()!.array.slice(start, start + count), 1));
}
