// What is chosen on a page: one state that all charts of a section share.

export class View {
  constructor(state) {
    this.state = state;
    this.listeners = [];
  }
  get(key) {
    return this.state[key];
  }
  set(change) {
    const keys = Object.keys(change).filter((key) => this.state[key] !== change[key]);
    if (keys.length === 0) return;
    Object.assign(this.state, change);
    for (const listener of this.listeners) listener(keys);
  }
  listen(listener) {
    this.listeners.push(listener);
  }
}
