/** Why a pack is refused: a code for programs, a line for people. */
export class Refusal extends Error {
  constructor(code, reason) {
    super(reason);
    this.code = code;
  }
}

/** Refuse the pack unless something holds. */
export function need(holds, reason, code = "bad-pack") {
  if (!holds) throw new Refusal(code, reason);
}
