// A cache of recent results; the least recently used one is dropped first.

/* Keeps a limited number of things by name.
     most    the limit */
export class Recent {
  constructor(most) {
    this.most = most;
    this.things = new Map(); // from the least to the most recently used
  }

  get(name) {
    const thing = this.things.get(name);
    if (thing !== undefined) this.set(name, thing);
    return thing;
  }

  set(name, thing) {
    this.things.delete(name);
    this.things.set(name, thing);
    if (this.things.size > this.most) this.things.delete(this.things.keys().next().value);
  }

  delete(name) {
    this.things.delete(name);
  }
}
