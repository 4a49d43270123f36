// What was asked for lately, so that it need not be asked for again; what was not wanted for longest is forgotten.

/* Keeps as many things, by name.
     most    how many */
export class Recent {
  constructor(most) {
    this.most = most;
    this.things = new Map(); // what was wanted last is the last
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
