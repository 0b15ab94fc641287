// Time of the replay: playing or paused, at a speed; its listeners are informed of every change.

export class Playback {
  #listeners = [];

  /** Take the duration and the time of its beginning since the start of the flight [s]. */
  constructor(duration, since) {
    this.duration = duration;
    this.since = since;
    this.t = 0;
    this.speed = 1;
    this.isPlaying = false;
  }

  onChange(listener) {
    this.#listeners.push(listener);
  }

  /** Return a time of the replay as one since the start of the flight [s], in words. */
  words(t) {
    return (this.since + t).toFixed(1);
  }

  /** Play; from the start if the end is reached. */
  play() {
    if (this.t >= this.duration) this.t = 0;
    this.#set(this.t, true);
  }

  pause() {
    this.#set(this.t, false);
  }

  toggle() {
    if (this.isPlaying) this.pause();
    else this.play();
  }

  /** Go to time t [s]. */
  seek(t) {
    this.#set(Math.min(Math.max(t, 0), this.duration), this.isPlaying);
  }

  /** Advance by seconds of wall time while playing; pause at the end. */
  advance(seconds) {
    if (!this.isPlaying) return;
    const t = Math.min(this.t + seconds * this.speed, this.duration);
    this.#set(t, t < this.duration);
  }

  #set(t, isPlaying) {
    this.t = t;
    this.isPlaying = isPlaying;
    for (const listener of this.#listeners) listener();
  }
}
