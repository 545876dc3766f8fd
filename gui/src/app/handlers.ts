// SPDX-License-Identifier: Apache-2.0

/** Functions that are called with each of some values. One that ends its own subscription meanwhile, or another's, is fine. */
export class Handlers<Value> {
  private readonly handlers = new Set<(value: Value) => void>();

  add(handler: (value: Value) => void): () => void {
    const own = (value: Value) => {
      handler(value);
    };
    this.handlers.add(own);
    return () => {
      this.handlers.delete(own);
    };
  }

  call(value: Value): void {
    for (const handler of [...this.handlers]) if (this.handlers.has(handler)) handler(value);
  }
}
