// Files as a head takes them, wherever they come from.

export async function asked(address: string | URL): Promise<Response> {
  const response = await fetch(address);
  if (!response.ok) throw new Error(`${address}: the server answers ${response.status}`);
  return response;
}

/** An image of some rows and columns at `scale` times its size, without colour management. */
export function bitmapOf(image: Blob, scale: number, [rows, columns]: [number, number]): Promise<ImageBitmap> {
  const smaller = scale === 1 ? {} : { resizeWidth: Math.max(1, Math.round(columns * scale)), resizeHeight: Math.max(1, Math.round(rows * scale)), resizeQuality: "high" as const };
  return createImageBitmap(image, { colorSpaceConversion: "none", premultiplyAlpha: "none", ...smaller });
}
