// The mesh of a pack's head.glb: V_0 + Σ_n β_n ΔV_n of equation (7), with the normals of the result.

import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

type Attribute = THREE.BufferAttribute | THREE.InterleavedBufferAttribute;

export class Face {
  /** A group for each tile; `uv` over all tiles, v down. */
  readonly geometry = new THREE.BufferGeometry();
  /** Vertices of the blend, x y z one after the other. */
  readonly vertices: Float32Array;
  readonly around: THREE.Sphere;
  private readonly normals: Float32Array;

  private constructor(
    private readonly neutral: Float32Array,
    private readonly deltas: (Float32Array | Int16Array)[],
    private readonly step: number,
    /** The vertex that each corner of the file is: those on seams are there more than once. */
    private readonly vertexOf: Uint32Array,
    private readonly triangles: Uint32Array,
    uv: Attribute,
  ) {
    this.vertices = neutral.slice();
    this.normals = new Float32Array(neutral.length);
    for (const name of ["position", "normal"]) this.geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * vertexOf.length), 3));
    this.geometry.setAttribute("uv", uv);
    this.geometry.setIndex(new THREE.BufferAttribute(triangles, 1));
    this.deform(new Float32Array(deltas.length));
    this.around = sphereAround(neutral, vertexOf, triangles);
    this.geometry.boundingSphere = this.around;
  }

  /** `tileOf` says on which of the tiles each triangle lies; null where there is one. */
  static async read(glb: ArrayBuffer, tileOf: Uint8Array | null, tiles: number): Promise<Face> {
    const { scene } = await new GLTFLoader().parseAsync(glb, "");
    let mesh: THREE.Mesh | null = null;
    scene.traverse((found) => { if (found instanceof THREE.Mesh) mesh = found; });
    const { geometry, scale } = mesh! as THREE.Mesh;
    const { position, uv, _seam } = geometry.attributes as Record<string, Attribute>;
    const vertexOf = verticesOf(position.count, _seam);
    const { triangles, starts } = byTile(geometry.getIndex()!, tileOf, tiles);
    const deltas = geometry.morphAttributes.position!.map((shape) => atVertices(shape, vertexOf));
    const neutral = Float32Array.from(atVertices(position, vertexOf), (value) => value * scale.x);
    const face = new Face(neutral, deltas, scale.x, vertexOf, triangles, uv);
    for (let t = 0; t < tiles; t++) face.geometry.addGroup(starts[t], starts[t + 1] - starts[t], t);
    return face;
  }

  deform(weights: Float32Array): void {
    const { vertices, deltas, step } = this;
    vertices.set(this.neutral);
    weights.forEach((weight, n) => {
      if (weight === 0) return;
      const delta = deltas[n];
      for (let i = 0; i < vertices.length; i++) vertices[i] += weight * step * delta[i];
    });
    this.computeNormals();
    this.spread("position", vertices);
    this.spread("normal", this.normals);
  }

  // Over vertices, not corners: a seam of the UV layout is no crease.
  private computeNormals(): void {
    const { vertices: p, normals, triangles, vertexOf } = this;
    normals.fill(0);
    for (let t = 0; t < triangles.length; t += 3) {
      const a = 3 * vertexOf[triangles[t]];
      const b = 3 * vertexOf[triangles[t + 1]];
      const c = 3 * vertexOf[triangles[t + 2]];
      const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
      const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
      const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
      normals[a] += x, normals[a + 1] += y, normals[a + 2] += z;
      normals[b] += x, normals[b + 1] += y, normals[b + 2] += z;
      normals[c] += x, normals[c + 1] += y, normals[c + 2] += z;
    }
    for (let i = 0; i < normals.length; i += 3) {
      const length = Math.hypot(normals[i], normals[i + 1], normals[i + 2]) || 1;
      for (let k = 0; k < 3; k++) normals[i + k] /= length;
    }
  }

  private spread(name: string, values: Float32Array): void {
    const attribute = this.geometry.getAttribute(name) as THREE.BufferAttribute;
    const to = attribute.array as Float32Array;
    this.vertexOf.forEach((vertex, corner) => {
      for (let k = 0; k < 3; k++) to[3 * corner + k] = values[3 * vertex + k];
    });
    attribute.needsUpdate = true;
  }
}

function verticesOf(corners: number, seam: Attribute | undefined): Uint32Array {
  let last = -1;
  return Uint32Array.from({ length: corners }, (_, corner) => (seam?.getX(corner) ? last : ++last));
}

/** Three numbers a vertex, of an attribute that has them at each corner. */
function atVertices(attribute: Attribute, vertexOf: Uint32Array): Float32Array | Int16Array {
  const Kind = attribute.array instanceof Int16Array ? Int16Array : Float32Array;
  const values = new Kind(3 * (vertexOf[vertexOf.length - 1] + 1));
  vertexOf.forEach((vertex, corner) => {
    for (let k = 0; k < 3; k++) values[3 * vertex + k] = attribute.getComponent(corner, k);
  });
  return values;
}

/** Triangles in the order of their tiles, and where each tile's begin and end. */
function byTile(index: THREE.BufferAttribute, tileOf: Uint8Array | null, tiles: number): { triangles: Uint32Array; starts: number[] } {
  const order = [...Array(index.count / 3).keys()];
  const starts = [0];
  for (let t = 0; t < tiles; t++) starts.push(starts[t] + 3 * (tileOf ? tileOf.reduce((count, tile) => count + Number(tile === t), 0) : order.length));
  if (tileOf) order.sort((a, b) => tileOf[a] - tileOf[b]);
  return { triangles: Uint32Array.from({ length: index.count }, (_, i) => index.getX(3 * order[Math.floor(i / 3)] + (i % 3))), starts };
}

// Of what is drawn: a vertex that no triangle uses may lie anywhere.
function sphereAround(positions: Float32Array, vertexOf: Uint32Array, triangles: Uint32Array): THREE.Sphere {
  const used = Float32Array.from({ length: 3 * triangles.length }, (_, i) => positions[3 * vertexOf[triangles[Math.floor(i / 3)]] + (i % 3)]);
  const geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(used, 3));
  geometry.computeBoundingSphere();
  return geometry.boundingSphere!;
}
