// What facezip.d.ts declares is what there is; nothing of this is bundled.

import type { Group } from "three";
import type * as Declared from "../../three/facezip";
import type * as Actual from "./facezip";

type Same<A, B> = [A] extends [B] ? ([B] extends [A] ? true : never) : never;
/** Public members that three's groups do not have. */
type Public<T> = Pick<T, Exclude<keyof T, keyof Group>>;

export const same: Same<typeof Declared.loadFaceZip extends (...given: infer G) => unknown ? G : never, Parameters<typeof Actual.loadFaceZip>> = true;
export const alike: Same<Public<Declared.FaceZipHead>, Public<Actual.FaceZipHead>> = true;
