// Frames of a sequence: a slider that is the light's or the camera's way, and a button that plays them.

const MILLISECONDS = 80;

export class Player {
  constructor(figure, { frames, names }) {
    Object.assign(this, { figure, frames, names, timer: 0 });
    this.slider = figure.querySelector("input");
    this.button = figure.querySelector("button");
    this.slider.addEventListener("input", () => this.show());
    this.button.addEventListener("click", () => this.toggle());
    this.show();
  }

  show() {
    const at = Number(this.slider.value);
    this.figure.querySelector("img").src = this.frames[at];
    this.figure.querySelector("figcaption").textContent = this.names[at];
  }

  toggle() {
    clearInterval(this.timer);
    const plays = this.button.textContent === "play";
    this.button.textContent = plays ? "stop" : "play";
    if (plays) {
      this.timer = setInterval(() => {
        this.slider.value = (Number(this.slider.value) + 1) % this.frames.length;
        this.show();
      }, MILLISECONDS);
    }
  }
}
