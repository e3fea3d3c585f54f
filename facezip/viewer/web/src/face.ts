// The mesh: V_0 + Σ_n β_n ΔV_n of equation (7), with the normals of the result.

import * as THREE from "three";
import { readArray, type Scene } from "./scene";

export class Face {
  readonly geometry = new THREE.BufferGeometry();
  /** Vertices of the blend, x y z one after the other. */
  readonly vertices: Float32Array;
  private readonly normals: Float32Array;

  private constructor(
    private readonly neutral: Float32Array,
    private readonly deltas: Int16Array,
    private readonly scale: number[],
    private readonly cornerVertices: Uint32Array,
    uv: Float32Array,
    private readonly triangles: Uint32Array,
  ) {
    this.vertices = neutral.slice();
    this.normals = new Float32Array(neutral.length);
    const corners = 3 * cornerVertices.length;
    this.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(corners), 3));
    this.geometry.setAttribute("normal", new THREE.BufferAttribute(new Float32Array(corners), 3));
    this.geometry.setAttribute("uv", new THREE.BufferAttribute(uv, 2));
    this.geometry.setIndex(new THREE.BufferAttribute(triangles, 1));
    this.deform(new Float32Array(scale.length));
    this.geometry.computeBoundingSphere();
  }

  static async read(mesh: NonNullable<Scene["mesh"]>): Promise<Face> {
    const names = ["positions", "deltas", "corner_vertices", "corner_uv", "triangles"];
    const [positions, deltas, vertices, uv, triangles] = await Promise.all(names.map(readArray));
    return new Face(
      new Float32Array(positions), new Int16Array(deltas), mesh.delta_scale, new Uint32Array(vertices),
      new Float32Array(uv), new Uint32Array(triangles),
    );
  }

  deform(weights: Float32Array): void {
    const { vertices, deltas } = this;
    vertices.set(this.neutral);
    weights.forEach((weight, n) => {
      if (weight === 0) return;
      const step = weight * this.scale[n];
      for (let i = 0, d = n * vertices.length; i < vertices.length; i++, d++) vertices[i] += step * deltas[d];
    });
    this.computeNormals();
    this.spread("position", vertices);
    this.spread("normal", this.normals);
  }

  // Over vertices, not corners: a seam of the UV layout is no crease.
  private computeNormals(): void {
    const { vertices: p, normals, triangles, cornerVertices } = this;
    normals.fill(0);
    for (let t = 0; t < triangles.length; t += 3) {
      const a = 3 * cornerVertices[triangles[t]];
      const b = 3 * cornerVertices[triangles[t + 1]];
      const c = 3 * cornerVertices[triangles[t + 2]];
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
    this.cornerVertices.forEach((vertex, corner) => {
      for (let k = 0; k < 3; k++) to[3 * corner + k] = values[3 * vertex + k];
    });
    attribute.needsUpdate = true;
  }
}
