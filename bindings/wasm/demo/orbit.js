// A camera that goes around a box: by dragging, by arrow keys, nearer and farther by the wheel.

const FOV = 30;
/** Milliseconds without a movement after which it rests. */
const PAUSE = 250;
const round = (v) => Number(v.toFixed(4));

/** Fires "turn" while it moves, "rest" when it has stopped and "point" (with `detail`, the event) for a click. `camera` is undefined until it is first moved. */
export class Orbit extends EventTarget {
  #target = [0, 0, 0];
  #radius = 1;
  #yaw;
  #pitch;
  #zoom;
  #moved = false;
  #timer;
  #last;
  #hasMoved = false;

  constructor(element) {
    super();
    this.reset();
    element.addEventListener("pointerdown", (event) => {
      this.#last = [event.clientX, event.clientY];
      this.#hasMoved = false;
      element.setPointerCapture(event.pointerId);
    });
    element.addEventListener("pointermove", (event) => {
      if (!this.#last) return;
      const [x, y] = this.#last;
      // A hand that clicks is not quite still.
      if (!this.#hasMoved && Math.hypot(event.clientX - x, event.clientY - y) < 3) return;
      this.#hasMoved = true;
      this.#last = [event.clientX, event.clientY];
      this.#turn((x - event.clientX) * 0.008, (event.clientY - y) * 0.008);
    });
    for (const name of ["pointerup", "pointercancel"]) {
      element.addEventListener(name, (event) => {
        if (name === "pointerup" && this.#last && !this.#hasMoved) this.dispatchEvent(new CustomEvent("point", { detail: event }));
        this.#last = undefined;
        if (this.#timer !== undefined) this.#rest();
      });
    }
    element.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        this.#zoom = Math.min(8, Math.max(0.3, this.#zoom * Math.exp(event.deltaY * 0.001)));
        this.#turn(0, 0);
      },
      { passive: false },
    );
    element.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
      if (!step) return;
      event.preventDefault();
      this.#turn(...step);
    });
  }

  /** A box to go around. */
  around(min, max) {
    this.#target = min.map((low, k) => round((low + max[k]) / 2));
    this.#radius = Math.hypot(...min.map((low, k) => max[k] - low)) / 2 || 1;
    this.reset();
  }

  reset() {
    const [x, y, z] = [0.62, 0.42, 1];
    this.#yaw = Math.atan2(x, z);
    this.#pitch = Math.atan2(y, Math.hypot(x, z));
    this.#zoom = 1;
    this.#moved = false;
  }

  get camera() {
    if (!this.#moved) return undefined;
    const distance = (this.#radius * this.#zoom) / Math.sin((FOV / 2) * (Math.PI / 180));
    const away = [
      Math.sin(this.#yaw) * Math.cos(this.#pitch),
      Math.sin(this.#pitch),
      Math.cos(this.#yaw) * Math.cos(this.#pitch),
    ];
    return { eye: this.#target.map((v, k) => round(v + away[k] * distance)), target: this.#target, fov_y_deg: FOV };
  }

  #turn(yaw, pitch) {
    this.#moved = true;
    this.#yaw += yaw;
    this.#pitch = Math.min(1.55, Math.max(-1.55, this.#pitch + pitch));
    this.dispatchEvent(new Event("turn"));
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#rest(), PAUSE);
  }

  #rest() {
    clearTimeout(this.#timer);
    this.#timer = undefined;
    this.dispatchEvent(new Event("rest"));
  }
}
